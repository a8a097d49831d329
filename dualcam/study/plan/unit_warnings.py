"""Values of a plan that look as if they were in another unit."""

import math
from collections.abc import Collection
from functools import cache

from dualcam.common.unit_guards import unit_warning
from dualcam.study.plan.plan import Plan

LOOKED_AT = 1000  # runs, for the extreme values of a distribution without ends


def unit_warnings_of(plan: Plan, known: Collection[str] = ()) -> list[str]:
    """A warning for each name that varies with a strange extreme value, but for those of a `known` unit.

    A name with the values of another one is told where the other one is not.
    """
    found: dict[str, str] = {}
    first_rows = cache(lambda: plan.rows(0, LOOKED_AT))  # drawn once, where they are needed
    for name, ends in plan.limits().items():
        source = plan.same_as.get(name, name)
        if source in known or source in found or source in plan.texts:
            continue
        if not all(map(math.isfinite, ends)):
            column = first_rows()[:, plan.names.index(name)]
            ends = float(column.min()), float(column.max())
        texts = (unit_warning(name, end, f"plan: {name}") for end in sorted(ends, key=abs, reverse=True))
        if text := next(filter(None, texts), None):
            found[name] = text
    return list(found.values())
