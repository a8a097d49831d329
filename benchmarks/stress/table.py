"""The table of the outcomes, and the page docs/stress.md."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.oracles import reference
from benchmarks.stress.scene import Scene, Verdict


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

    def outcome(self) -> str:
        parts = [f"**{len(self.wrong)} wrong**"] if self.wrong else []
        right = self.runs - len(self.wrong) - self.refusals.total()
        parts += [f"{right} right"] if parts or self.refusals else ["right"]
        parts += [f"{count} refused: {text}" for text, count in self.refusals.most_common()]
        return "; ".join(parts)

    def cells(self) -> list[str]:
        error = f"{self.error:.1e}" if self.judged else ""
        cost = f"{1e3 * self.step:.3g} / {1e3 * self.rate:.3g}"
        return [
            self.name,
            str(self.runs),
            str(self.judged),
            error,
            f"{self.residual:.1e}",
            cost,
            self.outcome(),
        ]


REASONS = {
    "jam when loading": '"the contacts jam when loading at theta = ..."',
    "nothing resists": '"nothing resists the motion on a dwell"',
    "jam and let go": '"the contacts jam and let go without end"',
    "too many segments": '"the step needs too many segments"',
    "both grooves are level": '"both grooves are level at theta = ..."',
    "elliptical groove": '"the elliptical groove ... ends at psi = ..., reached at theta = ..."',
    "describing the grooves": '"describing the grooves in between takes more than ... polynomials"',
    "is refused": '"... is refused: allowed is ..."',
}


def reason(refusal: str) -> str:
    return next((words for key, words in REASONS.items() if key in refusal), f'"{refusal[:160]}"')


HEAD = ["varied", "runs", "judged", "worst error", "energy residual", "cost, ms", "outcome"]


def markdown(rows: Sequence[Row], seconds: float) -> str:
    lines = [
        "# Stress table of the general mechanism",
        "",
        "Elliptical and tabulated grooves, nonlinear spring and damper, masses: the range of each quantity",
        "and the outcome. Error: of angle, speed and accounts, relative to the largest angle, speed and",
        "energy of the scene, at the tolerance 1e-9 unless the row says otherwise. *Judged*: runs with an",
        "independent reference (at random: the same intervals cut differently). All runs are held to the",
        "laws, the runs that are not judged to the laws alone. Energy residual: relative to the largest",
        "account. Cost, in processor time: longest doStep / most for a simulated second.",
        "benchmarks/stress/__init__.py describes the judges.",
        "",
        "| " + " | ".join(HEAD) + " |",
        "|" + "---|" * len(HEAD),
        *("| " + " | ".join(row.cells()) + " |" for row in rows),
        "",
    ]
    wrong = [(row, scene, verdict) for row in rows for scene, verdict in row.wrong]
    if wrong:
        lines += ["## Wrong", ""]
        for row, scene, verdict in wrong[:60]:
            lines.append(f"- {row.name}: {scene.label}: {verdict.problems[0].strip()[:300]}")
        if len(wrong) > 60:
            lines.append(f"- and {len(wrong) - 60} more")
        lines.append("")
    facts = circumstances("stress", "scipy", "numpy")
    facts["took"] = f"{seconds / 60:.0f} min"
    return "\n".join([*lines, "---", "", *(f"{name}: {value}  " for name, value in facts.items())]) + "\n"


def describe(scene: Scene) -> str:
    """Parameters, tables and intervals, with which the scene can be run again."""
    tables = {n: reference.read_table(v) for n, v in scene.params.items() if n.endswith(".table") and v}
    params = {n: v for n, v in scene.params.items() if n not in tables}
    return (
        f"  params = {params}\n  tables = {tables}\n  intervals = {scene.intervals}\n"
        f"  tolerance {scene.tolerance}, {scene.steps} steps per interval, "
        f"without closed forms: {scene.general}"
    )
