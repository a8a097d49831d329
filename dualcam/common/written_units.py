"""Values with a written unit, such as "45 deg", converted to the unit of a variable.

The library pint knows the units. Loading pint takes half a second, so pint is loaded at the first such value.
Pint counts angles as plain numbers; here an angle is a dimension of its own, so that "20 deg" is no length
and no friction coefficient.
"""

from __future__ import annotations

import math
import re
from decimal import Decimal
from functools import cache
from typing import TYPE_CHECKING, Any

from dualcam.errors import DesignError

if TYPE_CHECKING:
    from pint import Unit, UnitRegistry

LONGEST = 60  # characters; a longer text is no quantity
ANGLES = ("radian", "degree", "turn", "revolution", "arcminute", "arcsecond", "grade", "gon")
NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,3})?"
QUANTITY = re.compile(rf"\s*({NUMBER})\s*(.*?)\s*", re.DOTALL)
GRAD = re.compile(r"\bgrad[es]*\b", re.IGNORECASE)  # degrees in German, gon in English, giga-radian for pint
SMALL = ("milli", "micro", "nano")  # prefixes that radian may have
# Units that people write in one word: N.m, N.mm, kg.cm2 and the like.
JOINED = re.compile(r"(?<![A-Za-z])([kmM]?N|[km]?g)([cm]?m)(s?)(?![A-Za-z])")
UNIT = re.compile(r"[A-Za-zµμ°ºΩ%][A-Za-z0-9µμ°ºΩ%²³^*./·⋅ ()-]*")
EXAMPLES = {
    "m": "20 mm", "rad": "45 deg", "N/m": "50 N/mm", "N": "50 N", "kg.m2": "3 kg.cm^2", "N.m": "7 N.m",
    "s": "10 ms", "Pa": "210 GPa", "kg": "300 g", "rad/s": "30 rpm", "m/s": "10 mm/s", "s/m": "0.5 s/m",
    "m3/(N.m)": "1e-6 mm^3/(N.m)",
}  # fmt: skip


def quantity(text: str, unit: str) -> float:
    """The number that a quantity such as "45 deg" is in `unit`. DesignError for any other text."""
    example = f'write for example "{EXAMPLES[unit]}"' if unit in EXAMPLES else ""
    if len(text) > LONGEST:
        raise DesignError(f"a text of {len(text)} characters: allowed is a number with a unit")
    if re.fullmatch(r"\s*[+-]?\d+,\d+\s*\D*.*", text, re.DOTALL):
        raise DesignError(f"a decimal comma: write {text.strip().replace(',', '.', 1)} with a decimal point")
    match = QUANTITY.fullmatch(text)
    if match is None:
        allowed = "allowed is a number" + ("" if unit in ("1", "") else f" in {unit}")
        raise DesignError("; ".join(filter(None, [allowed, example])))
    number, written = Decimal(match[1]), match[2]
    if not written:
        if unit in ("1", ""):
            raise DesignError(f"a number in quotes: write {match[1]} without quotes")
        usual = EXAMPLES.get(unit, f"1 {unit}").partition(" ")[2]
        text = f'no unit in the quotes: write "{match[1]} {usual}", or {match[1]} without quotes in {unit}'
        raise DesignError(text)
    return _converted(number, written, unit, example)


def written_unit(text: str) -> str:
    """The unit of a text such as "40 deg"; none where the text is no number with a unit."""
    match = QUANTITY.fullmatch(text) if len(text) <= LONGEST else None
    return match[2] if match else ""


def _converted(number: Decimal, written: str, unit: str, example: str) -> float:
    target = _parsed(unit)
    if GRAD.search(written):
        raise DesignError(
            f'unit {written!r} can mean degrees or gon: write "{number} {GRAD.sub("deg", written)}" for'
            f' degrees, or "{number} {GRAD.sub("gon", written)}" for gon (100 gon = 90 deg)'
        )
    kinds = {"m": "length", "rad": "angle", "1": "a plain number", "N": "force", "s": "time", "kg": "mass"}
    kind, hint = kinds.get(unit, unit), f"; {example}" if example else ""
    try:
        source = _parsed(written)
    except Exception:  # pint has many, also those of Python's tokenizer
        raise DesignError(f"unit {written!r} is not known: allowed are units of {kind}{hint}") from None
    if _is_huge_angle(source):
        raise DesignError(f"unit {written!r} is not allowed for an angle: allowed are rad, mrad and deg")
    if source.dimensionality != target.dimensionality or _turns(source) != _turns(target):
        raise DesignError(f"{written} is no unit of {kind}: allowed is {unit_words(unit)}{hint}")
    try:
        converted = float(_registry().Quantity(number, source).to(target).magnitude)
    except Exception as error:
        raise DesignError(f"unit {written!r} cannot be converted to {unit}: {error}") from None
    if not math.isfinite(converted):
        raise DesignError(f"{converted} {unit}: allowed is a finite number")
    return converted


def si_number(text: str) -> float:
    """The number that a quantity such as "79 GPa" is in m, kg, s and rad. DesignError for any other text."""
    match = QUANTITY.fullmatch(text) if len(text) <= LONGEST else None
    if match is None or not match[2]:
        raise DesignError('allowed is a number with a unit, such as "79 GPa"')
    try:
        base = _registry().Quantity(Decimal(match[1]), _parsed(match[2])).to_base_units()
        return float(base.magnitude)
    except Exception:  # pint has many
        text = f"unit {match[2]!r} is not known: allowed are units such as mm, N/mm, deg"
        raise DesignError(text) from None


def unit_words(unit: str) -> str:
    """What may stand as the unit of a value."""
    return "a plain number without a unit" if unit in ("1", "") else f"{unit} or a multiple of {unit}"


@cache
def _registry() -> UnitRegistry[Any]:
    from pint import UnitRegistry

    return UnitRegistry(non_int_type=Decimal)  # 18 mm is 0.018 m to the last digit


@cache
def _parsed(text: str) -> Unit:
    """A unit as people and the FMU write it: "N.s2/m2", "kg m^2", "N·m/rad"."""
    if text in ("1", ""):
        return _registry().Unit("")
    if not UNIT.fullmatch(text) or re.search(r"\d{2}", text):
        raise DesignError(f"unit {text!r}")
    plain = JOINED.sub(
        lambda match: "*".join(filter(None, match.groups())),
        text.translate(str.maketrans("·⋅.²³μº", "***23µ°")),
    )
    plain = re.sub(r"\s*([*/^])\s*", r"\1", plain.replace("**", "^"))
    plain = re.sub(r"([A-Za-zµ°%)])\^?(-?\d)", r"\1**\2", plain).replace(" ", "*")
    return _registry().parse_units(plain)


def _is_huge_angle(unit: Unit) -> bool:
    """Whether an angle in the unit has a prefix such as kilo or giga."""
    names = (name for name, _ in _registry().Quantity(Decimal(1), unit).unit_items())
    angles = ((name, angle) for name in names for angle in ANGLES if name.endswith(angle))
    return any(name != angle and not name.startswith(SMALL) for name, angle in angles)


def _turns(unit: Unit) -> float:
    """The power of angle in a unit."""
    items = _registry().Quantity(Decimal(1), unit).unit_items()
    turning = (power for name, power in items if "per_minute" in name or name.endswith(ANGLES))
    return sum(float(str(power)) for power in turning)
