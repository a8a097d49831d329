"""The table of the outcomes, as stress.csv has it."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.harness.oracles import reference
from verification.stress.scene import Scene, Verdict


@dataclass
class Row:
    name: str
    runs: int = 0
    judged: int = 0
    amplified: int = 0
    error: float = 0.0
    residual: float = 0.0
    step: float = 0.0
    rate: float = 0.0
    wrong: list[tuple[Scene, Verdict]] = field(default_factory=list)
    refusals: Counter[str] = field(default_factory=Counter)

    def add(self, scene: Scene, verdict: Verdict) -> None:
        self.runs += 1
        self.judged += verdict.judged
        self.step = max(self.step, verdict.step)
        self.rate = max(self.rate, verdict.rate)
        if verdict.problems:
            self.wrong.append((scene, verdict))
            return
        self.residual = max(self.residual, verdict.residual)
        if not math.isnan(verdict.error):
            self.error = max(self.error, verdict.error)
        else:
            self.amplified += verdict.judged
        if verdict.refusal:
            self.refusals[reason(verdict.refusal)] += 1

    def cells(self) -> list[str]:
        error = f"{self.error:.1e}" if self.judged else ""
        refused = self.refusals.total()
        return [
            self.name,
            str(self.runs),
            str(self.judged),
            str(self.runs - len(self.wrong) - refused),
            str(len(self.wrong)),
            str(refused),
            error,
            f"{self.residual:.1e}",
            f"{1e3 * self.step:.3g}",
            f"{1e3 * self.rate:.3g}",
        ]


REASONS = {
    "jam when loading": '"the contacts jam when loading at theta = ..."',
    "nothing resists": '"nothing resists ... at theta = ..."',
    "needs an inertia": '"friction that varies with the sliding speed needs an inertia"',
    "with a damper": '"with a damper and without inertia"',
    "take the inertia": '"take the inertia that the torque feels to zero"',
    "wedge and let go": '"the contacts wedge and let go without end"',
    "too many evaluations": '"the step needs too many evaluations of the motion"',
    "too many segments": '"the step needs too many segments"',
    "both grooves are level": '"both grooves are level at theta = ..."',
    "elliptical groove": '"the elliptical groove ... ends at psi = ..., reached at theta = ..."',
    "describing the grooves": '"describing the grooves in between takes more than ... polynomials"',
    "is refused": '"... is refused: allowed is ..."',
}


def reason(refusal: str) -> str:
    return next((words for key, words in REASONS.items() if key in refusal), f'"{refusal[:160]}"')


HEAD = [
    "varied",
    "runs",
    "judged",
    "right",
    "wrong",
    "refused",
    "worst error",
    "energy residual",
    "longest step, ms",
    "ms per second",
]
MOST = 20  # wrong runs of a row that are published


def published(row: Row) -> dict[str, str]:
    """A row of stress.csv. Several messages or wrong runs stand in one cell, with ` | ` between."""
    messages = [f"{count} {text}" for text, count in row.refusals.most_common()]
    wrong = [f"{scene.label}: {verdict.problems[0].strip()[:300]}" for scene, verdict in row.wrong[:MOST]]
    lists = {"messages": messages, "wrong runs": wrong}
    return {**dict(zip(HEAD, row.cells(), strict=True)), **{k: " | ".join(v) for k, v in lists.items()}}


def describe(scene: Scene) -> str:
    """Parameters, tables and intervals, with which the scene can be run again."""
    tables = {n: reference.read_table(v) for n, v in scene.params.items() if n.endswith(".table") and v}
    params = {n: v for n, v in scene.params.items() if n not in tables}
    laws = {n: Path(v).read_text() for n, v in params.items() if n.endswith(".friction_table") and v}
    return (
        f"  params = {params}\n  tables = {tables}\n  friction tables = {laws}\n"
        f"  intervals = {scene.intervals}\n"
        f"  tolerance {scene.tolerance}, {scene.steps} steps per interval, "
        f"without closed forms: {scene.general}"
    )
