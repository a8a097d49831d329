"""The first minutes of a new user: how long each command takes, and how much disk the package takes.

    ./build.sh run firstuse

A new virtual environment gets the wheel in `dist` and nothing else. Each command then runs in a folder of its
own, with no compiler on the PATH. `--help` is the median of several starts. The exported FMU runs in FMPy and
in ecos, which have other environments; the largest difference of theta to `dualcam simulate` is in the last
column."""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import fmpy
import numpy as np

from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import ROOT
from dualcam.errors import DualcamError
from verification.masters import install, players
from verification.masters.scenes import PROFILE

STARTS = 7  # of `dualcam --help`
MEBIBYTE = 1024.0**2
SWING, SAMPLES = 0.5, 50  # s, and samples of theta
LARGEST = 8  # packages shown with their sizes
COMMANDS = {
    "new": ["new", "my.toml", "--from", "robot"],
    "check": ["check", "my.toml"],
    "simulate with plot": ["simulate", "my.toml", "-o", "out.csv", "--plot", "out.png"],
    "export": ["export", "my.toml", "-o", "MyCam.fmu"],
    "export FMI 3.0": ["export", "my.toml", "-o", "MyCam3.fmu", "--fmi", "3"],
    "report": ["report", "my.toml", "-o", "my_report.html"],
    "ssp": ["ssp", "my.toml", "-o", "MyCam.ssp"],
}
COLUMNS = ("what", "time [s]", "size [MiB]", "difference [rad]")


class Environment:
    """A virtual environment in a scratch folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.programs = folder / ("Scripts" if os.name == "nt" else "bin")
        self.work = folder.parent / "work"
        self.work.mkdir()

    def run(self, *words: str | Path) -> float:
        """Seconds of one program of the environment; its PATH has no compiler."""
        begin = time.perf_counter()
        command = [str(self.programs / words[0]), *map(str, words[1:])]
        subprocess.run(command, check=True, cwd=self.work, capture_output=True, env={"PATH": ""})
        return time.perf_counter() - begin


def wheel() -> Path:
    """The wheel in `dist`."""
    found = sorted((ROOT / "dist").glob("dualcam-*.whl"))
    if len(found) != 1:
        raise DualcamError(f"dist holds {len(found)} wheels: allowed is one, which ./build.sh wheel makes")
    return found[0]


def new_environment(folder: Path) -> tuple[Environment, float]:
    """A new environment with the wheel, and the seconds that this takes."""
    begin = time.perf_counter()
    subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
    environment = Environment(folder)
    python = environment.programs / "python"
    words = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check", str(wheel())]
    subprocess.run([str(python), *words], check=True)
    return environment, time.perf_counter() - begin


def size_of(folder: Path) -> float:
    """MiB of all files below a folder, or of one file, in whole blocks of the disk where known."""
    files = [folder] if folder.is_file() else [path for path in folder.rglob("*") if path.is_file()]
    return sum(getattr(f.lstat(), "st_blocks", -(-f.lstat().st_size // 512)) * 512 for f in files) / MEBIBYTE


def largest_packages(folder: Path) -> list[tuple[str, float]]:
    (packages,) = folder.rglob("site-packages")
    sizes = [(path.name, size_of(path)) for path in packages.iterdir()]
    return sorted(sizes, key=lambda entry: -entry[1])[:LARGEST]


def differences(environment: Environment) -> dict[str, float]:
    """Largest difference of theta [rad] between the exported FMU in another master and `dualcam simulate`.
    The masters hold the torque for 1 ms; the scenario of `simulate` has the same steps."""
    scene = replace(PROFILE, outputs=("theta", "omega"))
    file = environment.work / "my.toml"
    text = file.read_text(encoding="utf-8").partition("[scenario]")[0]
    lines = [text, "[scenario]", f"stop = {scene.duration}", f"output_interval = {scene.step}"]
    for name, values in scene.inputs.items():
        held = np.repeat(values[:-1], 2).tolist()
        times = np.repeat(scene.times, 2)[1:-1].tolist()
        lines.append(f"inputs.{name} = {{ time = {times}, value = {held} }}")
    (environment.work / "held.toml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    environment.run("dualcam", "simulate", "held.toml", "-o", "held.csv", "--variables", "theta")
    expected = np.genfromtxt(environment.work / "held.csv", delimiter=",", names=True)["theta"]
    fmu = environment.work / "MyCam.fmu"
    by_fmpy = fmpy.simulate_fmu(
        str(fmu),
        stop_time=scene.duration,
        output_interval=scene.step,
        input=scene.table,
        output=["theta"],
        start_values=dict(scene.start),
    )["theta"]
    found = {"MyCam.fmu in FMPy": float(np.max(np.abs(by_fmpy - expected)))}
    with tempfile.TemporaryDirectory() as folder:
        by_ecos = players.ecos(scene, fmu, Path(folder))["theta"]
    return found | {"MyCam.fmu in ecos": float(np.max(np.abs(by_ecos - expected)))}


def package_differences(environment: Environment) -> dict[str, float]:
    """The same for the SSP package of a design that swings back from 1 rad without torque."""
    text = (environment.work / "my.toml").read_text(encoding="utf-8").partition("[scenario]")[0]
    text = text.replace("theta = 0.0", "theta = 1.0")
    scenario = f"[scenario]\nstop = {SWING}\noutput_interval = {SWING / SAMPLES}\n"
    (environment.work / "swing.toml").write_text(text + scenario, encoding="utf-8")
    environment.run("dualcam", "simulate", "swing.toml", "-o", "swing.csv", "--variables", "theta")
    environment.run("dualcam", "ssp", "swing.toml", "-o", "swing.ssp")
    expected = np.genfromtxt(environment.work / "swing.csv", delimiter=",", names=True)["theta"][1:]
    package, found = environment.work / "swing.ssp", {}
    for master, host in (("ecos", "ecospy"), ("libcosim", "libcosimpy")):
        venv = install.package(host, *(["tbb"] if master == "ecos" else []))
        file = environment.work / f"swing.{master}"
        words = [package, "start", "0.001", SAMPLES, round(SWING / SAMPLES / 1e-3), file, "cam.theta"]
        program: list[str | Path] = [
            venv / "bin/python",
            players.HOSTS / f"{master}_ssp.py",
            *map(str, words),
        ]
        players.insist(program, environment.work, LD_LIBRARY_PATH=str(venv / "lib"))
        apart = np.abs(players.read(file)["cam.theta"] - expected)
        found[f"SSP package in {master}"] = float(np.max(apart))
    return found


def row(
    what: str, seconds: float | None = None, size: float | None = None, apart: float | None = None
) -> dict[str, str]:
    cells = (seconds, size, apart)
    return dict(zip(COLUMNS, (what, *("" if v is None else f"{v:.3g}" for v in cells)), strict=True))


def measure() -> list[dict[str, str]]:
    with tempfile.TemporaryDirectory() as scratch:
        environment, seconds = new_environment(Path(scratch) / "environment")
        rows = [row("install the wheel", seconds, size_of(environment.folder))]
        rows += [row(f"of this: {name}", None, size) for name, size in largest_packages(environment.folder)]
        starts = [environment.run("dualcam", "--help") for _ in range(STARTS)]
        rows.append(row("dualcam --help", statistics.median(starts)))
        rows += [row(f"dualcam {what}", environment.run("dualcam", *w)) for what, w in COMMANDS.items()]
        total = sum(float(one["time [s]"]) for one in rows if one["time [s]"])
        rows.append(row("all of the above", total))
        apart = differences(environment) | package_differences(environment)
        rows += [row(what, None, None, value) for what, value in apart.items()]
    return rows


def main(words: Sequence[str] | None = None) -> int:
    arguments = harness.options(__doc__, "first_use").parse_args(words)
    console = harness.new_console()
    rows = measure()
    table = harness.table("first use", *COLUMNS)
    for entry in rows:
        table.add_row(*entry.values())
    console.print(table)
    facts = circumstances("firstuse", "numpy")
    harness.publish(rows, facts, arguments.output, console)
    return 0


if __name__ == "__main__":
    sys.exit(main())
