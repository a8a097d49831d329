"""The first stage of a file: what its schema refuses, in words."""

from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from typing import Any

from pydantic import ValidationError

from dualcam.common.entries import NUMBERS_BY_NAME, QUANTITIES_BY_NAME, QUANTITY, hint
from dualcam.common.mistakes import Findings
from dualcam.study.plot_keys import problems_of_keys

Place = tuple[str | int, ...]  # keys on the way through a file, such as ("plan", "vary", "push")
TABLES = {"list_type": "a list of tables"}  # by pydantic's word for what is none
BY_NAME = (NUMBERS_BY_NAME.words, QUANTITIES_BY_NAME.words)


def check_schema(model: Any, content: Mapping[str, Any], whole: str) -> None:  # noqa: ANN401
    """StudyError with all that the schema refuses in a file. `whole` names the whole file."""
    findings = Findings()
    try:
        model.model_validate(content)
    except ValidationError as error:
        found = error.errors(include_url=False)
        found = [each for each in found if each["loc"][0] != "plots" or len(each["loc"]) < 2]  # plot_keys
        meant = {place for each in found for place in _meant(model, each)}
        lacking: dict[Place, list[str]] = {}
        for each in found:
            if each["type"] == "missing" and each["loc"] not in meant:
                lacking.setdefault(each["loc"][:-1], []).append(str(each["loc"][-1]))
        findings.note(*(text for each in found for text in _words(model, each, whole)))
        for table, keys in lacking.items():
            findings.note(f"{_where(table, whole)} lacks {', '.join(sorted(keys))}")
    plots = content.get("plots")
    findings.note(*(problems_of_keys(plots) if isinstance(plots, list) else ()))
    findings.refuse()


def _meant(model: Any, problem: Mapping[str, Any]) -> Iterator[Place]:  # noqa: ANN401
    """The keys that an unknown key may stand for: their lack is then no mistake of its own."""
    if problem["type"] == "extra_forbidden":
        *table, key = problem["loc"]
        for close in get_close_matches(str(key), _fields(model, tuple(table)), n=2, cutoff=0.6):
            yield (*table, close)


def _words(model: Any, problem: Mapping[str, Any], whole: str) -> Iterator[str]:  # noqa: ANN401
    place, value, kind = problem["loc"], problem["input"], problem["type"]
    where, key = _where(place[:-1], whole), place[-1]
    allowed = problem["ctx"]["words"] if kind == "kind" else TABLES.get(kind, "a table")
    if kind == "extra_forbidden":
        yield f"{where} has {key}{hint(str(key), _fields(model, place[:-1]))}"
    elif allowed in BY_NAME and isinstance(value, Mapping):
        for name, each in value.items():
            if not QUANTITY.suits(each):
                yield f"{_where((*place, name), whole)} = {_shown(each)}: allowed is a number or a text"
    elif kind != "missing":
        start = f"{where}: " if where != whole else ""
        yield f"{start}{key} = {_shown(value)}: allowed is {allowed}"


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


def _shown(value: object) -> str:
    """A value, short."""
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _fields(kind: Any, place: Place) -> list[str]:  # noqa: ANN401
    """The keys of the table at a place, which the schema allows."""
    for key in place:
        kind = kind.model_fields[key].annotation if hasattr(kind, "model_fields") else kind.__args__[-1]
        kind = kind.__origin__ if hasattr(kind, "__metadata__") else kind  # without what Annotated says
    return list(kind.model_fields)
