"""The command: compiles, runs, compares, prints the table, writes CSV."""

from __future__ import annotations

import math
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import build_fmu
from trajectory_hash import (
    ARM,
    NATIVE,
    TARGETS,
    WINDOWS,
    X86,
    Missing,
    binary_of,
    emulator,
)

from benchmarks import platform_cost
from benchmarks.harness import core, results
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.fmu import Slave
from benchmarks.harness.repository import BENCHMARKS
from benchmarks.mechanisms import ELLIPSES, START, SWING, Parameters

FOLDER = BENCHMARKS / "platform_cost"
BUILT = core.BUILD / "platform_cost"
STEPS = 30  # of a block, less than a half swing
TIMED, REPEATS = 34, 1_000  # blocks: 10^6 steps in all, of which the fastest thousandth counts
COUNTED = 200  # blocks
COUNT = re.compile(r"instructions: (\d+)")
NANOSECONDS, INSTRUCTIONS = "ns", "instructions"

Row = dict[str, str]


@dataclass(frozen=True)
class Scene:
    """`torque`: the range of torques, as shares of the stick band; of slip, multiples of its upper edge."""

    name: str
    parameters: Parameters
    torque: tuple[float, float]


SCENES = (
    Scene("stick", START, (0.1, 0.9)),
    Scene("slip in helices (closed form)", SWING, (1.28, 1.32)),
    Scene("slip in ellipses (collocation)", {**ELLIPSES, **START}, (1.28, 1.32)),
)


class Case:
    """A scene as words for the program, from the FMU's own description and stick band."""

    def __init__(self, scene: Scene) -> None:
        slave = Slave()
        slave.set(scene.parameters)
        slave.initialise()
        load, release = slave.real("torque_load"), slave.real("torque_release")
        begin = 0.0 if scene.torque[0] > 1.0 else release  # slip: multiples of the upper edge
        low, high = (begin + share * (load - begin) for share in scene.torque)
        self.name, self.guid = scene.name, slave.description.guid
        self.words = [repr(low), repr(high)]
        self.words += [f"{name}={slave.references[name]}" for name in ("tau", "theta", "events")]
        for name, value in scene.parameters.items():
            text = repr(float(value)) if slave.types[name] == "Real" else str(value)
            self.words.append(f"{name}={slave.references[name]}={text}")


def program(platform: str) -> Path:
    target = TARGETS[platform]
    product = BUILT / f"steps-{target}.exe"
    flags = ["-O2", "-target", target, "-D_POSIX_C_SOURCE=199309L", f"-I{BENCHMARKS}", f"-I{NATIVE}"]
    flags += [] if platform == WINDOWS else ["-ldl"]
    build_fmu.compile_c(build_fmu.ZIG, flags, [FOLDER / "steps.c"], product)
    return product


def counter(qemu: str) -> Path:
    """The plugin for this version of qemu."""
    text = subprocess.run([qemu, "--version"], capture_output=True, text=True).stdout
    version = re.search(r"version (\d+)", text)
    if version is None:
        raise Missing(f"{qemu} names no version")
    product = BUILT / "count_instructions.so"
    flags = ["-O2", "-shared", "-fPIC", f"-DPLUGIN_VERSION={1 if int(version[1]) < 9 else 2}"]
    build_fmu.compile_c(build_fmu.ZIG, flags, [FOLDER / "count_instructions.c"], product)
    return product


class Runner:
    """The program of a platform. `emulated`: the words before the program's."""

    def __init__(self, platform: str, emulated: Sequence[str]) -> None:
        self.platform, self.root = platform, "Z:" if platform == WINDOWS else ""
        self.binary = binary_of(platform, core.FORWARD)
        if not self.binary.exists():
            raise Missing("the binary is not built: ./build.sh run all")
        self.words = [*emulated, str(program(platform))]
        self.reached: dict[str, str] = {}

    def run(self, case: Case, repeats: int, blocks: int, steps: int) -> tuple[float, str, str]:
        """Seconds of the blocks, the last angle and the number of mode changes, what the plugin says."""
        words = [*self.words, f"{self.root}{self.binary}", case.guid]
        words += [*map(str, (repeats, blocks, steps)), *case.words]
        environment = {**os.environ, "WINEPREFIX": str(BUILT / "wine"), "WINEDEBUG": "-all"}
        done = subprocess.run(words, capture_output=True, text=True, env=environment, timeout=300)
        if done.returncode != 0 or not done.stdout:
            raise SystemExit(f"{self.platform}: {case.name}: exit {done.returncode}\n{done.stderr[-2000:]}")
        seconds, angle, events = done.stdout.split()
        if steps > 0:
            self.reached[case.name] = f"{angle} after {events} mode changes"
        return float(seconds), events, done.stderr

    def seconds(self, case: Case) -> tuple[float, float]:
        """Of the blocks with and without their steps; SystemExit if the mode changes inside a block."""
        (with_steps, after, _), (without, before, _) = (self.run(case, REPEATS, TIMED, n) for n in (STEPS, 0))
        if after != before:
            raise SystemExit(f"{self.platform}: {case.name}: the mode changes inside a block")
        return with_steps, without

    def instructions(self, case: Case) -> float:
        """Of one step."""
        counts = [int(COUNT.findall(self.run(case, 1, COUNTED, n)[2])[0]) for n in (STEPS, 0)]
        return (counts[0] - counts[1]) / (COUNTED * STEPS)


def timed(runners: Sequence[Runner], case: Case, rounds: int) -> list[float]:
    """Nanoseconds of a step: the least of all rounds, in which the platforms take turns."""
    least = [[math.inf, math.inf] for _ in runners]
    for _ in range(rounds):
        for k, runner in enumerate(runners):
            least[k] = [min(pair) for pair in zip(least[k], runner.seconds(case), strict=True)]
    return [1e9 * (both - without) / (TIMED * STEPS) for both, without in least]


def with_counter(qemu: str, words: Sequence[str]) -> list[str]:
    found = shutil.which(qemu)
    if found is None:
        raise Missing(f"{qemu} is not installed (Debian: qemu-user)")
    return [found, "-plugin", str(counter(found)), *words]


def rows_of(case: Case, quantity: str, platform: str, values: Sequence[float]) -> Row:
    here, there = values
    return {
        "scene": case.name,
        "platform": platform,
        "quantity": quantity,
        "linux_x86_64": f"{here:.1f}",
        "value": f"{there:.1f}",
        "ratio": f"{there / here:.3f}",
    }


def windows(cases: Sequence[Case], rounds: int) -> list[Row]:
    runners = [Runner(X86, []), Runner(WINDOWS, emulator(WINDOWS))]
    rows = [rows_of(case, NANOSECONDS, WINDOWS, timed(runners, case, rounds)) for case in cases]
    expect_equal(runners)
    return rows


def arm(cases: Sequence[Case]) -> list[Row]:
    runners = [
        Runner(X86, with_counter("qemu-x86_64", [])),
        Runner(ARM, with_counter("qemu-aarch64", emulator(ARM)[1:])),
    ]
    rows = [rows_of(case, INSTRUCTIONS, ARM, [r.instructions(case) for r in runners]) for case in cases]
    expect_equal(runners)
    return rows


def expect_equal(runners: Sequence[Runner]) -> None:
    if any(runner.reached != runners[0].reached for runner in runners):
        raise SystemExit(f"the platforms reach different bits: {[runner.reached for runner in runners]}")


def main() -> int:
    parser = results.options(platform_cost.__doc__, "platform_cost", 7)
    arguments = parser.parse_args()
    console, cases, rows = results.new_console(), [Case(scene) for scene in SCENES], list[Row]()
    BUILT.mkdir(parents=True, exist_ok=True)
    for name, measured in (
        (WINDOWS, lambda: windows(cases, arguments.rounds)),
        (ARM, lambda: arm(cases)),
    ):
        try:
            rows += measured()
        except Missing as reason:
            results.say(console, f"{name}: not run, {reason}")
    if not rows:
        return 1
    table = results.table("A step on other platforms", *rows[0])
    for row in rows:
        table.add_row(*row.values())
    console.print(table)
    results.publish(rows, circumstances("platforms"), arguments.output, console)
    return 0


if __name__ == "__main__":
    sys.exit(main())
