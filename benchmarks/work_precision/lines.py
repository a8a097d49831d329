"""The lines of the comparison: every way to simulate with its settings."""

from __future__ import annotations

import importlib.util
import time
from collections.abc import Callable

from rich.console import Console

from benchmarks.harness import core
from benchmarks.work_precision.fmus import CFmu, FmpyFmu, build_python_fmu, hand_written, python_fmu
from benchmarks.work_precision.plain_cam import PlainCam, scipy_advance
from benchmarks.work_precision.scenes import Points, Result, Scene
from benchmarks.work_precision.sundials import Exchange, sundae_advance

Run = Callable[[], tuple[float, Result]]  # seconds, result
Line = dict[str, Callable[[], Run]]  # setting -> how to make it ready

OURS = "FMU from C"
TOLERANCES = [10.0**-k for k in range(3, 13)]
SCIPY = ("RK45", "DOP853", "LSODA", "Radau")
OPTIONAL = {"scikit-sundae": "sksundae", "pythonfmu": "pythonfmu"}  # package -> its module


def timed(scene: Scene, solve: Callable[[PlainCam], Points]) -> Run:
    def run() -> tuple[float, Result]:
        cam = PlainCam(scene.parameters)
        start = time.perf_counter()
        points = solve(cam)
        return time.perf_counter() - start, scene.result(points)

    return run


def installed(package: str) -> bool:
    return importlib.util.find_spec(package) is not None


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
            kind(scene, core.FORWARD, {**scene.parameters, "ledger": ledger}, t, n).run
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


def exchange_line(scene: Scene) -> Line:
    return {
        f"tolerance {rtol:g}": lambda r=rtol: Exchange(scene, r).run  # type: ignore[misc]
        for rtol in TOLERANCES
    }


def sundae_line(scene: Scene) -> Line:
    return {
        f"{method} rtol {rtol:g}": lambda m=method, r=rtol: timed(  # type: ignore[misc]
            scene, lambda cam: cam.run(scene.pieces, sundae_advance(m, r))
        )
        for method in ("BDF", "Adams")
        for rtol in TOLERANCES
    }


def python_fmu_line(scene: Scene) -> Line:
    build_python_fmu()
    return {
        f"{method} rtol {rtol:g}": lambda m=method, r=rtol: python_fmu(scene, m, r).run  # type: ignore[misc]
        for method in ("DOP853", "Radau", "LSODA")
        for rtol in (1e-3, 1e-5, 1e-7, 1e-8, 1e-9, 1e-11)
    }


def hand_written_line(scene: Scene) -> Line:
    core.build_hand_written_fmu()
    return {
        f"steps of {step:g} s, threshold {factor:g} x step": lambda h=step, f=factor: (  # type: ignore[misc]
            hand_written(scene, h, f * h).run
        )
        for step in (1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7)
        for factor in (1.0, 100.0)
        if scene.duration / step < 4e7
    }


def lines_of(scene: Scene, console: Console) -> dict[str, Line]:
    """All lines. A line whose package is not installed is left out, with a message."""
    lines: dict[str, Line] = {
        OURS: own_line(scene, CFmu),
        "FMU with ledger": own_line(scene, CFmu, True),
        "FMU from FMPy": own_line(scene, FmpyFmu),
        **{f"SciPy {method}": event_line(scene, method) for method in SCIPY},
        **{f"tanh, {method}": smooth_line(scene, method) for method in SCIPY},
        "CVode on our ME": exchange_line(scene),
    }
    if installed("sksundae"):
        lines["scikit-sundae"] = sundae_line(scene)
    if installed("pythonfmu"):
        lines["PythonFMU"] = python_fmu_line(scene)
    missing = [package for package, module in OPTIONAL.items() if not installed(module)]
    if missing:
        console.print(f"left out, not installed: {', '.join(missing)} (pip install -e '.[bench]')")
    lines["hand-written FMU"] = hand_written_line(scene)
    return lines
