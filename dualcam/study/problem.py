"""What is wrong with a study as a whole."""

from __future__ import annotations

from collections.abc import Sequence

from dualcam.errors import FmuError


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


def refuse(problems: Sequence[str], where: str = "") -> None:
    """StudyError with all problems at once, if there are any.

    `where` names the file, and stands before all of them."""
    if not problems:
        return
    found = list(dict.fromkeys(problems))
    before = f"{where}: " if where else ""
    if len(found) == 1:
        raise StudyError(before + found[0], found)
    raise StudyError("\n".join([f"{before}{len(found)} mistakes", *(f"  {text}" for text in found)]), found)
