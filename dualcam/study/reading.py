"""One reading of a TOML table that describes a study, with all that is wrong with it.

What is refused is left out, and the rest is read on, so that one reading finds all mistakes."""

from __future__ import annotations

import importlib
import math
import re
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

from dualcam.errors import DualcamError
from dualcam.study.entries import hint
from dualcam.study.plan import Plan
from dualcam.study.problem import StudyError, refuse
from dualcam.study.quantities import STRING, Units, in_si, in_unit, number
from dualcam.study.sampling import tables
from dualcam.study.sampling.correlation import Correlation
from dualcam.study.sampling.formula import is_formula
from dualcam.study.sampling.profiles import profiles_of_file
from dualcam.study.sampling.texts import GivenTexts
from dualcam.study.sampling.vary import Vary
from dualcam.study.scenario import Controller, History, Scenario

WITH = {  # keys of a name that vary together, by the key that says what the values are
    "same_as": ("same_as",),
    "table": ("table", "deviation", "correlation_length", "count"),
    "values": ("values", "weights", "unit"),
    "distribution": ("distribution", "from", "to", "count", "mean", "std", "arguments", "unit"),
    "from": ("from", "to", "count", "log", "unit"),
}
RUNS = 128  # in place of a number that is refused: every kind of plan takes it
STAND_IN = Vary(0.0, 1.0, count=2)  # for values that are refused, so that the rest can be checked


class Reading:
    """One reading. `folder` is that of the file, where relative paths start.

    Attributes
    ----------
    problems : list of str
        What is wrong so far.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._seed = 0  # of the plan
        self.problems: list[str] = []
        self._refused: set[str] = set()  # names with a mistake: what follows from it is no mistake of its own
        self._used: set[str] = set()  # names in formulas, also in those that are refused
        self._is_plan_whole = True

    def note(self, problems: Iterable[str]) -> None:
        """Further problems, but for those that follow from a mistake that is known."""
        for text in problems:
            told = re.split(r": did you mean|: allowed are", text)[0]
            follows = any(re.search(rf"(?<![\w.]){re.escape(name)}(?![\w.])", told) for name in self._refused)
            follows |= any(told.startswith(f"plan: {name} is no variable") for name in self._used)
            if not follows:
                self.problems.append(text)

    def attempt(self, function: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
        """What the function gives; None, and its problems, if the call is refused."""
        try:
            return function(*arguments)
        except StudyError as error:
            self.note(error.problems)
        except DualcamError as error:
            self.note([str(error)])
        return None

    # ---- the schema ----

    def validated(
        self,
        model: Any,  # noqa: ANN401
        content: Mapping[str, Any],
        where: str,
        within: tuple[str, ...] = (),
    ) -> dict[str, Any]:
        """The content without what the model refuses. `where` names the whole table, `within` is its place in
        the file."""
        from pydantic import ValidationError

        left = dict(content)
        self._used |= _names_in(content)
        try:
            model.model_validate(left)
        except ValidationError as error:
            lacking: dict[tuple[int | str, ...], list[str]] = {}
            for problem in error.errors(include_url=False):
                inner = problem["loc"]
                place = (*within, *inner)
                if place[0] == "plots" and len(place) > 1:
                    continue  # each kind of picture has keys of its own, which are checked later
                if problem["type"] == "missing":
                    lacking.setdefault(place[:-1], []).append(str(place[-1]))
                    continue
                self.problems.append(_words(problem, place, where, _fields(model, inner[:-1])))
                if place[:2] == ("plan", "vary") and len(place) > 2:
                    self._refused.add(str(place[2]))
                if place[:2] == ("plan", "correlation"):
                    inner = inner[: 3 - len(within)]
                self._is_plan_whole &= place[:1] != ("plan",) or len(place) != 2
                left = _without(left, inner)
            for place, keys in lacking.items():
                table = place[len(within) :]
                self.problems.append(f"{_where(place, where)} lacks {', '.join(sorted(keys))}")
                left = _without(left, table) if table else left
        return left

    # ---- the plan ----

    def plan(self, content: Mapping[str, Any] | None, units: Units) -> Plan | None:
        """The plan of a table; where something is refused, one of the rest. `units`: those into which texts
        such as "40 deg" go."""
        if content is None:
            return None
        if "table" in content:
            return self._plan_of_table(content, units)
        if "kind" not in content:
            self.note(["plan lacks kind"])
        self._seed = content.get("seed", 0)
        same_as, vary = {}, {}
        for name, each in content.get("vary", {}).items():
            if "same_as" in each:
                self._check_keys(name, each, "same_as")
                same_as[name] = each["same_as"]
            else:
                vary[name] = self._attempt_of(name, self._vary, name, each, units) or STAND_IN
        parts = {
            "same_as": same_as,
            "derived": _texts(content.get("derived", {})),
            "constraints": _texts(content.get("constraints", {})),
            "on_violation": content.get("on_violation", "redraw"),
            "second_order": content.get("second_order", True),
            "levels": content.get("levels", 4),
        }
        correlations = [self.attempt(_correlation, each) for each in content.get("correlation", ())]
        parts["correlations"] = [each for each in correlations if each is not None]
        numbers = content.get("runs", 0 if self._is_plan_whole else RUNS), content.get("seed", 0)
        made: Plan | None = self.attempt(lambda: Plan(content.get("kind", "random"), vary, *numbers, **parts))
        return made or self._rest(vary, same_as, parts["derived"])

    def _attempt_of(self, name: str, function: Callable[..., Any], *arguments: Any) -> Any:  # noqa: ANN401
        """As `attempt`, for values of a name."""
        before = len(self.problems)
        found = self.attempt(function, *arguments)
        if len(self.problems) > before:
            self._refused.add(name)
        return found

    def _rest(
        self, vary: Mapping[str, Vary], same_as: Mapping[str, str], derived: Mapping[str, str]
    ) -> Plan | None:
        """A plan of what is right, whose names can be checked further."""
        sound = {name: STAND_IN if each.problem(False) else each for name, each in vary.items()}
        self._refused |= {name for name in vary if sound[name] is not vary[name]}
        same = {name: other for name, other in same_as.items() if other in sound and name not in sound}
        try:
            return Plan("random", sound, 1, same_as=same, derived=derived)
        except StudyError:
            return Plan("random", sound, 1, same_as=same) if sound else None

    def _plan_of_table(self, content: Mapping[str, Any], units: Units) -> Plan | None:
        if others := sorted(set(content) - {"kind", "table"}):
            self.note([f"plan of a table has {', '.join(others)}: allowed are kind, table"])
        if content.get("kind", "table") != "table":
            self.note([f"plan has a table and is of kind {content['kind']}: allowed is one of them"])
        path = self.folder / content["table"]
        if tables.is_parquet(path):
            return self.attempt(Plan.from_parquet, path)
        return self.attempt(Plan.from_csv, path, [name for name, unit in units().items() if unit == STRING])

    def _check_keys(self, name: str, content: Mapping[str, Any], by: str) -> None:
        """Notes keys that do not go with the key that says what the values are."""
        if others := sorted(set(content) - set(WITH[by])):
            self.note([f"plan: {name} of {by} has {', '.join(others)}: allowed are {', '.join(WITH[by])}"])
            self._refused.add(name)

    def _vary(self, name: str, content: Mapping[str, Any], units: Units) -> Vary:
        """StudyError for values that are no numbers in the unit of the name."""
        where = f"plan: {name}"
        self._check_keys(name, content, next((by for by in WITH if by in content), "from"))
        unit = content.get("unit", "")

        def read(key: str, value: Any) -> float:  # noqa: ANN401
            if unit and isinstance(value, str):
                return in_unit(f"{where}: {key}", value, unit)
            return number(f"{where}: {key}", name, value, units)

        if unit and name in units():
            raise StudyError(f"{where}: unit = {unit!r}: the FMU says the unit of {name}: leave unit out")
        if "table" in content:
            return self._profiles(name, content)
        if "values" in content:
            values = content["values"]
            if units().get(name) == STRING or (name not in units() and _are_names(values)):
                return Vary(values=GivenTexts.of([str(value) for value in values], self.folder))
            weights = tuple(content.get("weights", ()))
            return Vary(values=tuple(read("values", each) for each in values), weights=weights, unit=unit)
        low, high = (read(key, content.get(key, math.nan)) for key in ("from", "to"))
        count, log = content.get("count", 0), content.get("log", False)
        given = {key: read(key, content[key]) for key in ("mean", "std") if key in content}
        given |= {
            key: read(f"arguments: {key}", value) for key, value in content.get("arguments", {}).items()
        }
        return Vary(low, high, count, log, (), content.get("distribution", ""), given, unit=unit)

    def _profiles(self, name: str, content: Mapping[str, Any]) -> Vary:
        """Tables with a random error. StudyError for a file or numbers that make none."""
        where = f"plan: {name}"
        if lacking := [key for key in WITH["table"] if key not in content]:
            raise StudyError(f"{where} of table lacks {', '.join(lacking)}")
        numbers = {}
        for key, unit in (("deviation", "m"), ("correlation_length", "rad")):
            value = content[key]
            numbers[key] = in_unit(f"{where}: {key}", value, unit) if isinstance(value, str) else float(value)
        try:
            profiles = profiles_of_file(
                self.folder / content["table"], **numbers, count=content["count"], seed=self._seed
            )
        except StudyError as error:
            raise StudyError(f"{where}: {error}") from error
        return Vary(values=profiles)

    # ---- the scenario ----

    def scenario(self, content: Mapping[str, Any] | None, units: Units) -> Scenario | None:
        """The scenario of a table; None where something is refused."""
        if content is None:
            return None
        before = len(self.problems)
        histories = {
            name: self.attempt(self._history, name, each, units)
            for name, each in content.get("inputs", {}).items()
        }
        control = self.attempt(_controller, content["controller"]) if "controller" in content else None
        stop, step = (
            self.attempt(_time, f"scenario: {key}", content[key]) if key in content else None
            for key in ("stop", "step")
        )
        sound = {name: history for name, history in histories.items() if history is not None}
        tolerance = content.get("tolerance")
        if len(self.problems) == before and stop is not None:
            return self.attempt(Scenario, stop, sound, step, tolerance, control) or self._inputs_of(sound)
        found = self.attempt(Scenario, 1.0 if stop is None else stop, sound, None, tolerance, control)
        return found or self._inputs_of(sound)

    @staticmethod
    def _inputs_of(histories: Mapping[str, History]) -> Scenario | None:
        """A scenario of the names of inputs, which can be checked further."""
        try:
            return Scenario(1.0, {name: History([0.0], [0.0]) for name in histories})
        except StudyError:
            return None

    def _history(self, name: str, content: Any, units: Units) -> History:  # noqa: ANN401
        where = f"scenario: {name}"
        if not isinstance(content, Mapping):
            content = {"time": [0.0], "value": [content]}
        found = dict(content)
        known: Callable[[], str] = lambda: units().get(name) or "1"  # noqa: E731
        for key in ("time", "value"):
            if key in found:
                own = (lambda: "s") if key == "time" else known
                found[key] = [_number(f"{where}: {key}", each, own) for each in found[key]]
        for key, own in (
            ("mean", known),
            ("amplitude", known),
            ("frequency", lambda: "Hz"),
            ("phase", lambda: "rad"),
        ):
            if key in found:
                found[key] = _number(f"{where}: {key}", found[key], own)
        return History(**found)


def read_plan(content: Mapping[str, Any], folder: Path, units: Units) -> Plan:
    """The plan of a table in a file of this folder. StudyError with all mistakes."""
    from dualcam.study.schema import PLAN

    reading = Reading(folder)
    plan = reading.plan(reading.validated(PLAN, content, "plan", ("plan",)), units)
    refuse(reading.problems)
    assert plan is not None
    return plan


def read_scenario(content: Mapping[str, Any], folder: Path, units: Units) -> Scenario:
    """The scenario of a table in a file of this folder. StudyError with all mistakes."""
    from dualcam.study.schema import SCENARIO

    reading = Reading(folder)
    scenario = reading.scenario(reading.validated(SCENARIO, content, "scenario", ("scenario",)), units)
    refuse(reading.problems)
    assert scenario is not None
    return scenario


def _correlation(content: Mapping[str, Any]) -> Correlation:
    of = list(content["of"])
    if len(of) != 2:
        raise StudyError(f"plan: correlation of {', '.join(of)}: allowed are two names")
    kinds = [kind for kind in ("rank", "pearson") if kind in content]
    if len(kinds) != 1:
        raise StudyError(f"plan: correlation of {' and '.join(of)}: allowed is one of rank and pearson")
    return Correlation(of[0], of[1], float(content[kinds[0]]), kinds[0])


def _names_in(content: Any) -> set[str]:  # noqa: ANN401
    """What looks like a name in any text."""
    if isinstance(content, str):
        return set(re.findall(r"[A-Za-z_][\w.]*", content))
    if isinstance(content, Mapping):
        return {name for each in content.values() for name in _names_in(each)}
    return {name for each in content for name in _names_in(each)} if isinstance(content, list) else set()


def _texts(formulas: Mapping[str, Any]) -> dict[str, str]:
    """Formulas; a number is one."""
    return {name: str(text) for name, text in formulas.items()}


def _are_names(values: Iterable[object]) -> bool:
    """Whether none of the values is a number, or a text with one: they are texts for a law."""
    return all(isinstance(value, str) and not value[:1].strip("+-.").isdigit() for value in values)


def _time(where: str, value: Any) -> Any:  # noqa: ANN401
    return _number(where, value, lambda: "s")


def _number(where: str, value: Any, unit: Callable[[], str]) -> Any:  # noqa: ANN401
    """A number or a formula; a text with a unit becomes a number."""
    if not isinstance(value, str) or is_formula(value):
        return value
    return in_unit(where, value, unit())


def _controller(content: Mapping[str, Any]) -> Controller:
    module, _, function = content["create_law"].partition(":")
    try:
        create_law = getattr(importlib.import_module(module), function)
    except (ImportError, AttributeError, ValueError) as error:
        raise StudyError(
            f"controller: create_law = {content['create_law']!r}: allowed is module:function: {error}"
        ) from error
    arguments = {
        name: value
        if not isinstance(value, str) or is_formula(value)
        else in_si(f"controller: {name}", value)
        for name, value in content.get("arguments", {}).items()
    }
    period = _time("controller: period", content["period"])
    return Controller(create_law, period, content["reads"], content["writes"], arguments)


# ---- words for what the schema refuses ----


def _where(place: tuple[int | str, ...], whole: str) -> str:
    """The name of a table in messages."""
    match place:
        case ():
            return whole
        case ("plan", "vary", str(name), *_):
            return f"plan: {name}"
        case ("plan", "correlation", int(number), *_):
            return f"plan: correlation {number + 1}"
        case ("scenario", "inputs", str(name), *_):
            return f"scenario: {name}"
        case ("scenario", "controller", *_):
            return "controller"
    return ": ".join(map(str, place))


def _words(
    problem: Mapping[str, Any], place: tuple[int | str, ...], whole: str, fields: Collection[str]
) -> str:
    value = problem["input"]
    where, key = _where(place[:-1], whole), place[-1]
    if problem["type"] == "extra_forbidden":
        return f"{where} has {key}{hint(str(key), fields)}"
    if problem["type"] == "kind":
        allowed = problem["ctx"]["words"]
    elif problem["type"] == "list_type":
        allowed = "a list of tables"
    else:
        allowed = "a table"
    shown = f"{value!r}" if len(repr(value)) <= 60 else f"{repr(value)[:57]}..."
    start = f"{where}: " if where != whole else ""
    return f"{start}{key} = {shown}: allowed is {allowed}"


def _fields(kind: Any, place: tuple[int | str, ...]) -> list[str]:  # noqa: ANN401
    """The keys of the table at a place, which the schema may allow no table at all."""
    for key in place:
        kind = _plain(kind)
        if hasattr(kind, "model_fields"):
            field = kind.model_fields.get(key)
            kind = field.annotation if field else None
        else:
            arguments = getattr(kind, "__args__", None)
            kind = arguments[-1] if arguments else None
    return list(getattr(_plain(kind), "model_fields", ()))


def _plain(kind: Any) -> Any:  # noqa: ANN401
    """A type without what Annotated says about it."""
    return kind.__origin__ if hasattr(kind, "__metadata__") else kind


def _without(content: Any, place: tuple[int | str, ...]) -> Any:  # noqa: ANN401
    """The content without the entry at a place."""
    first, *rest = place
    if isinstance(content, Mapping):
        if first not in content:
            return content
        others = {name: value for name, value in content.items() if name != first}
        return {**others, first: _without(content[first], tuple(rest))} if rest else others
    if isinstance(content, list) and isinstance(first, int) and first < len(content):
        return [
            _without(each, tuple(rest)) if k == first else each
            for k, each in enumerate(content)
            if rest or k != first
        ]
    return content
