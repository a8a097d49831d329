"""Groove laws z = g(psi) as the FMU has them (fmu_src/geometry/groove.h), for arrays, with the curvature
of the unwrapped groove (x = r psi, z). Each law is one module and one entry of `CLOSED_FORMS`.

A `Table` lays the very curve through its samples that the FMU lays (fmu_src/geometry/groove_table.h)."""

from collections.abc import Mapping, Sequence
from typing import Any

from dualcam.common.groove_laws import TABLE
from dualcam.design.grooves.cycloid import Cycloid
from dualcam.design.grooves.ellipse import Ellipse
from dualcam.design.grooves.groove import ClosedForm, Groove, Point, curvature
from dualcam.design.grooves.helix import Helix
from dualcam.design.grooves.table import Table

CLOSED_FORMS: tuple[type[ClosedForm], ...] = (Helix, Ellipse, Cycloid)
CLASSES = (*CLOSED_FORMS, Table)

__all__ = [
    "CLASSES",
    "ClosedForm",
    "Cycloid",
    "Ellipse",
    "Groove",
    "Helix",
    "Point",
    "Table",
    "both_parameters",
    "curvature",
    "groove_of",
]


def groove_of(parameters: Mapping[str, Any]) -> Groove:
    """The groove of the FMU's parameters after `cam1.` or `cam2.`."""
    if parameters["profile"] == TABLE.number:
        return Table.read(parameters["table"], parameters["radius"])
    kind = next(one for one in CLOSED_FORMS if one.law.number == parameters["profile"])
    return kind(*(parameters[name] for name in ("radius", *kind.law.parameters)))


def both_parameters(grooves: Sequence[Groove]) -> dict[str, float | int]:
    """Parameters of both cams under their full names."""
    return {f"cam{i}.{name}": v for i, g in enumerate(grooves, 1) for name, v in g.parameters().items()}
