"""The worst of a million steps, for hardware in the loop: how long, how many instructions, what happens.

    ./build.sh worst

A run of 10^6 steps of 1 ms goes through stick, breakaway both ways, reversals, flank changes, both stops with
bounces, a follower force that turns the load around, torque and force that jump, ramps and swings, a torque
that alternates from step to step: segments of random kind, length and level. A step sets both inputs (and the
torque's rate, where it is a ramp), steps, reads angle and speed. The run is repeated from the same saved
state; the least time of each step over the rounds is the step's own, free of interrupts, which are never at
the same step twice.

Then callgrind counts the instructions of single steps (instructions.py), each from a saved state LEAD_IN
steps before: the longest steps, the longest with so many mode changes and of each kind, and as many at
random, which show how far time stands for instructions. What happens in a step is told by its modes, stop
heat and reactions before and after, read in a run of its own. Where there is no valgrind there are times
only.

bound() is what holds by construction: the product of the limits of all loops, as they are written in the C
sources.
"""

from __future__ import annotations

import argparse
import ctypes
import math
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.progress import track

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / folder) for folder in ("fmu_src", "benchmarks")]
import build_fmu  # noqa: E402
import instructions  # noqa: E402
import pictures  # noqa: E402
import slave  # noqa: E402
import step_cost  # noqa: E402

STEP = 1e-3  # s
LEAD_IN = 200  # steps before a counted one, which fill what is kept from step to step
STICK, LOADING, RELEASING, LOWER, UPPER, WEDGED = range(1, 7)
READ = ("theta", "omega", "energy.heat_stop", "cam1.reaction", "cam2.reaction")
RESULTS = ROOT / "benchmarks/results"

Array = NDArray[Any]


# ---- Scenes -------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scene:
    name: str
    what: str
    parameters: step_cost.Parameters


BOUNCING: step_cost.Parameters = {"stop.restitution": 0.5, "initial.theta": 0.7}


def scenes() -> list[Scene]:
    heavy = {**BOUNCING, **step_cost.DAMPED}
    forces = {**BOUNCING, **step_cost.FORCES}
    return [
        Scene("helices", "helical grooves, linear spring and damper, masses: closed form", heavy),
        Scene("ellipses", "elliptical grooves with every force", forces | step_cost.ELLIPSES),
        Scene("tables", "grooves as tables of 37 points with every force", forces | step_cost.tables()),
        Scene(
            "no inertia",
            "elliptical grooves without inertia, damper 500 N.s/m",
            {**BOUNCING, **step_cost.ELLIPSES, **step_cost.LIGHT, "inertia.shaft": 0.0},
        ),
    ]


@dataclass
class Program:
    """Inputs of every step."""

    tau: Array
    tau_rate: Array
    force: Array

    def __len__(self) -> int:
        return len(self.tau)


@dataclass(frozen=True)
class Levels:
    """What the inputs range over."""

    low: float  # N.m: presses to the lower stop
    high: float  # N.m: to the upper one
    pull: float  # N: more than the spring, so that the load turns around

    @classmethod
    def of(cls, parameters: step_cost.Parameters) -> Levels:
        """From torque and spring at the upper stop, where both are largest."""
        probe = step_cost.Slave("DualCamForward")
        probe.set(parameters)
        probe.set({"initial.theta": probe.real("stop.upper")})
        probe.fmu.setupExperiment(tolerance=step_cost.TOLERANCE, startTime=0.0)
        probe.fmu.enterInitializationMode()
        load = probe.real("torque_load")
        return cls(-0.3 * load, 1.2 * load, -1.5 * probe.real("spring.force"))


KINDS = ("hold", "ramp", "swing", "alternate", "up", "down", "pull", "pull ramp")


def segment(
    kind: str, count: int, last: float, levels: Levels, random: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Torque, its rate and the force of one segment."""
    t = STEP * np.arange(count)
    level, zero = random.uniform(levels.low, levels.high), np.zeros(count)
    flat = np.full(count, level)
    if kind == "ramp":
        rate = (level - last) / (STEP * count)
        return last + rate * t, np.full(count, rate), zero
    if kind == "swing":
        size, turn = 0.4 * levels.high * random.random(), 2.0 * math.pi * random.uniform(2.0, 40.0)
        rates = size * turn * np.cos(turn * t) if random.random() < 0.5 else zero
        return level + size * np.sin(turn * t), rates, zero
    if kind == "alternate":
        return np.where(np.arange(count) % 2, level, random.uniform(levels.low, levels.high)), zero, zero
    if kind in ("up", "down"):
        return np.full(count, levels.high if kind == "up" else levels.low), zero, zero
    if kind == "pull":
        return flat, zero, np.where(np.arange(count) // 10 % 2, random.uniform(levels.pull, 0.0), 0.0)
    if kind == "pull ramp":
        return flat, zero, np.linspace(0.0, random.uniform(levels.pull, 0.0), count)
    return flat, zero, zero


def program(count: int, levels: Levels, seed: int = 1) -> Program:
    random = np.random.default_rng(seed)
    parts: list[tuple[Array, Array, Array]] = []
    length, last = 0, 0.0
    while length < count:
        kind = KINDS[random.integers(len(KINDS))]
        parts.append(segment(kind, int(random.integers(20, 120)), last, levels, random))
        length += len(parts[-1][0])
        last = float(parts[-1][0][-1])
    tau, rate, force = (np.concatenate(columns)[:count] for columns in zip(*parts, strict=True))
    return Program(tau, rate, force)


# ---- The C loops --------------------------------------------------------------------------------------


class ReadingStruct(ctypes.Structure):
    """`Reading`."""

    _fields_ = [
        ("get_integer", ctypes.c_void_p),
        ("integers", ctypes.c_uint * 2),
        ("reals", ctypes.c_void_p),
        ("count", ctypes.c_size_t),
    ]


def compile_loops() -> Path:
    library = build_fmu.BUILD / "worst_step.so"
    flags = [*build_fmu.TARGET, "-O3", "-fPIC", "-shared", "-fvisibility=hidden"]
    build_fmu.compile_c(build_fmu.ZIG, flags, [ROOT / "benchmarks/worst_step.c"], library)
    return library


class Rig:
    """An instance at the start of the run."""

    def __init__(self, parameters: step_cost.Parameters, steps: Program) -> None:
        self.path, self.steps = compile_loops(), steps
        self.loops = ctypes.CDLL(str(self.path))
        self.loops.clock_seconds.restype = ctypes.c_double
        self.slave = step_cost.Slave("DualCamForward")
        self.slave.set(parameters)
        fmu = self.slave.fmu
        fmu.setupExperiment(tolerance=step_cost.TOLERANCE, startTime=0.0)
        fmu.enterInitializationMode()
        self.slave.set({"tau": float(steps.tau[0]), "F_ext": float(steps.force[0])})
        fmu.exitInitializationMode()
        self.state = fmu.getFMUState()
        self.rig = slave.rig_struct(fmu.dll, fmu.component, self.slave.references)

    def part(self, first: int, end: int) -> slave.ProgramStruct:
        columns = (self.steps.tau, self.steps.tau_rate, self.steps.force)
        return slave.ProgramStruct(*(c[first:].ctypes.data for c in columns), STEP, first, end - first)

    def run(self, loop: str, *arguments: object, first: int = 0, end: int | None = None) -> None:
        """All steps, or some that go on where it stands."""
        if end is None:
            self.slave.fmu.setFMUState(self.state)
            end = len(self.steps)
        program = self.part(first, end)
        failed = getattr(self.loops, loop)(ctypes.byref(self.rig), ctypes.byref(program), *arguments)
        if failed != 0:
            raise SystemExit(f"worst_step: {loop}: {failed} of {end - first} steps failed")

    def time(self, rounds: int, what: str, console: Console) -> Array:
        """Least seconds of each step."""
        least = np.full(len(self.steps), np.inf)
        for _ in track(range(rounds), what, console=console, transient=True):
            self.run("time_steps", step_cost.pointer(least))
        return np.maximum(least - self.loops.clock_seconds(), 0.0)

    def record(self) -> tuple[NDArray[np.int32], Array]:
        """Mode and events, and READ, after each step."""
        references = (ctypes.c_uint * len(READ))(*(self.slave.references[name] for name in READ))
        reading = ReadingStruct(
            slave.address(self.slave.fmu.dll, "fmi2GetInteger"),
            (ctypes.c_uint * 2)(self.slave.references["mode"], self.slave.references["events"]),
            ctypes.addressof(references),
            len(READ),
        )
        integers = np.zeros((len(self.steps), 2), dtype=np.int32)
        reals = np.zeros((len(self.steps), len(READ)))
        pointers = (ctypes.c_void_p(integers.ctypes.data), step_cost.pointer(reals))
        self.run("record_steps", ctypes.byref(reading), *pointers)
        return integers, reals

    def jobs(self, chosen: NDArray[np.intp]) -> list[instructions.Job]:
        """For instructions.count(): each of the chosen steps, in rising order, from the state LEAD_IN steps
        before."""
        fmu = self.slave.fmu
        fmu.setFMUState(self.state)
        found, here = [], 0
        for k in chosen.tolist():
            start = max(0, k - LEAD_IN)
            self.run("run_steps", first=here, end=start)
            here = start
            state = fmu.getFMUState()
            found.append(
                {
                    "loop": "run_steps",
                    "fmu": instructions.fmu_words(fmu),
                    "references": self.slave.references,
                    "states": [instructions.serialized(fmu, state)],
                    "tau": instructions.raw(self.steps.tau[start : k + 1]),
                    "tau_rate": instructions.raw(self.steps.tau_rate[start : k + 1]),
                    "force": instructions.raw(self.steps.force[start : k + 1]),
                    "step": STEP,
                    "first": start,
                }
            )
            fmu.freeFMUState(state)
        return found

    def count(self, chosen: NDArray[np.intp]) -> NDArray[np.int64]:
        """Instructions of the chosen steps; zeros where nothing can count them."""
        if not instructions.available():
            return np.zeros(len(chosen), dtype=np.int64)
        return np.array(instructions.count(self.path, self.jobs(chosen)))


# ---- What happens -------------------------------------------------------------------------------------


def plural(changes: int) -> str:
    return f"{changes} mode change" + ("" if changes == 1 else "s")


@dataclass
class History:
    """Of every step: mode before and after, mode changes, impacts, other flanks, and what the inputs do."""

    before: NDArray[np.int32]
    after: NDArray[np.int32]
    changes: NDArray[np.int32]
    impact: NDArray[np.bool_]
    flank: NDArray[np.bool_]
    jump: NDArray[np.bool_]
    ramp: NDArray[np.bool_]

    @classmethod
    def of(cls, integers: NDArray[np.int32], reals: Array, steps: Program) -> History:
        mode, events = integers.T
        before = np.concatenate(([STICK], mode[:-1]))
        heat, flank = reals[:, 2], np.signbit(reals[:, 3:])
        moved = np.concatenate(([False], (flank[1:] != flank[:-1]).any(axis=1)))
        end = steps.tau + STEP * steps.tau_rate
        return cls(
            before,
            mode,
            np.diff(events, prepend=0),
            np.diff(heat, prepend=0.0) > 0.0,
            moved,
            np.concatenate(([False], ~np.isclose(steps.tau[1:], end[:-1])))
            | (np.diff(steps.force, prepend=0.0) != 0),
            steps.tau_rate != 0.0,
        )

    def kinds(self) -> dict[str, NDArray[np.bool_]]:
        """Every kind of event, and the steps with it."""
        b, a = self.before, self.after
        slipping = np.isin(b, (LOADING, RELEASING))
        return {
            "stick throughout": (b == STICK) & (a == STICK) & (self.changes == 0),
            "slip throughout": slipping & (a == b) & (self.changes == 0) & ~self.flank & ~self.impact,
            "breakaway, loading": (b == STICK) & (a == LOADING),
            "breakaway, releasing": (b == STICK) & (a == RELEASING),
            "comes to rest": slipping & (a == STICK),
            "reversal": slipping & np.isin(a, (LOADING, RELEASING)) & (a != b) & ~self.impact,
            "flank change": self.flank & np.isin(a, (LOADING, RELEASING)) & (a == b),
            "impact, upper stop": self.impact & (b == LOADING),
            "impact, lower stop": self.impact & (b == RELEASING),
            "rests at the upper stop": (a == UPPER) & (b != UPPER),
            "rests at the lower stop": (a == LOWER) & (b != LOWER),
            "leaves a stop": np.isin(b, (LOWER, UPPER)) & np.isin(a, (LOADING, RELEASING)),
            "input jumps": self.jump,
            "input ramps": self.ramp,
        }

    def story(self, k: int) -> str:
        """What happens in step k."""
        names = ("", "stick", "loading", "releasing", "lower stop", "upper stop", "wedged")
        words = [f"{names[self.before[k]]} to {names[self.after[k]]}", plural(int(self.changes[k]))]
        facts = (
            (self.impact, "impact"),
            (self.flank, "other flank"),
            (self.jump, "input jumps"),
            (self.ramp, "ramp"),
        )
        return ", ".join(words + [word for found, word in facts if found[k]])


# ---- The bound ----------------------------------------------------------------------------------------


def limits() -> dict[str, float]:
    """Every limit of a loop in a step, by file and name, as the C sources have it."""
    found = {}
    for file in ("mechanism", "passage", "leap", "bernstein", "radau", "event"):
        for suffix in (".c", ".h"):
            source = ROOT / "fmu_src" / (file + suffix)
            text = source.read_text() if source.exists() else ""
            for body in re.findall(r"enum \{([^}]*=[^}]*)\}", text):
                for name, value in re.findall(r"(\w+) = (\d+)\b", body):
                    found[f"{file}.{name}"] = float(value)
            roots = [float(n) for n in re.findall(r"n < (\d+); n\+\+", text)]
            if roots:
                found[f"{file}.ROOT"] = max(roots)
            for name, value in re.findall(r"const double (LEAST_PROGRESS|SHORTEST) = ([\d.e-]+);", text):
                found[f"{file}.{name}"] = float(value)
    return found


@dataclass(frozen=True)
class Bound:
    """Of the general mechanism: how often each thing can happen at most inside the next."""

    searches: int  # leaps tried per leg, each a share shorter
    solves: int  # of the collocation equations in each of these
    evaluations: int  # of the balance of forces per solve
    legs: int  # per step: each to a mode change, a border of a piece, or as far as one leap can go
    play: int  # evaluations per solve without inertia and damping

    @property
    def solves_per_leg(self) -> int:
        return self.searches * self.solves + 3  # and the three peaks

    @property
    def evaluations_per_step(self) -> float:
        return float(self.legs) * self.solves_per_leg * self.evaluations


def bound() -> Bound:
    """passage_find() shortens by 8 from the time left to SHORTEST of it; solve_well() solves up to
    MAX_SHORTENINGS times, find_event() looks for each of the six watched events twice, and each time shortens
    the leap up to ITERATIONS times and nudges it NUDGES times; each solve iterates MAX_ITERATIONS times over
    RADAU_MAX nodes and starts from one more balance."""
    c = limits()
    watched = 6  # WATCH_COUNT
    searches = math.ceil(math.log(1.0 / c["passage.SHORTEST"], 8.0))
    find = 2 * watched * (c["passage.ITERATIONS"] + 1 + c["passage.NUDGES"])
    return Bound(
        searches=searches,
        solves=int(c["passage.MAX_SHORTENINGS"] + find),
        evaluations=int(c["leap.MAX_ITERATIONS"] * c["radau.RADAU_MAX"] + 1),
        legs=int(c["mechanism.MAX_EVENTS_PER_STEP"]),
        play=int((c["leap.ITERATIONS"] + 1) * c["radau.RADAU_MAX"]),
    )


def bound_of_closed_form() -> int:
    """Evaluations of the closed form per leg, in steps of up to half a period of the oscillation:
    first_descent() goes through two bows for speed (or band edge) and each contact, finds a zero of rate and
    of value in each; time_of_way() is one more root; peak_of() looks at the extrema of twice BOWS bows of the
    same three."""
    c = limits()
    root, bows = c["event.ROOT"], c["event.BOWS"]
    return int(3 * 2 * (2 * root + 2) + root + 3 * (2 * bows * (root + 1) + 1))


# ---- Measuring ----------------------------------------------------------------------------------------


@dataclass
class Study:
    scene: Scene
    seconds: Array
    history: History
    chosen: NDArray[np.intp]
    instructions: NDArray[np.int64]

    def counted(self, mask: NDArray[np.bool_]) -> int:
        """Most instructions among the counted steps of that mask; 0 if none was counted."""
        inside = mask[self.chosen]
        return int(self.instructions[inside].max()) if inside.any() else 0

    def counted_per_change(self, mask: NDArray[np.bool_]) -> int:
        """The same, of instructions over mode changes and one more: what lies between them."""
        inside = mask[self.chosen]
        each = self.instructions / (1 + self.history.changes[self.chosen])
        return int(each[inside].max()) if inside.any() else 0

    @property
    def uncounted(self) -> NDArray[np.bool_]:
        """The steps that were not counted."""
        mask = np.ones(len(self.seconds), dtype=bool)
        mask[self.chosen] = False
        return mask

    @property
    def worst(self) -> int:
        """Place in `chosen` of the step with most instructions, or of the longest where none are counted."""
        return int(np.argmax(self.instructions if self.instructions.any() else self.seconds[self.chosen]))


def longest(seconds: Array, count: int, mask: NDArray[np.bool_] | None = None) -> NDArray[np.intp]:
    inside = np.arange(len(seconds)) if mask is None else np.flatnonzero(mask)
    return inside[np.argsort(seconds[inside])[-count:]]


def choose(seconds: Array, history: History, count: int) -> NDArray[np.intp]:
    """The steps to count, rising."""
    masks = [history.changes == n for n in np.unique(history.changes)] + list(history.kinds().values())
    picked = [longest(seconds, count), *(longest(seconds, max(1, count // 10), mask) for mask in masks)]
    chance = np.random.default_rng(5).choice(len(seconds), min(count, len(seconds)), replace=False)
    return np.unique(np.concatenate([*picked, chance]))


def study(scene: Scene, count: int, rounds: int, counted: int, console: Console) -> Study:
    steps = program(count, Levels.of(scene.parameters))
    rig = Rig(scene.parameters, steps)
    history = History.of(*rig.record(), steps)
    seconds = rig.time(rounds, scene.name, console)
    chosen = choose(seconds, history, counted)
    return Study(scene, seconds, history, chosen, rig.count(chosen))


# ---- Results ------------------------------------------------------------------------------------------

CHANGES = (0, 1, 2, 3, 6, 11, 21, 41, math.inf)  # mode changes of a step, in groups
QUANTILES = (0.5, 0.9, 0.99, 0.999, 0.9999, 1.0)


def rows_of(made: Study) -> Iterator[dict[str, str]]:
    """Quantiles of the time, then each kind of step and each number of mode changes with what it costs at
    most."""

    def row(what: str, mask: NDArray[np.bool_], happens: str = "") -> dict[str, str]:
        times = made.seconds[mask]
        return {
            "scene": made.scene.name,
            "what": what,
            "steps": str(int(mask.sum())),
            "ns_median": f"{1e9 * np.median(times):.0f}" if len(times) else "",
            "ns_worst": f"{1e9 * times.max():.0f}" if len(times) else "",
            "instructions_worst": f"{n}" if (n := made.counted(mask)) else "",
            "instructions_per_change_worst": f"{n}" if (n := made.counted_per_change(mask)) else "",
            "happens": happens,
            "limit": "",
        }

    everything = np.ones(len(made.seconds), dtype=bool)
    yield row("not counted", made.uncounted)
    yield row("all", everything, made.history.story(int(made.chosen[made.worst])))
    for q in QUANTILES:
        at_least = made.seconds >= np.quantile(made.seconds, q, method="higher")
        yield {
            **row(f"quantile {q:g}", at_least),
            "ns_median": f"{1e9 * float(np.quantile(made.seconds, q)):.0f}",
        }
    for kind, mask in made.history.kinds().items():
        yield row(kind, mask)
    for low, high in pairwise(CHANGES):
        mask = (made.history.changes >= low) & (made.history.changes < high)
        name = (
            f"{low}" if high == low + 1 else f"{low} to {high - 1}" if high < math.inf else f"{low} and more"
        )
        yield row(plural(1) if name == "1" else f"{name} mode changes", mask)


def bound_rows() -> Iterator[dict[str, str]]:
    b, closed, c = bound(), bound_of_closed_form(), limits()
    empty = {"steps": "", "ns_median": "", "ns_worst": ""}
    for what, number, why in (
        ("legs per step", b.legs, "MAX_EVENTS_PER_STEP of mechanism.c: beyond, a step is refused"),
        ("searches per leg", b.searches, "passage_find(): shorter by 8 down to SHORTEST"),
        ("solves per search", b.solves, "MAX_SHORTENINGS + 2 x 6 watched events x (ITERATIONS + 1 + NUDGES)"),
        ("evaluations per solve", b.evaluations, "MAX_ITERATIONS x RADAU_MAX + 1"),
        (
            "evaluations per leg",
            b.solves_per_leg * b.evaluations,
            "their product, and three peaks",
        ),
        ("depth of halving", c["bernstein.MAX_DEPTH"], "MAX_DEPTH of bernstein.c: an interval without width"),
        ("jams per step", c["mechanism.MAX_JAMS_PER_STEP"], "MAX_JAMS_PER_STEP of mechanism.c"),
        ("evaluations per step", b.evaluations_per_step, "the product of all"),
        ("evaluations per solve, play", b.play, "without inertia and damping: (ITERATIONS + 1) x RADAU_MAX"),
        ("closed form: evaluations per leg", closed, "roots of at most 200 evaluations: event.c"),
        ("closed form: evaluations per step", float(b.legs) * closed, "the product"),
    ):
        yield {
            "scene": "bound",
            "what": what,
            **empty,
            "instructions_worst": "",
            "instructions_per_change_worst": "",
            "happens": why,
            "limit": f"{number:.6g}",
        }


COLOURS = ("C0", "C3", "C2", "C1")


def picture(studies: list[Study], facts: dict[str, str], path: Path) -> None:
    figure, (spread, relation) = pictures.blank(12.5, 5.2, columns=2)
    for made, colour in zip(studies, COLOURS, strict=False):
        seconds = np.sort(made.seconds)[::-1]
        share = np.arange(1, len(seconds) + 1) / len(seconds)
        keep = np.unique(np.geomspace(1, len(seconds), 600).astype(int)) - 1
        spread.loglog(1e6 * seconds[keep], share[keep], color=colour, lw=1.8, label=made.scene.name)
        spread.plot(1e6 * seconds[0], share[0], "o", color=colour, ms=6)
        times = 1e6 * made.seconds[made.chosen]
        if not made.instructions.any():
            continue
        relation.loglog(times, made.instructions, ".", color=colour, ms=3, alpha=0.5)
        w = made.worst
        relation.plot(times[w], int(made.instructions[w]), "o", color=colour, ms=7, label=made.scene.name)
    spread.set_xlabel("time of a step [us]")
    spread.set_ylabel("share of steps that take longer")
    spread.set_title(f"{len(studies[0].seconds):,} steps of 1 ms", fontsize=11)
    spread.legend(frameon=False)
    relation.set_xlabel("time of a step [us]")
    relation.set_ylabel("instructions")
    relation.set_title("Counted steps, with the worst of each run", fontsize=11)
    if any(made.instructions.any() for made in studies):
        relation.legend(frameon=False)
    else:
        relation.text(0.5, 0.5, instructions.WITHOUT, ha="center", transform=relation.transAxes)
    pictures.finish(figure, facts, path)


def report(studies: list[Study], console: Console) -> None:
    for made in studies:
        table = step_cost.table(
            f"{made.scene.name}: {made.scene.what}",
            "steps",
            "number",
            "ns, median",
            "ns, worst",
            "instructions, worst",
        )
        for row in rows_of(made):
            table.add_row(
                *(row[name] for name in ("what", "steps", "ns_median", "ns_worst", "instructions_worst"))
            )
        console.print(table)
        worst = int(made.chosen[made.worst])
        console.print(
            f"Worst: step {worst}, {made.instructions[made.worst]} instructions,"
            f" {1e6 * made.seconds[worst]:.2f} us: {made.history.story(worst)}",
            highlight=False,
        )
        missing = [kind for kind, mask in made.history.kinds().items() if not mask.any()]
        if missing:
            console.print(f"not met in this run: {', '.join(missing)}", highlight=False)
    b = bound()
    console.print(
        f"Bound: {b.evaluations_per_step:.2g} evaluations of the balance of forces in a step,"
        f" {b.solves_per_leg * b.evaluations:.2g} per leg of it.",
        highlight=False,
    )


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--steps", type=int, default=1_000_000, help="per scene (10^6)")
    parser.add_argument("--rounds", type=int, default=5, help="times that every step is timed (5)")
    parser.add_argument(
        "--count", type=int, default=200, help="longest steps whose instructions are counted (200)"
    )
    parser.add_argument("--output", type=Path, default=RESULTS / "worst_step.csv")
    parser.add_argument("--picture", type=Path, default=RESULTS / "worst_step.png")
    arguments = parser.parse_args()
    console = Console() if sys.stdout.isatty() else Console(width=120)
    if not instructions.available():
        console.print(instructions.WITHOUT)
    studies = [study(s, arguments.steps, arguments.rounds, arguments.count, console) for s in scenes()]
    report(studies, console)
    facts = step_cost.circumstances("worst")
    rows = [*(row for made in studies for row in rows_of(made)), *bound_rows()]
    picture(studies, facts, arguments.picture)
    step_cost.publish([{**row, **facts} for row in rows], facts, arguments.output, console, arguments.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
