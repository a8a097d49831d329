"""Looks for mistakes in the C code without running the code: clang-tidy, cppcheck and the analyzer of gcc.

    python fmu_src/tools/static_analysis.py

clang-tidy and cppcheck come with the extra `check`. clang-tidy holds the analyzer that scan-build calls.
Without gcc, its analyzer is left out, and this is told. Exit code 1: a tool has found something.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from os import cpu_count
from pathlib import Path

from compiler import ROOM_OF_THE_FMU, fmi_headers
from fmus import MODELS, core_sources, model_defines
from platforms import ARITHMETIC
from rich.progress import track
from workspace import FLEET, ROOT, relative

INCLUDES = ("-Ifmu_src", f"-I{fmi_headers()}")
VERSIONS = (2, 3)

# False findings of clang-tidy, with the reason.
FALSE_OF_CLANG_TIDY = {
    # all members are doubles, so that there is no padding; -0.0 and NaN may count as a change
    ("fmu_src/forward/lifecycle.c", "bugprone-suspicious-memory-comparison"),
    # asks whether any bit of a state has changed
    ("fmu_src/fmi/simulation.c", "bugprone-suspicious-memory-comparison"),
    # does not see that the search ends between the knots 0 and `last`: the next knot is infinitely far there
    ("fmu_src/model/friction_table.c", "clang-analyzer-core.UndefinedBinaryOperatorResult"),
    # does not see that a degree is never negative
    ("fmu_src/numerics/bernstein.c", "clang-analyzer-core.uninitialized.UndefReturn"),
    # does not see that a table has at least two speeds
    ("fmu_src/model/friction_table_load.c", "clang-analyzer-optin.portability.UnixAPI"),
}
FINDING = re.compile(r"^(?P<file>[^:\n]+):\d+:\d+: (?:warning|error): .* \[(?P<check>[^],]+)[^]]*\]$", re.M)

# False findings of cppcheck, with the reason.
FALSE_OF_CPPCHECK = (
    # counts the first turn of a loop that does not run for k = 0
    ("uninitvar", "fmu_src/numerics/jet.c"),
    ("uninitvar", "fmu_src/inverse/imposed_motion.c"),
    # only a transmission of one straight piece has coefficients, and only its steps read them
    ("uninitvar", "fmu_src/contact/slip_mode.c"),
    # does not see that a degree is never negative
    ("uninitvar", "fmu_src/numerics/bernstein.c"),
    # takes the bound of the enumeration KNOWN_* for one past its end
    ("arrayIndexOutOfBoundsCond", "fmu_src/collocation/radau_step.c"),
    # does not see that `*out = ...` writes what `out->by` points at
    ("ctuuninitvar", "fmu_src/contact/balance_partials.c"),
)
# False findings of gcc 12's analyzer: its loops may run zero times, and it takes the 64 bits of a double for
# a flag.
GCC_WITHOUT = (
    "-Wno-analyzer-use-of-uninitialized-value",
    "-Wno-analyzer-shift-count-overflow",
    "-Wno-analyzer-too-complex",
)


@dataclass(frozen=True)
class Unit:
    """A source file with the options that select its FMU."""

    source: Path
    defines: tuple[str, ...]

    @property
    def options(self) -> list[str]:
        return [ARITHMETIC[0], *self.defines, *INCLUDES]


def defines(identifier: str, version: int) -> tuple[str, ...]:
    """The options of an FMU's build, with a name in place of the GUID."""
    return (
        *model_defines(identifier, version),
        '-DMODEL_GUID="analysis"',
        f"-DMODEL_IDENTIFIER={identifier}",
    )


def units() -> list[Unit]:
    """Each file once; the files of the room that depends on the FMU once for each FMU."""
    found = {
        Unit(source, defines(identifier, version) if ROOM_OF_THE_FMU in source.parents else ())
        for identifier in MODELS
        for version in VERSIONS
        for source in core_sources(identifier, version)
    }
    found |= {Unit(source, ()) for source in FLEET.glob("*.c")}
    return sorted(found, key=lambda unit: (unit.source, unit.defines))


def output_of(command: list[str]) -> str:
    """What a tool reports, "" where it is content."""
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return done.stdout + done.stderr if done.returncode else ""


def is_false(finding: re.Match[str]) -> bool:
    return (relative(Path(finding["file"])), finding["check"]) in FALSE_OF_CLANG_TIDY


def clang_tidy(unit: Unit) -> str:
    command = [tool("clang-tidy"), "--quiet", relative(unit.source), "--", *unit.options]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    found = [finding for finding in FINDING.finditer(done.stdout) if not is_false(finding)]
    if found:
        return done.stdout
    return done.stderr if done.returncode else ""


def gcc_analyzer(unit: Unit) -> str:
    warnings = ("-fanalyzer", *GCC_WITHOUT, "-Werror")
    with tempfile.NamedTemporaryFile(suffix=".o") as product:
        return output_of(
            ["gcc", "-O2", *warnings, *unit.options, "-c", relative(unit.source), "-o", product.name]
        )


def cppcheck() -> str:
    sources = [relative(unit.source) for unit in units() if ROOM_OF_THE_FMU not in unit.source.parents]
    suppressed = [f"--suppress={finding}:{source}" for finding, source in FALSE_OF_CPPCHECK]
    wanted = ["--enable=warning,performance,portability", "--error-exitcode=1", "--max-configs=1", "--quiet"]
    wanted += ["-D__has_attribute(x)=0"]
    return output_of([tool("cppcheck"), "--std=c11", *wanted, *suppressed, *INCLUDES, *sources])


def tool(name: str) -> str:
    """The program beside this Python."""
    return str(Path(sys.executable).with_name(name))


def findings() -> Iterator[str]:
    has_gcc = shutil.which("gcc") is not None
    tools = [clang_tidy, gcc_analyzer] if has_gcc else [clang_tidy]
    if not has_gcc:
        print("gcc is not installed: its analyzer is left out")
    yield cppcheck()
    jobs = [(look, unit) for unit in units() for look in tools]
    with ThreadPoolExecutor(cpu_count()) as pool:
        results = pool.map(lambda job: job[0](job[1]), jobs)
        yield from track(results, "clang-tidy and gcc -fanalyzer", total=len(jobs))


def main() -> int:
    found = [text for text in findings() if text]
    print("\n".join(found) if found else "static analysis: no finding")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
