"""Tables of a file as the schema allows them, and words for what it refuses."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from difflib import get_close_matches
from typing import Any

from dualcam.study.entries import NUMBERS_BY_NAME, QUANTITIES_BY_NAME, QUANTITY, hint
from dualcam.study.problem import Findings, Place

BY_NAME = (NUMBERS_BY_NAME.words, QUANTITIES_BY_NAME.words)
# Tables whose names count, and what is left of an entry that is refused.
NAMED: dict[Place, Any] = {
    ("plan", "vary"): {},
    ("plan", "derived"): "0",
    ("plan", "constraints"): "1",
    ("scenario", "inputs"): {},
    ("scenario", "controller", "arguments"): 0.0,
    ("optimise", "constraints"): {},
    ("optimise", "objectives"): "",
    ("optimise", "tolerances"): {},
    ("optimise", "start"): 0.0,
}
COUNTED = ("kind", "runs")  # keys of [plan] that an unknown key may stand for


def validated(
    model: Any,  # noqa: ANN401
    content: Mapping[str, Any],
    where: str,
    findings: Findings,
) -> dict[str, Any]:
    """The content without what the model refuses. `where` names the whole table."""
    from pydantic import ValidationError

    left = dict(content)
    try:
        model.model_validate(left)
    except ValidationError as error:
        problems = error.errors(include_url=False)
        for problem in problems:
            place = problem["loc"]
            if problem["type"] == "extra_forbidden":
                _spoil_meant(place, _fields(model, place[:-1]), findings)
        for problem in problems:
            place = problem["loc"]
            if problem["type"] == "missing" or (place[0] == "plots" and len(place) > 1):
                continue  # each kind of picture has keys of its own, which are checked later
            strange = _strange_entries(problem)
            for name in strange:
                shown = _shown(problem["input"][name])
                text = f"{_where((*place, name), where)} = {shown}: allowed is a number or a text"
                findings.note((*place, name), text)
                left = _without(left, (*place, name))
            if not strange:
                findings.note(place, _words(problem, where, _fields(model, place[:-1])))
                left = _without(left, place)
        _note_lacking(
            [problem["loc"] for problem in problems if problem["type"] == "missing"], where, findings
        )
    return left


def _strange_entries(problem: Mapping[str, Any]) -> list[str]:
    """Which entries of a table by name are of another kind; none of what is no such table."""
    is_table = problem["type"] == "kind" and problem["ctx"]["words"] in BY_NAME
    content = problem["input"] if is_table and isinstance(problem["input"], Mapping) else {}
    return [name for name, value in content.items() if not QUANTITY.suits(value)]


def _spoil_meant(place: Place, fields: Collection[str], findings: Findings) -> None:
    """An unknown key may be a key that the table lacks: the lack is then no mistake of its own."""
    close = get_close_matches(str(place[-1]), fields, n=2, cutoff=0.6)
    for key in close or (COUNTED if place[:-1] == ("plan",) else ()):
        findings.spoil(*place[:-1], key, "given")


def is_lacking(place: Place, findings: Findings) -> bool:
    """Whether a key that is not there lacks, rather than that another key stands for it."""
    return findings.is_sound(*place, "given")


def _note_lacking(places: Collection[Place], where: str, findings: Findings) -> None:
    lacking: dict[Place, list[str]] = {}
    for place in places:
        if place[0] != "plots" and is_lacking(place, findings):
            lacking.setdefault(place[:-1], []).append(str(place[-1]))
    for table, keys in lacking.items():
        findings.note((*table, keys[0]), f"{_where(table, where)} lacks {', '.join(sorted(keys))}")
        for key in keys:
            findings.spoil(*table, key)


def _where(place: Place, whole: str) -> str:
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
        case ("optimise", "constraints", str(name), *_):
            return f"optimise: constraint {name}"
    return ": ".join(map(str, place))


def _words(problem: Mapping[str, Any], whole: str, fields: Collection[str]) -> str:
    place, value = problem["loc"], problem["input"]
    where, key = _where(place[:-1], whole), place[-1]
    if problem["type"] == "extra_forbidden":
        return f"{where} has {key}{hint(str(key), fields)}"
    if problem["type"] == "kind":
        allowed = problem["ctx"]["words"]
    elif problem["type"] == "list_type":
        allowed = "a list of tables"
    else:
        allowed = "a table"
    start = f"{where}: " if where != whole else ""
    return f"{start}{key} = {_shown(value)}: allowed is {allowed}"


def _shown(value: object) -> str:
    """A value, short."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _fields(kind: Any, place: Place) -> list[str]:  # noqa: ANN401
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


def _without(content: Any, place: Place, within: Place = ()) -> Any:  # noqa: ANN401
    """The content without the entry at a place; `within` is that of the content.

    A list keeps its length: an empty table is left."""
    first, *rest = place
    if isinstance(content, Mapping):
        if first not in content:
            return content
        others = {name: value for name, value in content.items() if name != first}
        if rest:
            return {**others, first: _without(content[first], tuple(rest), (*within, first))}
        return {**others, first: NAMED[within]} if within in NAMED else others
    if isinstance(content, list) and isinstance(first, int) and first < len(content):
        left = _without(content[first], tuple(rest), (*within, first)) if rest else {}
        return [left if k == first else each for k, each in enumerate(content)]
    return content
