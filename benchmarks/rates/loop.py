"""A control loop in Python: 10 s at 1 kHz. One turn sets a torque, steps 1 ms, reads angle and speed.

cam                the forward FMU through dualcam.Fmu, as a user has it
null               an FMU that does nothing through dualcam.Fmu: Python, ctypes and the handle
null, bare ctypes  the same calls with arguments laid out in advance and no handle: the least Python can do
null, FMPy         the same calls by FMPy's own methods with lists of values
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from ctypes import c_double, c_uint

from rich.console import Console

from benchmarks.harness import core
from benchmarks.harness.fmu import Slave
from benchmarks.harness.timing import Block, in_turns
from benchmarks.rates.measure import MICROSECOND, Group, Limit, Measure
from dualcam import Fmu
from dualcam.fmi.fmu import Scalar

STEP = 1e-3  # s
TURNS = 10_000
PARAMETERS: dict[str, Scalar] = {"initial.theta": 0.5}
TORQUE = [3.0 + 2.0 * math.sin(2.0 * math.pi * 2.0 * k * STEP) for k in range(TURNS)]  # sticks and slips
SUBJECT = f"{TURNS} turns"


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
        return (time.perf_counter() - start) / TURNS

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
        return (time.perf_counter() - start) / TURNS

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
        return (time.perf_counter() - start) / TURNS

    return block


def started(slave: Slave) -> Slave:
    slave.initialise()
    return slave


def take(rounds: int, console: Console) -> Iterator[Group]:
    with Fmu(core.fmu_path(core.FORWARD)) as cam, Fmu(core.fmu_path(core.NULL)) as null:
        blocks = {
            "cam": handle_loop(cam, PARAMETERS),
            "null": handle_loop(null, {}),
            "null, bare ctypes": ctypes_loop(started(Slave(core.NULL))),
            "null, FMPy": fmpy_loop(started(Slave(core.NULL))),
        }
        yield Group(SUBJECT, in_turns(blocks, rounds, "loops", console))


MEASURE = Measure(
    *("loop", "A turn of a control loop in Python", take, 51, "cam"),
    limits=(Limit(SUBJECT, "cam", MICROSECOND, 50.0),),
)
