"""What the readers of all tables of a file share."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from dualcam.common.mistakes import Findings, StudyError
from dualcam.fmi.library import MODELS
from dualcam.study.file.paths import resources_of
from dualcam.study.file.quantities import Units, units_of
from dualcam.study.run.fmu_check import Variables


@dataclass(frozen=True)
class Context:
    """The folder of a file, where relative paths start; the FMU that it names, and its variables."""

    folder: Path
    fmu: str | Path
    variables: Variables

    @classmethod
    def of(cls, folder: Path, fmu: str) -> Context:
        """StudyError for an FMU that cannot be read."""
        path = fmu if fmu in MODELS else folder / fmu
        findings = Findings()
        variables = findings.attempt(Variables.of_fmu, path)
        if variables is None:
            raise StudyError("; ".join(findings.problems))
        return cls(folder, path, variables)

    @cached_property
    def units(self) -> Units:
        """Unit by variable."""
        return units_of(self.variables.by_name)

    @cached_property
    def resources(self) -> set[str]:
        """The FMU's own files."""
        return resources_of(self.fmu)
