"""One hash of all outputs over all scenes, for each platform and compiler that this machine can run.

    ./build.sh run hash [--quick] [word ...]

--quick: the binaries for this machine, and WebAssembly. Words: builds whose name has one of them, beside the
first build. tests/support/trajectory_hash.py plays the scenes. The exit code is 1 if a hash differs.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from trajectory_hash import QUICK, Build, Missing, all_builds, hashes, total, write_tables

from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import VERIFICATION

Row = dict[str, str]


def chosen(quick: bool, words: list[str]) -> list[Build]:
    first, *others = QUICK if quick else all_builds()
    return [first, *(build for build in others if not words or any(word in build.name for word in words))]


def row_of(build: Build, found: dict[str, str], first: dict[str, str]) -> Row:
    differing = sum(first.get(scene) != value for scene, value in found.items())
    return {
        "platform": build.platform,
        "compiler": build.compiler,
        "hash": total(found),
        "scenes": str(len(found)),
        "scenes_that_differ": str(differing),
    }


def main() -> int:
    parser = harness.options(__doc__, "trajectory_hash", folder=VERIFICATION / "results")
    parser.add_argument("--quick", action="store_true", help="this machine and WebAssembly only")
    parser.add_argument("words", nargs="*", help="words: builds whose name has one of them")
    arguments = parser.parse_args()
    console, first, rows = harness.new_console(), dict[str, str](), list[Row]()
    with tempfile.TemporaryDirectory() as folder:
        write_tables(Path(folder))
        for build in chosen(arguments.quick, arguments.words):
            try:
                found = hashes(build, Path(folder))
            except Missing as reason:
                harness.say(console, f"{build.name}: not run, {reason}")
                continue
            first = first or found
            rows.append(row_of(build, found, first))
            harness.say(console, f"{build.name}: {total(found)}")
    if not arguments.quick and not arguments.words:
        harness.publish(rows, circumstances("hash"), arguments.output, console)
    return int(any(row["hash"] != rows[0]["hash"] for row in rows))


if __name__ == "__main__":
    sys.exit(main())
