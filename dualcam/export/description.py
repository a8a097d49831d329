"""modelDescription.xml of an exported FMU: the text of the original with other values of some attributes.

Nothing else changes, neither the order of elements nor the model structure.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from xml.parsers import expat
from xml.sax.saxutils import escape

from dualcam.errors import ExportError
from dualcam.fmi.model_description import Scalar

AGAIN = "the project's FMU is of another version of dualcam: install dualcam again, or build the FMUs again"

TAG = re.compile(rb'<[^\s/>]+(?:\s+[^\s=]+\s*=\s*"[^"]*")*\s*/?>')
TOKEN = {2: "guid", 3: "instantiationToken"}


@dataclass(frozen=True)
class Tag:
    """A start tag, at these bytes of the document."""

    name: str
    attributes: dict[str, str]
    begin: int
    end: int


@dataclass(frozen=True)
class VariableTag:
    """A variable of either version of FMI; `tag` is the one with the start value."""

    name: str
    reference: int
    type: str  # "Real", "Integer", "Boolean", "String", as FMI 2.0 names them
    causality: str
    unit: str | None
    tag: Tag

    @property
    def start(self) -> str | None:
        """The start value as the document has it."""
        return self.tag.attributes.get("value" if self.tag.name == "Start" else "start")


class Description:
    """A modelDescription.xml of this project."""

    def __init__(self, xml: bytes) -> None:
        self.xml = xml
        self.tags = _tags(xml)
        self.root = self.tags[0]
        self.fmi = int(self.root.attributes["fmiVersion"][0])
        self.variables = {v.name: v for v in _variables(self.tags, self.fmi)}

    @property
    def identifier(self) -> str:
        """The model's C identifier."""
        return next(t.attributes["modelIdentifier"] for t in self.tags if t.name == "CoSimulation")

    @property
    def token(self) -> str:
        """GUID; in FMI 3.0 the instantiation token."""
        return self.root.attributes[TOKEN[self.fmi]]

    @property
    def display_units(self) -> dict[str, tuple[str, float]]:
        """Unit -> the unit in which a tool shows the value, and its factor."""
        found, unit = {}, ""
        for tag in self.tags:
            if tag.name == "Unit":
                unit = tag.attributes["name"]
            elif tag.name == "DisplayUnit":
                found[unit] = tag.attributes["name"], float(tag.attributes["factor"])
        return found

    def edited(
        self,
        root: Mapping[str, str],
        identifier: str,
        start: Mapping[str, Scalar],
        stop: float | None = None,
    ) -> bytes:
        """The document with other attributes of the root, C identifier, start values and, unless None, stop
        time [s] of the default experiment.
        """
        edits = [(self.root, dict(root))]
        for tag in self.tags:
            if tag.name == "DefaultExperiment" and stop is not None:
                edits.append((tag, {"stopTime": number_text(float(stop))}))
            if tag.name in ("CoSimulation", "ModelExchange"):
                edits.append((tag, {"modelIdentifier": identifier}))
        for name, value in start.items():
            tag = self.variables[name].tag
            edits.append((tag, {"value" if tag.name == "Start" else "start": number_text(value)}))
        xml = self.xml
        for tag, attributes in sorted(edits, key=lambda edit: edit[0].begin, reverse=True):
            xml = xml[: tag.begin] + _edited_tag(xml[tag.begin : tag.end], attributes) + xml[tag.end :]
        return xml


def number_text(value: Scalar) -> str:
    """A value as XML writes it: a number with the fewest digits that read back as the same number."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        return f"{value:.0f}" if abs(value) < 1e15 and value == int(value) else repr(value)
    return str(value)


def typed(variable: VariableTag, value: Scalar) -> Scalar:
    """A value that the FMU accepts, in the Python type of the variable."""
    return {"Real": float, "Integer": int, "Boolean": bool, "String": str}[variable.type](value)


def model_identifier(name: str) -> str:
    """The C identifier of a model, which FMI demands for the names of binaries and functions: `name` with "_"
    in place of each character that is not allowed, and before a digit at the beginning.

    ExportError for a name without a letter from a to z or digit.

    Examples
    --------
    >>> model_identifier("my cam")
    'my_cam'
    """
    if not re.search(r"[A-Za-z0-9]", name):
        raise ExportError(f"name {name!r}: allowed is a name with at least one letter from a to z or digit")
    identifier = re.sub(r"[^A-Za-z0-9_]", "_", name)
    return f"_{identifier}" if identifier[0].isdigit() else identifier


def _edited_tag(tag: bytes, attributes: Mapping[str, str]) -> bytes:
    for name, value in attributes.items():
        head, before, rest = tag.partition(f' {name}="'.encode())
        if not before:
            raise ExportError(f"modelDescription.xml without {name} in {tag.decode()}: {AGAIN}")
        tag = head + before + escape(value, {'"': "&quot;"}).encode() + rest[rest.index(b'"') :]
    return tag


def _tags(xml: bytes) -> list[Tag]:
    """All start tags in order."""
    found: list[Tag] = []
    parser = expat.ParserCreate()

    def start(name: str, attributes: dict[str, str]) -> None:
        match = TAG.match(xml, parser.CurrentByteIndex)
        if match is None:
            raise ExportError(f"modelDescription.xml: the tag {name} cannot be read: {AGAIN}")
        found.append(Tag(name, attributes, *match.span()))

    parser.StartElementHandler = start
    parser.Parse(xml, True)
    return found


def _variables(tags: list[Tag], fmi: int) -> list[VariableTag]:
    """In FMI 2.0 the tag after ScalarVariable has type and start value. In FMI 3.0 the tag of a variable is
    named after the type, and the start value of a String has a tag of its own."""
    types = {"Float64": "Real", "Int32": "Integer", "Boolean": "Boolean", "String": "String"}
    found = []
    for tag, inner in pairwise([*tags, tags[-1]]):
        a = tag.attributes
        if tag.name == "ScalarVariable":
            kind, unit, place = inner.name, inner.attributes.get("unit"), inner
        elif fmi == 3 and tag.name in types:
            kind, unit, place = types[tag.name], a.get("unit"), inner if inner.name == "Start" else tag
        else:
            continue
        found.append(VariableTag(a["name"], int(a["valueReference"]), kind, a["causality"], unit, place))
    return found
