"""FMUs in a scene: ours from C and through FMPy, one written by hand, one by PythonFMU."""

from __future__ import annotations

import json
import shutil
import time
from functools import cache
from pathlib import Path

from benchmarks.harness import core
from benchmarks.harness.fmu import Parameters
from benchmarks.harness.pieces import PieceRun
from benchmarks.harness.repository import BENCHMARKS
from benchmarks.work_precision.plain_cam import DEFAULTS
from benchmarks.work_precision.scenes import HEATS, Result, Scene

PYTHON_FMU = "PythonCam"


class CFmu(PieceRun):
    """One setting of an FMU in a scene, stepped in C with `steps` steps per piece."""

    def __init__(
        self, scene: Scene, identifier: str, settings: Parameters, tolerance: float, steps: int
    ) -> None:
        self.scene, own = scene, identifier == core.FORWARD
        self.has_ledger = own and bool(settings.get("ledger", True))
        reads = ["theta", "omega", *(f"energy.{name}" for name in HEATS if self.has_ledger)]
        super().__init__(identifier, settings, scene.pieces, reads, steps, tolerance, 5 if own else 1)

    def run(self) -> tuple[float, Result]:
        """Seconds of one run, and its result."""
        seconds = self.seconds()
        points = [(float(theta), float(omega)) for theta, omega in self.points[:, :2]]
        if self.has_ledger:
            return seconds, (points, self.points[:, 2:].sum(axis=1).tolist())
        return seconds, self.scene.result(points)


class FmpyFmu(CFmu):
    """The forward FMU, stepped by FMPy's methods."""

    def run(self) -> tuple[float, Result]:
        fmu = self.slave.fmu
        fmu.setFMUState(self.state)
        torque = [self.slave.references["tau"]]
        outputs, reads = list(self.references[:2]), list(self.references)
        found, instant = [], 0.0
        start = time.perf_counter()
        for duration, tau in self.scene.pieces:
            step = duration / self.steps
            for k in range(self.steps):
                fmu.setReal(torque, [tau])
                fmu.doStep(instant + k * step, step)
                fmu.getReal(outputs)
            instant += duration
            found.append(fmu.getReal(reads))
        seconds = time.perf_counter() - start
        return seconds, self.scene.result([(v[0], v[1]) for v in found])


def hand_written(scene: Scene, step: float, threshold: float) -> CFmu:
    settings = {**DEFAULTS, **scene.parameters, "solver.step": step, "solver.threshold": threshold}
    return CFmu(scene, core.HAND_WRITTEN, dict(settings), 1e-9, 1)


def python_fmu(scene: Scene, method: str, tolerance: float) -> CFmu:
    settings: Parameters = {"parameters": json.dumps(scene.parameters), "method": method}
    return CFmu(scene, PYTHON_FMU, settings, tolerance, 1)


@cache
def build_python_fmu() -> None:
    """PythonCam.fmu from python_fmu/python_cam.py, with plain_cam.py inside."""
    from pythonfmu.builder import FmuBuilder

    folder = core.BUILD / "python_fmu"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    # PythonFMU imports the script and finds the equations beside it only.
    files = (BENCHMARKS / "python_fmu/python_cam.py", BENCHMARKS / "work_precision/plain_cam.py")
    script, equations = (Path(shutil.copy(file, folder)) for file in files)
    made = FmuBuilder.build_FMU(script, dest=folder, project_files=[equations])
    Path(made).replace(core.fmu_path(PYTHON_FMU))
