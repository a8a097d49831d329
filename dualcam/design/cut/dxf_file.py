"""The unwrapped groove as a DXF drawing in millimetres."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from dualcam.common.paths import whole_file
from dualcam.design.cut.groove_cut import Curve, GrooveCut
from dualcam.design.cut.labels import AXIS_LABEL, ZERO_LABEL, cut_label
from dualcam.design.cut.sampling import CHORD_ERROR, places, unwrapped
from dualcam.design.statics import Array
from dualcam.errors import DesignError

if TYPE_CHECKING:
    from ezdxf.document import Drawing

MM = 1e3  # per metre
LAYERS = {  # name: colour of AutoCAD's index
    "CENTRE": 1,
    "FLANK_UPPER": 5,
    "FLANK_LOWER": 3,
    "ENDS": 4,
    "STOPS": 6,
    "CYLINDER": 8,
    "MARK": 9,
    "AXIS": 2,
    "TEXT": 7,
}


def write_dxf(cut: GrooveCut, path: Path) -> None:
    """Write the drawing: the cam's surface seen from outside, x = radius times angle, y = z."""
    drawing = _drawing()
    for end in range(cut.mechanism.contacts):
        _draw_groove(drawing, cut, end)
    _draw_cylinder(drawing, cut)
    _draw_axis(drawing, cut)
    _write_text(drawing, cut)
    with whole_file(path) as unfinished:
        drawing.saveas(unfinished)


def require_ezdxf() -> Any:  # noqa: ANN401
    """The library; DesignError if the library is not installed."""
    try:
        import ezdxf
    except ImportError:
        raise DesignError('a .dxf file needs the library ezdxf: pip install "dualcam[dxf]"') from None
    return ezdxf


def _drawing() -> Drawing:
    ezdxf = require_ezdxf()
    drawing = ezdxf.new("R2010", setup=["linetypes"])
    drawing.units = ezdxf.units.MM
    for name, color in LAYERS.items():
        drawing.layers.add(name, color=color, linetype="CENTER" if name == "CENTRE" else "CONTINUOUS")
    return drawing


def _draw_groove(drawing: Drawing, cut: GrooveCut, end: int) -> None:
    psi = places(cut, unwrapped(cut))
    flanks = cut.flanks(psi)
    _line(drawing, "CENTRE", _flat(cut, Curve(psi, cut.centre(psi).z), end))
    _line(drawing, "FLANK_UPPER", _flat(cut, flanks.upper, end))
    _line(drawing, "FLANK_LOWER", _flat(cut, flanks.lower, end))
    points = 2 * math.ceil(math.pi / math.sqrt(8.0 * CHORD_ERROR / (2.0 * cut.pin_radius))) + 1
    for at_end in (False, True):
        _line(drawing, "ENDS", _flat(cut, cut.round_end(at_end, np.linspace(0.0, 1.0, points)), end))
    for x, y in _flat(cut, cut.stops(), end):
        _line(drawing, "STOPS", np.array([(x, y - MM * cut.pin_radius), (x, y + MM * cut.pin_radius)]))
        _line(drawing, "STOPS", np.array([(x - MM * cut.pin_radius, y), (x + MM * cut.pin_radius, y)]))


def _flat(cut: GrooveCut, curve: Curve, end: int) -> Array:
    """Points of the drawing [mm], shape (n, 2)."""
    return MM * np.stack([cut.radius * cut.angle(curve.psi, end), curve.z], axis=-1)


def _line(drawing: Drawing, layer: str, points: Array) -> None:
    drawing.modelspace().add_lwpolyline(points.tolist(), dxfattribs={"layer": layer})


def _draw_axis(drawing: Drawing, cut: GrooveCut) -> None:
    """An arrow along +z beside the left edge of the unwrapped surface, from z = 0, with its name."""
    height, size = _text_height(cut), 2.0 * MM * cut.pin_radius
    x = MM * _left_edge(cut) - max(2.0 * size, 4.0 * height)
    tip = max(MM * float(cut.centre(cut.end).z), 2.0 * size)
    head = [(x - 0.25 * size, tip - size), (x + 0.25 * size, tip - size)]
    _line(drawing, "AXIS", np.array([(x, 0.0), (x, tip), *head, (x, tip)]))
    text = drawing.modelspace().add_text("+z (up)", height=height, dxfattribs={"layer": "TEXT"})
    text.set_placement((x, tip + 0.6 * height), align=require_ezdxf().enums.TextEntityAlignment.CENTER)


def _left_edge(cut: GrooveCut) -> float:
    """x of the left edge of the unwrapped surface [m]."""
    middle = cut.radius * float(cut.angle(0.5 * (cut.begin + cut.end)))
    return middle - math.pi * cut.radius / cut.mechanism.contacts


def _text_height(cut: GrooveCut) -> float:
    """Height of a letter [mm]."""
    return MM * cut.radius / 12.0


def _draw_cylinder(drawing: Drawing, cut: GrooveCut) -> None:
    """Both edges of the unwrapped surface, a turn apart, with all grooves between them; and the mark."""
    turn = 2.0 * math.pi * cut.radius
    left = _left_edge(cut)
    low, high = (float(cut.centre(psi).z) for psi in (cut.begin, cut.end))
    margin = 2.0 * cut.pin_radius
    for layer, x in (("CYLINDER", left), ("CYLINDER", left + turn), ("MARK", 0.0)):
        _line(drawing, layer, MM * np.array([(x, low - margin), (x, high + margin)]))


def _write_text(drawing: Drawing, cut: GrooveCut) -> None:
    height = _text_height(cut)
    y = MM * float(cut.centre(cut.begin).z) - 3.0 * MM * cut.pin_radius
    lines = [
        cut_label(cut),
        f"unwrapped at the radius {MM * cut.radius:.6g} mm, seen from outside, units mm",
        ZERO_LABEL,
        AXIS_LABEL,
        f"lines are within {1e6 * CHORD_ERROR:g} um of the curves",
    ]
    for k, line in enumerate(lines):
        text = drawing.modelspace().add_text(line, height=height, dxfattribs={"layer": "TEXT"})
        text.set_placement((0.0, y - 1.6 * height * (k + 1)))
