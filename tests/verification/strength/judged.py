"""Judged mutants in random scenes: does a mistake that counts as harmless move results beyond the tolerance?

    python -m verification.strength.judged [--count 600] [--only 90 117]

equivalent.toml judges some mutants by reasons: equivalent, cost only. This program runs them in the random
scenes of tests/verification/stress, and in such scenes on helices, with the library of the last
./build.sh run mutants.
The first pass has no mutant in force and notes the scenes in which a mistake makes a difference. A second
pass plays these scenes once again with the mistake. Results that differ by more than 100 tolerances, and by
more than ten times the change that data changed by a tolerance make, are listed: such a judgement is wrong.
Scenes in which the FMU without a mistake differs as much from its own run at a hundredth of the tolerance
show nothing and are left out.
"""

from __future__ import annotations

import argparse
import ctypes
import math
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness import core, results
from benchmarks.harness.oracles import driver
from benchmarks.harness.processes import TooLong, time_limit
from verification.processes import Lost, in_processes
from verification.strength import judgements, mutants, switch, tree
from verification.stress import families
from verification.stress.at_random import fuzz
from verification.stress.drive import drive
from verification.stress.judges import change_of_fmu, largest_error, sizes_of
from verification.stress.mechanisms import Tables
from verification.stress.scene import COMPARED, DEFAULT_TOLERANCE, Params, Scene, Trace

ROWS = ("laws", "loads", "dampers", "restitution", "stops", "tolerances", "fuzz", "fuzz_laws", "fuzz_loads")
COUNT = 600
LONGEST = 1.0  # s, of a scene without a mutant
SECONDS = 60.0  # of scenes for one mutant
HANG = 600.0  # s, after which the process of a mutant is ended
ALLOWED, AMPLIFIED = 100.0, 10.0  # tolerances; times the change by changed data
FINER = 100.0  # the run that decides between both
STEPS = (1, 2, 7)  # in an interval


@dataclass(frozen=True)
class Played:
    """A scene without a mutant."""

    scene: Scene
    trace: Trace
    differs: frozenset[int]  # mutants whose mistake makes a difference

    @property
    def tolerance(self) -> float:
        return self.scene.tolerance or DEFAULT_TOLERANCE


@dataclass
class Finding:
    """What a mutant does to the scenes in which its mistake makes a difference."""

    scenes: int = 0
    changed: int = 0  # scenes with any other result
    worst: float = 0.0  # tolerances
    wrong: list[str] = field(default_factory=list)


def extracted(folder: Path) -> Path:
    """The library of the forward FMU with all mutants."""
    path = folder / "mutants.so"
    with zipfile.ZipFile(tree.TREES / "mutants" / "build" / f"{core.FORWARD}.fmu") as archive:
        path.write_bytes(archive.read(f"binaries/linux64/{core.FORWARD}.so"))
    return path


def put_in_force(library: Any, number: int) -> None:
    ctypes.c_int.in_dll(library, switch.SYMBOL).value = number


# ---- without a mutant ----


def player(path: Path, count: int) -> Callable[[Scene], Played | None]:
    """`count`: bytes of the marks."""
    library = driver.load(path)
    marks = (ctypes.c_ubyte * count)()
    ctypes.c_void_p.in_dll(library, switch.MARKS).value = ctypes.addressof(marks)

    def play(scene: Scene) -> Played | None:
        """None where the scene shows nothing: refused, wrong, or too slow."""
        ctypes.memset(marks, 0, count)
        put_in_force(library, -1)
        begin = time.process_time()
        try:
            with time_limit(LONGEST):
                trace = drive(library, scene)
        except (TooLong, AssertionError):
            return None
        if trace.problems or not trace.read or time.process_time() - begin > LONGEST:
            return None
        return Played(scene, trace, frozenset(n for n, m in enumerate(marks) if m & switch.DIFFERS_BIT))

    return play


def base_runs(scenes: Sequence[Scene], path: Path, count: int, processes: int) -> Iterator[Played]:
    for _, found in in_processes(scenes, partial(player, path, count), processes, HANG):
        if isinstance(found, Played):
            yield found


# ---- with a mutant ----


def difference(played: Played, one: Trace, other: Trace) -> tuple[float, str]:
    """In tolerances, and where."""
    if len(one.read) != len(other.read):
        return math.inf, f"refused: {one.refusal or other.refusal}"
    largest = {n: max(one.largest.get(n, 0.0), other.largest.get(n, 0.0)) for n in COMPARED}
    size = sizes_of(largest, max(one.turnover, other.turnover))
    error, where = largest_error(played.scene, one.read, other.read, size)
    return error / played.tolerance, where


def is_firm(played: Played, library: Any) -> bool:
    """Without a mutant the result hardly depends on the tolerance."""
    finer = drive(library, replace(played.scene, tolerance=max(played.tolerance / FINER, 1e-12)))
    return difference(played, finer, played.trace)[0] <= ALLOWED


def data_move(played: Played, library: Any) -> float:
    """Tolerances."""
    largest = {n: played.trace.largest.get(n, 0.0) for n in COMPARED}
    size = sizes_of(largest, played.trace.turnover)
    return change_of_fmu(played.scene, played.trace, size, played.tolerance, library) / played.tolerance


def meet(number: int, played: Played, finding: Finding, library: Any) -> None:
    put_in_force(library, number)
    trace = drive(library, played.scene)
    put_in_force(library, 0)
    finding.scenes += 1
    finding.changed += trace.read != played.trace.read
    error, where = difference(played, trace, played.trace)
    if error <= ALLOWED and not trace.problems:
        finding.worst = max(finding.worst, error)
        return
    if not is_firm(played, library):
        return
    moved = data_move(played, library)
    if error > ALLOWED + AMPLIFIED * moved or trace.problems:
        text = f"{played.scene.row} {played.scene.label}, tolerance {played.tolerance:g}"
        problems = "".join(f"; {problem}" for problem in trace.problems)
        finding.wrong.append(f"{text}: {error:.1e} tolerances ({where}); data move {moved:.1e}{problems}")


def judge(path: Path, played: Sequence[Played], seconds: float) -> Callable[[int], Finding]:
    library = driver.load(path)

    def judged(number: int) -> Finding:
        finding, begin = Finding(), time.process_time()
        for one in played:
            if number in one.differs and time.process_time() - begin < seconds:
                meet(number, one, finding, library)
        return finding

    return judged


# ---- the command ----


def on_helices(rng: np.random.Generator, scene: Scene) -> Scene:
    """The scene on two helices, with linear forces: its motion has a closed form."""
    linear: Params = {name: 0.0 for name in ("spring.stiffness2", "spring.stiffness3")}
    linear |= {f"damper.q_{side}": 0.0 for side in ("load", "release")}
    for i in (1, 2):
        linear |= {f"cam{i}.profile": 1, f"cam{i}.lead_angle": float(rng.uniform(0.2, 1.2))}
    return replace(scene, params=scene.params | linear, label=f"{scene.label} on helices")


def drawn(count: int, folder: Path) -> list[Scene]:
    """Scenes of the shipped library, in random order, in one step or several for each interval."""
    rng = np.random.default_rng([31, 1])
    tables = Tables(folder)
    listed = [*families.collect(ROWS, count, tables), *(on_helices(rng, s) for s in fuzz(tables, count, 1))]
    shipped = [replace(s, steps=int(rng.choice(STEPS))) for s in listed if not s.general]
    return [shipped[k] for k in rng.permutation(len(shipped))]


def judged_numbers(places: mutants.Copy) -> dict[int, str]:
    """The mutants of equivalent.toml and their verdicts."""
    known = judgements.listed()
    found = {n: judgements.judgement_of(site, known) for n, site in places.places.items()}
    return {n: judgement.verdict for n, judgement in found.items() if judgement is not None}


def main(words: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--count", type=int, default=COUNT, help=f"scenes at random of each row ({COUNT})")
    parser.add_argument("--seconds", type=float, default=SECONDS, help=f"for one mutant ({SECONDS:g})")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--only", type=int, nargs="+", default=[], help="numbers of mutants")
    given = parser.parse_args(words)
    np.seterr(all="ignore")
    console, copy = results.new_console(), mutants.kept_copy()
    verdicts = judged_numbers(copy)
    numbers = given.only or sorted(verdicts)
    wrong = 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        path = extracted(folder)
        scenes = drawn(given.count, folder)
        played = list(base_runs(scenes, path, max(copy.places) + 1, given.processes))
        results.say(console, f"{len(played)} of {len(scenes)} scenes can be compared")
        work = partial(judge, path, played, given.seconds)
        for number, finding in in_processes(numbers, work, given.processes, HANG):
            site = copy.places[number]
            place = f"{number}: {site.file} {site.function}(): {site.original} -> {site.mutated}"
            if isinstance(finding, Lost):
                results.say(console, f"{place}\n    {finding.reason}")
                wrong += 1
                continue
            counts = f"{finding.scenes} scenes, {finding.changed} change, {len(finding.wrong)} wrong"
            verdict = verdicts.get(number, "")
            results.say(console, f"{place}\n    {verdict}: {counts}, else {finding.worst:.2g}")
            results.say(console, *(f"    {text}" for text in finding.wrong[:5]))
            wrong += bool(finding.wrong) and verdicts.get(number) != "survives"
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
