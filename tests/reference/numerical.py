"""Segments by numerical integration, in double precision."""

from __future__ import annotations

import numpy as np

from .arithmetic import DOUBLE, poly
from .integration import EventProblem, Peaks, Solver
from .mechanism import Mechanism
from .parameters import FLOWS, Refused
from .segment import Outcome, Segment


class OdeFlow:
    """DOP853 in double precision, for any segment. State: theta, omega (with inertia), FLOWS."""

    arithmetic = DOUBLE

    def __init__(self, rtol: float = 1e-13) -> None:
        self.solver = Solver(rtol)

    def advance(self, mechanism: Mechanism, segment: Segment) -> Outcome:
        inertial, sigma = mechanism.inertial, segment.slip.sigma
        size = 2 if inertial else 1
        y = np.array([segment.theta, segment.omega][:size] + [0.0] * len(FLOWS))
        scale = self._scale(mechanism, segment, size)
        time, length, peaks, name = 0.0, float(segment.length), Peaks(), "knot"
        while name == "knot":
            piece, knot = mechanism.groove.ahead(float(y[0]), sigma)
            problem = self._problem(mechanism, segment, y, piece, knot, scale)
            time, y, name = self.solver.integrate_to_event(problem, time, y, length, peaks)
            if name == "knot":
                y[0] = knot
                name = self._vanished(problem, time, y) or name
        causes = {name}
        watched, _ = problem.observe(time, y)
        if name in (
            "cross1",
            "cross2",
        ):  # without follower inertia both contact loads vanish at the same time
            both = [n for n in ("cross1", "cross2") if n in watched]
            causes |= {n for n in both if abs(watched[n]) < 1e-10 * problem.zero_scale[n]}
        omega = float(y[1]) if inertial else problem.rates(time, y)[0]
        if abs(omega) <= 1e-13 * peaks.best[0] and "end" not in causes:
            causes.add("rest")  # with damping on the shaft alone, torque and speed vanish at the same time
        flows = [float(v) for v in y[size:]]
        return Outcome(time, float(y[0]), omega, flows, causes, peaks.best[0], (peaks.best[1], peaks.best[2]))

    @staticmethod
    def _vanished(problem: EventProblem, time: float, y: np.ndarray) -> str | None:
        """Name of a contact whose load is zero at a knot. In a dwell without friction the other contact is
        idle; the flank on which this contact bears after the dwell is decided anew."""
        watched, _ = problem.observe(time, y)
        for name in ("cross1", "cross2"):
            if name in watched and abs(watched[name]) <= 1e-12 * problem.zero_scale[name]:
                return name
        return None

    @staticmethod
    def _problem(
        mechanism: Mechanism,
        segment: Segment,
        y: np.ndarray,
        piece: int,
        knot: float | None,
        scale: np.ndarray,
    ) -> EventProblem:
        slip, inertial, stop = segment.slip, mechanism.inertial, segment.stop
        at, load, powers = mechanism.groove.at, mechanism.load, mechanism.powers
        friction1, friction2 = mechanism.mu1 > 0, mechanism.mu2 > 0

        def rates(t: float, y: np.ndarray) -> list[float]:
            kin, tau, f_ext = at(float(y[0]), piece), poly(segment.tau, t), poly(segment.f_ext, t)
            now = load(kin, slip, float(y[1]) if inertial else 0.0, tau, f_ext)
            motion = [now.omega, now.alpha] if inertial else [now.omega]
            return motion + powers(kin, slip, now, tau, f_ext)

        def observe(t: float, y: np.ndarray) -> tuple[dict[str, float], tuple[float, float, float]]:
            theta = float(y[0])
            kin, tau, f_ext = at(theta, piece), poly(segment.tau, t), poly(segment.f_ext, t)
            now = load(kin, slip, float(y[1]) if inertial else 0.0, tau, f_ext)
            seen = {"stop": theta - stop}
            if knot is not None:
                seen["knot"] = theta - knot
            if inertial:
                seen["rest"] = now.omega
            else:
                f0 = mechanism.spring_force(kin.z) + f_ext
                ratio = mechanism.static_ratio(kin, slip.sigma * segment.load_sign, f0)
                if ratio is None:
                    raise Refused("moving wedge")
                seen |= {"rest": tau - ratio * f0, "kink": f0}
            if friction1:
                seen["cross1"] = now.x1
            if friction2:
                seen["cross2"] = now.x2
            return seen, (abs(now.omega), *mechanism.reactions(kin, now.x1, now.x2))

        kin = at(float(y[0]), piece)
        tau, f_ext = segment.tau[0], segment.f_ext[0]
        natural = mechanism.scales(kin, slip, float(y[1]) if inertial else segment.omega, tau, f_ext)
        zero_scale = {"cross1": natural.x1, "cross2": natural.x2, "stop": 0.0, "knot": 0.0}
        if inertial:
            zero_scale["rest"] = 0.0
        else:
            zero_scale["kink"] = mechanism.force_scale(kin, f_ext)
            ratio = mechanism.static_ratio(
                kin, slip.sigma * segment.load_sign, mechanism.spring_force(kin.z) + f_ext
            )
            zero_scale["rest"] = abs(tau) + abs(ratio or 0.0) * zero_scale["kink"]

        def fastest_rate(y: np.ndarray) -> float:
            kin = at(float(y[0]), piece)
            omega = float(y[1]) if inertial else 0.0
            return mechanism.rate(kin, slip, omega)

        return EventProblem(rates, observe, zero_scale, fastest_rate, scale)

    @staticmethod
    def _scale(mechanism: Mechanism, segment: Segment, size: int) -> np.ndarray:
        """Absolute tolerances: rounding of the natural size of each state."""
        reach = max(abs(mechanism.upper), abs(mechanism.lower))
        kin = mechanism.groove.at(segment.theta)
        load = mechanism.load(kin, segment.slip, segment.omega, segment.tau[0], segment.f_ext[0])
        rate = mechanism.rate(kin, segment.slip)
        rate = max(rate, 1e-9)
        travel = min(reach, abs(load.omega) / rate + abs(load.alpha) / rate**2 + 1e-9 * reach)
        speed = abs(load.omega) + travel * rate + 1e-12
        force = mechanism.force_scale(kin, segment.f_ext[0])
        energy = abs(segment.tau[0]) * reach * 1e-2 + force * mechanism.reach * 1e-2 + 1e-12
        return 1e-15 * np.array([reach, speed][:size] + [energy] * len(FLOWS))
