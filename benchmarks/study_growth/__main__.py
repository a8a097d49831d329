"""The command: measures, prints the results against their targets, writes the CSV file."""

from __future__ import annotations

import statistics
import sys
import tempfile
from pathlib import Path

import distributed
from rich.console import Console

from benchmarks import study_growth
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.timing import Ratio
from benchmarks.study_growth.measure import (
    FILE,
    TABLES,
    Costs,
    cluster_of,
    costs,
    on_dask,
    on_processes,
    over_tables,
    processor_time,
    throughput,
)
from benchmarks.study_growth.paper import STORES, grown, most_workers

LEAST_GROWTH = 1.8  # two workers over one
MOST_TABLES = 1.5  # 100 tables over one


def row(part: str, what: str, value: float, note: str = "") -> dict[str, str]:
    return {"part": part, "what": what, "value": f"{value:.4g}", "note": note}


def growth(rounds: int, files: int, console: Console) -> tuple[list[dict[str, str]], dict[str, Ratio]]:
    """Runs per second of one and two workers, in turns."""
    seconds: dict[str, dict[int, list[float]]] = {"processes": {1: [], 2: []}, "Dask": {1: [], 2: []}}
    for number in range(rounds):
        for count in (1, 2) if number % 2 else (2, 1):
            seconds["processes"][count].append(1.0 / throughput(on_processes(count), files * count))
            with cluster_of(count) as cluster, distributed.Client(cluster) as client:
                seconds["Dask"][count].append(1.0 / throughput(on_dask(client), files * count))
    lines, ratios = [], {}
    for kind, by_count in seconds.items():
        for count, taken in by_count.items():
            rate = 1.0 / statistics.median(taken)
            lines.append(row("throughput", f"{kind}, workers {count}, runs/s", rate))
            harness.say(console, f"{kind}, workers {count}: {rate:,.0f} runs/s")
        ratios[kind] = Ratio.of(by_count[1], by_count[2])
        lines.append(row("throughput", f"{kind}, two over one", ratios[kind].median, str(ratios[kind])))
        harness.say(console, f"{kind}: two workers are {ratios[kind]} times one")
    return lines, ratios


def processor_times(rounds: int, files: int, console: Console) -> list[dict[str, str]]:
    """Of a run with one and with two processes: what two free processors would make of them."""
    times = {count: [processor_time(count, files) for _ in range(rounds)] for count in (1, 2)}
    lines = [
        row("processor time", f"processes, workers {count}, us of a run", 1e6 * statistics.median(taken))
        for count, taken in times.items()
    ]
    free = 2.0 * statistics.median(times[1]) / statistics.median(times[2])
    lines.append(row("processor time", "processes, two over one if both processors are free", free))
    harness.say(console, f"By processor time two workers are {free:.2f} times one")
    return lines


def parts(found: Costs) -> list[dict[str, str]]:
    texts = {
        "values of the plan": found.rows,
        "runs": found.runs,
        "encoding": found.encode,
        "writing": found.write,
        "study, by pipe": found.study_by_pipe,
        "study and scheduler, by Dask": found.study_by_dask,
    }
    lines = [row("cost of a file", f"{what}, ms", 1e3 * value) for what, value in texts.items()]
    return [*lines, row("cost of a file", "size, MB", found.size / 1e6)]


def main() -> int:
    parser = harness.options(study_growth.__doc__, "study_growth", 5)
    parser.add_argument("--files", type=int, default=40, help="of a worker, in each round")
    arguments = parser.parse_args()
    console = harness.new_console()
    lines, ratios = growth(arguments.rounds, arguments.files, console)

    lines += processor_times(arguments.rounds, arguments.files, console)
    found = costs(arguments.rounds)
    lines += (shown := parts(found))
    table = harness.table(f"A file of {FILE:,} runs", "what", "value")
    for cost in shown:
        table.add_row(cost["what"], cost["value"])
    console.print(table)

    table = harness.table("On paper", "store", "orders", "workers", "runs per second", "limit")
    for each in grown(found):
        cells = each.store, each.travelling, f"{each.workers}", f"{each.runs_per_second:,.0f}", each.limit
        table.add_row(*cells)
        what = f"{each.store}, {each.travelling}, workers {each.workers}, runs/s"
        lines.append(row("on paper", what, each.runs_per_second, each.limit))
    console.print(table)
    for store in STORES:
        for group in (False, True):
            most, limit = most_workers(found, store, group)
            what = f"{store}, {'groups' if group else 'each file alone'}: growth ends at workers"
            lines.append(row("on paper", what, most, limit))
            harness.say(console, f"{what} {most:.0f}: {limit}")

    with tempfile.TemporaryDirectory() as folder:
        pairs = [[over_tables(count, Path(folder)) for count in (TABLES, 1)] for _ in range(arguments.rounds)]
    tables = Ratio.of([many for many, _ in pairs], [one for _, one in pairs])
    lines.append(row("groove tables", f"{TABLES} over one, time", tables.median, str(tables)))
    harness.say(console, f"{TABLES} groove tables take {tables} times as long as one")

    goals = {f"two workers on {kind}": ratio.median / LEAST_GROWTH for kind, ratio in ratios.items()}
    goals["groove tables"] = MOST_TABLES / tables.median
    harness.say(console, *(f"{goal}: {'met' if share >= 1.0 else 'MISSED'}" for goal, share in goals.items()))
    harness.publish(lines, circumstances("studygrowth", "distributed", "pyarrow"), arguments.output, console)
    return 0 if all(share >= 1.0 for share in goals.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
