"""Which unknowns the data do not determine, alone or together, and what would help."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dualcam.common.arrays import Array
from dualcam.errors import FmuError
from dualcam.identification.least_squares import Solution
from dualcam.identification.motion import DYNAMIC, MeasuredMotion
from dualcam.identification.torque_model import TorqueModel
from dualcam.identification.unknowns import CAMS, Unknown

OPEN = 1.0  # half of the 95 % interval along a direction, in sizes, from which the direction counts as open
TAKES_PART = 0.1  # of the largest component of a direction
INVISIBLE = 1e-3  # of the standard deviation of a residual
CHANGE = 0.1  # of a size, for the sentence
SAME = 1e-9  # of the largest torque: a difference that is rounding
NARROW = 0.3  # of the range of theta between the stops
SPEED_TERMS = ("friction_peak", "stribeck_velocity", "friction_viscous")
LOSSES = ("friction", *SPEED_TERMS)


@dataclass(frozen=True)
class Ambiguity:
    """Unknowns that can change together while the torque stays the same within its noise.

    `names`: the unknowns; one name: the recording says nothing about this unknown. `text`: a sentence with an
    example in numbers. `advice`: what would tell the unknowns apart.
    """

    names: tuple[str, ...]
    text: str
    advice: str

    def __str__(self) -> str:
        return f"{self.text} {self.advice}".rstrip()


def ambiguities_of(
    solution: Solution, unknowns: Sequence[Unknown], motion: MeasuredMotion, span: float, speeds: Array
) -> list[Ambiguity]:
    """Directions in the space of the unknowns that the data leave open."""
    names = [unknown.name for unknown in unknowns]
    solution = _in_present_sizes(solution)
    _, _, directions = np.linalg.svd(solution.jacobian, full_matrices=False)
    found: list[Ambiguity] = []
    for direction in directions:
        if solution.half_width(direction) < OPEN:
            continue
        lead = int(np.argmax(np.abs(direction)))
        part = [k for k in range(len(names)) if abs(direction[k]) > TAKES_PART * abs(direction[lead])]
        part.sort(key=lambda k: -abs(direction[k]))
        members = tuple(names[k] for k in part)
        if any(set(members) <= set(other.names) for other in found):
            continue
        text = _sentence(solution, unknowns, direction, part)
        found.append(Ambiguity(members, text, _advice(members, motion, span, speeds)))
    return found


def exchangeable_cams(model: TorqueModel, solution: Solution, unknowns: Sequence[Unknown]) -> list[Ambiguity]:
    """Pairs of values, one of each cam, that can be swapped without a change of the torque. Derivatives do
    not show such a pair: the error has two equal minima, and each is narrow."""
    names = [unknown.name for unknown in unknowns]
    pairs = [name.partition(".")[2] for name in names if name.startswith(f"{CAMS[0]}.")]
    pairs = [last for last in pairs if f"{CAMS[1]}.{last}" in names]
    places = [[names.index(f"{cam}.{last}") for cam in CAMS] for last in pairs]
    if not places:
        return []
    moved, swapped = solution.values.copy(), solution.values.copy()
    for first, second in places:
        value = 0.5 * (solution.values[first] + solution.values[second])
        moved[[first, second]] = value * (1.0 - CHANGE), value
        swapped[[first, second]] = value, value * (1.0 - CHANGE)
    try:
        before, after = (model.limits(values)[0] for values in (moved, swapped))
    except FmuError:
        return []
    slips = model.motion.direction != 0
    if np.abs(after - before)[slips].max() > SAME * np.abs(before)[slips].max():
        return []
    return [
        Ambiguity(
            tuple(f"{cam}.{last}" for cam in CAMS),
            f"{CAMS[0]}.{last} and {CAMS[1]}.{last} are exchangeable: the grooves of both cams are alike, so"
            " the torque is the same with the values swapped.",
            f"Fit {last}, one value for both cams.",
        )
        for last in pairs
    ]


def _in_present_sizes(solution: Solution) -> Solution:
    """The solution in units of the fitted values, where these are larger than the start values."""
    growth = np.maximum(1.0, np.abs(solution.values) / solution.sizes)
    return replace(
        solution,
        sizes=solution.sizes * growth,
        jacobian=solution.jacobian * growth,
        covariance=solution.covariance / np.outer(growth, growth),
        widths=solution.widths / growth[:, None],
    )


def _error(solution: Solution) -> float:
    """Standard deviation of a residual [N.m]."""
    telling = int(np.count_nonzero(solution.jacobian.any(axis=1)))
    freedom = max(1, telling - len(solution.values))
    rms = math.sqrt(float(solution.residual @ solution.residual) / freedom)
    return max(rms, solution.noise)


def _sentence(solution: Solution, unknowns: Sequence[Unknown], direction: Array, part: list[int]) -> str:
    lead = part[0]
    step = np.zeros(len(direction))
    step[part] = CHANGE * direction[part] / direction[lead]
    change = solution.jacobian @ step
    rms = math.sqrt(float(np.mean(change**2)))
    amounts = step * solution.sizes
    words = [f"{unknowns[k].name} by {_amount(amounts[k], unknowns[k])}" for k in part]
    error = _error(solution)
    effect = (
        "does not change the torque"
        if rms < INVISIBLE * error
        else f"changes the torque by {rms:.2g} N.m RMS"
    )
    if len(part) == 1:
        return (
            f"{unknowns[lead].name} is not determined: a change by {words[0].partition(' by ')[2]} {effect}."
        )
    together = " and ".join([", ".join(words[:-1]), words[-1]])
    names = " and ".join([", ".join(unknowns[k].name for k in part[:-1]), unknowns[part[-1]].name])
    return f"{names} cannot be told apart: a change of {together} together {effect}."


def _amount(value: float, unknown: Unknown) -> str:
    return f"{value:+.3g}{'' if unknown.unit == '1' else ' ' + unknown.unit}"


def _advice(names: tuple[str, ...], motion: MeasuredMotion, span: float, speeds: Array) -> str:
    """What to record, or to leave out."""
    found: list[str] = []
    lasts = {name.rpartition(".")[2] for name in names}
    groups = {name.partition(".")[0] for name in names}
    pairs = [last for last in lasts if all(f"{cam}.{last}" in names for cam in CAMS)]
    found += [f"Fit {last}, one value for both cams." for last in sorted(pairs)]
    loading, releasing = motion.count(1), motion.count(-1)
    if not (loading and releasing) and len(lasts) > 1 and (lasts & set(LOSSES) or groups & {"damper"}):
        present, absent = ("loading", "releasing") if loading else ("releasing", "loading")
        found.append(
            f"The recording has {present} only: record {absent} too. Half the difference of both torques is"
            " friction, the mean is spring."
        )
    if groups & {"inertia"}:
        if motion.kind != DYNAMIC:
            found.append("The recording is quasi-static: inertia needs a motion with larger acceleration.")
        elif len(groups) > 1 or len(lasts) > 1:
            found.append("Record motions of several frequencies.")
    if lasts & set(SPEED_TERMS) or groups & {"damper"} or "damping" in lasts:
        low, high = 1e3 * np.quantile(speeds, (0.05, 0.95)) if len(speeds) else (0.0, 0.0)
        found.append(
            f"The pins slide at {low:.3g} to {high:.3g} mm/s: record speeds that differ more, from far below"
            " to above the Stribeck velocity."
        )
    if {"preload", "stiffness"} <= lasts or {"torque_offset", "preload"} <= lasts or "angle_offset" in lasts:
        moving = motion.theta[motion.direction != 0]
        if np.ptp(moving) < NARROW * span:
            found.append(
                f"The angle covers {moving.min():.3g} to {moving.max():.3g} rad: record a wider range."
            )
    return " ".join(
        found or ["Leave one of them out of the fit." if len(names) > 1 else "Leave it out of the fit."]
    )
