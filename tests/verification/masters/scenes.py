"""What every master plays, and what FMPy makes of it."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from itertools import pairwise
from pathlib import Path

import build_fmu
import fmpy
import numpy as np
from numpy.typing import NDArray

ROOT = build_fmu.ROOT
Array = NDArray[np.float64]
Result = Mapping[str, Array]  # by the outputs' names, a value for each communication point

STICK, LOADING, RELEASING, LOWER, UPPER = 1, 2, 3, 4, 5
FORWARD, INVERSE = "DualCamForward", "DualCamInverse"
H = 1e-3  # s, the communication step


@dataclass(frozen=True, eq=False)
class Scene:
    name: str
    text: str
    model: str
    duration: float
    outputs: tuple[str, ...]
    modes: frozenset[int]  # those that a reader of `mode` must see
    start: Mapping[str, float | int | str] = field(default_factory=dict)
    inputs: Mapping[str, Array] = field(default_factory=dict)  # a value for each communication point
    step: float = H
    tables: Mapping[Path, str] = field(default_factory=dict)  # of grooves, with their content

    @property
    def times(self) -> Array:
        return self.step * np.arange(round(self.duration / self.step) + 1, dtype=np.float64)

    @property
    def table(self) -> NDArray[np.void]:
        """The inputs as FMPy takes them."""
        columns = {"time": self.times, **self.inputs}
        rows = np.zeros(len(self.times), dtype=[(name, np.float64) for name in columns])
        for name, column in columns.items():
            rows[name] = column
        return rows

    def prepare(self) -> None:
        for path, content in self.tables.items():
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(content)

    def write_inputs(self, path: Path) -> Path:
        with path.open("w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(["time", *self.inputs])
            writer.writerows(
                zip(self.times.tolist(), *(v.tolist() for v in self.inputs.values()), strict=True)
            )
        return path


def grid(duration: float) -> Array:
    return H * np.arange(round(duration / H) + 1, dtype=np.float64)


# Up to the breakaway torque (0.66 N.m), loading, the upper stop, back to within the band there, releasing
# (below 5.6 N.m), and at rest again at the end.
TIMES = [0.0, 0.1, 0.3, 0.45, 0.6, 0.8, 1.3, 1.5]
TORQUES = [0.0, 0.5, 4.0, 14.0, 14.0, 6.0, 2.0, 2.0]
MOTION = ("theta", "omega", "z", "v", "mode", "energy.heat_stop")

PROFILE = Scene(
    "profile",
    "a torque over time: stick, breakaway, loading, upper stop, releasing, stick",
    FORWARD,
    1.5,
    MOTION,
    frozenset({STICK, LOADING, RELEASING, LOWER, UPPER}),
    inputs={
        "tau": np.interp(grid(1.5), TIMES, TORQUES),
        "F_ext": 10.0 * np.sin(9.0 * grid(1.5)),
    },
)

# For masters that have no input: through parameters, and a torque that stays as it is.
FLUNG = Scene(
    "flung",
    "through start values alone at the upper stop: loading, stop, releasing, lower stop, loading, stick",
    FORWARD,
    0.3,
    MOTION,
    frozenset({STICK, LOADING, RELEASING}),
    start={"initial.theta": 1.35, "initial.omega": 20.0, "stop.restitution": 0.3, "tau": 2.0},
)


# Start values of every type, and a file.
GROOVE = build_fmu.BUILD / "masters/groove 2.csv"
ANGLES = [k / 10 for k in range(-20, 21)]
GENERAL = Scene(
    "any groove",
    "torque of *profile*; elliptical and tabulated groove, cubic spring, damper, mass: integrated to 1e-9",
    FORWARD,
    1.5,
    MOTION,
    frozenset({STICK, LOADING, RELEASING, LOWER, UPPER}),
    start={
        "cam1.profile": 2,
        "cam2.profile": 3,
        "cam2.table": str(GROOVE),
        "spring.stiffness3": 1e8,
        "damper.c_load": 20.0,
        "damper.c_release": 40.0,
        "inertia.follower_mass": 0.5,
        "stop.upper": 0.9,
        "contacts": 1,
    },
    inputs=PROFILE.inputs,
    tables={GROOVE: "psi_rad,z_m\n" + "".join(f"{a!r},{0.02 * a + 0.0011 * a * a!r}\n" for a in ANGLES)},
)


FLUNG_GENERAL = replace(
    GENERAL,
    name="flung in any groove",
    text="the start values of *flung* in the grooves of *any groove*",
    duration=0.3,
    modes=FLUNG.modes,
    start={**GENERAL.start, **FLUNG.start, "initial.theta": 0.85},
    inputs={},
)


def swing(duration: float) -> dict[str, Array]:
    """Up, down a part of the way, up, and down again: cubic in between, at rest where it turns."""
    turns = [(0.0, 0.0), (0.3, 1.2), (0.5, 0.5), (0.8, 1.3), (1.0, 0.1)]
    t = grid(duration)
    theta, omega, alpha = np.zeros((3, len(t)))
    for (t0, a), (t1, b) in pairwise(turns):
        inside = (t >= t0) & (t <= t1)
        s = (t[inside] - t0) / (t1 - t0)
        theta[inside] = a + (b - a) * s * s * (3 - 2 * s)
        omega[inside] = (b - a) * 6 * s * (1 - s) / (t1 - t0)
        alpha[inside] = (b - a) * 6 * (1 - 2 * s) / (t1 - t0) ** 2
    return {"theta": theta, "omega": omega, "alpha": alpha, "F_ext": 10.0 * np.sin(9.0 * t)}


IMPOSED = Scene(
    "imposed motion",
    "an elastic shaft turned up, back and up again: stick at each reversal",
    INVERSE,
    1.0,
    ("tau", "z", "v", "theta_cam", "mode"),
    frozenset({STICK, LOADING, RELEASING}),
    start={"shaft.stiffness": 100.0},
    inputs=swing(1.0),
)

SCENES = (PROFILE, FLUNG, GENERAL, FLUNG_GENERAL, IMPOSED)


def fmu(model: str, version: str = "2.0") -> Path:
    folder = {"2.0": ".", "3.0": "fmi3"}.get(version, version)
    return build_fmu.BUILD / folder / f"{model}.fmu"


def play(scene: Scene, path: Path, kind: str = "CoSimulation", tolerance: float | None = None) -> Result:
    """The scene in FMPy. Model exchange: its forward Euler method, a step per communication point."""
    scene.prepare()
    result = fmpy.simulate_fmu(
        str(path),
        stop_time=scene.duration,
        step_size=scene.step,
        output_interval=scene.step,
        relative_tolerance=tolerance,
        solver="Euler",
        record_events=False,
        fmi_type=kind,
        start_values=dict(scene.start),
        input=scene.table if scene.inputs else None,
        output=list(scene.outputs),
    )
    return {name: np.asarray(result[name], dtype=float) for name in scene.outputs}


@cache
def reference(scene: Scene, path: Path, kind: str = "CoSimulation") -> Result:
    """What FMPy gets; it is a fault if the scene does not show what it is there for."""
    result = play(scene, path, kind)
    missing = scene.modes - set(result["mode"])
    if missing and kind == "CoSimulation":
        raise AssertionError(f"scene {scene.name}: modes {sorted(missing)} are not seen")
    return result
