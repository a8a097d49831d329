"""Compiles the parts into build/ssp/parts, by the functions of fmu_src/tools/build_fmu.py."""

from __future__ import annotations

import hashlib
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import build_fmu

from system_examples.ssp.parts import FOLDER, PARTS, Part
from system_examples.ssp.variables import LOCAL, OUTPUT, PARAMETER, UNITS

ROOT = build_fmu.ROOT
SOURCES = Path(__file__).resolve().parent


def header(part: Part) -> str:
    """part_variables.h. Only fmi2.c, which has defined Variable, sees the list of names."""
    names = "".join(f"    {v.constant},\n" for v in part.variables)
    rows = "".join(f'    {{"{v.name}", {v.causality.upper()}, {v.start!r}}},\n' for v in part.variables)
    return (
        "/* Written by system_examples/ssp/compilation.py. */\n"
        f"enum {{\n{names}    VARIABLE_COUNT\n}};\n"
        "#ifdef LIST_VARIABLES\n"
        f"static const Variable VARIABLES[VARIABLE_COUNT] = {{\n{rows}}};\n"
        "#endif\n"
    )


def description(part: Part, guid: str) -> str:
    """modelDescription.xml."""
    root = ET.Element(
        "fmiModelDescription",
        fmiVersion="2.0",
        modelName=part.identifier,
        guid=guid,
        description=part.text,
        license="BSD-2-Clause",
        generationTool="system_examples/ssp/compilation.py",
        variableNamingConvention="structured",
        numberOfEventIndicators="0",
    )
    ET.SubElement(
        root,
        "CoSimulation",
        modelIdentifier=part.identifier,
        canHandleVariableCommunicationStepSize="true",
        canNotUseMemoryManagementFunctions="true",
    )
    units = ET.SubElement(root, "UnitDefinitions")
    for unit in sorted({v.unit for v in part.variables}):
        base = {name: str(exponent) for name, exponent in UNITS[unit].items()}
        ET.SubElement(ET.SubElement(units, "Unit", name=unit), "BaseUnit", base)
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError")
    ET.SubElement(root, "DefaultExperiment", startTime="0", stepSize="5e-05")
    variables = ET.SubElement(root, "ModelVariables")
    for reference, v in enumerate(part.variables):
        facts = {"name": v.name, "valueReference": str(reference), "description": v.text}
        facts |= {"causality": v.causality}
        facts |= {"variability": "fixed" if v.causality == PARAMETER else "continuous"}
        real = {"unit": v.unit}
        if v.causality == OUTPUT:
            facts["initial"] = "calculated"
        elif v.causality == LOCAL:
            facts |= {"initial": "calculated", "variability": "discrete"}
        else:
            real["start"] = repr(v.start)
        if v.causality == PARAMETER:
            facts["initial"] = "exact"
        ET.SubElement(ET.SubElement(variables, "ScalarVariable", facts), "Real", real)
    structure = ET.SubElement(root, "ModelStructure")
    outputs = [str(i) for i, v in enumerate(part.variables, start=1) if v.causality == OUTPUT]
    for name in ("Outputs", "InitialUnknowns"):
        unknowns = ET.SubElement(structure, name)
        for index in outputs:
            ET.SubElement(unknowns, "Unknown", index=index)
    ET.indent(root)
    return '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"


@dataclass(frozen=True)
class PartFmu(build_fmu.Fmu):
    """A part as build_fmu.py builds it, elsewhere than the FMUs of the cam."""

    @property
    def path(self) -> Path:
        """The FMU in build/ssp/parts."""
        return FOLDER / f"{self.identifier}.fmu"


def fmu(part: Part) -> PartFmu:
    """The part, its header written. All that a binary is made of and that is no C file is in the GUID."""
    sources = [SOURCES / name for name in ("fmi2.c", *part.sources)]
    variables = header(part)
    headers = [*sorted(SOURCES.glob("*.h")), build_fmu.BARE / "incapable.h"]
    included = [path.read_text() for path in headers]
    guid = hashlib.sha256("\0".join([description(part, ""), variables, *included]).encode()).hexdigest()[:32]
    folder = FOLDER / "include" / part.identifier
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "part_variables.h").write_text(variables)
    return PartFmu(
        part.identifier,
        sources,
        description(part, guid),
        guid,
        {"documentation/licenses/license.txt": ROOT / "LICENSE"},
        defines=[f"-I{build_fmu.relative(folder)}"],
    )


def build() -> None:
    """Build the parts that are missing or out of date."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    with build_fmu.locked():
        for part in PARTS:
            build_fmu.build(fmu(part))
