"""The command: measures, prints the tables, writes CSV and picture."""

from __future__ import annotations

import ctypes
import sys

from benchmarks import integrators
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import DOCS
from benchmarks.integrators.measure import Result, cost_of_evaluation, measure
from benchmarks.integrators.methods import VARIANTS, Candidates
from benchmarks.integrators.results import picture, row_of, table_of
from benchmarks.integrators.scenes import scenes


def main() -> None:
    parser = harness.options(integrators.__doc__, "integrators", 21, DOCS / "integrators.png")
    parser.add_argument("--scene", default="", help="only scenes whose name begins so; writes no files")
    arguments = parser.parse_args()
    console = harness.new_console()
    candidates = Candidates()
    cast = [scene for scene in scenes() if scene.name.startswith(arguments.scene)]
    results: list[Result] = []
    for scene in cast:
        candidates.prepare(scene)
        mine, doubt = measure(candidates, scene, arguments.rounds, console)
        results += mine
        console.print(table_of(scene, mine, doubt))
    plain, full = (cost_of_evaluation(candidates, cast[0], partials) for partials in (False, True))
    fit = float(candidates.library.fit_error(ctypes.byref(cast[0].struct)))
    harness.say(
        console,
        VARIANTS,
        f"One alpha costs {plain:.2f}, with partial derivatives {full:.2f} (exp + sincos).",
        f"Polynomials of the transmission: relative error {fit:.1e}; Taylor uses the closed form.",
    )
    command = " ".join(["python -m benchmarks.integrators", *sys.argv[1:]])
    facts = circumstances("", "scipy") | {"command": command}
    if arguments.scene:
        harness.say_facts(facts, console)
        return
    picture(cast, results, arguments.picture)
    rows = [row_of(result) for result in results]
    harness.publish(rows, facts, arguments.output, console, arguments.picture)


if __name__ == "__main__":
    main()
