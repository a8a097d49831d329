"""The values of one name that varies, of its table in a file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from dualcam.study.problem import StudyError
from dualcam.study.reading.context import Context
from dualcam.study.reading.files import is_file_name, missing_file
from dualcam.study.reading.quantities import STRING, are_of_one_kind, in_unit, number, unit_in
from dualcam.study.sampling.profiles import profiles_of_file
from dualcam.study.sampling.texts import GivenTexts
from dualcam.study.sampling.vary import Vary
from dualcam.study.sound_plan import STAND_IN

WITH = {  # keys of a name that vary together, by the key that says what the values are
    "same_as": ("same_as",),
    "table": ("table", "deviation", "correlation_length", "count"),
    "values": ("values", "weights", "unit"),
    "distribution": ("distribution", "from", "to", "count", "mean", "std", "arguments", "unit"),
    "from": ("from", "to", "count", "log", "unit"),
}
OF_ONE_KIND = ("from", "to", "mean", "std", "loc", "scale", "values")  # in units of one kind
PROFILE = {"deviation": "m", "correlation_length": "rad"}


def kind_of(content: Mapping[str, Any]) -> str:
    """The key that says what the values are."""
    return next((by for by in WITH if by in content), "from")


class ValuesReader:
    """Reads the table of one name."""

    def __init__(self, context: Context, name: str, content: Mapping[str, Any]) -> None:
        self._context, self._findings = context, context.findings
        self._name, self._content = name, content
        self._where, self._place = f"plan: {name}", ("plan", "vary", name)

    def check_keys(self) -> None:
        """Notes keys that do not go with the key that says what the values are."""
        by = kind_of(self._content)
        others = sorted(set(self._content) - set(WITH[by]))
        if others and self._findings.is_sound(*self._place):
            allowed = ", ".join(WITH[by])
            self._note("", f"{self._where} of {by} has {', '.join(others)}: allowed are {allowed}")

    def values(self, seed: int) -> Vary:
        """The values; a stand-in where some are refused. `seed` is that of the plan."""
        self.check_keys()
        if "table" in self._content:
            return self._profiles(seed) or STAND_IN
        self._check_unit()
        if "values" in self._content:
            return self._list() or STAND_IN
        given = self._numbers(["from", "to", "mean", "std"], self._content)
        arguments = self._numbers(self._content.get("arguments", {}), self._content.get("arguments", {}))
        self._check_kinds()
        if not self._findings.is_sound(*self._place):
            return STAND_IN
        low, high = (given.pop(key, math.nan) for key in ("from", "to"))
        count, log = self._content.get("count", 0), self._content.get("log", False)
        name, unit = self._content.get("distribution", ""), self._content.get("unit", "")
        return Vary(low, high, count, log, (), name, given | arguments, unit=unit)

    def _note(self, key: str, *problems: str) -> None:
        self._findings.note((*self._place, key) if key else self._place, *problems)

    # ---- numbers ----

    def _check_unit(self) -> None:
        unit = self._content.get("unit", "")
        where = f"{self._where}: unit = {unit!r}"
        if unit and self._name in self._context.units:
            self._note("unit", f"{where}: the FMU says the unit of {self._name}: leave unit out")
        elif unit and not are_of_one_kind(unit, unit):
            self._note("unit", f"{where} is not known: allowed are units such as mm, N/mm, deg")

    def _number(self, key: str, shown: str, value: Any) -> float | None:  # noqa: ANN401
        """In the unit of the name; None, with a note, for a text that has none."""
        if not self._findings.is_sound(*self._place, "unit"):
            return None
        where, unit = f"{self._where}: {shown}", self._content.get("unit", "")
        if unit and isinstance(value, str):
            return self._findings.attempt((*self._place, key), in_unit, where, value, unit)
        units = self._context.units
        found = self._findings.attempt((*self._place, key), number, where, self._name, value, units)
        if found is not None and math.isnan(found):
            self._note(key, f"{where} = {value}: allowed are finite numbers")
        return found

    def _numbers(self, keys: Iterable[str], content: Mapping[str, Any]) -> dict[str, float]:
        is_argument = content is not self._content
        found = {
            key: self._number(key, f"arguments: {key}" if is_argument else key, content[key])
            for key in keys
            if key in content
        }
        return {key: value for key, value in found.items() if value is not None}

    def _check_kinds(self) -> None:
        """Texts of a name that the FMU does not have are in units of one kind: the FMU does not say which."""
        if self._name in self._context.units or not self._findings.is_sound(*self._place):
            return
        entries = {**self._content, **self._content.get("arguments", {})}
        given = [
            (key, value, unit_in(value))
            for key in OF_ONE_KIND
            if key in entries
            for value in (entries[key] if key == "values" else [entries[key]])
        ]
        units = [each for each in given if each[2]]
        for key, value, unit in units[1:]:
            first = units[0]
            if not are_of_one_kind(unit, first[2]):
                self._note(
                    key,
                    f"{self._where}: {first[0]} = {first[1]!r}, {key} = {value!r}: {first[2]} and {unit} "
                    "measure different things: allowed are units of one kind",
                )
                return

    # ---- lists ----

    def _list(self) -> Vary | None:
        values, unit = self._content["values"], self._content.get("unit", "")
        kind = self._context.units.get(self._name, "")
        if kind == STRING or (kind == "" and are_names(values)):
            texts = [str(value) for value in values]
            if kind == STRING:
                note_missing_files(self._context, self._name, texts)
            weights = tuple(self._content.get("weights", ()))
            return Vary(values=GivenTexts.of(texts, self._context.folder), weights=weights)
        numbers = [self._number("values", "values", each) for each in values]
        self._check_kinds()
        if not self._findings.is_sound(*self._place):
            return None
        found = tuple(value for value in numbers if value is not None)
        return Vary(values=found, weights=tuple(self._content.get("weights", ())), unit=unit)

    # ---- groove tables with an error ----

    def _profiles(self, seed: int) -> Vary | None:
        """Tables with a random error; None for a file or numbers that make none."""
        if not self._findings.is_sound(*self._place):
            return None
        if lacking := [key for key in WITH["table"] if key not in self._content]:
            self._note("", f"{self._where} of table lacks {', '.join(lacking)}")
            return None
        numbers = {key: self._above_zero(key, unit) for key, unit in PROFILE.items()}
        if self._content["count"] < 1:
            count = self._content["count"]
            self._note("count", f"{self._where}: count = {count}: allowed is the number of tables, 1 or more")
        path = self._content["table"]
        if problem := missing_file(self._context.folder, path):
            self._note("table", f"{self._where}: table = {path!r}: {problem}")
        if not self._findings.is_sound(*self._place):
            return None
        try:
            profiles = profiles_of_file(
                self._context.folder / path, **numbers, count=self._content["count"], seed=seed
            )
        except StudyError as error:
            self._note("table", f"{self._where}: {error}")
            return None
        return Vary(values=profiles)

    def _above_zero(self, key: str, unit: str) -> float:
        value, where = self._content[key], f"{self._where}: {key}"
        if isinstance(value, str):
            value = self._findings.attempt((*self._place, key), in_unit, where, value, unit)
        if value is not None and not (math.isfinite(value) and value > 0.0):
            self._note(key, f"{where} = {value:g}: allowed is a finite number above 0")
        return math.nan if value is None else float(value)


def are_names(values: Iterable[object]) -> bool:
    """Whether none of the values is a number, or a text with one: they are texts for a law."""
    return all(isinstance(value, str) and not value[:1].strip("+-.").isdigit() for value in values)


def note_missing_files(context: Context, name: str, texts: Iterable[str]) -> None:
    """Notes texts of a String that look like files, where neither the folder nor the FMU has them."""
    for text in dict.fromkeys(texts):
        if not is_file_name(text) or text in context.resources:
            continue
        if problem := missing_file(context.folder, text):
            context.findings.note(("plan", "vary", name, "values"), f"plan: {name} = {text!r}: {problem}")
