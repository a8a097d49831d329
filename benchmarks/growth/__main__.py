"""The command: measures, prints the table, writes CSV and picture."""

from __future__ import annotations

import sys

from benchmarks import growth
from benchmarks.growth.measure import Instances, of_tables, start_up
from benchmarks.growth.results import Found, picture, rows_of, table_of
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import RESULTS

STARTS = 21


def main() -> int:
    parser = harness.options(growth.__doc__, "growth", 5, RESULTS / "growth.png")
    parser.add_argument("--steps", type=int, default=10_000_000, help="largest number of steps (10^7)")
    parser.add_argument("--instances", type=int, default=100_000, help="largest number of instances (10^5)")
    parser.add_argument("--points", type=int, default=100_000, help="largest number of table points (10^5)")
    arguments = parser.parse_args()
    console = harness.new_console()
    instances = Instances()
    studies = (
        instances.of_threads,
        lambda: of_tables(arguments.points),
        lambda: instances.of_steps(arguments.steps),
        lambda: instances.of_instances(arguments.instances),
    )
    found: Found = {}
    for _ in range(arguments.rounds):
        for study in studies:
            for what, unit, size, seconds, gained in study():
                found.setdefault((what, unit, size), []).append((seconds, gained))
    for what, unit, size, seconds, gained in start_up(STARTS):
        found[what, unit, size] = [(seconds, gained)]
    rows, facts = rows_of(found), circumstances("growth", "numpy")
    console.print(table_of(rows))
    picture(rows, facts, arguments.picture)
    harness.publish(rows, facts, arguments.output, console, arguments.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
