"""Which keys the pictures of a study have, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from dualcam.study.entries import NUMBER, TEXT, Kind, hint, problems_of_entries
from dualcam.study.plan import Plan
from dualcam.study.readings import Readings

NAMES = TEXT.listed()
BEST = Kind(
    "a list of two of max, min",
    lambda value: NAMES.suits(value) and len(value) == 2 and not set(value) - {"max", "min"},
)
SHARE = Kind("a number above 0, at most 1", lambda value: NUMBER.suits(value) and 0.0 < value <= 1.0)
KINDS = {
    "map": {"x": TEXT, "y": TEXT, "z": TEXT},
    "sobol": {"of": NAMES},
    "pareto": {"x": TEXT, "y": TEXT, "best": BEST, "color": TEXT},
    "parallel": {"axes": NAMES, "color": TEXT, "highlight": SHARE},
}
OPTIONAL = {"title", "highlight", "color", "best"}


def problems_of_plots(
    plots: Sequence[Mapping[str, Any]], plan_kind: str | None, known: Collection[str]
) -> list[str]:
    """What is wrong with the pictures of a study whose columns are known, one text each.

    `plan_kind` None: the kind of the plan is refused."""
    return [problem for plot in plots for problem in _problems_of_plot(plot, plan_kind, known)]


def _problems_of_plot(plot: Mapping[str, Any], plan_kind: str | None, known: Collection[str]) -> list[str]:
    if not isinstance(plot, Mapping):
        return [f"plots with {plot!r}: allowed are tables"]
    kind = plot.get("kind", "")
    if kind not in list(KINDS):
        return [f"plot of kind {kind!r}{hint(kind, KINDS) if isinstance(kind, str) else _ALLOWED}"]
    kinds = {"kind": TEXT, "title": TEXT, **KINDS[kind]}
    found = problems_of_entries(plot, f"plot {kind}", kinds, set(kinds) - OPTIONAL)
    sound = {key: value for key, value in plot.items() if key in kinds and kinds[key].suits(value)}
    found += [
        f"plot {kind}: {name!r} is no column of numbers{hint(name, known)}"
        for name in columns_of(sound)
        if name not in known
    ]
    if kind == "sobol" and plan_kind not in ("indices", None):
        found.append(f"plot sobol needs a plan of kind indices, this one is of kind {plan_kind}")
    return found


_ALLOWED = f": allowed are {', '.join(KINDS)}"


def columns_to_draw(plan: Plan, readings: Readings) -> list[str]:
    """Columns with one number for each run."""
    names = [name for name in plan.names if name not in plan.texts]
    return names + [name for name in readings.columns if name not in readings.series]


def columns_of(plot: Mapping[str, Any]) -> list[str]:
    """The columns that a picture shows."""
    single = [plot[key] for key in ("x", "y", "z", "color") if key in plot]
    lists = [plot[key] for key in ("of", "axes") if NAMES.suits(plot.get(key))]
    return [*single, *(name for each in lists for name in each)]
