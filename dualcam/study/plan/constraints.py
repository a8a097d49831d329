"""Formulas of a plan: derived values in order, and constraints."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from dualcam.common.mistakes import StudyError
from dualcam.fmi.reals import Array
from dualcam.scenario.formula import Formula, formula


def in_order(derived: Mapping[str, str]) -> list[tuple[str, Formula]]:
    """Derived names with their formulas, each after those that it uses. StudyError for a circle."""
    left = {name: formula(text) for name, text in derived.items()}
    done: list[tuple[str, Formula]] = []
    while left:
        ready = [name for name, each in left.items() if not set(each.names) & set(left)]
        if not ready:
            raise StudyError(f"derived: {', '.join(left)} use each other in a circle: break it")
        done += [(name, left.pop(name)) for name in ready]
    return done


def violations(
    constraints: Mapping[str, str], columns: Mapping[str, Array], count: int
) -> dict[str, NDArray[np.bool_]]:
    """Which of `count` runs violate which constraint: True where a formula is not true.

    `columns` has the values of the runs by name, shape (count,) each."""
    return {name: ~formula(text).truth(columns, count) for name, text in constraints.items()}


def any_of(found: Mapping[str, NDArray[np.bool_]], count: int) -> NDArray[np.bool_]:
    """Which of `count` runs violate any constraint."""
    return np.any([*found.values(), np.zeros(count, bool)], axis=0)
