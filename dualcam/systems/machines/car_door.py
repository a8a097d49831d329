"""A car's side door with the dual cam beside its hinge: geometry, weight, the cam's design, and its plant.

Signs: the door's angle is 0 closed and 67 deg fully open. A torque about the hinge is + if it opens the door.
The cam turns with the door, RATIO = 2 times as far, and loads its spring while the door closes:
theta = RATIO (67 deg - angle), tau = -torque/RATIO.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, cached_property

import numpy as np

from dualcam.design.statics import Array
from dualcam.fmi.fmu import Fmu
from dualcam.systems.blocks.axis import CamAxis
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD
from dualcam.systems.blocks.gravity import GravityLoad, hinged_load, vertical_in_car
from dualcam.systems.blocks.helical_cam import HelicalCam
from dualcam.systems.blocks.motions import PickAndPlace
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.blocks.record import Record
from dualcam.systems.blocks.speed_controller import SpeedController

# Passenger's side door. Source: jandaa/door-model, door_model.py ("Parameters from OEM"), MIT licence.
# Car axes: x to the rear, y to the right, z to the roof; door closed.
MASS = 36.1736  # kg
HINGE = (np.array([0.749783, 0.910696, 0.10185]), np.array([0.753367, 0.896342, 0.51262]))  # m, lower, upper
CENTRE = np.array([1.252737, 0.845036, 0.400716])  # m
OPEN = math.radians(67.0)  # rad, fully open
# The source has no inertia. m r^2 = 9.2 kg.m2 about the hinge is the smallest possible inertia. The radius of
# gyration about the centre is assumed to be that of a uniform panel 0.87 m long, 0.87/sqrt(12) = 0.25 m.
ARM = 0.50334  # m, of the centre of mass from the hinge's axis (a test computes it from the points)
GYRATION = 0.25  # m
DOOR_INERTIA = MASS * (ARM**2 + GYRATION**2)  # kg.m2, 11.4
HANDLE = 0.85  # m from the axis, assumed: the door is about 1 m long

PITCH, ROLL = math.radians(11.8), math.radians(6.27)  # the source's slopes
LEVEL, NOSE_UP, NOSE_DOWN = "level", "nose up", "nose down"
SIDE_UP, SIDE_DOWN, BOTH = "door side up", "door side down", "nose and side up"
ATTITUDES = {
    LEVEL: (0.0, 0.0),
    NOSE_UP: (PITCH, 0.0),
    NOSE_DOWN: (-PITCH, 0.0),
    SIDE_UP: (0.0, ROLL),
    SIDE_DOWN: (0.0, -ROLL),
}
ATTITUDES_NOT_DESIGNED_FOR = {BOTH: (PITCH, ROLL)}  # not designed for

RATIO = 2.0  # cam's angle per door's angle: 134 deg, less than the 180 deg between the two pins
RADIUS = 0.04  # m, both cams
FRICTION = 0.19  # both contacts; grease 2 of the paper (docs/paper.md)
HOLD_MARGIN = 1.1  # band over weight
SPRING_RISE = 0.05  # of the preload over the stroke: a soft stack of disc springs
CLOSING_LIMIT = 1.2  # rad/s, 1.2 m/s at the door's edge
PUSH = 60.0 * HANDLE  # N.m, a hand that keeps pushing

# The motor of the robot's elbow behind another 8:1, of which the last 2:1 is the cam's: 48:1 in all.
MOTOR = AK80_6.with_gear(8.0)
INERTIA = DOOR_INERTIA + MOTOR.inertia  # kg.m2 about the hinge, with the rotor
# The cycle: open in 3 s, hold 4 s, close in 3 s. The latch pulls the door in over the last degree.
MOTION = PickAndPlace(start=math.radians(1.0), end=math.radians(65.0), move=3.0, dwell=4.0)
DURATION = 2.0 * MOTION.move + MOTION.dwell  # s
BANDWIDTH = 2.0  # Hz, both poles of the speed loop, critically damped
MASS_BELIEVED, FRICTION_BELIEVED = 1.03, 0.95  # shares of the truth that the controller believes
REST_SPEED = 5e-3  # rad/s
REST_MARGIN = 0.01  # share of the band kept between a held weight and the band's edge


def weight_on_slope(mass: float, pitch: float, roll: float) -> GravityLoad[float]:
    """The weight of the door about its hinge, in a car on a slope, as an equivalent pendulum.

    `mass` of the door [kg]. `pitch`, `roll`: angles of the car [rad]; `pitch` > 0 lifts the nose, `roll` > 0
    lifts the door's side.
    """
    return hinged_load(mass, HINGE, CENTRE, vertical_in_car(pitch, roll))


@cache
def weight(attitude: str, mass: float = MASS) -> GravityLoad[float]:
    """The weight of the door about its hinge, in a car parked in one of the named ways, as a pendulum.

    `attitude`: a key of ATTITUDES or ATTITUDES_NOT_DESIGNED_FOR. `mass` of the door [kg].
    """
    return weight_on_slope(mass, *(ATTITUDES | ATTITUDES_NOT_DESIGNED_FOR)[attitude])


def hinge_tilt() -> float:
    """The angle between the hinge and the vertical on level ground [deg]."""
    axis = HINGE[1] - HINGE[0]
    return math.degrees(math.acos(axis[2] / float(np.linalg.norm(axis))))


@cache
def extreme_weight_torques() -> tuple[float, float]:
    """Largest closing and opening torque of the weight, over all angles and attitudes, both > 0 [N.m]."""
    angles = np.linspace(0.0, OPEN, 200)
    torques = [weight(attitude).torque(angle) for attitude in ATTITUDES for angle in angles]
    return -min(torques), max(torques)


# ---- the cam at the door ----


@dataclass(frozen=True)
class DoorCam:
    """Cam and damper as the door feels them: by the door's angle, as torque about the hinge.

    `cam`: the cam beside the hinge. `orifice`: quadratic damper on the follower while the door closes
    [N.s2/m2].
    """

    cam: HelicalCam
    orifice: float = 0.0

    def band(self, angle: float) -> tuple[float, float]:
        """The stick band at an `angle` of the door [rad]: the torques about the hinge [N.m] that just close
        and just open the door; between them the door rests."""
        release, load = self.cam.band(RATIO * (OPEN - angle))
        return -RATIO * load, -RATIO * release

    @cached_property
    def damping(self) -> float:
        """Torque of the damper over the squared speed of the closing door [N.m.s2]: N rho_+ q v^2."""
        return RATIO * self.cam.load_arm * self.orifice * (RATIO * self.cam.dz_dtheta) ** 2

    def torque(self, angle: float, speed: float) -> float:
        """The torque about the hinge [N.m] that keeps the door moving; 0 at rest.

        `angle` of the door [rad]. `speed` of the door [rad/s].
        """
        closes, opens = self.band(angle)
        if speed < 0.0:
            return closes - self.damping * speed**2
        return opens if speed > 0.0 else 0.0

    def with_spring_force(self, share: float) -> DoorCam:
        """The same with `share` times the preload and stiffness [1]."""
        spring = replace(self.cam, preload=share * self.cam.preload, stiffness=share * self.cam.stiffness)
        return replace(self, cam=spring)

    def parameters(self) -> dict[str, float]:
        """The same as start values of the FMU by name, in SI units."""
        return {**self.cam.parameters(), "damper.q_load": self.orifice}


def stroke(cam: HelicalCam) -> float:
    """The travel of the follower over the door's range [m]. `cam`: the cam beside the hinge."""
    return cam.dz_dtheta * RATIO * OPEN


@cache
def design() -> DoorCam:
    """The designed cam of the door: lead angle, preload, stiffness and damper.

    Notes
    -----
    The statics are those of two equal helices: rho = (r/2) tan(lambda +- phi), phi = atan(mu). C and O are
    the weight's largest closing and opening torque.

    - Lead angle: T_load : -T_release = C : O, so sin(2 lambda) = sin(2 phi) (C - O)/(C + O).
    - Preload: N T_load = 1.1 C at theta = 0, where the spring is weakest. The 10 % cover a friction 5 % below
      and a mass 3 % above the believed one.
    - Damper: one-way orifice, D = q v^2. With a hand that keeps pushing with 60 N on the worst slope, the
      door settles at CLOSING_LIMIT.
    """
    closing, opening = extreme_weight_torques()
    sine = math.sin(2.0 * math.atan(FRICTION)) * (closing - opening) / (closing + opening)
    lead = 0.5 * math.asin(sine)
    cam = HelicalCam(radius=(RADIUS, RADIUS), lead_angle=(lead, lead), friction=(FRICTION, FRICTION))
    preload = HOLD_MARGIN * closing / (RATIO * cam.load_arm)
    cam = replace(cam, preload=preload, stiffness=SPRING_RISE * preload / stroke(cam))
    excess = PUSH + closing - RATIO * cam.load_arm * preload  # N.m, with the door fully open
    force = excess / (RATIO * cam.load_arm)  # N, of the damper at the limit
    return DoorCam(cam, orifice=force / (RATIO * cam.dz_dtheta * CLOSING_LIMIT) ** 2)


def plain_door() -> DoorCam:
    """The door without cam and damper: no spring, no friction, no torque."""
    return DoorCam(replace(design().cam, friction=(0.0, 0.0), preload=0.0, stiffness=0.0))


def share_of_angles_held(
    cam: DoorCam, attitudes: Sequence[str] = tuple(ATTITUDES), points: int = 1000
) -> float:
    """The share [1] of all angles and attitudes at which the door stays where it is let go.

    `cam` and damper. `attitudes`: how the car is parked. `points`: number of angles of the door, evenly over
    its range.
    """
    held = 0
    for attitude in attitudes:
        load = weight(attitude)
        for angle in np.linspace(0.0, OPEN, points):
            closes, opens = cam.band(angle)
            held += closes < load.torque(angle) < opens
    return held / (points * len(attitudes))


def handle_force(cam: DoorCam, attitudes: Sequence[str]) -> float:
    """The largest force at the handle that moves the door slowly, either way, over all its angles [N].

    `cam` and damper. `attitudes`: how the car is parked.
    """
    largest = 0.0
    for attitude in attitudes:
        load = weight(attitude)
        for angle in np.linspace(0.0, OPEN, 100):
            closes, opens = cam.band(angle)
            largest = max(largest, opens - load.torque(angle), load.torque(angle) - closes)
    return largest / HANDLE


# ---- the plant and its motor ----


def door_axis(fmu: Fmu) -> CamAxis:
    """The forward FMU `fmu` as the door: its angle and speed are those about the hinge."""
    return CamAxis(fmu, ratio=-RATIO, offset=OPEN)


def plant_parameters(cam: DoorCam) -> dict[str, float]:
    """Start values of the FMU by name, in SI units, for the door with `cam` and damper."""
    return {
        **cam.parameters(),
        "inertia.shaft": INERTIA / RATIO**2,
        "stop.lower": 0.0,
        "stop.upper": RATIO * OPEN,
    }


def cam_in_controller(cam: DoorCam) -> DoorCam:
    """The `cam` as the controller believes it: with FRICTION_BELIEVED times the friction."""
    return replace(cam, cam=cam.cam.with_friction_scaled(FRICTION_BELIEVED))


def controller(cam: DoorCam, attitude: str) -> SpeedController:
    """The speed controller, whose model of the door is off by MASS_BELIEVED and FRICTION_BELIEVED.

    `cam`: the true cam and damper. `attitude`: how the car is parked.
    """
    return SpeedController(
        inertia=INERTIA,
        load=weight(attitude, MASS_BELIEVED * MASS),
        cam=cam_in_controller(cam),
        torque_limit=MOTOR.peak_torque,
        bandwidth=BANDWIDTH,
        rest_speed=REST_SPEED,
        rest_margin=REST_MARGIN,
        period=CONTROL_PERIOD,
    )


def reference_motion() -> tuple[Array, Array]:
    """Open, hold, close: planned angle [rad] and speed [rad/s] at the periods' ends, shape (n + 1,) each."""
    periods = round(DURATION / CONTROL_PERIOD)
    return MOTION.sample(MOTION.dwell + CONTROL_PERIOD * np.arange(periods + 1))


@dataclass(frozen=True)
class MotorCycle:
    """Figures of a run in which the motor opens, holds and closes the door. `record`: the run."""

    record: Record

    @property
    def holding(self) -> slice:
        """The control periods of the second half of the hold."""
        end = MOTION.move + MOTION.dwell
        return slice(round((end - 0.5 * MOTION.dwell) / CONTROL_PERIOD), round(end / CONTROL_PERIOD))

    @property
    def hold_power(self) -> float:
        """Power from the supply while the door is held open [W]."""
        return float(np.mean(self.record.supply_energy[self.holding])) / CONTROL_PERIOD

    @property
    def move_energy(self) -> float:
        """Energy from the supply, less what is given back, of the cycle without its hold [J]."""
        return self.record.net_energy - self.hold_power * MOTION.dwell

    @property
    def motor_off(self) -> np.ndarray:
        """Whether the motor is switched off, by control period: bool, shape (n,)."""
        return self.record.command == 0.0

    @property
    def motor_off_share(self) -> float:
        """Share of the cycle with the motor switched off."""
        return float(np.mean(self.motor_off))


def break_even(plain: MotorCycle, cam: MotorCycle) -> float:
    """The time of holding [s] after which the cycle with the cam has taken less from the supply.

    `plain`, `cam`: the runs of the door without and with the cam.
    """
    return (cam.move_energy - plain.move_energy) / (plain.hold_power - cam.hold_power)
