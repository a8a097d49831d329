"""A motor in Python on the forward FMU: which coupling is stable, and how large its error is.

The winding of the motor AK80-6 drives the cam through a gear of 50:1. The voltage is a sine, with which the
cam turns from the lower stop to the upper stop and back, and sticks in between:

    tau = N Kt (v(t) - N Kt omega)/R - N^2 J_rotor alpha

The rotor's inertia is left out, is part of the plant (its torque needs alpha), or is in `inertia.shaft`. The
coupling is explicit (PlantCoupling.step_explicit) or implicit (step_implicit).

The truth is one FMU that holds the whole system: the rotor in `inertia.shaft`, the back-EMF as
`shaft.damping`, and the torque N Kt v(t)/R with three derivatives in steps of 0.05 ms.
tests/test_own_plant.py compares the truth with SciPy's solution of the equations."""

from __future__ import annotations

import math
import sys
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console

from benchmarks.harness import core, pictures
from benchmarks.harness import results as harness
from benchmarks.harness.circumstances import circumstances
from benchmarks.harness.repository import DOCS
from benchmarks.harness.timing import Array
from dualcam import Fmu
from dualcam.coupling import PlantCoupling, ShaftMotion, reflected_inertia
from dualcam.errors import UnstableCouplingWarning
from dualcam.systems.blocks.motor import AK80_6

GEAR_RATIO = 50.0
CONSTANT = GEAR_RATIO * AK80_6.torque_constant  # N.m/A at the shaft
DAMPING = CONSTANT**2 / AK80_6.resistance  # N.m.s/rad, of the back-EMF
ROTOR = reflected_inertia(GEAR_RATIO, AK80_6.rotor_inertia)  # kg.m2 at the shaft
CAM = 0.002  # kg.m2
VOLTAGE, FREQUENCY = 15.0, 0.7  # V, Hz
DURATION, STEP = 1.4, 1e-3  # s
STEPS = (0.25e-3, 0.5e-3, STEP, 2e-3, 4e-3)  # s
TRUTH_STEP = 0.05e-3  # s


def voltage(time: float) -> float:
    return VOLTAGE * math.sin(2.0 * math.pi * FREQUENCY * time)


def winding(shaft: ShaftMotion) -> float:
    """Torque of the motor without its rotor's inertia [N.m]."""
    return CONSTANT * (voltage(shaft.time) - CONSTANT * shaft.omega) / AK80_6.resistance


def motor(shaft: ShaftMotion) -> float:
    """Torque of the motor with its rotor's inertia [N.m]."""
    return winding(shaft) - ROTOR * shaft.alpha


@dataclass(frozen=True)
class Variant:
    """A way to couple. `order`: of explicit coupling. `end_weight`: of implicit coupling, else NaN."""

    name: str
    rotor: str  # "left out", "in the plant" or "in inertia.shaft"
    order: int = 0
    end_weight: float = math.nan

    @property
    def coupling(self) -> str:
        if math.isnan(self.end_weight):
            return "explicit, " + ("torque held", "straight line", "parabola")[self.order]
        return "implicit, " + ("mean motion" if self.end_weight == 0.5 else "end motion")


VARIANTS = (
    Variant("a", "left out"),
    Variant("b", "in the plant"),
    Variant("c", "in inertia.shaft"),
    Variant("d", "in inertia.shaft", order=1),
    Variant("e", "in inertia.shaft", order=2),
    Variant("f", "in the plant", end_weight=0.5),
    Variant("g", "in inertia.shaft", end_weight=0.5),
    Variant("h", "in inertia.shaft", end_weight=1.0),
)


@dataclass(frozen=True)
class Run:
    """theta [rad] and omega [rad/s] after each step, shape (n, 2); the spectral radius in the last step in
    which the cam slid, NaN for implicit coupling; steps of the FMU per communication step."""

    motion: Array
    spectral_radius: float
    fmu_steps: float
    warned: bool


def truth(fmu: Fmu) -> Array:
    """theta [rad] and omega [rad/s] at multiples of TRUTH_STEP from 0 on, shape (n, 2)."""
    gain, circular = CONSTANT / AK80_6.resistance, 2.0 * math.pi * FREQUENCY
    fmu.start({"inertia.shaft": CAM + ROTOR, "shaft.damping": DAMPING})
    tau, motion = fmu.reals("tau"), fmu.reals("theta", "omega")
    found = [motion.read()]
    for k in range(round(DURATION / TRUTH_STEP)):
        phase = circular * k * TRUTH_STEP
        tau.values[:] = gain * VOLTAGE * math.sin(phase)
        tau.write()
        for order, shape in enumerate((math.cos(phase), -math.sin(phase), -math.cos(phase)), start=1):
            tau.write_derivatives(order, [gain * VOLTAGE * circular**order * shape])
        fmu.step(TRUTH_STEP)
        found.append(motion.read())
    return np.array(found)


def run(fmu: Fmu, variant: Variant, step: float) -> Run:
    fmu.start({"inertia.shaft": CAM + (ROTOR if variant.rotor == "in inertia.shaft" else 0.0)})
    coupling = PlantCoupling(fmu, motor if variant.rotor == "in the plant" else winding)
    count = round(DURATION / step)
    found, radius, trials = np.empty((count, 2)), math.nan, 0
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for k in range(count):
            if math.isnan(variant.end_weight):
                made = coupling.step_explicit(step, variant.order)
            else:
                made = coupling.step_implicit(step, variant.end_weight)
            radius = made.stability.spectral_radius if made.stability else radius
            found[k] = made.motion.theta, made.motion.omega
            trials += made.fmu_steps
    warned = any(issubclass(one.category, UnstableCouplingWarning) for one in caught)
    return Run(found, radius, trials / count, warned)


def error(made: Run, exact: Array, step: float) -> float:
    """Largest error of theta [rad]."""
    stride = round(step / TRUTH_STEP)
    return float(np.abs(made.motion[:, 0] - exact[stride::stride, 0]).max())


def study(fmu: Fmu, steps: Sequence[float] = STEPS) -> tuple[Array, dict[tuple[Variant, float], Run]]:
    """The truth, and all variants with all steps."""
    exact = truth(fmu)
    return exact, {(variant, step): run(fmu, variant, step) for variant in VARIANTS for step in steps}


def rows_of(exact: Array, runs: dict[tuple[Variant, float], Run]) -> list[dict[str, str]]:
    return [
        {
            "variant": variant.name,
            "rotor": variant.rotor,
            "coupling": variant.coupling,
            "step [s]": f"{step:g}",
            "spectral radius": "" if math.isnan(made.spectral_radius) else f"{made.spectral_radius:.3g}",
            "warned": "yes" if made.warned else "no",
            "theta max [rad]": f"{error(made, exact, step):.2g}",
            "FMU steps": f"{made.fmu_steps:.3g}",
        }
        for (variant, step), made in runs.items()
    ]


def report(rows: list[dict[str, str]], console: Console) -> None:
    columns = [name for name in rows[0] if name != "step [s]"]
    for step in dict.fromkeys(row["step [s]"] for row in rows):
        table = harness.table(f"communication step {step} s", *columns)
        for row in rows:
            if row["step [s]"] == step:
                table.add_row(*(row[name] for name in columns))
        console.print(table)


def picture(exact: Array, runs: dict[tuple[Variant, float], Run], facts: dict[str, str], path: Path) -> None:
    figure, (left, right) = pictures.blank(12.5, 5.2, columns=2)
    for number, variant in enumerate(VARIANTS):
        steps = [step for one, step in runs if one is variant]
        errors = [error(runs[variant, step], exact, step) for step in steps]
        implicit = not math.isnan(variant.end_weight)
        left.loglog(
            [1e3 * step for step in steps],
            errors,
            "o-" if implicit else "s--",
            ms=4,
            color=f"C{number}",
            label=f"{variant.name}: rotor {variant.rotor}, {variant.coupling}",
        )
    left.set_xticks([1e3 * step for step in STEPS], [f"{1e3 * step:g}" for step in STEPS])
    left.minorticks_off()
    left.set_xlabel("communication step [ms]")
    left.set_ylabel("largest error of the angle [rad]")
    time = np.arange(len(exact)) * TRUTH_STEP
    right.plot(time, exact[:, 0], color="black", lw=4.0, alpha=0.3, label="whole system in one FMU")
    for variant in (VARIANTS[0], VARIANTS[6]):
        found = runs[variant, STEP].motion[:, 0]
        right.plot(
            np.arange(1, len(found) + 1) * STEP,
            found,
            lw=0.8,
            color=f"C{VARIANTS.index(variant)}",
            label=f"{variant.name}: rotor {variant.rotor}, {variant.coupling}",
        )
    right.set_title(f"steps of {1e3 * STEP:g} ms", fontsize=11)
    right.set_xlabel("time [s]")
    right.set_ylabel("angle of cam 2 [rad]")
    right.set_ylim(-0.05, 1.85)
    for panel in (left, right):
        panel.legend(fontsize=7.5, loc="lower right" if panel is left else "upper right")
    left.set_ylim(top=3.0, bottom=1e-9)
    pictures.finish(figure, facts, path)


def main() -> int:
    arguments = harness.options(__doc__, "own_plant", picture=DOCS / "own_plant.png").parse_args()
    console = harness.new_console()
    with Fmu(core.fmu_path(core.FORWARD)) as fmu:
        exact, runs = study(fmu)
    rows, facts = rows_of(exact, runs), circumstances("ownplant", "numpy")
    report(rows, console)
    picture(exact, runs, facts, arguments.picture)
    harness.publish(rows, facts, arguments.output, console, arguments.picture)
    return 0


if __name__ == "__main__":
    sys.exit(main())
