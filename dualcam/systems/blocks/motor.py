"""A brushless motor with a gear, and the motor that the example systems use.

SI units. Torques, speeds and inertias with the word "output" are those of the shaft behind the gear.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from dualcam.coupling.plant import reflected_inertia


@dataclass(frozen=True)
class Motor:
    """A brushless motor with a gear, as one equivalent DC winding: v = R i + L di/dt + Kt gear omega.

    The gear is rigid and has no losses.

    Parameters
    ----------
    resistance : Resistance of the winding [ohm].
    inductance : Inductance of the winding [H].
    torque_constant : Torque per current at the rotor [N.m/A], which is the back-EMF per speed [V.s/rad].
    rotor_inertia : Inertia of the rotor [kg.m2].
    gear : Turns of the rotor per turn of the output [1].
    voltage : Largest voltage of the drive [V].
    peak_torque : Largest torque at the output [N.m].
    rated_torque : Continuous torque at the output [N.m].
    peak_speed : Largest speed of the output [rad/s].

    Examples
    --------
    >>> from dualcam.systems.blocks.motor import AK80_6
    >>> round(AK80_6.output_constant, 3), round(AK80_6.inertia, 5)  # N.m/A, kg.m2
    (0.546, 0.00219)
    """

    resistance: float
    inductance: float
    torque_constant: float
    rotor_inertia: float
    gear: float
    voltage: float
    peak_torque: float
    rated_torque: float
    peak_speed: float

    @property
    def output_constant(self) -> float:
        """Torque per ampere at the output [N.m/A]."""
        return self.torque_constant * self.gear

    @property
    def inertia(self) -> float:
        """Rotor inertia at the output [kg.m2]."""
        return reflected_inertia(self.gear, self.rotor_inertia)

    @property
    def electrical_time_constant(self) -> float:
        """L/R [s]."""
        return self.inductance / self.resistance

    def with_gear(self, ratio: float) -> Motor:
        """The same motor behind another gear without losses.

        `ratio`: turns of this motor's output per turn of the new one [1], which is slower by this factor.
        """
        return replace(
            self,
            gear=self.gear * ratio,
            peak_torque=self.peak_torque * ratio,
            rated_torque=self.rated_torque * ratio,
            peak_speed=self.peak_speed / ratio,
        )

    def rms_current(self, heat: float, duration: float) -> float:
        """The RMS current [A] that makes a `heat` [J] in the winding in a `duration` [s]: heat = R I^2 t."""
        return math.sqrt(heat / (self.resistance * duration))


# T-Motor AK80-6. Source: dfki-ric-underactuated-lab/torque_limited_simple_pendulum,
# hardware/testbench_description.md, BSD-3-Clause. The source gives R and L from phase to phase. With Kt they
# serve here as one equivalent winding. The heat of all compared cases is scaled alike.
AK80_6 = Motor(
    resistance=0.170,
    inductance=57e-6,
    torque_constant=0.091,
    rotor_inertia=6.0719e-5,
    gear=6.0,
    voltage=24.0,
    peak_torque=12.0,
    rated_torque=6.0,
    peak_speed=38.2,
)
