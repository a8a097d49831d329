"""The modelDescription.xml of an FMU of FMI 2.0 or FMI 3.0, read into typed objects."""

import xml.etree.ElementTree as ElementTree
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from dualcam.common.entries import repeated
from dualcam.errors import FmuError

Scalar = float | int | bool | str
Kind = Literal["real", "integer", "boolean", "string", "binary", "clock"]

XML = "modelDescription.xml"
KINDS: dict[str, Kind] = {
    "Real": "real", "Float64": "real", "Float32": "real",
    "Integer": "integer", "Enumeration": "integer",
    "Int8": "integer", "Int16": "integer", "Int32": "integer", "Int64": "integer",
    "UInt8": "integer", "UInt16": "integer", "UInt32": "integer", "UInt64": "integer",
    "Boolean": "boolean", "String": "string", "Binary": "binary", "Clock": "clock",
}  # fmt: skip
TRUE = ("true", "1")

# What `initial` is where the XML does not say: FMI 2.0, section 2.2.7, and FMI 3.0, section 2.4.7.5.
PARAMETERS = ("parameter", "structuralParameter")


@dataclass(frozen=True)
class Variable:
    """One variable of an FMU.

    Attributes
    ----------
    name, description : str
    value_reference : The number by which FMI calls name the variable.
    type : As in the XML: "Real", "Integer" and so on in FMI 2.0; "Float64", "Int32" and so on in FMI 3.0.
    causality, variability, initial
        FMI's words, such as "parameter", "tunable", "exact"; `initial` is None for the independent variable.
    start : Start value by type. None without start value, and of arrays and binary variables.
    min, max, unit
        Limits of allowed values, and unit; those of the declared type where the variable itself has none.
    declared_type : Name of the declared type.
    is_array : FMI 3.0 has arrays.
    """

    name: str
    value_reference: int
    type: str
    causality: str
    variability: str
    initial: str | None = None
    start: Scalar | None = None
    min: float | int | None = None
    max: float | int | None = None
    unit: str | None = None
    description: str = ""
    declared_type: str | None = None
    is_array: bool = False

    @property
    def kind(self) -> Kind:
        """The kind of value, which is the same in FMI 2.0 and FMI 3.0."""
        return KINDS[self.type]


@dataclass(frozen=True)
class Interface:
    """What the FMU can do in one use; a capability that the XML does not name is absent."""

    model_identifier: str
    needs_execution_tool: bool = False
    allows_one_instance: bool = False  # in one process
    can_save_state: bool = False
    can_serialize_state: bool = False
    provides_directional_derivatives: bool = False
    can_handle_variable_steps: bool = False  # these three: co-simulation
    can_interpolate_inputs: bool = False
    max_output_derivative_order: int = 0


@dataclass(frozen=True)
class DefaultExperiment:
    """The run that the FMU proposes. [s], but `tolerance`, which is relative."""

    start_time: float | None = None
    stop_time: float | None = None
    step_size: float | None = None
    tolerance: float | None = None


@dataclass(frozen=True)
class ModelDescription:
    """What an FMU says about itself.

    Attributes
    ----------
    fmi_version : "2.0", "3.0", ...
    model_name, description : str
    guid : Identity of the model; FMI 3.0 says instantiation token.
    variables : In the order of the XML.
    co_simulation, model_exchange : None: the FMU has no such use.
    default_experiment : DefaultExperiment
    state_count, event_indicator_count
        Numbers of continuous states and of event indicators, for model exchange.
    """

    fmi_version: str
    model_name: str
    guid: str
    variables: tuple[Variable, ...]
    description: str = ""
    co_simulation: Interface | None = None
    model_exchange: Interface | None = None
    default_experiment: DefaultExperiment = DefaultExperiment()
    state_count: int = 0
    event_indicator_count: int = 0

    @property
    def fmi_major(self) -> int:
        """2 or 3."""
        return int(self.fmi_version.partition(".")[0])


def read_model_description(path: str | Path) -> ModelDescription:
    """Read the modelDescription.xml of an FMU.

    `path`: an FMU of FMI 2.0 or FMI 3.0. FmuError for anything else.

    Examples
    --------
    >>> from dualcam.fmi import fmu_path, read_model_description
    >>> description = read_model_description(fmu_path("forward"))
    >>> description.model_name, description.fmi_version
    ('DualCamForward', '2.0')
    >>> next(variable.unit for variable in description.variables if variable.name == "tau")
    'N.m'
    """
    if not isinstance(path, str | Path):
        raise FmuError(f"FMU {path!r}: allowed is the path of an FMU (str or Path)")
    path = Path(path)
    if not path.is_file():
        raise FmuError(
            f"there is no file {path}: give the path of an FMU, or one of this package's own by its name,"
            ' "forward" or "inverse"'
        )
    try:
        with zipfile.ZipFile(path) as archive:
            content = archive.read(XML)
    except (OSError, KeyError, zipfile.BadZipFile, zlib.error, RuntimeError, NotImplementedError) as error:
        raise FmuError(f"{path} is no FMU, a ZIP archive with a {XML}: {error}") from error
    try:
        return parse_model_description(content)
    except FmuError as error:
        raise FmuError(f"{path}: {error}") from error


def parse_model_description(content: str | bytes) -> ModelDescription:
    """The description in the text of a modelDescription.xml. FmuError if there is none of FMI 2.0 or 3.0."""
    try:
        root = ElementTree.fromstring(content)
    except ElementTree.ParseError as error:
        raise FmuError(f"no valid {XML}: {error}") from error
    if root.tag != "fmiModelDescription":
        raise FmuError(f"no valid {XML}: the document is a <{root.tag}>, allowed is <fmiModelDescription>")
    version = root.get("fmiVersion")
    if version is None:
        raise FmuError(f"no valid {XML}: attribute 'fmiVersion' is missing")
    if version != "2.0" and not version.startswith("3."):
        raise FmuError(f"the FMU is of FMI {version}: allowed are 2.0 and 3.0")
    try:
        return _parsed(root, version)
    except KeyError as error:
        raise FmuError(f"no valid {XML}: attribute {error} is missing") from error
    except (ValueError, OverflowError) as error:  # of a number, or an FmuError of this file
        raise FmuError(f"no valid {XML}: {error}") from error


def _parsed(root: ElementTree.Element, version: str) -> ModelDescription:
    read = _read_2 if version == "2.0" else _read_3
    token = "guid" if version == "2.0" else "instantiationToken"
    types = _declared_types(root)
    variables = tuple(one for element in root.iterfind("ModelVariables/*") for one in read(element, types))
    for name in repeated(variable.name for variable in variables):
        raise FmuError(f"variable {name} is there twice")
    uses = {use: _interface(root.find(use)) for use in ("CoSimulation", "ModelExchange")}
    rates = "Derivatives/Unknown" if version == "2.0" else "ContinuousStateDerivative"
    states = root.findall(f"ModelStructure/{rates}")
    indicators = len(root.findall("ModelStructure/EventIndicator"))  # of FMI 3.0
    return ModelDescription(
        fmi_version=version,
        model_name=root.attrib["modelName"],
        guid=root.attrib[token],
        variables=variables,
        description=root.get("description", ""),
        co_simulation=uses["CoSimulation"],
        model_exchange=uses["ModelExchange"],
        default_experiment=_experiment(root.find("DefaultExperiment")),
        state_count=len(states),
        event_indicator_count=indicators or int(root.get("numberOfEventIndicators", 0)),
    )


def _interface(element: ElementTree.Element | None) -> Interface | None:
    if element is None:
        return None

    def has(*names: str) -> bool:
        return any(element.get(name) in TRUE for name in names)

    return Interface(
        element.attrib["modelIdentifier"],
        needs_execution_tool=has("needsExecutionTool"),
        allows_one_instance=has("canBeInstantiatedOnlyOncePerProcess"),
        can_save_state=has("canGetAndSetFMUstate", "canGetAndSetFMUState"),
        can_serialize_state=has("canSerializeFMUstate", "canSerializeFMUState"),
        provides_directional_derivatives=has(
            "providesDirectionalDerivative", "providesDirectionalDerivatives"
        ),
        can_handle_variable_steps=has("canHandleVariableCommunicationStepSize"),
        can_interpolate_inputs=has("canInterpolateInputs"),
        max_output_derivative_order=int(element.get("maxOutputDerivativeOrder", 0)),
    )


def _experiment(element: ElementTree.Element | None) -> DefaultExperiment:
    given = {} if element is None else element.attrib
    names = ("startTime", "stopTime", "stepSize", "tolerance")
    return DefaultExperiment(*(float(given[name]) if name in given else None for name in names))


Attributes = dict[str, str]


def _declared_types(root: ElementTree.Element) -> dict[str, Attributes]:
    """Attributes of each declared type by its name. FMI 2.0 has them in a child, FMI 3.0 in the element."""
    found = {}
    for element in root.iterfind("TypeDefinitions/*"):
        inner = element[0] if element.tag == "SimpleType" and len(element) else element
        found[element.attrib["name"]] = dict(inner.attrib)
    return found


def _read_2(element: ElementTree.Element, types: dict[str, Attributes]) -> list[Variable]:
    name = element.attrib["name"]
    typed = next((child for child in element if child.tag in KINDS), None)
    if typed is None:
        raise FmuError(f"variable {name} has no type")
    return [_variable(name, typed.tag, element.attrib | typed.attrib, types, "continuous")]


def _read_3(element: ElementTree.Element, types: dict[str, Attributes]) -> list[Variable]:
    """The variable and its aliases, which have names of their own."""
    name, kind = element.attrib["name"], KINDS.get(element.tag)
    if kind is None:
        raise FmuError(f"variable {name} has the type {element.tag}: allowed are {', '.join(KINDS)}")
    given = dict(element.attrib)
    is_array = element.find("Dimension") is not None
    first = element.find("Start")
    if first is not None and kind == "string":
        given["start"] = first.attrib["value"]
    variability = "continuous" if kind == "real" else "discrete"
    own = _variable(name, element.tag, given, types, variability, is_array)
    aliases = [
        _variable(alias.attrib["name"], element.tag, given | alias.attrib, types, variability, is_array)
        for alias in element.findall("Alias")
    ]
    return [own, *aliases]


def _variable(
    name: str,
    type_name: str,
    given: Attributes,
    types: dict[str, Attributes],
    usual_variability: str,
    is_array: bool = False,
) -> Variable:
    declared = given.get("declaredType")
    if declared is not None and declared not in types:
        raise FmuError(f"variable {name} has the declared type {declared}, which is not defined")
    inherited = types[declared] if declared is not None else {}
    causality = given.get("causality", "local")
    variability = given.get("variability") or (
        "fixed" if causality in (*PARAMETERS, "calculatedParameter") else usual_variability
    )
    usual_initial = None if causality == "independent" else "calculated"
    if causality in (*PARAMETERS, "input") or (usual_initial and variability == "constant"):
        usual_initial = "exact"

    def value(attribute: str) -> Scalar | None:
        text = given.get(attribute, inherited.get(attribute) if attribute != "start" else None)
        return None if text is None or is_array else _value(name, attribute, KINDS[type_name], text)

    def number(attribute: str) -> float | int | None:
        limit = value(attribute)
        return None if isinstance(limit, str) else limit

    return Variable(
        name=name,
        value_reference=int(given["valueReference"]),
        type=type_name,
        causality=causality,
        variability=variability,
        initial=given.get("initial") or usual_initial,
        start=value("start"),
        min=number("min"),
        max=number("max"),
        unit=given.get("unit", inherited.get("unit")),
        description=given.get("description", ""),
        declared_type=declared,
        is_array=is_array,
    )


def _value(name: str, attribute: str, kind: Kind, text: str) -> Scalar | None:
    """The value of an attribute by the variable's type."""
    if kind == "string":
        return text
    try:
        if kind == "real":
            return float(text)
        if kind == "integer":
            return int(text)
    except ValueError:
        raise FmuError(f"variable {name}: {attribute} = {text!r} is no {kind} number") from None
    if kind == "boolean":
        return text.strip() in TRUE
    return None
