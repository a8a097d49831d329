"""FMI 2.0 model exchange at the limits: indicators beyond the range of numbers, no friction. Closed forms."""

import math
import sys

import pytest
from driver import MODEL_EXCHANGE, models
from mechanisms import PRELOAD, RHO

FORWARD = models["DualCamForward"]
VELOCITY, LOAD, RELEASE, LOWER, UPPER, FLANK_1, FLANK_2 = range(7)  # places of the indicators


@pytest.fixture
def exchange(make_model):
    """Model exchange in continuous time from given parameters and inputs."""

    def begin(values):
        fmu = make_model(FORWARD, kind=MODEL_EXCHANGE)
        fmu.set(values)
        fmu.setup()
        fmu.enter("step mode")
        fmu.settle()
        return fmu

    return begin


def test_indicators_beyond_the_range_of_numbers_are_its_ends(exchange):
    """The edge that loads is rho F, 1.6 m times 1.5e308 N: no number. The other edge is one."""
    scale = 120.0  # of the radii, and so of rho
    values = {"cam1.radius": 0.02 * scale, "cam2.radius": 0.02 * scale, "spring.preload": 1.5e308}
    assert math.isinf(RHO[1] * scale * values["spring.preload"])
    fmu = exchange(values | {"spring.stiffness": 0.0})
    assert fmu.vector("GetEventIndicators", 7)[LOAD] == sys.float_info.max


def test_without_friction_no_flank_changes(exchange):
    """The spring alone: alpha = (tau - z' F)/J. Contacts that let go slide on in any case."""
    values = {"cam1.friction": 0.0, "cam2.friction": 0.0, "tau": 2.0, "spring.stiffness": 0.0}
    fmu = exchange(values | {"initial.omega": 3.0})
    found = fmu.vector("GetEventIndicators", 7)
    assert found[FLANK_1] == found[FLANK_2] == 1.0
    assert found[VELOCITY] == pytest.approx(3.0, rel=1e-9)
    assert fmu.vector("GetDerivatives", 2) == pytest.approx([3.0, (2.0 - 0.01 * PRELOAD) / 0.002], rel=1e-12)
