"""The reference result in an exported FMU: a run of the exported FMU itself, for a check of other tools."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from dualcam.errors import ExportError, FmuError
from dualcam.export.description import number_text
from dualcam.fmi.fmu import Fmu
from dualcam.fmi.model_description import Scalar
from dualcam.fmi.variables import parameters_of

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
Array = NDArray[np.float64]

POINTS = 101
SLOW = 1e-9  # rad/s: a direction of motion; forces of inertia and damping are below rounding
STATE = ("gamma", "z", "spring.force", "torque_load", "torque_release", "efficiency")
STOPS = ("stop.lower", "stop.upper")
REACTIONS = ("cam1.reaction", "cam2.reaction")
# Parameters of the forward FMU -> the inputs that take their place in the inverse FMU, which has no state.
START_INPUTS = {"initial.theta": "theta", "initial.omega": "omega"}
MOTION = {"theta": 0.0, "omega": 0.0, "alpha": 0.0, "F_ext": 0.0, "shaft.stiffness": 0.0}


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
    knots = [[0.0, 0.0, 0.0], [0.4, torque, 0.0], [0.5, torque, force], [0.9, 0.0, force], [1.0, 0.0, force]]
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


@dataclass(frozen=True)
class SlowMotionCurves:
    """Slow motion without external force, from stop to stop. NaN: a jam, or an infinite value."""

    theta: Array  # shape (n,) [rad]
    values: dict[str, Array]  # shape (n,), in the FMU's units
    reactions: dict[str, Array]  # "loading", "releasing"; shape (2, n) for both cams [N, of one contact]

    def largest(self, name: str) -> float:
        """The largest magnitude of an entry of `values`; 0 if the entry has no number."""
        magnitudes = np.abs(self.values[name])
        return float(np.max(magnitudes[np.isfinite(magnitudes)], initial=0.0))


def slow_motion_curves(parameters: Mapping[str, Scalar]) -> SlowMotionCurves:
    """Curves of a design by its parameters, tables as absolute paths. FmuError if the FMU refuses."""
    omitted = (*START_INPUTS, "tau")  # tau is an input of the forward FMU alone
    given = {name: value for name, value in parameters.items() if name not in omitted} | MOTION
    theta = np.linspace(*stops_of(given), POINTS)
    with Fmu("inverse") as fmu:
        loading = np.array([_read(fmu, given, angle, SLOW) for angle in theta]).T
        releasing = np.array([_read(fmu, given, angle, -SLOW) for angle in theta]).T
    state = np.where(np.isfinite(loading), loading, releasing)[: len(STATE)]
    values = {name: np.where(np.isfinite(row), row, np.nan) for name, row in zip(STATE, state, strict=True)}
    reactions = {"loading": loading[len(STATE) :], "releasing": releasing[len(STATE) :]}
    return SlowMotionCurves(theta, values, reactions)


def stops_of(given: Mapping[str, Scalar]) -> tuple[float, float]:
    """Both end stops [rad]: those of the design, else the start values of the FMU."""
    known = parameters_of("inverse")
    lower, upper = (float(given.get(name, known[name].start)) for name in STOPS)
    return lower, upper


def _read(fmu: Fmu, given: Mapping[str, Scalar], theta: float, omega: float) -> list[float]:
    """STATE and REACTIONS at this angle and speed; NaN where the mechanism jams."""
    try:
        fmu.start({**given, "theta": float(theta), "omega": omega})
        return fmu.reals(*STATE, *REACTIONS).read()
    except FmuError:
        return [np.nan] * (len(STATE) + len(REACTIONS))
