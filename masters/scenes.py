"""What every master plays, and what FMPy makes of it."""

from __future__ import annotations

import csv
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from pathlib import Path

import fmpy
import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "fmu_src"))
import build_fmu  # noqa: E402

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
    start: Mapping[str, float] = field(default_factory=dict)
    inputs: Mapping[str, Array] = field(default_factory=dict)  # a value for each communication point
    step: float = H

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
TORQUES = [0.0, 0.5, 4.0, 14.0, 14.0, 6.0, 3.0, 3.0]
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
RELEASED = Scene(
    "start values",
    "flung at the upper stop under a constant torque: loading, stop, releasing, stop, loading, stick",
    FORWARD,
    0.3,
    MOTION,
    frozenset({STICK, LOADING, RELEASING}),
    start={"initial.theta": 1.35, "initial.omega": 20.0, "stop.restitution": 0.3, "tau": 2.0},
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

SCENES = (PROFILE, RELEASED, IMPOSED)


def fmu(model: str, version: str = "2.0") -> Path:
    folder = {"2.0": ".", "3.0": "fmi3"}.get(version, version)
    return build_fmu.BUILD / folder / f"{model}.fmu"


def play(scene: Scene, path: Path, kind: str = "CoSimulation", tolerance: float | None = None) -> Result:
    """The scene in FMPy. Model exchange: its forward Euler method, a step per communication point."""
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
