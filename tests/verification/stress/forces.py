"""Scenes that vary forces and masses: stiffness, inertia, friction, preload, dampers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np

from benchmarks.harness.oracles import Interval
from verification.stress.mechanisms import Sizes, Tables, damper, ellipses, helices, spring, up_and_back
from verification.stress.scene import Params, Scene

STIFFNESS = "stiffness 1e-3 to 1e9 N/m"


def stiffness(tables: Tables) -> Iterator[Scene]:
    for number, k in enumerate(np.logspace(-3, 9, 25).tolist()):
        for shape, judge in ((ellipses(), "simulate"), (helices(), "exact")):
            grooves = shape | spring(k, 0.03, nonlinear=judge == "simulate")
            masses = grooves | {"inertia.shaft": 0.002, "inertia.follower_mass": 0.3}
            yield from damped_springs(masses, judge, f"k {k:g}", 1 + number % 3)
            yield from same_torque(masses, judge, f"k {k:g}")
            yield from without_inertia(grooves | {"inertia.shaft": 0.0}, judge, k)


def damped_springs(p: Params, judge: str, label: str, steps: int) -> Iterator[Scene]:
    """Damping ratios from none to twice the critical one."""
    sizes, general = Sizes.of(p), judge == "exact"
    critical = 2.0 * math.sqrt(sizes.inertia() * sizes.stiffness()) / sizes.dz_dtheta() ** 2
    intervals = up_and_back(1.4 * sizes.torque(0.7), 1.3 * sizes.period())
    for ratio in (0.0, 0.1, 2.0):
        q = p | damper(ratio * critical)
        text = f"{label}, damping {ratio}"
        yield Scene(STIFFNESS, q, intervals, judge, text, general=general, steps=steps)


def same_torque(p: Params, judge: str, label: str) -> Iterator[Scene]:
    """10 N.m for every spring: from free flight to hardly any motion."""
    p = p | {"spring.preload": 50.0, "spring.stiffness2": 0.0, "spring.stiffness3": 0.0}
    sizes = Sizes.of(p)
    time = min(1.3 * sizes.period(), 3.0 * math.sqrt(sizes.inertia() / 10.0))
    p |= damper(3.0 * sizes.inertia() / time / sizes.dz_dtheta() ** 2 * 0.1)
    intervals = up_and_back(10.0, time)
    yield Scene(STIFFNESS, p, intervals, judge, f"{label}, 10 N.m", general=judge == "exact")


def without_inertia(p: Params, judge: str, k: float) -> Iterator[Scene]:
    intervals = up_and_back(1.4 * Sizes.of(p).torque(0.5), 0.7)
    for c in (0.0, k):  # time constant 1 s
        text = f"k {k:g}, no inertia, c {c:g}"
        yield Scene(STIFFNESS, p | damper(c), intervals, judge, text, general=judge == "exact")


def inertia(tables: Tables) -> Iterator[Scene]:
    row = "inertia 1e-12 to 1e3 kg.m2"
    for J in np.logspace(-12, 3, 16).tolist():
        for shape, judge in ((ellipses(), "simulate"), (helices(), "exact")):
            general, nonlinear = judge == "exact", judge == "simulate"
            base = shape | spring(2e4, 0.03, nonlinear=nonlinear) | {"inertia.shaft": J}
            sizes = Sizes.of(base)
            torque = 1.3 * sizes.torque(0.7)
            intervals = up_and_back(torque, 1.2 * sizes.period())
            yield Scene(row, base, intervals, judge, f"J {J:g}, no damping", general=general)
            yield from damped_inertia(row, base | damper(200.0) | {"shaft.damping": 0.003}, judge, J, torque)


def damped_inertia(row: str, p: Params, judge: str, J: float, torque: float) -> Iterator[Scene]:
    """Against the reference, and small inertias against the limit without inertia too."""
    sizes = Sizes.of(p)
    rise = (1.1 * sizes.torque(1.1) - torque) / 0.05
    smooth = [Interval(0.05, torque, rise), Interval(0.05, torque + 0.05 * rise)]
    if judge == "simulate" and J < 1e-5:
        yield Scene(row, p, smooth[:1], "radau", f"J {J:g}, damped", steps=6)
    else:
        yield Scene(row, p, smooth, judge, f"J {J:g}, damped", general=judge == "exact", steps=3)
    if J <= 1e-6:
        decay = J / (0.003 + 200.0 * sizes.dz_dtheta() ** 2)
        yield Scene(
            "inertia 1e-12 to 1e-6, against the limit without",
            p,
            [*smooth, Interval(0.03, 0.2 * torque), Interval(0.05, 1.5 * torque)],
            "limit",
            f"J {J:g}, damped, against no inertia",
            instead=p | {"inertia.shaft": 0.0},
            slack=10.0 * decay / 0.01,
            compared=("theta", "energy.spring"),
            steps=4,
        )


def friction(tables: Tables) -> Iterator[Scene]:
    row = "friction 0 to 1.5, up to and past self-locking"
    frictions = [0.0, 1e-9, 1e-3, 0.1, 0.3, 0.6, 0.8, 0.999, 1.0, 1.001, 1.2, 1.5]
    for mu1, mu2 in product(frictions, frictions):
        pair = {"cam1.friction": mu1, "cam2.friction": mu2}
        low = math.pi / 4 if max(mu1, mu2) < 0.6 else 0.4
        shapes: list[tuple[Params, str]] = [
            (helices(low, 1.1 * low) | pair, "exact"),
            (ellipses(**{"cam1.lead_angle": 0.3, "cam2.lead_angle": 0.5, **pair}), "simulate"),
        ]
        for shape, judge in shapes:
            p = shape | spring(3e4, 0.02, nonlinear=judge == "simulate")
            p |= {"inertia.shaft": 0.002, "initial.theta": 0.3, "inertia.follower": 1e-4}
            sizes = Sizes.of(p)
            torque = sizes.torque(0.7)
            intervals = [
                Interval(0.02, 1.3 * torque),
                Interval(0.03, 0.0),
                Interval(0.02, 0.0, -2.0 * torque / 0.02),
                Interval(0.03, -0.3 * torque, 1.7 * torque / 0.03),
            ]
            yield Scene(row, p, intervals, judge, f"mu {mu1:g}, {mu2:g}", general=judge == "exact", steps=2)
    for mu in (1e-3, 0.3, 0.8):
        # exactly at the angle of friction
        p = helices(math.atan(mu), math.atan(mu)) | spring(3e4, 0.02, nonlinear=False)
        p |= {"cam1.friction": mu, "cam2.friction": mu, "initial.theta": 0.5, "inertia.shaft": 0.002}
        torque = Sizes.of(p).torque(0.7)
        intervals = [Interval(0.02, 0.0), Interval(0.02, -0.1 * torque), Interval(0.02, 1.3 * torque)]
        yield Scene(row, p, intervals, "exact", f"mu {mu:g} = tan(lambda)", general=True)


def zero_preload(tables: Tables) -> Iterator[Scene]:
    row = "no preload, axial force through zero"
    for inertia, c, mu, at in product((0.002, 0.0), (0.0, 40.0), (0.0, 0.14, 0.4), (0.0, 0.5)):
        p = ellipses(**{"cam1.friction": mu, "cam2.friction": mu, "stop.lower": -0.5}) | spring(
            2e4, 0.03, 0.0
        )
        p |= damper(c) | {"inertia.shaft": inertia, "initial.theta": at}
        force = Sizes.of(p).mechanism.spring_force(0.01)
        torque = Sizes.of(p).torque(0.5)
        intervals = [
            Interval(0.02, 0.0),
            Interval(0.03, 0.0, F_ext=force, F_ext_rate=-3.0 * force / 0.03),
            Interval(0.03, 0.2 * torque, F_ext=-force, F_ext_rate=0.0, F_ext_rate2=3.0 * force / 0.03**2),
            Interval(0.04, 0.3 * torque, -torque / 0.04, F_ext=0.5 * force, F_ext_rate=-force / 0.04),
            Interval(0.03, 0.0, F_ext=0.0),
        ]
        yield Scene(row, p, intervals, "simulate", f"J {inertia}, c {c}, mu {mu}, from {at}", steps=2)
        q = p | {"spring.stiffness": 0.0, "spring.stiffness2": 0.0, "spring.stiffness3": 0.0}
        free = [
            Interval(0.02, 0.0),
            Interval(0.02, 0.0, F_ext=20.0),
            Interval(0.02, 0.05),
            Interval(0.02, 0.0),
        ]
        yield Scene(row, q, free, "simulate", f"no spring at all, J {inertia}, c {c}, mu {mu}, from {at}")


def dampers(tables: Tables) -> Iterator[Scene]:
    row = "dampers 1 to 1e9 (c and q)"
    for size in np.logspace(0, 9, 10).tolist():
        for c, q in ((size, 0.0), (0.0, size), (size, size)):
            for shape, exact in ((ellipses(), False), (helices(), True)):
                if exact and q:
                    continue
                p = shape | spring(3e4, 0.03, nonlinear=not exact) | damper(c, q) | {"initial.theta": 0.1}
                torque = Sizes.of(p | {"inertia.shaft": 0.0}).torque(0.7)
                # long enough to see the spring win
                time = min(max(0.05, 0.5 * c / 3e4, 0.3 * math.sqrt(q * 0.01 / 3e4)), 1e4)
                smooth = [Interval(time, torque, 0.5 * torque / time), Interval(time, 1.5 * torque)]
                both = [*smooth, Interval(time, 0.1 * torque), Interval(time, -torque)]
                label = f"c {c:g}, q {q:g}"
                quiet = p | {"inertia.shaft": 0.0}
                judge = "exact" if exact else "simulate"
                yield Scene(row, quiet, both, judge, label + ", no inertia", general=exact, steps=2)
                p |= {"inertia.shaft": 0.002}
                if exact:
                    yield Scene(row, p, both, "exact", label, general=True, steps=2)
                    continue
                yield from curved_dampers(row, p, both, label, size, c, q)


def curved_dampers(
    row: str, p: Params, intervals: list[Interval], label: str, size: float, c: float, q: float
) -> Iterator[Scene]:
    """In elliptical grooves: against the reference, and large dampers against the limit without inertia
    too."""
    smooth, time = intervals[:2], intervals[0].duration
    if size > 1e3:
        yield Scene(row, p, smooth[:1], "radau", label, steps=4)
    else:
        yield Scene(row, p, smooth, "simulate", label, steps=2)
    if size >= 1e5:
        slow = 0.002 / (Sizes.of(p).dz_dtheta() ** 2 * (c + 2.0 * q * 0.005 / time))
        yield Scene(
            "dampers 1e5 to 1e9, against the limit without inertia",
            p,
            intervals,
            "limit",
            label + ", against no inertia",
            instead=p | {"inertia.shaft": 0.0},
            slack=10.0 * slow / time,
            compared=("theta", "energy.spring"),
            steps=2,
        )
