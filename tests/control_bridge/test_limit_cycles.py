"""The bridge to python-control: hysteresis and limit cycles."""

import math
import warnings
from itertools import pairwise

import control
import numpy as np
import pytest
from control_cases import FORWARD, PERIOD, UPPER, edge
from mechanisms import INERTIA, LIFT, RHO, STIFFNESS
from scipy.integrate import quad

from dualcam import CamHysteresis


def test_describing_function_of_straight_edges():
    """Against the integrals of its definition, piece by piece."""
    rise = {sign: RHO[sign] * STIFFNESS * LIFT for sign in RHO}  # N.m/rad
    hysteresis = CamHysteresis(FORWARD, 0.7, tau=4.2)
    for amplitude in (1.5, 2.5, 3.5):
        top, bottom = (
            (4.2 + s * amplitude - edge(s, 0.0)) / rise[s] for s in (+1, -1)
        )  # where it turns round

        def theta(phase, amplitude=amplitude, top=top, bottom=bottom):
            tau = 4.2 + amplitude * math.sin(phase)
            if 0.5 * math.pi <= phase < 1.5 * math.pi:
                return min(top, (tau - edge(-1, 0.0)) / rise[-1])
            return max(bottom, (tau - edge(+1, 0.0)) / rise[+1])

        leave_top = math.pi - math.asin((edge(-1, top) - 4.2) / amplitude)
        leave_bottom = 2.0 * math.pi + math.asin((edge(+1, bottom) - 4.2) / amplitude)
        kinks = sorted({0.5 * math.pi, leave_top, 1.5 * math.pi, leave_bottom % (2.0 * math.pi)})
        ends = [0.0, *kinks, 2.0 * math.pi]
        parts = [
            sum(quad(lambda p, f=f: theta(p) * f(p), a, b, epsabs=1e-13)[0] for a, b in pairwise(ends))
            for f in (math.sin, math.cos)
        ]
        expected = complex(*parts) / (math.pi * amplitude)
        assert hysteresis.describing_function(amplitude) == pytest.approx(expected, rel=1e-5)


STEEPENING = {"cam2.profile": 2, "cam2.ellipse_curvature": 1, "cam2.lead_angle": 0.7}


@pytest.mark.parametrize("parameters", [{}, STEEPENING], ids=["helices", "a cam that steepens"])
def test_describing_function_is_that_of_the_fmu(slave, parameters):
    """Without inertia, swung through a sine; amplitudes that reach both stops too."""
    hysteresis = CamHysteresis(FORWARD, 0.7, parameters=parameters)
    phases = 2.0 * np.pi / 2000 * np.arange(4000)
    for share in (1.3, 2.0, 9.0):
        amplitude = share * hysteresis.dead_band
        bias = hysteresis.bias_at(amplitude)
        slave.start(parameters | {"inertia.shaft": 0.0, "initial.theta": 0.7, "tau": bias})
        command, state = slave.reals("tau"), slave.reals("theta")
        angles = []
        for phase in phases:
            command.values[0] = bias + amplitude * math.sin(phase)
            command.write()
            slave.step(1e-3)
            angles += state.read()
        cycle, at = np.array(angles[2000:]), phases[2000:]
        expected = complex(cycle @ np.sin(at), cycle @ np.cos(at)) / (1000 * amplitude)
        assert hysteresis.describing_function(amplitude) == pytest.approx(expected, rel=1e-4)
        assert cycle.mean() == pytest.approx(0.7, abs=1e-5)
    assert (cycle.min(), cycle.max()) == (0.0, UPPER)


def test_the_method_and_python_controls_own_integral_agree():
    hysteresis = CamHysteresis(FORWARD, 0.7, tau=4.2)
    for amplitude in (1.5, 2.5):
        theirs = control.describing_function(hysteresis, [amplitude], num_points=4000, try_method=False)
        assert hysteresis.describing_function(amplitude) == pytest.approx(theirs[0], rel=1e-5)


def test_in_the_dead_band_nothing_moves():
    hysteresis = CamHysteresis(FORWARD, 0.7)
    assert hysteresis.dead_band == pytest.approx(0.5 * (edge(+1, 0.7) - edge(-1, 0.7)), rel=1e-9)
    assert hysteresis.describing_function(0.999 * hysteresis.dead_band) == 0.0
    assert abs(hysteresis.describing_function(1.01 * hysteresis.dead_band)) > 0.0
    assert hysteresis.describing_function(0.0) == 0.0
    assert hysteresis(0.5) == 0.0
    assert hysteresis(3.0) > 0.0
    assert hysteresis.natural_frequency(INERTIA) == pytest.approx(
        math.sqrt(RHO[+1] * STIFFNESS * LIFT / INERTIA), rel=1e-9
    )
    assert hysteresis.natural_frequency() == pytest.approx(hysteresis.natural_frequency(INERTIA), rel=1e-9)
    for inertia in (0.0, math.nan, "2e-3"):
        with pytest.raises(ValueError, match=r"inertia = .*: allowed is"):
            hysteresis.natural_frequency(inertia)
    with pytest.raises(ValueError, match="amplitude"):
        hysteresis.describing_function(-1.0)


# Integral action on the angle through an actuator and a filter of 0.3 s each: H = K/(s (0.3 s + 1)^2) from
# angle to torque. A low-pass: at the cycle's frequency the third harmonic comes back more than 10 times
# weaker than the first.
LAG = 0.3  # s
MIDDLE = 1.5  # rad
ROOM = {"stop.upper": 3.0}
LIGHT = ROOM | {"inertia.shaft": 2e-5, "ledger": False}


def controller(gain):
    s = control.tf("s")
    return gain / (s * (LAG * s + 1.0) ** 2)


def predicted(gain):
    """Amplitudes of the torque [N.m] and frequencies [rad/s] of limit cycles."""
    hysteresis = CamHysteresis(FORWARD, MIDDLE, parameters=ROOM)
    amplitudes = np.linspace(1.02, 6.0, 120) * hysteresis.dead_band
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        response = control.describing_function_response(
            controller(gain), hysteresis, amplitudes, np.logspace(-1, 2, 400)
        )
    return hysteresis, response.intersections


def simulated(fmu, gain, duration, torque):
    """The nonlinear loop with the FMU, its inertia and all, every ms, started on its bias with the integrator
    off by `torque` [N.m]. Torque and angle, shape (steps, 2)."""
    law = control.sample_system(control.ss(controller(gain)), PERIOD)
    drive, back, out = law.A, law.B[:, 0], law.C[0]
    bias = 0.5 * (edge(+1, MIDDLE) + edge(-1, MIDDLE))
    at_rest = np.vstack([drive - np.eye(3), out])  # x stays, and -out x is that torque
    x = np.linalg.lstsq(at_rest, [0.0, 0.0, 0.0, -torque])[0]
    fmu.start(LIGHT | {"initial.theta": MIDDLE, "tau": bias})
    command, state = fmu.reals("tau"), fmu.reals("theta")
    found = np.empty((round(duration / PERIOD), 2))
    for row in found:
        (theta,) = state.read()
        command.values[0] = bias - out @ x
        command.write()
        x = drive @ x + back * (theta - MIDDLE)
        fmu.step(PERIOD)
        row[:] = command.values[0], theta
    return found


def swing(found):
    """First harmonics of torque and angle, as amplitudes, and their frequency [rad/s], over whole cycles."""
    above = found[:, 0] > found[:, 0].mean()
    up = np.flatnonzero(above[1:] & ~above[:-1])
    span = found[up[0] : up[-1]]
    frequency = 2.0 * np.pi * (len(up) - 1) / (len(span) * PERIOD)
    wave = np.exp(-1j * frequency * PERIOD * np.arange(len(span)))
    torque, theta = (2.0 * abs(np.mean((column - column.mean()) * wave)) for column in span.T)
    return torque, theta, frequency


@pytest.mark.parametrize("gain", [25.0, 28.0])
def test_a_limit_cycle_is_predicted(slave, gain):
    """The stable one of two; the prediction is legitimate: the cam's own frequency is far above, the third
    harmonic of the torque is small."""
    hysteresis, cycles = predicted(gain)
    assert len(cycles) == 2
    (threshold, _), (torque, frequency) = sorted(cycles)
    assert hysteresis.natural_frequency(LIGHT["inertia.shaft"]) > 100.0 * frequency
    third = abs(controller(gain)(3j * frequency) / controller(gain)(1j * frequency))
    assert third < 0.1
    found = swing(simulated(slave, gain, 60.0, 2.0 * threshold)[-20_000:])
    theta = torque * abs(hysteresis.describing_function(torque))
    assert found == pytest.approx((torque, theta, frequency), rel=0.1)


def test_below_the_unstable_cycle_the_oscillation_dies(slave):
    """The other intersection is the border: from below it the loop comes to rest."""
    _, cycles = predicted(25.0)
    threshold = min(cycles)[0]
    found = simulated(slave, 25.0, 200.0, 0.5 * threshold)
    assert np.ptp(found[-50_000:, 1]) < 1e-3


@pytest.mark.parametrize("gain", [5.0, 10.0])
def test_where_none_is_predicted_none_is_found(slave, gain):
    """From an offset that is as large as the limit cycles of higher gains."""
    hysteresis, cycles = predicted(gain)
    assert cycles == []
    found = simulated(slave, gain, 300.0, 4.0 * hysteresis.dead_band)
    assert np.ptp(found[:5_000, 1]) > 0.3
    assert np.ptp(found[-50_000:, 1]) < 1e-3
