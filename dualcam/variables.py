"""The variables of the FMUs, from the modelDescription.xml inside: the one source of names and limits."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType
from xml.etree import ElementTree

from dualcam.errors import FmuError
from dualcam.library import fmu_path

MODELS = ("forward", "inverse")
TYPES = {"Real": float, "Integer": int, "Boolean": bool, "String": str}

Value = float | int | bool | str


@dataclass(frozen=True)
class Variable:
    """One parameter or input of an FMU."""

    name: str
    kind: type[float] | type[int] | type[bool] | type[str]
    causality: str
    unit: str  # as the FMU writes it, "1" without a unit
    least: float
    greatest: float
    start: Value
    description: str

    def allowed(self) -> str:
        """The allowed values in words, with the unit."""
        if self.kind is bool:
            return "true or false"
        if self.kind is str:
            return "text in quotes"
        return f"{self._range()}{self.in_unit}"

    @property
    def in_unit(self) -> str:
        """The unit in a sentence, empty for a plain number."""
        return "" if self.unit in ("1", "") else f" in {self.unit}"

    def _range(self) -> str:
        what = "a whole number" if self.kind is int else "a number"
        low, high = math.isfinite(self.least), math.isfinite(self.greatest)
        if low and high:
            return f"{what} from {self.least:.6g} to {self.greatest:.6g}"
        if low:
            return f"{what} >= {self.least:.6g}"
        return f"{what} <= {self.greatest:.6g}" if high else f"a finite {what[2:]}"


def _value(kind: type, text: str) -> Value:
    return text == "true" if kind is bool else kind(text)


def _variable(element: ElementTree.Element) -> Variable:
    (content,) = (child for child in element if child.tag in TYPES)
    kind = TYPES[content.tag]
    unit = content.get("unit", "1" if kind is float else "")
    return Variable(
        element.get("name", ""),
        kind,
        element.get("causality", ""),
        unit,
        float(content.get("min", "-inf")),
        float(content.get("max", "inf")),
        _value(kind, content.get("start", "")),
        element.get("description", ""),
    )


@cache
def _variables(model: str) -> Mapping[str, Variable]:
    path = fmu_path(model)
    try:
        with zipfile.ZipFile(path) as archive:
            root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    except (OSError, KeyError, zipfile.BadZipFile, ElementTree.ParseError) as error:
        raise FmuError(f"{path} is no FMU with a modelDescription.xml: {error}") from error
    found = [
        _variable(element)
        for element in root.iter("ScalarVariable")
        if element.get("causality") in ("parameter", "input")
    ]
    return MappingProxyType({variable.name: variable for variable in found})


def parameters_of(model: str) -> Mapping[str, Variable]:
    """The parameters of one model by name, in the FMU's order."""
    return {name: v for name, v in _variables(model).items() if v.causality == "parameter"}


def inputs_of(model: str) -> Mapping[str, Variable]:
    """The inputs of one model by name, in the FMU's order."""
    return {name: v for name, v in _variables(model).items() if v.causality == "input"}


def all_parameters() -> Mapping[str, Variable]:
    """The parameters of both models by name."""
    return {**parameters_of("forward"), **parameters_of("inverse")}


def all_inputs() -> Mapping[str, Variable]:
    """The inputs of both models by name."""
    return {**inputs_of("forward"), **inputs_of("inverse")}
