"""The rows of the table by their short names."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from verification.stress import forces, grooves, laws, motions
from verification.stress.at_random import fuzz
from verification.stress.mechanisms import Tables
from verification.stress.scene import Scene

FAMILIES: dict[str, Callable[[Tables], Iterator[Scene]]] = {
    "stiffness": forces.stiffness,
    "inertia": forces.inertia,
    "friction": forces.friction,
    "laws": laws.friction_laws,
    "loads": laws.load_laws,
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


RANDOM: dict[str, Callable[[Tables, int, int], Iterator[Scene]]] = {
    "fuzz": fuzz,
    "fuzz_laws": laws.fuzz_laws,
    "fuzz_loads": laws.fuzz_loads,
}
ROWS = (*FAMILIES, *RANDOM)
FEWER = {"fuzz_loads": 8}  # such a scene takes about eight times as long


def collect(names: Sequence[str], count: int, tables: Tables, seed: int = 0) -> list[Scene]:
    """The scenes of the rows named. `count`: scenes at random for each row of RANDOM, or FEWER."""
    made = [scene for name in names if name in FAMILIES for scene in FAMILIES[name](tables)]
    for name in names:
        if name in RANDOM:
            made += RANDOM[name](tables, count // FEWER.get(name, 1), seed)
    return made
