"""The section on the cost of one step."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.harness.markdown import Row, prose, read, rounded, row_of, table


def target_text(shown: Sequence[Row]) -> str:
    """Whose target the table has, and which rows miss the target."""
    missed = [row for row in shown if row["target"] and float(row["less_null_fmu"]) > float(row["target"])]
    names = ", ".join(f"`{row['scene']}` ({rounded(row['less_null_fmu'])})" for row in missed)
    rows = f"{len(missed)} rows miss their target: {names}." if missed else "All rows meet their target."
    return f"""The number behind "of" is a target that this project set for itself, in the same unit. {rows}
        A row without "of" has no target."""


def step_cost(folder: Path, picture: str) -> str:
    rows = read(folder, "step_cost")
    unit, null = row_of(rows, scene="exp+sincos"), row_of(rows, scene="null")
    shown = [row for row in rows if row["scene"] not in ("exp+sincos", "dependent", "null", "evaluation")]
    reasons = list(dict.fromkeys(row["least_is"] for row in shown if row["least_is"]))
    cells = [
        [
            row["scene"],
            rounded(row["ns_per_step"]),
            rounded(row["ratio_to_exp_sincos"]),
            rounded(row["less_null_fmu"]) + (f" (of {row['target']})" if row["target"] else ""),
            rounded(row["ratio_to_null_fmu"]),
            rounded(row["instructions_per_step"]),
            rounded(row["least_ns"])
            + (f" ({reasons.index(row['least_is']) + 1})" if row["least_is"] else ""),
            rounded(row["ratio_to_least"]),
            rounded(row["fmpy_ratio_to_null_fmu"]),
        ]
        for row in shown
    ]
    head = [
        "scene",
        "ns",
        "x exp+sincos",
        "less null FMU",
        "x null FMU",
        "instructions",
        "limit, ns",
        "x limit",
        "FMPy, x null FMU",
    ]
    paths = [row for row in shown if row["ratio_to_least"]]
    nearest, farthest = (f(paths, key=lambda row: float(row["ratio_to_least"])) for f in (min, max))
    text = [
        "## One step",
        f"![Time of one step]({picture})",
        prose(
            f"""One step sets the torque, steps 1 ms, reads angle and speed. One exp and one sincos, called
            for many numbers, take {rounded(unit["ns_per_step"])} ns on this machine. The three calls of an
            FMU that does nothing take {rounded(null["ns_per_step"])} ns. The acceleration in elliptical
            grooves with every force takes {rounded(row_of(rows, scene="evaluation")["ns_per_step"])} ns.
            "Less null FMU": the time without the three calls, in units of one exp and one sincos. Callgrind
            counts the instructions. Through FMPy the calls themselves take so long that the model hardly
            shows."""
        ),
        prose(target_text(shown)),
        table(head, cells),
        "The limit is the time of the work that cannot be left out, each part at its own price:",
        "\n".join(f"{number}. {reason}" for number, reason in enumerate(reasons, 1)),
        prose(
            f"""Nearest to the limit is `{nearest["scene"]}` ({rounded(nearest["ratio_to_least"])} times),
            farthest `{farthest["scene"]}` ({rounded(farthest["ratio_to_least"])} times). In slip of known
            step size the time above the limit is that of the checks that no event happens inside the step, of
            the ledger's accounts and peaks, and of sums carried with twice the digits. The checks are the
            reason why events are exact. In general grooves the time is that of two sweeps over the nodes, of
            the same checks and of the accounts. Nearly every operation of a sweep waits for the one before:
            the grooves' polynomials, the balance of forces, two integrals, three divisions. Therefore latency
            counts: compiled for vectors twice as wide (AVX) the step has fewer instructions and takes as
            long."""
        ),
        "Scenes:",
        "\n".join(f"- {row['scene']}: {row['what']}" for row in shown),
    ]
    return "\n\n".join(text)
