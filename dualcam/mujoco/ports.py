"""The cams of one joint in all instances: a fleet of FMUs, and the law of their shaft over a step."""

import math
import warnings
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from dualcam.common.arrays import Array
from dualcam.errors import DualcamWarning, MujocoError, UnstableCouplingWarning
from dualcam.fleet import Fleet, FleetState
from dualcam.fleet.values import FleetValue
from dualcam.mujoco.cam_joint import CamJoint, DriveTrain
from dualcam.mujoco.torques import CamLaw, DriveLaw, ShaftLaw

# Parameters that do not act in the inverse FMU behind an elastic shaft.
WITHOUT_EFFECT = (
    *("damper.c_load", "damper.q_load", "damper.c_release", "damper.q_release", "shaft.damping"),
    *("inertia.follower_mass", "inertia.follower"),
)


class PortState(NamedTuple):
    """What a port needs to go on from a point in time."""

    fleet: FleetState
    arrays: tuple[Array, ...]


class Port(ABC):
    """The cams of one joint in all instances.

    A cam at a stop carries any torque into that stop: there an edge of the stick band is infinite."""

    INPUTS: ClassVar[tuple[str, ...]]
    OUTPUTS: ClassVar[tuple[str, ...]]  # the angle of the cam first, the edges of the stick band last

    def __init__(self, cam: CamJoint, count: int, values: Mapping[str, FleetValue]) -> None:
        self.cam = cam
        self.fleet = Fleet(cam.model, count, self.INPUTS, self.OUTPUTS, values)
        self.stops = (self.fleet.get("stop.lower"), self.fleet.get("stop.upper"))
        self._outputs = np.empty((count, len(self.OUTPUTS)))
        self._read()

    def _read(self) -> None:
        for i, name in enumerate(self.OUTPUTS):
            self._outputs[:, i] = self.fleet.get(name)

    def _band(self) -> tuple[Array, Array]:
        """Edges of the stick band."""
        angle, release, load = self._outputs[:, 0], self._outputs[:, -2], self._outputs[:, -1]
        lower = np.where(angle <= self.stops[0], -math.inf, release)
        return lower, np.where(angle >= self.stops[1], math.inf, load)

    @abstractmethod
    def start(self, chosen: NDArray[np.bool_], theta: Array, omega: Array) -> None:
        """Begin anew at these angles and speeds of the joint, where chosen."""

    @abstractmethod
    def law(self, angle: Array, speed: Array, step: float) -> ShaftLaw:
        """The shaft's law over the step that would end at `angle` and `speed` without the shaft's torque."""

    @abstractmethod
    def advance(self, theta: Array, torque: Array, step: float) -> None:
        """The step is made: the joint is at `theta`, the shaft gave `torque` to the cam."""

    def arrays(self) -> tuple[Array, ...]:
        """What belongs to the state besides that of the FMUs."""
        return (self._outputs,)

    def save(self) -> PortState:
        """The present state."""
        return PortState(self.fleet.save(), tuple(array.copy() for array in self.arrays()))

    def restore(self, state: PortState) -> None:
        """Go back to a saved state."""
        self.fleet.restore(state.fleet)
        for array, saved in zip(self.arrays(), state.arrays, strict=True):
            array[:] = saved


def port_of(cam: CamJoint, theta: Array, omega: Array, step: float) -> Port:
    """The port of a cam, at the start of a run with that time step."""
    if not isinstance(cam, DriveTrain):
        return CamPort(cam, theta)
    port = DrivePort(cam, theta, omega)
    _warn_of_step(port, step)
    return port


class CamPort(Port):
    """The inverse FMU behind an elastic shaft.

    The FMU carries the cam's angle x along as the joint moves, and gives the edges of the stick band at x. In
    the next step the shaft's torque is K (theta - x), inside the band: while the torque is at an edge the cam
    slips."""

    INPUTS = ("theta",)
    OUTPUTS = ("theta_cam", "torque_release", "torque_load")

    def __init__(self, cam: CamJoint, theta: Array) -> None:
        values = cam.values()
        _warn_of_no_effect(cam, values)
        super().__init__(cam, len(theta), values | {"shaft.stiffness": float(cam.stiffness), "theta": theta})

    def start(self, chosen: NDArray[np.bool_], theta: Array, omega: Array) -> None:
        self.fleet.reset(chosen, {"theta": theta})
        self._read()

    def law(self, angle: Array, speed: Array, step: float) -> ShaftLaw:
        stiffness = float(self.cam.stiffness)
        return CamLaw(stiffness * (angle - self._outputs[:, 0]), stiffness * step**2, *self._band())

    def advance(self, theta: Array, torque: Array, step: float) -> None:
        # Only the angle is given, and the speed stays 0: the FMU's path from angle to angle is then monotone,
        # as is the motion of MuJoCo within a step.
        self.fleet.step(theta[:, None], step, self._outputs)


def _warn_of_no_effect(cam: CamJoint, values: Mapping[str, FleetValue]) -> None:
    found = [name for name in WITHOUT_EFFECT if np.any(np.asarray(values.get(name, 0.0)) != 0.0)]
    if found:
        warnings.warn(
            f"joint {cam.joint!r}: {', '.join(found)} of the cam do not act behind an elastic shaft: use"
            " DriveTrain, where they act, or damping and armature of the joint",
            DualcamWarning,
            stacklevel=5,
        )


class DrivePort(Port):
    """The forward FMU behind an elastic shaft.

    The FMU gets the torques of motor and shaft, constant over a step. The shaft's law takes the cam's motion
    over the coming step from its present angle, speed and acceleration, and from the stick band."""

    INPUTS = ("tau",)
    OUTPUTS = ("theta", "omega", "alpha", "torque_release", "torque_load")

    def __init__(self, cam: DriveTrain, theta: Array, omega: Array) -> None:
        values = cam.values() | {"initial.theta": theta, "initial.omega": omega}
        super().__init__(cam, len(theta), values)
        self._damping = float(cam.damping)
        self.inertia = self.fleet.get("inertia.shaft")
        if not np.all(self.inertia > 0.0):
            self.fleet.close()
            raise MujocoError(
                f"joint {cam.joint!r}: inertia.shaft = {self.inertia.min()} kg.m2: allowed is a number > 0,"
                " the inertia of the cam and of the motor's rotor behind its gear"
            )
        self.motor = np.zeros(len(theta))  # N.m on the cam
        self._given = np.zeros(len(theta))  # N.m, motor and shaft in the last step

    def start(self, chosen: NDArray[np.bool_], theta: Array, omega: Array) -> None:
        inside = np.clip(theta, *self.stops)  # a joint may be a little beyond its limits
        self.fleet.reset(chosen, {"initial.theta": inside, "initial.omega": omega})
        self.motor[chosen] = self._given[chosen] = 0.0
        self._read()

    def law(self, angle: Array, speed: Array, step: float) -> ShaftLaw:
        theta, omega, alpha = self._outputs[:, :3].T
        alpha = alpha + (self.motor - self._given) / self.inertia  # without the shaft's torque
        motion = (angle - theta, speed - omega, omega, alpha)
        shaft = (float(self.cam.stiffness), self._damping, step)
        return DriveLaw(*shaft, *motion, self.inertia, self.motor, *self._band())

    def advance(self, theta: Array, torque: Array, step: float) -> None:
        self._given[:] = torque + self.motor
        self.fleet.step(self._given[:, None], step, self._outputs)

    def arrays(self) -> tuple[Array, ...]:
        return (self._outputs, self.motor, self._given)


def _warn_of_step(port: DrivePort, step: float) -> None:
    """In a step in which the cam breaks away or comes to rest, the law of the shaft has an error. That error
    stays small if the step is short beside the swing of the cam on the shaft: K h^2 <= J."""
    cam, inertia = port.cam, float(port.inertia.min())
    if cam.stiffness * step**2 > inertia:
        warnings.warn(
            f"joint {cam.joint!r}: the drive train may tremble where it breaks away or comes to rest, since"
            f" K h^2 = {cam.stiffness * step**2:.3g} kg.m2 is above inertia.shaft = {inertia:.3g} kg.m2: what"
            f" works is a time step up to {math.sqrt(inertia / cam.stiffness):.3g} s, a stiffness up to"
            f" {inertia / step**2:.3g} N.m/rad, or CamJoint",
            UnstableCouplingWarning,
            stacklevel=4,
        )
