"""What an identification found: values with intervals, doubts, residuals."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dualcam.common.arrays import Array
from dualcam.design_file import DesignFile
from dualcam.errors import IdentificationError
from dualcam.identification.ambiguity import Ambiguity
from dualcam.identification.lack_of_fit import Lever, Missing
from dualcam.identification.motion import MeasuredMotion, rms_of
from dualcam.identification.recording import Recording

KNOWN, AT_LIMIT, OPEN = "known", "at its limit", "not determined"
MOST_DECIMALS = 7
HEADS = ("parameter", "start", "fitted", "95 % interval", "unit")


@dataclass(frozen=True)
class FittedParameter:
    """One fitted value.

    Attributes
    ----------
    name : As given in `fit`.
    keys : The FMU's parameters with this value.
    unit : Unit, "1" for a plain number.
    start, value : Value of the design, and fitted value.
    low, high : Ends of the 95 % interval.
    status : {"known", "at its limit", "not determined"}
        "at its limit": the recording asks for a value beyond the least or greatest allowed one. "not
        determined": see the ambiguities.
    limit : The limit at which the best value is.
    part
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
class Fit:
    """The numbers of a fit, as Identification documents them."""

    design: DesignFile
    recording: Recording
    motion: MeasuredMotion
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
        return rms_of(self.residual[self.slips])

    @property
    def rms_before(self) -> float:
        """The same for the start values [N.m]."""
        return rms_of((self.before - self.measured)[self.slips])

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


def _ordinal(number: int) -> str:
    ending = "th" if number % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(number % 10, "th")
    return f"{number}{ending}"


def rows_of(fit: Fit) -> list[list[str]]:
    """One row of texts for each fitted value."""
    return [
        [
            one.name,
            f"{one.start:.5g}",
            one.rounded,
            one.interval,
            "-" if one.unit == "1" else one.unit,
        ]
        for one in fit.parameters
    ]
