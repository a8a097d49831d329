"""The verdict on a design."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from dualcam.checking.numbers import KeyNumbers, key_numbers
from dualcam.checking.plausible import implausible
from dualcam.checking.remedies import RemedySearch
from dualcam.checking.rules import swap_warning, troubles
from dualcam.checking.trouble import ERROR, WARNING
from dualcam.common.unit_guards import units_checked_before
from dualcam.design_file import DesignFile, DesignSource, Finding, as_design
from dualcam.design_file.toml_text import line_of
from dualcam.errors import FmuError
from dualcam.fmi.library import fmu_path
from dualcam.fmi.variables import inputs_of, unused

UNIT = "unit"  # kind of a warning about a value that looks like another unit
NO_CAUSE = ("scenario.stop",)  # values that make no error, whatever their unit


@dataclass(frozen=True)
class Verdict:
    """All findings about a design.

    Attributes
    ----------
    name : str
        Name of the design.
    model : {"forward", "inverse"}
        The model that was started.
    starts : bool
        Whether the FMU starts with the design's parameters.
    findings : tuple of Finding
        Errors first, then warnings. Where a value looks like another unit, the warning about this value comes
        before the errors, because the unit is their likely cause.
    notes : tuple of str
        How the files of groove tables were understood.
    numbers : KeyNumbers or None
        Torques, efficiency, stroke, contact pressure, spring, roller and wear; None for a design with errors.
    """

    name: str
    model: str
    starts: bool
    findings: tuple[Finding, ...]
    notes: tuple[str, ...] = ()
    numbers: KeyNumbers | None = None

    @property
    def errors(self) -> tuple[Finding, ...]:
        """The findings with which the design does not work."""
        return tuple(finding for finding in self.findings if finding.severity == ERROR)

    @property
    def warnings(self) -> tuple[Finding, ...]:
        """The findings that refuse nothing."""
        return tuple(finding for finding in self.findings if finding.severity != ERROR)

    @property
    def strange_units(self) -> tuple[Finding, ...]:
        """The warnings about values that look like another unit."""
        return tuple(finding for finding in self.warnings if finding.kind == UNIT)

    @property
    def good(self) -> bool:
        """Whether there are no errors and the FMU starts. Warnings do not count."""
        return self.starts and not self.errors

    def to_json(self) -> dict[str, Any]:
        """The verdict as a dictionary of plain values, for json.dumps.

        Returns
        -------
        dict
            Keys name, model, good, starts, findings (a list of dictionaries), notes, numbers (in SI units;
            null for a design with errors).
        """
        return {
            "name": self.name,
            "model": self.model,
            "good": self.good,
            "starts": self.starts,
            "findings": [finding.as_dict() for finding in self.findings],
            "notes": list(self.notes),
            "numbers": self.numbers.as_dict() if self.numbers else None,
        }


def check_design(design: DesignSource) -> Verdict:
    """Check a design and start its FMU.

    Parameters
    ----------
    design : DesignFile, str or Path
        A design, from `read_design`, or the path of its file.

    Returns
    -------
    Verdict
        All findings. An error has the nearest value that works where a search finds one; no error has one
        while a value looks like another unit.

    Raises
    ------
    DesignFileError
        The file is refused.
    FmuError
        Where this package's FMUs are missing.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from dualcam.design_file import write_template
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     verdict = check_design(write_template("robot", Path(folder) / "my.toml"))
    >>> verdict.good
    True
    """
    design = as_design(design, shows_findings=True)
    found = troubles(design)
    start = _start_of(design)
    refusal = start.refusal
    causes = [warning for warning in design.warnings if warning.kind == UNIT and warning.key not in NO_CAUSE]
    if causes:
        findings = [trouble.finding for trouble in found]
    else:
        search = RemedySearch(design, found, lambda other: _start_of(other).refusal)
        findings = [search.mended(trouble) for trouble in found]
    errors = [finding.kind for finding in findings if finding.severity == ERROR]
    has_errors = bool(errors)
    if has_errors and not causes and (swapped := swap_warning(design, errors)):
        findings.append(swapped)
    if refusal and not has_errors:
        text = f"the FMU does not start: {refusal}{_soft_shaft(design)}"
        findings.append(Finding(ERROR, "", None, text, kind="fmu"))
    findings += [*_unused(design), *_only_defaults(design)]
    if not (refusal or has_errors):
        findings += implausible(design)
    placed = [finding.at_line(_line(design, finding.key)) for finding in findings]
    others = [warning for warning in design.warnings if warning not in causes]
    ordered = sorted([*placed, *others], key=lambda finding: finding.severity != ERROR)
    numbers = None if refusal or has_errors else key_numbers(design, start.friction_class)
    return Verdict(design.name, design.model, not refusal, (*causes, *ordered), design.notes, numbers)


@dataclass(frozen=True)
class _Start:
    """The start of the FMU with a design: its refusal, empty if it starts, or its friction class."""

    refusal: str
    friction_class: int = 0


def _start_of(design: DesignFile) -> _Start:
    from dualcam.fmi.fmu import Fmu

    with Fmu(fmu_path(design.model)) as fmu, units_checked_before():
        try:
            fmu.start(design.parameters_for() | _first_inputs(design))
        except FmuError as error:
            return _Start(str(error))
        return _Start("", int(fmu.get("friction_class")))


def _first_inputs(design: DesignFile) -> dict[str, float]:
    """Inputs at the start: the imposed angle must be between the stops."""
    if design.model != "inverse":
        return {}
    low, high = design.value("stop.lower"), design.value("stop.upper")
    histories = design.scenario.inputs if design.scenario else {}
    first = {
        name: float(history.value[0])
        for name, history in histories.items()
        if len(history.value) and name in inputs_of("inverse")
    }
    return {"theta": min(max(0.0, low), high)} | first


def _unused(design: DesignFile) -> list[Finding]:
    """Warnings about parameters of the other model, apart from the start, where an inverse FMU begins."""
    known = design.parameters_for()
    return [
        Finding(
            WARNING,
            name,
            value,
            unused(name, value, design.model) + (_soft_shaft(design) if name == "shaft.stiffness" else ""),
            kind="unused",
        )
        for name, value in design.parameters.items()
        if name not in known and not name.startswith("initial.")
    ]


def _only_defaults(design: DesignFile) -> list[Finding]:
    """A warning about a file without a parameter."""
    if design.parameters:
        return []
    text = "no parameter is given: every value is the default of the FMU, listed by `dualcam info`"
    return [Finding(WARNING, "", None, text, kind="defaults")]


def _soft_shaft(design: DesignFile) -> str:
    """What to do about an elastic shaft with friction that falls with the speed; empty without both."""
    peaks = any(design.value(f"cam{i}.friction_peak") > 1.0 for i in (1, 2))
    if not peaks or design.value("shaft.stiffness") == 0.0:
        return ""
    return (
        f". For stick-slip put the soft shaft (shaft.stiffness = {design.value('shaft.stiffness'):g} N.m/rad)"
        " outside a forward FMU: docs/stick-slip.md"
    )


def _line(design: DesignFile, key: str) -> int | None:
    return line_of(design.lines, tuple(key.split("."))) if key else None
