"""Scenes that `compare.py` plays in two builds: mechanisms, inputs and steps, all by seeded draws.

Scene `number` of a group is the same on every machine with the same NumPy. A scene that the FMU refuses is a
scene, too: both builds have to refuse it.
"""

from __future__ import annotations

import gzip
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness.oracles import Interval, reference

Scalar = float | int | bool | str
Rng = np.random.Generator
FORWARD, INVERSE = "DualCamForward", "DualCamInverse"
FORWARD_ONLY = ("initial.", "stop.restitution")  # parameters that the inverse FMU has not
TOLERANCES = (1e-4, 1e-6, 1e-9, 1e-11)
GENERAL_SCENES = Path(__file__).resolve().parents[2] / "data" / "general_scenes.json.gz"
MOST_MOVES = 60  # of a random scene
SHORT_STEP = 1e-3  # s


@dataclass(frozen=True)
class Move:
    """One communication step."""

    length: float  # s
    values: Mapping[str, Scalar]  # set before the step
    derivatives: Mapping[str, Sequence[float]] = field(default_factory=dict)  # of inputs, orders 1 to 3
    state: str = ""  # before the step: keep, restore, or copy (restore through bytes)
    states: Sequence[float] = ()  # model exchange: continuous states; none: an Euler step from the last ones


@dataclass(frozen=True)
class Scene:
    title: str
    model: str
    parameters: Mapping[str, Scalar]
    moves: Sequence[Move]
    tolerance: float | None = None
    version: int = 2
    use: str = "co-simulation"  # or exchange, or early return (FMI 3.0)
    resets: bool = False  # plays some moves and resets the FMU before
    probes: bool = False  # reads every derivative of a variable by another one, after both ends of the scene
    read_every: int = 1  # moves
    read_most_every: int = 5  # moves; then derivatives and step.* are read, too


# ---- mechanisms ----


@dataclass(frozen=True)
class Drawn:
    """A random scene of the reference: parameters of the FMU, and intervals of its inputs."""

    parameters: dict[str, Scalar]
    intervals: Sequence[Interval]

    def range_of(self) -> tuple[float, float]:
        """Of theta [rad]."""
        return float(self.parameters.get("stop.lower", 0.0)), float(self.parameters.get("stop.upper", 1.3963))

    def time(self) -> float:
        """Of a typical motion [s]."""
        return float(np.median([interval.duration for interval in self.intervals]))

    def largest(self, name: str) -> float:
        """Of an input."""
        return max(abs(getattr(interval, name)) for interval in self.intervals)


def drawn(rng: Rng, helical: bool, folder: Path) -> Drawn:
    p, intervals = reference.random_scene(rng) if helical else reference.random_general_scene(rng, folder)
    return Drawn({**p, "ledger": bool(rng.random() < 0.85)}, intervals)


# ---- inputs and steps ----


def polynomial(u: Sequence[float], t: float) -> list[float]:
    """Value and derivatives at t of the sum of u_k t^k/k!."""
    n = len(u)
    return [sum(u[k + j] * t**j / math.factorial(j) for j in range(n - k)) for k in range(n)]


def draw_cuts(rng: Rng, duration: float) -> list[float]:
    """Times at which an interval is cut: whole, in parts, about each 1 ms, or very near to its ends."""
    kind = rng.choice(4, p=[0.45, 0.3, 0.2, 0.05])
    if kind == 0:
        return [0.0, duration]
    if kind == 3:
        return [0.0, duration * 1e-12, duration * (1.0 - 1e-9), duration]
    steps = max(1, int(rng.choice([2, 5, 12])) if kind == 1 else min(20, round(duration / SHORT_STEP)))
    return [0.0, *np.sort(rng.uniform(0.0, duration, steps - 1)).tolist(), duration]


def cut(duration: float, inputs: Mapping[str, Sequence[float]], times: Sequence[float]) -> Iterator[Move]:
    for start, end in pairwise(times):
        at = {name: polynomial(u, start) for name, u in inputs.items()}
        derivatives = {name: u[1:] for name, u in at.items() if any(u[1:])}
        yield Move(end - start, {name: u[0] for name, u in at.items()}, derivatives)


def log_uniform(rng: Rng, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw_polynomial(rng: Rng, size: float, duration: float, curved: float) -> list[float]:
    """A constant, ramp, parabola or cubic; `curved`: the share that is not constant."""
    order = int(rng.integers(1, 4)) if rng.random() < curved else 0
    swing = size * rng.uniform(-1.5, 1.5, order)
    return [0.0] + [float(x) * math.factorial(k) / duration**k for k, x in enumerate(swing, start=1)]


def draw_moves(rng: Rng, scene: Drawn) -> list[Move]:
    moves: list[Move] = []
    for interval in scene.intervals:
        inputs = {name: interval.at(name, 0.0) for name in ("tau", "F_ext")}
        moves += cut(interval.duration, inputs, draw_cuts(rng, interval.duration))
    return moves[:MOST_MOVES]


def tuned(rng: Rng, p: Mapping[str, Scalar], moves: Sequence[Move]) -> list[Move]:
    """The same moves, with tunable parameters changed on the way, and states kept, restored and copied."""
    tunes, goes_back = rng.random() < 0.25, rng.random() < 0.25
    tunable = ["cam1.friction", "cam2.friction"]
    tunable += [n for n in p if n.startswith(("spring.", "damper.")) and p[n]]
    found, kept = [], False
    for move in moves:
        values, state = dict(move.values), ""
        if tunes and rng.random() < 0.15:
            name = str(rng.choice(tunable))
            values[name] = float(p[name]) * rng.uniform(0.6, 1.2)
        if goes_back and rng.random() < 0.2:
            state = str(rng.choice(["restore", "copy"])) if kept and rng.random() < 0.6 else "keep"
            kept = True
        found.append(Move(move.length, values, move.derivatives, state))
    return found


def random_scene(helical: bool, number: int, folder: Path) -> Scene:
    kind = "helical" if helical else "general"
    rng = np.random.default_rng([1 if helical else 2, number])
    scene = drawn(rng, helical, folder)
    moves = tuned(rng, scene.parameters, draw_moves(rng, scene))
    tolerance = None if rng.random() < 0.3 else float(rng.choice(TOLERANCES))
    every, resets = int(rng.choice([1, 1, 3, 1000])), bool(rng.random() < 0.1)
    title = f"{kind} {number}"
    return Scene(title, FORWARD, scene.parameters, moves, tolerance, resets=resets, read_every=every)


# ---- inverse ----


def inverse_scene(number: int, folder: Path) -> Scene:
    """An imposed swing with reversals and rests; the shaft rigid or elastic."""
    rng = np.random.default_rng([3, number])
    scene = drawn(rng, rng.random() < 0.4, folder)
    p = {name: value for name, value in scene.parameters.items() if not name.startswith(FORWARD_ONLY)}
    (lower, upper), period = scene.range_of(), scene.time()
    stiffness = 0.0
    if rng.random() < 0.5:
        stiffness = scene.largest("tau") / (upper - lower) * log_uniform(rng, 1.0, 300.0)
    p["shaft.stiffness"] = stiffness
    middle, swing = 0.5 * (lower + upper), 0.5 * (upper - lower) * rng.uniform(0.1, 1.02)
    w, phase = 2.0 * math.pi / period, rng.uniform(0.0, 6.0)
    smooth, h = rng.random() < 0.6, period * log_uniform(rng, 2e-3, 0.5)
    rest = int(rng.integers(0, 30))
    pull = draw_polynomial(rng, 0.3 * scene.largest("F_ext"), 40.0 * h, 0.5)
    moves, t = [], 0.0
    for k in range(40):
        values = [
            swing * w**order * math.sin(w * t + phase + order * math.pi / 2) for order in range(6)
        ]  # fmt: skip
        if k == rest:
            values[1:] = [0.0] * 5
        values[0] += middle
        force = polynomial(pull, t)
        inputs: dict[str, Scalar] = dict(zip(("theta", "omega", "alpha"), values[:3], strict=True))
        derivatives = {"theta": values[1:4], "omega": values[2:5], "alpha": values[3:6], "F_ext": force[1:]}
        moves.append(Move(h, inputs | {"F_ext": force[0]}, derivatives if smooth else {}))
        t += h * (0.0 if k == rest else 1.0)
    tolerance = None if rng.random() < 0.3 else float(rng.choice(TOLERANCES))
    version = 3 if not smooth and rng.random() < 0.3 else 2
    title = f"inverse {number}, {'elastic' if stiffness else 'rigid'}"
    return Scene(title, INVERSE, p, tuned(rng, p, moves), tolerance, version)


# ---- model exchange, and FMI 3.0 ----


def exchange_scene(number: int, folder: Path) -> Scene:
    """Random states, or explicit Euler steps with their events; one in six of the inverse FMU."""
    if number % 6 == 5:
        return replace(inverse_scene(number, folder), version=2 + number // 6 % 2, use="exchange")
    rng = np.random.default_rng([4, number])
    scene = drawn(rng, rng.random() < 0.5, folder)
    (lower, upper), period = scene.range_of(), scene.time()
    jumps = rng.random() < 0.5
    moves = []
    for move in draw_moves(rng, scene):
        speed = float(rng.choice([0.0, (upper - lower) / period])) * rng.uniform(-1.0, 1.0)
        states = (float(rng.uniform(lower, upper)), speed) if jumps else ()
        moves.append(Move(min(move.length, 0.01 * period), move.values, states=states))
    version = 2 + number % 2
    return Scene(f"exchange {number}", FORWARD, scene.parameters, moves, None, version, "exchange")


def early_return_scene(number: int, folder: Path) -> Scene:
    """FMI 3.0: steps with early return at mode changes, event mode, inputs asked for within the step."""
    rng = np.random.default_rng([5, number])
    scene = drawn(rng, rng.random() < 0.7, folder)
    moves = draw_moves(rng, scene)[:20]
    title = f"early return {number}"
    return Scene(title, FORWARD, scene.parameters, moves, None, 3, "early return", read_most_every=1)


def curved_scene(number: int, folder: Path) -> Scene:
    """A cubic torque on the default mechanism: FMI 3.0 with early return, or FMI 2.0 in few steps."""
    rng = np.random.default_rng([8, number])
    duration = float(rng.uniform(0.02, 0.3))
    scale = [2.0, 5.0 / duration, 10.0 / duration**2, 30.0 / duration**3]
    tau = [float(size * x) for size, x in zip(scale, rng.uniform(-1.0, 1.0, 4), strict=True)]
    title = f"curved torque {number}"
    if number % 2 == 0:
        moves = list(cut(duration, {"tau": tau}, [0.0, duration]))
        return Scene(title, FORWARD, {}, moves, None, 3, "early return")
    moves = list(cut(duration, {"tau": tau}, draw_cuts(rng, duration)))
    if number == 1:  # ends 1e-12 s behind a breakaway
        derivatives = [5.204793012928848, 2.410753348015536, -3.5484609676281345]
        moves = [Move(0.08870064548360176, {"tau": 0.1920512627236736}, {"tau": derivatives})]
    return Scene(title, FORWARD, {}, moves)


def probing_scene(number: int, folder: Path) -> Scene:
    """Which derivatives are allowed, and all their values."""
    if number % 4 == 2:
        return replace(exchange_scene(number // 4, folder), probes=True)
    scene = (
        inverse_scene(number, folder) if number % 4 == 3 else random_scene(number % 8 == 0, number, folder)
    )
    moves = [replace(move, derivatives={}) for move in scene.moves]  # FMI 3.0 cannot set them
    return replace(scene, moves=moves, version=2 + number // 4 % 2, probes=True)


def plain_3_scene(number: int, folder: Path) -> Scene:
    """FMI 3.0, plain co-simulation with constant inputs."""
    scene = random_scene(number % 2 == 0, 10_000_000 + number, folder)
    moves = [Move(m.length, m.values, {}, m.state) for m in scene.moves]
    return Scene(f"FMI 3.0 {scene.title}", FORWARD, scene.parameters, moves, scene.tolerance, 3)


# ---- mechanisms of the tests, and of the file of general scenes ----

ELLIPSES = {"cam1.profile": 2, "cam2.profile": 2, "cam2.radius": 0.025, "cam2.lead_angle": 0.7}
GROOVES: tuple[dict[str, Scalar], ...] = (
    {},
    {"cam1.lead_angle": 0.6, "cam2.lead_angle": 0.9},
    {**ELLIPSES},
    {**ELLIPSES, "cam1.profile": 1, "cam1.ellipse_curvature": 1},
)
FORCES: dict[str, Scalar] = {
    "spring.stiffness2": 1e5, "spring.stiffness3": 1e6, "damper.c_load": 20.0, "damper.q_load": 50.0,
    "damper.c_release": 30.0, "damper.q_release": 40.0,
}  # fmt: skip
FOLLOWER: dict[str, Scalar] = {
    "inertia.follower_mass": 0.3, "inertia.follower": 3e-5, "shaft.damping": 0.01, "stop.restitution": 0.5
}  # fmt: skip
VARIANTS: tuple[dict[str, Scalar], ...] = ({}, FORCES, FOLLOWER, FORCES | FOLLOWER, {"inertia.shaft": 0.0})
PARAMETERS = [grooves | variant for grooves in GROOVES for variant in VARIANTS]


def known_scene(number: int, folder: Path) -> Scene:
    """The mechanisms of the tests at each tolerance, in coarse and in 1 ms steps."""
    number, which = divmod(number, len(PARAMETERS))
    fine, tolerance = divmod(number, len(TOLERANCES))
    rng = np.random.default_rng([6, which])
    moves: list[Move] = []
    for _ in range(12):
        duration = float(rng.uniform(0.02, 0.1))
        tau = draw_polynomial(rng, 5.0, duration, 0.5)
        tau[0] = float(rng.uniform(-5.0, 15.0))
        count = round(duration / SHORT_STEP) if fine else 1
        inputs = {"tau": tau, "F_ext": [float(rng.uniform(-50.0, 50.0))]}
        moves += cut(duration, inputs, np.linspace(0.0, duration, count + 1).tolist())
    title = f"mechanism {which}, tolerance {TOLERANCES[tolerance]:g}, {'1 ms' if fine else 'coarse'}"
    every = 50 if fine else 1
    return Scene(title, FORWARD, PARAMETERS[which], moves, TOLERANCES[tolerance], read_most_every=every)


KNOWN_SCENES = len(PARAMETERS) * len(TOLERANCES) * 2


@cache
def _general_entries() -> list[dict[str, Any]]:
    return json.loads(gzip.decompress(GENERAL_SCENES.read_bytes()))


def kept_scene(number: int, folder: Path, tolerance: float, fine: bool) -> Scene:
    """A scene of tests/data; its tables are written into `folder`."""
    entry = _general_entries()[number]
    p = dict(entry["params"])
    for name, (psi, z) in entry["tables"].items():
        path = folder / f"kept-{number}-{name[:4]}.csv"
        rows = [f"{float(a)!r},{float(b)!r}" for a, b in zip(psi, z, strict=True)]
        path.write_text("\n".join(["psi_rad,z_m", *rows]) + "\n")
        p[name] = str(path)
    moves: list[Move] = []
    for duration, tau, tau1, pull, pull1, tau2, tau3, pull2, pull3 in entry["intervals"]:
        inputs = {"tau": [tau, tau1, tau2, tau3], "F_ext": [pull, pull1, pull2, pull3]}
        count = max(1, round(duration / SHORT_STEP)) if fine else 1
        moves += cut(duration, inputs, np.linspace(0.0, duration, count + 1).tolist())
    title = f"tests/data {entry['number']}, tolerance {tolerance:g}, {'1 ms' if fine else 'coarse'}"
    every = 50 if fine else 1
    return Scene(title, FORWARD, p, moves, tolerance, read_most_every=every)


KEPT_SCENES = 220


def refused_scene(number: int, folder: Path) -> Scene:
    """One value that is not allowed, before or during the run."""
    rng = np.random.default_rng([7, number])
    scene = random_scene(number % 2 == 0, 20_000_000 + number, folder)
    bad = [math.nan, math.inf, -1.0, 1e300, 100.0][int(rng.integers(5))]
    parameters, moves = dict(scene.parameters), list(scene.moves[:12])
    names = ["tau", "F_ext", "cam1.friction", "spring.preload", "length", "derivative", *parameters]
    name = str(rng.choice(names))
    if name == "length":
        moves[2:2] = [Move(float(rng.choice([0.0, -1e-3, math.nan, math.inf, 1e9])), {})]
    elif name == "derivative":
        moves[2:2] = [Move(1e-3, {}, {"tau": [bad, 1.0, 1.0, 1.0]})]
    elif name in parameters and not isinstance(parameters[name], float):
        parameters[name] = "missing.csv" if isinstance(parameters[name], str) else 7
    elif name in parameters and rng.random() < 0.5:
        parameters[name] = bad
    else:
        moves[2:2] = [Move(1e-3, {name: bad})]
    return Scene(f"refusal {number}, {name}", FORWARD, parameters, moves, scene.tolerance)
