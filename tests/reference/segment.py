"""One segment: sliding on one pair of flanks up to the first event."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from .arithmetic import Arithmetic, Number, Polynomial
from .mechanism import Mechanism, Slip


@dataclass(frozen=True)
class Segment:
    """Sliding on one pair of flanks, from local time 0 for at most `length`."""

    slip: Slip
    theta: Number
    omega: Number
    tau: Polynomial  # of local time
    f_ext: Polynomial
    length: Number
    stop: Number  # rad, the end stop in the direction of motion
    load_sign: int = 1  # sign of F_0; without inertia it selects the band edge that ends the motion


@dataclass
class Outcome:
    """Where a segment ended, and why: a subset of end, rest, stop, cross1, cross2, kink."""

    time: Number
    theta: Number
    omega: Number
    flows: list[Number]
    causes: set[str]
    peak_omega: Number
    peak_reactions: tuple[Number, Number]  # per contact


class Flow(Protocol):
    arithmetic: Arithmetic

    def advance(self, mechanism: Mechanism, segment: Segment) -> Outcome: ...
