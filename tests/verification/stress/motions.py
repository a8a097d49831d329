"""Scenes that vary the motion: steps, reversals, starts at a stop, restitution, tolerance."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import product

import numpy as np

from benchmarks.harness.oracles import Interval, general_scenes
from verification.stress.mechanisms import Sizes, Tables, damper, ellipses, spring
from verification.stress.scene import Scene


def step_sizes(tables: Tables) -> Iterator[Scene]:
    row = "communication steps 1e-9 to 1e3 s"
    for h in np.logspace(-9, 3, 13).tolist():
        base = ellipses() | spring(3e4, 0.03) | damper(30.0, 10.0)
        base |= {"inertia.shaft": 0.002, "initial.theta": 0.3, "initial.omega": 3.0}
        torque = 1.2 * Sizes.of(base).torque(0.8)
        count = int(min(1000, max(1, 0.1 / h)))
        intervals = [Interval(count * h, torque), Interval(count * h, 0.3 * torque)]
        yield Scene(row, base, intervals, "simulate", f"h {h:g}, period 0.03 s", steps=count)
        # a mechanism as slow or as fast as the step
        for periods in (0.01, 1.0, 20.0):
            J = Sizes.of(base).stiffness() * (h / periods / (2.0 * math.pi)) ** 2
            p = base | {"inertia.shaft": J, "initial.omega": 0.0} | damper()
            critical = 2.0 * math.sqrt(J * Sizes.of(base).stiffness()) / Sizes.of(base).dz_dtheta() ** 2
            p |= damper(0.1 * critical)
            steps = 200 if periods < 1.0 else 3
            intervals = [Interval(steps * h, torque), Interval(steps * h, 0.2 * torque)]
            yield Scene(row, p, intervals, "simulate", f"h {h:g} of {periods:g} periods", steps=steps)


def reversals(tables: Tables) -> Iterator[Scene]:
    row = "1e4 reversals a second"
    for mu, c in product((0.0, 0.05, 0.14), (0.0, 50.0)):
        p = ellipses(**{"cam1.friction": mu, "cam2.friction": mu}) | spring(3e4, 0.03) | damper(c)
        p |= {"inertia.shaft": 1e-6, "initial.theta": 0.7}
        middle = Sizes.of(p).torque(0.7)
        intervals = [Interval(1e-4, middle * (1.0 + 1.2 * (-1) ** i)) for i in range(400)]
        yield Scene(row, p, intervals, "simulate", f"square torque, mu {mu}, c {c}")
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
            intervals = [
                Interval(1e-4, middle * (1.0 - 0.8 * s), 1.6 * s * middle / 1e-4) for s in [1, -1] * 200
            ]
            yield Scene(row, q, intervals, "simulate", f"saw-tooth torque without inertia, mu {mu}, c {c}")


def starts_at_stops(tables: Tables) -> Iterator[Scene]:
    row = "starts at a stop"
    for upper, inertia, c, e in product((False, True), (0.002, 0.0), (0.0, 40.0), (0.0, 0.5)):
        p = ellipses(**{"stop.restitution": e}) | spring(2e4, 0.03) | damper(c)
        at = 1.3963 if upper else 0.0
        p |= {"inertia.shaft": inertia, "initial.theta": at}
        torque = Sizes.of(p).torque(at)
        for factor in (-0.5, 0.0, 0.5, 1.0, 1.5):
            for omega in (0.0, 5.0, -5.0) if inertia else (0.0,):
                intervals = [
                    Interval(0.02, factor * torque),
                    Interval(0.02, factor * torque, (0.95 - factor) * torque / 0.02),
                    Interval(0.02, 0.0),
                ]
                label = (
                    f"{'upper' if upper else 'lower'}, J {inertia}, c {c}, e {e}, tau {factor}, omega {omega}"
                )
                yield Scene(row, p | {"initial.omega": omega}, intervals, "simulate", label, steps=2)


def restitutions(tables: Tables) -> Iterator[Scene]:
    row = "restitution 0 to 1"
    for e in (0.0, 1e-9, 1e-3, 0.1, 0.5, 0.9, 0.99, 0.999, 1.0):
        for mu, c in product((0.0, 0.14), (0.0, 30.0)):
            p = ellipses(**{"stop.restitution": e, "cam1.friction": mu, "cam2.friction": mu})
            p |= spring(2e4, 0.03) | damper(c) | {"inertia.shaft": 0.002, "initial.theta": 0.4}
            torque = Sizes.of(p).torque(1.3963)
            intervals = [Interval(0.03, 2.0 * torque), Interval(0.03, -torque), Interval(0.03, 0.0)]
            yield Scene(row, p, intervals, "simulate", f"e {e:g}, mu {mu}, c {c}", steps=2)
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
