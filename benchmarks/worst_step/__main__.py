"""The command: measures, prints the tables, writes CSV and picture."""

from __future__ import annotations

import sys

from benchmarks import worst_step
from benchmarks.harness import instructions
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import RESULTS
from benchmarks.worst_step.results import picture, report, rows_of, rows_of_bound
from benchmarks.worst_step.scenes import scenes
from benchmarks.worst_step.study import study


def main() -> int:
    parser = harness.options(worst_step.__doc__, "worst_step", 5, RESULTS / "worst_step.png")
    parser.add_argument("--steps", type=int, default=1_000_000, help="per scene (10^6)")
    parser.add_argument(
        "--count", type=int, default=200, help="longest steps whose instructions are counted (200)"
    )
    arguments = parser.parse_args()
    console = harness.new_console()
    if not instructions.available():
        console.print(instructions.WITHOUT)
    studies = [study(s, arguments.steps, arguments.rounds, arguments.count, console) for s in scenes()]
    report(studies, console)
    facts = circumstances("worst")
    rows = [*(row for made in studies for row in rows_of(made)), *rows_of_bound()]
    picture(studies, facts, arguments.picture)
    harness.publish(rows, facts, arguments.output, console, arguments.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
