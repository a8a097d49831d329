"""The plan of a table in a file, and the values of each name that varies."""

import math
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from functools import partial
from typing import Any

from dualcam.common.mistakes import Findings, StudyError
from dualcam.common.tables import in_unit as converted
from dualcam.fmi.reals import Array
from dualcam.scenario.formula import formula, is_formula
from dualcam.study.file.context import STRING, Context, are_of_one_kind, in_unit, unit_in
from dualcam.study.plan import tables
from dualcam.study.plan.correlation import Correlation
from dualcam.study.plan.plan import Plan
from dualcam.study.plan.profiles import profiles_of_file
from dualcam.study.plan.texts import GivenTexts
from dualcam.study.plan.vary import Vary

AS_GIVEN = ("runs", "seed", "on_violation", "second_order", "levels")  # keys that are arguments of Plan
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


def plan_of(context: Context, content: Mapping[str, Any]) -> Plan:
    """The plan of a table. StudyError with all that is wrong with its values."""
    if "table" in content:
        return _plan_of_file(context, content)
    findings = Findings()
    if "kind" not in content:
        findings.note("plan lacks kind")
    same_as: dict[str, str] = {}
    vary: dict[str, Vary] = {}
    for name, each in content.get("vary", {}).items():
        found = findings.attempt(_Values(context, name, each).read, max(content.get("seed", 0), 0))
        if "same_as" in each:
            same_as[name] = each["same_as"]
        else:
            vary[name] = found or STAND_IN
    correlations = [findings.attempt(_correlation, each) for each in content.get("correlation", ())]
    formulas = {
        key: {name: str(text) for name, text in content.get(key, {}).items()}
        for key in ("derived", "constraints")
    }
    sound = [each for each in correlations if each is not None]
    used = [name for each in sound for name in (each.first, each.second)]
    sound_texts = [text for each in formulas.values() for text in each.values() if is_formula(text)]
    used += [name for text in sound_texts for name in formula(text).names]
    findings.note(*_with_names_of_fmu(context, vary, {*same_as.values(), *used} - {*formulas["derived"]}))
    given = {key: content[key] for key in AS_GIVEN if key in content}
    kind = content.get("kind", "random")
    plan = findings.attempt(Plan, kind, vary, same_as=same_as, correlations=sound, **formulas, **given)
    return findings.result(plan)


def _with_names_of_fmu(context: Context, vary: dict[str, Vary], used: set[str]) -> list[str]:
    """A name in `vary` with a slip, which is written in full elsewhere, is told once and gets its name."""
    found = []
    unknown = [name for name in vary if name not in context.units]
    for name in sorted(used - {*vary}):
        if name in context.units and (close := get_close_matches(name, unknown, n=1, cutoff=0.6)):
            found.append(f"plan: {close[0]} is no variable of the FMU: did you mean {name}?")
            vary[name] = vary[close[0]]
    return found


def _plan_of_file(context: Context, content: Mapping[str, Any]) -> Plan:
    if others := sorted(set(content) - {"kind", "table"}):
        raise StudyError(f"plan of a table has {', '.join(others)}: allowed are kind, table")
    if content.get("kind", "table") != "table":
        raise StudyError(f"plan has a table and is of kind {content['kind']}: allowed is one of them")
    written = content["table"]
    if problem := context.missing_file(written):
        raise StudyError(f"plan: table = {written!r}: {problem}")
    path = context.folder / written
    texts = [name for name, unit in context.units.items() if unit == STRING]
    if path.suffix.lower() in (".parquet", ".pq"):
        columns = tables.read_parquet(path)
    else:
        columns = tables.read_csv(path, texts, partial(_in_unit_of_fmu, context))
    findings = Findings()
    for name in texts:
        findings.note(*context.missing_texts(name, [str(text) for text in columns.get(name, ())]))
    return findings.result(findings.attempt(Plan.from_columns, columns, path.parent))


def _in_unit_of_fmu(context: Context, name: str, unit: str, values: Array) -> Array:
    """The values of a column with a unit, in the unit of the FMU's variable."""
    where = f"plan: column {name}"
    zero, one = (context.number(where, name, f"{count} {unit}") for count in (0, 1))
    return converted(values, one - zero) + zero


def _correlation(content: Mapping[str, Any]) -> Correlation:
    """One of the list."""
    of = list(content["of"])
    if len(of) != 2:
        raise StudyError(f"plan: correlation of {', '.join(of)}: allowed are two names")
    kinds = [kind for kind in ("rank", "pearson") if kind in content]
    if len(kinds) != 1:
        raise StudyError(f"plan: correlation of {' and '.join(of)}: allowed is one of rank and pearson")
    return Correlation(of[0], of[1], float(content[kinds[0]]), kinds[0])


class _Values:
    """Reads the table of one name that varies."""

    def __init__(self, context: Context, name: str, content: Mapping[str, Any]) -> None:
        self._context, self._name, self._content = context, name, content
        self._where, self._findings = f"plan: {name}", Findings()

    def read(self, seed: int) -> Vary | None:
        """The values; None for those of another name. StudyError with all that is wrong with them."""
        by = next((key for key in WITH if key in self._content), "from")
        if others := sorted(set(self._content) - set(WITH[by])):
            allowed = ", ".join(WITH[by])
            raise StudyError(f"{self._where} of {by} has {', '.join(others)}: allowed are {allowed}")
        if by == "same_as":
            return None
        found = self._profiles(seed) if by == "table" else self._list() if by == "values" else self._range()
        self._findings.refuse()
        return found

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
                found = f"{self._where}: {first[0]} = {first[1]!r}, {key} = {value!r}"
                why = f"{first[2]} and {unit} measure different things"
                raise StudyError(f"{found}: {why}: allowed are units of one kind")

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
