"""Stick-slip behind a soft shaft: limit cycles of the FMU against closed solution and phase plane.

    ./build.sh run stickslip

Amplitude and period over the speed of the drive, the speed at which the cycle ends, and the rate at which
oscillations about steady slip grow; for Coulomb friction with a static excess and for a Stribeck law."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.console import Console

from benchmarks.harness import core
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import DOCS
from benchmarks.stick_slip import reference, run
from benchmarks.stick_slip.picture import picture
from benchmarks.stick_slip.scene import SCENES, Cycle, Scene
from dualcam import Fmu

SHARES = (0.02, 0.05, 0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 0.97, 0.999)  # of the last speed
ACCURACY = 1e-5  # of the last speed


@dataclass(frozen=True)
class Point:
    """At a speed of the drive [rad/s]."""

    speed: float
    found: Cycle | None
    expected: Cycle | None


@dataclass(frozen=True)
class End:
    """The speed at which the cycle ends: in the FMU, and by the reference [rad/s]."""

    found: float
    expected: float


def points(fmu: Fmu, scene: Scene, last: float, shares: Sequence[float] = SHARES) -> list[Point]:
    """Cycles at these shares of the last speed."""
    speeds = [share * last for share in shares]
    return [Point(speed, run.cycle(fmu, scene, speed), reference.cycle(scene, speed)) for speed in speeds]


def end(fmu: Fmu, scene: Scene, accuracy: float = ACCURACY) -> End:
    expected = reference.last_speed(scene)
    return End(run.last_speed(fmu, scene, 0.99 * expected, 1.01 * expected, accuracy), expected)


def rows_of(name: str, found: Sequence[Point], ends: End) -> list[dict[str, str]]:
    rows = []
    for point in found:
        if point.found is None or point.expected is None:
            raise RuntimeError(f"{name}: no cycle at {point.speed} rad/s")
        amplitude = point.found.amplitude / point.expected.amplitude - 1.0
        period = point.found.period / point.expected.period - 1.0
        rows.append(
            {
                "friction": name,
                "speed of the drive [rad/s]": f"{point.speed:.6g}",
                "amplitude [rad]": f"{point.found.amplitude:.8g}",
                "relative error": f"{amplitude:.1e}",
                "period [s]": f"{point.found.period:.8g}",
                "relative error of the period": f"{period:.1e}",
                "last speed [rad/s]": f"{ends.found:.6g}",
                "relative error of the last speed": f"{ends.found / ends.expected - 1.0:.1e}",
            }
        )
    return rows


def report(rows: list[dict[str, str]], console: Console) -> None:
    names = ("speed", "amplitude", "error", "period", "error", "last speed", "error")
    for friction in dict.fromkeys(row["friction"] for row in rows):
        table = harness.table(friction, *names)
        for row in rows:
            if row["friction"] == friction:
                table.add_row(*list(row.values())[1:])
        console.print(table)


def main() -> int:
    arguments = harness.options(__doc__, "stick_slip", picture=DOCS / "stick_slip.png").parse_args()
    console = harness.new_console()
    rows, cycles, ends = [], {}, {}
    with Fmu(core.fmu_path(core.FORWARD)) as fmu:
        for name, scene in SCENES.items():
            ends[name] = end(fmu, scene)
            cycles[name] = points(fmu, scene, ends[name].expected)
            rows += rows_of(name, cycles[name], ends[name])
        report(rows, console)
        facts = circumstances("stickslip", "numpy", "scipy")
        found = {
            name: (
                np.array([[p.speed, p.found.amplitude, p.found.period] for p in cycles[name] if p.found]),
                ends[name].expected,
            )
            for name in SCENES
        }
        picture(fmu, found, facts, arguments.picture)
    harness.publish(rows, facts, arguments.output, console, arguments.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
