"""What the readers of all tables of a file share: its folder, and the FMU that it names."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from zipfile import BadZipFile, ZipFile

from dualcam.common.mistakes import Findings
from dualcam.common.paths import near_names
from dualcam.errors import DualcamError
from dualcam.fmi.library import MODELS, source_path
from dualcam.study.file.quantities import STRING, Units
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
        findings.refuse()
        assert variables is not None
        return cls(folder, path, variables)

    @cached_property
    def units(self) -> Units:
        """Unit by variable."""
        others = {"string": STRING}
        return {
            name: (each.unit or "1") if each.kind == "real" else others.get(each.kind)
            for name, each in self.variables.by_name.items()
        }

    @cached_property
    def _resources(self) -> set[str]:
        """The files in the folder resources of the FMU, which texts may name, too."""
        try:
            with ZipFile(source_path(self.fmu)) as archive:
                names = archive.namelist()
        except (DualcamError, OSError, BadZipFile):
            return set()
        return {name.removeprefix("resources/") for name in names if name.startswith("resources/")}

    def missing_file(self, text: str) -> str | None:
        """What to say of a file that is not there: its name, the folder searched, and the nearest name."""
        path = self.folder / text
        try:
            if path.exists():
                return None
            searched = path.parent.resolve()
            names = [each.name for each in searched.iterdir()] if searched.is_dir() else None
        except (OSError, ValueError) as error:
            return f"the file cannot be read: {error}"
        if names is None:
            return f"there is no folder {searched}"
        close = near_names(path.name, names, 2)
        then = f"did you mean {' or '.join(close)}?" if close else "allowed is a path, relative to the plan"
        return f"there is no file {path.name} in the folder {searched}: {then}"

    def missing_texts(self, name: str, texts: Iterable[str]) -> list[str]:
        """What to say of texts of a String that look like files, which neither the folder nor the FMU has."""
        return [
            f"plan: {name} = {text!r}: {problem}"
            for text in dict.fromkeys(texts)
            if Path(text).suffix and "\n" not in text and text not in self._resources
            if (problem := self.missing_file(text))
        ]
