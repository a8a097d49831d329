"""Limit cycles of the cam under a sampled controller: predicted by harmonic balance, checked in the loop."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from dualcam.control.harmonic_balance import Candidate, LimitCycle, Start
from dualcam.control.play_operator import PlayOperator
from dualcam.control.sampled_loop import (
    LATE,
    MOST_SAMPLES,
    MOST_TORQUE,
    LoopMotion,
    SampledController,
    SampledLoop,
)

ALLOWED = 0.1  # relative error of a prediction that is said to hold
STARTS = (-0.05, 0.3, -0.95, 0.95)  # offsets from which the loop is run, of the distance to the stop there
LEAST_MARGIN = 1.9  # see LimitCycle; measured: tests/verification/results/hunting.csv
LONGER = 5.0  # times the duration of runs that have not settled: the duration to try
ON_STOP = 1e-3  # of the room between the stops
GROWS = f"lets the controller's torque grow beyond {MOST_TORQUE:g} N.m, or a state beyond 1e308"


@dataclass(frozen=True)
class LimitCycles:
    """Limit cycles as predicted, and as the FMU in the loop shows them.

    Attributes
    ----------
    predicted : By harmonic balance, by rising amplitude.
    simulated
        Different motions in which the loop with the FMU settles, by rising amplitude; rest, also on a stop,
        is none of them. Empty if the check was left out.
    holds
        Whether the FMU agrees with the prediction to 10 %: True, too, where the loop swings as predicted.
        Without the check: None, or False where a margin is too small (see LimitCycle).
    findings : Where the prediction does not hold; the texts of the warnings.
    rests : Whether every run of the check came to rest between the stops. None without the check.
    """

    predicted: tuple[LimitCycle, ...]
    simulated: tuple[LoopMotion, ...] = ()
    holds: bool | None = None
    findings: tuple[str, ...] = ()
    rests: bool | None = None


def unchecked(controller: SampledController, found: list[Candidate]) -> LimitCycles:
    """The predictions alone."""
    cycles = tuple(one.cycle for one in found)
    findings = tuple(
        f"predicted is {_words(cycle)}, but with this swing the cam nearly rests at its turning points: the"
        f" torque there is {cycle.margin:.2g} half widths of the stick band from its middle, and the"
        f" describing function holds from {LEAST_MARGIN} on. Run the check"
        for cycle in cycles
        if cycle.margin < LEAST_MARGIN
    )
    if controller.unstable:
        findings += (
            f"the controller is unstable: it has a pole of magnitude {controller.largest_pole:.4g}, allowed"
            " for rest is at most 1. A describing function does not tell whether the loop holds it. Run the"
            " check",
        )
    return LimitCycles(cycles, (), False if findings else None, findings)


def check_in_loop(
    hysteresis: PlayOperator,
    controller: SampledController,
    found: list[Candidate],
    duration: float,
) -> LimitCycles:
    """The predictions beside the FMU in the loop."""
    loop = SampledLoop(hysteresis.path, hysteresis.parameters, controller, hysteresis.theta)
    try:
        checks = _Checks(hysteresis, loop, found, duration)
        findings = [*checks.of_predictions(), *checks.of_offsets()]
    finally:
        loop.close()
    motions = tuple(sorted(checks.motions, key=lambda motion: motion.amplitude))
    cycles, rests = tuple(one.cycle for one in found), checks.kinds == {"rest"}
    return LimitCycles(cycles, motions, not findings, tuple(findings), rests)


class _Checks:
    """Runs of the loop. `motions`: the different ones in which the loop settled, but for rest. `kinds`: those
    of all runs."""

    def __init__(
        self, hysteresis: PlayOperator, loop: SampledLoop, found: list[Candidate], duration: float
    ) -> None:
        self.hysteresis, self.loop, self.found, self.duration = hysteresis, loop, found, duration
        self.motions: list[LoopMotion] = []
        self.kinds: set[str] = set()

    def _settle(self, start: Start) -> LoopMotion:
        settled = self.loop.settle(start.theta, start.omega, start.x, start.bias, self.duration)
        self.kinds.add(settled.kind)
        return settled

    def of_predictions(self) -> Iterator[str]:
        """Texts where the loop does not settle in a stable cycle, or does not part at a border."""
        for one in self.found:
            if one.cycle.stable:
                settled = self._settle(one.start)
                if not _agrees(one.cycle, settled):
                    yield (
                        f"predicted is {_words(one.cycle)}, but from there the FMU in the loop"
                        f" {_said(settled)}"
                    )
            else:
                inside, outside = (
                    self._settle(one.start.scaled(factor, self.hysteresis.theta))
                    for factor in (1.0 - ALLOWED, 1.0 + ALLOWED)
                )
                if not inside.amplitude < one.cycle.amplitude < outside.amplitude:
                    yield (
                        f"predicted is {_words(one.cycle)}, but the FMU in the loop {_said(inside)} from 0.9"
                        f" of this amplitude, and {_said(outside)} from 1.1 of this amplitude"
                    )

    def of_offsets(self) -> Iterator[str]:
        """Texts where the loop, left at an offset, settles in what is not predicted."""
        middle = float(np.mean(self.hysteresis.band(self.hysteresis.theta)))
        theta, states = self.hysteresis.theta, np.zeros(self.loop.controller.states)
        unsettled: dict[str, list[str]] = {}  # offsets by what is said of them
        for share in STARTS:
            stop = self.hysteresis.upper if share > 0.0 else self.hysteresis.lower
            begin = theta + abs(share) * (stop - theta)
            settled = self._settle(Start(begin, 0.0, states, middle))
            if settled.kind in ("stop", "diverges", "grows", "undecided"):
                where = f"{begin:.4g} rad ({_ends(settled)} at the end{self._drift(settled)})"
                unsettled.setdefault(self._complaint(settled), []).append(where)
            elif settled.kind != "rest" and not any(_alike(settled, other) for other in self.motions):
                self.motions.append(settled)
                if not any(one.cycle.stable and _agrees(one.cycle, settled) for one in self.found):
                    yield (
                        f"left at {begin:.4g} rad, the FMU in the loop {_said(settled)}{self._why(settled)}."
                        " No limit cycle like this one is predicted: the describing function does not hold"
                        " there"
                    )
        for complaint, offsets in unsettled.items():
            yield f"left at {' or '.join(offsets)}, the FMU in the loop {complaint}"

    def _complaint(self, settled: LoopMotion) -> str:
        """What is wrong where the loop neither rests nor swings, and what to do."""
        if settled.kind == "undecided":
            return f"is neither at rest nor in cycles after {self.duration:g} s. {self._longer('decides')}"
        if settled.kind == "grows":
            return (
                f"swings with an amplitude that still grows after {self.duration:g} s."
                f" {self._longer('shows where it ends')}"
            )
        if settled.kind == "diverges":
            return (
                f"{GROWS}. The controller has a pole of"
                f" magnitude {self.loop.controller.largest_pole:.4g}, allowed for rest is at most 1"
            )
        lower = settled.lowest < self.hysteresis.theta
        stop = f"lower stop, {self.hysteresis.lower:g}" if lower else f"upper stop, {self.hysteresis.upper:g}"
        return (
            f"is held at the {stop} rad, after {self.duration:g} s: the torque does not bring the cam back."
            " Look at the sign of the controller (from the error, theta less the angle, to the torque) and at"
            " its gains"
        )

    def _drift(self, settled: LoopMotion) -> str:
        """How far an unsettled cam still moved. Where it stands, an integral of the error is not settled."""
        if settled.kind != "undecided":
            return ""
        if settled.amplitude == 0.0:
            return ", where it sticks while the torque goes on to change"
        return f", moved by {2.0 * settled.amplitude:.2g} rad in the last {LATE * self.duration:.3g} s"

    def _longer(self, effect: str) -> str:
        """The advice of a longer duration, as far as one is allowed."""
        period = self.loop.controller.period
        longest = MOST_SAMPLES * period
        if self.duration < longest:
            return f"A longer duration {effect}: try duration={min(LONGER * self.duration, longest):g}"
        return f"This is the longest duration that the period of {period:g} s allows"

    def _why(self, settled: LoopMotion) -> str:
        """What the harmonic balance does not know of this motion."""
        near = ON_STOP * (self.hysteresis.upper - self.hysteresis.lower)
        if settled.lowest < self.hysteresis.lower + near or settled.highest > self.hysteresis.upper - near:
            return ", and hits a stop"
        return ""


def _agrees(cycle: LimitCycle, settled: LoopMotion) -> bool:
    """Amplitude and frequency of a stable cycle within 10 %."""
    return settled.kind == "cycle" and all(
        abs(a - b) <= ALLOWED * b
        for a, b in ((cycle.amplitude, settled.amplitude), (cycle.frequency, settled.frequency))
    )


def _alike(one: LoopMotion, other: LoopMotion) -> bool:
    return one.kind == other.kind and abs(one.amplitude - other.amplitude) <= ALLOWED * other.amplitude


def _words(cycle: LimitCycle) -> str:
    kind = "a limit cycle" if cycle.stable else "a border"
    return f"{kind} with an amplitude of {cycle.amplitude:.4g} rad at {cycle.frequency:.4g} rad/s"


def _said(settled: LoopMotion) -> str:
    swing = f"an amplitude of {settled.amplitude:.4g} rad"
    ends = _ends(settled)
    return {
        "rest": "comes to rest",
        "stop": f"is pressed on the stop {ends}",
        "diverges": f"{GROWS}, the cam {ends}",
        "cycle": f"swings with {swing} at {settled.frequency:.4g} rad/s, from {ends}",
        "irregular": f"hunts in unequal cycles, with {swing} at {settled.frequency:.4g} rad/s, from {ends}",
        "grows": f"swings with an amplitude that still grows at the end of the duration, from {ends}",
        "undecided": f"is neither at rest nor in cycles at the end of the duration, from {ends}",
    }[settled.kind]


def _ends(settled: LoopMotion) -> str:
    """Both ends of the range, with so many digits that they differ."""
    low, high = settled.lowest, settled.highest
    digits = next((n for n in range(4, 17) if f"{low:.{n}g}" != f"{high:.{n}g}"), 4)
    return f"{low:.{digits}g} to {high:.{digits}g} rad" if low != high else f"at {low:.4g} rad"
