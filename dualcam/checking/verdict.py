"""The verdict on a design."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from dualcam.checking.rules import ERROR, Remedy, Trouble, swap_warning, troubles
from dualcam.checking.search import nearest_working
from dualcam.checking.values import value_of, with_value
from dualcam.design_file import DesignFile, DesignSource, Finding, as_design
from dualcam.design_file.toml_text import line_of
from dualcam.errors import DualcamError, FmuError
from dualcam.library import fmu_path
from dualcam.unit_guards import unit_warning, units_checked_before
from dualcam.variables import all_parameters, inputs_of

PIN_UNITS = {"pin.radius": "m", "pin.width": "m"}


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
        Errors first, then warnings.
    notes : tuple of str
        How the files of groove tables were understood.
    """

    name: str
    model: str
    starts: bool
    findings: tuple[Finding, ...]
    notes: tuple[str, ...] = ()

    @property
    def errors(self) -> tuple[Finding, ...]:
        """The findings with which the design does not work."""
        return tuple(finding for finding in self.findings if finding.severity == ERROR)

    @property
    def good(self) -> bool:
        """Whether there are no errors and the FMU starts. Warnings do not count."""
        return self.starts and not self.errors

    def to_json(self) -> dict[str, Any]:
        """The verdict as a dictionary of plain values, for json.dumps.

        Returns
        -------
        dict
            Keys name, model, good, starts, findings (a list of dictionaries), notes.
        """
        return {
            "name": self.name,
            "model": self.model,
            "good": self.good,
            "starts": self.starts,
            "findings": [finding.as_dict() for finding in self.findings],
            "notes": list(self.notes),
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
        All findings, each with the nearest value that works where a search finds one.

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
    refusal = start_refusal(design)
    findings = [_with_remedy(design, trouble, found) for trouble in found]
    if any(finding.severity == ERROR for finding in findings) and (swapped := swap_warning(design)):
        findings.append(swapped)
    if refusal and not any(finding.severity == ERROR for finding in findings):
        findings.append(Finding(ERROR, "", None, f"the FMU does not start: {refusal}", kind="fmu"))
    placed = [finding.at_line(_line(design, finding.key)) for finding in findings]
    ordered = sorted([*placed, *design.warnings], key=lambda finding: finding.severity != ERROR)
    return Verdict(design.name, design.model, not refusal, tuple(ordered), design.notes)


def start_refusal(design: DesignFile) -> str:
    """The FMU's message if the FMU does not start with the design's parameters, else an empty text."""
    from dualcam.fmu import Fmu

    with Fmu(fmu_path(design.model)) as fmu, units_checked_before():
        try:
            fmu.start(design.parameters_for() | _first_inputs(design))
        except FmuError as error:
            return str(error)
    return ""


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


def _line(design: DesignFile, key: str) -> int | None:
    return line_of(design.lines, tuple(key.split("."))) if key else None


# ---- the nearest value that works ----


def _with_remedy(design: DesignFile, trouble: Trouble, all_found: list[Trouble]) -> Finding:
    """The finding with a value that makes the finding disappear, from the first remedy that has one.

    If the finding is the only error, values are preferred with which the whole design is good."""
    finding = trouble.finding
    hint = unit_warning(finding.key, finding.value) if finding.severity == ERROR else ""
    likely = f"; {hint.partition(': ')[2]}" if hint else ""
    alone = finding.severity == ERROR and sum(t.finding.severity == ERROR for t in all_found) == 1
    change, value = next(_working_values(design, trouble, alone), ("", None))
    works = f"{change} = {value:.10g}{_unit(change, value)} works" if value is not None else ""
    text = ". ".join(filter(None, [f"{finding.text}{likely}", works, trouble.hint]))
    return replace(finding, text=text, nearest=value, change=change)


def _working_values(design: DesignFile, trouble: Trouble, alone: bool) -> Iterator[tuple[str, float]]:
    for strict in (True, False) if alone else (False,):
        for remedy in trouble.remedies:
            value = _search(design, trouble.finding, remedy, strict)
            if value is not None:
                yield remedy.key, value


def _search(design: DesignFile, finding: Finding, remedy: Remedy, strict: bool) -> float | None:
    """The nearest value without this finding; if strict, without any error, and the FMU starts."""
    current = value_of(design, remedy.key)
    if current is None or current == remedy.bound:
        return None

    def works(value: float) -> bool:
        try:
            left = troubles(with_value(design, remedy.key, value), locate=False)
        except DualcamError:
            return False
        found = {trouble.finding.kind for trouble in left}
        errors = {trouble.finding.kind for trouble in left if trouble.finding.severity == ERROR}
        return finding.kind not in found and "groove" not in errors and not (strict and errors)

    value = nearest_working(float(current), remedy.bound, works)
    if value is not None and strict and start_refusal(with_value(design, remedy.key, value)):
        return None
    return value


def _unit(key: str, value: float) -> str:
    known = all_parameters()
    unit = known[key].unit if key in known else PIN_UNITS.get(key, "1")
    degrees = f" ({math.degrees(value):.4g} deg)" if unit == "rad" else ""
    return "" if unit == "1" else f" {unit}{degrees}"
