"""A torque that holds the shaft at a stop before it takes the shaft away, in one step and in cut ones."""

from itertools import pairwise

import numpy as np
import pytest
from driver import FORWARD


@pytest.mark.parametrize("cuts", [[], [0.01], [0.03, 0.5]])
def test_a_torque_that_holds_the_shaft_at_the_stop_before_it_turns(make_model, cuts):
    """A torque of 1e-12 N.m moves the shaft off its upper stop, by 1e-36 rad, before the torque c t holds it
    there. The shaft leaves when the torque c t - d t^2/2 is zero. From then on J alpha is the torque."""
    inertia, c, d = 1.2, 0.3, 15.0
    parameters = {
        "cam1.lead_angle": 0.3,
        "cam1.friction": 0.0,
        "cam2.friction": 0.0,
        "cam2.lead_angle": 4e-9,
        "inertia.shaft": inertia,
        "inertia.follower": 0.0,
        "inertia.follower_mass": 0.0,
        "spring.preload": 0.01,
        "spring.stiffness": 0.0,
        "spring.stiffness3": 1e-9,  # nearly no force: by collocation
        "stop.lower": 0.0,
        "stop.upper": 1.0,
        "initial.theta": 1.0,
    }
    fmu = make_model(FORWARD).start(parameters)
    for t, end in pairwise([0.0, *cuts, 0.9]):
        fmu.set({"tau": c * t - d * t * t / 2.0})
        fmu.set_derivatives({"tau": [c - d * t, -d]})
        fmu.step(end - t)
    torque = np.polynomial.Polynomial([0.0, c, -d / 2.0])
    impulse = torque.integ(lbnd=2.0 * c / d)
    assert fmu.get("omega") == pytest.approx(impulse(0.9) / inertia, rel=1e-9)
    assert fmu.get("theta") == pytest.approx(1.0 + impulse.integ(lbnd=2.0 * c / d)(0.9) / inertia, rel=1e-9)


@pytest.mark.parametrize("h", [2e-5, 4e-5, 1e-4])
def test_energy_of_a_motion_that_has_hardly_begun(make_model, h):
    """The motion begins half-way, where the torque exceeds the holding torque. Over 1e-11 rad the holding
    torque is constant, so work and kinetic energy are integrals of polynomials. Energies of 1e-12 J are known
    to the rounding of z: the preload times a rounding of the way to the upper stop."""
    inertia = 1.0
    parameters = {
        "cam1.profile": 2,
        "cam1.ellipse_a": 0.1,
        "cam1.ellipse_b": 0.2,
        "cam1.ellipse_curvature": 1,
        "cam1.radius": 0.01,
        "cam1.lead_angle": 1.1,
        "cam1.friction": 0.02,
        "cam2.friction": 0.0,
        "cam2.radius": 0.07,
        "cam2.lead_angle": 0.5,
        "inertia.shaft": inertia,
        "spring.preload": 7.0,
        "spring.stiffness": 0.0,
        "stop.upper": 1.0,
    }
    height = make_model(FORWARD).start(parameters | {"initial.theta": 1.0}).get("z")
    fmu = make_model(FORWARD).start(parameters)
    hold = fmu.get("torque_load")
    fmu.set_derivatives({"tau": [hold / h, 4.0 * hold / h**2]})
    fmu.step(h)
    torque = np.polynomial.Polynomial([0.0, hold / h, 2.0 * hold / h**2])
    omega = (torque - hold).integ(lbnd=h / 2.0) / inertia
    rounding = 4 * np.finfo(float).eps * parameters["spring.preload"] * height
    work = (torque * omega).integ(lbnd=h / 2.0)(h)
    assert fmu.get("energy.work_in") == pytest.approx(work, rel=1e-8, abs=rounding)
    assert fmu.get("energy.kinetic") == pytest.approx(inertia * omega(h) ** 2 / 2.0, rel=1e-8)
    assert abs(fmu.get("energy.residual")) <= rounding
