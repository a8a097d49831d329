"""Scenes with friction that depends on the sliding speed, solved by the reference simulator.

    python tests/support/friction_scenes.py      computes them: an hour

They are kept in data/friction_scenes.json.gz, as the scenes of general_scenes.py are, and chosen by the same
rules; the suite recomputes a few of them to prove the file.
"""

from __future__ import annotations

import gzip
import json
import tempfile
from collections.abc import Callable
from itertools import count
from multiprocessing import Pool
from pathlib import Path

import numpy as np
from general_scenes import (
    FADING,
    LARGEST_ERROR,
    MEASURED,
    MOST_EVENTS,
    PROBE,
    STILL,
    Scene,
    Tables,
    differences,
    from_json,
    nudged,
    patience,
    regime,
    scales,
    to_json,
)
from reference import Refused, random_friction_scene, read_table, simulate

FILE = Path(__file__).resolve().parents[1] / "data" / "friction_scenes.json.gz"
LOADED_FILE = FILE.with_name("friction_load_scenes.json.gz")  # friction depends on the load as well
WANTED, LOADED_WANTED = 173, 190
SEED = 18


def candidate(number: int, loaded: bool = False) -> tuple[Scene, Tables] | None:
    """Scene `number` with its tables, or None if the scene is not fit for a test."""
    with tempfile.TemporaryDirectory() as folder:
        rng = np.random.default_rng([SEED, number])
        try:
            with patience():
                drawn = random_friction_scene(rng, number, folder, loaded)
                if drawn is None:
                    return None
                params, intervals = drawn
                points = simulate(params, intervals)
                if points[-1].events > MOST_EVENTS:
                    return None
                others = simulate(*nudged(params, intervals, rng), rtol=3e-13)
                apart = simulate(*nudged(params, intervals, rng, PROBE))
        except (Refused, ArithmeticError, ValueError, TypeError, TimeoutError):
            return None
        tables = {n: read_table(p) for n, p in params.items() if n.endswith(".table") and p}
    doubts = {doubt for p in (*points, *others) for doubt in p.doubts}
    same = [(p.mode, p.events) for p in points] == [(p.mode, p.events) for p in others]
    error, size = differences(points, others), scales(points)
    small = all(error[name] <= LARGEST_ERROR * size[name] for name in MEASURED)
    closed = all(abs(p.energy["residual"]) <= LARGEST_ERROR * size["energy.residual"] for p in points)
    if not (doubts <= {FADING, STILL} and (same or doubts) and small and closed):
        return None
    moved = differences(points, apart)
    condition = max(moved[n] / size[n] for n in MEASURED if not n.startswith("peak.")) / PROBE
    return Scene(number, regime(params), params, intervals, points, error, condition), tables


def loaded_candidate(index: int) -> tuple[Scene, Tables] | None:
    """The odd numbers."""
    return candidate(2 * index + 1, loaded=True)


def load(folder: str | Path, file: Path = FILE) -> list[Scene]:
    """All scenes of the file; their tables are written into `folder`."""
    return [from_json(entry, Path(folder)) for entry in json.loads(gzip.decompress(file.read_bytes()))]


def write(file: Path, draw: Callable[[int], tuple[Scene, Tables] | None], wanted: int) -> None:
    entries = []
    with Pool() as pool:
        for found in pool.imap(draw, count()):
            if found is None:
                continue
            entries.append(to_json(*found))
            if len(entries) == wanted:
                pool.terminate()
                break
    file.write_bytes(gzip.compress(json.dumps(entries, separators=(",", ":")).encode(), mtime=0))
    print(f"{len(entries)} scenes, {file.stat().st_size / 1000:.0f} kB in {file}")


def main() -> None:
    write(FILE, candidate, WANTED)
    write(LOADED_FILE, loaded_candidate, LOADED_WANTED)


if __name__ == "__main__":
    main()
