"""The command: compares, measures, prints the table, writes CSV."""

from __future__ import annotations

import ctypes
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.harness import core, results
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import VERIFICATION
from verification import elementary
from verification.elementary import arguments, errors, shares
from verification.elementary.arguments import Array

ALLOWED = 1.0  # ulp
DOUBTFUL = 0.8  # ulp: all errors above are computed again with 60 digits
CHECKED = 10_000  # arguments of each function at which reference.c is compared with 60 digits
AGREEMENT = 1e-9  # ulp, between the two
CHUNK = 200_000
CALLS = 20_000  # that callgrind counts
LOOPS = Path(__file__).with_name("loops.c")
FLAGS = (core.OPTIMISED[0], "-fomit-frame-pointer")  # of the FMUs
TIMED = np.linspace(0.01, 6.0, 10_000)
PAIRED = ("sin and cos",)  # whose errors are those of others
# The C library chooses its variant by the processor. These settings take fused multiply-add away from glibc.
NOT_FUSED = "glibc.cpu.hwcaps=-FMA,-FMA4,-AVX2,-AVX2_Usable"


def loops() -> ctypes.CDLL:
    flags = [*FLAGS, "-fPIC", "-shared"]
    sources = [LOOPS, *sorted((core.FMU_SRC / "elementary").glob("*.c"))]
    library = ctypes.CDLL(str(core.compile_c(flags, sources, core.BUILD / "loops/elementary.so")))
    library.seconds.restype = ctypes.c_double
    return library


def address(x: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(x.ctypes.data)


def computed(library: ctypes.CDLL, name: str, x: Array, second: Array) -> Array:
    y = np.empty_like(x)
    words = (b"own", name.encode(), ctypes.c_size_t(len(x)))
    library.values(*words, address(x), address(second), address(y))
    return y


@dataclass
class Errors:
    """Of one function, in ulp."""

    count: int = 0
    nearest: int = 0  # arguments whose result is the double nearest to the exact value
    greatest: float = 0.0  # by 60 digits
    at: tuple[float, float] = (0.0, 0.0)
    disagreement: float = 0.0  # of reference.c and 60 digits

    def add(self, name: str, numbers: tuple[Array, Array, Array], found: Array, chosen: Array) -> None:
        """`numbers`: arguments, second arguments, results; `found`: errors by reference.c. Those of `chosen`
        indices are computed again with 60 digits."""
        self.count += len(found)
        self.nearest += int(np.count_nonzero(abs(found) <= 0.5))
        for k in chosen:
            x, second, y = (float(part[k]) for part in numbers)
            exact = errors.exact_error(name, x, second, y)
            self.disagreement = max(self.disagreement, abs(exact - float(found[k])))
            if not abs(exact) <= self.greatest:  # a NaN counts
                self.greatest, self.at = abs(exact), (x, second)


def chunks(name: str, count: int) -> Iterator[tuple[Array, Array]]:
    """All hard arguments, then random ones."""
    hard = arguments.hard_arguments(name)
    for k in range(0, len(hard[0]), CHUNK):
        yield hard[0][k : k + CHUNK].copy(), hard[1][k : k + CHUNK].copy()
    r = np.random.default_rng(1)
    for _ in range(max(1, count // CHUNK)):
        yield arguments.random_arguments(name, r, CHUNK)


def errors_of(library: ctypes.CDLL, reference: errors.Reference, name: str, count: int) -> Errors:
    made, r = Errors(), np.random.default_rng(4)
    checked = -(-CHECKED * CHUNK // max(count, CHUNK))
    for x, second in chunks(name, count):
        y = computed(library, name, x, second)
        found = reference.errors(name, x, second, y)
        size = np.where(np.isnan(found), math.inf, abs(found))
        chosen = np.concatenate(
            [np.flatnonzero(size > DOUBTFUL), [np.argmax(size)], r.integers(len(x), size=checked)]
        )
        made.add(name, (x, second, y), found, np.unique(chosen))
    return made


def nanoseconds(library: ctypes.CDLL, name: str, rounds: int) -> list[float]:
    """Of one call: own, library; the least of all rounds."""
    y, best = np.empty_like(TIMED), [math.inf, math.inf]
    shuffled = np.random.default_rng(2).permutation(TIMED)
    for _ in range(rounds):
        for k, kind in enumerate((b"own", b"library")):
            seconds = library.seconds(
                kind, name.encode(), ctypes.c_size_t(len(y)), address(shuffled), address(y)
            )
            best[k] = min(best[k], 1e9 * seconds)
    return best


def program() -> Path:
    product = core.BUILD / "loops/elementary"
    sources = [LOOPS, *sorted((core.FMU_SRC / "elementary").glob("*.c"))]
    return core.compile_c(FLAGS, sources, product)


def instructions(loop: Path, kind: str, name: str, tunables: str = "") -> str:
    """Of one call with its loop; empty without valgrind."""
    if shutil.which("valgrind") is None:
        return ""
    with tempfile.TemporaryDirectory() as folder:
        words = ["valgrind", "--tool=callgrind", "--collect-atstart=no", "--toggle-collect=loop"]
        words += [f"--callgrind-out-file={folder}/out", str(loop), kind, name, str(CALLS)]
        environment = {**os.environ, "GLIBC_TUNABLES": tunables}
        done = subprocess.run(words, capture_output=True, text=True, env=environment)
        total = re.search(r"^(?:summary|totals): (\d+)", Path(folder, "out").read_text(), re.MULTILINE)
        if done.returncode != 0 or total is None:
            raise SystemExit(f"callgrind failed\n{done.stderr[-2000:]}")
        return f"{int(total[1]) / CALLS:.0f}"


def error_cells(found: Errors) -> dict[str, str]:
    return {
        "arguments": str(found.count),
        "greatest_error_ulp": f"{found.greatest:.4f}",
        "at": f"{found.at[0]:.17g}",
        "at_second": f"{found.at[1]:.17g}",
        "nearest_percent": f"{100.0 * found.nearest / found.count:.1f}",
        "disagreement_ulp": f"{found.disagreement:.1e}",
    }


COLUMNS = {
    "greatest error [ulp]": "greatest_error_ulp",
    "nearest [%]": "nearest_percent",
    "own [ns]": "ns",
    "library [ns]": "ns_library",
    "own [instr.]": "instructions",
    "library [instr.]": "instructions_library",
    "library, not fused [instr.]": "instructions_library_not_fused",
}


def main() -> int:
    parser = results.options(elementary.__doc__, "elementary", 51, folder=VERIFICATION / "results")
    parser.add_argument("--count", type=float, default=1e7, help="random arguments of each function (1e7)")
    options = parser.parse_args()
    console, library, loop, rows = results.new_console(), loops(), program(), []
    reference = errors.Reference()
    table = results.table("Functions of the core and of the C library", "function", *COLUMNS)
    failed = False
    for name in (*errors.EXACT, *PAIRED, *errors.OF_TWO):
        known = name not in PAIRED
        found = errors_of(library, reference, name, int(options.count)) if known else Errors(1)
        failed |= not (found.greatest < ALLOWED and found.disagreement < AGREEMENT)
        own, others = nanoseconds(library, name, options.rounds)
        cells = error_cells(found)
        row = {"function": name, **(cells if known else dict.fromkeys(cells, ""))}
        row |= {"ns": f"{own:.1f}", "ns_library": f"{others:.1f}"}
        row["instructions"] = instructions(loop, "own", name)
        row["instructions_library"] = instructions(loop, "library", name)
        row["instructions_library_not_fused"] = instructions(loop, "library", name, NOT_FUSED)
        rows.append(row)
        table.add_row(name, *(row[key] for key in COLUMNS.values()))
    console.print(table)
    facts = circumstances("elementary", "numpy")
    results.publish(rows, facts, options.output, console)
    if of_steps := shares.measure():
        console.print(shares.table(of_steps))
        results.publish(of_steps, facts, options.output.with_stem(options.output.stem + "_shares"), console)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
