"""All that the benchmarks know about fmu_src: the build program, the sources and the limits of their
loops."""

from __future__ import annotations

import ctypes
import functools
import re
from collections.abc import Sequence
from pathlib import Path

import build_fmu

from benchmarks.harness.repository import BENCHMARKS, ROOT

FMU_SRC = ROOT / "fmu_src"

BUILD = build_fmu.BUILD
FORWARD = "DualCamForward"
NULL = "NullFmu"  # does nothing: its cost is that of the calls of FMI
HAND_WRITTEN = "HandWritten"
NO_CLOSED_FORM = "-DDUALCAM_NO_CLOSED_FORM"  # every motion is integrated

OPTIMISED = ("-O3", "-fvisibility=hidden")

# The limits of the loops of a step. Name in the benchmarks -> file of fmu_src without suffix (with its room,
# where the name alone is not unique), and the constant in it. An empty constant: the largest upper limit of a
# loop `for (...; n < limit; n++)`.
LOOP_LIMITS = {
    "segments per step": ("work", "MAX_SEGMENTS_PER_STEP"),
    "work per step": ("work", "MAX_WORK"),
    "jams per step": ("tolerances", "MAX_WEDGES_PER_STEP"),
    "shortest segment": ("tolerances", "LOCATION_SHORTEST"),
    "shortenings": ("tolerances", "STEP_TRIALS"),
    "event iterations": ("tolerances", "LOCATION_ITERATIONS"),
    "event nudges": ("tolerances", "LOCATION_EXTENSIONS"),
    "collocation iterations": ("tolerances", "RADAU_NEWTON_ITERATIONS"),
    "quasi-static iterations": ("tolerances", "BRACKET_ITERATIONS"),
    "collocation nodes": ("radau", "RADAU_MAX"),
    "bisections": ("tolerances", "BERNSTEIN_MAX_DEPTH"),
    "closed-form root iterations": ("tolerances", "ROOT_MAX_ITERATIONS"),
    "closed-form arcs": ("linear_search", "INTERVALS"),
}


def fmu_path(identifier: str) -> Path:
    return BUILD / f"{identifier}.fmu"


def source_text(stem: str) -> str:
    """The text of `stem`.h and `stem`.c, wherever they stand in fmu_src."""
    files = sorted(path for suffix in ("c", "h") for path in FMU_SRC.rglob(f"{stem}.{suffix}"))
    if not files:
        raise FileNotFoundError(f"fmu_src has no {stem}.c and no {stem}.h")
    return "\n".join(path.read_text() for path in files)


def loop_limit(name: str) -> float:
    """The limit of a loop, a key of LOOP_LIMITS, as the C sources have it. KeyError if they do not."""
    stem, constant = LOOP_LIMITS[name]
    pattern = rf"\b{constant} (?:= )?([\d.e+-]+)\b" if constant else r"n < (\d+); n\+\+"
    found = [float(value) for value in re.findall(pattern, source_text(stem))]
    if not found:
        raise KeyError(f"{name}: {constant or 'no loop with a limit'} in {stem}")
    return max(found)


def compile_c(flags: Sequence[str], sources: Sequence[Path], product: Path) -> Path:
    """Compiles for the platform and with the warnings of the FMUs."""
    build_fmu.compile_c(build_fmu.ZIG, [*build_fmu.TARGET, *flags], sources, product)
    return product


@functools.cache
def loop_library(source: str | Path, flags: tuple[str, ...] = OPTIMISED) -> Path:
    """The timed loops of a C file, a path below benchmarks/ or an absolute one, as a shared library.
    Compiled once per process."""
    path = BENCHMARKS / source
    return compile_c([*flags, "-fPIC", "-shared"], [path], BUILD / "loops" / f"{path.stem}.so")


def load_loops(source: str | Path, *timed: str, flags: tuple[str, ...] = OPTIMISED) -> ctypes.CDLL:
    """The same, loaded. `timed`: the functions that return seconds."""
    library = ctypes.CDLL(str(loop_library(source, flags)))
    for name in timed:
        getattr(library, name).restype = ctypes.c_double
    return library


def library_without_closed_forms(product: Path) -> Path:
    """The forward FMU's library in which every motion is integrated. Compiled if a source has changed."""
    return variant(product, [*build_fmu.SHARED, NO_CLOSED_FORM])


def library_with_symbols(product: Path) -> Path:
    """The forward FMU's library with the names of its functions. Compiled if a source has changed."""
    return variant(product, [flag for flag in build_fmu.SHARED if flag != "-s"])


def variant(product: Path, options: Sequence[str]) -> Path:
    """The forward FMU's library, compiled with these options."""
    fmu = build_fmu.dual_cam(FORWARD, check=True)
    flags = [*options, *fmu.defines, *build_fmu.identity(fmu)]
    stamp = build_fmu.fingerprint([*fmu.sources, *build_fmu.headers()], *build_fmu.TARGET, *flags)
    if not build_fmu.is_fresh(product, stamp):
        compile_c(flags, fmu.sources, product)
        build_fmu.set_stamp(product, stamp)
    return product


@functools.cache
def build_hand_written_fmu() -> None:
    """HandWritten.fmu from hand_written/hand_written.c."""
    with build_fmu.locked():
        build_fmu.build(build_fmu.hand_written_fmu(build_fmu.dual_cam(FORWARD, False)))
