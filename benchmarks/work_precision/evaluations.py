"""Number and time of the evaluations of the right-hand side in SciPy."""

from __future__ import annotations

import itertools
import math

from benchmarks.work_precision.lines import TOLERANCES, event_line
from benchmarks.work_precision.plain_cam import Advance, Array, PlainCam, Rates, scipy_advance
from benchmarks.work_precision.scenes import Scene


class Counted:
    """An `advance` that counts the evaluations of the right-hand side."""

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
    """Number and time of the evaluations of the right-hand side by SciPy's fastest setting with at most that
    error."""
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
            "us_per_simulated_s": f"{1e6 * seconds / scene.duration:.4g}",
            "evaluations_per_simulated_s": f"{cam.calls / scene.duration:.4g}",
            "us_per_evaluation": f"{1e6 * seconds / cam.calls:.3g}",
        }
    return best
