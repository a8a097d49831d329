"""MuJoCo's step with cams on its joints, for one mjData or many."""

from collections.abc import Sequence
from typing import NamedTuple, Self

import mujoco
import numpy as np
from numpy.typing import ArrayLike, NDArray

from dualcam.common.arrays import Array, real_array
from dualcam.errors import MujocoError
from dualcam.fleet import Fleet
from dualcam.fleet.values import chosen_instances
from dualcam.mujoco.cam_joint import CamJoint
from dualcam.mujoco.model_joint import check_range, checked_cams, checked_data, checked_model, hinge_joint
from dualcam.mujoco.ports import DrivePort, Port, PortState, port_of
from dualcam.mujoco.torques import FreeMotion, shaft_torques

WHOLE_STATE = mujoco.mjtState.mjSTATE_INTEGRATION


class _Views(NamedTuple):
    """Arrays of one mjData, looked up once."""

    qpos: Array
    qvel: Array
    free_acceleration: Array  # without constraints and cams
    applied: Array
    constraint: Array


class SimulationState(NamedTuple):
    """The whole state of a CamSimulation, from `CamSimulation.save`.

    `physics`: state of each mjData, as `mujoco.mj_getState` gives it for mjSTATE_INTEGRATION, shape (count,
    size). `ports`: states of the cams. `arrays`: torques of the last step.
    """

    physics: Array
    ports: tuple[PortState, ...]
    arrays: tuple[Array, ...]


class CamSimulation:
    """A MuJoCo model with cams on its hinge joints: one mjData, or many.

    `step` takes the place of `mujoco.mj_step`. The torques of the cams are found together with the motion at
    the end of the step, so that no stiffness of a shaft is too large for the model's time step. Each mjData
    moves bit for bit as if it were alone.

    Parameters
    ----------
    model : The model. Its integrator is Euler, implicit or implicitfast.
    data : The data that are stepped. The cams start at their joints' present angles.
    cams : The cams, each on a joint of its own. A `DriveTrain` is a CamJoint.

    Attributes
    ----------
    data : The data.
    torque
        Torques of the shafts on the cams in the last step [N.m], shape (count, n). A joint has the torque
        -ratio times that.

    Raises
    ------
    MujocoError : A joint, a model or data that do not suit. The message says what would.

    Examples
    --------
    >>> import mujoco
    >>> from dualcam.mujoco import CamJoint, CamSimulation
    >>> from dualcam.mujoco.ur3e_elbow import elbow_mjcf
    >>> model = mujoco.MjModel.from_xml_string(elbow_mjcf(payload=1.5, limits=(0.0, 1.3963)))
    >>> data = mujoco.MjData(model)
    >>> data.qpos[:] = 1.0, -1.0  # rad
    >>> cam = CamJoint("elbow", stiffness=4000.0, parameters={"spring.stiffness": 70e3})
    >>> with CamSimulation(model, data, cam) as simulation:
    ...     for _ in range(1000):
    ...         simulation.step()
    >>> [round(float(x), 2) for x in (data.qpos[0], simulation.torque[0, 0])]  # rad, N.m of gravity
    [1.0, 7.99]
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData | Sequence[mujoco.MjData],
        cams: CamJoint | Sequence[CamJoint],
    ) -> None:
        self.model = checked_model(model)
        self.data = checked_data(model, data)
        self.cams = checked_cams(cams)
        joints = [hinge_joint(model, cam) for cam in self.cams]
        self._qpos = np.array([joint.qpos for joint in joints])
        self._dofs = np.array([joint.dof for joint in joints])
        self._ratio = np.array([float(cam.ratio) for cam in self.cams])
        self._offset = np.array([float(cam.offset) for cam in self.cams])
        self._units = np.zeros((len(joints), model.nv))
        self._units[range(len(joints)), self._dofs] = 1.0
        self._ratios = np.outer(self._ratio, self._ratio)
        self._views = [
            _Views(one.qpos, one.qvel, one.qacc_smooth, one.qfrc_applied, one.qfrc_constraint)
            for one in self.data
        ]
        count, n = len(self.data), len(joints)
        self.torque = np.zeros((count, n))
        self._angle, self._speed, self._acceleration = np.zeros((3, count, n))  # of the joints
        self._responses = np.zeros((count, n, model.nv))  # accelerations per torque on each of the joints
        self._rows = list(self._responses)
        self._constraint = np.zeros((count, model.nv))  # generalised forces of the last step
        self._times = np.zeros(count)
        self._is_whole = True  # no step has been left half done
        self._ports: list[Port] = []
        try:
            self._read_joints(np.ones(count, bool))
            theta, omega = self._theta(), self._ratio * self._speed
            for i, (cam, joint) in enumerate(zip(self.cams, joints, strict=True)):
                self._ports.append(port_of(cam, theta[:, i], omega[:, i], float(model.opt.timestep)))
                check_range(model, joint, self._ports[-1])
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the cams. Any later call is an error."""
        for port in self._ports:
            port.fleet.close()

    # ---- steps ----

    def step(self) -> None:
        """One step of all mjData with their cams, in place of `mujoco.mj_step`.

        MujocoError: the time of an mjData is not that after the last step: the cams do not know what happened
        since. Or the last step failed, and neither `restore` nor `reset` was called since. FleetError: the
        FMU refuses the step of an instance. FmuError: an angle of a joint is not finite.
        """
        if not self._is_whole:
            raise MujocoError("the last step failed: allowed are restore of a state, and reset of all mjData")
        step = float(self.model.opt.timestep)
        for i in range(len(self.data)):
            self._predict(i)
        self._is_whole = False
        free = self._free_motion(step)
        laws = [port.law(free.angle[:, i], free.speed[:, i], step) for i, port in enumerate(self._ports)]
        self.torque = shaft_torques(laws, free.mobility, self.torque)
        on_joints = -self._ratio * self.torque
        for i in range(len(self.data)):
            self._finish(i, on_joints[i])
        theta = self._theta()
        for i, port in enumerate(self._ports):
            port.advance(theta[:, i], self.torque[:, i], step)
        self._is_whole = True

    def _predict(self, i: int) -> None:
        """The first half of the step of one mjData, up to its accelerations without cams and constraints."""
        model, data, views = self.model, self.data[i], self._views[i]
        mujoco.mj_step1(model, data)
        if data.time != self._times[i]:
            raise MujocoError(
                f"time of mjData {i} = {data.time:.9g} s, but its cams are at {self._times[i]:.9g} s: allowed"
                " are step and restore of CamSimulation, and reset after mj_step, another change of the state"
                " or mj_resetData, which MuJoCo also calls where a state is not finite"
            )
        mujoco.mj_fwdActuation(model, data)
        mujoco.mj_fwdAcceleration(model, data)
        mujoco.mj_solveM(model, data, self._rows[i], self._units)
        self._angle[i] = views.qpos[self._qpos]
        self._speed[i] = views.qvel[self._dofs]
        self._acceleration[i] = views.free_acceleration[self._dofs]

    def _free_motion(self, step: float) -> FreeMotion:
        """The joints as they would move over the step without the cams.

        MuJoCo's integrators are semi-implicit: the speed at the end makes the angle at the end. The forces of
        constraints (contacts, limits, equalities) are those of the last step."""
        by_constraints = np.matmul(self._responses, self._constraint[:, :, None])[:, :, 0]
        speed = self._speed + step * (self._acceleration + by_constraints)
        angle = self._angle + step * speed
        mobility = self._ratios * self._responses[:, :, self._dofs]
        return FreeMotion(self._ratio * (angle - self._offset), self._ratio * speed, mobility)

    def _finish(self, i: int, torque: Array) -> None:
        """The step of one mjData with these torques on its joints, beside those that the user applied."""
        data, views = self.data[i], self._views[i]
        applied = views.applied[self._dofs]
        views.applied[self._dofs] = applied + torque
        mujoco.mj_step2(self.model, data)
        views.applied[self._dofs] = applied
        if not data.time > self._times[i]:
            raise MujocoError(
                f"mjData {i} was reset by MuJoCo, since its accelerations at {self._times[i]:.9g} s were not"
                " finite: allowed are smaller time steps and torques; restore a state, or reset, goes on"
            )
        self._constraint[i] = views.constraint
        self._angle[i] = views.qpos[self._qpos]
        self._times[i] = data.time

    def _theta(self) -> Array:
        """Angles of the shafts' ends at the joints, as the cams count them."""
        return self._ratio * (self._angle - self._offset)

    # ---- runs, values, states ----

    def reset(self, instances: ArrayLike | None = None) -> None:
        """Begin anew with the cams at their joints' present angles, each with the torque nearest to 0 in its
        stick band. Call this after `mujoco.mj_resetData`, or after another change of the state.

        `instances`: numbers of the mjData, or bool of shape (count,), which of them. Default: all.
        """
        chosen = chosen_instances(instances, len(self.data)).astype(bool)
        self._read_joints(chosen)
        theta, omega = self._theta(), self._ratio * self._speed
        for i, port in enumerate(self._ports):
            port.start(chosen, theta[:, i], omega[:, i])
        self._is_whole |= bool(chosen.all())

    def _read_joints(self, chosen: NDArray[np.bool_]) -> None:
        self.torque[chosen] = self._constraint[chosen] = 0.0
        for i in np.flatnonzero(chosen):
            self._angle[i] = self._views[i].qpos[self._qpos]
            self._speed[i] = self._views[i].qvel[self._dofs]
            self._times[i] = self.data[i].time

    def fleet(self, joint: str) -> Fleet:
        """The FMUs of the cam on a `joint`, one instance per mjData, for `get` and `set`. Do not step it.

        For example `simulation.fleet("elbow").get("energy.heat_cam1")`. MujocoError: the joint has no cam.
        """
        return self._port(joint).fleet

    def set_motor(self, joint: str, torque: ArrayLike) -> None:
        """Set the `torque` of a DriveTrain's motor on the cam [N.m], from the next step on.

        `torque`: one for all, or shape (count,). `joint`: its name. MujocoError: the joint has no DriveTrain,
        or a torque is not finite.
        """
        port = self._port(joint)
        if not isinstance(port, DrivePort):
            raise MujocoError(
                f"joint {joint!r} has a CamJoint, which has no motor: give the joint an actuator in the"
                " model, or use DriveTrain"
            )
        given = real_array(torque, f"torque of joint {joint!r}", MujocoError)
        if given.shape not in ((), port.motor.shape) or not np.isfinite(given).all():
            raise MujocoError(
                f"torque of joint {joint!r} = {torque!r}: allowed is a finite number, or"
                f" {len(self.data)} of them [N.m]"
            )
        port.motor[:] = given

    def _port(self, joint: str) -> Port:
        found = {port.cam.joint: port for port in self._ports}
        if joint not in found:
            raise MujocoError(f"joint {joint!r} has no cam: allowed are {', '.join(map(repr, found))}")
        return found[joint]

    def save(self) -> SimulationState:
        """The whole state of all mjData and their cams now, for `restore`."""
        physics = np.empty((len(self.data), mujoco.mj_stateSize(self.model, WHOLE_STATE)))
        for row, data in zip(physics, self.data, strict=True):
            mujoco.mj_getState(self.model, data, row, WHOLE_STATE)
        ports = tuple(port.save() for port in self._ports)
        return SimulationState(physics, ports, (self.torque.copy(), self._constraint.copy()))

    def restore(self, state: SimulationState) -> None:
        """Go back to a `state` of `save`. The run from there on repeats bit for bit.

        FmuError: the state is of another simulation.
        """
        for port, saved in zip(self._ports, state.ports, strict=True):
            port.restore(saved)
        for row, data in zip(state.physics, self.data, strict=True):
            mujoco.mj_setState(self.model, data, row, WHOLE_STATE)
        self.torque[:], self._constraint[:] = state.arrays
        self._times[:] = [data.time for data in self.data]
        self._is_whole = True
