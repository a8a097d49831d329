"""Hunting of a PI position loop: the border between rest and growth, predicted and of the FMU in the loop.

    ./build.sh run hunting

The joint is the default cam at 0.7 rad. The controller gives its torque every ms:

    tau = middle of the band + Kp e + sum of Ki e ms

Left: the loop begins with a swing of 0.1 rad. The line is where the predicted border has this amplitude
(CamHysteresis.limit_cycles). Right: the border over the integral gain. The table also has the border over the
static excess of friction."""

from __future__ import annotations

import math
import sys
import warnings
from dataclasses import dataclass
from pathlib import Path

import control
import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from benchmarks.harness import core, pictures
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import DOCS, VERIFICATION
from dualcam import CamHysteresis, Fmu
from dualcam.control import LimitCycle
from dualcam.errors import LimitCycleWarning

Array = NDArray[np.float64]
Values = dict[str, float | int]

THETA, PERIOD, SWING = 0.7, 1e-3, 0.1  # rad, s, rad
PROPORTIONAL = (10.0, 20.0, 35.0, 60.0, 100.0)  # N.m/rad
INTEGRAL = (100.0, 200.0, 400.0, 800.0, 1600.0, 3200.0)  # N.m/(rad.s)
PEAKS = (1.0, 1.2, 1.4, 1.6, 1.8, 2.0)
GAINS = (50.0, 2000.0)  # of the loops with a static excess
STRIBECK = 0.03  # m/s
SAMPLES = 3000  # of a run
LARGE = 0.3  # rad: beyond any hunting within the stick band; growth ends at the stops


@dataclass(frozen=True)
class Loop:
    """A PI controller on the cam."""

    proportional: float
    integral: float
    peak: float = 1.0

    @property
    def parameters(self) -> Values:
        return {
            f"cam{i}.{name}": value
            for i in (1, 2)
            for name, value in (("friction_peak", self.peak), ("stribeck_velocity", STRIBECK))
        }

    def hysteresis(self) -> CamHysteresis:
        return CamHysteresis(core.fmu_path(core.FORWARD), THETA, parameters=self.parameters)

    def predicted(self) -> LimitCycle | None:
        """The border; None where there is none between the stops."""
        law = control.ss(1.0, self.integral * PERIOD, 1.0, self.proportional, PERIOD)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", LimitCycleWarning)  # the margin is in the table
            found = self.hysteresis().limit_cycles(law, check=False).predicted
        borders = [one for one in found if not one.stable]
        return borders[0] if borders else None

    def frequency(self) -> float:
        """Of the swing without friction [rad/s]: 5.2 N.m/rad of the cam's spring, 0.002 kg.m2."""
        return math.sqrt((self.proportional + 5.2) / 0.002)

    def grows(self, fmu: Fmu, amplitude: float, frequency: float) -> bool:
        """Whether a swing grows to the stops. The swing begins in the middle, on the way up."""
        bias = float(np.mean(self.hysteresis().band(THETA)))
        integral = self.integral * PERIOD / (np.exp(1j * frequency * PERIOD) - 1.0) * -amplitude
        held, angles = bias + float(integral.imag), np.empty(SAMPLES)
        fmu.start(
            self.parameters | {"initial.theta": THETA, "initial.omega": amplitude * frequency, "tau": held}
        )
        tau, theta = fmu.reals("tau"), fmu.reals("theta")
        for k in range(SAMPLES):
            (angles[k],) = theta.read()
            error = THETA - angles[k]
            tau.values[:] = held + self.proportional * error
            tau.write()
            held += self.integral * PERIOD * error
            fmu.step(PERIOD)
        return bool(np.ptp(angles[-SAMPLES // 4 :]) > 2.0 * max(amplitude, LARGE))

    def border(self, fmu: Fmu, near: float, frequency: float) -> float:
        """Amplitude [rad] from which on swings grow in the FMU, to 0.5 %."""
        low, high = 0.02 * near, min(2.0 * near, 0.69)
        while high > 1.005 * low:
            middle = math.sqrt(low * high)
            low, high = (low, middle) if self.grows(fmu, middle, frequency) else (middle, high)
        return math.sqrt(low * high)


def rows_of(fmu: Fmu) -> list[dict[str, str]]:
    """Of all loops: those without a static excess first."""
    loops = [Loop(p, i) for p in PROPORTIONAL for i in INTEGRAL] + [Loop(*GAINS, peak) for peak in PEAKS]
    rows = []
    for loop in loops:
        predicted = loop.predicted()
        found = loop.border(fmu, predicted.amplitude, predicted.frequency) if predicted else math.nan
        rows.append(
            {
                "Kp [N.m/rad]": f"{loop.proportional:g}",
                "Ki [N.m/(rad.s)]": f"{loop.integral:g}",
                "friction peak": f"{loop.peak:g}",
                "predicted border [rad]": f"{predicted.amplitude:.4f}" if predicted else "",
                "border of the FMU [rad]": f"{found:.4f}" if predicted else "",
                "predicted over FMU": f"{predicted.amplitude / found:.3f}" if predicted else "",
                "margin": f"{predicted.margin:.3g}" if predicted else "",
                "grows from 0.1 rad": "yes" if loop.grows(fmu, SWING, loop.frequency()) else "no",
            }
        )
    return rows


def report(rows: list[dict[str, str]], console: Console) -> None:
    table = harness.table("PI position loop of the default cam", *rows[0])
    for row in rows:
        table.add_row(*row.values())
    console.print(table)


def picture(rows: list[dict[str, str]], facts: dict[str, str], path: Path) -> None:
    body, (left, right) = pictures.blank(9.0, 4.2, columns=2)
    numbers = [[float(value or "nan") for value in list(row.values())[:5]] for row in rows]
    count = len(PROPORTIONAL) * len(INTEGRAL)
    borders = np.array(numbers)[:count, 3].reshape(len(PROPORTIONAL), len(INTEGRAL))
    borders = np.where(np.isnan(borders), 1.0, borders)  # beyond the stops
    left.contour(
        np.log10(INTEGRAL),
        PROPORTIONAL,
        np.log(borders),
        [math.log(SWING)],
        colors="black",
        linestyles="solid",
    )
    left.plot([], [], color="black", label="predicted border")
    for word, mark, label in (("no", "o", "FMU: comes to rest"), ("yes", "x", "FMU: grows")):
        chosen = [
            n for n, row in zip(numbers, rows[:count], strict=False) if row["grows from 0.1 rad"] == word
        ]
        colour = "C0" if word == "no" else "C3"
        left.plot(np.log10([n[1] for n in chosen]), [n[0] for n in chosen], mark, color=colour, label=label)
    left.set_xticks(np.log10(INTEGRAL), [f"{value:g}" for value in INTEGRAL])
    left.set_xlabel("integral gain [N.m/(rad.s)]")
    left.set_ylabel("proportional gain [N.m/rad]")
    left.set_title("from a swing of 0.1 rad", fontsize=10)
    left.set_ylim(0.0, 150.0)
    left.legend(fontsize=8, loc="upper left")
    for number, proportional in enumerate(PROPORTIONAL):
        points = np.array([n for n in numbers[:count] if n[0] == proportional])
        right.loglog(points[:, 1], points[:, 3], color=f"C{number}", label=f"{proportional:g} N.m/rad")
        right.loglog(points[:, 1], points[:, 4], "o", ms=4, color=f"C{number}")
    right.set_xticks(INTEGRAL, [f"{value:g}" for value in INTEGRAL])
    right.set_yticks([0.01, 0.02, 0.05, 0.1, 0.2, 0.5], ["0.01", "0.02", "0.05", "0.1", "0.2", "0.5"])
    right.minorticks_off()
    right.set_xlabel("integral gain [N.m/(rad.s)]")
    right.set_ylabel("amplitude of the border [rad]")
    right.set_title("lines: predicted, marks: FMU", fontsize=10)
    right.legend(fontsize=8, loc="lower left")
    pictures.finish(body, facts, path)


def main() -> int:
    arguments = harness.options(
        __doc__, "hunting", picture=DOCS / "hunting.png", folder=VERIFICATION / "results"
    ).parse_args()
    console = harness.new_console()
    with Fmu(core.fmu_path(core.FORWARD)) as fmu:
        rows = rows_of(fmu)
    report(rows, console)
    facts = circumstances("hunting", "numpy", "scipy", "control")
    picture(rows, facts, arguments.picture)
    harness.publish(rows, facts, arguments.output, console, arguments.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
