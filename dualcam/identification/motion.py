"""The motion behind a recording: angle, speed, acceleration, and which samples slip in which direction."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dualcam.common.arrays import Array
from dualcam.errors import IdentificationError
from dualcam.identification.recording import Recording
from dualcam.identification.smoothing import NARROWEST, half_of, noise_between, smooth, widths_of

AUTO, QUASI_STATIC, DYNAMIC = "auto", "quasi-static", "dynamic"
KINDS = (AUTO, QUASI_STATIC, DYNAMIC)
SURE = 4.0  # standard deviations of its noise from which a speed has a known sign
SLOWEST = 1e-3  # of the usual speed; slower samples count as at rest
SEEN = 3.0  # the acceleration is in the recording where its RMS is this many times its noise
STRANGE = 100.0  # rad/s: a speed that asks for the unit of time
USUAL = 0.95  # quantile of speeds


@dataclass(frozen=True, eq=False)
class MeasuredMotion:
    """The motion of cam 2, each array of shape (n,)."""

    theta: Array  # rad, smoothed where the cam slips and no speed is measured
    omega: Array  # rad/s
    alpha: Array  # rad/s2, 0 in quasi-static motion
    direction: NDArray[np.int_]  # 1 loading, -1 releasing, 0 at rest, or so near that it is not known
    kind: str  # "quasi-static" or "dynamic": whether alpha counts
    slowest: float  # speed below which a sample counts as at rest [rad/s]
    window: float | None  # of the local polynomials [s]; None where the speed was measured
    theta_noise: float  # rad
    alpha_noise: float  # rad/s2
    alpha_rms: float  # rad/s2

    def count(self, direction: int) -> int:
        """Number of samples with that direction."""
        return int(np.count_nonzero(self.direction == direction))

    def time_question(self, duration: float) -> str:
        """A question after the unit of time, where the speeds are strange, else nothing."""
        fastest = float(np.abs(self.omega).max())
        if fastest < STRANGE:
            return ""
        return (
            f"The recording has a duration of {duration:.4g} s and speeds up to {fastest:.4g} rad/s: is the"
            " time in s? Then name the column time_s"
        )


def motion_of(recording: Recording, kind: str = AUTO, window: float | None = None) -> MeasuredMotion:
    """The motion behind a recording. `kind` is one of KINDS: "auto" is dynamic where the acceleration stands
    out of its noise. `window` of the local polynomials [s]; None: that of the least error of prediction."""
    if kind not in KINDS:
        raise IdentificationError(f"motion = {kind!r}: allowed are {', '.join(KINDS)}")
    time = recording.time
    duration = float(time[-1] - time[0])
    if window is not None and not 0.0 < window <= duration:
        raise IdentificationError(
            f"window = {window!r} s: allowed is a time > 0, at most the {duration:.4g} s of the recording"
        )
    half = None if window is None else half_of(time, window)
    angle = smooth(time, recording.theta, half)
    if recording.omega is None:
        theta, omega, alpha = angle.value, angle.slope, angle.curvature
        alpha_noise = angle.curvature_noise
        direction, slowest, clear = _directions(recording, angle.half)
    else:
        speed = smooth(time, recording.omega, half)
        theta, omega, alpha = recording.theta, recording.omega, speed.slope
        alpha_noise = speed.slope_noise
        noise = np.full(len(time), noise_between(omega))
        sign, limit = _signs(omega, noise)
        direction, slowest = np.where(_unsure(sign), 0, sign), float(np.median(limit))
    moving = direction != 0
    alpha_rms, noise_rms = (rms_of(values[moving]) for values in (alpha, alpha_noise))
    if kind == AUTO:
        kind = DYNAMIC if alpha_rms > SEEN * noise_rms else QUASI_STATIC
    if recording.omega is None:
        theta = np.where(moving, theta, clear[0])
        if kind == QUASI_STATIC:
            theta, omega = clear
    return MeasuredMotion(
        theta,
        omega,
        alpha if kind == DYNAMIC else np.zeros_like(alpha),
        direction,
        kind,
        slowest,
        None if recording.omega is not None else (2 * angle.half + 1) * float(np.median(np.diff(time))),
        angle.noise,
        noise_rms,
        alpha_rms,
    )


def _directions(recording: Recording, half: int) -> tuple[NDArray[np.int_], float, tuple[Array, Array]]:
    """Directions, the speed below which no direction is known, and angle and speed clear of reversals.

    A window that holds a reversal mixes both directions. So a direction is sure where, for some window up to
    the chosen one, the speed has a sure sign in the whole window. Narrow windows come close to a reversal,
    wide ones know slow directions. Angle and speed are those of the widest such window. Where there is none,
    the angle is the measured one: a window would round off the corner of a reversal."""
    time, theta = recording.time, recording.theta
    direction = np.zeros(len(time), dtype=int)
    values, slopes = theta, smooth(time, theta, NARROWEST).slope
    slowest = math.inf
    for width in dict.fromkeys([*(width for width in widths_of(len(time)) if width < half), half]):
        found = smooth(time, theta, width)
        sign, limit = _signs(found.slope, found.slope_noise)
        unsure = _unsure(sign)
        unsure[[0, -1]] = True  # a reversal of which the recording has one side only
        clear = np.convolve(unsure, np.ones(2 * width + 1), "same") < 0.5
        direction = np.where(clear & (direction == 0), sign, direction)
        values, slopes = np.where(clear, found.value, values), np.where(clear, found.slope, slopes)
        slowest = min(slowest, float(np.median(limit)))
    return direction, slowest, (values, slopes)


def _signs(omega: Array, noise: Array) -> tuple[NDArray[np.int_], Array]:
    """The sure signs of speeds, 0 for the others, and the speeds from which a sign is sure."""
    limit = np.maximum(SURE * noise, SLOWEST * float(np.quantile(np.abs(omega), USUAL)))
    return np.where(np.abs(omega) > limit, np.sign(omega), 0.0).astype(int), limit


def _unsure(sign: NDArray[np.int_]) -> NDArray[np.bool_]:
    """Samples without a sure sign, and both samples beside a change of the sign."""
    unsure = sign == 0
    changes = sign[1:] != sign[:-1]
    unsure[1:] |= changes
    unsure[:-1] |= changes
    return unsure


def rms_of(values: Array) -> float:
    """Root mean square; 0 of no values."""
    return math.sqrt(float(np.mean(values**2))) if len(values) else 0.0
