"""The bridge to python-control: controllers designed with it."""

import control
import numpy as np
import pytest
from control_cases import FORWARD, PERIOD
from mechanisms import ELLIPSES

import dualcam


def loop_of(parameters, weights):
    """A sampled loop: LQR about slip that is about to begin at 0.4 rad, and its linear model with the
    reference as input, both with deviations of theta and omega as outputs."""
    signals = {"inputs": "tau", "outputs": ["theta", "omega"], "parameters": parameters, "period": PERIOD}
    plant = dualcam.linearize(FORWARD, 0.4, at_rest="loading", **signals)
    point = plant.operating_point
    gain, _, poles = control.dlqr(plant, np.diag(weights), [[1.0]])
    feed = 1.0 / plant.dcgain()[0]

    def law(t, x, u, params):
        reference, theta, omega = u
        return point.tau + feed * (reference - point.theta) - gain @ [theta - reference, omega]

    controller = control.nlsys(
        None, law, inputs=["reference", "theta", "omega"], outputs="tau", dt=PERIOD, name="law"
    )
    cam = dualcam.to_nonlinear_io_system(FORWARD, **signals)
    closed = control.interconnect([cam, controller], inputs="reference", outputs=["theta", "omega"])
    linear = control.ss(plant.A - plant.B @ gain, plant.B * (gain[0, 0] + feed), np.eye(2), 0, PERIOD)
    return closed, linear, poles


def step_error(closed, linear, amplitude):
    """Largest difference of the angles after a step of the reference, in amplitudes."""
    time = PERIOD * np.arange(300)
    step = np.full_like(time, 0.4 + amplitude)
    found = control.input_output_response(closed, time, step, [0.4, 0.0])
    expected = control.forced_response(linear, time, np.full_like(time, amplitude))
    assert np.ptp(expected.outputs[0]) > 0.9 * amplitude
    return np.abs(found.outputs[0] - 0.4 - expected.outputs[0]).max() / amplitude


WEIGHTS = (5e3, 5.0)


def test_lqr_is_stable_and_does_not_overshoot():
    """So that the motion keeps to its direction, the linear model's."""
    for parameters in ({}, ELLIPSES | {"spring.stiffness3": 1e8}):
        poles = np.log(loop_of(parameters, WEIGHTS)[2].astype(complex)) / PERIOD
        assert np.all(poles.real < -5.0)
        assert np.all(poles.imag == 0.0)


def test_step_responses_of_helices_agree_at_any_amplitude():
    """While they load, two helices and a linear spring are linear, whatever the amplitude."""
    closed, linear, _ = loop_of({}, WEIGHTS)
    for amplitude in (0.01, 0.1, 0.5):
        assert step_error(closed, linear, amplitude) <= 1e-12


def test_step_responses_differ_in_proportion_to_the_amplitude():
    closed, linear, _ = loop_of(ELLIPSES | {"spring.stiffness3": 1e8}, WEIGHTS)
    errors = [step_error(closed, linear, amplitude) for amplitude in (0.08, 0.04, 0.02)]
    assert errors[2] <= 0.01
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.1)


def test_a_continuous_lqr_loop_follows_its_linear_model():
    """With the plant from model exchange, until the speed counts as rest."""
    signals = {"inputs": "tau", "outputs": ["theta", "omega"]}
    plant = dualcam.linearize(FORWARD, 0.4, at_rest="loading", **signals)
    gain, _, poles = control.lqr(plant, np.diag(WEIGHTS), [[1.0]])
    assert np.all(poles.real < 0.0)
    tau, feed = plant.operating_point.tau, 1.0 / plant.dcgain()[0]
    law = control.nlsys(
        None,
        lambda t, x, u, params: tau + feed * (u[0] - 0.4) - gain @ [u[1] - u[0], u[2]],
        inputs=["reference", "theta", "omega"],
        outputs="tau",
        name="law",
    )
    cam = dualcam.to_nonlinear_io_system(FORWARD, **signals)
    closed = control.interconnect([cam, law], inputs="reference", outputs=["theta", "omega"])
    linear = control.ss(plant.A - plant.B @ gain, plant.B * (gain[0, 0] + feed), np.eye(2), 0)
    time = np.linspace(0.0, 0.1, 101)
    found = control.input_output_response(
        closed, time, np.full_like(time, 0.5), [0.4, 0.0], solve_ivp_kwargs={"rtol": 1e-8, "atol": 1e-10}
    )
    expected = control.forced_response(linear, time, np.full_like(time, 0.1))
    assert expected.outputs[1, 1:].min() > 1e-3
    assert found.outputs[0] == pytest.approx(0.4 + expected.outputs[0], abs=1e-6)
