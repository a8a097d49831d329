"""The nearest value of a key that works, found by search."""

from __future__ import annotations

import math
from collections.abc import Callable

DIGITS = 4  # of a proposed value
# Shares of the way to the bound that are tried until one works: denser at both ends.
SHARES = sorted({(k / 24) ** 2 for k in range(1, 25)} | {1.0 - 0.5**k for k in range(1, 20)})
HALVINGS = 40


def nearest_working(current: float, bound: float, works: Callable[[float], bool]) -> float | None:
    """The value nearest to `current` on the way to `bound` that works, rounded towards `bound`, or None."""
    last = current
    for share in SHARES:
        probe = current + (bound - current) * share
        if works(probe):
            edge = _edge(last, probe, 1e-6 * abs(bound - current), works)
            return _rounded(edge, current, bound, works)
        last = probe
    return None


def _edge(bad: float, good: float, close: float, works: Callable[[float], bool]) -> float:
    """The working value next to values that do not work, to `close` or a ten-millionth of the value."""
    for _ in range(HALVINGS):
        middle = 0.5 * (bad + good)
        if middle in (bad, good) or abs(good - bad) <= max(close, 1e-7 * abs(good)):
            break
        if works(middle):
            good = middle
        else:
            bad = middle
    return good


def _rounded(edge: float, current: float, bound: float, works: Callable[[float], bool]) -> float:
    """`edge` with few digits, rounded towards the bound; `edge` itself if no such value works."""
    for digits in range(DIGITS, 10):
        rounded = round_away(edge, digits, up=bound > current)
        within = min(current, bound) <= rounded <= max(current, bound)
        if within and works(rounded):
            return rounded
    return edge


def round_away(value: float, digits: int, up: bool) -> float:
    """`value` to that many digits, up or down."""
    if value == 0.0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(abs(value))) - digits + 1)
    count = math.ceil(value / unit) if up else math.floor(value / unit)
    return float(f"{count * unit:.{digits}g}")
