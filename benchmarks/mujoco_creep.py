"""Creep of a held joint in MuJoCo over the settings of its friction, and the cost of a step beside the cam's.

    ./build.sh creep

The elbow of system_examples/mujoco_elbow.py stands at 60 deg, motor off. The same spring torque and friction
hold the arm by MuJoCo's frictionloss, with one setting after another, and by the cam. Creep is the mean speed
from 2 s to 4 s. Each cost is the processor time of one step of one mjData, the call from Python included: a
median over rounds in which all ways take turns. Costs over that of `frictionloss` as it comes are medians of
the ratios of the same round.
"""

from __future__ import annotations

import statistics
import sys
import time
from collections.abc import Callable
from contextlib import ExitStack
from functools import partial

import mujoco

from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.timing import Block, Ratio, in_turns
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


def main() -> int:
    arguments = harness.options(__doc__, "mujoco_creep", 15).parse_args()
    console = harness.new_console()
    table = harness.table(
        "The elbow at rest, motor off", "held by", "creep [rad/s]", "us per step", "over as it comes"
    )
    with ExitStack() as stack:
        all_ways = ways(stack)
        creep = {name: creep_of(way) for name, way in all_ways.items()}
        blocks = {name: block_of(way) for name, way in all_ways.items()}
        times = in_turns(blocks, arguments.rounds, "steps", console)
    plain = times[f"frictionloss, {AS_IT_COMES}"]
    rows = []
    for name, seconds in times.items():
        ratio = Ratio.of(seconds, plain)
        row = {
            "held_by": name,
            "creep": f"{creep[name]:.1e}",
            "us_per_step": f"{1e6 * statistics.median(seconds):.2f}",
            "ratio": f"{ratio.median:.2f}",
        }
        rows.append(row)
        table.add_row(*row.values())
    console.print(table)
    harness.publish(rows, circumstances("creep", "numpy", "mujoco"), arguments.output, console)
    return 0


if __name__ == "__main__":
    sys.exit(main())
