"""The general mechanism at its limits: what was varied, how far, and what came out.

    ./build.sh stress                     all rows, written to docs/stress.md
    python benchmarks/stress.py           the same, with the FMU as it was built last
    python benchmarks/stress.py --rows stiffness,dwell --fuzz 100 --output /tmp/stress.md

Every run goes through the FMU's C functions in a process of its own, so that a crash or a step that never
ends is a result too. Judges, none of which shares anything with the C core but the equations:

reference   tests/reference.py: `simulate` (DOP853, all events), and for helices `simulate_exact` (closed
            form at 60 digits, never stiff); the FMU is then compiled without its closed forms, or gets the
            helix as a table
Radau       one stiff smooth stretch by scipy's Radau method, from the pointwise equations of the reference;
            its own error is the change from a run at a 30 times coarser tolerance
limit       the reference of the mechanism without the small thing (inertia, ...), to within its size
laws        no NaN, theta between its stops, energy conserved, heat never given back, the same answer however
            an interval is cut, a doStep below 2 s; these are checked in every run. Energy: to ten times the
            tolerance, once for every 1000 mode changes, for each swing to and fro adds an error of its own

Errors are relative to the scene's largest angle, speed and energy. A run is right if they stay below
ten times the tolerance; where they do not, the reference itself is run with data changed by a tolerance, and
what that changes is allowed too.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import os
import signal
import sys
import tempfile
import time
import traceback
import warnings
import zipfile
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from importlib.metadata import version
from itertools import pairwise, product
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from scipy.integrate import Radau

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / folder) for folder in ("fmu_src", "benchmarks", "tests")]
import build_fmu  # noqa: E402
import driver  # type: ignore[import-not-found]  # noqa: E402
import general_scenes  # type: ignore[import-not-found]  # noqa: E402
import reference  # type: ignore[import-not-found]  # noqa: E402
import step_cost  # noqa: E402
from reference import DOUBLE, HEATS, INTEGERS, Interval, Mechanism, Refused, Slip  # noqa: E402

FOLDER = build_fmu.BUILD / "stress"
DEFAULT_TOLERANCE = 1e-9
LONGEST_STEP = 2.0  # s, a doStep that takes longer is wrong
PATIENCE = 60  # s, for a reference; one that takes longer is given up and the laws judge alone
HANG = 300.0  # s, after which a process is ended
REFERENCES = {"simulate", "exact", "radau"}
MOTION = ("theta", "omega")
ACCOUNTS = ("work_in", "work_ext", "spring", "kinetic", *HEATS)
REALS = driver.FORWARD.names(type=["Real"])
CLEAR = ("must", "allowed", "jam", "changes too often")  # a refusal has one of these words
Params = dict[str, Any]


# ---- Scenes -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scene:
    row: str
    params: Params
    intervals: list[Interval]
    judge: str = "laws"  # a key of JUDGES
    label: str = ""
    tolerance: float | None = None
    steps: int = 1  # equal communication steps per interval
    general: bool = False  # with the FMU compiled without closed forms
    instead: Params | None = None  # parameters of the reference, where they are others
    slack: float = 0.0  # error of a limit, relative
    compared: tuple[str, ...] = (*MOTION, *(f"energy.{name}" for name in ACCOUNTS))
    points: list[reference.Point] | None = None  # solved already

    @property
    def allowed(self) -> float:
        return 10.0 * (self.tolerance or DEFAULT_TOLERANCE) + self.slack


@dataclass
class Trace:
    """What was read after each interval, and the rest of what a run shows."""

    read: list[dict[str, float]] = field(default_factory=list)
    largest: dict[str, float] = field(default_factory=dict)
    turnover: float = 0.0  # J, the largest torque times the angle between the stops
    residual: float = 0.0  # relative to the largest account
    step: float = 0.0  # longest doStep, s
    total: float = 0.0  # all doSteps, s
    simulated: float = 0.0
    refusal: str = ""
    problems: list[str] = field(default_factory=list)


@dataclass
class Verdict:
    error: float = math.nan
    residual: float = 0.0
    step: float = 0.0
    rate: float = 0.0  # s per simulated s
    refusal: str = ""
    problems: list[str] = field(default_factory=list)
    judged: bool = False  # by more than the laws
    note: str = ""


def ellipses(**more: float) -> Params:
    given = {
        1: {"radius": 0.03, "lead_angle": 0.70, "ellipse_a": 0.15, "ellipse_b": 0.15, "ellipse_curvature": 1},
        2: {
            "radius": 0.025,
            "lead_angle": 0.85,
            "ellipse_a": 0.12,
            "ellipse_b": 0.12,
            "ellipse_curvature": -1,
        },
    }
    made: Params = {f"cam{i}.{name}": v for i, cam in given.items() for name, v in cam.items()}
    return made | {"cam1.profile": 2, "cam2.profile": 2} | more


def helices(lead1: float = 0.75, lead2: float = 0.85) -> Params:
    return {
        "cam1.radius": 0.03,
        "cam2.radius": 0.025,
        "cam1.lead_angle": lead1,
        "cam2.lead_angle": lead2,
    }


def spring(k: float, reach: float, preload: float = 0.2, bent: bool = True) -> Params:
    """Preload and bends in units of the force of k at the end of the way."""
    made = {"spring.stiffness": k, "spring.preload": preload * k * reach}
    bends = {"spring.stiffness2": 0.3 * k / reach, "spring.stiffness3": 0.2 * k / reach**2}
    return made | (bends if bent else {})


def damper(c: float = 0.0, q: float = 0.0) -> Params:
    return {f"damper.{kind}_{side}": v for kind, v in (("c", c), ("q", q)) for side in ("load", "release")}


@dataclass(frozen=True)
class Sizes:
    """What a mechanism does: torque that loads, at an angle; stiffness and inertia as cam 2 sees them."""

    mechanism: Mechanism

    @classmethod
    def of(cls, params: Params) -> Sizes:
        return cls(Mechanism({n: v for n, v in params.items() if n != "ledger"}, DOUBLE))

    def torque(self, theta: float, f_ext: float = 0.0) -> float:
        kin = self.mechanism.groove.at(theta)
        ratio = self.mechanism.static_ratio(kin, +1)
        if ratio is None:
            ratio = kin.dz
        return ratio * (self.mechanism.spring_force(kin.z) + f_ext)

    def lift(self, theta: float = 0.7) -> float:
        return float(self.mechanism.groove.at(theta).dz)

    def stiffness(self, theta: float = 0.7) -> float:
        kin = self.mechanism.groove.at(theta)
        return float(abs(self.mechanism.spring_slope(kin.z)) * kin.dz**2)

    def inertia(self, theta: float = 0.7) -> float:
        m, kin = self.mechanism, self.mechanism.groove.at(theta)
        return float(m.J + m.m * kin.dz**2 + m.I * kin.dgamma**2)

    def period(self) -> float:
        return 2.0 * math.pi * math.sqrt(self.inertia() / self.stiffness())


def up_and_back(torque: float, duration: float) -> list[Interval]:
    """Loads, holds a little, lets go, pulls back, and loads on a ramp."""
    return [
        Interval(duration, torque),
        Interval(0.5 * duration, 0.4 * torque),
        Interval(0.7 * duration, -0.2 * torque),
        Interval(duration, 0.0, 1.5 * torque / duration),
    ]


class Tables:
    """Writes tables into a folder."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.count = folder, 0

    def write(self, psi: Iterable[float], z: Iterable[float]) -> str:
        path = self.folder / f"{self.count}.csv"
        self.count += 1
        reference.write_table(path, psi, z)
        return str(path)

    def helix(self, radius: float, lead: float, lower: float, upper: float, count: int = 9) -> str:
        psi = np.linspace(min(lower, 0.0) - 0.1, upper + 0.1, count)
        return self.write(psi, radius * math.tan(lead) * psi)

    def dwell(self, radius: float, first: float, last: float, lead: float = 0.7) -> str:
        """Steep on both sides of a flat part from first to last, with rounded ends."""
        psi = np.linspace(-0.6, 2.0, 66)
        x = np.linspace(-0.6, 2.0, 65 * 40 + 1)
        outside = np.maximum(np.maximum(first - x, x - last), 0.0) / 0.15
        slope = radius * math.tan(lead) * -np.expm1(-(outside**2))
        rise = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(x))])
        return self.write(psi, rise[::40])


DECADES_OF_ANGLE = [1e-6, 1e-4, 1e-2, 0.2, 0.8, 1.3]
LEADS = [*DECADES_OF_ANGLE, *(math.pi / 2 - x for x in (1e-2, 1e-4, 1e-6))]


def stiffness(tables: Tables) -> Iterator[Scene]:
    row = "stiffness 1e-3 to 1e9 N/m"
    for number, k in enumerate(np.logspace(-3, 9, 25).tolist()):
        for shape, judge in ((ellipses(), "simulate"), (helices(), "exact")):
            bent = judge == "simulate"
            p = shape | spring(k, 0.03, bent=bent) | {"inertia.shaft": 0.002, "inertia.follower_mass": 0.3}
            sizes = Sizes.of(p)
            critical = 2.0 * math.sqrt(sizes.inertia() * sizes.stiffness()) / sizes.lift() ** 2
            torque = 1.4 * sizes.torque(0.7)
            for ratio in (0.0, 0.1, 2.0):
                q = p | damper(ratio * critical)
                general = judge == "exact"
                way = up_and_back(torque, 1.3 * sizes.period())
                yield Scene(
                    row, q, way, judge, f"k {k:g}, damping {ratio}", general=general, steps=1 + number % 3
                )
            # the same torque, whatever the spring: from free flight to hardly any motion
            p |= {"spring.preload": 50.0, "spring.stiffness2": 0.0, "spring.stiffness3": 0.0}
            sizes = Sizes.of(p)
            time = min(1.3 * sizes.period(), 3.0 * math.sqrt(sizes.inertia() / 10.0))
            p |= damper(3.0 * sizes.inertia() / time / sizes.lift() ** 2 * 0.1)
            yield Scene(row, p, up_and_back(10.0, time), judge, f"k {k:g}, 10 N.m", general=judge == "exact")
            # without inertia
            p = shape | spring(k, 0.03, bent=bent) | {"inertia.shaft": 0.0}
            sizes = Sizes.of(p)
            for c in (0.0, k):  # time constant 1 s
                way = up_and_back(1.4 * sizes.torque(0.5), 0.7)
                yield Scene(
                    row, p | damper(c), way, judge, f"k {k:g}, no inertia, c {c:g}", general=judge == "exact"
                )


def inertia(tables: Tables) -> Iterator[Scene]:
    row = "inertia 1e-12 to 1e3 kg.m2"
    for J in np.logspace(-12, 3, 16).tolist():
        for shape, judge in ((ellipses(), "simulate"), (helices(), "exact")):
            general, bent = judge == "exact", judge == "simulate"
            base = shape | spring(2e4, 0.03, bent=bent) | {"inertia.shaft": J}
            sizes = Sizes.of(base)
            torque = 1.3 * sizes.torque(0.7)
            way = up_and_back(torque, 1.2 * sizes.period())
            yield Scene(row, base, way, judge, f"J {J:g}, no damping", general=general)
            p = base | damper(200.0) | {"shaft.damping": 0.003}
            sizes = Sizes.of(p)
            rise = (1.1 * sizes.torque(1.1) - torque) / 0.05
            smooth = [Interval(0.05, torque, rise), Interval(0.05, torque + 0.05 * rise)]
            if judge == "simulate" and J < 1e-5:
                yield Scene(row, p, smooth[:1], "radau", f"J {J:g}, damped", steps=6)
            else:
                yield Scene(row, p, smooth, judge, f"J {J:g}, damped", general=general, steps=3)
            if J <= 1e-6:
                decay = J / (0.003 + 200.0 * sizes.lift() ** 2)
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
            p = shape | spring(3e4, 0.02, bent=judge == "simulate")
            p |= {"inertia.shaft": 0.002, "initial.theta": 0.3, "inertia.follower": 1e-4}
            sizes = Sizes.of(p)
            torque = sizes.torque(0.7)
            way = [
                Interval(0.02, 1.3 * torque),
                Interval(0.03, 0.0),
                Interval(0.02, 0.0, -2.0 * torque / 0.02),
                Interval(0.03, -0.3 * torque, 1.7 * torque / 0.03),
            ]
            yield Scene(row, p, way, judge, f"mu {mu1:g}, {mu2:g}", general=judge == "exact", steps=2)
    for mu in (1e-3, 0.3, 0.8):
        # exactly at the angle of friction
        p = helices(math.atan(mu), math.atan(mu)) | spring(3e4, 0.02, bent=False)
        p |= {"cam1.friction": mu, "cam2.friction": mu, "initial.theta": 0.5, "inertia.shaft": 0.002}
        torque = Sizes.of(p).torque(0.7)
        way = [Interval(0.02, 0.0), Interval(0.02, -0.1 * torque), Interval(0.02, 1.3 * torque)]
        yield Scene(row, p, way, "exact", f"mu {mu:g} = tan(lambda)", general=True)


def lead_angles(tables: Tables) -> Iterator[Scene]:
    row = "lead angles 1e-6 to pi/2 - 1e-6"
    for lead1, lead2 in product(LEADS, LEADS):
        for mu in (0.0, 0.05):
            p = helices(lead1, lead2) | {"cam1.friction": mu, "cam2.friction": mu}
            kin = reference.Helices(0.03 * math.tan(lead1), 0.025 * math.tan(lead2)).at(0.0)
            reach = 1.3963 * float(kin.dz)
            p |= spring(50.0 / reach, reach, bent=False) | {"inertia.shaft": 0.002}
            sizes = Sizes.of(p)
            p["inertia.shaft"] = max(1e-3 * sizes.stiffness(), 1e-9)
            sizes = Sizes.of(p)
            way = up_and_back(1.3 * sizes.torque(0.7), 1.2 * sizes.period())
            label = f"helices {lead1:.6g}, {lead2:.6g}, mu {mu:g}"
            yield Scene(row, p, way, "exact", label, general=True, steps=2)
            q = dict(p)
            for i, lead in ((1, lead1), (2, lead2)):
                radius = p[f"cam{i}.radius"]
                q |= {f"cam{i}.profile": 3, f"cam{i}.table": tables.helix(radius, lead, 0.0, 1.3963)}
            yield Scene(row, q, way, "exact", label + ", as tables", instead=p)


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
            course = reference.Ellipse(radius, lead, a, b, kappa)
            gamma = 1.2 - 1e-12
            z = course.derivatives(gamma, 0)[0]
            upper = gamma + z / (0.025 * math.tan(0.8))
            for stop in (upper * (1.0 - 1e-9), 0.9 * upper):
                # without friction a swing returns to where it began: not to a stop, that it might touch
                p = p | {"stop.upper": stop, "initial.theta": 0.03 * stop} | spring(2e4, max(z, 1e-3))
                try:
                    sizes = Sizes.of(p)
                    torque, time = 1.5 * sizes.torque(0.8 * stop), 1.5 * sizes.period()
                except (Refused, ArithmeticError):
                    torque, time = 30.0, 0.05
                label = f"curvature {kappa}, S {s0:.9g} to {s1:.12g}, mu {mu}, stop {stop:.12g}"
                yield Scene(row, p, up_and_back(torque, time), "simulate", label, steps=2)


def step_sizes(tables: Tables) -> Iterator[Scene]:
    row = "communication steps 1e-9 to 1e3 s"
    for h in np.logspace(-9, 3, 13).tolist():
        base = ellipses() | spring(3e4, 0.03) | damper(30.0, 10.0)
        base |= {"inertia.shaft": 0.002, "initial.theta": 0.3, "initial.omega": 3.0}
        torque = 1.2 * Sizes.of(base).torque(0.8)
        count = int(min(1000, max(1, 0.1 / h)))
        way = [Interval(count * h, torque), Interval(count * h, 0.3 * torque)]
        yield Scene(row, base, way, "simulate", f"h {h:g}, period 0.03 s", steps=count)
        # a mechanism as slow or as fast as the step
        for periods in (0.01, 1.0, 20.0):
            J = Sizes.of(base).stiffness() * (h / periods / (2.0 * math.pi)) ** 2
            p = base | {"inertia.shaft": J, "initial.omega": 0.0} | damper()
            critical = 2.0 * math.sqrt(J * Sizes.of(base).stiffness()) / Sizes.of(base).lift() ** 2
            p |= damper(0.1 * critical)
            steps = 200 if periods < 1.0 else 3
            way = [Interval(steps * h, torque), Interval(steps * h, 0.2 * torque)]
            yield Scene(row, p, way, "simulate", f"h {h:g} of {periods:g} periods", steps=steps)


def reversals(tables: Tables) -> Iterator[Scene]:
    row = "1e4 reversals a second"
    for mu, c in product((0.0, 0.05, 0.14), (0.0, 50.0)):
        p = ellipses(**{"cam1.friction": mu, "cam2.friction": mu}) | spring(3e4, 0.03) | damper(c)
        p |= {"inertia.shaft": 1e-6, "initial.theta": 0.7}
        middle = Sizes.of(p).torque(0.7)
        way = [Interval(1e-4, middle * (1.0 + 1.2 * (-1) ** i)) for i in range(400)]
        yield Scene(row, p, way, "simulate", f"square torque, mu {mu}, c {c}")
        # swings of its own, in one step
        J = Sizes.of(p).stiffness() / (math.pi * 1e4) ** 2
        p |= {"inertia.shaft": J, "initial.theta": 0.9}
        middle = Sizes.of(p).torque(0.7)
        yield Scene(row, p, [Interval(0.02, middle)], "simulate", f"own swings, mu {mu}, c {c}")
        if mu == 0.0 and c == 0.0:
            yield Scene(row, p, [Interval(1.0, middle)], "laws", "own swings for 1 s")
    for mu in (0.0, 0.14):
        p = ellipses(**{"cam1.friction": mu, "cam2.friction": mu}) | spring(3e4, 0.03)
        p |= {"inertia.shaft": 0.0, "initial.theta": 0.7}
        for c in (0.0, 50.0):
            q = p | damper(c)
            middle = Sizes.of(q).torque(0.7)
            way = [Interval(1e-4, middle * (1.0 - 0.8 * s), 1.6 * s * middle / 1e-4) for s in [1, -1] * 200]
            yield Scene(row, q, way, "simulate", f"saw-tooth torque without inertia, mu {mu}, c {c}")


def zero_preload(tables: Tables) -> Iterator[Scene]:
    row = "no preload, axial force through zero"
    for inertia, c, mu, at in product((0.002, 0.0), (0.0, 40.0), (0.0, 0.14, 0.4), (0.0, 0.5)):
        p = ellipses(**{"cam1.friction": mu, "cam2.friction": mu, "stop.lower": -0.5}) | spring(
            2e4, 0.03, 0.0
        )
        p |= damper(c) | {"inertia.shaft": inertia, "initial.theta": at}
        force = Sizes.of(p).mechanism.spring_force(0.01)
        torque = Sizes.of(p).torque(0.5)
        way = [
            Interval(0.02, 0.0),
            Interval(0.03, 0.0, F_ext=force, F_ext_rate=-3.0 * force / 0.03),
            Interval(0.03, 0.2 * torque, F_ext=-force, F_ext_rate=0.0, F_ext_rate2=3.0 * force / 0.03**2),
            Interval(0.04, 0.3 * torque, -torque / 0.04, F_ext=0.5 * force, F_ext_rate=-force / 0.04),
            Interval(0.03, 0.0, F_ext=0.0),
        ]
        yield Scene(row, p, way, "simulate", f"J {inertia}, c {c}, mu {mu}, from {at}", steps=2)
        q = p | {"spring.stiffness": 0.0, "spring.stiffness2": 0.0, "spring.stiffness3": 0.0}
        free = [
            Interval(0.02, 0.0),
            Interval(0.02, 0.0, F_ext=20.0),
            Interval(0.02, 0.05),
            Interval(0.02, 0.0),
        ]
        yield Scene(row, q, free, "simulate", f"no spring at all, J {inertia}, c {c}, mu {mu}, from {at}")


def starts_at_stops(tables: Tables) -> Iterator[Scene]:
    row = "starts at a stop"
    for upper, inertia, c, e in product((False, True), (0.002, 0.0), (0.0, 40.0), (0.0, 0.5)):
        p = ellipses(**{"stop.restitution": e}) | spring(2e4, 0.03) | damper(c)
        at = 1.3963 if upper else 0.0
        p |= {"inertia.shaft": inertia, "initial.theta": at}
        torque = Sizes.of(p).torque(at)
        for factor in (-0.5, 0.0, 0.5, 1.0, 1.5):
            for omega in (0.0, 5.0, -5.0) if inertia else (0.0,):
                way = [
                    Interval(0.02, factor * torque),
                    Interval(0.02, factor * torque, (0.95 - factor) * torque / 0.02),
                    Interval(0.02, 0.0),
                ]
                label = (
                    f"{'upper' if upper else 'lower'}, J {inertia}, c {c}, e {e}, tau {factor}, omega {omega}"
                )
                yield Scene(row, p | {"initial.omega": omega}, way, "simulate", label, steps=2)


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
        except (Refused, ArithmeticError):
            continue
        # angles of cam 2 at which the pin enters and leaves the flat part
        lifts = [(theta, sizes.lift(theta)) for theta in np.linspace(0.0, 1.3963, 400).tolist()]
        flats = [theta for theta, lift in lifts if lift < 1e-9] or [0.5, 0.6]
        starts = {
            "before": 0.6 * flats[0],
            "first end": flats[0],
            "in": 0.5 * (flats[0] + flats[-1]),
            "last end": flats[-1],
            "after": 0.5 * (flats[-1] + 1.3963),
        }
        torque = max(sizes.torque(theta) for theta, _ in lifts)
        force = max(abs(sizes.mechanism.spring_force(sizes.mechanism.groove.at(t).z)) for t, _ in lifts)
        for name, start in starts.items():
            q = p | {"initial.theta": start}
            for s in (1.0, -1.0):
                way = [
                    Interval(0.02, 0.6 * s * torque),
                    Interval(0.03, 0.0, F_ext=0.5 * s * force),
                    Interval(0.03, -0.4 * s * torque, 0.8 * s * torque / 0.03, F_ext=-1.5 * force),
                    Interval(0.02, 0.05 * s * torque, F_ext=0.3 * force),
                ]
                yield Scene(row, q, way, "simulate", f"{which}, {body}, mu {mu}, {name}, sign {s:g}", steps=2)


def dampers(tables: Tables) -> Iterator[Scene]:
    row = "dampers 1 to 1e9 (c and q)"
    for size in np.logspace(0, 9, 10).tolist():
        for c, q in ((size, 0.0), (0.0, size), (size, size)):
            for shape, exact in ((ellipses(), False), (helices(), True)):
                if exact and q:
                    continue
                p = shape | spring(3e4, 0.03, bent=not exact) | damper(c, q) | {"initial.theta": 0.1}
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
                if size > 1e3:
                    yield Scene(row, p, smooth[:1], "radau", label, steps=4)
                else:
                    yield Scene(row, p, smooth, "simulate", label, steps=2)
                if size >= 1e5:
                    slow = 0.002 / (Sizes.of(p).lift() ** 2 * (c + 2.0 * q * 0.005 / time))
                    yield Scene(
                        "dampers 1e5 to 1e9, against the limit without inertia",
                        p,
                        both,
                        "limit",
                        label + ", against no inertia",
                        instead=quiet,
                        slack=10.0 * slow / time,
                        compared=("theta", "energy.spring"),
                        steps=2,
                    )


def restitutions(tables: Tables) -> Iterator[Scene]:
    row = "restitution 0 to 1"
    for e in (0.0, 1e-9, 1e-3, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0):
        for mu, c in product((0.0, 0.14), (0.0, 30.0)):
            p = ellipses(**{"stop.restitution": e, "cam1.friction": mu, "cam2.friction": mu})
            p |= spring(2e4, 0.03) | damper(c) | {"inertia.shaft": 0.002, "initial.theta": 0.4}
            torque = Sizes.of(p).torque(1.3963)
            way = [Interval(0.03, 2.0 * torque), Interval(0.03, -torque), Interval(0.03, 0.0)]
            yield Scene(row, p, way, "simulate", f"e {e:g}, mu {mu}, c {c}", steps=2)
            long = [Interval(1.0, 3.0 * torque)]
            yield Scene(row, p, long, "laws", f"e {e:g}, mu {mu}, c {c}, 1 s against the upper stop")


def tolerances(tables: Tables) -> Iterator[Scene]:
    row = "tolerances 1e-4 to 1e-12"
    known = general_scenes.load(tables.folder)
    for number, tolerance in enumerate((1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12)):
        for scene in known[number % 4 :: 4]:
            yield Scene(
                row,
                scene.params,
                scene.intervals,
                "simulate",
                f"scene {scene.number}, tolerance {tolerance:g}",
                tolerance=tolerance,
                steps=1 + scene.number % 4,
                points=scene.points,
                slack=max(scene.error[name] / s for name, s in general_scenes.scales(scene.points).items()),
            )


def decades(rng: np.random.Generator, low: float, high: float) -> float:
    return float(10.0 ** rng.uniform(low, high))


def draw_groove(rng: np.random.Generator, tables: Tables, i: int, span: tuple[float, float]) -> Params:
    kind, radius = int(rng.integers(1, 4)), decades(rng, -2.5, -0.5)
    made: Params = {f"cam{i}.profile": kind, f"cam{i}.radius": radius}
    if kind == 1:
        made[f"cam{i}.lead_angle"] = float(rng.choice([*LEADS, rng.uniform(0.1, 1.4)], p=[*[0.04] * 9, 0.64]))
    elif kind == 2:
        s0, s1 = rng.choice([0.0, 1e-6, *rng.uniform(0.05, 0.95, 4)], 2).tolist()
        s1 = 1.0 - decades(rng, -9, -1) if rng.random() < 0.1 else s1
        if s0 == s1:
            s1 = s0 + 0.01
        # a lower stop below zero needs arc on that side too
        a = radius * max(span[1], 0.1) * rng.uniform(1.001, 2.0) / abs(s1 - s0)
        if span[0] < 0.0:
            s0 = min(max(s0, 0.1), 0.9)
            a = max(a, radius * -span[0] * 1.1 / min(s0, 1.0 - s0))
        b = a * decades(rng, -1, 1)
        made |= {
            f"cam{i}.ellipse_a": a,
            f"cam{i}.ellipse_b": b,
            f"cam{i}.lead_angle": math.atan(b / a * s0 / math.sqrt(1.0 - s0 * s0)),
            f"cam{i}.ellipse_curvature": 1 if s1 > s0 else -1,
        }
    elif rng.random() < 0.7:
        psi, z = reference._draw_table(rng, radius, *span)
        made[f"cam{i}.table"] = tables.write(psi, z)
    else:  # rough: steps, flats and corners
        psi = np.sort(
            np.concatenate([rng.uniform(span[0] - 0.2, span[1] + 0.2, int(rng.integers(3, 30))), [0.0]])
        )
        psi[0], psi[-1] = span[0] - 0.2, span[1] + 0.2
        rise = rng.choice([0.0, 1.0, 1e-3], len(psi) - 1, p=[0.2, 0.7, 0.1]) * rng.uniform(
            0.1, 3.0, len(psi) - 1
        )
        made[f"cam{i}.table"] = tables.write(
            psi, np.concatenate([[0.0], np.cumsum(radius * rise * np.diff(psi))])
        )
    friction = [0.0, rng.uniform(0.0, 0.3), rng.uniform(0.0, 1.5), decades(rng, -9, -1)]
    made[f"cam{i}.friction"] = float(rng.choice(friction, p=[0.15, 0.6, 0.15, 0.1]))
    return made


def draw(rng: np.random.Generator, tables: Tables) -> Scene:
    """Anything: sizes over many decades, but such that something moves in 0.1 to 1 s."""

    def maybe(share: float, value: float) -> float:
        return value if rng.random() < share else 0.0

    lower, upper = -maybe(0.4, rng.uniform(0.05, 1.0)), float(rng.uniform(0.2, 2.5))
    p: Params = {"stop.lower": lower, "stop.upper": upper}
    for i in (1, 2):
        p |= draw_groove(rng, tables, i, (lower, upper))
    k = decades(rng, -2, 8) if rng.random() < 0.3 else decades(rng, 2, 5)
    reach = 0.5 * (p["cam1.radius"] + p["cam2.radius"]) * 0.5
    force = k * reach
    p |= {
        "spring.stiffness": maybe(0.9, k),
        "spring.preload": maybe(0.8, force * decades(rng, -3, 1) * rng.choice([1.0, 1.0, 1.0, -1.0])),
        "spring.stiffness2": maybe(0.5, k / reach * rng.uniform(-0.3, 1.0)),
        "spring.stiffness3": maybe(0.5, k / reach**2 * rng.uniform(-0.2, 1.0)),
        "stop.restitution": maybe(0.3, float(rng.choice([rng.uniform(0.0, 0.9), 0.99, 1.0]))),
        "contacts": int(rng.integers(1, 3)),
        "initial.theta": float(rng.choice([max(lower, 0.0), lower, upper, rng.uniform(lower, upper)])),
    }
    lift = reach
    time = decades(rng, -2, 0)
    J = k * lift**2 * (time / 6.0) ** 2  # a swing takes about `time`
    critical = 2.0 * math.sqrt(J * k) / lift
    p["inertia.shaft"] = maybe(0.75, J * decades(rng, *([-9, 1] if rng.random() < 0.3 else [-1, 1])))
    p["inertia.follower_mass"] = maybe(0.4, J / lift**2 * decades(rng, -3, 1))
    p["inertia.follower"] = maybe(0.3, J * decades(rng, -3, 1))
    wide = rng.random() < 0.25
    for side in ("load", "release"):
        p[f"damper.c_{side}"] = maybe(0.5, critical * decades(rng, -2, 7 if wide else 1))
        p[f"damper.q_{side}"] = maybe(0.4, critical * time / reach * decades(rng, -2, 7 if wide else 1))
    p["shaft.damping"] = maybe(0.4, critical * lift**2 * decades(rng, -2, 4 if wide else 1))
    if p["inertia.shaft"]:
        p["initial.omega"] = maybe(0.4, rng.uniform(-1.0, 1.0) * upper / time * 3.0)
    duration = decades(rng, -1, 0)
    torque = force * lift * (1.0 + abs(p["spring.preload"]) / force)
    intervals = []
    shares = rng.dirichlet(np.ones(int(rng.integers(1, 7)))).tolist()
    for share in shares:
        length = max(duration * share, 1e-6)
        values = [
            torque
            * float(rng.choice([0.0, rng.uniform(-2.0, 0.0), rng.uniform(0.0, 1.5), rng.uniform(1.0, 5.0)]))
        ]
        values += [
            torque * maybe(0.25, rng.uniform(-3.0, 3.0)) * math.factorial(o) / length**o for o in (1, 2, 3)
        ]
        pulls = [force * maybe(0.4, rng.uniform(-2.0, 1.0))]
        pulls += [
            force * maybe(0.15, rng.uniform(-2.0, 2.0)) * math.factorial(o) / length**o for o in (1, 2, 3)
        ]
        intervals.append(Interval(length, values[0], values[1], pulls[0], pulls[1], *values[2:], *pulls[2:]))
    tolerance = None if rng.random() < 0.5 else float(rng.choice([1e-4, 1e-6, 1e-8, 1e-11]))
    return Scene("", {n: reference._plain(v) for n, v in p.items()}, intervals, "cuts", "", tolerance)


def fuzz(tables: Tables, count: int, seed: int = 0) -> Iterator[Scene]:
    row = f"everything at random ({count} scenes of 0.1 to 1 s)"
    for number in range(count):
        scene = draw(np.random.default_rng([77, seed, number]), tables)
        yield replace(scene, row=row, label=f"fuzz {number}")


FAMILIES: dict[str, Callable[[Tables], Iterator[Scene]]] = {
    "stiffness": stiffness,
    "inertia": inertia,
    "friction": friction,
    "lead": lead_angles,
    "ellipse": slopes_of_ellipses,
    "steps": step_sizes,
    "reversals": reversals,
    "preload": zero_preload,
    "stops": starts_at_stops,
    "dwell": dwells,
    "dampers": dampers,
    "restitution": restitutions,
    "tolerances": tolerances,
}


# ---- Running the FMU ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Libraries:
    shipped: Path
    general: Path


def prepare() -> Libraries:
    """The shipped library, and the same without its closed forms."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(driver.FMU) as archive:
        name = "binaries/linux64/DualCamForward.so"
        shipped = FOLDER / "shipped.so"
        fresh = FOLDER / f"shipped.{os.getpid()}"
        fresh.write_bytes(archive.read(name))
        fresh.replace(shipped)
    fmu = build_fmu.dual_cam("DualCamForward", check=True)
    defines = [*fmu.defines, *build_fmu.identity(fmu), "-DDUALCAM_NO_CLOSED_FORM"]
    general = FOLDER / "general.so"
    flags = [*build_fmu.TARGET, *build_fmu.SHARED, *defines]
    stamp = build_fmu.fingerprint([*fmu.sources, *build_fmu.headers()], *flags)
    if not build_fmu.is_fresh(general, stamp):
        build_fmu.compile_c(build_fmu.ZIG, flags, fmu.sources, general)
        build_fmu.set_stamp(general, stamp)
    return Libraries(shipped, general)


def read(fmu: driver.Driver) -> dict[str, float]:
    status, values = fmu.try_get(REALS)
    if status != driver.OK:
        raise AssertionError(f"reading is refused: {fmu.messages[-1:]}")
    return dict(zip(REALS, values, strict=True)) | {"events": fmu.get("events"), "mode": fmu.get("mode")}


Cut = Callable[[int, float], Sequence[float]]  # number and duration of an interval -> times


def equal_cuts(steps: int) -> Cut:
    return lambda _, length: np.linspace(0.0, length, steps + 1).tolist()


def drive(library: Any, scene: Scene, cut: Cut | None = None) -> Trace:  # noqa: ANN401
    trace, fmu = Trace(), driver.Driver(library)
    try:
        _drive(fmu, scene, cut or equal_cuts(scene.steps), trace)
    finally:
        fmu.free()
    return trace


def _drive(fmu: driver.Driver, scene: Scene, cut: Cut, trace: Trace) -> None:
    def refused(where: str) -> None:
        text = fmu.messages[-1].text if fmu.messages else ""
        trace.refusal = f"{where}: {text}"
        if not any(word in text for word in CLEAR):
            trace.problems.append(f"unclear refusal: {trace.refusal}")

    first = scene.intervals[0]
    given = {n: int(v) if n in INTEGERS else v for n, v in scene.params.items() if v != ""}
    for name, value in (given | {"tau": first.tau, "F_ext": first.F_ext}).items():
        if fmu.try_set({name: value}) != driver.OK:
            return refused("setting")
    fmu.setup(0.0, scene.tolerance)
    fmu.ok("fmi2EnterInitializationMode")
    if fmu.call("fmi2ExitInitializationMode") != driver.OK:
        return refused("initialization")
    values = read(fmu)
    start, largest = values, {name: abs(values[name]) for name in scene_names()}
    lower, upper = (fmu.get(f"stop.{side}") for side in ("lower", "upper"))
    heats = {name: 0.0 for name in HEATS}
    worst_heat, worst_residual = 0.0, 0.0
    for number, interval in enumerate(scene.intervals):
        for a, b in pairwise(float(t) for t in cut(number, interval.duration)):
            inputs = {name: interval.at(name, a) for name in ("tau", "F_ext")}
            fmu.set({name: u[0] for name, u in inputs.items()})
            rates = {name: u[1:] for name, u in inputs.items() if any(u[1:])}
            if rates:
                fmu.set_derivatives(rates)
            begun = time.process_time()
            status = fmu.call("fmi2DoStep", fmu.time, b - a, 1)
            took = time.process_time() - begun
            trace.step, trace.total = max(trace.step, took), trace.total + took
            if took > LONGEST_STEP:
                trace.problems.append(f"a doStep of {took:.1f} s (interval {number}, h = {b - a:g})")
            if status != driver.OK:
                return refused(f"doStep (t = {fmu.time:g}, h = {b - a:g})")
            fmu.time += b - a
            trace.simulated += b - a
            values = read(fmu)
            bad = [name for name in REALS if math.isnan(values[name])]
            if bad:
                trace.problems.append(f"NaN under OK: {bad} (interval {number})")
                return
            if not lower <= values["theta"] <= upper:
                trace.problems.append(f"theta = {values['theta']!r} outside its stops (interval {number})")
            for name in largest:
                largest[name] = max(largest[name], abs(values[name]))
            worst_residual = max(worst_residual, abs(values["energy.residual"]))
            for name in HEATS:
                heat = values[f"energy.{name}"]
                worst_heat = max(worst_heat, heats[name] - heat)
                heats[name] = max(heats[name], heat)
        trace.read.append(values)
    largest["omega"] = max(largest["omega"], _finite(values["peak.omega"]))
    trace.largest = largest
    trace.turnover = _finite(values["peak.torque"]) * (upper - lower)
    # what goes to and fro inside a step does not show at its ends; its rounding does
    way = min(upper - lower, _finite(values["peak.omega"], math.inf) * trace.simulated)
    rounding = 1e-13 * values["peak.torque"] * way
    initial = abs(start["energy.spring"]) + abs(start["energy.kinetic"])
    energy = max([initial, *(largest[f"energy.{name}"] for name in ACCOUNTS)])
    trace.residual = max(worst_residual - rounding, 0.0) / energy if energy else 0.0
    # each swing to and fro passes that energy on, with an error of its own: they add up
    swings = max(1.0, values["events"] / 1000)
    allowed = 10.0 * (scene.tolerance or DEFAULT_TOLERANCE) * energy * swings + rounding
    if worst_residual > allowed:
        trace.problems.append(f"energy.residual {worst_residual:.3g} J of {energy:.3g} J")
    if worst_heat > allowed:
        trace.problems.append(f"heat given back: {worst_heat:.3g} J of {energy:.3g} J")


def _finite(value: float, otherwise: float = 0.0) -> float:
    return value if math.isfinite(value) else otherwise


def scene_names() -> list[str]:
    return [*MOTION, *(f"energy.{name}" for name in ACCOUNTS)]


def sizes_of(largest: dict[str, float], turnover: float) -> dict[str, float]:
    """What errors are relative to. A millionth of what the largest torque could do between the stops is no
    motion but rounding."""
    energy = max(1e-6 * turnover, *(largest[f"energy.{name}"] for name in ACCOUNTS)) or 1.0  # J
    return {n: energy if n.startswith("energy.") else largest[n] or 1.0 for n in scene_names()}


# ---- Judges -------------------------------------------------------------------------------------------


def plain(scene: Scene) -> Params:
    p = scene.params if scene.instead is None else scene.instead
    return {name: value for name, value in p.items() if name != "ledger"}


def radau(params: Params, intervals: Sequence[Interval]) -> list[dict[str, float]]:
    """One stretch of sliding upwards on the flanks it starts on, to be refused if it does not stay there."""
    runs = [_radau(params, intervals, rtol) for rtol in (1e-8, 3e-10)]
    sizes = {name: max(abs(point[name]) for point in runs[1]) for name in runs[1][0]}
    for coarse, fine in zip(*runs, strict=True):
        for name, size in sizes.items():
            if abs(coarse[name] - fine[name]) > 3e-9 * (size or 1.0):
                raise Refused(f"Radau itself is uncertain by {abs(coarse[name] - fine[name]) / size:.1e}")
    return runs[1]


def _radau(params: Params, intervals: Sequence[Interval], rtol: float) -> list[dict[str, float]]:
    mechanism, found = Mechanism(params, DOUBLE), []
    groove, slip = mechanism.groove, Slip(+1, (1, 1))
    y = np.array([mechanism.theta0, mechanism.omega0])

    def load_at(t: float, y: np.ndarray, interval: Interval) -> Any:  # noqa: ANN401
        theta = float(y[0])
        kin = groove.at(theta, groove.ahead(theta, +1)[0])
        tau, f_ext = (interval.at(name, t)[0] for name in ("tau", "F_ext"))
        return mechanism.load(kin, slip, float(y[1]), tau, f_ext)

    def rates(t: float, y: np.ndarray, interval: Interval) -> list[float]:
        return [float(y[1]), float(load_at(t, y, interval).alpha)]

    for interval in intervals:
        scale = rtol * np.array([1e-2, 0.1 / interval.duration])
        solver = Radau(partial(rates, interval=interval), 0.0, y, interval.duration, rtol=rtol, atol=scale)
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise Refused(f"Radau: {message}")
            load = load_at(float(solver.t), solver.y, interval)
            if min(load.x1, load.x2, solver.y[1]) < 0 or solver.y[0] >= mechanism.upper:
                raise Refused("not one smooth stretch")
        y = np.array(solver.y)
        kin = groove.at(float(y[0]))
        point = {"theta": float(y[0]), "omega": float(y[1])}
        point["energy.spring"] = mechanism.spring_energy(kin.z)
        point["energy.kinetic"] = mechanism.kinetic_energy(kin, float(y[1]))
        found.append(point)
    return found


def solved(scene: Scene, intervals: Sequence[Interval], params: Params) -> list[dict[str, float]]:
    if scene.judge == "radau":
        return radau(params, intervals)
    solve = reference.simulate_exact if scene.judge == "exact" else reference.simulate
    points = scene.points if scene.points is not None and params == plain(scene) else solve(params, intervals)
    doubts = {doubt for point in points for doubt in point.doubts}
    if doubts - {general_scenes.FADING, general_scenes.STILL}:
        raise Refused(f"the reference is in doubt: {sorted(doubts)}")
    return [{name: float(point.value(name)) for name in scene_names()} for point in points]


def largest_error(
    scene: Scene,
    found: Sequence[dict[str, float]],
    wanted: Sequence[dict[str, float]],
    size: dict[str, float],
) -> tuple[float, str]:
    worst, where = 0.0, ""
    for number, (values, point) in enumerate(zip(found, wanted, strict=True)):
        for name in set(scene.compared) & set(point):
            error = abs(values[name] - point[name]) / size[name]
            if not error <= worst:
                worst, where = error, f"interval {number}: {name} {values[name]!r}, not {point[name]!r}"
    return worst, where


class Impatient(Exception):
    pass


def with_patience(work: Callable[[], Any]) -> Any:  # noqa: ANN401
    def give_up(*_: object) -> None:
        raise Impatient

    signal.signal(signal.SIGALRM, give_up)
    signal.alarm(PATIENCE)
    try:
        return work()
    finally:
        signal.alarm(0)


def by_reference(scene: Scene, trace: Trace, verdict: Verdict) -> None:
    params = plain(scene)
    try:
        wanted = with_patience(lambda: solved(scene, scene.intervals, params))
    except (Refused, ArithmeticError, ValueError, NotImplementedError, Impatient) as doubt:
        verdict.note = f"no reference: {type(doubt).__name__} {doubt}"
        return
    largest = {
        n: max([trace.largest[n], *(abs(point.get(n, 0.0)) for point in wanted)]) for n in scene_names()
    }
    size = sizes_of(largest, trace.turnover)
    verdict.error, where = largest_error(scene, trace.read, wanted, size)
    verdict.judged = True
    if verdict.error <= scene.allowed:
        return
    rng, by = np.random.default_rng(1), scene.tolerance or DEFAULT_TOLERANCE
    try:
        moved = 0.0
        for _ in range(2):
            changed, intervals = general_scenes.nudged(params, scene.intervals, rng, by)
            found = with_patience(partial(solved, replace(scene, points=None), intervals, changed))
            moved = max(moved, largest_error(scene, found, wanted, size)[0])
    except (Refused, ArithmeticError, ValueError, Impatient):
        moved = 0.0
    if verdict.error > scene.allowed + 30.0 * moved:
        verdict.problems.append(f"error {verdict.error:.2e} ({where}); data amplify {moved / by:.1e}")
    else:
        verdict.note = f"amplified {moved / by:.1e} times"
        verdict.error = math.nan


def random_cuts(rng: np.random.Generator) -> Cut:
    def cut(_: int, length: float) -> list[float]:
        count = int(rng.choice([1, 2, 5, 20]))
        return [0.0, *np.unique(rng.uniform(0.0, length, count - 1)).tolist(), length]

    return cut


def by_cutting(scene: Scene, trace: Trace, verdict: Verdict, library: Any) -> None:  # noqa: ANN401
    """Whole intervals against pieces; where they differ, against data changed by a tolerance."""
    tolerance = scene.tolerance or DEFAULT_TOLERANCE
    pieces = drive(library, scene, random_cuts(np.random.default_rng(5)))
    verdict.problems += [f"in pieces: {text}" for text in pieces.problems]
    verdict.step = max(verdict.step, pieces.step)
    if pieces.refusal or trace.refusal or not (pieces.read and trace.read):
        if bool(pieces.refusal) != bool(trace.refusal) and "too often" not in pieces.refusal + trace.refusal:
            verdict.note = f"refused in one piece only: {trace.refusal or '-'} | {pieces.refusal or '-'}"
        return
    if pieces.problems or trace.problems or len(pieces.read) != len(trace.read):
        return
    size = sizes_of({n: max(trace.largest[n], pieces.largest[n]) for n in scene_names()}, trace.turnover)
    verdict.error, where = largest_error(scene, trace.read, pieces.read, size)
    verdict.judged = True
    if verdict.error <= 100.0 * tolerance:
        return
    rng, moved = np.random.default_rng(6), 0.0
    for by in (tolerance, tolerance, 10.0 * tolerance):
        params, intervals = general_scenes.nudged(scene.params, scene.intervals, rng, by)
        other = drive(library, replace(scene, params=params, intervals=intervals))
        if len(other.read) == len(trace.read):
            moved = max(moved, largest_error(scene, other.read, trace.read, size)[0])
    if verdict.error > 100.0 * tolerance + 10.0 * moved:
        verdict.problems.append(
            f"cutting changes {verdict.error:.2e} ({where}); data amplify {moved / tolerance:.1e}"
        )
    else:
        verdict.note = f"chaotic: data amplify {moved / tolerance:.1e}"
        verdict.error = math.nan


def judge(scene: Scene, libraries: dict[bool, Any]) -> Verdict:
    library = libraries[scene.general]
    trace = drive(library, scene)
    verdict = Verdict(
        residual=trace.residual, step=trace.step, refusal=trace.refusal, problems=trace.problems
    )
    verdict.rate = trace.total / trace.simulated if trace.simulated else 0.0
    if scene.judge == "cuts":
        by_cutting(scene, trace, verdict, library)
    elif scene.judge != "laws" and len(trace.read) == len(scene.intervals) and trace.largest:
        by_reference(scene, trace, verdict)
    return verdict


# ---- Processes ----------------------------------------------------------------------------------------


def work(connection: Connection, paths: Libraries, scenes: Sequence[Scene]) -> None:
    np.seterr(all="ignore")
    warnings.simplefilter("ignore")  # of a reference at the end of its range: then it counts as none
    libraries = {False: driver.load(paths.shipped), True: driver.load(paths.general)}
    while (number := connection.recv()) is not None:
        try:
            verdict = judge(scenes[number], libraries)
        except Exception:
            verdict = Verdict(problems=["the test itself failed: " + traceback.format_exc(limit=-3)])
        connection.send(verdict)


@dataclass
class Worker:
    process: Any
    connection: Connection
    number: int = -1
    since: float = 0.0


def judged(scenes: Sequence[Scene], paths: Libraries, workers: int) -> Iterator[tuple[Scene, Verdict]]:
    """Every scene in a process that may crash or hang."""
    context = multiprocessing.get_context("fork")
    waiting = iter(range(len(scenes)))

    def hire() -> Worker:
        ours, theirs = context.Pipe()
        process = context.Process(target=work, args=(theirs, paths, scenes), daemon=True)
        process.start()
        theirs.close()
        return Worker(process, ours)

    def hand_out(worker: Worker) -> bool:
        number = next(waiting, None)
        worker.connection.send(number)
        worker.number, worker.since = -1 if number is None else number, time.monotonic()
        return number is not None

    busy = [worker for worker in (hire() for _ in range(min(workers, len(scenes)))) if hand_out(worker)]
    while busy:
        ready = wait([worker.connection for worker in busy], timeout=1.0)
        for worker in list(busy):
            verdict = None
            if worker.connection in ready:
                try:
                    verdict = worker.connection.recv()
                except EOFError:
                    worker.process.join()
                    verdict = Verdict(problems=[f"crash: exit code {worker.process.exitcode}"])
            elif time.monotonic() - worker.since > HANG:
                worker.process.kill()
                verdict = Verdict(problems=[f"hangs: more than {HANG:g} s"])
            if verdict is None:
                continue
            yield scenes[worker.number], verdict
            busy.remove(worker)
            if verdict.problems and verdict.problems[0].startswith(("crash", "hangs")):
                worker = hire()
            if hand_out(worker):
                busy.append(worker)


# ---- The table ----------------------------------------------------------------------------------------


@dataclass
class Row:
    name: str
    runs: int = 0
    judged: int = 0
    amplified: int = 0
    error: float = 0.0
    residual: float = 0.0
    step: float = 0.0
    rate: float = 0.0
    wrong: list[tuple[Scene, Verdict]] = field(default_factory=list)
    refusals: Counter[str] = field(default_factory=Counter)

    def add(self, scene: Scene, verdict: Verdict) -> None:
        self.runs += 1
        self.judged += verdict.judged
        self.step = max(self.step, verdict.step)
        self.rate = max(self.rate, verdict.rate)
        if verdict.problems:
            self.wrong.append((scene, verdict))
            return
        self.residual = max(self.residual, verdict.residual)
        if not math.isnan(verdict.error):
            self.error = max(self.error, verdict.error)
        else:
            self.amplified += verdict.judged
        if verdict.refusal:
            self.refusals[reason(verdict.refusal)] += 1

    def outcome(self) -> str:
        parts = [f"**{len(self.wrong)} wrong**"] if self.wrong else []
        right = self.runs - len(self.wrong) - self.refusals.total()
        parts += [f"{right} right"] if parts or self.refusals else ["right"]
        parts += [f"{count} refused: {text}" for text, count in self.refusals.most_common()]
        return "; ".join(parts)

    def cells(self) -> list[str]:
        error = f"{self.error:.1e}" if self.judged else ""
        cost = f"{1e3 * self.step:.3g} / {1e3 * self.rate:.3g}"
        return [
            self.name,
            str(self.runs),
            str(self.judged),
            error,
            f"{self.residual:.1e}",
            cost,
            self.outcome(),
        ]


REASONS = {
    "jam when loading": '"the contacts jam when loading at theta = ..."',
    "nothing resists": '"nothing resists the motion on a dwell"',
    "jam and let go": '"the contacts jam and let go without end"',
    "too often": '"the mode changes too often"',
    "both grooves are level": '"both grooves are level at theta = ..."',
    "elliptical groove": '"the elliptical groove ... ends at psi = ..., reached at theta = ..."',
    "describing the grooves": '"describing the grooves in between takes more than ... polynomials"',
    "is refused": '"... is refused: allowed is ..."',
}


def reason(refusal: str) -> str:
    return next((words for key, words in REASONS.items() if key in refusal), f'"{refusal[:160]}"')


HEAD = ["varied", "runs", "judged", "worst error", "energy residual", "cost, ms", "outcome"]


def markdown(rows: Sequence[Row], seconds: float) -> str:
    lines = [
        "# Stress table of the general mechanism",
        "",
        "Elliptical and tabulated grooves, nonlinear spring and damper, masses: how far each was taken",
        "and what came out. Error: of angle, speed and accounts, relative to the largest angle, speed and",
        "energy of the scene, at the tolerance 1e-9 unless the row says otherwise. *Judged*: runs with an",
        "independent reference (at random: the same intervals cut differently); the others are held to the",
        "laws alone, as all are. Energy residual: relative to the largest account. Cost, in processor time:",
        "longest doStep / most for a simulated second.",
        "The judges are described in benchmarks/stress.py.",
        "",
        "| " + " | ".join(HEAD) + " |",
        "|" + "---|" * len(HEAD),
        *("| " + " | ".join(row.cells()) + " |" for row in rows),
        "",
    ]
    wrong = [(row, scene, verdict) for row in rows for scene, verdict in row.wrong]
    if wrong:
        lines += ["## Wrong", ""]
        for row, scene, verdict in wrong[:60]:
            lines.append(f"- {row.name}: {scene.label}: {verdict.problems[0].strip()[:300]}")
        if len(wrong) > 60:
            lines.append(f"- and {len(wrong) - 60} more")
        lines.append("")
    facts = step_cost.circumstances("stress")
    facts["versions"] += f", SciPy {version('scipy')}, NumPy {version('numpy')}"
    facts["took"] = f"{seconds / 60:.0f} min"
    return "\n".join([*lines, "---", "", *(f"{name}: {value}  " for name, value in facts.items())]) + "\n"


def describe(scene: Scene) -> str:
    """Everything needed to run it again."""
    tables = {n: reference.read_table(v) for n, v in scene.params.items() if n.endswith(".table") and v}
    params = {n: v for n, v in scene.params.items() if n not in tables}
    return (
        f"  params = {params}\n  tables = {tables}\n  intervals = {scene.intervals}\n"
        f"  tolerance {scene.tolerance}, {scene.steps} steps per interval, "
        f"without closed forms: {scene.general}"
    )


def collect(names: Iterable[str], count: int, tables: Tables, seed: int = 0) -> list[Scene]:
    made = [scene for name in names if name != "fuzz" for scene in FAMILIES[name](tables)]
    return made + (list(fuzz(tables, count, seed)) if "fuzz" in names else [])


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--rows", default=",".join([*FAMILIES, "fuzz"]), help="names, with commas between")
    parser.add_argument("--fuzz", type=int, default=3000, help="scenes at random (default 3000)")
    parser.add_argument("--seed", type=int, default=0, help="of the scenes at random")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--output", type=Path, default=ROOT / "docs/stress.md")
    parser.add_argument("--details", type=Path, help="write every wrong scene, in full, to this file")
    arguments = parser.parse_args()
    console, begun = Console(), time.monotonic()
    names = arguments.rows.split(",")
    unknown = set(names) - {*FAMILIES, "fuzz"}
    if unknown:
        parser.error(
            f"no such rows: {', '.join(sorted(unknown))}; there are {', '.join([*FAMILIES, 'fuzz'])}"
        )
    paths = prepare()
    rows: dict[str, Row] = {}
    details: list[str] = []
    with tempfile.TemporaryDirectory() as folder:
        scenes = collect(names, arguments.fuzz, Tables(Path(folder)), arguments.seed)
        columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
        with Progress(*columns, console=console) as progress:
            tasks = {
                name: progress.add_task(name, total=count)
                for name, count in Counter(scene.row for scene in scenes).items()
            }
            rows = {name: Row(name) for name in tasks}
            for scene, verdict in judged(scenes, paths, arguments.workers):
                rows[scene.row].add(scene, verdict)
                progress.advance(tasks[scene.row])
                if verdict.problems:
                    text = f"{scene.row}: {scene.label}: " + "; ".join(verdict.problems)
                    console.print(text[:500], highlight=False, markup=False)
                    details.append(f"{text}\n{describe(scene)}\n")
                elif verdict.note and arguments.details:
                    details.append(f"({scene.row}: {scene.label}: {verdict.note})\n")
    text = markdown(list(rows.values()), time.monotonic() - begun)
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text(text)
    if arguments.details:
        arguments.details.write_text("\n".join(details))
    console.print(text, highlight=False, markup=False)
    return 1 if any(row.wrong for row in rows.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
