"""The groove laws of the FMU: all other modules take numbers, words and parameters from this table.

The classes that evaluate a law are those of dualcam.design.grooves."""

from typing import NamedTuple


class GrooveLaw(NamedTuple):
    """Number and word of `cam1.profile`, and the parameters after `cam1.` of this law, without the radius.

    `steepness`: the parameter that makes the whole groove steeper; empty for a table."""

    number: int
    word: str
    parameters: tuple[str, ...]
    steepness: str = ""


HELIX = GrooveLaw(1, "helix", ("lead_angle",), "lead_angle")
ELLIPSE = GrooveLaw(2, "ellipse", ("lead_angle", "ellipse_a", "ellipse_b", "ellipse_curvature"), "lead_angle")
TABLE = GrooveLaw(3, "table", ("table",))
CYCLOID = GrooveLaw(4, "cycloid", ("cycloid_rise", "cycloid_angle"), "cycloid_rise")

LAWS = {law.number: law for law in (HELIX, ELLIPSE, TABLE, CYCLOID)}
NUMBERS = {law.word: number for number, law in LAWS.items()}
PARAMETERS = tuple(dict.fromkeys(name for law in LAWS.values() for name in law.parameters))
ALLOWED = ", ".join(f'{law.number} or "{law.word}"' for law in LAWS.values())


def laws_with(parameter: str) -> list[GrooveLaw]:
    """The laws that use a parameter of a cam; all laws where it belongs to none."""
    return [law for law in LAWS.values() if parameter in law.parameters or parameter not in PARAMETERS]
