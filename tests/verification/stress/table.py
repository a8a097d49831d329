"""The table of the outcomes, and the page docs/stress.md."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from benchmarks.harness.circumstances import circumstances
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


INTRODUCTION = """\
Read this page to see what the FMU does with extreme parameters. The table has elliptical and tabulated
grooves, nonlinear springs and dampers, and masses. Each row has the range of the varied quantity, and
counts what came out of the runs. The scenes are far harder than those of [accuracy.md](accuracy.md):
parameters go over many decades.

- *Judged*: compared with an independent solution. In the rows "at random" a run is compared with a second
  run of the FMU, whose intervals are cut differently. Other runs are held to the laws alone, such as the
  balance of energy. `tests/verification/stress/__init__.py` describes judges and laws.
- *Right*: not refused, all laws hold, and a judged run differs by at most 100 tolerances. A scene that
  depends strongly on its data has a wider limit: the run is repeated with parameters and inputs changed by
  one tolerance. If its results change by d, then 10 d is allowed.
- *Wrong*: neither right nor refused. [The list](#wrong) is below.
- *Refused*: the step or the start ends with a message. [The messages](#refused) are below.
- *Worst error*: the largest error of angle, speed and accounts among the right runs, relative to the largest
  angle, speed and energy of the scene. The tolerance is 1e-9 unless the row says otherwise. In the rows
  "against the limit" it is the distance from the limit. Elsewhere an error above 1e-7 belongs to a scene that
  depends strongly on the data.
- *Energy residual*: relative to the largest account, among the right runs.
- *Longest step*: processor time of the longest doStep.
- *ms per second*: the most processor time for a simulated second. Short steps count
  most: 0.01 ms for a step of 1e-9 s are 1e7 ms per second."""

REFUSED = """\
Numbers of runs that are refused, by the message."""

WORDS_OF_WRONG = """\
Wrong runs are no part of the columns "worst error" and "energy residual". The words of the list:

- *interval*: a part of a scene with one polynomial for each input. The intervals of a scene are numbered
  from 0.
- *cutting changes E*: the FMU runs the scene twice, in steps that cut the intervals differently. The
  results differ by E, relative to the largest size in the scene. The quantity that differs most follows,
  with the values of both runs.
- *data amplify A*: the FMU runs the scene again with parameters and inputs changed by the tolerance and by
  ten times the tolerance. The results change by at most A times the tolerance.
- *in pieces*: the finding belongs to the run with more cuts.
- *energy.residual X of Y*: the accounts miss X of the balance of energy, and Y is the largest account.
- *a doStep of T*: one step computes for longer than 2 s."""


def markdown(rows: Sequence[Row], seconds: float) -> str:
    lines = [
        "# Stress table of the general mechanism",
        "",
        *INTRODUCTION.split("\n"),
        "",
        "| " + " | ".join(HEAD) + " |",
        "|" + "---|" * len(HEAD),
        *("| " + " | ".join(row.cells()) + " |" for row in rows),
        "",
    ]
    lines += ["## Refused", "", *REFUSED.split("\n"), "", "| varied | refused | message |", "|---|---|---|"]
    for row in rows:
        lines += [f"| {row.name} | {count} | {text} |" for text, count in row.refusals.most_common()]
    lines.append("")
    lines += ["## Wrong", "", *list_of_wrong(rows), ""]
    facts = circumstances("stress", "scipy", "numpy")
    facts["took"] = f"{seconds / 60:.0f} min"
    return "\n".join([*lines, "---", "", *(f"{name}: {value}  " for name, value in facts.items())]) + "\n"


def list_of_wrong(rows: Sequence[Row]) -> list[str]:
    wrong = [(row, scene, verdict) for row in rows for scene, verdict in row.wrong]
    if not wrong:
        return [f"None of the {sum(row.runs for row in rows)} runs came out wrong."]
    lines = [*WORDS_OF_WRONG.split("\n"), ""]
    for row, scene, verdict in wrong[:60]:
        lines.append(f"- {row.name}: {scene.label}: {verdict.problems[0].strip()[:300]}")
    if len(wrong) > 60:
        lines.append(f"- and {len(wrong) - 60} more")
    return lines


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
