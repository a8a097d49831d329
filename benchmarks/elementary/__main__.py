"""The command: compares, measures, prints the table, writes CSV."""

from __future__ import annotations

import ctypes
import math
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import mpmath
import numpy as np

import build_fmu
from benchmarks import elementary
from benchmarks.harness import core, results
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import BENCHMARKS

Array = np.ndarray
MP = mpmath.MPContext()
MP.dps = 60
ALLOWED = 1.0  # ulp
CHUNK = 200_000
CALLS = 20_000  # that callgrind counts
LOOPS = BENCHMARKS / "elementary/loops.c"
TIMED = np.linspace(0.01, 6.0, 10_000)


def sizes(r: np.random.Generator, low: float, high: float) -> Array:
    """Numbers of any sign; sizes from `low` to `high` are equally likely by their logarithm."""
    return r.choice([-1.0, 1.0], CHUNK) * np.exp(r.uniform(math.log(low), math.log(high), CHUNK))


def angles(r: np.random.Generator) -> Iterator[Array]:
    while True:
        yield r.uniform(-0.8, 0.8, CHUNK)
        yield r.uniform(-100.0, 100.0, CHUNK)
        yield sizes(r, 1.0, 1e6)
        yield sizes(r, 1e6, 1e300)


def exponents(r: np.random.Generator) -> Iterator[Array]:
    while True:
        yield r.uniform(-1.0, 1.0, CHUNK)
        yield r.uniform(-745.0, 709.7, CHUNK)
        yield sizes(r, 1e-10, 50.0)


def positive(r: np.random.Generator) -> Iterator[Array]:
    while True:
        yield r.uniform(0.5, 2.0, CHUNK)
        yield 1.0 + sizes(r, 1e-10, 0.1)
        yield abs(sizes(r, 1e-320, 1e300))


def above_minus_one(r: np.random.Generator) -> Iterator[Array]:
    while True:
        yield r.uniform(-0.99, 1.0, CHUNK)
        yield r.uniform(-0.03, 0.03, CHUNK)
        yield abs(sizes(r, 1e-10, 1e10))


def any_size(r: np.random.Generator) -> Iterator[Array]:
    while True:
        yield r.uniform(-1.1, 1.1, CHUNK)
        yield sizes(r, 0.01, 100.0)
        yield sizes(r, 1e-300, 1e300)


# name -> the function of numpy, that with 60 digits, its arguments
FUNCTIONS: dict[
    str, tuple[Callable[..., Array], Callable[..., mpmath.mpf], Callable[..., Iterator[Array]]]
] = {
    "exp": (np.exp, MP.exp, exponents),
    "expm1": (np.expm1, MP.expm1, exponents),
    "log": (np.log, MP.log, positive),
    "log1p": (np.log1p, MP.log1p, above_minus_one),
    "sin": (np.sin, MP.sin, angles),
    "cos": (np.cos, MP.cos, angles),
    "tan": (np.tan, MP.tan, angles),
    "atan": (np.arctan, MP.atan, any_size),
    "cbrt": (np.cbrt, lambda x: MP.sign(x) * MP.cbrt(abs(x)), any_size),
}
MEASURED_TOO = ("sin and cos", "atan2")  # of which the greatest error is that of others, or in the tests


def loops() -> ctypes.CDLL:
    flags = ["-O3", "-fPIC", "-shared"]
    sources = [LOOPS, *sorted((core.FMU_SRC / "elementary").glob("*.c"))]
    library = ctypes.CDLL(str(core.compile_c(flags, sources, core.BUILD / "loops/elementary.so")))
    library.seconds.restype = ctypes.c_double
    return library


def address(x: Array) -> ctypes.c_void_p:
    return ctypes.c_void_p(x.ctypes.data)


def greatest_error(library: ctypes.CDLL, name: str, count: int) -> tuple[float, float]:
    """In ulp, and the argument."""
    in_long, exact, arguments = FUNCTIONS[name]
    worst, at = 0.0, 0.0
    chunks = arguments(np.random.default_rng(1))
    for _ in range(max(1, count // CHUNK)):
        x = next(chunks)
        y = np.empty_like(x)
        library.values(name.encode(), ctypes.c_size_t(len(x)), address(x), address(y))
        reference = in_long(x.astype(np.longdouble))
        error = abs((y.astype(np.longdouble) - reference) / np.spacing(abs(reference.astype(float))))
        k = int(np.argmax(error))
        if not error[k] <= worst:  # a NaN counts
            worst, at = float(error[k]), float(x[k])
            value, computed = exact(MP.mpf(at)), MP.mpf(float(y[k]))
    return float(abs(computed - value) / math.ulp(float(value))), at


def nanoseconds(library: ctypes.CDLL, name: str, rounds: int) -> list[float]:
    """Of one call: own, library; the least of all rounds."""
    y, best = np.empty_like(TIMED), [math.inf, math.inf]
    shuffled = np.random.default_rng(2).permutation(TIMED)
    for _ in range(rounds):
        for k, kind in enumerate((b"own", b"library")):
            seconds = library.seconds(
                kind, name.encode(), ctypes.c_size_t(len(y)), address(shuffled), address(y)
            )
            best[k] = min(best[k], 1e9 * seconds)
    return best


def instructions(name: str) -> list[str]:
    """Of one call with its loop: own, library; empty without valgrind."""
    if shutil.which("valgrind") is None:
        return ["", ""]
    program = core.BUILD / "loops/elementary"
    sources = [LOOPS, *sorted((core.FMU_SRC / "elementary").glob("*.c"))]
    if not program.exists() or any(path.stat().st_mtime > program.stat().st_mtime for path in sources):
        core.compile_c(["-fomit-frame-pointer", *core.OPTIMISED], sources, program)
    found = []
    for kind in ("own", "library"):
        with tempfile.TemporaryDirectory() as folder:
            words = ["valgrind", "--tool=callgrind", "--collect-atstart=no", "--toggle-collect=loop"]
            words += [f"--callgrind-out-file={folder}/out", str(program), kind, name, str(CALLS)]
            done = subprocess.run(words, capture_output=True, text=True)
            total = re.search(r"^(?:summary|totals): (\d+)", Path(folder, "out").read_text(), re.MULTILINE)
            if done.returncode != 0 or total is None:
                raise SystemExit(f"callgrind failed\n{done.stderr[-2000:]}")
            found.append(f"{int(total[1]) / CALLS:.0f}")
    return found


def main() -> int:
    parser = results.options(elementary.__doc__, "elementary", 51)
    parser.add_argument("--count", type=float, default=1e7, help="arguments of each function (1e7)")
    arguments = parser.parse_args()
    if np.finfo(np.longdouble).nmant < 63:
        raise SystemExit(
            "long double of this machine has no 64-bit mantissa; the tests compare with 60 digits"
        )
    console, library, rows = results.new_console(), loops(), []
    table = results.table(
        "Functions of the core and of the C library",
        *(
            "function",
            "greatest error [ulp]",
            "at",
            "own [ns]",
            "library [ns]",
            "own [instr.]",
            "library [instr.]",
        ),
    )
    failed = False
    for name in (*FUNCTIONS, *MEASURED_TOO):
        error, at = (
            greatest_error(library, name, int(arguments.count)) if name in FUNCTIONS else (math.nan, 0.0)
        )
        failed = failed or error >= ALLOWED
        times, counts = nanoseconds(library, name, arguments.rounds), instructions(name)
        known = name in FUNCTIONS
        cells = [f"{error:.3f}" if known else "", f"{at:.17g}" if known else ""]
        cells += [f"{value:.1f}" for value in times] + counts
        keys = ("greatest_error_ulp", "at", "ns", "ns_library", "instructions", "instructions_library")
        rows.append({"function": name, **dict(zip(keys, cells, strict=True))})
        table.add_row(name, *cells)
    console.print(table)
    results.publish(rows, circumstances("elementary", "numpy"), arguments.output, console)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
