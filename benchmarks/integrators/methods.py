"""The candidate integrators: methods with their variants, and how to run them in C."""

from __future__ import annotations

import ctypes
import statistics

from benchmarks.harness import core
from benchmarks.harness.timing import unit_block
from benchmarks.integrators.scenes import Scene
from benchmarks.integrators.structs import ControlStruct, MethodStruct, OutcomeStruct, SceneStruct
from benchmarks.integrators.tables import tables

FOLDER = core.BUILD / "integrators"
FITTED = (0.0, 1.4)  # rad, the range of theta in which the polynomials of the transmission are fitted


def radau(
    stages: int, power: float = 1.0, matrix: int = 0, linear: bool = False, slaved: bool = False
) -> MethodStruct:
    return MethodStruct(4, stages, ControlStruct(matrix, linear, slaved, power, power * (stages + 1)))


def gauss(stages: int) -> MethodStruct:
    return MethodStruct(5, stages, ControlStruct(0, False, False, 1.0, stages + 1.0))


def end_power(stages: int) -> float:
    """Local error of the interior ~ h^(s+1), of the end ~ h^(2s)."""
    return 2.0 * stages / (stages + 1.0)


VARIANTS = """\
radau, gauss: full Newton from the tangent; error from the defect at the start, divided by 1 + stiffness
safe: linearised predictor when stiff; theta also estimated from the defect in omega
half, end: safe, with (error)^power controlled, power half way to or at that of superconvergence
chord, simple: derivatives and LU of the first iteration, or of the start of the step, kept"""


def methods() -> dict[str, MethodStruct]:
    made = {
        "dp5(4)": MethodStruct(0),
        "dop853": MethodStruct(1),
        "taylor": MethodStruct(2),
        "rodas4": MethodStruct(3),
    }
    made |= {f"gauss{s}": gauss(s) for s in (3, 5)}
    made |= {f"radau{s}": radau(s) for s in (2, 3, 5, 7)}
    for s in (3, 5, 7):
        half = 0.5 * (1.0 + end_power(s))
        made[f"radau{s} safe"] = radau(s, linear=True, slaved=True)
        made[f"radau{s} half"] = radau(s, half, linear=True, slaved=True)
        made[f"radau{s} half chord"] = radau(s, half, 1, linear=True, slaved=True)
        made[f"radau{s} half simple"] = radau(s, half, 2, linear=True, slaved=True)
        made[f"radau{s} end"] = radau(s, end_power(s), linear=True, slaved=True)
    return made


def load_candidates() -> ctypes.CDLL:
    """Compiles integrators.c with the compiler of the FMUs. SystemExit if Python lays its structure out
    otherwise."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    (FOLDER / "integrator_tables.h").write_text(tables())
    flags = (*core.OPTIMISED, f"-I{FOLDER}")
    timed = ("seconds_run", "seconds_evaluations", "seconds_plain", "fit_error")
    loaded = core.load_loops("integrators/integrators.c", *timed, flags=flags)
    loaded.scene_size.restype = ctypes.c_size_t
    if loaded.scene_size() != ctypes.sizeof(SceneStruct):
        raise SystemExit("integrators: the structures of integrators.c and structs.py differ")
    return loaded


class Candidates:
    """The compiled candidates and the unit they are measured in."""

    def __init__(self) -> None:
        self.library = load_candidates()
        self.block = unit_block(self.library, "seconds_plain")

    def unit(self) -> float:
        """Seconds of one exp and one sincos, by the loop after two blocks that warm up."""
        return statistics.median([self.block() for _ in range(7)][2:])

    def prepare(self, scene: Scene) -> None:
        """Fits the transmission and finds the scales of theta and omega."""
        low, high = (ctypes.c_double(x) for x in FITTED)
        self.library.prepare(ctypes.byref(scene.struct), low, high, ctypes.byref(radau(5, linear=True)))

    def run(
        self,
        scene: SceneStruct,
        method: MethodStruct,
        tolerance: float,
        repeats: int = 1,
        limit: int = 400000,
    ) -> tuple[float, OutcomeStruct]:
        """Seconds of one run of the scene, and how it ended."""
        outcome = OutcomeStruct()
        seconds = self.library.seconds_run(
            ctypes.byref(scene),
            ctypes.byref(method),
            ctypes.c_double(tolerance),
            ctypes.c_long(limit),
            ctypes.c_int(repeats),
            ctypes.byref(outcome),
        )
        return float(seconds) / repeats, outcome

    def evaluation(self, scene: SceneStruct, with_partials: bool) -> float:
        """Seconds of one evaluation of alpha."""
        total, count = ctypes.c_double(), 5000
        seconds = self.library.seconds_evaluations(
            ctypes.byref(scene), ctypes.c_bool(with_partials), ctypes.c_int(count), ctypes.byref(total)
        )
        return float(seconds) / count
