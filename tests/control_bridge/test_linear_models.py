"""The bridge to python-control: linear models."""

import math

import control
import matplotlib.pyplot as plt
import numpy as np
import pytest
from control_cases import ALL, FORWARD, edge, refused
from mechanisms import ELLIPSES, GROOVES, INERTIA, LIFT, RHO, STIFFNESS
from numpy.polynomial import Chebyshev

import dualcam
from dualcam.errors import DualcamWarning, OperatingPointError

pytestmark = pytest.mark.filterwarnings("ignore:.*no equilibrium")


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


@pytest.mark.parametrize(
    ("omega", "tau", "steady", "remedy"),
    [
        (0.0, 5.0, edge(+1, 0.5), "give at_rest = 'loading' and leave tau out"),
        (0.0, 1.0, edge(-1, 0.5), "give at_rest = 'releasing' and leave tau out"),
        (2.0, 5.0, edge(+1, 0.5), "keeps the speed: leave tau out"),
    ],
)
def test_a_point_that_is_no_equilibrium_is_said_to_be_none(omega, tau, steady, remedy):
    """Coulomb friction: the torque of steady slip is the edge of the stick band."""
    alpha = (tau - steady) / INERTIA
    text = rf"alpha = {alpha:.4g} rad/s2.* tau = {steady:.4g} N.m .*{remedy}"
    with pytest.warns(DualcamWarning, match=text):
        point = dualcam.linearize(FORWARD, 0.5, omega, tau).operating_point
    assert point.alpha == pytest.approx(alpha)
    plant = dualcam.to_nonlinear_io_system(FORWARD, "tau", "theta")
    with pytest.warns(DualcamWarning, match=text):
        control.linearize(plant, [0.5, omega], tau)


@pytest.mark.filterwarnings("error::dualcam.errors.DualcamWarning")
def test_no_warning_at_an_equilibrium():
    """Also for a torque with four digits of it."""
    for model in ({"at_rest": "loading"}, {"at_rest": "frozen"}, {"tau": 3.0, "at_rest": "frozen"}):
        dualcam.linearize(FORWARD, 0.5, **model)
    dualcam.linearize(FORWARD, 0.5, 2.0)
    dualcam.linearize(FORWARD, 0.5, 2.0, float(f"{edge(+1, 0.5):.4g}"))


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
