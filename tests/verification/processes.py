"""Work in processes that may crash or hang."""

from __future__ import annotations

import multiprocessing
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from typing import Any


@dataclass(frozen=True)
class Lost:
    """The result of work whose process has crashed or was ended."""

    reason: str


@dataclass
class Worker:
    process: Any
    connection: Connection
    number: int = -1  # of the item
    since: float = 0.0  # s, of the monotonic clock


def serve(connection: Connection, prepare: Callable[[], Callable[[Any], Any]], items: Sequence[Any]) -> None:
    """The loop of a worker: receives numbers of items, sends results."""
    work = prepare()
    while (number := connection.recv()) is not None:
        connection.send(work(items[number]))


def in_processes(
    items: Sequence[Any], prepare: Callable[[], Callable[[Any], Any]], workers: int, longest: float
) -> Iterator[tuple[Any, Any]]:
    """Every item with its result, as the results come.

    `prepare` runs once in each process and returns the function of an item. The result is a Lost where the
    process crashes or an item takes more than `longest` seconds."""
    context = multiprocessing.get_context("fork")
    waiting = iter(range(len(items)))

    def hire() -> Worker:
        ours, theirs = context.Pipe()
        process = context.Process(target=serve, args=(theirs, prepare, items), daemon=True)
        process.start()
        theirs.close()
        return Worker(process, ours)

    def hand_out(worker: Worker) -> bool:
        number = next(waiting, None)
        worker.connection.send(number)
        worker.number, worker.since = -1 if number is None else number, time.monotonic()
        return number is not None

    busy = [worker for worker in (hire() for _ in range(min(workers, len(items)))) if hand_out(worker)]
    while busy:
        ready = wait([worker.connection for worker in busy], timeout=1.0)
        for worker in list(busy):
            if worker.connection in ready:
                result = received(worker)
            elif time.monotonic() - worker.since > longest:
                worker.process.kill()
                result = Lost(f"hangs: more than {longest:g} s")
            else:
                continue
            yield items[worker.number], result
            busy.remove(worker)
            if isinstance(result, Lost):
                worker = hire()
            if hand_out(worker):
                busy.append(worker)


def received(worker: Worker) -> object:
    try:
        return worker.connection.recv()
    except EOFError:
        worker.process.join()
        return Lost(f"crash: exit code {worker.process.exitcode}")
