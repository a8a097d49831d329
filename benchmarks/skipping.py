"""The cost of each part of the mechanism, and whether an absent part costs nothing.

    ./build.sh run skipping

Two mechanisms that have every part, with helical grooves and with elliptical ones, slip under torques that
differ from step to step. In each mechanism one part at a time is left out. Steps of 1 ms are made by
harness/pieces.c. All variants run in turns. Ratios are those of the same round, medians with quartiles. An
absent part that saves less than NOTHING is a defect, unless the closed form has nothing to save there:
another number in the same formula.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from rich.console import Console

from benchmarks.harness import core, pictures
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.fmu import LOADING, STICK, Slave
from benchmarks.harness.pieces import PieceRun
from benchmarks.harness.repository import RESULTS
from benchmarks.harness.timing import Ratio, in_turns
from benchmarks.mechanisms import ELLIPSES, FORCES, START, STEP, Parameters, drive, jitter

STEPS = 25
REPEATS = 20  # of all steps in a block
NOTHING = 0.01  # of a step; below this nothing is saved
ALL_READ = (
    *("theta", "omega", "z", "v", "alpha", "gamma", "spring.force", "damper.force", "torque_load"),
    *("cam1.reaction", "cam2.reaction", "cam1.sliding_speed", "cam2.sliding_speed", "torque_release"),
    *("efficiency", "energy.spring", "energy.kinetic", "energy.residual"),
)

EVERYTHING: Parameters = {
    **START,
    "initial.omega": 2.0,
    "inertia.shaft": 0.005,
    "inertia.follower_mass": 0.3,
    "inertia.follower": 3e-5,
    "shaft.damping": 0.002,
    "damper.c_load": 20.0,
    "damper.c_release": 20.0,
}
CURVED: Parameters = {**EVERYTHING, **ELLIPSES, **FORCES, "inertia.shaft": 0.005}
NO_FRICTION: Parameters = {"cam1.friction": 0.0, "cam2.friction": 0.0}
NO_LINEAR: Parameters = {"damper.c_load": 0.0, "damper.c_release": 0.0}
NO_QUADRATIC: Parameters = {"damper.q_load": 0.0, "damper.q_release": 0.0}
NO_CUBIC: Parameters = {"spring.stiffness2": 0.0, "spring.stiffness3": 0.0}
NO_MASSES: Parameters = {"inertia.follower_mass": 0.0, "inertia.follower": 0.0}
HELICES: Parameters = {"cam1.profile": 1, "cam2.profile": 1}


@dataclass(frozen=True)
class Variant:
    name: str
    parameters: Parameters
    torque: str = "drive"  # "drive", "hold" (inside the stick band) or "reverse" (mode changes)
    reads: tuple[str, ...] = ()


def variants(base: Parameters) -> list[Variant]:
    curved = base is CURVED
    found = [
        Variant("everything", base, reads=ALL_READ),
        Variant("unread outputs", base),
        Variant("friction", {**base, **NO_FRICTION}),
        Variant("damper", {**base, **NO_LINEAR, **NO_QUADRATIC}),
        Variant("shaft damping", {**base, "shaft.damping": 0.0}),
        Variant("follower's masses", {**base, **NO_MASSES}),
        Variant("ledger", {**base, "ledger": False}),
        Variant("motion", {**base, "initial.omega": 0.0}, "hold"),
        Variant("motion and ledger", {**base, "initial.omega": 0.0, "ledger": False}, "hold"),
        Variant("(with events)", base, "reverse"),
    ]
    if curved:
        found += [
            Variant("quadratic damper", {**base, **NO_QUADRATIC}),
            Variant("cubic spring", {**base, **NO_CUBIC}),
            Variant("general grooves", {**base, **HELICES}),
            Variant("general grooves, nonlinear forces", {**base, **HELICES, **NO_CUBIC, **NO_QUADRATIC}),
        ]
    return found


def torques(kind: str, parameters: Parameters) -> np.ndarray:
    """The torque of every step [N.m], given the stick band at the start."""
    slave = Slave()
    slave.set(parameters)
    slave.enter_initialization()
    release, load = slave.real("torque_release"), slave.real("torque_load")
    if kind == "drive":
        return drive(release, load, STEPS)
    if kind == "hold":
        return release + (load - release) * jitter(0.2, 0.8, STEPS)
    return np.where(np.arange(STEPS) // 5 % 2, 0.2 * release, 1.4 * load)


class SteppedVariant(PieceRun):
    """Steps of 1 ms with a torque each, in one mode throughout unless the variant has mode changes.

    SystemExit if the motion is in another mode."""

    def __init__(self, variant: Variant) -> None:
        pieces = [(STEP, float(tau)) for tau in torques(variant.torque, variant.parameters)]
        super().__init__(core.FORWARD, variant.parameters, pieces, variant.reads, repeats=REPEATS)
        self.seconds()
        mode, events = self.slave.integer("mode"), self.slave.integer("events")
        expected = {"drive": LOADING, "hold": STICK}.get(variant.torque)
        if expected is not None and mode != expected:
            raise SystemExit(f"{variant.name}: mode {mode}, not {expected}")
        self.mode_changes = events / STEPS if expected is None else 0.0  # per step


CLOSED = {"friction", "damper", "shaft damping", "follower's masses"}  # other numbers in the same closed form
STRAIGHT, GENERAL = "helical grooves, linear forces", "elliptical grooves, all forces"
NULL = "(the null FMU)"


def verdict_on(title: str, name: str, saved: float, mode_changes: float) -> str:
    """`saved`: share of a step's time. `mode_changes`: per step."""
    if name in (NULL, "everything"):
        return ""
    if mode_changes:
        return f"{mode_changes:.2g} mode changes per step"
    if saved >= NOTHING:
        return f"saves {saved:.0%}"
    return "nothing to save" if title == STRAIGHT and name in CLOSED else "DEFECT"


def study(title: str, base: Parameters, rounds: int, console: Console) -> list[dict[str, str]]:
    """The rows of one mechanism, whose table is printed."""
    stepped = {variant.name: SteppedVariant(variant) for variant in variants(base)}
    null = PieceRun(core.NULL, {}, [(STEP, 1.0)] * STEPS, (), repeats=REPEATS)
    blocks = {name: run.seconds for name, run in stepped.items()} | {NULL: null.seconds}
    times = in_turns(blocks, rounds, title, console)
    table = harness.table(title, "without", "ns before", "ns", "ratio (quartiles)", "verdict")
    rows = []
    for name, seconds in times.items():
        against = times["everything" if name in ("everything", "unread outputs") else "unread outputs"]
        before, after = (1e9 * float(np.median(each)) / STEPS for each in (against, seconds))
        ratio = Ratio.of(seconds, against)
        changes = stepped[name].mode_changes if name in stepped else 0.0
        verdict = verdict_on(title, name, 1.0 - ratio.median, changes)
        table.add_row(name, f"{before:.1f}", f"{after:.1f}", str(ratio), verdict)
        rows.append(
            {
                "mechanism": title,
                "without": name,
                "ns_before": f"{before:.2f}",
                "ns_per_step": f"{after:.2f}",
                "ratio": f"{ratio.median:.4f}",
                "lower_quartile": f"{ratio.lower:.4f}",
                "upper_quartile": f"{ratio.upper:.4f}",
                "verdict": verdict,
            }
        )
    console.print(table)
    return rows


def picture(rows: Sequence[Mapping[str, str]], facts: Mapping[str, str], path: Path) -> None:
    """The time of a step with and without each part, one panel per mechanism."""
    titles = list(dict.fromkeys(row["mechanism"] for row in rows))
    figure, panels = pictures.blank(12.5, 5.4, columns=len(titles))
    for panel, title in zip(panels, titles, strict=True):
        found = [row for row in rows if row["mechanism"] == title and row["without"][0] != "("]
        del found[0]  # everything: the next one is without unread outputs
        floor = next(
            float(r["ns_per_step"]) for r in rows if r["mechanism"] == title and "null" in r["without"]
        )
        for place, row in enumerate(reversed(found)):
            before, after = float(row["ns_before"]), float(row["ns_per_step"])
            panel.barh(place, before, 0.62, color=pictures.PALE)
            panel.barh(place, after, 0.62, color=pictures.ACCENT)
            panel.text(
                max(before, after) * 1.02, place, f"{before:.0f} to {after:.0f} ns", va="center", fontsize=8
            )
        panel.axvline(floor, color="black", lw=1.2)
        panel.set_yticks(range(len(found)), [row["without"] for row in reversed(found)], fontsize=9)
        panel.set_xlim(0.0, 1.3 * max(float(row["ns_before"]) for row in found))
        panel.grid(False, axis="y")
        panel.set_xlabel("time of one step [ns]")
        panel.set_title(title, fontsize=11)
    pale, own = ((plt.Rectangle((0, 0), 1, 1, color=c)) for c in (pictures.PALE, pictures.ACCENT))
    line = plt.Line2D([], [], color="black", lw=1.2)
    names = ("before", "without the part that the row names", "an FMU that does nothing")
    figure.legend((pale, own, line), names, loc="outside upper center", ncol=3, frameon=False, fontsize=9)
    pictures.finish(figure, facts, path)


def main() -> int:
    parser = harness.options(__doc__, "skipping", 101, RESULTS / "skipping.png")
    arguments = parser.parse_args()
    console = harness.new_console()
    facts = circumstances("skipping", "numpy")
    rows = []
    for title, base in ((STRAIGHT, EVERYTHING), (GENERAL, CURVED)):
        rows += study(title, base, arguments.rounds, console)
    harness.say(
        console,
        "everything: all outputs and locals are read after each step; unread outputs: nothing is read but"
        " theta and omega, as in all that follow, whose cost is a ratio to it.",
    )
    picture(rows, facts, arguments.picture)
    harness.publish(rows, facts, arguments.output, console, arguments.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
