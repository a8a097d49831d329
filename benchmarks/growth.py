"""How cost grows: with instances, steps, table points and threads; and what starting up costs.

    ./build.sh growth

Everything runs through growth.c, starting up in start_up.c, a process each. A step is: set tau, 1 ms, read
theta and omega; tau is to and fro, so that the cam slips, reverses and sticks. Times are medians over rounds
in which all sizes take their turn; memory is what the process gained (resident). What does not rise per unit
grows linearly.
"""

from __future__ import annotations

import argparse
import ctypes
import math
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from rich.console import Console

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / folder) for folder in ("fmu_src", "benchmarks")]
import build_fmu  # noqa: E402
import instructions  # noqa: E402
import pictures  # noqa: E402
import step_cost  # noqa: E402
from work_precision import circumstances  # noqa: E402

START_UP = ("load the library", "instantiate", "initialise", "first step")
TORQUES = (8.0, 1.0)  # N.m, 32 steps each
TABLE_WIDTH = 1.8  # rad
WORK = 100_000  # steps at least per timing
Row = tuple[str, str, float, float, float]  # what, unit, size, microseconds and bytes per unit


class MakerStruct(ctypes.Structure):
    """`Maker` of growth.c."""

    _fields_ = [
        *(
            (name, ctypes.c_void_p)
            for name in ("instantiate", "setup", "enter", "leave", "release", "set_real")
        ),
        ("initial", ctypes.c_uint),
        ("guid", ctypes.c_char_p),
        ("resources", ctypes.c_char_p),
        ("callbacks", ctypes.c_void_p),
    ]


def memory() -> int:
    """Bytes of this process in memory."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


class Growth:
    def __init__(self) -> None:
        library = build_fmu.BUILD / "growth.so"
        flags = [*build_fmu.TARGET, "-O3", "-fPIC", "-shared", "-fvisibility=hidden"]
        build_fmu.compile_c(build_fmu.ZIG, flags, [ROOT / "benchmarks/growth.c"], library)
        self.loops = ctypes.CDLL(str(library))
        self.loops.sweep.restype = ctypes.c_double
        self.slave = step_cost.Slave("DualCamForward")
        fmu = self.slave.fmu

        def address(name: str) -> int | None:
            return ctypes.cast(getattr(fmu.dll, "fmi2" + name), ctypes.c_void_p).value

        names = ("Instantiate", "SetupExperiment", "EnterInitializationMode", "ExitInitializationMode")
        self.maker = MakerStruct(
            *(address(name) for name in (*names, "FreeInstance", "SetReal")),
            self.slave.references["initial.theta"],
            fmu.guid.encode(),
            Path(fmu.unzipDirectory, "resources").as_uri().encode(),
            ctypes.addressof(fmu.callbacks),
        )
        self.struct = self.slave.struct()

    @contextmanager
    def instances(self, count: int) -> Iterator[tuple[ctypes.Array[ctypes.c_void_p], tuple[float, float]]]:
        """Initialised instances, and seconds of instantiating and of initialising all."""
        made, seconds = (ctypes.c_void_p * count)(), (ctypes.c_double * 2)()
        if self.loops.make(ctypes.byref(self.maker), ctypes.c_size_t(count), made, seconds) != 0:
            raise SystemExit("growth: an instance could not be made")
        yield made, (seconds[0], seconds[1])
        self.loops.release(ctypes.byref(self.maker), ctypes.c_size_t(count), made)

    def sweep(self, made: ctypes.Array[ctypes.c_void_p], steps: int, instant: float = 0.0) -> float:
        """Seconds in which every instance takes so many steps."""
        status = ctypes.c_int()
        seconds = self.loops.sweep(
            ctypes.byref(self.struct),
            made,
            ctypes.c_size_t(len(made)),
            ctypes.c_double(instant),
            ctypes.c_size_t(steps),
            (ctypes.c_double * 2)(*TORQUES),
            ctypes.byref(status),
        )
        if status.value != 0:
            raise SystemExit(f"growth: status {status.value}")
        return float(seconds)

    # ---- what grows ----

    def of_instances(self, largest: int) -> Iterator[Row]:
        for count in powers(1, largest):
            before = memory()
            with self.instances(count) as (made, (instantiate, initialise)):
                gained = memory() - before
                rounds = max(64, WORK // count // 64 * 64)
                stepped = self.sweep(made, rounds)
            yield "instances: instantiate", "instance", count, instantiate / count, gained / count
            yield "instances: initialise", "instance", count, initialise / count, math.nan
            yield "instances: step", "step", count, stepped / count / rounds, math.nan

    def of_steps(self, largest: int) -> Iterator[Row]:
        for count in powers(1, largest):
            repeats = max(1, min(1000, WORK // count))
            seconds, gained = 0.0, 0
            for _ in range(repeats):
                with self.instances(1) as (made, _times):
                    before = memory()
                    seconds += self.sweep(made, count)
                    gained = max(gained, memory() - before)
            yield "steps", "step", count, seconds / repeats / count, gained / count

    def of_threads(self) -> Iterator[Row]:
        """Each thread steps 100 instances of its own; time is that of all."""
        for count in (1, 2):
            pools = [self.instances(100) for _ in range(count)]
            made = [pool.__enter__()[0] for pool in pools]
            threads = [threading.Thread(target=self.sweep, args=(own, 6400)) for own in made]
            start = time.perf_counter()
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            seconds = time.perf_counter() - start
            for pool in pools:
                pool.__exit__(None, None, None)
            yield "threads", "step", count, seconds / count / 640_000, math.nan


def powers(smallest: int, largest: int) -> list[int]:
    return [10**k for k in range(10) if smallest <= 10**k <= largest]


def write_table(points: int) -> Path:
    path = build_fmu.BUILD / "growth" / f"{points}.csv"
    path.parent.mkdir(parents=True, exist_ok=True)
    psi = np.linspace(-0.2, TABLE_WIDTH - 0.2, points)
    start = math.sqrt(0.5)
    z = 0.05 * (np.sqrt(1.0 - (start - 0.4 * psi) ** 2) - start)
    rows = [f"{p!r},{h!r}" for p, h in zip(psi.tolist(), z.tolist(), strict=True)]
    path.write_text("\n".join(["psi_rad,z_m", *rows]) + "\n")
    return path


def of_tables(largest: int) -> Iterator[Row]:
    for points in powers(10, largest):
        table = str(write_table(points))
        slave = step_cost.Slave("DualCamForward")
        before = memory()
        start = time.perf_counter()
        slave.set({"cam1.profile": 3, "cam2.profile": 3, "cam1.table": table, "cam2.table": table})
        slave.set({"initial.theta": 0.7})
        slave.fmu.setupExperiment(tolerance=step_cost.TOLERANCE, startTime=0.0)
        slave.fmu.enterInitializationMode()
        slave.fmu.exitInitializationMode()
        seconds, gained = time.perf_counter() - start, memory() - before
        yield "table points: initialise", "point", points, seconds / points, gained / points
        scene = step_cost.Scene("", "", None, {}, step_cost.to_and_fro)
        torque = scene.torque(0.0, 0.0)
        run = step_cost.Run(step_cost.compile_loops(), slave, torque, scene.steps, 0.0)
        run.save()
        run.block()
        stepped = run.block()
        yield "table points: step", "step", points, stepped, math.nan
        knots = way_of(run) * (points - 1) / TABLE_WIDTH
        yield (
            "table points: knot passed",
            "step and knot",
            points,
            stepped / (1.0 + knots / len(run.steps)),
            math.nan,
        )
        slave.fmu.freeInstance()


def way_of(run: step_cost.Run) -> float:
    """How far theta turns in all, rad; each groove's psi by about half of that."""
    run.restore()
    instant, way, last = run.instant, 0.0, run.slave.real("theta")
    for tau, step in zip(run.torque.tolist(), run.steps.tolist(), strict=True):
        run.slave.set({"tau": tau})
        run.slave.fmu.doStep(instant, step)
        theta = run.slave.real("theta")
        instant, way, last = instant + step, way + abs(theta - last), theta
    return way


def start_up(rounds: int) -> Iterator[Row]:
    """In a fresh process each, from C: the first time everything is touched."""
    program = build_fmu.BUILD / "start_up"
    build_fmu.compile_c(
        build_fmu.ZIG, [*build_fmu.TARGET, "-O2", "-ldl"], [ROOT / "benchmarks/start_up.c"], program
    )
    slave = step_cost.Slave("DualCamForward")
    words = [str(program), *instructions.fmu_words(slave.fmu), str(slave.references["tau"])]
    runs = [list(map(float, subprocess.check_output(words, text=True).split())) for _ in range(rounds)]
    for name, seconds in zip(START_UP, zip(*runs, strict=True), strict=True):
        yield f"start-up: {name}", "call", 1, statistics.median(seconds), math.nan


PANELS = (
    ("Instances", ("instances: instantiate", "instances: initialise", "instances: step")),
    ("Steps", ("steps",)),
    ("Table points", ("table points: initialise", "table points: step", "table points: knot passed")),
)


def picture(rows: Sequence[Mapping[str, str]], facts: Mapping[str, str], path: Path) -> None:
    """Time per unit over the number of units, start-up beside it."""
    figure, panels = pictures.blank(13.0, 8.2, rows=2, columns=2)
    for panel, (title, whats) in zip(panels, PANELS, strict=False):
        for number, what in enumerate(whats):
            found = [row for row in rows if row["what"] == what]
            sizes, times = ([float(row[name]) for row in found] for name in ("size", "us_per_unit"))
            label = f"{what.split(': ')[-1].removesuffix('s')}, per {found[0]['unit']}"
            if float(found[-1]["bytes_per_unit"] or 0.0) > 1.0:
                label += f", {float(found[-1]['bytes_per_unit']):.0f} bytes"
            panel.loglog(sizes, times, "o-", color=f"C{number}", ms=4, label=label)
        panel.set_title(title, fontsize=11, pad=10)
        panel.set_xlabel(f"number of {title.lower()}")
        panel.set_ylabel("time per unit [us]")
        low, high = panel.get_ylim()
        panel.set_ylim(low / 2.0, high * 4.0)  # flat is to look flat, and the legend needs room
        panel.legend(loc="upper left", frameon=False, fontsize=9, ncol=2)
    bar, left = panels[-1], 0.0
    for number, name in enumerate(START_UP):
        time = next(float(row["us_per_unit"]) for row in rows if row["what"] == f"start-up: {name}")
        bar.barh(0, time, 0.5, left=left, color=f"C{number}", label=f"{name}, {time:.0f} us")
        left += time
    bar.set_ylim(-1.0, 1.4)
    bar.set_yticks([])
    bar.grid(False, axis="y")
    bar.set_xlabel("time [us]")
    bar.set_title(f"From nothing to the end of the first step: {left:.0f} us", fontsize=11, pad=10)
    bar.legend(loc="upper center", ncol=2, frameon=False, fontsize=9)
    pictures.finish(figure, facts, path)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--steps", type=int, default=10_000_000, help="largest number of steps (10^7)")
    parser.add_argument("--instances", type=int, default=100_000, help="largest number of instances (10^5)")
    parser.add_argument("--points", type=int, default=100_000, help="largest number of table points (10^5)")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--output", type=Path, default=ROOT / "benchmarks/results/growth.csv")
    parser.add_argument("--picture", type=Path, default=ROOT / "benchmarks/results/growth.png")
    arguments = parser.parse_args()
    console = Console() if sys.stdout.isatty() else Console(width=120)
    growth = Growth()
    studies: list[Callable[[], Iterator[Row]]] = [
        growth.of_threads,
        lambda: of_tables(arguments.points),
        lambda: growth.of_steps(arguments.steps),
        lambda: growth.of_instances(arguments.instances),
    ]
    found: dict[tuple[str, str, float], list[tuple[float, float]]] = {}
    for _ in range(arguments.rounds):
        for study in studies:
            for what, unit, size, seconds, gained in study():
                found.setdefault((what, unit, size), []).append((seconds, gained))
    for what, unit, size, seconds, gained in start_up(21):
        found[what, unit, size] = [(seconds, gained)]

    facts = circumstances("growth")
    table = step_cost.table(
        "Growth", "what", "size", "us per unit", "unit", "to the smallest", "bytes per unit"
    )
    rows: list[dict[str, str]] = []
    smallest: dict[str, list[float]] = {}
    for (what, unit, size), values in found.items():
        times = [seconds for seconds, _ in values]
        first = smallest.setdefault(what, times)
        ratio = statistics.median(a / b for a, b in zip(times, first, strict=True))
        largest = max(gained for _, gained in values)  # the first round: later ones reuse what is there
        gained_text = f"{largest:.0f}" if largest == largest else ""
        microseconds = f"{1e6 * statistics.median(times):.4g}"
        table.add_row(what, f"{size:g}", microseconds, unit, f"{ratio:.3g}", gained_text)
        rows.append(
            {
                "what": what,
                "size": f"{size:g}",
                "us_per_unit": microseconds,
                "unit": unit,
                "ratio_to_smallest": f"{ratio:.4g}",
                "bytes_per_unit": gained_text,
                **facts,
            }
        )
    console.print(table)
    picture(rows, facts, arguments.picture)
    step_cost.publish(rows, facts, arguments.output, console, arguments.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
