"""Creep of a held joint in MuJoCo over the settings of its friction, and the cost of a step beside the cam's.

The elbow of system_examples/mujoco_elbow.py stands at 60 deg, motor off. The same spring torque and friction
hold the arm by MuJoCo's frictionloss, with one setting after another, and by the cam. Creep is the mean speed
from 2 s to 4 s. Each cost is the processor time of one step of one mjData, the call from Python included.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial

import mujoco
from rich.console import Console

from benchmarks.harness.timing import Block, in_turns
from benchmarks.rates.measure import Group, Measure
from dualcam.mujoco import CamSimulation
from system_examples import mujoco_elbow as elbow

AS_IT_COMES = "as it comes"
SHORT = f'solreffriction="{2.0 * elbow.STEP} 1"'  # the shortest time constant that MuJoCo takes
STIFF = 'solimpfriction="0.9999 0.9999 0.001 0.5 2"'  # the largest impedance
# Attributes of the joint, attributes of the options.
SETTINGS = {
    AS_IT_COMES: ("", ""),
    "cone elliptic, impratio 100": ("", 'cone="elliptic" impratio="100"'),
    "integrator implicitfast": ("", 'integrator="implicitfast"'),
    "solver PGS": ("", 'solver="PGS"'),
    "solver CG": ("", 'solver="CG"'),
    "tolerance 1e-14, 1000 iterations": ("", 'tolerance="1e-14" iterations="1000"'),
    "solreffriction of two steps": (SHORT, ""),
    "solimpfriction 0.9999": (STIFF, ""),
    "both": (f"{SHORT} {STIFF}", ""),
    "noslip_iterations 1": ("", 'noslip_iterations="1"'),
    "noslip_iterations 3": ("", 'noslip_iterations="3"'),
    "noslip_iterations 20": ("", 'noslip_iterations="20"'),
}
COUNTS = (1, 10, 100)  # cams side by side
BEGIN, END = 2.0, 4.0  # s, of the creep
WORK = 2000  # steps of one mjData, of all together, in a block

Way = tuple[list[mujoco.MjData], Callable[[], None]]  # the data, and a step of all of them


def ways(stack: ExitStack) -> dict[str, Way]:
    """All ways to hold, at rest at the start."""
    found: dict[str, Way] = {}
    for name, (joint, option) in SETTINGS.items():
        model = elbow.arm(f"{elbow.as_frictionloss()} {joint}", option)
        data = elbow.arm_at(elbow.END, model)
        found[f"frictionloss, {name}"] = [data], partial(mujoco.mj_step, model, data)
    for count in COUNTS:
        model = elbow.arm()
        many = [elbow.arm_at(elbow.END, model) for _ in range(count)]
        simulation = stack.enter_context(CamSimulation(model, many, elbow.elbow_cam()))
        found[f"cam, {count} side by side"] = many, simulation.step
    return found


def creep_of(way: Way) -> float:
    """Mean speed of the elbow from BEGIN to END [rad/s]."""
    (first, *_), step = way
    for _ in range(round(BEGIN / elbow.STEP)):
        step()
    angle = first.qpos[0]
    for _ in range(round((END - BEGIN) / elbow.STEP)):
        step()
    return float(first.qpos[0] - angle) / (END - BEGIN)


def block_of(way: Way) -> Block:
    data, step = way
    steps = max(5, WORK // len(data))

    def block() -> float:
        start = time.process_time()
        for _ in range(steps):
            step()
        return (time.process_time() - start) / steps / len(data)

    return block


def take(rounds: int, console: Console) -> Iterator[Group]:
    with ExitStack() as stack:
        all_ways = ways(stack)
        creep = {name: f"{creep_of(way):.1e}" for name, way in all_ways.items()}
        blocks = {name: block_of(way) for name, way in all_ways.items()}
        yield Group("elbow at rest", in_turns(blocks, rounds, "steps", console), creep)


MEASURE = Measure(
    *("creep", "A step of MuJoCo with the elbow at rest, motor off", take, 15),
    *(f"frictionloss, {AS_IT_COMES}", "creep, rad/s", ("numpy", "mujoco")),
)
