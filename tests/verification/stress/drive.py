"""Drives the FMU's C functions through a scene and checks the laws at every communication point."""

from __future__ import annotations

import math
import os
import time
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import core
from benchmarks.harness.oracles import Interval, driver, reference
from verification.stress.scene import ACCOUNTS, COMPARED, DEFAULT_TOLERANCE, REALS, Scene, Trace

FOLDER = core.BUILD / "stress"
LONGEST_STEP = 2.0  # s, a doStep that takes longer breaks a law
CLEAR = ("must", "allowed", "jam", "too many segments")  # a refusal has one of these words

Cut = Callable[[int, float], Sequence[float]]  # number and duration of an interval -> communication points


@dataclass(frozen=True)
class Libraries:
    """The shipped library, and the same without its closed forms."""

    shipped: Path
    general: Path

    def load(self) -> dict[bool, Any]:
        """By Scene.general."""
        return {False: driver.load(self.shipped), True: driver.load(self.general)}


def shipped_library() -> Path:
    """The library of the FMU."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    shipped, fresh = FOLDER / "shipped.so", FOLDER / f"shipped.{os.getpid()}"
    with zipfile.ZipFile(core.fmu_path(core.FORWARD)) as archive:
        fresh.write_bytes(archive.read(f"binaries/linux64/{core.FORWARD}.so"))
    fresh.replace(shipped)
    return shipped


def prepare() -> Libraries:
    return Libraries(shipped_library(), core.library_without_closed_forms(FOLDER / "general.so"))


def equal_cuts(steps: int) -> Cut:
    return lambda _, length: np.linspace(0.0, length, steps + 1).tolist()


def finite(value: float, otherwise: float = 0.0) -> float:
    return value if math.isfinite(value) else otherwise


class Refusal(Exception):
    """The FMU has refused a call with a message."""


class Run:
    """One run of a scene through the FMU, which fills a Trace."""

    def __init__(self, fmu: Any, scene: Scene, cut: Cut) -> None:
        self.fmu, self.scene, self.cut, self.trace = fmu, scene, cut, Trace()
        self.heats = {name: 0.0 for name in reference.HEATS}  # J, the largest until now
        self.worst_heat, self.worst_residual = 0.0, 0.0  # J

    def follow(self) -> None:
        """The whole scene, until a refusal or the first NaN."""
        trace = self.trace
        try:
            values = self.initialise()
            self.start, self.largest = values, {name: abs(values[name]) for name in COMPARED}
            for number, interval in enumerate(self.scene.intervals):
                for begin, end in pairwise(float(t) for t in self.cut(number, interval.duration)):
                    self.set_inputs(interval, begin)
                    self.step(end - begin, number)
                    values = self.read()
                    if not self.obeys_the_laws_of_a_point(values, number):
                        return
                trace.read.append(values)
        except Refusal as refusal:
            trace.refusal = str(refusal)
            if not any(word in trace.refusal for word in CLEAR):
                trace.problems.append(f"unclear refusal: {trace.refusal}")
            return
        self.judge_energy(values)

    def refuse(self, where: str) -> Refusal:
        return Refusal(f"{where}: {self.fmu.messages[-1].text if self.fmu.messages else ''}")

    def initialise(self) -> dict[str, float]:
        first, fmu = self.scene.intervals[0], self.fmu
        integers = reference.INTEGERS
        given = {n: int(v) if n in integers else v for n, v in self.scene.params.items() if v != ""}
        for name, value in (given | {"tau": first.tau, "F_ext": first.F_ext}).items():
            if fmu.try_set({name: value}) != driver.OK:
                raise self.refuse("setting")
        fmu.setup(0.0, self.scene.tolerance)
        fmu.ok("fmi2EnterInitializationMode")
        if fmu.call("fmi2ExitInitializationMode") != driver.OK:
            raise self.refuse("initialization")
        self.lower, self.upper = (fmu.get(f"stop.{side}") for side in ("lower", "upper"))
        return self.read()

    def read(self) -> dict[str, float]:
        status, values = self.fmu.try_get(REALS)
        if status != driver.OK:
            raise AssertionError(f"reading is refused: {self.fmu.messages[-1:]}")
        integers = {name: self.fmu.get(name) for name in ("events", "mode")}
        return dict(zip(REALS, values, strict=True)) | integers

    def set_inputs(self, interval: Interval, begin: float) -> None:
        """`begin`: time since the start of the interval [s]."""
        inputs = {name: interval.at(name, begin) for name in ("tau", "F_ext")}
        self.fmu.set({name: u[0] for name, u in inputs.items()})
        rates = {name: u[1:] for name, u in inputs.items() if any(u[1:])}
        if rates:
            self.fmu.set_derivatives(rates)

    def step(self, h: float, number: int) -> None:
        """`number`: of the interval."""
        fmu, trace = self.fmu, self.trace
        begun = time.process_time()
        status = fmu.call("fmi2DoStep", fmu.time, h, 1)
        took = time.process_time() - begun
        trace.step, trace.total = max(trace.step, took), trace.total + took
        if took > LONGEST_STEP:
            trace.problems.append(f"a doStep of {took:.1f} s (interval {number}, h = {h:g})")
        if status != driver.OK:
            raise self.refuse(f"doStep (t = {fmu.time:g}, h = {h:g})")
        fmu.time += h
        trace.simulated += h

    def obeys_the_laws_of_a_point(self, values: dict[str, float], number: int) -> bool:
        """False where the run cannot go on: a NaN."""
        problems = self.trace.problems
        bad = [name for name in REALS if math.isnan(values[name])]
        if bad:
            problems.append(f"NaN under OK: {bad} (interval {number})")
            return False
        if not self.lower <= values["theta"] <= self.upper:
            problems.append(f"theta = {values['theta']!r} outside its stops (interval {number})")
        for name in self.largest:
            self.largest[name] = max(self.largest[name], abs(values[name]))
        self.worst_residual = max(self.worst_residual, abs(values["energy.residual"]))
        for name in self.heats:
            heat = values[f"energy.{name}"]
            self.worst_heat = max(self.worst_heat, self.heats[name] - heat)
            self.heats[name] = max(self.heats[name], heat)
        return True

    def judge_energy(self, values: dict[str, float]) -> None:
        """Energy is conserved and heat never given back. `values`: those at the end."""
        trace, largest, stroke = self.trace, self.largest, self.upper - self.lower
        largest["omega"] = max(largest["omega"], finite(values["peak.omega"]))
        trace.largest = largest
        trace.turnover = finite(values["peak.torque"]) * stroke
        # Motion to and fro inside a step does not show at its ends, but its rounding errors do.
        travel = min(stroke, finite(values["peak.omega"], math.inf) * trace.simulated)
        rounding = 1e-13 * values["peak.torque"] * travel
        # The height z is known to a rounding of its largest value, and a stored energy likewise.
        rounding += float(np.finfo(float).eps) * trace.turnover
        initial = abs(self.start["energy.spring"]) + abs(self.start["energy.kinetic"])
        energy = max([initial, *(largest[f"energy.{name}"] for name in ACCOUNTS)])
        trace.residual = max(self.worst_residual - rounding, 0.0) / energy if energy else 0.0
        # Each swing to and fro passes the energy on with an error of its own; the errors add up.
        swings = max(1.0, values["events"] / 1000)
        allowed = 10.0 * (self.scene.tolerance or DEFAULT_TOLERANCE) * energy * swings + rounding
        if self.worst_residual > allowed:
            trace.problems.append(f"energy.residual {self.worst_residual:.3g} J of {energy:.3g} J")
        if self.worst_heat > allowed:
            trace.problems.append(f"heat given back: {self.worst_heat:.3g} J of {energy:.3g} J")


def drive(library: Any, scene: Scene, cut: Cut | None = None) -> Trace:
    """The trace of a scene. `cut`: communication points, if not the equal steps of the scene."""
    fmu = driver.Driver(library)
    run = Run(fmu, scene, cut or equal_cuts(scene.steps))
    try:
        run.follow()
    finally:
        fmu.free()
    return run.trace
