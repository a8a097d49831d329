"""What is wrong with a study: all mistakes of a stage at once.

The stages are the schema of a file, the values in it, and what the FMU says. A later one begins where the one
before finds nothing."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from dualcam.errors import DualcamError, StudyError

Made = TypeVar("Made")


class Findings:
    """All that is wrong in one stage of the checks of a study."""

    def __init__(self) -> None:
        self.problems: list[str] = []

    def note(self, *problems: str) -> None:
        self.problems += [text for text in problems if text not in self.problems]

    def attempt(self, function: Callable[..., Made], *arguments: Any, **named: Any) -> Made | None:  # noqa: ANN401
        """What the function gives; None, and its problems, if the call is refused."""
        try:
            return function(*arguments, **named)
        except StudyError as error:
            self.note(*error.problems)
        except DualcamError as error:
            self.note(str(error))
        return None

    def refuse(self) -> None:
        """StudyError with all problems at once, if there are any."""
        refuse(self.problems)

    def result(self, made: Made | None) -> Made:
        """What an attempt has made. StudyError with all problems at once, if there are any."""
        self.refuse()
        assert made is not None
        return made


@contextmanager
def told_of(path: Path) -> Iterator[None]:
    """What is refused within is said of this file."""
    try:
        yield
    except StudyError as error:
        problems = error.problems
    else:
        return
    refuse(problems, str(path))


def refuse(problems: Iterable[str], where: str = "") -> None:
    """StudyError with all problems at once, if there are any, after `where`, the file."""
    found = list(dict.fromkeys(problems))
    if not found:
        return
    before = f"{where}: " if where else ""
    if len(found) == 1:
        raise StudyError(before + found[0], found)
    raise StudyError("\n".join([f"{before}{len(found)} mistakes", *(f"  {text}" for text in found)]), found)


def optional_module(name: str, advice: str) -> Any:  # noqa: ANN401
    """A module of another package. StudyError with the advice if it is not installed."""
    try:
        return import_module(name)
    except ImportError:
        raise StudyError(advice) from None
