"""The forearm of a UR3e with its wrists and a payload, as load on the elbow."""

import math

from dualcam.systems.blocks.elementwise import Number
from dualcam.systems.blocks.gravity import GravityLoad

# UR3e. Source: UniversalRobots/Universal_Robots_ROS2_Description, config/ur3e (physical_parameters.yaml,
# default_kinematics.yaml, joint_limits.yaml), BSD-3-Clause.
FOREARM_MASS = 1.437  # kg
FOREARM_CENTRE = 0.1632  # m from the elbow's axis, along the forearm
FOREARM_INERTIA = 6.544570e-3  # kg.m2 about its centre, across the forearm (the source's cylinder)
WRIST_MASSES = (0.871, 0.805, 0.261)  # kg, wrists 1 to 3
WRIST_DISTANCE = 0.2132  # m from the elbow's axis to wrist 1's
ELBOW_SPEED_LIMIT = math.radians(180.0)  # rad/s


def arm_moment(payload: Number) -> Number:
    """The first moment of the arm about the elbow [kg.m] with a mass `payload` [kg], float or shape (count,).

    Notes
    -----
    Wrist and payload count at wrist 1's axis. For gravity that is exact while wrist 1 keeps wrist 2's axis
    upright (the tool grips from the side): wrist and payload are then straight below wrist 1's axis. With the
    tool pointing down they are 0.085 m beside it. That adds the same torque at every angle, about 2 N.m at
    1.5 kg.
    """
    return FOREARM_MASS * FOREARM_CENTRE + (sum(WRIST_MASSES) + payload) * WRIST_DISTANCE


def arm_inertia(payload: Number) -> Number:
    """The inertia of the arm about the elbow [kg.m2], without the rotor, with a mass `payload` [kg].

    Wrist and payload move along without turning, so they add no inertia of their own. The moment with which
    wrist 1 keeps them level against acceleration, at most 0.4 N.m at 1.5 kg here, is left out.
    """
    forearm = FOREARM_INERTIA + FOREARM_MASS * FOREARM_CENTRE**2
    return forearm + (sum(WRIST_MASSES) + payload) * WRIST_DISTANCE**2


def arm_weight(payload: Number, lean: float) -> GravityLoad[Number]:
    """The arm's weight on the elbow.

    `payload`: its mass [kg], float or shape (count,). `lean`: the arm's angle from upright at theta = 0
    [rad].
    """
    return GravityLoad(moment=arm_moment(payload), lean=lean)
