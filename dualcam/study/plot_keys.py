"""Which keys the pictures of a study have, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from dualcam.study.entries import NUMBER, TEXT, Kind, entries, hint
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError
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
    plots: Sequence[Mapping[str, Any]], plan_kind: str, known: Collection[str]
) -> list[str]:
    """What is wrong with the pictures of a study whose columns are known, one text each."""
    found = []
    for plot in plots:
        kind = plot.get("kind", "")
        if kind not in list(KINDS):
            found.append(f"plot of kind {kind!r}{hint(kind, KINDS) if isinstance(kind, str) else _ALLOWED}")
            continue
        kinds = {"kind": TEXT, "title": TEXT, **KINDS[kind]}
        try:
            entries(plot, f"plot {kind}", kinds, set(kinds) - OPTIONAL)
        except StudyError as error:
            found.append(str(error))
            continue
        found += [
            f"plot {kind}: {name!r} is no column of numbers{hint(name, known)}"
            for name in columns_of(plot)
            if name not in known
        ]
        if kind == "sobol" and plan_kind != "indices":
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
    return [*single, *plot.get("of", []), *plot.get("axes", [])]
