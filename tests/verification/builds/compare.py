"""Do two builds of the FMUs compute the same, bit for bit?

    ./build.sh run compare OLD_DIRECTORY [NEW_DIRECTORY]

Each directory holds DualCamForward.fmu, DualCamInverse.fmu and fmi3/ with both again, as `./build.sh` leaves
them in build/, the default for the new ones. The same scenes are played in both; all outputs and local
variables, derivatives, statuses and the number of log messages are compared at every communication point.
Neither the texts of messages nor the bytes of FMU states are compared. Exit code 1: something differs.

A child process plays the scenes. A scene in which one build takes longer than --patience allows ends the
child process; the next child process repeats the scene with the other build alone, then goes on. A scene in
which the old build hangs, or both do, and one with a step that only the old build refuses, are reported apart
and are no difference. Linux x86-64.
"""

from __future__ import annotations

import argparse
import multiprocessing
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path

from benchmarks.harness.repository import ROOT
from verification.builds import scenes
from verification.builds.fmu import Fmu, Instance, Names, Record
from verification.builds.play import Difference, compare, play
from verification.builds.scenes import FORWARD, INVERSE, Scene

MODELS = [(model, version) for version in (2, 3) for model in (FORWARD, INVERSE)]
OLD, NEW = "old", "new"
TIME_OF_MOVE = 2e-3  # s of CPU time, more than ten times what a move takes
PATIENCE_ELSEWHERE = 4.0  # times as much for scenes without early return: of these, no build hangs for ever
SCATTER = 7919  # a prime: its multiples modulo a group's size reach every scene, of all kinds early
LISTED = 5  # differences of a group that are shown, and variables
LISTED_OF_SCENE = 2  # differences
Fmus = Mapping[tuple[str, str, int], Fmu]  # by build, model, version of FMI


@dataclass(frozen=True)
class Group:
    title: str
    count: int
    make: Callable[[int, Path], Scene]  # of a number below `count`, and the folder for tables


@dataclass
class Outcome:
    """Of a group, or of one scene of it."""

    scenes: int = 0
    values: int = 0
    differences: int = 0
    shown: list[str] = field(default_factory=list)
    variables: Counter[str] = field(default_factory=Counter)  # that differ, how often
    apart: list[str] = field(default_factory=list)  # the old build, or both, hang; only the old one refuses

    def add(self, other: Outcome) -> None:
        self.scenes += other.scenes
        self.values += other.values
        self.differences += other.differences
        self.shown = (self.shown + other.shown)[:LISTED]
        self.variables += other.variables
        self.apart += other.apart

    def __str__(self) -> str:
        apart = f", {len(self.apart)} apart" if self.apart else ""
        return f"{self.scenes:6d} scenes {self.values:12,d} values {self.differences:9,d} differences{apart}"


# ---- groups ----


def groups(helical: int, general: int, share: float) -> list[Group]:
    """`share`: part of the scenes of the other groups that is played, of all kinds."""

    def part(title: str, count: int, make: Callable[[int, Path], Scene]) -> Group:
        played = max(1, round(share * count))
        return Group(title, played, lambda k, folder: make(SCATTER * k % count, folder))

    found = [part("mechanisms of the tests", scenes.KNOWN_SCENES, scenes.known_scene)]
    for fine in (False, True):
        for number, tolerance in enumerate(scenes.TOLERANCES):
            every = 4 if fine else 1
            title = f"tests/data, tolerance {tolerance:g}, {'1 ms' if fine else 'coarse'} steps"
            make = partial(_every, number if fine else 0, every, tolerance, fine)
            found.append(part(title, scenes.KEPT_SCENES // every, make))
    return [
        *found,
        Group("random helices", helical, partial(scenes.random_scene, True)),
        Group("random grooves", general, partial(scenes.random_scene, False)),
        part("inverse", 600, scenes.inverse_scene),
        part("model exchange", 400, scenes.exchange_scene),
        part("FMI 3.0", 300, scenes.plain_3_scene),
        part("FMI 3.0, early return", 200, scenes.early_return_scene),
        part("curved torques", 100, scenes.curved_scene),
        part("all derivatives", 40, scenes.probing_scene),
        part("refused values", 400, scenes.refused_scene),
    ]


def _every(first: int, every: int, tolerance: float, fine: bool, number: int, folder: Path) -> Scene:
    return scenes.kept_scene(first + every * number, folder, tolerance, fine)


# ---- builds ----


def fmu_path(directory: Path, model: str, version: int) -> Path:
    return directory / ("fmi3" if version == 3 else "") / f"{model}.fmu"


def load(
    directories: Mapping[str, Path], folder: Path
) -> tuple[Fmus, dict[tuple[str, int], Names], list[str]]:
    """The FMUs of both builds; what is read of each model; variables that only one of both builds has."""
    fmus, names, missing = {}, {}, []
    for model, version in MODELS:
        for build, directory in directories.items():
            path = fmu_path(directory, model, version)
            fmus[build, model, version] = Fmu(path, folder / build / str(version) / model, version)
        old, new = fmus[OLD, model, version], fmus[NEW, model, version]
        names[model, version] = _common(old.names(), set(new.variables))
        for name in sorted(old.variables.keys() ^ new.variables.keys()):
            where = OLD if name in old.variables else NEW
            missing.append(f"{model}, FMI {version}: only the {where} build has the variable {name}")
    return fmus, names, missing


def _common(names: Names, known: set[str]) -> Names:
    def kept(group: Sequence[str]) -> tuple[str, ...]:
        return tuple(name for name in group if name in known)

    return Names(
        kept(names.reals), kept(names.integers), kept(names.booleans), kept(names.step), kept(names.outputs),
        kept(names.unknowns), kept(names.knowns), names.states, names.indicators,
    )  # fmt: skip


def compare_sizes(fmus: Fmus, names: Mapping[tuple[str, int], Names]) -> Outcome:
    """Of serialized FMU states, right after the start."""
    outcome = Outcome()
    for model, version in MODELS:
        sizes = []
        for build in (OLD, NEW):
            instance = Instance(fmus[build, model, version], names[model, version], Record(), "co-simulation")
            instance.start({}, None)
            sizes.append(instance.serialized_size(instance.take_state()))
            instance.free()
        title = f"{model}, FMI {version}"
        old, new = sizes
        found = [Difference(title, 0.0, "size of a serialized state", old, new)] if old != new else []
        outcome.add(Outcome(1, 1, len(found), [str(d) for d in found]))
    return outcome


# ---- child processes play the scenes ----


@dataclass(frozen=True)
class Job:
    fmus: Fmus
    names: Mapping[tuple[str, int], Names]
    folder: Path  # for tables
    tolerance: float
    patience: float  # s of CPU time, for one scene in one build; to it come TIME_OF_MOVE


@dataclass(frozen=True)
class Message:
    """From a child process: it begins to play that scene in `build`, or it has the outcome."""

    number: int
    title: str
    build: str
    outcome: Outcome | None = None


def judge(scene: Scene, old: Record, new: Record, tolerance: float) -> Outcome:
    found = compare(scene.title, old, new, tolerance)
    counted = [difference for difference in found if not difference.mended]
    shown = [str(difference) for difference in counted[:LISTED_OF_SCENE]]
    apart = [str(difference) for difference in found if difference.mended]
    variables = Counter(difference.what for difference in counted)
    return Outcome(1, old.values, len(counted), shown, variables, apart)


def _play_group(connection: Connection, job: Job, group: Group, first: int, skipped: frozenset[str]) -> None:
    """From scene `first` on; in that one, without the builds that were found to hang in it."""
    for number in range(first, group.count):
        scene = group.make(number, job.folder)
        key = scene.model, scene.version
        records: dict[str, Record] = {}
        for build in (OLD, NEW):
            if number == first and build in skipped:
                continue
            connection.send(Message(number, scene.title, build))
            limit = job.patience + TIME_OF_MOVE * len(scene.moves)
            limit *= 1.0 if scene.use == "early return" else PATIENCE_ELSEWHERE
            signal.setitimer(signal.ITIMER_PROF, limit)  # the timer's signal ends this process
            records[build] = play(job.fmus[build, *key], job.names[key], scene)
            signal.setitimer(signal.ITIMER_PROF, 0.0)
        outcome = Outcome(1)
        if len(records) == 2:
            outcome = judge(scene, records[OLD], records[NEW], job.tolerance)
        connection.send(Message(number, scene.title, "", outcome))


def _messages(receiver: Connection) -> Iterator[Message]:
    """Until the child process ends."""
    while True:
        try:
            yield receiver.recv()
        except EOFError:
            return


def _judge_ended(title: str, ended: Mapping[str, str]) -> Outcome:
    """Of a scene in which one build or both ended the process. A failure of the new build alone counts."""
    builds = " and ".join(f"{build} build: {why}" for build, why in ended.items())
    if set(ended) == {NEW}:
        return Outcome(differences=1, shown=[f"{title}: {builds}"])
    return Outcome(apart=[f"{title}: {builds}"])


def run(job: Job, group: Group) -> Outcome:
    """All scenes of the group, in one child process and one more for each time that a build hangs."""
    whole, first = Outcome(), 0
    ended: dict[str, str] = {}  # in scene `first`: by build, why the process ended
    while first < group.count:
        receiver, sender = multiprocessing.Pipe(duplex=False)
        arguments = sender, job, group, first, frozenset(ended)
        child = multiprocessing.get_context("fork").Process(target=_play_group, args=arguments)
        child.start()
        sender.close()
        last = Message(first, "", "")
        for last in _messages(receiver):
            if last.outcome is None:
                continue
            whole.add(last.outcome)
            if ended:
                whole.add(_judge_ended(last.title, ended))
            first, ended = last.number + 1, {}
        child.join()
        if child.exitcode == 0:
            continue
        if child.exitcode is None or child.exitcode > 0 or not last.build:
            raise RuntimeError(f"{group.title}, scene {first}: the process that plays it has failed")
        ended[last.build] = signal.Signals(-child.exitcode).name.replace("SIGPROF", "out of time")
        if len(ended) == 2:
            whole.add(Outcome(scenes=1))
            whole.add(_judge_ended(last.title, ended))
            first, ended = first + 1, {}
    return whole


# ---- command line ----


def parsed(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("old", type=Path, help="directory of the old build")
    new = ROOT / "build"
    parser.add_argument("new", type=Path, nargs="?", default=new, help="of the new build; default: build")
    parser.add_argument("--quick", action="store_true", help="a small part of the scenes")
    count = "number of random scenes with helices; a third as many with any grooves"
    parser.add_argument("--count", type=int, default=3000, help=count)
    parser.add_argument("--only", default="", help="only groups with this text in their title")
    parser.add_argument(
        "--tolerance",
        type=float,
        default=0.0,
        metavar="REL",
        help="a difference up to this part of the variable's largest value in the scene is none",
    )
    patience = (
        f"CPU time for one scene with early return in one build, s, beside {TIME_OF_MOVE:g} s for each step; "
        f"{PATIENCE_ELSEWHERE:g} times as much for others"
    )
    parser.add_argument("--patience", type=float, default=1.0, help=patience)
    given = parser.parse_args(arguments)
    for directory in (given.old, given.new):
        for model, version in MODELS:
            path = fmu_path(directory, model, version)
            if not path.exists():
                parser.error(f"{path} is missing: run ./build.sh in the tree of that build")
    return given


def main(arguments: Sequence[str] | None = None) -> int:
    given = parsed(arguments)
    helical, share = (given.count // 10, 0.1) if given.quick else (given.count, 1.0)
    whole, begin = Outcome(), time.perf_counter()

    def report(title: str, outcome: Outcome) -> None:
        print(f"{title:45} {outcome}", flush=True)
        for text in (*outcome.shown, *outcome.apart[:LISTED]):
            print(f"    {text}")
        if outcome.variables:
            common = outcome.variables.most_common(LISTED)
            print(f"    most often: {', '.join(f'{what} {number}' for what, number in common)}")
        whole.add(outcome)

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fmus, names, missing = load({OLD: given.old, NEW: given.new}, folder)
        report("variables", Outcome(0, len(names), len(missing), missing[:LISTED]))
        report("size of serialized states", compare_sizes(fmus, names))
        job = Job(fmus, names, folder, given.tolerance, given.patience)
        for group in groups(helical, helical // 3, share):
            if given.only in group.title:
                report(group.title, run(job, group))
    print(f"{'all':45} {whole}, {time.perf_counter() - begin:.0f} s")
    return int(whole.differences > 0)


if __name__ == "__main__":
    sys.exit(main())
