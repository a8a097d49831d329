"""Which integrator suits theta'' = alpha(t, theta, omega): work against error, scene by scene.

    .venv/bin/python benchmarks/integrators.py

Builds integrators.c with the compiler of the FMUs, lets every candidate run every scene at tolerances
1e-4 to 1e-12, and compares its end point with a reference that two unrelated methods agree on. Times are
ratios to one exp and one sincos of the machine's libm, measured in the same round and in turns (see
step_cost.py), medians over the rounds. Scenes "1 ms" restart the method at every communication point:
nothing is kept from the step before, and the times are those of one communication step.
"""

from __future__ import annotations

import argparse
import csv
import ctypes
import math
import random
import statistics
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from rich.box import SIMPLE
from rich.console import Console
from rich.progress import track
from rich.table import Table
from scipy.integrate._ivp import dop853_coefficients as dop853
from scipy.integrate._ivp.rk import RK45

ROOT = Path(__file__).resolve().parent.parent
PICTURE = Path(__file__).resolve().parent.parent / "docs" / "integrators.png"
sys.path[:0] = [str(ROOT / "fmu_src"), str(ROOT / "benchmarks")]
import build_fmu  # noqa: E402
import step_cost  # noqa: E402

FOLDER = build_fmu.BUILD / "integrators"
TOLERANCES = [1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12]
PIECE = (0.0, 1.4)  # rad, what one polynomial of the geometry covers
NODES = 7
Long = np.longdouble


# ---- Coefficients -> integrator_tables.h --------------------------------------------------------------


def legendre(degree: int) -> np.ndarray:
    """Power coefficients of the Legendre polynomial on [0, 1], lowest first."""
    powers = range(degree + 1)
    return np.array(
        [(-1) ** (degree + k) * math.comb(degree, k) * math.comb(degree + k, k) for k in powers], dtype=Long
    )


def evaluate(power: np.ndarray, x: Any) -> Any:  # noqa: ANN401
    total = Long(0) * x
    for c in power[::-1]:
        total = total * x + c
    return total


def integral(power: np.ndarray) -> np.ndarray:
    return np.concatenate([[Long(0)], power / np.arange(1, len(power) + 1, dtype=Long)])


def nodes(stages: int, radau: bool) -> np.ndarray:
    """Roots of P_s (Gauss) or of P_s - P_{s-1} (Radau IIA), polished in extended precision."""
    power = legendre(stages)
    if radau:
        power = power - np.append(legendre(stages - 1), Long(0))
    slope = power[1:] * np.arange(1, stages + 1, dtype=Long)
    x = np.sort(np.roots(power[::-1].astype(float)).real).astype(Long)
    for _ in range(6):
        x = x - evaluate(power, x) / evaluate(slope, x)
    if radau:
        x[-1] = Long(1)
    return x


def product_of(roots: Iterable[Long]) -> np.ndarray:
    """Power coefficients of the product of (1 - x / root)."""
    power = np.array([1], dtype=Long)
    for root in roots:
        power = np.append(power, Long(0)) - np.append(Long(0), power) / root
    return power


def lagrange(x: np.ndarray, k: int) -> np.ndarray:
    power = np.array([1], dtype=Long)
    for j, root in enumerate(x):
        if j != k:
            power = (np.append(Long(0), power) - np.append(power, Long(0)) * root) / (x[k] - root)
    return power


def number(value: float) -> str:
    return float(value).hex()


def braces(values: np.ndarray) -> str:
    if values.ndim == 1:
        return "{" + ", ".join(number(v) for v in values) + "}"
    return "{" + ",\n     ".join(braces(row) for row in values) + "}"


def collocation(name: str, stages: int, radau: bool) -> str:
    x = nodes(stages, radau)
    basis = [lagrange(x, k) for k in range(stages)]
    a = np.array([[evaluate(integral(p), xj) for p in basis] for xj in x])
    b = np.array([evaluate(integral(p), Long(1)) for p in basis])
    once = integral(product_of(x))
    grid = np.linspace(0, 1, 2001).astype(Long)
    fields = {
        "c": x,
        "b": b,
        "ba": np.array([sum(b[j] * a[j, k] for j in range(stages)) for k in range(stages)]),
        "start": np.array([p[0] for p in basis]),
        "a": a,
        "aa": np.array(
            [[sum(a[i, j] * a[j, k] for j in range(stages)) for k in range(stages)] for i in range(stages)]
        ),
    }
    lines = [f"    .{key} = {braces(values)}," for key, values in fields.items()]
    lines.append(f"    .omega_error = {number(np.abs(evaluate(once, grid)).max())},")
    lines.append(f"    .theta_error = {number(np.abs(evaluate(integral(once), grid)).max())},")
    return f"static const Collocation {name} = {{\n" + "\n".join(lines) + "\n};\n"


def weighted(row: np.ndarray, name: str) -> str:
    return " + ".join(f"{number(a)} * {name}[{j}]" for j, a in enumerate(row) if a != 0.0)


def explicit(name: str, a: np.ndarray, b: np.ndarray, c: np.ndarray) -> str:
    """Straight-line code for the stages: zeros of the tableau cost nothing."""
    head = "(const Scene *m, const State *y, double h, double w[], double f[])"
    lines = [f"static inline void {name}_stages{head} {{", "    w[0] = y->omega;"]
    for i in range(1, len(b)):
        lines.append(f"    w[{i}] = y->omega + h * ({weighted(a[i, :i], 'f')});")
        at = f"y->theta + h * ({weighted(a[i, :i], 'w')})"
        lines.append(f"    f[{i}] = acceleration(m, y->t + {number(c[i])} * h, {at}, w[{i}]);")
    lines += ["}", f"INLINE double {name}_weigh(const double x[]) {{", f"    return {weighted(b, 'x')};", "}"]
    return "\n".join(lines) + "\n"


def tables() -> str:
    """The header with the coefficients of all methods."""
    rows = f"[{NODES}]"
    made = [
        "/* Written by integrators.py. */",
        f"typedef struct {{ double c{rows}, b{rows}, ba{rows}, start{rows}, a{rows}{rows}, aa{rows}{rows}; "
        "double omega_error, theta_error; } Collocation;",
        explicit("dp5", RK45.A, RK45.B, RK45.C),
        f"static const double DP5_ERROR[7] = {braces(RK45.E)};",
        explicit("dop853", dop853.A[:12, :12], dop853.B, dop853.C[:12]),
        f"static const double DOP853_ERROR3[12] = {braces(dop853.E3[:12])};",
        f"static const double DOP853_ERROR5[12] = {braces(dop853.E5[:12])};",
    ]
    made += [collocation(f"RADAU{s}", s, True) for s in (2, 3, 5, 7)]
    made += [collocation(f"GAUSS{s}", s, False) for s in (3, 5)]
    return "\n".join(made)


# ---- The structures of integrators.c ------------------------------------------------------------------


def doubles(*names: str) -> list[tuple[str, type]]:
    return [(name, ctypes.c_double) for name in names]


class EllipseStruct(ctypes.Structure):
    _fields_ = doubles("start", "rate", "steepness", "height")


class CourseStruct(ctypes.Structure):
    _fields_ = [
        *((name, ctypes.c_double * 13) for name in ("a1", "a2", "z", "gamma")),
        *doubles("middle", "scale"),
    ]


class SceneStruct(ctypes.Structure):
    _fields_ = [
        *doubles("r1", "r2", "mu1", "mu2", "inertia", "mass", "spin", "preload", "k", "k2", "k3"),
        *doubles("c", "q", "b", "tau0", "tau1", "theta", "omega", "span"),
        ("parts", ctypes.c_int),
        ("groove1", EllipseStruct),
        ("groove2", EllipseStruct),
        ("course", CourseStruct),
        *doubles("theta_scale", "omega_scale"),
    ]


COUNTS = ("steps", "rejected", "values", "partials", "solves", "newton", "failed")


class OutcomeStruct(ctypes.Structure):
    _fields_ = [*((name, ctypes.c_long) for name in COUNTS), *doubles("theta", "omega")]


class ControlStruct(ctypes.Structure):
    _fields_ = [
        ("matrix", ctypes.c_int),
        ("linear", ctypes.c_bool),
        ("slaved", ctypes.c_bool),
        *doubles("power", "order"),
    ]


class MethodStruct(ctypes.Structure):
    _fields_ = [("kind", ctypes.c_int), ("stages", ctypes.c_int), ("control", ControlStruct)]


# ---- Scenes and methods -------------------------------------------------------------------------------


def ellipse(radius: float, lead: float, a: float, b: float, curvature: int) -> EllipseStruct:
    start = math.sin(math.atan(a / b * math.tan(lead)))
    return EllipseStruct(start, curvature * radius / a, radius * b / a, curvature * b)


@dataclass
class Scene:
    name: str
    what: str
    parameters: dict[str, float]
    span: float
    stiff: bool = False
    parts: int = 1
    struct: SceneStruct = field(default_factory=SceneStruct)

    def __post_init__(self) -> None:
        r1, r2 = 0.03, 0.025
        given = {"r1": r1, "r2": r2, "mu1": 0.14, "mu2": 0.14, "span": self.span, "parts": self.parts}
        for name, value in {**given, **self.parameters}.items():
            setattr(self.struct, name, value)
        self.struct.groove1 = ellipse(r1, 0.70, 0.15, 0.15, 1)
        self.struct.groove2 = ellipse(r2, 0.85, 0.12, 0.12, -1)


SWING = {"inertia": 0.002, "preload": 100.0, "k": 50000.0, "tau0": 10.0}
FULL = {"mass": 0.3, "spin": 3e-5, "k2": 1e6, "k3": 1e8, "c": 50.0, "q": 20.0, "b": 0.005, "tau1": 50.0}
GENTLE = {"inertia": 0.002, "preload": 10.0, "k": 50.0, "tau0": 0.19, "theta": 0.2, "omega": 1.0, "c": 0.5}
STIFF = {"preload": 20.0, "k": 1000.0, "c": 400.0, "q": 1000.0, "tau0": 0.8, "tau1": 0.3}
RIGID = {"inertia": 0.002, "preload": 100.0, "k": 5e7, "c": 8e4, "tau0": 2.0, "tau1": 1000.0}


def scenes() -> list[Scene]:
    return [
        Scene("1 swing", "elliptical grooves, linear spring, 30 ms swing", SWING, 0.03),
        Scene("2 swing, full", "the same with all nonlinearities and masses", SWING | FULL, 0.03),
        Scene("3 gentle, 1 ms", "slow motion, 1 ms steps", GENTLE, 0.2, parts=200),
        Scene("3b swing, 1 ms", "scene 1 in 1 ms steps", SWING, 0.03, parts=30),
        Scene("3c full, 1 ms", "scene 2 in 1 ms steps", SWING | FULL, 0.03, parts=30),
        Scene("4 stiff", "fast time constant 1e-6 s, from rest", STIFF | {"inertia": 1e-7}, 0.3, True),
        Scene("4b stiff, 1 ms", "scene 4 in 1 ms steps", STIFF | {"inertia": 1e-7}, 0.3, True, 300),
        Scene("5 very stiff", "fast time constant 1e-9 s, from rest", STIFF | {"inertia": 1e-10}, 0.3, True),
        Scene("5b very stiff, 1 ms", "scene 5 in 1 ms steps", STIFF | {"inertia": 1e-10}, 0.3, True, 300),
        Scene("6 near-rigid", "stiff spring, damping ratio 2, from rest", RIGID, 0.1, True),
        Scene("6b near-rigid, 1 ms", "scene 6 in 1 ms steps", RIGID, 0.1, True, 100),
    ]


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


# ---- Running -----------------------------------------------------------------------------------------


def compile_candidates() -> ctypes.CDLL:
    FOLDER.mkdir(parents=True, exist_ok=True)
    (FOLDER / "integrator_tables.h").write_text(tables())
    library = FOLDER / "integrators.so"
    flags = [*build_fmu.TARGET, "-O3", "-fPIC", "-shared", "-fvisibility=hidden", f"-I{FOLDER}"]
    build_fmu.compile_c(build_fmu.ZIG, flags, [ROOT / "benchmarks/integrators.c"], library)
    loaded = ctypes.CDLL(str(library))
    for name in ("seconds_run", "seconds_evaluations", "seconds_plain", "fit_error"):
        getattr(loaded, name).restype = ctypes.c_double
    loaded.scene_size.restype = ctypes.c_size_t
    if loaded.scene_size() != ctypes.sizeof(SceneStruct):
        raise SystemExit("integrators: the structures of integrators.c and integrators.py differ")
    return loaded


class Candidates:
    """The compiled candidates and the unit they are measured in."""

    def __init__(self) -> None:
        self.library = compile_candidates()
        self.block = step_cost.elementary(self.library, "seconds_plain")

    def unit(self) -> float:
        """Seconds of one exp and one sincos. One block after other code has to warm up first."""
        return statistics.median([self.block() for _ in range(7)][2:])

    def prepare(self, scene: Scene) -> None:
        low, high = (ctypes.c_double(x) for x in PIECE)
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


def in_parts(scene: Scene, parts: int) -> SceneStruct:
    struct = SceneStruct.from_buffer_copy(scene.struct)
    struct.parts = parts
    return struct


def reference(candidates: Candidates, scene: Scene) -> tuple[tuple[float, float], float]:
    """(theta, omega) at the end, and how far two unrelated methods are apart, relative to the scales."""
    first = candidates.run(in_parts(scene, 500), radau(7, linear=True), 1e-13)[1]
    if scene.stiff:
        second = candidates.run(in_parts(scene, 1000), gauss(5), 1e-13)[1]
    else:
        second = candidates.run(in_parts(scene, 300), MethodStruct(1), 1e-13)[1]
    if first.failed < 0 or second.failed < 0:
        raise SystemExit(f"{scene.name}: no reference")
    return (first.theta, first.omega), max(errors(scene, second, (first.theta, first.omega)))


def errors(scene: Scene, outcome: OutcomeStruct, exact: tuple[float, float]) -> tuple[float, float]:
    return (
        abs(outcome.theta - exact[0]) / scene.struct.theta_scale,
        abs(outcome.omega - exact[1]) / scene.struct.omega_scale,
    )


@dataclass
class Result:
    scene: str
    method: str
    tolerance: float
    outcome: OutcomeStruct
    error: tuple[float, float]
    nanoseconds: float  # of a run, or of a communication step
    ratio: float  # to one exp and one sincos

    @property
    def good(self) -> bool:
        return self.outcome.failed >= 0 and math.isfinite(max(self.error))

    @property
    def iterations(self) -> float:
        return self.outcome.newton / self.outcome.solves if self.outcome.solves else math.nan


def measure(
    candidates: Candidates, scene: Scene, rounds: int, console: Console
) -> tuple[list[Result], float]:
    exact, doubt = reference(candidates, scene)
    cases: list[tuple[str, MethodStruct, float, int, OutcomeStruct]] = []
    slow: set[str] = set()
    for name, method in methods().items():
        for tolerance in TOLERANCES:
            if name in slow:
                continue
            seconds, outcome = candidates.run(scene.struct, method, tolerance)
            if outcome.failed < 0 and seconds > 0.05:
                slow.add(name)
            cases.append((name, method, tolerance, max(1, int(3e-4 / seconds)), outcome))
    times: list[list[tuple[float, float]]] = [[] for _ in cases]
    order = list(range(len(cases)))
    shuffle = random.Random(3).shuffle
    for _ in track(range(rounds), scene.name, console=console, transient=True):
        shuffle(order)
        for number in order:
            name, method, tolerance, repeats, _ = cases[number]
            if times[number] and sum(s for s, _ in times[number]) > 0.2:
                continue
            unit = candidates.unit()
            times[number].append((candidates.run(scene.struct, method, tolerance, repeats)[0], unit))
    results = []
    for (name, _, tolerance, _, outcome), pairs in zip(cases, times, strict=True):
        seconds = statistics.median(s for s, _ in pairs) / scene.parts
        ratio = statistics.median(s / u for s, u in pairs) / scene.parts
        results.append(
            Result(scene.name, name, tolerance, outcome, errors(scene, outcome, exact), seconds * 1e9, ratio)
        )
    return results, doubt


def table_of(scene: Scene, results: list[Result], doubt: float) -> Table:
    title = f"{scene.name}: {scene.what} (reference to {doubt:.0e})"
    made = Table(title=title, box=SIMPLE, title_justify="left", pad_edge=False)
    counts = ("steps", "rej", "alpha", "with d", "Newton")
    for number, column in enumerate(("method", "tol", *counts, "ns", "/(e+s)", "err th", "err om")):
        made.add_column(column, no_wrap=True, justify="left" if number == 0 else "right")
    for r in results:
        o = r.outcome
        per = scene.parts
        numbers = [f"{count / per:.4g}" for count in (o.steps, o.rejected, o.values, o.partials)]
        fine = [f"{r.iterations:.2f}", f"{r.nanoseconds:.0f}", f"{r.ratio:.3g}"]
        error = [f"{e:.1e}" for e in r.error] if r.good else ["gave up", ""]
        made.add_row(r.method, f"{r.tolerance:.0e}", *numbers, *fine, *error)
    return made


COLOURS = {
    "dp5(4)": "tab:gray",
    "dop853": "black",
    "taylor": "tab:olive",
    "rodas4": "tab:brown",
    "gauss3": "tab:pink",
    "gauss5": "tab:purple",
    "radau2": "tab:cyan",
    "radau3": "tab:green",
    "radau5": "tab:red",
    "radau7": "tab:blue",
}
STYLES = {"": ":", "safe": "-.", "half": "--", "half simple": "-"}


def draw(panel: plt.Axes, scene: Scene, results: list[Result]) -> None:
    for name in methods():
        family, _, variant = name.partition(" ")
        if variant not in STYLES:
            continue
        mine = [r for r in results if r.scene == scene.name and r.method == name and r.good]
        error = [max(*r.error, 1e-16) for r in mine]
        style = STYLES[variant] if family.startswith("radau") else "-"
        panel.loglog(
            [r.ratio for r in mine], error, style, marker="o", ms=3, lw=1.2, color=COLOURS[family], label=name
        )
    panel.set_title(scene.name)
    panel.grid(True, which="major", alpha=0.3)
    what = "communication step" if scene.parts > 1 else "run"
    panel.set_xlabel(f"time of a {what} / (exp + sincos)")
    panel.set_ylabel("error at the end / scale")


def picture(cast: list[Scene], results: list[Result], path: Path) -> None:
    columns = 3
    rows = len(cast) // columns + 1  # one panel is the legend
    figure, axes = plt.subplots(rows, columns, figsize=(6.0 * columns, 4.6 * rows), squeeze=False)
    for panel, scene in zip(axes.flat, cast, strict=False):
        draw(panel, scene, results)
    for panel in axes.flat[len(cast) :]:
        panel.axis("off")
    handles, labels = axes.flat[0].get_legend_handles_labels()
    axes.flat[-1].legend(handles, labels, loc="center", ncol=2)
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def write(path: Path, results: list[Result], facts: dict[str, str]) -> None:
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        counts = [*COUNTS]
        writer.writerow(
            [
                "scene",
                "method",
                "tolerance",
                *counts,
                "ns",
                "ratio_to_exp_sincos",
                "error_theta",
                "error_omega",
                "newton_per_solve",
                *facts,
            ]
        )
        for r in results:
            numbers = [getattr(r.outcome, name) for name in counts]
            fine = [f"{x:.5g}" for x in (r.nanoseconds, r.ratio, *r.error, r.iterations)]
            writer.writerow([r.scene, r.method, f"{r.tolerance:g}", *numbers, *fine, *facts.values()])


def describe_cost(candidates: Candidates, scene: Scene, console: Console) -> None:
    def ratio(block: Callable[[], float]) -> float:
        return statistics.median(block() / candidates.unit() for _ in range(51))

    plain = ratio(lambda: candidates.evaluation(scene.struct, False))
    full = ratio(lambda: candidates.evaluation(scene.struct, True))
    console.print(f"One alpha costs {plain:.2f}, with partial derivatives {full:.2f} (exp + sincos).")


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--rounds", type=int, default=21, help="rounds of blocks (default 21)")
    parser.add_argument("--scene", default="", help="only scenes whose name begins so; writes no files")
    parser.add_argument("--output", type=Path, default=ROOT / "benchmarks/results/integrators.csv")
    arguments = parser.parse_args()
    console = Console()
    candidates = Candidates()
    cast = [s for s in scenes() if s.name.startswith(arguments.scene)]
    results: list[Result] = []
    for scene in cast:
        candidates.prepare(scene)
        mine, doubt = measure(candidates, scene, arguments.rounds, console)
        results += mine
        console.print(table_of(scene, mine, doubt))
    console.print(VARIANTS, highlight=False, markup=False)
    describe_cost(candidates, cast[0], console)
    fit = float(candidates.library.fit_error(ctypes.byref(cast[0].struct)))
    console.print(f"Polynomials of the geometry: relative error {fit:.1e}; Taylor uses the closed form.")
    words = " ".join(["benchmarks/integrators.py", *sys.argv[1:]])
    facts = step_cost.circumstances("") | {"command": words}
    facts["versions"] += f", scipy {version('scipy')}"
    for name, value in facts.items():
        console.print(f"{name}: {value}", highlight=False, markup=False)
    if not arguments.scene:
        arguments.output.parent.mkdir(parents=True, exist_ok=True)
        write(arguments.output, results, facts)
        picture(cast, results, PICTURE)
        console.print(f"written: {arguments.output} and {PICTURE}", highlight=False, markup=False)


if __name__ == "__main__":
    main()
