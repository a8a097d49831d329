"""The forward equations of docs/mechanism.md, section 6, as plain Python, for the peers of the comparison.

Both grooves are alike, so gamma = theta/2. The peers profit from this, the FMU does not know it:

    z = g(theta/2)   z' = a/2   z'' = g''/4   a = g' = r s
    rho_sigma = 1/(2 kappa_sigma) = r (a + sigma mu r)/(2 (r - sigma mu a))
    (J + rho m z' + I/4) alpha = tau - b omega - rho (F_s + F_ext + D + m z'' omega^2)      F_ext = 0

The pins keep the flank that the spring presses them to, and no stop is met (tests/test_benchmarks.py).
Therefore the only event is omega = 0, at which the stick band decides. Parameters are local variables of the
right-hand sides, which compute with Python's own floats: with two states these are several times as fast as
numpy. The module imports nothing of the project, because PythonFMU copies it into an FMU.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
Rates = Callable[[float, Array], tuple[float, float]]
Piece = tuple[float, float]  # duration [s] and torque [N.m]
Advance = Callable[[Rates, int, float, float, float], tuple[float, float, float]]

HELIX, ELLIPSE = 1, 2
DEFAULTS: dict[str, float] = {
    **{
        f"cam{i}.{name}": value
        for i in (1, 2)
        for name, value in {
            "radius": 0.02,
            "profile": HELIX,
            "lead_angle": math.pi / 4,
            "ellipse_a": 0.05,
            "ellipse_b": 0.05,
            "ellipse_curvature": -1,
            "friction": 0.14,
        }.items()
    },
    "spring.preload": 50.0,
    "spring.stiffness": 50000.0,
    **dict.fromkeys(("spring.stiffness2", "spring.stiffness3"), 0.0),
    **{f"damper.{law}_{side}": 0.0 for law in "cq" for side in ("load", "release")},
    "inertia.shaft": 0.002,
    **dict.fromkeys(("inertia.follower_mass", "inertia.follower", "shaft.damping"), 0.0),
    **dict.fromkeys(("initial.theta", "initial.omega"), 0.0),
}


class Failure(Exception):
    """A solver gave up."""


class PlainCam:
    def __init__(self, parameters: Mapping[str, float]) -> None:
        p = DEFAULTS | dict(parameters)
        for name, value in p.items():
            if name.startswith("cam1.") and p["cam2" + name[4:]] != value:
                raise ValueError(f"{name}: both grooves must be alike")
        self.r, self.mu = p["cam1.radius"], p["cam1.friction"]
        self.straight = p["cam1.profile"] == HELIX
        self.spring = tuple(p[f"spring.{n}"] for n in ("preload", "stiffness", "stiffness2", "stiffness3"))
        self.damper = {s: (p[f"damper.c_{n}"], p[f"damper.q_{n}"]) for s, n in ((1, "load"), (-1, "release"))}
        self.J, self.m, self.I = (p[f"inertia.{n}"] for n in ("shaft", "follower_mass", "follower"))
        self.b = p["shaft.damping"]
        self.start = p["initial.theta"], p["initial.omega"]
        self.slope = self.r * math.tan(p["cam1.lead_angle"])
        steep = p["cam1.ellipse_a"] / p["cam1.ellipse_b"] * math.tan(p["cam1.lead_angle"])
        self.s0, self.c0 = steep / math.hypot(1.0, steep), 1.0 / math.hypot(1.0, steep)
        self.ds_dpsi = p["cam1.ellipse_curvature"] * self.r / p["cam1.ellipse_a"]
        self.height = p["cam1.ellipse_curvature"] * p["cam1.ellipse_b"]
        self.linear = (
            self.straight and not any(self.spring[2:]) and not self.damper[1][1] + self.damper[-1][1]
        )

    def groove(self, psi: float) -> tuple[float, float, float]:
        """z, g', g'' (section 2)."""
        if self.straight:
            return self.slope * psi, self.slope, 0.0
        s = self.s0 + self.ds_dpsi * psi
        c = math.sqrt((1.0 - s) * (1.0 + s))
        slope = self.ds_dpsi * self.height / c
        return self.height * (self.c0 - c), slope * s, self.ds_dpsi * slope / (c * c)

    def rho(self, a: float, sigma: float) -> float:
        return self.r * (a + sigma * self.mu * self.r) / (2.0 * (self.r - sigma * self.mu * a))

    def direction(self, theta: float, tau: float) -> int:
        """0: the torque is inside the stick band."""
        z, a, _ = self.groove(theta / 2.0)
        force, k, k2, k3 = self.spring
        force += z * (k + z * (k2 + z * k3))
        return int(tau > self.rho(a, 1) * force) - int(tau < self.rho(a, -1) * force)

    def stored(self, theta: float, omega: float) -> float:
        """Energy of the spring and of motion [J]."""
        z, a, _ = self.groove(theta / 2.0)
        force, k, k2, k3 = self.spring
        inertia = self.J + self.m * a * a / 4.0 + self.I / 4.0
        return z * (force + z * (k / 2 + z * (k2 / 3 + z * k3 / 4))) + inertia * omega * omega / 2.0

    def moving(self, sigma: int, tau: float) -> Rates:
        """Rates while it slides in direction sigma."""
        if self.linear:
            half = self.slope / 2.0
            rho = self.rho(self.slope, sigma)
            inertia = self.J + rho * self.m * half + self.I / 4.0
            push = (tau - rho * self.spring[0]) / inertia
            stiffness = rho * self.spring[1] * half / inertia
            damping = (self.b + rho * self.damper[sigma][0] * half) / inertia

            def linear(_t: float, y: Array) -> tuple[float, float]:
                theta, omega = y.tolist()
                return omega, push - stiffness * theta - damping * omega

            return linear
        c, q = self.damper[sigma]
        groove, rho_of, J, m, quarter, b = self.groove, self.rho, self.J, self.m, self.I / 4.0, self.b
        force, k, k2, k3 = self.spring

        def rates(_t: float, y: Array) -> tuple[float, float]:
            theta, omega = y.tolist()
            z, a, dda = groove(theta / 2.0)
            half = a / 2.0
            rho, v = rho_of(a, sigma), half * omega
            axial = force + z * (k + z * (k2 + z * k3)) + v * (c + q * abs(v)) + m * dda / 4.0 * omega * omega
            return omega, (tau - b * omega - rho * axial) / (J + rho * m * half + quarter)

        return rates

    def regularised(self, width: float, tau: float) -> Rates:
        """The usual smooth friction: sigma = tanh(omega/width)."""
        loading, releasing = self.damper[1], self.damper[-1]
        groove, rho_of, J, m, quarter, b = self.groove, self.rho, self.J, self.m, self.I / 4.0, self.b
        force, k, k2, k3 = self.spring
        tanh = math.tanh

        def rates(_t: float, y: Array) -> tuple[float, float]:
            theta, omega = y.tolist()
            z, a, dda = groove(theta / 2.0)
            half = a / 2.0
            c, q = loading if omega > 0.0 else releasing
            rho, v = rho_of(a, tanh(omega / width)), half * omega
            axial = force + z * (k + z * (k2 + z * k3)) + v * (c + q * abs(v)) + m * dda / 4.0 * omega * omega
            return omega, (tau - b * omega - rho * axial) / (J + rho * m * half + quarter)

        return rates

    def run(self, pieces: Sequence[Piece], advance: Advance) -> list[tuple[float, float]]:
        """theta and omega at the end of every piece of constant torque. `advance` follows the rates in one
        direction to rest or to the end of the piece and returns the time left, theta and omega. Where the
        stick band holds it, nothing is integrated."""
        theta, omega = self.start
        points = []
        for left, tau in pieces:
            while left > 0.0:
                sigma = (omega > 0.0) - (omega < 0.0) or self.direction(theta, tau)
                if sigma == 0:
                    break
                left, theta, omega = advance(self.moving(sigma, tau), sigma, left, theta, omega)
            points.append((theta, omega))
        return points

    def run_regularised(
        self, pieces: Sequence[Piece], method: str, rtol: float, width: float
    ) -> list[tuple[float, float]]:
        y, points = self.start, []
        for duration, tau in pieces:
            rates = self.regularised(width, tau)
            found = solve_ivp(rates, (0.0, duration), y, method, t_eval=(duration,), rtol=rtol, atol=rtol)
            if found.status < 0:
                raise Failure(found.message)
            y = float(found.y[0, -1]), float(found.y[1, -1])
            points.append(y)
        return points


def rest_event(sigma: int) -> Callable[[float, Array], float]:
    def rest(_t: float, y: Array) -> float:
        return float(y[1])

    marked: Any = rest
    marked.terminal, marked.direction = True, -sigma
    return rest


RESTS = {sigma: rest_event(sigma) for sigma in (1, -1)}


def scipy_advance(method: str, rtol: float) -> Advance:
    def advance(
        rates: Rates, sigma: int, left: float, theta: float, omega: float
    ) -> tuple[float, float, float]:
        found = solve_ivp(
            rates, (0.0, left), (theta, omega), method, rtol=rtol, atol=rtol, events=RESTS[sigma]
        )
        if found.status < 0:
            raise Failure(found.message)
        if found.status == 1:
            return left - float(found.t[-1]), float(found.y[0, -1]), 0.0
        return 0.0, float(found.y[0, -1]), float(found.y[1, -1])

    return advance
