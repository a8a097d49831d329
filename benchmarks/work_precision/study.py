"""All settings of a scene: errors, times in turns, check of the reference, evaluations in SciPy."""

from __future__ import annotations

import itertools
import math
import statistics
from collections.abc import Callable
from dataclasses import dataclass, field

from rich.console import Console

from benchmarks.harness import core
from benchmarks.harness.oracles import reference
from benchmarks.harness.processes import TooLong, time_limit
from benchmarks.harness.timing import Ratio, in_turns
from benchmarks.work_precision.fmus import CFmu
from benchmarks.work_precision.lines import OURS, TOLERANCES, Run, event_line, lines_of
from benchmarks.work_precision.plain_cam import Advance, Array, PlainCam, Rates, scipy_advance
from benchmarks.work_precision.scenes import Scene, of_reference


def verify(scene: Scene) -> list[tuple[str, float]]:
    """The reference by a second method, the peers' equations by tight integration, and the FMU at 1e-12."""
    method, rtol = ("Radau", 1e-12) if scene.name == "stiff" else ("DOP853", 1e-13)
    cam = PlainCam(scene.parameters)
    plain = scene.result(cam.run(scene.pieces, scipy_advance(method, rtol)))
    _, fmu = CFmu(scene, core.FORWARD, dict(scene.parameters), 1e-12, 1).run()
    found = {f"plain_cam.py, {method} {rtol:g}": plain, "FMU 1e-12": fmu}
    if scene.exact:
        second = of_reference(reference.simulate(scene.parameters, scene.intervals))
        found = {"tests/reference, DOP853 1e-13": second} | found
    return [(name, max(scene.errors(result))) for name, result in found.items()]


@dataclass
class Setting:
    line: str
    name: str
    run: Run | None
    errors: tuple[float, float, float] = (math.nan, math.nan, math.nan)
    failure: str = ""
    first: float = math.inf  # s, of the run that gave the errors
    times: list[float] = field(default_factory=list)

    @property
    def error(self) -> float:
        return max(self.errors)

    @property
    def time(self) -> float:
        return statistics.median(self.times)

    def beats(self, other: Setting) -> bool:
        """By far: as exact in half the time."""
        return self.line == other.line and self.error <= other.error and self.first < 0.5 * other.first


def try_out(scene: Scene, line: str, name: str, make: Callable[[], Run], limit: float) -> Setting:
    """Runs the setting once: its error, or how it fails. `limit`: seconds."""
    made = Setting(line, name, None)
    try:
        run = make()
        with time_limit(limit):
            made.first, result = run()
        made.errors = scene.errors(result)
        if not math.isfinite(made.error) or made.error > 1.0:
            made.failure = f"wrong: error {made.error:.2g}"
        else:
            made.run = run
    except TooLong:
        made.failure = f"more than {limit:g} s"
    except Exception as problem:  # whatever a solver of somebody else raises is its failure
        made.failure = " ".join(f"{type(problem).__name__}: {problem}".split())[:60]
    return made


@dataclass
class Study:
    scene: Scene
    checks: list[tuple[str, float]]
    settings: list[Setting]

    @property
    def lines(self) -> list[str]:
        return list(dict.fromkeys(s.line for s in self.settings))

    def usable(self, line: str) -> list[Setting]:
        """The settings that were timed."""
        return [s for s in self.settings if s.line == line and s.times]

    def best(self, line: str, level: float) -> Setting | None:
        return min((s for s in self.usable(line) if s.error <= level), key=lambda s: s.time, default=None)

    def ratio(self, line: str, level: float) -> Ratio | None:
        """How many times as long as our best from C, at this error."""
        ours, peer = self.best(OURS, level), self.best(line, level)
        return Ratio.of(peer.times, ours.times) if ours and peer else None


def study(scene: Scene, rounds: int, limit: float, console: Console) -> Study:
    settings = [
        try_out(scene, line, name, make, limit)
        for line, made in lines_of(scene, console).items()
        for name, make in made.items()
    ]

    def block(run: Run) -> Callable[[], float]:
        return lambda: run()[0] / scene.duration

    worth = [s for s in settings if s.run and not any(other.beats(s) for other in settings)]
    blocks = {f"{s.line}, {s.name}": block(s.run) for s in worth if s.run}
    times = in_turns(blocks, rounds, scene.name, console)
    for s in settings:
        s.times = times.get(f"{s.line}, {s.name}", [])
    return Study(scene, verify(scene), settings)


class Counted:
    """An `advance` that counts the evaluations of the right-hand side."""

    def __init__(self, advance: Advance) -> None:
        self.inner, self.calls = advance, 0

    def advance(
        self, rates: Rates, sigma: int, left: float, theta: float, omega: float
    ) -> tuple[float, float, float]:
        def counting(t: float, y: Array) -> tuple[float, float]:
            self.calls += 1
            return rates(t, y)

        return self.inner(counting, sigma, left, theta, omega)


def evaluations(scene: Scene, level: float) -> dict[str, str]:
    """Number and time of the evaluations of the right-hand side by SciPy's fastest setting with at most that
    error."""
    best: dict[str, str] = {}
    least: float = math.inf
    for method, rtol in itertools.product(("DOP853", "LSODA"), TOLERANCES):
        run = event_line(scene, method)[f"rtol {rtol:g}"]()
        seconds, found = run()
        if seconds >= least or max(scene.errors(found)) > level:
            continue
        least = seconds
        cam = Counted(scipy_advance(method, rtol))
        PlainCam(scene.parameters).run(scene.pieces, cam.advance)
        best = {
            "scene": scene.name,
            "line": f"SciPy {method}",
            "setting": f"rtol {rtol:g}",
            "us_per_simulated_s": f"{1e6 * seconds / scene.duration:.4g}",
            "evaluations_per_simulated_s": f"{cam.calls / scene.duration:.4g}",
            "us_per_evaluation": f"{1e6 * seconds / cam.calls:.3g}",
        }
    return best
