"""Many motor-driven axes under loads by one fleet of the forward FMU, begun at any state."""

from collections.abc import Mapping
from typing import Protocol, Self

import numpy as np

from dualcam.common.moved import also_called
from dualcam.design.statics import Array
from dualcam.fleet import Fleet
from dualcam.fleet.values import FleetValue
from dualcam.systems.blocks.axis import angle_amid


class Loads(Protocol):
    """The loads of many axes by their angles."""

    def torque(self, theta: Array, /) -> Array:
        """The torques of the loads [N.m], + in the direction of theta, shape (count,).

        `theta`: angles of the axes [rad], shape (count,).
        """
        ...


class AxisBank:
    """Many axes as `dualcam.systems.blocks.axis.CamAxis` has one, without a gear.

    Parameters
    ----------
    count : Number of axes.
    parameters : Start values of the FMU: one value for all axes, or an array of shape (count,).

    Attributes
    ----------
    angle, speed : State of the axes [rad, rad/s], shape (count,).

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.systems.machines import elbow
    >>> from dualcam.systems.blocks.axis_bank import AxisBank
    >>> payload = np.array([0.5, 1.5, 2.5])  # kg
    >>> with AxisBank(3, elbow.plant_parameters(elbow.design_cam(), 1.5)) as bank:
    ...     bank.start(np.full(3, 1.0), np.zeros(3), {"inertia.shaft": elbow.inertia(payload)})
    ...     for _ in range(50):
    ...         bank.step(np.full(3, -3.0), elbow.weight(payload), 1e-3)
    ...     bank.angle.round(4).tolist()  # rad: the motor lifts the two lighter arms
    [0.9803, 0.9965, 1.0]
    """

    def __init__(self, count: int, parameters: Mapping[str, FleetValue]) -> None:
        self._fleet = Fleet("forward", count, parameters={**parameters, "ledger": False})
        self._tau, self._state = np.empty((count, 1)), np.empty((count, 2))
        self._read(np.column_stack([self._fleet.get("theta"), self._fleet.get("omega")]))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def close(self) -> None:
        """Free all instances. Any later call is an error."""
        self._fleet.close()

    def start(self, angle: Array, speed: Array, parameters: Mapping[str, FleetValue]) -> None:
        """Begin a new run of all axes.

        `angle`, `speed`: state at the beginning [rad, rad/s], shape (count,). `parameters`: start values that
        replace earlier ones. FleetError: the FMU refuses a start value.
        """
        self._fleet.reset(parameters={**parameters, "initial.theta": angle, "initial.omega": speed})
        self.angle, self.speed = angle, speed

    @also_called(size="step")
    def step(self, torque: Array, loads: Loads, step: float) -> None:
        """One step of all axes, with torques that are constant over the step.

        `torque`: torques of the motors [N.m], shape (count,). `loads`: the loads, held over the step at the
        angle amid the step. `step`: length of the step [s]. FleetError: the FMU refuses the step of an axis.
        """
        self._tau[:, 0] = torque + loads.torque(angle_amid(self.angle, self.speed, step))
        self._read(self._fleet.step(self._tau, step, self._state))

    def _read(self, state: Array) -> None:
        self.angle, self.speed = state.T.copy()
