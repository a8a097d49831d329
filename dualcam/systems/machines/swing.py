"""The measured swing of a walker, sampled for simulation: motion of the knee and of its hinge on the thigh.

The swing lasts from toe-off (65 % of the gait cycle) to heel strike. At other cadences than the self-selected
one the same curves over the phase of the stride take a shorter or longer time, as if the walker took the same
steps faster. Inertial torques then grow with the square of the cadence, gravity's do not.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from dualcam.design.statics import Array
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD
from dualcam.systems.blocks.motions import FourierSeries
from dualcam.systems.blocks.pendulum import HingeMotion
from dualcam.systems.machines.gait import Walker

SWING = (0.65, 1.0)  # toe-off to heel strike, in strides


@dataclass(frozen=True)
class Swing:
    """One swing of a walker at a cadence, one entry per end of a control period.

    Attributes
    ----------
    walker : The measured walker.
    cadence : Share of the self-selected cadence [1].
    rotor_inertia : Inertia of the rotor at the knee [kg.m2].
    period : Control period [s].
    time : Time from toe-off [s], shape (n + 1,).
    extension : Knee angle at the stop [rad].
    angle : Measured knee angle from the stop [rad], shape (n + 1,).
    speed : Its first time derivative [rad/s], shape (n + 1,).
    acceleration : Its second time derivative [rad/s2], shape (n + 1,).
    hinge : The motion of the knee itself, n + 1 entries.
    """

    walker: Walker
    cadence: float
    rotor_inertia: float
    period: float
    time: Array
    extension: float
    angle: Array
    speed: Array
    acceleration: Array
    hinge: list[HingeMotion]

    @property
    def demand(self) -> Array:
        """Torque against flexion [N.m] that makes joint and rotor follow the measured motion."""
        return self._drive - (self.walker.pendulum.inertia + self.rotor_inertia) * self.acceleration

    @property
    def moment(self) -> Array:
        """Knee extension moment [N.m] of the leg without any rotor, by inverse dynamics."""
        return self._drive - self.walker.pendulum.inertia * self.acceleration

    @property
    def percent_of_stride(self) -> Array:
        """Gait cycle [%]."""
        return 100.0 * (SWING[0] + self.time * self.cadence / self.walker.stride)

    @property
    def _drive(self) -> Array:
        angles = (self.angle + self.extension).tolist()
        pairs = zip(self.hinge, angles, strict=True)
        return np.array([self.walker.pendulum.drive(hinge, angle)[0] for hinge, angle in pairs])


def measured_swing(
    walker: Walker, cadence: float, rotor_inertia: float, period: float = CONTROL_PERIOD
) -> Swing:
    """The measured swing of a `walker`, sampled from toe-off to heel strike.

    `cadence`: share of the self-selected cadence [1]. `rotor_inertia`: inertia of the rotor at the knee
    [kg.m2]. `period`: control period [s].

    Examples
    --------
    >>> from dualcam.systems.machines.gait import DESIGN_WALKER
    >>> from dualcam.systems.machines.swing import measured_swing
    >>> swing = measured_swing(DESIGN_WALKER, cadence=1.0, rotor_inertia=0.0)
    >>> len(swing.time), round(float(swing.time[-1]), 3)  # 35 % of the stride of 1.195 s, every ms
    (419, 0.418)
    """
    stride = walker.stride / cadence
    periods = round((SWING[1] - SWING[0]) * stride / period)
    time = period * np.arange(periods + 1, dtype=float)
    since = SWING[0] * stride + time  # s since heel strike
    knee, thigh, forward, upward = (
        FourierSeries(curve, stride) for curve in (walker.knee, walker.thigh, walker.forward, walker.upward)
    )
    tilt = np.column_stack([thigh.sample(since, order) for order in range(5)])
    ahead = np.column_stack([forward.sample(since, order) for order in (2, 3, 4)])
    above = np.column_stack([upward.sample(since, order) for order in (2, 3, 4)])
    rows = zip(tilt.tolist(), ahead.tolist(), above.tolist(), strict=True)
    extension = full_extension(walker)
    return Swing(
        walker=walker,
        cadence=cadence,
        rotor_inertia=rotor_inertia,
        period=period,
        time=time,
        extension=extension,
        angle=knee.sample(since) - extension,
        speed=knee.sample(since, 1),
        acceleration=knee.sample(since, 2),
        hinge=[HingeMotion(*row) for row in rows],
    )


def full_extension(walker: Walker) -> float:
    """The smallest knee angle [rad] of the `walker`'s measured swing: the wearer's own full extension."""
    knee = FourierSeries(walker.knee, 1.0)

    def angle(phase: float) -> float:
        return float(knee.sample(np.array([phase]))[0])

    return float(minimize_scalar(angle, bounds=(0.9, 1.0), method="bounded", options={"xatol": 1e-10}).fun)
