"""The inputs of a design as tables: parameters, spring, pin, limits and scenario, in SI and usual units."""

import math
from dataclasses import fields
from pathlib import Path

from dualcam.common.groove_laws import LAWS, PARAMETERS, laws_with
from dualcam.design import HelicalSpring, Limits, Pin, Roller
from dualcam.design_file import DesignFile
from dualcam.design_file.friction_tables import ANALYTIC_FRICTION
from dualcam.fmi.model_description import Scalar
from dualcam.fmi.variables import SettableVariable, all_inputs, parameters_of
from dualcam.scenario.scenario import History, Scenario

Row = tuple[str, ...]

USUAL = {  # unit of the FMU -> usual unit, its factor
    "rad": ("deg", 180.0 / math.pi),
    "rad/s": ("deg/s", 180.0 / math.pi),
    "m": ("mm", 1e3),
    "N/m": ("N/mm", 1e-3),
    "kg.m2": ("kg.cm2", 1e4),
    "Pa": ("MPa", 1e-6),
}
UNITS = {  # of the keys of [pin], [roller], [helical_spring] and [limits] that have one
    "pin": {"radius": "m", "width": "m", "modulus": "Pa", "cam_modulus": "Pa", "wear": "m3/(N.m)"},
    "roller": {"bearing_radius": "m", "lever_arm": "m"},
    "helical_spring": {
        "wire_diameter": "m",
        "coil_diameter": "m",
        "tensile_strength": "Pa",
        "shear_modulus": "Pa",
        "fatigue_strength": "Pa",
    },
    "limits": {"pressure": "Pa", "wear_depth": "m"},
}
MOST_POINTS = 12  # of an input over time that are listed one by one


def input_tables(design: DesignFile) -> dict[str, list[Row]]:
    """Heading -> rows: key, value in SI, unit, value in the usual unit."""
    tables = {"Parameters of the mechanism": _parameters(design)}
    if design.spring_limits is not None:
        lengths = design.spring_limits._asdict().items()
        tables["Lengths of the spring"] = [_row(f"spring.{name}", length, "m") for name, length in lengths]
    if design.pin is not None:
        tables["Pin and material"] = _object("pin", design.pin)
    if design.roller is not None:
        tables["Roller"] = [row for row in _object("roller", design.roller) if row[0] != "roller.radius"]
    if design.helical_spring is not None:
        tables["Wire and coil of the spring"] = _object("helical_spring", design.helical_spring)
    if design.limits is not None:
        ends = zip(("least", "greatest"), design.limits.lead_angle, strict=True)
        leads = [_row(f"limits.lead_angle, {which}", angle, "rad") for which, angle in ends]
        tables["Limits of the check"] = leads + _object("limits", design.limits)
    if design.scenario is not None:
        tables["Scenario"] = _scenario(design.scenario)
    return tables


def _parameters(design: DesignFile) -> list[Row]:
    """Those of the file, and the defaults that act; a default of 0 does not."""
    rows = []
    for name, variable in parameters_of(design.model).items():
        given = name in design.parameters
        value = design.value(name)
        if (given or (value and name != "ledger")) and _is_used(design, name):
            rows.append(_parameter(variable, value, given))
    return rows


def _is_used(design: DesignFile, name: str) -> bool:
    """Whether the groove law of the cam, or its friction law, uses the parameter."""
    group, _, key = name.partition(".")
    if key in ANALYTIC_FRICTION and design.value(f"{group}.friction_table"):
        return False
    return key not in PARAMETERS or LAWS[int(design.value(f"{group}.profile"))] in laws_with(key)


def _parameter(variable: SettableVariable, value: Scalar, given: bool) -> Row:
    if variable.name.endswith(".profile"):
        row: Row = variable.name, LAWS[int(value)].word, "", ""
    else:
        shown = Path(value).name if isinstance(value, str) else value
        row = _entry(variable.name, shown, variable.unit or "1")
    return row if given else (f"{row[0]} (default)", *row[1:])


def _row(name: str, value: float, unit: str) -> Row:
    usual, factor = ("GPa", 1e-9) if name.endswith("modulus") else USUAL.get(unit, ("", 1.0))
    beside = f"{value * factor:.6g} {usual}" if usual else ""
    return name, f"{value:.6g}", "" if unit == "1" else unit, beside


def _object(table: str, of: Pin | Roller | HelicalSpring | Limits) -> list[Row]:
    """The keys of a table whose object has their values; a key without value is left out."""
    values = {field.name: getattr(of, field.name) for field in fields(of) if field.name != "lead_angle"}
    units = UNITS[table]
    return [_entry(f"{table}.{k}", v, units.get(k, "1")) for k, v in values.items() if v is not None]


def _entry(key: str, value: Scalar, unit: str) -> Row:
    if isinstance(value, bool):
        return key, "true" if value else "false", "", ""
    if isinstance(value, str):
        return key, value, "", ""
    return _row(key, value, unit)


def _scenario(scenario: Scenario) -> list[Row]:
    rows = [_row("scenario.stop", scenario.stop, "s")]
    known = all_inputs()
    for name, history in scenario.inputs.items():
        unit = known[name].unit if name in known else ""
        rows += _history(f"scenario.inputs.{name}", history, unit)
    return rows


def _history(key: str, history: History, unit: str) -> list[Row]:
    if history.derivative_of:
        return [(key, f"time derivative of {history.derivative_of}", unit, "")]
    if len(set(history.value)) == 1:
        return [_row(f"{key}, constant", history.value[0], unit)]
    if len(history.time) > MOST_POINTS:
        span = f"{len(history.time)} points, {min(history.value):.6g} to {max(history.value):.6g}"
        return [(f"{key}, {history.shape}", span, unit, "")]
    points = zip(history.time, history.value, strict=True)
    return [_row(f"{key} at {time:g} s ({history.shape})", value, unit) for time, value in points]
