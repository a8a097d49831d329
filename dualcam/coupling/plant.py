"""Plants on the shaft of the forward FMU, and when explicit coupling with them is stable.

Explicit coupling with a plant tau = tau_0 - K theta - D omega - M alpha maps the errors of one communication
step to those of the next step. The coupling is stable where the spectral radius of that map is at most 1.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from dualcam.common.arrays import Array, number_of, positive_number
from dualcam.errors import CouplingError

LARGEST_RADIUS = 1.001  # without a warning: errors that grow less than e times in 1000 steps
ROUNDING = 1e-11  # of the spectral radius
LEAST_RATIO = 0.5001  # of the interface Jacobian, from which on damping of the cam is told from rounding
LARGEST_DAMPING = 50.0  # B h/J that is told from a cam without inertia
DIFFERENCE = 1e-6  # rad, rad/s, rad/s2, and relative: shift of the motion for the plant's derivatives


class ShaftMotion(NamedTuple):
    """The motion of cam 2's shaft, where the plant acts.

    `time` [s]. `theta`, `omega`, `alpha`: angle [rad], speed [rad/s], acceleration [rad/s2].
    """

    time: float
    theta: float
    omega: float
    alpha: float


PlantTorque = Callable[[ShaftMotion], float]  # N.m on the shaft, + in the direction of theta


class Impedance(NamedTuple):
    """What a plant opposes to the motion: minus the derivatives of its torque.

    `stiffness`: -d tau/d theta [N.m/rad]. `damping`: -d tau/d omega [N.m.s/rad]. `inertia`: -d tau/d alpha
    [kg.m2].
    """

    stiffness: float = 0.0
    damping: float = 0.0
    inertia: float = 0.0


def reflected_inertia(gear_ratio: float, rotor_inertia: float) -> float:
    """Inertia N^2 J_rotor of a rotor behind its gear [kg.m2], to be added to the FMU's `inertia.shaft`.

    `gear_ratio`: N, turns of the rotor per turn of the shaft [1]. `rotor_inertia`: J_rotor [kg.m2].
    CouplingError: if a value is not finite, or the inertia is negative. The rotor turns N times as fast, so
    its kinetic energy is 1/2 J_rotor (N omega)^2.

    Examples
    --------
    >>> round(reflected_inertia(50.0, 6.07e-5), 6)
    0.15175
    """
    ratio = number_of(gear_ratio, "gear_ratio", error=CouplingError)
    return number_not_negative("rotor_inertia", rotor_inertia, "kg.m2") * ratio**2


def impedance_of(plant: PlantTorque, motion: ShaftMotion) -> Impedance:
    """Stiffness, damping and inertia of a plant at a motion, by central differences.

    `plant`: torque on the shaft [N.m]. `motion`: where the differences are taken.

    Examples
    --------
    >>> found = impedance_of(lambda shaft: 3.0 - 0.5 * shaft.omega, ShaftMotion(0.0, 0.1, 2.0, 0.0))
    >>> round(found.damping, 6)
    0.5
    """

    def slope(name: str) -> float:
        value = getattr(motion, name)
        shift = DIFFERENCE * max(1.0, abs(value))
        above, below = (motion._replace(**{name: value + sign * shift}) for sign in (1, -1))
        return (plant(below) - plant(above)) / (2.0 * shift)

    return Impedance(slope("theta"), slope("omega"), slope("alpha"))


def spectral_radius(
    step: float,
    inertia: float,
    plant: Impedance,
    order: int = 0,
    cam_damping: float = 0.0,
    *,
    plant_is_fmu: bool = False,
) -> float:
    """Factor by which errors grow per step of explicit coupling, in the long run.

    Parameters
    ----------
    step : Communication step h [s].
    inertia : Inertia J of the cam as the shaft feels it while it slides [kg.m2].
    plant : Of the plant at the shaft.
    order : 0: the torque is held over the step; 1, 2: the torque is a straight line, a parabola.
    cam_damping : Viscous damping B of the cam itself, as the shaft feels it [N.m.s/rad].
    plant_is_fmu
        True: the plant is an FMU of its own, as in an SSP package. The master gives it the speed at the
        beginning of a step, and the cam gets the torque at the end of that step: one step later than from
        `PlantCoupling`. The torque is held, so `order` is 0.

    Returns
    -------
    float
        Largest magnitude of the eigenvalues of the loop [1]. At most 1: stable. An error of the angle stays
        as it is where the plant has no stiffness: then 1 is the least.

    Notes
    -----
    The loop is that of `PlantCoupling.step_explicit` with tau = -K theta - D omega - M alpha and
    J alpha = tau - B omega. Its state is theta, omega, alpha and the slope of alpha. The cam's own spring is
    left out, so the step must be short compared with the period of the cam's own oscillation. Friction that
    takes energy out of the loop is left out too.

    Examples
    --------
    Damping alone: 1 - D h/J.

    >>> round(spectral_radius(1e-3, 0.002, Impedance(damping=5.0)), 6)
    1.5
    """
    _check_impedance(plant)
    return _largest(_loop(step, inertia, plant, order, cam_damping, plant_is_fmu))


def _largest(loop: Array) -> float:
    """Largest magnitude of the eigenvalues."""
    return float(np.abs(np.linalg.eigvals(loop)).max())


def _loop(
    step: float, inertia: float, plant: Impedance, order: int, cam_damping: float, plant_is_fmu: bool
) -> Array:
    """Maps theta, omega, alpha, the slope of alpha, and the plant's torque to those a step later."""
    step = check_positive("step", step, "s")
    inertia = check_positive("inertia", inertia, "kg.m2")
    check_order(order)
    cam_damping = number_not_negative("cam_damping", cam_damping, "N.m.s/rad")
    if plant_is_fmu and order:
        raise CouplingError(f"order = {order}: allowed is 0 where the plant is an FMU, whose torque is held")
    propagator = _propagator(step, inertia, cam_damping)

    def torque(motion: ShaftMotion) -> float:
        return -plant.stiffness * motion.theta - plant.damping * motion.omega - plant.inertia * motion.alpha

    def next_state(theta: float, omega: float, alpha: float, jerk: float, before: float) -> list[float]:
        begin = ShaftMotion(0.0, theta, omega, alpha)
        now = torque_polynomial(torque, begin, jerk, step, order)
        acting = [before, 0.0, 0.0] if plant_is_fmu else now
        theta, omega, tau, slope, _ = propagator @ [theta, omega, *acting]
        alpha = (tau - cam_damping * omega) / inertia
        return [theta, omega, alpha, (slope - cam_damping * alpha) / inertia, now[0]]

    return np.array([next_state(*row) for row in np.eye(5).tolist()]).T


def _propagator(step: float, inertia: float, damping: float) -> Array:
    """Maps theta, omega, tau, its slope and bend to those at the end of the step, J omega' = tau - B omega.

    With x = B h/J and phi_k = sum of (-x)^n/(n + k)!, the integral of exp(-B (h - s)/J) s^k/k! over the step
    is h^(k + 1) phi_(k + 1)."""
    phi = _phi(damping * step / inertia)
    gain, powers = step / inertia, step ** np.arange(3)
    return np.array(
        [
            [1.0, step * phi[1], *(step * gain * powers * phi[2:])],
            [0.0, phi[0], *(gain * powers * phi[1:4])],
            [0.0, 0.0, 1.0, step, step**2 / 2.0],
            [0.0, 0.0, 0.0, 1.0, step],
            [0.0, 0.0, 0.0, 0.0, 1.0],
        ]
    )


def _phi(x: float) -> Array:
    """phi_0 to phi_4 at x >= 0: the series of phi_4 where x is small, else phi_(k + 1) = (1/k! - phi_k)/x."""
    found = np.array([math.exp(-x), 0.0, 0.0, 0.0, 0.0])
    if x < 1.0:
        found[4] = math.fsum((-x) ** n / math.factorial(n + 4) for n in range(16))
        for k in (3, 2, 1):
            found[k] = 1.0 / math.factorial(k) - x * found[k + 1]
        return found
    for k in range(4):
        found[k + 1] = (1.0 / math.factorial(k) - found[k]) / x
    return found


def cam_of_step(step: float, dtheta_dtau: float, domega_dtau: float) -> tuple[float, float] | None:
    """Inertia J [kg.m2] and viscous damping B [N.m.s/rad] of the cam, from a step's interface Jacobian.

    Both are as the shaft feels them. None where the cam did not slide throughout the step. `step`:
    communication step h [s]. `dtheta_dtau`, `domega_dtau`: `step.dtheta_dtau` [rad/(N.m)] and
    `step.domega_dtau` [rad/(N.m.s)] after that step.

    Notes
    -----
    With x = B h/J an inertia with damping has domega_dtau = (1 - exp(-x))/B and
    dtheta_dtau/(h domega_dtau) = (x - 1 + exp(-x))/(x (1 - exp(-x))), which rises from 1/2 to 1. The cam's
    own spring acts over the step, too, and is a small part of B.

    Examples
    --------
    >>> cam_of_step(1e-3, 0.25e-3, 0.5)
    (0.002, 0.0)
    """
    ratio = dtheta_dtau / (step * domega_dtau) if domega_dtau > 0.0 else 0.0
    if not 0.45 < ratio < 1.05:  # 0.45: the cam's own spring makes the ratio a little less than 1/2
        return None
    if ratio <= LEAST_RATIO:
        return step / domega_dtau, 0.0

    def excess(x: float) -> float:
        return (x - 1.0 + math.exp(-x)) / (x * -math.expm1(-x)) - ratio

    x = LARGEST_DAMPING if excess(LARGEST_DAMPING) <= 0.0 else brentq(excess, 1e-3, LARGEST_DAMPING)
    damping = -math.expm1(-x) / domega_dtau
    return damping * step / x, damping


def largest_stable_step(
    inertia: float, plant: Impedance, order: int = 0, cam_damping: float = 0.0, *, plant_is_fmu: bool = False
) -> float:
    """Communication step [s] up to which explicit coupling is stable, from 1e-9 to 1 s, else 0 or infinity.

    It is 0 where no step of that range is stable, infinity where all steps are. Stable means that no error
    grows, however slowly. So the answer is 0 for a held spring without damping.

    `inertia` J of the cam as the shaft feels it [kg.m2]. `plant`: of the plant at the shaft. `order`,
    `cam_damping`, `plant_is_fmu`: as in `spectral_radius`.

    Examples
    --------
    Damping alone: 2 J/D, and half of that where the plant is an FMU of its own.

    >>> round(largest_stable_step(0.002, Impedance(damping=5.0)), 6)
    0.0008
    >>> round(largest_stable_step(0.002, Impedance(damping=5.0), plant_is_fmu=True), 6)
    0.0004
    """
    _check_impedance(plant)
    # Without stiffness an error of the angle stays, without damping that of the speed, too.
    staying = 0 if plant.stiffness else 1 if plant.damping or cam_damping else 2

    def growth(step: float) -> float:
        loop = _loop(step, inertia, plant, order, cam_damping, plant_is_fmu)
        return _largest(loop[staying:, staying:]) - 1.0

    steps = np.geomspace(1e-9, 1.0, 181).tolist()
    first = next((k for k, step in enumerate(steps) if growth(step) > ROUNDING), None)
    if first is None:
        return math.inf
    # At the step before, errors may grow more slowly than rounding lets see. There they do not decay.
    if first == 0 or growth(steps[first - 1]) > -ROUNDING:
        return 0.0
    low, high = steps[first - 1], steps[first]
    while high - low > 1e-9 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if growth(middle) < -ROUNDING else (low, middle)
    return float(low)


def loop_growth(step: float, cam: Impedance, plant: Impedance) -> float:
    """Factor by which an error grows per step [1] in the loop of cam and plant itself, solved exactly.

    The loop is (J + M) alpha + (B + D) omega + (k + K) theta = 0, the cam with stiffness k. It is 1 where the
    plant has no part in the instability: where each impedance of the plant is >= 0, or that of the cam more.
    """
    sums = [own + other for own, other in zip(cam, plant, strict=True)]
    if not any(own < 0.0 and total < 0.0 for own, total in zip(plant, sums, strict=True)):
        return 1.0
    stiffness, damping, inertia = sums
    if inertia <= 0.0:
        return math.inf
    rate = float(np.roots([inertia, damping, stiffness]).real.max())
    return math.exp(min(step * rate, 700.0))


def unstable_loop_text(step: float, cam: Impedance, plant: Impedance) -> str:
    """The warning about a loop that is unstable whatever the step [s] is; "" where none is due."""
    growth = loop_growth(step, cam, plant)
    if growth <= LARGEST_RADIUS:
        return ""
    return (
        "the loop of plant and cam is itself unstable, no step makes it stable: errors change"
        f" {growth:.4g} times per {step:g} s. {impedance_words(cam, plant)} Is the sign of the controller"
        " right? Its torque must fall as theta and omega rise. Where the machine itself is unstable, such as"
        " with a load beyond its top, the motion is that of the machine."
    )


def impedance_words(cam: Impedance, plant: Impedance) -> str:
    """The impedances of both sides of the loop."""
    return (
        f"The plant has stiffness {plant.stiffness:.4g} N.m/rad, damping {plant.damping:.4g} N.m.s/rad,"
        f" inertia {plant.inertia:.4g} kg.m2. As the step tells, the cam has stiffness {cam.stiffness:.4g}"
        f" N.m/rad, inertia {cam.inertia:.4g} kg.m2 and, with its spring, viscous damping {cam.damping:.4g}"
        " N.m.s/rad."
    )


@dataclass(frozen=True)
class LoopStability:
    """Whether explicit coupling is stable, from the latest step.

    Attributes
    ----------
    step : Communication step [s].
    inertia, cam_damping, cam_stiffness
        Inertia [kg.m2], viscous damping [N.m.s/rad], stiffness [N.m/rad] of the cam as the shaft feels them.
    plant : Of the plant, at the beginning of the step.
    order : Order of the torque's polynomial.
    spectral_radius : Factor by which errors grow per step [1].
    """

    step: float
    inertia: float
    plant: Impedance
    order: int
    spectral_radius: float
    cam_damping: float = 0.0
    cam_stiffness: float = 0.0

    @property
    def stable(self) -> bool:
        """Whether errors do not grow, or less than e times in 1000 steps."""
        return self.spectral_radius <= LARGEST_RADIUS

    def __str__(self) -> str:
        cam = Impedance(self.cam_stiffness, self.cam_damping, self.inertia)
        verdict = "stable" if self.stable else "unstable"
        text = (
            f"explicit coupling with a step of {self.step:g} s is {verdict}: errors change"
            f" {self.spectral_radius:.4g} times per step, allowed is 1. {impedance_words(cam, self.plant)}"
        )
        if self.stable:
            return text
        if itself := unstable_loop_text(self.step, cam, self.plant):
            return itself
        without_inertia = self.cam_damping * self.step >= 0.99 * LARGEST_DAMPING * self.inertia
        allowed = largest_stable_step(self.inertia, self.plant, self.order, self.cam_damping)
        allowed = 0.0 if without_inertia else allowed  # then the step does not matter
        smaller = f"steps up to {allowed:.3g} s, or " if allowed > 0.0 else ""
        return (
            f"{text} What works: {smaller}step_implicit. Rotor inertia belongs into inertia.shaft, times the"
            " square of the gear ratio (reflected_inertia)."
        )


def torque_polynomial(
    plant: PlantTorque, begin: ShaftMotion, jerk: float, step: float, order: int
) -> list[float]:
    """The plant's torque over the step from the motion predicted by derivatives up to `order`: value, first
    and second time derivative at the beginning of the step."""

    def at(share: float) -> float:
        s = share * step
        if order == 1:
            motion = ShaftMotion(
                begin.time + s, begin.theta + s * begin.omega, begin.omega + s * begin.alpha, begin.alpha
            )
        else:
            motion = ShaftMotion(
                begin.time + s,
                begin.theta + s * (begin.omega + s * begin.alpha / 2.0),
                begin.omega + s * (begin.alpha + s * jerk / 2.0),
                begin.alpha + s * jerk,
            )
        return plant(motion)

    first = at(0.0)
    if order == 0:
        return [first, 0.0, 0.0]
    last = at(1.0)
    if order == 1:
        return [first, (last - first) / step, 0.0]
    middle = at(0.5)
    return [
        first,
        (4.0 * middle - 3.0 * first - last) / step,
        4.0 * (first - 2.0 * middle + last) / step**2,
    ]


def _check_impedance(plant: Impedance) -> None:
    if not isinstance(plant, Impedance):
        raise CouplingError(f"plant = {plant!r}: allowed is an Impedance, of stiffness, damping and inertia")
    for name, value in plant._asdict().items():
        number_of(value, name, error=CouplingError)


def check_positive(name: str, value: object, unit: str) -> float:
    """`value` as a number, or a CouplingError."""
    return positive_number(value, name, f"a finite number > 0, in {unit}", CouplingError)


def number_not_negative(name: str, value: object, unit: str) -> float:
    """`value` as a number, or a CouplingError."""
    allowed = f"a finite number >= 0, in {unit}"
    number = number_of(value, name, allowed, CouplingError)
    if number < 0.0:
        raise CouplingError(f"{name} = {value!r}: allowed is {allowed}")
    return number


def check_order(order: int) -> None:
    if order not in (0, 1, 2):
        raise CouplingError(f"order = {order}: allowed are 0 (held), 1 (straight line) and 2 (parabola)")
