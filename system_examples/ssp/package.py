"""Systems of FMUs as SSP packages (SSP 1.0).

A package holds SystemStructure.ssd (components, connectors with units, connections), and under resources
the FMUs and, for each component, its start values (.ssv). All parameter sets have one name, START: ecos
applies the sets of a name, libcosim the first of each component.
"""

from __future__ import annotations

import io
import os
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import build_fmu  # the folder fmu_src/tools is on PYTHONPATH, see build.sh

FOLDER = build_fmu.BUILD / "ssp"
START = "start"
NAMES = {
    kind: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for kind, name in (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"))
}
NAMES["osp"] = "http://opensimulationplatform.com/SSP/OSPAnnotations"
for prefix, address in NAMES.items():
    ET.register_namespace(prefix, address)

Value = float | int


def tag(name: str) -> str:
    """`ssd:Component` as ElementTree wants it."""
    prefix, local = name.split(":")
    return f"{{{NAMES[prefix]}}}{local}"


def add(parent: ET.Element, name: str, /, **attributes: str) -> ET.Element:
    """A new element below `parent`."""
    return ET.SubElement(parent, tag(name), attributes)


def document(root: ET.Element) -> bytes:
    """The XML file."""
    ET.indent(root)
    file = io.BytesIO()
    ET.ElementTree(root).write(file, encoding="UTF-8", xml_declaration=True)
    return file.getvalue() + b"\n"


def split(end: str) -> tuple[str, str]:
    """Component and variable of `cam.energy.spring`."""
    component, _, variable = end.partition(".")
    return component, variable


@dataclass(frozen=True)
class Component:
    """An FMU with start values."""

    name: str
    fmu: Path
    values: Mapping[str, Value]  # start values of parameters

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
class System:
    """Components and their connections."""

    name: str
    text: str
    components: tuple[Component, ...]
    connections: tuple[tuple[str, str], ...]  # output and input, as component.variable
    step: float  # s, communication step
    duration: float  # s

    @property
    def path(self) -> Path:
        return FOLDER / f"{self.name}.ssp"

    def write(self) -> Path:
        """The package."""
        members = {"SystemStructure.ssd": document(structure(self))}
        for component in self.components:
            members[f"resources/{component.fmu.name}"] = component.fmu.read_bytes()
            members[f"resources/{component.name}.ssv"] = document(parameters(component))
        self.path.parent.mkdir(parents=True, exist_ok=True)
        unfinished = self.path.with_suffix(f".{os.getpid()}")
        build_fmu.write_archive(unfinished, members)
        unfinished.replace(self.path)
        return self.path


def add_units(root: ET.Element, prefix: str, units: Mapping[str, dict[str, str]]) -> None:
    """The units by their exponents of base units."""
    element = add(root, f"{prefix}:Units")
    for name, base in sorted(units.items()):
        add(add(element, "ssc:Unit", name=name), "ssc:BaseUnit", **base)


def structure(system: System) -> ET.Element:
    """SystemStructure.ssd."""
    root = ET.Element(tag("ssd:SystemStructureDescription"), name=system.name, version="1.0")
    content = add(root, "ssd:System", name=system.name, description=system.text)
    elements, units = add(content, "ssd:Elements"), dict[str, dict[str, str]]()
    connected = {end for pair in system.connections for end in pair}
    for component in system.components:
        element = add(
            elements,
            "ssd:Component",
            name=component.name,
            type="application/x-fmu-sharedlibrary",
            source=f"resources/{component.fmu.name}",
            implementation="CoSimulation",
        )
        connectors = add(element, "ssd:Connectors")
        for name, (kind, data) in component.variables.items():
            if f"{component.name}.{name}" in connected or kind == "output" or name in component.values:
                connector = add(connectors, "ssd:Connector", name=name, kind=kind)
                unit = {key: data.attrib[key] for key in ("unit",) if key in data.attrib}
                add(connector, f"ssc:{data.tag}", **unit)
                units |= {name: component.units[name] for name in unit.values()}
        bindings = add(element, "ssd:ParameterBindings")
        add(bindings, "ssd:ParameterBinding", source=f"resources/{component.name}.ssv")
    connections = add(content, "ssd:Connections")
    for output, reader in system.connections:
        ends = dict(zip(("startElement", "startConnector"), split(output), strict=True))
        ends |= dict(zip(("endElement", "endConnector"), split(reader), strict=True))
        add(connections, "ssd:Connection", **ends)
    add_units(root, "ssd", units)
    experiment = add(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=repr(system.duration))
    annotations = add(experiment, "ssd:Annotations")
    annotation = add(annotations, "ssc:Annotation", type="com.opensimulationplatform")  # libcosim's
    add(add(annotation, "osp:Algorithm"), "osp:FixedStepAlgorithm", baseStepSize=repr(system.step))
    return root


def parameters(component: Component) -> ET.Element:
    """The component's start values as an .ssv file."""
    root = ET.Element(tag("ssv:ParameterSet"), name=START, version="1.0")
    values, units = add(root, "ssv:Parameters"), dict[str, dict[str, str]]()
    for name, value in component.values.items():
        causality, data = component.variables[name]
        if causality != "parameter":
            raise ValueError(f"{component.name}.{name} is no parameter")
        number = {"value": repr(float(value)) if data.tag == "Real" else repr(int(value))}
        if "unit" in data.attrib:
            number["unit"] = data.attrib["unit"]
            units[number["unit"]] = component.units[number["unit"]]
        add(add(values, "ssv:Parameter", name=name), f"ssv:{data.tag}", **number)
    add_units(root, "ssv", units)
    return root
