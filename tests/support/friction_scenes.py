"""Scenes with friction that depends on the sliding speed, solved by the reference simulator.

    python tests/support/friction_scenes.py      computes them: an hour

They are kept in data/friction_scenes.json.gz, as the scenes of general_scenes.py are, and chosen by the same
rules; the suite recomputes a few of them to prove the file.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import count
from multiprocessing import Pool
from pathlib import Path

import numpy as np
from general_scenes import Found, fit, save, to_json
from reference import random_friction_scene

FILE = Path(__file__).resolve().parents[1] / "data" / "friction_scenes.json.gz"
LOADED_FILE = FILE.with_name("friction_load_scenes.json.gz")  # friction depends on the load as well
WANTED, LOADED_WANTED = 173, 190
SEED = 18


def candidate(number: int, loaded: bool = False) -> Found | None:
    rng = np.random.default_rng([SEED, number])
    return fit(number, lambda folder: random_friction_scene(rng, number, folder, loaded), rng)


def loaded_candidate(index: int) -> Found | None:
    """The odd numbers."""
    return candidate(2 * index + 1, loaded=True)


def write(file: Path, draw: Callable[[int], Found | None], wanted: int) -> None:
    entries = []
    with Pool() as pool:
        for found in pool.imap(draw, count()):
            if found is None:
                continue
            entries.append(to_json(*found))
            if len(entries) == wanted:
                pool.terminate()
                break
    save(entries, file)


def main() -> None:
    write(FILE, candidate, WANTED)
    write(LOADED_FILE, loaded_candidate, LOADED_WANTED)


if __name__ == "__main__":
    main()
