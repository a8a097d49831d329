"""The wanted torque as a function of arrays, from a number, a function or samples."""

import math
import warnings
from collections.abc import Callable
from numbers import Real

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import real_array
from dualcam.design.statics import Array
from dualcam.errors import DesignError, DualcamWarning

Torque = Callable[[Array], Array]  # N.m, at theta [rad], of the shape of theta
WantedTorque = float | Torque | tuple[ArrayLike, ArrayLike]
ROUNDED = 1e-4  # rad: samples may end this much before the range, as 80 deg and 1.3963 rad differ by 4e-5
ENOUGH = 200  # samples that a long table is thinned to, if these meet all others
SAME = 1e-5  # of the largest torque: by how much a spline through fewer samples may miss the others
PARTS = 20  # of the range, in which noise is looked for
DOUBTFUL, NOISY = 3.0, 10.0  # times as many samples as their noise allows: a warning, an error
MOST_DOUBTFUL = 1000  # samples; more would give no table of a groove


def wanted_torque(torque: WantedTorque, angles: Array) -> Torque:
    """The wanted torque as a function that takes arrays of theta: a number, a function, or the spline through
    samples, which is tried at `angles`. DesignError for what is no torque at each of them."""
    if isinstance(torque, Real) and not isinstance(torque, bool):
        return _constant(float(real_array(torque, "torque", DesignError)))
    if callable(torque):
        return _function(torque, angles)
    return _samples(torque, float(angles[-1]))  # type: ignore[arg-type]


def _constant(value: float) -> Torque:
    if not math.isfinite(value):
        raise DesignError(f"torque {value} N.m: allowed is a finite number")
    return lambda theta: np.full(np.shape(theta), value)


def _function(torque: Torque, angles: Array) -> Torque:
    """`torque` for arrays, also if it takes one angle at a time, or returns one number for an array."""

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
        theta, value = torque
    except (TypeError, ValueError):
        raise DesignError(
            f"torque = {torque!r:.60}: allowed is a number [N.m], a function of theta [rad], or samples"
            " (theta, torque), two arrays of numbers"
        ) from None
    return _spline(
        real_array(theta, "torque: theta", DesignError), real_array(value, "torque", DesignError), upper
    )


def _spline(angle: Array, value: Array, upper: float) -> Torque:
    if angle.ndim != 1 or angle.shape != value.shape or len(angle) < 4:
        raise DesignError(
            f"torque: samples (theta, torque) of shapes {angle.shape} and {value.shape}: allowed are two"
            " arrays of shape (n,), n >= 4"
        )
    if not (np.isfinite(angle).all() and np.isfinite(value).all()):
        raise DesignError("torque: samples must be finite numbers")
    if len(back := np.flatnonzero(np.diff(angle) <= 0.0)):
        k = int(back[0])
        raise DesignError(
            f"torque: theta[{k + 1}] = {angle[k + 1]:.9g} rad is not above theta[{k}] = {angle[k]:.9g} rad:"
            " allowed are increasing angles"
        )
    if angle[0] > ROUNDED or angle[-1] < upper - ROUNDED:
        low, high, end = (f"{math.degrees(rad):.6g}" for rad in (angle[0], angle[-1], upper))
        raise DesignError(
            f"torque: samples from {angle[0]:g} to {angle[-1]:g} rad ({low} to {high} deg): allowed are"
            f" samples that cover 0 to upper = {upper:g} rad ({end} deg)"
        )
    from scipy.interpolate import CubicSpline

    angle, value = _thinned(angle, value)
    _judge_noise(angle, value)
    return CubicSpline(angle, value)


def _thinned(angle: Array, value: Array) -> tuple[Array, Array]:
    """Half as many samples again and again, as long as their spline meets all others."""
    kept = angle, value
    while len(kept[0]) > 2 * ENOUGH:
        fewer = _half(*kept)
        if np.abs(_misses(fewer, angle, value)).max() > SAME * np.abs(value).max():
            break
        kept = fewer
    return kept


def _half(angle: Array, value: Array) -> tuple[Array, Array]:
    """Half of the samples, both ends included."""
    places = np.linspace(0, len(angle) - 1, max(4, len(angle) // 2)).round().astype(int)
    return angle[places], value[places]


def _misses(fewer: tuple[Array, Array], angle: Array, value: Array) -> Array:
    """By how much a spline through fewer samples misses all samples [N.m]."""
    from scipy.interpolate import CubicSpline

    return CubicSpline(*fewer)(angle) - value


def _judge_noise(angle: Array, value: Array) -> None:
    """DesignError, or a warning, for samples whose noise bends the torque more than the torque itself bends.

    Noise e of samples at a distance h has the second derivative e/h^2, a torque T over the range L about
    T/L^2. So the noise allows sqrt(T/e) intervals. Half of the samples miss the others by about e. The
    median over parts of the range leaves out kinks."""
    squares = _misses(_half(angle, value), angle, value) ** 2
    parts = np.array_split(squares, min(PARTS, len(angle) // 4))
    noise = math.sqrt(2.0 * np.median([part.mean() for part in parts]))
    if noise == 0.0:
        return
    points = 1.0 + math.sqrt(np.abs(value).max() / noise)
    if len(angle) <= DOUBTFUL * points:
        return
    text = (
        f"torque: {len(angle):,} samples with a noise of about {noise:.1g} N.m are noisy or too fine, and the"
        f" groove would follow the noise: smooth the samples, or thin them to about {points:,.0f} points"
    )
    if len(angle) > min(NOISY * points, MOST_DOUBTFUL):
        raise DesignError(text)
    warnings.warn(DualcamWarning(text), stacklevel=2)
