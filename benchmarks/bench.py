"""All benchmarks in turn, then docs/performance.md from their results: about ten minutes.

    ./build.sh run bench [--quick] [PART ...]

Each part is a command of its own. It runs in a process of its own and writes a CSV file and a picture into
benchmarks/results, with machine, versions, commit and its command. A part that misses one of its targets
says so, and the next part begins. --quick makes few rounds and small sizes, to see that all parts work, and
writes into build/quick: its numbers are worth nothing.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

from benchmarks.harness.repository import DOCS, RESULTS, ROOT

QUICK = ROOT / "build" / "quick"


@dataclass(frozen=True)
class Part:
    command: str  # of `./build.sh run`
    name: str  # of the module and of its CSV file
    description: str
    quick: str  # arguments
    words: tuple[str, ...] = ()  # module and argument, where it is no module of this name
    drawn: bool = True

    def arguments(self, folder: Path, quick: bool) -> list[str]:
        if not quick:
            return []
        files = ["--output", str(folder / f"{self.name}.csv")]
        if self.drawn:
            files += ["--picture", str(folder / f"{self.name}.png")]
        return self.quick.split() + files


PARTS = (
    Part("cost", "step_cost", "the cost of a step", "--rounds 3 --fmpy-rounds 3"),
    Part("loop", "loop", "a control loop in Python", "--rounds 3", ("rates", "loop"), drawn=False),
    Part("skipping", "skipping", "the cost of each part where it is absent", "--rounds 3"),
    Part("worst", "worst_step", "the worst of a million steps", "--steps 5000 --rounds 2 --count 10"),
    Part("growth", "growth", "growth", "--steps 1000 --instances 100 --points 100 --rounds 2"),
    Part("precision", "work_precision", "run time against error", "--rounds 2 --limit 0.05"),
)


def run(part: Part, folder: Path, quick: bool) -> bool:
    """False if the part misses a target. SystemExit if it has written nothing."""
    written, begun = folder / f"{part.name}.csv", time.time()
    module, *words = part.words or (part.name,)
    command = [sys.executable, "-m", f"benchmarks.{module}", *words, *part.arguments(folder, quick)]
    done = subprocess.run(command, cwd=ROOT)
    if not written.exists() or written.stat().st_mtime < begun - 1.0:
        raise SystemExit(f"bench: {part.command} ended with {done.returncode} and has written nothing")
    return done.returncode == 0


def write_page(results: Path, folder: Path) -> None:
    """performance.md in `folder`, unless a quick run has not made the results of all parts."""
    missing = [part.command for part in PARTS if not (results / f"{part.name}.csv").exists()]
    if missing:
        print(f"== no page without the results of: {', '.join(missing)}")
        return
    page = folder / "performance.md"
    command = [sys.executable, "-m", "benchmarks.report", "--results", str(results), "--page", str(page)]
    subprocess.run(command, cwd=ROOT, check=True)


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("parts", nargs="*", metavar="PART", help=", ".join(part.command for part in PARTS))
    parser.add_argument("--quick", action="store_true", help="few rounds, into build/quick")
    parser.add_argument("--folder", type=Path, default=QUICK, help="where --quick writes")
    arguments = parser.parse_args()
    unknown = set(arguments.parts) - {part.command for part in PARTS}
    if unknown:
        parser.error(f"no such part: {', '.join(sorted(unknown))}")
    folder = arguments.folder.resolve() if arguments.quick else RESULTS
    chosen = [part for part in PARTS if not arguments.parts or part.command in arguments.parts]
    start, amiss = time.monotonic(), []
    for number, part in enumerate(chosen, 1):
        minutes = (time.monotonic() - start) / 60.0
        print(f"== {number} of {len(chosen)}: {part.description} (after {minutes:.1f} minutes)", flush=True)
        if not run(part, folder, arguments.quick):
            amiss.append(part.command)
    write_page(folder, folder if arguments.quick else DOCS)
    print(f"== {(time.monotonic() - start) / 60.0:.1f} minutes")
    if amiss:
        print(f"== a target is missed, see above: {', '.join(amiss)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
