"""FMI 2.0 model exchange at the limits: an acceleration that is no number, indicators beyond the range of
numbers, a wedge, no friction. Against equations of tests/test_friction_jams.py and closed forms."""

import ctypes
import math
import sys

import pytest
from driver import MODEL_EXCHANGE, models
from mechanisms import PRELOAD, RHO
from scipy.optimize import brentq
from test_friction_jams import PAINLEVE, agrees

FORWARD = models["DualCamForward"]
VELOCITY, LOAD, RELEASE, LOWER, UPPER, FLANK_1, FLANK_2 = range(7)  # places of the indicators
WEDGED = 6


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


def test_a_wedge_has_an_indicator_for_the_load_that_ends_it(exchange):
    """Beyond a finite edge of the band, with no pair of flanks that agrees, until the load has grown."""
    tau = 0.1
    least = brentq(lambda load: 1.0 if agrees(tau, load) else -1.0, 0.1, 0.5)
    fmu = exchange(PAINLEVE | {"tau": tau, "F_ext": 0.5 * least})
    assert fmu.get("mode") == WEDGED
    for share in (0.6, 0.9, 1.0 - 1e-6):
        fmu.set({"F_ext": share * least})
        assert fmu.vector("GetEventIndicators", 7)[FLANK_1] > 0.0
        assert fmu.vector("GetDerivatives", 2) == [0.0, 0.0]
    fmu.set({"F_ext": (1.0 + 1e-6) * least})
    assert fmu.vector("GetEventIndicators", 7)[FLANK_1] < 0.0


def test_an_acceleration_that_is_no_number_is_refused(exchange):
    fmu = exchange({"inertia.shaft": 1e-300, "tau": 1e9})
    room = (ctypes.c_double * 2)()
    fmu.refused("GetDerivatives", room, 2, mentions=("tau = 1000000000", "inertia"))


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


def test_a_wedge_under_friction_that_depends_on_the_load_holds(exchange):
    """Its conditions are no polynomials of the inputs: no indicator tells its end."""
    law = {"cam1.friction_load_exponent": 1e-6, "cam2.friction_load_exponent": 1e-6}
    fmu = exchange(PAINLEVE | law | {"tau": 0.1, "F_ext": 0.1})
    assert fmu.get("mode") == WEDGED
    assert fmu.vector("GetEventIndicators", 7)[FLANK_1] == 1.0
