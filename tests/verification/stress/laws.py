"""Scenes whose friction depends on the sliding speed and on the load: Stribeck's law, a lubricated branch,
the load law, tables.

Source of the laws: docs/mechanism.md, section 9.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from benchmarks.harness.oracles import Interval
from verification.stress.at_random import decades, draw, maybe
from verification.stress.mechanisms import Sizes, Tables, damper, ellipses, helices, spring
from verification.stress.scene import Params, Scene


def law(peak: float, speed: float, exponent: int, viscous: float) -> Params:
    """The same law at both cams. `speed`: Stribeck velocity [m/s]; `viscous` [s/m]."""
    values = {
        "friction_peak": peak,
        "stribeck_velocity": speed,
        "stribeck_exponent": exponent,
        "friction_viscous": viscous,
    }
    return {f"cam{i}.{name}": value for i in (1, 2) for name, value in values.items()}


def to_and_fro(parameters: Params) -> list[Interval]:
    """Torques that load, let go, pull back and come again, by the size of the loads at 0.7 rad."""
    torque = Sizes.of(parameters).torque(0.7)
    return [
        Interval(0.02, 1.6 * torque),
        Interval(0.03, 0.0),
        Interval(0.02, 0.0, -1.5 * torque / 0.02),
        Interval(0.03, -0.3 * torque, 2.2 * torque / 0.03),
    ]


def friction_laws(tables: Tables) -> Iterator[Scene]:
    row = (
        "Stribeck velocity 1e-6 to 10 m/s, static over kinetic friction 1 to 5, lubricated branch 0 to 1 s/m"
    )
    for peak, speed, exponent, viscous in product(
        (1.0, 1.001, 1.5, 5.0), (1e-6, 1e-4, 1e-2, 1.0, 10.0), (1, 2), (0.0, 1.0)
    ):
        if peak == 1.0 and (viscous == 0.0 or exponent == 2 or speed != 1.0):
            continue
        # the reference takes minutes where friction falls at once
        judge = "simulate" if speed >= 1e-3 or peak < 1.1 else "cuts"
        for shape, nonlinear in ((ellipses(), True), (helices(0.8, 0.9), False)):
            p = shape | law(peak, speed, exponent, viscous) | spring(3e4, 0.02, nonlinear=nonlinear)
            p |= damper(20.0) | {"inertia.shaft": 0.002, "initial.theta": 0.3}
            label = f"peak {peak:g}, Stribeck velocity {speed:g}, exponent {exponent}, viscous {viscous:g}"
            yield Scene(row, p, to_and_fro(p), judge, label, steps=2)


def load_laws(tables: Tables) -> Iterator[Scene]:
    """The reaction passes the reference load, and the load below which friction levels off."""
    row = "load exponent -0.9 to 0.9, reference load 1e-3 to 1e3 times the spring's force"
    for exponent, share, falls in product((-0.9, -1 / 3, 0.4, 0.9), (1e-3, 1.0, 1e3), (False, True)):
        for shape, nonlinear in ((ellipses(), True), (helices(0.8, 0.9), False)):
            p = shape | spring(3e4, 0.02, nonlinear=nonlinear) | damper(20.0)
            p |= {"inertia.shaft": 0.002, "initial.theta": 0.3}
            for i in (1, 2):
                p[f"cam{i}.friction_load_exponent"] = exponent
                p[f"cam{i}.friction_load"] = share * 600.0  # N, the force of the spring at 0.02 m
                # the coefficient at the load of the scene stays about that of Coulomb's law
                p[f"cam{i}.friction"] = 0.14 * share**exponent
            if falls:
                p |= law(1.5, 1e-2, 2, 0.0)
            label = f"exponent {exponent:g}, reference load {share:g}, {'Stribeck' if falls else 'Coulomb'}"
            yield Scene(row, p, to_and_fro(p), "simulate", label, steps=2)


def with_law(rng: np.random.Generator, scene: Scene) -> Scene:
    """The scene with a friction law at one cam or at both."""
    drawn: Params = {}
    for i in rng.choice([1, 2], int(rng.integers(1, 3)), replace=False).tolist():
        drawn[f"cam{i}.friction_viscous"] = maybe(rng, 0.5, decades(rng, -4, 1))
        if scene.params["inertia.shaft"]:
            drawn[f"cam{i}.friction_peak"] = 1.0 + maybe(rng, 0.8, decades(rng, -4, 1))
            drawn[f"cam{i}.stribeck_velocity"] = decades(rng, -6, 1)
            drawn[f"cam{i}.stribeck_exponent"] = int(rng.integers(1, 3))
    return replace(scene, params=scene.params | drawn)


def random_law(tables: Tables, number: int, seed: int = 0) -> Scene:
    """One scene of fuzz_laws()."""
    rng = np.random.default_rng([78, seed, number])
    return replace(with_law(rng, draw(rng, tables)), label=f"law {number}")


def fuzz_laws(tables: Tables, count: int, seed: int = 0) -> Iterator[Scene]:
    """Everything at random, and friction laws over many decades."""
    row = f"everything and friction laws at random ({count} scenes of 0.1 to 1 s)"
    for number in range(count):
        yield replace(random_law(tables, number, seed), row=row)


def force_of(params: Params) -> float:
    """N: the spring's preload and the force of its stiffness over the larger radius."""
    reach = max(params[f"cam{i}.radius"] for i in (1, 2))
    return float(abs(params["spring.preload"]) + params["spring.stiffness"] * reach) or 1.0


def with_load(rng: np.random.Generator, scene: Scene, tables: Tables) -> Scene:
    """The scene with a load law at one cam or at both, or with a table over speed and load at one. Without
    inertia friction does not fall with the load."""
    drawn: Params = {}
    force, inertia = force_of(scene.params), scene.params["inertia.shaft"]
    for i in rng.choice([1, 2], int(rng.integers(1, 3)), replace=False).tolist():
        drawn[f"cam{i}.friction_load_exponent"] = float(rng.uniform(-0.9 if inertia else 0.0, 0.9))
        drawn[f"cam{i}.friction_load"] = force * decades(rng, -3, 2)
    if inertia and rng.random() < 0.3:
        speeds = np.concatenate([[0.0], np.cumsum(10.0 ** rng.uniform(-4, 0, int(rng.integers(2, 5))))])
        loads = force * decades(rng, -2, 0) * np.cumprod(rng.uniform(1.5, 8.0, int(rng.integers(2, 5))))
        power = rng.uniform(-0.5, 0.5)
        mu = 0.1 * np.exp(rng.normal(0, 0.5, len(speeds)))[None, :] * (loads / loads[0])[:, None] ** power
        mu *= np.exp(rng.normal(0, 0.05, mu.shape))
        path = tables.write_law(speeds, loads, np.minimum(mu, 10.0))
        drawn[f"cam{rng.integers(1, 3)}.friction_table"] = path
    return replace(scene, params=scene.params | drawn)


def random_load(tables: Tables, number: int, seed: int = 0) -> Scene:
    """One scene of fuzz_loads()."""
    rng = np.random.default_rng([79, seed, number])
    return replace(with_load(rng, with_law(rng, draw(rng, tables)), tables), label=f"load law {number}")


def fuzz_loads(tables: Tables, count: int, seed: int = 0) -> Iterator[Scene]:
    """Everything at random, and friction laws over speed and load."""
    row = f"everything, friction laws and load laws at random ({count} scenes of 0.1 to 1 s)"
    for number in range(count):
        yield replace(random_load(tables, number, seed), row=row)
