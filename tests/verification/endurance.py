"""Memory over many lives of instances, and time, energy and phase over many steps.

    ./build.sh run endurance

Lives: an instance is made, runs, is reset, runs again, saves a state and is freed; 10^6 times in one process.
The resident memory is read after the first tenth and at the end.

Free oscillation: helices without friction under a constant torque. With z = z' theta the motion is
theta(t) = theta_0 + A cos(w t), w = z' sqrt(k / J), here 50 rad/s. After 10^8 steps of 1 ms (27.8 h of
simulated time) the angle and the speed are compared with this formula, worked out with 60 digits. The phase
error is that of the phasor (theta - theta_0, -omega / w). The energy is kinetic plus spring minus the work of
the torque.

Stick-slip: the default mechanism with friction under a torque that repeats after 400 steps. From the second
period on each period is a copy of the one before, so theta at the end of every period is the same number. The
residual of the energy ledger is compared with the work of the torque.
"""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Iterator, Sequence

import mpmath
import numpy as np
from rich.console import Console

from benchmarks.harness import core
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.fmu import Slave
from benchmarks.harness.processes import resident_bytes
from benchmarks.harness.repository import VERIFICATION
from benchmarks.harness.slave import address
from benchmarks.harness.timing import pointer

SOURCE = VERIFICATION / "endurance.c"
STEP = 1e-3  # s
PERIOD = 400  # steps
SAMPLES = 10  # readings of a run
LAST_SUCCESSFUL_TIME = 2  # of fmi2StatusKind
NO_FRICTION = {"cam1.friction": 0.0, "cam2.friction": 0.0, "initial.theta": 0.2}
TORQUE = 4.0  # N.m, of the free oscillation
FUNCTIONS = (
    *("Instantiate", "SetupExperiment", "EnterInitializationMode", "ExitInitializationMode", "Reset"),
    *("FreeInstance", "DoStep", "GetFMUstate", "FreeFMUstate"),
)

Row = dict[str, str]


class LifeStruct(ctypes.Structure):
    """`Life` of endurance.c."""

    _fields_ = [*((name, ctypes.c_void_p) for name in FUNCTIONS), ("guid", ctypes.c_char_p)]


def lives(count: int) -> int:
    """Bytes by which the resident memory grows over the last nine tenths of `count` lives."""
    loops = core.load_loops(SOURCE)
    slave = Slave()
    functions = (address(slave.fmu.dll, f"fmi2{name}") for name in FUNCTIONS)
    life = LifeStruct(*functions, slave.description.guid.encode())
    before = 0
    for part in (count // 10, count - count // 10):
        before = resident_bytes()
        if loops.live(ctypes.byref(life), ctypes.c_size_t(part)) != 0:
            raise SystemExit("endurance: a call of a life was not OK")
    return resident_bytes() - before


def runs(slave: Slave, torque: Sequence[float], steps: int) -> Iterator[int]:
    """Makes the steps in SAMPLES parts, each a number of periods; yields the steps made so far after each."""
    loops = core.load_loops(SOURCE, "repeat")
    struct, torques = slave.struct(), np.array(torque)
    part = steps // SAMPLES // PERIOD * PERIOD
    for first in range(0, part * SAMPLES, part):
        sizes = (ctypes.c_size_t(first), ctypes.c_size_t(part), ctypes.c_double(STEP))
        if loops.repeat(ctypes.byref(struct), *sizes, pointer(torques), ctypes.c_size_t(len(torque))) < 0.0:
            raise SystemExit("endurance: a step failed")
        yield first + part


def time_error(slave: Slave, steps: int) -> float:
    """s, of the time that the FMU has reached; the loop takes each time as a multiple of the step."""
    reached = ctypes.c_double()
    slave.fmu.fmi2GetRealStatus(slave.fmu.component, LAST_SUCCESSFUL_TIME, ctypes.byref(reached))
    return reached.value - steps * STEP


class Oscillation:
    """The free oscillation in closed form."""

    def __init__(self, slave: Slave) -> None:
        one, two = (
            mpmath.mpf(slave.real(f"{cam}.radius")) * mpmath.tan(slave.real(f"{cam}.lead_angle"))
            for cam in ("cam1", "cam2")
        )
        slope = one * two / (one + two)  # z' = dz/dtheta
        self.stiffness = mpmath.mpf(slave.real("spring.stiffness")) * slope**2  # N.m/rad
        self.inertia = mpmath.mpf(slave.real("inertia.shaft"))
        self.w = mpmath.sqrt(self.stiffness / self.inertia)
        self.centre = (TORQUE - slope * mpmath.mpf(slave.real("spring.preload"))) / self.stiffness
        self.amplitude = mpmath.mpf(slave.real("theta")) - self.centre

    def phase_error(self, steps: int, theta: float, omega: float) -> float:
        """rad, of the phasor."""
        exact = self.w * steps * mpmath.mpf(STEP)
        found = mpmath.atan2(-omega / self.w / self.amplitude, (theta - self.centre) / self.amplitude)
        return float(mpmath.fmod(found - exact + mpmath.pi, 2 * mpmath.pi)) - float(mpmath.pi)

    def energy_error(self, theta: float, omega: float) -> float:
        """Relative to the energy of the oscillation."""
        whole = self.stiffness * self.amplitude**2
        return float((self.inertia * omega**2 + self.stiffness * (theta - self.centre) ** 2) / whole - 1)


def oscillation(steps: int) -> list[Row]:
    slave = Slave()
    slave.set(NO_FRICTION)
    slave.initialise()
    rows = []
    with mpmath.workdps(60):
        exact = Oscillation(slave)
        for made in runs(slave, [TORQUE], steps):
            theta, omega = slave.real("theta"), slave.real("omega")
            phase, energy = exact.phase_error(made, theta, omega), exact.energy_error(theta, omega)
            errors = {"time, s": time_error(slave, made), "phase, rad": phase, "energy": energy}
            rows += rows_of("free oscillation", made, errors)
    return rows


def stick_slip(steps: int) -> list[Row]:
    slave = Slave()
    slave.initialise()
    torque = [6.0 + 6.0 * abs(2.0 * k / PERIOD - 1.0) - 6.0 * (k < PERIOD // 4) for k in range(PERIOD)]
    first, rows = None, []
    for made in runs(slave, torque, steps):
        theta = slave.real("theta")
        first = theta if first is None else first
        residual = slave.real("energy.residual") / slave.real("energy.work_in")
        errors = {"time, s": time_error(slave, made), "theta, rad": theta - first}
        errors["mode changes"] = slave.integer("events")
        rows += rows_of("stick-slip", made, errors | {"ledger residual": residual})
    return rows


def rows_of(scene: str, count: int, found: dict[str, float]) -> list[Row]:
    return [{"scene": scene, "count": f"{count}", "what": w, "value": f"{v:.3g}"} for w, v in found.items()]


def report(rows: Sequence[Row], console: Console) -> None:
    """The last reading of each number."""
    table = harness.table("Endurance", "scene", "count", "what", "value")
    last = {(row["scene"], row["what"]): row for row in rows}
    for row in last.values():
        table.add_row(*row.values())
    console.print(table)


def main() -> int:
    parser = harness.options(__doc__, "endurance", folder=VERIFICATION / "results")
    parser.add_argument("--lives", type=int, default=1_000_000, help="of instances (10^6)")
    parser.add_argument("--steps", type=int, default=100_000_000, help="per scene (10^8)")
    arguments = parser.parse_args()
    console = harness.new_console()
    grown = float(lives(arguments.lives))
    rows = rows_of("lives", arguments.lives, {"growth of resident memory, bytes": grown})
    rows += oscillation(arguments.steps) + stick_slip(arguments.steps)
    report(rows, console)
    harness.publish(rows, circumstances("endurance"), arguments.output, console)
    return 0


if __name__ == "__main__":
    sys.exit(main())
