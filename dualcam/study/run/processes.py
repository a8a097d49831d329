"""Workers that are processes of this machine, and the choice among all workers."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from multiprocessing.connection import Connection, wait
from queue import SimpleQueue
from typing import TYPE_CHECKING, cast

from dualcam.common.mistakes import StudyError
from dualcam.fmi.fmu import Array
from dualcam.study.run.chunk import Answer, Order, Task
from dualcam.study.run.cluster import Cluster
from dualcam.study.run.runner import Block, Runner
from dualcam.study.run.workers import AHEAD, Answers, Died, InThisProcess, Workers

if TYPE_CHECKING:
    from distributed import Client

GRACE = 2.0  # s, for a process that is sent home in the middle of something
Made = Callable[[], Answer] | Exception  # runs whose file is not written yet


class _Worker:
    """A process that makes runs, and the two pipes to it, which nobody else has: whatever it is doing when it
    dies, or when this process is interrupted, can hold up nobody.

    Not concurrent.futures: Ctrl-C within its submit(), or a process that dies meanwhile, may leave an
    executor that is waited for without end (CPython 3.11)."""

    def __init__(self, task: Task) -> None:
        context = multiprocessing.get_context("spawn")
        orders, self._orders = context.Pipe(duplex=False)
        self.answers, answers = context.Pipe(duplex=False)
        self._process = context.Process(target=_serve, args=(task, orders, answers), daemon=True)
        self._process.start()
        orders.close()
        answers.close()
        self.lives = False
        self.given: deque[tuple[int, Order]] = deque()

    def give(self, place: int, order: Order) -> None:
        self.given.append((place, order))
        with suppress(OSError):  # it is dead, and its answer will say so
            self._orders.send(order)

    def receive(self) -> tuple[int, Answer] | None:
        """The first order given and its answer, which may take its time; None, which comes once before, says
        that it lives. Died if it does no more."""
        try:
            answer = self.answers.recv()
        except (EOFError, OSError) as error:
            raise Died from error
        if isinstance(answer, Exception):
            raise answer
        self.lives = True
        return None if answer is None else (self.given.popleft()[0], answer)

    def dismiss(self) -> None:
        """One that has nothing to do ends by itself, one that has as it finds its pipe closed."""
        if not self.given:
            with suppress(OSError):
                self._orders.send(None)
        self._orders.close()

    def join(self) -> None:
        self._process.join(2.0 * GRACE)
        self._process.kill()
        self._process.join()
        self.answers.close()


def _serve(task: Task, orders: Connection, answers: Connection) -> None:
    """In a worker: its end tidies up, as the FMU's own does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches it too, but its study sends it home
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(1))
    os.environ.setdefault("MIMALLOC_PURGE_DELAY", "-1")  # Arrow's memory is used again for the next file
    waiting: SimpleQueue[Order | None] = SimpleQueue()
    threading.Thread(target=_listen, args=(orders, waiting), daemon=True).start()
    answers.send(None)
    made: SimpleQueue[Made | None] = SimpleQueue()
    writer = threading.Thread(target=_finish, args=(made, answers), daemon=True)  # a study's end may not wait
    writer.start()
    while (order := waiting.get()) is not None:
        try:
            made.put(task.made(order))
        except Exception as error:
            made.put(error)
    made.put(None)
    writer.join()


def _finish(made: SimpleQueue[Made | None], answers: Connection) -> None:
    """In a worker: a file is written while the runs of the next one are made."""
    while (each := made.get()) is not None:
        try:
            answer: Answer | Exception = each if isinstance(each, Exception) else each()
        except Exception as error:
            answer = error
        with suppress(OSError):  # the study is over or was killed, which `_listen` finds
            answers.send(answer)


def _listen(orders: Connection, waiting: SimpleQueue[Order | None]) -> None:
    """In a worker: orders are taken while it computes. Ends it where the study is over."""
    with suppress(EOFError, OSError):
        while True:
            waiting.put(order := orders.recv())
            if order is None:
                return
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(GRACE)
    os._exit(1)


class Processes(Workers):
    """Processes of this machine, started as there is work for them."""

    def __init__(self, task: Task, count: int) -> None:
        super().__init__(task)
        check_processes(task.job, "this study", "let a function of a module make the controller")
        self._most = count
        self._team: list[_Worker] = []

    def count(self) -> int:
        return self._most

    def close(self) -> None:
        _send_home(self._team)
        self._team = []

    def answers(self, orders: Iterable[Order]) -> Answers:
        left = deque(enumerate(orders))
        try:
            while len(self._team) < min(self._most, len(left)):
                self._team.append(_Worker(self.task))  # one by one, so that those which began are sent home
            while left or any(worker.given for worker in self._team):
                for worker in self._team:
                    _occupy(worker, left, AHEAD if len(left) > len(self._team) else 1)
                yield from self._ready(left)
        except BaseException:  # what is in flight would be taken for an answer to the next orders
            self.close()
            raise

    def _ready(self, left: deque[tuple[int, Order]]) -> Iterator[tuple[int, Answer]]:
        """Those that are there, once one is."""
        ready = wait([worker.answers for worker in self._team if worker.given])
        for number, worker in enumerate(self._team):
            if worker.answers not in ready:
                continue
            try:
                made = worker.receive()
            except Died:
                self._team[number] = _Worker(self.task)
                _send_home([worker])
                (place, order), *others = worker.given
                left.extendleft(reversed(others))
                made = place, self._alone(self._attempt, order)
            if made is not None:
                yield made

    def _attempt(self, rows: Array) -> Block:
        worker = _Worker(self.task)
        try:
            worker.give(0, rows)
            made = worker.receive() or worker.receive()
        except Died as error:
            if worker.lives:
                raise
            raise StudyError(
                "processes die as they start. A script is read by each of them: what starts a study there "
                'belongs under `if __name__ == "__main__":`; or use workers = 0'
            ) from error
        finally:
            _send_home([worker])
        assert made is not None
        return cast(Block, made[1])


def workers_for(task: Task, runner: Runner, count: int, scheduler: str | Client | None = None) -> Workers:
    """`count` processes, or this process with its `runner` for 0; or those of a Dask scheduler."""
    if scheduler is None and count == 0:
        return InThisProcess(task, runner)
    runner.close()
    return Processes(task, count) if scheduler is None else Cluster(task, scheduler)


def _occupy(worker: _Worker, left: deque[tuple[int, Order]], most: int) -> None:
    while left and len(worker.given) < most:
        worker.give(*left[0])
        left.popleft()


def _send_home(team: list[_Worker]) -> None:
    for worker in team:
        worker.dismiss()
    for worker in team:
        worker.join()


def in_a_daemon() -> bool:
    """Whether this process is one of multiprocessing's daemons, which may start no processes."""
    return multiprocessing.current_process().daemon


def check_processes(thing: object, name: str, remedy: str) -> None:
    """StudyError where this process may start no others, or where no other one can get a thing."""
    if in_a_daemon():
        raise StudyError(
            "this process is a daemon of multiprocessing, such as a worker of its Pool, and may start no"
            " processes: use workers = 0"
        )
    try:
        pickle.dumps(thing)
    except Exception as error:  # pickle has several for it
        why = f"cannot be sent to other processes: {error}"
        raise StudyError(f"{name} {why}: {remedy}, or use workers = 0") from error
