"""The prosthetic knee as a task: swing an unknown shank as a measured walker does."""

from dataclasses import dataclass, replace
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dualcam.common.arrays import Array
from dualcam.gym.task import (
    Motion,
    Quantity,
    Range,
    Scene,
    Task,
    check_range,
    highest_speed,
    spread,
    torque_entry,
)
from dualcam.systems.blocks.axis import CamGear
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD
from dualcam.systems.blocks.elliptical_cam import EllipticalCam
from dualcam.systems.machines import knee
from dualcam.systems.machines.gait import DESIGN_WALKER
from dualcam.systems.machines.swing import measured_swing

WALKER = DESIGN_WALKER
SLOWEST, FASTEST, CADENCES = 0.8, 1.2, 41  # share of the self-selected cadence, in steps of 1 %
SCENE = ("shank", "friction", "cadence")
MOST_SHANK = 2.0
MOST_FRICTION = 0.2


class Curves(NamedTuple):
    """Measured swings at all cadences, each of shape (CADENCES, most periods + 1)."""

    angle: Array  # of the knee at the ends of the control periods [rad]
    speed: Array  # likewise [rad/s]
    tilt: Array  # the thigh's inclination in the middle of the control periods [rad]
    turning: Array  # its second derivative [rad/s2]
    ahead: Array  # acceleration of the knee's axis in the middle of the control periods, forward [m/s2]
    above: Array  # likewise, upward
    length: NDArray[np.int64]  # control periods of the swing, shape (CADENCES,)


@cache
def curves() -> Curves:
    """The measured swings, sampled, at all cadences."""
    fine = [measured_swing(WALKER, cadence, 0.0, 0.5 * CONTROL_PERIOD) for cadence in cadences()]
    coarse = [(len(swing.time) - 1) // 2 for swing in fine]
    most = max(coarse) + 1

    def padded(rows: list[list[float]]) -> Array:
        return np.array([row[:most] + [row[-1]] * (most - len(row)) for row in rows])

    middles = [swing.hinge[1::2] for swing in fine]
    return Curves(
        angle=padded([swing.angle[::2].tolist() for swing in fine]),
        speed=padded([swing.speed[::2].tolist() for swing in fine]),
        tilt=padded([[hinge.tilt[0] for hinge in middle] for middle in middles]),
        turning=padded([[hinge.tilt[2] for hinge in middle] for middle in middles]),
        ahead=padded([[hinge.forward[0] for hinge in middle] for middle in middles]),
        above=padded([[hinge.upward[0] for hinge in middle] for middle in middles]),
        length=np.array(coarse),
    )


def cadences() -> list[float]:
    """The cadences that are drawn: shares of the self-selected cadence [1]."""
    return np.linspace(SLOWEST, FASTEST, CADENCES).round(2).tolist()


@dataclass(frozen=True)
class KneeTask(Task):
    """Swing the shank as the measured walker does, from toe-off to heel strike, where the episode is over.
    The mass of shank and foot and the friction are unknown.

    Parameters
    ----------
    energy_weight, error_weight, impact_weight : As in `Task`; the error counts ten times as much.
    shank : Least and largest mass and inertia of shank and foot over those of the walker [1].
    friction : Least and largest Coulomb coefficient of both contacts [1].
    cadence : Least and largest cadence over the self-selected one [1], drawn in steps of 1 %.
    """

    error_weight: float = 1000.0
    shank: Range = (0.85, 1.15)
    friction: Range = (0.10, 0.18)
    cadence: Range = (0.9, 1.1)

    motor = knee.MOTOR
    gear = CamGear()
    periods = 5
    draws = len(SCENE)
    told = SCENE

    def __post_init__(self) -> None:
        super().__post_init__()
        check_range("shank", self.shank, 0.5, MOST_SHANK, "")
        check_range("friction", self.friction, 0.0, MOST_FRICTION, "")
        check_range("cadence", self.cadence, SLOWEST, FASTEST, "")

    @property
    def observations(self) -> tuple[Quantity, ...]:
        inertia = 0.5 * WALKER.pendulum.inertia
        cam = replace(design_cam(), friction=MOST_FRICTION)
        held = float(np.max(np.abs(cam.torque(np.linspace(0.0, knee.RANGE, 100), np.ones(100)))))
        speed = highest_speed(self.motor.peak_torque + most_drive() + held, knee.RANGE, inertia)
        planned = curves()
        fastest = float(np.max(np.abs(planned.speed)))
        return (
            Quantity("angle", "rad", 0.0, knee.RANGE),
            Quantity("speed", "rad/s", -speed, speed),
            Quantity("planned_angle", "rad", -0.01, knee.RANGE),
            Quantity("planned_speed", "rad/s", -fastest, fastest),
            Quantity("phase", "1", 0.0, 1.0),
            Quantity("cadence", "1", SLOWEST, FASTEST),
            torque_entry(self.motor),
        )

    def parameters(self) -> dict[str, float | int]:
        return dict(knee.plant_parameters(design_cam().parameters(), WALKER))

    def draw(self, numbers: Array) -> Scene:
        """Shank, friction and cadence [1], its number, state at toe-off."""
        shank, friction = spread(numbers[:, 0], self.shank), spread(numbers[:, 1], self.friction)
        drawn = spread(numbers[:, 2], self.cadence)
        row = np.rint((drawn - SLOWEST) / (FASTEST - SLOWEST) * (CADENCES - 1)).astype(int)
        planned = curves()
        return {
            "shank": shank,
            "friction": friction,
            "cadence": np.array(cadences())[row],
            "row": row,
            "start": planned.angle[row, 0],
            "start_speed": planned.speed[row, 0],
        }

    def start_values(self, scene: Scene) -> dict[str, Array]:
        return {
            "inertia.shaft": scene["shank"] * WALKER.pendulum.inertia + self.motor.inertia,
            "cam1.friction": scene["friction"],
            "cam2.friction": scene["friction"],
        }

    def load_torque(self, scene: Scene, angle: Array, period: NDArray[np.int64]) -> Array:
        planned, body = curves(), WALKER.pendulum
        at = (scene["row"], np.minimum(period, planned.angle.shape[1] - 1))
        pendulum = replace(body, inertia=scene["shank"] * body.inertia, moment=scene["shank"] * body.moment)
        flexion = angle + extension()
        return pendulum.torque(
            planned.tilt[at], planned.turning[at], planned.ahead[at], planned.above[at], flexion
        )

    def wanted(self, scene: Scene, period: NDArray[np.int64]) -> Array:
        planned = curves()
        return planned.angle[scene["row"], np.minimum(period, planned.angle.shape[1] - 1)]

    def observe(self, scene: Scene, motion: Motion) -> Array:
        planned = curves()
        at = (scene["row"], np.minimum(motion.period, planned.angle.shape[1] - 1))
        phase = np.minimum(motion.period / planned.length[scene["row"]], 1.0)
        plan = (planned.angle[at], planned.speed[at], phase, scene["cadence"])
        return np.column_stack([motion.angle, motion.speed, *plan, motion.torque])

    def is_over(self, scene: Scene, period: NDArray[np.int64]) -> NDArray[np.bool_]:
        """Whether the next step would pass heel strike."""
        return period + self.periods > curves().length[scene["row"]]


@cache
def design_cam() -> EllipticalCam:
    """The knee's cam, designed once: that of `dualcam.systems.machines.knee.design_cam`."""
    return knee.design_cam()


@cache
def most_drive() -> float:
    """A bound of the torque of gravity and of the thigh's motion [N.m] at the heaviest shank."""
    planned, body = curves(), WALKER.pendulum
    turning, ahead, above = (
        float(np.max(np.abs(c))) for c in (planned.turning, planned.ahead, planned.above)
    )
    return MOST_SHANK * (body.inertia * turning + body.moment * (ahead + above + body.gravity))


@cache
def extension() -> float:
    """The walker's knee angle at full extension [rad]."""
    return measured_swing(WALKER, 1.0, 0.0).extension
