"""The command: counts SciPy's evaluations, measures, prints the tables, writes CSV and picture."""

from __future__ import annotations

import sys

from benchmarks import work_precision
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import RESULTS
from benchmarks.work_precision.results import TARGET_LEVEL, picture, report, verdicts, write
from benchmarks.work_precision.scenes import SCENES
from benchmarks.work_precision.study import evaluations, study

LIMIT = 1.0  # s for one run


def main() -> int:
    parser = harness.options(work_precision.__doc__, "work_precision", 5, RESULTS / "work_precision.png")
    parser.add_argument("--limit", type=float, default=LIMIT, help=f"s, for one run ({LIMIT:g})")
    parser.add_argument("--only", help="scenes whose name contains this; nothing is written")
    parser.add_argument("--evaluations", action="store_true", help="only count SciPy's evaluations")
    arguments = parser.parse_args()
    console = harness.new_console()
    chosen = [scene for scene in SCENES if (arguments.only or "") in scene.name]
    facts = circumstances("precision", "numpy", "scipy", "scikit-sundae", "pythonfmu")
    if not arguments.only:
        rows = [evaluations(scene, TARGET_LEVEL) for scene in chosen]
        harness.publish(rows, facts, arguments.output.with_name("evaluations.csv"), console)
    if arguments.evaluations:
        return 0
    studies = [study(scene, arguments.rounds, arguments.limit, console) for scene in chosen]
    report(studies, console)
    harness.say_facts(facts, console)
    if arguments.only:
        return 0
    write(arguments.output, studies, facts)
    picture(studies, facts, arguments.picture)
    harness.say(console, f"written: {arguments.output} and {arguments.picture}")
    return 1 if any(line.endswith("MISSED") for line in verdicts(studies)) else 0


if __name__ == "__main__":
    sys.exit(main())
