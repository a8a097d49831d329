"""Draws docs/design_contact.png, design_roller.png, design_wear.png and design_spring.png for
docs/design-quantities.md: the quantities of the design on that page.

Run by `./build.sh run figures`."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dualcam.design import Fatigue, HelicalSpring, Pin, Roller, find_springs, line_contact, shear_below
from dualcam.design_file import DesignFile, read_design
from dualcam.design_file.durability import spring_fatigue, spring_forces, wear_life, wear_of
from dualcam.plots.design import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    draw_contact,
    figure,
    legend_above,
    plot_goodman,
    plot_wear,
)

PAGE = Path(__file__).resolve().parents[1] / "design-quantities.md"
DPI = 200


def page_design() -> DesignFile:
    """The first design on the page."""
    blocks = re.findall(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "lift.toml"
        path.write_text(blocks[0], encoding="utf-8")
        return read_design(path)


def contact_figure(design: DesignFile) -> Figure:
    """Pressure along each groove, and the shear stress below the surface over the depth."""
    assert design.pin is not None
    picture, (pressure, shear, below) = figure(3, 2.6)
    draw_contact(pressure, shear, design.mechanism(), design.pin, np.inf)
    draw_depth(below, Pin(radius=0.003, width=0.008), load=400.0)
    return picture


def draw_depth(axes: Axes, pin: Pin, load: float) -> None:
    """Shear stress over the depth below the middle of the contact, of the worked example."""
    contact = line_contact(load, pin)
    half_width, top = float(contact.half_width), float(contact.pressure)
    depth = np.linspace(0.0, 3.0 * half_width, 200)
    axes.plot(1e6 * depth, shear_below(depth, half_width, top) / 1e6, color=BLUE, label="400 N on 8 mm")
    largest = f"{float(contact.shear) / 1e6:.0f} MPa at {1e6 * float(contact.depth):.0f} µm"
    axes.plot(1e6 * contact.depth, contact.shear / 1e6, "o", color=ORANGE, label=largest)
    axes.set_xlabel("depth below the surface [µm]")
    axes.set_ylabel("shear stress [MPa]")
    axes.set_ylim(bottom=0.0)
    axes.grid(alpha=0.3)
    legend_above(axes)


def roller_figure() -> Figure:
    """Coefficient in effect over the friction of the bearing, of the roller of the worked example."""
    picture, (axes,) = figure(1, 3.0)
    bearing = np.linspace(0.0, 0.6, 241)
    for radius, colour, style in ((0.004, ORANGE, "--"), (0.005, BLUE, "-"), (0.008, GREEN, "-.")):
        rollers = [Roller(radius, float(mu), 0.002, 1e-5) for mu in bearing]
        label = f"roller of {2e3 * radius:g} mm"
        axes.plot(bearing, [one.friction for one in rollers], style, color=colour, label=label)
    axes.axhline(0.14, color=GREY, lw=0.9, ls=":", label="slides")
    axes.set_xlabel("coefficient of friction in the bearing")
    axes.set_ylabel("coefficient of friction\nin effect")
    axes.set_ylim(bottom=0.0)
    axes.grid(alpha=0.3)
    legend_above(axes)
    return picture


def wear_figure(design: DesignFile) -> Figure:
    """Depth along each groove at the end of the life, and the torque then."""
    found = wear_of(design, design.mechanism())
    assert found is not None
    cycles = wear_life(design, found).cycles
    return plot_wear(found, found.after(cycles), cycles)


def spring_figure(design: DesignFile) -> Figure:
    """Goodman diagram of the spring of the page, with the springs of the search."""
    spring, mechanism = design.helical_spring, design.mechanism()
    assert spring is not None and design.limits is not None
    cycle = spring_fatigue(spring, mechanism)
    picture = plot_goodman(spring, cycle, design.limits.spring_safety)
    (axes,) = picture.axes
    least, largest = spring_forces(mechanism)
    better = found_spring(design).fatigue(least, largest)
    axes.plot(better.mean / 1e6, better.amplitude / 1e6, "s", color=GREEN, label=label_of(better))
    legend_above(axes)
    return picture


def label_of(cycle: Fatigue) -> str:
    return f"found spring: {cycle.safety:.3g}"


def found_spring(design: DesignFile) -> HelicalSpring:
    """The lightest spring that lasts, within the outer diameter of the page's spring."""
    spring, mechanism = design.helical_spring, design.mechanism()
    assert spring is not None
    least, largest = spring_forces(mechanism)
    stiffness = mechanism.spring.stiffness
    return find_springs(
        least, stiffness, (largest - least) / stiffness, grade="DM", outer_diameter=0.032, guided=True
    )[0]


def draw_all(folder: Path) -> None:
    """Write all pictures of the page to the folder."""
    design = page_design()
    pictures = {
        "design_contact.png": contact_figure(design),
        "design_roller.png": roller_figure(),
        "design_wear.png": wear_figure(design),
        "design_spring.png": spring_figure(design),
    }
    for name, picture in pictures.items():
        picture.savefig(folder / name, dpi=DPI, metadata={"Software": None})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=PAGE.parent)
    draw_all(parser.parse_known_args()[0].output)


if __name__ == "__main__":
    main()
