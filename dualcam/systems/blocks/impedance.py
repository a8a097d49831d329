"""Impedance control: the motor acts like a spring and a damper between a joint and its reference motion."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from dualcam.common.moved import old_names


@dataclass(frozen=True)
class ImpedanceController:
    """A virtual spring and damper between a joint and its reference motion.

    `stiffness` of the virtual spring [N.m/rad]. `damping`: coefficient of the virtual damper [N.m.s/rad].

    Examples
    --------
    >>> from dualcam.systems.blocks.impedance import ImpedanceController
    >>> ImpedanceController(stiffness=100.0, damping=5.0).torque(error=0.1, rate=-1.0)
    -5.0
    """

    stiffness: float
    damping: float

    @classmethod
    def tuned(cls, inertia: float, frequency: float, damping_ratio: float) -> ImpedanceController:
        """The impedance for an `inertia` of the joint [kg.m2].

        `frequency`: natural frequency of the inertia on the virtual spring [Hz]. `damping_ratio` [1].
        """
        rate = 2.0 * math.pi * frequency
        return cls(rate**2 * inertia, 2.0 * damping_ratio * rate * inertia)

    def torque(self, error: float, rate: float) -> float:
        """The torque [N.m] for an `error` of the angle [rad] and its `rate` [rad/s], actual minus wanted."""
        return -self.stiffness * error - self.damping * rate


if not TYPE_CHECKING:  # type checkers report the old names
    __getattr__ = old_names(__name__, {"Impedance": "ImpedanceController"})
