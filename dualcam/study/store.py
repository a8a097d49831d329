"""Results on disk: a folder with one file per chunk of runs, complete or absent, and study.json, which says
what study they are of. A chunk comes into being by renaming a finished file, so an interruption leaves no
half of one, and a study that is continued makes exactly the chunks that are not there."""

from __future__ import annotations

import csv
import importlib
import importlib.util
import json
import os
from collections.abc import Iterator, Sequence
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
        self, folder: str | Path, facts: dict[str, Any], runs: int, chunk: int, form: str | None
    ) -> None:
        """Opens it, or makes it. StudyError if it holds another study, or cannot be written. A study begun
        earlier keeps its size of chunks and its format."""
        self.folder = Path(folder)
        self.runs = runs
        facts = json.loads(json.dumps(facts))  # as it is read back
        begun = _record(self.folder)
        if begun is None:
            begun = {"study": facts, "runs": runs, "chunk": chunk, "format": form or default_format()}
            if begun["format"] not in FORMATS:
                raise StudyError(f"format {form!r}: allowed are {', '.join(FORMATS)}")
            _check_writer(begun["format"])  # before the folder is made
            self._write(self.folder / RECORD, json.dumps(begun, indent=1).encode())
        elif begun["study"] != facts:
            differing = [key for key in facts if begun["study"].get(key) != facts[key]]
            raise StudyError(
                f"{self.folder} holds another study (its {', '.join(differing)} differ): give another "
                "folder, or delete it"
            )
        self.chunk, self.form = int(begun["chunk"]), str(begun["format"])
        _check_writer(self.form)

    def missing(self) -> list[range]:
        """Runs not yet made, chunk by chunk."""
        starts = range(0, self.runs, self.chunk)
        return [
            range(start, min(start + self.chunk, self.runs))
            for start in starts
            if not self._path(start).exists()
        ]

    def _path(self, start: int) -> Path:
        return self.folder / f"runs-{start:09d}.{self.form}"

    def write(
        self, runs: range, names: Sequence[str], rows: Array, results: Sequence[str], block: Block
    ) -> None:
        """One chunk. StudyError if it cannot be written; what was written before it stays."""
        messages = [block.messages.get(place, "") for place in range(len(runs))]
        columns = [*rows.T, *block.values.T]
        path = self._path(runs.start)
        if self.form == "parquet":
            content = _parquet(["run", *names, *results, "message"], [np.array(runs), *columns, messages])
        else:
            content = _csv(
                ["run", *names, *results, "message"], [list(runs), *(c.tolist() for c in columns), messages]
            )
        self._write(path, content)

    def _write(self, path: Path, content: bytes) -> None:
        unfinished = path.with_suffix(".unfinished")
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            with unfinished.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            unfinished.replace(path)
        except OSError as error:
            unfinished.unlink(missing_ok=True)
            raise StudyError(
                f"cannot write {path}: {error.strerror or error}. The runs written before are kept: make "
                "room, or whatever it takes, and give the same command again"
            ) from error


def _check_writer(form: str) -> None:
    """StudyError if what writes this format is not installed."""
    if form == "parquet":
        _pyarrow()


def _parquet(names: Sequence[str], columns: Sequence[Any]) -> bytes:
    pyarrow, parquet = _pyarrow()
    sink = pyarrow.BufferOutputStream()
    parquet.write_table(pyarrow.table(dict(zip(names, columns, strict=True))), sink)
    return bytes(sink.getvalue())


def _csv(names: Sequence[str], columns: Sequence[list[Any]]) -> bytes:
    import io

    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(names)
    writer.writerows(zip(*columns, strict=True))
    return text.getvalue().encode()


def _pyarrow() -> tuple[Any, Any]:
    try:
        return importlib.import_module("pyarrow"), importlib.import_module("pyarrow.parquet")
    except ImportError:
        raise StudyError(
            "format parquet needs pyarrow: pip install 'dualcam[study]', or use format csv"
        ) from None


def _record(folder: Path) -> dict[str, Any] | None:
    try:
        record: dict[str, Any] = json.loads((folder / RECORD).read_text())
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise StudyError(
            f"{folder / RECORD} cannot be read: {error}: give another folder, or delete it"
        ) from error
    return record


def read(folder: str | Path, columns: Sequence[str] | None = None) -> dict[str, Column]:
    """Columns of a study by name, all if none are named, in the order of the runs; `run` is the run's number,
    `message` why it failed, if it did."""
    folder = Path(folder)
    record = _record(folder)
    if record is None:
        raise StudyError(f"{folder} holds no study: there is no {RECORD}")
    paths = sorted(folder.glob(f"runs-*.{record['format']}"))
    if not paths:
        raise StudyError(f"{folder} holds no runs yet")
    parts = list(_parts(paths, columns if columns is None else list(dict.fromkeys(columns))))
    if lacking := set(columns or ()) - set(parts[0]):
        raise StudyError(f"{folder} has no column {', '.join(lacking)}")
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _parts(paths: Sequence[Path], columns: Sequence[str] | None) -> Iterator[dict[str, Column]]:
    for path in paths:
        if path.suffix == ".parquet":
            table = _pyarrow()[1].read_table(path, columns=columns)
            yield {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}
        else:
            with path.open(newline="") as file:
                names, *rows = csv.reader(file)
            wanted = [name for name in names if columns is None or name in columns]
            by_name = dict(zip(names, zip(*rows, strict=True), strict=True))
            yield {name: _parsed(name, by_name[name]) for name in wanted}


def _parsed(name: str, cells: Sequence[str]) -> Column:
    if name == "message":
        return np.array(cells, dtype=object)
    return np.array(cells, dtype=np.int64 if name == "run" else np.float64)
