"""The schema of design files as one pydantic model, made from the FMUs' variables."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, BeforeValidator, Field, WithJsonSchema, create_model
from pydantic_core import PydanticCustomError

from dualcam.common import groove_laws
from dualcam.common.toml_table import TomlTable
from dualcam.common.unit_guards import unit_warning
from dualcam.common.written_units import quantity
from dualcam.errors import DesignError
from dualcam.fmi.variables import SettableVariable, all_inputs, all_parameters

SHAPES = ("linear", "smooth")


def _entry(
    name: str, unit: str, description: str, least: float = -math.inf, greatest: float = math.inf
) -> SettableVariable:
    return SettableVariable(name, float, "parameter", unit, least, greatest, 0.0, description)


SPRING = (
    _entry("free_length", "m", "Length of the unloaded spring", 0.0),
    _entry("solid_length", "m", "Length of the spring with all coils in contact", 0.0),
)
PIN = (
    _entry("radius", "m", "Radius of the pin", 0.0),
    _entry("width", "m", "Width of the flank along the pin", 0.0),
    _entry("modulus", "Pa", "Young's modulus of the pin; the default is steel", 0.0),
    _entry("poisson", "1", "Poisson's ratio of the pin", 0.0, 0.5),
    _entry("cam_modulus", "Pa", "Young's modulus of the cams; the default is steel", 0.0),
    _entry("cam_poisson", "1", "Poisson's ratio of the cams", 0.0, 0.5),
    _entry("wear", "m3/(N.m)", "Specific wear rate of the pin; 0: the pin does not wear", 0.0, 1.0),
)
HELICAL_SPRING = (
    _entry("wire_diameter", "m", "Diameter of the wire", 1e-6, 1.0),
    _entry("coil_diameter", "m", "Mean diameter of the coil: outer diameter less wire diameter", 1e-6, 100.0),
    _entry("active_coils", "1", "Number of active coils", 2.0, 1e4),
    _entry("total_coils", "1", "Number of all coils; active coils and 2 if not given", 2.0, 1e5),
    _entry("tensile_strength", "Pa", "Tensile strength; that of the grade if not given", 1e6, 1e11),
    _entry("shear_modulus", "Pa", "Shear modulus of the wire; the default is spring steel", 1e6, 1e13),
    _entry(
        "fatigue_strength",
        "Pa",
        "Shear stress amplitude that the wire endures at mean stress 0; by Zimmerli if not given",
        1e3,
        1e11,
    ),
)
ROLLER = (
    _entry("bearing_friction", "1", "Coefficient of friction in the bearing of the roller", 0.0),
    _entry("bearing_radius", "m", "Radius at which the bearing rubs, less than pin.radius", 0.0),
    _entry("lever_arm", "m", "Lever arm of rolling resistance between roller and flank", 0.0),
    _entry("sliding_friction", "1", "Coefficient of friction if the roller slides on the flank", 0.0),
)
LEAD_ANGLE = _entry("lead_angle", "rad", "Least and greatest lead angle", 0.0, 0.5 * math.pi)
PRESSURE = _entry(
    "pressure", "Pa", "Greatest contact pressure by Hertz; the default is for hardened steel", 0.0
)
LIMITS = (
    _entry("spring_safety", "1", "Least Goodman safety of the helical spring", 0.01, 100.0),
    _entry("wear_depth", "m", "Greatest depth of wear of each groove and of the pin", 1e-9, 1.0),
    _entry("cycles", "1", "Least number of slow cycles until then; 0: any number", 0.0, 1e15),
)
TIMES = (
    _entry("stop", "s", "End of the simulation", 0.0),
    _entry("step", "s", "Step for FMUs that take no derivatives of inputs; DualCam FMUs take them", 0.0),
    _entry("tolerance", "1", "Relative tolerance of the FMU's integrator", 0.0),
    _entry("output_interval", "s", "Time between two samples of `dualcam simulate`", 0.0),
)


# ---- kinds of values ----


def _refused(text: str) -> PydanticCustomError:
    return PydanticCustomError("value", "{text}", {"text": text})


def to_number(value: object, variable: SettableVariable) -> float:
    """A number, or a text with a unit, in the unit of the variable. Raises what pydantic collects."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise _refused(f"allowed is {variable.allowed()}")
    try:
        number = quantity(value, variable.unit) if isinstance(value, str) else float(value)
    except DesignError as error:
        raise _refused(str(error)) from None
    except OverflowError:
        number = math.inf
    if not (math.isfinite(number) and variable.least <= number <= variable.greatest):
        words = {"text": f"allowed is {variable.allowed()}", "number": number}
        raise PydanticCustomError("range", "{text}", words)
    return number


def _whole(value: object, variable: SettableVariable) -> int:
    number = value
    if variable.name.endswith(".profile") and isinstance(value, str):
        number = groove_laws.NUMBERS.get(value)
    if isinstance(number, float) and number.is_integer():
        number = int(number)
    is_between = number == 0 and variable.name.endswith(".ellipse_curvature")
    if type(number) is int and variable.least <= number <= variable.greatest and not is_between:
        return number
    if variable.name.endswith(".ellipse_curvature"):
        raise _refused("allowed is -1 (the groove flattens) or +1 (the groove steepens)")
    words = f" ({groove_laws.ALLOWED})" if variable.name.endswith(".profile") else ""
    raise _refused(f"allowed is {variable.allowed()}{words}")


def _number_schema(variable: SettableVariable) -> dict[str, Any]:
    number: dict[str, Any] = {"type": "number"}
    if math.isfinite(variable.least):
        number["minimum"] = variable.least
    if math.isfinite(variable.greatest):
        number["maximum"] = variable.greatest
    return {"anyOf": [number, {"type": "string", "description": "a number with its unit"}]}


def number_type(variable: SettableVariable) -> Any:  # noqa: ANN401
    """The type of a number in the variable's unit, or text with a unit."""
    convert = BeforeValidator(lambda value: to_number(value, variable))
    return Annotated[float, convert, WithJsonSchema(_number_schema(variable))]


def _type_of(variable: SettableVariable) -> Any:  # noqa: ANN401
    if variable.kind is float:
        return number_type(variable)
    if variable.kind is int:
        schema: dict[str, Any] = {"type": "integer", "minimum": variable.least, "maximum": variable.greatest}
        if variable.name.endswith(".profile"):
            schema = {"enum": [*groove_laws.LAWS, *groove_laws.NUMBERS]}
        elif variable.name.endswith(".ellipse_curvature"):
            schema = {"enum": [-1, 1]}
        convert = BeforeValidator(lambda value: _whole(value, variable))
        return Annotated[int, convert, WithJsonSchema(schema)]
    return variable.kind


def _field(variable: SettableVariable, default: float | None = None) -> Any:  # noqa: ANN401
    unit = f" [{variable.unit}]" if variable.unit not in ("1", "") else ""
    return _key(_type_of(variable), variable.description + unit, default)


def _key(kind: Any, description: str, default: object = None, **extra: Any) -> Any:  # noqa: ANN401
    """The type and the field of a key; `default` is what editors show where the key is left out."""
    extra |= {} if default is None else {"default": default}
    return kind, Field(default=None, description=description, json_schema_extra=extra or None)


def _table(name: str, description: str, fields: Mapping[str, Any]) -> Any:  # noqa: ANN401
    return _key(create_model(name, __base__=TomlTable, __doc__=description, **fields), description)


def _words(also: str) -> Any:  # noqa: ANN401
    """The type of a text that pages and FMUs show: printable characters, and those of `also`."""

    def refuse_control_characters(text: str) -> str:
        if all(character.isprintable() or character in also or character == " " for character in text):
            return text
        raise _refused(
            "allowed is text without control characters. In double quotes a backslash begins one: write a"
            " path in single quotes, 'D:\\bench\\front'"
        )

    return Annotated[str, AfterValidator(refuse_control_characters)]


# ---- tables of the file ----


def _history_type(variable: SettableVariable) -> Any:  # noqa: ANN401
    """An input over time: a constant, or a table of times and values."""
    instant = _entry("time", "s", "Time")

    def convert(value: object) -> dict[str, Any]:
        if not isinstance(value, dict):
            return {"time": (0.0,), "value": (to_number(value, variable),)}
        found = {**value}
        unit = found.pop("unit", None)
        if not (unit is None or isinstance(unit, str)):
            raise _refused("unit: allowed is text in quotes")
        for name, kind in (("time", instant), ("value", variable)):
            if name in found:
                found[name] = _numbers(name, found[name], kind, unit if name == "value" else None)
        return found

    fields: dict[str, Any] = {
        "time": (tuple[float, ...], Field(default=(), description="Times [s]")),
        "value": (tuple[float, ...], Field(default=(), description=f"Values [{variable.unit}] at the times")),
        "shape": (str, Field(default="linear", description="Between the points: linear or smooth")),
        "derivative_of": (str, Field(default="", description="The input of which this is the derivative")),
    }
    model = create_model(f"History_{variable.name}", __base__=TomlTable, **fields)
    points = {"type": "array", "items": {"type": ["number", "string"]}}
    table = {
        "type": "object",
        "additionalProperties": False,
        "properties": {
            "time": points,
            "value": points,
            "unit": {"type": "string", "description": "Unit of all values, such as deg"},
            "shape": {"enum": list(SHAPES)},
            "derivative_of": {"type": "string"},
        },
    }
    schema = WithJsonSchema({"anyOf": [*_number_schema(variable)["anyOf"], table]})
    return Annotated[model, BeforeValidator(convert), schema]


def _numbers(name: str, values: object, variable: SettableVariable, unit: str | None) -> tuple[float, ...]:
    if not isinstance(values, list):
        raise _refused(f"{name}: allowed is a list of numbers")
    found = []
    for place, value in enumerate(values, 1):
        plain = isinstance(value, int | float) and not isinstance(value, bool)
        try:
            found.append(to_number(f"{value} {unit}" if unit and plain else value, variable))
        except PydanticCustomError as error:
            hint = unit_warning(f"limits.{variable.name}", value) or ""
            text = f"{name}, number {place} of {len(values)}, {value!r}: {error.message()}"
            text += f"; {hint.partition(': ')[2]}" if hint else ""
            raise _refused(text) from None
    return tuple(found)


def _range_type(variable: SettableVariable) -> Any:  # noqa: ANN401
    def convert(value: object) -> tuple[float, ...]:
        if not isinstance(value, list) or len(value) != 2:
            raise _refused("allowed are two numbers: [low, high]")
        return _numbers(variable.name, value, variable, None)

    pair = {"type": "array", "items": _number_schema(variable), "minItems": 2, "maxItems": 2}
    return Annotated[tuple[float, ...], BeforeValidator(convert), WithJsonSchema(pair)]


def _scenario_fields() -> dict[str, Any]:
    inputs = {
        name: _key(_history_type(variable), f"{variable.description} [{variable.unit}]")
        for name, variable in all_inputs().items()
    }
    fields = {entry.name: _field(entry) for entry in TIMES}
    return fields | {"inputs": _table("Inputs", "Inputs over time: numbers, or {time, value, shape}", inputs)}


def defaults() -> dict[str, Any]:
    """Defaults of the tables that have a class of dualcam.design, by their keys, in SI units: those of the
    class. A key without default is left out."""
    from dualcam.design import HelicalSpring, Limits, Pin, Roller

    tables = {"pin": Pin, "roller": Roller, "helical_spring": HelicalSpring, "limits": Limits}
    return {
        f"{table}.{field.name}": field.default
        for table, of in tables.items()
        for field in dataclasses.fields(of)
        if field.default is not dataclasses.MISSING and field.default is not None
    }


def _defaulted(table: str, entries: Sequence[SettableVariable]) -> dict[str, Any]:
    """The fields of a table, with the defaults of its class."""
    return {entry.name: _field(entry, defaults().get(f"{table}.{entry.name}")) for entry in entries}


def _helical_spring_fields() -> dict[str, Any]:
    from dualcam.design.spring_steel import STRENGTHS

    grade = "Grade of the wire by EN 10270-1: SL, SM, DM, SH or DH"
    more = {
        "grade": _key(str, grade, enum=list(STRENGTHS)),
        "shot_peened": _key(bool, "Whether the spring is shot-peened", False),
        "guided": _key(bool, "Whether a rod or a sleeve guides the spring: then it cannot buckle", False),
    }
    return _defaulted("helical_spring", HELICAL_SPRING) | more


def _limit_fields() -> dict[str, Any]:
    given = defaults()
    lead, words = list(given["limits.lead_angle"]), "Least and greatest lead angle [rad]"
    return {
        "lead_angle": _key(_range_type(LEAD_ANGLE), words, lead),
        "pressure": _field(PRESSURE, given["limits.pressure"]),
        "self_locking": _key(bool, "Whether a contact may lock itself", given["limits.self_locking"]),
        **_defaulted("limits", LIMITS),
    }


GROUPS = {
    "cam1": "Cam 1, which stands still",
    "cam2": "Cam 2, which turns with the shaft",
    "spring": "The spring: preload + stiffness z + stiffness2 z^2 + stiffness3 z^3",
    "damper": "The damper on the follower",
    "inertia": "Masses and moments of inertia",
    "shaft": "The shaft of cam 2",
    "stop": "The end stops of cam 2",
    "initial": "Start of the forward model",
}


@cache
def design_model() -> type[BaseModel]:
    """The pydantic model of a whole design file."""
    groups: dict[str, dict[str, Any]] = {}
    top: dict[str, Any] = {
        "title": _key(_words(""), "A title, for reports"),
        "description": _key(_words("\n\r\t"), "What the design is for"),
    }
    for name, variable in all_parameters().items():
        group, _, rest = name.rpartition(".")
        if group:
            groups.setdefault(group, {})[rest] = _field(variable)
        else:
            top[name] = _field(variable)
    groups["spring"] |= {entry.name: _field(entry) for entry in SPRING}
    for group, fields in groups.items():
        top[group] = _table(group.capitalize(), GROUPS.get(group, group), fields)
    top["scenario"] = _table("Scenario", "What is simulated", _scenario_fields())
    pin = "The pin, or a roller on the pin: what runs in the groove, and its material"
    top["pin"] = _table("Pin", pin, _defaulted("pin", PIN))
    bearing = "Bearing of a roller with the radius of [pin]"
    top["roller"] = _table("Roller", bearing, _defaulted("roller", ROLLER))
    wire = "Wire and coil of the spring, for stress and fatigue"
    top["helical_spring"] = _table("HelicalSpring", wire, _helical_spring_fields())
    top["limits"] = _table("Limits", "What `dualcam check` allows", _limit_fields())
    top["study"] = _key(dict[str, Any], "A parameter study: plan, results, plots")
    return create_model("DesignFile", __base__=TomlTable, __doc__="A design of the dual cam", **top)


def json_schema() -> dict[str, Any]:
    """JSON Schema of design files, for editors."""
    schema = design_model().model_json_schema()
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | schema


def known_keys() -> dict[str, str]:
    """All keys, dotted, with their descriptions; inputs as `scenario.inputs.tau`."""
    found: dict[str, str] = {}

    def add(prefix: str, model: type[BaseModel]) -> None:
        for name, field in model.model_fields.items():
            key = f"{prefix}{name}"
            found[key] = field.description or ""
            kind: Any = field.annotation
            is_table = isinstance(kind, type) and issubclass(kind, TomlTable)
            if is_table and not kind.__name__.startswith("History_"):
                add(f"{key}.", kind)

    add("", design_model())
    return found
