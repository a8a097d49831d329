"""Efficiency over the lead angles, by the formula of dualcam.design alone: also where it has no meaning."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize

from case_studies.paper.published import EQUAL, LOADING, RELEASING
from dualcam.design.statics import Array, transfer


def efficiency(
    lead: tuple[ArrayLike, ArrayLike], friction: tuple[float, float], radii: tuple[float, float]
) -> Array:
    """Torque when releasing over torque when loading, same axial force, at lead angles [rad]."""
    slopes = [radius * np.tan(angle) for radius, angle in zip(radii, lead, strict=True)]
    release, load = (transfer(slopes, friction, radii, sign).rho for sign in (RELEASING, LOADING))
    return np.asarray(release / load)


def searched_optimum(friction: tuple[float, float], radii: tuple[float, float]) -> tuple[float, float, float]:
    """Lead angles [rad] and efficiency of the optimum, by a search that knows the efficiency alone."""
    found = minimize(
        lambda x: -float(efficiency((x[0], x[1]), friction, radii)),
        [0.6, 0.6],
        method="Nelder-Mead",
        options={"xatol": 1e-10, "fatol": 1e-15, "maxiter": 2000},
    )
    return float(found.x[0]), float(found.x[1]), -float(found.fun)


def beyond_one(friction: float) -> tuple[float, float]:
    """Share of the square with |eta| > 1, and the largest of the smaller lead angle there (equal radii)."""
    axis = (np.arange(1800) + 0.5) / 1800 * 0.5 * math.pi
    x, y = np.meshgrid(axis, axis)
    above = np.abs(efficiency((x, y), (friction, friction), EQUAL)) > 1.0
    return float(np.mean(above)), float(np.max(np.minimum(x, y)[above]))
