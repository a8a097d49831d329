"""What a plan says: its fields, and what follows from them alone."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from numpy.typing import ArrayLike

from dualcam.common.arrays import TRUTH, Array, real_array
from dualcam.common.mistakes import StudyError
from dualcam.study.plan import arrangements
from dualcam.study.plan.correlation import Correlation
from dualcam.study.plan.texts import Texts
from dualcam.study.plan.vary import Vary


@dataclass(frozen=True)
class PlanFields:
    """The fields of a `Plan`, which may be wrong."""

    kind: str
    vary: Mapping[str, Vary] = field(default_factory=dict)
    runs: int = 0
    seed: int = 0
    table: ArrayLike | None = None
    same_as: Mapping[str, str] = field(default_factory=dict)
    derived: Mapping[str, str] = field(default_factory=dict)
    constraints: Mapping[str, str] = field(default_factory=dict)
    on_violation: str = "redraw"
    correlations: Sequence[Correlation] = ()
    second_order: bool = True
    levels: int = 4

    @property
    def names(self) -> list[str]:
        """The names of the columns of `rows`: what varies, then `same_as`, then `derived`."""
        return [*self.vary, *self.same_as, *self.derived]

    @cached_property
    def texts(self) -> dict[str, Texts]:
        """The texts of each String, by name: `rows` has their places."""
        own = {
            name: vary.texts for name, vary in self.vary.items() if vary.is_list and vary.texts is not None
        }
        return own | {name: own[other] for name, other in self.same_as.items() if other in own}

    @cached_property
    def table_rows(self) -> Array:
        """The table as an array, shape (runs, variables)."""
        return real_array(self.table, "plan: table", StudyError, kinds=TRUTH)  # type: ignore[arg-type]

    @cached_property
    def count(self) -> int:
        """The number of runs."""
        if self.kind == "grid":
            return math.prod(vary.size() for vary in self.vary.values())
        if self.kind == "table":
            return len(self.table_rows)
        return arrangements.count(self.kind, self.runs, len(self.vary), self.second_order)
