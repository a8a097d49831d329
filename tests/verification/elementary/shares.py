"""Which elementary functions the steps of the FMU call, and which share of the instructions these functions
take.

Callgrind counts calls and instructions in the scenes of benchmarks/step_cost, and in one of them with the
friction laws of benchmarks/friction_cost.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from rich.table import Table

from benchmarks.friction_cost import job, laws
from benchmarks.harness import core, instructions, results, steps
from benchmarks.harness.instructions import Counted
from benchmarks.step_cost.scenes import Scene, general_scenes, straight_scenes

PREFIX = "elementary_"
WITH_LAWS = "ellipses"
INTERNAL = ("log_near_one", "exp_at_limits", "reduce_exactly", "angle_at_limits", "tan_near_zero")


def scenes() -> Iterator[tuple[str, Scene]]:
    for scene in (*straight_scenes(), *general_scenes()):
        if not scene.separate:  # all steps, one after the other
            yield scene.name, scene
        if scene.name == WITH_LAWS:
            for law in laws():
                if law.cams == "both" and law.parameters:
                    changed = replace(scene, parameters=scene.parameters | law.parameters)
                    yield f"{scene.name}, {law.name}", changed


def row_of(name: str, count: int, counted: Counted) -> dict[str, str]:
    own = sum(n for f, n in counted.own.items() if f.startswith(PREFIX) or f in INTERNAL)
    calls = {f.removeprefix(PREFIX): n / count for f, n in counted.calls.items() if f.startswith(PREFIX)}
    return {
        "scene": name,
        "instructions_per_step": f"{counted.instructions / count:.0f}",
        "share_percent": f"{100.0 * own / counted.instructions:.2f}",
        "calls_per_step": "; ".join(f"{n:.2f} {f}" for f, n in sorted(calls.items())),
    }


def measure() -> list[dict[str, str]]:
    """One row for each scene; none without valgrind."""
    if not instructions.available():
        return []
    library = core.library_with_symbols(core.BUILD / "loops/DualCamForward-symbols.so")
    cast = list(scenes())
    counts = instructions.count_calls(steps.library(), [job(scene, library) for _, scene in cast])
    return [
        row_of(name, len(scene.steps), counted) for (name, scene), counted in zip(cast, counts, strict=True)
    ]


def table(rows: list[dict[str, str]]) -> Table:
    made = results.table("Calls of the core's functions in steps", "scene", "instr.", "share [%]", "calls")
    for row in rows:
        made.add_row(*row.values())
    return made
