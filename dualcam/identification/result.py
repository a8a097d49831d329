"""What an identification found: values with intervals, doubts, residuals."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from dualcam.common.unit_guards import torque_factor_warnings
from dualcam.design_file import DesignFile
from dualcam.errors import IdentificationError
from dualcam.identification.ambiguity import Ambiguity
from dualcam.identification.lack_of_fit import Lever, Missing
from dualcam.identification.motion import Motion
from dualcam.identification.recording import Recording
from dualcam.identification.smoothing import NORMAL

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

KNOWN, AT_LIMIT, OPEN = "known", "at its limit", "not determined"
WELL = 1.2  # RMS of residuals over noise, up to which the model explains the recording
EXACT = 1e-3  # residual over torque, below which nothing is missing
MOST_DECIMALS = 7
FAR = 6.0  # standard deviations, from which a sample may be a fault
CLOSE = 0.95  # correlation from which two values are named
SMOOTH = 0.1  # noise of alpha over its RMS, from which inertias come out too small


@dataclass(frozen=True)
class FittedParameter:
    """One fitted value.

    Attributes
    ----------
    name : str
        As given in `fit`.
    keys : tuple of str
        The FMU's parameters with this value.
    unit : str
        Unit, "1" for a plain number.
    start, value : float
        Value of the design, and fitted value.
    low, high : float
        Ends of the 95 % interval.
    status : {"known", "at its limit", "not determined"}
        "at its limit": the recording asks for a value beyond the least or greatest allowed one. "not
        determined": see the ambiguities.
    limit : float or None
        The limit at which the best value is.
    part : float
        RMS of the value's part of the torque where the cam slips [N.m], by the derivative at the best value.
    """

    name: str
    keys: tuple[str, ...]
    unit: str
    start: float
    value: float
    low: float
    high: float
    status: str
    limit: float | None = None
    part: float = math.inf

    @property
    def limit_text(self) -> str:
        """A sentence where the best value is at a limit, else nothing."""
        if self.limit is None or self.status == OPEN:
            return ""
        if self.status == AT_LIMIT:
            return f"{self.name} = {self.value:.4g} is at its limit: the data ask for a value beyond"
        return (
            f"{self.name}: the limit {self.limit:.4g} is inside the 95 % interval. The recording does not"
            f" show that {self.name} differs from {self.limit:.4g}"
        )

    @property
    def interval(self) -> str:
        """The 95 % interval in words, to two digits of its half width."""
        return OPEN if self.status == OPEN else f"{self._rounded(self.low)} to {self._rounded(self.high)}"

    @property
    def rounded(self) -> str:
        """The fitted value to two digits of the half width of its interval."""
        return f"{self.value:.4g}" if self.status == OPEN else self._rounded(self.value)

    def _rounded(self, value: float) -> str:
        half = 0.5 * (self.high - self.low)
        decimals = 1 - math.floor(math.log10(half)) if 0.0 < half < math.inf else MOST_DECIMALS + 1
        return f"{value:.{max(decimals, 0)}f}" if decimals <= MOST_DECIMALS else f"{value:.6g}"


@dataclass(frozen=True, eq=False)
class Identification:
    """The result of `identify`. Indexing by a name gives the fitted parameter.

    Attributes
    ----------
    design : DesignFile
        The design of the start values.
    recording : Recording
        All samples.
    motion : Motion
        Motion at the samples that count.
    time, measured : ndarray, shape (n,)
        Time [s] and measured torque [N.m] of these samples.
    low, high : ndarray, shape (n,)
        Limits of the fitted model's torque [N.m]; both are alike where the cam slips.
    before : ndarray, shape (n,)
        Torque of the model with the start values that is nearest to the measured torque [N.m].
    residual : ndarray, shape (n,)
        Fitted minus measured torque [N.m]; 0 where a torque at rest is allowed.
    sliding_speed : ndarray, shape (n,)
        Sliding speed of the faster contact [m/s].
    noise : float
        Standard deviation of the noise of the measured torque [N.m], from neighbouring samples.
    parameters : tuple of FittedParameter
        In the order of `fit`.
    correlation : ndarray, shape (p, p)
        Correlation of the fitted values.
    ambiguities : tuple of Ambiguity
        What the data cannot tell apart.
    missing : tuple of Missing
        Values outside of the fit that the residuals ask for, the best one first; see `lack_of_fit`.
    levers : tuple of Lever
        Fitted values that a small error of a held value would change strongly.
    """

    design: DesignFile
    recording: Recording
    motion: Motion
    time: Array
    measured: Array
    low: Array
    high: Array
    before: Array
    residual: Array
    sliding_speed: Array
    noise: float
    parameters: tuple[FittedParameter, ...]
    correlation: Array
    ambiguities: tuple[Ambiguity, ...]
    missing: tuple[Missing, ...] = ()
    levers: tuple[Lever, ...] = ()

    def __getitem__(self, name: str) -> FittedParameter:
        for parameter in self.parameters:
            if parameter.name == name:
                return parameter
        fitted = ", ".join(parameter.name for parameter in self.parameters)
        raise IdentificationError(f"{name!r} was not fitted: allowed are {fitted}")

    @property
    def slips(self) -> NDArray[np.bool_]:
        """Which samples slip in a known direction, shape (n,)."""
        return self.motion.direction != 0

    @property
    def rms(self) -> float:
        """RMS of the residual where the cam slips [N.m]."""
        return _rms(self.residual[self.slips])

    @property
    def rms_before(self) -> float:
        """The same for the start values [N.m]."""
        return _rms((self.before - self.measured)[self.slips])

    def summary(self) -> list[str]:
        """What the recording is, and how well the model explains the recording, line by line."""
        motion = self.motion
        counts = (
            f"{motion.count(1)} loading, {motion.count(-1)} releasing, {motion.count(0)} at rest or reversing"
        )
        smoothed = "" if motion.window is None else f", angle smoothed over {motion.window:.3g} s"
        whole = f"{len(self.recording)} samples over {np.ptp(self.recording.time):.4g} s"
        every = -(-len(self.recording) // len(self.time))
        if every > 1:
            whole += f", of which every {_ordinal(every)} counts, {len(self.time)} samples"
        return [
            f"{whole}: {counts}",
            f"{motion.kind} motion{smoothed}",
            f"residual RMS {self.rms:.3g} N.m, before the fit {self.rms_before:.3g} N.m",
            f"noise of the torque {self.noise:.3g} N.m, of the angle {motion.theta_noise:.2g} rad",
        ]

    def warnings(self) -> list[str]:
        """What the data cannot tell apart, and other doubts."""
        from dualcam.identification.words import asked_for, levers_of, weak_parts

        if gross := self.recording_faults():
            return gross  # all else follows from the fault
        found = torque_factor_warnings(self._factor(), self.recording.torque_unit)
        if not found:  # after another unit the shape of the residuals says little
            found += asked_for(self)
        found += [str(ambiguity) for ambiguity in self.ambiguities]
        found += [text for one in self.parameters if (text := one.limit_text)]
        found += levers_of(self)
        found += weak_parts(self)
        found += self._close_pairs()
        found += self._outliers()
        if self.rms > max(WELL * self.noise, EXACT * _rms(self.measured)):
            found.append(
                f"The residual is {self.rms / self.noise:.2g} times the noise: the model lacks something. The"
                " residuals over angle and speed show what"
            )
        motion = self.motion
        inertias = [one.name for one in self.parameters if one.name.startswith("inertia.")]
        if inertias and motion.alpha_noise > SMOOTH * motion.alpha_rms:
            found.append(
                f"The acceleration has noise of {motion.alpha_noise:.2g} rad/s2 at an RMS of"
                f" {motion.alpha_rms:.2g} rad/s2: {' and '.join(inertias)} may come out too small. Give a"
                " longer window, or measure the speed"
            )
        return found

    def recording_faults(self) -> list[str]:
        """What makes the recording useless as read: another unit of time, or a torque of opposite sign."""
        if question := self.motion.time_question(float(np.ptp(self.recording.time))):
            return [question]
        slips = self.slips
        if np.mean(self.measured[slips]) * np.mean(self.before[slips]) >= 0.0:
            return []
        return [
            "The measured torque has the opposite sign of the design's: is the torque positive in the"
            " loading direction? Change the sign of the torque in the recording"
        ]

    def _factor(self) -> float:
        """RMS of the measured torque over that of the start values, where the cam slips."""
        before = _rms(self.before[self.slips])
        return _rms(self.measured[self.slips]) / before if before else math.nan

    def _close_pairs(self) -> list[str]:
        known = [k for k, one in enumerate(self.parameters) if one.status != OPEN]
        return [
            f"{self.parameters[i].name} and {self.parameters[k].name} have a correlation of"
            f" {self.correlation[i, k]:.3f}: an error of one is an error of the other"
            for i in known
            for k in known
            if i < k and abs(self.correlation[i, k]) > CLOSE
        ]

    def _outliers(self) -> list[str]:
        """A warning where single samples are far from the others."""
        usual = NORMAL * float(np.median(np.abs(self.residual[self.slips])))
        far = np.flatnonzero(self.slips & (np.abs(self.residual) > FAR * max(usual, self.noise)))
        if not len(far):
            return []
        count = "1 sample is" if len(far) == 1 else f"{len(far)} samples are"
        return [
            f"{count} off by more than {FAR:g} standard deviations, the first at {self.time[far[0]]:.6g} s:"
            " leave out samples that are faults"
        ]

    def as_dict(self) -> dict[str, Any]:
        """The result as plain data, for JSON."""
        return {
            "samples": len(self.recording),
            "loading": self.motion.count(1),
            "releasing": self.motion.count(-1),
            "at_rest": self.motion.count(0),
            "motion": self.motion.kind,
            "residual_rms": self.rms,
            "residual_rms_before": self.rms_before,
            "noise": self.noise,
            "parameters": {
                one.name: {
                    "start": one.start,
                    "value": one.value,
                    "interval": [one.low, one.high],
                    "unit": one.unit,
                    "status": one.status,
                }
                for one in self.parameters
            },
            "correlation": self.correlation,
            "not_told_apart": [list(one.names) for one in self.ambiguities],
            "residuals_ask_for": [one.name for one in self.missing],
            "samples_that_count": len(self.time),
            "warnings": self.warnings(),
        }

    def plot(self) -> Figure:
        """Measured and fitted torque over the angle, and residuals over angle, sliding speed and time.

        Returns
        -------
        matplotlib.figure.Figure
        """
        from dualcam.identification.picture import plot_identification

        return plot_identification(self)

    def write_report(self, path: str | Path) -> Path:
        """Write one HTML page with the result.

        Parameters
        ----------
        path : str or Path
            The page (.html).

        Returns
        -------
        Path
            The written file.
        """
        from dualcam.identification.page import write_page

        return write_page(self, path)

    def write_design(self, path: str | Path) -> Path:
        """Write the design file with the fitted values. Comments and all other lines stay.

        Parameters
        ----------
        path : str or Path
            The new design file.

        Returns
        -------
        Path
            The written file.
        """
        from dualcam.identification.fitted_design import write_fitted

        return write_fitted(self, path)


def _ordinal(number: int) -> str:
    ending = "th" if number % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return f"{number}{ending}"


def _rms(values: Array) -> float:
    return math.sqrt(float(np.mean(values**2))) if len(values) else 0.0
