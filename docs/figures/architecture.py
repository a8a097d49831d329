"""Draws the pictures of docs/architecture.md: the rooms of fmu_src and of dualcam, and which one uses which.

Run by `./build.sh run figures`. The arrows come from the `#include` lines of the C files, and from the
sentences "May import ..." of the Python rooms. An arrow that follows from others is left out: where A uses B
and B uses C, no arrow leads from A to C. The same sources and the same version of matplotlib give the same
files."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch
from python_rooms import may_import

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "fmu_src"
OUTSIDE = {"tools"}  # the build, no part of an FMU

INK = "#222222"
ARROW = "#5a5a5a"
Place = tuple[float, float, float, float]  # left, bottom, width and height of a box

# Bottom up: where a room's box stands, its colour, and what the room holds.
ARITHMETIC, LAWS, MOTION, BOUNDARY = "#e9e9e9", "#fbe8cf", "#d6e4f5", "#dcefdc"
ROOMS: dict[str, tuple[Place, str, str]] = {
    "platform": ((7.0, 0.0, 2.8, 0.95), ARITHMETIC, "operating systems"),
    "elementary": ((4.35, 0.0, 2.3, 0.95), ARITHMETIC, "exp, log, sin, ..."),
    "numerics": ((0.2, 0.0, 3.8, 0.95), ARITHMETIC, "sums, jets, roots, tolerances"),
    "model": ((0.2, 1.35, 6.4, 0.95), LAWS, "parameters, inputs, modes, ledger"),
    "geometry": ((0.2, 2.7, 9.6, 0.95), LAWS, "groove laws, tables, and the transmission along theta"),
    "contact": ((0.2, 4.05, 9.6, 0.95), LAWS, "friction, flanks, stick band, balance of forces"),
    "closed_form": ((0.2, 5.4, 3.1, 1.3), MOTION, "slip in closed form,\nand its events"),
    "collocation": ((3.6, 5.4, 3.1, 1.3), MOTION, "slip by integration,\nand its events"),
    "inverse": ((7.0, 5.4, 2.8, 2.65), MOTION, "inverse dynamics:\nmotion in,\ntorque out"),
    "forward": ((0.2, 7.1, 6.5, 0.95), MOTION, "forward dynamics: torque in, motion out"),
    "outputs": ((0.2, 8.45, 6.5, 0.95), MOTION, "what is read at one instant"),
    "sensitivity": ((0.2, 9.8, 9.6, 0.95), MOTION, "derivatives of outputs and of a whole step"),
    "fmi": ((0.2, 11.15, 9.6, 0.95), BOUNDARY, "the calls of FMI 2.0 and FMI 3.0; no physics"),
    "web": ((0.2, 12.5, 9.6, 0.95), BOUNDARY, "messages for a page in a browser"),
}
PYTHON_ROOMS: dict[str, tuple[Place, str, str]] = {
    "common": ((0.1, 0, 9.8, 0.8), ARITHMETIC, "arrays, paths, units, tables of people, HTML"),
    "fmi": ((0.1, 1.2, 9.8, 0.8), ARITHMETIC, "handles of FMUs, FMI 2.0 and 3.0"),
    "control": ((0.1, 2.4, 1.4, 1), MOTION, "python-\ncontrol"),
    "fleet": ((1.7, 2.4, 1.9, 1), MOTION, "many instances,\nin C"),
    "coupling": ((3.8, 2.4, 1.5, 1), MOTION, "own plants"),
    "design": ((5.5, 2.4, 2.2, 1), LAWS, "statics, grooves,\nstrength, wear"),
    "scenario": ((7.9, 2.4, 2, 1), LAWS, "inputs over time"),
    "gradient": ((1.3, 3.8, 1.3, 1), MOTION, "JAX, PyTorch"),
    "systems.blocks": ((2.8, 3.8, 3.4, 1), MOTION, "motor, loads, motions,\ncontrollers"),
    "design_file": ((6.4, 3.8, 3.5, 1), LAWS, "TOML to a design and back,\nall findings at once"),
    "systems.machines": ((2, 5.2, 2.5, 1), MOTION, "elbow, knee, door,\nclamp"),
    "mujoco": ((4.7, 5.2, 1.9, 1), MOTION, "cam on joints\nof MuJoCo"),
    "simulation": ((6.8, 5.2, 1.6, 1), MOTION, "one run"),
    "checking": ((8.6, 5.2, 1.3, 2.4), LAWS, "verdict:\nrules and\nremedies"),
    "gym": ((2, 6.6, 2.5, 1), MOTION, "environments"),
    "plots": ((4.7, 6.6, 3.7, 1), BOUNDARY, "pictures by matplotlib"),
    "export": ((2, 8, 3.4, 1), BOUNDARY, "the FMU of a design"),
    "identification": ((5.6, 8, 2, 1), BOUNDARY, "parameters from\na recording"),
    "report": ((7.8, 8, 2.1, 1), BOUNDARY, "HTML about\na design"),
    "ssp": ((2, 9.4, 1.6, 1), BOUNDARY, "packages of\nFMUs"),
    "view": ((3.8, 9.4, 1.6, 1), BOUNDARY, "the page that\nmoves"),
    "study": ((7.8, 9.4, 2.1, 1), BOUNDARY, "plans, runs, results,\noptimisation"),
    "cli": ((0.1, 10.8, 9.8, 0.8), BOUNDARY, "commands: may import every room"),
}
Rooms = dict[str, tuple[Place, str, str]]


def rooms_of_tree() -> set[str]:
    """The folders of fmu_src that hold C code of the FMUs."""
    return {path.name for path in SOURCES.iterdir() if path.is_dir() and any(path.glob("*.[ch]"))} - OUTSIDE


def includes() -> set[tuple[str, str]]:
    """Pairs of rooms: the first one includes a header of the second one."""
    found = set()
    for path in sorted(SOURCES.glob("*/*.[ch]")):
        for included in re.findall(r'^#include "(\w+)/', path.read_text(encoding="utf-8"), re.MULTILINE):
            found.add((path.parent.name, included))
    return {(user, used) for user, used in found if user != used and user not in OUTSIDE}


def imports() -> set[tuple[str, str]]:
    """Pairs of rooms of dualcam but for cli: the first one may import the second one."""
    allowed, drawn = may_import(ROOT), PYTHON_ROOMS.keys() - {"cli"}
    return {(room, other) for room, others in allowed.items() for other in others if {room, other} <= drawn}


def without_shortcuts(rooms: Rooms, arrows: set[tuple[str, str]]) -> set[tuple[str, str]]:
    """The arrows that do not follow from others. There is no circle among them."""
    reached = set(arrows)
    for middle in rooms:  # Warshall's algorithm
        before = {a for a, b in reached if b == middle}
        after = {b for a, b in reached if a == middle}
        reached |= {(a, b) for a in before for b in after}
    return {(a, b) for a, b in arrows if not any((a, c) in reached and (c, b) in reached for c in rooms)}


def draw_room(axes: Axes, name: str, room: tuple[Place, str, str], sizes: tuple[float, float]) -> None:
    (left, bottom, width, height), color, words = room
    style = "round,pad=0,rounding_size=0.1"
    axes.add_patch(FancyBboxPatch((left, bottom), width, height, boxstyle=style, fc=color, ec=INK, lw=1.0))
    middle, top = left + 0.5 * width, bottom + height
    axes.text(middle, top - 0.29, name, size=sizes[0], weight="bold", color=INK, ha="center", va="center")
    text_height = 0.5 * (top - 0.49 + bottom)
    axes.text(middle, text_height, words, size=sizes[1], color=INK, ha="center", va="center")


def ends_of_arrow(user: Place, used: Place) -> tuple[tuple[float, float], tuple[float, float]]:
    """Upright between boxes that stand above each other, else level with their lower edges."""
    left, right = max(user[0], used[0]), min(user[0] + user[2], used[0] + used[2])
    if left < right:
        x = 0.5 * (left + right)
        return (x, user[1]), (x, used[1] + used[3])
    to_the_left = used[0] < user[0]
    start = (user[0] if to_the_left else user[0] + user[2], user[1] + 0.2)
    end = (used[0] + used[2] if to_the_left else used[0], used[1] + 0.2)
    return start, end


def draw_arrow(axes: Axes, user: Place, used: Place) -> None:
    ends = ends_of_arrow(user, used)
    style = "-|>,head_length=6,head_width=3.5"
    axes.add_patch(FancyArrowPatch(*ends, arrowstyle=style, color=ARROW, lw=1.6, shrinkA=0, shrinkB=0))


def draw(rooms: Rooms, arrows: set[tuple[str, str]], sizes: tuple[float, float]) -> Figure:
    top = max(bottom + height for (_, bottom, _, height), _, _ in rooms.values())
    figure = Figure(figsize=(7.0, round(0.688 * (top + 0.3), 2)), facecolor="white")
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(0.0, 10.0)
    axes.set_ylim(-0.15, top + 0.15)
    axes.axis("off")
    for user, used in sorted(without_shortcuts(rooms, arrows)):
        draw_arrow(axes, rooms[user][0], rooms[used][0])
    for name, room in rooms.items():
        draw_room(axes, name, room, sizes)
    return figure


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=ROOT / "docs", help="directory of the picture (docs)")
    folder = parser.parse_args().output
    if set(ROOMS) != rooms_of_tree():
        raise SystemExit(f"the rooms of fmu_src are {sorted(rooms_of_tree())}: give each a box in ROOMS")
    pictures = {
        "architecture.svg": (ROOMS, includes(), (16.0, 13.0)),
        "architecture_python.svg": (PYTHON_ROOMS, imports(), (11.0, 8.5)),
    }
    settings = {**mpl.rcParamsDefault, "svg.hashsalt": "dualcam"}
    for name, what in pictures.items():
        with mpl.rc_context(settings):
            draw(*what).savefig(folder / name, metadata={"Date": None})
        print(f"Picture: {folder / name}")


if __name__ == "__main__":
    main()
