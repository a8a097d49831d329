"""Nonlinear least squares with limits, in units of each unknown's own size, and the spread of the result."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import t as student

from dualcam.common.arrays import Array
from dualcam.errors import FmuError, IdentificationError
from dualcam.identification.torque_model import ANGLE_MARGIN, TorqueModel
from dualcam.identification.unknowns import Unknown

MARGIN = 2.0  # standard deviations by which a torque at rest may leave the band
STEP = 1e-5  # of a size, for differences
INSIDE = 0.1  # of a size: the least distance of the first guess from a limit
WEAK = 0.1  # weight of the start: acts on directions that the data leave open by 10 sizes
REFUSED = 1e3  # residual where the FMU refuses the values, in standard deviations
SHARE = 0.1  # of the RMS torque: what a change by one size does, for an unknown that starts at 0
SEEN = 1e-7  # of the RMS torque: a change that is no rounding
LARGEST = 1e12  # size of an unknown, in SI units
BLOCKS = 30
LEAST = 1e-3  # of the noise: least standard deviation of residuals, for recordings without noise
CONFIDENCE = 0.95
COARSE, ACCURACY = 1e-3, 1e-9  # relative changes at which a search ends


@dataclass(frozen=True, eq=False)
class Solution:
    """The best values and what the samples say about them."""

    values: Array  # in the unknown's unit, shape (p,)
    sizes: Array  # of each unknown, likewise
    residual: Array  # model minus measured torque [N.m], shape (n,); 0 where a torque at rest is allowed
    jacobian: Array  # of the residual [N.m] by values in units of `sizes`, shape (n, p)
    covariance: Array  # of values in units of `sizes`, shape (p, p)
    widths: Array  # for `half_width`, in units of `sizes`, shape (2, p, p)
    noise: float  # standard deviation of the torque's noise [N.m]

    def half_width(self, direction: Array) -> float:
        """Half of the 95 % interval of the values' component along a direction, in units of `sizes`."""
        return float(np.linalg.norm(direction @ self.widths, axis=1).max())

    def pull(self, k: int) -> float:
        """How far the residuals pull value k from its place, in units of `sizes`: 0 but at a limit."""
        step, *_ = np.linalg.lstsq(self.jacobian, -self.residual, rcond=None)
        return float(step[k])

    @property
    def correlation(self) -> Array:
        """Correlation of the values, shape (p, p)."""
        spread = np.sqrt(np.diag(self.covariance))
        return self.covariance / np.outer(spread, spread)


class Problem:
    """The residuals of samples `rows` as a function of unknowns in units of their sizes."""

    def __init__(
        self,
        model: TorqueModel,
        torque: Array,
        noise: float,
        unknowns: Sequence[Unknown],
        progress: Callable[[str], None] | None = None,
    ) -> None:
        self.progress, self.runs = progress, 0
        self.model, self.torque, self.noise, self.unknowns = model, torque, noise, unknowns
        self.start = np.array([unknown.start for unknown in unknowns])
        self.model.limits(self.start)  # the FMU's own message where the FMU refuses the design
        self.sizes = np.array([self._size(k) for k in range(len(unknowns))])
        limits = np.array([(unknown.least, unknown.greatest) for unknown in unknowns])
        self.least, self.greatest = (limits / self.sizes[:, None]).T
        self.slack = self._slack()

    def _slack(self) -> Array:
        """How far noise of torque and angle takes a torque at rest out of its band [N.m], shape (n,)."""
        shift = ANGLE_MARGIN * self.model.motion.theta_noise
        before, after = (np.stack(self.model.limits(self.start, by)) for by in (-shift, shift))
        known = np.isfinite(before) & np.isfinite(after)
        change = np.subtract(after, before, out=np.zeros_like(before), where=known)
        from_angle = 0.5 * np.abs(change).max(axis=0)
        return np.where(self.model.motion.direction == 0, np.hypot(MARGIN * self.noise, from_angle), 0.0)

    def _size(self, k: int) -> float:
        """Size of an unknown: its start, or what changes the torque by a share of its RMS."""
        if self.start[k]:
            return abs(float(self.start[k]))
        before = np.concatenate(self.model.limits(self.start))
        finite = np.isfinite(before)
        torque = math.sqrt(float(np.mean(self.torque**2)))
        sign = 1.0 if self.unknowns[k].greatest > 0.0 else -1.0
        step = 1e-9
        while step < LARGEST:
            values = self.start.copy()
            values[k] = sign * step
            try:
                change = np.concatenate(self.model.limits(values))[finite] - before[finite]
            except FmuError:
                break
            rms = math.sqrt(float(np.mean(change**2)))
            if rms > SEEN * torque:
                return step * SHARE * torque / rms
            step *= 10.0
        return 1.0

    def residual(self, x: Array) -> Array:
        """Model minus measurement [N.m]. At rest: the distance from the band beyond the margin of noise."""
        self.runs += 1
        if self.progress is not None:
            self.progress(f"fit: run {self.runs} through {len(self.torque)} samples")
        low, high = self.model.limits(x * self.sizes)
        low, high = low - self.slack, high + self.slack
        return np.maximum(low - self.torque, 0.0) + np.minimum(high - self.torque, 0.0)

    def jacobian(self, x: Array) -> Array:
        """Central differences; one-sided at a limit, and where the FMU refuses one side."""
        columns = []
        for k in range(len(x)):
            sides = []
            for step in (-STEP, STEP):
                moved = x.copy()
                moved[k] = min(max(x[k] + step, self.least[k]), self.greatest[k])
                try:
                    sides.append((moved[k], self.residual(moved)))
                except FmuError:
                    sides.append((x[k], self.residual(x)))
            (first, before), (second, after) = sides
            columns.append((after - before) / (second - first) if second > first else 0.0 * after)
        return np.stack(columns, axis=1)

    def solve(self, guesses: Sequence[Array]) -> Solution:
        """The best result of some first guesses, in the unknowns' units."""
        first = [guess / self.sizes for guess in guesses]
        if len(first) > 1:
            first = [min((self._solve(x, COARSE) for x in first), key=lambda one: one[1])[0]]
        x, _ = self._solve(first[0], ACCURACY)
        residual, jacobian = self.residual(x), self.jacobian(x)
        covariance, widths = spread(residual, jacobian, self.noise)
        return Solution(x * self.sizes, self.sizes, residual, jacobian, covariance, widths, self.noise)

    def _solve(self, guess: Array, accuracy: float) -> tuple[Array, float]:
        """Best values in units of the sizes, and the sum of squares."""
        anchor = self.start / self.sizes
        width = np.minimum(INSIDE, 0.25 * (self.greatest - self.least))
        first = np.clip(guess, self.least + width, self.greatest - width)

        def residuals(x: Array) -> Array:
            try:
                samples = self.residual(x) / self.noise
            except FmuError:
                samples = np.full(len(self.torque), REFUSED)
            return np.concatenate([samples, WEAK * (x - anchor)])

        def jacobian(x: Array) -> Array:
            return np.vstack([self.jacobian(x) / self.noise, WEAK * np.eye(len(x))])

        done = least_squares(
            residuals,
            first,
            jacobian,
            (self.least, self.greatest),
            xtol=accuracy,
            ftol=accuracy,
            gtol=None,
            max_nfev=200,
        )
        return done.x, float(done.cost)


def spread(residual: Array, jacobian: Array, noise: float) -> tuple[Array, Array]:
    """The covariance for independent residuals, shape (p, p), and `Solution.widths`, in units of the sizes.

    Half a 95 % interval along v is the longer v W of two: for independent residuals of one variance, and for
    residuals that are alike within each of some blocks in time (cluster-robust covariance; A. C. Cameron, D.
    L. Miller, A practitioner's guide to cluster-robust inference, 2015). Errors of the model and of a
    smoothed angle last for many samples. IdentificationError for no more telling samples than unknowns.
    """
    count = jacobian.shape[1]
    telling = np.flatnonzero((residual != 0.0) | jacobian.any(axis=1))
    freedom = len(telling) - count
    if freedom < 1:
        raise IdentificationError(
            f"{len(telling)} samples tell something about {count} unknowns: allowed are more samples than"
            " unknowns. At rest friction can carry any torque of the stick band: record motion"
        )
    residual, jacobian = residual[telling], jacobian[telling]
    held = np.vstack([jacobian, WEAK * noise * np.eye(count)])
    _, singular, directions = np.linalg.svd(held, full_matrices=False)
    root = directions.T / singular  # root @ root.T is the inverse of held.T @ held
    variance = max(float(residual @ residual) / freedom, (LEAST * noise) ** 2)
    covariance = variance * root @ root.T
    plain = _quantile(freedom) * math.sqrt(variance) * root
    blocks = min(BLOCKS, len(telling) // 5)
    if blocks <= count + 1:
        return covariance, np.stack([plain, plain])
    parts = zip(np.array_split(jacobian, blocks), np.array_split(residual, blocks), strict=True)
    scores = np.stack([part.T @ rest for part, rest in parts], axis=1)  # one column for each block
    square = np.linalg.cholesky(scores @ scores.T + (LEAST * noise) ** 2 * np.eye(count))
    factor = _quantile(blocks - count) * math.sqrt(blocks / (blocks - count))
    return covariance, np.stack([plain, factor * root @ (root.T @ square)])


def _quantile(freedom: int) -> float:
    return float(student.ppf(0.5 + CONFIDENCE / 2.0, freedom))
