"""What a control loop in Python costs: 10 s at 1 kHz through dualcam.Fmu, and where the time goes.

    ./build.sh loop

One turn of the loop sets a torque, steps 1 ms, reads angle and speed. It is timed four ways, in turns as in
benchmarks/step_cost.py, and reported as the median over the rounds with quartiles:

cam                the forward FMU through dualcam.Fmu: what a user has
null               an FMU that does nothing through dualcam.Fmu: Python, ctypes and the handle
null, bare ctypes  the same calls with arguments laid out in advance and no handle: the least Python can do
null, FMPy         the same calls by FMPy's own methods with lists of values
"""

from __future__ import annotations

import argparse
import math
import statistics
import sys
import time
from collections.abc import Callable
from ctypes import c_double, c_uint
from pathlib import Path

from rich.console import Console

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / folder) for folder in (".", "fmu_src", "benchmarks")]
import build_fmu  # noqa: E402
import step_cost  # noqa: E402

from dualcam import Fmu  # noqa: E402
from dualcam.fmu import Scalar  # noqa: E402

STEP = 1e-3  # s
TURNS = 10_000
TARGET = 0.5  # s for 10 s
PARAMETERS: dict[str, Scalar] = {"initial.theta": 0.5}
TORQUE = [3.0 + 2.0 * math.sin(2.0 * math.pi * 2.0 * k * STEP) for k in range(TURNS)]  # sticks and slips


def handle_loop(fmu: Fmu, parameters: dict[str, Scalar]) -> Callable[[], float]:
    command, state = fmu.reals("tau"), fmu.reals("theta", "omega")

    def block() -> float:
        fmu.start(parameters)
        start = time.perf_counter()
        for tau in TORQUE:
            command.values[0] = tau
            command.write()
            fmu.step(STEP)
            _theta, _omega = state.read()
        return time.perf_counter() - start

    return block


def ctypes_loop(slave: step_cost.Slave) -> Callable[[], float]:
    library, component, references = slave.fmu.dll, slave.fmu.component, slave.references
    inputs, outputs = (c_uint * 1)(references["tau"]), (c_uint * 2)(references["theta"], references["omega"])
    command, state = (c_double * 1)(), (c_double * 2)()
    set_real, do_step, get_real = library.fmi2SetReal, library.fmi2DoStep, library.fmi2GetReal

    def block() -> float:
        instant = 0.0
        start = time.perf_counter()
        for tau in TORQUE:
            command[0] = tau
            set_real(component, inputs, 1, command)
            do_step(component, instant, STEP, 1)
            instant += STEP
            get_real(component, outputs, 2, state)
            _theta, _omega = state
        return time.perf_counter() - start

    return block


def fmpy_loop(slave: step_cost.Slave) -> Callable[[], float]:
    fmu, inputs = slave.fmu, [slave.references["tau"]]
    outputs = [slave.references["theta"], slave.references["omega"]]

    def block() -> float:
        instant = 0.0
        start = time.perf_counter()
        for tau in TORQUE:
            fmu.setReal(inputs, [tau])
            fmu.doStep(instant, STEP)
            instant += STEP
            _theta, _omega = fmu.getReal(outputs)
        return time.perf_counter() - start

    return block


def started(slave: step_cost.Slave) -> step_cost.Slave:
    slave.fmu.setupExperiment(startTime=0.0)
    slave.fmu.enterInitializationMode()
    slave.fmu.exitInitializationMode()
    return slave


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--rounds", type=int, default=51)
    parser.add_argument("--output", type=Path, default=ROOT / "benchmarks/results/loop_cost.csv")
    arguments = parser.parse_args()
    console = Console()
    with Fmu(build_fmu.BUILD / "DualCamForward.fmu") as cam, Fmu(build_fmu.BUILD / "NullFmu.fmu") as null:
        blocks = {
            "cam": handle_loop(cam, PARAMETERS),
            "null": handle_loop(null, {}),
            "null, bare ctypes": ctypes_loop(started(step_cost.Slave("NullFmu"))),
            "null, FMPy": fmpy_loop(started(step_cost.Slave("NullFmu"))),
        }
        times = step_cost.in_turns(blocks, arguments.rounds, "loops", console)
        changes = cam.get("events")

    facts = step_cost.circumstances("loop")
    table = step_cost.table(
        f"{TURNS} turns of {1e3 * STEP:g} ms: set a torque, step, read angle and speed",
        "through", "s", "us per turn", "share of cam",
    )  # fmt: skip
    rows = []
    for name, seconds in times.items():
        median, share = statistics.median(seconds), step_cost.Ratio.of(seconds, times["cam"])
        table.add_row(name, f"{median:.3f}", f"{1e6 * median / TURNS:.2f}", str(share))
        numbers = {"seconds": f"{median:.5f}", "share_of_cam": f"{share.median:.4f}"}
        quartiles = {"lower_quartile": f"{share.lower:.4f}", "upper_quartile": f"{share.upper:.4f}"}
        rows.append({"through": name, "turns": str(TURNS), **numbers, **quartiles, **facts})
    console.print(table)
    whole = statistics.median(times["cam"])
    console.print(
        f"The cam changed its mode {changes} times. 10 s take {whole:.3f} s:", highlight=False, end=" "
    )
    console.print(f"target {step_cost.verdict(whole, TARGET)}.", highlight=False)
    step_cost.publish(rows, facts, arguments.output, console)
    return 0 if whole <= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
