"""The table of fitted values, for the command line and the report."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dualcam.identification.result import Identification

OPEN = "not determined"
MOST_SHOWN = 3  # values that the residuals ask for, in one warning
HEADS = ("parameter", "start", "fitted", "95 % interval", "unit")


def rows_of(found: Identification) -> list[list[str]]:
    """One row of texts for each fitted value."""
    return [
        [
            one.name,
            f"{one.start:.5g}",
            one.rounded,
            one.interval,
            "-" if one.unit == "1" else one.unit,
        ]
        for one in found.parameters
    ]


def asked_for(found: Identification) -> list[str]:
    """A warning where the residuals ask for a value outside of the fit."""
    if not found.missing:
        return []
    best, *others = found.missing
    unit = "" if best.unit == "1" else f" {best.unit}"
    held = f", held at {best.held:.4g}{unit}," if best.held else ""
    text = (
        f"Lack of fit: the residuals ask for {best.name}{held} to change by {best.change:+.3g}{unit}"
        f" (95 % interval {best.half_width:.2g}{unit} to both sides). So the intervals above are too narrow."
        f" Try --fit {','.join([*(one.name for one in found.parameters), best.name])}"
    )
    if others:
        names = " or ".join(one.name for one in others[: MOST_SHOWN - 1])
        text += f". A change of {names} would explain nearly as much"
    return [text]


def levers_of(found: Identification) -> list[str]:
    """A warning for each fitted value that small errors of held values change strongly."""
    texts = []
    for one in found.parameters:
        if one.status == OPEN or one.limit is not None:
            continue
        levers = [lever for lever in found.levers if lever.name == one.name]
        if levers:
            unit = "" if one.unit == "1" else f" {one.unit}"
            parts = [f"{lever.held_text} by {abs(lever.change):.2g}{unit}" for lever in levers]
            texts.append(
                f"{one.name} depends on values that are held: an error of 10 % changes {one.name} through"
                f" {', through '.join(parts)}. Fit these too, or be sure of their values"
            )
    return texts


def weak_parts(found: Identification) -> list[str]:
    """A warning for each fitted value whose part of the torque is below the noise."""
    return [
        f"{one.name} makes {one.part:.2g} N.m RMS of the torque, less than the noise of {found.noise:.2g}"
        " N.m: other errors of the model can show up as this value"
        for one in found.parameters
        if one.status == "known" and one.limit is None and one.part < found.noise
    ]
