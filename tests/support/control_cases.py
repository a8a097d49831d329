"""Parameters and helpers that several tests of dualcam under python-control share.

These tests compare plants, linear models, controllers and limit cycles with closed forms of the helix, with
high-order differences of the co-simulation FMU, and with loops around this FMU.
"""

from driver import models
from mechanisms import FOLLOWER, FORCES, LIFT, PRELOAD, RHO, STIFFNESS
from refusals import refused_by

from dualcam.errors import FmuError

FORWARD, INVERSE = (model.fmu for model in models.values())
PERIOD = 1e-3

UPPER = 1.3963  # rad, the upper stop of the start values
ALL = FOLLOWER | FORCES
LOCKING = {"cam1.lead_angle": 0.1, "cam2.lead_angle": 0.1}


def edge(direction, theta, F_ext=0.0):
    """Edge of the stick band of the default helices, N.m."""
    return RHO[direction] * (PRELOAD + STIFFNESS * LIFT * theta + F_ext)


def refused(*mentions, error=FmuError):
    """Expects this error, a ValueError, with a message that contains all of `mentions`."""
    assert issubclass(error, ValueError)
    return refused_by(error, *mentions)
