"""The scene in the FMU: co-simulation, with the shaft's torque as a polynomial in time.

tau = K (Omega t - theta) depends on theta. Per step the FMU gets the torque and three derivatives at the
beginning of the step, from omega, alpha and the jerk there:

    tau' = K (Omega - omega),    tau'' = -K alpha,    tau''' = -K jerk"""

from __future__ import annotations

import math
import warnings

from benchmarks.stick_slip.scene import INERTIA, SHAFT, Cycle, Scene
from dualcam import Fmu
from dualcam.control.forward import LOADING
from dualcam.errors import UnitWarning

STEP = 2e-4  # s, of the communication; 1/630 of the natural period
LONGEST = 10.0  # natural periods of slip without rest, after which a cycle counts as ended


class SoftShaft:
    """The FMU behind the soft shaft. Time 0 has the twist `twist` [rad]."""

    def __init__(
        self, fmu: Fmu, scene: Scene, speed: float, omega: float, twist: float, tolerance: float = 1e-11
    ) -> None:
        values = scene.parameters() | {"initial.omega": omega, "tau": SHAFT * twist}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UnitWarning)  # stops at many turns are meant
            fmu.start(values, tolerance=tolerance)
        self.fmu, self.speed, self.begin = fmu, speed, twist
        self._tau, self._omega = fmu.reals("tau"), fmu.reals("omega")
        self._motion, self._mode = fmu.reals("theta", "omega", "alpha"), fmu.variable("mode").name

    def twist(self, theta: float) -> float:
        """delta now, at the angle of cam 2 [rad]."""
        return self.begin + self.speed * self.fmu.time - theta

    def step(self, size: float) -> None:
        theta, omega, alpha = self._motion.read()
        (jerk,) = self._omega.read_derivatives(2)
        self._tau.values[:] = SHAFT * self.twist(theta)
        self._tau.write()
        for order, derivative in enumerate((self.speed - omega, -alpha, -jerk), start=1):
            self._tau.write_derivatives(order, [SHAFT * derivative])
        self.fmu.step(size)

    def motion(self) -> tuple[float, float, float]:
        """theta, omega and alpha."""
        theta, omega, alpha = self._motion.read()
        return theta, omega, alpha

    @property
    def mode(self) -> int:
        return int(self.fmu.get(self._mode))


def cycle(fmu: Fmu, scene: Scene, speed: float, step: float = STEP, cycles: int = 3) -> Cycle | None:
    """The limit cycle: the last of some cycles from rest. None where the cam slips on without rest.

    In steady cycles the cam advances by Omega times the period, and rests at one angle in each."""
    shaft = SoftShaft(fmu, scene, speed, 0.0, scene.static_torque / SHAFT)
    allowed = LONGEST * 2.0 * math.pi / scene.natural_frequency
    rests, twists, slip_since, slipped = [0.0], [0.0], 0.0, False
    while len(rests) <= cycles:
        shaft.step(step)
        theta, omega, alpha = shaft.motion()
        slips = shaft.mode == LOADING
        if slips and not slipped:
            slip_since, twists = fmu.time, []
        if slips and abs(speed - omega) < 2.0 * abs(alpha) * step:
            # near an extreme of the twist: that of the parabola
            twists.append(shaft.twist(theta) + (speed - omega) ** 2 / (2.0 * alpha))
        if slips and fmu.time - slip_since > allowed:
            return None
        if slipped and not slips:
            rests.append(theta)
        slipped = slips
    return Cycle(0.5 * (max(twists) - min(twists)), (rests[-1] - rests[-2]) / speed)


def last_speed(fmu: Fmu, scene: Scene, low: float, high: float, accuracy: float) -> float:
    """The speed of the drive at which the limit cycle ends [rad/s], by bisection."""
    while high - low > accuracy * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if cycle(fmu, scene, middle) else (low, middle)
    return 0.5 * (low + high)


def growth_rate(fmu: Fmu, scene: Scene, speed: float, share: float = 1e-3, periods: int = 10) -> float:
    """Rate at which a small oscillation about steady slip grows [1/s], < 0 where steady slip is stable.

    Energy of the oscillation, J (omega - Omega)^2 + K (delta - delta_0)^2, begins with a speed that is off by
    `share`, and grows with twice the rate."""
    steady = (scene.damping * speed + scene.torque(speed)) / SHAFT
    shaft = SoftShaft(fmu, scene, speed, speed * (1.0 + share), steady)
    duration = periods * 2.0 * math.pi / scene.natural_frequency
    count = math.ceil(duration / STEP)
    for _ in range(count):
        shaft.step(duration / count)
    theta, omega, _ = shaft.motion()
    energy = INERTIA * (omega - speed) ** 2 + SHAFT * (shaft.twist(theta) - steady) ** 2
    return 0.5 * math.log(energy / (INERTIA * (share * speed) ** 2)) / duration
