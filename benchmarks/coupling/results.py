"""Tables and rows of the coupled loop."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import Console
from rich.table import Table

from benchmarks.coupling.scenes import FITTED, MASTERS, STEP
from benchmarks.coupling.study import CHECK_STEP, MEASURES, UNITS, Study, worst_ratio
from benchmarks.harness import results as harness

TARGET = 50.0  # times closer than with held inputs


def table_of(made: Study) -> Table:
    table = harness.table(
        f"{made.scene.name}: {made.scene.description}",
        "master",
        "theta",
        "max",
        "omega",
        "max",
        "closer",
        "order",
    )
    for master in MASTERS:
        ratio = made.ratio(master, STEP)
        table.add_row(
            f"{master.name} {master.scheme}",
            *(f"{e:.1e}" for e in made.errors[master, STEP]),
            "" if master.order == 0 else f"{ratio.min():.0f}-{ratio.max():.0f}",
            f"{made.convergence(master):.2f}",
        )
    return table


def report(studies: list[Study], console: Console) -> None:
    console.print(
        f"Errors with steps of {1e3 * STEP:g} ms: RMS and largest of theta [rad] and of omega [rad/s]; how"
        f" many times closer than held inputs; order of convergence of the first from {1e3 * FITTED[0]:g} to"
        f" {1e3 * FITTED[-1]:g} ms.\n",
        highlight=False,
        markup=False,
    )
    for made in studies:
        console.print(table_of(made))
        sizes = ", ".join(f"{m} {e:.1e}" for m, e in zip(MEASURES, made.agreement, strict=True))
        changes = f"mode changes {made.mode_changes}, of the truth {len(made.truth.modes) - 1}"
        console.print(f"Coupled every {1e6 * CHECK_STEP:g} us: {sizes}; {changes}.\n", highlight=False)
    least = worst_ratio(studies)
    console.print(
        f"Second order is at least {least:.0f} times closer than held inputs;"
        f" target {TARGET:g}: {'met' if least >= TARGET else 'MISSED'}.\n",
        highlight=False,
    )


def rows_of(made: Study) -> Iterator[dict[str, str]]:
    quantities = [f"{m} [{u}]" for m, u in zip(MEASURES, UNITS, strict=True)]
    ratios = [f"{m}: times closer than held" for m in MEASURES]
    for (master, step), sizes in made.errors.items():
        numbers = zip((*quantities, *ratios), (*sizes, *made.ratio(master, step)), strict=True)
        yield {
            "scene": made.scene.name,
            "what": made.scene.description,
            "master": master.name,
            "way": master.scheme,
            "step [s]": str(step),
            **{name: f"{value:.5g}" for name, value in numbers},
            "order of convergence": f"{made.convergence(master):.3f}",
        }
