"""Two helical cams with slightly elastic flanks, without any rule of flanks.

Each flank is a spring and a damper along its normal, so that the reactions follow from the motion. The
follower and cam 2 have equations of motion of their own, which SciPy's Radau method integrates. All bodies
need inertia.
Source: the balances of docs/mechanism.md, sections 2 and 9.
"""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from reference.friction import FrictionLaw
from reference.parameters import DEFAULTS
from scipy.integrate import solve_ivp

STIFFNESS = 1e12  # N/m^2, x_i per depth of the pin in flank i
DAMPING = 0.3  # of the follower between its flanks, as a share of critical damping
REVERSAL = 1e-6  # m/s, the sliding speeds within which friction changes its sign


class ElasticFlanks:
    """At rest at theta = 0 without loads in the contacts; then under a constant torque and without F_ext."""

    def __init__(self, parameters: Mapping[str, float], tau: float) -> None:
        """`tau` in N.m."""
        self.p, self.tau = DEFAULTS | dict(parameters), tau
        self.radius = [self.p[f"cam{i}.radius"] for i in (1, 2)]
        self.rise = [r * math.tan(self.p[f"cam{i}.lead_angle"]) for i, r in enumerate(self.radius, 1)]
        self.length = [math.hypot(r, a) for r, a in zip(self.radius, self.rise, strict=True)]
        self.laws = [FrictionLaw.of_cam(self.p, i) for i in (1, 2)]
        lightest = min(self.p["inertia.follower_mass"], self.p["inertia.follower"] / self.rise[0] ** 2)
        self.damping = 2.0 * DAMPING * math.sqrt(STIFFNESS * lightest)

    def contact(self, i: int, depth: float, rate: float, turn: float, load: float) -> tuple[float, float]:
        """Torque, N.m, and axial force, N, of contact i. `depth` in m, `rate` in m/s, `turn` in rad/s; `load`
        in N: the axial load, which makes the nominal load of docs/mechanism.md, section 9."""
        r, a, sliding = self.radius[i], self.rise[i], turn * self.length[i]
        x = STIFFNESS * depth + self.damping * rate
        share = self.rise[1 - i] / sum(self.rise) * self.length[i] / r
        mu = self.laws[i].at(abs(sliding), abs(load) * share / self.p["contacts"])
        friction = math.tanh(sliding / REVERSAL) * mu * abs(x)
        return r * (a * x + r * friction), r * x - a * friction

    def rates(self, _: float, state: Sequence[float]) -> list[float]:
        """Of z, gamma, theta and their speeds."""
        p, a = self.p, self.rise
        z, gamma, theta, dz, dgamma, dtheta = state
        turns, speeds = (gamma, theta - gamma), (dgamma, dtheta - dgamma)
        spring = p["spring.preload"] + p["spring.stiffness"] * z
        (torque1, axial1), (torque2, axial2) = (
            self.contact(i, a[i] * turns[i] - z, a[i] * speeds[i] - dz, speeds[i], spring) for i in (0, 1)
        )
        return [
            dz,
            dgamma,
            dtheta,
            (axial1 + axial2 - spring) / p["inertia.follower_mass"],
            (torque2 - torque1) / p["inertia.follower"],
            (self.tau - torque2) / p["inertia.shaft"],
        ]

    def angle_after(self, end: float) -> float:
        """theta after `end` seconds, rad."""
        found = solve_ivp(
            self.rates, (0.0, end), np.zeros(6), "Radau", rtol=1e-7, atol=1e-13, max_step=end / 20
        )
        assert found.success, found.message
        return float(found.y[2, -1])
