"""What is wrong with a study as a whole: all mistakes, each with its place."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import MISSING, fields
from typing import Any, TypeVar

from dualcam.errors import DualcamError, FmuError

Place = tuple[str | int, ...]  # keys on the way through a file, such as ("plan", "vary", "push")
Made = TypeVar("Made")


class StudyError(FmuError):
    """This study cannot be made, or not be continued; the message says what to do.

    Attributes
    ----------
    problems : tuple of str
        All that is wrong, one text each; a single one for most errors.
    """

    def __init__(self, message: str, problems: Sequence[str] = ()) -> None:
        super().__init__(message)
        self.problems = tuple(problems) or (message,)

    def __reduce__(self) -> tuple[type[StudyError], tuple[str, tuple[str, ...]]]:
        return type(self), (str(self), self.problems)


class Findings:
    """All that is wrong with a study, by the place in its file.

    A check notes what it finds, and leaves out what depends on a place that is not sound: one mistake gives
    one message.

    Attributes
    ----------
    problems : list of str
        The messages, in the order of the checks.

    Examples
    --------
    >>> from dualcam.study.problem import Findings
    >>> findings = Findings()
    >>> findings.note(("plan", "vary", "push", "from"), "plan: push: from = '5 ells': not known")
    >>> findings.is_sound("plan", "vary", "push"), findings.is_sound("plan", "vary", "peak")
    (False, True)
    """

    def __init__(self) -> None:
        self.problems: list[str] = []
        self._broken: set[Place] = set()

    def note(self, place: Place, *problems: str) -> None:
        """Problems at a place, which is then not sound."""
        self.problems += [text for text in problems if text not in self.problems]
        if problems:
            self._broken.add(place)

    def spoil(self, *place: str | int) -> None:
        """The place depends on a mistake at another one: no message of its own."""
        self._broken.add(place)

    def is_sound(self, *place: str | int) -> bool:
        """Whether nothing is wrong at a place, within it, and around it."""
        return not any(
            broken[: len(place)] == place[: len(broken)] for broken in self._broken if broken or not place
        )

    def attempt(self, place: Place, function: Callable[..., Made], *arguments: Any) -> Made | None:  # noqa: ANN401
        """What the function gives; None, and its problems, if the call is refused."""
        try:
            return function(*arguments)
        except StudyError as error:
            self.note(place, *error.problems)
        except DualcamError as error:
            self.note(place, str(error))
        return None

    def refuse(self, where: str = "") -> None:
        """StudyError with all problems at once, if there are any."""
        refuse(self.problems, where)


def unchecked(of: type[Made], /, **values: Any) -> Made:  # noqa: ANN401
    """An object of a dataclass whose values may be wrong: the checks of all parts then look at it at once."""
    made = object.__new__(of)
    for each in fields(of):  # type: ignore[arg-type]
        value = values.get(each.name, each.default)
        if value is MISSING:
            make = each.default_factory
            assert callable(make), each.name
            value = make()
        object.__setattr__(made, each.name, value)
    return made


def refuse(problems: Iterable[str], where: str = "") -> None:
    """StudyError with all problems at once, if there are any.

    `where` names the file, and stands before all of them."""
    found = list(dict.fromkeys(problems))
    if not found:
        return
    before = f"{where}: " if where else ""
    if len(found) == 1:
        raise StudyError(before + found[0], found)
    raise StudyError("\n".join([f"{before}{len(found)} mistakes", *(f"  {text}" for text in found)]), found)
