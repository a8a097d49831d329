"""Draws the three pictures of docs/mechanism.md: the mechanism, the forces at the pin, the stick band.

Run by `./build.sh run figures`. The same sources and the same version of matplotlib give the same files. The
pictures are drawn to scale: dualcam.design computes their geometry and their torques. The symbols are those
of the page."""

from __future__ import annotations

import argparse
import math
import warnings
from pathlib import Path
from typing import Literal

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, Ellipse, FancyArrowPatch, Polygon, Rectangle
from numpy.typing import NDArray

from dualcam.design import Helix, Mechanism, Spring
from dualcam.errors import UnitWarning

DOCS = Path(__file__).resolve().parent.parent

INK = "#222222"
CAM1 = "#8a5a1c"  # brown: the fixed cam
CAM2 = "#1f5fa8"  # blue: the rotating cam
PIN = "#b3202c"  # red: pin and carriage
FORCE = "#167a3a"  # green: load of the spring and from outside; sum of forces
RUB = "#c76a00"  # orange: friction
METAL = "#d9d9d9"
Point = tuple[float, float]
Array = NDArray[np.float64]

# The mechanism of the first two pictures, in mm and rad. The default mechanism has r1 = r2 = 20 mm: both cams
# would be drawn on top of each other.
RADIUS = (20.0, 28.0)
LEAD = (math.radians(46.0), math.radians(38.0))
FRICTION = 0.32  # of the second picture: a friction angle that can be seen
THETA = math.radians(80.0)
SPRING_LOAD = Spring(50.0, 50e3)  # N, N/m: the default spring


def mechanism_drawn() -> Mechanism:
    """The mechanism of the first picture; lengths in mm."""
    with warnings.catch_warnings(action="ignore", category=UnitWarning):  # millimetres are meant
        one, two = (Helix(r, lead) for r, lead in zip(RADIUS, LEAD, strict=True))
    return Mechanism((one, two), (FRICTION, FRICTION), SPRING_LOAD, THETA)


def default_mechanism() -> Mechanism:
    """The mechanism that the FMU's default parameters describe; lengths in m."""
    groove = Helix(0.02, math.pi / 4)
    return Mechanism((groove, groove), (0.14, 0.14), SPRING_LOAD, 1.3963)


# ---- parts of all pictures ----


def new_figure(width: float, height: float) -> Figure:
    """Inches. At 7 inches a text of 14 points has 11 pixels where the picture is 400 pixels wide."""
    return Figure(figsize=(width, height), facecolor="white")


def arrow(axes: Axes, start: Point, end: Point, color: str, width: float = 2.4) -> None:
    style = "-|>,head_length=7,head_width=3.6"
    axes.add_patch(
        FancyArrowPatch(start, end, arrowstyle=style, color=color, lw=width, shrinkA=0, shrinkB=0, zorder=8)
    )


def curved_arrow(axes: Axes, points: Array, color: str, width: float = 2.4) -> None:
    """Along points of shape (n, 2); the head is at the last one."""
    axes.plot(*points[:-1].T, color=color, lw=width, solid_capstyle="butt", zorder=7)
    arrow(axes, tuple(points[-3]), tuple(points[-1]), color, width)


def text(
    axes: Axes,
    place: Point,
    words: str,
    color: str = INK,
    size: float = 15.0,
    *,
    ha: Literal["left", "center", "right"] = "center",
    weight: str = "normal",
    rotation: float = 0.0,
) -> None:
    font = {"color": color, "size": size, "weight": weight}
    axes.text(*place, words, fontdict=font, ha=ha, va="center", rotation=rotation, zorder=10)


def pointer(
    axes: Axes, words_at: Point, target: Point, words: str, color: str, ha: Literal["left", "right"]
) -> None:
    """Words with a thin line to what they name; the line ends in a dot there."""
    axes.plot(*zip(words_at, target, strict=True), color=color, lw=1.0, zorder=9)
    axes.plot(*target, "o", color=color, ms=4.0, zorder=9)
    text(axes, words_at, words, color, ha=ha)


def bare(axes: Axes, x: Point, y: Point) -> None:
    axes.set_xlim(*x)
    axes.set_ylim(*y)
    axes.set_aspect("equal")
    axes.axis("off")


# ---- the mechanism ----

TILT = math.radians(20.0)  # of the view, from the horizontal
FRONT = math.radians(46.0)  # the angle from cam 1's mark that faces the reader
BOTTOM, TOP1, TOP2 = -14.0, 46.0, 34.0  # mm: heights of the cams, z of the pin counted from 0
ROD = 6.0  # mm, radius of the carriage's rod
PLATE, COVER = 62.0, 98.0  # mm: heights of the carriage's plate and of the fixed cover, the plate's at z = 0
PIN_RADIUS = 2.6


def seen(radius: float, angle: float, height: float) -> Point:
    """Parallel projection of a point in cylindrical coordinates. In front the angle grows to the right."""
    turned = angle - FRONT
    return radius * math.sin(turned), height * math.cos(TILT) - radius * math.cos(turned) * math.sin(TILT)


def ring(radius: float, height: float, first: float, last: float) -> Array:
    """Points of a circle about the axis from one angle to another, shape (n, 2)."""
    return np.array([seen(radius, angle, height) for angle in np.linspace(first, last, 60)])


def cylinder(
    axes: Axes, radius: float, low: float, high: float, color: str, alpha: float, order: int
) -> None:
    """Front wall and upper rim."""
    left, right = FRONT - math.pi / 2, FRONT + math.pi / 2
    wall = np.concatenate([ring(radius, low, left, right), ring(radius, high, left, right)[::-1]])
    axes.add_patch(Polygon(wall, fc=color, ec="none", alpha=alpha, zorder=order))
    axes.plot(*np.concatenate([wall, wall[:1]]).T, color=color, lw=1.4, zorder=order)
    center = seen(0.0, 0.0, high)
    size = (2.0 * radius, 2.0 * radius * math.sin(TILT))
    axes.add_patch(Ellipse(center, *size, fc="white", ec=color, lw=1.4, alpha=0.5, zorder=order))
    axes.add_patch(Ellipse(center, *size, fc="none", ec=color, lw=1.4, zorder=order))


def draw_groove(axes: Axes, radius: float, angle: Array, height: Array, color: str) -> None:
    """A band on a cylinder, as wide as the pin."""
    along = np.stack([radius * np.gradient(angle), np.gradient(height)])
    along /= np.hypot(*along)
    edges = []
    for side in (1.0, -1.0):
        shifted = (angle - side * PIN_RADIUS * along[1] / radius, height + side * PIN_RADIUS * along[0])
        edges.append(np.array([seen(radius, a, h) for a, h in zip(*shifted, strict=True)]))
    band = np.concatenate([edges[0], edges[1][::-1]])
    axes.add_patch(Polygon(band, fc=color, ec=color, alpha=0.45, lw=1.2, zorder=5))


def draw_spring(axes: Axes, low: float, high: float) -> None:
    coils, radius = 6, 11.0
    turn = np.linspace(0.0, 2.0 * math.pi * coils, 400)
    height = low + (high - low) * turn / turn[-1]
    axes.plot(radius * np.sin(turn), height - 2.0 * np.cos(turn), color="#555555", lw=2.2, zorder=3)


def draw_side(axes: Axes) -> None:
    """The view from the side and a little from above."""
    configuration = mechanism_drawn().configuration(THETA)
    gamma, z = float(configuration.psi[0]), float(configuration.z)
    up = math.cos(TILT)
    # base, cams, grooves
    axes.add_patch(Rectangle((-40, -36), 80, 7, fc=METAL, ec=INK, hatch="///", lw=1.0, zorder=1))
    cylinder(axes, RADIUS[0], BOTTOM - 10.0, TOP1, CAM1, 0.16, 2)
    cylinder(axes, RADIUS[1], BOTTOM, TOP2, CAM2, 0.12, 4)
    slope = [math.tan(lead) for lead in LEAD]
    span = np.linspace(-0.12, 1.95, 90)
    draw_groove(axes, RADIUS[0], gamma * span, RADIUS[0] * slope[0] * gamma * span, CAM1)
    phi = THETA - gamma
    draw_groove(axes, RADIUS[1], THETA - phi * span, RADIUS[1] * slope[1] * phi * span, CAM2)
    for angle, radius, top, color in ((0.0, RADIUS[0], TOP1, CAM1), (THETA, RADIUS[1], TOP2, CAM2)):
        axes.plot(*seen(radius, angle, top), "D", color=color, ms=7, mec="white", zorder=6)
    # carriage: hidden rod, rod, plate; pin
    pin = seen(RADIUS[1] + 3.0, gamma, z)
    plate = (PLATE + z) * up
    for x in (-ROD, ROD):
        axes.plot([x, x], [z * up - 6.0, TOP1 * up], color=PIN, lw=1.2, ls=(0, (4, 3)), zorder=5)
    axes.add_patch(
        Rectangle((-ROD, TOP1 * up), 2 * ROD, plate - TOP1 * up, fc="#f0c9cb", ec=PIN, lw=1.4, zorder=3)
    )
    axes.add_patch(Rectangle((-17, plate), 34, 4, fc="#f0c9cb", ec=PIN, lw=1.4, zorder=4))
    axes.add_patch(Circle(pin, PIN_RADIUS, fc=PIN, ec="white", lw=1.0, zorder=7))
    # spring and cover
    axes.add_patch(Rectangle((-24, COVER * up + 6), 48, 5, fc=METAL, ec=INK, hatch="///", lw=1.0, zorder=2))
    draw_spring(axes, plate + 5.5, COVER * up + 5)
    # axis
    axes.plot([0, 0], [-42, COVER * up + 18], color=INK, lw=0.9, ls=(0, (10, 3, 2, 3)), zorder=1)
    # z: from the plate's place at theta = 0
    start = PLATE * up
    axes.plot([17, 33], [plate, plate], color=PIN, lw=0.9)
    axes.plot([6, 33], [start, start], color=PIN, lw=0.9, ls=(0, (3, 2)))
    arrow(axes, (29, start), (29, plate), PIN)
    text(axes, (34, 0.5 * (start + plate)), "$z$", PIN, 18)
    # F
    arrow(axes, (-29, plate + 22), (-29, plate + 2), FORCE, 3.2)
    axes.plot([-33, -17], [plate + 2, plate + 2], color=FORCE, lw=0.9)
    text(axes, (-32, plate + 14), "$F_s + F_{ext}$", FORCE, 16, ha="right")
    # tau
    curved_arrow(axes, ring(RADIUS[1] + 4.0, BOTTOM + 4, FRONT - 1.25, FRONT + 1.2), CAM2, 3.0)
    text(axes, (36, BOTTOM * up - 4), r"$\tau,\ \theta$", CAM2, 18, ha="left")
    # names
    pointer(axes, (-38, 47), seen(RADIUS[0], FRONT - 0.7, TOP1 - 4), "cam 1\nfixed", CAM1, ha="right")
    pointer(axes, (-38, 24), seen(RADIUS[1], FRONT - 1.2, TOP2 - 9), "cam 2\nturns", CAM2, ha="right")
    pointer(axes, (-38, 3), seen(RADIUS[0], 0.08 * gamma, 0.08 * z), "groove 1", CAM1, ha="right")
    pointer(axes, (38, 3), seen(RADIUS[1], THETA - 0.08 * phi, 0.08 * z), "groove 2", CAM2, ha="left")
    pointer(axes, (38, 29), pin, "pin", PIN, ha="left")
    pointer(axes, (32, 47), (ROD - 2, 53), "carriage", PIN, ha="left")
    pointer(axes, (32, plate + 13), (10, plate + 13), "spring", "#555555", ha="left")
    bare(axes, (-70, 70), (-44, 112))


def draw_top(axes: Axes) -> None:
    """The view along the axis from above: marks of both cams and the pin, which coincide at theta = 0."""
    gamma = float(mechanism_drawn().configuration(THETA).psi[0])
    first = -math.pi / 2 - FRONT  # of cam 1's mark in the picture: the reader of the side view is below
    for radius, color in zip(RADIUS, (CAM1, CAM2), strict=True):
        axes.add_patch(Circle((0, 0), radius, fc="none", ec=color, lw=2.2, zorder=3))
    axes.add_patch(Circle((0, 0), ROD, fc="#f0c9cb", ec=PIN, lw=1.4, zorder=4))

    def at(radius: float, angle: float) -> Point:
        return radius * math.cos(first + angle), radius * math.sin(first + angle)

    def arc(radius: float, begin: float, end: float) -> Array:
        return np.array([at(radius, angle) for angle in np.linspace(begin, end, 80)])

    for angle, radius, color in ((0.0, RADIUS[0], CAM1), (THETA, RADIUS[1], CAM2)):
        line = np.array([(0.0, 0.0), at(54.0, angle)])
        axes.plot(*line.T, color=color, lw=1.2, ls=(0, (5, 3)), zorder=2)
        axes.plot(*at(radius, angle), "D", color=color, ms=8, mec="white", zorder=6)
    ends = np.array([at(-RADIUS[1] - 3.0, gamma), at(RADIUS[1] + 3.0, gamma), at(47.0, gamma)])
    axes.plot(*ends[:2].T, color=PIN, lw=6.0, solid_capstyle="round", zorder=5)
    axes.plot(*ends[1:].T, color=PIN, lw=1.2, ls=(0, (5, 3)), zorder=2)
    curved_arrow(axes, arc(36.0, 0.0, gamma), CAM1)
    curved_arrow(axes, arc(36.0, gamma, THETA), PIN)
    curved_arrow(axes, arc(51.0, 0.0, THETA), CAM2, 3.0)
    text(axes, at(41.5, 0.5 * gamma), r"$\gamma$", CAM1, 18)
    text(axes, at(41.5, 0.5 * (gamma + THETA)), r"$\varphi$", PIN, 18)
    text(axes, at(56.0, 0.5 * THETA), r"$\theta$", CAM2, 18)
    text(axes, at(57.0, -0.03), "mark\non cam 1", CAM1, 15, ha="right")
    text(axes, at(57.0, THETA + 0.03), "mark\non cam 2", CAM2, 15, ha="left")
    # radii
    for radius, angle, color, name in ((RADIUS[0], 2.25, CAM1, "$r_1$"), (RADIUS[1], -1.35, CAM2, "$r_2$")):
        arrow(axes, (0.0, 0.0), at(radius, angle), color, 1.6)
        text(axes, at(0.68 * RADIUS[0], angle + 0.42), name, color, 17)
    pointer(axes, (30, 27), at(-RADIUS[1], gamma), "pin", PIN, ha="left")
    bare(axes, (-70, 70), (-59, 33))


def draw_mechanism() -> Figure:
    figure = new_figure(7.0, 12.4)
    side = figure.add_axes((0.0, 0.375, 1.0, 0.625))
    top = figure.add_axes((0.0, 0.0, 1.0, 0.37))
    draw_side(side)
    draw_top(top)
    for axes, words in ((side, "seen from the side"), (top, "seen from above")):
        axes.text(
            0.02, 0.98, words, transform=axes.transAxes, fontsize=15, color=INK, va="top", style="italic"
        )
    return figure


# ---- forces at the pin ----


def draw_contact(axes: Axes, i: int, sigma: int) -> None:
    """The unwrapped groove i around the pin, and what the cam does to the pin."""
    side = 1.0 if i == 0 else -1.0  # the groove of cam 2 rises to the left
    color = (CAM1, CAM2)[i]
    lead = LEAD[i]
    along = np.array([side * math.cos(lead), math.sin(lead)])
    normal = np.array([-side * math.sin(lead), math.cos(lead)])
    radius, length = 1.0, 4.6
    # groove: two flanks
    for shift, width in ((-radius, 3.4), (radius, 1.4)):
        flank = np.array([shift * normal - length * along, shift * normal + length * along])
        axes.plot(*flank.T, color=color, lw=width, zorder=2)
    band = [shift * normal + s * length * along for shift, s in ((-1, -1), (-1, 1), (1, 1), (1, -1))]
    axes.add_patch(Polygon(band, fc=color, alpha=0.12, ec="none", zorder=1))
    axes.add_patch(Circle((0, 0), radius, fc="#f0c9cb", ec=PIN, lw=1.6, zorder=3))
    # direction of motion
    arrow(axes, tuple(sigma * 1.5 * along), tuple(sigma * 3.9 * along), PIN, 2.0)
    middle = sigma * 2.8 * along + 0.45 * normal
    text(axes, tuple(middle), "motion", PIN, 13, rotation=side * math.degrees(lead))
    # forces, from the contact point
    contact = -radius * normal
    size = 4.6
    push, rub = size * normal, -sigma * FRICTION * size * along
    total = push + rub
    arrow(axes, tuple(contact), tuple(contact + push), INK)
    arrow(axes, tuple(contact), tuple(contact + rub), RUB)
    arrow(axes, tuple(contact), tuple(contact + total), FORCE, 3.0)
    axes.plot(*contact, "o", color=INK, ms=5, zorder=9)
    number = i + 1
    away = -rub / np.hypot(*rub)  # from the sum of both forces
    text(axes, tuple(contact + 0.92 * push + 0.7 * away), f"$R_{number}$", INK, 17)
    text(axes, tuple(contact + 0.95 * total - 0.75 * away), "sum", FORCE, 14)
    text(axes, tuple(contact + 0.35 * rub - 1.0 * normal), rf"$\mu_{number} R_{number}$", RUB, 17)
    # friction angle, between the normal and the sum
    direction = [math.degrees(math.atan2(v[1], v[0])) for v in (push, total)]
    low, high = min(direction), max(direction)
    axes.add_patch(Arc(tuple(contact), 9.2, 9.2, theta1=low, theta2=high, color=INK, lw=1.5, zorder=7))
    half = math.radians(0.5 * (low + high))
    spot = contact + 5.25 * np.array([math.cos(half), math.sin(half)])
    text(axes, tuple(spot), rf"$\phi_{number}$", INK, 17)
    # lead angle, at the lower end of the supporting flank
    corner = -radius * normal - length * along
    arrow(axes, tuple(corner), (corner[0] + side * 4.3, corner[1]), INK, 1.0)
    ends = (0.0, math.degrees(lead)) if side > 0 else (180.0 - math.degrees(lead), 180.0)
    axes.add_patch(Arc(tuple(corner), 3.8, 3.8, theta1=ends[0], theta2=ends[1], color=INK, lw=1.5))
    spot = corner + 2.6 * np.array([side * math.cos(0.45 * lead), math.sin(0.45 * lead)])
    text(axes, tuple(spot), rf"$\lambda_{number}$", INK, 17)
    length_along = (r"$r_1 \gamma$", r"$r_2 \varphi$")[i]
    text(axes, (corner[0] + side * 5.0, corner[1]), length_along, INK, 15)
    bare(axes, (-5.6, 5.6), (-5.3, 5.3))


def draw_forces() -> Figure:
    figure = new_figure(7.0, 7.2)
    for column, (sigma, name) in enumerate(((1, "loading"), (-1, "releasing"))):
        figure.text(0.29 + 0.49 * column, 0.975, name, fontsize=17, ha="center", va="top", weight="bold")
        for i in (0, 1):
            axes = figure.add_axes((0.055 + 0.49 * column, 0.475 - 0.46 * i, 0.47, 0.46))
            draw_contact(axes, i, sigma)
    for i, words in enumerate(("groove of cam 1", "groove of cam 2")):
        color = (CAM1, CAM2)[i]
        figure.text(
            0.03, 0.70 - 0.46 * i, words, fontsize=16, color=color, rotation=90, ha="center", va="center"
        )
    return figure


# ---- the stick band ----


def draw_band() -> Figure:
    figure = new_figure(7.0, 5.4)
    axes = figure.add_axes((0.11, 0.13, 0.86, 0.84))
    mechanism = default_mechanism()
    theta = mechanism.angles(201)
    release, load = mechanism.band(theta)
    axes.fill_between(theta, release, load, color="#d6e4f5", lw=0)
    axes.plot(theta, load, color=PIN, lw=2.0)
    axes.plot(theta, release, color=CAM2, lw=2.0)
    low, high = 0.35, 1.05
    ends = {angle: [float(edge) for edge in mechanism.band(angle)] for angle in (low, high)}
    corners = [(low, ends[low][1]), (high, ends[high][1]), (high, ends[high][0]), (low, ends[low][0])]
    for start, end in zip(corners, [*corners[1:], corners[0]], strict=True):
        middle = (0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1]))
        axes.plot(*zip(start, end, strict=True), color=INK, lw=3.0, zorder=6, solid_capstyle="round")
        further = (middle[0] + 0.04 * (end[0] - start[0]), middle[1] + 0.04 * (end[1] - start[1]))
        style = "-|>,head_length=14,head_width=8"
        axes.add_patch(FancyArrowPatch(middle, further, arrowstyle=style, color=INK, lw=0, zorder=7))
    for number, corner in enumerate(corners, 1):
        axes.plot(*corner, "o", color=INK, ms=7, zorder=8)
        above = 0.45 if number in (1, 2) else -0.5
        text(axes, (corner[0], corner[1] + above), str(number), INK, 15, weight="bold")
    text(axes, (0.57, 6.15), "loading: the torque\nis on the upper edge", PIN, 14, ha="right")
    text(axes, (0.86, 2.3), "releasing: the torque\nis on the lower edge", CAM2, 14, ha="left")
    text(axes, (1.08, 6.2), "stick: cam 2\nstands still", "#2c4a6e", 14, ha="left")
    text(axes, (1.3, 10.0), r"$T_{load}$", PIN, 17, ha="right")
    text(axes, (1.385, 4.5), r"$T_{release}$", CAM2, 17, ha="right")
    axes.set_xlabel(r"angle of cam 2, $\theta$ [rad]", fontsize=15)
    axes.set_ylabel(r"torque, $\tau$ [N.m]", fontsize=15)
    axes.tick_params(labelsize=14)
    axes.set_xlim(0.0, 1.3963)
    axes.set_ylim(0.0, 10.6)
    for name in ("top", "right"):
        axes.spines[name].set_visible(False)
    return figure


PICTURES = {"mechanism": draw_mechanism, "mechanism_forces": draw_forces, "mechanism_band": draw_band}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--output", type=Path, default=DOCS, help="directory of the pictures (docs)")
    options = parser.parse_args()
    # Identifiers inside an SVG file come from the salt instead of a random number.
    settings = {**mpl.rcParamsDefault, "svg.hashsalt": "dualcam", "mathtext.fontset": "dejavuserif"}
    with mpl.rc_context(settings):
        for name, draw in PICTURES.items():
            path = options.output / f"{name}.svg"
            draw().savefig(path, metadata={"Date": None})
            print(f"Picture: {path}")


if __name__ == "__main__":
    main()
