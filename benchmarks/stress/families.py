"""The rows of the table by their short names."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator

from benchmarks.stress import forces, grooves, motions
from benchmarks.stress.at_random import fuzz
from benchmarks.stress.mechanisms import Tables
from benchmarks.stress.scene import Scene

FAMILIES: dict[str, Callable[[Tables], Iterator[Scene]]] = {
    "stiffness": forces.stiffness,
    "inertia": forces.inertia,
    "friction": forces.friction,
    "lead": grooves.lead_angles,
    "ellipse": grooves.slopes_of_ellipses,
    "steps": motions.step_sizes,
    "reversals": motions.reversals,
    "preload": forces.zero_preload,
    "stops": motions.starts_at_stops,
    "dwell": grooves.dwells,
    "dampers": forces.dampers,
    "restitution": motions.restitutions,
    "tolerances": motions.tolerances,
}


def collect(names: Iterable[str], count: int, tables: Tables, seed: int = 0) -> list[Scene]:
    made = [scene for name in names if name != "fuzz" for scene in FAMILIES[name](tables)]
    return made + (list(fuzz(tables, count, seed)) if "fuzz" in names else [])
