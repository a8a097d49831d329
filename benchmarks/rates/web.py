"""The cost of the engine of the page in V8, the JavaScript engine of Chromium and node.

Node runs dualcam/view/engine.js and the WebAssembly module. Timed are, in two designs: to set a torque and
step 1 ms, to begin a new run with another radius, and to compute one angle of the stick band. The time is
that of the processor.
"""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Iterator
from pathlib import Path

from rich.console import Console

from benchmarks.harness.repository import ROOT
from benchmarks.rates.measure import Group, Measure
from dualcam import fmu_path
from dualcam.fmi import read_model_description
from dualcam.fmi.library import web_path

STEP = 1e-3  # s
TURNS = 10_000
TORQUE = [4.0 + 4.0 * math.sin(2.0 * math.pi * 5.0 * k * STEP) for k in range(TURNS)]  # N.m
ANGLES = [1.3 * k / 999 for k in range(1000)]  # rad
ELLIPSES = {
    f"cam{cam}.{name}": value for cam in (1, 2) for name, value in (("profile", 2), ("ellipse_a", 0.08))
}
SCENES: dict[str, dict[str, float]] = {"helices": {}, "ellipses": ELLIPSES}


def times_in_node(rounds: int) -> tuple[dict[str, list[float]], str]:
    """Seconds of each block over the rounds, and the version of V8."""
    read = read_model_description(fmu_path("forward"))
    variables = [
        {"name": v.name, "vr": v.value_reference, "type": v.type, "causality": v.causality}
        | {"variability": v.variability}
        for v in read.variables
    ]
    job = {
        "description": {"guid": read.guid, "variables": variables},
        "scenes": SCENES,
        "step": STEP,
        "torque": TORQUE,
        "rounds": rounds,
        "angles": ANGLES,
    }
    files: list[str | Path] = [ROOT / "dualcam/view/engine.js", web_path("DualCamForward.wasm")]
    words = ["node", Path(__file__).with_suffix(".mjs"), *files]
    done = subprocess.run(words, input=json.dumps(job), stdout=subprocess.PIPE, encoding="utf-8", check=True)
    found = json.loads(done.stdout)
    return found["times"], found["v8"]


def take(rounds: int, _console: Console) -> Iterator[Group]:
    times, v8 = times_in_node(rounds)
    yield Group(f"V8 {v8}", times)


MEASURE = Measure("web", "Engine of the page in V8", take, 21)
