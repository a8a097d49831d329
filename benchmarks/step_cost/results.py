"""Rows, tables and the picture of the step cost."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console

from benchmarks.harness import pictures
from benchmarks.harness.results import say, table, verdict
from benchmarks.harness.timing import Ratio
from benchmarks.step_cost.measure import Measured
from benchmarks.step_cost.scenes import Least, Scene

FMPY_TARGET = 1.05  # times a step of the FMU that does nothing, both through FMPy
OTHERS = {
    "exp+sincos": "one exp and one sincos, calls independent",
    "dependent": "one exp and one sincos, each waiting for the one before",
    "null": "an FMU that does nothing",
    "evaluation": "the acceleration in elliptical grooves with every force, evaluated once",
}

Row = dict[str, str]


def least_seconds(least: Least, measured: Measured) -> list[float]:
    """The limit of a scene in every round."""
    names = ("null", "exp+sincos", "evaluation")
    rounds = zip(*(measured.seconds[name] for name in names), strict=True)
    return [least.seconds(*prices) for prices in rounds]


def less_null(name: str, measured: Measured) -> Ratio:
    """A step less a step of the FMU that does nothing, in units."""
    pairs = zip(measured.seconds[name], measured.seconds["null"], strict=True)
    return Ratio.of([seconds - null for seconds, null in pairs], measured.seconds["exp+sincos"])


def row_of(name: str, description: str, scene: Scene | None, measured: Measured) -> Row:
    """The row of a scene or, with None, of one of OTHERS."""
    seconds = measured.seconds[name]
    unit, null = (Ratio.of(seconds, measured.seconds[other]) for other in ("exp+sincos", "null"))
    own = less_null(name, measured)
    least = scene.least if scene else None
    target = scene.target if scene else None
    bottom = least_seconds(least, measured) if least else []
    fmpy = measured.fmpy_seconds
    through = Ratio.of(fmpy[name], fmpy["null"]) if name in fmpy else None
    return {
        "scene": name,
        "what": description,
        "ns_per_step": f"{1e9 * statistics.median(seconds):.2f}",
        "ratio_to_exp_sincos": f"{unit.median:.4f}",
        "lower_quartile": f"{unit.lower:.4f}",
        "upper_quartile": f"{unit.upper:.4f}",
        "less_null_fmu": f"{own.median:.4f}",
        "target": "" if target is None else f"{target:g}",
        "share_of_target": "" if target is None else f"{own.median / target:.4f}",
        "ratio_to_null_fmu": f"{null.median:.4f}",
        "least_ns": f"{1e9 * statistics.median(bottom):.2f}" if bottom else "",
        "ratio_to_least": f"{Ratio.of(seconds, bottom).median:.4g}" if bottom else "",
        "least_is": least.why if least else "",
        "instructions_per_step": f"{measured.instructions[name]:.0f}"
        if name in measured.instructions
        else "",
        "events_per_step": f"{measured.mode_changes[name]:g}" if scene else "",
        "fmpy_ratio_to_null_fmu": f"{through.median:.4f}" if through else "",
        "fmpy_lower_quartile": f"{through.lower:.4f}" if through else "",
        "fmpy_upper_quartile": f"{through.upper:.4f}" if through else "",
        "fmpy_target": f"{FMPY_TARGET:g}" if through and scene else "",
    }


def rows_of(cast: Sequence[Scene], measured: Measured) -> list[Row]:
    others = [row_of(name, description, None, measured) for name, description in OTHERS.items()]
    return others + [row_of(scene.name, scene.description, scene, measured) for scene in cast]


def report(cast: Sequence[Scene], measured: Measured, rows: Sequence[Row], console: Console) -> None:
    in_c = table(
        "One step in C",
        *("scene", "ns", "/(exp+sincos)", "less null", "target", "/null", "/limit", "instr.", "events"),
    )
    in_fmpy = table("One step through FMPy", "scene", "/null", "target <=")
    for row in rows:
        name, target = row["scene"], row["target"]
        own = less_null(name, measured).median
        in_c.add_row(
            name,
            f"{float(row['ns_per_step']):.1f}",
            str(Ratio.of(measured.seconds[name], measured.seconds["exp+sincos"])),
            f"{own:.3g}",
            verdict(own, float(target) if target else None),
            f"{float(row['ratio_to_null_fmu']):.3g}",
            row["ratio_to_least"],
            row["instructions_per_step"],
            row["events_per_step"],
        )
        if row["fmpy_target"]:
            through = Ratio.of(measured.fmpy_seconds[name], measured.fmpy_seconds["null"])
            in_fmpy.add_row(name, str(through), verdict(through.median, FMPY_TARGET))
    legend = (
        "Median ratio (quartiles); limit: the work that cannot be left out; events: mode changes per step"
    )
    console.print(legend, in_c, in_fmpy, sep="\n")
    say(console, *(f"{scene.name}: {scene.description}" for scene in cast))
    microseconds = statistics.median(measured.fmpy_seconds["null"]) * 1e6
    say(console, f"A step of the null FMU through FMPy takes {microseconds:.2f} us.")


def picture(rows: Sequence[Mapping[str, str]], facts: Mapping[str, str], path: Path) -> None:
    """A bar per scene, with its limit."""
    shown = [row for row in rows if row["scene"] not in ("dependent", "evaluation")]
    figure, (panel,) = pictures.blank(10.5, 0.31 * len(shown) + 1.6)
    for place, row in enumerate(reversed(shown)):
        nanoseconds = float(row["ns_per_step"])
        own = row["scene"] not in ("exp+sincos", "null")
        panel.barh(place, nanoseconds, 0.62, color=pictures.ACCENT if own else pictures.PALE)
        panel.text(1.08 * nanoseconds, place, f"{nanoseconds:,.0f} ns", va="center", fontsize=8)
        if row["least_ns"]:
            limit = float(row["least_ns"])
            panel.plot([limit, limit], [place - 0.38, place + 0.38], color="black", lw=2.2)
    panel.plot([], [], color="black", lw=2.2, label="limit: the work that cannot be left out")
    panel.set_yticks(range(len(shown)), [row["scene"] for row in reversed(shown)], fontsize=9)
    panel.set_xscale("log")
    panel.set_xlim(3.0, 3.0 * max(float(row["ns_per_step"]) for row in shown))
    panel.set_ylim(-0.8, len(shown) - 0.2)
    panel.grid(False, axis="y")
    panel.set_xlabel("time of one step [ns]")
    panel.set_title("One step of 1 ms in C: set the torque, step, read angle and speed", fontsize=11)
    panel.legend(loc="upper right", frameon=True, fontsize=9)
    pictures.finish(figure, facts, path)
