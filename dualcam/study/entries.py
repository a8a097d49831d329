"""Tables that users write: which entries they may have, and of what kind."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

from dualcam.study.problem import StudyError


@dataclass(frozen=True)
class Kind:
    """What a value must be, in words, and whether one is that."""

    words: str
    suits: Callable[[Any], bool]

    def listed(self) -> Kind:
        """A list of one or more of these."""
        return Kind(
            f"a list of {self.words.removeprefix('a ')}s, at least one",
            lambda value: isinstance(value, list | tuple) and len(value) > 0 and all(map(self.suits, value)),
        )


def is_whole(value: object) -> bool:
    return hasattr(value, "__index__") and not isinstance(value, bool)


def hint(name: str, known: Iterable[str]) -> str:
    """The end of a message about an unknown name: what could be meant, or what is allowed."""
    allowed = list(known)
    close = get_close_matches(str(name), allowed, n=2, cutoff=0.6)
    return f": did you mean {' or '.join(close)}?" if close else f": allowed are {', '.join(allowed)}"


NUMBER = Kind("a number", lambda value: isinstance(value, int | float) and not isinstance(value, bool))
WHOLE = Kind("a whole number", is_whole)
SWITCH = Kind("true or false", lambda value: isinstance(value, bool))
# Texts with a unit are read once the variable is known.
QUANTITY = Kind(
    'a number, or text with a unit such as "40 deg"',
    lambda value: isinstance(value, str) or NUMBER.suits(value),
)
VALUES = Kind(  # true and false are those of a Boolean variable
    'a list of numbers, or of texts with a unit such as "40 deg", at least one',
    Kind("", lambda value: isinstance(value, int | float | str)).listed().suits,
)
SCENARIO_NUMBER = Kind(  # which of the three a text is, is known once the names that vary are
    'a number, a text with a unit such as "10 ms", or a formula such as "2 * peak"',
    QUANTITY.suits,
)
TEXT = Kind("a text", lambda value: isinstance(value, str))
TABLE = Kind("a table", lambda value: isinstance(value, Mapping))
NUMBERS_BY_NAME = Kind(
    "a table of formulas or numbers, by name",
    lambda value: isinstance(value, Mapping) and all(map(QUANTITY.suits, value.values())),
)
QUANTITIES_BY_NAME = Kind(
    'a table of numbers, or of texts with a unit such as "2 mm", by name', NUMBERS_BY_NAME.suits
)


def entries(content: object, where: str, kinds: Mapping[str, Kind], needed: Collection[str] = ()) -> Any:  # noqa: ANN401
    """The table itself. StudyError if it is none, or has other entries, too few, or one of another kind."""
    if not isinstance(content, Mapping):
        raise StudyError(f"{where} is {content!r}: allowed is a table with {', '.join(kinds)}")
    if unknown := sorted(set(content) - set(kinds)):
        raise StudyError(f"{where} has {', '.join(unknown)}: allowed are {', '.join(kinds)}")
    if lacking := sorted(set(needed) - set(content)):
        raise StudyError(f"{where} lacks {', '.join(lacking)}")
    for name, value in content.items():
        if not kinds[name].suits(value):
            raise StudyError(f"{where}: {name} = {value!r}: allowed is {kinds[name].words}")
    return content
