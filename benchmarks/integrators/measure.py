"""Runs every method in a scene at every tolerance: work, time and error."""

from __future__ import annotations

import math
import random
import statistics
from dataclasses import dataclass, field

from rich.console import Console
from rich.progress import track

from benchmarks.integrators.methods import Candidates, gauss, methods, radau
from benchmarks.integrators.scenes import Scene
from benchmarks.integrators.structs import MethodStruct, OutcomeStruct, SceneStruct

TOLERANCES = [1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12]
SHORTEST_TIMING = 3e-4  # s
MOST_SECONDS = 0.2  # of all timings of a case


def in_parts(scene: Scene, parts: int) -> SceneStruct:
    struct = SceneStruct.from_buffer_copy(scene.struct)
    struct.parts = parts
    return struct


def reference(candidates: Candidates, scene: Scene) -> tuple[tuple[float, float], float]:
    """(theta, omega) at the end, and the difference of two unrelated methods, relative to the scales.

    SystemExit if one of them fails."""
    first = candidates.run(in_parts(scene, 500), radau(7, linear=True), 1e-13)[1]
    if scene.stiff:
        second = candidates.run(in_parts(scene, 1000), gauss(5), 1e-13)[1]
    else:
        second = candidates.run(in_parts(scene, 300), MethodStruct(1), 1e-13)[1]
    if first.failed < 0 or second.failed < 0:
        raise SystemExit(f"{scene.name}: no reference")
    return (first.theta, first.omega), max(errors(scene, second, (first.theta, first.omega)))


def errors(scene: Scene, outcome: OutcomeStruct, exact: tuple[float, float]) -> tuple[float, float]:
    return (
        abs(outcome.theta - exact[0]) / scene.struct.theta_scale,
        abs(outcome.omega - exact[1]) / scene.struct.omega_scale,
    )


@dataclass
class Result:
    scene: str
    method: str
    tolerance: float
    outcome: OutcomeStruct
    error: tuple[float, float]
    nanoseconds: float  # of a run, or of a communication step
    ratio: float  # to one exp and one sincos

    @property
    def good(self) -> bool:
        return self.outcome.failed >= 0 and math.isfinite(max(self.error))

    @property
    def iterations(self) -> float:
        return self.outcome.newton / self.outcome.solves if self.outcome.solves else math.nan


@dataclass
class Case:
    """A method at a tolerance: its first run, and (time of a run, unit) of the rounds [s]."""

    name: str
    method: MethodStruct
    tolerance: float
    repeats: int  # of the run in each timing
    outcome: OutcomeStruct
    times: list[tuple[float, float]] = field(default_factory=list)

    @property
    def enough(self) -> bool:
        """Whether further rounds of a slow case would only take time."""
        return sum(seconds for seconds, _ in self.times) > MOST_SECONDS

    def result(self, scene: Scene, exact: tuple[float, float]) -> Result:
        seconds = statistics.median(run for run, _ in self.times) / scene.parts
        ratio = statistics.median(run / unit for run, unit in self.times) / scene.parts
        error = errors(scene, self.outcome, exact)
        return Result(scene.name, self.name, self.tolerance, self.outcome, error, seconds * 1e9, ratio)


def cases_of(candidates: Candidates, scene: Scene) -> list[Case]:
    """A method that gives up after a long time is not tried at finer tolerances."""
    cases: list[Case] = []
    slow: set[str] = set()
    for name, method in methods().items():
        for tolerance in TOLERANCES:
            if name in slow:
                continue
            seconds, outcome = candidates.run(scene.struct, method, tolerance)
            if outcome.failed < 0 and seconds > 0.05:
                slow.add(name)
            repeats = max(1, int(SHORTEST_TIMING / seconds))
            cases.append(Case(name, method, tolerance, repeats, outcome))
    return cases


def measure(
    candidates: Candidates, scene: Scene, rounds: int, console: Console
) -> tuple[list[Result], float]:
    """The results of all cases, and how far the two reference solutions are apart."""
    exact, doubt = reference(candidates, scene)
    cases = cases_of(candidates, scene)
    order = list(range(len(cases)))
    shuffle = random.Random(3).shuffle
    for _ in track(range(rounds), scene.name, console=console, transient=True):
        shuffle(order)
        for number in order:
            case = cases[number]
            if case.enough:
                continue
            unit = candidates.unit()
            run, _ = candidates.run(scene.struct, case.method, case.tolerance, case.repeats)
            case.times.append((run, unit))
    return [case.result(scene, exact) for case in cases], doubt


def cost_of_evaluation(candidates: Candidates, scene: Scene, with_partials: bool) -> float:
    """Of alpha, in units of one exp and one sincos."""
    return statistics.median(
        candidates.evaluation(scene.struct, with_partials) / candidates.unit() for _ in range(51)
    )
