"""What the readers of all tables of a file share: its folder, the FMU that it names, and the FMU's units, in
which a text such as "40 deg" becomes a number."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from zipfile import BadZipFile, ZipFile

from dualcam.common.mistakes import Findings, StudyError
from dualcam.common.paths import near_names
from dualcam.errors import DesignError, DualcamError
from dualcam.fmi.library import MODELS, source_path
from dualcam.study.run.fmu_check import Variables

STRING = "String"  # in place of the unit of a String


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
        return cls(folder, path, findings.result(findings.attempt(Variables.of_fmu, path)))

    @cached_property
    def units(self) -> dict[str, str | None]:
        """Unit by variable, "1" for a plain number; None: no real."""
        others = {"string": STRING}
        return {
            name: (each.unit or "1") if each.kind == "real" else others.get(each.kind)
            for name, each in self.variables.by_name.items()
        }

    def number(self, where: str, name: str, value: float | str) -> float:
        """A number, or that of a text with a unit, in the unit of a name. `where` begins a StudyError."""
        if not isinstance(value, str):
            return float(value)
        if name not in self.units:  # a number for formulas
            return in_si(where, value)
        unit = self.units[name]
        if unit is None or unit == STRING:
            allowed = "allowed is a number without unit"
            raise StudyError(f"{where} = {value!r}: {name} is no real variable: {allowed}")
        return in_unit(where, value, unit)

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


def in_si(where: str, text: str) -> float:
    """The number of a text in the base unit of the SI. `where` begins the message of the StudyError."""
    from dualcam.common.written_units import si_number

    try:
        return si_number(text)
    except DesignError as error:
        raise StudyError(f"{where} = {text!r}: {error}") from None


def in_unit(where: str, text: str, unit: str) -> float:
    """The number of a text in a unit. `where` begins the message of the StudyError."""
    from dualcam.common.written_units import quantity  # loads pydantic and pint, which few plans need

    try:
        return quantity(text, unit)
    except DesignError as error:
        raise StudyError(f"{where} = {text!r}: {error}") from None
    except Exception:  # pint has many, for units of FMUs of others
        why = f"texts cannot be converted to the FMU's unit {unit!r}: allowed is a number"
        raise StudyError(f"{where} = {text!r}: {why}") from None


def unit_in(value: object) -> str:
    """The unit that a text has; none of a number."""
    from dualcam.common.written_units import written_unit

    return written_unit(value) if isinstance(value, str) else ""


def are_of_one_kind(one: str, other: str) -> bool:
    """Whether numbers in one unit can be converted to the other; not where a unit is not known."""
    from dualcam.common.written_units import quantity

    try:
        quantity(f"1 {one}", other)
    except Exception:  # pint has many
        return False
    return True
