"""A tolerance beside the value of the design, as a user meets it who writes deviations or another unit."""

import contextlib
import math
import warnings

import pytest
from scipy.stats import norm

from dualcam.design import Helix, Mechanism, Spring
from dualcam.design.tolerances import Tolerance, analyse
from dualcam.errors import DesignError, UnitWarning

PLAIN = Mechanism((Helix(0.02, math.pi / 4),) * 2, (0.14, 0.14), Spring(50.0, 5e4), 1.3963)


@pytest.mark.parametrize(
    "tolerance, words",
    [
        (Tolerance.within("spring.preload", -2.0, 2.0), "not deviations"),
        (Tolerance("spring.stiffness", norm(50.0, 1.0)), "this looks like N/mm; 50 N/mm is 50000 N/m"),
        (Tolerance(("cam1.friction", "cam2.friction"), norm(0.4, 0.01)), "the design has 0.14"),
    ],
)
def test_a_tolerance_beside_the_design_warns(tolerance, words):
    """The values of the tolerance do not have that of the design between them."""
    with pytest.warns(UnitWarning) as caught, contextlib.suppress(DesignError):
        analyse(PLAIN, [tolerance], samples=100)
    assert any(words in str(one.message) for one in caught)


def test_a_tolerance_around_the_design_does_not_warn():
    at_the_end = PLAIN.grooves[0].radius
    inside = [
        Tolerance.within("cam1.radius", at_the_end, 1.001 * at_the_end, "uniform"),
        Tolerance.within("cam1.clearance", 5e-5, 1e-4),
    ]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        analyse(PLAIN, inside, samples=1000)
