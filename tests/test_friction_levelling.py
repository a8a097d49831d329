"""Friction under small loads (docs/mechanism.md, section 9): below 0.01 R_ref the load law levels off.

Oracles: the series of the logarithm in powers of the load, and the balance of two equal contacts, which the
reaction gives in closed form.
"""

import math

import numpy as np
import pytest
from driver import models
from reference import STICK
from scipy.optimize import brentq

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]
LEVEL, R_REF = 0.01, 5000.0  # of R_ref; N, so large that the spring's force rounds none of the small loads
LEAD, RADIUS, KINETIC = 0.6, 0.02, 0.12
EXPONENTS = [-0.9, -1 / 3, 0.4, 0.9]
EQUAL = {
    f"cam{i}.{name}": value
    for i in (1, 2)
    for name, value in (
        ("radius", RADIUS),
        ("lead_angle", LEAD),
        ("friction", KINETIC),
        ("friction_load", R_REF),
    )
}


def exponents(nu):
    return {f"cam{i}.friction_load_exponent": nu for i in (1, 2)}


def coefficient(nu, reaction):
    """mu_k exp(nu l), with l the first four terms of the series of ln q = ln q_0 + ln(1 + w)/2."""
    q = reaction / R_REF
    if q >= LEVEL:
        return KINETIC * q**nu
    w = (q / LEVEL) ** 2 - 1
    return KINETIC * math.exp(nu * (math.log(LEVEL) + (w - w**2 / 2 + w**3 / 3 - w**4 / 4) / 2))


def edge_of(nu, reaction, sigma, contacts=1):
    """The axial load and the torque on the band's edge at which each contact bears `reaction`."""
    s, h, mu = math.tan(LEAD), math.hypot(1.0, math.tan(LEAD)), coefficient(nu, reaction)
    axial = 2 * contacts * reaction * (1 - sigma * mu * s) / h
    return axial, contacts * reaction * RADIUS * (s + sigma * mu) / h


NO_SPRING = {"spring.preload": 0.0, "spring.stiffness": 0.0, "initial.theta": 0.5, "contacts": 1}


def at_rest(make_model, nu, F_0):
    """At rest under the axial load F_0, all of it from outside, with the torque z' F_0 of no friction."""
    torque = 0.5 * RADIUS * math.tan(LEAD) * F_0
    fmu = make_model(FORWARD).start(EQUAL | exponents(nu) | NO_SPRING | {"F_ext": F_0, "tau": torque})
    assert fmu.get("mode") == STICK
    return fmu


def under_reaction(make_model, nu, reaction):
    """The coefficient at rest, where the outputs share F_0 as without friction: R/h = F_0/2."""
    fmu = at_rest(make_model, nu, 2 * reaction / math.hypot(1.0, math.tan(LEAD)))
    assert fmu.get("cam1.reaction") == pytest.approx(reaction, rel=1e-14)
    return fmu.get("cam1.friction_coefficient")


@pytest.mark.parametrize("nu", EXPONENTS)
def test_coefficient_is_the_series(make_model, nu):
    for q in (0.0, 1e-9, 1e-4, 3e-3, 9e-3, LEVEL, 0.011, 0.3, 1.0, 20.0):
        found = under_reaction(make_model, nu, q * R_REF)
        assert found == pytest.approx(coefficient(nu, q * R_REF), rel=1e-13)


@pytest.mark.parametrize("nu", EXPONENTS)
def test_value_and_derivative_are_continuous(make_model, nu):
    """From both sides of q_0: the values, and the differences of second order, meet at nu mu/R."""
    edge = LEVEL * R_REF
    just = [under_reaction(make_model, nu, edge * (1 + x)) for x in (-1e-12, 0.0, 1e-12)]
    assert np.ptp(just) <= 3e-12 * just[1]
    slope = nu * just[1] / edge
    for side in (-1, 1):
        h = side * 1e-4 * edge
        f = [under_reaction(make_model, nu, edge + k * h) for k in range(3)]
        one_sided = (-3 * f[0] + 4 * f[1] - f[2]) / (2 * h)
        assert one_sided == pytest.approx(slope, rel=1e-7)
        bend = (f[0] - 2 * f[1] + f[2]) / h**2
        assert bend == pytest.approx(nu * (nu - 1) * just[1] / edge**2, rel=1e-3)


@pytest.mark.parametrize("sigma", [1, -1])
@pytest.mark.parametrize("nu", [-1 / 3, 0.4, 0.9])
def test_band_edge_of_equal_contacts(make_model, nu, sigma):
    """The reaction gives the load and the torque of the edge; the FMU finds the torque from the load."""
    for q in (1e-7, 1e-3, 5e-3, 9.99e-3, 1.001e-2, 0.1):
        axial, torque = edge_of(nu, q * R_REF, sigma)
        fmu = at_rest(make_model, nu, axial)
        name = "torque_load" if sigma > 0 else "torque_release"
        assert fmu.get(name) == pytest.approx(torque, rel=1e-12), q


@pytest.mark.parametrize("nu", EXPONENTS)
def test_without_load_the_edge_is_that_of_coulomb(make_model, nu):
    """rho takes mu(0) = mu_k (0.01 exp(-25/24))^nu. With nu = -0.9 contacts with mu(0) lock. Their friction
    falls as the torque grows: where 1 - mu tan(lead) passes zero, slip begins."""
    mu = KINETIC * (LEVEL * math.exp(-25 / 24)) ** nu
    coulomb = {f"cam{i}.friction": mu for i in (1, 2)} | {
        f"cam{i}.friction_load_exponent": 0.0 for i in (1, 2)
    }
    small = 1e-8 * R_REF
    fmu = at_rest(make_model, nu, small)
    if mu * math.tan(LEAD) >= 1.0:
        unlocked = R_REF * (KINETIC * math.tan(LEAD)) ** (-1 / nu)  # N, where mu tan(lead) = 1
        reaction = brentq(lambda R: edge_of(nu, R, 1)[0] - small, unlocked, 2 * unlocked, rtol=1e-15)
        torque = edge_of(nu, reaction, 1)[1]
        rounding = math.ulp(1.0) / (1 - coefficient(nu, reaction) * math.tan(LEAD))  # of torque/axial
        assert fmu.get("torque_load") == pytest.approx(torque, rel=4 * rounding)
        return
    other = make_model(FORWARD).start(EQUAL | coulomb | NO_SPRING | {"F_ext": small})
    for name in ("torque_load", "torque_release"):
        assert fmu.get(name) == pytest.approx(other.get(name), rel=1e-11)


@pytest.mark.parametrize("nu", [-1 / 3, 0.4])
def test_torque_of_an_imposed_motion_through_small_loads(make_model, nu):
    """F_ext takes both reactions from above the level through zero: the torque is that of the reaction which
    the other flank bears then, without a jump."""
    fmu = make_model(INVERSE).start(
        EQUAL
        | exponents(nu)
        | {"spring.preload": 0.0, "spring.stiffness": 0.0, "contacts": 1, "theta": 0.5, "omega": 1.0}
    )
    for q in (0.02, 0.0101, 0.0099, 5e-3, 1e-3, 1e-6, -1e-6, -1e-3, -9e-3, -0.02):
        side = 1 if q > 0 else -1
        axial, torque = edge_of(nu, abs(q) * R_REF, side)
        fmu.set({"F_ext": side * axial})
        assert fmu.get("tau") == pytest.approx(side * torque, rel=1e-11), q
