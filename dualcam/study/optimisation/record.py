"""What was evaluated, on disk: one line of JSON for each batch of designs, written before the search goes on.

A search is a function of its seed and of what its designs gave. A search that was interrupted is therefore
made again from its beginning, and each batch that is on disk is read instead of evaluated: no design is
evaluated twice, and the end is that of an uninterrupted search, bit for bit. A line that an interruption cut
is dropped.
"""

import json
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from filelock import FileLock

from dualcam.common.mistakes import StudyError
from dualcam.fmi.reals import Array
from dualcam.study.optimisation.evaluation import ARRAYS, EvaluatedDesigns
from dualcam.study.run.chunk import checksum
from dualcam.study.store.storage import Folder, locked

FACTS = "optimisation.json"
BATCHES = "evaluations.jsonl"


class Record:
    """The batches of one search in a folder; without a folder nothing is kept."""

    def __init__(self, folder: Path | None, facts: dict[str, Any], versions: dict[str, str]) -> None:
        """StudyError if the folder holds another search, or cannot be written."""
        self._folder = folder
        self._known: Iterator[EvaluatedDesigns] = iter(())
        self.resumed = 0  # designs on disk
        self._lock: FileLock | None = None
        if folder is None:
            return
        try:
            Folder(folder).make()
            busy = f"another process is searching in {folder}: wait for its end, or give another folder"
            self._lock = locked(folder / ".lock", busy)
            self._begin(folder, json.loads(json.dumps(facts)), versions)
            batches = self._read(folder / BATCHES)
        except StudyError:
            self.close()
            raise
        except (OSError, ValueError, KeyError) as error:
            self.close()
            text = f"{folder} cannot be used: {error}: give another folder, or delete it"
            raise StudyError(text) from error
        self.resumed = sum(len(batch.shares) for batch in batches)
        self._known = iter(batches)

    def close(self) -> None:
        """Others may write there now."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def _begin(self, folder: Path, facts: dict[str, Any], versions: dict[str, str]) -> None:
        path = folder / FACTS
        if path.exists():
            begun = json.loads(path.read_text(encoding="utf-8"))
            other = [key for key in facts if json.dumps(begun["task"].get(key)) != json.dumps(facts[key])]
            other += [key for key in versions if begun["versions"].get(key) != versions[key]]
            if other and (folder / BATCHES).exists():
                why = f"holds another search (other {', '.join(other)})"
                raise StudyError(f"{folder} {why}: give another folder, or delete it")
        text = json.dumps({"task": facts, "versions": versions}, indent=1)
        Folder(folder).write(FACTS, text.encode())

    def _read(self, path: Path) -> list[EvaluatedDesigns]:
        """All whole lines; what follows them is cut off."""
        if not path.exists():
            return []
        content, end, batches = path.read_bytes(), 0, []
        for line in content.splitlines(keepends=True):
            batch = _parsed(line)
            if batch is None:
                break
            batches.append(batch)
            end += len(line)
        if end < len(content):
            with path.open("r+b") as file:
                file.truncate(end)
        return batches

    def next_known(self, shares: Array) -> EvaluatedDesigns | None:
        """The next batch on disk, which must be that of these designs; None if there is no more."""
        batch = next(self._known, None)
        if batch is not None and not np.array_equal(batch.shares, shares):
            raise StudyError(
                f"the designs in {self._folder} are not those that this search asks for, as by another "
                "computer's arithmetic: give another folder, or delete it"
            )
        return batch

    def append(self, batch: EvaluatedDesigns) -> None:
        """Keep a batch. StudyError if the disk does not take it."""
        if self._folder is None:
            return
        path = self._folder / BATCHES
        try:
            with path.open("ab") as file:
                file.write(_line(batch))
                file.flush()
                os.fsync(file.fileno())
        except OSError as error:
            raise StudyError(
                f"cannot write {path}: {error.strerror or error}. What was evaluated before is kept: make "
                "room, and give the same command again"
            ) from error


def _line(batch: EvaluatedDesigns) -> bytes:
    arrays = {name: getattr(batch, name).tolist() for name in ARRAYS}
    text = json.dumps(arrays | {"messages": batch.messages}).encode()
    return b"%s %s\n" % (checksum(text).encode(), text)


def _parsed(line: bytes) -> EvaluatedDesigns | None:
    """None for a line that is not as it was written."""
    mark, _, text = line.rstrip(b"\n").partition(b" ")
    with suppress(ValueError):
        if line.endswith(b"\n") and mark.decode() == checksum(text):
            read = json.loads(text)
            count = len(read["shares"])
            arrays = {name: np.array(read[name], float).reshape(count, -1) for name in ARRAYS}
            messages = {int(place): text for place, text in read["messages"].items()}
            return EvaluatedDesigns(**arrays, messages=messages)
    return None
