"""Runs the spring clamp's package in ecos and libcosim, with and without connections to parameters."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dualcam import Fmu
from dualcam.ssp import START
from dualcam.systems.machines import clamp
from system_examples.ssp.clamp import FRICTION_CONNECTIONS, WATCHED, clamp_system
from system_examples.ssp.components import CAM
from system_examples.ssp.coupling import Columns, couple
from system_examples.ssp.hosts import Host, ecos, libcosim
from system_examples.ssp.outcome import Outcome, largest_difference
from system_examples.ssp.package import ExampleSystem
from verification.masters import install
from verification.masters.install import Failed, Missing, say

CYCLES = round(3600.0 / clamp.MOTION.period)
CONNECTIONS, SCRIPT = "connections", "script"
HEATS = ("cam.energy.heat_cam1", "cam.energy.heat_cam2", "thermal.heat_in", "thermal.heat_out")
KINDS = {  # columns of the table
    "angle [rad]": ("cam.theta",),
    "command [N.m]": ("servo.command",),
    "temperature [K]": ("thermal.temperature.contact", "thermal.temperature.housing"),
    "heat [J]": HEATS,
}
# Over an hour, in rad, N.m, K and J: the FMU integrates slip to 1e-9, the heat is 1e4 J.
ALLOWED = 1e-7
HEAD = ("package", "master", "version", "friction passed on by", *KINDS, "allowed", "verdict")


@dataclass(frozen=True)
class Case:
    """A package in a master."""

    master: str
    package: str  # on PyPI
    host: Host
    passed_by: str
    refused: bool = False  # the master is known to refuse connections to parameters


CASES = (
    Case("ecos", "ecospy", ecos, CONNECTIONS),
    Case("libcosim", "libcosimpy", libcosim, CONNECTIONS, refused=True),
    Case("libcosim", "libcosimpy", libcosim, SCRIPT),
)


def rows_of(case: Case, system: ExampleSystem, cycles: int) -> Columns:
    """The run in a master, one row per cycle; Missing or Failed if there is none."""
    passed = [f"{source}->{target}" for source, target in FRICTION_CONNECTIONS]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "rows.csv"
        numbers = [repr(system.step), str(cycles), str(clamp.SAMPLES_PER_CYCLE)]
        words: list[str | Path] = [system.path, START, *numbers, file, *WATCHED]
        return case.host([*words, *(passed if case.passed_by == SCRIPT else [])], file)


def run_case(case: Case, systems: Mapping[str, ExampleSystem], expected: Columns) -> Outcome:
    """One package in one master, against `expected`."""
    system = systems[case.passed_by]
    version = install.pins()[case.package]
    head, blank = (system.name, case.master, version, case.passed_by), ("",) * len(KINDS)
    say(f"{case.master} {version}: {system.name}")
    try:
        found = rows_of(case, system, len(expected["cam.theta"]))
    except Missing as reason:
        return Outcome((*head, *blank, "", f"skipped: {reason}"))
    except Failed as reason:
        if case.refused and "causality 'input'" in str(reason):
            return Outcome((*head, *blank, "", "refuses parameters"))
        return Outcome((*head, *blank, "", f"**fails**: {reason}"), wrong=True)
    largest = [largest_difference(found, expected, names) for names in KINDS.values()]
    agrees = max(largest) <= ALLOWED
    cells = (*head, *(f"{value:.1e}" for value in largest), f"{ALLOWED:.0e}")
    if case.refused:
        return Outcome((*cells, "**accepts parameters**"), wrong=True)
    return Outcome((*cells, "agrees" if agrees else "**differs**"), wrong=not agrees)


def beside_python(found: Columns) -> Outcome:
    """The coupled package against `dualcam.systems.machines.clamp.run`."""
    cycles = len(found["cam.theta"])
    with Fmu(CAM) as fmu:
        record = clamp.run(fmu, cycles)
    ends = record.thermal[1:]
    temperatures = [
        found[f"thermal.temperature.{name}"] - np.array([getattr(state, name) for state in ends])
        for name in ("contact", "housing")
    ]
    heats = [
        found[f"thermal.{name}"] - np.array([getattr(state, name) for state in ends])
        for name in ("heat_in", "heat_out")
    ]
    largest = [float(np.max(np.abs(difference))) for difference in (temperatures, heats)]
    agrees = max(largest) <= ALLOWED
    differences = ("", "", *(f"{value:.1e}" for value in largest))
    return Outcome(
        (
            *("spring_clamp", "Python", "", "Python", *differences, f"{ALLOWED:.0e}"),
            "agrees" if agrees else "**differs**",
        ),
        wrong=not agrees,
    )


def outcomes(only: list[str] | None = None, cycles: int = CYCLES) -> list[Outcome]:
    """The rows of the table, of all masters or of some."""
    systems = {
        name: clamp_system(cycles, parameter_connections=name == CONNECTIONS)
        for name in (CONNECTIONS, SCRIPT)
    }
    for system in systems.values():
        system.write()
    coupled, steps = systems[CONNECTIONS], cycles * clamp.SAMPLES_PER_CYCLE
    say(f"FMPy: {coupled.path.name}")
    expected = couple(coupled.path, coupled.step, steps, WATCHED, clamp.SAMPLES_PER_CYCLE)
    rows = [run_case(case, systems, expected) for case in CASES if only is None or case.master in only]
    return [*rows, beside_python(expected)]
