"""From FMU file to plant, linear model, controller, limit cycle: dualcam under python-control.

Held against closed forms of the helix, high-order differences of the co-simulation FMU, and loops around it.
"""

import gc
import math
import random
import warnings
from itertools import pairwise
from pathlib import Path

import control
import matplotlib.pyplot as plt
import numpy as np
import pytest
from driver import models
from mechanisms import ELLIPSES, FOLLOWER, FORCES, GROOVES, INERTIA, LIFT, PRELOAD, RHO, STIFFNESS
from numpy.polynomial import Chebyshev
from scipy.integrate import quad

import dualcam
from dualcam import CamHysteresis, ContinuousFmu, Fmu, FmuError, OperatingPointError

FORWARD, INVERSE = (model.fmu for model in models.values())
PERIOD = 1e-3

UPPER = 1.3963  # rad, the upper stop of the start values
ALL = FOLLOWER | FORCES
LOCKING = {"cam1.lead_angle": 0.1, "cam2.lead_angle": 0.1}


def edge(direction, theta, F_ext=0.0):
    """Of the default helices' stick band, N.m."""
    return RHO[direction] * (PRELOAD + STIFFNESS * LIFT * theta + F_ext)


def refused(*mentions, error=FmuError):
    """Expects that error, a ValueError that says all of this."""
    assert issubclass(error, ValueError)
    return pytest.raises(error, match="".join(f"(?=(?s:.*){mention})" for mention in mentions))


@pytest.fixture(scope="module")
def slave():
    with Fmu(FORWARD) as fmu:
        yield fmu


@pytest.fixture(scope="module")
def continuous():
    return dualcam.to_nonlinear_io_system(FORWARD)


@pytest.fixture(scope="module")
def sampled():
    return dualcam.to_nonlinear_io_system(FORWARD, period=PERIOD)


# ---- the continuous plant ----


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


# ---- the sampled plant ----


def torques(count, period):
    return 3.0 + 6.0 * np.sin(2.0 * np.pi * 3.0 * period * np.arange(count))


@pytest.mark.parametrize("period", [1e-4, 1e-3, 0.0123, 0.3])
@pytest.mark.parametrize(
    "parameters",
    [{}, {"stop.restitution": 0.5}, GROOVES["mixed"] | ALL],
    ids=["helices", "bounces", "all"],
)
def test_a_sampled_plant_is_the_stepped_fmu(slave, parameters, period):
    """Through stick, slip, stops and bounces; all that it forgets between periods is the mode."""
    count = max(200, round(0.3 / period))
    system = dualcam.to_nonlinear_io_system(FORWARD, "tau", None, parameters, period)
    time = period * np.arange(count + 1)
    found = control.input_output_response(system, time, torques(count + 1, period), [0.5, 1.0])
    slave.start(parameters | {"initial.theta": 0.5, "initial.omega": 1.0})
    command, outputs = slave.reals("tau"), slave.reals("theta", "omega", "z", "v")
    events = slave.get("events")
    for k, tau in enumerate(torques(count + 1, period)):
        assert found.outputs[:, k] == pytest.approx(outputs.read(), rel=1e-7, abs=1e-9)
        command.values[0] = tau
        command.write()
        slave.step(period)
    assert slave.get("events") > events


def test_a_sampled_plant_forgets(sampled):
    states = [(0.5, 2.0, 3.0), (0.5, -2.0, 3.0), (0.5, 0.0, 3.0), (1.3963, 1.0, 5.0), (0.9, 0.0, 9.0)]
    order = states * 5
    random.Random(2).shuffle(order)
    found = {}
    for theta, omega, tau in order:
        x = sampled.dynamics(0.0, [theta, omega], [tau, 0.0]).tolist()
        sampled.output(0.0, [0.1, 0.0], [0.0, 0.0])
        assert found.setdefault((theta, omega, tau), x) == x


def test_without_inertia_it_is_the_play_of_the_torque():
    system = dualcam.to_nonlinear_io_system(FORWARD, "tau", "theta", {"inertia.shaft": 0.0}, 0.01)
    theta = 0.5
    for tau in (3.0, 4.5, 4.0, 3.0, 2.0, 6.0):
        low, high = ((tau / RHO[sign] - PRELOAD) / (STIFFNESS * LIFT) for sign in (+1, -1))
        theta, wanted = system.dynamics(0.0, [theta, 0.0], [tau])[0], min(max(theta, low), high)
        assert theta == pytest.approx(wanted, rel=1e-12)


def test_other_outputs_and_an_input_left_out():
    outputs = ["alpha", "mode", "torque_load", "cam1.reaction", "theta"]
    for period in (None, PERIOD):
        system = dualcam.to_nonlinear_io_system(FORWARD, "tau", outputs, {"F_ext": 25.0}, period)
        assert system.output_labels == ["alpha", "mode", "torque_load", "cam1_reaction", "theta"]
        found = dict(zip(outputs, system.output(0.0, [0.5, 2.0], [3.0]), strict=True))
        assert found["alpha"] == pytest.approx((3.0 - edge(+1, 0.5, 25.0)) / INERTIA, rel=1e-9)
        assert found["torque_load"] == pytest.approx(edge(+1, 0.5, 25.0), rel=1e-12)
        assert (found["mode"], found["theta"]) == (2.0, 0.5)
        assert found["cam1.reaction"] > 0.0


def test_a_handle_gives_its_parameters(slave):
    slave.start({"spring.preload": 80.0, "initial.theta": 1.0})
    for system in (
        dualcam.to_nonlinear_io_system(slave, outputs="torque_load"),
        dualcam.to_nonlinear_io_system(slave, outputs="torque_load", period=PERIOD),
    ):
        assert system.output(0.0, [0.5, 0.0], [3.0, 0.0]) == pytest.approx(RHO[+1] * (80.0 + 250.0))
    assert slave.get("theta") == 1.0  # itself it stays as it is
    with ContinuousFmu(FORWARD) as fmu:
        fmu.start({"inertia.shaft": 0.004})
        assert dualcam.linearize(fmu, 0.5, 1.0).B[1, 0] == pytest.approx(250.0)


def test_systems_free_their_fmu():
    system = dualcam.to_nonlinear_io_system(FORWARD)
    directory = Path(system._fmu._instance._directory)
    assert directory.exists()
    del system
    gc.collect()
    assert not directory.exists()


# ---- linear models ----


def central(f, x, h):
    """Derivative by central differences of order 6."""
    weights = {1: 45.0, 2: -9.0, 3: 1.0}
    return math.fsum(w * (f(x + k * h) - f(x - k * h)) for k, w in weights.items()) / (60.0 * h)


def close(found, expected, scale):
    assert abs(found - expected) <= 1e-6 * max(abs(expected), 1e-6 * scale), (found, expected)


def columns(read, point, sizes, one_sided=()):
    """Partial derivatives of `read`, an array, by each of `point`: differences, or, where there is something
    else on the other side, the slope of a polynomial through points on this side."""
    found = []
    for i, size in enumerate(sizes):

        def along(value, i=i):
            return np.array(read(*[value if j == i else x for j, x in enumerate(point)]))

        rows = len(along(point[i]))
        if i in one_sided:
            way = one_sided[i] * size
            nodes = 0.5 * (1.0 - np.cos(np.pi * (np.arange(10) + 0.5) / 10))
            values = np.array([along(point[i] + way * node) for node in nodes])
            fits = [Chebyshev.fit(nodes, values[:, row], 9, domain=[0, 1]) for row in range(rows)]
            found.append([fit.deriv()(0.0) / way for fit in fits])
        else:
            found.append([central(lambda x, row=row: along(x)[row], point[i], size) for row in range(rows)])
    return np.array(found).T


@pytest.fixture
def reader(slave):
    """alpha, z and v of the co-simulation FMU, started at a point."""

    def reader(parameters):
        def read(theta, omega, tau, F_ext):
            slave.start(
                parameters | {"initial.theta": theta, "initial.omega": omega, "tau": tau, "F_ext": F_ext}
            )
            return [slave.get(name) for name in ("alpha", "z", "v")]

        return read

    return reader


def compare(model, found, alpha):
    """A model against partial derivatives of alpha, z and v by theta, omega, tau and F_ext."""
    expected = {"A": np.vstack([[0.0, 1.0], found[:1, :2]]), "B": np.vstack([[0.0, 0.0], found[:1, 2:]])}
    expected["C"] = np.vstack([np.eye(2), found[1:, :2]])
    expected["D"] = np.vstack([np.zeros((2, 2)), found[1:, 2:]])
    for name, matrix in expected.items():
        actual = getattr(model, name)
        assert actual.shape == matrix.shape
        for a, e in zip(actual.ravel(), matrix.ravel(), strict=True):
            close(a, e, max(1.0, abs(alpha)))


@pytest.mark.parametrize("groove", GROOVES)
@pytest.mark.parametrize("omega", [3.0, -3.0])
@pytest.mark.parametrize("F_ext", [10.0, -400.0])
def test_a_linear_model_of_slip_is_that_of_differences(reader, groove, omega, F_ext):
    parameters = GROOVES[groove] | ALL
    model = dualcam.linearize(FORWARD, 0.6, omega, 2.0, F_ext, parameters=parameters)
    read = reader(parameters)
    point = (0.6, omega, 2.0, F_ext)
    assert model.operating_point.alpha == pytest.approx(read(*point)[0], rel=1e-12)
    compare(model, columns(read, point, (1e-3, 1e-2, 1e-2, 0.1)), model.operating_point.alpha)
    assert model.input_labels == ["tau", "F_ext"]
    assert model.output_labels == ["theta", "omega", "z", "v"]
    assert model.state_labels == ["theta", "omega"]


@pytest.mark.parametrize("groove", GROOVES)
@pytest.mark.parametrize(("at_rest", "direction"), [("loading", 1), ("releasing", -1)])
def test_a_linear_model_of_slip_about_to_begin(reader, groove, at_rest, direction):
    """At the edge of the band slip goes on to one side only: differences by the speed are one-sided, those by
    theta and tau at a speed that is as good as none."""
    parameters = GROOVES[groove] | ALL
    model = dualcam.linearize(FORWARD, 0.6, F_ext=10.0, at_rest=at_rest, parameters=parameters)
    at = model.operating_point
    read = reader(parameters)
    rest = read(0.6, 0.0, at.tau, 10.0)
    assert (at.theta, at.omega, at.F_ext) == (0.6, 0.0, 10.0)
    assert at.alpha == pytest.approx(0.0, abs=1e-9)
    assert rest[0] == pytest.approx(0.0, abs=1e-9)
    assert read(0.6, 0.0, at.tau + direction * 1e-3, 10.0)[0] * direction > 0.0
    assert read(0.6, 0.0, at.tau - direction * 1e-3, 10.0)[0] == 0.0
    tiny = direction * 1e-10
    found = columns(read, (0.6, tiny, at.tau, 10.0), (1e-3, 0.3, 1e-2, 0.1), one_sided={1: direction})
    compare(model, found, 1.0)


def test_the_torque_that_keeps_a_speed(reader):
    for groove, omega in ((groove, omega) for groove in GROOVES for omega in (4.0, -4.0)):
        parameters = GROOVES[groove] | ALL
        point = dualcam.linearize(FORWARD, 0.6, omega, parameters=parameters).operating_point
        size = ALL["shaft.damping"] / INERTIA
        assert reader(parameters)(0.6, omega, point.tau, 0.0)[0] == pytest.approx(0.0, abs=1e-9 * size)
        assert point.mode == (2 if omega > 0.0 else 3)


def test_frozen_nothing_moves():
    model = dualcam.linearize(FORWARD, 0.5, at_rest="frozen", inputs="tau", outputs=["theta", "z"])
    assert not model.A.any()
    assert not model.B.any()
    assert model.C.tolist() == [[1.0, 0.0], [pytest.approx(LIFT), 0.0]]
    point = model.operating_point
    assert edge(-1, 0.5) < point.tau < edge(+1, 0.5)
    assert (point.alpha, point.mode) == (0.0, 1)
    assert dualcam.linearize(FORWARD, 0.5, tau=3.0, at_rest="frozen").operating_point.tau == 3.0
    slips = dualcam.linearize(FORWARD, 0.5, tau=5.0)
    assert slips.operating_point.alpha == pytest.approx((5.0 - edge(+1, 0.5)) / INERTIA)


def step_columns(slave, parameters, point, period):
    """Partial derivatives of one step's end by theta, omega, tau, F_ext."""

    def read(theta, omega, tau, F_ext):
        slave.start(
            parameters | {"initial.theta": theta, "initial.omega": omega, "tau": tau, "F_ext": F_ext},
            tolerance=1e-12,
        )
        slave.step(period)
        return [slave.get("theta"), slave.get("omega")]

    return columns(read, point, (1e-3, 1e-2, 1e-2, 0.1))


def test_a_sampled_model_of_helices_is_exact(slave):
    parameters = {"shaft.damping": 0.01, "damper.c_load": 20.0, "inertia.follower_mass": 0.3}
    for period in (1e-3, 0.01):
        model = dualcam.linearize(FORWARD, 0.4, 5.0, 4.0, parameters=parameters, period=period)
        found = step_columns(slave, parameters, (0.4, 5.0, 4.0, 0.0), period)
        assert model.dt == period
        assert np.hstack([model.A, model.B]) == pytest.approx(found, rel=1e-6, abs=1e-9)


def test_elsewhere_a_sampled_model_is_right_to_first_order(slave):
    """Its error is a share of what a period does that is proportional to the period."""
    parameters = ELLIPSES | ALL
    errors = []
    for period in (4e-3, 2e-3, 1e-3):
        model = dualcam.linearize(FORWARD, 0.6, 5.0, 4.0, parameters=parameters, period=period)
        found = step_columns(slave, parameters, (0.6, 5.0, 4.0, 0.0), period)
        change = np.hstack([np.eye(2), np.zeros((2, 2))])
        errors.append(np.abs((model.A - found[:, :2])[1, 0] / (found - change)[1, 0]))
    assert errors[2] < 0.02
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(2.0, rel=0.15)


def test_linearize_of_python_control_is_the_same(continuous):
    ours = dualcam.linearize(FORWARD, 0.5, 2.0, 3.0)
    for theirs in (
        control.linearize(continuous, [0.5, 2.0], [3.0, 0.0]),
        control.linearize(continuous, control.OperatingPoint([0.5, 2.0], [3.0, 0.0], None, None)),
        continuous.linearize([0.5, 2.0], [3.0, 0.0], name="slip", inputs=["u0", "u1"]),
    ):
        for name in "ABCD":
            assert getattr(theirs, name) == pytest.approx(getattr(ours, name))
    assert (theirs.name, theirs.input_labels) == ("slip", ["u0", "u1"])
    renamed = dualcam.to_nonlinear_io_system(FORWARD, "tau", "z")
    renamed.update_names(inputs="torque", outputs="lift")
    theirs = control.linearize(renamed, [0.5, 2.0], 3.0)
    assert (theirs.input_labels, theirs.output_labels) == (["torque"], ["lift"])
    assert theirs.C[0, 0] == pytest.approx(LIFT)
    with refused("sticks", "at_rest", error=OperatingPointError):
        control.linearize(continuous, [0.5, 0.0], [3.0, 0.0])


def test_bode_of_the_linear_model_is_an_oscillator():
    """theta = tau/(J s^2 + rho k z'), and z = z' theta."""
    model = dualcam.linearize(FORWARD, 0.5, at_rest="loading", inputs="tau", outputs=["theta", "z"])
    omega = np.array([1.0, 10.0, 40.0, 100.0, 1000.0])
    expected = 1.0 / (RHO[+1] * STIFFNESS * LIFT - INERTIA * omega**2)
    response = control.frequency_response(model, omega)
    assert response.complex[0, 0] == pytest.approx(expected, rel=1e-9)
    assert response.complex[1, 0] == pytest.approx(LIFT * expected, rel=1e-9)
    plot = control.bode_plot(model[0, 0], omega)
    drawn = plot.lines[0, 0][0].get_ydata()
    assert drawn == pytest.approx(np.abs(expected), rel=1e-9)
    plt.close(plot.figure)


# ---- controllers ----


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


# ---- hysteresis and limit cycles ----


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


# ---- bad input ----


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
        with refused("DualCamInverse", r"use DualCamForward\.fmu"):
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
    with refused("no play", error=OperatingPointError):
        CamHysteresis(FORWARD, 1.0, parameters=soft)


def test_hysteresis_of_what_is_no_play():
    with refused("no play", "atan", error=OperatingPointError):
        CamHysteresis(FORWARD, 0.5, parameters=LOCKING)
    with refused("between the stops", error=OperatingPointError):
        CamHysteresis(FORWARD, 1.5)
