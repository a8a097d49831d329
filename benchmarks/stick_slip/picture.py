"""The picture of the limit cycles: amplitude, period and phase plane."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

from benchmarks.harness import pictures
from benchmarks.stick_slip import reference, run
from benchmarks.stick_slip.scene import SCENES, SHAFT, Scene
from dualcam import Fmu

Array = NDArray[np.float64]
COLOURS = ("C0", "C3")
SHOWN = (0.1, 0.5, 0.95)  # of the last speed, in the phase planes
ENDED = 1.02


def orbit(fmu: Fmu, scene: Scene, speed: float, periods: float) -> Array:
    """Torque of the shaft [N.m] and speed of cam 2 [rad/s] from break-away on, shape (n, 2)."""
    shaft = run.SoftShaft(fmu, scene, speed, 0.0, scene.static_torque / SHAFT)
    duration, rows = periods * 2.0 * np.pi / scene.natural_frequency, []
    while fmu.time < duration:
        shaft.step(run.STEP)
        theta, omega, _ = shaft.motion()
        rows.append((SHAFT * shaft.twist(theta), omega))
    return np.array(rows)


def curves(panel: Axes, column: int, factor: float, found: Mapping[str, tuple[Array, float]]) -> None:
    """One figure of the cycle over the speed: the reference as a line, the FMU as marks."""
    for colour, (name, scene) in zip(COLOURS, SCENES.items(), strict=True):
        points, last = found[name]
        speeds = np.geomspace(points[0, 0], 0.9999 * last, 60)
        cycles = [reference.cycle(scene, float(speed)) for speed in speeds]
        values = [(cycle.amplitude, cycle.period)[column] if cycle else np.nan for cycle in cycles]
        panel.plot(speeds, factor * np.array(values), color=colour, lw=1.2, label=f"{name}, reference")
        panel.plot(
            points[:, 0], factor * points[:, column + 1], "o", color=colour, ms=4, label=f"{name}, FMU"
        )
        panel.axvline(last, color=colour, ls=":", lw=1.0)
    panel.set_xlabel("speed of the drive [rad/s]")


def picture(fmu: Fmu, found: Mapping[str, tuple[Array, float]], facts: Mapping[str, str], path: Path) -> None:
    """`found`: by friction, rows of speed, amplitude and period of the FMU, and the last speed."""
    body, (amplitude, period, *planes) = pictures.blank(8.0, 7.0, rows=2, columns=2)
    curves(amplitude, 0, 1e3, found)
    amplitude.set_ylabel("amplitude of the twist [mrad]")
    amplitude.set_ylim(bottom=0.0)
    amplitude.legend(fontsize=7.5)
    curves(period, 1, 1.0, found)
    period.set_ylabel("period [s]")
    period.set_yscale("log")
    period.set_xscale("log")
    period.set_yticks([0.1, 0.2, 0.5, 1.0, 2.0], ["0.1", "0.2", "0.5", "1", "2"])
    period.set_xticks([0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0], ["0.05", "0.1", "0.2", "0.5", "1", "2", "5"])
    period.minorticks_off()
    for panel, colour, (name, scene) in zip(planes, COLOURS, SCENES.items(), strict=True):
        last = found[name][1]
        for share in SHOWN:
            rows = orbit(fmu, scene, share * last, 4.0 if share > 0.2 else 7.0)
            panel.plot(*rows.T, color=colour, lw=1.0)
        panel.plot(*orbit(fmu, scene, ENDED * last, 40.0).T, color="0.6", lw=0.6, zorder=0)
        panel.set_title(f"{name}: {', '.join(f'{s * last:.2g}' for s in SHOWN)} rad/s", fontsize=9)
        panel.set_xlabel("torque of the shaft [N.m]")
        panel.set_ylabel("speed of cam 2 [rad/s]")
    pictures.finish(body, facts, path)
