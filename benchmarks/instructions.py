"""Instructions of loops over an FMU's steps, counted by callgrind.

The loops are those that are timed, run again by replay.py in a bare Python under valgrind, from serialized
FMU states that the caller has saved. Collection is on inside the FMU's own functions of a step only (toggled
at their entry and exit), so neither the loop nor the setting back of states counts; each job begins at zero
and ends with a file of its own. Functions of libm that the FMU calls count; callgrind knows no instructions
newer than AVX2, so that a memcpy may be another one than outside.
"""

from __future__ import annotations

import os
import pickle
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
Job = dict[str, Any]

STEP_FUNCTIONS = ("fmi2SetReal", "fmi2SetRealInputDerivatives", "fmi2DoStep", "fmi2GetReal")
BEGIN, END = "getpgrp", "getppid"  # of the C library, called by replay.py before and after what is to count
WITHOUT = "valgrind is not installed: no instructions are counted"


def available() -> bool:
    return shutil.which("valgrind") is not None


def raw(values: Sequence[float] | np.ndarray) -> bytes:
    return np.asarray(values, dtype=np.float64).tobytes()


def fmu_words(fmu: Any) -> tuple[str, str, str]:  # noqa: ANN401
    """Of an FMPy slave: library, GUID and resources."""
    folder = Path(fmu.unzipDirectory)
    library = folder / "binaries/linux64" / f"{fmu.modelIdentifier}.so"
    return str(library), fmu.guid, (folder / "resources").as_uri()


def serialized(fmu: Any, state: object) -> bytes:  # noqa: ANN401
    return bytes(fmu.serializeFMUState(state))


def count(loops: Path, jobs: Sequence[Job]) -> list[int]:
    """Instructions of each job's loop."""
    with tempfile.TemporaryDirectory() as folder:
        plan, out = Path(folder, "plan"), Path(folder, "out")
        plan.write_bytes(pickle.dumps({"loops": str(loops), "jobs": list(jobs)}))
        words = ["valgrind", "--tool=callgrind", "--collect-atstart=no", f"--callgrind-out-file={out}"]
        words += [f"--toggle-collect={name}" for name in STEP_FUNCTIONS]
        words += [f"--zero-before={BEGIN}", f"--dump-after={END}"]
        words += [sys.executable, "-S", "-E", "-s", str(ROOT / "benchmarks/replay.py"), str(plan)]
        done = subprocess.run(words, capture_output=True, text=True, env=os.environ | {"LD_BIND_NOW": "1"})
        if done.returncode != 0:
            raise SystemExit(f"callgrind failed\n{done.stdout}{done.stderr[-3000:]}")
        found = [total_of(Path(f"{out}.{n + 1}")) for n in range(len(jobs))]
    return found


def total_of(file: Path) -> int:
    found = re.search(r"^(?:summary|totals): (\d+)", file.read_text(), re.MULTILINE)
    if found is None:
        raise SystemExit(f"callgrind: no total in {file.name}")
    return int(found.group(1))
