"""Runs the examples as SSP packages in ecos and libcosim, and compares with the Python versions.

    ./build.sh run ssp                all, written to docs/use-ssp.md
    ./build.sh run ssp --only ecos    one master; nothing is written

The packages go to build/ssp. Each master must agree to rounding with the same FMUs coupled by FMPy in the
same order. These must agree with the Python versions as closely as computing ahead makes up for the two steps
that a command takes. A master that cannot be installed is skipped, with the reason. The exit code is 1 if a
master that ran does not agree.
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

from benchmarks.harness.circumstances import core_of
from benchmarks.harness.old_figures import with_line
from dualcam.ssp import START
from system_examples.ssp import clamp_runs, compilation, hosts, parts
from system_examples.ssp.coupling import Columns, couple
from system_examples.ssp.outcome import Outcome, largest_difference, table
from system_examples.ssp.package import ExampleSystem
from system_examples.ssp.systems import EXAMPLES, STEPS_PER_PERIOD, WATCHED, Example, Run
from verification.masters import install, players
from verification.masters.install import Failed, Missing, say

# libcosim counts whole nanoseconds, FMPy and ecos add steps: their times differ by 1e-12 s in the end. The
# knee's cam is integrated to 1e-9. In rad, rad/s, N.m and J.
ROUNDING = 1e-9
ANGLE_TOLERANCE = 1e-4  # rad, to the Python version: less than a count of the motor's encoder
FIGURE_TOLERANCE = 0.02  # relative

Runner = Callable[[ExampleSystem, int, Path], Columns]


def arguments(system: ExampleSystem, periods: int, file: Path) -> list[str | Path]:
    """The arguments of a program in tests/verification/masters/hosts that runs the package in a master."""
    return [system.path, START, repr(system.step), str(periods), str(STEPS_PER_PERIOD), file, *WATCHED]


def ecos(system: ExampleSystem, periods: int, file: Path) -> Columns:
    """The run by ecos; Missing or Failed if there is none."""
    return hosts.ecos(arguments(system, periods, file), file)


def libcosim(system: ExampleSystem, periods: int, file: Path) -> Columns:
    """The run by libcosim; Missing or Failed if there is none."""
    return hosts.libcosim(arguments(system, periods, file), file)


@dataclass(frozen=True)
class Master:
    """A master that runs packages."""

    name: str
    package: str
    runner: Runner

    @property
    def version(self) -> str:
        """Its pinned version."""
        return install.pins()[self.package]


MASTERS = (Master("ecos", "ecospy", ecos), Master("libcosim", "libcosimpy", libcosim))
KINDS = {  # columns of the table
    "angle [rad]": ("cam.theta", "controller.reference"),
    "speed [rad/s]": ("cam.omega",),
    "torque [N.m]": ("motor.tau",),
    "accounts [J]": tuple(n for n in WATCHED if n.startswith(("motor.heat", "motor.energy", "cam.energy"))),
}


def run_in(master: Master, system: ExampleSystem, expected: Columns) -> Outcome:
    """One package in one master, against `expected`."""
    head, blank = (system.name, master.name, master.version), ("",) * len(KINDS)
    allowed = f"{ROUNDING:.0e}"
    periods = len(expected["cam.theta"])
    say(f"{master.name} {master.version}: {system.name}")
    try:
        with tempfile.TemporaryDirectory() as folder:
            found = master.runner(system, periods, Path(folder) / "rows.csv")
    except Missing as reason:
        return Outcome((*head, *blank, allowed, f"skipped: {reason}"))
    except Failed as reason:
        return Outcome((*head, *blank, allowed, f"**fails**: {reason}"), wrong=True)
    largest = [largest_difference(found, expected, names) for names in KINDS.values()]
    agrees = max(largest) <= ROUNDING
    cells = (*head, *(f"{value:.1e}" for value in largest), allowed)
    return Outcome((*cells, "agrees" if agrees else "**differs**"), wrong=not agrees)


def coupled(example: Example) -> Columns:
    """The run by FMPy, with a row for each control period."""
    system = example.system
    return couple(system.path, system.step, round(system.duration / system.step), WATCHED, STEPS_PER_PERIOD)


def compare(name: str, package: Run, python: Run) -> list[Outcome]:
    """The package's run against that of the Python version."""
    distance = float(np.max(np.abs(package.angle - python.angle)))
    agrees = distance <= ANGLE_TOLERANCE
    verdict = ("**differs**", "agrees")
    rows = [
        Outcome(
            (
                name,
                "angle at every tick [mrad]",
                "",
                "",
                f"{1e3 * distance:.4f}",
                f"{1e3 * ANGLE_TOLERANCE:g}",
                verdict[agrees],
            ),
            not agrees,
        )
    ]
    expected = python.figures()
    for what, figure in package.figures().items():
        share = abs(figure - expected[what]) / abs(expected[what])
        agrees = share <= FIGURE_TOLERANCE
        figures = (f"{expected[what]:.4f}", f"{figure:.4f}", f"{100 * share:.3f} %")
        cells = (name, what, *figures, f"{100 * FIGURE_TOLERANCE:g} %", verdict[agrees])
        rows.append(Outcome(cells, not agrees))
    return rows


CHECKERS = (
    (f"VDMCheck2 {install.version_of(install.VDMCHECK)}", players.vdmcheck),
    (f"fmutool {install.pins()['fmu-manipulation-toolbox']}", players.fmutool),
)


def check(name: str, checker: Callable[[Path], None]) -> Outcome:
    """What a checker finds in the parts; FMPy's has seen them when they were built."""
    say(f"{name}: {len(parts.PARTS)} parts")
    try:
        for part in parts.PARTS:
            checker(part.path)
    except Missing as reason:
        return Outcome((name, f"skipped: {reason}"))
    except Failed as reason:
        return Outcome((name, f"**{part.identifier}**: {reason}"), wrong=True)
    return Outcome((name, "finds nothing"))


CHECK_HEAD = ("checker of the parts", "verdict")
MASTER_HEAD = ("system", "master", "version", *KINDS, "allowed", "verdict")
PYTHON_HEAD = ("system", "what", "Python", "package", "apart", "allowed", "verdict")


def markdown(
    checks: Sequence[Outcome],
    masters: Sequence[Outcome],
    pythons: Sequence[Outcome],
    clamps: Sequence[Outcome],
) -> str:
    """The page docs/use-ssp.md."""
    page = (compilation.SOURCES / "page.md").read_text()
    facts = f"versions: Python {platform.python_version()}, FMPy {version('fmpy')}, core {core_of()}"
    page = page.replace("<!-- checks -->", "\n".join(table(CHECK_HEAD, checks)))
    page = page.replace("<!-- clamp -->", "\n".join(table(clamp_runs.HEAD, clamps)))
    page = page.replace("<!-- masters -->", "\n".join(table(MASTER_HEAD, masters)))
    return page.replace("<!-- python -->", "\n".join([*table(PYTHON_HEAD, pythons), "", facts]))


def main() -> int:
    """Command line; returns the exit code."""
    parser = argparse.ArgumentParser(prog="ssp", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--only", help="names of masters, with commas; nothing is written then")
    only = parser.parse_args().only
    names = None if only is None else only.split(",")
    chosen = [master for master in MASTERS if names is None or master.name in names]
    compilation.build()
    checks = [check(*row) for row in CHECKERS] if only is None else []
    masters: list[Outcome] = []
    pythons: list[Outcome] = []
    for build_example in EXAMPLES.values():
        example = build_example()
        package = example.system.write()
        say(f"FMPy: {package.relative_to(compilation.ROOT)}")
        columns = coupled(example)
        masters += [run_in(master, example.system, columns) for master in chosen]
        pythons += compare(example.system.name, example.package_run(columns), example.python_run())
    clamps = clamp_runs.outcomes(names)
    print(
        *table(CHECK_HEAD, checks),
        "",
        *table(MASTER_HEAD, masters),
        "",
        *table(PYTHON_HEAD, pythons),
        "",
        *table(clamp_runs.HEAD, clamps),
        sep="\n",
    )
    if only is None:
        page = with_line(markdown(checks, masters, pythons, clamps))
        (compilation.ROOT / "docs/use-ssp.md").write_text(page)
        say("written to docs/use-ssp.md")
    return int(any(o.wrong for o in (*checks, *masters, *pythons, *clamps)))


if __name__ == "__main__":
    sys.exit(main())
