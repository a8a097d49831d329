"""The cam's friction hysteresis for describing function analysis."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping

import control
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from dualcam.control.forward import CamAtState, Source, open_forward
from dualcam.control.harmonic_balance import candidates
from dualcam.control.limit_cycles import LimitCycles, check_in_loop, unchecked
from dualcam.control.linear import OperatingPointError
from dualcam.control.sampled_loop import SampledController, check_duration
from dualcam.control.swing import ImposedSwing
from dualcam.errors import LimitCycleWarning
from dualcam.fmi.fmu import Fmu, RepeatedStart
from dualcam.fmi.model_description import Scalar
from dualcam.fmi.reals import Array

POINTS = 201  # angles of the stick band from the FMU; cubic splines between them
DURATION = 200.0  # s, of a run of the loop
PHASES = 4096  # per cycle: kinks at turning points make an error of the harmonic near 1/PHASES^2


class CamHysteresis(control.DescribingFunctionNonlinearity):
    """The cam's friction hysteresis, for control.describing_function_response.

    An instance gives the deviation of theta [rad] from `theta`, as a function of the deviation of tau [N.m]
    from a bias: control.describing_function_response(H, hysteresis, A), with H from theta to -tau.

    Parameters
    ----------
    source : str, Path, Fmu or ContinuousFmu
        "forward", the path of a forward FMU (FMI 2.0 or 3.0), or a handle (then with the parameters of its
        last start).
    theta : float
        Mean angle of the oscillation [rad], between the stops.
    tau : float, optional
        Bias of the torque [N.m]: the mean angle then depends on the amplitude. None: for each amplitude the
        bias that keeps the mean angle at `theta`, as integral action in the loop does.
    parameters : mapping of str to float, int, bool or str, optional
        Start values of the FMU (spring, grooves, friction, stops, F_ext). Inertia and `shaft.damping` have an
        effect on `swing_torque` and `limit_cycles` only: the play operator is that of slow motion.

    Raises
    ------
    OperatingPointError
        theta is no play of tau: `theta` not between the stops, a contact that locks, a spring so soft that
        the cam snaps through.
    FmuError
        A value that the FMU refuses.

    Notes
    -----
    In slow motion, without effect of inertia and damping, the cam is a play operator from torque to angle,

        theta' > 0 only where tau = T_load(theta),    theta' < 0 only where tau = T_release(theta),

    between its end stops. Its edges are not parallel: the band widens as the spring is compressed. Both edges
    are read from the FMU (docs/mechanism.md, section 3).

    With control.describing_function_response the prediction holds for a loop that is a low-pass, so that the
    angle's third harmonic hardly returns as torque. The oscillation must be slow against sqrt(dT/dtheta/J),
    the cam's natural frequency (`natural_frequency`). Otherwise the list of limit cycles is wrong, or empty,
    without a warning. `limit_cycles` has the inertia and the controller's hold in the loop, and checks its
    prediction with the FMU.

    Friction that falls with the speed: the edges are the static ones. `swing_torque` has the whole law.

    Examples
    --------
    >>> import dualcam
    >>> hysteresis = dualcam.CamHysteresis("forward", theta=0.5)
    >>> round(hysteresis.dead_band, 3)  # N.m
    0.857
    >>> hysteresis.describing_function(0.5)  # inside the dead band nothing moves
    0j
    """

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
                "theta is no play of tau: both edges of the stick band must rise with theta all the way;"
                " lead angles beyond atan(friction), a stiffer spring or closer stops make them"
            )
        self.theta, self.bias = theta, tau
        self._release, self._load = (CubicSpline(angles, band[:, i]) for i in range(2))
        self._ends = band[[0, -1]].T  # release and load at the lower and the upper stop
        self._falling, self._rising = (CubicSpline(band[:, i], angles) for i in range(2))
        self._middle = float(np.mean(self.band(theta))) if tau is None else tau
        self._angle = theta  # rad, present angle, for __call__

    def band(self, theta: float) -> tuple[float, float]:
        """Edges of the stick band.

        Parameters
        ----------
        theta : float
            Angle [rad].

        Returns
        -------
        tuple of float
            T_release and T_load [N.m].
        """
        return float(self._release(theta)), float(self._load(theta))

    @property
    def dead_band(self) -> float:
        """Half the width of the stick band at `theta` [N.m]: amplitudes up to this move nothing."""
        release, load = self.band(self.theta)
        return 0.5 * (load - release)

    def natural_frequency(self, inertia: float) -> float:
        """Natural frequency of small oscillations while loading, sqrt(dT_load/dtheta / inertia).

        Parameters
        ----------
        inertia : float
            Inertia felt at the shaft [kg.m2].

        Returns
        -------
        float
            Angular frequency [rad/s].
        """
        return math.sqrt(float(self._load(self.theta, 1)) / inertia)

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
        """One steady cycle under tau = bias + amplitude sin(phase).

        Parameters
        ----------
        amplitude, bias : float
            Of the torque [N.m].

        Returns
        -------
        tuple of ndarray, shape (4096,) each
            Torque [N.m] and angle [rad] at equal phases from 0 on.
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
        """The angle in the steady cycle under any periodic torque.

        Parameters
        ----------
        tau : ndarray, shape (n,)
            A period of the torque [N.m].

        Returns
        -------
        ndarray, shape (n,)
            Angle [rad].
        """
        lowest, highest = (self._angle_at_edge(tau, rising).tolist() for rising in (True, False))
        angle, found = self.theta, []
        for _ in range(2):  # the first period forgets where it began
            found = [angle := min(max(angle, low), high) for low, high in zip(lowest, highest, strict=True)]
        return np.array(found)

    def bias_at(self, amplitude: float) -> float:
        """The bias of cycles of an amplitude: as given, or the one with the mean angle `theta`.

        Parameters
        ----------
        amplitude : float
            Of the torque [N.m].

        Returns
        -------
        float
            Bias of the torque [N.m].
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
        """First harmonic of the angle over that of the torque.

        Parameters
        ----------
        A : float
            Amplitude of the torque [N.m], >= 0.

        Returns
        -------
        complex
            [rad/(N.m)]; 0 in the dead band.

        Raises
        ------
        OperatingPointError
            A negative amplitude.
        """
        if not A >= 0.0:
            raise OperatingPointError(f"amplitude A = {A}: allowed is >= 0")
        if A == 0.0 or (self.bias is None and self.dead_band >= A):
            return 0j
        theta = self.cycle(A, self.bias_at(A))[1]
        # theta = mean + A (Re N sin + Im N cos) + ...; the first line of its spectrum is Im N - i Re N
        return complex(2j / (PHASES * A) * np.fft.rfft(theta)[1])

    # ---- in a loop, with inertia ----

    def swing_torque(self, amplitude: float, frequency: float) -> complex:
        """First harmonic of the torque that a sinusoidal swing needs, over the amplitude of the angle.

        Parameters
        ----------
        amplitude : float
            Of the angle, about `theta` [rad].
        frequency : float
            Angular frequency of the swing [rad/s].

        Returns
        -------
        complex
            [N.m/rad]: stiffness less inertia times frequency squared, and j times the friction's part. With
            all inertia, damping, and the friction law at the speed of each instant.

        Raises
        ------
        OperatingPointError
            The swing reaches a stop, or no torque moves the cam so.
        FmuError
            The cam has no inertia.

        Examples
        --------
        >>> import dualcam
        >>> hysteresis = dualcam.CamHysteresis("forward", theta=0.5)
        >>> needed = hysteresis.swing_torque(0.2, 20.0)
        >>> round(needed.real, 2), round(needed.imag, 2)  # N.m/rad
        (4.4, 5.45)
        """
        reach = min(self.theta - self.lower, self.upper - self.theta)
        if not 0.0 < amplitude < reach or not frequency > 0.0:
            raise OperatingPointError(
                f"amplitude = {amplitude:g} rad, frequency = {frequency:g} rad/s: allowed are amplitudes"
                f" between 0 and {reach:g} rad, the distance to the nearer stop, and frequencies > 0"
            )
        cam = CamAtState(self.path, self.parameters)
        try:
            return ImposedSwing(cam, self.theta, self.F_ext).harmonics(amplitude, frequency).first
        finally:
            cam.fmu.close()

    def limit_cycles(
        self, controller: control.lti.LTI, check: bool = True, duration: float = DURATION
    ) -> LimitCycles:
        """Limit cycles under a sampled position controller: predicted, and checked with the FMU in the loop.

        Parameters
        ----------
        controller : control.StateSpace or control.TransferFunction
            From the error, `theta` less the angle [rad], to the torque [N.m], with a sampling time. The
            torque is held over the period.
        check : bool
            Whether the loop is run with the FMU: from each prediction, and from four offsets. Seconds;
            without the check about one second.
        duration : float
            Longest time [s] of each run of the check; at most 4e6 periods of the controller.

        Returns
        -------
        LimitCycles

        Warns
        -----
        LimitCycleWarning
            Once per finding: the FMU in the loop swings where no limit cycle is predicted, a prediction is
            wrong by more than 10 % in amplitude or frequency, or a run ends pressed on a stop (a controller
            of the wrong sign), with a torque that grows without end (an unstable controller) or without
            having settled. Without the check: a prediction whose margin is too small (see LimitCycle), or a
            controller that is unstable.

        Raises
        ------
        FmuError
            No controller, a continuous one, one with several inputs or outputs, or with coefficients that are
            not finite; a duration that is no time, or above 4e6 periods.
        OperatingPointError
            The hysteresis has a bias `tau`: the controller makes the bias.

        Notes
        -----
        Two harmonic balances are solved, each with the inertia, the shaft's damping and the hold. One takes
        the angle for sinusoidal (`swing_torque`): good for swings that inertia carries. The other one takes
        the torque on the grooves for sinusoidal, and then adds harmonics up to the ninth: good for slow
        cycles with long rests. Neither knows the stops, nor the jumps out of rest of friction that falls with
        the speed. The check knows both.

        Examples
        --------
        >>> import warnings
        >>> import control, dualcam
        >>> hysteresis = dualcam.CamHysteresis("forward", theta=0.7)
        >>> period, proportional, integral = 1e-3, 50.0, 2000.0  # s, N.m/rad, N.m/(rad.s)
        >>> law = control.ss(1.0, integral * period, 1.0, proportional, period)
        >>> with warnings.catch_warnings(record=True) as caught:
        ...     warnings.simplefilter("always")
        ...     found = hysteresis.limit_cycles(law)
        >>> [(round(c.amplitude, 3), round(c.frequency), c.stable) for c in found.predicted]  # rad, rad/s
        [(0.09, 163, False)]
        >>> [round(motion.amplitude, 2) for motion in found.simulated]  # rad, from stop to stop
        [0.66]
        >>> len(caught), found.holds
        (1, False)
        """
        if self.bias is not None:
            raise OperatingPointError(
                f"limit_cycles with the bias tau = {self.bias:g} N.m: allowed is a CamHysteresis without tau,"
                " because the controller makes the bias"
            )
        law = SampledController(controller)
        if check:
            check_duration(duration, law.period)
        found = candidates(self, law)
        result = check_in_loop(self, law, found, duration) if check else unchecked(law, found)
        for finding in result.findings:
            warnings.warn(finding, LimitCycleWarning, stacklevel=2)
        return result


def _check_number(name: str, value: object, allowed: str) -> None:
    """OperatingPointError if a value is no finite number."""
    number = isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool)
    if not number or not math.isfinite(value):  # type: ignore[arg-type]
        raise OperatingPointError(f"{name} = {value!r}: allowed is a finite number [{allowed}]")
