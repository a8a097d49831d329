"""What one communication step costs: against one exp and one sincos, and against an FMU that does nothing.

    ./build.sh cost

One step is fmi2SetReal(tau), fmi2DoStep(1 ms), fmi2GetReal(theta, omega). Everything is measured in one
process and in turns: every round runs a block of each quantity, in an order that is shuffled anew, so
that a slow moment of the machine hits all alike. What is reported are ratios of blocks of the same
round, as the median over the rounds, with quartiles. Before each block the FMU is set back, untimed, to
the state saved after set-up: all rounds do the same work, and the mode of motion is verified by reading
`mode` and `events` before and after. tau differs from step to step in every scene. Blocks of scenes that
move far in little time are short. "Events" are single steps, each from its own saved state: all those of a
scene in which the mode changes.

The unit is the plain loop of benchmarks/step_cost.c: exp(-x) and sincos(x) of the machine's own libm,
called through pointers, x in [0, 2 pi] from memory, results summed, so that consecutive calls may
overlap. The same with each call waiting for the one before is printed as well; it is the slower of the
two and not used in any ratio. A scene's target is for its step less a step of the FMU that does nothing.

Instructions per step are counted by callgrind over the same blocks (instructions.py). The limit of a scene is
the time of what cannot be left out: the three calls of an FMU that does nothing, and the exponentials or the
evaluations of the acceleration that its step needs at least (Least), at the price that each has by itself: an
evaluation that of integrators.c, which has nothing in common with the FMU's code.
"""

from __future__ import annotations

import argparse
import atexit
import csv
import ctypes
import functools
import math
import platform
import random
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from numpy.typing import NDArray
from rich.box import SIMPLE
from rich.console import Console
from rich.progress import track
from rich.table import Table

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / folder) for folder in ("fmu_src", "benchmarks")]
import build_fmu  # noqa: E402
import instructions  # noqa: E402
import pictures  # noqa: E402
from slave import SlaveStruct, slave_struct  # noqa: E402

STEP = 1e-3  # s
STEPS = 1000  # per block in C
FMPY_STEPS = 200  # per block through FMPy
STUCK_TARGET, SLIP_TARGET, GENERAL_TARGET, FMPY_TARGET = 1.5, 4.0, 25.0, 1.05
TOLERANCE = 1e-9
STICK, LOADING = 1, 2

Array = NDArray[np.float64]
Parameters = dict[str, float | str]


@functools.cache
def unpacked(path: Path) -> str:
    """An FMU is unpacked once, however many instances there are: they run from the same file. Each process
    has its own, since unpacking over a library in use crashes whoever runs it."""
    folder = tempfile.mkdtemp()
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return str(extract(str(path), unzipdir=folder))


class Slave:
    """An instance of one of the FMUs with its variables by name."""

    def __init__(self, identifier: str) -> None:
        folder = unpacked(build_fmu.BUILD / f"{identifier}.fmu")
        self.description = read_model_description(folder)
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.types = {v.name: v.type for v in self.description.modelVariables}
        self.fmu = FMU2Slave(
            guid=self.description.guid,
            unzipDirectory=folder,
            modelIdentifier=identifier,
            instanceName=identifier,
        )
        self.fmu.instantiate()

    def set(self, values: Parameters) -> None:
        for name, value in values.items():
            if self.types[name] == "Real":
                self.fmu.setReal([self.references[name]], [value])
            elif self.types[name] == "String":
                self.fmu.setString([self.references[name]], [str(value)])
            elif self.types[name] == "Integer":
                self.fmu.setInteger([self.references[name]], [int(value)])
            else:
                self.fmu.setBoolean([self.references[name]], [bool(value)])

    def real(self, name: str) -> float:
        return float(self.fmu.getReal([self.references[name]])[0])

    def integer(self, name: str) -> int:
        return int(self.fmu.getInteger([self.references[name]])[0])

    def struct(self) -> SlaveStruct:
        return slave_struct(self.fmu.dll, self.fmu.component, self.references)


@dataclass(frozen=True)
class Least:
    """What a step cannot do without, beside the calls themselves."""

    why: str
    units: int = 0  # one exp and one sincos each
    evaluations: int = 0  # of the acceleration in general grooves with all forces

    def seconds(self, calls: float, unit: float, evaluation: float) -> float:
        return calls + self.units * unit + self.evaluations * evaluation


CALLS = Least("the calls")
KEPT = Least("the calls: of a step size known before, ten multiplications are left")
NEW = Least("the calls, one exp and one sincos", units=1)
PARTED = Least("the calls, exp and sincos for two parts of the step and for the instant between", units=3)
NODES = Least("the calls, the acceleration at the start and three nodes", evaluations=4)
LEAPS = Least(
    "the calls, the acceleration at four points of a leap over, to and from the instant", evaluations=12
)


@dataclass
class Scene:
    """Parameters, the torque of every step given the stick band at the start, and what must be seen."""

    name: str
    what: str
    target: float | None
    parameters: Parameters
    torque: Callable[[float, float], Array]  # (torque_release, torque_load) -> N.m, one per step
    mode: int | None = None  # throughout, without any event; None: events are the point
    lead_in: int = 0  # untimed steps before the state is saved
    steps: Array = field(default_factory=lambda: np.full(STEPS, STEP))
    through_fmpy: bool = True
    apart: bool = False  # only the steps with events, each from its own saved state
    least: Least | None = None


def jitter(low: float, high: float, count: int = STEPS) -> Array:
    return np.random.default_rng(1).uniform(low, high, count)


# Spring as soft and stops as wide as it takes to slip through a whole block: a half swing then lasts
# about 1.7 s. The FMU does the same arithmetic at any stiffness > 0.
SWING: Parameters = {"spring.stiffness": 50.0, "stop.upper": 1000.0, "initial.theta": 1.0}
DAMPED: Parameters = {
    "damper.c_load": 20.0,
    "damper.c_release": 20.0,
    "inertia.follower_mass": 0.3,
    "inertia.follower": 3e-5,
}


def drive(release: float, load: float) -> Array:
    return load * jitter(1.28, 1.32)


def to_and_fro(release: float, load: float) -> Array:
    return 4.0 + 4.0 * np.sin(2.0 * math.pi * 5.0 * STEP * np.arange(STEPS))


def inside_band(release: float, load: float) -> Array:
    return release + (load - release) * jitter(0.1, 0.9)


def straight_scenes() -> list[Scene]:
    """Two helices, linear forces: closed forms."""
    return [
        Scene(
            "stuck",
            "at rest, tau anywhere inside the stick band",
            STUCK_TARGET,
            {"initial.theta": 0.7},
            inside_band,
            STICK,
            least=CALLS,
        ),
        Scene(
            "slip undamped",
            "helices, soft spring, one half swing, tau = 1.30 +- 0.02 T_load",
            SLIP_TARGET,
            SWING,
            drive,
            LOADING,
            lead_in=10,
            least=KEPT,
        ),
        Scene(
            "slip, no ledger",
            "slip undamped with ledger = false",
            SLIP_TARGET,
            {**SWING, "ledger": False},
            drive,
            LOADING,
            lead_in=10,
            least=KEPT,
        ),
        Scene(
            "slip damped",
            "slip undamped, but with follower mass 0.3 kg, its inertia, damper 20 N.s/m",
            SLIP_TARGET,
            {**SWING, **DAMPED},
            drive,
            LOADING,
            lead_in=10,
            least=KEPT,
        ),
        Scene(
            "damped, h varies",
            "slip damped with steps of 0.9 to 1.1 ms: nothing can be kept from the step before",
            None,
            {**SWING, **DAMPED},
            drive,
            LOADING,
            lead_in=10,
            steps=jitter(0.9e-3, 1.1e-3),
            least=NEW,
        ),
        Scene(
            "damped, h = dt",
            "slip damped with h = t[k+1] - t[k], as some masters compute it: its last digits vary",
            None,
            {**SWING, **DAMPED},
            drive,
            LOADING,
            lead_in=10,
            steps=np.diff(np.arange(STEPS + 1) * STEP),
            least=KEPT,
        ),
        Scene(
            "stick-slip",
            "default mechanism, tau = 4 + 4 sin(2 pi 5 t) N.m: sticks, slips both ways, meets the stop",
            None,
            {},
            to_and_fro,
        ),
        Scene(
            "events",
            "the steps of stick-slip in which the mode changes",
            None,
            {},
            to_and_fro,
            through_fmpy=False,
            apart=True,
            least=PARTED,
        ),
    ]


# The general mechanism with the start values of all else: half a swing lasts 40 ms and more.
HALF_SWING = 30  # steps
ELLIPSES: Parameters = {"cam1.profile": 2, "cam2.profile": 2}
START: Parameters = {"initial.theta": 0.7}
CUBIC: Parameters = {"spring.stiffness2": 1e6, "spring.stiffness3": 1e8}
FORCES: Parameters = {
    **CUBIC,
    "damper.c_load": 20.0,
    "damper.c_release": 20.0,
    "damper.q_load": 50.0,
    "damper.q_release": 50.0,
    "inertia.follower_mass": 0.3,
    "inertia.follower": 3e-5,
    "shaft.damping": 0.002,
}
LIGHT: Parameters = {"damper.c_load": 500.0, "damper.c_release": 500.0}
VISCOUS: Parameters = {"inertia.shaft": 0.0, "damper.c_load": 5000.0, "damper.c_release": 5000.0}


def tables() -> Parameters:
    """The elliptical groove of the start values, sampled."""
    path = build_fmu.BUILD / "step_cost" / "ellipse.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    psi = np.linspace(-0.2, 1.6, 37)
    start = math.sqrt(0.5)
    z = 0.05 * (np.sqrt(1.0 - (start - 0.4 * psi) ** 2) - start)
    rows = [f"{p!r},{h!r}" for p, h in zip(psi.tolist(), z.tolist(), strict=True)]
    text = "\n".join(["psi_rad,z_m", *rows]) + "\n"
    if not path.exists() or path.read_text() != text:  # another process may be reading it
        path.write_text(text)
    return {"cam1.profile": 3, "cam2.profile": 3, "cam1.table": str(path), "cam2.table": str(path)}


def push(release: float, load: float) -> Array:
    return load * jitter(1.28, 1.32, HALF_SWING)


def general_scenes() -> list[Scene]:
    """Curved grooves or nonlinear forces: collocation, to the tolerance TOLERANCE."""

    def slipping(name: str, what: str, parameters: Parameters) -> Scene:
        steps = np.full(HALF_SWING, STEP)
        start = START | parameters
        return Scene(
            name, what, GENERAL_TARGET, start, push, LOADING, 3, steps, through_fmpy=False, least=NODES
        )

    def events(name: str, what: str, parameters: Parameters) -> Scene:
        return Scene(name, what, None, parameters, to_and_fro, through_fmpy=False, apart=True, least=LEAPS)

    table = tables()
    return [
        slipping("cubic spring", "helices, spring stiffness with its square and cube", CUBIC),
        slipping(
            "ellipses", "elliptical grooves, all else as it starts, tau = 1.30 +- 0.02 T_load", ELLIPSES
        ),
        slipping("ellipses, no ledger", "ellipses with ledger = false", ELLIPSES | {"ledger": False}),
        slipping(
            "all forces", "ellipses with cubic spring, quadratic damper, masses, losses", ELLIPSES | FORCES
        ),
        slipping("all, no ledger", "all forces with ledger = false", ELLIPSES | FORCES | {"ledger": False}),
        slipping("tables", "the grooves of ellipses, sampled at 37 points", table),
        slipping("tables, all forces", "tables with the forces of all forces", table | FORCES),
        slipping("viscous", "ellipses without inertia, damper 5000 N.s/m", ELLIPSES | VISCOUS),
        slipping("viscous, no ledger", "viscous with ledger = false", ELLIPSES | VISCOUS | {"ledger": False}),
        Scene(
            "ellipses stuck",
            "stuck in elliptical grooves",
            GENERAL_TARGET,
            START | ELLIPSES,
            inside_band,
            STICK,
            through_fmpy=False,
            least=CALLS,
        ),
        Scene(
            "ellipses to and fro",
            "elliptical grooves, tau of stick-slip",
            None,
            ELLIPSES,
            to_and_fro,
            through_fmpy=False,
        ),
        events("ellipses, events", "the steps of ellipses to and fro in which the mode changes", ELLIPSES),
        events("all, events", "the same with all forces", ELLIPSES | FORCES),
        events("tables, events", "the same in tables", table),
        events("viscous, events", "the same without inertia, damper 500 N.s/m", ELLIPSES | VISCOUS | LIGHT),
    ]


class Run:
    """A slave that has been set up, the torques and steps of a block, and how to time one."""

    def __init__(self, loops: ctypes.CDLL, slave: Slave, torque: Array, steps: Array, instant: float) -> None:
        self.loops, self.slave = loops, slave
        self.torque, self.steps, self.instant = np.ascontiguousarray(torque), steps, instant
        self.struct = slave.struct()
        self.state: ctypes.c_void_p | None = None

    def save(self) -> None:
        self.state = self.slave.fmu.getFMUState()

    def restore(self) -> None:
        if self.state is not None:
            self.slave.fmu.setFMUState(self.state)

    def block(self) -> float:
        """Seconds per step of one block in C."""
        self.restore()
        status, total = ctypes.c_int(), ctypes.c_double()
        seconds = self.loops.seconds_steps(
            ctypes.byref(self.struct),
            ctypes.c_double(self.instant),
            pointer(self.steps),
            pointer(self.torque),
            ctypes.c_size_t(len(self.steps)),
            ctypes.byref(status),
            ctypes.byref(total),
        )
        return checked(seconds, status, total) / len(self.steps)

    def job(self) -> instructions.Job:
        """A block of it for instructions.count()."""
        fmu = self.slave.fmu
        return {
            "loop": "seconds_steps",
            "fmu": instructions.fmu_words(fmu),
            "references": self.slave.references,
            "states": [] if self.state is None else [instructions.serialized(fmu, self.state)],
            "instants": instructions.raw([self.instant]),
            "steps": instructions.raw(self.steps),
            "torques": instructions.raw(self.torque[: len(self.steps)]),
        }

    def fmpy_block(self) -> float:
        """Seconds per step of one block through FMPy's own methods."""
        self.restore()
        fmu, inputs = self.slave.fmu, [self.slave.references["tau"]]
        outputs = [self.slave.references["theta"], self.slave.references["omega"]]
        values = [[tau] for tau in self.torque[:FMPY_STEPS].tolist()]
        steps, instant = self.steps[:FMPY_STEPS].tolist(), self.instant
        start = time.perf_counter()
        for value, step in zip(values, steps, strict=True):
            fmu.setReal(inputs, value)
            fmu.doStep(instant, step)
            fmu.getReal(outputs)
            instant += step
        return (time.perf_counter() - start) / FMPY_STEPS


def checked(seconds: float, status: ctypes.c_int, total: ctypes.c_double) -> float:
    if status.value != 0 or not math.isfinite(total.value):
        raise SystemExit(f"step_cost: status {status.value}, sum of outputs {total.value}")
    return float(seconds)


class Apart:
    """The steps of a run in which the mode changes, and the states before them."""

    def __init__(self, run: Run) -> None:
        self.run = run
        slave, fmu = run.slave, run.slave.fmu
        states, instants, torques = [], [], []
        self.events, instant = 0, run.instant
        for tau, step in zip(run.torque.tolist(), run.steps.tolist(), strict=True):
            state, before = fmu.getFMUState(), slave.integer("events")
            slave.set({"tau": tau})
            fmu.doStep(instant, step)
            count = slave.integer("events") - before
            if count > 0:
                self.events += count
                states.append(state.value)
                instants.append(instant)
                torques.append(tau)
            else:
                fmu.freeFMUState(state)
            instant += step
        self.count = len(states)
        if self.count == 0:
            raise SystemExit("step_cost: no mode change at all")
        self.states = (ctypes.c_void_p * self.count)(*states)
        self.instants, self.torques = np.array(instants), np.array(torques)
        self.steps = np.full(self.count, STEP)

    def block(self) -> float:
        """Seconds per step, over all of them."""
        status, total = ctypes.c_int(), ctypes.c_double()
        seconds = self.run.loops.seconds_apart(
            ctypes.byref(self.run.struct),
            self.states,
            pointer(self.instants),
            pointer(self.steps),
            pointer(self.torques),
            ctypes.c_size_t(self.count),
            ctypes.byref(status),
            ctypes.byref(total),
        )
        return checked(seconds, status, total) / self.count

    def job(self) -> instructions.Job:
        """All of them for instructions.count()."""
        fmu = self.run.slave.fmu
        return {
            **self.run.job(),
            "loop": "seconds_apart",
            "states": [instructions.serialized(fmu, ctypes.c_void_p(state)) for state in self.states],
            "instants": instructions.raw(self.instants),
            "steps": instructions.raw(self.steps),
            "torques": instructions.raw(self.torques),
        }


def instructions_per_step(runs: Mapping[str, Run | Apart], console: Console) -> dict[str, float]:
    """By scene; empty where nothing can count them."""
    if not instructions.available():
        console.print(instructions.WITHOUT)
        return {}
    jobs = [run.job() for run in runs.values()]
    counts = instructions.count(library(), jobs)
    lengths = [len(job["torques"]) // 8 for job in jobs]
    return {name: n / length for name, n, length in zip(runs, counts, lengths, strict=True)}


def set_up(scene: Scene, loops: ctypes.CDLL) -> Run:
    """An instance at the start of the timed steps."""
    slave = Slave("DualCamForward")
    slave.set(scene.parameters)
    slave.fmu.setupExperiment(tolerance=TOLERANCE, startTime=0.0)
    slave.fmu.enterInitializationMode()
    torque = scene.torque(slave.real("torque_release"), slave.real("torque_load"))
    slave.set({"tau": float(torque[0])})
    slave.fmu.exitInitializationMode()
    instant = 0.0
    for tau in torque[: scene.lead_in]:
        slave.set({"tau": float(tau)})
        slave.fmu.doStep(instant, STEP)
        instant += STEP
    return Run(loops, slave, torque, scene.steps, instant)


def prepare(scene: Scene, loops: ctypes.CDLL) -> tuple[Run | Apart, float]:
    """Sets the scene up, saves its state, and runs one block to see which modes it goes through.
    Returns what to time and its mode changes per step."""
    run = set_up(scene, loops)
    if scene.apart:
        apart = Apart(run)
        return apart, apart.events / apart.count
    slave = run.slave
    run.save()
    first_mode, first_events = slave.integer("mode"), slave.integer("events")
    run.block()
    events = slave.integer("events") - first_events
    modes = {first_mode, slave.integer("mode")}
    if scene.mode is None and events == 0:
        raise SystemExit(f"{scene.name}: no mode change at all")
    if scene.mode is not None and (events != 0 or modes != {scene.mode}):
        raise SystemExit(f"{scene.name}: modes {modes} and {events} events, not mode {scene.mode} alone")
    return run, events / len(scene.steps)


def pointer(array: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def elementary(loops: ctypes.CDLL, loop: str) -> Callable[[], float]:
    """Seconds for one exp and one sincos of the machine's libm. Looked up by name, they are its newest
    versions, also where an FMU built for an older glibc gets the older ones."""
    libm = ctypes.CDLL("libm.so.6")
    functions = [ctypes.cast(getattr(libm, name), ctypes.c_void_p) for name in ("exp", "sincos")]
    angles = np.random.default_rng(2).uniform(0.0, 2.0 * math.pi, STEPS)

    def block() -> float:
        total = ctypes.c_double()
        seconds = getattr(loops, loop)(
            *functions, pointer(angles), ctypes.c_size_t(STEPS), ctypes.byref(total)
        )
        return float(seconds) / STEPS

    return block


def evaluation() -> Callable[[], float]:
    """Seconds for the acceleration in elliptical grooves with all forces, in integrators.c."""
    import integrators  # which imports this module

    candidates = integrators.Candidates()
    scene = next(scene for scene in integrators.scenes() if scene.name == "2 swing, full")
    candidates.prepare(scene)
    return lambda: candidates.evaluation(scene.struct, with_partials=False)


def library() -> Path:
    return build_fmu.BUILD / "step_cost.so"


def compile_loops() -> ctypes.CDLL:
    flags = [*build_fmu.TARGET, "-O3", "-fPIC", "-shared", "-fvisibility=hidden"]
    build_fmu.compile_c(build_fmu.ZIG, flags, [ROOT / "benchmarks/step_cost.c"], library())
    loops = ctypes.CDLL(str(library()))
    for name in ("seconds_plain", "seconds_dependent", "seconds_steps", "seconds_apart"):
        getattr(loops, name).restype = ctypes.c_double
    return loops


def processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{names[0]}, {len(names)} processors" if names else platform.processor()


def commit() -> str:
    def git(*words: str) -> str:
        return subprocess.run(["git", *words], cwd=ROOT, capture_output=True, text=True).stdout.strip()

    try:
        revision = git("rev-parse", "--short", "HEAD")
        written = (":!benchmarks/results", ":!docs")  # by the benchmarks before this one
        changed = git("status", "--porcelain", "--untracked-files=no", "--", ".", *written)
    except OSError:
        return "unknown"
    return (revision or "none yet") + (" with changes" if changed else "")


def circumstances(command: str) -> dict[str, str]:
    """Of this run of `./build.sh command`."""
    return {
        "command": f"./build.sh {command}" + "".join(f" {word}" for word in sys.argv[1:]),
        "date": time.strftime("%Y-%m-%d"),
        "machine": f"{processor()}, {platform.machine()}, {' '.join(platform.libc_ver())}",
        "versions": f"Python {platform.python_version()}, FMPy {version('fmpy')}, zig {version('ziglang')}",
        "commit": commit(),
    }


@dataclass
class Ratio:
    """Median and quartiles of the ratios of blocks of the same round."""

    median: float
    lower: float
    upper: float

    @classmethod
    def of(cls, above: list[float], below: list[float]) -> Ratio:
        lower, median, upper = statistics.quantiles(
            [a / b for a, b in zip(above, below, strict=True)], n=4, method="inclusive"
        )
        return cls(median, lower, upper)

    def __str__(self) -> str:
        return f"{self.median:.3g} ({self.lower:.3g}-{self.upper:.3g})"


def in_turns(
    blocks: dict[str, Callable[[], float]], rounds: int, what: str, console: Console
) -> dict[str, list[float]]:
    """Times of every block over the rounds, each round in a new order."""
    order = list(blocks)
    shuffle = random.Random(3).shuffle
    times: dict[str, list[float]] = {name: [] for name in blocks}
    for number in track(range(-1, rounds), what, console=console, total=rounds + 1, transient=True):
        shuffle(order)
        for name in order:
            seconds = blocks[name]()
            if number >= 0:  # the first round warms up
                times[name].append(seconds)
    return times


def table(title: str, *columns: str) -> Table:
    made = Table(title=title, box=SIMPLE, title_justify="left", pad_edge=False)
    for number, column in enumerate(columns):
        made.add_column(column, no_wrap=True, justify="left" if number == 0 else "right")
    return made


def verdict(value: float, target: float | None) -> str:
    return "" if target is None else f"{target:g} {'met' if value <= target else 'MISSED'}"


def publish(
    rows: Sequence[Mapping[str, str]],
    facts: Mapping[str, str],
    output: Path,
    console: Console,
    drawn: Path | None = None,
) -> None:
    """Prints the circumstances of a benchmark and writes its rows as CSV. `drawn`: the picture of them."""
    for name, value in facts.items():
        console.print(f"{name}: {value}", highlight=False, markup=False)
    output.parent.mkdir(parents=True, exist_ok=True)
    with output.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    written = f"{output} and {drawn}" if drawn else str(output)
    console.print(f"written: {written}", highlight=False, markup=False)


def picture(rows: Sequence[Mapping[str, str]], facts: Mapping[str, str], path: Path) -> None:
    """A bar per scene, with its limit."""
    shown = [row for row in rows if row["scene"] not in ("dependent", "evaluation")]
    figure, (panel,) = pictures.blank(10.5, 0.31 * len(shown) + 1.6)
    for place, row in enumerate(reversed(shown)):
        nanoseconds = float(row["ns_per_step"])
        own = row["scene"] not in ("exp+sincos", "null")
        panel.barh(place, nanoseconds, 0.62, color=pictures.ACCENT if own else pictures.PALE)
        panel.text(1.08 * nanoseconds, place, f"{nanoseconds:,.0f} ns", va="center", fontsize=8)
        if row["least_ns"]:
            limit = float(row["least_ns"])
            panel.plot([limit, limit], [place - 0.38, place + 0.38], color="black", lw=2.2)
    panel.plot([], [], color="black", lw=2.2, label="limit: what cannot be left out")
    panel.set_yticks(range(len(shown)), [row["scene"] for row in reversed(shown)], fontsize=9)
    panel.set_xscale("log")
    panel.set_xlim(3.0, 3.0 * max(float(row["ns_per_step"]) for row in shown))
    panel.set_ylim(-0.8, len(shown) - 0.2)
    panel.grid(False, axis="y")
    panel.set_xlabel("time of one step [ns]")
    panel.set_title("One step of 1 ms in C: set the torque, step, read angle and speed", fontsize=11)
    panel.legend(loc="upper right", frameon=True, fontsize=9)
    pictures.finish(figure, facts, path)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--rounds", type=int, default=301, help="rounds of blocks in C (default 301)")
    parser.add_argument("--fmpy-rounds", type=int, default=151, help="rounds of blocks through FMPy (151)")
    parser.add_argument(
        "--output", type=Path, default=ROOT / "benchmarks/results/step_cost.csv", help="the CSV file"
    )
    parser.add_argument("--picture", type=Path, default=ROOT / "benchmarks/results/step_cost.png")
    arguments = parser.parse_args()
    console = Console() if sys.stdout.isatty() else Console(width=120)

    loops = compile_loops()
    cast = [*straight_scenes(), *general_scenes()]
    runs = {scene.name: prepare(scene, loops) for scene in cast}
    null = Slave("NullFmu")
    nothing = Run(loops, null, jitter(0.0, 1.0), np.full(STEPS, STEP), 0.0)
    times = in_turns(
        {
            "exp+sincos": elementary(loops, "seconds_plain"),
            "dependent": elementary(loops, "seconds_dependent"),
            "null": nothing.block,
            "evaluation": evaluation(),
            **{name: run.block for name, (run, _) in runs.items()},
        },
        arguments.rounds,
        "in C",
        console,
    )
    fmpy_times = in_turns(
        {
            "null": nothing.fmpy_block,
            **{
                scene.name: run.fmpy_block
                for scene in cast
                if scene.through_fmpy and isinstance(run := runs[scene.name][0], Run)
            },
        },
        arguments.fmpy_rounds,
        "through FMPy",
        console,
    )

    counts = instructions_per_step(
        {"null": nothing} | {name: run for name, (run, _) in runs.items()}, console
    )

    facts = circumstances("cost")
    rows: list[dict[str, str]] = []
    in_c = table(
        "One step in C",
        *("scene", "ns", "/(exp+sincos)", "less null", "target", "/null", "/limit", "instr.", "events"),
    )
    in_fmpy = table("One step through FMPy", "scene", "/null", "target <=")

    def limit(least: Least) -> list[float]:
        return [
            least.seconds(*each)
            for each in zip(times["null"], times["exp+sincos"], times["evaluation"], strict=True)
        ]

    def add(
        name: str,
        what: str,
        target: float | None = None,
        events: float | None = None,
        least: Least | None = None,
    ) -> None:
        unit = Ratio.of(times[name], times["exp+sincos"])
        own = Ratio.of([t - n for t, n in zip(times[name], times["null"], strict=True)], times["exp+sincos"])
        floor = Ratio.of(times[name], times["null"])
        through = Ratio.of(fmpy_times[name], fmpy_times["null"]) if name in fmpy_times else None
        nanoseconds = statistics.median(times[name]) * 1e9
        changes = "" if events is None else f"{events:g}"
        bottom = limit(least) if least else []
        above = f"{Ratio.of(times[name], bottom).median:.4g}" if bottom else ""
        counted = f"{counts[name]:.0f}" if name in counts else ""
        in_c.add_row(
            name,
            f"{nanoseconds:.1f}",
            str(unit),
            f"{own.median:.3g}",
            verdict(own.median, target),
            f"{floor.median:.3g}",
            above,
            counted,
            changes,
        )
        fmpy_target = FMPY_TARGET if events is not None else None
        if through and fmpy_target:
            in_fmpy.add_row(name, str(through), verdict(through.median, fmpy_target))
        rows.append(
            {
                "scene": name,
                "what": what,
                "ns_per_step": f"{nanoseconds:.2f}",
                "ratio_to_exp_sincos": f"{unit.median:.4f}",
                "lower_quartile": f"{unit.lower:.4f}",
                "upper_quartile": f"{unit.upper:.4f}",
                "less_null_fmu": f"{own.median:.4f}",
                "target": "" if target is None else f"{target:g}",
                "share_of_target": "" if target is None else f"{own.median / target:.4f}",
                "ratio_to_null_fmu": f"{floor.median:.4f}",
                "least_ns": f"{1e9 * statistics.median(bottom):.2f}" if bottom else "",
                "ratio_to_least": above,
                "least_is": least.why if least else "",
                "instructions_per_step": counted,
                "events_per_step": changes,
                "fmpy_ratio_to_null_fmu": f"{through.median:.4f}" if through else "",
                "fmpy_lower_quartile": f"{through.lower:.4f}" if through else "",
                "fmpy_upper_quartile": f"{through.upper:.4f}" if through else "",
                "fmpy_target": f"{fmpy_target:g}" if fmpy_target else "",
                **facts,
            }
        )

    add("exp+sincos", "one exp and one sincos, calls independent")
    add("dependent", "one exp and one sincos, each waiting for the one before")
    add("null", "an FMU that does nothing")
    add("evaluation", "the acceleration in elliptical grooves with every force, evaluated once")
    for scene in cast:
        add(scene.name, scene.what, scene.target, runs[scene.name][1], scene.least)
    console.print(
        "Median ratio (quartiles); limit: what cannot be left out; events: mode changes per step",
        in_c,
        in_fmpy,
        sep="\n",
    )
    for scene in cast:
        console.print(f"{scene.name}: {scene.what}", highlight=False, markup=False)
    fmpy_null = statistics.median(fmpy_times["null"]) * 1e6
    console.print(
        f"A step of the null FMU through FMPy takes {fmpy_null:.2f} us.", highlight=False, markup=False
    )
    picture(rows, facts, arguments.picture)
    publish(rows, facts, arguments.output, console, arguments.picture)


if __name__ == "__main__":
    main()
