"""Linear models of slip with friction that depends on the sliding speed: their damping has dmu/dv."""

import math

import pytest
import test_linear_models
from control_cases import ALL, FORWARD
from mechanisms import ELLIPSES, GROOVES, INERTIA, LIFT, PRELOAD, STIFFNESS

import dualcam

LAW = {
    "cam1.friction_peak": 1.6,
    "cam1.stribeck_velocity": 0.05,
    "cam1.friction_viscous": 0.3,
    "cam2.friction_peak": 1.3,
    "cam2.stribeck_velocity": 0.08,
    "cam2.stribeck_exponent": 1,
    "cam2.friction_viscous": 0.1,
}
reader = test_linear_models.reader


@pytest.mark.parametrize("groove", GROOVES)
@pytest.mark.parametrize("omega", [3.0, 0.5, -0.5, -3.0])
def test_a_linear_model_of_slip_is_that_of_differences(reader, groove, omega):
    parameters = GROOVES[groove] | ALL | LAW
    model = dualcam.linearize(FORWARD, 0.6, omega, 2.0, 10.0, parameters=parameters)
    found = test_linear_models.columns(reader(parameters), (0.6, omega, 2.0, 10.0), (1e-3, 1e-3, 1e-2, 0.1))
    test_linear_models.compare(model, found, model.operating_point.alpha)


@pytest.mark.parametrize(("at_rest", "direction"), [("loading", 1), ("releasing", -1)])
def test_a_linear_model_of_slip_about_to_begin(reader, at_rest, direction):
    """At the static edge. Friction falls with the speed at once under Tustin's law."""
    parameters = ELLIPSES | ALL | LAW
    model = dualcam.linearize(FORWARD, 0.6, F_ext=10.0, at_rest=at_rest, parameters=parameters)
    at, read = model.operating_point, reader(parameters)
    assert read(0.6, 0.0, at.tau + direction * 1e-3, 10.0)[0] * direction > 0.0
    assert read(0.6, 0.0, at.tau - direction * 1e-3, 10.0)[0] == 0.0
    tiny = direction * 1e-10
    sizes, sides = (1e-3, 0.05, 1e-2, 0.1), {1: direction}
    found = test_linear_models.columns(read, (0.6, tiny, at.tau, 10.0), sizes, one_sided=sides)
    test_linear_models.compare(model, found, 1.0)


def test_damping_at_the_first_motion_of_equal_helices():
    """rho = z' (1 + mu)/(1 - mu), so drho/dmu = 2 z'/(1 - mu)^2, at the static coefficient. Under Tustin's
    law mu falls by mu_k (peak - 1) z' sqrt(2)/v_s per speed of the shaft. Gauss' law is flat there."""
    for exponent in (1, 2):
        law = {
            f"cam{i}.{n}": x
            for i in (1, 2)
            for n, x in (("friction_peak", 1.5), ("stribeck_exponent", exponent))
        }
        model = dualcam.linearize(FORWARD, 0.4, at_rest="loading", parameters=law)
        static = 1.5 * 0.14
        axial = PRELOAD + STIFFNESS * LIFT * 0.4
        fall = 0.14 * 0.5 * LIFT * math.sqrt(2.0) / 0.01  # of mu over the speed, v_s = 0.01 m/s
        expected = 2.0 * LIFT / (1.0 - static) ** 2 * fall * axial / INERTIA if exponent == 1 else 0.0
        assert model.A[1, 1] == pytest.approx(expected, rel=1e-9, abs=1e-9)
        edge = LIFT * (1.0 + static) / (1.0 - static) * axial
        assert model.operating_point.tau == pytest.approx(edge, rel=1e-12)
