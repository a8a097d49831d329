"""A package's FMUs coupled by FMPy, with nothing but the package.

Masters couple such a system explicitly, all components side by side (Jacobi): the outputs at t are the inputs
over [t, t + step]. couple() does the same.
"""

from __future__ import annotations

import shutil
import tempfile
import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dualcam import Fmu
from dualcam.fmi import Reals
from dualcam.ssp import Value
from dualcam.ssp.package import split, tag

Columns = Mapping[str, np.ndarray]


End = tuple[str, str]  # component and variable


@dataclass(frozen=True)
class Connection:
    """From a value of one group of variables to a value of another."""

    source: np.ndarray
    source_index: int
    target: np.ndarray
    target_index: int


def couple(
    package: Path, step: float, count: int, watched: Sequence[str], every: int = 1
) -> dict[str, np.ndarray]:
    """`count` steps of `step` [s] of the package's FMUs, side by side; the watched variables after each
    `every` steps, shape (count // every,) each. FmuError if an FMU refuses a value or a step."""
    with ExitStack() as stack:
        folder = Path(tempfile.mkdtemp(prefix="ssp-"))
        stack.callback(shutil.rmtree, folder, ignore_errors=True)
        with zipfile.ZipFile(package) as archive:
            archive.extractall(folder)
        structure = ET.parse(folder / "SystemStructure.ssd").getroot()
        fmus = started_fmus(structure, folder, stack)
        outputs, connections, inputs = connected(structure, fmus)
        watched_groups, positions = groups(fmus, [split(name) for name in watched])
        columns = [positions[split(name)] for name in watched]
        rows = np.empty((count // every, len(watched)))
        exchange(outputs, connections, inputs)
        for k in range(1, count + 1):
            for fmu in fmus.values():
                fmu.step(step)
            exchange(outputs, connections, inputs)
            if k % every == 0:
                for group in watched_groups:
                    group.read()
                rows[k // every - 1] = [values[index] for values, index in columns]
    return {name: rows[:, i] for i, name in enumerate(watched)}


def started_fmus(structure: ET.Element, folder: Path, stack: ExitStack) -> dict[str, Fmu]:
    """The components' FMUs by name, started with their parameter sets, and closed with `stack`."""
    fmus: dict[str, Fmu] = {}
    for element in structure.iter(tag("ssd:Component")):
        fmu = stack.enter_context(Fmu(folder / element.attrib["source"]))
        binding = element.find(f".//{tag('ssd:ParameterBinding')}")
        fmu.start({} if binding is None else read_values(folder / binding.attrib["source"]))
        fmus[element.attrib["name"]] = fmu
    return fmus


def read_values(path: Path) -> dict[str, Value]:
    """Start values of an .ssv file by name."""
    values: dict[str, Value] = {}
    for row in ET.parse(path).iter(tag("ssv:Parameter")):
        number = row[0].attrib["value"]
        values[row.attrib["name"]] = float(number) if row[0].tag == tag("ssv:Real") else int(number)
    return values


def connected(
    structure: ET.Element, fmus: Mapping[str, Fmu]
) -> tuple[list[Reals], list[Connection], list[Reals]]:
    """Groups of all connected outputs, the connections, and groups of all connected inputs."""
    ends = [
        tuple((c.attrib[f"{side}Element"], c.attrib[f"{side}Connector"]) for side in ("start", "end"))
        for c in structure.iter(tag("ssd:Connection"))
    ]
    outputs, sources = groups(fmus, [start for start, _ in ends])
    inputs, targets = groups(fmus, [end for _, end in ends])
    return outputs, [Connection(*sources[start], *targets[end]) for start, end in ends], inputs


def groups(
    fmus: Mapping[str, Fmu], ends: Sequence[End]
) -> tuple[list[Reals], dict[End, tuple[np.ndarray, int]]]:
    """One group of variables per FMU, and by end the group's values with the end's index in them."""
    found: list[Reals] = []
    positions: dict[End, tuple[np.ndarray, int]] = {}
    for name, fmu in fmus.items():
        variables = list(dict.fromkeys(variable for component, variable in ends if component == name))
        if variables:
            group = fmu.reals(*variables)
            found.append(group)
            positions |= {(name, variable): (group.values, i) for i, variable in enumerate(variables)}
    return found, positions


def exchange(outputs: Sequence[Reals], connections: Sequence[Connection], inputs: Sequence[Reals]) -> None:
    """Pass all connected outputs on to the inputs."""
    for group in outputs:
        group.read()
    for c in connections:
        c.target[c.target_index] = c.source[c.source_index]
    for group in inputs:
        group.write()
