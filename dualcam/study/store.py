"""Results on disk: a folder with one file per chunk of runs, complete or absent, and study.json, which says
what study they are of. A chunk comes into being by renaming a finished file, so an interruption leaves no
half of one; its name holds a checksum (CRC-32) of its content. A study that is continued makes exactly the
chunks that are not there, or that something else has damaged since. One study at a time writes into a folder.
"""

from __future__ import annotations

import csv
import importlib
import importlib.util
import io
import json
import os
import sys
import zlib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dualcam.fmu import Array
from dualcam.study.problem import StudyError
from dualcam.study.runner import Block

FORMATS = ("parquet", "csv")
RECORD = "study.json"
Column = NDArray[Any]


def default_format() -> str:
    return "parquet" if importlib.util.find_spec("pyarrow") else "csv"


class Store:
    """The folder of one study."""

    def __init__(
        self, folder: str | Path, facts: dict[str, Any], runs: int, chunk: int, file_format: str | None
    ) -> None:
        """Opens it, or makes it. StudyError if it holds runs of another study, if another process writes
        there, or if it cannot be written. A study begun earlier keeps its size of chunks and its format."""
        self.folder = Path(folder)
        self.runs = runs
        self.damaged: dict[int, Path] = {}  # by their first run, found by `missing`
        facts = json.loads(json.dumps(facts))  # as it is read back
        file_format = file_format or default_format()
        if file_format not in FORMATS:
            raise StudyError(f"file_format = {file_format!r}: allowed are {', '.join(FORMATS)}")
        begun = _record(self.folder)
        _check_writer(begun["format"] if begun else file_format)  # before the folder is made
        self._lock = self._locked()
        try:
            begun = _record(self.folder)  # another process may have been there before the lock
            begun = self._begin(begun, {"study": facts, "runs": runs, "chunk": chunk, "format": file_format})
        except StudyError:
            self.close()
            raise
        self.chunk, self.file_format = int(begun["chunk"]), str(begun["format"])

    def _begin(self, begun: dict[str, Any] | None, wanted: dict[str, Any]) -> dict[str, Any]:
        """The record that holds: the one that is there, if runs are."""
        differing = [] if begun is None else _differing(begun["study"], wanted["study"])
        if begun is not None and not differing:
            return begun
        if differing and any(self.folder.glob("runs-*")):
            raise StudyError(
                f"{self.folder} holds runs of another study (other {', '.join(differing)}): give another "
                "folder, or delete it"
            )
        self._write(self.folder / RECORD, json.dumps(wanted, indent=1).encode())
        return wanted

    def _locked(self) -> int | None:
        """A handle of the folder with an advisory lock on it, which ends with the process, whatever ends
        that; None where file systems or Windows have no such locks."""
        if sys.platform == "win32":
            return None
        import fcntl

        self._make_folder()
        handle = os.open(self.folder, os.O_RDONLY)
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            os.close(handle)
            raise StudyError(
                f"another process is writing a study into {self.folder}: wait for its end, or give another "
                "folder"
            ) from None
        except OSError:  # such as NFS without locks
            os.close(handle)
            return None
        return handle

    def close(self) -> None:
        """Others may write there now."""
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None

    def missing(self) -> list[range]:
        """Runs not yet made, chunk by chunk."""
        starts = range(0, self.runs, self.chunk)
        chunks = [range(start, min(start + self.chunk, self.runs)) for start in starts]
        return [runs for runs in chunks if not self._holds(runs)]

    def _holds(self, runs: range) -> bool:
        for path in self.folder.glob(f"runs-{runs.start:09d}-*.{self.file_format}"):
            try:
                _content(path)
            except StudyError:
                self.damaged[runs.start] = path
            else:
                return True
        return False

    def write(
        self, runs: range, names: Sequence[str], rows: Array, results: Sequence[str], block: Block
    ) -> None:
        """One chunk. StudyError if it cannot be written; what was written before it stays."""
        messages = [block.messages.get(place, "") for place in range(len(runs))]
        columns = [*rows.T, *block.values.T]
        if self.file_format == "parquet":
            content = _parquet(["run", *names, *results, "message"], [np.array(runs), *columns, messages])
        else:
            content = _csv(
                ["run", *names, *results, "message"], [list(runs), *(c.tolist() for c in columns), messages]
            )
        if runs.start in self.damaged:
            self.damaged.pop(runs.start).unlink(missing_ok=True)
        self._write(self.folder / f"runs-{runs.start:09d}-{_checksum(content)}.{self.file_format}", content)

    def _make_folder(self) -> None:
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise StudyError(f"cannot make the folder {self.folder}: {error.strerror or error}") from error

    def _write(self, path: Path, content: bytes) -> None:
        unfinished = path.with_suffix(".unfinished")
        self._make_folder()
        try:
            with unfinished.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            unfinished.replace(path)
        except OSError as error:
            with suppress(OSError):
                unfinished.unlink()
            raise StudyError(
                f"cannot write {path}: {error.strerror or error}. The runs written before are kept: make "
                "room, or whatever it takes, and give the same command again"
            ) from error


def _check_writer(file_format: str) -> None:
    """StudyError if what writes this format is not installed."""
    if file_format == "parquet":
        _pyarrow()


def _parquet(names: Sequence[str], columns: Sequence[Any]) -> bytes:
    pyarrow, parquet = _pyarrow()
    sink = pyarrow.BufferOutputStream()
    parquet.write_table(pyarrow.table(dict(zip(names, columns, strict=True))), sink)
    return bytes(sink.getvalue())


def _csv(names: Sequence[str], columns: Sequence[list[Any]]) -> bytes:
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(names)
    writer.writerows(zip(*columns, strict=True))
    return text.getvalue().encode()


def _pyarrow() -> tuple[Any, Any]:
    try:
        return importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    except ImportError:
        raise StudyError("format parquet needs pyarrow: pip install pyarrow, or use format csv") from None


def _record(folder: Path) -> dict[str, Any] | None:
    path = folder / RECORD
    try:
        record: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        fit = record["format"] in FORMATS and int(record["chunk"]) > 0
        if not (fit and isinstance(record["study"], dict)):
            raise ValueError("its entries are not those of a study")
    except FileNotFoundError:
        return None
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise StudyError(f"{path} cannot be read: {error}: give another folder, or delete it") from error
    return record


def _differing(begun: dict[str, Any], facts: dict[str, Any], where: str = "") -> list[str]:
    """Entries, by their path. Compared as text: NaN, a range that is not given, differs from itself."""
    found = []
    for key in [*facts, *(key for key in begun if key not in facts)]:
        old, new = begun.get(key), facts.get(key)
        if isinstance(old, dict) and isinstance(new, dict):
            found += _differing(old, new, f"{where}{key}: ")
        elif json.dumps(old) != json.dumps(new):
            found.append(where + key)
    return found


def read_results(folder: str | Path, columns: Sequence[str] | None = None) -> dict[str, Column]:
    """The results of a study as one table, in the order of the runs.

    Parameters
    ----------
    folder : str or Path
        Folder of the study.
    columns : sequence of str, optional
        Names of columns. None: all.

    Returns
    -------
    dict of str to ndarray, shape (runs,)
        Columns by name: `run` (number of the run, from 0), the values that vary and the results in the FMU's
        units, and `message` (why the run failed, or empty). Results of a failed run are NaN.

    Raises
    ------
    StudyError
        The folder holds no runs, a file is damaged, or there is no such column.

    Examples
    --------
    >>> import tempfile
    >>> from dualcam.study import Plan, Scenario, Study, Vary, read_results
    >>> plan = Plan("grid", {"spring.preload": Vary(values=[50.0, 60.0])})  # N
    >>> study = Study("forward", plan, Scenario(0.1), ["torque_load"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = study.run(folder, workers=0)
    ...     table = read_results(folder, ["run", "torque_load"])
    >>> table["torque_load"].round(4).tolist()  # N.m
    [0.6628, 0.7953]
    """
    folder = Path(folder)
    record = _record(folder)
    if record is None:
        raise StudyError(f"{folder} holds no study: there is no {RECORD}")
    paths = sorted(folder.glob(f"runs-{'[0-9]' * 9}-*.{record['format']}"))
    if not paths:
        raise StudyError(f"{folder} holds no runs yet")
    wanted = None if columns is None else list(dict.fromkeys(columns))
    parts = [_part(path, wanted) for path in paths]
    if lacking := [name for name in wanted or () if name not in parts[0]]:
        raise StudyError(f"{folder} has no column {', '.join(lacking)}")
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _checksum(content: bytes) -> str:
    return f"{zlib.crc32(content):08x}"


def _content(path: Path) -> bytes:
    """StudyError if it is not as it was written."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise StudyError(f"{path} cannot be read: {error.strerror or error}") from error
    if not path.stem.endswith(f"-{_checksum(content)}"):
        raise StudyError(f"{path} is damaged: run the study again, which makes these runs anew")
    return content


def _part(path: Path, columns: Sequence[str] | None) -> dict[str, Column]:
    """A chunk's columns."""
    return (_of_parquet if path.suffix == ".parquet" else _of_csv)(_content(path), columns)


def _of_parquet(content: bytes, columns: Sequence[str] | None) -> dict[str, Column]:
    # With threads Arrow can abort or hang the process at its end (apache/arrow, issues 33975 and 34314).
    without_threads = {"use_threads": False, "pre_buffer": False}
    table = _pyarrow()[1].read_table(io.BytesIO(content), columns=columns, **without_threads)
    return {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}


def _of_csv(content: bytes, columns: Sequence[str] | None) -> dict[str, Column]:
    names, *rows = csv.reader(io.StringIO(content.decode(), newline=""))
    wanted = [name for name in names if columns is None or name in columns]
    by_name = dict(zip(names, zip(*rows, strict=True), strict=True))
    return {name: _parsed(name, by_name[name]) for name in wanted}


def _parsed(name: str, cells: Sequence[str]) -> Column:
    if name == "message":
        return np.array(cells, dtype=object)
    return np.array(cells, dtype=np.int64 if name == "run" else np.float64)
