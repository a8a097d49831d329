"""A brushless motor with a gear, and the motor that the example systems use.

SI units. Torques, speeds and inertias with the word "output" are those of the shaft behind the gear.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from dualcam.plant import reflected_inertia


@dataclass(frozen=True)
class Motor:
    """A brushless motor with a gear, as one equivalent DC winding: v = R i + L di/dt + Kt gear omega.

    The gear is rigid and has no losses.
    """

    resistance: float  # ohm
    inductance: float  # H
    torque_constant: float  # N.m/A at the rotor, and V.s/rad
    rotor_inertia: float  # kg.m2
    gear: float  # rotor turns per output turn
    voltage: float  # V, the largest voltage of the drive
    peak_torque: float  # N.m at the output
    rated_torque: float  # N.m at the output, continuous
    peak_speed: float  # rad/s at the output

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
        """The same motor behind another gear without losses, which divides the output speed by `ratio`."""
        return replace(
            self,
            gear=self.gear * ratio,
            peak_torque=self.peak_torque * ratio,
            rated_torque=self.rated_torque * ratio,
            peak_speed=self.peak_speed / ratio,
        )

    def rms_current(self, heat: float, duration: float) -> float:
        """RMS current [A] that makes this heat [J] in the winding within this time [s]: heat = R I^2 t."""
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
