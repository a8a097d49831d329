"""The command: measures, prints the results against their targets, writes the CSV file."""

from __future__ import annotations

import statistics
import sys

from benchmarks import study_rate
from benchmarks.harness import core
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.timing import Ratio
from benchmarks.study_rate.measure import memory, profile, rates
from benchmarks.study_rate.study import RUNS, study
from dualcam.study.run.runner import Runner

MEMORY_MARGIN = 1.0  # MiB
TARGET_RATE, TARGET_IN_C, TARGET_NAIVE = 20_000.0, 0.7, 1000.0


def row(
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


def say_shares(times: dict[str, list[float]]) -> str:
    middle = {name: statistics.median(seconds) for name, seconds in times.items()}
    return f"Of a run of the cam {middle['cam, in C'] / middle['cam']:.0%} is in the FMU."


def main() -> int:
    parser = harness.options(study_rate.__doc__, "study_rate", 21)
    parser.add_argument("--runs", type=int, default=100_000, help="of the study whose memory is watched")
    arguments = parser.parse_args()
    console = harness.new_console()
    rows = study().plan.rows(0, RUNS)
    cam = Runner(study(core.FORWARD).job())
    times = rates(cam, rows, arguments.rounds, console)
    calls = ", ".join(f"{name[4:]} {value:.1f}" for name, value in profile(rows).items())
    early, late, rate = memory(arguments.runs)

    table = harness.table(
        "Load and release, one core", "way", "us per run", "runs per second", "rate / cam's"
    )
    ratios = {name: Ratio.of(times["cam"], seconds) for name, seconds in times.items()}
    lines: list[dict[str, str]] = []
    for name, seconds in times.items():
        median = statistics.median(seconds)
        table.add_row(name, f"{1e6 * median:.1f}", f"{1.0 / median:,.0f}", str(ratios[name]))
        lines.append(row(name, median, f"{ratios[name].median:.4g}"))
    lines.append(row(f"{arguments.runs} runs onto disk", 1.0 / rate, "", early, late))
    console.print(table)
    goals = {
        f"{TARGET_RATE:,.0f} runs a second": 1.0 / statistics.median(times["cam"]) / TARGET_RATE,
        f"{TARGET_IN_C} of the rate from C": 1.0 / ratios["cam, in C"].median / TARGET_IN_C,
        f"{TARGET_NAIVE:,.0f} times naive": 1.0 / ratios["naive"].median / TARGET_NAIVE,
        "no growth of memory": 1.0 if late - early < MEMORY_MARGIN else 0.0,
    }
    harness.say(
        console,
        say_shares(times),
        f"A run of the cam, us: {calls}",
        f"{arguments.runs:,} runs with results on disk as Parquet: {rate:,.0f} a second in one process; "
        f"at most {early:.1f} MiB in the second tenth of them, {late:.1f} in the last",
        *(f"{goal}: {'met' if share >= 1.0 else 'MISSED'} ({share:.0%})" for goal, share in goals.items()),
    )
    harness.publish(lines, circumstances("rate"), arguments.output, console)
    return 0 if all(share >= 1.0 for share in goals.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
