"""Tables that users write: which entries they may have, and of what kind."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from numbers import Integral
from typing import Any, TypeGuard

LISTED = 12  # names in a message


@dataclass(frozen=True)
class Kind:
    """What a value must be, in words and as JSON Schema, and whether one is that."""

    words: str
    suits: Callable[[Any], bool]
    json: Mapping[str, Any] = field(default_factory=dict)

    def listed(self) -> Kind:
        """A list of one or more of these."""
        is_short = "," not in self.words
        each = (
            f"{self.words.removeprefix('a ')}s, at least one" if is_short else f"one or more of: {self.words}"
        )
        return Kind(
            f"a list of {each}",
            lambda value: isinstance(value, list | tuple) and len(value) > 0 and all(map(self.suits, value)),
            {"type": "array", "items": self.json, "minItems": 1},
        )


def is_whole(value: object) -> TypeGuard[int]:
    """Whether a value is a whole number; no array is."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def repeated(names: Iterable[object]) -> list[str]:
    """The texts that stand there more than once."""
    counts = Counter(name for name in names if isinstance(name, str))
    return [name for name, count in counts.items() if count > 1]


def hint(name: str, known: Iterable[str]) -> str:
    """The end of a message about an unknown name: what could be meant, or what is allowed."""
    allowed = list(dict.fromkeys(known))
    if close := get_close_matches(str(name), allowed, n=2, cutoff=0.6):
        return f": did you mean {' or '.join(close)}?"
    more = f" and {len(allowed) - LISTED} more" if len(allowed) > LISTED else ""
    return f": allowed are {', '.join(allowed[:LISTED])}{more}"


_NUMBER_OR_TEXT = {"type": ["number", "string"]}
_BY_NAME = {"type": "object", "additionalProperties": _NUMBER_OR_TEXT}
NUMBER = Kind(
    "a number",
    lambda value: isinstance(value, int | float) and not isinstance(value, bool),
    {"type": "number"},
)
WHOLE = Kind("a whole number", is_whole, {"type": "integer"})
SWITCH = Kind("true or false", lambda value: isinstance(value, bool), {"type": "boolean"})
# Texts with a unit are read once the variable is known.
QUANTITY = Kind(
    'a number, or text with a unit such as "40 deg"',
    lambda value: isinstance(value, str) or NUMBER.suits(value),
    _NUMBER_OR_TEXT,
)
_VALUE = Kind("", lambda one: isinstance(one, int | float | str), {"type": ["number", "string", "boolean"]})
VALUES = replace(  # true and false are those of a Boolean variable
    _VALUE.listed(), words='a list of numbers, or of texts with a unit such as "40 deg", at least one'
)
SCENARIO_NUMBER = replace(  # which of the three a text is, is known once the names that vary are
    QUANTITY, words='a number, a text with a unit such as "10 ms", or a formula such as "2 * peak"'
)
TEXT = Kind("a text", lambda value: isinstance(value, str), {"type": "string"})
TABLE = Kind("a table", lambda value: isinstance(value, Mapping), {"type": "object"})
NUMBERS_BY_NAME = Kind(
    "a table of formulas or numbers, by name",
    lambda value: isinstance(value, Mapping) and all(map(QUANTITY.suits, value.values())),
    _BY_NAME,
)
QUANTITIES_BY_NAME = replace(
    NUMBERS_BY_NAME, words='a table of numbers, or of texts with a unit such as "2 mm", by name'
)


def problems_of_entries(
    content: Mapping[str, Any], where: str, kinds: Mapping[str, Kind], needed: Collection[str] = ()
) -> list[str]:
    """What is wrong with the entries of a table: others than these, too few, or of another kind."""
    unknown = sorted(set(content) - set(kinds))
    found = [f"{where} has {name}{hint(name, kinds)}" for name in unknown]
    meant = {close for name in unknown for close in get_close_matches(name, kinds, n=2, cutoff=0.6)}
    if lacking := sorted(set(needed) - set(content) - meant):
        found.append(f"{where} lacks {', '.join(lacking)}")
    return found + [
        f"{where}: {name} = {value!r}: allowed is {kinds[name].words}"
        for name, value in content.items()
        if name in kinds and not kinds[name].suits(value)
    ]
