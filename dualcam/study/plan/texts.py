"""Texts that a String parameter gets, such as the groove tables of a study, on any machine.

A row of a plan has the place of a text in its list, so that rows are arrays of numbers. Files that travel
with a study are kept for the process that reads them, in a folder of its own, which the end of the process
deletes. A process that is killed leaves its folder behind, but not the lock of the folder: the next process
that needs such files sees that, and deletes the folder."""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import tempfile
import uuid
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Protocol, runtime_checkable

from filelock import FileLock, Timeout

from dualcam.common.mistakes import StudyError

LOCK = ".lock"


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
    """Texts, or absolute paths of files. A text that names a file travels with the content."""

    texts: tuple[str, ...]
    contents: dict[int, bytes] = field(default_factory=dict, repr=False)  # of the files, by the place

    @classmethod
    def of(cls, texts: Sequence[str], folder: Path | None = None) -> GivenTexts:
        """Texts of a list. The content of a file in `folder`, or else in the current one, is kept."""
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
        digests = {place: hashlib.sha256(each).hexdigest() for place, each in self.contents.items()}
        names = enumerate(self.texts)
        return [f"{Path(text).name} {digests[k]}" if k in digests else text for k, text in names]


# ---- files that travelled ----


def is_file(path: Path, content: bytes) -> bool:
    """Whether there is a file of that content."""
    try:
        return path.stat().st_size == len(content) and path.read_bytes() == content
    except OSError:
        return False


def kept_file(name: str, content: bytes) -> Path:
    """A file of that content, which is there until this process ends. StudyError if it cannot be written."""
    digest = hashlib.sha256(content).hexdigest()[:16]
    file = f"{Path(name).stem[:40]}-{digest}.csv"
    folder = Path(tempfile.gettempdir())
    try:
        folder = _own_folder(os.getpid())
        folder.mkdir(parents=True, exist_ok=True)  # temporary folders are tidied while processes live
        path = folder / file
        if not is_file(path, content):
            unfinished = path.with_suffix(f".{uuid.uuid4().hex}")
            unfinished.write_bytes(content)
            unfinished.replace(path)  # whole or not at all: other threads may read the file
    except OSError as error:
        raise StudyError(f"the table {folder / file} cannot be written: {error.strerror or error}") from error
    return path


@cache
def _own_folder(process: int) -> Path:
    """The folder of this process; a fork has another number, and another folder."""
    user = os.getuid() if hasattr(os, "getuid") else "own"
    parent = Path(tempfile.gettempdir()) / f"dualcam-{user}" / "study-tables"
    parent.mkdir(parents=True, exist_ok=True)
    delete_abandoned(parent)
    folder = parent / f"{process}-{uuid.uuid4().hex}"
    lock = FileLock(f"{folder}{LOCK}")
    with suppress(NotImplementedError):  # a file system without locks: nobody takes the folder for abandoned
        lock.acquire(blocking=False)
    atexit.register(_delete_own, process, folder, lock)
    return folder


def _delete_own(process: int, folder: Path, lock: FileLock) -> None:
    if os.getpid() == process:  # not in a fork
        shutil.rmtree(folder, ignore_errors=True)
        lock.release()
        Path(lock.lock_file).unlink(missing_ok=True)


def delete_abandoned(parent: Path) -> None:
    """Delete the folders whose processes live no more."""
    for path in parent.glob(f"*{LOCK}"):
        lock = FileLock(path)
        with suppress(Timeout, NotImplementedError, OSError):
            lock.acquire(blocking=False)
            shutil.rmtree(path.with_suffix(""), ignore_errors=True)
            lock.release()
            path.unlink(missing_ok=True)
