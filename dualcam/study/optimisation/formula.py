"""Formulas over results and varied values, such as `energy.heat_cam1@0.5 + 2 * theta`."""

from __future__ import annotations

import re
from functools import cache

from dualcam.study.sampling.formula import Formula

TIMED = r"[A-Za-z_]\w*(?:\.[A-Za-z_]\w*)*@(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
PARTS = re.compile(rf"`[^`]*`|'[^']*'|(?P<timed>{TIMED})")


@cache
def result_formula(text: str) -> Formula:
    """The formula of a text. `name@time` is one name, which formulas of plans do not have. StudyError if the
    text is no formula."""

    def with_quotes(match: re.Match[str]) -> str:
        return f"`{match[0]}`" if match["timed"] else match[0]

    return Formula(PARTS.sub(with_quotes, text))
