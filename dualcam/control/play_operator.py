"""The cam in slow motion as a play operator from torque to angle, and its describing function."""

import math
from collections.abc import Mapping

import control
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from dualcam.common.arrays import positive_number
from dualcam.control.forward import Source, open_forward
from dualcam.control.linear import linearize
from dualcam.errors import OperatingPointError
from dualcam.fmi.fmu import Fmu, RepeatedStart
from dualcam.fmi.model_description import Scalar
from dualcam.fmi.reals import Array

POINTS = 201  # angles of the stick band from the FMU; cubic splines between them
PHASES = 4096  # per cycle: kinks at turning points make an error of the harmonic near 1/PHASES^2


class PlayOperator(control.DescribingFunctionNonlinearity):
    """Torque to angle between the edges of the stick band. Attributes: `theta` and `bias` as given, `lower`
    and `upper` stop [rad], `inertia` and `damping` of the shaft, `F_ext`, `path` and `parameters` of the
    FMU."""

    def __init__(
        self,
        source: Source,
        theta: float,
        tau: float | None = None,
        parameters: Mapping[str, Scalar] | None = None,
    ) -> None:
        super().__init__()
        _check_number("theta", theta, "rad, between the stops")
        if tau is not None:
            _check_number("tau", tau, "N.m, or None")
        fmu, values = open_forward(Fmu, source, parameters)
        try:
            runs = RepeatedStart(fmu, values, ["initial.theta"])
            self.lower, self.upper = fmu.real("stop.lower"), fmu.real("stop.upper")
            self.path, self.parameters = fmu.path, values
            self.inertia, self.damping = fmu.real("inertia.shaft"), fmu.real("shaft.damping")
            self.F_ext = float(values.get("F_ext", 0.0))
            if not self.lower < theta < self.upper:
                raise OperatingPointError(
                    f"theta = {theta:g} rad: allowed is between the stops, {self.lower:g}"
                    f" and {self.upper:g} rad"
                )
            angles = np.linspace(self.lower, self.upper, POINTS)
            edges = fmu.reals("torque_release", "torque_load")
            band = np.empty((POINTS, 2))
            for angle, row in zip(angles, band, strict=True):
                runs.initialize([angle])
                row[:] = edges.read()
        finally:
            fmu.close()
        if not np.all(np.isfinite(band)) or not np.all(np.diff(band, axis=0) > 0.0):
            raise OperatingPointError(
                "the torque band must rise with theta from stop to stop, and does not: lead angles beyond"
                " atan(friction), a stiffer spring or closer stops make it rise"
            )
        self.theta, self.bias = theta, tau
        self._release, self._load = (CubicSpline(angles, band[:, i]) for i in range(2))
        self._ends = band[[0, -1]].T  # release and load at the lower and the upper stop
        self._falling, self._rising = (CubicSpline(band[:, i], angles) for i in range(2))
        self._middle = float(np.mean(self.band(theta))) if tau is None else tau
        self._angle = theta  # rad, present angle, for __call__

    def band(self, theta: float) -> tuple[float, float]:
        """Edges of the stick band, T_release and T_load [N.m]. `theta`: angle [rad]."""
        return float(self._release(theta)), float(self._load(theta))

    @property
    def dead_band(self) -> float:
        """Half the width of the stick band at `theta` [N.m]: amplitudes up to this move nothing."""
        release, load = self.band(self.theta)
        return 0.5 * (load - release)

    def natural_frequency(self, inertia: float | None = None) -> float:
        """Natural frequency of small oscillations while loading, sqrt(dT_load/dtheta / inertia) [rad/s].

        `inertia` felt at the shaft [kg.m2], > 0. None: that of the FMU with its follower, from `linearize`.
        FmuError: an inertia that is no number > 0; None, and the FMU has no inertia.
        """
        if inertia is None:
            model = linearize(self.path, self.theta, at_rest="loading", parameters=self.parameters)
            return math.sqrt(-float(model.A[1, 0]))
        return math.sqrt(float(self._load(self.theta, 1)) / positive_number(inertia, "inertia"))

    # ---- as a function of time ----

    def __call__(self, x: float) -> float:
        """The angle [rad] after a torque [N.m], both as deviations, the torque's from the bias (without a
        bias: from the middle of the band at `theta`). The instance remembers the angle between calls."""
        tau = self._middle + float(np.squeeze(x))
        self._angle = float(
            np.clip(self._angle, self._angle_at_edge(tau, True), self._angle_at_edge(tau, False))
        )
        return self._angle - self.theta

    def _isstatic(self) -> bool:
        return False

    def _angle_at_edge(self, tau: float | Array, rising: bool) -> Array:
        """The angle [rad] at which that edge of the band is tau [N.m], limited by the stops."""
        edge = self._rising if rising else self._falling
        low, high = self._ends[1 if rising else 0]
        return np.clip(edge(np.clip(tau, low, high)), self.lower, self.upper)

    # ---- in a cycle ----

    def cycle(self, amplitude: float, bias: float) -> tuple[Array, Array]:
        """One steady cycle under tau = bias + amplitude sin(phase). Returns the torque [N.m] and angle [rad]
        at equal phases from 0 on, shape (4096,) each.

        `amplitude`, `bias`: of the torque [N.m].
        """
        phase = 2.0 * np.pi / PHASES * np.arange(PHASES)
        tau = bias + amplitude * np.sin(phase)
        top = self._angle_at_edge(bias + amplitude, True)
        bottom = self._angle_at_edge(bias - amplitude, False)
        if bottom >= top:  # the cam rests
            return tau, np.full(PHASES, 0.5 * (top + bottom))
        falls = (phase >= 0.5 * np.pi) & (phase < 1.5 * np.pi)
        theta = np.where(
            falls,
            np.minimum(top, self._angle_at_edge(tau, False)),
            np.maximum(bottom, self._angle_at_edge(tau, True)),
        )
        return tau, theta

    def steady_angle(self, tau: Array) -> Array:
        """The angle [rad] in the steady cycle under any periodic torque, shape (n,). `tau`: a period of the
        torque [N.m], shape (n,).
        """
        lowest, highest = (self._angle_at_edge(tau, rising).tolist() for rising in (True, False))
        angle, found = self.theta, []
        for _ in range(2):  # the first period forgets where it began
            found = [angle := min(max(angle, low), high) for low, high in zip(lowest, highest, strict=True)]
        return np.array(found)

    def bias_at(self, amplitude: float) -> float:
        """The bias [N.m] of cycles of an amplitude: as given, or the one with the mean angle `theta`.
        `amplitude`: of the torque [N.m].
        """
        if self.bias is not None:
            return self.bias
        release, load = self.band(self.theta)
        # At these two biases the whole cycle is below or above theta.
        return float(
            brentq(
                lambda bias: float(np.mean(self.cycle(amplitude, bias)[1])) - self.theta,
                release - amplitude,
                load + amplitude,
                xtol=1e-13,
            )
        )

    def describing_function(self, A: float) -> complex:
        """First harmonic of the angle over that of the torque. Returns [rad/(N.m)]; 0 in the dead band. `A`:
        amplitude of the torque [N.m], >= 0. OperatingPointError: a negative amplitude.
        """
        if not A >= 0.0:
            raise OperatingPointError(f"amplitude A = {A}: allowed is >= 0")
        if A == 0.0 or (self.bias is None and self.dead_band >= A):
            return 0j
        theta = self.cycle(A, self.bias_at(A))[1]
        # theta = mean + A (Re N sin + Im N cos) + ...; the first line of its spectrum is Im N - i Re N
        return complex(2j / (PHASES * A) * np.fft.rfft(theta)[1])


def _check_number(name: str, value: object, allowed: str) -> None:
    """OperatingPointError if a value is no finite number."""
    number = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not number or not math.isfinite(value):  # type: ignore[arg-type]
        raise OperatingPointError(f"{name} = {value!r}: allowed is a finite number [{allowed}]")
