"""Instructions of loops over an FMU's steps, counted by callgrind.

A job is a timed loop with its data. `replay.py` runs the jobs again in a bare Python under valgrind, from
serialized FMU states that the caller has saved. Collection is switched on at the entry and off at the exit of
the FMU's own functions of a step. Therefore neither the loop nor the restoring of states is counted. The
counters are set to zero at the start of each job and written at its end. Functions of libm that the FMU calls
are counted. Callgrind knows no instructions newer than AVX2, so a memcpy may be another one than outside.
"""

from __future__ import annotations

import os
import pickle
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness.repository import ROOT

Job = dict[str, Any]

STEP_FUNCTIONS = ("fmi2SetReal", "fmi2SetRealInputDerivatives", "fmi2DoStep", "fmi2GetReal")
BEGIN, END = "getpgrp", "getppid"  # of the C library; replay.py calls them before and after the counted loop
FUNCTION = re.compile(r"(?P<called>c?)fn=\((?P<id>\d+)\)(?: (?P<name>.*))?")
COST = re.compile(r"[+*-]?\d* (?P<instructions>\d+)$")
WITHOUT = "valgrind is not installed: no instructions are counted"


def available() -> bool:
    return shutil.which("valgrind") is not None


def raw(values: Sequence[float] | np.ndarray) -> bytes:
    return np.asarray(values, dtype=np.float64).tobytes()


def fmu_words(fmu: Any) -> tuple[str, str, str]:  # noqa: ANN401
    """Library, GUID and resources of an FMPy slave."""
    folder = Path(fmu.unzipDirectory)
    library = folder / "binaries/linux64" / f"{fmu.modelIdentifier}.so"
    return str(library), fmu.guid, (folder / "resources").as_uri()


def serialized(fmu: Any, state: object) -> bytes:  # noqa: ANN401
    return bytes(fmu.serializeFMUState(state))


@dataclass(frozen=True)
class Counted:
    """Instructions of a job's loop. By name, as far as the library has symbols: calls of functions, and the
    instructions of functions without those of the functions that they call."""

    instructions: int
    calls: dict[str, int]
    own: dict[str, int]


def count(loops: Path, jobs: Sequence[Job]) -> list[int]:
    """Instructions of each job's loop. `loops`: the library of the loops. SystemExit if callgrind fails."""
    return [counted.instructions for counted in count_calls(loops, jobs)]


def count_calls(loops: Path, jobs: Sequence[Job]) -> list[Counted]:
    """The same, with the calls."""
    with tempfile.TemporaryDirectory() as folder:
        plan, out = Path(folder, "plan"), Path(folder, "out")
        plan.write_bytes(pickle.dumps({"loops": str(loops), "jobs": list(jobs)}))
        words = ["valgrind", "--tool=callgrind", "--collect-atstart=no", f"--callgrind-out-file={out}"]
        words += [f"--toggle-collect={name}" for name in STEP_FUNCTIONS]
        words += [f"--zero-before={BEGIN}", f"--dump-after={END}"]
        words += [sys.executable, "-S", "-E", "-s", "-m", "benchmarks.harness.replay", str(plan)]
        environment = os.environ | {"LD_BIND_NOW": "1"}
        done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, env=environment)
        if done.returncode != 0:
            raise SystemExit(f"callgrind failed\n{done.stdout}{done.stderr[-3000:]}")
        found = [read_counts(Path(f"{out}.{n + 1}")) for n in range(len(jobs))]
    return found


def read_counts(file: Path) -> Counted:
    """A file of callgrind. "fn=(id) name", later only "fn=(id)", names the function of the lines that follow,
    "cfn=(id)" that of the next "calls". The line after "calls" is the cost of the called function."""
    text = file.read_text()
    total = re.search(r"^(?:summary|totals): (\d+)", text, re.MULTILINE)
    if total is None:
        raise SystemExit(f"callgrind: no total in {file.name}")
    names: dict[str, str] = {}
    calls: Counter[str] = Counter()
    own: Counter[str] = Counter()
    called = here = ""
    lines = iter(text.splitlines())
    for line in lines:
        if function := FUNCTION.match(line):
            if function["name"]:
                names[function["id"]] = function["name"]
            if function["called"]:
                called = function["id"]
            else:
                here = function["id"]
        elif line.startswith("calls="):
            calls[called] += int(line.removeprefix("calls=").split()[0])
            next(lines)
        elif here and (cost := COST.match(line)):
            own[here] += int(cost["instructions"])
    return Counted(int(total.group(1)), by_name(calls, names), by_name(own, names))


def by_name(counts: Counter[str], names: dict[str, str]) -> dict[str, int]:
    return {names[key]: n for key, n in counts.items()}
