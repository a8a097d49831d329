"""What the readers of all tables of a file share."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path

from dualcam.study.checking import Variables
from dualcam.study.problem import Findings
from dualcam.study.reading.files import resources_of
from dualcam.study.reading.quantities import Units, units_of


@dataclass(frozen=True)
class Context:
    """One reading of a file.

    Attributes
    ----------
    folder
        That of the file, where relative paths start.
    fmu
        The FMU that the file names; None where none is named.
    variables
        Those of the FMU by name; None where the FMU cannot be read.
    findings
        All that is wrong so far.
    tries_runs
        Whether the FMU is asked what it refuses of the sound parts, where something else is wrong.
    """

    folder: Path
    fmu: str | Path | None
    variables: Variables | None
    findings: Findings = field(default_factory=Findings)
    tries_runs: bool = True

    @cached_property
    def units(self) -> Units:
        """Unit by variable; nothing of an FMU that cannot be read."""
        return units_of(self.variables.by_name if self.variables else {})

    @cached_property
    def resources(self) -> set[str]:
        """The FMU's own files."""
        return set() if self.fmu is None else resources_of(self.fmu)
