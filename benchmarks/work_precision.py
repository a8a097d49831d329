"""Run time against error: the FMU beside the ways in which such a mechanism is simulated otherwise.

    ./build.sh precision

Four scenes under torque that is constant in pieces of 0.1 or 1 s. The error is the largest over the ends of
all pieces of the errors in angle, speed and dissipated energy, each relative to its own largest size in the
scene. What has been dissipated is the work done less what is stored, which costs nothing (theta alone gives
the work while the torque is constant). The reference is tests/reference.py (helices: closed form at 60
digits; else DOP853 at 1e-13 with events polished), verified in every run by a second method: for helices its
DOP853, and for all the other code for the equations, plain_cam.py, in SciPy's DOP853 or Radau; last, by the
FMU at tolerance 1e-12.

Every line is one way to simulate, with the settings that trade time for error; a point is one setting:

FMU from C          DualCamForward, stepped by work_precision.c: tolerances 1e-3 to 1e-12, steps 0.1 ms to
                    a whole piece; without its ledger, since no peer keeps one
FMU with ledger     the same with it, and with the energy that it has booked
FMU from FMPy       as the first, by FMPy's methods
SciPy ...           plain_cam.py: one right-hand side per direction, omega = 0 as a terminal event, nothing
                    integrated while it sticks; RK45, DOP853, LSODA, Radau
tanh, ...           the same with sigma = tanh(omega/width) and no events, in the same solvers
CVode on our ME     the model-exchange FMU, FMPy's CVodeSolver, no maximum step, nothing recorded
scikit-sundae       SUNDIALS' CVODE, BDF and Adams, on plain_cam.py as for SciPy
PythonFMU           plain_cam.py and SciPy inside do_step, stepped by work_precision.c, one step per piece
hand-written FMU    hand_written.c, fixed steps of semi-implicit Euler, stepped by work_precision.c

Set-up (load, instantiate, initialise) is timed nowhere. Every setting runs once for its error and, unless
another setting of its line is as exact in half the time, once in every round, the rounds each in a new order;
ratios are those of the same round, reported as medians. At each error level the fastest setting of a line
that meets it counts. Settings that fail or take more than LIMIT seconds are listed. Peers that are not
installed are left out with a message: pip install -e '.[bench]'.
"""

from __future__ import annotations

import argparse
import csv
import ctypes
import importlib.util
import itertools
import json
import math
import shutil
import signal
import statistics
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache, cached_property
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np
from fmpy.fmi2 import FMU2Model
from fmpy.sundials import CVodeSolver
from matplotlib.axes import Axes
from rich.console import Console
from rich.table import Table

ROOT = Path(__file__).resolve().parent.parent
PICTURE = ROOT / "benchmarks" / "results" / "work_precision.png"
sys.path[:0] = [str(ROOT / folder) for folder in ("fmu_src", "benchmarks", "tests")]
import build_fmu  # noqa: E402
import pictures  # noqa: E402
import reference  # type: ignore[import-not-found] # noqa: E402
import step_cost  # noqa: E402
from plain_cam import DEFAULTS, Advance, Array, Failure, Piece, PlainCam, Rates, scipy_advance  # noqa: E402

Points = list[tuple[float, float]]  # theta, omega at the end of every piece
Result = tuple[Points, list[float]]  # and the energy dissipated until then
Run = Callable[[], tuple[float, Result]]  # seconds, result

LIMIT = 1.0  # s for one run
LEVELS = [1e-2, 1e-4, 1e-6, 1e-8, 1e-10]
TOLERANCES = [10.0**-k for k in range(3, 13)]
HEATS = ("heat_cam1", "heat_cam2", "heat_damper", "heat_shaft", "heat_stop")
SCIPY = ("RK45", "DOP853", "LSODA", "Radau")


# ---- Scenes -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scene:
    name: str
    what: str
    parameters: dict[str, Any]
    pieces: tuple[Piece, ...]

    @property
    def exact(self) -> bool:
        return PlainCam(self.parameters).linear

    @property
    def duration(self) -> float:
        return sum(duration for duration, _ in self.pieces)

    @cached_property
    def intervals(self) -> list[reference.Interval]:
        return [reference.Interval(duration, tau) for duration, tau in self.pieces]

    @cached_property
    def truth(self) -> Result:
        solve = reference.simulate_exact if self.exact else reference.simulate
        return of_reference(solve(self.parameters, self.intervals))

    def result(self, points: Points) -> Result:
        """With the energy dissipated until each point: work done less what is stored."""
        cam = PlainCam(self.parameters)
        theta, work, heats = cam.start[0], 0.0, []
        before = cam.stored(*cam.start)
        for (_, tau), point in zip(self.pieces, points, strict=True):
            work += tau * (point[0] - theta)
            theta = point[0]
            heats.append(work - (cam.stored(*point) - before))
        return points, heats

    def errors(self, found: Result) -> tuple[float, float, float]:
        """Largest errors of theta, omega and energy, relative to the largest sizes (1, where that is 0)."""
        pairs = zip(columns(found), columns(self.truth), strict=True)
        theta, omega, heat = (float(np.max(np.abs(a - b)) / (np.max(np.abs(b)) or 1.0)) for a, b in pairs)
        return theta, omega, heat


def columns(result: Result) -> list[np.ndarray]:
    return [*np.array(result[0]).T, np.array(result[1])]


def of_reference(points: Sequence[reference.Point]) -> Result:
    heats = [math.fsum(p.energy[name] for name in HEATS) for p in points]
    return [(p.theta, p.omega) for p in points], heats


def pieces(duration: float, *torques: float) -> tuple[Piece, ...]:
    return tuple((duration, tau) for tau in torques)


def quiet_hold() -> tuple[Piece, ...]:
    """Three moves in 100 s; else torques inside the stick band."""
    torques = [(3.5, 4.5)[k % 2] for k in range(100)]
    torques[0], torques[34], torques[67] = 5.0, 5.6, 3.0
    return pieces(1.0, *torques)


TORQUES = pieces(0.1, 5.0, 3.0, 5.0, 2.5, 4.0, 5.5, 4.5, 2.2, 5.0, 4.0)
STEEPENING = step_cost.ELLIPSES | {
    f"cam{i}.ellipse_{name}": value
    for i in (1, 2)
    for name, value in (("a", 0.08), ("b", 0.08), ("curvature", 1))
}
SLOW = {"initial.theta": 0.6, "inertia.shaft": 0.005}
STIFF = {
    **STEEPENING,
    **step_cost.CUBIC,
    "initial.theta": 0.6,
    "inertia.shaft": 2e-6,
    **dict.fromkeys(("damper.c_load", "damper.c_release"), 2000.0),
    **dict.fromkeys(("damper.q_load", "damper.q_release"), 500.0),
}
SCENES = [
    Scene(
        "helices, stick-slip",
        "helical grooves, J = 0.005 kg.m2, ten torques of 0.1 s: slips both ways, turns, sticks",
        SLOW,
        TORQUES,
    ),
    Scene(
        "ellipses, all forces",
        "elliptical grooves, cubic spring, quadratic damper, masses, shaft damping; ten torques of 0.1 s",
        {**STEEPENING, **step_cost.FORCES, **SLOW},
        pieces(0.1, 8.0, 4.0, 8.0, 3.0, 6.0, 9.0, 6.0, 3.0, 8.0, 5.0),
    ),
    Scene(
        "stiff",
        "elliptical grooves, cubic spring, J = 2e-6 kg.m2, damper 2000 N.s/m: time constants 1e-5 and 0.03 s",
        STIFF,
        pieces(0.1, 8.0, 3.0),
    ),
    Scene(
        "long hold",
        "helical grooves, 100 s: a new torque inside the stick band every second, three moves",
        {"initial.theta": 0.6},
        quiet_hold(),
    ),
]


def verify(scene: Scene) -> list[tuple[str, float]]:
    """The reference by a second method, the peers' equations by tight integration, and the FMU at 1e-12."""
    method, rtol = ("Radau", 1e-12) if scene.name == "stiff" else ("DOP853", 1e-13)
    cam = PlainCam(scene.parameters)
    plain = scene.result(cam.run(scene.pieces, scipy_advance(method, rtol)))
    _, fmu = CFmu(scene, "DualCamForward", full(scene), 1e-12, 1).run()
    found = {f"plain_cam.py, {method} {rtol:g}": plain, "FMU 1e-12": fmu}
    if scene.exact:
        second = of_reference(reference.simulate(scene.parameters, scene.intervals))
        found = {"tests/reference.py, DOP853 1e-13": second} | found
    return [(name, max(scene.errors(result))) for name, result in found.items()]


# ---- FMUs stepped from C ------------------------------------------------------------------------------


class PiecesStruct(ctypes.Structure):
    """`Pieces` of work_precision.c."""

    _fields_ = [
        ("duration", ctypes.c_void_p),
        ("tau", ctypes.c_void_p),
        ("count", ctypes.c_size_t),
        ("steps", ctypes.c_size_t),
        ("read", ctypes.c_void_p),
        ("reads", ctypes.c_size_t),
    ]


@cache
def loops() -> ctypes.CDLL:
    library = build_fmu.BUILD / "work_precision.so"
    flags = [*build_fmu.TARGET, "-O3", "-fPIC", "-shared", "-fvisibility=hidden"]
    build_fmu.compile_c(build_fmu.ZIG, flags, [ROOT / "benchmarks/work_precision.c"], library)
    found = ctypes.CDLL(str(library))
    found.seconds_pieces.restype = ctypes.c_double
    return found


class CFmu:
    """One setting of an FMU in a scene: an initialised instance and how to time a run."""

    def __init__(
        self,
        scene: Scene,
        identifier: str,
        settings: step_cost.Parameters,
        tolerance: float,
        steps: int,
        reads: Sequence[str] | None = None,
    ) -> None:
        """`reads`: what is read at the end of every piece, if not what the errors need."""
        self.scene, self.settings, self.tolerance, self.steps = scene, settings, tolerance, steps
        self.slave = step_cost.Slave(identifier)
        self.struct = self.slave.struct()
        own = identifier == "DualCamForward"
        self.booked = own and bool(settings.get("ledger", True))
        names = ["theta", "omega", *(f"energy.{name}" for name in HEATS if self.booked)]
        names = names if reads is None else list(reads)
        self.references = (ctypes.c_uint * len(names))(*(self.slave.references[name] for name in names))
        self.durations, self.torques = np.array(scene.pieces).T.copy()
        self.points = np.zeros((len(scene.pieces), len(names)))
        self.pieces = PiecesStruct(
            self.durations.ctypes.data,
            self.torques.ctypes.data,
            len(scene.pieces),
            steps,
            ctypes.addressof(self.references),
            len(names),
        )
        self.initialise()
        self.state = self.slave.fmu.getFMUState() if own else None
        self.repeats = 5 if own else 1

    def initialise(self) -> None:
        fmu = self.slave.fmu
        self.slave.set(self.settings)
        fmu.setupExperiment(tolerance=self.tolerance, startTime=0.0)
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()

    def timed(self) -> float:
        """Seconds of one run."""
        if self.state is None:
            self.slave.fmu.reset()
            self.initialise()
        status = ctypes.c_int()
        seconds = loops().seconds_pieces(
            ctypes.byref(self.struct),
            ctypes.byref(self.pieces),
            self.state,
            ctypes.c_size_t(self.repeats),
            step_cost.pointer(self.points),
            ctypes.byref(status),
        )
        if status.value != 0:
            raise Failure(f"status {status.value}")
        return float(seconds)

    def run(self) -> tuple[float, Result]:
        seconds = self.timed()
        points = [(float(theta), float(omega)) for theta, omega in self.points[:, :2]]
        if self.booked:
            return seconds, (points, self.points[:, 2:].sum(axis=1).tolist())
        return seconds, self.scene.result(points)


class FmpyFmu(CFmu):
    """The same, stepped by FMPy's methods."""

    def run(self) -> tuple[float, Result]:
        fmu = self.slave.fmu
        fmu.setFMUState(self.state)
        torque = [self.slave.references["tau"]]
        outputs, reads = list(self.references[:2]), list(self.references)
        found, instant = [], 0.0
        start = time.perf_counter()
        for duration, tau in self.scene.pieces:
            step = duration / self.steps
            for k in range(self.steps):
                fmu.setReal(torque, [tau])
                fmu.doStep(instant + k * step, step)
                fmu.getReal(outputs)
            instant += duration
            found.append(fmu.getReal(reads))
        seconds = time.perf_counter() - start
        return seconds, self.scene.result([(v[0], v[1]) for v in found])


def full(scene: Scene) -> step_cost.Parameters:
    """The scene's parameters for our own FMU."""
    return dict(scene.parameters)


def hand_written(scene: Scene, step: float, threshold: float) -> CFmu:
    settings = {**DEFAULTS, **scene.parameters, "solver.step": step, "solver.threshold": threshold}
    return CFmu(scene, "HandWritten", dict(settings), 1e-9, 1)


def python_fmu(scene: Scene, method: str, tolerance: float) -> CFmu:
    settings: step_cost.Parameters = {"parameters": json.dumps(scene.parameters), "method": method}
    return CFmu(scene, "PythonCam", settings, tolerance, 1)


# ---- SUNDIALS -----------------------------------------------------------------------------------------


class NoInput:
    """Torque is constant while CVode integrates."""

    def apply(self, time: float) -> None:
        pass


class Exchange:
    """Our model-exchange FMU in FMPy's CVode."""

    def __init__(self, scene: Scene, tolerance: float) -> None:
        self.scene, self.tolerance = scene, tolerance
        self.slave = step_cost.Slave("DualCamForward")
        old = self.slave.fmu
        self.model = FMU2Model(
            guid=old.guid, unzipDirectory=old.unzipDirectory, modelIdentifier=old.modelIdentifier
        )
        self.model.instantiate()
        self.slave.fmu = self.model
        self.reads = [self.slave.references[n] for n in ("theta", "omega")]

    def event(self, tau: float | None = None) -> None:
        model = self.model
        model.enterEventMode()
        if tau is not None:
            model.setReal([self.slave.references["tau"]], [tau])
        while model.newDiscreteStates()[0]:
            pass
        model.enterContinuousTimeMode()

    def run(self) -> tuple[float, Result]:
        model, scene = self.model, self.scene
        model.reset()
        self.slave.set(full(scene))
        model.setupExperiment(startTime=0.0)
        model.enterInitializationMode()
        self.slave.set({"tau": scene.pieces[0][1]})
        model.exitInitializationMode()
        while model.newDiscreteStates()[0]:
            pass
        model.enterContinuousTimeMode()
        solver = CVodeSolver(
            nx=self.slave.description.numberOfContinuousStates,
            nz=self.slave.description.numberOfEventIndicators,
            get_x=model.getContinuousStates,
            set_x=model.setContinuousStates,
            get_dx=model.getDerivatives,
            get_z=model.getEventIndicators,
            get_nominals=model.getNominalsOfContinuousStates,
            set_time=model.setTime,
            input=NoInput(),
            startTime=0.0,
            relativeTolerance=self.tolerance,
            maxNumSteps=1_000_000,
        )
        points: Points = []
        instant, until = 0.0, 0.0
        start = time.perf_counter()
        for number, (duration, tau) in enumerate(scene.pieces):
            if number > 0:
                self.event(tau)
                solver.reset(instant)
            until += duration
            while until - instant > 1e-12 * until:
                state_event, _, instant = solver.step(instant, until)
                model.setTime(instant)
                step_event, _ = model.completedIntegratorStep()
                if state_event or step_event:
                    self.event()
                    solver.reset(instant)
            theta, omega = model.getReal(self.reads)
            points.append((theta, omega))
        return time.perf_counter() - start, scene.result(points)


def sundae_advance(method: str, rtol: float) -> Callable[..., tuple[float, float, float]]:
    """As scipy_advance, by scikit-sundae's CVODE."""
    from sksundae.cvode import CVODE

    rates: list[Rates] = []

    def right(t: float, y: Any, yp: Any) -> None:  # noqa: ANN401
        yp[:] = rates[0](t, y)

    solvers = {}
    for sigma in (1, -1):

        def rest(_t: float, y: Sequence[float], events: Any) -> None:  # noqa: ANN401
            events[0] = y[1]

        marked: Any = rest
        marked.terminal, marked.direction = [True], [-sigma]
        options = {"method": method, "rtol": rtol, "atol": rtol, "max_num_steps": 1_000_000}
        solvers[sigma] = CVODE(right, eventsfn=rest, num_events=1, **options)

    def advance(
        moving: Rates, sigma: int, left: float, theta: float, omega: float
    ) -> tuple[float, float, float]:
        rates[:] = [moving]
        solver = solvers[sigma]
        solver.init_step(0.0, np.array([theta, omega]))
        found = solver.step(left, tstop=left)
        if not found.success:
            raise Failure(found.message)
        t, y = float(found.t), np.ravel(found.y)
        if t < left * (1.0 - 1e-12):
            return left - t, float(y[0]), 0.0
        return 0.0, float(y[0]), float(y[1])

    return advance


# ---- Lines --------------------------------------------------------------------------------------------


def timed(scene: Scene, solve: Callable[[PlainCam], Points]) -> Run:
    def run() -> tuple[float, Result]:
        cam = PlainCam(scene.parameters)
        start = time.perf_counter()
        points = solve(cam)
        return time.perf_counter() - start, scene.result(points)

    return run


def installed(package: str) -> bool:
    return importlib.util.find_spec(package) is not None


OURS = "FMU from C"
Line = dict[str, Callable[[], Run]]  # setting -> how to make it ready


def steps_of(scene: Scene) -> dict[str, int]:
    """Steps per piece, by the step's length."""
    duration = scene.pieces[0][0]
    return {f"{1e3 * h:g} ms": round(duration / h) for h in (1e-4, 1e-3, 1e-2, 1e-1, 1.0) if h <= duration}


def own_line(scene: Scene, kind: type[CFmu], ledger: bool = False) -> Line:
    lengths = steps_of(scene)
    if kind is FmpyFmu:
        lengths = {name: steps for name, steps in lengths.items() if steps * len(scene.pieces) <= 10_000}
    longest = min(lengths.values())
    return {
        f"tolerance {tolerance:g}, steps of {name}": lambda t=tolerance, n=steps: (  # type: ignore[misc]
            kind(scene, "DualCamForward", {**scene.parameters, "ledger": ledger}, t, n).run
        )
        for name, steps in lengths.items()
        for tolerance in TOLERANCES
        if steps == longest or tolerance in (1e-3, 1e-6, 1e-9, 1e-12)
    }


def event_line(scene: Scene, method: str) -> Line:
    return {
        f"rtol {rtol:g}": lambda r=rtol: timed(  # type: ignore[misc]
            scene, lambda cam: cam.run(scene.pieces, scipy_advance(method, r))
        )
        for rtol in TOLERANCES
    }


def smooth_line(scene: Scene, method: str) -> Line:
    return {
        f"rtol {rtol:g}, width {width:g}": lambda r=rtol, w=width: timed(  # type: ignore[misc]
            scene, lambda cam: cam.run_regularised(scene.pieces, method, r, w)
        )
        for rtol, width in [(1e-3, 1.0), (1e-3, 0.1), (1e-4, 1e-2), (1e-5, 1e-3), (1e-6, 1e-4), (1e-8, 1e-5)]
    }


def lines_of(scene: Scene, console: Console) -> dict[str, Line]:
    lines: dict[str, Line] = {
        OURS: own_line(scene, CFmu),
        "FMU with ledger": own_line(scene, CFmu, True),
        "FMU from FMPy": own_line(scene, FmpyFmu),
    }
    for method in SCIPY:
        lines[f"SciPy {method}"] = event_line(scene, method)
    for method in SCIPY:
        lines[f"tanh, {method}"] = smooth_line(scene, method)
    lines["CVode on our ME"] = {
        f"tolerance {rtol:g}": lambda r=rtol: Exchange(scene, r).run  # type: ignore[misc]
        for rtol in TOLERANCES
    }
    if installed("sksundae"):
        lines["scikit-sundae"] = {
            f"{method} rtol {rtol:g}": lambda m=method, r=rtol: timed(  # type: ignore[misc]
                scene, lambda cam: cam.run(scene.pieces, sundae_advance(m, r))
            )
            for method in ("BDF", "Adams")
            for rtol in TOLERANCES
        }
    if installed("pythonfmu"):
        build_python_fmu()
        lines["PythonFMU"] = {
            f"{method} rtol {rtol:g}": lambda m=method, r=rtol: python_fmu(scene, m, r).run  # type: ignore[misc]
            for method in ("DOP853", "Radau", "LSODA")
            for rtol in (1e-3, 1e-5, 1e-7, 1e-8, 1e-9, 1e-11)
        }
    missing = [
        p
        for p, module in (("scikit-sundae", "sksundae"), ("pythonfmu", "pythonfmu"))
        if not installed(module)
    ]
    if missing:
        console.print(f"left out, not installed: {', '.join(missing)} (pip install -e '.[bench]')")
    build_hand_written()
    lines["hand-written FMU"] = {
        f"steps of {step:g} s, threshold {factor:g} x step": lambda h=step, f=factor: (  # type: ignore[misc]
            hand_written(scene, h, f * h).run
        )
        for step in (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7)
        for factor in (1.0, 100.0)
        if scene.duration / step < 4e7
    }
    return lines


@cache
def build_hand_written() -> None:
    with build_fmu.locked():
        build_fmu.build(build_fmu.hand_written_fmu(build_fmu.dual_cam("DualCamForward", False)))


@cache
def build_python_fmu() -> None:
    from pythonfmu.builder import FmuBuilder

    folder = build_fmu.BUILD / "python_fmu"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    script = ROOT / "benchmarks/python_fmu/python_cam.py"
    made = FmuBuilder.build_FMU(script, dest=folder, project_files=[ROOT / "benchmarks/plain_cam.py"])
    Path(made).replace(build_fmu.BUILD / "PythonCam.fmu")


# ---- Measuring ----------------------------------------------------------------------------------------


@dataclass
class Setting:
    line: str
    name: str
    run: Run | None
    errors: tuple[float, float, float] = (math.nan, math.nan, math.nan)
    failure: str = ""
    first: float = math.inf  # s, of the run that gave the errors
    times: list[float] = field(default_factory=list)

    @property
    def error(self) -> float:
        return max(self.errors)

    @property
    def time(self) -> float:
        return statistics.median(self.times)

    def beats(self, other: Setting) -> bool:
        """By far: as exact in half the time."""
        return self.line == other.line and self.error <= other.error and self.first < 0.5 * other.first


class TooLong(Exception):
    pass


@contextmanager
def at_most(seconds: float) -> Iterator[None]:
    def stop(_signal: int, _frame: object) -> None:
        raise TooLong

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def try_out(scene: Scene, line: str, name: str, make: Callable[[], Run], limit: float) -> Setting:
    """Runs it once: its error, or how it fails."""
    made = Setting(line, name, None)
    try:
        run = make()
        with at_most(limit):
            made.first, result = run()
        made.errors = scene.errors(result)
        if not math.isfinite(made.error) or made.error > 1.0:
            made.failure = f"wrong: error {made.error:.2g}"
        else:
            made.run = run
    except TooLong:
        made.failure = f"more than {limit:g} s"
    except Exception as problem:  # whatever a solver of somebody else raises is its failure
        made.failure = " ".join(f"{type(problem).__name__}: {problem}".split())[:60]
    return made


@dataclass
class Study:
    scene: Scene
    checks: list[tuple[str, float]]
    settings: list[Setting]

    @property
    def lines(self) -> list[str]:
        return list(dict.fromkeys(s.line for s in self.settings))

    def usable(self, line: str) -> list[Setting]:
        """Those that were timed."""
        return [s for s in self.settings if s.line == line and s.times]

    def best(self, line: str, level: float) -> Setting | None:
        return min((s for s in self.usable(line) if s.error <= level), key=lambda s: s.time, default=None)

    def ratio(self, line: str, level: float) -> step_cost.Ratio | None:
        """How many times as long as our best from C, at this error."""
        ours, peer = self.best(OURS, level), self.best(line, level)
        return step_cost.Ratio.of(peer.times, ours.times) if ours and peer else None


def study(scene: Scene, rounds: int, limit: float, console: Console) -> Study:
    settings = [
        try_out(scene, line, name, make, limit)
        for line, made in lines_of(scene, console).items()
        for name, make in made.items()
    ]

    def block(run: Run) -> Callable[[], float]:
        return lambda: run()[0] / scene.duration

    worth = [s for s in settings if s.run and not any(other.beats(s) for other in settings)]
    blocks = {f"{s.line}, {s.name}": block(s.run) for s in worth if s.run}
    times = step_cost.in_turns(blocks, rounds, scene.name, console)
    for s in settings:
        s.times = times.get(f"{s.line}, {s.name}", [])
    return Study(scene, verify(scene), settings)


# ---- Results ------------------------------------------------------------------------------------------

TARGETS = (("SciPy", 1000.0), ("CVode on our ME", 100.0), ("scikit-sundae", 100.0), ("PythonFMU", 1000.0))
TARGET_LEVEL = 1e-8


def cell(made: Study, line: str, level: float) -> str:
    ratio = made.ratio(line, level)
    if ratio is not None:
        return f"{ratio.median:.3g}"
    return "no" if made.best(line, level) is None else "we: no"


def table_of(made: Study) -> Table:
    table = step_cost.table(
        f"{made.scene.name}: {made.scene.what}",
        "times as long, at error",
        *(f"{level:g}" for level in LEVELS),
        "least error",
        "failed",
    )
    table.add_row(
        "FMU from C, us per simulated s",
        *(f"{1e6 * s.time:.3g}" if (s := made.best(OURS, level)) else "no" for level in LEVELS),
        f"{min(s.error for s in made.usable(OURS)):.1e}",
        str(sum(1 for s in made.settings if s.line == OURS and s.failure)),
    )
    for line in made.lines:
        if line != OURS:
            failed = sum(1 for s in made.settings if s.line == line and s.failure)
            least = min((s.error for s in made.usable(line)), default=math.nan)
            table.add_row(line, *(cell(made, line, level) for level in LEVELS), f"{least:.1e}", str(failed))
    return table


def against(made: Study, prefix: str) -> float | None:
    """The ratio at TARGET_LEVEL of the best line of that name; none where no such line gets there."""
    ratios = [made.ratio(line, TARGET_LEVEL) for line in made.lines if line.startswith(prefix)]
    return min((r.median for r in ratios if r), default=None)


def verdicts(studies: list[Study]) -> list[str]:
    found = []
    for prefix, target in TARGETS:
        for made in studies:
            least = against(made, prefix)
            if not any(line.startswith(prefix) for line in made.lines):
                result = "not measured"
            elif least is None:
                result = "does not get there"
            else:
                result = f"{least:.4g} {'met' if least >= target else 'MISSED'}"
            found.append(f"{prefix}, {made.scene.name}, error {TARGET_LEVEL:g}: >= {target:g}: {result}")
    wins = [
        f"{line} at {level:g} in {made.scene.name} ({1.0 / ratio.median:.2f} times as fast)"
        for made in studies
        for line in made.lines
        for level in LEVELS
        if not line.startswith("FMU")
        if (ratio := made.ratio(line, level)) and ratio.median < 1.0
    ]
    found.append(
        "A peer wins: " + ("; ".join(wins) + " MISSED" if wins else "nowhere, at none of the levels")
    )
    return found


def report(studies: list[Study], console: Console) -> None:
    for made in studies:
        console.print(table_of(made))
        for name, error in made.checks:
            console.print(f"reference against {name}: {error:.1e}", highlight=False, markup=False)
        for s in made.settings:
            if s.failure:
                console.print(f"failed: {s.line}, {s.name}: {s.failure}", highlight=False, markup=False)
        console.print()
    for line in verdicts(studies):
        console.print(line, highlight=False, markup=False, soft_wrap=True)


def write(path: Path, studies: list[Study], facts: dict[str, str]) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(
            [
                *("scene", "line", "setting", "error_theta", "error_omega", "error_energy"),
                *("us_per_simulated_s", "ratio_to_best_fmu_from_c_at_least_as_exact", "failure"),
            ]
        )
        for made in studies:
            for s in made.settings:
                ours = made.best(OURS, s.error) if s.times else None
                ratio = f"{step_cost.Ratio.of(s.times, ours.times).median:.4g}" if ours else ""
                seconds = s.time if s.times else s.first / made.scene.duration
                cost = f"{1e6 * seconds:.4g}" if s.run else ""
                errors = [f"{e:.2e}" if e == e else "" for e in s.errors]
                writer.writerow([made.scene.name, s.line, s.name, *errors, cost, ratio, s.failure])
            for name, error in made.checks:
                writer.writerow([made.scene.name, "reference", name, f"{error:.2e}", "", "", "", "", ""])
        for name, value in facts.items():
            writer.writerow([f"# {name}: {value}"])


STYLES: dict[str, tuple[str, str, str]] = {  # colour, marker, line
    OURS: ("black", "o", "-"),
    "FMU with ledger": ("0.45", "o", "-"),
    "FMU from FMPy": ("0.45", "o", ":"),
    **{f"SciPy {m}": (c, "s", "-") for m, c in zip(SCIPY, ("C0", "C9", "C2", "C4"), strict=True)},
    **{f"tanh, {m}": (c, "x", ":") for m, c in zip(SCIPY, ("C0", "C9", "C2", "C4"), strict=True)},
    "CVode on our ME": ("C3", "D", "-"),
    "scikit-sundae": ("C1", "v", "-"),
    "PythonFMU": ("C5", "P", "-"),
    "hand-written FMU": ("C6", "^", "--"),
}


def front(settings: list[Setting]) -> list[Setting]:
    """Those that are clearly more exact than all that are faster."""
    kept: list[Setting] = []
    for s in sorted(settings, key=lambda s: (s.time, s.error)):
        if not kept or s.error < 0.8 * kept[-1].error:
            kept.append(s)
    return kept


def draw(panel: Axes, made: Study) -> None:
    for line in made.lines:
        colour, marker, style = STYLES[line]
        best = front(made.usable(line))
        panel.loglog(
            [max(s.error, 1e-16) for s in best],
            [s.time for s in best],
            style,
            marker=marker,
            ms=8 if line == OURS else 5,
            lw=2.6 if line == OURS else 1.1,
            color=colour,
            label=line,
        )
        if line == OURS:  # what it takes for any larger error as well
            panel.loglog([1.0, best[0].error], [best[0].time] * 2, "--", color=colour, lw=1.0)
    panel.set_title(made.scene.name, fontsize=11)
    panel.set_xlim(1.0, 1e-16)
    panel.grid(True, which="major", alpha=0.3)


def picture(studies: list[Study], facts: dict[str, str], path: Path) -> None:
    figure = pictures.sheet(13.0, 10.0)
    axes = figure.subplots(2, 2, sharex=True)
    for panel, made in zip(axes.flat, studies, strict=True):
        draw(panel, made)
    for panel in axes[:, 0]:
        panel.set_ylabel("run time per simulated second [s]")
    for panel in axes[1]:
        panel.set_xlabel("largest error of angle, speed and energy, relative")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncol=5, fontsize=10)
    figure.suptitle(
        "Run time against error: each line's best settings, lower and further right is better", fontsize=13
    )
    pictures.finish(figure, facts, path)


def versions() -> str:
    found = []
    for package in ("numpy", "scipy", "scikit-sundae", "pythonfmu"):
        try:
            found.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            found.append(f"no {package}")
    return ", ".join(found)


# ---- what the peers' time is made of ------------------------------------------------------------------


class Counted:
    """Equations of motion that know how often they have been evaluated."""

    def __init__(self, advance: Advance) -> None:
        self.inner, self.calls = advance, 0

    def advance(
        self, rates: Rates, sigma: int, left: float, theta: float, omega: float
    ) -> tuple[float, float, float]:
        def counting(t: float, y: Array) -> tuple[float, float]:
            self.calls += 1
            return rates(t, y)

        return self.inner(counting, sigma, left, theta, omega)


def evaluations(scene: Scene, level: float) -> dict[str, str]:
    """How often SciPy's fastest setting with at most that error evaluates the right-hand side, and how long
    that takes."""
    duration = sum(interval.duration for interval in scene.intervals)
    best: dict[str, str] = {}
    least: float = math.inf
    for method, rtol in itertools.product(("DOP853", "LSODA"), TOLERANCES):
        run = event_line(scene, method)[f"rtol {rtol:g}"]()
        seconds, found = run()
        if seconds >= least or max(scene.errors(found)) > level:
            continue
        least = seconds
        cam = Counted(scipy_advance(method, rtol))
        PlainCam(scene.parameters).run(scene.pieces, cam.advance)
        best = {
            "scene": scene.name,
            "line": f"SciPy {method}",
            "setting": f"rtol {rtol:g}",
            "us_per_simulated_s": f"{1e6 * seconds / duration:.4g}",
            "evaluations_per_simulated_s": f"{cam.calls / duration:.4g}",
            "us_per_evaluation": f"{1e6 * seconds / cam.calls:.3g}",
        }
    return best


def circumstances(command: str) -> dict[str, str]:
    facts = step_cost.circumstances(command)
    facts["versions"] += f", {versions()}"
    return facts


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--rounds", type=int, default=5, help="rounds in which every setting runs once (5)")
    parser.add_argument("--limit", type=float, default=LIMIT, help=f"s, for one run ({LIMIT:g})")
    parser.add_argument("--only", help="scenes whose name contains this; nothing is written")
    parser.add_argument("--evaluations", action="store_true", help="only count SciPy's evaluations")
    parser.add_argument("--output", type=Path, default=ROOT / "benchmarks/results/work_precision.csv")
    parser.add_argument("--picture", type=Path, default=PICTURE)
    arguments = parser.parse_args()
    console = Console() if sys.stdout.isatty() else Console(width=120)
    chosen = [scene for scene in SCENES if (arguments.only or "") in scene.name]
    facts = circumstances("precision")
    if not arguments.only:
        rows = [{**evaluations(scene, TARGET_LEVEL), **facts} for scene in chosen]
        step_cost.publish(rows, facts, arguments.output.with_name("evaluations.csv"), console)
    if arguments.evaluations:
        return 0
    studies = [study(scene, arguments.rounds, arguments.limit, console) for scene in chosen]
    report(studies, console)
    for name, value in facts.items():
        console.print(f"{name}: {value}", highlight=False, markup=False)
    if arguments.only:
        return 0
    write(arguments.output, studies, facts)
    picture(studies, facts, arguments.picture)
    console.print(f"written: {arguments.output} and {arguments.picture}", highlight=False, markup=False)
    return 1 if any(line.endswith("MISSED") for line in verdicts(studies)) else 0


if __name__ == "__main__":
    sys.exit(main())
