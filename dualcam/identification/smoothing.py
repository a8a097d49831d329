"""Local polynomials: a smooth curve through noisy samples, its derivatives, and their noise.

In a window around each sample a polynomial of degree 4 is fitted by least squares, as by Savitzky and Golay
(Analytical Chemistry 36, 1964), here for uneven steps of time too. The width of the window is that of the
least error of prediction, when each sample in turn is left out (cross-validation; W. Cleveland, C. Loader,
Smoothing by local regression, 1996). A wider window would smooth away motion, a narrower one would keep more
noise.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dualcam.common.arrays import Array

DEGREE = 4  # the curvature of a polynomial of this degree has an error of fourth order in the window
NARROWEST = 4  # samples on each side: 9 samples for 5 coefficients
WIDEST = 200
TRIED = 1000  # samples at which windows are compared
AT_ONCE = 50_000  # samples of all windows in one array
EVEN = 1e-9  # of a window; steps of time that differ less count as equal
NORMAL = 1.4826  # standard deviation over median of the magnitude, for a normal distribution


@dataclass(frozen=True, eq=False)
class Smooth:
    """Values of the local polynomials and their derivatives by time, each of shape (n,).

    `slope_noise` and `curvature_noise` are standard deviations; `noise` is that of one sample."""

    value: Array
    slope: Array
    curvature: Array
    slope_noise: Array
    curvature_noise: Array
    noise: float
    half: int  # samples of a window on each side of its middle


def smooth(time: Array, samples: Array, half: int | None = None) -> Smooth:
    """Local polynomials through samples over time; `half` None: the window of least error of prediction."""
    widths = widths_of(len(time))
    if half is None:
        half, noise = _best(time, samples, widths)
    else:
        half = min(max(half, NARROWEST), (len(time) - 1) // 2)
        noise = _best(time, samples, [width for width in widths if width <= half])[1]
    parts = _parts(time, samples, np.arange(len(time)), half)
    value, slope, curvature, slope_gain, curvature_gain = parts[:5]
    return Smooth(value, slope, curvature, noise * slope_gain, noise * curvature_gain, noise, half)


def noise_of(time: Array, samples: Array, rows: NDArray[np.intp]) -> float:
    """Standard deviation of the noise, from the narrowest windows at `rows`. Some jumps do not count."""
    residual, leverage = _parts(time, samples, rows, NARROWEST)[5:]
    return NORMAL * float(np.median(np.abs(residual) / np.sqrt(1.0 - leverage)))


def noise_between(samples: Array) -> float:
    """Standard deviation of the noise, from each sample and its neighbours: also where signs change often."""
    second = samples[:-2] - 2.0 * samples[1:-1] + samples[2:]
    return NORMAL * float(np.median(np.abs(second))) / math.sqrt(6.0)


def half_of(time: Array, seconds: float) -> int:
    """Samples on each side of a window of that many seconds."""
    return max(NARROWEST, round(0.5 * seconds / float(np.median(np.diff(time)))))


def widths_of(count: int) -> list[int]:
    """Windows to compare: each about a third wider than the one before."""
    found, width = [NARROWEST], float(NARROWEST)
    while (width := 1.3 * width + 0.5) <= min(WIDEST, count // 10):
        found.append(int(width))
    return found


def _best(time: Array, samples: Array, widths: list[int]) -> tuple[int, float]:
    """The window of the least error of prediction, and the noise that its residuals show."""
    errors, variances = [], []
    some = np.unique(np.linspace(0, len(time) - 1, min(len(time), TRIED)).astype(np.intp))
    for half in widths:
        residual, leverage = _parts(time, samples, some, half)[5:]
        errors.append(float(np.mean((residual / (1.0 - leverage)) ** 2)))
        variances.append(float(np.sum(residual**2) / np.sum(1.0 - leverage)))
    best = int(np.argmin(errors))
    return widths[best], math.sqrt(variances[best])


def _parts(time: Array, samples: Array, rows: NDArray[np.intp], half: int) -> list[Array]:
    """What `_local` gives, for many samples."""
    size = max(1, AT_ONCE // (2 * half + 1))
    chunks = [rows[start : start + size] for start in range(0, len(rows), size)]
    found = [_local(time, samples, chunk, half) for chunk in chunks]
    return [np.concatenate(part) for part in zip(*found, strict=True)]


def _local(time: Array, samples: Array, rows: NDArray[np.intp], half: int) -> tuple[Array, ...]:
    """Value, slope, curvature, noise gains of slope and curvature, residual and leverage at some samples."""
    width = 2 * half + 1
    first = np.clip(rows - half, 0, len(time) - width)
    window = first[:, None] + np.arange(width)
    offset = time[window] - time[rows][:, None]
    scale = np.abs(offset).max(axis=1)
    x = offset / scale[:, None]
    if np.abs(x - x[0]).max() < EVEN:
        x = x[:1]  # all windows have the same weights
    coefficients = _solved(x)
    weights = []  # of the samples, for value, slope and half of the curvature
    for column in range(3):
        weight = np.zeros_like(x)
        for power in range(DEGREE, -1, -1):
            weight *= x
            weight += coefficients[:, power, column, None]
        weights.append(weight)
    middle = samples[rows]
    differences = samples[window] - middle[:, None]
    value, slope, curvature = (
        differences @ weight[0] if len(weight) == 1 else np.einsum("nk,nk->n", weight, differences)
        for weight in weights
    )
    gain = [np.broadcast_to(np.sqrt(np.sum(weight**2, axis=1)), len(rows)) for weight in weights]
    leverage = np.broadcast_to(weights[0], x.shape)[np.arange(len(x)), (rows - first)[: len(x)]]
    return (
        middle + value,
        slope / scale,
        2.0 * curvature / scale**2,
        gain[1] / scale,
        2.0 * gain[2] / scale**2,
        -value,
        np.broadcast_to(leverage, len(rows)),
    )


def _solved(x: Array) -> Array:
    """First three columns of the inverse of the normal equations' matrix at each sample, shape (n, 5, 3)."""
    moments = []
    power = np.ones_like(x)
    for _ in range(2 * DEGREE + 1):
        moments.append(power.sum(axis=1))
        power *= x
    order = np.arange(DEGREE + 1)
    gram = np.stack(moments, axis=1)[:, order[:, None] + order]
    wanted = np.broadcast_to(np.eye(DEGREE + 1)[:, :3], (len(x), DEGREE + 1, 3))
    return np.linalg.solve(gram, wanted)
