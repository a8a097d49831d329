"""The coupled loop under every master, and its errors."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.progress import track

from benchmarks.coupling.flywheel import Flywheel, expanded
from benchmarks.coupling.monolith import Monolith, Truth
from benchmarks.coupling.scenes import CAM, DURATION, FITTED, GRID, MASTERS, STEP, STEPS, Master, Scene
from benchmarks.harness.timing import Array
from dualcam import Fmu

CHECK_STEP = 10e-6  # s

MEASURES = ("theta RMS", "theta max", "omega RMS", "omega max")
UNITS = ("rad", "rad", "rad/s", "rad/s")


def errors(found: Array, exact: Array) -> Array:
    """As MEASURES."""
    difference = found - exact
    rms, largest = np.sqrt((difference**2).mean(axis=0)), np.abs(difference).max(axis=0)
    return np.array([rms[0], largest[0], rms[1], largest[1]])


@dataclass
class Study:
    """One scene: its truth, the error of the FMU coupled every CHECK_STEP, and the errors of all masters at
    all steps."""

    scene: Scene
    truth: Truth
    agreement: Array
    mode_changes: int  # of the FMU
    errors: dict[tuple[Master, float], Array]
    traces: dict[Master, Array]  # theta and omega at STEP

    def ratio(self, master: Master, step: float) -> Array:
        """Error with held inputs over error of the master, as MEASURES."""
        return np.array(self.errors[Master(0, master.in_turn), step] / self.errors[master, step])

    def convergence(self, master: Master, measure: int = 0, steps: tuple[float, ...] = FITTED) -> float:
        """Order of convergence: slope of the straight line through double logarithms."""
        sizes = [self.errors[master, step][measure] for step in steps]
        return float(np.polyfit(np.log(steps), np.log(sizes), 1)[0])


def study(slave: Fmu, scene: Scene, console: Console, check_step: float = CHECK_STEP) -> Study:
    truth = Monolith(scene).solve()
    fine = run(slave, scene, Master(2), check_step)
    agreement = errors(fine[:: round(GRID / check_step)], truth.motion(GRID))
    made = Study(scene, truth, agreement, int(slave.get("events")), {}, {})
    cases = [(master, step) for master in MASTERS for step in STEPS]
    for master, step in track(cases, scene.name, console=console, transient=True):
        found = run(slave, scene, master, step)
        made.errors[master, step] = errors(found, truth.motion(step))
        if step == STEP:
            made.traces[master] = found
    return made


def worst_ratio(studies: list[Study]) -> float:
    """The least ratio() of second order, both schemes, over all scenes and measures."""
    masters = [master for master in MASTERS if master.order == 2]
    return min(float(made.ratio(master, STEP).min()) for made in studies for master in masters)


def run(slave: Fmu, scene: Scene, master: Master, step: float) -> Array:
    """theta and omega at the communication points."""
    flywheel, order = Flywheel(scene, step), master.order
    count = round(DURATION / step)
    found = np.empty((count + 1, 2))
    start = {"initial.theta": scene.angle, "tau": scene.stiffness * scene.twist, "ledger": False}
    slave.start(CAM | start)
    tau, motion = slave.reals("tau"), slave.reals("theta", "omega")
    found[0] = motion.read()
    for k in range(count):
        known = [found[k].tolist(), *(motion.read_derivatives(i) for i in range(1, order + 1))]
        flywheel.take_inputs(k * step, known)
        torque = flywheel.torque(order)
        flywheel.step()
        if master.in_turn:
            torque = expanded(flywheel.torque(order), -step)
        tau.values[0] = torque[0]
        tau.write()
        for i in range(1, order + 1):
            tau.write_derivatives(i, [torque[i]])
        slave.step(step)
        found[k + 1] = motion.read()
    return found
