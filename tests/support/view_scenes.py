"""Runs with which the engine of the page is compared with the FMU, and the three that carry them out: the
engine in node, the page in Chromium, and the FMU behind dualcam.Fmu.

A run is a list of commands. Each driver gives a list of results: for `read` the numbers of READ, for a call
that was refused {"refused": text}.
"""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from driver import ROOT

from dualcam import Fmu, fmu_path
from dualcam.common.groove_laws import LAWS
from dualcam.errors import FmuError
from dualcam.fmi import read_model_description
from dualcam.fmi.library import MODELS, web_path

SUPPORT = ROOT / "tests/support"
ENGINE = ROOT / "dualcam/view/engine.js"
NODE = shutil.which("node")
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")

READ = {
    "forward": [
        *("time", "theta", "omega", "z", "v", "alpha", "gamma", "mode", "events", "torque_load"),
        *("torque_release", "spring.force", "damper.force", "cam1.reaction", "cam2.reaction"),
        *("cam1.sliding_speed", "cam2.sliding_speed", "energy.work_in", "energy.heat_cam1"),
        *("energy.heat_cam2", "energy.kinetic", "energy.heat_stop", "peak.torque", "peak.omega"),
    ],
    "inverse": ["time", "tau", "z", "v", "mode", "torque_load", "torque_release", "energy.heat_cam1"],
}
EXACT = ("mode", "events")
TOLERANCE = 1e-9  # of the largest absolute value of a variable within the run
Result = Any
Results = list[Result]
Command = Sequence[Any]


@dataclass(frozen=True)
class Scene:
    """A run: start values and groove tables of the design, then commands."""

    start: Mapping[str, float | bool | str]
    commands: Sequence[Command]
    files: Mapping[str, str] = field(default_factory=dict)
    model: str = "forward"


# ---- commands ----

# Time s, torque as a share of the largest: loading to the upper stop with a stop on the way, small reversals
# inside the stick band, release to the lower stop, and a push beyond.
TORQUE = (
    *((0.0, 0.0), (0.1, 0.5), (0.15, 0.45), (0.2, 0.5), (0.3, 0.25), (0.4, 0.6), (0.5, 1.0), (0.6, 1.2)),
    *((0.65, 0.9), (0.75, 0.1), (0.85, -0.3), (0.9, -0.3), (0.95, 0.4), (1.05, 0.1), (1.1, 0.7), (1.2, -0.1)),
)
STEPS = (1e-3, 4e-4, 2.3e-3)  # s


def loading(torque: float, force: float = 0.0) -> list[Command]:
    """Steps through TORQUE up to `torque` [N.m], with an axial force up to `force` [N]."""
    times, shares = zip(*TORQUE, strict=True)
    commands: list[Command] = []
    time, k = 0.0, 0
    while time < times[-1]:
        commands.append(("set", "tau", torque * float(np.interp(time, times, shares))))
        if force:
            commands.append(("set", "F_ext", force * math.sin(20.0 * time)))
        commands += [("step", STEPS[k % len(STEPS)]), ("read",)]
        time, k = time + STEPS[k % len(STEPS)], k + 1
    return commands


def imposed() -> list[Command]:
    """A swing to and fro for the inverse model, with a rest at the end."""
    commands: list[Command] = []
    for k in range(400):
        phase = 2.0 * math.pi * 2.0 * k * 2e-3
        motion = {"theta": 0.6 - 0.6 * math.cos(phase), "omega": 0.6 * 4.0 * math.pi * math.sin(phase)}
        motion["alpha"] = 0.6 * (4.0 * math.pi) ** 2 * math.cos(phase)
        commands += [("set", name, value) for name, value in motion.items()]
        commands += [("set", "F_ext", 20.0 * math.sin(3.0 * phase)), ("step", 2e-3), ("read",)]
    return commands


def table(slope: float, bend: float) -> str:
    """A groove table of z = slope psi + bend psi^2."""
    rows = [f"{psi:.6f},{slope * psi + bend * psi * psi:.12g}" for psi in np.linspace(-0.2, 1.6, 61)]
    return "psi_rad,z_m\n" + "\n".join(rows) + "\n"


def in_between(commands: Sequence[Command], *more: Sequence[Command]) -> list[Command]:
    """`more`, each a list of commands, at equal distances within `commands`, after a `read`."""
    found: list[Command] = []
    reads = [k for k, command in enumerate(commands) if command[0] == "read"]
    places = [reads[len(reads) * (k + 1) // (len(more) + 1)] for k in range(len(more))]
    for k, command in enumerate(commands):
        found.append(command)
        for place, group in zip(places, more, strict=True):
            found += group if k == place else []
    return found


# ---- scenes ----

FLAT = {"cam1.profile": 2, "cam1.ellipse_a": 0.08, "cam1.ellipse_b": 0.08, "cam1.ellipse_curvature": -1}
STEEP = {"cam2.profile": 2, "cam2.ellipse_a": 0.09, "cam2.ellipse_b": 0.07, "cam2.ellipse_curvature": 1}
HEAVY = {"inertia.shaft": 0.004, "inertia.follower_mass": 0.3, "shaft.damping": 0.01}
TABLES = {"cam1.profile": 3, "cam1.table": "first.csv", "cam2.profile": 3, "cam2.table": "the second.csv"}
TABLE_FILES = {"first.csv": table(0.018, 0.002), "the second.csv": table(0.022, -0.003)}
FRICTION = "v_m_s,mu\n0,0.2\n0.05,0.15\n0.5,0.12\n"
DAMPED = {"damper.c_load": 20.0, "damper.q_load": 50.0, "damper.c_release": 30.0, "spring.stiffness3": 1e6}

SCENES = {
    "helices": Scene({}, loading(10.0)),
    "helices, restitution and axial force": Scene({"stop.restitution": 0.5, **HEAVY}, loading(10.0, 80.0)),
    "flattening ellipse": Scene({**FLAT, "stop.upper": 1.0}, loading(8.0)),
    "steepening ellipse": Scene({**STEEP, **DAMPED, "stop.upper": 1.0}, loading(10.0)),
    "both ellipses": Scene({**FLAT, **STEEP, **HEAVY, "stop.upper": 1.0}, loading(9.0, 50.0)),
    "cycloid and helix": Scene({"cam1.profile": 4, **HEAVY}, loading(12.0)),
    "tables": Scene({**TABLES, **HEAVY}, loading(9.0), TABLE_FILES),
    "table and helix": Scene({"cam1.profile": 3, "cam1.table": "first.csv"}, loading(9.0), TABLE_FILES),
    "without inertia": Scene({"inertia.shaft": 0.0}, loading(10.0)),
    "friction table": Scene(
        {"cam1.friction_table": "law.csv"},
        loading(10.0),
        {"law.csv": "v_m_s,mu\n0,0.2\n0.05,0.15\n0.5,0.12\n"},
    ),
    "start in between": Scene({"initial.theta": 0.7, "initial.omega": 5.0}, loading(10.0)),
}
CHANGES = {
    "tuned while it moves": in_between(
        loading(10.0, 30.0),
        [("set", "cam1.friction", 0.2), ("set", "spring.preload", 90.0)],
        [("set", "spring.stiffness", 35e3), ("set", "damper.c_load", 40.0)],
        [("set", "cam2.friction", 0.05), ("set", "cam1.friction", 0.05)],
    ),
    "another design while it moves": in_between(
        loading(10.0),
        [("set", "inertia.shaft", 0.003)],
        [("set", "cam2.lead_angle", 0.7), ("set", "contacts", 1), ("set", "spring.stiffness", 40e3)],
        [("set", "cam1.radius", 0.025), ("set", "ledger", False)],
        [("set", "stop.upper", 1.6), ("reset",), ("read",)],
    ),
    "refusals": in_between(
        loading(10.0),
        [("set", "cam1.friction", -1.0), ("set", "tau", math.nan), ("read",)],
        [("set", "stop.upper", 0.01), ("read",), ("set", "cam1.profile", 3), ("read",)],
        [("set", "cam1.profile", 7), ("step", 0.0), ("step", -1e-3), ("step", math.nan), ("read",)],
        [
            ("set", "cam1.lead_angle", -0.1),
            ("set", "cam1.lead_angle", 0.8),
            ("set", "stop.lower", 2.0),
            ("read",),
        ],
        [
            ("set", "cam1.friction", 1.1),
            ("set", "cam2.friction", 1.2),
            ("set", "cam1.friction", 0.2),
            ("read",),
        ],
        [("set", "spring.stiffness", math.inf), ("set", "initial.theta", 3.0), ("read",)],
    ),
}
SCENES |= {name: Scene({}, commands) for name, commands in CHANGES.items()}


# ---- the FMU ----


class Twin:
    """The FMU with the calls of the engine. A parameter that is not tunable begins a new run with it, at the
    present time, angle and speed."""

    def __init__(self, scene: Scene, folder: Path) -> None:
        for name, text in scene.files.items():
            (folder / name).write_text(text, encoding="utf-8")
        self.path = fmu_path(scene.model)
        self.design = {n: str(folder / v) if n.endswith("table") and v else v for n, v in scene.start.items()}
        self.fmu, self.values = Fmu(self.path), dict(self.design)
        self.fmu.start(self.design)

    def restart(
        self, values: Mapping[str, float | bool | str], kept: Mapping[str, float], time: float
    ) -> None:
        fresh = Fmu(self.path)
        try:
            fresh.start({**values, **kept}, time=time)
        except FmuError:
            fresh.close()
            raise
        self.fmu.close()
        self.fmu, self.values = fresh, dict(values)

    def set(self, name: str, value: float | bool | str) -> None:
        variable = self.fmu.variable(name)
        if variable.causality == "input" or variable.variability == "tunable":
            self.fmu.set(name, value)
            self.values[name] = value
            return
        motion = {"initial.theta": self.fmu.real("theta"), "initial.omega": self.fmu.real("omega")}
        self.restart({**self.values, name: value}, {} if name in motion else motion, self.fmu.time)

    def get(self, name: str) -> float | bool | str:
        return self.fmu.time if name == "time" else self.fmu.get(name)

    def step(self, seconds: float) -> None:
        self.fmu.step(seconds)

    def reset(self) -> None:
        self.restart(self.design, {}, 0.0)


def run_on_fmu(scene: Scene, folder: Path) -> Results:
    """The results of dualcam.Fmu; `folder` is for the groove tables."""
    twin, results = Twin(scene, folder), []
    names = READ[scene.model]
    actions: dict[str, Callable[..., Any]] = {
        **{"set": twin.set, "step": twin.step, "reset": twin.reset},
        "read": lambda: results.append([float(twin.get(name)) for name in names]),
    }
    try:
        for action, *operands in scene.commands:
            try:
                actions[action](*operands)
            except FmuError as error:
                results.append({"refused": str(error)})
    finally:
        twin.fmu.close()
    return results


# ---- the engine ----


def description(model: str) -> dict[str, Any]:
    """The FMU's variables, as the engine takes them."""
    read = read_model_description(fmu_path(model))
    rows = [
        {
            **{"name": v.name, "vr": v.value_reference, "type": v.type},
            **{"causality": v.causality, "variability": v.variability, "start": v.start},
        }
        for v in read.variables
    ]
    return {"guid": read.guid, "variables": rows}


def run_in_node(scene: Scene) -> Results:
    """The results of the engine in node. `json` writes NaN and Infinity as JavaScript does."""
    job = {
        "description": description(scene.model),
        "files": dict(scene.files),
        "start": dict(scene.start),
        "commands": list(scene.commands),
        "names": READ[scene.model],
    }
    done = subprocess.run(
        [NODE, SUPPORT / "run_engine.mjs", ENGINE, web_path(f"{MODELS[scene.model]}.wasm")],
        **{"input": json.dumps(job), "capture_output": True, "encoding": "utf-8", "timeout": 120},
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


# ---- the page ----


def design_text(scene: Scene) -> str:
    """The design file of a scene."""
    values = {n: LAWS[int(v)].word if n.endswith(".profile") else v for n, v in scene.start.items()}
    return "".join(f"{name} = {json.dumps(value)}\n" for name, value in values.items())


def run_in_page(page: Any, scene: Scene) -> Results:
    """The results of window.dualcam; `page` is a page of Playwright that shows the design of the scene."""
    drive = (SUPPORT / "drive_model.mjs").read_text(encoding="utf-8").replace("export function", "function")
    script = f"async ([commands, names]) => {{ {drive} await window.dualcam.ready;"
    script += " return drive(window.dualcam, commands, names); }"
    return page.evaluate(script, [[list(command) for command in scene.commands], READ[scene.model]])


# ---- comparison ----


def numbers(results: Results, model: str = "forward") -> np.ndarray:
    """The rows that `read` gave, (reads, names)."""
    rows = [row for row in results if isinstance(row, list)]
    return np.array(rows, dtype=float).reshape(len(rows), len(READ[model]))


def refusals(results: Results) -> list[tuple[int, str]]:
    """Place and text of each refusal. dualcam.errors.FmuError adds words around the FMU's text."""
    return [(k, row["refused"]) for k, row in enumerate(results) if isinstance(row, dict)]


def assert_equal(found: Results, expected: Results, model: str = "forward") -> None:
    """The numbers agree to TOLERANCE, modes and counts exactly; the same calls are refused."""
    assert [k for k, _ in refusals(found)] == [k for k, _ in refusals(expected)]
    a, b = numbers(found, model), numbers(expected, model)
    assert a.shape == b.shape and len(b) > 100
    assert np.isfinite(b).all()
    for column, name in enumerate(READ[model]):
        difference = np.abs(a[:, column] - b[:, column]).max()
        scale = 0.0 if name in EXACT else np.abs(b[:, column]).max()
        assert difference <= TOLERANCE * scale, (name, difference, scale)
