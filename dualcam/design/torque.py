"""The wanted torque as a function of arrays, from a function or from samples."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline

from dualcam.design.statics import Array, DesignError

Torque = Callable[[Array], Array]  # N.m, at theta [rad], of the shape of theta


def wanted_torque(torque: Torque | tuple[ArrayLike, ArrayLike], angles: Array) -> Torque:
    """The wanted torque as a function of arrays.

    Parameters
    ----------
    torque : callable or tuple of array_like
        A function of theta [rad] that gives the torque [N.m]; or samples (theta, torque) of shape (n,),
        n >= 4, which a cubic spline joins.
    angles : ndarray
        Angles [rad], from 0 on, at which the torque must be defined.

    Returns
    -------
    callable
        The torque [N.m] at an array of theta [rad], of the shape of theta.

    Raises
    ------
    DesignError
        A function that fails at `angles`; samples that are no numbers, or do not cover the range.

    Examples
    --------
    >>> import math, numpy as np
    >>> from dualcam.design.torque import wanted_torque
    >>> torque = wanted_torque(lambda theta: 3.0 + math.sin(theta), np.linspace(0.0, 1.0, 5))
    >>> torque(np.array([0.0, math.pi / 6])).round(3).tolist()  # N.m
    [3.0, 3.5]
    """
    return _function(torque, angles) if callable(torque) else _samples(torque, float(angles[-1]))


def _function(torque: Torque, angles: Array) -> Torque:
    """`torque` for arrays, also if the function takes one angle at a time, or returns one number for an
    array."""

    def at_once(theta: Array) -> Array:
        found = np.asarray(torque(theta)).astype(float, casting="same_kind")  # no complex numbers
        return np.broadcast_to(found, np.shape(theta))

    def one_by_one(theta: Array) -> Array:
        angles = np.ravel(theta).tolist()
        return np.reshape([float(torque(angle)) for angle in angles], np.shape(theta))  # type: ignore[arg-type]

    try:
        at_once(angles)
    except Exception:  # any error for an array, as math.sin's TypeError
        try:
            one_by_one(angles)
        except Exception as error:
            raise DesignError(
                f"torque: the function fails ({type(error).__name__}: {error}): allowed is one that gives a"
                " torque for an angle, or an array for an array"
            ) from error
        return one_by_one
    return at_once


def _samples(torque: tuple[ArrayLike, ArrayLike], upper: float) -> Torque:
    """A spline through samples (theta, torque)."""
    try:
        theta, value = (np.asarray(each, dtype=float) for each in torque)
    except (TypeError, ValueError):
        raise DesignError(
            "torque: allowed is a function of theta [rad], or samples: (theta, torque), two arrays of numbers"
        ) from None
    return _spline(theta, value, upper)


def _spline(angle: Array, value: Array, upper: float) -> Torque:
    if angle.ndim != 1 or angle.shape != value.shape or len(angle) < 4 or not (np.diff(angle) > 0.0).all():
        raise DesignError("torque: samples must be two arrays of shape (n,), n >= 4, of increasing theta")
    if not (np.isfinite(angle).all() and np.isfinite(value).all()):
        raise DesignError("torque: samples must be finite numbers")
    if angle[0] > 0.0 or angle[-1] < upper:
        raise DesignError(
            f"torque: samples from {angle[0]:g} to {angle[-1]:g} rad: they must cover 0 to upper ="
            f" {upper:g} rad"
        )
    return CubicSpline(angle, value)
