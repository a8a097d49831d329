"""Runs per second and core of a parameter study: load-and-release of 0.4 s with nine parameters that vary.

    ./build.sh rate

One core, one process. Timed in turns as in benchmarks/step_cost.py, reported as the median over the rounds
with quartiles, all by dualcam.study unless it says otherwise:

cam             the forward FMU, begun with a saved state: what a user has
cam, reset      the same, begun with fmi2Reset
null            an FMU that does nothing, whose runs begin with fmi2Reset: Python and ctypes
cam, ramps      torque that rises and falls along ramps: driven oscillations instead of free ones
cam, in C       the calls of "cam" on the same values from a C loop (study_rate.c): what the FMU itself takes
null, in C      likewise
naive           fmpy.simulate_fmu for each run

Then what share of a run is the FMU's, and the best rate that this leaves to Python beside the do-nothing FMU;
where a run of the cam goes, call by call, as Python sees it; and whether the memory of a whole study with its
results on disk grows.
"""

from __future__ import annotations

import argparse
import ctypes
import statistics
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import fmpy
import numpy as np
from rich.console import Console

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / folder) for folder in (".", "fmu_src", "benchmarks")]
import build_fmu  # noqa: E402
import step_cost  # noqa: E402

from dualcam.fmu import Array  # noqa: E402
from dualcam.study import History, Plan, Scenario, Study, Vary  # noqa: E402
from dualcam.study.runner import Runner  # noqa: E402

RUNS = 4000  # in a timed block
NAIVE_RUNS = 10
MEMORY_MARGIN = 1.0  # MiB
TARGET_RATE, TARGET_NULL, TARGET_NAIVE = 20_000.0, 0.7, 1000.0
VARY = {
    "cam1.radius": Vary(0.015, 0.03),
    "cam2.radius": Vary(0.015, 0.03),
    "cam1.lead_angle": Vary(0.55, 1.0),
    "cam2.lead_angle": Vary(0.55, 1.0),
    "cam1.friction": Vary(0.05, 0.2),
    "cam2.friction": Vary(0.05, 0.2),
    "spring.preload": Vary(20.0, 100.0),
    "spring.stiffness": Vary(1e4, 8e4, log=True),
    "inertia.shaft": Vary(0.001, 0.02, log=True),
}
RESULTS = (
    "energy.spring@0.2",
    "energy.heat_cam1",
    "energy.heat_cam2",
    "peak.omega",
    "peak.reaction1",
    "efficiency",
)
HALF, TORQUE = 0.2, 8.0  # s, N.m
PIECES = History([0.0, HALF, HALF], [TORQUE, TORQUE, 0.0])
RAMPS = History([0.0, HALF, 2.0 * HALF], [0.0, TORQUE, 0.0])


def study(identifier: str, history: History = PIECES, runs: int = RUNS) -> Study:
    plan = Plan("sobol", VARY, runs, seed=1)
    scenario = Scenario(2.0 * HALF, {"tau": history}, step=HALF)  # the step that the do-nothing FMU asks for
    return Study(build_fmu.BUILD / f"{identifier}.fmu", plan, scenario, RESULTS)


def block(runner: Runner, rows: Array) -> float:
    start = time.perf_counter()
    made = runner.run(rows)
    seconds = time.perf_counter() - start
    assert not made.messages, made.messages
    return seconds / len(rows)


class Calls(ctypes.Structure):
    """`Study` of study_rate.c."""

    FUNCTIONS = (
        *("fmi2SetFMUstate", "fmi2Reset", "fmi2SetupExperiment", "fmi2EnterInitializationMode"),
        *("fmi2ExitInitializationMode", "fmi2SetReal", "fmi2DoStep", "fmi2GetReal"),
    )
    _fields_ = (
        *((name, ctypes.c_void_p) for name in FUNCTIONS),
        ("component", ctypes.c_void_p),
        ("state", ctypes.c_void_p),
        ("varied", ctypes.POINTER(ctypes.c_uint)),
        ("results", ctypes.POINTER(ctypes.c_uint)),
        ("varied_count", ctypes.c_size_t),
        ("results_count", ctypes.c_size_t),
        ("tau", ctypes.c_uint),
    )


def compile_loop() -> ctypes.CDLL:
    library = build_fmu.BUILD / "study_rate" / "loop.so"
    flags = ["-O2", "-fPIC", "-shared", *build_fmu.TARGET]
    build_fmu.compile_c(build_fmu.ZIG, flags, [ROOT / "benchmarks/study_rate.c"], library)
    loop = ctypes.CDLL(str(library))
    loop.seconds_study.restype = ctypes.c_double
    return loop


def in_c(loop: ctypes.CDLL, runner: Runner, rows: Array) -> Callable[[], float]:
    """Seconds of a run of the runner's FMU from C, whose results are the runner's."""
    library, fmu, state = runner._library, runner._fmu, runner._state

    def references(names: Sequence[str]) -> ctypes.Array[ctypes.c_uint]:
        return (ctypes.c_uint * len(names))(*(fmu.variable(name).valueReference for name in names))

    calls = Calls(
        *(ctypes.cast(getattr(library, name), ctypes.c_void_p) for name in Calls.FUNCTIONS),
        runner._component,
        state and state._address,
        references(list(VARY)),
        references([name.partition("@")[0] for name in RESULTS]),
        len(VARY),
        len(RESULTS),
        references(["tau"])[0],
    )
    values, results, status = np.ascontiguousarray(rows), np.empty((len(rows), len(RESULTS))), ctypes.c_int()

    def seconds() -> float:
        taken: float = loop.seconds_study(
            ctypes.byref(calls),
            values.ctypes.data_as(ctypes.c_void_p),
            ctypes.c_size_t(len(rows)),
            ctypes.c_double(TORQUE),
            ctypes.c_double(HALF),
            results.ctypes.data_as(ctypes.c_void_p),
            ctypes.byref(status),
        )
        assert status.value == 0
        return taken / len(rows)

    seconds()
    assert np.array_equal(results, runner.run(rows).values)
    return seconds


def naive(rows: Array) -> float:
    names = [(name, float) for name in ("time", "tau", "F_ext")]
    torque = np.array([(0.0, 8.0, 0.0), (0.2, 8.0, 0.0), (0.2, 0.0, 0.0)], dtype=names)
    start = time.perf_counter()
    for row in rows[:NAIVE_RUNS]:
        fmpy.simulate_fmu(
            str(build_fmu.BUILD / "DualCamForward.fmu"),
            stop_time=0.4,
            step_size=0.2,
            output_interval=0.2,
            start_values=dict(zip(VARY, row.tolist(), strict=True)),
            input=torque,
            output=[name.partition("@")[0] for name in RESULTS],
        )
    return (time.perf_counter() - start) / NAIVE_RUNS


def profile(runner: Runner, rows: Array) -> dict[str, float]:
    """Microseconds of a run by FMI function; the clock's own time is taken off."""
    clock = time.perf_counter
    totals: dict[str, float] = {}
    plain = list(runner.calls)

    def timed(call: Callable[[], int], name: str) -> int:
        start = clock()
        status = call()
        totals[name] += clock() - start
        return status

    for k, call in enumerate(plain):
        assert isinstance(call, partial)
        totals[call.func.__name__] = 0.0
        runner.calls[k] = partial(timed, call, call.func.__name__)
    runner.run(rows)
    runner.calls[:] = plain
    start = clock()
    for _ in rows:
        clock()
    tick = (clock() - start) / len(rows)
    names = [call.func.__name__ for call in plain if isinstance(call, partial)]
    return {name: 1e6 * (total / len(rows) - names.count(name) * tick) for name, total in totals.items()}


def resident() -> float:
    """MiB of this process that are in memory."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * 4096 / 2**20


def memory(runs: int) -> tuple[float, float, float]:
    """Most MiB during the second tenth of the chunks and during the last, and runs per second, of a study in
    this process. From chunk to chunk it goes up and down with what is being written."""
    whole = study("DualCamForward", runs=runs)
    whole.plan.rows(0, 1)  # the plan's own table is there from the start
    seen: list[float] = []
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        whole.make(
            folder, workers=0, form="csv", chunk=max(runs // 100, 1), each=lambda: seen.append(resident())
        )
    tenth = len(seen) // 10
    return max(seen[tenth : 2 * tenth]), max(seen[-tenth:]), runs / (time.perf_counter() - start)


def line(
    way: str, seconds: float, ratio: str, early: float | None = None, late: float | None = None
) -> dict[str, str]:
    return {
        "way": way,
        "us_per_run": f"{1e6 * seconds:.2f}",
        "runs_per_second": f"{1.0 / seconds:.0f}",
        "rate_over_cam": ratio,
        "MiB_second_tenth": "" if early is None else f"{early:.1f}",
        "MiB_last_tenth": "" if late is None else f"{late:.1f}",
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--rounds", type=int, default=21)
    parser.add_argument("--runs", type=int, default=100_000, help="of the study whose memory is watched")
    parser.add_argument("--output", type=Path, default=ROOT / "benchmarks/results/study_rate.csv")
    arguments = parser.parse_args()
    console = Console()
    rows = study("DualCamForward").plan.rows(0, RUNS)
    cam, null = (Runner(study(name).job()) for name in ("DualCamForward", "NullFmu"))
    loop = compile_loop()
    blocks: dict[str, Callable[[], float]] = {
        "cam": partial(block, cam, rows),
        "cam, reset": partial(block, Runner(study("DualCamForward").job(), saves_state=False), rows),
        "null": partial(block, null, rows),
        "cam, ramps": partial(block, Runner(study("DualCamForward", RAMPS).job()), rows),
        "cam, in C": in_c(loop, cam, rows),
        "null, in C": in_c(loop, null, rows),
        "naive": partial(naive, rows),
    }
    times = step_cost.in_turns(blocks, arguments.rounds, "runs", console)
    parts = profile(cam, rows)
    early, late, rate = memory(arguments.runs)

    facts = step_cost.circumstances("rate")
    table = step_cost.table(
        "Load and release, one core", "way", "us per run", "runs per second", "rate / cam's"
    )
    lines: list[dict[str, str]] = []
    ratios = {name: step_cost.Ratio.of(times["cam"], seconds) for name, seconds in times.items()}
    for name, seconds in times.items():
        median = statistics.median(seconds)
        table.add_row(name, f"{1e6 * median:.1f}", f"{1.0 / median:,.0f}", str(ratios[name]))
        lines.append(line(name, median, f"{ratios[name].median:.4g}") | facts)
    lines.append(line(f"{arguments.runs} runs onto disk", 1.0 / rate, "", early, late) | facts)
    console.print(table)
    middle = {name: statistics.median(seconds) for name, seconds in times.items()}
    python = middle["null"] - middle["null, in C"]
    most = middle["null"] / (python + middle["cam, in C"])
    inside = middle["cam, in C"] / middle["cam"]
    console.print(
        f"Of a run of the cam {inside:.0%} is in the FMU. If Python took no more "
        f"for it than for the do-nothing FMU, the rate would be {most:.2f} of that one's.",
        highlight=False,
    )
    calls = ", ".join(f"{name[4:]} {value:.1f}" for name, value in parts.items())
    console.print(f"A run of the cam, us: {calls}", highlight=False)
    console.print(
        f"{arguments.runs:,} runs with results on disk as CSV: {rate:,.0f} a second in one process; "
        f"at most {early:.1f} MiB in the second tenth of them, {late:.1f} in the last",
        highlight=False,
    )
    goals = {
        f"{TARGET_RATE:,.0f} runs a second": 1.0 / statistics.median(times["cam"]) / TARGET_RATE,
        f"{TARGET_NULL} of the do-nothing FMU's rate": 1.0 / ratios["null"].median / TARGET_NULL,
        f"{TARGET_NAIVE:,.0f} times naive": 1.0 / ratios["naive"].median / TARGET_NAIVE,
        "no growth of memory": 1.0 if late - early < MEMORY_MARGIN else 0.0,
    }
    for goal, share in goals.items():
        console.print(f"{goal}: {'met' if share >= 1.0 else 'MISSED'} ({share:.0%})", highlight=False)
    step_cost.publish(lines, facts, arguments.output, console)
    return 0 if all(share >= 1.0 for share in goals.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
