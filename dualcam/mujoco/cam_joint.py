"""What sits on a joint: a cam beside the joint, or a cam between a motor and the joint."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from dualcam.design_file.reader import DesignSource, as_design
from dualcam.errors import MujocoError
from dualcam.fleet.values import FleetValue
from dualcam.systems.blocks.axis import CamGear


@dataclass(frozen=True)
class CamJoint:
    """A cam that acts on a hinge joint beside the joint's actuators, through an elastic shaft.

    The inverse FMU gets the angle of the shaft at the joint and gives the shaft's torque. Friction holds
    the cam while that torque is inside the stick band.

    Parameters
    ----------
    joint : Name of the joint in the model.
    stiffness
        Torsional stiffness of the shaft between the cam and the joint [N.m/rad]. A round steel shaft has 79
        GPa pi d^4/(32 l).
    design : The design, or the path of its file. Default: the FMU's default values.
    parameters
        Parameters of the FMU that replace those of the design: one value, or an array with one value per
        mjData.
    ratio
        Angle of the cam over that of the joint [1], not 0. With ratio < 0 the cam turns against the joint.
    offset : Angle of the joint at theta = 0 of the cam [rad].
    cam_stops
        Whether the stops of the cam may carry the joint. Else the range of the joint must be inside them.

    Raises
    ------
    MujocoError : A number that cannot be.

    Examples
    --------
    >>> from dualcam.mujoco import CamJoint
    >>> CamJoint("elbow", stiffness=4000.0, ratio=-1.0, offset=1.2).gear.cam_angle(0.5)
    0.7
    """

    joint: str
    stiffness: float
    design: DesignSource | None = None
    parameters: Mapping[str, FleetValue] = field(default_factory=dict)
    ratio: float = 1.0
    offset: float = 0.0
    cam_stops: bool = False

    model: ClassVar[str] = "inverse"

    def __post_init__(self) -> None:
        if not isinstance(self.joint, str) or not self.joint:
            raise MujocoError(f"joint = {self.joint!r}: allowed is the name of a hinge joint")
        if not isinstance(self.parameters, Mapping):
            raise MujocoError(
                f"joint {self.joint!r}: parameters = {self.parameters!r}: allowed is a dict of values by name"
            )
        self._check("stiffness", lambda value: value > 0.0, "a finite number > 0, in N.m/rad")
        self._check("ratio", lambda value: value != 0.0, "a finite number, not 0")
        self._check("offset", lambda value: True, "a finite number, in rad")

    def _check(self, name: str, suits: Callable[[float], bool], allowed: str) -> None:
        value = getattr(self, name)
        is_number = isinstance(value, int | float | np.number) and math.isfinite(value)
        if not is_number or not suits(value):
            raise MujocoError(f"joint {self.joint!r}: {name} = {value!r}: allowed is {allowed}")

    @property
    def gear(self) -> CamGear:
        """How the joint drives the cam."""
        return CamGear(self.ratio, self.offset)

    def values(self) -> dict[str, FleetValue]:
        """Start values of the FMU by name, of the design and the parameters."""
        found: dict[str, FleetValue] = {}
        if self.design is not None:
            found.update(as_design(self.design).parameters_for(self.model))
        return found | dict(self.parameters)


@dataclass(frozen=True)
class DriveTrain(CamJoint):
    """A motor and the cam behind an elastic shaft that drives a hinge joint.

    The forward FMU gets the torques of the motor and of the shaft and gives the motion of the cam. Its
    `inertia.shaft` is that of cam and rotor. All friction laws, dampers and inertias of the cam act. The time
    step h should satisfy K h^2 <= `inertia.shaft`; beyond comes an UnstableCouplingWarning.

    `joint`, `stiffness`, `design`, `parameters`, `ratio`, `offset`, `cam_stops`: as in `CamJoint`.
    `inertia.shaft` must be > 0. `damping` of the shaft between the cam and the joint [N.m.s/rad].
    MujocoError: a number that cannot be.
    """

    damping: float = 0.0

    model: ClassVar[str] = "forward"

    def __post_init__(self) -> None:
        super().__post_init__()
        self._check("damping", lambda value: value >= 0.0, "a finite number >= 0, in N.m.s/rad")
