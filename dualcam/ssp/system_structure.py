"""What a system of FMUs is made of: components with start values, connections, times."""

from __future__ import annotations

import xml.etree.ElementTree as ET
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from dualcam.common.archive import archive_bytes, read_members
from dualcam.common.paths import path_of

Value = float | int


@dataclass(frozen=True)
class Component:
    """An FMU with start values.

    Attributes
    ----------
    name
        Letters, digits, _ and -.
    fmu
        The FMU, FMI 2.0.
    values
        Parameter -> start value, in the FMU's unit. An FMU of this project starts from these values in every
        master: the package holds a copy with them. Those of another FMU are a parameter set of the package
        alone, which FMPy's `simulate_ssp` does not read.
    """

    name: str
    fmu: Path
    values: Mapping[str, Value]

    def __post_init__(self) -> None:
        object.__setattr__(self, "fmu", path_of(self.fmu, "the FMU"))

    @cached_property
    def members(self) -> Mapping[str, bytes] | None:
        """Of the FMU that starts from `values`; None where the FMU in `fmu` is packed as it is."""
        from dualcam.export.changed import is_own, restarted

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
