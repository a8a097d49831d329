"""Parameters of the mechanisms that several benchmarks step, and torques for them. All else has its start
value."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from benchmarks.harness import core
from benchmarks.harness.timing import Array

STEP = 1e-3  # s
STEPS = 1000  # per block

Parameters = dict[str, float | str]

START: Parameters = {"initial.theta": 0.7}
# With so soft a spring and so wide stops the cam slips through a whole block: a half swing lasts about 1.7 s.
# The FMU does the same arithmetic at any stiffness > 0.
SWING: Parameters = {"spring.stiffness": 50.0, "stop.upper": 1000.0, "initial.theta": 1.0}
DAMPED: Parameters = {
    "damper.c_load": 20.0,
    "damper.c_release": 20.0,
    "inertia.follower_mass": 0.3,
    "inertia.follower": 3e-5,
}
ELLIPSES: Parameters = {"cam1.profile": 2, "cam2.profile": 2}
CUBIC: Parameters = {"spring.stiffness2": 1e6, "spring.stiffness3": 1e8}
FORCES: Parameters = {
    **CUBIC,
    **DAMPED,
    "damper.q_load": 50.0,
    "damper.q_release": 50.0,
    "shaft.damping": 0.002,
}
LIGHT: Parameters = {"damper.c_load": 500.0, "damper.c_release": 500.0}
VISCOUS: Parameters = {"inertia.shaft": 0.0, "damper.c_load": 5000.0, "damper.c_release": 5000.0}

TABLE_START, TABLE_WIDTH = -0.2, 1.8  # rad


def write_ellipse_table(path: Path, points: int) -> Path:
    """The elliptical groove of the start values, sampled at equal steps of psi."""
    path.parent.mkdir(parents=True, exist_ok=True)
    psi = np.linspace(TABLE_START, TABLE_START + TABLE_WIDTH, points)
    start = math.sqrt(0.5)
    z = 0.05 * (np.sqrt(1.0 - (start - 0.4 * psi) ** 2) - start)
    rows = [f"{p!r},{h!r}" for p, h in zip(psi.tolist(), z.tolist(), strict=True)]
    text = "\n".join(["psi_rad,z_m", *rows]) + "\n"
    if not path.exists() or path.read_text() != text:  # another process may be reading the file
        path.write_text(text)
    return path


def tables(points: int = 37) -> Parameters:
    """Both grooves as tables of the ellipse."""
    path = str(write_ellipse_table(core.BUILD / "tables" / f"ellipse_{points}.csv", points))
    return {"cam1.profile": 3, "cam2.profile": 3, "cam1.table": path, "cam2.table": path}


def jitter(low: float, high: float, count: int = STEPS) -> Array:
    """Uniform random numbers, the same in every run."""
    return np.random.default_rng(1).uniform(low, high, count)


# Torques [N.m] of every step of a block, given the edges of the stick band at its start.


def inside_band(release: float, load: float) -> Array:
    return release + (load - release) * jitter(0.1, 0.9)


def drive(release: float, load: float, count: int = STEPS) -> Array:
    """Slips all the time, loading."""
    return load * jitter(1.28, 1.32, count)


def to_and_fro(release: float = 0.0, load: float = 0.0) -> Array:
    """Sticks, slips both ways, meets the stop."""
    return 4.0 + 4.0 * np.sin(2.0 * math.pi * 5.0 * STEP * np.arange(STEPS))
