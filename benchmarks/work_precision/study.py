"""All settings of a scene: their errors, their times in turns, and the check of the reference."""

from __future__ import annotations

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
from benchmarks.work_precision.lines import OURS, Run, lines_of
from benchmarks.work_precision.plain_cam import PlainCam, scipy_advance
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
