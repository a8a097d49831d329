"""The command: studies all scenes, prints the tables, writes CSV and picture."""

from __future__ import annotations

import sys

from benchmarks import coupling
from benchmarks.coupling.results import TARGET, picture, report, rows_of
from benchmarks.coupling.scenes import SCENES
from benchmarks.coupling.study import study, worst_ratio
from benchmarks.harness import core
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import DOCS
from dualcam import Fmu


def main() -> int:
    arguments = harness.options(coupling.__doc__, "coupling", picture=DOCS / "coupling.png").parse_args()
    console = harness.new_console()
    with Fmu(core.fmu_path(core.FORWARD)) as slave:
        studies = [study(slave, scene, console) for scene in SCENES]
    report(studies, console)
    picture(studies, arguments.picture)
    rows = [row for made in studies for row in rows_of(made)]
    facts = circumstances("coupling", "numpy", "scipy")
    harness.publish(rows, facts, arguments.output, console, arguments.picture)
    return 0 if worst_ratio(studies) >= TARGET else 1


if __name__ == "__main__":
    sys.exit(main())
