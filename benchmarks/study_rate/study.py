"""The study: nine parameters that vary, torque for half the time, and a block of its runs."""

from __future__ import annotations

import time

from benchmarks.harness import core
from dualcam.fmi.fmu import Array
from dualcam.study import History, Plan, Scenario, Study, Vary
from dualcam.study.run.runner import Runner

RUNS = 4000  # in a timed block
VARY = {
    "cam1.radius": Vary(0.015, 0.03),
    "cam2.radius": Vary(0.015, 0.03),
    "cam1.lead_angle": Vary(0.55, 1.0),
    "cam2.lead_angle": Vary(0.55, 1.0),
    "cam1.friction": Vary(0.05, 0.2),
    "cam2.friction": Vary(0.05, 0.2),
    "spring.preload": Vary(20.0, 100.0),
    "spring.stiffness": Vary(1e4, 8e4, log=True),
    "inertia.shaft": Vary(0.001, 0.02, log=True),
}
RESULTS = (
    "energy.spring@0.2",
    "energy.heat_cam1",
    "energy.heat_cam2",
    "peak.omega",
    "peak.reaction1",
    "efficiency",
)
HALF, TORQUE = 0.2, 8.0  # s, N.m
PIECES = History([0.0, HALF, HALF], [TORQUE, TORQUE, 0.0])
RAMPS = History([0.0, HALF, 2.0 * HALF], [0.0, TORQUE, 0.0])


CURVE = History([0.0, "rise", "rise + fall"], [0.0, "peak", 0.0], "smooth")
OF_THE_CURVE = {"peak": Vary(6.0, 9.0), "rise": Vary(0.1, 0.2), "fall": Vary(0.1, 0.2)}  # N.m, s, s


def smooth_study(runs: int = RUNS) -> Study:
    """The same with a torque along a curve, whose peak and times vary."""
    plan = Plan("sobol", VARY | OF_THE_CURVE, runs, seed=1)
    return Study(core.fmu_path(core.FORWARD), plan, Scenario(2.0 * HALF, {"tau": CURVE}), RESULTS)


def study(identifier: str = core.FORWARD, history: History = PIECES, runs: int = RUNS) -> Study:
    plan = Plan("sobol", VARY, runs, seed=1)
    scenario = Scenario(2.0 * HALF, {"tau": history}, step=HALF)  # the step that the do-nothing FMU asks for
    return Study(core.fmu_path(identifier), plan, scenario, RESULTS)


def seconds_of_runs(runner: Runner, rows: Array) -> float:
    """Seconds per run, of the processor."""
    start = time.process_time()
    made = runner.run(rows)
    seconds = time.process_time() - start
    assert not made.messages, made.messages
    return seconds / len(rows)
