"""The scene: cam 2 turns upwards, driven at constant speed through a soft shaft.

    J omega' = K delta - b omega - T(omega),    delta' = Omega - omega,    delta = Omega t - theta

Both grooves are helices of 45 deg and equal radius, and the spring has no stiffness. So the torque T of the
cam depends on the speed alone (docs/mechanism.md, sections 3 and 9):

    T(omega) = F r/2 (1 + mu(v))/(1 - mu(v)),    v = omega r/sqrt(2)

The equations stand here once more, apart from the FMU, because the references are made of them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

RADIUS, FORCE, KINETIC, INERTIA = 0.02, 100.0, 0.14, 0.002  # m, N, 1, kg.m2
SHAFT = 5.0  # N.m/rad, stiffness K of the soft shaft
SLIDING = RADIUS / math.sqrt(2.0)  # m/rad, sliding speed over the speed of cam 2
FAR = 1e3  # rad, of the stops


@dataclass(frozen=True)
class Scene:
    """Friction law and damping.

    `drop`: "sudden" for Coulomb friction with a static excess, whose fall takes no speed, else "Stribeck".
    For the FMU a sudden drop is a fall within `stribeck_velocity`."""

    peak: float = 1.5
    stribeck_velocity: float = 0.01  # m/s
    exponent: int = 2
    damping: float = 0.01  # N.m.s/rad, b
    drop: str = "Stribeck"

    @property
    def natural_frequency(self) -> float:
        """Of the cam on the soft shaft [rad/s]."""
        return math.sqrt(SHAFT / INERTIA)

    @property
    def damping_ratio(self) -> float:
        return self.damping / (2.0 * math.sqrt(SHAFT * INERTIA))

    @property
    def static_torque(self) -> float:
        """At which slip begins [N.m]."""
        return torque_of(KINETIC * self.peak)

    @property
    def kinetic_torque(self) -> float:
        """Of fast slip [N.m]."""
        return torque_of(KINETIC)

    def coefficient(self, omega: float) -> float:
        """mu at a speed [rad/s], > 0 where the drop is sudden."""
        if self.drop == "sudden":
            return KINETIC
        ratio = max(omega, 0.0) * SLIDING / self.stribeck_velocity
        return KINETIC * (1.0 + (self.peak - 1.0) * math.exp(-(ratio**self.exponent)))

    def torque(self, omega: float) -> float:
        """T(omega) of slip [N.m]."""
        return torque_of(self.coefficient(omega))

    def slope(self, omega: float) -> float:
        """dT/domega [N.m.s/rad], < 0."""
        mu, ratio = self.coefficient(omega), omega * SLIDING / self.stribeck_velocity
        power = self.exponent * ratio ** (self.exponent - 1) * SLIDING / self.stribeck_velocity
        fall = -(mu - KINETIC) * power
        return FORCE * RADIUS / (1.0 - mu) ** 2 * fall

    def parameters(self) -> dict[str, float | int]:
        """Start values of the forward FMU."""
        values: dict[str, float | int] = {
            "spring.preload": FORCE,
            "spring.stiffness": 0.0,
            "inertia.shaft": INERTIA,
            "shaft.damping": self.damping,
            "stop.lower": -FAR,
            "stop.upper": FAR,
        }
        for cam in ("cam1", "cam2"):
            values |= {
                f"{cam}.radius": RADIUS,
                f"{cam}.lead_angle": math.pi / 4,
                f"{cam}.friction": KINETIC,
                f"{cam}.friction_peak": self.peak,
                f"{cam}.stribeck_velocity": self.stribeck_velocity,
                f"{cam}.stribeck_exponent": self.exponent,
            }
        return values

    def with_drop_within(self, velocity: float) -> Scene:
        """The same scene with another Stribeck velocity [m/s]."""
        return replace(self, stribeck_velocity=velocity)


def torque_of(mu: float) -> float:
    """Torque that moves the cam upwards against friction [N.m]."""
    return 0.5 * FORCE * RADIUS * (1.0 + mu) / (1.0 - mu)


SUDDEN = Scene(drop="sudden", stribeck_velocity=1e-9, exponent=1)
STRIBECK = Scene()
SCENES = {"static excess": SUDDEN, "Stribeck": STRIBECK}


@dataclass(frozen=True)
class Cycle:
    """A limit cycle with rest.

    `amplitude`: half the range of the twist delta [rad]. `period` [s]."""

    amplitude: float
    period: float
