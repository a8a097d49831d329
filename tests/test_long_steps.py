"""One step over many oscillations, in closed form: events and peaks among them, worked out apart.

Both grooves are helices and the spring is linear, so that a torque that grows in proportion to time makes the
mechanism load with an oscillation on top: J alpha = tau - rho (F0 + k z' theta + c z' omega), mechanism.md,
section 6. The torque starts so, and the speed of the drift exceeds that of the oscillation, so that the
mechanism never stops. The equation is solved here by its characteristic polynomial, and searched on a grid.
"""

import cmath
import math

import numpy as np
import pytest
from mechanisms import INERTIA, LIFT, PRELOAD, RHO, STIFFNESS
from reference import UPPER_STOP
from scipy.optimize import brentq

PERIODS = 60.0
GRID = 400  # samples for each period
RADIUS, FRICTION, CONTACTS = 0.02, 0.14, 2
# Of torque on reaction at 45 degrees: R = T sqrt(1 + s^2)/(r (s + mu)) with s = 1, for each of two contacts.
REACTION = math.sqrt(2.0) / (RADIUS * (1.0 + FRICTION)) / CONTACTS


class Drift:
    """theta = mean + speed t + Re(amplitude exp(root t)), under the torque tau + rate t."""

    def __init__(self, damping: float, speed: float, share: float, phase: float) -> None:
        stiffness = RHO[1] * STIFFNESS * LIFT
        self.damping = RHO[1] * damping * LIFT
        self.root = (-self.damping + cmath.sqrt(self.damping**2 - 4 * INERTIA * stiffness)) / (2 * INERTIA)
        self.speed, self.rate = speed, speed * stiffness
        self.amplitude = share * speed / self.root * cmath.exp(1j * phase)
        self.mean = 2.0 * abs(self.amplitude)
        self.tau = RHO[1] * PRELOAD + stiffness * self.mean + self.damping * speed

    def motion(self, t, order: int = 0):
        """theta, omega or alpha."""
        line = (self.mean + self.speed * t, self.speed, 0.0)[order]
        return line + (self.amplitude * self.root**order * np.exp(self.root * t)).real

    def transmitted(self, t):
        """The torque on the pin, N.m."""
        return self.tau + self.rate * t - INERTIA * self.motion(t, 2)

    def first_time_at(self, theta: float, end: float) -> float:
        t = np.linspace(0.0, end, int(GRID * end / self.period))
        k = int(np.argmax(self.motion(t) >= theta))
        return brentq(lambda t: float(self.motion(t)) - theta, t[k - 1], t[k], xtol=1e-15, rtol=1e-15)

    @property
    def period(self) -> float:
        return 2 * math.pi / self.root.imag

    def largest(self, values, end: float) -> float:
        """The maximum over [0, end] of a smooth function: the best sample and the parabola around."""
        t = np.linspace(0.0, end, int(GRID * end / self.period))
        y = np.abs(values(t))
        k = int(np.argmax(y))
        if k in (0, len(t) - 1):
            return float(y[k])
        before, here, after = y[k - 1 : k + 2]
        return float(here + (after - before) ** 2 / (8.0 * (2.0 * here - before - after)))


RANDOM = np.random.default_rng(7)
DRIFTS = [
    Drift(damping, 0.3, float(RANDOM.uniform(0.2, 0.8)), float(RANDOM.uniform(-math.pi, math.pi)))
    for damping in (0.0, 0.5, 5.0, 50.0)
    for _ in range(4)
]


def started(make, drift: Drift, damping: float, **parameters):
    start = {"initial.theta": float(drift.motion(0.0)), "initial.omega": float(drift.motion(0.0, 1))}
    fmu = make().start(start | {"damper.c_load": damping, "tau": drift.tau, **parameters})
    fmu.set_rates(tau=drift.rate)
    return fmu


def damping_of(drift: Drift) -> float:
    return drift.damping / (RHO[1] * LIFT)


@pytest.mark.parametrize("drift", DRIFTS, ids=range(len(DRIFTS)))
def test_end_and_peaks_of_a_step_over_many_oscillations(make, drift):
    for periods in (0.3, 1.7, 4.4, 11.3, PERIODS):
        h = periods * drift.period
        fmu = started(make, drift, damping_of(drift), **{"stop.upper": 100.0})
        fmu.step(h)
        assert fmu.get("theta") == pytest.approx(drift.motion(h), rel=1e-12)
        assert fmu.get("omega") == pytest.approx(drift.motion(h, 1), rel=1e-11)
        largest = drift.largest(lambda t: drift.motion(t, 1), h)
        assert fmu.get("peak.omega") == pytest.approx(largest, rel=1e-8), periods
        reaction = REACTION * drift.largest(drift.transmitted, h)
        for cam in (1, 2):
            assert fmu.get(f"peak.reaction{cam}") == pytest.approx(reaction, rel=1e-8), periods
        assert fmu.get("peak.torque") == pytest.approx(drift.tau + drift.rate * h, rel=1e-12)


@pytest.mark.parametrize("drift", DRIFTS, ids=range(len(DRIFTS)))
def test_the_stop_is_hit_after_many_oscillations(make, drift):
    """All kinetic energy becomes heat at the stop, which tells the instant."""
    for periods in (0.6, 3.2, 17.9, 41.3):
        stop = float(drift.mean + drift.speed * periods * drift.period)
        hit = drift.first_time_at(stop, (periods + 2.0) * drift.period)
        fmu = started(make, drift, damping_of(drift), **{"stop.upper": stop})
        fmu.step(PERIODS * drift.period)
        assert (fmu.get("mode"), fmu.get("theta")) == (UPPER_STOP, stop)
        heat = 0.5 * INERTIA * float(drift.motion(hit, 1)) ** 2
        assert fmu.get("energy.heat_stop") == pytest.approx(heat, rel=1e-9), periods
