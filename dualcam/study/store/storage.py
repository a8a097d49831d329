"""Where the files of a study lie: a folder of this machine, or a store that fsspec knows by its URL.

A file appears whole or not at all: in a folder by renaming a finished file, in an object store because an
upload does so.
"""

import os
import uuid
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from filelock import FileLock, Timeout

from dualcam.common.mistakes import StudyError

UNFINISHED = ".unfinished"
Listed = tuple[int, int | None]  # size of a file [bytes], and when its content changed [ns]; None: not known
KEPT = "The runs written before are kept: make room, or whatever it takes, and give the same command again"


class Storage(Protocol):
    """A folder with files, by names such as `runs/runs-000000000.parquet`."""

    def make(self) -> None:
        """The folder exists. StudyError if it cannot be made."""

    def write(self, name: str, content: bytes | memoryview) -> int | None:
        """A whole file, in the place of another one of that name; its time as of `listing`. StudyError if it
        cannot be written."""

    def read(self, name: str) -> bytes:
        """FileNotFoundError if there is none of that name; another OSError if it cannot be read."""

    def listing(self, folder: str) -> dict[str, Listed]:
        """The files of a folder in this one, by name; without those that are unfinished."""

    def remove(self, name: str) -> None:
        """The file is there no more."""

    def tidy(self, folder: str) -> None:
        """Nothing unfinished is left of writers that were interrupted."""

    def open(self, name: str) -> Any:  # noqa: ANN401
        """What pyarrow reads: a path, or an open file."""

    @property
    def checks_itself(self) -> bool:
        """Whether damaged bytes are found where they are kept: nobody then reads all files again."""


@dataclass(frozen=True)
class Folder(Storage):
    """A folder of this machine, or of a file system that several machines share."""

    path: Path

    def __str__(self) -> str:
        return str(self.path)

    def make(self) -> None:
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StudyError(f"cannot make the folder {self.path}: {error.strerror or error}") from error

    def write(self, name: str, content: bytes | memoryview) -> int | None:
        path = self.path / name
        unfinished = path.with_name(f".{path.name}-{uuid.uuid4().hex}{UNFINISHED}")
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with unfinished.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
                changed = os.fstat(file.fileno()).st_mtime_ns
            unfinished.replace(path)
        except OSError as error:
            with suppress(OSError):
                unfinished.unlink()
            raise StudyError(f"cannot write {path}: {error.strerror or error}. {KEPT}") from error
        return changed

    def read(self, name: str) -> bytes:
        return (self.path / name).read_bytes()

    def listing(self, folder: str) -> dict[str, Listed]:
        try:
            with os.scandir(self.path / folder) as entries:
                found = {each.name: each.stat() for each in entries if not each.name.endswith(UNFINISHED)}
        except FileNotFoundError:
            return {}
        return {name: (each.st_size, each.st_mtime_ns) for name, each in found.items()}

    def remove(self, name: str) -> None:
        (self.path / name).unlink(missing_ok=True)

    def tidy(self, folder: str) -> None:
        for path in (self.path / folder).glob(f".*{UNFINISHED}"):
            path.unlink(missing_ok=True)

    def open(self, name: str) -> str:
        return str(self.path / name)

    checks_itself = False


@dataclass(frozen=True)
class ObjectStore(Storage):
    """A folder in a store that fsspec knows, such as s3://bucket/folder. Credentials are those of the
    environment of each process, as fsspec finds them."""

    url: str

    def __str__(self) -> str:
        return self.url

    def _files(self) -> tuple[Any, str]:
        import fsspec

        return fsspec.core.url_to_fs(self.url)  # fsspec keeps one object for each store

    def make(self) -> None:
        try:
            files, path = self._files()
            files.makedirs(path, exist_ok=True)
        except Exception as error:  # each store has its own
            raise StudyError(f"cannot use {self.url}: {error}") from error

    def write(self, name: str, content: bytes | memoryview) -> None:
        """The store knows when; the answer is None."""
        try:
            files, path = self._files()
            files.makedirs(f"{path}/{name}".rpartition("/")[0], exist_ok=True)
            files.pipe_file(f"{path}/{name}", bytes(content))
        except Exception as error:
            raise StudyError(f"cannot write {self.url}/{name}: {error}. {KEPT}") from error

    def read(self, name: str) -> bytes:
        files, path = self._files()
        content: bytes = files.cat_file(f"{path}/{name}")
        return content

    def listing(self, folder: str) -> dict[str, Listed]:
        files, path = self._files()
        try:
            found = files.ls(f"{path}/{folder}", detail=True, refresh=True)
        except FileNotFoundError:
            return {}
        return {
            each["name"].rpartition("/")[2]: (each["size"], None) for each in found if each["type"] == "file"
        }

    def remove(self, name: str) -> None:
        files, path = self._files()
        with suppress(FileNotFoundError):
            files.rm_file(f"{path}/{name}")

    def tidy(self, folder: str) -> None:
        """Uploads that were interrupted are never seen."""

    def open(self, name: str) -> Any:  # noqa: ANN401
        files, path = self._files()
        return files.open(f"{path}/{name}", "rb")

    checks_itself = True


def locked(path: Path, busy: str) -> FileLock | None:
    """A lock that ends with the process, whatever ends that; None where a file system has none. StudyError if
    the file cannot be made, or, with the text `busy`, if another process has the lock."""
    lock = FileLock(path)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        raise StudyError(busy) from None
    except NotImplementedError:  # such as NFS without locks
        return None
    except OSError as error:
        raise StudyError(f"cannot write {path}: {error.strerror or error}") from error
    return lock


def is_url(place: str | Path) -> bool:
    """Whether a place is the URL of a store, and no path."""
    return not isinstance(place, Path) and "://" in place


def storage_at(place: str | Path) -> Storage:
    """A folder, or the store of a URL such as s3://bucket/folder.

    StudyError if the store needs a package that is not installed."""
    text = str(place)
    if not is_url(place):
        return Folder(Path(place))
    if text.startswith("file://"):
        return Folder(Path(text.removeprefix("file://")))
    try:
        import fsspec

        fsspec.core.url_to_fs(text)
    except ImportError as error:
        raise StudyError(
            f'{text}: this store needs a package: {error}. pip install "dualcam[study]" has fsspec, and each '
            "store its own package, such as s3fs for s3://"
        ) from None
    except Exception as error:
        raise StudyError(f"{text} is no store that fsspec knows: {error}") from error
    return ObjectStore(text.rstrip("/"))
