"""The table of fitted values, for the command line and the report."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dualcam.identification.result import Identification

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
