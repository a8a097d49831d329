"""A robot's elbow with the dual cam: plant, cam, motion and controller of the example robot_joint.

Sign: theta = 0 is the arm raised, 10 deg from upright. theta grows as the arm drops, to horizontal at the end
of the cam's 80 deg. Gravity then pushes in +theta, compresses the spring and grows with theta, as the torque
of a helix under a linear spring does.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from dualcam.design.statics import Array
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD
from dualcam.systems.blocks.elementwise import Number
from dualcam.systems.blocks.gravity import GravityLoad
from dualcam.systems.blocks.helical_cam import HelicalCam, fit_spring
from dualcam.systems.blocks.motions import PickAndPlace
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.blocks.position_controller import PositionController, RestLimits, lqi_gains
from dualcam.systems.blocks.record import Record
from dualcam.systems.machines.robot_arm import arm_inertia, arm_weight

RANGE = 1.3963  # rad, of the cam
CLEARANCE = 0.02  # rad between the motion and each end stop
LEAN = math.radians(10.0)  # rad from upright at theta = 0
MOTION = PickAndPlace(start=CLEARANCE, end=RANGE - CLEARANCE, move=1.0, dwell=1.0)
CYCLES = 2  # the first one settles, the last one is reported

DESIGN_PAYLOAD = 1.5  # kg
# Both lead angles pi/4: the optimum of the efficiency for equal friction (dualcam.design.optimum).
HELIX = HelicalCam(radius=(0.025, 0.025), lead_angle=(math.pi / 4, math.pi / 4), friction=(0.14, 0.14))
NO_CAM = replace(HELIX, friction=(0.0, 0.0))  # no spring: no axial force, no friction, no torque

BANDWIDTH = 8.0  # Hz, radius of the position loop's poles over 2 pi
PAYLOAD_ERROR = 0.1  # kg that the controller believes beyond the truth
FRICTION_BELIEVED = 0.9  # share of the true coefficient that the controller believes
REST = RestLimits(
    tolerance=0.5e-3,  # 0.1 mm at the wrist; two counts of the actuator's 12-bit encoder
    speed=5e-3,
    margin=0.2,
)


def weight(payload: Number) -> GravityLoad[Number]:
    """The arm's weight on the elbow. `payload`: mass of the payload [kg], float or shape (count,)."""
    return arm_weight(payload, LEAN)


def inertia(payload: Number) -> Number:
    """The inertia of arm and rotor about the elbow [kg.m2] with a mass `payload` [kg], of its shape."""
    return AK80_6.inertia + arm_inertia(payload)


def design_cam() -> HelicalCam:
    """The cam with the spring that puts the middle of the stick band on gravity at the design payload."""
    return fit_spring(HELIX, weight(DESIGN_PAYLOAD).torque, 0.0, RANGE)


def plant_parameters(cam: HelicalCam, payload: float) -> dict[str, float | int]:
    """Start values of the FMU for the joint with a `cam` by name, in SI units. `payload`: its mass [kg]."""
    return {
        **cam.parameters(),
        "inertia.shaft": inertia(payload),
        "stop.lower": 0.0,
        "stop.upper": RANGE,
        "contacts": 2,
    }


def controller(cam: HelicalCam, payload: float, friction: float = FRICTION_BELIEVED) -> PositionController:
    """The position controller, whose model of the joint has PAYLOAD_ERROR more payload.

    `cam`: the true cam. `payload`: true mass of the payload [kg]. `friction`: share of the cam's friction
    that the controller believes [1].
    """
    told = payload + PAYLOAD_ERROR
    return PositionController(
        inertia=inertia(told),
        load=weight(told),
        cam=cam.with_friction_scaled(friction),
        torque_limit=AK80_6.peak_torque,
        gains=lqi_gains(BANDWIDTH, CONTROL_PERIOD),
        rest=REST,
        period=CONTROL_PERIOD,
    )


def reference_motion() -> tuple[Array, Array]:
    """Planned angle [rad] and speed [rad/s] at the control periods' ends, all cycles, shape (n + 1,) each."""
    periods = round(CYCLES * MOTION.period / CONTROL_PERIOD)
    return MOTION.sample(CONTROL_PERIOD * np.arange(periods + 1))


def horizontal_torque(payload: float) -> float:
    """Gravity's torque about the elbow with the arm horizontal [N.m] and a mass `payload` [kg]."""
    return weight(payload).torque(0.5 * math.pi - LEAN)


def friction_heat_of_slow_cycle(cam: HelicalCam) -> float:
    """Friction heat [J] of `cam` in a slow cycle over MOTION: the area between T_load and T_release."""
    middle = 0.5 * (MOTION.start + MOTION.end)  # the band is affine in theta, so its mean is its middle
    release, load = cam.band(middle)
    return (load - release) * (MOTION.end - MOTION.start)


@dataclass(frozen=True)
class Cycle:
    """Figures of the last cycle of a run.

    `payload`: mass of the payload [kg]. `joint`: name of the joint. `full_record`: the run from the start.
    """

    payload: float
    joint: str
    full_record: Record

    @cached_property
    def record(self) -> Record:
        """The last cycle."""
        return self.full_record.last(MOTION.period)

    @property
    def moving(self) -> np.ndarray:
        """Whether the plan moves, by control period of the last cycle: bool, shape (n,)."""
        return np.diff(reference_motion()[0])[-len(self.record.time) :] != 0.0

    @property
    def lifts(self) -> bool:
        """Whether the joint follows its plan at all, to 0.1 rad."""
        return self.record.max_error < 0.1

    @property
    def joule_heat(self) -> float:
        """Heat in the motor per cycle [J]."""
        return self.record.heat

    @property
    def joule_heat_moving(self) -> float:
        """Heat in the motor while the plan moves [J]; the rest falls on the holds."""
        return float(np.sum(self.record.motor_heat[self.moving]))

    @property
    def rms_current(self) -> float:
        """RMS current over the cycle [A]."""
        return AK80_6.rms_current(self.joule_heat, MOTION.period)

    @property
    def hold_current(self) -> float:
        """RMS current over the second half of the hold at the bottom, where gravity is largest [A]."""
        tail = MOTION.dwell / 2
        end = MOTION.period / 2 + MOTION.dwell
        phase = np.mod(self.record.time - 0.5 * CONTROL_PERIOD, MOTION.period)
        held = (phase > end - tail) & (phase < end)
        return AK80_6.rms_current(float(np.mean(self.record.motor_heat[held])), CONTROL_PERIOD)

    @property
    def friction_heat(self) -> float:
        """Friction heat of both contacts per cycle [J]."""
        return self.record.friction_heat

    @property
    def electric_energy(self) -> float:
        """Energy from the supply per cycle, energy given back deducted [J]."""
        return self.record.net_energy

    @property
    def largest_torque(self) -> float:
        """Largest torque of the motor at the output [N.m]."""
        return self.record.largest_torque

    @property
    def rms_error(self) -> float:
        """RMS tracking error [rad]."""
        return self.record.rms_error

    @property
    def max_error(self) -> float:
        """Largest tracking error [rad]."""
        return self.record.max_error
