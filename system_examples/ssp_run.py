"""The three examples as SSP packages, run by ecos and libcosim and compared with the Python versions.

    ./build.sh ssp                                   all, written to docs/ssp.md
    python system_examples/ssp_run.py --only ecos    one master, with the cam as it was built last

The packages go to build/ssp. Each master must agree with the same FMUs coupled by FMPy in the same order,
to rounding; these with the Python versions as closely as computing ahead makes up for a command's way of
two steps. A master that cannot be installed is skipped, with the reason. The exit code is 1 if one that
ran does not agree.
"""

from __future__ import annotations

import argparse
import platform
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import numpy as np
import ssp_parts
from ssp_packages import START, Columns, System, couple
from ssp_systems import EXAMPLES, PER_TICK, WATCHED, Course, Example

sys.path.insert(0, str(ssp_parts.ROOT / "masters"))
import install
import players
from install import Failed, Missing, say

# libcosim's times are whole nanoseconds, FMPy's and ecos' are sums of steps: some 1e-12 s apart in the end.
# The knee's cam is integrated to 1e-9. In rad, rad/s, N.m and J.
ROUNDING = 1e-9
ANGLE_APART = 1e-4  # rad, largest distance from the Python version: less than a count of the motor's encoder
NUMBERS_APART = 0.02  # of the number

Runner = Callable[[System, int, Path], Columns]


def arguments(system: System, ticks: int, file: Path) -> list[str | Path]:
    return [system.path, START, repr(system.step), str(ticks), str(PER_TICK), file, *WATCHED]


def ecos(system: System, ticks: int, file: Path) -> Columns:
    venv = install.package("ecospy", "tbb")  # tbb: a library that ecospy needs and does not bring
    words = [venv / "bin/python", players.HOSTS / "ecos_ssp.py", *arguments(system, ticks, file)]
    players.insist(words, file.parent, LD_LIBRARY_PATH=str(venv / "lib"))
    return players.read(file)


def libcosim(system: System, ticks: int, file: Path) -> Columns:
    venv = install.package("libcosimpy")
    words = [venv / "bin/python", players.HOSTS / "libcosim_ssp.py", *arguments(system, ticks, file)]
    players.insist(words, file.parent)
    return players.read(file)


@dataclass(frozen=True)
class Master:
    name: str
    package: str
    runner: Runner

    @property
    def version(self) -> str:
        return install.pins()[self.package]


MASTERS = (Master("ecos", "ecospy", ecos), Master("libcosim", "libcosimpy", libcosim))
KINDS = {  # columns of the table
    "angle [rad]": ("cam.theta", "controller.reference"),
    "speed [rad/s]": ("cam.omega",),
    "torque [N.m]": ("motor.tau",),
    "accounts [J]": tuple(n for n in WATCHED if n.startswith(("motor.heat", "motor.energy", "cam.energy"))),
}


@dataclass(frozen=True)
class Outcome:
    cells: tuple[str, ...]
    wrong: bool = False


def apart(found: Columns, expected: Columns, names: Sequence[str]) -> float:
    """The largest difference over all ticks; infinite where a number is missing."""
    if any(name not in found or len(found[name]) != len(expected[name]) for name in names):
        return float("inf")
    differences = [np.abs(found[name] - expected[name]) for name in names]
    return float(np.max(np.where(np.isnan(differences), np.inf, differences)))


def play(master: Master, system: System, expected: Columns) -> Outcome:
    """One package in one master."""
    head, blank = (system.name, master.name, master.version), ("",) * len(KINDS)
    allowed = f"{ROUNDING:.0e}"
    ticks = len(expected["cam.theta"])
    say(f"{master.name} {master.version}: {system.name}")
    try:
        with tempfile.TemporaryDirectory() as folder:
            found = master.runner(system, ticks, Path(folder) / "rows.csv")
    except Missing as reason:
        return Outcome((*head, *blank, allowed, f"skipped: {reason}"))
    except Failed as reason:
        return Outcome((*head, *blank, allowed, f"**fails**: {reason}"), wrong=True)
    largest = [apart(found, expected, names) for names in KINDS.values()]
    agrees = max(largest) <= ROUNDING
    cells = (*head, *(f"{value:.1e}" for value in largest), allowed)
    return Outcome((*cells, "agrees" if agrees else "**differs**"), wrong=not agrees)


def coupled(example: Example) -> Columns:
    """By FMPy, with a row for each tick."""
    system = example.system
    return couple(system.path, system.step, round(system.duration / system.step), WATCHED, PER_TICK)


def compare(name: str, package: Course, original: Course) -> list[Outcome]:
    """The package's story beside that of the Python version."""
    distance = float(np.max(np.abs(package.angle - original.angle)))
    agrees = distance <= ANGLE_APART
    verdict = ("**differs**", "agrees")
    rows = [
        Outcome(
            (
                name,
                "angle at every tick [mrad]",
                "",
                "",
                f"{1e3 * distance:.4f}",
                f"{1e3 * ANGLE_APART:g}",
                verdict[agrees],
            ),
            not agrees,
        )
    ]
    told = original.numbers()
    for what, number in package.numbers().items():
        share = abs(number - told[what]) / abs(told[what])
        agrees = share <= NUMBERS_APART
        cells = (f"{told[what]:.4f}", f"{number:.4f}", f"{100 * share:.3f} %", f"{100 * NUMBERS_APART:g} %")
        rows.append(Outcome((name, what, *cells, verdict[agrees]), not agrees))
    return rows


CHECKERS = (
    (f"VDMCheck2 {install.version_of(install.VDMCHECK)}", players.vdmcheck),
    (f"fmutool {install.pins()['fmu-manipulation-toolbox']}", players.fmutool),
)


def check(name: str, checker: Callable[[Path], None]) -> Outcome:
    """What a checker finds in the parts; FMPy's has seen them when they were built."""
    say(f"{name}: {len(ssp_parts.PARTS)} parts")
    try:
        for part in ssp_parts.PARTS:
            checker(part.path)
    except Missing as reason:
        return Outcome((name, f"skipped: {reason}"))
    except Failed as reason:
        return Outcome((name, f"**{part.identifier}**: {reason}"), wrong=True)
    return Outcome((name, "finds nothing"))


CHECK_HEAD = ("checker of the parts", "verdict")
MASTER_HEAD = ("system", "master", "version", *KINDS, "allowed", "verdict")
STORY_HEAD = ("system", "what", "Python", "package", "apart", "allowed", "verdict")


def table(head: Sequence[str], outcomes: Sequence[Outcome]) -> list[str]:
    rows = [head, *(o.cells for o in outcomes)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(head))]
    lines = [" | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    lines.insert(1, " | ".join("-" * width for width in widths))
    return [f"| {line} |" for line in lines]


def markdown(checks: Sequence[Outcome], masters: Sequence[Outcome], stories: Sequence[Outcome]) -> str:
    page = (ssp_parts.SOURCES / "page.md").read_text()
    facts = f"versions: Python {platform.python_version()}, FMPy {version('fmpy')}"
    page = page.replace("<!-- checks -->", "\n".join(table(CHECK_HEAD, checks)))
    page = page.replace("<!-- masters -->", "\n".join(table(MASTER_HEAD, masters)))
    return page.replace("<!-- stories -->", "\n".join([*table(STORY_HEAD, stories), "", facts]))


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--only", help="names of masters, with commas; nothing is written then")
    only = parser.parse_args().only
    chosen = [master for master in MASTERS if only is None or master.name in only.split(",")]
    ssp_parts.build()
    checks = [check(*row) for row in CHECKERS] if only is None else []
    masters: list[Outcome] = []
    stories: list[Outcome] = []
    for make in EXAMPLES.values():
        example = make()
        package = example.system.write()
        say(f"FMPy: {package.relative_to(ssp_parts.ROOT)}")
        columns = coupled(example)
        masters += [play(master, example.system, columns) for master in chosen]
        stories += compare(example.system.name, example.course(columns), example.original())
    print(
        *table(CHECK_HEAD, checks),
        "",
        *table(MASTER_HEAD, masters),
        "",
        *table(STORY_HEAD, stories),
        sep="\n",
    )
    if only is None:
        (ssp_parts.ROOT / "docs/ssp.md").write_text(markdown(checks, masters, stories))
        say("written to docs/ssp.md")
    return int(any(o.wrong for o in (*checks, *masters, *stories)))


if __name__ == "__main__":
    sys.exit(main())
