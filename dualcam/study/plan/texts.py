"""Texts that a String parameter gets, such as the groove tables of a study, on any machine.

A row of a plan has the place of a text in its list, so that rows are arrays of numbers."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, runtime_checkable

from dualcam.study.plan.kept_files import is_file, kept_file


@runtime_checkable
class Texts(Protocol):
    """The texts of one String parameter."""

    def __len__(self) -> int:
        """How many texts there are."""

    def __getitem__(self, place: int) -> str:
        """The text at a place, from 0. The text of a file is a path that this machine can read."""

    def label(self, place: int) -> str:
        """The text in the table of results: the same on every machine."""

    def facts(self) -> list[str]:
        """What makes two lists the same, as plain data."""


@dataclass(frozen=True)
class GivenTexts:
    """Texts, or absolute paths of files, as they were given. A text that names a file travels with the
    content.

    Examples
    --------
    >>> from dualcam.study.plan.texts import GivenTexts
    >>> GivenTexts.of(["a", "b"])[1]
    'b'
    """

    texts: tuple[str, ...]
    contents: dict[int, bytes] = field(default_factory=dict, repr=False)  # of the files, by the place

    @classmethod
    def of(cls, texts: Sequence[str], folder: Path | None = None) -> GivenTexts:
        """Texts of a list. A relative path of a file in `folder`, or else in the current one, becomes an
        absolute one, and its content is kept."""
        found, contents = [], {}
        for place, text in enumerate(texts):
            path = (folder or Path()) / text
            try:
                contents[place] = path.read_bytes()
                found.append(str(path.absolute()))
            except (OSError, ValueError):  # no file: a text for the FMU, such as a file of its resources
                found.append(text)
        return cls(tuple(found), contents)

    def __len__(self) -> int:
        return len(self.texts)

    def __getitem__(self, place: int) -> str:
        text = self.texts[place]
        if place not in self.contents or is_file(Path(text), self.contents[place]):
            return text
        return str(kept_file(Path(text).name, self.contents[place]))

    def label(self, place: int) -> str:
        """The text as it was given, in the table of results: the same on every machine."""
        return self.texts[place]

    def facts(self) -> list[str]:
        """The texts; of a file its name and a hash of its content."""
        return [
            f"{Path(text).name} {hashlib.sha256(self.contents[place]).hexdigest()}"
            if place in self.contents
            else text
            for place, text in enumerate(self.texts)
        ]
