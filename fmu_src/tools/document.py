"""The page documentation/index.html of an FMU: a template, two figures and the table of variables.

The figures are SVG, drawn from the start values in modelDescription.xml and from the reference result. Their
numbers are rounded, so that every machine writes the same bytes.
"""

from __future__ import annotations

import csv
import math
import xml.etree.ElementTree as ET
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from string import Template

TEMPLATE = Path(__file__).resolve().parent / "document.html"

BLUE, ORANGE, GREY, INK = "#0969da", "#bc4c00", "#8c959f", "#1b1f24"
Points = Sequence[tuple[float, float]]

# Texts that differ between the two FMUs.
LOOP_CAPTION = {
    "DualCamForward": """\
The reference result: torque goes in, angle comes out. Between the dashed edges of the stick band friction
holds the cam; outside, inertia makes it swing. The dashed edges are those without F<sub>ext</sub>. On the
way back a force F<sub>ext</sub> of 50 N raises both edges.""",
    "DualCamInverse": """\
The reference result: a swing to 1.2 rad and back within 1 s goes in, torque comes out. Dashed: the edges
of the stick band without F<sub>ext</sub>; inertia and an F<sub>ext</sub> that rises to 50 N are what
lies between them and the curve.""",
}
REGIME = {
    "DualCamForward": """\
<p>Without inertia (<i>J</i> = <i>m</i> = <i>I</i> = 0) the motion is viscous where there is damping,
else the play operator of <i>&tau;</i>: <i>&theta;</i> moves just far enough that <i>&tau;</i> is on the
edge of the stick band. Stick or slip is decided by torque, never from a small velocity. End stops carry
only torque that presses into them and have a coefficient of restitution.</p>""",
    "DualCamInverse": """\
<p>This FMU reads it the other way round: <i>&tau;</i> from <i>&theta;</i>, <i>&omega;</i> and
<i>&alpha;</i>. At <i>&omega;</i> = 0 the direction of the last motion is kept (loading, before any).
With <code>shaft.stiffness</code> <i>K</i> &gt; 0 the torque is <i>&tau;</i> = <i>K</i> (<i>&theta;</i>
&minus; <i>&theta;</i><sub>cam</sub>); <i>&theta;</i><sub>cam</sub> moves only where <i>&tau;</i> would
leave the stick band, and neither inertia nor damping acts.</p>""",
}
USE = {
    "DualCamForward": """\
<p>Connect a torque to <code>tau</code>, read <code>theta</code> and <code>omega</code>. The outputs
depend on the state alone: a loop closed over the FMU is no algebraic loop. A step lands on exactly its
end, whatever happens inside; how an interval is cut into steps does not change the answer beyond the
tolerance. $polynomials</p>
<p><b>Model exchange.</b> The states are <i>&theta;</i> and <i>&omega;</i>; it needs an inertia. The mode
changes at events only: velocity zero, an edge of the stick band, a stop, a contact on another flank. The
accounts <code>energy.*</code> (but for spring and kinetic) and <code>peak.*</code> are integrals over steps
and stay 0.</p>
<p><b>Ramps in FMPy.</b> FMPy 0.3.32 does not apply an input inside the right-hand side of its CVode. So a
ramp of the torque makes the steps of CVode tiny, and may end in the error "mxstep steps taken before
reaching tout". A torque in steps of 1 ms does not: write each step as two rows, at its beginning and at
its end. Or use co-simulation.</p>""",
    "DualCamInverse": """\
<p>Set <code>theta</code>, <code>omega</code>, <code>alpha</code> and <code>F_ext</code> as they are at
the end of the next step, make the step, read <code>tau</code>. Between communication points the motion
is the cubic through angles and speeds. $polynomials</p>
<p><b>Model exchange.</b> There are no states; the torque follows the inputs, and the direction of motion
changes at an event, velocity zero.</p>""",
}
POLYNOMIALS = {
    "DualCamForward": {
        2: """\
Inputs may be polynomials (fmi2SetRealInputDerivatives, orders 1 to 3).""",
        3: """\
FMI 3.0 has no derivatives of inputs. Instead, for inputs among requiredIntermediateVariables, the callback
intermediateUpdate is asked for values at the thirds and the end of the step before that begins: the inputs
are the cubics through them. Then it is called at each mode change and at the end, when variables can be
read; a master that takes early returns may end the step there, or later at its earlyReturnTime. With event
mode and early return the step ends at the first change of <code>mode</code> after its start, with
eventHandlingNeeded; a change that an input brings about at its very start is none.""",
    },
    "DualCamInverse": {
        2: """\
Or give derivatives of <code>theta</code> (fmi2SetRealInputDerivatives, orders 1 to 3): then it is that
polynomial.""",
        3: """\
A step is never cut short, since its motion is imposed to its end: eventHandlingNeeded tells a master with
event mode that <code>mode</code> is another one there, and intermediateUpdate is called there.""",
    },
}
SIGNS = ("Integer", "Int32")
NUMBERS = ("Real", "Integer", "Float64", "Int32")
GROUPS = {
    "independent": "Independent variable",
    "input": "Inputs",
    "output": "Outputs",
    "parameter": "Parameters",
    "local": "To be read at any time",
}


class Chart:
    """An SVG with two axes. Data coordinates in, pixels out."""

    WIDTH, HEIGHT = 420, 330
    LEFT, RIGHT, TOP, BOTTOM = 58, 14, 14, 48

    def __init__(self, x: tuple[float, float], y: tuple[float, float], title: str) -> None:
        self.x, self.y = x, y
        self.parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {self.WIDTH} {self.HEIGHT}" role="img" '
            f'font-family="system-ui, sans-serif" font-size="14" fill="{INK}">',
            f"<title>{escape(title)}</title>",
        ]

    def place(self, x: float, y: float) -> tuple[float, float]:
        wide, high = self.WIDTH - self.LEFT - self.RIGHT, self.HEIGHT - self.TOP - self.BOTTOM
        across = (x - self.x[0]) / (self.x[1] - self.x[0])
        up = (y - self.y[0]) / (self.y[1] - self.y[0])
        return round(self.LEFT + wide * across, 1), round(self.TOP + high * (1 - up), 1)

    def axes(self, x_step: float, y_step: float, x_name: str, y_name: str) -> None:
        (left, bottom), (right, top) = self.place(self.x[0], self.y[0]), self.place(self.x[1], self.y[1])
        for k in range(math.ceil(self.x[0] / x_step), math.floor(self.x[1] / x_step) + 1):
            at, _ = self.place(k * x_step, 0)
            self.parts.append(f'<path d="M{at} {bottom}V{top}" stroke="#e6e9ed"/>')
            self.text(at, bottom + 17, f"{k * x_step:g}", "middle")
        for k in range(math.ceil(self.y[0] / y_step), math.floor(self.y[1] / y_step) + 1):
            _, at = self.place(0, k * y_step)
            self.parts.append(f'<path d="M{left} {at}H{right}" stroke="#e6e9ed"/>')
            self.text(left - 7, at + 4.5, f"{k * y_step:g}", "end")
        self.parts.append(f'<path d="M{left} {top}V{bottom}H{right}" fill="none" stroke="{GREY}"/>')
        self.text((left + right) / 2, self.HEIGHT - 8, x_name, "middle")
        middle = round((top + bottom) / 2, 1)
        turned = f'transform="rotate(-90 16 {middle})"'
        self.parts.append(f'<text x="16" y="{middle}" text-anchor="middle" {turned}>{y_name}</text>')

    def text(self, x: float, y: float, text: str, anchor: str = "start", colour: str = INK) -> None:
        self.parts.append(f'<text x="{x:g}" y="{y:g}" text-anchor="{anchor}" fill="{colour}">{text}</text>')

    def label(self, x: float, y: float, text: str, colour: str = INK, anchor: str = "start") -> None:
        self.text(*self.place(x, y), text, anchor, colour)

    def line(self, points: Points, colour: str, width: float = 1.6, more: str = "") -> None:
        path = "L".join("{:g} {:g}".format(*self.place(*point)) for point in points)
        self.parts.append(
            f'<path d="M{path}" fill="none" stroke="{colour}" stroke-width="{width:g}" {more}/>'
        )

    def arrow(self, tail: tuple[float, float], tip: tuple[float, float], colour: str) -> None:
        """A line with a head of 9 pixels."""
        (x0, y0), (x1, y1) = self.place(*tail), self.place(*tip)
        length = math.hypot(x1 - x0, y1 - y0)
        ux, uy = (x1 - x0) / length, (y1 - y0) / length
        sides = [(x1 - 9 * ux + side * 4 * uy, y1 - 9 * uy - side * 4 * ux) for side in (1, -1)]
        head = " ".join(f"{x:.1f},{y:.1f}" for x, y in [(x1, y1), *sides])
        stop = f"{x1 - 7 * ux:.1f} {y1 - 7 * uy:.1f}"
        self.parts.append(f'<path d="M{x0} {y0}L{stop}" stroke="{colour}" stroke-width="2"/>')
        self.parts.append(f'<polygon points="{head}" fill="{colour}"/>')

    def circle(self, x: float, y: float, radius: float, fill: str) -> None:
        cx, cy = self.place(x, y)
        self.parts.append(
            f'<circle cx="{cx}" cy="{cy}" r="{radius:g}" fill="{fill}" stroke="{INK}" stroke-width="1.4"/>'
        )

    def svg(self) -> str:
        return "\n".join([*self.parts, "</svg>"])


@dataclass(frozen=True)
class Row:
    """A variable of modelDescription.xml, in FMI 2.0 and 3.0 alike."""

    type: str
    attributes: dict[str, str]


def variables(root: ET.Element) -> list[Row]:
    listed = list(root.iterfind("ModelVariables/*"))
    if root.attrib["fmiVersion"] == "2.0":
        return [Row(v[0].tag, v.attrib | v[0].attrib) for v in listed]
    return [Row(v.tag, v.attrib) for v in listed]


def start_values(root: ET.Element) -> dict[str, float]:
    """Name -> start value, of the parameters that are numbers."""
    return {
        v.attributes["name"]: float(v.attributes["start"])
        for v in variables(root)
        if v.attributes["causality"] == "parameter" and v.type in NUMBERS
    }


def slopes(p: dict[str, float]) -> tuple[float, float]:
    """The slopes a1, a2 in m/rad of two helices: the start values describe helices."""
    first, second = (p[f"cam{i}.radius"] * math.tan(p[f"cam{i}.lead_angle"]) for i in (1, 2))
    return first, second


def edge_of_stick_band(p: dict[str, float], theta: float, sigma: int) -> float:
    """T_load (sigma = 1) or T_release (sigma = -1) in N.m, of two helices without F_ext."""
    kappa = 0.0
    for i, a in enumerate(slopes(p), start=1):
        r, friction = p[f"cam{i}.radius"], sigma * p[f"cam{i}.friction"]
        kappa += (1 - friction * a / r) / (r * (a / r + friction))
    a1, a2 = slopes(p)
    z = a1 * a2 / (a1 + a2) * theta
    return (p["spring.preload"] + p["spring.stiffness"] * z) / kappa


def sketch(p: dict[str, float]) -> str:
    """SVG of both grooves over the angle about the axis, at two angles of cam 2."""
    a1, a2 = slopes(p)
    before, after = 0.7, p["stop.upper"]
    end, top = 1.12 * after, a1 * after
    chart = Chart(
        (0, math.degrees(end)), (0, 1e3 * top), "The grooves of both cams, unrolled, and the pin in them"
    )
    chart.axes(20, 5, "angle about the axis [deg]", "height z [mm]")
    round_ends = 'stroke-linecap="butt" stroke-opacity="{}"'

    def groove(points: Points, colour: str, opacity: float) -> None:
        shown = [(math.degrees(angle), 1e3 * z) for angle, z in points]
        chart.line(shown, colour, 16, round_ends.format(0.28 * opacity))
        chart.line(shown, colour, 1.4, round_ends.format(opacity))

    def pin(theta: float) -> tuple[float, float]:
        gamma = a2 / (a1 + a2) * theta
        return math.degrees(gamma), 1e3 * a1 * gamma

    groove([(0, 0), (top / a1 * 0.8, top * 0.8)], BLUE, 1)
    groove([(before, 0), (0, a2 * before)], ORANGE, 0.45)
    groove([(after, 0), (after - 0.86 * top / a2, 0.86 * top)], ORANGE, 1)
    (x0, z0), (x1, z1) = pin(before), pin(after)
    chart.circle(x0, z0, 8, "#d0d7de")
    chart.circle(x1, z1, 8, "#ffffff")
    chart.arrow((x1, z1 - 1.0), (x1, z1 - 6.2), INK)
    chart.label(x1 + 1.5, z1 - 6.0, "<tspan font-style='italic'>F</tspan>")
    low = 0.045e3 * top
    chart.arrow((math.degrees(before) + 5, low), (math.degrees(after) - 7, low), ORANGE)
    chart.label(math.degrees(before) + 4, low + 0.9, "turns by &theta;", ORANGE)
    chart.label(math.degrees(top / a1 * 0.8) + 1, 0.83e3 * top, "groove of cam 1 (fixed)", BLUE, "middle")
    chart.label(3, 0.93e3 * top, "groove of cam 2, before and after", ORANGE)
    chart.label(x1 + 5, z1 - 0.2, "pin, at angle &gamma;")
    return chart.svg()


def read(path: Path) -> list[dict[str, float]]:
    with path.open(newline="") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def between(rows: list[dict[str, float]], time: float, name: str) -> float:
    """The column `name` at `time`, on the straight line between two rows."""
    k = min(max(bisect_right([row["time"] for row in rows], time), 1), len(rows) - 1)
    a, b = rows[k - 1], rows[k]
    return a[name] + (b[name] - a[name]) * (time - a["time"]) / (b["time"] - a["time"])


def loop(p: dict[str, float], given: list[dict[str, float]], result: list[dict[str, float]]) -> str:
    """SVG of torque over angle, from the reference result."""
    path = []
    for row in result:
        both = {n: row[n] if n in row else between(given, row["time"], n) for n in ("theta", "tau")}
        path.append((math.degrees(both["theta"]), both["tau"]))
    end = math.degrees(p["stop.upper"])
    chart = Chart(
        (0, end), (0, 10), "Torque over angle, loading and releasing, with the edges of the stick band"
    )
    chart.axes(20, 2, "angle of cam 2, &theta; [deg]", "torque &tau; [N&middot;m]")
    for sigma, name in ((1, "load"), (-1, "release")):
        edge = [(at, edge_of_stick_band(p, math.radians(at), sigma)) for at in (0.0, end)]
        chart.line(edge, GREY, 1.4, 'stroke-dasharray="6 4"')
        at, offset = (0.93 * end, 0.3) if sigma > 0 else (0.99 * end, -1.5)
        level = edge_of_stick_band(p, math.radians(at), sigma)
        subscript = f'<tspan font-style="italic">T</tspan><tspan dy="4" font-size="10">{name}</tspan>'
        chart.label(at, level + offset, subscript, "#57606a", "end")
    chart.line(path, BLUE, 2, 'stroke-linejoin="round"')
    return chart.svg()


def value_and_display(text: str, unit: ET.Element | None) -> str:
    """A start value; in brackets the value in the display unit, which a tool shows."""
    shown = None if unit is None else unit.find("DisplayUnit")
    number = f"{float(text):.6g}"
    if shown is None or float(text) == 0:
        return number
    return f"{number} [{float(text) * float(shown.attrib['factor']):.6g} {shown.attrib['name']}]"


def row(variable: Row, units: dict[str, ET.Element]) -> str:
    given = variable.attributes
    unit = given.get("unit")
    start = given.get("start", "")
    if start and variable.type in NUMBERS:
        start = value_and_display(start, units.get(unit or ""))
    low, high = given.get("min"), given.get("max")
    span = " to ".join(f"{float(end):.6g}" for end in (low, high) if end is not None)
    if variable.type in SIGNS and (low, high) == ("-1", "1"):
        span = "-1 or 1"  # the XML can give the range only
    elif low is None or high is None:
        span = ("from " if low else "up to ") + span if span else ""
    text = escape(given["description"])
    if given["variability"] == "tunable":
        text += "; tunable"
    unit_text = escape(unit) if unit else variable.type
    return (
        f"<tr><td><code>{escape(given['name'])}</code></td><td>{unit_text}</td>"
        f'<td class="number">{escape(start)}</td><td class="number">{span}</td><td>{text}</td></tr>'
    )


def table(root: ET.Element) -> str:
    units = {unit.attrib["name"]: unit for unit in root.iter("Unit")}
    lines = []
    for causality, title in GROUPS.items():
        rows = [row(v, units) for v in variables(root) if v.attributes["causality"] == causality]
        if rows:
            lines += [f'<tr class="group"><td colspan="5">{title}</td></tr>', *rows]
    return "\n".join(lines)


def page(description: str, reference: Path) -> str:
    """The page of the FMU with the modelDescription.xml `description`; the folder `reference` holds its
    reference result."""
    root = ET.fromstring(description)
    name, fmi = root.attrib["modelName"], int(root.attrib["fmiVersion"][0])
    p = start_values(root)
    return Template(TEMPLATE.read_text(encoding="utf-8")).substitute(
        name=name,
        version=root.attrib["version"],
        description=escape(root.attrib["description"]),
        sketch=sketch(p),
        loop=loop(p, read(reference / f"{name}_in.csv"), read(reference / f"{name}_ref.csv")),
        loop_caption=LOOP_CAPTION[name],
        regime=REGIME[name],
        use=Template(USE[name]).substitute(polynomials=POLYNOMIALS[name][fmi]),
        fmi=fmi,
        variables=table(root),
    )
