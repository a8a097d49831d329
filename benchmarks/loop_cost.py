"""The cost of a control loop in Python: 10 s at 1 kHz through dualcam.Fmu, and its parts.

    ./build.sh loop

One turn of the loop sets a torque, steps 1 ms, reads angle and speed. It is timed four ways, in turns, and
reported as the median over the rounds with quartiles:

cam                the forward FMU through dualcam.Fmu, as a user has it
null               an FMU that does nothing through dualcam.Fmu: Python, ctypes and the handle
null, bare ctypes  the same calls with arguments laid out in advance and no handle: the least Python can do
null, FMPy         the same calls by FMPy's own methods with lists of values
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from ctypes import c_double, c_uint

from benchmarks.harness import core
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.fmu import Slave
from benchmarks.harness.timing import Block, Ratio, in_turns
from dualcam import Fmu
from dualcam.fmu import Scalar

STEP = 1e-3  # s
TURNS = 10_000
TARGET = 0.5  # s for 10 s
PARAMETERS: dict[str, Scalar] = {"initial.theta": 0.5}
TORQUE = [3.0 + 2.0 * math.sin(2.0 * math.pi * 2.0 * k * STEP) for k in range(TURNS)]  # sticks and slips


def handle_loop(fmu: Fmu, parameters: dict[str, Scalar]) -> Block:
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


def ctypes_loop(slave: Slave) -> Block:
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


def fmpy_loop(slave: Slave) -> Block:
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


def started(slave: Slave) -> Slave:
    slave.initialise()
    return slave


def report_row(name: str, seconds: list[float], whole: list[float]) -> dict[str, str]:
    share = Ratio.of(seconds, whole)
    return {
        "through": name,
        "turns": str(TURNS),
        "seconds": f"{statistics.median(seconds):.5f}",
        "share_of_cam": f"{share.median:.4f}",
        "lower_quartile": f"{share.lower:.4f}",
        "upper_quartile": f"{share.upper:.4f}",
    }


def main() -> int:
    arguments = harness.options(__doc__, "loop_cost", 51).parse_args()
    console = harness.new_console()
    with Fmu(core.fmu_path(core.FORWARD)) as cam, Fmu(core.fmu_path(core.NULL)) as null:
        blocks = {
            "cam": handle_loop(cam, PARAMETERS),
            "null": handle_loop(null, {}),
            "null, bare ctypes": ctypes_loop(started(Slave(core.NULL))),
            "null, FMPy": fmpy_loop(started(Slave(core.NULL))),
        }
        times = in_turns(blocks, arguments.rounds, "loops", console)
        changes = cam.get("events")
    table = harness.table(
        f"{TURNS} turns of {1e3 * STEP:g} ms: set a torque, step, read angle and speed",
        *("through", "s", "us per turn", "share of cam"),
    )
    for name, seconds in times.items():
        median, share = statistics.median(seconds), Ratio.of(seconds, times["cam"])
        table.add_row(name, f"{median:.3f}", f"{1e6 * median / TURNS:.2f}", str(share))
    console.print(table)
    whole = statistics.median(times["cam"])
    target = harness.verdict(whole, TARGET)
    harness.say(
        console, f"The cam changed its mode {changes} times. 10 s take {whole:.3f} s: target {target}."
    )
    rows = [report_row(name, seconds, times["cam"]) for name, seconds in times.items()]
    harness.publish(rows, circumstances("loop"), arguments.output, console)
    return 0 if whole <= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
