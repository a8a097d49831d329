"""An own plant in Python on the shaft of the forward FMU: explicit and implicit coupling.

    def motor(shaft: ShaftMotion) -> float:                  # N.m
        back_emf = torque_constant * gear_ratio * shaft.omega
        return gear_ratio * torque_constant * (voltage(shaft.time) - back_emf) / resistance

    coupling = PlantCoupling(fmu, motor)
    for _ in range(1000):
        coupling.step_implicit(1e-3)

Explicit coupling computes the torque from the motion at the beginning of the step: an error of the torque
comes back in the next step, multiplied. Implicit coupling solves for the torque that suits the motion over
the same step, by Newton's method with the interface Jacobian; it is stable for every passive plant.
docs/couple-own-plant.md has bounds of stability and sources.
"""

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from dualcam.common.arrays import Array, number_of, real_array
from dualcam.common.moved import also_called
from dualcam.coupling.held_feedback import TorqueSwings, held_feedback_text
from dualcam.coupling.plant import (
    DIFFERENCE,
    Impedance,
    LoopStability,
    PlantTorque,
    ShaftMotion,
    cam_of_step,
    check_order,
    check_positive,
    impedance_of,
    spectral_radius,
    torque_polynomial,
    unstable_loop_text,
)
from dualcam.errors import CouplingError, UnstableCouplingWarning
from dualcam.fmi.fmu import Fmu

STEP_SENSITIVITIES = ("step.dtheta_dtau", "step.domega_dtau", "step.domega_dtheta")
CHECKED = 16  # implicit steps, of which one is checked for an unstable loop, at the cost of half a step
ITERATIONS = 100  # most trial steps of one implicit step; bisection alone needs about 60
TOLERANCE = 1e-9  # N.m, and relative, of the torque of an implicit step


@dataclass(frozen=True)
class CoupledStep:
    """One step of the plant and the FMU together.

    Attributes
    ----------
    torque
        Torque on the shaft [N.m]: of an implicit step that of the whole step, of an explicit step that at its
        beginning.
    motion : Motion at the end of the step.
    fmu_steps : Steps that the FMU made, those that were taken back included.
    stability : Of an explicit step in which the cam slid throughout, else None.
    """

    torque: float
    motion: ShaftMotion
    fmu_steps: int
    stability: LoopStability | None = None


class PlantCoupling:
    """A plant in Python that acts on the shaft of the forward FMU.

    Put the plant's inertia into `inertia.shaft` where you can: both couplings then are more exact, and stick,
    slip and stops act on the whole inertia. See docs/couple-own-plant.md.

    Parameters
    ----------
    fmu : The forward FMU, started.
    plant
        Torque of the plant on the shaft [N.m]. All that depends on the motion at once belongs inside, also a
        controller's voltage. The function is called several times per step, so the function must not change
        the plant's own states. Change those after the step, from the step's result.

    Raises
    ------
    CouplingError
        `fmu` is not the forward FMU, whose input is the torque, or `plant` is no function.

    Examples
    --------
    >>> from dualcam import Fmu
    >>> with Fmu("forward") as fmu:
    ...     fmu.start({"inertia.shaft": 0.15})
    ...     coupling = PlantCoupling(fmu, lambda shaft: 6.0 - 0.5 * shaft.omega)
    ...     result = coupling.step_implicit(1e-3)
    >>> round(result.motion.omega, 4)
    0.0355
    """

    def __init__(self, fmu: Fmu, plant: PlantTorque) -> None:
        if not isinstance(fmu, Fmu):
            raise CouplingError(f'fmu = {fmu!r}: allowed is the forward FMU, started, Fmu("forward")')
        lacking = [name for name in ("tau", *STEP_SENSITIVITIES) if name not in fmu.names]
        if lacking or fmu.variable("tau").causality != "input":
            raise CouplingError(
                f"{fmu.path} is no plant with input tau and step.domega_dtau: allowed is the forward FMU,"
                ' Fmu("forward")'
            )
        if not callable(plant):
            raise CouplingError(
                f"plant = {plant!r}: allowed is a function that gets the motion of the shaft, a ShaftMotion,"
                " and returns the plant's torque [N.m], such as lambda shaft: 6.0 - 0.5 * shaft.omega"
            )
        self.fmu = fmu
        self.plant = plant
        self._tau = fmu.reals("tau")
        self._motion = fmu.reals("theta", "omega", "alpha")
        self._speed = fmu.reals("omega")
        self._sensitivity = fmu.reals(*STEP_SENSITIVITIES)
        self._warned = False
        self._unchecked = 0  # steps until the next check of the loop
        self._checked = False
        self._swings = TorqueSwings(math.inf)
        self._foreseen: float | None = None  # N.m, of the plant at the motion at the end of the last step

    def motion(self) -> ShaftMotion:
        """The motion of the shaft now."""
        theta, omega, alpha = self._motion.read()
        return ShaftMotion(self.fmu.time, theta, omega, alpha)

    @also_called(size="step")
    def step_explicit(self, step: float, order: int = 0) -> CoupledStep:
        """One step with the plant's torque from the motion at the beginning of the step.

        `step`: communication step [s]. `order`: 0: the torque is held. 1, 2: the torque is a straight line, a
        parabola, through the plant's torques at the motion that the FMU's derivatives predict. The error of
        theta is of order `order` + 1 in the step where the motion is smooth. CouplingError: if the plant
        returns no finite number, or changes when it is called, or if `step` or `order` is not allowed.

        Warns
        -----
        UnstableCouplingWarning
            Once per object, where the loop is unstable with this step, or with any step, or where feedback
            that is computed outside the plant makes the torque go up and down without decay. The text has the
            numbers, and what works.
        """
        step = check_positive("step", step, "s")
        check_order(order)
        begin = self._begin(step)
        jerk = self._speed.read_derivatives(2)[0] if order == 2 else 0.0
        polynomial = torque_polynomial(self._plant_torque, begin, jerk, step, order)
        self._advance(step, polynomial[: order + 1])
        stability = self._stability(begin, step, order)
        if stability and not stability.stable:
            self._warn(str(stability))
        return self._finished(begin, CoupledStep(polynomial[0], self.motion(), 1, stability))

    @also_called(size="step")
    def step_implicit(self, step: float, end_weight: float = 0.5) -> CoupledStep:
        """One step with the torque that suits the motion over the same step, by Newton's method.

        The FMU makes the step, its interface Jacobian corrects the torque, the FMU's state is restored and
        the step is made again, until the torque of the FMU and of the plant agree. Where the plant is linear
        and no event falls into the step, the second trial is exact.

        Parameters
        ----------
        step : Communication step [s].
        end_weight
            The plant gets the angle and the speed of the beginning of the step times 1 - end_weight plus
            those of the end times end_weight, and the mean acceleration. 0.5: the mean, an error of second
            order. 1: the end, an error of first order, but a stiff damper does not ring. Allowed is 0.5 to 1.

        Returns
        -------
        CoupledStep

        Warns
        -----
        UnstableCouplingWarning
            Once per object, where the loop is unstable with any step, as with a controller of the wrong
            sign, or where feedback that is computed outside the plant makes the torque go up and down without
            decay.

        Raises
        ------
        CouplingError
            If no torque is found: then the plant drives its own motion on. If the plant returns no finite
            number, or changes when it is called, or if an argument is not allowed. The FMU is then as before
            the step.
        """
        step = check_positive("step", step, "s")
        if not 0.5 <= number_of(end_weight, "end_weight", "0.5 to 1", CouplingError) <= 1.0:
            raise CouplingError(f"end_weight = {end_weight}: allowed is 0.5 to 1")
        state, begin, torque = self.fmu.save_state(), self._begin(step), self._tau.read()[0]
        bracket = _Bracket()
        try:
            for trial in range(1, ITERATIONS + 1):
                if trial > 1:
                    self.fmu.restore_state(state)
                self._advance(step, [torque])
                end = self.motion()
                residual, slope = self._residual(torque, begin, end, step, end_weight)
                bracket.add(torque, residual)
                allowed = TOLERANCE * max(1.0, abs(torque))
                if abs(residual) <= allowed or bracket.width <= 1e-4 * allowed:
                    self._warn(self._loop_text(begin, step))
                    return self._finished(begin, CoupledStep(torque, end, trial))
                torque = bracket.next_trial(torque, residual, slope)
        except BaseException:  # also what the plant itself raises
            self.fmu.restore_state(state)
            raise
        self.fmu.restore_state(state)
        raise CouplingError(
            f"time = {begin.time:.9g} s: no torque suits the plant within {ITERATIONS} trials. At"
            f" {torque:.6g} N.m the plant differs by {residual:.3g} N.m. Allowed is a plant whose torque"
            " falls as the speed rises; a smaller step may help"
        )

    def _residual(
        self, torque: float, begin: ShaftMotion, end: ShaftMotion, step: float, weight: float
    ) -> tuple[float, float]:
        """The torque less the plant's at the motion of this trial [N.m], and its derivative by the torque."""
        dtheta, domega, _ = self._sensitivity.read()
        motion = ShaftMotion(
            begin.time + weight * step,
            begin.theta + weight * (end.theta - begin.theta),
            begin.omega + weight * (end.omega - begin.omega),
            (end.omega - begin.omega) / step,
        )
        shift = DIFFERENCE * max(1.0, abs(torque))
        shifted = ShaftMotion(
            motion.time,
            motion.theta + shift * weight * dtheta,
            motion.omega + shift * weight * domega,
            motion.alpha + shift * domega / step,
        )
        plant = self._plant_torque(motion)
        return torque - plant, 1.0 - (self._plant_torque(shifted) - plant) / shift

    def _begin(self, step: float) -> ShaftMotion:
        """The motion now. CouplingError before the first step if the plant changes when it is called; a
        warning if feedback outside of the plant makes the loop unstable."""
        begin = self.motion()
        if not self._checked:
            first, second = self._plant_torque(begin), self._plant_torque(begin)
            if first != second:
                raise CouplingError(
                    f"the plant returns {first:.6g} N.m and {second:.6g} N.m at the same motion: allowed is a"
                    " function that changes no state and uses no random numbers. Change the plant's own"
                    " states after the step"
                )
            self._swings = TorqueSwings(self.fmu.real("stop.upper") - self.fmu.real("stop.lower"))
            self._checked = True
        if self._foreseen is not None:
            torque = self._plant_torque(begin)
            if torque != self._foreseen:
                self._warn(held_feedback_text(self._swings, step, self._foreseen, torque), stacklevel=5)
        return begin

    def _finished(self, begin: ShaftMotion, step: CoupledStep) -> CoupledStep:
        """The step, after a look at the torques so far."""
        self._swings.add(step.torque, step.motion.theta - begin.theta)
        suspicious = not self._warned and self._swings.are_unstable
        self._foreseen = self._plant_torque(step.motion) if suspicious else None
        return step

    def _warn(self, text: str, stacklevel: int = 4) -> None:
        """Once per object; nothing where the text is empty."""
        if text and not self._warned:
            self._warned = True
            warnings.warn(text, UnstableCouplingWarning, stacklevel)

    def _plant_torque(self, motion: ShaftMotion) -> float:
        returned = self.plant(motion)
        try:
            torque = float(real_array(returned, "the torque").item())
        except ValueError:  # as for an array of several elements
            torque = math.nan
        if not math.isfinite(torque):
            raise CouplingError(
                f"the plant returns {returned!r} at {motion}: allowed is a finite number [N.m]"
            )
        return torque

    def _advance(self, step: float, polynomial: list[float]) -> None:
        """Step with the torque and its time derivatives at the beginning of the step."""
        self._tau.values[:] = polynomial[0]
        self._tau.write()
        for order, derivative in enumerate(polynomial[1:], start=1):
            self._tau.write_derivatives(order, [derivative])
        self.fmu.step(step)

    def _stability(self, begin: ShaftMotion, step: float, order: int) -> LoopStability | None:
        """Of the latest step. None where the cam did not slide throughout."""
        cam = self._cam(step)
        if cam is None:
            return None
        plant = impedance_of(self._plant_torque, begin)
        radius = spectral_radius(step, cam.inertia, plant, order, cam.damping)
        return LoopStability(step, cam.inertia, plant, order, radius, cam.damping, cam.stiffness)

    def _cam(self, step: float) -> Impedance | None:
        """The cam in the latest step. None where the cam did not slide throughout."""
        dtheta_dtau, domega_dtau, domega_dtheta = self._sensitivity.read()
        found = cam_of_step(step, dtheta_dtau, domega_dtau)
        if found is None:
            return None
        inertia, damping = found
        return Impedance(-domega_dtheta / domega_dtau, damping, inertia)

    def _loop_text(self, begin: ShaftMotion, step: float) -> str:
        """A warning if the loop is unstable with any step: of the first step in slip and of some after it."""
        self._unchecked -= 1
        if self._unchecked > 0 or self._warned or (cam := self._cam(step)) is None:
            return ""
        self._unchecked = CHECKED
        return unstable_loop_text(step, cam, impedance_of(self._plant_torque, begin))


def step_difference(run: Callable[[float], ArrayLike], step: float) -> float:
    """The largest difference between a run and one of ten times shorter steps, in the unit of what `run`
    returns.

    An error of first order in the step is 10/9 of this difference.

    `run`: makes the whole run from its start with that step [s]. Returns what is compared, such as the angle:
    at the end, at instants that do not depend on the step, or after each step (or at the start and after each
    step), along the first axis. `step`: communication step [s]. CouplingError: `step` is not allowed, or what
    the runs return is not finite or does not fit together.

    Examples
    --------
    >>> from dualcam import Fmu
    >>> def run(step):
    ...     with Fmu("forward") as fmu:
    ...         fmu.start({"inertia.shaft": 0.15})
    ...         coupling = PlantCoupling(fmu, lambda shaft: 6.0 - 0.5 * shaft.omega)
    ...         return [coupling.step_explicit(step).motion.theta for _ in range(round(0.2 / step))]
    >>> round(step_difference(run, 2e-3), 5)  # rad
    0.001
    """
    step = check_positive("step", step, "s")
    whole, fine = (np.asarray(run(size), dtype=float) for size in (step, 0.1 * step))
    if fine.ndim and whole.ndim:
        fine = _at_instants_of(whole, fine)
    if whole.shape != fine.shape or not whole.size:
        raise CouplingError(
            f"the run with the step {step:g} s returns the shape {whole.shape}, that with a tenth of it"
            f" {fine.shape}: allowed are equal shapes, or one row after each step"
        )
    largest = float(np.abs(fine - whole).max())
    if not math.isfinite(largest):
        raise CouplingError("a run returns values that are not finite: allowed are finite numbers")
    return largest


def _at_instants_of(whole: Array, fine: Array) -> Array:
    """Those rows of a run with a tenth of the step that are at the instants of the whole run, if any."""
    if len(fine) == 10 * len(whole):
        return fine[9::10]
    if len(fine) == 10 * (len(whole) - 1) + 1:
        return fine[::10]
    return fine


class _Bracket:
    """The torques between which the residual passes zero upwards.

    For a passive plant the residual rises with the torque by at least 1 N.m per N.m, except where an impact
    at the end of the step makes it fall. So the residual has a zero, which bisection finds where
    Newton's method does not."""

    def __init__(self) -> None:
        self.low, self.high = -math.inf, math.inf
        self._before = math.inf
        self._reach = 1.0

    @property
    def width(self) -> float:
        return self.high - self.low

    def add(self, torque: float, residual: float) -> None:
        if residual < 0.0:
            self.low = torque
        else:
            self.high = torque

    def next_trial(self, torque: float, residual: float, slope: float) -> float:
        """By Newton's method, or by bisection where Newton's method leaves the bracket or is slow."""
        slow, self._before = abs(residual) > 0.5 * self._before, abs(residual)
        trial = torque - residual / slope if slope > 0.0 else math.nan
        if math.isfinite(self.width):
            return trial if self.low < trial < self.high and not slow else 0.5 * (self.low + self.high)
        if slope > 0.0 and not slow:
            return trial
        self._reach *= 2.0  # for a passive plant the zero is not farther than the residual
        return torque - self._reach * residual
