"""Scenes with helical grooves, solved in closed form at 60 digits. Tests compare the FMU with them.

    python tests/support/exact_scenes.py      computes them: some minutes

They are kept in data/exact_scenes.json.gz, as the scenes of general_scenes.py are. The suite recomputes a few
of them to prove the file.
"""

from __future__ import annotations

from collections.abc import Iterator
from multiprocessing import Pool
from pathlib import Path

import general_scenes
import numpy as np
from general_scenes import Scene, regime, save, to_json
from reference import Refused, random_scene, simulate_exact

FILE = Path(__file__).resolve().parents[1] / "data" / "exact_scenes.json.gz"
CHUNKS, SCENES = 24, 10  # 240 scenes
TRIALS = 100  # scenes that are drawn for a chunk at most
AMBIGUOUS = "several flank pairs are consistent"  # no unique motion (Painleve's paradox)


def well_posed(chunk: int) -> Iterator[Scene]:
    """Random scenes that have one answer: not wedged while moving, no paradox."""
    found = 0
    for number in range(TRIALS):
        params, intervals = random_scene(np.random.default_rng([chunk, number]))
        try:
            points = simulate_exact(params, intervals)
        except Refused:
            continue
        if any(AMBIGUOUS in point.doubts for point in points):
            continue
        yield Scene(TRIALS * chunk + number, regime(params), params, intervals, points, {}, 0.0)
        found += 1
        if found == SCENES:
            return


def solved(chunk: int) -> list[Scene]:
    return list(well_posed(chunk))


def load() -> list[list[Scene]]:
    """The scenes of each chunk."""
    scenes = general_scenes.load(FILE.parent, FILE)
    return [[s for s in scenes if s.number // TRIALS == chunk] for chunk in range(CHUNKS)]


def main() -> None:
    with Pool() as pool:
        entries = [to_json(scene, {}) for scenes in pool.imap(solved, range(CHUNKS)) for scene in scenes]
    save(entries, FILE)


if __name__ == "__main__":
    main()
