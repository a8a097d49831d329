"""Limit cycles from the equations of the scene, without the FMU.

Slip begins where K delta = T_s, at rest. So each cycle is one slip from this one point of the phase plane,
until omega = 0 again, and a rest until the twist has grown back:

    period = slip + (T_s - K delta_end)/(K Omega)

Sudden drop: slip is a damped harmonic oscillation. omega obeys the same linear equation as delta, so the
relative speed y = Omega - omega has y(0) = Omega, y'(0) = -(T_s - T_k)/J. Slip ends where y = Omega again.
Without damping the amplitude is sqrt((dT/K)^2 + (Omega/w)^2) with dT = T_s - T_k, and the cycle never ends.
With damping the cycle ends where the next maximum of y is Omega: the speed grazes zero. For a small damping
ratio this speed is dT/(w J sqrt(4 pi zeta)), which textbooks give.

Any other law: the slip is integrated by DOP853 with a relative tolerance of 1e-12 and event location."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from benchmarks.stick_slip.scene import INERTIA, SHAFT, SLIDING, Cycle, Scene

LONGEST = 20.0  # natural periods of slip without rest, after which a cycle counts as ended


def cycle(scene: Scene, speed: float) -> Cycle | None:
    """The limit cycle at a speed of the drive [rad/s]. None: the slip from rest never comes to rest again."""
    return sudden_cycle(scene, speed) if scene.drop == "sudden" else phase_plane_cycle(scene, speed)


# ---- sudden drop: closed solution ----


class Slip:
    """Slip after a sudden drop: y = exp(-decay t) (Omega cos(w_d t) + sine sin(w_d t))."""

    def __init__(self, scene: Scene, speed: float) -> None:
        self.scene, self.speed = scene, speed
        self.damped = scene.natural_frequency * math.sqrt(1.0 - scene.damping_ratio**2)
        self.decay = scene.damping_ratio * scene.natural_frequency
        fall = (scene.static_torque - scene.kinetic_torque) / INERTIA
        self.sine = (self.decay * speed - fall) / self.damped

    def y(self, time: float) -> float:
        """The relative speed [rad/s]."""
        phase = self.damped * time
        return math.exp(-self.decay * time) * (self.speed * math.cos(phase) + self.sine * math.sin(phase))

    def rate(self, time: float) -> float:
        """y' [rad/s2]."""
        phase = self.damped * time
        cosine = self.sine * self.damped - self.decay * self.speed
        sine = -self.speed * self.damped - self.decay * self.sine
        return math.exp(-self.decay * time) * (cosine * math.cos(phase) + sine * math.sin(phase))

    def twist(self, time: float) -> float:
        """delta [rad], from the torque balance K delta = J omega' + b omega + T_k."""
        omega = self.speed - self.y(time)
        torque = -INERTIA * self.rate(time) + self.scene.damping * omega + self.scene.kinetic_torque
        return torque / SHAFT

    def turning_times(self) -> tuple[float, float]:
        """Times at which y is smallest, and then largest [s]."""
        cosine = self.sine * self.damped - self.decay * self.speed
        sine = self.speed * self.damped + self.decay * self.sine
        first = math.atan2(cosine, sine) / self.damped % (math.pi / self.damped)
        return first, first + math.pi / self.damped


def sudden_cycle(scene: Scene, speed: float) -> Cycle | None:
    """See the closed solution above."""
    move = Slip(scene, speed)
    smallest, largest = move.turning_times()
    if move.y(largest) < speed:
        return None
    end = float(brentq(lambda time: move.y(time) - speed, smallest, largest, xtol=1e-16, rtol=1e-15))
    extremes = [float(brentq(move.y, *ends, xtol=1e-16)) for ends in ((0.0, smallest), (smallest, end))]
    amplitude = 0.5 * abs(move.twist(extremes[0]) - move.twist(extremes[1]))
    return Cycle(amplitude, end + (scene.static_torque / SHAFT - move.twist(end)) / speed)


# ---- any law: the phase plane ----


def phase_plane_cycle(scene: Scene, speed: float) -> Cycle | None:
    def rates(time: float, state: NDArray[np.float64]) -> list[float]:
        delta, omega = state
        balance = SHAFT * delta - scene.damping * omega - scene.torque(omega)
        return [speed - omega, balance / INERTIA]

    def rests(time: float, state: NDArray[np.float64]) -> float:
        return float(state[1])

    def turns(time: float, state: NDArray[np.float64]) -> float:
        return float(state[1]) - speed

    rests.terminal, rests.direction = True, -1.0  # type: ignore[attr-defined]
    duration = LONGEST * 2.0 * math.pi / scene.natural_frequency
    start = [scene.static_torque / SHAFT, 0.0]
    found = solve_ivp(
        rates, (0.0, duration), start, method="DOP853", rtol=1e-12, atol=1e-14, events=(rests, turns)
    )
    if not found.t_events[0].size:
        return None
    twists = found.y_events[1][:, 0]
    rest = (scene.static_torque / SHAFT - found.y_events[0][0][0]) / speed
    return Cycle(0.5 * float(np.ptp(twists)), float(found.t_events[0][0] + rest))


# ---- where cycles end, and where steady slip is stable ----


def last_speed(scene: Scene, low: float = 0.05, high: float = 50.0, accuracy: float = 1e-7) -> float:
    """The speed of the drive at which the limit cycle ends [rad/s], by bisection."""
    if scene.drop == "sudden":

        def grazes(speed: float) -> float:
            move = Slip(scene, speed)
            return move.y(move.turning_times()[1]) / speed - 1.0

        return float(brentq(grazes, low, high, xtol=1e-15, rtol=1e-14))
    while high - low > accuracy * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if cycle(scene, middle) else (low, middle)
    return 0.5 * (low + high)


def textbook_last_speed(scene: Scene) -> float:
    """The same for a sudden drop and small damping [rad/s]: the energy of a jump, dT^2/(2 K), is the energy
    that damping takes in a period, pi b Omega^2/w."""
    drop = scene.static_torque - scene.kinetic_torque
    impedance = INERTIA * scene.natural_frequency
    return drop / (impedance * math.sqrt(4.0 * math.pi * scene.damping_ratio))


def gradual_last_speed(scene: Scene) -> float:
    """The same for a drop that takes the Stribeck velocity, and small damping [rad/s].

    At the last speed the motion grazes rest: omega = Omega (1 - cos w t). There the excess of friction puts
    in the energy Omega times the integral of T - T_k over the time, with omega = Omega w^2 t^2/2. The energy
    that damping takes is pi b Omega^2/w."""
    drop = scene.static_torque - scene.kinetic_torque
    width = scene.stribeck_velocity / SLIDING  # rad/s
    shape = 2.0 * math.sqrt(2.0) * math.gamma(1.25) if scene.exponent == 2 else math.sqrt(2.0 * math.pi)
    return (shape * drop * math.sqrt(width) / (math.pi * scene.damping)) ** (2.0 / 3.0)


def stable_speed(scene: Scene) -> float:
    """The speed beyond which steady slip is stable, where b + dT/domega = 0 [rad/s]."""
    scale = scene.stribeck_velocity / SLIDING  # rad/s; beyond it the slope of both laws only fades
    return float(brentq(lambda omega: scene.damping + scene.slope(omega), scale, 10.0 * scale, xtol=1e-14))
