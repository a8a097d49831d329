"""Loads that fade away toward a stop: a spring without preload and stiffness presses with k_2 z^2.

Near z = 0 the rounding of z hides this force, which must neither jam the contacts nor end the step. Oracle:
the shaft alone. The loads of the contacts are below 1e-15 N, so the torque does the work tau theta, and the
impacts at the stop turn all of this work into heat.
"""

from itertools import product

import pytest
from driver import FORWARD, OK
from reference import LOWER_STOP

NEAR_THE_STOP = {
    "cam1.profile": 2,
    "cam1.radius": 0.01,
    "cam1.ellipse_a": 0.1,
    "cam1.ellipse_b": 0.1,
    "cam1.ellipse_curvature": -1,
    "cam2.lead_angle": 0.7,
    "cam2.friction": 0.2,
    "cam2.friction_viscous": 1.0,
    "cam1.friction_load": 1.0,
    "cam1.friction_load_exponent": -0.1,
    "spring.preload": 0.0,
    "spring.stiffness": 0.0,
    "inertia.shaft": 0.01,
    "stop.restitution": 0.2,
    "stop.upper": 0.3,
    "tau": -1.0,
}
# Of cam 1 the lead angle, rad, the friction and its growth with the speed, s/m; the radius of cam 2, m
DESIGNS = [(0.8, 0.5, 100.0, 0.05), (0.6, 1.0, 0.0, 0.02)]


@pytest.mark.parametrize("design", DESIGNS)
def test_a_load_below_the_rounding_of_the_height_does_not_jam(make_model, design):
    """Found by `./build.sh fuzz`: the contacts jammed on the way, or the step needed too many segments. The
    sign of a load was unknown, but the sign of its rate was taken for known. This rate was that of the
    friction coefficient alone, or that of k_2 z^2 at z = -1e-20 m instead of zero."""
    lead, friction, growth, radius = design
    own = {"cam1.lead_angle": lead, "cam1.friction": friction, "cam1.friction_viscous": growth}
    for bend, begin in product((1e5, -1e5), (1e-11, 1e-12, 1e-13)):
        at = {"cam2.radius": radius, "spring.stiffness2": bend, "initial.theta": begin}
        fmu = make_model(FORWARD).start(NEAR_THE_STOP | own | at)
        assert fmu.call("fmi2DoStep", 0.0, 1.0, 1) == OK, fmu.messages[-1].text
        assert fmu.get("mode") == LOWER_STOP
        assert fmu.get("energy.heat_stop") == pytest.approx(begin, rel=1e-9)
