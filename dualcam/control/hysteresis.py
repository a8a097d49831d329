"""The cam's friction hysteresis for describing function analysis."""

import warnings

from dualcam.control.forward import CamAtState, Names
from dualcam.control.harmonic_balance import candidates
from dualcam.control.limit_cycles import LimitCycles, check_in_loop, unchecked
from dualcam.control.play_operator import PlayOperator
from dualcam.control.sampled_loop import Law, SampledController, check_duration
from dualcam.control.swing import ImposedSwing
from dualcam.errors import LimitCycleWarning, OperatingPointError

DURATION = 200.0  # s, of a run of the loop


class CamHysteresis(PlayOperator):
    """The cam's friction hysteresis, for control.describing_function_response.

    An instance gives the deviation of theta [rad] from `theta`, as a function of the deviation of tau [N.m]
    from a bias: control.describing_function_response(H, hysteresis, A), with H from theta to -tau.

    Parameters
    ----------
    source
        "forward", the path of a forward FMU (FMI 2.0 or 3.0), or a handle (then with the parameters of its
        last start).
    theta : Mean angle of the oscillation [rad], between the stops.
    tau
        Bias of the torque [N.m]: the mean angle then depends on the amplitude. None: for each amplitude the
        bias that keeps the mean angle at `theta`, as integral action in the loop does.
    parameters
        Start values of the FMU (spring, grooves, friction, stops, F_ext). Inertia and `shaft.damping` have an
        effect on `swing_torque` and `limit_cycles` only: the play operator is that of slow motion.

    Raises
    ------
    OperatingPointError
        `theta` is not between the stops, or the torque band does not rise with theta from stop to stop: a
        contact locks, or the spring is so soft that the cam snaps through.
    FmuError : A value that the FMU refuses.

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

    def swing_torque(self, amplitude: float, frequency: float) -> complex:
        """First harmonic of the torque that a sinusoidal swing needs, over the amplitude of the angle
        [N.m/rad]: stiffness less inertia times frequency squared, and j times the friction's part. With all
        inertia, damping, and the friction law at the speed of each instant.

        `amplitude`: of the angle, about `theta` [rad]. `frequency`: angular frequency of the swing [rad/s].
        OperatingPointError: the swing reaches a stop, or no torque moves the cam so. FmuError: the cam has no
        inertia.

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
        self,
        controller: Law,
        check: bool = True,
        duration: float = DURATION,
        *,
        inputs: Names = None,
    ) -> LimitCycles:
        """Limit cycles under a sampled position controller: predicted, and checked with the FMU in the loop.

        Parameters
        ----------
        controller
            With a sampling time. Its one output is the torque [N.m], which is held over the period. An input
            is "error", `theta` less the angle [rad], "theta", the angle [rad], "omega" [rad/s], or
            "reference", which stays constant. Whatever else makes the torque of rest counts as a bias.
        check
            Whether the loop is run with the FMU: from each prediction, and from four offsets. Seconds;
            without the check about one second.
        duration : Longest time [s] of each run of the check; at most 4e6 periods of the controller.
        inputs
            What the inputs of the controller are, in their order. None: their names say it, where `xd[0]` and
            `ud[0]` of control.create_statefbk_iosystem are references; a single input of another name is the
            error.

        Returns
        -------
        LimitCycles

        Warns
        -----
        LimitCycleWarning
            Once per finding: the FMU in the loop swings where no limit cycle is predicted, a prediction is
            wrong by more than 10 % in amplitude or frequency, or a run ends pressed on a stop (a controller
            of the wrong sign), with a torque that grows without end (an unstable controller), with a swing
            that still grows, or without having settled. Without the check: a prediction whose margin is too
            small (see LimitCycle), or a controller that is unstable.

        Raises
        ------
        FmuError
            No controller, a nonlinear or continuous one, one with several outputs, with other inputs, or with
            coefficients that are not finite; a duration that is no time, or above 4e6 periods.
        OperatingPointError : The hysteresis has a bias `tau`: the controller makes the bias.

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
        >>> len(caught), found.holds, found.rests
        (1, False, False)
        """
        if self.bias is not None:
            raise OperatingPointError(
                f"limit_cycles with the bias tau = {self.bias:g} N.m: allowed is a CamHysteresis without tau,"
                " because the controller makes the bias"
            )
        law = SampledController(controller, inputs)
        if check:
            check_duration(duration, law.period)
        found = candidates(self, law)
        result = check_in_loop(self, law, found, duration) if check else unchecked(law, found)
        for finding in result.findings:
            warnings.warn(finding, LimitCycleWarning, stacklevel=2)
        return result
