"""What a new user does first with the installed package: new design, check, simulation, page, export, run of
the exported FMU. No compiler and no FMPy is used, even where they are installed.

    python tests/support/smoke.py

Runs in an empty scratch folder, so that no module of a clone is imported. The exit code is 0 if all works.
"""

from __future__ import annotations

import importlib
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FORBIDDEN = ("ziglang", "fmpy")
# A module of value None cannot be imported.
WITHOUT_COMPILER = f"import sys; sys.modules.update(dict.fromkeys({FORBIDDEN!r})); "
COMMAND = WITHOUT_COMPILER + "import runpy; runpy.run_module('dualcam', run_name='__main__')"

# Two helices of 45 deg and radius 0.02 m, without friction, under a constant spring force of 50 N: the torque
# 50 N * 0.01 m/rad = 0.5 N.m holds them. 1.5 N.m on 0.01 kg.m2 give 100 rad/s2, and 0.125 rad after 0.05 s.
FRICTIONLESS = {
    "cam1.friction": 0.0,
    "cam2.friction": 0.0,
    "spring.stiffness": 0.0,
    "inertia.shaft": 0.01,
}
TORQUE, SECONDS, ANGLE = 1.5, 0.05, 0.125


def run_from_rest(fmu: Path, parameters: dict[str, float]) -> float:
    """The angle [rad] after a constant torque."""
    dualcam = importlib.import_module("dualcam")
    with dualcam.Fmu(fmu) as cam:
        cam.start({**parameters, "tau": TORQUE})
        for _ in range(50):
            cam.step(SECONDS / 50)
        return float(cam.get("theta"))


def check_own_fmus() -> None:
    """Both FMUs for both versions of FMI are in the package; the forward one does what the hand says."""
    dualcam = importlib.import_module("dualcam")
    package = Path(dualcam.__file__).parent
    for fmi in (2, 3):
        paths = {kind: dualcam.fmu_path(kind, fmi=fmi) for kind in ("forward", "inverse")}
        assert all(path.is_relative_to(package) for path in paths.values()), paths
        angle = run_from_rest(paths["forward"], FRICTIONLESS)
        assert abs(angle - ANGLE) < 1e-9, f"FMI {fmi}: theta = {angle} rad, not {ANGLE} rad"
    print(f"dualcam {dualcam.__version__} in {package}")


def run_commands(folder: Path) -> None:
    """The first commands; afterwards the exported FMU runs."""
    for words in (
        ["new", "my.toml", "--from", "robot"],
        ["check", "my.toml"],
        ["simulate", "my.toml", "-o", "out.csv", "--plot", "out.png"],
        ["view", "my.toml", "-o", "my.html"],
        ["export", "my.toml", "-o", "MyCam.fmu"],
        ["export", "my.toml", "-o", "MyCam3.fmu", "--fmi", "3"],
    ):
        begin = time.perf_counter()
        subprocess.run([sys.executable, "-c", COMMAND, *words], check=True, cwd=folder, timeout=120)
        print(f"dualcam {' '.join(words)}: {time.perf_counter() - begin:.1f} s")
    for name in ("out.csv", "out.png", "my.html"):
        assert (folder / name).stat().st_size > 1000, name
    angles = [run_from_rest(folder / name, FRICTIONLESS) for name in ("MyCam.fmu", "MyCam3.fmu")]
    assert abs(angles[0] - angles[1]) < 1e-12, angles


def main() -> int:
    sys.modules.update(dict.fromkeys(FORBIDDEN))  # type: ignore[arg-type]
    with tempfile.TemporaryDirectory() as scratch:
        os.chdir(scratch)
        try:
            check_own_fmus()
            run_commands(Path(scratch))
        finally:
            os.chdir(Path(scratch).parent)  # Windows removes no folder that is in use
    return 0


if __name__ == "__main__":
    sys.exit(main())
