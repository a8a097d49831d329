"""The values of one name that varies, of its table in a file."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from dualcam.common.mistakes import Findings, StudyError
from dualcam.study.file.context import STRING, Context, are_of_one_kind, in_unit, unit_in
from dualcam.study.plan.profiles import profiles_of_file
from dualcam.study.plan.texts import GivenTexts
from dualcam.study.plan.vary import Vary

WITH = {  # keys of a name that vary together, by the key that says what the values are
    "same_as": ("same_as",),
    "table": ("table", "deviation", "correlation_length", "count"),
    "values": ("values", "weights", "unit"),
    "distribution": ("distribution", "from", "to", "count", "mean", "std", "arguments", "unit"),
    "from": ("from", "to", "count", "log", "unit"),
}
OF_ONE_KIND = ("from", "to", "mean", "std", "loc", "scale", "values")  # in units of one kind
PROFILE = {"deviation": "m", "correlation_length": "rad"}
STAND_IN = Vary(0.0, 1.0, count=2)  # for values that are refused, so that the rest can be checked


class ValuesReader:
    """Reads the table of one name."""

    def __init__(self, context: Context, name: str, content: Mapping[str, Any]) -> None:
        self._context, self._name, self._content = context, name, content
        self._where, self._findings = f"plan: {name}", Findings()

    def read(self, seed: int) -> Vary | None:
        """The values; None for those of another name. StudyError with all that is wrong with them.

        `seed` is that of the plan."""
        by = next((key for key in WITH if key in self._content), "from")
        if others := sorted(set(self._content) - set(WITH[by])):
            allowed = ", ".join(WITH[by])
            raise StudyError(f"{self._where} of {by} has {', '.join(others)}: allowed are {allowed}")
        if by == "same_as":
            return None
        other = self._list if by == "values" else self._range
        found = self._profiles(seed) if by == "table" else other()
        self._findings.refuse()
        return found

    # ---- numbers ----

    def _range(self) -> Vary:
        self._check_unit()
        given = self._numbers(["from", "to", "mean", "std"], self._content)
        arguments = self._numbers(self._content.get("arguments", {}), self._content.get("arguments", {}))
        self._check_kinds()
        low, high = (given.pop(key, math.nan) for key in ("from", "to"))
        count, log = self._content.get("count", 0), self._content.get("log", False)
        name, unit = self._content.get("distribution", ""), self._content.get("unit", "")
        return Vary(low, high, count, log, (), name, given | arguments, unit=unit)

    def _check_unit(self) -> None:
        unit = self._content.get("unit", "")
        where = f"{self._where}: unit = {unit!r}"
        if unit and self._name in self._context.units:
            raise StudyError(f"{where}: the FMU says the unit of {self._name}: leave unit out")
        if unit and not are_of_one_kind(unit, unit):
            raise StudyError(f"{where} is not known: allowed are units such as mm, N/mm, deg")

    def _number(self, shown: str, value: float | str) -> float:
        """In the unit of the name; NaN, with a note, for one that is refused."""
        where, unit = f"{self._where}: {shown}", self._content.get("unit", "")
        if unit and isinstance(value, str):
            found = self._findings.attempt(in_unit, where, value, unit)
        else:
            found = self._findings.attempt(self._context.number, where, self._name, value)
        if found is not None and math.isnan(found):
            self._findings.note(f"{where} = {value}: allowed are finite numbers")
        return math.nan if found is None else found

    def _numbers(self, keys: Iterable[str], content: Mapping[str, Any]) -> dict[str, float]:
        before = "" if content is self._content else "arguments: "
        return {key: self._number(before + key, content[key]) for key in keys if key in content}

    def _check_kinds(self) -> None:
        """Texts of a name that the FMU does not have are in units of one kind: the FMU does not say which."""
        if self._name in self._context.units or self._findings.problems:
            return
        entries = {**self._content, **self._content.get("arguments", {})}
        given = [
            (key, value, unit)
            for key in OF_ONE_KIND
            if key in entries
            for value in (entries[key] if key == "values" else [entries[key]])
            if (unit := unit_in(value))
        ]
        for key, value, unit in given[1:]:
            first = given[0]
            if not are_of_one_kind(unit, first[2]):
                raise StudyError(
                    f"{self._where}: {first[0]} = {first[1]!r}, {key} = {value!r}: {first[2]} and {unit} "
                    "measure different things: allowed are units of one kind"
                )

    # ---- lists ----

    def _list(self) -> Vary:
        self._check_unit()
        values, unit = self._content["values"], self._content.get("unit", "")
        weights = tuple(self._content.get("weights", ()))
        kind = self._context.units.get(self._name, "")
        if kind == STRING or (kind == "" and are_names(values)):
            texts = [str(value) for value in values]
            if kind == STRING:
                self._findings.note(*self._context.missing_texts(self._name, texts))
            return Vary(values=GivenTexts.of(texts, self._context.folder), weights=weights)
        numbers = tuple(self._number("values", each) for each in values)
        self._check_kinds()
        return Vary(values=numbers, weights=weights, unit=unit)

    # ---- groove tables with an error ----

    def _profiles(self, seed: int) -> Vary:
        """Tables with a random error."""
        if lacking := [key for key in WITH["table"] if key not in self._content]:
            raise StudyError(f"{self._where} of table lacks {', '.join(lacking)}")
        numbers = {key: self._in(unit, key) for key, unit in PROFILE.items()}
        path, count = self._content["table"], self._content["count"]
        if problem := self._context.missing_file(path):
            self._findings.note(f"{self._where}: table = {path!r}: {problem}")
        self._findings.refuse()
        try:
            profiles = profiles_of_file(self._context.folder / path, **numbers, count=count, seed=seed)
        except StudyError as error:
            raise StudyError(f"{self._where}: {error}") from error
        return Vary(values=profiles)

    def _in(self, unit: str, key: str) -> float:
        value = self._content[key]
        if isinstance(value, str):
            value = self._findings.attempt(in_unit, f"{self._where}: {key}", value, unit)
        return math.nan if value is None else float(value)


def are_names(values: Iterable[object]) -> bool:
    """Whether none of the values is a number, or a text with one: they are texts for a law."""
    return all(isinstance(value, str) and not value[:1].strip("+-.").isdigit() for value in values)
