"""Tables, CSV file and picture of the candidate integrators."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from rich.table import Table

from benchmarks.harness import results as harness
from benchmarks.integrators.measure import Result
from benchmarks.integrators.methods import methods
from benchmarks.integrators.scenes import Scene
from benchmarks.integrators.structs import COUNTS


def table_of(scene: Scene, results: list[Result], doubt: float) -> Table:
    made = harness.table(
        f"{scene.name}: {scene.description} (reference to {doubt:.0e})",
        *("method", "tol", "steps", "rej", "alpha", "with d", "Newton", "ns", "/(e+s)", "err th", "err om"),
    )
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
    unit = "communication step" if scene.parts > 1 else "run"
    panel.set_xlabel(f"time of a {unit} / (exp + sincos)")
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


def row_of(result: Result) -> dict[str, str]:
    numbers = {
        "ns": result.nanoseconds,
        "ratio_to_exp_sincos": result.ratio,
        "error_theta": result.error[0],
        "error_omega": result.error[1],
        "newton_per_solve": result.iterations,
    }
    return {
        "scene": result.scene,
        "method": result.method,
        "tolerance": f"{result.tolerance:g}",
        **{name: str(getattr(result.outcome, name)) for name in COUNTS},
        **{name: f"{value:.5g}" for name, value in numbers.items()},
    }
