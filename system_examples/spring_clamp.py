"""How far does the torque of a dual cam drift while its grease warms up?

A fixture in a cold hall clamps a workpiece and lets go, every 3 s, for one hour. A servo loads the spring of
the clamp, the stick band of the cam holds the clamp, the servo releases the spring. At the start the grease
has 5 degC and is thick. Friction heats the contacts, the grease gets thinner, and friction falls.

    FMU --heat of both contacts--> thermal network --temperature of the contacts--> viscosity of the grease
     ^-----------Stribeck velocity, slope of the lubricated branch-----------------------|

The FMU knows no temperature. The loop is closed outside the FMU, once per cycle: the FMU's ledger has the
heat of each contact, and the coefficients of friction can be tuned during a run. The comparison is the same
clamp whose friction stays that of the cold start.

Grease: the base oil of a usual grease under Vogel's law (dualcam.systems.blocks.grease). Thermal network:
contact zone and housing, in air (dualcam.systems.blocks.thermal_network). Clamp, servo, numbers:
dualcam.systems.machines.clamp. The coefficients of friction are plausible, not measured.

Left out, in both cases alike: heat of the servo and of the spring, the workpiece, the thickener of the
grease, losses of bearings.

Copy this file for an own system. The same system as an SSP package: system_examples/ssp/clamp.py.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dualcam import Fmu
from dualcam.systems.blocks.grease import CELSIUS
from dualcam.systems.machines import clamp
from dualcam.systems.machines.clamp import GREASE, HALL, MOTION, NETWORK, WarmUp

BUILD = Path(__file__).resolve().parent.parent / "build"
COLD, WARMING = "friction of the cold start", "friction follows the temperature"
COLOURS = {COLD: "tab:grey", WARMING: "tab:red"}
CYCLES = round(3600.0 / MOTION.period)
MINUTES = (0, 1, 5, 10, 20, 40, 60)  # rows of the table; the last one is the last cycle
Results = dict[str, WarmUp]


# ---- run ----


def run(path: str | Path, cycles: int = CYCLES) -> Results:
    """Both cases with the FMU at that path."""
    with Fmu(path) as fmu:
        return {
            name: clamp.run(fmu, cycles, warming=warming)
            for name, warming in ((WARMING, True), (COLD, False))
        }


# ---- results ----


def design_table() -> list[str]:
    """The clamp and its grease."""
    release, load = clamp.cam(HALL).band(MOTION.end)
    a, b, c = GREASE.oil.vogel
    viscous = GREASE.oil.relative_viscosity(HALL)
    return [
        f"Spring clamp: {clamp.PRELOAD:.0f} N and {clamp.STIFFNESS / 1e3:.0f} N/mm, stroke"
        f" {1e3 * clamp.cam(HALL).dz_dtheta * MOTION.end:.0f} mm; stick band when clamped {release:.1f} to"
        f" {load:.1f} N.m",
        f"Cycle: {MOTION.period:.0f} s, moves of {MOTION.move:.1f} s; sliding speed up to"
        f" {1e3 * clamp.sliding_speed(MOTION.peak_speed):.0f} mm/s",
        f"Base oil: {GREASE.oil.viscosity_40:.0f} mm2/s at 40 degC, {GREASE.oil.viscosity_100:.0f} mm2/s at"
        f" 100 degC; eta = {1e6 * a:.1f} uPa.s exp({b:.0f} K/(T - {c:.2f} K)),",
        f"          at {HALL - CELSIUS:.0f} degC {viscous:.1f} times as viscous as at 40 degC",
        f"Air {NETWORK.air - CELSIUS:.0f} degC; contact zone {NETWORK.contact_capacity:.0f} J/K, housing"
        f" {NETWORK.housing_capacity:.0f} J/K; {NETWORK.contact_conductance:.2f} W/K between them,"
        f" {NETWORK.air_conductance:.2f} W/K to the air",
    ]


def cycle_at(minute: float, record: WarmUp) -> int:
    """The cycle that begins then, or the last one."""
    return min(round(60.0 * minute / MOTION.period), len(record.friction_heat) - 1)


def result_row(record: WarmUp, k: int) -> list[str]:
    """The cells of the table for one cycle, without the time."""
    state, load, release = record.thermal[k], record.loading[k], record.releasing[k]
    return [
        f"{state.contact - CELSIUS:.1f}",
        f"{state.housing - CELSIUS:.1f}",
        f"{load.friction_coefficient:.3f}",
        f"{load.torque:.2f}",
        f"{release.torque:.2f}",
        f"{record.friction_heat[k]:.2f}",
        f"{1e3 * record.largest_error[k]:.1f}",
    ]


def result_table(results: Results) -> list[str]:
    """Temperatures, friction and torque over the hour."""
    lines = []
    for name, record in results.items():
        lines += [
            f"{name[0].upper()}{name[1:]}",
            "           contact  housing  friction     torque at mid-stroke      heat per    largest",
            "    time     zone            coefficient  loading    releasing       cycle     error",
            "   [min]   [degC]   [degC]       [1]       [N.m]       [N.m]          [J]      [mrad]",
        ]
        for minute in MINUTES:
            cells = result_row(record, cycle_at(minute, record))
            widths = (8, 8, 11, 12, 12, 13, 11)
            lines.append(
                f"{minute:8d} " + "".join(f"{cell:>{w}}" for cell, w in zip(cells, widths, strict=True))
            )
        lines.append("")
    return lines


def balance_table(results: Results) -> list[str]:
    """Where the heat has gone: the FMU's account beside those of the network."""
    lines = ["Heat [J]                            from the FMU   to the air   in the masses   left over"]
    for name, record in results.items():
        end = record.thermal[-1]
        stored = NETWORK.stored(end)
        rest = record.ledger_heat - end.heat_out - stored
        lines.append(
            f"{name:35s} {record.ledger_heat:12.1f} {end.heat_out:12.1f} {stored:15.1f} {rest:11.0e}"
        )
    return lines


# ---- picture ----


def picture(results: Results, output: Path) -> None:
    """Save temperatures, torque and the friction law as an image."""
    figure = Figure(figsize=(13.0, 4.5), layout="constrained")
    temperature, torque, law = figure.subplots(1, 3)
    draw_temperature(temperature, results)
    draw_torque(torque, results)
    draw_law(law, results[WARMING])
    output.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(output, dpi=110)


def draw_temperature(axes: Axes, results: Results) -> None:
    """Contact zone and housing over time."""
    for name, record in results.items():
        for node, style in (("contact", "-"), ("housing", "--")):
            axes.plot(
                record.time / 60.0, record.column(node), style, color=COLOURS[name], label=f"{node}, {name}"
            )
    axes.set(title="Temperatures", xlabel="time [min]", ylabel="temperature [degC]", xlim=(0.0, 60.0))
    axes.set(ylim=(0.0, 60.0))
    axes.legend(loc="upper left", fontsize=9)


def draw_torque(axes: Axes, results: Results) -> None:
    """The torque at mid-stroke over time."""
    for name, record in results.items():
        for middles, style in ((record.loading, "-"), (record.releasing, "--")):
            axes.plot(record.time / 60.0, [m.torque for m in middles], style, color=COLOURS[name])
    for torque, label in ((18.5, "loading"), (11.2, "releasing")):
        axes.text(30.0, torque, label, color=COLOURS[WARMING])
    axes.text(30.0, 22.6, COLD, color=COLOURS[COLD], ha="center")
    axes.set(title="Torque at mid-stroke", xlabel="time [min]", ylabel="torque [N.m]", xlim=(0.0, 60.0))
    axes.set(ylim=(0.0, 26.0))


def draw_law(axes: Axes, record: WarmUp) -> None:
    """The friction coefficient over the sliding speed, cold to warm."""
    speed = np.linspace(0.0, clamp.sliding_speed(MOTION.peak_speed), 300)
    end = record.thermal[-1].contact
    for temperature, colour in ((HALL, "tab:blue"), (CELSIUS + 15.0, "tab:purple"), (end, "tab:red")):
        mu = [GREASE.coefficient(v, temperature) for v in speed]
        axes.plot(1e3 * speed, mu, color=colour, label=f"{temperature - CELSIUS:.0f} degC")
    axes.set(title="Friction of the grease", xlabel="sliding speed [mm/s]", ylabel="friction coefficient")
    axes.set(xlim=(0.0, 1e3 * speed[-1]), ylim=(0.0, 0.3))
    axes.legend(loc="upper left", fontsize=9)


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--fmu", type=Path, default=BUILD / "DualCamForward.fmu")
    parser.add_argument("--output", type=Path, default=BUILD / "spring_clamp.png", help="picture to write")
    options = parser.parse_args(arguments)
    results = run(options.fmu)
    print("\n".join([*design_table(), "", *result_table(results), *balance_table(results)]))
    picture(results, options.output)
    print(f"\nPicture: {options.output}")


if __name__ == "__main__":
    main()
