"""The truth: cam and flywheel as one system, solved with all its mode changes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.coupling.scenes import CAM, DURATION, GRID, STOPS, Scene
from benchmarks.harness.fmu import LOADING, RELEASING, STICK
from benchmarks.harness.timing import Array


@dataclass
class Truth:
    """theta, omega, phi, phi' at multiples of GRID, and the start [s] of every mode."""

    states: Array
    modes: list[tuple[float, int]] = field(default_factory=list)

    def motion(self, step: float) -> Array:
        """theta and omega at multiples of `step`."""
        return self.states[:: round(step / GRID), :2]

    def resting(self) -> list[tuple[float, float]]:
        """The spans of stick [s]."""
        ends = [*self.modes, (DURATION, STICK)]
        return [(start, end) for (start, mode), (end, _) in pairwise(ends) if mode == STICK]


class Monolith:
    """Cam and flywheel as one system. Two helices: z'' = gamma'' = 0, and while the pin touches the flank
    that the spring presses it against,

        kappa_i = (1 - sigma mu_i s_i)/(r_i (s_i + sigma mu_i))      rho = 1/(kappa_1 + kappa_2)
        [J + rho m z' + rho kappa_1 I gamma'] alpha = tau - rho (F0 + k z)

    It sticks at omega = 0 while rho_- (F0 + k z) <= tau <= rho_+ (F0 + k z)."""

    def __init__(self, scene: Scene, longest: float = 1e-3) -> None:
        self.scene, self.longest = scene, longest
        radii = [CAM["cam1.radius"], CAM["cam2.radius"]]
        leads = [CAM["cam1.lead_angle"], CAM["cam2.lead_angle"]]
        slopes = [math.tan(lead) for lead in leads]
        frictions = [CAM["cam1.friction"], CAM["cam2.friction"]]
        a1, a2 = (r * s for r, s in zip(radii, slopes, strict=True))
        self.dz_dtheta = a1 * a2 / (a1 + a2)  # z'
        self.ratio, self.inertia = {}, {}
        for mode, sigma in ((LOADING, 1), (RELEASING, -1)):
            kappa1, kappa2 = (
                (1.0 - sigma * mu * s) / (r * (s + sigma * mu))
                for r, s, mu in zip(radii, slopes, frictions, strict=True)
            )
            rho = 1.0 / (kappa1 + kappa2)
            self.ratio[mode] = rho
            follower = CAM["inertia.follower"] * a2 / (a1 + a2)
            mass = CAM["inertia.follower_mass"] * self.dz_dtheta
            self.inertia[mode] = CAM["inertia.shaft"] + rho * (mass + kappa1 * follower)

    def torque(self, y: Array) -> float:
        theta, omega, phi, speed = y
        return float(self.scene.stiffness * (phi - theta) + self.scene.damping * (speed - omega))

    def excess(self, y: Array, mode: int) -> float:
        """Torque beyond the edge of the stick band at which that mode begins [N.m]."""
        force = CAM["spring.preload"] + CAM["spring.stiffness"] * self.dz_dtheta * y[0]
        return float(self.torque(y) - self.ratio[mode] * force)

    def rates(self, mode: int) -> Callable[[float, Array], list[float]]:
        scene = self.scene

        def rates(t: float, y: Array) -> list[float]:
            alpha = 0.0 if mode == STICK else self.excess(y, mode) / self.inertia[mode]
            wheel = (scene.motor(t) - scene.bearing * y[3] - self.torque(y)) / scene.inertia
            return [y[1], alpha, y[3], wheel]

        return rates

    def ends(self, mode: int) -> list[Callable[[float, Array], float]]:
        """The functions that pass through zero where that mode ends."""

        def end(value: Callable[[Array], float], direction: int) -> Callable[[float, Array], float]:
            def event(t: float, y: Array) -> float:
                return value(y)

            event.terminal = True  # type: ignore[attr-defined]
            event.direction = direction  # type: ignore[attr-defined]
            return event

        if mode == STICK:
            return [
                end(lambda y: self.excess(y, LOADING), 1),
                end(lambda y: self.excess(y, RELEASING), -1),
            ]
        return [end(lambda y: float(y[1]), -1 if mode == LOADING else 1)]

    def at_rest(self, y: Array) -> int:
        if self.excess(y, LOADING) > 0.0:
            return LOADING
        return RELEASING if self.excess(y, RELEASING) < 0.0 else STICK

    def solve(self) -> Truth:
        scene = self.scene
        instants = np.arange(round(DURATION / GRID) + 1) * GRID
        t, y = 0.0, np.array([scene.angle, 0.0, scene.angle + scene.twist, 0.0])
        mode = self.at_rest(y)
        truth = Truth(np.full((len(instants), len(y)), np.nan), [(t, mode)])
        while True:
            solution = solve_ivp(
                self.rates(mode),
                (t, instants[-1]),
                y,
                method="DOP853",
                rtol=1e-12,
                atol=1e-14,
                max_step=self.longest,
                events=self.ends(mode),
                dense_output=True,
            )
            inside = (instants >= t) & (instants <= solution.t[-1])
            if inside.any():
                truth.states[inside] = solution.sol(instants[inside]).T
            self.insist(solution.y, mode)
            if solution.status == 0:
                return truth
            t, y = float(solution.t[-1]), solution.y[:, -1].copy()
            if mode == STICK:
                mode = LOADING if solution.t_events[0].size else RELEASING
            else:
                y[1] = 0.0
                mode = self.at_rest(y)
            truth.modes.append((t, mode))

    def insist(self, states: Array, mode: int) -> None:
        """The equations above hold between the stops and while both reactions press on the first flanks."""
        if states[0].min() <= STOPS[0] or states[0].max() >= STOPS[1]:
            raise SystemExit(f"{self.scene.name}: reaches a stop")
        if mode == STICK:
            return
        alpha = np.array([self.excess(y, mode) for y in states.T]) / self.inertia[mode]
        force = CAM["spring.preload"] + CAM["spring.stiffness"] * self.dz_dtheta * states[0]
        if (force + CAM["inertia.follower_mass"] * self.dz_dtheta * alpha).min() <= 0.0:
            raise SystemExit(f"{self.scene.name}: the pin leaves its flank")
