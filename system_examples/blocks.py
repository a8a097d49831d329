"""Building blocks of the system examples: a motor and its current loop, a gravity load, a motion, the helical
dual cam's statics as a designer and a controller know them, and a position controller's gains.

SI units. Angles are those of the output shaft; cam 2 turns with it, + loads the spring.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import control
import numpy as np

# The accounts of the FMU that the examples keep
LEDGER = (
    "energy.work_in",
    "energy.spring",
    "energy.kinetic",
    "energy.heat_cam1",
    "energy.heat_cam2",
    "energy.heat_damper",
    "energy.heat_stop",
    "energy.residual",
)


@dataclass(frozen=True)
class Motor:
    """A brushless motor with a gear, as one equivalent DC winding: v = R i + L di/dt + Kt gear omega.

    The gear is rigid and loses nothing; `inertia` is the rotor's as the output shaft feels it.
    """

    resistance: float  # ohm
    inductance: float  # H
    torque_constant: float  # N.m/A at the rotor, and V.s/rad
    rotor_inertia: float  # kg.m2
    gear: float  # rotor turns per output turn
    voltage: float  # V, most the drive can apply
    peak_torque: float  # N.m at the output
    rated_torque: float  # N.m at the output, without end
    peak_speed: float  # rad/s at the output

    @property
    def output_constant(self) -> float:
        """Torque per ampere at the output, N.m/A."""
        return self.torque_constant * self.gear

    @property
    def inertia(self) -> float:
        """Rotor inertia at the output, kg.m2."""
        return self.rotor_inertia * self.gear**2

    @property
    def electrical_time(self) -> float:
        """L/R, s."""
        return self.inductance / self.resistance

    def behind(self, ratio: float) -> Motor:
        """The same motor behind another gear, which turns `ratio` times as slowly and loses nothing."""
        return replace(
            self,
            gear=self.gear * ratio,
            peak_torque=self.peak_torque * ratio,
            rated_torque=self.rated_torque * ratio,
            peak_speed=self.peak_speed / ratio,
        )


@dataclass(frozen=True)
class Tick:
    """What a motor did in one control tick."""

    torque: float  # N.m at the output, mean
    peak_torque: float  # N.m at the output, largest magnitude
    heat: float  # J, integral of R i^2
    energy: float  # J, integral of v i: what the supply gave


class CurrentLoop:
    """A motor under a PI current loop that runs many times within a tick of the position loop.

    Between two samples of the PI the voltage is constant, so the winding's response is an exponential: with
    a = exp(-R Ts/L) the samples obey i' = a i + (1 - a)/R (v - Kt gear omega), and the integrals of i and i^2
    are closed forms too. Nothing is integrated numerically. The speed is taken as constant over the tick; its
    voltage is fed forward.

    Design, on the sampled winding b/(z - a), b = (1 - a)/R: the PI's zero cancels the winding's pole and its
    gain puts the one pole that remains at exp(-2 pi bandwidth Ts). A step r of the reference is answered by
    i_k = r (1 - exp(-2 pi bandwidth k Ts)), without overshoot: limiting the reference limits the current.
    """

    def __init__(self, motor: Motor, bandwidth: float, rate: float, tick: float) -> None:
        """`bandwidth` and `rate` of the current loop in Hz, `tick` of the loop around it in s."""
        self.motor = motor
        self.samples = round(tick * rate)
        self.period = tick / self.samples  # s
        self.pole = math.exp(-self.period / motor.electrical_time)  # a
        self.closed_pole = math.exp(-2.0 * math.pi * bandwidth * self.period)
        self.proportional = (1.0 - self.closed_pole) * motor.resistance / (1.0 - self.pole)  # V/A
        self.integral = self.proportional * (1.0 - self.pole)  # V/A per sample
        self.current = 0.0  # A
        self._voltage = 0.0  # V, the PI's integral part

    def run(self, torque: float, speed: float) -> Tick:
        """One tick towards `torque` [N.m] at the output while the output turns at `speed` [rad/s]."""
        motor = self.motor
        torque = min(max(torque, -motor.peak_torque), motor.peak_torque)
        reference = torque / motor.output_constant
        back_emf = motor.output_constant * speed
        highest, lowest = motor.voltage - back_emf, -motor.voltage - back_emf  # V over the winding
        pole, period, gain, resistance = self.pole, self.period, self.proportional, motor.resistance
        decay = motor.electrical_time * (1.0 - pole)  # s, integral of the winding's response from 1 to 0
        decay_square = 0.5 * decay * (1.0 + pole)  # s, of its square
        current, held, peak = self.current, self._voltage, abs(self.current)
        charge = square = energy = 0.0  # integrals of i, i^2 and v i
        for _ in range(self.samples):
            error = reference - current
            voltage = gain * error + held
            if voltage > highest:
                voltage = highest
            elif voltage < lowest:
                voltage = lowest
            else:  # beyond the limits the integral part would wind up
                held += self.integral * error
            final = voltage / resistance
            start = current - final
            tail = start * decay
            area = final * period + tail
            charge += area
            square += final * (area + tail) + start * start * decay_square
            energy += (voltage + back_emf) * area
            current = final + start * pole
            if current > peak or -current > peak:
                peak = abs(current)
        self.current, self._voltage = current, held
        duration = period * self.samples
        return Tick(
            torque=motor.output_constant * charge / duration,
            peak_torque=motor.output_constant * peak,
            heat=motor.resistance * square,
            energy=energy,
        )


@dataclass(frozen=True)
class GravityLoad:
    """A mass on an arm that leans `lean` from upright at theta = 0 and falls as theta grows."""

    moment: float  # kg.m, mass times distance of its centre from the axis
    lean: float  # rad
    gravity: float = 9.81  # m/s2

    def torque(self, theta: float) -> float:
        """Torque about the axis [N.m], + in the direction of theta: the arm's fall loads the spring."""
        return self.moment * self.gravity * math.sin(self.lean + theta)

    def energy(self, theta: float) -> float:
        """Potential energy [J]: 0 with the arm horizontal."""
        return self.moment * self.gravity * math.cos(self.lean + theta)


@dataclass(frozen=True)
class PickAndPlace:
    """A cycle: rest at `start`, go to `end`, rest there, go back.

    Both moves are of minimum jerk, a quintic in time: rest to rest with zero acceleration at both ends.
    """

    start: float  # rad
    end: float  # rad
    move: float  # s, duration of one move
    dwell: float  # s, duration of one rest

    @property
    def period(self) -> float:
        """Duration of a cycle, s."""
        return 2.0 * (self.move + self.dwell)

    @property
    def peak_speed(self) -> float:
        """rad/s: 15/8 of the mean speed of a move."""
        return 1.875 * abs(self.end - self.start) / self.move

    @property
    def peak_acceleration(self) -> float:
        """rad/s2: 10/sqrt(3) of a move's length over its time squared."""
        return 10.0 / math.sqrt(3.0) * abs(self.end - self.start) / self.move**2

    def sample(self, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Angle [rad] and speed [rad/s] at these times [s]."""
        phase = np.mod(time, self.period)
        half = self.move + self.dwell
        there = phase < half
        s = np.clip((np.where(there, phase, phase - half) - self.dwell) / self.move, 0.0, 1.0)
        way = s**3 * (10.0 + s * (6.0 * s - 15.0))
        rate = 30.0 * s**2 * (1.0 - s) ** 2 / self.move
        length = self.end - self.start
        theta = np.where(there, self.start + length * way, self.end - length * way)
        omega = np.where(there, length * rate, -length * rate)
        return theta, omega


@dataclass(frozen=True)
class HelixCam:
    """Statics of the dual cam with two helical grooves and a linear spring, friction at both contacts."""

    radius: tuple[float, float]  # m, cams 1 and 2
    lead_angle: tuple[float, float]  # rad
    friction: tuple[float, float]  # Coulomb coefficients
    preload: float = 0.0  # N
    stiffness: float = 0.0  # N/m

    @cached_property
    def lift(self) -> float:
        """dz/dtheta, m/rad: a1 a2/(a1 + a2) with a_i = r_i tan(lambda_i)."""
        a1, a2 = (r * math.tan(lead) for r, lead in zip(self.radius, self.lead_angle, strict=True))
        return a1 * a2 / (a1 + a2)

    def _arm(self, direction: float) -> float:
        """Torque per axial force [m] while moving in `direction`: 1/(kappa_1 + kappa_2), where
        kappa_i = (1 - direction mu_i s_i)/(r_i (s_i + direction mu_i)) and s_i = tan(lambda_i)."""
        kappa = 0.0
        for r, lead, mu in zip(self.radius, self.lead_angle, self.friction, strict=True):
            slope = math.tan(lead)
            kappa += (1.0 - direction * mu * slope) / (r * (slope + direction * mu))
        return 1.0 / kappa

    @cached_property
    def load_arm(self) -> float:
        """Torque per axial force while loading, m."""
        return self._arm(1.0)

    @cached_property
    def release_arm(self) -> float:
        """Torque per axial force while releasing, m."""
        return self._arm(-1.0)

    @property
    def efficiency(self) -> float:
        """Share of the loading torque that comes back."""
        return self.release_arm / self.load_arm

    def band(self, theta: float) -> tuple[float, float]:
        """The torques [N.m] that just release and just load at `theta`; any between leaves it at rest."""
        force = self.preload + self.stiffness * self.lift * theta
        return self.release_arm * force, self.load_arm * force

    def torque(self, theta: float, direction: float) -> float:
        """Torque [N.m] that moves it slowly through `theta` in `direction` (+ loads, - releases)."""
        release, load = self.band(theta)
        return load if direction > 0.0 else release

    def parameters(self) -> dict[str, float]:
        """The same mechanism as start values of the FMU."""
        values = {"spring.preload": self.preload, "spring.stiffness": self.stiffness}
        for i in (0, 1):
            values[f"cam{i + 1}.radius"] = self.radius[i]
            values[f"cam{i + 1}.lead_angle"] = self.lead_angle[i]
            values[f"cam{i + 1}.friction"] = self.friction[i]
        return values


def spring_for(
    cam: HelixCam, load: Callable[[float], float], lower: float, upper: float, points: int = 400
) -> HelixCam:
    """`cam` with the spring that puts the middle of the stick band on `load(theta)` [N.m]: least squares over
    the range lower..upper [rad].

    The middle is affine in theta, so both unknowns enter linearly. The deviation is weighed by 1/load: the
    band's width grows with the torque it carries, and only inside the band is a load held for nothing.
    """
    theta = np.linspace(lower, upper, points)
    wanted = np.array([load(angle) for angle in theta])
    middle_arm = 0.5 * (cam.load_arm + cam.release_arm)
    columns = np.column_stack([np.ones(points), theta]) / wanted[:, None]
    (constant, slope), *_ = np.linalg.lstsq(columns, np.ones(points), rcond=None)
    preload, rise = float(constant) / middle_arm, float(slope) / middle_arm  # N, N/rad
    return replace(cam, preload=preload, stiffness=rise / cam.lift)


def lqi_gains(bandwidth: float, period: float) -> tuple[float, float, float]:
    """Gains on angle, speed and integral of the angle's error for a sampled double integrator theta'' = u.

    LQI: the state is extended by the integral of the error, so that a constant disturbance leaves no error,
    and one linear quadratic problem gives all three gains together. Only the integral is weighed,
    q integral^2 + u^2: in continuous time the optimum is then a third-order Butterworth pattern of radius
    w = q^(1/6), with gains 2 w^2, 2 w, w^3. One number, the bandwidth, is the whole tuning, and it holds for
    every inertia M: torque = M u.

    `bandwidth` = w/(2 pi) in Hz, `period` of the samples in s; gains in 1/s2, 1/s, 1/s3.
    """
    w = 2.0 * math.pi * bandwidth
    plant = np.array([[1.0, period], [0.0, 1.0]])
    drive = np.array([[0.5 * period**2], [period]])
    # Scaled time w t keeps the Riccati equation's entries near 1: angle, speed/w, integral w.
    scale = np.diag([1.0, 1.0 / w])
    plant = scale @ plant @ np.linalg.inv(scale)
    drive = scale @ drive * w**2
    gains, _, _ = control.dlqr(
        plant, drive, np.diag([0.0, 0.0, 1.0]), np.eye(1), integral_action=np.array([[w * period, 0.0]])
    )
    angle, speed, integral = gains[0]
    return float(angle) * w**2, float(speed) * w, float(integral) * w**3


def up_in_car(pitch: float, roll: float) -> np.ndarray:
    """The upward vertical in a car's own axes (x to the rear, y to the right, z to the roof), a unit vector.

    `pitch` > 0 lifts the nose, `roll` > 0 lifts the right side [rad]. The car is turned by
    R_x(roll) R_y(pitch); this is the last row.
    """
    return np.array([-math.cos(roll) * math.sin(pitch), math.sin(roll), math.cos(roll) * math.cos(pitch)])


def hinged_load(
    mass: float, hinge: tuple[np.ndarray, np.ndarray], centre: np.ndarray, up: np.ndarray
) -> GravityLoad:
    """The weight of a body [kg] about a tilted hinge, as the pendulum that it is.

    `hinge`: two points of its axis [m]; theta is right-handed about the way from the first to the second.
    `centre`: the body's centre of mass at theta = 0 [m], `up`: the vertical, all in the same axes. With e1
    from the axis to the centre and e2 = axis x e1, both unit vectors, the centre is r up.(e1 cos + e2 sin)
    high: a pendulum that leans atan2(-up.e2, up.e1) from upright, under the part of gravity across the axis.
    """
    first, second = hinge
    axis = (second - first) / np.linalg.norm(second - first)
    arm = np.cross(np.cross(axis, centre - first), axis)
    along, across = float(up @ arm), float(up @ np.cross(axis, arm))  # m
    return GravityLoad(moment=mass * math.hypot(along, across), lean=math.atan2(-across, along))


def holding_torque(band: tuple[float, float], weight: float, margin: float) -> float:
    """The smallest torque that keeps `weight` inside the stick band, `margin` away from its edges [N.m]."""
    return min(max(weight, band[0] + margin), band[1] - margin) - weight


@dataclass(frozen=True)
class Periodic:
    """A periodic function of time as a Fourier series, with its derivatives."""

    coefficients: tuple[float, ...]  # mean, then cosine and sine of each harmonic
    period: float  # s

    def sample(self, time: np.ndarray, order: int = 0) -> np.ndarray:
        """The derivative of that order at these times [s]."""
        total = np.full_like(time, self.coefficients[0] if order == 0 else 0.0)
        pairs = zip(self.coefficients[1::2], self.coefficients[2::2], strict=True)
        for n, (cosine, sine) in enumerate(pairs, start=1):
            rate = 2.0 * math.pi * n / self.period
            angle = rate * time + 0.5 * math.pi * order  # each derivative turns by a quarter and stretches
            total += rate**order * (cosine * np.cos(angle) + sine * np.sin(angle))
        return total


class HingeMotion(NamedTuple):
    """How a hinge moves from which a segment hangs: the inclination of its carrier [rad, + forward from
    straight down] and the hinge's acceleration [m/s2], each with its derivatives."""

    tilt: tuple[float, float, float, float, float]  # derivatives 0 to 4
    forward: tuple[float, float, float]
    upward: tuple[float, float, float]


@dataclass(frozen=True)
class HingedPendulum:
    """A rigid segment that hangs from a hinge on a moving carrier, as the shank hangs from the knee.

    With psi the carrier's inclination, theta the flexion of the hinge, chi = psi - theta + lead the
    inclination of the line from hinge to centre of mass, (a_x, a_y) the hinge's acceleration and M the torque
    that extends the hinge, the moments about the moving hinge balance as

        I chi'' + m d [a_x cos chi + (a_y + g) sin chi] = M

    or I theta'' = drive - M with drive = I psi'' + m d [a_x cos chi + (a_y + g) sin chi].
    """

    inertia: float  # kg.m2, I about the hinge
    moment: float  # kg.m, m d
    lead: float  # rad, how far the centre of mass is ahead of the line that theta is measured to
    gravity: float = 9.81  # m/s2

    def drive(
        self, hinge: HingeMotion, theta: float, omega: float = 0.0, alpha: float = 0.0
    ) -> tuple[float, float, float]:
        """The torque [N.m] that bends the hinge, and its first two time derivatives along a motion with these
        theta [rad], omega [rad/s], alpha [rad/s2]."""
        psi, psi1, psi2, psi3, psi4 = hinge.tilt
        x, x1, x2 = hinge.forward
        y, y1, y2 = hinge.upward
        y += self.gravity
        chi, turn, spin = psi - theta + self.lead, psi1 - omega, psi2 - alpha
        c, s = math.cos(chi), math.sin(chi)
        pull, across = x * c + y * s, y * c - x * s  # across = d pull/d chi
        value = self.inertia * psi2 + self.moment * pull
        first = self.inertia * psi3 + self.moment * (x1 * c + y1 * s + turn * across)
        second = self.inertia * psi4 + self.moment * (
            x2 * c + y2 * s + 2.0 * turn * (y1 * c - x1 * s) + spin * across - turn**2 * pull
        )
        return value, first, second


@dataclass(frozen=True)
class Impedance:
    """A controller that acts like a spring and a damper between a joint and its reference motion."""

    stiffness: float  # N.m/rad
    damping: float  # N.m.s/rad

    def torque(self, error: float, rate: float) -> float:
        """Torque [N.m] for an error of the angle [rad] and of the speed [rad/s], both actual minus wanted."""
        return -self.stiffness * error - self.damping * rate


@dataclass(frozen=True)
class EllipseCam:
    """The dual cam with two equal grooves, elliptical arcs that start steep and flatten, under a spring
    F = k z without preload and a linear damper that acts on the way back.

    Both pins turn by psi = theta/2. With S = S0 - r psi/a and S0 = sin(atan((a/b) tan lambda_0)):
    slope s = (b/a) S/sqrt(1 - S^2), z = b (sqrt(1 - S^2) - sqrt(1 - S0^2)), dz/dtheta = r s/2.
    """

    radius: float  # m
    lead_angle: float  # rad, at theta = 0
    ellipse_a: float  # m, semi-axis along the circumference
    ellipse_b: float  # m, semi-axis along z
    friction: float  # Coulomb coefficient
    stiffness: float = 0.0  # N/m
    release_damping: float = 0.0  # N.s/m

    def slope_and_lift(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Tangent of the lead angle, and z [m], at theta [rad]."""
        a, b = self.ellipse_a, self.ellipse_b
        start = math.sin(math.atan(a / b * math.tan(self.lead_angle)))
        place = start - 0.5 * self.radius * theta / a
        height = np.sqrt(1.0 - place**2)
        return b / a * place / height, b * (height - math.sqrt(1.0 - start**2))

    def torque(self, theta: np.ndarray, omega: np.ndarray) -> np.ndarray:
        """Torque [N.m] against +theta while it moves through theta [rad] with omega [rad/s], not zero.

        The pin bears on the flank that the axial force presses it to, so friction acts with the sign e of
        omega F: torque = F/(kappa_1 + kappa_2), kappa = (1 - e mu s)/(r (s + e mu)).
        """
        slope, lift = self.slope_and_lift(theta)
        speed = 0.5 * self.radius * slope * omega
        damper = np.where(speed < 0.0, self.release_damping * speed, 0.0)
        force = self.stiffness * lift + damper
        mu = self.friction * np.sign(omega) * np.sign(force)
        return force * self.radius * (slope + mu) / (2.0 * (1.0 - mu * slope))

    def parameters(self) -> dict[str, float]:
        """The same mechanism as start values of the FMU."""
        values = {
            "spring.preload": 0.0,
            "spring.stiffness": self.stiffness,
            "damper.c_release": self.release_damping,
        }
        for cam in ("cam1", "cam2"):
            values[f"{cam}.profile"] = 2
            values[f"{cam}.ellipse_curvature"] = -1
            values[f"{cam}.radius"] = self.radius
            values[f"{cam}.lead_angle"] = self.lead_angle
            values[f"{cam}.ellipse_a"] = self.ellipse_a
            values[f"{cam}.ellipse_b"] = self.ellipse_b
            values[f"{cam}.friction"] = self.friction
        return values
