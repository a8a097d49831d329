"""What does a robot's elbow gain from a controller that plans by trial runs of the FMU, if nothing is known?

The elbow of the example robot_joint with its cam follows one cycle of pick and place (4 s), with 200 random
payloads (0.5 to 2.5 kg) and friction coefficients (0.10 to 0.18). Two kinds of controllers do so, behind the
same encoder and with the same motor (dualcam.systems.machines.elbow_controllers has both):

    MPPI    model predictive path integral control: every 10 ms 192 random plans of the motor's torque over
            0.3 s run on instances of the forward FMU. Their mean, weighted by cost, is the next plan
    LQI     the hand-made controller of robot_joint, every 1 ms

    cost = heat of the motor + 1 J/mrad^2.s times the integral of the squared error

Payload and friction are those of the cam's design for "as designed", and the true ones for "informed". For
"estimate" a particle filter over 64 instances of the FMU (dualcam.systems.machines.payload_filter) finds
them.

Copy `Mppi` of dualcam.systems.machines.elbow_controllers for an own system. Its method `costs` says what is
good.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np
from matplotlib.figure import Figure
from rich.progress import track
from scipy.stats import bootstrap

from benchmarks.harness.circumstances import commit, core_of
from dualcam.design.statics import Array
from dualcam.systems.blocks.axis_bank import AxisBank
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.blocks.motor_bank import MotorBank
from dualcam.systems.machines import elbow
from dualcam.systems.machines.elbow_controllers import (
    ANGLES,
    CAM,
    COUNT,
    ERROR_COST,
    FRICTIONS,
    PAYLOADS,
    RATIO,
    Lqi,
    Mppi,
    estimator,
    informed,
)
from dualcam.systems.machines.payload_filter import Belief

BUILD = Path(__file__).resolve().parent.parent / "build"
DRAWS = 200
BLOCK = 10  # loops at a time
PERIODS = round(elbow.MOTION.period / CONTROL_PERIOD)
LATE_REST = np.r_[500:1000, 2500:3000]  # control periods: the second half of both rests
RESTS_END = np.array(
    [2999, 3999]
)  # control periods: the end of the rest at the bottom, the arrival at the top
FIGURES = (
    "cost [J]",
    "heat [J]",
    "RMS error [mrad]",
    "end error [mrad]",
    "rest current [A]",
    "off at rest [%]",
)

# By name: the controller for a true payload [kg] and friction, which only the informed ones are told.
Maker = Callable[[float, float, np.random.Generator], Mppi | Lqi]
CONTROLLERS: dict[str, Maker] = {
    "LQI, as designed": lambda payload, friction, random: Lqi(),
    "LQI, estimate": lambda payload, friction, random: Lqi(belief=estimator(random)),
    "LQI 4 Hz, estimate": lambda payload, friction, random: Lqi(belief=estimator(random), bandwidth=4.0),
    "LQI, informed": lambda payload, friction, random: Lqi(payload, friction),
    "MPPI, estimate": lambda payload, friction, random: Mppi(estimator(random), random),
    # the same number of runs: 64 plans on 3 payloads and frictions each
    "MPPI, 3 hypotheses": lambda payload, friction, random: Mppi(estimator(random), random, 64, hypotheses=3),
    "MPPI, informed": lambda payload, friction, random: Mppi(informed(payload, friction), random),
}
PAIRS = (
    ("MPPI, estimate", "LQI, as designed"),
    ("MPPI, estimate", "LQI, estimate"),
    ("MPPI, estimate", "LQI 4 Hz, estimate"),
    ("MPPI, informed", "LQI, informed"),
    ("LQI, estimate", "LQI, as designed"),
)
COUNTS = "number of loops"
LOOPS = "median (5 % to 95 % of the loops)"
TIMES = "time per 10 ms: median (99 % to largest)"
DIFFERENCES = "paired difference: median (95 % interval)"
Row = tuple[str, str, str, float, float, float]  # one of these four, name, figure, numbers


class Runs(NamedTuple):
    """Closed loops of one controller."""

    figures: Array  # (loops, FIGURES)
    seconds: Array  # (loops, periods of 10 ms, 2): processor time and time by the clock
    angles: Array  # rad, (loops, periods)
    torques: Array  # N.m asked for, (loops, periods)


def run_block(name: str, draws: Array, first: int, periods: int = PERIODS) -> Runs:
    """Loops of some payloads and frictions, shape (loops, 2). `first` is the number of the first loop."""
    count, (payload, friction) = len(draws), draws.T
    controllers = [
        CONTROLLERS[name](own, mu, np.random.default_rng([first + i, 1]))
        for i, (own, mu) in enumerate(draws.tolist())
    ]
    weight, motors = elbow.weight(payload), MotorBank(AK80_6, count)
    start = Belief(np.full(count, ANGLES[0]), np.zeros(count), payload, friction)
    heat, angles, torques = (np.empty((count, periods)) for _ in range(3))
    seconds = np.zeros((count, periods // RATIO, 2))
    with AxisBank(count, elbow.plant_parameters(CAM, elbow.DESIGN_PAYLOAD)) as arms:
        arms.start(start.angle, start.speed, start.start_values())
        for k in range(periods):
            shown = (COUNT * np.rint(arms.angle / COUNT)).tolist()
            for i, controller in enumerate(controllers):
                begin = time.process_time(), time.perf_counter()
                torques[i, k] = controller.torque(shown[i], k)
                seconds[i, k // RATIO] += time.process_time() - begin[0], time.perf_counter() - begin[1]
            motor = motors.run(torques[:, k], arms.speed)
            arms.step(motor.torque, weight, CONTROL_PERIOD)
            heat[:, k], angles[:, k] = motor.heat, arms.angle
    return Runs(figures_of(heat, angles, torques), seconds, angles, torques)


def figures_of(heat: Array, angles: Array, torques: Array) -> Array:
    """The FIGURES of each loop, of whole cycles; NaN where a loop is shorter than that."""
    if angles.shape[1] < PERIODS:
        return np.full((len(angles), len(FIGURES)), np.nan)
    error = angles - ANGLES[1 : PERIODS + 1]
    mean_square, total = np.mean(error**2, axis=1), np.sum(heat, axis=1)
    rest_power = np.mean(heat[:, LATE_REST], axis=1) / CONTROL_PERIOD  # W
    return np.column_stack(
        [
            total + ERROR_COST * elbow.MOTION.period * mean_square,
            total,
            1e3 * np.sqrt(mean_square),
            1e3 * np.max(np.abs(error[:, RESTS_END]), axis=1),
            np.sqrt(rest_power / AK80_6.resistance),
            100.0 * np.mean(torques[:, LATE_REST] == 0.0, axis=1),
        ]
    )


def study(count: int, workers: int, seed: int = 1) -> dict[str, Runs]:
    """All controllers with the same `count` payloads and frictions."""
    low, high = np.transpose([PAYLOADS, FRICTIONS])
    draws = np.random.default_rng(seed).uniform(low, high, (count, 2))
    firsts = range(0, count, BLOCK)
    names = [name for name in CONTROLLERS for _ in firsts]
    numbers = [first for _ in CONTROLLERS for first in firsts]
    parts = [draws[first : first + BLOCK] for first in numbers]
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        results = pool.map(run_block, names, parts, numbers)
        done = list(track(results, f"{count * len(CONTROLLERS)} loops", len(names), transient=True))
    blocks = {name: done[i * len(firsts) :][: len(firsts)] for i, name in enumerate(CONTROLLERS)}
    return {
        name: Runs(*(np.concatenate(parts) for parts in zip(*runs, strict=True)))
        for name, runs in blocks.items()
    }


def median_difference(differences: Array) -> tuple[float, float, float]:
    """The median of paired differences, with its interval of 95 % by the bootstrap."""
    middle, random = float(np.median(differences)), np.random.default_rng(1)
    if np.ptp(differences) == 0.0:
        return middle, middle, middle
    interval = bootstrap((differences,), np.median, method="percentile", rng=random).confidence_interval
    return middle, float(interval.low), float(interval.high)


def table(results: dict[str, Runs]) -> list[Row]:
    """All numbers of the report."""
    rows: list[Row] = []
    for name, runs in results.items():
        count = float(len(runs.figures))
        rows.append((COUNTS, name, "loops", count, count, count))
        for figure, values in zip(FIGURES, runs.figures.T, strict=True):
            low, middle, high = np.percentile(values, (5, 50, 95)).tolist()
            rows.append((LOOPS, name, figure, middle, low, high))
        for clock, values in zip(("processor [ms]", "clock [ms]"), 1e3 * runs.seconds.T, strict=True):
            rows.append((TIMES, name, clock, *np.percentile(values, (50, 99, 100)).tolist()))
    for one, other in PAIRS:
        for i, figure in enumerate(FIGURES):
            difference = results[one].figures[:, i] - results[other].figures[:, i]
            rows.append((DIFFERENCES, f"{one} - {other}", figure, *median_difference(difference)))
    return rows


def report(rows: Sequence[Row]) -> str:
    """The same as tables in Markdown."""
    lines = []
    for kind in (LOOPS, TIMES, DIFFERENCES):
        cells = {row[1:3]: f"{row[3]:.2f} ({row[4]:.2f} to {row[5]:.2f})" for row in rows if row[0] == kind}
        figures, names = (list(dict.fromkeys(key[i] for key in cells)) for i in (1, 0))
        lines += [f"| {kind} | {' | '.join(figures)} |", "| --- " * (len(figures) + 1) + "|"]
        lines += [f"| {name} | {' | '.join(cells[name, figure] for figure in figures)} |" for name in names]
        lines.append("")
    return "\n".join(lines)


def draw(results: dict[str, Runs], path: Path) -> None:
    """Cost, heat, error and rest current of all loops, sorted: a curve to the left is better."""
    figure = Figure(figsize=(11.0, 3.8), layout="constrained")
    colours = "0.6", "tab:blue", "tab:cyan", "navy", "tab:red", "tab:pink", "darkred"
    for place, (axes, i) in enumerate(zip(figure.subplots(1, 4, sharey=True), (0, 1, 2, 4), strict=True)):
        for (name, runs), colour in zip(results.items(), colours, strict=False):
            values = np.sort(runs.figures[:, i])
            share = 100.0 * (np.arange(len(values)) + 0.5) / len(values)
            style = "--" if name.endswith("informed") else "-"
            axes.plot(values, share, style, color=colour, label=name if place == 0 else None)
        axes.set(xlabel=FIGURES[i], xscale="linear" if i in (1, 4) else "log")
        axes.grid(alpha=0.3)
        if place == 0:
            axes.set_ylabel("loops with less [%]")
    figure.legend(loc="outside upper center", ncols=4)
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--draws", type=int, default=DRAWS, help=f"payloads and frictions ({DRAWS})")
    parser.add_argument("--workers", type=int, default=2, help="processes (2)")
    parser.add_argument("--picture", type=Path, default=BUILD / "sampling_elbow.png")
    parser.add_argument("--table", type=Path, default=BUILD / "sampling_elbow.csv")
    given = parser.parse_args(arguments)
    wall = time.perf_counter()
    results = study(given.draws, given.workers)
    rows = table(results)
    print(report(rows))
    draw(results, given.picture)
    with given.table.open("w", newline="", encoding="utf-8") as file:
        head = ("kind", "name", "figure", "middle", "low", "high", "commit", "core")
        measured = (commit(), core_of())
        csv.writer(file, lineterminator="\n").writerows([head, *((*row, *measured) for row in rows)])
    print(f"{time.perf_counter() - wall:.0f} s; written: {given.picture}, {given.table}")


if __name__ == "__main__":
    main()
