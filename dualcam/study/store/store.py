"""The folder of a study: a file for each chunk of runs, what study they are of, and which files are finished.

    study.json          the study, written at its begin
    finished.json       the files of runs that are there, with their sizes, checksums and times of change
    runs/runs-N.parquet the runs from number N on

The workers write the files of runs, each of which appears whole or not at all. The study keeps the record of
finished files. A study that is continued makes exactly the chunks that the record does not have, or that
something else has damaged since. A chunk that was written and not recorded is written once more, in its
place. One study at a time writes into a folder.
"""

import hashlib
import json
import platform
import tempfile
import time
import uuid
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

from filelock import FileLock

from dualcam.common.mistakes import StudyError
from dualcam.study.plan.plan import Plan
from dualcam.study.run.chunk import RUNS, Files, Written, checksum, name_of
from dualcam.study.run.readings import Readings
from dualcam.study.store.encoding import FORMATS, check_format, default_format
from dualcam.study.store.storage import Folder, Listed, Storage, locked, storage_at

LAYOUT = 2  # of the folder
RECORD, FINISHED, LOCK = "study.json", "finished.json", ".lock"
RECORD_EVERY = 1.0  # s: the record is written at most this often, and at the end
PACKAGES = ("dualcam", "numpy", "pyarrow")


def versions() -> dict[str, str]:
    """Of what makes the runs and their files."""
    found = {"python": platform.python_version()}
    for name in PACKAGES:
        with suppress(ImportError):
            found[name] = version(name)
    return found


class Store:
    """The folder of one study, while the study is run."""

    def __init__(
        self,
        folder: str | Path,
        facts: dict[str, Any],
        plan: Plan,
        readings: Readings,
        chunk: int,
        file_format: str | None,
    ) -> None:
        """Opens or makes it. StudyError if it holds another study, is in use, or cannot be written. A study
        begun earlier keeps its size of chunks and its format."""
        self.storage = storage_at(folder)
        self.plan, self.readings = plan, readings
        self.damaged: list[str] = []  # names of files, found by `missing`
        wanted = {
            "layout": LAYOUT,
            "study": json.loads(json.dumps(facts), parse_constant=_plain),  # as it is read back
            "runs": plan.count,
            "chunk": chunk,
            "format": file_format or default_format(),
            "versions": versions(),
            "texts": [*plan.texts, "message"],
            "series": readings.series,
        }
        check_format((record_in(self.storage) or wanted)["format"])  # before the folder is made
        self._lock = self._locked()
        try:
            self.record = self._begin(wanted)
            self.storage.tidy(RUNS)
            self._finished = finished_in(self.storage)
            self._mark = f".study-{uuid.uuid4().hex}"
            self.storage.write(self._mark, b"a study writes here")
        except BaseException:
            self._unlock()
            raise
        self._recorded = time.monotonic()
        self.chunk, self.file_format = int(self.record["chunk"]), str(self.record["format"])

    def _begin(self, wanted: dict[str, Any]) -> dict[str, Any]:
        """The record that holds: the one that is there, also by another process, if runs are."""
        begun = record_in(self.storage)
        differing = [] if begun is None else _differing(begun["study"], wanted["study"])
        if begun is not None and not differing:
            return begun
        if self.storage.listing(RUNS):
            why = f"of another study (other {', '.join(differing)})" if differing else f"without {RECORD}"
            raise StudyError(f"{self.storage} holds runs {why}: give another folder, or delete it")
        self.storage.write(RECORD, json.dumps(wanted, indent=1).encode())
        return wanted

    def _locked(self) -> FileLock | None:
        """The lock of the folder. A store that is no folder is locked for this machine alone."""
        self.storage.make()
        if isinstance(self.storage, Folder):
            path = self.storage.path / LOCK
        else:
            name = hashlib.sha256(str(self.storage).encode()).hexdigest()[:16]
            path = Path(tempfile.gettempdir()) / f"dualcam-study-{name}.lock"
        busy = f"another process is writing a study into {self.storage}: wait for its end, or give another"
        return locked(path, f"{busy} folder")

    def _unlock(self) -> None:
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def close(self) -> None:
        """The record is whole; others may write there now."""
        try:
            self._write_record()
        finally:
            with suppress(Exception):
                self.storage.remove(self._mark)
            self._unlock()

    def files(self) -> Files:
        """What workers need to write the files of runs."""
        metadata = {name: self.record[name] for name in ("study", "versions", "series")}
        return Files(self.storage, self.file_format, self.plan, self.readings, metadata, self._mark)

    def missing(self) -> list[range]:
        """Runs not yet made, file by file."""
        count, listed = self.plan.count, self.storage.listing(RUNS)
        files = [range(start, min(start + self.chunk, count)) for start in range(0, count, self.chunk)]
        return [runs for runs in files if not self._holds(runs, listed)]

    def _holds(self, runs: range, listed: dict[str, Listed]) -> bool:
        name = name_of(runs, self.file_format)
        recorded = self._finished.get(str(runs.start))
        if recorded is None:
            return False
        if is_sound(self.storage, name, recorded, listed):
            return True
        self.damaged.append(Path(name).name)
        del self._finished[str(runs.start)]
        return False

    def accept(self, runs: range, written: Written) -> None:
        """The file of these runs is finished, or is written now. StudyError if it cannot be."""
        changed = written.changed
        if written.content is not None:
            changed = self.storage.write(name_of(runs, self.file_format), written.content)
        self._finished[str(runs.start)] = [written.size, written.checksum, written.failed, changed]
        if time.monotonic() - self._recorded > RECORD_EVERY:
            self._write_record()

    def _write_record(self) -> None:
        self.storage.write(FINISHED, json.dumps(self._finished).encode())
        self._recorded = time.monotonic()


def record_in(storage: Storage) -> dict[str, Any] | None:
    """What study a folder is of; None if there is none. StudyError if that cannot be read."""
    where = f"{storage}/{RECORD}"
    try:
        record: dict[str, Any] = json.loads(storage.read(RECORD))
        if not (int(record["chunk"]) > 0 and isinstance(record["study"], dict)):
            raise ValueError("its entries are not those of a study")
        if record.get("layout") != LAYOUT:
            raise ValueError("it is of another version of dualcam")
        if record["format"] not in FORMATS:
            raise ValueError(f"it has files of the format {record['format']!r}")
    except FileNotFoundError:
        return None
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise StudyError(f"{where} cannot be read: {error}: give another folder, or delete it") from error
    return record


def finished_in(storage: Storage) -> dict[str, list[Any]]:
    """Size, checksum, failed runs and time of change of each finished file, by its first run."""
    try:
        finished: dict[str, list[Any]] = json.loads(storage.read(FINISHED))
        return {
            start: [int(size), str(crc), int(failed), changed[0] if changed else None]
            for start, (size, crc, failed, *changed) in finished.items()
        }
    except (OSError, ValueError, TypeError, AttributeError):
        return {}  # missing, or damaged: all is made again


def is_sound(storage: Storage, name: str, recorded: list[Any], listed: dict[str, Listed]) -> bool:
    """Whether a file of runs is as it was written; read only where its time of change differs."""
    size, changed = listed.get(Path(name).name, (-1, None))
    if size != recorded[0]:
        return False
    if storage.checks_itself or (changed is not None and changed == recorded[3]):
        return True
    try:
        return checksum(storage.read(name)) == recorded[1]
    except OSError:
        return False


def _plain(constant: str) -> str | None:
    """JSON has no NaN, which stands for a range that is not given, and no infinity."""
    return None if constant == "NaN" else constant


def _differing(begun: dict[str, Any], facts: dict[str, Any], where: str = "") -> list[str]:
    """Entries, by their path."""
    found = []
    for key in [*facts, *(key for key in begun if key not in facts)]:
        old, new = begun.get(key), facts.get(key)
        if isinstance(old, dict) and isinstance(new, dict):
            found += _differing(old, new, f"{where}{key}: ")
        elif old != new:
            found.append(where + key)
    return found
