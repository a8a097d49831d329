"""Which gains suit a robot's elbow if payload and friction are not known?

The elbow of the example robot_joint with its cam follows one cycle of pick and place (4 s) under a position
controller that believes in the design payload and friction. The controller has an encoder with 12 bits on the
rotor, a speed from differences of counts through a low-pass filter, and answers one period late.

    torque = I [a - kp e - kd e' - ki integral(e)] + T_cam - T_gravity       kp = 2 w^2, kd = 2 w, ki = s w^3

Two numbers are tuned: the bandwidth w/(2 pi) and the share s of the integral gain (s = 1: LQI, see
dualcam.systems.blocks.position_controller). Each pair on a grid of 20 x 20 runs with the same 250 random
payloads and frictions: 10^5 closed loops of 4000 periods, by a dualcam.Fleet and NumPy over all loops of a
block.

    cost      heat of the motor + 1 J/mrad^2.s times the integral of the squared error
    nominal   the gains with the least cost if payload and friction are as believed
    robust    the gains with the least 95th percentile of the cost

Copy this file for an own controller: `Controllers` is the only part that knows the control law.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
import os
import time
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from rich.progress import track

from dualcam import Fleet
from dualcam.design.statics import Array
from dualcam.systems.blocks.axis import angle_amid
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD
from dualcam.systems.blocks.motor import AK80_6
from dualcam.systems.blocks.motor_bank import MotorBank
from dualcam.systems.machines import elbow

BUILD = Path(__file__).resolve().parent.parent / "build"
CAM = elbow.design_cam()
BANDWIDTHS = np.geomspace(2.0, 20.0, 20)  # Hz
SHARES = np.linspace(0.0, 1.9, 20)  # of the LQI's integral gain; from 4 on the loop is unstable
DRAWS = 250
PAYLOADS, FRICTIONS = (0.5, 2.5), (0.10, 0.18)  # kg, 1
ERROR_COST = 1e6  # J/(rad^2.s)
BLOCK = 1000  # loops at a time: their arrays stay in the cache
COUNT = 2.0 * math.pi / 4096 / AK80_6.gear  # rad at the output, of the encoder
FILTER = 1.0 - math.exp(-2.0 * math.pi * 100.0 * CONTROL_PERIOD)  # low-pass filter of the speed, 100 Hz
PERIODS = round(elbow.MOTION.period / CONTROL_PERIOD)
ANGLES, SPEEDS = (plan[: PERIODS + 1] for plan in elbow.reference_motion())


@dataclass(frozen=True, eq=False)
class Loops:
    """Closed loops, one entry each."""

    bandwidth: Array  # Hz
    share: Array  # of the LQI's integral gain
    payload: Array  # kg
    friction: Array

    def part(self, rows: slice) -> Loops:
        """Some of the loops."""
        return Loops(self.bandwidth[rows], self.share[rows], self.payload[rows], self.friction[rows])


class Controllers:
    """The controllers of many loops. They believe in the design's payload and friction."""

    def __init__(self, loops: Loops) -> None:
        w = 2.0 * math.pi * loops.bandwidth
        inertia, load = elbow.inertia(elbow.DESIGN_PAYLOAD), elbow.weight(elbow.DESIGN_PAYLOAD)
        self.angle_gain, self.speed_gain = inertia * 2.0 * w**2, inertia * 2.0 * w
        self.integral_gain = inertia * loops.share * w**3 * CONTROL_PERIOD
        self.integral = np.zeros(w.size)  # rad, sum of the errors
        self.measured, self.speed = np.full(w.size, ANGLES[0]), np.zeros(w.size)
        self.due = np.zeros(w.size)  # N.m, for the coming period
        middle = 0.5 * (ANGLES[1:] + ANGLES[:-1])
        edges = np.array([CAM.band(angle) for angle in middle])
        inertial = inertia * np.diff(SPEEDS) / CONTROL_PERIOD - np.array([load.torque(a) for a in middle])
        self.release, self.load = (edges + inertial[:, None]).T  # N.m, feed-forward of both directions

    def torque(self, angle: Array, k: int) -> Array:
        """The torques [N.m] of period k, from the angles one period before."""
        torque, advance = self.due, ANGLES[k + 1] - ANGLES[k]
        measured = COUNT * np.rint(angle / COUNT)
        self.speed += FILTER * ((measured - self.measured) / CONTROL_PERIOD - self.speed)
        self.measured = measured
        error = measured - ANGLES[k]
        feedback = self.angle_gain * error + self.speed_gain * (self.speed - SPEEDS[k])
        feedback += self.integral_gain * self.integral
        if advance != 0.0:
            wanted = (self.load[k] if advance > 0.0 else self.release[k]) - feedback
            self.integral += error
        else:  # the plan rests: push towards the target, and let the cam hold close to it
            wanted = np.where(error < 0.0, self.load[k], self.release[k]) - feedback
            rests = (np.abs(error) < elbow.REST.tolerance) & (np.abs(self.speed) < elbow.REST.speed)
            wanted[rests] = 0.0
            self.integral = np.where(rests, 0.0, self.integral + error)
        limit = AK80_6.peak_torque
        self.due = np.minimum(np.maximum(wanted, -limit), limit)
        self.integral -= np.where(self.due == wanted, 0.0, error)  # at the limit the integral stands still
        return torque


def run_block(loops: Loops, periods: int) -> tuple[Array, Array]:
    """RMS error [rad] and heat of the motor [J] of each loop."""
    count = loops.payload.size
    parameters = elbow.plant_parameters(CAM, elbow.DESIGN_PAYLOAD) | {
        "inertia.shaft": elbow.inertia(loops.payload),
        "cam1.friction": loops.friction,
        "cam2.friction": loops.friction,
        "initial.theta": ANGLES[0],
        "ledger": False,
    }
    controllers, weight = Controllers(loops), elbow.weight(loops.payload)
    motors = MotorBank(AK80_6, count)
    angle, speed = np.full(count, ANGLES[0]), np.zeros(count)
    square, total, state = np.zeros(count), np.zeros(count), np.empty((count, 2))
    tau = np.empty((count, 1))
    with Fleet("forward", count, parameters=parameters) as fleet:
        for k in range(periods):
            motor = motors.run(controllers.torque(angle, k), speed)
            tau[:, 0] = motor.torque + weight.torque(angle_amid(angle, speed, CONTROL_PERIOD))
            angle, speed = fleet.step(tau, CONTROL_PERIOD, state).T.copy()
            square += (angle - ANGLES[k + 1]) ** 2
            total += motor.heat
    return np.sqrt(square / periods), total


def run(loops: Loops, block: int, workers: int, periods: int = PERIODS) -> tuple[Array, Array]:
    """The same of any number of loops, in blocks. Processes: NumPy's calls are so short that threads would
    wait for Python's lock."""
    parts = [loops.part(slice(first, first + block)) for first in range(0, loops.payload.size, block)]
    with ProcessPoolExecutor(workers, multiprocessing.get_context("spawn")) as pool:
        results = pool.map(partial(run_block, periods=periods), parts)
        done = list(track(results, f"{loops.payload.size:,} loops", len(parts), transient=True))
    errors, heats = zip(*done, strict=True)
    return np.concatenate(errors), np.concatenate(heats)


def grid(payloads: Array, frictions: Array) -> Loops:
    """All pairs of bandwidth and share, each with the same payloads and frictions."""
    bandwidth, share = (axis.ravel() for axis in np.meshgrid(BANDWIDTHS, SHARES, indexing="ij"))
    pairs, draws = len(bandwidth), len(payloads)
    return Loops(
        *(np.repeat(gain, draws) for gain in (bandwidth, share)),
        *(np.tile(drawn, pairs) for drawn in (payloads, frictions)),
    )


@dataclass(frozen=True, eq=False)
class Study:
    """Costs [J] over the grid: heat of the motor + ERROR_COST times the integral of the squared error."""

    believed: Array  # payload and friction as the controller believes, shape (bandwidths, shares)
    drawn: Array  # shape (bandwidths, shares, draws)
    seconds: tuple[float, float]  # wall clock and processor time of all drawn loops

    @property
    def high(self) -> Array:
        """95th percentile of the cost [J], shape (bandwidths, shares)."""
        return np.percentile(self.drawn, 95.0, axis=2)

    @property
    def picks(self) -> dict[str, tuple[int, ...]]:
        """Places of the nominal and of the robust gains."""
        maps = {"nominal": self.believed, "robust": self.high}
        return {name: tuple(map(int, np.unravel_index(np.argmin(x), x.shape))) for name, x in maps.items()}


def processor_time() -> float:
    """s, of this process and of those that it has ended."""
    return sum(os.times()[:4])


def study(draws: int = DRAWS, workers: int = 2, seed: int = 1) -> Study:
    """Run all loops of the grid."""
    shape = (len(BANDWIDTHS), len(SHARES))
    random = np.random.default_rng(seed)
    sure = grid(np.array([elbow.DESIGN_PAYLOAD]), np.array([elbow.HELIX.friction[0]]))
    loops = grid(random.uniform(*PAYLOADS, draws), random.uniform(*FRICTIONS, draws))
    duration = CONTROL_PERIOD * PERIODS

    def costs(loops: Loops) -> Array:
        error, heat = run(loops, BLOCK, workers)
        return heat + ERROR_COST * duration * error**2

    believed = costs(sure)
    wall, processor = time.perf_counter(), processor_time()
    drawn = costs(loops)
    seconds = time.perf_counter() - wall, processor_time() - processor
    return Study(believed.reshape(shape), drawn.reshape(*shape, draws), seconds)


def report(result: Study) -> str:
    """Both picks with their costs."""
    wall, processor = result.seconds
    lines = [
        f"{result.drawn.size:,} closed loops of {PERIODS} periods: {wall:.0f} s, processor {processor:.0f} s",
        "gains      bandwidth [Hz]  share  cost as believed [J]  median [J]  95th percentile [J]",
    ]
    for name, (i, j) in result.picks.items():
        lines.append(
            f"{name:10} {BANDWIDTHS[i]:14.1f} {SHARES[j]:6.1f} {result.believed[i, j]:21.1f}"
            f" {np.median(result.drawn[i, j]):11.1f} {result.high[i, j]:20.1f}"
        )
    return "\n".join(lines)


def draw_maps(result: Study, path: Path) -> None:
    """Both maps of the cost, with both picks."""
    figure = Figure(figsize=(6.4, 7.6), layout="constrained")
    titles = "payload and friction as believed", "95th percentile over payload and friction"
    maps = zip(figure.subplots(2, 1), titles, (result.believed, result.high), strict=True)
    for plot, title, cost in maps:
        levels = np.geomspace(cost.min(), min(cost.max(), 20.0 * cost.min()), 15)
        colours = plot.contourf(BANDWIDTHS, SHARES, cost.T, levels, norm="log", extend="max")
        for (name, (i, j)), mark in zip(result.picks.items(), "os", strict=True):
            style = {"color": "white", "mec": "black", "ms": 10, "clip_on": False}
            plot.plot(BANDWIDTHS[i], SHARES[j], mark, label=name, zorder=5, **style)
        plot.set(title=title, xlabel="bandwidth [Hz]", ylabel="share of integral gain", xscale="log")
        plot.set_xticks([2, 5, 10, 20], ["2", "5", "10", "20"])
        plot.set_xticks([], minor=True)
        plot.legend(loc="lower right")
        figure.colorbar(colours, ax=plot, label="cost [J]", format="%.0f")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=110)


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--draws", type=int, default=DRAWS, help=f"payloads and frictions ({DRAWS})")
    parser.add_argument("--workers", type=int, default=2, help="processes (2)")
    parser.add_argument("--picture", type=Path, default=BUILD / "controller_gains.png")
    given = parser.parse_args(arguments)
    result = study(given.draws, given.workers)
    print(report(result))
    draw_maps(result, given.picture)
    print(f"written: {given.picture}")


if __name__ == "__main__":
    main()
