"""Which groove makes a given spring give a wanted torque, and can that groove be made?

The arm: 1.5 kg at 0.5 m lean 10 deg from upright and fall to the horizontal while cam 2 turns by 80 deg and
loads a linear spring. On the way up the cam must give all of

    T_release(theta) = m g l sin(10 deg + theta),

its friction included. Then the hand that lifts the arm needs no force. To let the arm down slowly, the hand
needs T_load - T_release. Groove 2 is a helix at 45 deg, groove 1 is sought.

The constant torque: 4 N.m over 80 deg while loading, from a linear spring whose force grows threefold, with
equal grooves. They must be steep while the spring is slack and flat when the spring is tight.

Each groove becomes a table for DualCamInverse, which turns through it slowly. Wanted and obtained torque are
compared at angles that are no samples of the table. The strength is read from curvature and pressure, for a
steel pin of 3 mm radius and a flank 8 mm wide.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dualcam import Fmu
from dualcam.design import Assessment, Design, Helix, Limits, Pin, Spring, assess, optimum, synthesize
from dualcam.design.statics import Array
from dualcam.systems.blocks.slow_motion import slow_torque

BUILD = Path(__file__).resolve().parent.parent / "build"
UPPER = math.radians(80.0)
FRICTION = (0.14, 0.14)  # of the paper's first grease
WEIGHT = 1.5 * 9.81 * 0.5  # N.m, of the arm when it is level
LEAN = math.radians(10.0)
PIN = Pin(radius=0.003, width=0.008)
LIMITS = Limits()
SPEED = 1e-3  # rad/s
ANGLES = 997  # at which wanted and obtained torque are compared


@dataclass(frozen=True)
class Task:
    """The wanted torque, and the given spring and groove 2."""

    name: str
    colour: str
    direction: str
    torque: Callable[[Array], Array]
    spring: Spring
    groove2: Helix | None


@dataclass(frozen=True, eq=False)
class Result:
    """The groove that was found, and its torque in the FMU."""

    task: Task
    design: Design
    theta: Array  # rad, shape (ANGLES,)
    obtained: Array  # N.m, of the FMU in the wanted direction
    other: Array  # N.m, the other edge of the stick band
    assessment: Assessment

    @property
    def error(self) -> Array:
        """Obtained over wanted torque, less 1."""
        return self.obtained / self.task.torque(self.theta) - 1.0


TASKS = (
    Task(
        "arm lifted by its spring (releasing)",
        "tab:blue",
        "releasing",
        lambda theta: WEIGHT * np.sin(LEAN + theta),
        Spring(preload=170.0, stiffness=45e3),
        groove2=Helix(0.02, math.radians(45.0)),
    ),
    Task(
        "constant torque (loading), equal grooves",
        "tab:orange",
        "loading",
        lambda theta: np.full(np.shape(theta), 4.0),
        Spring(preload=200.0, stiffness=38e3),
        groove2=None,  # like groove 1
    ),
)


def solve(task: Task, fmu: Fmu) -> Result:
    """Design the groove and turn the FMU through it, both ways."""
    design = synthesize(
        task.torque, UPPER, task.spring, direction=task.direction, groove2=task.groove2, friction=FRICTION
    )
    theta = np.linspace(0.0, UPPER, ANGLES)
    with tempfile.TemporaryDirectory() as directory:
        parameters = design.mechanism.parameters(directory)
        loading = slow_torque(fmu, parameters, theta, SPEED)
        releasing = slow_torque(fmu, parameters, theta[::-1], -SPEED)[::-1]
    obtained, other = (releasing, loading) if task.direction == "releasing" else (loading, releasing)
    return Result(task, design, theta, obtained, other, assess(design.mechanism, PIN, LIMITS))


def run(fmu: str | Path) -> list[Result]:
    """All tasks with the inverse FMU at that path."""
    with Fmu(fmu) as handle:
        return [solve(task, handle) for task in TASKS]


def report(results: Sequence[Result]) -> str:
    """The grooves, their error, efficiency and strength, in words."""
    lines = []
    for result in results:
        checked, table = result.assessment, result.design.table
        lead = np.degrees(checked.lead_angle[0])
        release, load = result.design.mechanism.band(result.theta)
        sharpest = 1e3 / np.abs(checked.curvature).max()
        lines += [
            result.task.name,
            f"  groove 1: {len(table.psi)} samples, {math.degrees(table.psi[-1]):.1f} deg,"
            f" {1e3 * table.z[-1]:.2f} mm, lead angles {lead.min():.1f} to {lead.max():.1f} deg",
            f"  largest error in the FMU {np.abs(result.error).max():.1e} of the torque, at {ANGLES} angles",
            f"  efficiency {np.min(release / load):.3f} to {np.max(release / load):.3f}, at best"
            f" {optimum(FRICTION).efficiency:.3f}",
            f"  sharpest bend {sharpest:.1f} mm (pin {1e3 * PIN.radius:.0f} mm), largest load"
            f" {checked.load.max():.0f} N per contact, pressure {checked.pressure.max() / 1e6:.0f} MPa",
        ]
        lines += [f"  fails: {finding}" for finding in checked.findings] or ["  nothing fails"]
    return "\n".join(lines)


def picture(results: Sequence[Result], output: Path) -> None:
    """Save the designs as an image."""
    figure = Figure(figsize=(13.0, 12.0), layout="constrained")
    axes = figure.subplots(3, 2)
    worst = max(float(np.abs(result.error).max()) for result in results)
    obtained = f"friction {FRICTION[0]} included, obtained within {worst:.0e} of what was wanted"
    figure.suptitle(f"Grooves designed for a wanted torque, as tables in the FMU\n{obtained}", fontsize=14)
    panels = (_draw_torque, _draw_error, _draw_grooves, _draw_lead_angles, _draw_bend, _draw_pressure)
    for panel, draw in zip(axes.flat, panels, strict=True):
        draw(panel, results)
        panel.grid(color="0.9")
        if draw is not _draw_grooves:
            panel.set(xlabel="theta [deg]", xlim=(0.0, 80.0))
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110)


def _draw_torque(axes: Axes, results: Sequence[Result]) -> None:
    for result in results:
        degrees, colour = np.degrees(result.theta), result.task.colour
        axes.plot(degrees, result.obtained, color=colour, lw=4, alpha=0.45, label=result.task.name)
        axes.plot(degrees, result.task.torque(result.theta), "k--", lw=1.2)
        axes.plot(degrees, result.other, color=colour, lw=1, ls=":")
    axes.plot([], [], "k--", lw=1.2, label="wanted")
    axes.plot([], [], "k:", lw=1, label="the way back")
    axes.set(title="Torque of slow motion in DualCamInverse", ylabel="torque [N.m]", ylim=(0.0, 17.0))
    axes.legend(loc="upper left")


def _draw_error(axes: Axes, results: Sequence[Result]) -> None:
    for result in results:
        error = np.maximum(np.abs(result.error), 1e-16)
        axes.semilogy(np.degrees(result.theta), error, color=result.task.colour, lw=0.8)
    axes.axhline(1e-6, color="tab:red", ls="--", lw=1)
    axes.text(79.0, 1.3e-6, "asked for", color="tab:red", ha="right", va="bottom")
    axes.set(title="Obtained against wanted torque", ylabel="relative error", ylim=(1e-11, 1e-5))


def _draw_grooves(axes: Axes, results: Sequence[Result]) -> None:
    theta = np.linspace(0.0, UPPER, 300)
    for result in results:
        mechanism, colour = result.design.mechanism, result.task.colour
        pin = mechanism.configuration(theta)
        z, (first, second) = 1e3 * pin.z, 1e3 * np.array(mechanism.radius)[:, None] * pin.psi
        axes.plot(first, z, color=colour, lw=2)
        if result.task.groove2 is not None:
            axes.plot(second, z, color=colour, lw=1, ls="--")
        _draw_flanks(axes, first, z, colour)
    axes.plot([], [], "k-", lw=2, label="groove 1 (or both): path of the pin and flanks")
    axes.plot([], [], "k--", lw=1, label="groove 2, given: a helix")
    axes.set(title="Unwrapped grooves", xlim=(-5.0, 42.0), ylim=(-5.0, 21.0), aspect="equal")
    axes.set(xlabel="along the circumference, r psi [mm]", ylabel="z [mm]")
    axes.legend(loc="lower right", fontsize=9)


def _draw_flanks(axes: Axes, x: Array, z: Array, colour: str) -> None:
    dx, dz = np.gradient(x), np.gradient(z)
    length = np.hypot(dx, dz) / (1e3 * PIN.radius)
    left, right = ((x - side * dz / length, z + side * dx / length) for side in (1.0, -1.0))
    outline = [np.concatenate([one, other[::-1]]) for one, other in zip(left, right, strict=True)]
    axes.fill(*outline, color=colour, alpha=0.15, lw=0)


def _plot_both_grooves(axes: Axes, results: Sequence[Result], name: str, factor: float) -> None:
    for result in results:
        for value, style in zip(factor * getattr(result.assessment, name), ("-", "--"), strict=True):
            axes.plot(np.degrees(result.assessment.theta), value, color=result.task.colour, ls=style)


def _draw_lead_angles(axes: Axes, results: Sequence[Result]) -> None:
    _plot_both_grooves(axes, results, "lead_angle", 180.0 / math.pi)
    axes.plot([], [], "k-", label="groove 1")
    axes.plot([], [], "k--", label="groove 2")
    axes.axhline(math.degrees(math.atan(FRICTION[0])), color="tab:red", ls=":")
    axes.text(79.0, 8.6, "below: locks itself", color="tab:red", ha="right", va="bottom")
    axes.set(title="Lead angles", ylabel="lead angle [deg]", ylim=(0.0, 80.0))
    axes.legend(loc="upper right")


def _draw_bend(axes: Axes, results: Sequence[Result]) -> None:
    for result in results:
        bend = PIN.radius * result.assessment.curvature[0]
        axes.plot(np.degrees(result.assessment.theta), bend, color=result.task.colour)
    for side in (-1.0, 1.0):
        axes.axhline(side, color="tab:red", ls="--", lw=1)
    axes.text(79.0, -0.97, "beyond: the inner flank is undercut", color="tab:red", ha="right", va="bottom")
    axes.set(title="Bend of groove 1 (+ steepens)", ylim=(-1.1, 1.1))
    axes.set_ylabel("pin radius / radius of curvature")


def _draw_pressure(axes: Axes, results: Sequence[Result]) -> None:
    _plot_both_grooves(axes, results, "pressure", 1e-6)
    axes.axhline(LIMITS.pressure / 1e6, color="tab:red", ls="--", lw=1)
    axes.text(79.0, LIMITS.pressure / 1e6 + 15.0, "allowed", color="tab:red", ha="right", va="bottom")
    axes.set(title="Pressure between pin and flank (Hertz), the higher one of both ways")
    axes.set(ylabel="largest pressure [MPa]", ylim=(0.0, 1700.0))


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--fmu", type=Path, default=BUILD / "DualCamInverse.fmu")
    parser.add_argument("--output", type=Path, default=BUILD / "designed_groove.png", help="picture to write")
    options = parser.parse_args(arguments)
    results = run(options.fmu)
    print(report(results))
    picture(results, options.output)
    print(f"Picture: {options.output}")


if __name__ == "__main__":
    main()
