"""Files that the runs of this process read, such as groove tables that travel with a study.

Each process has a folder of its own, which the end of the process deletes. A process that is killed leaves
its folder behind. The system has then released the lock of the folder. The next process that needs such files
sees that, and deletes the folder."""

from __future__ import annotations

import atexit
import hashlib
import os
import shutil
import tempfile
import uuid
from contextlib import suppress
from functools import cache
from pathlib import Path

from filelock import FileLock, Timeout

from dualcam.common.mistakes import StudyError

LOCK = ".lock"


def is_file(path: Path, content: bytes) -> bool:
    """Whether there is a file of that content."""
    try:
        return path.stat().st_size == len(content) and path.read_bytes() == content
    except OSError:
        return False


def kept_file(name: str, content: bytes) -> Path:
    """A file of that content, which is there until this process ends; its name has a hash of the content.

    StudyError if the file cannot be written."""
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
