"""Random scenes of the domain on the built FMU, judged by the reference.

PYTHONPATH=tests:tests/support python -m verification.domain.run --scenes 10000 --jobs 2
... --class self-locking --scenes 2000         scenes of one class alone
... --far --scenes 1000                        scenes far outside: nothing but robustness
... --seed 4711                                one scene again, with its data
"""

from __future__ import annotations

import argparse
import pprint
import time
from collections import Counter
from collections.abc import Iterator
from multiprocessing import Pool
from pathlib import Path
from typing import Any

from driver import ROOT, load

from .domain import REFUSED, SELF_LOCKING, UNIQUE
from .play import Outcome, judge, judge_far
from .reference import solve
from .scenes import draw_far, draw_scene

BINARY = ROOT / "build" / "linux64" / "DualCamForward.so"
_worker: dict[str, Any] = {}


def _open(binary: Path, tolerance: float, far: bool, kind: str | None) -> None:
    _worker.update(library=load(binary), tolerance=tolerance, far=far, kind=kind)


def _judge(seed: int) -> Outcome | None:
    """None where the scene is not of the class asked for."""
    if _worker["far"]:
        return judge_far(_worker["library"], seed, _worker["tolerance"])
    if _worker["kind"] not in (None, draw_scene(seed).verdict.kind):
        return None
    return judge(_worker["library"], seed, _worker["tolerance"])


def outcomes(options: argparse.Namespace) -> Iterator[Outcome]:
    """The first `options.scenes` outcomes, in the order of their seeds."""
    start = options.binary, options.tolerance, options.far, options.kind
    seeds, left = range(options.first, options.first + 1000 * options.scenes), options.scenes
    with Pool(options.jobs, _open, start) as pool:
        for outcome in pool.imap(_judge, seeds, chunksize=4):
            if outcome is None:
                continue
            yield outcome
            left -= 1
            if left == 0:
                pool.terminate()
                return


def table(found: list[Outcome]) -> str:
    lines = ["         class  scenes  wrong  refused  open     error       cut  residual"]
    for kind in sorted({o.kind for o in found}):
        rows = [o for o in found if o.kind == kind]
        judged = [o for o in rows if not o.open and not o.refusal]
        error, cut = (max((getattr(o, name) for o in judged), default=0.0) for name in ("error", "cut_error"))
        counts = (
            sum(bool(o.problems) for o in rows),
            sum(bool(o.refusal) for o in rows),
            sum(bool(o.open) for o in rows),
        )
        residual = max((o.residual for o in rows), default=0.0)
        lines.append(
            f"{kind:>14} {len(rows):7} {counts[0]:6} {counts[1]:8} {counts[2]:5}"
            f" {error:9.3g} {cut:9.3g} {residual:9.1e}"
        )
    for title, texts in (
        ("refused", [f"{o.kind}: {o.refusal}" for o in found if o.refusal]),
        ("open", [f"{o.kind}: {o.open}" for o in found if o.open]),
    ):
        lines += [f"{title}: {count} {text}" for text, count in Counter(texts).most_common()]
    return "\n".join(lines)


def replay(options: argparse.Namespace) -> Outcome:
    """Prints a scene's data, its reference solution and what the FMU shows."""
    _open(options.binary, options.tolerance, options.far, None)
    if options.far:
        pprint.pp(draw_far(options.seed), width=110)
    else:
        scene = draw_scene(options.seed)
        pprint.pp(scene, width=110)
        if scene.verdict.kind != REFUSED:
            pprint.pp(solve(scene.params, scene.intervals, scene.verdict.kind == UNIQUE), width=110)
    outcome = _judge(options.seed)
    assert outcome is not None
    pprint.pp(outcome, width=110)
    return outcome


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--scenes", type=int, default=1000)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--seed", type=int, help="this scene alone")
    parser.add_argument("--class", dest="kind", choices=[UNIQUE, SELF_LOCKING, REFUSED])
    parser.add_argument("--far", action="store_true", help="scenes far outside the domain")
    parser.add_argument("--tolerance", type=float, default=1e-9, help="relative, of the FMU")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--binary", type=Path, default=BINARY, help="shared library of DualCamForward")
    options = parser.parse_args()
    if options.seed is not None:
        return int(bool(replay(options).problems))
    started, found = time.perf_counter(), []
    for outcome in outcomes(options):
        found.append(outcome)
        if outcome.problems:
            print(f"seed {outcome.seed} ({outcome.kind}): {'; '.join(outcome.problems)}", flush=True)
    print(table(found))
    print(f"{time.perf_counter() - started:.0f} s")
    return int(any(o.problems for o in found))


if __name__ == "__main__":
    raise SystemExit(main())
