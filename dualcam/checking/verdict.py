"""The verdict on a design."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from dualcam.checking.plausibility import implausible
from dualcam.checking.remedies import RemedySearch
from dualcam.checking.rules import swap_warning, troubles
from dualcam.common.unit_guards import units_checked_before
from dualcam.design import Limits, Pin, torque_band
from dualcam.design.band import locking_words, span
from dualcam.design.mechanism import POINTS, Mechanism
from dualcam.design.strength import strength
from dualcam.design_file import DesignFile, DesignSource, Finding, as_design
from dualcam.design_file.durability import (
    RollerNumbers,
    SpringNumbers,
    WearNumbers,
    largest_contact,
    roller_numbers,
    roller_words,
    spring_numbers,
    spring_words,
    wear_numbers,
    wear_words,
)
from dualcam.design_file.findings import ERROR, WARNING
from dualcam.design_file.toml_text import line_of
from dualcam.errors import FmuError
from dualcam.fmi.fmu import Fmu
from dualcam.fmi.library import fmu_path
from dualcam.fmi.variables import inputs_of, unused

UNIT = "unit"  # kind of a warning about a value that looks like another unit
NO_CAUSE = ("scenario.stop",)  # values that make no error, whatever their unit
FRICTION_CLASSES = {  # by the FMU's friction_class
    1: "one motion under every load (unique)",
    2: "several motions or none under some loads, where a fixed rule chooses (self-locking)",
}


@dataclass(frozen=True)
class Verdict:
    """All findings about a design.

    Attributes
    ----------
    name : Name of the design.
    model : The model that was started: "forward" or "inverse".
    starts : Whether the FMU starts with the design's parameters.
    findings : tuple of Finding
        Errors first, then warnings. Where a value looks like another unit, the warning about this value comes
        before the errors, because the unit is their likely cause.
    notes : How the files of groove tables were understood.
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
        """The verdict for json.dumps: name, model, good, starts, findings (a list of dictionaries), notes,
        and numbers in SI units, which are null for a design with errors."""
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
    """Check a design and start its FMU. DesignFileError where the file is refused, FmuError where this
    package's FMUs are missing.

    Parameters
    ----------
    design : A design, from `read_design`, or the path of its file.

    Returns
    -------
    Verdict
        All findings. An error has the nearest value that works where a search finds one; no error has one
        while a value looks like another unit.

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
    refusal, friction_class = _start_of(design)
    causes = [warning for warning in design.warnings if warning.kind == UNIT and warning.key not in NO_CAUSE]
    if causes:
        findings = [one.finding for one in found]
    else:
        search = RemedySearch(design, found, lambda other: _start_of(other)[0])
        findings = [search.mended(one) for one in found]
    errors = [finding.kind for finding in findings if finding.severity == ERROR]
    if errors and not causes and (swapped := swap_warning(design, errors)):
        findings.append(swapped)
    if refusal and not errors:
        text = f"the FMU does not start: {refusal}{_soft_shaft(design)}"
        findings.append(Finding(ERROR, "", None, text, kind="fmu"))
    findings += _unused(design)
    if not design.parameters:
        text = "no parameter is given: every value is the default of the FMU, listed by `dualcam info`"
        findings.append(Finding(WARNING, "", None, text, kind="defaults"))
    if not (refusal or errors):
        findings += implausible(design)
    placed = [
        one.at_line(line_of(design.lines, tuple(one.key.split("."))) if one.key else None) for one in findings
    ]
    others = [warning for warning in design.warnings if warning not in causes]
    ordered = sorted([*placed, *others], key=lambda finding: finding.severity != ERROR)
    numbers = None if refusal or errors else key_numbers(design, friction_class)
    return Verdict(design.name, design.model, not refusal, (*causes, *ordered), design.notes, numbers)


def _start_of(design: DesignFile) -> tuple[str, int]:
    """The FMU's refusal to start with a design, "" if it starts, and its friction class."""
    with Fmu(fmu_path(design.model)) as fmu, units_checked_before():
        try:
            fmu.start(design.parameters_for() | _first_inputs(design))
        except FmuError as error:
            return str(error), 0
        return "", int(fmu.get("friction_class"))


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


def _soft_shaft(design: DesignFile) -> str:
    """What to do about an elastic shaft with friction that falls with the speed; empty without both."""
    peaks = any(design.value(f"cam{i}.friction_peak") > 1.0 for i in (1, 2))
    if not peaks or design.value("shaft.stiffness") == 0.0:
        return ""
    return (
        f". For stick-slip put the soft shaft (shaft.stiffness = {design.value('shaft.stiffness'):g} N.m/rad)"
        " outside a forward FMU: docs/stick-slip.md"
    )


@dataclass(frozen=True)
class LargestPressure:
    """The largest Hertz pressure of the line contacts."""

    pressure: float  # Pa, as limit, moduli and shear
    limit: float
    theta: float  # rad
    cam: int  # 1 or 2
    modulus: float  # Young's, of the pin; cam_modulus of both cams
    cam_modulus: float
    shear: float  # largest shear stress below the surface
    depth: float  # of this shear stress [m]


@dataclass(frozen=True)
class KeyNumbers:
    """Numbers by which a design is judged, in slow motion over the whole range of theta."""

    load: tuple[float, float]  # least and largest torque to load [N.m]
    release: tuple[float, float]  # likewise torque given back [N.m]
    efficiency: tuple[float, float]  # likewise release over load at the same angle [1]
    self_locking: bool  # the spring cannot turn cam 2 back at some angle
    locked: tuple[tuple[float, float], ...]  # ranges of theta in which the spring cannot do so [rad]
    friction_class: int  # the FMU's: 1 unique, 2 self-locking
    stroke: float  # way of the follower from stop to stop [m]
    pressure: LargestPressure | None  # None without a pin
    roller: RollerNumbers | None = None  # None without a roller
    spring: SpringNumbers | None = None  # None without wire and coil
    wear: WearNumbers | None = None  # None where nothing wears

    def as_dict(self) -> dict[str, Any]:
        """The numbers as JSON has them, in SI units."""
        return asdict(self)

    def lines(self) -> list[str]:
        """One line for each number, with its unit."""
        return [
            f"torque to load: {span(np.array(self.load))} N.m",
            f"torque given back: {span(np.array(self.release))} N.m",
            f"efficiency: {span(100.0 * np.array(self.efficiency))} %",
            f"self-locking: {locking_words(self.locked)}",
            f"friction: {self.friction_words()}",
            f"stroke of the follower: {1e3 * self.stroke:.4g} mm",
            f"contact pressure: {self._pressure_in_words()}",
            *self._durability_lines(),
        ]

    def friction_words(self) -> str:
        """The class of the mechanism under friction."""
        return FRICTION_CLASSES[self.friction_class]

    def _durability_lines(self) -> list[str]:
        """Shear stress, roller, spring and wear, as far as they are known."""
        found = []
        if (contact := self.pressure) is not None:
            found.append(
                f"shear stress below the surface: at most {contact.shear / 1e6:.4g} MPa,"
                f" {1e3 * contact.depth:.3g} mm deep"
            )
        if self.roller is not None:
            found.append(f"roller: {roller_words(self.roller)}")
        if self.spring is not None:
            found.append(f"spring: {spring_words(self.spring)}")
            if not self.spring.has_length:
                found.append(
                    "spring length and buckling: not checked, the file gives no spring.free_length and"
                    " spring.solid_length"
                )
        if self.wear is not None:
            found.append(f"wear: {wear_words(self.wear)}")
        return found

    def _pressure_in_words(self) -> str:
        largest = self.pressure
        if largest is None:
            return "not checked, the file gives no [pin]"
        is_default = " (the default)" if largest.limit == Limits().pressure else ""
        steel = Pin.modulus
        is_steel = " (the default, steel)" if largest.modulus == largest.cam_modulus == steel else ""
        return (
            f"at most {largest.pressure / 1e6:.4g} MPa, at theta = {math.degrees(largest.theta):.4g} deg"
            f" on cam {largest.cam}; limit {largest.limit / 1e6:.6g} MPa{is_default}; Young's modulus of the"
            f" pin {largest.modulus / 1e9:.4g} GPa, of the cams {largest.cam_modulus / 1e9:.4g} GPa{is_steel}"
        )


def key_numbers(design: DesignFile, friction_class: int) -> KeyNumbers:
    """The key numbers of a design whose check finds no error."""
    mechanism = design.mechanism()
    band = torque_band(mechanism)
    return KeyNumbers(
        load=_ends(band.load),
        release=_ends(band.release),
        efficiency=_ends(band.efficiency),
        self_locking=band.self_locking,
        locked=band.locked,
        friction_class=friction_class,
        stroke=float(band.z[-1] - band.z[0]),
        pressure=None if design.pin is None else _largest_pressure(design, mechanism, design.pin),
        roller=roller_numbers(design),
        spring=spring_numbers(design, mechanism),
        wear=wear_numbers(design, mechanism),
    )


def _ends(values: np.ndarray) -> tuple[float, float]:
    return float(np.nanmin(values)), float(np.nanmax(values))


def _largest_pressure(design: DesignFile, mechanism: Mechanism, pin: Pin) -> LargestPressure:
    found = strength(mechanism, pin, np.linspace(*mechanism.reach(), POINTS))
    cam, place = np.unravel_index(int(np.argmax(found.pressure)), found.pressure.shape)
    contact = largest_contact(mechanism, pin, int(cam) + 1, float(found.theta[place]))
    return LargestPressure(
        pressure=float(found.pressure[cam, place]),
        limit=(design.limits or Limits()).pressure,
        theta=float(found.theta[place]),
        cam=int(cam) + 1,
        modulus=pin.modulus,
        cam_modulus=pin.cam_modulus,
        shear=float(contact.shear),
        depth=float(contact.depth),
    )
