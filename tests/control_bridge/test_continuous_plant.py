"""The bridge to python-control: the continuous plant."""

import copy
import random

import control
import numpy as np
import pytest
from control_cases import ALL, FORWARD, LOCKING, PERIOD, UPPER, edge
from mechanisms import GROOVES, INERTIA, LIFT

import dualcam


def test_names_and_sizes(continuous, sampled):
    for system, dt in ((continuous, 0), (sampled, PERIOD)):
        assert isinstance(system, control.NonlinearIOSystem)
        assert system.input_labels == ["tau", "F_ext"]
        assert system.output_labels == ["theta", "omega", "z", "v"]
        assert system.state_labels == ["theta", "omega"]
        assert (system.dt, system.name) == (dt, "cam")


RATES = {
    "loading": (0.5, 2.0, 3.0, 0.0, (3.0 - edge(+1, 0.5)) / INERTIA),
    "releasing": (0.5, -2.0, 3.0, 0.0, (3.0 - edge(-1, 0.5)) / INERTIA),
    "a force": (0.5, 2.0, 3.0, 25.0, (3.0 - edge(+1, 0.5, 25.0)) / INERTIA),
    "rest in the band": (0.5, 0.0, 3.0, 0.0, 0.0),
    "rest above it": (0.5, 0.0, 4.5, 0.0, (4.5 - edge(+1, 0.5)) / INERTIA),
    "rest below it": (0.5, 0.0, 1.0, 0.0, (1.0 - edge(-1, 0.5)) / INERTIA),
    "on the upper stop": (UPPER, 0.0, 50.0, 0.0, 0.0),
    "off the upper stop": (UPPER, 0.0, 1.0, 0.0, (1.0 - edge(-1, UPPER)) / INERTIA),
    "leaving it": (UPPER, -1.0, 50.0, 0.0, (50.0 - edge(-1, UPPER)) / INERTIA),
    "on the lower stop": (0.0, 0.0, -5.0, 0.0, 0.0),
}


@pytest.mark.parametrize("case", RATES)
def test_rates_are_those_of_the_inclusion(continuous, case):
    theta, omega, tau, F_ext, alpha = RATES[case]
    found = continuous.dynamics(0.0, [theta, omega], [tau, F_ext])
    assert found == pytest.approx([omega, alpha], rel=1e-9, abs=1e-12)
    outputs = continuous.output(0.0, [theta, omega], [tau, F_ext])
    assert outputs == pytest.approx([theta, omega, LIFT * theta, LIFT * omega], rel=1e-12)


def test_rates_depend_on_nothing_but_state_and_input():
    """Also where contacts lock, and flanks and mode would be remembered."""
    system = dualcam.to_nonlinear_io_system(FORWARD, parameters=LOCKING)
    states = [(0.5, 2.0, 3.0), (0.5, -2.0, -1.0), (0.5, 0.0, 0.0), (1.3963, 1.0, 5.0), (0.0, -1.0, -5.0),
              (0.9, 0.0, 9.0), (0.2, 1e-9, -9.0)]  # fmt: skip
    order = states * 5
    random.Random(1).shuffle(order)
    found = {}
    for theta, omega, tau in order:
        rates = system.dynamics(0.0, [theta, omega], [tau, 0.0]).tolist()
        assert found.setdefault((theta, omega, tau), rates) == rates


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, lambda plant: plant.copy()])
def test_copies_of_the_plant(continuous, copied):
    twin = copied(continuous)
    for theta, omega, tau, F_ext, alpha in RATES.values():  # in turn, on one FMU
        for system in (twin, continuous):
            found = system.dynamics(0.0, [theta, omega], [tau, F_ext])
            assert found == pytest.approx([omega, alpha], rel=1e-9, abs=1e-12)
    ours, theirs = (system.linearize([0.5, 2.0], [3.0, 0.0]) for system in (twin, continuous))
    assert np.array_equal(ours.A, theirs.A) and np.array_equal(ours.B, theirs.B)


@pytest.mark.filterwarnings("ignore:duplicate object found:UserWarning", "ignore:Unused output:UserWarning")
@pytest.mark.parametrize("twice", [lambda plant: [plant] * 2, lambda plant: [plant, plant.copy("cam_copy")]])
def test_two_cams_in_one_system(continuous, twice):
    signals = [(cam, place) for cam in (0, 1) for place in (0, 1)]
    both = control.interconnect(twice(continuous), inplist=signals, outlist=signals)
    (theta, omega, tau, F_ext, alpha), (*other, beta) = RATES["loading"], RATES["rest above it"]
    found = both.dynamics(0.0, [theta, omega, *other[:2]], [tau, F_ext, *other[2:]])
    assert found == pytest.approx([omega, alpha, 0.0, beta], rel=1e-9, abs=1e-12)


def test_near_rest_and_into_stops_the_speed_decays(continuous):
    """The set that stands for omega = 0, and what a solver finds beyond a stop."""
    for omega in (5e-4, -5e-4):
        assert continuous.dynamics(0.0, [0.5, omega], [3.0, 0.0]) == pytest.approx([omega, -omega / 1e-3])
    for theta, omega in ((UPPER, 3.0), (UPPER + 1e-3, 3.0), (0.0, -3.0), (-1e-3, -3.0)):
        rate = continuous.dynamics(0.0, [theta, omega], [3.0, 0.0])
        assert rate[0] == 0.0
        assert rate[1] * omega < -1e5


MOTIONS = {
    "up to rest": ({}, 4.5, 0.5, 0.0),
    "up to rest, damped": ({"shaft.damping": 0.05}, 4.5, 0.5, 0.0),
    "slows down to rest": ({}, 3.1, 0.5, 5.0),
    "to the upper stop": ({}, 12.0, 0.5, 0.0),
    "to the lower stop": ({}, -3.0, 0.5, 0.0),
    "turns round": ({}, 6.0, 0.2, -8.0),
    "ellipses": (GROOVES["mixed"] | ALL, 6.0, 0.2, -8.0),
}


@pytest.mark.parametrize("case", MOTIONS)
def test_its_response_is_that_of_co_simulation(case):
    """Which has located events. To the solver's tolerance, and the creep of 1e-6 rad at each rest."""
    parameters, tau, theta, omega = MOTIONS[case]
    time = np.linspace(0.0, 0.2, 201)
    torque = np.full_like(time, tau)
    angles = []
    for period, options in ((PERIOD, {}), (None, {"rtol": 1e-8, "atol": 1e-10, "max_step": 1e-3})):
        system = dualcam.to_nonlinear_io_system(FORWARD, "tau", "theta", parameters, period)
        response = control.input_output_response(
            system, time, torque, [theta, omega], solve_ivp_kwargs=options
        )
        angles.append(response.outputs)
    assert np.ptp(angles[0]) > 0.01
    assert np.abs(angles[0] - angles[1]).max() <= 5e-6


@pytest.mark.parametrize("method", ["RK45", "LSODA", "BDF"])
def test_solvers_of_every_kind_get_through_stick_and_slip(method):
    """With their usual tolerances, in at most some thousand evaluations: no chatter at rest."""
    system = dualcam.to_nonlinear_io_system(FORWARD, "tau", "theta")
    calls = [0]
    update = system.updfcn

    def counted(*arguments):
        calls[0] += 1
        return update(*arguments)

    system.updfcn = counted
    time = np.linspace(0.0, 1.0, 1001)
    torque = 3.0 + 2.5 * np.sin(4.0 * np.pi * time)
    kwargs = {"max_step": 5e-3}
    response = control.input_output_response(
        system, time, torque, [0.5, 0.0], solve_ivp_method=method, solve_ivp_kwargs=kwargs
    )
    assert calls[0] <= 20_000
    fine = dualcam.to_nonlinear_io_system(FORWARD, "tau", "theta", period=1e-4)
    steps = np.arange(10_001) * 1e-4
    middle = 3.0 + 2.5 * np.sin(4.0 * np.pi * (steps + 0.5e-4))
    truth = control.input_output_response(fine, steps, middle, [0.5, 0.0]).outputs[::10]
    assert np.ptp(truth) > 0.1
    assert np.abs(response.outputs - truth).max() <= 5e-3
