"""Search of helical springs in standard wire diameters for a wanted preload, stiffness and stroke."""

import math
from collections.abc import Iterator

import numpy as np

from dualcam.design.helical_spring import INDEX, HelicalSpring
from dualcam.design.spring_steel import DIAMETERS, RANGES, SHEAR_MODULUS, STRENGTHS
from dualcam.errors import DesignError

MOST_COILS = 20.0  # active ones, that are tried
COIL_STEP = 0.5  # between two numbers of active coils


def find_springs(
    preload: float,
    stiffness: float,
    stroke: float,
    *,
    grade: str = "DH",
    shot_peened: bool = False,
    safety: float = 1.2,
    outer_diameter: float = math.inf,
    inner_diameter: float = 0.0,
    free_length: float = math.inf,
    guided: bool = False,
    count: int = 5,
) -> tuple[HelicalSpring, ...]:
    """Helical springs in standard wire diameters, the lightest ones first.

    Parameters
    ----------
    preload : Force at the start of the stroke [N], >= 0.
    stiffness : Spring rate [N/m], > 0.
    stroke : Deflection from the preload to the largest force [m], > 0.
    grade : Grade of the wire (EN 10270-1), one of "DH", "SH", "DM", "SM", "SL".
    shot_peened : Whether the springs are shot-peened.
    safety : Least Goodman safety, and least allowed over largest static stress [1], > 0.
    outer_diameter, inner_diameter : Largest outer and least inner diameter of the coil [m].
    free_length : Largest length of the unloaded spring [m].
    guided : Whether a rod or a sleeve guides the spring, so that the spring cannot buckle.
    count : Largest number of springs, one for each wire diameter.

    Returns
    -------
    tuple of HelicalSpring
        Each has the wanted rate exactly: wire diameter of the standard, active coils in steps of a half, mean
        diameter that follows. For each wire diameter the lightest spring.

    Raises
    ------
    DesignError : A value outside its range, or no spring; the message says what the nearest spring lacks.

    Notes
    -----
    Tried are the usual diameters of EN 10270-1 from 0.3 to 20 mm and 2 to 20 active coils. A spring counts if
    its index is 4 to 20, if its length at full stroke is at least `HelicalSpring.least_length`, if the spring
    does not buckle, and if the spring fits the limits of stress and space.

    Examples
    --------
    >>> from dualcam.design import find_springs
    >>> best = find_springs(150.0, 40e3, 0.017, shot_peened=True, outer_diameter=0.045)[0]
    >>> 1e3 * best.wire_diameter, best.active_coils  # mm
    (4.0, 12.0)
    >>> round(best.rate, 6)  # N/m
    40000.0
    >>> best.fatigue(150.0, 150.0 + 40e3 * 0.017).safety >= 1.2
    True
    """
    _check_task(preload, stiffness, stroke, grade, safety)
    largest = preload + stiffness * stroke
    found: dict[float, HelicalSpring] = {}
    reasons: dict[str, int] = {}
    for spring in _candidates(stiffness, grade, shot_peened, guided):
        reason = _lack(spring, preload, largest, safety, outer_diameter, inner_diameter, free_length)
        if reason:
            reasons[reason] = reasons.get(reason, 0) + 1
        elif spring.wire_diameter not in found or spring.mass < found[spring.wire_diameter].mass:
            found[spring.wire_diameter] = spring
    if not found:
        common = sorted(reasons, key=lambda reason: -reasons[reason])
        raise DesignError(
            f"no spring of grade {grade} in standard wire diameters carries {preload:.4g} to {largest:.4g} N"
            f" with {stiffness / 1e3:.4g} N/mm: most fail by {' and '.join(common[:2])}"
        )
    return tuple(sorted(found.values(), key=lambda spring: spring.mass)[:count])


def _check_task(preload: float, stiffness: float, stroke: float, grade: str, safety: float) -> None:
    positive = {"stiffness": stiffness, "stroke": stroke, "safety": safety}
    for name, value in positive.items():
        if not 0.0 < value < math.inf:
            raise DesignError(f"{name} = {value}: allowed is a finite number > 0")
    if not 0.0 <= preload < math.inf:
        raise DesignError(f"preload = {preload}: allowed is a finite force >= 0 in N")
    if grade not in STRENGTHS:
        raise DesignError(f"grade = {grade!r}: allowed are {', '.join(STRENGTHS)} of EN 10270-1")


def _candidates(stiffness: float, grade: str, shot_peened: bool, guided: bool) -> Iterator[HelicalSpring]:
    """Springs of that rate with an allowed index."""
    thinnest, thickest = RANGES[grade]
    for d in (d for d in DIAMETERS if thinnest <= d <= thickest):
        for coils in np.arange(2.0, MOST_COILS + 0.25, COIL_STEP):
            coil = float(SHEAR_MODULUS * d**4 / (8.0 * coils * stiffness)) ** (1.0 / 3.0)
            if INDEX[0] <= coil / d <= INDEX[1]:
                yield HelicalSpring(
                    d, coil, float(coils), grade=grade, shot_peened=shot_peened, guided=guided
                )


def _lack(
    spring: HelicalSpring,
    preload: float,
    largest: float,
    safety: float,
    outer_diameter: float,
    inner_diameter: float,
    free_length: float,
) -> str:
    """Why a spring does not count; empty for a spring that does."""
    deflection = largest / spring.rate
    length = spring.least_length + deflection  # unloaded, as short as the gaps allow
    if spring.stress(largest) * safety > spring.allowed_stress:
        return "static stress"
    if spring.fatigue(preload, largest).safety < safety:
        return "fatigue"
    if spring.outer_diameter > outer_diameter:
        return "outer diameter"
    if spring.coil_diameter - spring.wire_diameter < inner_diameter:
        return "inner diameter"
    if length > free_length:
        return "free length"
    if spring.buckling_deflection(length) <= deflection:
        return "buckling"
    return ""
