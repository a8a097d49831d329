"""What each thing costs, and whether it costs nothing where it is absent.

    ./build.sh skipping

Two mechanisms that have everything, with helical grooves and with elliptical ones, slide under torques that
differ from step to step. In each, one thing at a time is left out. Every step of 1 ms is stepped by
work_precision.c; all variants run in turns, ratios are those of the same round, medians with quartiles. What
is absent and saves less than NOTHING is a defect, unless the closed form has nothing to save there: one
number instead of another.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from rich.console import Console

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / folder) for folder in ("fmu_src", "benchmarks")]
import pictures  # noqa: E402
import step_cost  # noqa: E402
from work_precision import CFmu, Scene, circumstances  # noqa: E402

STEP, STEPS = 1e-3, 25
NOTHING = 0.01  # of a step; below this nothing is saved
STICK, LOADING = 1, 2
ALL_READ = (
    *("theta", "omega", "z", "v", "alpha", "gamma", "spring.force", "damper.force", "torque_load"),
    *("cam1.reaction", "cam2.reaction", "cam1.sliding_speed", "cam2.sliding_speed", "torque_release"),
    *("efficiency", "energy.spring", "energy.kinetic", "energy.residual"),
)
Parameters = step_cost.Parameters

EVERYTHING: Parameters = {
    **step_cost.START,
    "initial.omega": 2.0,
    "inertia.shaft": 0.005,
    "inertia.follower_mass": 0.3,
    "inertia.follower": 3e-5,
    "shaft.damping": 0.002,
    "damper.c_load": 20.0,
    "damper.c_release": 20.0,
}
CURVED: Parameters = {**EVERYTHING, **step_cost.ELLIPSES, **step_cost.FORCES, "inertia.shaft": 0.005}
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
    """One per step, from the stick band at the start."""
    slave = step_cost.Slave("DualCamForward")
    slave.set(parameters)
    slave.fmu.setupExperiment(tolerance=step_cost.TOLERANCE, startTime=0.0)
    slave.fmu.enterInitializationMode()
    release, load = slave.real("torque_release"), slave.real("torque_load")
    if kind == "drive":
        return load * step_cost.jitter(1.28, 1.32, STEPS)
    if kind == "hold":
        return release + (load - release) * step_cost.jitter(0.2, 0.8, STEPS)
    return np.where(np.arange(STEPS) // 5 % 2, 0.2 * release, 1.4 * load)


class Stepped(CFmu):
    """Steps of 1 ms with a torque each, in one mode from beginning to end unless events are the point."""

    def __init__(self, variant: Variant) -> None:
        torque = torques(variant.torque, variant.parameters)
        pieces = tuple((STEP, float(tau)) for tau in torque)
        scene = Scene(variant.name, variant.name, dict(variant.parameters), pieces)
        super().__init__(scene, "DualCamForward", variant.parameters, step_cost.TOLERANCE, 1, variant.reads)
        self.repeats = 20
        self.seconds()
        mode, events = self.slave.integer("mode"), self.slave.integer("events")
        expected = {"drive": LOADING, "hold": STICK}.get(variant.torque)
        if expected is not None and mode != expected:
            raise SystemExit(f"{variant.name}: mode {mode}, not {expected}")
        self.events = events / STEPS if expected is None else 0.0

    def seconds(self) -> float:
        """Per step."""
        return self.timed() / STEPS


CLOSED = {"friction", "damper", "shaft damping", "follower's masses"}  # other numbers in the same closed form
STRAIGHT = "helical grooves, linear forces"


class Nothing(CFmu):
    """The same steps of an FMU that does nothing."""

    def __init__(self) -> None:
        pieces = tuple((STEP, 1.0) for _ in range(STEPS))
        super().__init__(Scene("", "", {}, pieces), "NullFmu", {}, step_cost.TOLERANCE, 1, ())
        self.repeats = 20

    def seconds(self) -> float:
        return self.timed() / STEPS


def verdict_on(title: str, name: str, saved: float, made: Stepped | Nothing) -> str:
    if isinstance(made, Nothing) or name == "everything":
        return ""
    if made.events:
        return f"{made.events:.2g} mode changes per step"
    if saved >= NOTHING:
        return f"saves {saved:.0%}"
    return "nothing to save" if title == STRAIGHT and name in CLOSED else "DEFECT"


def picture(rows: Sequence[Mapping[str, str]], facts: Mapping[str, str], path: Path) -> None:
    """What is left of a step's time without each thing, one panel per mechanism."""
    titles = list(dict.fromkeys(row["mechanism"] for row in rows))
    figure, panels = pictures.blank(12.5, 5.4, columns=len(titles))
    for panel, title in zip(panels, titles, strict=True):
        found = [row for row in rows if row["mechanism"] == title and row["without"][0] != "("]
        del found[0]  # everything: what the next is without
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
    names = ("before", "without what the row names", "an FMU that does nothing")
    figure.legend((pale, own, line), names, loc="outside upper center", ncol=3, frameon=False, fontsize=9)
    pictures.finish(figure, facts, path)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--rounds", type=int, default=101)
    parser.add_argument("--output", type=Path, default=ROOT / "benchmarks/results/skipping.csv")
    parser.add_argument("--picture", type=Path, default=ROOT / "benchmarks/results/skipping.png")
    arguments = parser.parse_args()
    console = Console() if sys.stdout.isatty() else Console(width=120)
    rows: list[dict[str, str]] = []
    facts = circumstances("skipping")
    for title, base in (
        ("helical grooves, linear forces", EVERYTHING),
        ("elliptical grooves, all forces", CURVED),
    ):
        made: dict[str, Stepped | Nothing] = {v.name: Stepped(v) for v in variants(base)}
        made["(the null FMU)"] = Nothing()
        blocks: dict[str, Callable[[], float]] = {name: stepped.seconds for name, stepped in made.items()}
        times = step_cost.in_turns(blocks, arguments.rounds, title, console)
        table = step_cost.table(title, "without", "ns before", "ns", "ratio (quartiles)", "verdict")
        for name, seconds in times.items():
            against = times["everything" if name in ("everything", "unread outputs") else "unread outputs"]
            before = 1e9 * float(np.median(against))
            ratio = step_cost.Ratio.of(seconds, against)
            nanoseconds = 1e9 * float(np.median(seconds))
            verdict = verdict_on(title, name, 1.0 - ratio.median, made[name])
            table.add_row(name, f"{before:.1f}", f"{nanoseconds:.1f}", str(ratio), verdict)
            rows.append(
                {
                    "mechanism": title,
                    "without": name,
                    "ns_before": f"{before:.2f}",
                    "ns_per_step": f"{nanoseconds:.2f}",
                    "ratio": f"{ratio.median:.4f}",
                    "lower_quartile": f"{ratio.lower:.4f}",
                    "upper_quartile": f"{ratio.upper:.4f}",
                    "verdict": verdict,
                    **facts,
                }
            )
        console.print(table)
    console.print(
        "everything: all outputs and locals are read after each step; unread outputs: nothing is read but"
        " theta and omega, as in all that follow, whose cost is a ratio to it.",
        highlight=False,
    )
    picture(rows, facts, arguments.picture)
    step_cost.publish(rows, facts, arguments.output, console, arguments.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
