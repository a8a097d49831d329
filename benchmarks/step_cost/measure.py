"""Sets the scenes up and times them."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass

import numpy as np
from rich.console import Console

from benchmarks.harness import core, steps
from benchmarks.harness.fmu import Slave
from benchmarks.harness.steps import SeparateSteps, StepBlock
from benchmarks.harness.timing import in_turns, unit_block
from benchmarks.mechanisms import STEP, STEPS, jitter
from benchmarks.step_cost.evaluation import evaluation
from benchmarks.step_cost.scenes import Scene


def set_up(scene: Scene, loops: ctypes.CDLL) -> StepBlock:
    """An instance at the start of the timed steps."""
    slave = Slave()
    slave.set(scene.parameters)
    slave.enter_initialization()
    torque = scene.torque(slave.real("torque_release"), slave.real("torque_load"))
    slave.set({"tau": float(torque[0])})
    slave.fmu.exitInitializationMode()
    instant = 0.0
    for tau in torque[: scene.lead_in]:
        slave.set({"tau": float(tau)})
        slave.fmu.doStep(instant, STEP)
        instant += STEP
    return StepBlock(loops, slave, torque, scene.steps, instant)


def prepare(scene: Scene, loops: ctypes.CDLL) -> tuple[StepBlock | SeparateSteps, float]:
    """The block of a scene, ready to be timed, and its mode changes per step.

    SystemExit if the motion is not in the mode that the scene asks for."""
    block = set_up(scene, loops)
    if scene.separate:
        separate = SeparateSteps(block)
        return separate, separate.mode_changes / separate.count
    slave = block.slave
    block.save()
    first_mode, first_events = slave.integer("mode"), slave.integer("events")
    block.seconds()
    events = slave.integer("events") - first_events
    modes = {first_mode, slave.integer("mode")}
    if scene.mode is None and events == 0:
        raise SystemExit(f"{scene.name}: no mode change at all")
    if scene.mode is not None and (events != 0 or modes != {scene.mode}):
        raise SystemExit(f"{scene.name}: modes {modes} and {events} events, not mode {scene.mode} alone")
    return block, events / len(scene.steps)


@dataclass
class Measured:
    """Times per round by name: of the unit, the FMU that does nothing, one evaluation, and all scenes."""

    seconds: dict[str, list[float]]
    fmpy_seconds: dict[str, list[float]]
    instructions: dict[str, float]
    mode_changes: dict[str, float]  # per step


def measure(cast: list[Scene], rounds: int, fmpy_rounds: int, console: Console) -> Measured:
    loops = steps.load_loops()
    prepared = {scene.name: prepare(scene, loops) for scene in cast}
    blocks = {name: block for name, (block, _) in prepared.items()}
    null = StepBlock(loops, Slave(core.NULL), jitter(0.0, 1.0), np.full(STEPS, STEP), 0.0)
    seconds = in_turns(
        {
            "exp+sincos": unit_block(loops, "seconds_plain"),
            "dependent": unit_block(loops, "seconds_dependent"),
            "null": null.seconds,
            "evaluation": evaluation(),
            **{name: block.seconds for name, block in blocks.items()},
        },
        rounds,
        "in C",
        console,
    )
    through_fmpy = {
        scene.name: block.fmpy_seconds
        for scene in cast
        if scene.through_fmpy and isinstance(block := blocks[scene.name], StepBlock)
    }
    fmpy_seconds = in_turns({"null": null.fmpy_seconds, **through_fmpy}, fmpy_rounds, "through FMPy", console)
    counts = steps.instructions_per_step({"null": null, **blocks}, console)
    return Measured(seconds, fmpy_seconds, counts, {name: changes for name, (_, changes) in prepared.items()})
