"""The scenes: a mechanism each, and inputs of random kind, length and level."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from benchmarks.harness.fmu import Slave
from benchmarks.harness.inputs import STEP, Array, Inputs
from benchmarks.mechanisms import DAMPED, ELLIPSES, FORCES, LIGHT, Parameters, tables


@dataclass(frozen=True)
class Scene:
    name: str
    description: str
    parameters: Parameters


BOUNCING: Parameters = {"stop.restitution": 0.5, "initial.theta": 0.7}


def scenes() -> list[Scene]:
    heavy = {**BOUNCING, **DAMPED}
    forces = {**BOUNCING, **FORCES}
    return [
        Scene("helices", "helical grooves, linear spring and damper, masses: closed form", heavy),
        Scene("ellipses", "elliptical grooves with every force", forces | ELLIPSES),
        Scene("tables", "grooves as tables of 37 points with every force", forces | tables()),
        Scene(
            "no inertia",
            "elliptical grooves without inertia, damper 500 N.s/m",
            {**BOUNCING, **ELLIPSES, **LIGHT, "inertia.shaft": 0.0},
        ),
    ]


@dataclass(frozen=True)
class Levels:
    """The ranges of the inputs."""

    low: float  # N.m: presses to the lower stop
    high: float  # N.m: to the upper one
    pull: float  # N: more than the spring, so that the load turns around

    @classmethod
    def of(cls, parameters: Parameters) -> Levels:
        """From torque and spring at the upper stop, where both are largest."""
        probe = Slave()
        probe.set(parameters)
        probe.set({"initial.theta": probe.real("stop.upper")})
        probe.enter_initialization()
        load = probe.real("torque_load")
        return cls(-0.3 * load, 1.2 * load, -1.5 * probe.real("spring.force"))


KINDS = ("hold", "ramp", "swing", "alternate", "up", "down", "pull", "pull ramp")


def stretch(
    kind: str, count: int, last: float, levels: Levels, random: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Torque, its rate and the force of `count` steps. `last`: the torque before them [N.m]."""
    t = STEP * np.arange(count)
    level, zero = random.uniform(levels.low, levels.high), np.zeros(count)
    flat = np.full(count, level)
    if kind == "ramp":
        rate = (level - last) / (STEP * count)
        return last + rate * t, np.full(count, rate), zero
    if kind == "swing":
        size, circular = 0.4 * levels.high * random.random(), 2.0 * math.pi * random.uniform(2.0, 40.0)
        rates = size * circular * np.cos(circular * t) if random.random() < 0.5 else zero
        return level + size * np.sin(circular * t), rates, zero
    if kind == "alternate":
        return np.where(np.arange(count) % 2, level, random.uniform(levels.low, levels.high)), zero, zero
    if kind in ("up", "down"):
        return np.full(count, levels.high if kind == "up" else levels.low), zero, zero
    if kind == "pull":
        return flat, zero, np.where(np.arange(count) // 10 % 2, random.uniform(levels.pull, 0.0), 0.0)
    if kind == "pull ramp":
        return flat, zero, np.linspace(0.0, random.uniform(levels.pull, 0.0), count)
    return flat, zero, zero


def random_inputs(count: int, levels: Levels, seed: int = 1) -> Inputs:
    """Inputs of `count` steps: stretches of 20 to 120 steps."""
    random = np.random.default_rng(seed)
    parts: list[tuple[Array, Array, Array]] = []
    length, last = 0, 0.0
    while length < count:
        kind = KINDS[random.integers(len(KINDS))]
        parts.append(stretch(kind, int(random.integers(20, 120)), last, levels, random))
        length += len(parts[-1][0])
        last = float(parts[-1][0][-1])
    tau, rate, force = (np.concatenate(columns)[:count] for columns in zip(*parts, strict=True))
    return Inputs(tau, rate, force)
