"""Scenes that vary the grooves: lead angles, the ends of an ellipse, dwells."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np

from benchmarks.harness.oracles import Interval, reference
from verification.stress.mechanisms import LEADS, Sizes, Tables, damper, helices, spring, up_and_back
from verification.stress.scene import Params, Scene


def lead_angles(tables: Tables) -> Iterator[Scene]:
    row = "lead angles 1e-6 to pi/2 - 1e-6"
    for lead1, lead2 in product(LEADS, LEADS):
        for mu in (0.0, 0.05):
            p = helices(lead1, lead2) | {"cam1.friction": mu, "cam2.friction": mu}
            kin = reference.Helices(0.03 * math.tan(lead1), 0.025 * math.tan(lead2)).at(0.0)
            reach = 1.3963 * float(kin.dz)
            p |= spring(50.0 / reach, reach, nonlinear=False) | {"inertia.shaft": 0.002}
            sizes = Sizes.of(p)
            p["inertia.shaft"] = max(1e-3 * sizes.stiffness(), 1e-9)
            sizes = Sizes.of(p)
            intervals = up_and_back(1.3 * sizes.torque(0.7), 1.2 * sizes.period())
            label = f"helices {lead1:.6g}, {lead2:.6g}, mu {mu:g}"
            yield Scene(row, p, intervals, "exact", label, general=True, steps=2)
            q = dict(p)
            for i, lead in ((1, lead1), (2, lead2)):
                radius = p[f"cam{i}.radius"]
                q |= {f"cam{i}.profile": 3, f"cam{i}.table": tables.helix(radius, lead, 0.0, 1.3963)}
            yield Scene(row, q, intervals, "exact", label + ", as tables", instead=p)


def slopes_of_ellipses(tables: Tables) -> Iterator[Scene]:
    row = "ellipse close to its vertical and level ends"
    ends = [0.0, 1e-9, 1e-6, 1e-4, 1e-2]
    for end, other, mu in product(ends, (0.0, 0.3), (0.0, 0.1)):
        for kappa in (1, -1):
            # S runs over the whole of [0, 1] but `end` on one side and `other` on the other
            s0, s1 = (other, 1.0 - end) if kappa > 0 else (1.0 - max(end, 1e-9), other)
            if (kappa > 0 and end == 0.0) or not 0.0 <= s0 < 1.0:
                s1 = min(s1, 1.0 - 1e-12)
            radius = 0.03
            a = radius * 1.2 / abs(s1 - s0)
            b = 0.6 * a
            lead = math.atan(b / a * s0 / math.sqrt(1.0 - s0 * s0))
            p: Params = {
                "cam1.radius": radius,
                "cam1.profile": 2,
                "cam1.lead_angle": lead,
                "cam1.ellipse_a": a,
                "cam1.ellipse_b": b,
                "cam1.ellipse_curvature": kappa,
                "cam2.radius": 0.025,
                "cam2.lead_angle": 0.8,
                "cam1.friction": mu,
                "cam2.friction": mu,
                "inertia.shaft": 0.002,
            }
            # the last angle at which gamma is inside the arc
            groove = reference.Ellipse(radius, lead, a, b, kappa)
            gamma = 1.2 - 1e-12
            z = groove.derivatives(gamma, 0)[0]
            upper = gamma + z / (0.025 * math.tan(0.8))
            for stop in (upper * (1.0 - 1e-9), 0.9 * upper):
                # without friction a swing returns to where it began: not to a stop, that it might touch
                p = p | {"stop.upper": stop, "initial.theta": 0.03 * stop} | spring(2e4, max(z, 1e-3))
                try:
                    sizes = Sizes.of(p)
                    torque, time = 1.5 * sizes.torque(0.8 * stop), 1.5 * sizes.period()
                except (reference.Refused, ArithmeticError):
                    torque, time = 30.0, 0.05
                label = f"curvature {kappa}, S {s0:.9g} to {s1:.12g}, mu {mu}, stop {stop:.12g}"
                yield Scene(row, p, up_and_back(torque, time), "simulate", label, steps=2)


def dwells(tables: Tables) -> Iterator[Scene]:
    row = "both ends of a dwell"
    flat, second = tables.dwell(0.03, 0.3, 0.6), tables.dwell(0.025, 0.4, 0.7)
    bodies: dict[str, Params] = {
        "shaft": {"inertia.shaft": 0.002},
        "shaft and follower": {"inertia.shaft": 1e-3, "inertia.follower_mass": 2.0, "inertia.follower": 1e-4},
        "follower alone": {"inertia.shaft": 0.0, "inertia.follower_mass": 2.0},
        "viscous shaft": {"inertia.shaft": 0.0, "shaft.damping": 0.05},
        "viscous damper": {"inertia.shaft": 0.0, **damper(60.0, 30.0)},
        "none": {"inertia.shaft": 0.0},
    }
    grooves: dict[str, Params] = {
        "cam 1": {"cam1.profile": 3, "cam1.table": flat, "cam2.lead_angle": 0.8},
        "cam 2": {"cam2.profile": 3, "cam2.table": second, "cam1.lead_angle": 0.7},
        "one each": {"cam1.profile": 3, "cam1.table": flat, "cam2.profile": 3, "cam2.table": second},
    }
    for (which, groove), (body, masses), mu in product(grooves.items(), bodies.items(), (0.0, 0.1)):
        p = {"cam1.radius": 0.03, "cam2.radius": 0.025, "cam1.friction": mu, "cam2.friction": mu}
        p |= groove | masses | spring(2e4, 0.03)
        try:
            sizes = Sizes.of(p)
        except (reference.Refused, ArithmeticError):
            continue
        # angles of cam 2 at which the pin enters and leaves the flat part
        ratios = [(theta, sizes.dz_dtheta(theta)) for theta in np.linspace(0.0, 1.3963, 400).tolist()]
        flats = [theta for theta, ratio in ratios if ratio < 1e-9] or [0.5, 0.6]
        starts = {
            "before": 0.6 * flats[0],
            "first end": flats[0],
            "in": 0.5 * (flats[0] + flats[-1]),
            "last end": flats[-1],
            "after": 0.5 * (flats[-1] + 1.3963),
        }
        torque = max(sizes.torque(theta) for theta, _ in ratios)
        force = max(abs(sizes.mechanism.spring_force(sizes.mechanism.groove.at(t).z)) for t, _ in ratios)
        for name, start in starts.items():
            q = p | {"initial.theta": start}
            for s in (1.0, -1.0):
                intervals = [
                    Interval(0.02, 0.6 * s * torque),
                    Interval(0.03, 0.0, F_ext=0.5 * s * force),
                    Interval(0.03, -0.4 * s * torque, 0.8 * s * torque / 0.03, F_ext=-1.5 * force),
                    Interval(0.02, 0.05 * s * torque, F_ext=0.3 * force),
                ]
                yield Scene(
                    row, q, intervals, "simulate", f"{which}, {body}, mu {mu}, {name}, sign {s:g}", steps=2
                )
