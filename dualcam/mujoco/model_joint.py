"""Whether a model, its data and its joints suit the cams, with messages that say what would."""

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from dualcam.errors import MujocoError
from dualcam.fmi.handle import unknown_variable
from dualcam.mujoco.cam_joint import CamJoint
from dualcam.mujoco.ports import Port

TYPES = {
    int(mujoco.mjtJoint.mjJNT_FREE): "free",
    int(mujoco.mjtJoint.mjJNT_BALL): "ball",
    int(mujoco.mjtJoint.mjJNT_SLIDE): "slide",
}
ROUNDING = 1e-9  # rad, of a joint's range beyond the cam's stops


class HingeJoint(NamedTuple):
    """Where the model has a hinge joint."""

    number: int  # in the model's list of joints
    qpos: int  # index of its angle
    dof: int  # index of its speed


def checked_model(model: object) -> mujoco.MjModel:
    """`model`, where it is one that a cam can be stepped with."""
    if not isinstance(model, mujoco.MjModel):
        raise MujocoError(f"model = {model!r}: allowed is a mujoco.MjModel")
    if model.opt.integrator == mujoco.mjtIntegrator.mjINT_RK4:
        raise MujocoError(
            "the model's integrator is RK4, which takes no torque that depends on the end of the step:"
            ' allowed are Euler, implicit and implicitfast, as in <option integrator="implicitfast"/>'
        )
    return model


def checked_data(model: mujoco.MjModel, data: object) -> list[mujoco.MjData]:
    """`data` as a list, each of that model and each only once."""
    listed = list(data) if isinstance(data, Sequence) else [data]
    for one in listed:
        if not isinstance(one, mujoco.MjData):
            raise MujocoError(f"data = {one!r}: allowed is a mujoco.MjData of the model, or a list of them")
        if one.model is not model and one.model._address != model._address:
            raise MujocoError("data is of another model: allowed is mujoco.MjData(model)")
    if not listed or len({id(one) for one in listed}) < len(listed):
        raise MujocoError(f"{len(listed)} mjData: allowed are one or more, each only once in the list")
    return listed


def checked_cams(cams: object) -> list[CamJoint]:
    """`cams` as a list of cams on different joints."""
    given = list(cams) if isinstance(cams, Sequence) else [cams]
    listed = [cam for cam in given if isinstance(cam, CamJoint)]
    if len(listed) < len(given) or not listed:
        raise MujocoError(f"cams = {cams!r}: allowed are one or more CamJoint or DriveTrain")
    names = [cam.joint for cam in listed]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise MujocoError(f"joint {twice[0]!r} has {names.count(twice[0])} cams: allowed is one")
    return listed


def hinge_joint(model: mujoco.MjModel, cam: CamJoint) -> HingeJoint:
    """The joint of a cam in a model."""
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, cam.joint)
    if index < 0:
        names = [model.joint(k).name for k in range(model.njnt)]
        hinges = [
            name for name, kind in zip(names, model.jnt_type, strict=True) if name and int(kind) not in TYPES
        ]
        raise MujocoError(unknown_variable(cam.joint, hinges, "the model").replace("variable", "hinge joint"))
    kind = TYPES.get(int(model.jnt_type[index]))
    if kind:
        raise MujocoError(
            f'joint {cam.joint!r} is of type "{kind}": allowed is "hinge", as the cam turns about an axis'
        )
    return HingeJoint(index, int(model.jnt_qposadr[index]), int(model.jnt_dofadr[index]))


def check_range(model: mujoco.MjModel, joint: HingeJoint, port: Port) -> None:
    """The range of the joint is inside the stops of all its cams, or the stops may carry the joint."""
    cam = port.cam
    if cam.cam_stops:
        return
    stops = np.array([port.stops[0].max(), port.stops[1].min()])
    allowed = np.sort(cam.gear.angle(stops))
    works = (
        f'range="{allowed[0]:.6g} {allowed[1]:.6g}" in radians or a smaller one, another offset or ratio, or'
        " cam_stops=True, with which the stops of the cam carry the joint"
    )
    stops_text = f"The stops of the cam, {stops[0]:.6g} and {stops[1]:.6g} rad, allow"
    if not model.jnt_limited[joint.number]:
        raise MujocoError(f"joint {cam.joint!r} has no limits. {stops_text} {works}")
    low, high = model.jnt_range[joint.number]
    if low < allowed[0] - ROUNDING or high > allowed[1] + ROUNDING:
        raise MujocoError(
            f"joint {cam.joint!r} has the range {low:.6g} to {high:.6g} rad. {stops_text} {works}"
        )
