"""Scenes with any grooves, solved by the reference simulator. Tests compare the FMU with these solutions.

    python tests/support/general_scenes.py        computes them anew: some minutes

A suite that solved all of them would take too long, so they are kept in data/general_scenes.json.gz, and the
suite recomputes a few of them to prove the file. Each scene was solved twice, the second time with all data
changed in their last digit and another tolerance of the integrator; scenes in which that changes anything by
more than 1e-11, or in which the count of mode changes is a matter of rounding (but for a limited number of
trains of bounces), were replaced by others.
"""

from __future__ import annotations

import gzip
import json
import math
import signal
import tempfile
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import astuple, dataclass, replace
from itertools import count
from multiprocessing import Pool
from pathlib import Path
from typing import Any

import numpy as np
from reference import (
    ENERGIES,
    INTEGERS,
    PEAKS,
    Interval,
    Point,
    Refused,
    random_general_scene,
    read_table,
    simulate,
    write_table,
)
from rich.progress import Progress

FILE = Path(__file__).resolve().parents[1] / "data" / "general_scenes.json.gz"
MOTION = ("theta", "omega", "z", "v")
MEASURED = (*MOTION, *(f"energy.{n}" for n in ENERGIES), *(f"peak.{n}" for n in PEAKS))
WANTED = {"inertial": 154, "viscous": 33, "rate-independent": 33}
FADING = "bounces within rounding"
STILL = "speed within rounding"
FADING_SHARE = 0.2  # of all scenes, at most
LARGEST_ERROR = 1e-11
MOST_EVENTS = 150
PATIENCE = 60  # seconds of processor time for one scene
PROBE = 1e-8  # relative change of the data, to measure how it is amplified
Tables = dict[str, tuple[list[float], list[float]]]


@dataclass
class Scene:
    number: int  # seed of the random generator
    regime: str
    params: dict[str, Any]
    intervals: list[Interval]
    points: list[Point]
    error: dict[str, float]  # estimated absolute error of the solution, largest over the points
    condition: float  # largest relative change of motion and accounts, per relative change of the data


Drawn = tuple[dict[str, Any], list[Interval]]
Found = tuple[Scene, Tables]


def regime(params: Mapping[str, Any]) -> str:
    if any(value for name, value in params.items() if name.startswith("inertia.")):
        return "inertial"
    damped = any(value for name, value in params.items() if name.startswith(("damper.", "shaft.damping")))
    return "viscous" if damped else "rate-independent"


def scales(points: Sequence[Point]) -> dict[str, float]:
    """Unit in which errors of each variable are measured: the largest angle, speed, account or load of the
    scene."""
    last = points[-1]
    energy = max(abs(value) for p in points for value in p.energy.values())
    found = {f"energy.{name}": energy for name in ENERGIES}
    found["theta"], found["z"] = max(abs(p.theta) for p in points), max(abs(p.z) for p in points)
    speed = last.peak["omega"]  # infinite after a jump of theta
    found["omega"] = speed if math.isfinite(speed) else max(abs(p.omega) for p in points)
    found["v"] = found["omega"] * max((abs(p.z / p.theta) for p in points if p.theta), default=1.0)
    found["v"] = max(found["v"], *(abs(p.v) for p in points))
    found |= {f"peak.{name}": last.peak[name] for name in PEAKS}
    return {name: float(value) or 1.0 for name, value in found.items()}


def wrong_modes(read: Sequence[Mapping[str, Any]], points: Sequence[Point]) -> list[str]:
    """One message for each wrong mode and each wrong count of mode changes among the values read at these
    points. An interval in which the reference has doubts is not compared, nor is the count of the interval
    after it."""
    wrong, doubtful = [], False
    counted, expected = 0, 0  # events at the end of the interval before
    for number, (values, point) in enumerate(zip(read, points, strict=True)):
        if not point.doubts:
            if values["mode"] != point.mode:
                wrong.append(f"interval {number}: mode {values['mode']}, not {point.mode}")
            changes = values["events"] - counted, point.events - expected
            if not doubtful and changes[0] != changes[1]:
                wrong.append(f"interval {number}: {changes[0]} mode changes, not {changes[1]}")
        counted, expected, doubtful = values["events"], point.events, bool(point.doubts)
    return wrong


def nudged(
    params: Mapping[str, Any], intervals: Sequence[Interval], rng: np.random.Generator, by: float = 2.0**-52
) -> tuple[dict[str, Any], list[Interval]]:
    """The same scene with data changed by the relative amount `by`. A restitution stays at most 1."""
    fixed = {"initial.theta", "stop.lower", "stop.upper", *INTEGERS}

    def nudge(value: float) -> float:
        return value * (1 + rng.choice([-1, 1]) * by)

    changed = {n: nudge(v) if isinstance(v, float) and n not in fixed else v for n, v in params.items()}
    if "stop.restitution" in changed:
        changed["stop.restitution"] = min(changed["stop.restitution"], 1.0)
    return changed, [replace(i, tau=nudge(i.tau), F_ext=nudge(i.F_ext)) for i in intervals]


def differences(points: Sequence[Point], others: Sequence[Point]) -> dict[str, float]:
    """Largest difference of each variable over the points. Equal infinities differ by 0."""
    found = {}
    for name in MEASURED:
        pairs = [(p.value(name), q.value(name)) for p, q in zip(points, others, strict=True)]
        found[name] = max(0.0 if a == b else abs(a - b) for a, b in pairs)
    return found


@contextmanager
def patience() -> Iterator[None]:
    """TimeoutError after PATIENCE seconds of processor time."""

    def give_up(*_: object) -> None:
        raise TimeoutError

    signal.signal(signal.SIGPROF, give_up)
    signal.setitimer(signal.ITIMER_PROF, PATIENCE)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)


def fit(number: int, draw: Callable[[str], Drawn | None], rng: np.random.Generator) -> Found | None:
    """Scene `number` with its tables, which `draw` writes into a folder; None if it is not fit for a test."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            with patience():
                drawn = draw(folder)
                if drawn is None:
                    return None
                params, intervals = drawn
                points = simulate(params, intervals)
                if points[-1].events > MOST_EVENTS:
                    return None
                others = simulate(*nudged(params, intervals, rng), rtol=3e-13)
                apart = simulate(*nudged(params, intervals, rng, PROBE))
        except (Refused, ArithmeticError, ValueError, TypeError, TimeoutError):
            return None
        tables = {n: read_table(p) for n, p in params.items() if n.endswith(".table") and p}
    doubts = {doubt for p in (*points, *others) for doubt in p.doubts}
    same = [(p.mode, p.events) for p in points] == [(p.mode, p.events) for p in others]
    error, size = differences(points, others), scales(points)
    closed = all(abs(p.energy["residual"]) <= LARGEST_ERROR * size["energy.residual"] for p in points)
    small = all(error[name] <= LARGEST_ERROR * size[name] for name in MEASURED)
    if not (doubts <= {FADING, STILL} and (same or doubts) and small and closed):
        return None
    moved = differences(points, apart)
    condition = max(moved[n] / size[n] for n in MEASURED if not n.startswith("peak.")) / PROBE
    return Scene(number, regime(params), params, intervals, points, error, condition), tables


def candidate(number: int) -> Found | None:
    rng = np.random.default_rng([20, number])
    return fit(number, lambda folder: random_general_scene(rng, folder), rng)


def compute() -> Iterator[Found]:
    """The first fit scenes of each regime, in the order of their numbers."""
    wanted, fading = Counter(WANTED), int(FADING_SHARE * sum(WANTED.values()))
    with Pool() as pool:
        for found in pool.imap(candidate, count()):
            if found is None or not wanted[found[0].regime]:
                continue
            if any(p.doubts for p in found[0].points):
                if not fading:
                    continue
                fading -= 1
            wanted[found[0].regime] -= 1
            yield found
            if not wanted.total():
                pool.terminate()
                return


def to_json(scene: Scene, tables: Tables) -> dict[str, Any]:
    points = [
        [
            *(p.value(name) if math.isfinite(p.value(name)) else None for name in MEASURED),
            p.mode,
            p.events,
            p.doubts,
        ]
        for p in scene.points
    ]
    return {
        "number": scene.number,
        "params": {name: value for name, value in scene.params.items() if name not in tables},
        "tables": tables,
        "intervals": [astuple(i) for i in scene.intervals],
        "points": points,
        "error": {name: float(f"{value:.1e}") for name, value in scene.error.items()},
        "condition": float(f"{scene.condition:.1e}"),
    }


def from_json(entry: dict[str, Any], folder: Path) -> Scene:
    params = dict(entry["params"])
    for name, (psi, z) in entry["tables"].items():
        params[name] = str(folder / f"{entry['number']}-{name[:4]}.csv")
        write_table(params[name], psi, z)
    points = []
    for *values, mode, events, doubts in entry["points"]:
        found = {n: math.inf if v is None else v for n, v in zip(MEASURED, values, strict=True)}
        energy = {name: found[f"energy.{name}"] for name in ENERGIES}
        peak = {name: found[f"peak.{name}"] for name in PEAKS}
        points.append(Point(*(found[name] for name in MOTION), mode, events, energy, peak, doubts))
    intervals = [Interval(*values) for values in entry["intervals"]]
    own = entry["error"], entry["condition"]
    return Scene(entry["number"], regime(params), params, intervals, points, *own)


def load(folder: str | Path, file: Path = FILE) -> list[Scene]:
    """All scenes of the file; their tables are written into `folder`."""
    return [from_json(entry, Path(folder)) for entry in json.loads(gzip.decompress(file.read_bytes()))]


def save(entries: Sequence[dict[str, Any]], file: Path) -> None:
    file.write_bytes(gzip.compress(json.dumps(entries, separators=(",", ":")).encode(), mtime=0))
    print(f"{len(entries)} scenes, {file.stat().st_size / 1000:.0f} kB in {file}")


def main() -> None:
    entries = []
    with Progress() as progress:
        task = progress.add_task("scenes", total=sum(WANTED.values()))
        for scene, tables in compute():
            entries.append(to_json(scene, tables))
            progress.advance(task)
    save(entries, FILE)


if __name__ == "__main__":
    main()
