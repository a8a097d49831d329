"""Parameters and inputs of this package's FMUs, from their modelDescription.xml: the source of all limits."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType

from dualcam.fmi.library import fmu_path
from dualcam.fmi.model_description import Scalar, Variable, read_model_description

KINDS = {"real": float, "integer": int, "boolean": bool, "string": str}


@dataclass(frozen=True)
class SettableVariable:
    """One parameter or input of an FMU."""

    name: str
    kind: type[float] | type[int] | type[bool] | type[str]
    causality: str
    unit: str  # as the FMU writes it, "1" without a unit
    least: float
    greatest: float
    start: Scalar
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


@cache
def _variables(model: str) -> Mapping[str, SettableVariable]:
    read = read_model_description(fmu_path(model)).variables
    found = [_settable(one) for one in read if one.causality in ("parameter", "input")]
    return MappingProxyType({variable.name: variable for variable in found})


def _settable(read: Variable) -> SettableVariable:
    kind = KINDS[read.kind]
    return SettableVariable(
        read.name,
        kind,
        read.causality,
        read.unit or ("1" if kind is float else ""),
        -math.inf if read.min is None else float(read.min),
        math.inf if read.max is None else float(read.max),
        "" if read.start is None else read.start,
        read.description,
    )


def parameters_of(model: str) -> Mapping[str, SettableVariable]:
    """The parameters of one model by name, in the FMU's order."""
    return {name: v for name, v in _variables(model).items() if v.causality == "parameter"}


def unused(name: str, value: Scalar, model: str) -> str:
    """The warning about a parameter that only the other model has."""
    return f"{name} = {value} is not used: the {model} model has no such parameter"


def inputs_of(model: str) -> Mapping[str, SettableVariable]:
    """The inputs of one model by name, in the FMU's order."""
    return {name: v for name, v in _variables(model).items() if v.causality == "input"}


def all_parameters() -> Mapping[str, SettableVariable]:
    """The parameters of both models by name."""
    return {**parameters_of("forward"), **parameters_of("inverse")}


def all_inputs() -> Mapping[str, SettableVariable]:
    """The inputs of both models by name."""
    return {**inputs_of("forward"), **inputs_of("inverse")}
