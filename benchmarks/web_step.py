"""The cost of the engine of the page in V8, the JavaScript engine of Chromium and node.

    ./build.sh web

Node runs dualcam/view/engine.js and the WebAssembly module. Timed are, in two designs: to set a torque and
step 1 ms, to begin a new run with another radius, and to compute one angle of the stick band. The time is
that of the processor. The median over the rounds is reported, with quartiles.
"""

from __future__ import annotations

import json
import math
import shutil
import statistics
import subprocess
import sys
from pathlib import Path

from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import BENCHMARKS, ROOT
from dualcam import fmu_path, read_model_description
from dualcam.library import web_path

STEP = 1e-3  # s
TURNS = 10_000
TORQUE = [4.0 + 4.0 * math.sin(2.0 * math.pi * 5.0 * k * STEP) for k in range(TURNS)]  # N.m
ANGLES = [1.3 * k / 999 for k in range(1000)]  # rad
ELLIPSES = {
    f"cam{cam}.{name}": value for cam in (1, 2) for name, value in (("profile", 2), ("ellipse_a", 0.08))
}
SCENES: dict[str, dict[str, float]] = {"helices": {}, "ellipses": ELLIPSES}


def times_in_node(node: str, rounds: int) -> tuple[dict[str, list[float]], str]:
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
    words: list[str | Path] = [
        node,
        BENCHMARKS / "web_step.mjs",
        ROOT / "dualcam/view/engine.js",
        web_path("DualCamForward.wasm"),
    ]
    done = subprocess.run(words, input=json.dumps(job), stdout=subprocess.PIPE, encoding="utf-8", check=True)
    found = json.loads(done.stdout)
    return found["times"], found["v8"]


def main() -> int:
    arguments = harness.options(__doc__, "web_step", 21).parse_args()
    console = harness.new_console()
    node = shutil.which("node")
    if node is None:
        harness.say(console, "web_step: node is not installed: install Node.js")
        return 1
    times, v8 = times_in_node(node, arguments.rounds)
    table = harness.table("Engine of the page in V8", "what", "us", "quartiles")
    rows = []
    for name, seconds in times.items():
        lower, median, upper = (1e6 * t for t in statistics.quantiles(seconds, n=4, method="inclusive"))
        table.add_row(name, f"{median:.3g}", f"{lower:.3g}-{upper:.3g}")
        rows.append(
            {"what": name, "us": f"{median:.4f}", "lower_quartile": f"{lower:.4f}"}
            | {"upper_quartile": f"{upper:.4f}", "v8": v8}
        )
    console.print(table)
    harness.publish(rows, circumstances("web"), arguments.output, console)
    return 0


if __name__ == "__main__":
    sys.exit(main())
