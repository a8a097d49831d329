"""The command: measures, prints the tables, writes CSV and picture."""

from __future__ import annotations

from benchmarks import step_cost
from benchmarks.harness import results
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import RESULTS
from benchmarks.step_cost.measure import measure
from benchmarks.step_cost.results import picture, report, rows_of
from benchmarks.step_cost.scenes import general_scenes, straight_scenes


def main() -> None:
    parser = results.options(step_cost.__doc__, "step_cost", 301, RESULTS / "step_cost.png")
    parser.add_argument("--fmpy-rounds", type=int, default=151, help="rounds of blocks through FMPy (151)")
    arguments = parser.parse_args()
    console = results.new_console()
    cast = [*straight_scenes(), *general_scenes()]
    measured = measure(cast, arguments.rounds, arguments.fmpy_rounds, console)
    rows, facts = rows_of(cast, measured), circumstances("cost")
    report(cast, measured, rows, console)
    picture(rows, facts, arguments.picture)
    results.publish(rows, facts, arguments.output, console, arguments.picture)


if __name__ == "__main__":
    main()
