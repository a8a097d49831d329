"""Torque, efficiency and reactions of a design in slow motion over the angle, computed by the inverse FMU."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dualcam.errors import FmuError
from dualcam.fmi.fmu import Fmu
from dualcam.fmi.model_description import Scalar
from dualcam.fmi.variables import parameters_of

Array = NDArray[np.float64]

POINTS = 101
SLOW = 1e-9  # rad/s: a direction of motion; forces of inertia and damping are below rounding
STATE = ("gamma", "z", "spring.force", "torque_load", "torque_release", "efficiency")
STOPS = ("stop.lower", "stop.upper")
REACTIONS = ("cam1.reaction", "cam2.reaction")
# Parameters of the forward FMU -> the inputs that take their place in the inverse FMU, which has no state.
START_INPUTS = {"initial.theta": "theta", "initial.omega": "omega"}
MOTION = {"theta": 0.0, "omega": 0.0, "alpha": 0.0, "F_ext": 0.0, "shaft.stiffness": 0.0}


@dataclass(frozen=True)
class SlowMotionCurves:
    """Slow motion without external force, from stop to stop. NaN: a jam, or an infinite value."""

    theta: Array  # shape (n,) [rad]
    values: dict[str, Array]  # shape (n,), in the FMU's units
    reactions: dict[str, Array]  # "loading", "releasing"; shape (2, n) for both cams [N, of one contact]

    def largest(self, name: str) -> float:
        """The largest magnitude of an entry of `values`; 0 if the entry has no number."""
        magnitudes = np.abs(self.values[name])
        return float(np.max(magnitudes[np.isfinite(magnitudes)], initial=0.0))


def slow_motion_curves(parameters: Mapping[str, Scalar]) -> SlowMotionCurves:
    """Curves of a design by its parameters, tables as absolute paths. FmuError if the FMU refuses."""
    omitted = (*START_INPUTS, "tau")  # tau is an input of the forward FMU alone
    given = {name: value for name, value in parameters.items() if name not in omitted} | MOTION
    theta = np.linspace(*_stops(given), POINTS)
    with Fmu("inverse") as fmu:
        loading = np.array([_read(fmu, given, angle, SLOW) for angle in theta]).T
        releasing = np.array([_read(fmu, given, angle, -SLOW) for angle in theta]).T
    state = np.where(np.isfinite(loading), loading, releasing)[: len(STATE)]
    values = {name: np.where(np.isfinite(row), row, np.nan) for name, row in zip(STATE, state, strict=True)}
    reactions = {"loading": loading[len(STATE) :], "releasing": releasing[len(STATE) :]}
    return SlowMotionCurves(theta, values, reactions)


def _stops(given: Mapping[str, Scalar]) -> tuple[float, float]:
    """Both end stops [rad]: those of the design, else the start values of the FMU."""
    known = parameters_of("inverse")
    lower, upper = (float(given.get(name, known[name].start)) for name in STOPS)
    return lower, upper


def _read(fmu: Fmu, given: Mapping[str, Scalar], theta: float, omega: float) -> list[float]:
    """STATE and REACTIONS at this angle and speed; NaN where the mechanism jams."""
    try:
        fmu.start({**given, "theta": float(theta), "omega": omega})
        return fmu.reals(*STATE, *REACTIONS).read()
    except FmuError:
        return [np.nan] * (len(STATE) + len(REACTIONS))
