"""A pytest plugin: runs the tests once, then once again for each mutant, in a child process.

    DUALCAM_MUTANTS_JOB=job.json python -m pytest -p benchmarks.test_strength.fork_server TESTS

The first pass has no mutant in force. It notes how long each test takes and which places the test reaches. A
child process begins with all that the first pass has imported and compiled. It runs only the tests that reach
the mutant's place, up to the first failure.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import gc
import hashlib
import importlib
import json
import mmap
import os
import pickle
import resource
import shutil
import signal
import sys
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from _pytest.runner import runtestprotocol

from benchmarks.test_strength.switch import ACTIVE, REACHED, SYMBOL

JOB = "DUALCAM_MUTANTS_JOB"
SLOWER, PATIENCE = 5.0, 2.0  # a test of a mutant may take so many times the processor time, and s on top
WAITING = 120.0  # s by the clock for one test that waits without computing
SAVE_EVERY = 10  # tests
TELL_EVERY = 20  # mutants
MEMORY = 4 << 30  # bytes, of a child
SURVIVES, KILLED = 0, 1

Item = Any  # pytest.Item, whose parts for a second run are not typed


@dataclass
class Job:
    """What the first pass finds, kept between runs in the file `reach`."""

    numbers: list[int]
    reach: Path
    status: Path  # folder: one file for each mutant
    limit: float  # s of tests for one mutant
    processes: int
    seconds: dict[str, float] = field(default_factory=dict)
    reached: dict[str, list[int]] = field(default_factory=dict)
    failed: list[str] = field(default_factory=list)
    kills: Counter[str] = field(default_factory=Counter)

    def save(self) -> None:
        found = {"seconds": self.seconds, "reached": self.reached, "failed": self.failed}
        self.reach.write_text(json.dumps(found))

    def tests_of(self, number: int, items: Sequence[Item]) -> list[Item]:
        """The tests that reach the mutant, as many as the limit allows. First those that have killed others,
        then one of each file, then a second of each file, the quickest first."""
        turns: Counter[str] = Counter()
        order: list[tuple[int, int, int, Item]] = []
        for item in sorted(items, key=lambda item: self.seconds[item.nodeid]):
            if number in self.reached.get(item.nodeid, ()):
                turns[item.location[0]] += 1
                order.append((-self.kills[item.nodeid], turns[item.location[0]], len(order), item))
        taken, total = [], 0.0
        for *_, item in sorted(order):
            total += self.seconds[item.nodeid]
            if total <= self.limit:
                taken.append(item)
        return taken


# ---- the first pass ----


def failed_in(reports: Sequence[pytest.TestReport]) -> bool:
    return any(report.failed for report in reports)


def tell(node: Item, text: str) -> None:
    """Past the capture of pytest."""
    writer = node.config.get_terminal_writer()
    writer.line(text)
    writer.flush()


def computed() -> float:
    """s of the processor, of this process and of those that it has started and ended."""
    return sum(os.times()[:4])


def first_pass(items: Sequence[Item], job: Job, marks: mmap.mmap) -> None:
    for k, item in enumerate(items):
        marks[:] = bytes(len(marks))
        begin = computed()
        reports = runtestprotocol(item, nextitem=items[(k + 1) % len(items)], log=False)
        job.seconds[item.nodeid] = computed() - begin
        job.reached[item.nodeid] = [n for n, mark in enumerate(marks[:]) if mark]
        if failed_in(reports):
            job.failed.append(item.nodeid)
            tell(item, f"fails without a mutant: {item.nodeid}")
        if k % SAVE_EVERY == 0:
            job.save()


def keep_compiled(tools: ModuleType, folder: Path) -> None:
    """The `core` fixture compiles once, not once in each child."""
    folder.mkdir(exist_ok=True)
    compile_c: Callable[..., None] = tools.compile_c

    def once(compiler: Sequence[str], flags: Sequence[str], sources: Sequence[Path], product: Path) -> None:
        own = "".join(Path(flag).read_text() for flag in flags if flag.endswith(".c"))
        options = [flag for flag in flags if not flag.endswith(".c")]
        key = repr((options, own, [str(path) for path in sources]))
        kept = folder / f"{hashlib.sha256(key.encode()).hexdigest()}.so"
        if not kept.exists():
            compile_c(compiler, flags, sources, product)
            shutil.copy(product, kept.with_suffix(f".{os.getpid()}"))
            kept.with_suffix(f".{os.getpid()}").replace(kept)
        shutil.copy(kept, product)

    tools.compile_c = once  # type: ignore[attr-defined]


def keep_solved(folder: Path) -> None:
    """The reference solves each scene once, not once in each child. It knows nothing of the FMU."""
    reference = importlib.import_module("reference")  # of the tests

    folder.mkdir(exist_ok=True)

    def kept(solve: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(solve)
        def once(*arguments: object, **named: object) -> object:
            key = repr((solve.__name__, arguments, sorted(named.items())))
            path = folder / hashlib.sha256(key.encode()).hexdigest()
            if "object at 0x" in key:  # an argument that does not tell what it is
                return solve(*arguments, **named)
            if not path.exists():
                path.with_suffix(f".{os.getpid()}").write_bytes(pickle.dumps(solve(*arguments, **named)))
                path.with_suffix(f".{os.getpid()}").replace(path)
            return pickle.loads(path.read_bytes())

        return once

    for name in ("simulate", "simulate_exact"):
        setattr(reference, name, kept(getattr(reference, name)))


# ---- a child ----


def loaded_libraries() -> list[ctypes.CDLL]:
    """Libraries of this process that have the switch."""
    lines = Path("/proc/self/maps").read_text().splitlines()
    paths = {line.split(maxsplit=5)[5] for line in lines if line.endswith(".so")}
    found = []
    for path in paths:
        if not path.startswith(("/usr", "/lib", sys.prefix)) and Path(path).exists():
            library = ctypes.CDLL(path)
            with contextlib.suppress(AttributeError, ValueError):
                ctypes.c_int.in_dll(library, SYMBOL)
                found.append(library)
    return found


def put_in_force(number: int) -> None:
    """In the libraries of this process, and in those that this process or its children will load."""
    os.environ[ACTIVE] = str(number)
    for library in loaded_libraries():
        ctypes.c_int.in_dll(library, SYMBOL).value = number


def limit_child() -> None:
    silence = os.open(os.devnull, os.O_WRONLY)
    os.dup2(silence, 1)
    os.dup2(silence, 2)
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def run_child(number: int, items: Sequence[Item], job: Job, session: pytest.Session) -> None:
    """Runs the tests of one mutant and ends the process. Signals end it where a test takes too long."""
    limit_child()
    put_in_force(number)
    session.config._tmp_path_factory._basetemp = folder_of(number, job)  # type: ignore[attr-defined]
    folder_of(number, job).mkdir(parents=True, exist_ok=True)
    session._setupstate.teardown_exact(items[0])
    status = job.status / str(number)
    for k, item in enumerate(items):
        status.write_text(item.nodeid)
        signal.setitimer(signal.ITIMER_PROF, SLOWER * job.seconds[item.nodeid] + PATIENCE)
        signal.setitimer(signal.ITIMER_REAL, WAITING)
        following = items[k + 1] if k + 1 < len(items) else None
        if failed_in(runtestprotocol(item, nextitem=following, log=False)):
            os._exit(KILLED)
    status.write_text(f"{len(items)} tests")
    os._exit(SURVIVES)


def folder_of(number: int, job: Job) -> Path:
    return job.status.parent / "temporary" / str(number)


def in_child(number: int, items: Sequence[Item], job: Job, session: pytest.Session) -> int:
    """The process in which the tests of one mutant run."""
    child = os.fork()
    if child == 0:
        try:
            run_child(number, items, job, session)
        finally:
            os._exit(KILLED)  # an error outside of a test, such as the lack of memory
    return child


def note_end(number: int, code: int, job: Job) -> None:
    """Completes the file of the mutant: what came of the tests, and the last test that ran."""
    last = (job.status / str(number)).read_text()
    if os.WIFSIGNALED(code):
        name = signal.Signals(os.WTERMSIG(code)).name
        word = "time" if name in ("SIGPROF", "SIGALRM") else f"crash {name}"
    else:
        word = "survives" if os.WEXITSTATUS(code) == SURVIVES else "fails"
    (job.status / str(number)).write_text(json.dumps({"end": word, "test": last}))
    if word != "survives":
        job.kills[last] += 1
    shutil.rmtree(folder_of(number, job), ignore_errors=True)


def kills_before(job: Job) -> Iterator[str]:
    """The tests that killed a mutant in an earlier run."""
    for path in job.status.iterdir():
        if (text := path.read_text()).startswith("{") and (read := json.loads(text))["end"] != "survives":
            yield read["test"]


def run_children(items: Sequence[Item], job: Job, session: pytest.Session) -> None:
    running: dict[int, int] = {}
    job.kills.update(kills_before(job))
    gc.freeze()  # else the first collection of each child copies all memory

    def wait_for_one() -> None:
        child, code = os.wait()
        if child in running:
            note_end(running.pop(child), code, job)

    for k, number in enumerate(job.numbers):
        tests = job.tests_of(number, items)
        (job.status / str(number)).write_text("not reached")
        if k % TELL_EVERY == 0:
            tell(session, f"{k} of {len(job.numbers)} mutants begun, {job.kills.total()} killed so far")
        if not tests:
            note_end(number, SURVIVES, job)
            continue
        while len(running) >= job.processes:
            wait_for_one()
        running[in_child(number, tests, job, session)] = number
    while running:
        wait_for_one()


# ---- hooks of pytest ----


def read_job() -> Job:
    given = json.loads(Path(os.environ[JOB]).read_text())
    reach, status = Path(given.pop("reach")), Path(given.pop("status"))
    job = Job(reach=reach, status=status, **given)
    if job.reach.exists():
        for name, value in json.loads(job.reach.read_text()).items():
            setattr(job, name, value)
    return job


def pytest_configure() -> None:
    """Before test modules import the reference."""
    keep_solved(read_job().status.parent / "solved")


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> bool:
    import build_fmu

    job = read_job()
    items = session.items
    keep_compiled(build_fmu, job.status.parent / "compiled")
    marks_file = Path(os.environ[REACHED])
    with marks_file.open("r+b") as file, mmap.mmap(file.fileno(), 0) as marks:
        fresh = [item for item in items if item.nodeid not in job.seconds]
        if fresh:
            first_pass(fresh, job, marks)
            job.save()
        sound = [item for item in items if item.nodeid not in job.failed]
        run_children(sound, job, session)
    return True
