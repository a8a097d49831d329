"""What a system of FMUs is made of, and what is wrong with it before it becomes a package: all at once."""

import math
import re
import tempfile
import warnings
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cached_property
from pathlib import Path
from types import UnionType

from dualcam.checking import check_design
from dualcam.checking.rules import EQUAL_RADII
from dualcam.common.archive import archive_bytes, read_members
from dualcam.common.unit_guards import unit_warning
from dualcam.design import Limits
from dualcam.design_file import DesignFile, Finding
from dualcam.errors import DesignError, DualcamError, DualcamWarning
from dualcam.export.changed import RESOURCES, is_own, restarted
from dualcam.fmi.library import source_path
from dualcam.fmi.model_description import ModelDescription, Scalar, Variable, read_model_description
from dualcam.fmi.variables import all_parameters

Value = float | int
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_-]*")
FMI_2_ALONE = "SSP 1.0 holds FMUs of FMI 2.0 for co-simulation: `dualcam export my.toml -o MyCam.fmu --fmi 2`"
# A component has no wishes about its cam: self-locking and any lead angle are allowed.
ALL_ALLOWED = Limits(lead_angle=(0.0, 0.5 * math.pi), self_locking=True)


@dataclass(frozen=True)
class Component:
    """An FMU with start values.

    Attributes
    ----------
    name
        Letters, digits, _ and -.
    fmu
        Path of the FMU, FMI 2.0; "forward" or "inverse" is this package's own.
    values
        Parameter -> start value, in the FMU's unit. An FMU of this project starts from these values in every
        master: the package holds a copy with them. Those of another FMU are a parameter set of the package
        alone, which FMPy's `simulate_ssp` does not read.
    """

    name: str
    fmu: Path
    values: Mapping[str, Value]

    def __post_init__(self) -> None:
        object.__setattr__(self, "fmu", source_path(self.fmu))

    @cached_property
    def members(self) -> Mapping[str, bytes] | None:
        """Of the FMU that starts from `values`; None where the FMU in `fmu` is packed as it is."""
        before = read_members(self.fmu) if self.values else {}
        after = restarted(before, self.values) if is_own(before) else before
        return None if after is before else after

    @property
    def resource(self) -> str:
        """The file of the FMU below resources."""
        return self.fmu.name if self.members is None else f"{self.name}.fmu"

    def content(self) -> bytes:
        """The FMU's file in the package."""
        return self.fmu.read_bytes() if self.members is None else archive_bytes(self.members)

    @cached_property
    def description(self) -> ET.Element:
        """The FMU's modelDescription.xml."""
        with zipfile.ZipFile(self.fmu) as archive:
            return ET.fromstring(archive.read("modelDescription.xml"))

    @cached_property
    def variables(self) -> dict[str, tuple[str, ET.Element]]:
        """Causality and type by name."""
        rows = self.description.iter("ScalarVariable")
        return {row.attrib["name"]: (row.attrib["causality"], row[0]) for row in rows}

    @cached_property
    def units(self) -> dict[str, dict[str, str]]:
        """Exponents of the base units by unit."""
        return {u.attrib["name"]: dict(u[0].attrib) for u in self.description.iter("Unit")}


@dataclass(frozen=True)
class SystemStructure:
    """Components and their connections, as System documents them."""

    name: str
    text: str
    components: tuple[Component, ...]
    connections: tuple[tuple[str, str], ...]
    step: float
    duration: float
    ports: tuple[str, ...] = ()


def check_system(system: SystemStructure) -> None:
    """DesignError with all problems of a system. Warnings about start values become Python warnings."""
    descriptions: dict[str, ModelDescription] = {}
    problems = list(_forms(system))
    problems = problems or [*_times(system), *_components(system, descriptions)]
    if not problems:  # what follows looks up components by their names
        check = _Ends(system, descriptions)
        problems = [*_values(system, descriptions), *check.connections(), *check.ports()]
    problems = problems or list(_files(system))
    found = [] if problems else [judged(each, descriptions[each.name]) for each in system.components]
    problems += [text for errors, _ in found for text in errors]
    if problems:
        raise DesignError("\n".join([f"the system {system.name!r} cannot be packed:", *problems]))
    for text in (text for _, doubts in found for text in doubts):
        warnings.warn(text, DualcamWarning, stacklevel=3)


def _forms(system: SystemStructure) -> Iterator[str]:
    """Components, connections and ports are lists of what belongs there."""
    if not _is_list(system.components, Component):
        yield f"components = {system.components!r}: allowed is a list of Component"
    elif not all(isinstance(component.values, Mapping) for component in system.components):
        yield "the values of a component: allowed is a dict of start values by name, such as {}"
    pairs = system.connections
    if not (_is_list(pairs, list | tuple) and all(len(one) == 2 and _is_list(one, str) for one in pairs)):
        yield (
            f'connections = {pairs!r}: allowed is a list of pairs, such as [("motor.tau", "cam.tau")]: one'
            " pair for each connection"
        )
    if not _is_list(system.ports, str):
        yield f'ports = {system.ports!r}: allowed is a list of "component.variable", such as ["cam.theta"]'


def _is_list(values: object, kind: type | UnionType) -> bool:
    return isinstance(values, list | tuple) and all(isinstance(value, kind) for value in values)


def _times(system: SystemStructure) -> Iterator[str]:
    for name in ("step", "duration"):
        value = getattr(system, name)
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
            yield f"{name} = {value!r}: allowed is a finite number > 0, in s"
            return
    if system.step > system.duration:
        yield f"step = {system.step!r} s: allowed is up to the duration, {system.duration!r} s"


def _components(system: SystemStructure, descriptions: dict[str, ModelDescription]) -> Iterator[str]:
    """Names and FMUs; the descriptions of the FMUs go to `descriptions`."""
    if not system.components:
        yield "components = (): allowed is one component or more"
    for component in system.components:
        name, file = component.name, component.fmu
        if not (isinstance(name, str) and NAME.fullmatch(name)):
            yield f"component {name!r}: allowed are names of letters, digits, _ and -, such as 'cam'"
        if name in descriptions:
            yield f"component {name!r} is given twice: give each component its own name"
        try:
            description = descriptions[name] = read_model_description(file)
        except DualcamError as error:
            yield f"component {name!r}: {error}"
            continue
        if description.fmi_major != 2 or description.co_simulation is None:
            yield f"component {name!r}: {file} is FMI {description.fmi_version}: {FMI_2_ALONE}"


def _values(system: SystemStructure, descriptions: dict[str, ModelDescription]) -> Iterator[str]:
    """Start values: known parameters, in their ranges."""
    for component in system.components:
        known = {variable.name: variable for variable in descriptions[component.name].variables}
        for name, value in component.values.items():
            end = f"{component.name}.{name}"
            if name not in known:
                parameters = [each for each in known if known[each].causality == "parameter"]
                yield f"{end}: {component.fmu.name} has no parameter {name}{_guess(name, parameters)}"
            elif known[name].causality != "parameter":
                yield f"{end} is no parameter (its causality is {known[name].causality}): leave it out"
            elif not _is_allowed(known[name], value):
                hint = (unit_warning(name, value) or "").partition(": ")[2]
                yield f"{end} = {value!r}: allowed is {_range(known[name])}{hint and '; '}{hint}"


def _files(system: SystemStructure) -> Iterator[str]:
    """Different FMUs have different names in the package."""
    files: dict[str, Path] = {}
    for component in system.components:
        file = component.fmu
        other = files.setdefault(component.resource, file)
        if other.resolve() != file.resolve():
            yield f"{file} and {other} have one name in the package: rename one of both files"


def _is_allowed(variable: Variable, value: object) -> bool:
    if not isinstance(value, int | float) or not math.isfinite(value):
        return False
    if variable.kind != "real" and value != int(value):
        return False
    low = -math.inf if variable.min is None else variable.min
    high = math.inf if variable.max is None else variable.max
    return low <= value <= high and variable.kind != "string"


def _range(variable: Variable) -> str:
    if variable.kind == "string":
        return "no text: a text is a start value of the FMU itself"
    low, high = variable.min, variable.max
    limits = [f"{word} {limit:g}" for word, limit in ((">=", low), ("<=", high)) if limit is not None]
    return " ".join(["a finite number" if variable.kind == "real" else "a whole number", *limits])


class _Ends:
    """Checks of what connections and ports name, "component.variable"."""

    def __init__(self, system: SystemStructure, descriptions: dict[str, ModelDescription]) -> None:
        self.system = system
        self.known = {
            f"{name}.{variable.name}": variable
            for name, description in descriptions.items()
            for variable in description.variables
        }
        self.units = {component.name: component.units for component in system.components}
        self.driven: dict[str, str] = {}  # input -> what drives it

    def connections(self) -> Iterator[str]:
        """Each from an output to an input, or to a tunable parameter, of equal kind and unit."""
        for output, reader in self.system.connections:
            unknown = [*self._unknown(output), *self._unknown(reader)]
            yield from unknown
            if not unknown:
                yield from self._connection(output, reader)

    def _connection(self, output: str, reader: str) -> Iterator[str]:
        said, start, end = f"connection {output} -> {reader}", self.known[output], self.known[reader]
        if start.causality != "output":
            yield f"{said}: {output} is {_kind(start)}, allowed is an output"
        if not _is_driven(end):
            yield f"{said}: {reader} is {_kind(end)}, allowed is an input or a tunable parameter"
        if start.kind != end.kind:
            yield f"{said}: {output} is {start.type} and {reader} is {end.type}: allowed are equal types"
        elif start.unit and end.unit and self._unit(output) != self._unit(reader):
            yield f"{said}: the unit {start.unit} is not {end.unit}, and not every master converts units"
        yield from self._drives(reader, output)

    def ports(self) -> Iterator[str]:
        """Inputs and outputs, each with a name of its own; an input has no other source."""
        names: dict[str, str] = {}
        for port in self.system.ports:
            unknown = list(self._unknown(port))
            yield from unknown
            if unknown:
                continue
            variable = self.known[port]
            if variable.causality not in ("input", "output"):
                yield f"port {port} is {_kind(variable)}: allowed is an input or an output"
            if variable.causality == "input":
                yield from self._drives(port, "the system")
            if variable.name in names:
                yield f"ports {names[variable.name]} and {port} have one name: give one of both"
            names[variable.name] = port

    def _drives(self, reader: str, source: str) -> Iterator[str]:
        if reader in self.driven:
            yield f"{reader} has two sources, {self.driven[reader]} and {source}: allowed is one"
        self.driven[reader] = source

    def _unit(self, end: str) -> object:
        """The unit by its base units, by which units of different names are equal."""
        unit = self.known[end].unit or ""
        return self.units[end.partition(".")[0]].get(unit, unit)

    def _unknown(self, end: str) -> Iterator[str]:
        if end not in self.known:
            component, _, variable = end.partition(".")
            if component not in self.units:
                yield f"{end}: there is no component {component}{_guess(component, self.units)}"
            else:
                names = {one.name for name, one in self.known.items() if name.startswith(f"{component}.")}
                yield f"{end}: there is no such variable{_guess(variable, names)}"


def _is_driven(variable: Variable) -> bool:
    is_tunable = variable.causality == "parameter" and variable.variability == "tunable"
    return variable.causality == "input" or is_tunable


def _kind(variable: Variable) -> str:
    fixed = "fixed " if variable.causality == "parameter" and not _is_driven(variable) else ""
    kind = f"{fixed}{variable.causality}"
    return f"{'an' if kind[0] in 'aeiou' else 'a'} {kind}"


def _guess(name: str, known: Iterable[str]) -> str:
    near = get_close_matches(name, list(known), n=1)
    return f": did you mean {near[0]}?" if near else ""


def judged(component: Component, description: ModelDescription) -> list[list[str]]:
    """Errors and warnings of `dualcam check` in an FMU of this project, but for [limits] and equal radii."""
    if component.members is None:
        return [[], []]
    with tempfile.TemporaryDirectory() as folder:
        for name, content in component.members.items():
            if name.startswith(RESOURCES) and name.endswith(".csv"):
                (Path(folder) / Path(name).name).write_bytes(content)
        verdict = check_design(_design(component, description, Path(folder)))
    return [
        [f"component {component.name!r}: {finding}" for finding in findings if finding.kind != EQUAL_RADII]
        for findings in (verdict.errors, verdict.warnings)
    ]


def _design(component: Component, description: ModelDescription, folder: Path) -> DesignFile:
    """The design of a component's FMU with its values; the tables are in the folder."""
    known = {variable.name: variable for variable in description.variables}
    start: dict[str, Scalar] = {}
    for name in all_parameters():
        told = known[name].start if name in known else None
        if told is not None:
            start[name] = str(folder / told) if isinstance(told, str) and told else told
    model = "forward" if known["tau"].causality == "input" else "inverse"
    found = [(name, value, unit_warning(name, value)) for name, value in component.values.items()]
    strange = [Finding("warning", name, value, text, kind="unit") for name, value, text in found if text]
    parameters = start | dict(component.values)
    return DesignFile(component.fmu, parameters, model, limits=ALL_ALLOWED, warnings=tuple(strange))
