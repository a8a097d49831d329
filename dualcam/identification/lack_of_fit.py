"""Lack of fit: held values and zero errors of sensors that would explain a part of the residual."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dualcam.common.arrays import Array
from dualcam.design_file import DesignFile
from dualcam.errors import FmuError
from dualcam.identification.least_squares import Solution, spread
from dualcam.identification.motion import DYNAMIC, MeasuredMotion
from dualcam.identification.torque_model import TorqueModel
from dualcam.identification.unknowns import (
    ANGLE_OFFSET,
    TORQUE_OFFSET,
    Unknown,
    names_without_effect,
    unknowns_of,
)

PEAK = "friction_peak"
# Values that may be missing in a fit, each with the step of a difference where the value is 0.
STEPS = {
    TORQUE_OFFSET: 1e-3,  # N.m
    ANGLE_OFFSET: 1e-4,  # rad
    "friction": 1e-4,
    PEAK: 1e-3,
    "friction_viscous": 1e-3,  # s/m
    "spring.preload": 1e-2,  # N
    "spring.stiffness": 1.0,  # N/m
    "shaft.damping": 1e-4,  # N.m.s/rad
    "inertia.shaft": 1e-5,  # kg.m2
}
RELATIVE = 1e-3  # step over the value
FAR = 2.5  # half widths of the 95 % interval, 5 standard deviations: zero is excluded by far
LIKELY = 1.5  # the same for the zero error of the torque, which most sensors have: 3 standard deviations
AS_GOOD = 0.8  # of the best drop of the sum of squares: the residuals do not tell these values apart
ERROR = 0.1  # relative error of a held value, for the doubt
STRONG = 0.5  # relative change of a fitted value by such an error, from which the doubt is told
LEAST_SHARE = 1e-6  # part of a column that the fitted values do not explain; less is rounding


@dataclass(frozen=True)
class Missing:
    """A value outside of the fit that the residuals ask for."""

    name: str  # as in `fit`
    unit: str  # unit, "1" for a plain number
    held: float  # value in the fit
    change: float  # change that the residuals ask for, by one linear step
    half_width: float  # half of the 95 % interval of `change`
    drop: float  # part of the sum of squares that the change explains, 0 to 1


@dataclass(frozen=True)
class Lever:
    """A fitted value that a small error of a held value changes strongly."""

    name: str  # the fitted value
    unit: str  # of the fitted value, "1" for a plain number
    change: float  # change of the fitted value by 10 % of the held value
    held_name: str  # the held value
    held: float
    held_unit: str  # of the held value, "1" for a plain number

    @property
    def held_text(self) -> str:
        """The held value with name and unit."""
        return f"{self.held_name} = {self.held:.4g}{'' if self.held_unit == '1' else ' ' + self.held_unit}"


def lack_of_fit(
    design: DesignFile,
    motion: MeasuredMotion,
    force: Array,
    unknowns: Sequence[Unknown],
    solution: Solution,
) -> tuple[list[Missing], list[Lever]]:
    """Score test of one further value at a time, and what errors of the held values do.

    The derivatives of the torque by the fitted values are extended by those of one further value. One step
    of Gauss and Newton gives the change that the residuals ask for, with its 95 % interval. The interval is
    that of the fit: the blocks in time take into account that neighbouring residuals are alike. The missing
    values are the one that explains most of the residual, if its change is beyond doubt, and those that
    explain nearly as much. `force`: axial force on the follower [N], shape (n,).
    """
    others = _others(design, motion, unknowns)
    slips = np.flatnonzero(motion.direction)
    if not others or len(slips) <= len(unknowns) + 1:
        return [], []
    columns = _columns(design, motion, force, [*unknowns, *others], solution.values, len(unknowns))
    residual, jacobian = solution.residual[slips], solution.jacobian[slips]
    found, levers = [], []
    for other, column in zip(others, columns, strict=True):
        if column is None:
            continue
        one, shift = _one(other, column, residual, jacobian, solution.noise)
        if one is None:
            continue
        found.append((one, other))
        levers += _levers(unknowns, solution, other, shift)
    allowed = [
        one
        for one, other in found
        if abs(one.change) > (LIKELY if one.name == TORQUE_OFFSET else FAR) * one.half_width
        and other.least <= one.held + one.change <= other.greatest
    ]
    best = max((one.drop for one in allowed), default=0.0)
    near = [one for one in allowed if one.drop > AS_GOOD * best]
    return sorted(near, key=lambda one: (one.name == ANGLE_OFFSET, -one.drop)), levers


def _others(design: DesignFile, motion: MeasuredMotion, unknowns: Sequence[Unknown]) -> list[Unknown]:
    """Values that are not in the fit and can act."""
    owned = {key for one in unknowns for key in one.keys or (one.name,)}
    refused = names_without_effect(design)
    found = []
    for name in STEPS:
        (one,) = unknowns_of(design, [name])
        acts = name not in refused and (name != "inertia.shaft" or motion.kind == DYNAMIC)
        if acts and not owned & set(one.keys or (name,)):
            found.append(one)
    return found


def _columns(
    design: DesignFile,
    motion: MeasuredMotion,
    force: Array,
    unknowns: Sequence[Unknown],
    values: Array,
    fitted: int,
) -> list[Array | None]:
    """Derivatives of the torque where the cam slips, by each value that is not fitted.

    None where the FMU refuses the step."""
    start = np.concatenate([values, [one.start for one in unknowns[fitted:]]])
    found: list[Array | None] = []
    with TorqueModel(design, motion, force, unknowns) as model:
        slips = motion.direction != 0
        before = model.limits(start)[0][slips]
        for k in range(fitted, len(unknowns)):
            step = RELATIVE * abs(start[k]) or STEPS[unknowns[k].name]
            moved = start.copy()
            moved[k] += step
            try:
                found.append((model.limits(moved)[0][slips] - before) / step)
            except FmuError:
                found.append(None)
    return found


def _one(
    other: Unknown, column: Array, residual: Array, jacobian: Array, noise: float
) -> tuple[Missing | None, Array]:
    """The change of one further value, and the change of the fitted values per unit of the held one."""
    shift = np.asarray(np.linalg.lstsq(jacobian, column, rcond=None)[0], dtype=np.float64)
    rest = column - jacobian @ shift
    size = float(np.linalg.norm(column))
    if not np.isfinite(size) or float(np.linalg.norm(rest)) <= LEAST_SHARE * size:
        return None, -shift
    # In units in which one changes the torque by 1 N.m RMS.
    unit = math.sqrt(len(column)) / size
    extended = np.column_stack([jacobian, column * unit])
    step, *_ = np.linalg.lstsq(extended, -residual, rcond=None)
    after = residual + extended @ step
    _, widths = spread(after, extended, noise)
    half = float(np.linalg.norm(widths[:, -1], axis=1).max())
    alone = residual - jacobian @ np.linalg.lstsq(jacobian, residual, rcond=None)[0]
    drop = 1.0 - float(after @ after) / max(float(alone @ alone), np.finfo(float).tiny)
    return Missing(other.name, other.unit, other.start, float(step[-1]) * unit, half * unit, drop), -shift


def _levers(unknowns: Sequence[Unknown], solution: Solution, other: Unknown, shift: Array) -> list[Lever]:
    """Fitted values that an error of 10 % of a held value changes by half of themselves or more."""
    found: list[Lever] = []
    if other.name == PEAK:  # 1 is the law of Coulomb, no measured value
        return found
    for k, one in enumerate(unknowns):
        change = float(shift[k] * solution.sizes[k]) * ERROR * other.start
        size = (
            min(abs(value) for value in (one.start, float(solution.values[k])) if value) if one.start else 0.0
        )
        if size and abs(change) > STRONG * size:
            found.append(Lever(one.name, one.unit, change, other.name, other.start, other.unit))
    return found
