"""Harmonic balance of the cam under a sampled controller, with inertia, damping, friction law and hold.

One signal of the loop is taken for sinusoidal, the angle or the torque on the grooves. What the cam does to
the other one is computed exactly. The balance of the first harmonics gives amplitude and frequency.

Source: A. Gelb, W. E. Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design,
McGraw-Hill 1968, chapters 2 and 3."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.optimize import OptimizeResult, root

from dualcam.control.forward import CamAtState
from dualcam.control.play_operator import PlayOperator
from dualcam.control.sampled_loop import SampledController
from dualcam.control.swing import FEW_NODES, Harmonics, ImposedSwing
from dualcam.fmi.reals import Array

AMPLITUDES, FREQUENCIES, FINE = 14, 18, 400  # of a search, spaced by equal factors
SMALLEST, SLOWEST = 1e-3, 1e-4  # first amplitude over the largest, first frequency over the largest
LARGEST, FASTEST = 0.99, 0.9  # of the distance to the nearer stop, of pi over the period
DISTORTED = 0.5  # beyond it a signal is not at all sinusoidal, and its balance says nothing
HARMONICS, SAMPLES = 9, 256  # of a cycle in which the torque has more harmonics than the first
SAME = 0.2  # relative: two predictions nearer than this are one


@dataclass(frozen=True)
class LimitCycle:
    """A predicted limit cycle.

    Attributes
    ----------
    amplitude : Half the range of the angle [rad].
    torque : Half the range of the controller's torque, of its first harmonic [N.m].
    frequency : Angular frequency [rad/s].
    stable : False: a border. From smaller swings the loop comes to rest, from larger ones the swing grows.
    sinusoid : What the harmonic balance takes for sinusoidal: "angle" or "torque".
    distortion : Second and third harmonic of that signal over the first one, as the loop returns them [1].
    margin
        Of a sinusoidal angle: distance of the torque at the turning points from the middle of the stick band,
        in half widths of the band. Below 1 the cam would rest there. Below 1.9 the prediction can be wrong by
        more than 10 %. Infinite for a sinusoidal torque, which has these rests.
    """

    amplitude: float
    torque: float
    frequency: float
    stable: bool
    sinusoid: str
    distortion: float
    margin: float


@dataclass(frozen=True)
class Start:
    """A state of the loop. `x`: of the controller; `bias`: torque beside the controller's [N.m]."""

    theta: float
    omega: float
    x: Array
    bias: float

    def scaled(self, factor: float, middle: float) -> Start:
        """In a swing about `middle` that is larger by a factor."""
        theta = middle + factor * (self.theta - middle)
        return Start(theta, factor * self.omega, factor * self.x, self.bias)


@dataclass(frozen=True)
class Candidate:
    """A limit cycle, and a state of the loop in it."""

    cycle: LimitCycle
    start: Start


def candidates(hysteresis: PlayOperator, controller: SampledController) -> list[Candidate]:
    """The limit cycles that both balances find, by rising amplitude. Of two that are nearly the same, the one
    with less distortion."""
    found = SinusoidalTorque(hysteresis, controller).candidates()
    if hysteresis.inertia > 0.0:
        cam = CamAtState(hysteresis.path, hysteresis.parameters)
        try:
            found += SinusoidalAngle(hysteresis, controller, cam).candidates()
        finally:
            cam.fmu.close()
    kept: list[Candidate] = []
    for one in sorted(found, key=lambda one: one.cycle.distortion):
        if one.cycle.distortion <= DISTORTED and not any(_same(one.cycle, other.cycle) for other in kept):
            kept.append(one)
    return sorted(kept, key=lambda one: one.cycle.amplitude)


def _same(one: LimitCycle, other: LimitCycle) -> bool:
    return all(
        abs(a - b) <= SAME * max(a, b)
        for a, b in ((one.amplitude, other.amplitude), (one.frequency, other.frequency))
    )


# ---- harmonic balance ----


class Balance:
    """A signal of the loop is taken for sinusoidal. `value` is zero in a limit cycle."""

    name = ""

    def value(self, amplitude: float, frequency: float) -> complex:
        """Of the balance, at an amplitude of the signal and an angular frequency [rad/s]."""
        raise NotImplementedError

    def search(self) -> Iterator[tuple[float, float]]:
        """Amplitudes and frequencies near the zeros."""
        raise NotImplementedError

    def candidate(self, amplitude: float, frequency: float, stable: bool) -> Candidate:
        """Of a zero."""
        raise NotImplementedError

    def candidates(self) -> list[Candidate]:
        """Of all zeros."""
        zeros = [zero for near in self.search() if (zero := self._refined(*near))]
        return [self.candidate(*zero, self._stable(*zero)) for zero in zeros]

    def _refined(self, amplitude: float, frequency: float) -> tuple[float, float] | None:
        """The zero near a place, None if there is none."""
        size = abs(self.value(amplitude, 1.01 * frequency) - self.value(amplitude, frequency)) * 100.0

        def residual(logarithms: Array) -> list[float]:
            value = self.value(*np.exp(logarithms).tolist()) / size
            return [value.real, value.imag]

        found = _root(residual, np.log([amplitude, frequency]), xtol=1e-6, maxfev=60)
        if found is None:
            return None
        place = np.exp(found.x).tolist()
        near = all(0.5 < a / b < 2.0 for a, b in zip(place, (amplitude, frequency), strict=True))
        return (place[0], place[1]) if near and np.abs(found.fun).max() < 1e-3 else None

    def _stable(self, amplitude: float, frequency: float) -> bool:
        """Whether a swing beyond the cycle decays. With s = sigma + j frequency, balance of a disturbed cycle
        needs sigma = Im(dg/dA / dg/dfrequency) dA."""
        by_amplitude = self.value(1.003 * amplitude, frequency) - self.value(0.997 * amplitude, frequency)
        by_frequency = self.value(amplitude, 1.001 * frequency) - self.value(amplitude, 0.999 * frequency)
        return (by_amplitude / by_frequency).imag < 0.0


class SinusoidalAngle(Balance):
    """Torque that the swing needs = torque of the controller. Good where the inertia carries the cam through
    its turning points."""

    name = "angle"

    def __init__(self, hysteresis: PlayOperator, controller: SampledController, cam: CamAtState) -> None:
        self.hysteresis, self.controller, self.theta = hysteresis, controller, hysteresis.theta
        self.swing = ImposedSwing(cam, hysteresis.theta, hysteresis.F_ext)
        nearer = min(hysteresis.theta - hysteresis.lower, hysteresis.upper - hysteresis.theta)
        self.largest, self.fastest = LARGEST * nearer, FASTEST * math.pi / controller.period

    def harmonics(self, amplitude: float, frequency: float) -> Harmonics:
        if amplitude > self.largest:
            raise ValueError(f"amplitude = {amplitude} rad reaches a stop")
        return self.swing.harmonics(amplitude, frequency, FEW_NODES)

    def value(self, amplitude: float, frequency: float) -> complex:
        return self.harmonics(amplitude, frequency).first + self.controller.response(frequency)

    def search(self) -> Iterator[tuple[float, float]]:
        amplitudes = self.largest * np.geomspace(SMALLEST, 0.999, AMPLITUDES)
        frequencies = self.fastest * np.geomspace(SLOWEST, 1.0, FREQUENCIES)
        needed = np.array([[self._first(a, w) for w in frequencies] for a in amplitudes])
        # without the inertia, whose share is largest by far at the end, splines over the frequency are good
        inertia = -needed[:, -1].real / frequencies[-1] ** 2
        static = needed + np.outer(inertia, frequencies**2)
        fine = self.fastest * np.geomspace(SLOWEST, 1.0, FINE)
        spline = CubicSpline(np.log(frequencies), static, axis=1)
        values = spline(np.log(fine)) - np.outer(inertia, fine**2)
        values += np.array([self.controller.response(w) for w in fine])
        return _cells(values, amplitudes, fine)

    def _first(self, amplitude: float, frequency: float) -> complex:
        try:
            return self.harmonics(amplitude, frequency).first
        except ValueError:
            return complex(math.nan, math.nan)

    def candidate(self, amplitude: float, frequency: float, stable: bool) -> Candidate:
        found = self.harmonics(amplitude, frequency)
        # a harmonic of the needed torque moves the cam by as much as the loop at that frequency lets it
        returned = [
            harmonic / self.value(amplitude, k * frequency)
            for k, harmonic in ((2, found.second), (3, found.third))
        ]
        torque = amplitude * abs(self.controller.response(frequency))
        distortion = float(np.hypot(*np.abs(returned)))
        x = (self.controller.state_phasor(frequency) * -amplitude).imag
        return Candidate(
            LimitCycle(
                amplitude, torque, frequency, stable, self.name, distortion, self._margin(amplitude, found)
            ),
            Start(self.theta, amplitude * frequency, x, found.mean),  # in the middle, on the way up
        )

    def _margin(self, amplitude: float, found: Harmonics) -> float:
        """See LimitCycle: the smaller one of both turning points."""
        margins = []
        for side in (1.0, -1.0):
            release, load = self.hysteresis.band(self.theta + side * amplitude)
            torque = found.mean + side * amplitude * found.first.real
            distance = abs(2.0 * torque - load - release)
            margins.append(distance / (load - release) if load > release else math.inf)
        return min(margins)


class SinusoidalTorque(Balance):
    """Torque on the grooves = torque of the controller less that of inertia and damping of the shaft. Good in
    slow cycles, in which the cam rests at its turning points for long."""

    name = "torque"

    def __init__(self, hysteresis: PlayOperator, controller: SampledController) -> None:
        self.hysteresis, self.controller = hysteresis, controller
        self.fastest = FASTEST * math.pi / controller.period
        width = hysteresis.band(hysteresis.upper)[1] - hysteresis.band(hysteresis.lower)[0]
        smallest = max(1.005 * hysteresis.dead_band, SMALLEST * width)  # with no friction nothing is dead
        self.amplitudes = np.geomspace(smallest, width, 3 * AMPLITUDES)
        self._cam = lru_cache(hysteresis.describing_function)

    def linear(self, frequency: float) -> complex:
        """From the angle to minus the torque on the grooves [N.m/rad]."""
        s = 1j * frequency
        shaft = self.hysteresis.inertia * s**2 + self.hysteresis.damping * s
        return self.controller.response(frequency) + shaft

    def value(self, amplitude: float, frequency: float) -> complex:
        return 1.0 + self._cam(amplitude) * self.linear(frequency)

    def search(self) -> Iterator[tuple[float, float]]:
        frequencies = self.fastest * np.geomspace(SLOWEST, 1.0, FINE)
        cam = np.array([self._cam(a) for a in self.amplitudes])
        loop = np.array([self.linear(w) for w in frequencies])
        return _cells(1.0 + np.outer(cam, loop), self.amplitudes, frequencies)

    def candidate(self, amplitude: float, frequency: float, stable: bool) -> Candidate:
        """With more harmonics of the torque than the first one, where they converge."""
        count = max(1, min(HARMONICS, int(self.fastest / frequency)))
        guess = np.zeros(count + 1, complex)
        guess[:2] = self.hysteresis.bias_at(amplitude), amplitude
        sine = np.abs(np.fft.rfft(self._angle(guess))) * (2.0 / SAMPLES)
        returned = [sine[k] * abs(self.linear(k * frequency)) / amplitude for k in (2, 3)]
        torques, frequency = self._with_harmonics(guess, frequency)
        theta = self._angle(torques)
        lines = np.fft.rfft(theta)[: count + 1] * (2.0 / SAMPLES)
        lines[0] = 0.0
        orders = [1, *range(1, count + 1)]  # that of the mean has no share
        controller = -lines * np.array([self.controller.response(k * frequency) for k in orders])
        top = int(np.argmax(theta))  # where the cam turns round
        phase = np.exp(2j * np.pi * np.arange(count + 1) * top / SAMPLES)
        phasors = np.array([self.controller.state_phasor(k * frequency) for k in orders])
        x = (-(lines * phase)[:, None] * phasors).real.sum(axis=0)
        swing = np.ptp(np.fft.irfft(controller * SAMPLES / 2.0, SAMPLES))
        distortion = float(np.hypot(*returned))
        return Candidate(
            LimitCycle(
                0.5 * float(np.ptp(theta)),
                0.5 * float(swing),
                frequency,
                stable,
                self.name,
                distortion,
                math.inf,
            ),
            Start(float(theta[top]), 0.0, x, float(torques[0].real)),
        )

    def _with_harmonics(self, guess: Array, frequency: float) -> tuple[Array, float]:
        """Harmonics of the torque on the grooves, and the frequency: every harmonic is balanced, the mean
        angle is kept, and the first harmonic is the phase. The guess where nothing converges."""
        order = np.arange(1, len(guess))

        def unknown(values: Array) -> tuple[Array, float]:
            torques = np.zeros(len(guess), complex)
            torques[0], torques[1] = values[0], values[1]
            torques[2:] = values[2 : len(guess)] + 1j * values[len(guess) : -1]
            return torques, frequency * math.exp(values[-1])

        def residual(values: Array) -> Array:
            torques, now = unknown(values)
            theta = self._angle(torques)
            lines = np.fft.rfft(theta)[: len(guess)] * (2.0 / SAMPLES)
            linear = np.array([self.linear(k * now) for k in order])
            balance = (torques[1:] + linear * lines[1:]) / abs(guess[1])
            middle = (theta.mean() - self.hysteresis.theta) / np.ptp(theta) if np.ptp(theta) > 0.0 else 1.0
            return np.concatenate([[middle], balance.real, balance.imag])

        first = np.concatenate([guess[:2].real, np.zeros(2 * (len(guess) - 2)), [0.0]])
        found = _root(residual, first, xtol=1e-8, maxfev=500)
        if found is None or not found.success:
            return guess, frequency
        torques, now = unknown(found.x)
        near = 0.5 < abs(torques[1] / guess[1]) < 2.0 and 0.5 < now / frequency < 2.0
        return (torques, now) if near else (guess, frequency)

    def _angle(self, torques: Array) -> Array:
        """A steady cycle of the angle under harmonics of the torque, shape (SAMPLES,)."""
        spectrum = np.zeros(SAMPLES // 2 + 1, complex)
        spectrum[: len(torques)] = torques * SAMPLES / 2.0
        spectrum[0] *= 2.0
        return self.hysteresis.steady_angle(np.fft.irfft(spectrum, SAMPLES))


# ---- help for the search ----


def _root(
    residual: Callable[[Array], ArrayLike], first: Array, xtol: float, maxfev: int
) -> OptimizeResult | None:
    """What scipy.optimize.root finds. None where a trial overflows, or the cam cannot move as it says."""
    try:
        with np.errstate(over="ignore", invalid="ignore"):
            return root(residual, first, options={"xtol": xtol, "maxfev": maxfev})
    except (ValueError, ArithmeticError):
        return None


def _cells(values: Array, amplitudes: Array, frequencies: Array) -> Iterator[tuple[float, float]]:
    """Middles of the cells of a grid at whose corners both parts of the values change their signs."""
    corners = np.stack([values[:-1, :-1], values[1:, :-1], values[:-1, 1:], values[1:, 1:]])
    with np.errstate(invalid="ignore"):
        change = [
            (part.min(axis=0) <= 0.0) & (part.max(axis=0) >= 0.0) for part in (corners.real, corners.imag)
        ]
    for i, j in np.argwhere(change[0] & change[1]):
        yield (
            math.sqrt(amplitudes[i] * amplitudes[i + 1]),
            math.sqrt(frequencies[j] * frequencies[j + 1]),
        )
