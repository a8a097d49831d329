"""Which keys the pictures of a study have, and what is wrong with them."""

from collections.abc import Mapping, Sequence
from typing import Any

from dualcam.common.entries import NUMBER, TEXT, Kind, hint, problems_of_entries
from dualcam.study.plan.plan import Plan
from dualcam.study.run.readings import Readings

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


def problems_of_keys(plots: Sequence[Any]) -> list[str]:
    """What is wrong with the keys of pictures, one text each."""
    found = []
    for plot in plots:
        kind = plot.get("kind", "") if isinstance(plot, Mapping) else None
        if kind is None:
            found.append(f"plots with {plot!r}: allowed are tables")
        elif not isinstance(kind, str) or kind not in KINDS:
            found.append(f"plot of kind {kind!r}{hint(str(kind), KINDS)}")
        else:
            kinds = {"kind": TEXT, "title": TEXT, **KINDS[kind]}
            found += problems_of_entries(plot, f"plot {kind}", kinds, set(kinds) - OPTIONAL)
    return found


def problems_of_columns(plots: Sequence[Mapping[str, Any]], plan: Plan, readings: Readings) -> list[str]:
    """What is wrong with the columns of pictures whose keys are sound, one text each."""
    known = [name for name in plan.names if name not in plan.texts]  # columns with one number for each run
    known += [name for name in readings.columns if name not in readings.series]
    found = [
        f"plot {plot['kind']}: {name!r} is no column of numbers{hint(name, known)}"
        for plot in plots
        for name in columns_of(plot)
        if name not in known
    ]
    if plan.kind != "indices" and any(plot["kind"] == "sobol" for plot in plots):
        found.append(f"plot sobol needs a plan of kind indices, this one is of kind {plan.kind}")
    return found


def columns_of(plot: Mapping[str, Any]) -> list[str]:
    """The columns that a picture shows."""
    single = [plot[key] for key in ("x", "y", "z", "color") if key in plot]
    lists = [plot[key] for key in ("of", "axes") if key in plot]
    return [*single, *(name for each in lists for name in each)]
