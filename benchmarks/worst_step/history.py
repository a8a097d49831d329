"""The history of a run: the events of every step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.harness.fmu import LOADING, LOWER, RELEASING, STICK, UPPER
from benchmarks.harness.inputs import STEP, Array, Inputs


def plural(changes: int) -> str:
    return f"{changes} mode change" + ("" if changes == 1 else "s")


@dataclass
class History:
    """Of every step: mode before and after, mode changes, impacts, flank changes, and the kind of its
    inputs."""

    before: NDArray[np.int32]
    after: NDArray[np.int32]
    changes: NDArray[np.int32]
    impact: NDArray[np.bool_]
    flank: NDArray[np.bool_]
    jump: NDArray[np.bool_]
    ramp: NDArray[np.bool_]

    @classmethod
    def of(cls, integers: NDArray[np.int32], reals: Array, inputs: Inputs) -> History:
        mode, events = integers.T
        before = np.concatenate(([STICK], mode[:-1]))
        heat, flank = reals[:, 2], np.signbit(reals[:, 3:])
        moved = np.concatenate(([False], (flank[1:] != flank[:-1]).any(axis=1)))
        end = inputs.tau + STEP * inputs.tau_rate
        return cls(
            before,
            mode,
            np.diff(events, prepend=0),
            np.diff(heat, prepend=0.0) > 0.0,
            moved,
            np.concatenate(([False], ~np.isclose(inputs.tau[1:], end[:-1])))
            | (np.diff(inputs.force, prepend=0.0) != 0),
            inputs.tau_rate != 0.0,
        )

    def kinds(self) -> dict[str, NDArray[np.bool_]]:
        """The steps of every kind of event."""
        b, a = self.before, self.after
        slipping = np.isin(b, (LOADING, RELEASING))
        return {
            "stick throughout": (b == STICK) & (a == STICK) & (self.changes == 0),
            "slip throughout": slipping & (a == b) & (self.changes == 0) & ~self.flank & ~self.impact,
            "breakaway, loading": (b == STICK) & (a == LOADING),
            "breakaway, releasing": (b == STICK) & (a == RELEASING),
            "comes to rest": slipping & (a == STICK),
            "reversal": slipping & np.isin(a, (LOADING, RELEASING)) & (a != b) & ~self.impact,
            "flank change": self.flank & np.isin(a, (LOADING, RELEASING)) & (a == b),
            "impact, upper stop": self.impact & (b == LOADING),
            "impact, lower stop": self.impact & (b == RELEASING),
            "rests at the upper stop": (a == UPPER) & (b != UPPER),
            "rests at the lower stop": (a == LOWER) & (b != LOWER),
            "leaves a stop": np.isin(b, (LOWER, UPPER)) & np.isin(a, (LOADING, RELEASING)),
            "input jumps": self.jump,
            "input ramps": self.ramp,
        }

    def story(self, k: int) -> str:
        """The events of step k in words."""
        names = ("", "stick", "loading", "releasing", "lower stop", "upper stop", "wedged")
        words = [f"{names[self.before[k]]} to {names[self.after[k]]}", plural(int(self.changes[k]))]
        facts = (
            (self.impact, "impact"),
            (self.flank, "other flank"),
            (self.jump, "input jumps"),
            (self.ramp, "ramp"),
        )
        return ", ".join(words + [word for found, word in facts if found[k]])
