"""The section on friction that depends on the sliding speed or the load."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.harness.markdown import Row, prose, read, rounded, table

RATIOS = {
    "ratio_per_communication_step": "per communication step",
    "ratio_per_collocation_step": "per collocation step",
}


def span(rows: Sequence[Row], column: str) -> str:
    ratios = sorted(float(row[column]) for row in rows)
    return f"{ratios[0]:.2f} to {ratios[-1]:.2f}"


def verdict(rows: Sequence[Row]) -> str:
    """How many mechanisms are within the target, per collocation step, for each law."""
    parts = []
    for law in dict.fromkeys(row["law"] for row in rows if row["target"]):
        found = [row for row in rows if row["law"] == law]
        met = sum(float(row["ratio_per_collocation_step"]) <= float(row["target"]) for row in found)
        spans = ", ".join(f"{span(found, column)} {what}" for column, what in RATIOS.items())
        parts.append(f"- {law}: {met} of {len(found)} rows meet the target. Ratios: {spans}.")
    return "\n".join(map(prose, parts))


def friction_cost(folder: Path) -> str:
    rows = read(folder, "friction_cost")
    by_speed, loaded = dict.fromkeys(row["target"] for row in rows if row["target"])
    cells = [
        [
            row["mechanism"],
            row["law"],
            row["cams"],
            rounded(row["instructions_per_communication_step"]),
            f"{float(row['collocation_steps_per_communication_step']):.2f}",
            f"{float(row['ratio_per_communication_step']):.2f}",
            f"{float(row['ratio_per_collocation_step']):.2f}",
        ]
        for row in rows
    ]
    head = [
        "mechanism",
        "law",
        "cams",
        "instructions",
        "collocation steps",
        "x Coulomb",
        "x, per collocation step",
    ]
    return "\n\n".join(
        [
            "## Friction that depends on speed or load",
            prose(
                f"""`./build.sh run friction` counts the instructions of a general step of 1 ms with static
                excess, Stribeck curve and lubricated branch, or with a coefficient that depends on the load,
                against the same step with Coulomb's law. The mechanisms are those of the section
                [One step](#one-step). Thirty steps lead through the fall of the Stribeck curve and beyond.
                The targets of this project for each collocation step are {by_speed} times Coulomb's law, and
                {loaded} times where friction depends on the load. A Stribeck curve bends the motion, and a
                bent motion needs more collocation steps."""
            ),
            verdict(rows),
            table(head, cells),
            prose(
                """Coulomb's law takes two sweeps over the nodes. Where friction varies, half a sweep at the
                middle and the end of the step gives the first iterate, and one sweep follows in most steps.
                With exponent 1 the excess falls as exp(-v/v_s), so that the exponential counts at most speeds
                of these scenes: four of them in each sweep. Coulomb's law on the cubic spring has a
                step with the largest speed inside, where seven nodes find the peak. Where friction varies, a
                second step of four nodes ends at the peak. A friction table has samples. A step ends at each
                sample, and halfway between two samples that are far apart: the length is an unknown of the
                step. Where friction depends on the load, each node takes one logarithm and one exponential
                for each contact more."""
            ),
            prose(
                """With a friction table over the load ln mu is, between two speeds and two loads, a
                polynomial of degree 5 in the speed and of degree 3 in the logarithm of the nominal load. A
                step ends where the nominal load passes a load of the table."""
            ),
        ]
    )
