"""Systems of FMUs as SSP packages (SSP 1.0), and the package of one design.

A package holds SystemStructure.ssd (components, connectors with units, connections), and under resources
the FMUs and, for each component, its start values (.ssv). All parameter sets have one name, START: ecos
applies the sets of a name, libcosim the first of each component, FMPy none. So an FMU of this project gets
the start values of its component itself, too.
"""

import io
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from dualcam.common.archive import write_archive
from dualcam.common.arrays import number_of
from dualcam.common.paths import path_of, whole_file
from dualcam.design_file import DesignFile, DesignSource, as_design
from dualcam.errors import DesignError
from dualcam.export.exporter import export_fmu
from dualcam.fmi.fmu import STEP_SIZES
from dualcam.ssp.system_structure import Component, SystemStructure, Value, check_system

START = "start"
NAMES = {
    kind: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for kind, name in (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues"))
}
NAMES["osp"] = "http://opensimulationplatform.com/SSP/OSPAnnotations"
NAMES["oms"] = "https://raw.githubusercontent.com/OpenModelica/OMSimulator/master/schema/oms.xsd"
for prefix, address in NAMES.items():
    ET.register_namespace(prefix, address)

TOLERANCE = 1e-9  # the FMUs' default


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
class System(SystemStructure):
    """Components and their connections.

    Attributes
    ----------
    name, text
        Name and description of the system.
    components
        The FMUs with their start values.
    connections
        Pairs of an output and an input, each as "component.variable".
    step
        Communication step [s].
    duration
        Time [s] at which a simulation of the package ends by default.
    ports
        Inputs and outputs, as "component.variable", that are connectors of the system itself.
    """

    def save(self, path: str | Path) -> Path:
        """Write the package; equal systems give equal bytes.

        Parameters
        ----------
        path
            The file, a name that ends in .ssp, in a folder that exists.

        Returns
        -------
        Path
            The written file.

        Raises
        ------
        DesignError
            A path that is no good; wrong names, start values, connections, ports, times, FMUs: all at once.

        Warns
        -----
        DualcamWarning
            For each warning of `dualcam check` about the start values of a component.
        """
        path = package_path(path)
        check_system(self)
        if path.resolve() in [component.fmu.resolve() for component in self.components]:
            raise DesignError(f"{path} is the FMU of a component: give the package another name")
        members = {"SystemStructure.ssd": document(structure(self))}
        for component in self.components:
            members[f"resources/{component.resource}"] = component.content()
            members[f"resources/{component.name}.ssv"] = document(parameters(component))
        with whole_file(path) as unfinished:
            write_archive(unfinished, members)
        return path


def package_path(path: object) -> Path:
    """`path` as the file of a package. DesignError for another ending than .ssp and for a missing folder."""
    package = path_of(path, "the package")
    if package.suffix.lower() != ".ssp":
        raise DesignError(f"{package}: allowed are names that end in .ssp")
    if not package.absolute().parent.is_dir():
        raise DesignError(f"{package}: the folder does not exist: make the folder, or choose another")
    return package


def add_units(root: ET.Element, prefix: str, units: Mapping[str, dict[str, str]]) -> None:
    """The units by their exponents of base units. The schema allows no empty list."""
    if not units:
        return
    element = add(root, f"{prefix}:Units")
    for name, base in sorted(units.items()):
        add(add(element, "ssc:Unit", name=name), "ssc:BaseUnit", **base)


def add_connector(connectors: ET.Element, component: Component, name: str) -> dict[str, dict[str, str]]:
    """The connector of a variable; the unit that the connector uses, with its exponents."""
    kind, data = component.variables[name]
    connector = add(connectors, "ssd:Connector", name=name, kind=kind)
    unit = {"unit": data.attrib["unit"]} if "unit" in data.attrib else {}
    add(connector, f"ssc:{data.tag}", **unit)
    return {used: component.units[used] for used in unit.values()}


def component_of(system: SystemStructure, end: str) -> Component:
    """The component of `end`, "component.variable"."""
    return next(component for component in system.components if component.name == split(end)[0])


def structure(system: SystemStructure) -> ET.Element:
    """SystemStructure.ssd."""
    root = ET.Element(tag("ssd:SystemStructureDescription"), name=system.name, version="1.0")
    content = add(root, "ssd:System", name=system.name, description=system.text)
    units = dict[str, dict[str, str]]()
    if system.ports:
        connectors = add(content, "ssd:Connectors")
        for port in system.ports:
            units |= add_connector(connectors, component_of(system, port), split(port)[1])
    elements = add(content, "ssd:Elements")
    connected = {*system.ports, *(end for pair in system.connections for end in pair)}
    # FMPy 0.3.32 gives an input without connection the value of another input
    open_kinds = ("output",) if connected else ("output", "input")
    for component in system.components:
        element = add(
            elements,
            "ssd:Component",
            name=component.name,
            type="application/x-fmu-sharedlibrary",
            source=f"resources/{component.resource}",
            implementation="CoSimulation",
        )
        connectors = add(element, "ssd:Connectors")
        for name, (kind, _) in component.variables.items():
            is_open = kind in open_kinds
            if f"{component.name}.{name}" in connected or is_open or name in component.values:
                units |= add_connector(connectors, component, name)
        bindings = add(element, "ssd:ParameterBindings")
        add(bindings, "ssd:ParameterBinding", source=f"resources/{component.name}.ssv")
    if system.connections or system.ports:  # the schema allows no empty element
        add_connections(content, system)
    add_master_of_openmodelica(content, system.step)
    add_units(root, "ssd", units)
    experiment = add(root, "ssd:DefaultExperiment", startTime="0.0", stopTime=repr(system.duration))
    annotations = add(experiment, "ssd:Annotations")
    annotation = add(annotations, "ssc:Annotation", type="com.opensimulationplatform")  # libcosim's
    add(add(annotation, "osp:Algorithm"), "osp:FixedStepAlgorithm", baseStepSize=repr(system.step))
    return root


def add_master_of_openmodelica(content: ET.Element, step: float) -> None:
    """OMSimulator's fixed-step master, step in s. Its Lua interface refuses a system without this entry."""
    annotation = add(add(content, "ssd:Annotations"), "ssc:Annotation", type="org.openmodelica")
    information = add(add(annotation, "oms:Annotations"), "oms:SimulationInformation")
    tolerances = {"absoluteTolerance": repr(TOLERANCE), "relativeTolerance": repr(TOLERANCE)}
    add(information, "oms:FixedStepMaster", description="oms-ma", stepSize=repr(step), **tolerances)


def add_connections(content: ET.Element, system: SystemStructure) -> None:
    """The connections between components, and those of the system's own connectors."""
    connections = add(content, "ssd:Connections")
    for output, reader in system.connections:
        ends = dict(zip(("startElement", "startConnector"), split(output), strict=True))
        ends |= dict(zip(("endElement", "endConnector"), split(reader), strict=True))
        add(connections, "ssd:Connection", **ends)
    for port in system.ports:
        owner, variable = split(port)
        is_input = component_of(system, port).variables[variable][0] == "input"
        side, other = ("end", "start") if is_input else ("start", "end")
        ends = {f"{side}Element": owner, f"{side}Connector": variable, f"{other}Connector": variable}
        add(connections, "ssd:Connection", **ends)


def parameters(component: Component) -> ET.Element:
    """The component's start values as an .ssv file."""
    root = ET.Element(tag("ssv:ParameterSet"), name=START, version="1.0")
    values, units = add(root, "ssv:Parameters"), dict[str, dict[str, str]]()
    for name, value in component.values.items():
        _, data = component.variables[name]
        number = {"value": repr(float(value)) if data.tag == "Real" else repr(int(value))}
        if "unit" in data.attrib:
            number["unit"] = data.attrib["unit"]
            units[number["unit"]] = component.units[number["unit"]]
        add(add(values, "ssv:Parameter", name=name), f"ssv:{data.tag}", **number)
    add_units(root, "ssv", units)
    return root


def design_system(design: DesignFile, fmu: Path, step: float = 1e-3, ports: bool = False) -> System:
    """The system with one component "cam": `fmu`, an FMU of FMI 2.0 exported from the design, with the
    numbers of the design as start values. `step` [s] and `ports` are those of `export_ssp`.
    """
    values: dict[str, Value] = {k: v for k, v in design.parameters_for().items() if not isinstance(v, str)}
    cam = Component("cam", fmu, values)
    ends = [f"cam.{name}" for name, (kind, _) in cam.variables.items() if kind in ("input", "output")]
    duration = 1.0 if design.scenario is None else design.scenario.stop
    return System(
        design.name, f"Dual cam {design.name}", (cam,), (), step, duration, tuple(ends) if ports else ()
    )


def export_ssp(design: DesignSource, path: str | Path, step: float = 1e-3, *, ports: bool = False) -> Path:
    """Write an SSP package with one component "cam", the FMU of a design.

    The design's numbers are the parameter set "start" (`resources/cam.ssv`). The torque of the scenario is no
    part of the package.

    Parameters
    ----------
    design : The design, from `read_design`, or the path of its file.
    path : The package, a name that ends in .ssp.
    step : Communication step [s] that the package proposes.
    ports : bool
        Whether the inputs and outputs of the cam are connectors of the system, too. SSP 1.0 allows them. FMPy
        0.3.32 needs them; ecos 0.7.2 and libcosim 0.11 do not load a package that has them.

    Returns
    -------
    Path
        The written file.

    Raises
    ------
    DualcamError
        A path or step that is no good, or a design that the FMU refuses.

    Examples
    --------
    >>> import tempfile
    >>> from dualcam.design_file import write_template
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     design = write_template("minimal", Path(folder) / "my.toml")
    ...     export_ssp(design, Path(folder) / "MyCam.ssp").name
    'MyCam.ssp'
    """
    design, path = as_design(design), package_path(path)
    if not number_of(step, "step", STEP_SIZES) > 0.0:
        raise DesignError(f"step = {step!r}: allowed is {STEP_SIZES}")
    with tempfile.TemporaryDirectory() as folder:
        fmu = export_fmu(design, Path(folder) / f"{path.stem}.fmu")
        return design_system(design, fmu, step, ports).save(path)
