"""The bound of the work in a step: the limits of the loops and of the counter in the C sources."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from benchmarks.harness.core import LOOP_LIMITS, loop_limit

WATCHED_EVENTS = 6  # which end a segment
SHORTENED_BY = 8.0  # a segment that is too long is tried again with this part of its length
PEAKS = 3  # which are searched at the end of a segment


@dataclass(frozen=True)
class Bound:
    """Of the general mechanism: how often each operation can happen at most inside the next."""

    searches: int  # lengths tried per segment, each a part of the one before
    solves: int  # of the collocation equations per length
    evaluations: int  # of the balance of forces per solve
    segments: int  # per step: each to a mode change, to a breakpoint, or one collocation step long
    work: int  # evaluations per step after which no segment and no solve begins
    quasistatic: int  # evaluations per solve without inertia and damping

    @property
    def evaluations_per_segment(self) -> int:
        return (self.searches * self.solves + PEAKS) * self.evaluations

    @property
    def evaluations_per_step(self) -> float:
        return self.work + max(self.evaluations, self.quasistatic)


def bound() -> Bound:
    """The event location shortens a segment by SHORTENED_BY, from the time left to its shortest part of it. A
    solution is tried at most as often as it is shortened. For each watched event the search runs twice; each
    time it shortens the segment in its iterations and moves it by its nudges. A solve iterates over all nodes
    and starts from one more balance of forces."""
    searches = math.log(1.0 / loop_limit("shortest segment"), SHORTENED_BY)
    searching = 2 * WATCHED_EVENTS * (loop_limit("event iterations") + 1 + loop_limit("event nudges"))
    nodes = loop_limit("collocation nodes")
    return Bound(
        searches=math.ceil(searches),
        solves=int(loop_limit("shortenings") + searching),
        evaluations=int(loop_limit("collocation iterations") * nodes + 1),
        segments=int(loop_limit("segments per step")),
        work=int(loop_limit("work per step")),
        quasistatic=int((loop_limit("quasi-static iterations") + 1) * nodes),
    )


def bound_of_closed_form() -> int:
    """Evaluations of the closed form per segment, in steps of up to half a period of the oscillation. The
    search for the first event goes through two arcs for the speed (or the edge of the stick band) and for
    each contact, and finds a zero of the rate and of the value in each. One more root gives the instant at
    which a given angle is reached. The peaks are the extrema of the same three functions in twice the
    arcs."""
    root, arcs = loop_limit("closed-form root iterations"), loop_limit("closed-form arcs")
    return int(3 * 2 * (2 * root + 2) + root + 3 * (2 * arcs * (root + 1) + 1))


def constants(*names: str) -> str:
    """The names of limits in the C sources."""
    return ", ".join(LOOP_LIMITS[name][1] for name in names)


def bound_rows() -> Iterator[tuple[str, float, str]]:
    """Name, number and reason of each factor and product."""
    b, closed = bound(), bound_of_closed_form()
    yield "segments per step", b.segments, f"{constants('segments per step')}: beyond, a step is refused"
    yield "searches per segment", b.searches, f"shorter by 8 down to {constants('shortest segment')}"
    events = constants("event iterations", "event nudges")
    searching = f"2 x {WATCHED_EVENTS} watched events x (1 + {events})"
    yield "solves per search", b.solves, f"{constants('shortenings')} + {searching}"
    factors = constants("collocation iterations", "collocation nodes")
    yield "evaluations per solve", b.evaluations, f"product of {factors}, and one"
    yield "evaluations per segment", b.evaluations_per_segment, "their product, and three peaks"
    yield (
        "depth of halving",
        loop_limit("bisections"),
        f"{constants('bisections')}: an interval without width",
    )
    yield "jams per step", loop_limit("jams per step"), constants("jams per step")
    yield "evaluations per step", b.evaluations_per_step, f"{constants('work per step')}, and one solve more"
    yield "evaluations per solve, quasi-static", b.quasistatic, "without inertia and damping"
    root = int(loop_limit("closed-form root iterations"))
    yield "closed form: evaluations per segment", closed, f"roots of at most {root} evaluations"
    yield (
        "closed form: evaluations per step",
        b.work + closed,
        f"{constants('work per step')}, and one segment",
    )
