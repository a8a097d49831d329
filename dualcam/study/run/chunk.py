"""What a worker does: it makes the runs of a chunk, and writes their file if it sees the study's folder."""

import json
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from dualcam.fmi.fmu import Array
from dualcam.study.plan.plan import Plan
from dualcam.study.plan.texts import Texts
from dualcam.study.run.readings import Readings
from dualcam.study.run.runner import Block, Job, run_rows
from dualcam.study.store.encoding import Column, encoded
from dualcam.study.store.storage import Storage

RUNS = "runs"  # folder of the files of runs and of nothing else, so that other programs read it as it is


def name_of(runs: range, file_format: str) -> str:
    """Of the file of these runs. The same for whoever makes them, so that no run is there twice."""
    return f"{RUNS}/runs-{runs.start:09d}.{file_format}"


def checksum(content: bytes | memoryview) -> str:
    """CRC-32."""
    return f"{zlib.crc32(content):08x}"


@dataclass(frozen=True)
class Written:
    """A file of runs that is there. Its `content` travels where the worker does not see the folder."""

    size: int  # bytes
    checksum: str
    failed: int  # runs
    changed: int | None = None  # as of `Storage.listing`
    content: bytes | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Files:
    """The files of runs of one study. `mark` is a file in the folder while the study is run: a worker that
    does not see it sees another folder, on a machine of its own, or none."""

    storage: Storage
    file_format: str
    plan: Plan
    readings: Readings
    metadata: Mapping[str, Any]
    mark: str

    def __getstate__(self) -> dict[str, Any]:
        """For another process: without what this process sees."""
        state = {name: value for name, value in vars(self).items() if name not in ("is_seen", "_metadata")}
        return state | {"plan": self.plan.for_workers()}

    @cached_property
    def is_seen(self) -> bool:
        """Whether this process sees the study's folder."""
        try:
            self.storage.read(self.mark)
        except Exception:  # each store has its own; the study then gets the content
            return False
        return True

    @cached_property
    def _metadata(self) -> str:
        return json.dumps(self.metadata)

    def content(self, runs: range, rows: Array, block: Block) -> bytes | memoryview:
        """The file of these runs, with the values of the plan."""
        messages = np.full(len(runs), "", dtype=object)
        for place, text in block.messages.items():
            messages[place] = text
        columns: dict[str, Column] = {"run": np.arange(runs.start, runs.stop)}
        columns |= (varied := varied_columns(self.plan.names, rows, self.plan.texts))
        columns |= self.readings.of(block.values, varied, list(block.messages))
        return encoded(columns | {"message": messages}, self.file_format, self._metadata)

    def write(self, runs: range, content: bytes | memoryview, failed: int) -> Written:
        """The file of these runs is there, or the study gets the content. StudyError if neither."""
        written = Written(len(content), checksum(content), failed)
        if not self.is_seen:
            return replace(written, content=bytes(content))
        return replace(written, changed=self.storage.write(name_of(runs, self.file_format), content))


def varied_columns(names: Sequence[str], rows: Array, texts: Mapping[str, Texts]) -> dict[str, Column]:
    """The columns of rows of a plan: numbers, or the texts of Strings as the plan has them."""
    columns: dict[str, Column] = dict(zip(names, rows.T, strict=True))
    for name, known in texts.items():
        places, inverse = np.unique(columns[name].astype(int), return_inverse=True)
        labels = [known.label(place) for place in places.tolist()]
        columns[name] = np.array(labels, dtype=object)[inverse]
    return columns


Order = range | Array
Answer = Block | Written


@dataclass(frozen=True)
class Task:
    """What a worker is for: runs of rows that it is given, or chunks of a study."""

    job: Job
    files: Files | None = None

    def made(self, order: Order, run: Callable[[Array], Block] | None = None) -> Callable[[], Answer]:
        """Makes the runs of an order; what is returned then writes their file, and gives the answer. Another
        thread may call that. `run`: of a runner of this task; None: that of this thread."""
        rows = self.rows(order)
        block = run(rows) if run else run_rows(self.job, rows)
        return self.finish(order, rows, block)

    def finish(self, order: Order, rows: Array, block: Block) -> Callable[[], Answer]:
        """The rest of `made`, for runs that were made."""
        if not isinstance(order, range):
            return lambda: block
        assert self.files is not None
        content = self.files.content(order, rows, block)
        return partial(self.files.write, order, content, len(block.messages))

    def rows(self, order: Order) -> Array:
        """The values of the runs of an order."""
        if not isinstance(order, range):
            return order
        assert self.files is not None
        return self.files.plan.rows(order.start, order.stop)
