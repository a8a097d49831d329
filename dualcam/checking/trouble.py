"""A finding of the check with what can help."""

from __future__ import annotations

from dataclasses import dataclass

from dualcam.checking.values import value_of
from dualcam.design_file import DesignFile, Finding

ERROR, WARNING = "error", "warning"


@dataclass(frozen=True)
class Remedy:
    """A key whose value, moved towards `bound`, can make a finding disappear."""

    key: str
    bound: float


@dataclass(frozen=True)
class Trouble:
    """A finding, and what can help, the first remedy first; `hint` is a further sentence."""

    finding: Finding
    remedies: tuple[Remedy, ...] = ()
    hint: str = ""


def finding_of(
    design: DesignFile, kind: str, key: str, text: str, severity: str = ERROR, value: object = None
) -> Finding:
    """A finding about the value of a key."""
    shown = value_of(design, key) if value is None and key else value
    return Finding(severity, key, shown, text, kind=kind)
