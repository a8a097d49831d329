"""Places along a groove that are close enough for straight lines between them."""

from collections.abc import Callable

import numpy as np

from dualcam.design.cut.groove_cut import Curve, GrooveCut
from dualcam.design.statics import Array
from dualcam.errors import DesignError

CHORD_ERROR = 0.5e-6  # m between a curve and the straight line between two of its points
SHARES = np.array([0.12, 0.31, 0.5, 0.69, 0.88])  # of an interval, where the error is measured
MOST_POINTS = 50_000

# psi of shape (n,) -> points of several curves [m], shape (curves, n, 2 or 3)
Curves = Callable[[Array], Array]


def places(cut: GrooveCut, curves: Curves, most: float = CHORD_ERROR, intervals: int = 1) -> Array:
    """Increasing angles psi [rad] with the stops, so close that straight lines are at most `most` [m] off.
    `intervals`: at least so many between the stops."""
    psi = np.unique([cut.begin, *np.linspace(*cut.travel, intervals + 1), cut.end])
    while True:
        coarse = chord_errors(psi, curves) > most
        if not coarse.any():
            return psi
        if len(psi) > MOST_POINTS:
            raise DesignError(
                f"cam {cut.cam}: more than {MOST_POINTS:,} points are needed for lines within"
                f" {1e6 * most:g} um of the groove: the groove bends too sharply"
            )
        psi = np.sort(np.append(psi, 0.5 * (psi[:-1] + psi[1:])[coarse]))


def chord_errors(psi: Array, curves: Curves) -> Array:
    """Distance of the curves from the straight line, in each interval [m]; shape (n - 1,)."""
    ends = curves(psi)
    first, chord = ends[:, :-1], np.diff(ends, axis=1)
    length2 = np.maximum((chord**2).sum(axis=-1), np.finfo(float).tiny)
    largest = np.zeros(len(psi) - 1)
    for share in SHARES:
        away = curves(psi[:-1] + share * np.diff(psi)) - first
        along = ((away * chord).sum(axis=-1) / length2)[..., None] * chord
        largest = np.maximum(largest, np.linalg.norm(away - along, axis=-1).max(axis=0))
    return largest


def unwrapped(cut: GrooveCut) -> Curves:
    """Centre line, upper and lower flank on the unwrapped cylinder of the cam's radius."""
    return lambda psi: np.array([np.stack([cut.radius * u, z], axis=-1) for u, z in _lines(cut, psi)])


def wrapped(cut: GrooveCut) -> Curves:
    """Centre line, upper and lower flank of the pin's first end in space, at the cam's radius."""
    return lambda psi: np.array([in_space(cut.angle(u), z, cut.radius) for u, z in _lines(cut, psi)])


def _lines(cut: GrooveCut, psi: Array) -> tuple[Curve, Curve, Curve]:
    """Centre line, upper and lower flank."""
    return (Curve(psi, cut.centre(psi).z), *cut.flanks(psi))


def in_space(angle: Array, z: Array, radius: float) -> Array:
    """Points (x, y, z) [m], shape (n, 3)."""
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=-1)
