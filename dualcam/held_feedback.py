"""Feedback that is computed outside the plant function of a coupling, and so is held over each step."""

from __future__ import annotations

import math
from collections import deque
from itertools import pairwise

SWINGS = 20  # up or down, of the torque, that make a pattern
MOST_STEPS = 10  # per swing: a slower swing is resolved
ALIKE = 2.0  # ratio of the sizes of two swings in turn; those of noise differ more
LASTING = 0.9  # of the sizes of the first half of the swings, those of the second half
ROUNDING = 1e-6  # of the torque: smaller swings do not count


class TorqueSwings:
    """Finds the pattern of an unstable loop in the torques of the steps: the torque goes up and down every few
    steps, each time by about as much, without decay."""

    def __init__(self) -> None:
        self._torque, self._turned_at, self._steps, self._rises = math.nan, math.nan, 0, False
        self._swings: deque[tuple[int, float]] = deque(maxlen=SWINGS)  # steps, and size [N.m]

    def add(self, torque: float) -> None:
        """The torque of the next step [N.m]."""
        if torque != self._torque and (torque > self._torque) is not self._rises:
            self._swings.append((self._steps, abs(self._torque - self._turned_at)))
            self._turned_at, self._steps, self._rises = self._torque, 0, torque > self._torque
        self._torque = torque
        self._steps += 1

    @property
    def steps(self) -> int:
        """Steps of the latest swings together."""
        return sum(steps for steps, _ in self._swings)

    @property
    def size(self) -> float:
        """Of the latest swing [N.m]."""
        return self._swings[-1][1]

    @property
    def are_unstable(self) -> bool:
        """Whether the latest swings have the pattern."""
        if len(self._swings) < SWINGS or self.steps > MOST_STEPS * SWINGS:
            return False
        sizes = [size for _, size in self._swings]
        half = SWINGS // 2
        return (
            sizes[-1] > ROUNDING * abs(self._torque)
            and all(a < ALIKE * b and b < ALIKE * a for a, b in pairwise(sizes))
            and sum(sizes[half:]) > LASTING * sum(sizes[:half])
        )


def held_feedback_text(swings: TorqueSwings, step: float, end: float, begin: float) -> str:
    """Of the warning: torques of the plant function at the same motion, at the end of a step and at the
    beginning of the next one [N.m]."""
    return (
        f"the torque has gone up and down {SWINGS} times in {swings.steps} steps of {step:g} s, the last time"
        f" by {swings.size:.4g} N.m, without decay, and something outside the plant function changes it: at the"
        f" same motion the function returned {end:.6g} N.m at the end of a step and {begin:.6g} N.m at the"
        " beginning of the next one. Feedback that is computed outside the function, such as a controller's"
        " voltage, is held over the step, and the check of stability does not see it. What works: a shorter"
        " step, or the feedback inside the function and step_implicit. step_difference tells how much a"
        " shorter step changes. If your machine holds this feedback over the same period, its loop is unstable"
    )
