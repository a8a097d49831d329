"""Position loops that hunt: predicted by harmonic balance, against loops that are computed apart from the
package (support/held_loop.py) or stepped here."""

import math
import re
import warnings

import control
import numpy as np
import pytest
from control_cases import FORWARD, PERIOD, refused
from held_loop import UPPER, advance, pi_loop, swing
from mechanisms import INERTIA, LIFT, PRELOAD, RHO, STIFFNESS
from numpy.polynomial.legendre import leggauss
from scipy.integrate import quad

from dualcam import CamHysteresis, Fmu, linearize
from dualcam.control import LimitCycles
from dualcam.control.forward import STATES
from dualcam.errors import LimitCycleWarning, OperatingPointError
from dualcam.fmi import RepeatedStart

MIDDLE = 0.7  # rad
HELD = 0.5 * (RHO[1] + RHO[-1]) * (PRELOAD + STIFFNESS * LIFT * MIDDLE)  # N.m, middle of the band


def pi_controller(proportional, integral, period=PERIOD):
    return control.ss(1.0, integral * period, 1.0, proportional, period)


def analysed(controller, parameters=None, **options):
    """Result and the texts of the warnings."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = CamHysteresis(FORWARD, MIDDLE, parameters=parameters).limit_cycles(controller, **options)
    assert all(issubclass(one.category, LimitCycleWarning) for one in caught)
    assert [str(one.message) for one in caught] == list(found.findings)
    return found


def values(found):
    """Of the predicted cycles."""
    return np.array([(one.amplitude, one.frequency, one.torque, one.stable) for one in found.predicted])


# ---- the reference ----


def test_reference_moves_as_the_fmu(slave):
    """Through all modes, random torques held for random times."""
    rng = np.random.default_rng(3)
    slave.start({"initial.theta": MIDDLE})
    state, modes = (MIDDLE, 0.0), set()
    for _ in range(300):
        tau, h = rng.uniform(-15.0, 25.0), rng.uniform(1e-3, 0.03)
        slave.set("tau", tau)
        slave.step(h)
        state = advance(*state, tau, h)
        assert (slave.get("theta"), slave.get("omega")) == pytest.approx(state, rel=1e-8, abs=1e-8)
        modes.add(slave.get("mode"))
    assert modes == {1, 2, 3, 4, 5}


# ---- loops that swing by more than 60 deg, where the describing function of slow motion finds nothing ----


@pytest.mark.parametrize(("proportional", "integral"), [(50.0, 2000.0), (100.0, 1000.0), (20.0, 500.0)])
def test_a_swing_between_the_stops_is_found_and_warned_of(proportional, integral):
    hysteresis = CamHysteresis(FORWARD, MIDDLE)
    s = control.tf("s")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        slow = control.describing_function_response(
            proportional + integral / s,
            hysteresis,
            np.linspace(1.02, 20.0, 200) * hysteresis.dead_band,
            np.logspace(-1, 3, 400),
        )
    assert slow.intersections == []

    start = (MIDDLE - 0.6, 0.0, HELD)
    angles = pi_loop(proportional, integral, PERIOD, MIDDLE, start, 20_000)[-10_000:]
    amplitude, frequency = swing(angles, PERIOD)
    assert 2.0 * amplitude > math.radians(60.0)

    found = analysed(pi_controller(proportional, integral))
    assert not found.holds
    assert any("hits a stop" in text and "does not hold" in text for text in found.findings)
    (motion,) = found.simulated
    assert (motion.amplitude, motion.frequency) == pytest.approx((amplitude, frequency), rel=0.03)


# ---- the border between rest and growth ----


def grows(proportional, integral, amplitude, frequency):
    """Whether a swing of that amplitude about the reference goes on: the reference loop, begun in the middle
    on the way up, with the integral as in a steady oscillation."""
    error = -amplitude  # phasor at the phase 0 of a sine
    held = (integral * PERIOD * error / (np.exp(1j * frequency * PERIOD) - 1.0)).imag
    start = (MIDDLE, amplitude * frequency, HELD + held)
    angles = pi_loop(proportional, integral, PERIOD, MIDDLE, start, 4000)
    return np.ptp(angles[-1000:]) > 2.0 * amplitude


GAINS = [(p, i) for p in (10.0, 20.0, 50.0, 100.0) for i in (300.0, 1000.0, 3000.0)]
STICKY = [(10.0, 1000.0), (10.0, 3000.0), (20.0, 3000.0)]  # the cam nearly rests at its turning points


def border_of(proportional, integral, **options):
    found = analysed(pi_controller(proportional, integral), **options)
    (border,) = found.predicted
    assert not border.stable and border.sinusoid == "angle"
    return border, found


@pytest.mark.parametrize(("proportional", "integral"), [gains for gains in GAINS if gains not in STICKY])
def test_the_border_is_within_ten_percent(proportional, integral):
    border, found = border_of(proportional, integral, check=False)
    assert found.findings == () and found.holds is None
    for factor in (0.9, 1.1):
        swung = grows(proportional, integral, factor * border.amplitude, border.frequency)
        assert swung == (factor > 1.0), (factor, border)


@pytest.mark.parametrize(("proportional", "integral"), STICKY)
def test_a_border_that_is_wrong_is_warned_of(proportional, integral):
    """A swing of 0.9 times the predicted border grows. The margin says so."""
    border, unchecked = border_of(proportional, integral, check=False)
    assert grows(proportional, integral, 0.9 * border.amplitude, border.frequency)
    assert ["half widths of the stick band" in text for text in unchecked.findings] == [True]
    assert unchecked.holds is False


def test_the_check_finds_a_border_that_is_wrong():
    _, found = border_of(*STICKY[2])
    assert any("predicted is a border" in text for text in found.findings)


def test_the_hold_is_in_the_loop():
    """A proportional controller alone drives a swing through its hold: a border, beyond which the loop grows.
    With a period that is 20 times as short the border is beyond the stops."""
    border, _ = border_of(100.0, 0.0, check=False)
    for factor in (0.9, 1.1):
        assert grows(100.0, 0.0, factor * border.amplitude, border.frequency) == (factor > 1.0)
    unchecked = analysed(pi_controller(100.0, 0.0, PERIOD / 20), check=False)
    assert unchecked.predicted == () and unchecked.rests is None


def test_a_loop_that_rests_has_no_limit_cycle_and_no_warning():
    found = analysed(pi_controller(5.0, 20.0))
    assert (found.predicted, found.simulated, found.findings, found.holds) == ((), (), (), True)
    assert found.rests is True
    for offset in (-0.6, 0.1, 0.6):
        angles = pi_loop(5.0, 20.0, PERIOD, MIDDLE, (MIDDLE + offset, 0.0, HELD), 30_000)
        assert np.ptp(angles[-10_000:]) < 1e-3


# ---- controllers of several signals ----


def lqi_controller(angle, speed, integral):
    """From reference, theta and omega; the state is the sum of the errors times the period."""
    direct = [[angle, -angle, -speed]]
    names = ["reference", "theta", "omega"]
    return control.ss(1.0, [[PERIOD, -PERIOD, 0.0]], integral, direct, PERIOD, inputs=names, outputs="tau")


def lqi_swings(angle, speed, integral, amplitude, frequency):
    """Whether a swing goes on, as in `grows`, with the speed fed back. Computed without the package."""
    error = -amplitude
    held = HELD + (integral * PERIOD * error / (np.exp(1j * frequency * PERIOD) - 1.0)).imag
    theta, omega, angles = MIDDLE, amplitude * frequency, np.empty(4000)
    for k in range(len(angles)):
        angles[k], error = theta, MIDDLE - theta
        tau = held + angle * error - speed * omega
        held += integral * PERIOD * error
        theta, omega = advance(theta, omega, tau, PERIOD)
    return np.ptp(angles[-1000:]) > 2.0 * amplitude


@pytest.mark.parametrize(
    "gains", [(50.0, 0.02, 2000.0), (100.0, 0.05, 10000.0), (50.0, -0.02, 1000.0), (20.0, -0.05, 0.0)]
)
def test_the_border_of_a_controller_with_an_integral_and_the_speed(gains):
    (border,) = analysed(lqi_controller(*gains), check=False).predicted
    assert not border.stable
    for factor in (0.9, 1.1):
        swings = lqi_swings(*gains, factor * border.amplitude, border.frequency)
        assert swings == (factor > 1.0), (factor, border)


def test_the_check_runs_a_controller_with_the_speed(slave):
    """The speed is fed back with the wrong sign; the quadratic damper limits the swing before the stops."""
    law = lqi_controller(50.0, -0.02, 2000.0)
    parameters = {"damper.q_load": 2000.0, "damper.q_release": 2000.0, "inertia.follower_mass": 2.0}
    found = analysed(law, parameters)
    (cycle,) = [one for one in found.predicted if one.stable]
    (motion,) = found.simulated
    measured = swing(stepped(slave, law, parameters, 1.1, 4.0)[-2000:], PERIOD)
    assert found.holds and (cycle.amplitude, cycle.frequency) == pytest.approx(measured, rel=0.1)
    assert (motion.amplitude, motion.frequency) == pytest.approx(measured, rel=0.01)


def test_names_of_the_inputs():
    """The same PI controller, from the error, or from reference and measurement."""
    expected = analysed(pi_controller(50.0, 2000.0), check=False)
    one = pi_controller(50.0, 2000.0)
    two = control.ss(1.0, [[2.0, -2.0]], 1.0, [[50.0, -50.0]], PERIOD)
    for names in (["reference", "theta"], ["error", "reference"], ["reference", "theta", "reference"]):
        direct = {"error": 50.0, "reference": 50.0, "theta": -50.0}
        D = np.array([[direct[name] for name in names]])
        law = control.ss(1.0, D / 25.0, 1.0, D, PERIOD)
        assert values(analysed(law, check=False, inputs=names)) == pytest.approx(values(expected), rel=1e-6)
    two.update_names(inputs=["xd[0]", "theta"])
    assert values(analysed(two, check=False)) == pytest.approx(values(expected), rel=1e-6)
    parts = [[(sign * control.tf(one)).num[0][0] for sign in (1.0, -1.0)]], [[[1.0, -1.0]] * 2]
    fractions = control.tf(*parts, PERIOD, inputs=["reference", "theta"])
    assert values(analysed(fractions, check=False)) == pytest.approx(values(expected), rel=1e-6)
    one.update_names(inputs="e")
    assert analysed(one, check=False) == expected == analysed(-one, check=False, inputs="theta")


def test_names_in_one_text():
    law = control.ss([], [], [], [[50.0, -1.0]], PERIOD)
    one, two = (analysed(law, inputs=names, check=False) for names in ("error, omega", ["error", "omega"]))
    assert values(one) == pytest.approx(values(two), rel=0.0)
    with refused("with 1 input, named omega"):
        CamHysteresis(FORWARD, MIDDLE).limit_cycles(control.ss([], [], [], 1.0, PERIOD), inputs="omega")


def test_a_controller_by_functions():
    """Its constants are part of the bias."""
    law = control.nlsys(
        lambda t, x, u, params: x + PERIOD * (u[0] - u[1]),
        lambda t, x, u, params: 3.0 + 2000.0 * x + 50.0 * (u[0] - u[1]) - 0.02 * u[2],
        states=1,
        inputs=["reference", "theta", "omega"],
        outputs="tau",
        dt=PERIOD,
    )
    expected = analysed(lqi_controller(50.0, 0.02, 2000.0), check=False)
    assert values(analysed(law, check=False)) == pytest.approx(values(expected), rel=1e-6)


def test_state_feedback_with_an_integral_of_python_control():
    """LQI by the linear model rests. Other gains swing as the same controller in other words."""
    plant = linearize(FORWARD, MIDDLE, at_rest="loading", inputs="tau", outputs=STATES, period=PERIOD)
    angle, weights = np.array([[1.0, 0.0]]), np.diag([5e3, 5.0, 100.0])
    best, _, _ = control.dlqr(plant, weights, [[1.0]], integral_action=angle)
    lqi, law = (
        control.create_statefbk_iosystem(plant, np.array(gain), integral_action=angle)[0]
        for gain in (best, [[50.0, 0.02, 2000.0 * PERIOD]])
    )
    assert lqi.input_labels == ["xd[0]", "xd[1]", "ud[0]", *STATES]
    assert analysed(lqi) == LimitCycles((), (), True, (), True)
    expected = analysed(lqi_controller(50.0, 0.02, 2000.0), check=False)
    assert values(analysed(law, check=False)) == pytest.approx(values(expected), rel=1e-6)


def test_controllers_that_have_other_signals_are_refused():
    hysteresis = CamHysteresis(FORWARD, MIDDLE)
    gains = {n: control.ss([], [], [], np.ones((1, n)), PERIOD) for n in (1, 2, 3)}
    with refused("2 inputs, named u.0., u.1.", "error", "theta", "omega", 'inputs=."reference", "theta".'):
        hysteresis.limit_cycles(gains[2])
    for count, names in (
        (2, ["theta"]),
        (1, "omega"),
        (1, "reference"),
        (2, ["theta", "speed"]),
        (3, None),
        (1, 3),
    ):
        with refused(f"{count} inputs?, named", "allowed are"):
            hysteresis.limit_cycles(gains[count], inputs=names)
    with refused("2 outputs", "without the cam", "one output, the torque"):
        hysteresis.limit_cycles(control.ss([], [], [], np.ones((2, 1)), PERIOD))
    improper = control.tf([[[1.0], [1.0, 1.0, 0.0]]], [[[1.0, 2.0], [1.0, 3.0]]], PERIOD)
    with refused("cannot write with states", "degree"):
        hysteresis.limit_cycles(improper, inputs=["reference", "theta"])
    with refused("finite numbers"):
        hysteresis.limit_cycles(math.nan * gains[2], inputs=["reference", "theta"])
    nonlinear = control.nlsys(None, lambda t, x, u, p: np.clip(u[:1], -1, 1), inputs=1, outputs=1, dt=PERIOD)
    with refused("NonlinearIOSystem", "not linear", "control.linearize"):
        hysteresis.limit_cycles(nonlinear)


def test_an_unstable_controller_of_two_signals_is_said_to_be_one():
    law = control.ss(1.5, [[0.0, 1.0]], 1.0, [[50.0, -50.0]], PERIOD, inputs=["reference", "theta"])
    found = analysed(law)
    assert found.holds is False and "pole of magnitude 1.5, allowed" in found.findings[-1]


def test_a_swing_that_still_grows_is_said_to_grow():
    """Without friction the loop is linear: the swing grows as exp(t/20 s), and passes no stop in 20 s."""
    gain, seconds = 5.0, 20.0
    damping = 0.5 * gain * PERIOD - 2.0 * INERTIA / seconds  # less than what the hold takes away
    none = {"cam1.friction": 0.0, "cam2.friction": 0.0, "shaft.damping": damping}
    found = analysed(control.ss([], [], [], gain, PERIOD), none, duration=seconds)
    (text,) = [text for text in found.findings if "still grows after 20 s" in text]
    assert not found.holds and "A longer duration" in text
    low, high = map(float, re.search(r"0.665 rad \(([\d.]+) to ([\d.]+) rad at the end", text).groups())
    assert 0.5 * (high - low) == pytest.approx(0.035 * math.e, rel=0.01)


# ---- limit cycles ----


def stepped(fmu, controller, parameters, theta, seconds):
    """Angles of a loop around the FMU, left at an angle at rest."""
    system, x, angles = control.ss(controller), np.zeros(controller.nstates), []
    bias = float(np.mean(CamHysteresis(FORWARD, MIDDLE, parameters=parameters).band(MIDDLE)))
    fmu.start(parameters | {"initial.theta": theta, "tau": bias})
    for _ in range(round(seconds / PERIOD)):
        angles.append(fmu.real("theta"))
        inputs = [MIDDLE - angles[-1]]
        if system.ninputs == 3:
            inputs = [MIDDLE, angles[-1], fmu.real("omega")]
        fmu.set("tau", bias + float(system.C[0] @ x + system.D[0] @ inputs))
        x = system.A @ x + system.B @ inputs
        fmu.step(PERIOD)
    return np.array(angles)


def test_a_stable_cycle_of_a_quadratic_damper(slave):
    """The damper limits the swing before the stops do. The border below is confirmed too."""
    parameters = {"damper.q_load": 2000.0, "damper.q_release": 2000.0, "inertia.follower_mass": 2.0}
    found = analysed(pi_controller(50.0, 2000.0), parameters)
    assert found.holds is True and found.rests is False
    border, cycle = found.predicted
    assert (border.stable, cycle.stable) == (False, True)
    measured = swing(stepped(slave, pi_controller(50.0, 2000.0), parameters, 1.1, 4.0)[-2000:], PERIOD)
    assert (cycle.amplitude, cycle.frequency) == pytest.approx(measured, rel=0.1)
    (motion,) = found.simulated
    assert (motion.amplitude, motion.frequency) == pytest.approx(measured, rel=0.01)


def test_a_slow_cycle_of_an_integrator(slave):
    """The controller of the tutorial: long rests, so the balance of the torque, with higher harmonics."""
    s = control.tf("s")
    controller = control.sample_system(control.ss(22.0 / (s * (0.3 * s + 1) ** 2)), PERIOD)
    stable = [one for one in analysed(controller, check=False).predicted if one.stable]
    (cycle,) = stable
    assert cycle.sinusoid == "torque"
    measured = swing(stepped(slave, controller, {}, 0.3, 60.0)[-30_000:], PERIOD)
    assert (cycle.amplitude, cycle.frequency) == pytest.approx(measured, rel=0.05)


EXCESS = {
    f"cam{i}.{name}": value
    for i in (1, 2)
    for name, value in (("friction_peak", 1.5), ("stribeck_velocity", 1e-3), ("stribeck_exponent", 1))
}


def test_hunting_of_a_static_excess_is_warned_of(slave):
    """The integral winds through the stick band, the cam jumps past the reference, and so on. No describing
    function knows these jumps. With Coulomb friction the same loop rests."""
    controller = pi_controller(20.0, 200.0)
    found = analysed(controller, EXCESS, duration=40.0)
    assert not found.holds
    hunting = [motion for motion in found.simulated if motion.amplitude < 0.1]
    assert len(hunting) == 1
    assert any("hunts" in text and "does not hold" in text for text in found.findings)
    angles = stepped(slave, controller, EXCESS, MIDDLE + 0.15, 30.0)[-20_000:]
    assert hunting[0].amplitude == pytest.approx(0.5 * np.ptp(angles), rel=0.1)
    calm = stepped(slave, controller, {}, MIDDLE + 0.15, 5.0)[-2000:]
    assert np.ptp(calm) < 1e-3


# ---- the torque of a swing ----

LAWS = {
    "Coulomb": {},
    "Gauss": {"friction_peak": 1.6, "stribeck_velocity": 0.05, "stribeck_exponent": 2},
    "Tustin": {
        "friction_peak": 1.4,
        "stribeck_velocity": 0.1,
        "stribeck_exponent": 1,
        "friction_viscous": 0.3,
    },
}


@pytest.mark.parametrize("law", LAWS)
def test_swing_torque_is_the_integral_of_its_definition(law):
    values = {
        "friction_peak": 1.0,
        "stribeck_velocity": 0.01,
        "stribeck_exponent": 2,
        "friction_viscous": 0.0,
    }
    values |= LAWS[law]
    mass, damping, viscous, amplitude, frequency = 0.5, 30.0, 0.01, 0.3, 20.0
    parameters = {f"cam{i}.{name}": value for i in (1, 2) for name, value in LAWS[law].items()}
    parameters |= {
        "inertia.follower_mass": mass,
        "damper.c_load": damping,
        "damper.c_release": damping,
        "shaft.damping": viscous,
    }

    def torque(phase):
        theta, omega = MIDDLE + amplitude * math.sin(phase), amplitude * frequency * math.cos(phase)
        alpha, sigma = -amplitude * frequency**2 * math.sin(phase), math.copysign(1.0, omega)
        ratio = abs(omega) * LIFT * math.sqrt(2.0) / values["stribeck_velocity"]
        fall = math.exp(-(ratio ** values["stribeck_exponent"]))
        mu = 0.14 * (1.0 + (values["friction_peak"] - 1.0) * fall)
        mu += values["friction_viscous"] * abs(omega) * LIFT * math.sqrt(2.0)
        axial = PRELOAD + LIFT * (STIFFNESS * theta + damping * omega + mass * alpha)
        assert axial > 0.0
        slide = LIFT * (1.0 + sigma * mu) / (1.0 - sigma * mu) * axial
        return INERTIA * alpha + viscous * omega + slide

    halves = ((-0.5 * math.pi, 0.5 * math.pi), (0.5 * math.pi, 1.5 * math.pi))
    sine, cosine = (
        sum(quad(lambda p, f=f: torque(p) * f(p), *half, epsabs=1e-12, limit=200)[0] for half in halves)
        for f in (math.sin, math.cos)
    )
    expected = complex(sine, cosine) / (math.pi * amplitude)
    found = CamHysteresis(FORWARD, MIDDLE, parameters=parameters).swing_torque(amplitude, frequency)
    assert found == pytest.approx(expected, rel=1e-8)


def test_swing_torque_is_that_of_the_inverse_fmu():
    """A groove that steepens, different laws in the cams."""
    parameters = {
        "cam2.profile": 2,
        "cam2.ellipse_curvature": 1,
        "cam2.lead_angle": 0.7,
        "cam2.radius": 0.025,
        "cam1.friction_peak": 1.5,
        "cam1.stribeck_velocity": 0.1,
        "cam2.friction_viscous": 0.2,
    }
    amplitude, frequency, middle = 0.4, 30.0, 0.6
    found = CamHysteresis(FORWARD, middle, parameters=parameters).swing_torque(amplitude, frequency)
    points, weights = leggauss(64)
    total = 0.0
    with Fmu("inverse") as inverse:
        runs = RepeatedStart(inverse, parameters, ["theta", "omega", "alpha"])
        for shift in (0.0, 2.0):
            for phase, weight in zip(0.5 * np.pi * (points + shift), 0.5 * np.pi * weights, strict=True):
                wave = amplitude * np.array(
                    [np.sin(phase), frequency * np.cos(phase), -(frequency**2) * np.sin(phase)]
                )
                runs.initialize(np.add(wave, [middle, 0.0, 0.0]))
                total += weight * inverse.real("tau") * np.exp(-1j * phase)
    assert found == pytest.approx(complex(1j * total / (np.pi * amplitude)), rel=1e-6)


# ---- refusals ----


def test_refused():
    hysteresis = CamHysteresis(FORWARD, MIDDLE)
    with refused("dt = 0", "sample_system"):
        hysteresis.limit_cycles(control.tf([1.0, 2.0], [1.0, 0.0]))
    with refused("dt = None", "sampled controller"):
        hysteresis.limit_cycles(control.ss(1.0, 1.0, 1.0, 1.0, None))
    for duration in (0.0, math.nan, "10"):
        with refused("duration"):
            hysteresis.limit_cycles(pi_controller(5.0, 20.0), duration=duration)
    with refused("tau = 3", error=OperatingPointError):
        CamHysteresis(FORWARD, MIDDLE, tau=3.0).limit_cycles(pi_controller(5.0, 20.0))
    for amplitude, frequency in ((0.0, 1.0), (UPPER, 1.0), (0.1, 0.0), (math.nan, 1.0)):
        with refused("amplitude", error=OperatingPointError):
            hysteresis.swing_torque(amplitude, frequency)


def test_values_that_are_no_controller_and_no_angle_are_refused():
    hysteresis = CamHysteresis(FORWARD, MIDDLE)
    for wrong in (50.0, "PI", None):
        with refused("controller = ", "control.StateSpace"):
            hysteresis.limit_cycles(wrong)
    for wrong in (control.ss(1.0, 1.0, 1.0, math.nan, PERIOD), control.tf([math.inf], [1.0, 0.0], PERIOD)):
        with refused("coefficients", "finite"):
            hysteresis.limit_cycles(wrong)
    with refused("degree"):
        hysteresis.limit_cycles(control.tf([1.0, 2.0, 3.0], [1.0, 0.0], PERIOD))
    for theta in ("40 deg", math.nan, None, True):
        with refused("theta = ", "finite number", error=OperatingPointError):
            CamHysteresis(FORWARD, theta)
    with refused("tau = '3'", error=OperatingPointError):
        CamHysteresis(FORWARD, MIDDLE, tau="3")


def test_a_run_of_too_many_samples_is_refused():
    with refused(
        "duration = 200 s", "period of 1e-09 s", "allowed are 4e\\+06", "up to 0.004 s", "from 5e-05 s"
    ):
        CamHysteresis(FORWARD, MIDDLE).limit_cycles(pi_controller(5.0, 20.0, period=1e-9))


def test_a_controller_with_the_wrong_sign_is_held_at_the_stops():
    found = analysed(pi_controller(-50.0, -2000.0), duration=3.0)
    texts = [text for text in found.findings if "held at" in text]
    assert ["lower stop, 0 rad" in text and "upper" not in text for text in texts] == [True, False]
    assert all("sign of the controller" in text for text in texts)
    assert not any("longer duration" in text for text in found.findings)


def test_a_gain_of_the_wrong_sign_does_not_hold():
    """Without an integral the torque stays the same on a stop: the cam rests there, far from theta."""
    controller = control.ss([], [], [], -50.0, PERIOD)
    hysteresis = CamHysteresis(FORWARD, 0.5)
    with pytest.warns(LimitCycleWarning, match="sign of the controller"):
        found = hysteresis.limit_cycles(controller, duration=3.0)
    assert found.holds is False and found.predicted == () and found.simulated == ()
    assert [text.split(", the FMU")[0].count("rad (") for text in found.findings] == [2, 2]


def test_a_weak_gain_of_the_wrong_sign_is_held_by_the_spring():
    """Both edges of the band rise more steeply over the angle than the torque."""
    assert RHO[1] * STIFFNESS * LIFT > RHO[-1] * STIFFNESS * LIFT > 3.0
    found = analysed(control.ss([], [], [], -3.0, PERIOD), duration=3.0)
    assert found.holds is True and found.findings == ()


@pytest.mark.parametrize("pole", [1.5, 40.0])
def test_an_unstable_controller_is_said_to_be_one(pole):
    """On a stop the torque is multiplied by the pole each period: 1e12 N.m in 73 periods at a pole of 1.5."""
    controller = control.ss(pole, 1.0, 1.0, 0.0, PERIOD)
    found = analysed(controller)
    assert found.holds is False and found.simulated == ()
    assert found.findings and all(
        "grow beyond 1e+12 N.m" in text and f"pole of magnitude {pole:g}, allowed" in text
        for text in found.findings
    )
    (text,) = analysed(controller, check=False).findings
    assert f"unstable: it has a pole of magnitude {pole:g}" in text and "Run the check" in text


def test_an_unstable_mode_that_the_torque_does_not_show():
    """The state of the pole 1.5 passes the largest double in 1751 periods: the torque is no number then."""
    controller = control.ss(np.diag([1.0, 1.5]), [[PERIOD], [1.0]], [[200.0, 0.0]], 0.0, PERIOD)
    text = analysed(controller).findings[-1]
    assert "or a state beyond 1e308" in text and "pole of magnitude 1.5, allowed" in text


@pytest.mark.parametrize("state_space", [(1.0, 0.0, 1.0), (1.0, PERIOD, 0.0)])
def test_an_integrator_without_effect_lets_the_cam_rest(state_space):
    found = analysed(control.ss(*state_space, 0.0, PERIOD), duration=20.0)
    assert found.holds is True and found.findings == ()


@pytest.mark.parametrize("damping", [0.0, 0.02])
def test_without_friction_the_loop_is_linear(damping):
    """It rests where all poles of the sampled linear loop are inside the unit circle."""
    law, none = pi_controller(5.0, 20.0), {"cam1.friction": 0.0, "cam2.friction": 0.0}
    plant = control.sample_system(control.tf([1.0], [INERTIA, damping, STIFFNESS * LIFT**2]), PERIOD)
    poles = control.feedback(plant * control.tf(law)).poles()
    found = analysed(law, none | {"shaft.damping": damping})
    assert found.predicted == ()
    assert found.holds is bool(np.abs(poles).max() < 1.0) is (damping > 0.0) is (not found.simulated)


@pytest.mark.parametrize(("theta", "integral"), [(0.2, 1.0), (0.6, 3.0), (0.6, 40.0), (1.0, 10.0)])
def test_trial_points_that_overflow_end_no_search(theta, integral):
    """The border scales with the spring's torque, so that at 0.8 rad tells those elsewhere."""
    z = control.tf([1, 0], [1], PERIOD)
    law = 300.0 + integral / (z - 1.0) + 200.0 * (z - 1.0) / (z - 0.8187)
    (border,), (other,) = (
        CamHysteresis(FORWARD, angle).limit_cycles(law, check=False).predicted for angle in (theta, 0.8)
    )
    load, other_load = (PRELOAD + STIFFNESS * LIFT * angle for angle in (theta, 0.8))
    assert not border.stable
    assert border.frequency == pytest.approx(other.frequency, rel=1e-6)
    assert border.amplitude / load == pytest.approx(other.amplitude / other_load, rel=1e-5)


def test_a_loop_that_creeps_is_told_how_far_and_how_long():
    """With a slow integrator the angle creeps, or sticks under a torque that grows on."""
    found = analysed(pi_controller(20.0, 5.0), duration=2.0)
    (text,) = found.findings
    ends = r"\(([\d.]+) to ([\d.]+) rad at the end, moved by ([\d.e-]+) rad in the last 0.8 s"
    low, high, moved = map(float, re.search(ends, text).groups())
    assert moved == pytest.approx(high - low, rel=0.05)
    assert "try duration=10" in text and found.rests is False
    longest = 4e6 * PERIOD  # s
    (text,) = analysed(pi_controller(20.0, 1e-5), duration=0.5 * longest).findings
    assert text.endswith(f"try duration={longest:g}")
    (text,) = analysed(pi_controller(20.0, 1e-5), duration=longest).findings
    assert text.endswith("This is the longest duration that the period of 0.001 s allows")


def test_ranges_are_shown_with_digits_that_differ():
    """Slow integrators: at the end of the run the cam creeps, or rests off the reference."""
    slow, crawling = (analysed(pi_controller(20.0, integral), duration=2.0) for integral in (5.0, 0.01))
    texts = [text for found in (slow, crawling) for text in found.findings]
    assert len(texts) == 2 and all("longer duration decides" in text for text in texts)
    ranges = re.findall(r"\(([\d.]+) to ([\d.]+) rad", " ".join(texts))
    assert ranges and all(low != high for low, high in ranges)
    assert "sticks while the torque goes on to change" in texts[1]


def test_without_inertia_only_slow_cycles_are_looked_for():
    found = analysed(pi_controller(5.0, 20.0), {"inertia.shaft": 0.0}, check=False)
    assert found.predicted == ()
