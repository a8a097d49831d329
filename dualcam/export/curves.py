"""Torque, efficiency and reactions of a design in slow motion over the angle, computed by the inverse FMU."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dualcam.errors import FmuError
from dualcam.fmu import Fmu
from dualcam.library import fmu_path

Array = NDArray[np.float64]
Scalar = float | int | bool | str

POINTS = 101
SLOW = 1e-9  # rad/s: a direction of motion; forces of inertia and damping are below rounding
STATE = ("gamma", "z", "spring.force", "torque_load", "torque_release", "efficiency")
REACTIONS = ("cam1.reaction", "cam2.reaction")
ONLY_FORWARD = ("tau", "initial.theta", "initial.omega")
MOTION = {"theta": 0.0, "omega": 0.0, "alpha": 0.0, "F_ext": 0.0, "shaft.stiffness": 0.0}


@dataclass(frozen=True)
class Curves:
    """Slow motion without external force. NaN: the mechanism jams there, or the value is infinite.

    `theta` [rad] has shape (n,), from the lower to the upper stop. Each entry of `values` has shape (n,), in
    the FMU's units; each entry of `reactions` has shape (2, n), for cam 1 and cam 2 [N, of one contact].
    """

    theta: Array
    values: dict[str, Array]
    reactions: dict[str, Array]  # "loading", "releasing"

    def largest(self, name: str) -> float:
        """The largest magnitude of an entry of `values`; 0 if the entry has no number."""
        magnitudes = np.abs(self.values[name])
        return float(np.max(magnitudes[np.isfinite(magnitudes)], initial=0.0))


def slow_motion_curves(parameters: Mapping[str, Scalar]) -> Curves:
    """Curves of a design.

    Parameters
    ----------
    parameters
        Name -> value, of either FMU; tables as absolute paths.

    Raises
    ------
    FmuError
        The FMU refuses the design.
    """
    given = {name: value for name, value in parameters.items() if name not in ONLY_FORWARD} | MOTION
    with Fmu(fmu_path("inverse")) as fmu:
        lower, upper = (_limit(fmu, given, name) for name in ("stop.lower", "stop.upper"))
        theta = np.linspace(lower, upper, POINTS)
        loading = np.array([_read(fmu, given, angle, SLOW) for angle in theta]).T
        releasing = np.array([_read(fmu, given, angle, -SLOW) for angle in theta]).T
    state = np.where(np.isfinite(loading), loading, releasing)[: len(STATE)]
    values = {name: np.where(np.isfinite(row), row, np.nan) for name, row in zip(STATE, state, strict=True)}
    reactions = {"loading": loading[len(STATE) :], "releasing": releasing[len(STATE) :]}
    return Curves(theta, values, reactions)


def _limit(fmu: Fmu, given: Mapping[str, Scalar], name: str) -> float:
    """An end stop [rad]."""
    return float(given[name]) if name in given else float(fmu.variable(name).start)


def _read(fmu: Fmu, given: Mapping[str, Scalar], theta: float, omega: float) -> list[float]:
    """STATE and REACTIONS at this angle and speed; NaN where the mechanism jams."""
    try:
        fmu.start({**given, "theta": float(theta), "omega": omega})
        return fmu.reals(*STATE, *REACTIONS).read()
    except FmuError:
        return [np.nan] * (len(STATE) + len(REACTIONS))
