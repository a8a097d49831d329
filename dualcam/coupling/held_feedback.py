"""Feedback that is computed outside the plant function of a coupling, and so is held over each step."""

import math
from collections import deque
from itertools import pairwise
from typing import NamedTuple

SWINGS = 24  # up or down, of the torque, that make a pattern
CROSSINGS = 8  # steps in a row, each from stop to stop, that make one, too
WHOLE = 0.99  # of the angle between the stops: a crossing
FEW_STEPS = 16  # per swing: such a swing is not resolved
MANY_STEPS = 100  # per swing: a slower one is not looked at
JUMP = 0.5  # of a swing in one step: not resolved either, as that of a controller at its limits
ALIKE = 1.3  # ratio of the sizes of two swings in turn; those of noise differ more
UNEVEN = 0.15  # of the steps, most differences between swings in the same direction; random ones have more
LASTING = 0.9  # of the sizes of the first half of the swings, those of the second half
ROUNDING = 1e-6  # of the torque: smaller swings do not count


class TorqueSwing(NamedTuple):
    """Of the torque, from one turning point to the next: size and largest change in one step [N.m]."""

    steps: int
    size: float
    jump: float

    @property
    def is_resolved(self) -> bool:
        """Whether the steps are short enough to follow it."""
        return self.steps > (MANY_STEPS if self.jump > JUMP * self.size else FEW_STEPS)


class TorqueSwings:
    """Finds the pattern of an unstable loop in the torques of the steps: the torque goes up and down, each
    time by about as much and in as many steps, without decay, and faster than the steps can follow. Or each
    step takes the cam from one stop to the other; `between_stops` is that angle [rad]."""

    def __init__(self, between_stops: float) -> None:
        self._between_stops, self._crossings = between_stops, 0
        self._torque, self._turned_at = math.nan, math.nan  # N.m
        self._steps, self._jump, self._rises = 0, 0.0, False
        self._swings: deque[TorqueSwing] = deque(maxlen=SWINGS)

    def add(self, torque: float, turn: float) -> None:
        """The torque of the next step [N.m], and the angle by which the cam turned [rad]."""
        self._crossings = self._crossings + 1 if abs(turn) > WHOLE * self._between_stops else 0
        change = torque - self._torque
        if change and (change > 0.0) is not self._rises:
            self._swings.append(TorqueSwing(self._steps, abs(self._torque - self._turned_at), self._jump))
            self._turned_at, self._steps, self._jump, self._rises = self._torque, 0, 0.0, change > 0.0
        self._jump = max(self._jump, abs(change))
        self._torque = torque
        self._steps += 1

    def in_words(self, step: float) -> str:
        """The pattern, with steps of that size [s]."""
        if self._crossings >= CROSSINGS:
            return f"each of the last {self._crossings} steps of {step:g} s took the cam from stop to stop"
        return (
            f"the torque has gone up and down {SWINGS} times in {sum(swing.steps for swing in self._swings)}"
            f" steps of {step:g} s, the last time by {self._swings[-1].size:.4g} N.m, without decay"
        )

    @property
    def are_unstable(self) -> bool:
        """Whether the latest steps have a pattern."""
        return self._crossings >= CROSSINGS or self._swing_without_decay

    @property
    def _swing_without_decay(self) -> bool:
        if len(self._swings) < SWINGS or any(swing.is_resolved for swing in self._swings):
            return False
        steps, sizes = [swing.steps for swing in self._swings], [swing.size for swing in self._swings]
        half = SWINGS // 2
        return (
            sizes[-1] > ROUNDING * abs(self._torque)
            and all(a < ALIKE * b and b < ALIKE * a for a, b in pairwise(sizes))
            and sum(sizes[half:]) > LASTING * sum(sizes[:half])
            and sum(abs(a - b) for a, b in zip(steps, steps[2:], strict=False)) <= UNEVEN * sum(steps)
        )


def held_feedback_text(swings: TorqueSwings, step: float, end: float, begin: float) -> str:
    """The warning about the plant's torques at one motion, at a step's end and the next's begin [N.m]."""
    return (
        f"{swings.in_words(step)}. Something outside the plant function changes the torque: at the same"
        f" motion the function returned {end:.6g} N.m at the end of a step and {begin:.6g} N.m at the"
        " beginning of the next one. Feedback that is computed outside the function, such as a controller's"
        " voltage, is held over the step, and the check of stability does not see it. What works: a shorter"
        " step, or the feedback inside the function and step_implicit. step_difference tells how much a"
        " shorter step changes. If your machine holds this feedback over the same period, its own loop is"
        " unstable"
    )
