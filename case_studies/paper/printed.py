"""The paper's equations as printed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from case_studies.paper.published import GREASES, INNER_RADIUS, LOADING, OUTER_RADIUS
from dualcam.design.statics import transfer


@dataclass(frozen=True)
class Case:
    """Two helices under an axial force, with the torque [N.m] by the paper's equations."""

    lead: tuple[float, float] = (0.8203, 0.7)  # rad
    radii: tuple[float, float] = (INNER_RADIUS, OUTER_RADIUS)  # m
    friction: float = GREASES[0]
    force: float = 1000.0  # N

    def tangents(self, direction: int = LOADING) -> tuple[float, float]:
        """tan(lambda_i + direction phi)."""
        phi = direction * math.atan(self.friction)
        return math.tan(self.lead[0] + phi), math.tan(self.lead[1] + phi)

    def correct(self, direction: int = LOADING) -> float:
        """Moment balance, as dualcam.design has it: T = F/(kappa_1 + kappa_2) [N.m]."""
        slopes = [radius * math.tan(lead) for radius, lead in zip(self.radii, self.lead, strict=True)]
        friction = (self.friction, self.friction)
        return self.force * float(transfer(slopes, friction, self.radii, direction).rho)

    def printed_3(self, direction: int = LOADING) -> float:
        """(3): the minus sign in the denominator."""
        (t1, t2), (r1, r2) = self.tangents(direction), self.radii
        return self.force * r2 * t2 / (1.0 - r2 * t2 / (r1 * t1))

    def tangential(self, direction: int = LOADING) -> float:
        """(7): tangential forces, not moments, are balanced; the torque is then taken at r2."""
        t1, t2 = self.tangents(direction)
        return self.radii[1] * self.force / (1.0 / t1 + 1.0 / t2)

    def swapped(self, direction: int = LOADING) -> float:
        """Section 4: each lead angle with the other cam's radius."""
        return replace(self, radii=self.radii[::-1]).correct(direction)

    def balance(self, direction: int, axial: int = 1, tangential: int = 1) -> float:
        """Torque at cam 2 from two rows: the follower's axial forces and moments, R_i normal, A_i = mu R_i.

            R1 cos l1 - s A1 sin l1 + R2 cos l2 - s A2 sin l2 = F
            r1 (R1 sin l1 + s A1 cos l1) - r2 (R2 sin l2 + s A2 cos l2) = 0        s: direction

        `axial`, `tangential` = -1 gives the term of A2 in that row the wrong sign."""
        (l1, l2), (r1, r2), mu = self.lead, self.radii, self.friction * direction
        rows = np.array(
            [
                [math.cos(l1) - mu * math.sin(l1), math.cos(l2) - axial * mu * math.sin(l2)],
                [
                    r1 * (math.sin(l1) + mu * math.cos(l1)),
                    -r2 * (math.sin(l2) + tangential * mu * math.cos(l2)),
                ],
            ]
        )
        reactions = np.linalg.solve(rows, [self.force, 0.0])
        return float(r2 * reactions[1] * (math.sin(l2) + mu * math.cos(l2)))
