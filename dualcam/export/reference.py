"""The reference result in an exported FMU: a run of the exported FMU itself, for a check of other tools."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from dualcam.errors import ExportError, FmuError
from dualcam.export.curves import SlowMotionCurves
from dualcam.export.description import number_text
from dualcam.fmi.fmu import Fmu

PERIOD = 0.01  # s
SHARE_OF_TORQUE = 0.8  # of the largest torque that loads: the run stays below the upper stop
SHARE_OF_FORCE = 0.05  # of the largest spring force
SHARE_OF_RANGE = 0.86  # of the angle between the stops
FOLDER = "extra/reference/"
OUTPUTS = {
    "forward": ("theta", "omega", "z", "v", "mode", "energy.spring", "energy.heat_cam1", "energy.heat_cam2"),
    "inverse": ("tau", "z", "v", "cam1.reaction", "cam2.reaction"),
}
INPUTS = {"forward": ("tau", "F_ext"), "inverse": ("theta", "omega", "alpha", "F_ext")}
HOW = {
    "forward": """\
Between the lines of the first file the inputs are straight lines; give the FMU their slopes with
fmi2SetRealInputDerivatives, in FMI 3.0 by intermediate update. A master that holds the inputs of a step's
beginning lags behind.""",
    "inverse": """\
A line of the first file is set before the step that ends at its time; the first one, before the
initialization ends.""",
}

Rows = list[list[float]]


@dataclass(frozen=True)
class Reference:
    """Inputs and results, one row each: time [s], then INPUTS or OUTPUTS of the model in SI units."""

    model: str
    inputs: Rows
    results: Rows

    def members(self, name: str) -> dict[str, bytes]:
        """Name in the archive -> content, for the model `name`."""
        title = f"Reference result of {name}"
        files = f"{name}_in.csv    inputs over time\n{name}_ref.csv   what the FMU answers"
        text = f"""\
{title}
{"=" * len(title)}

{files}

Every parameter has its start value. All numbers are in the units of modelDescription.xml.

{HOW[self.model]}

This FMU itself made the result in steps of {PERIOD:g} s, for a check of another tool. The original FMU of the
project dualcam holds a result of an independent program.
"""
        return {
            f"{FOLDER}README.txt": text.encode(),
            f"{FOLDER}{name}_in.csv": _table(INPUTS[self.model], self.inputs),
            f"{FOLDER}{name}_ref.csv": _table(OUTPUTS[self.model], self.results),
        }

    def largest_force(self) -> float:
        """The largest F_ext [N] of the run."""
        return max(row[1 + INPUTS[self.model].index("F_ext")] for row in self.inputs)

    def loop(self) -> tuple[list[float], list[float]]:
        """theta [rad] and tau [N.m] of each result."""
        if self.model == "inverse":
            return [row[1] for row in self.inputs], [row[1] for row in self.results]
        return [row[1] for row in self.results], [_between(self.inputs, row[0]) for row in self.results]


def reference_result(fmu: Fmu, model: str, curves: SlowMotionCurves) -> Reference:
    """Play the reference run of the exported FMU. ExportError if the FMU fails."""
    run = {"forward": _forward, "inverse": _inverse}[model]
    try:
        return Reference(model, *run(fmu, curves))
    except FmuError as error:
        raise ExportError(f"reference run at {fmu.time:g} s: {error}") from error


def _forward(fmu: Fmu, curves: SlowMotionCurves) -> tuple[Rows, Rows]:
    """Load, hold under a force, let go, hold."""
    torque = _rounded(SHARE_OF_TORQUE * curves.largest("torque_load"))
    force = _rounded(SHARE_OF_FORCE * curves.largest("spring.force"))
    knots = [
        [0.0, 0.0, 0.0],
        [0.4, torque, 0.0],
        [0.5, torque, force],
        [0.9, 0.0, force],
        [1.0, 0.0, force],
    ]
    group = fmu.reals(*INPUTS["forward"])
    fmu.start()
    results = [_row(fmu, "forward", 0.0)]
    for (t0, *u0), (t1, *u1) in pairwise(knots):
        slopes = [(b - a) / (t1 - t0) for a, b in zip(u0, u1, strict=True)]
        for k in range(round((t1 - t0) / PERIOD)):
            begin, end = (round(t0 + i * PERIOD, 9) for i in (k, k + 1))
            group.values[:] = [a + slope * k * PERIOD for a, slope in zip(u0, slopes, strict=True)]
            group.write()
            group.write_derivatives(1, slopes)
            fmu.step(end - begin)
            results.append(_row(fmu, "forward", end))
    return knots, results


def _inverse(fmu: Fmu, curves: SlowMotionCurves) -> tuple[Rows, Rows]:
    """A swing up and back within 1 s, under a growing force."""
    lower, upper = float(curves.theta[0]), float(curves.theta[-1])
    swing = SHARE_OF_RANGE * (upper - lower)
    force = _rounded(SHARE_OF_FORCE * curves.largest("spring.force"))
    inputs: Rows = []
    results: Rows = []
    for k in range(round(1 / PERIOD) + 1):
        t, angle = round(k * PERIOD, 9), 2 * math.pi * k * PERIOD
        turning = 2 * k * PERIOD % 1 != 0  # exactly at rest at both ends of the swing
        theta = lower + 0.5 * swing * (1 - math.cos(angle))
        omega = math.pi * swing * math.sin(angle) * turning
        inputs.append([t, theta, omega, 2 * math.pi**2 * swing * math.cos(angle), force * t])
        now = dict(zip(INPUTS["inverse"], inputs[-1][1:], strict=True))
        if k == 0:
            fmu.start(now)
        else:
            for name, value in now.items():
                fmu.set(name, value)
            fmu.step(t - inputs[-2][0])
        results.append(_row(fmu, "inverse", t))
    return inputs, results


def _row(fmu: Fmu, model: str, time: float) -> list[float]:
    return [time, *(float(fmu.get(name)) for name in OUTPUTS[model])]


def _rounded(value: float) -> float:
    """Two digits; 1 instead of 0, so that an input acts in any case."""
    return float(f"{value:.2g}") or 1.0


def _between(rows: Rows, time: float) -> float:
    """The first input at `time`, on the straight line between two rows."""
    for (t0, u0, *_), (t1, u1, *_) in pairwise(rows):
        if time <= t1:
            return u0 + (u1 - u0) * (time - t0) / (t1 - t0)
    return rows[-1][1]


def _table(names: Sequence[str], rows: Rows) -> bytes:
    lines = [",".join(["time", *names])]
    lines += [",".join(map(number_text, row)) for row in rows]
    return ("\n".join(lines) + "\n").encode()
