"""The bridge to python-control: bad input is refused with a reason."""

import math

import control
import numpy as np
import pytest
from control_cases import FORWARD, INVERSE, LOCKING, PERIOD, UPPER, refused

import dualcam
from dualcam import CamHysteresis
from dualcam.errors import OperatingPointError


def test_bad_signal_names():
    for period in (None, PERIOD):
        with refused("input 'torque'", "tau, F_ext"):
            dualcam.to_nonlinear_io_system(FORWARD, inputs="torque", period=period)
        with refused("'thet'", "did you mean theta"):
            dualcam.to_nonlinear_io_system(FORWARD, outputs=["thet"], period=period)
        with refused("energy.heat_cam1", "step"):
            dualcam.to_nonlinear_io_system(FORWARD, outputs="energy.heat_cam1", period=period)
        with refused("output 'cam1.radius'", "theta, omega"):
            dualcam.to_nonlinear_io_system(FORWARD, outputs="cam1.radius", period=period)
        with refused("inputs", "each once"):
            dualcam.to_nonlinear_io_system(FORWARD, inputs=["tau", "tau"], period=period)
        with refused("inputs", "one or more"):
            dualcam.to_nonlinear_io_system(FORWARD, inputs=[], period=period)
        with refused("cam1.frction", "did you mean cam1.friction"):
            dualcam.to_nonlinear_io_system(FORWARD, parameters={"cam1.frction": 0.1}, period=period)
    with refused("output 'alpha'", "theta, omega, z, v"):
        dualcam.linearize(FORWARD, 0.5, 1.0, outputs="alpha")


@pytest.mark.parametrize("period", [0, 0.0, -1e-3, math.nan, math.inf, True])
def test_bad_periods(period):
    for call in (
        lambda: dualcam.to_nonlinear_io_system(FORWARD, period=period),
        lambda: dualcam.linearize(FORWARD, 0.5, 1.0, period=period),
    ):
        with refused("period", "> 0 in s", "None"):
            call()


def test_dt_is_the_period():
    """python-control's name for it."""
    for call in (
        lambda **given: dualcam.to_nonlinear_io_system(FORWARD, **given),
        lambda **given: dualcam.linearize(FORWARD, 0.5, 1.0, **given),
    ):
        assert call(dt=PERIOD).dt == call(period=PERIOD).dt == PERIOD
        assert call().dt == 0
        with refused("dt = -1", "> 0 in s"):
            call(dt=-1.0)
        with refused("period = 0.01 and dt = 0.02", "one of them"):
            call(period=0.01, dt=0.02)


@pytest.mark.parametrize("period", [None, PERIOD])
def test_params_of_a_run_do_not_reach_the_fmu(period):
    """Those of other systems of a loop do no harm."""
    cam = dualcam.to_nonlinear_io_system(FORWARD, "tau", ["theta", "omega"], period=period)
    time = np.arange(3) * PERIOD
    for key in ("cam1.friction", "cam1_friction", "cam1.frction", "contacts"):
        message = rf"params with {key}: .*parameters=\{{...\}} of to_nonlinear_io_system"
        with refused(message):
            control.input_output_response(cam, time, np.zeros(3), [0.4, 0.0], params={"gain": 1.0, key: 0.1})
        with refused(message):
            control.linearize(cam, [0.4, 1.0], [0.0], params={key: 0.1})
    law = control.nlsys(
        None, lambda t, x, u, p: p["gain"] * u, inputs="e", outputs="tau", params={"gain": 1.0}, dt=cam.dt
    )
    loop = control.interconnect([law, cam], inputs="e", outputs=["theta", "omega"])
    control.input_output_response(loop, time, np.zeros(3), [0.4, 0.0], params={"gain": 2.0})


def test_bad_rest():
    with refused("rest_speed"):
        dualcam.to_nonlinear_io_system(FORWARD, rest_speed=0.0)


def test_the_wrong_fmu(tmp_path):
    text = tmp_path / "text.fmu"
    text.write_text("no FMU")
    for call in (
        lambda path: dualcam.to_nonlinear_io_system(path),
        lambda path: dualcam.to_nonlinear_io_system(path, period=PERIOD),
        lambda path: dualcam.linearize(path, 0.5, 1.0),
        lambda path: CamHysteresis(path, 0.5),
    ):
        with refused("DualCamInverse", 'use "forward"'):
            call(INVERSE)
        with refused("text.fmu", "no FMU"):
            call(text)
        with refused("no file"):
            call(tmp_path / "missing.fmu")


def test_model_exchange_without_inertia():
    nothing = {"inertia.shaft": 0.0}
    with refused("inertia.shaft", "co-simulation needs none"):
        dualcam.to_nonlinear_io_system(FORWARD, parameters=nothing)
    with refused("inertia.shaft"):
        dualcam.linearize(FORWARD, 0.5, 1.0, parameters=nothing)


@pytest.mark.parametrize("period", [None, PERIOD])
@pytest.mark.parametrize("theta", [-0.1, UPPER + 0.1])
def test_a_run_does_not_begin_outside_the_stops(period, theta):
    """Alone and in a loop. Where a solver ended beyond a stop, by 1e-3 of the room, is accepted."""
    plant = dualcam.to_nonlinear_io_system(FORWARD, "tau", "theta", period=period)
    loop = control.interconnect([plant], inputs="tau", outputs="theta")
    time, tau = PERIOD * np.arange(3), np.ones(3)
    for system in (plant, loop):
        with refused(f"theta = {theta:g}", "0" if theta < 0.0 else "1.3963"):
            control.input_output_response(system, time, tau, [theta, 0.0])
        control.input_output_response(system, time, tau, [UPPER, 0.0])
    if period is None:
        control.input_output_response(plant, time, tau, [UPPER + 1e-3, 0.0])


def test_bounces_need_a_sampled_system():
    with refused("stop.restitution", "period"):
        dualcam.to_nonlinear_io_system(FORWARD, parameters={"stop.restitution": 0.3})


@pytest.mark.parametrize(
    ("arguments", "mentions"),
    [
        ({"theta": 0.5}, ("depends on the torque", "at_rest = 'loading'", "tau")),
        ({"theta": 0.5, "tau": 3.0}, ("it sticks", "at_rest = 'loading'", "2.263", "3.97")),
        ({"theta": UPPER, "tau": 50.0}, ("pressed on the upper stop", "give theta below it")),
        ({"theta": 0.0, "tau": -5.0}, ("pressed on the lower stop",)),
        ({"theta": UPPER, "at_rest": "loading"}, ("upper stop", "below it")),
        ({"theta": 2.0, "omega": 1.0}, ("theta = 2 rad", "0 to 1.3963 rad")),
        ({"theta": 0.5, "omega": 1.0, "at_rest": "loading"}, ("allowed is only one of them",)),
        ({"theta": 0.5, "tau": 3.0, "at_rest": "loading"}, ("leave tau out",)),
        ({"theta": 0.5, "tau": 5.0, "at_rest": "frozen"}, ("it slips", "2.263")),
        ({"theta": 0.5, "at_rest": "up"}, ("'up'", '"loading", "releasing", "frozen"')),
    ],
)
def test_operating_points_without_a_model(arguments, mentions):
    with refused(*mentions, error=OperatingPointError):
        dualcam.linearize(FORWARD, **arguments)


def test_a_jammed_cam_has_no_model():
    """Beyond 1/tan(lead) friction lets no torque load it."""
    jams = {"cam1.lead_angle": 1.5, "cam2.lead_angle": 1.5, "stop.upper": 0.05}
    with refused("jam", r"cam1\.lead_angle", r"kappa_1 \+ kappa_2 must be > 0"):
        dualcam.linearize(FORWARD, 0.02, at_rest="loading", parameters=jams)


def test_a_wedged_cam_has_none_in_that_direction():
    """One contact locks by far, the other hardly rubs: no pair of flanks agrees with its reactions."""
    wedges = {"cam1.lead_angle": 0.247, "cam2.lead_angle": 0.458, "inertia.follower": 1e-3}
    wedges |= {"cam1.friction": 1.967, "cam2.friction": 0.095}
    with refused("friction jams it", "releasing", "lead angles", error=OperatingPointError):
        dualcam.linearize(FORWARD, 0.3, at_rest="releasing", parameters=wedges)
    with refused("no torque keeps this speed", error=OperatingPointError):
        dualcam.linearize(FORWARD, 0.3, 3.0, F_ext=-300.0, parameters=wedges)
    with refused("friction wedges it", error=OperatingPointError):
        dualcam.linearize(FORWARD, 0.3, tau=-100.0, parameters=wedges)


def test_lqr_at_a_stick_point_is_told_what_to_do():
    """The error comes before lqr's, which would be about a Riccati equation; with what it says lqr works."""
    with refused("no torque or force has an effect", "to control with", "sticks", "at_rest = 'loading'"):
        control.lqr(dualcam.linearize(FORWARD, 0.5, tau=3.0), np.eye(2), np.eye(2))
    gain, _, _ = control.lqr(dualcam.linearize(FORWARD, 0.5, at_rest="loading"), np.eye(2), np.eye(2))
    assert np.all(np.isfinite(gain))


def test_an_unstable_operating_point_can_be_stabilised():
    """A spring that softens: the torque that holds it falls as it is loaded."""
    soft = {"spring.preload": 400.0, "spring.stiffness": 1e4, "spring.stiffness2": -1e6}
    plant = dualcam.linearize(FORWARD, 1.0, at_rest="loading", inputs="tau", parameters=soft)
    assert plant.poles().real.max() > 1.0
    poles = control.lqr(plant, np.eye(2), [[1.0]])[2]
    assert poles.real.max() < 0.0
    with refused("torque band must rise", error=OperatingPointError):
        CamHysteresis(FORWARD, 1.0, parameters=soft)


def test_hysteresis_of_what_is_no_play():
    with refused("torque band must rise", "atan", error=OperatingPointError):
        CamHysteresis(FORWARD, 0.5, parameters=LOCKING)
    with refused("between the stops", error=OperatingPointError):
        CamHysteresis(FORWARD, 1.5)
