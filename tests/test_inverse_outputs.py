"""Outputs of the inverse FMU worked out by hand: sliding speeds, the largest torque on the way."""

import math

import pytest
from driver import models
from mechanisms import LIFT, PRELOAD, RHO, STIFFNESS


@pytest.fixture(scope="session")
def model():
    return models["DualCamInverse"]


def test_sliding_speeds(make):
    """Section 4: v_i = psi_i' |omega| hypot(r_i, a_i), with gamma' = a_2/(a_1 + a_2), phi' = 1 - gamma'."""
    leads, radii = (0.5, 0.9), (0.02, 0.03)
    fmu = make().start(
        {f"cam{i}.{n}": v[i - 1] for i in (1, 2) for n, v in (("lead_angle", leads), ("radius", radii))}
    )
    fmu.set({"theta": 0.4, "omega": -3.0})
    a = [r * math.tan(lead) for r, lead in zip(radii, leads, strict=True)]
    for i in (0, 1):
        speed = 3.0 * a[1 - i] / sum(a) * math.hypot(radii[i], a[i])
        assert fmu.get(f"cam{i + 1}.sliding_speed") == pytest.approx(speed, rel=1e-13)


def test_largest_torque_on_the_way_with_an_elastic_shaft(make):
    """A spring that softens: the torque of loading is largest where F_s is, at half of the way."""
    half = 0.5 * LIFT  # m
    fmu = make().start({"shaft.stiffness": 500.0, "spring.stiffness2": -STIFFNESS / (2.0 * half)})
    fmu.step(0.1, theta=1.0)
    largest = RHO[1] * (PRELOAD + STIFFNESS * half / 2.0)
    assert fmu.get("tau") < 0.9 * largest
    assert fmu.get("peak.torque") == pytest.approx(largest, rel=1e-3)
