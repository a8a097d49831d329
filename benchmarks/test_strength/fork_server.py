"""A pytest plugin: runs the tests once, then once again for each mutant, in a child process.

    DUALCAM_MUTANTS_JOB=job.json python -m pytest -p benchmarks.test_strength.fork_server TESTS

The first pass has no mutant in force. It notes in which places each test makes a difference. A second pass,
in child processes and without a mutant, too, notes how long each test takes there, and leaves out tests that
fail there. The child of a mutant begins with all that the first pass has imported and compiled. It runs only
the tests in which the mutant makes a difference, up to the first failure (schedule.py).
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
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import hypothesis
import pytest
from _pytest.runner import runtestprotocol

from benchmarks.test_strength.schedule import Item, Schedule, function_of
from benchmarks.test_strength.switch import ACTIVE, DIFFERS_BIT, REACHED, SYMBOL

JOB = "DUALCAM_MUTANTS_JOB"
SLOWER, PATIENCE = 5.0, 2.0  # a test of a mutant may take so many times the processor time, and s on top
WAITING = 120.0  # s by the clock, on top, for one test that waits without computing
SHARE = 0.05  # of a processor that a test has at least, on a machine with other work
TELL_EVERY, TELL_EVERY_TESTS = 20, 200  # mutants, tests
MEMORY = 4 << 30  # bytes, of a child
SURVIVES, KILLED = 0, 1

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


def first_pass(items: Sequence[Item], job: Schedule, marks: mmap.mmap) -> None:
    for k, item in enumerate(items):
        marks[:] = bytes(len(marks))
        reports = runtestprotocol(item, nextitem=items[(k + 1) % len(items)], log=False)
        job.reached[item.nodeid] = [n for n, mark in enumerate(marks[:]) if mark & DIFFERS_BIT]
        job.touched = sorted({*job.touched, *(n for n, mark in enumerate(marks[:]) if mark)})
        if failed_in(reports):
            job.failed.append(item.nodeid)
            tell(item, f"fails without a mutant: {item.nodeid}")
        if k % TELL_EVERY_TESTS == 0:
            tell(item, f"first pass: {k} of {len(items)} tests")
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
    """The reference solves each scene once, not once in each child or run. It knows nothing of the FMU."""
    reference = importlib.import_module("reference")  # of the tests
    sources = sorted(Path(reference.__path__[0]).glob("*.py"))
    folder /= hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()
    folder.mkdir(parents=True, exist_ok=True)

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


def enter_child(number: int, items: Sequence[Item], job: Schedule, session: pytest.Session) -> None:
    limit_child()
    put_in_force(max(number, 0))
    session.config._tmp_path_factory._basetemp = folder_of(number, job)  # type: ignore[attr-defined]
    folder_of(number, job).mkdir(parents=True, exist_ok=True)
    session._setupstate.teardown_exact(items[0])


def passes(items: Sequence[Item], k: int) -> bool:
    """Runs one of the tests."""
    following = items[k + 1] if k + 1 < len(items) else None
    return not failed_in(runtestprotocol(items[k], nextitem=following, log=False))


def run_child(number: int, items: Sequence[Item], job: Schedule, session: pytest.Session) -> None:
    """Runs the tests of one mutant and ends the process. Signals end it where a test takes too long."""
    enter_child(number, items, job, session)
    status = at_present(number, job)
    begun: set[str] = set()
    for k, item in enumerate(items):
        status.write_text(item.nodeid)
        function = function_of(item.nodeid)
        longest = SLOWER * job.usual_seconds(item, function not in begun) + PATIENCE
        begun.add(function)
        signal.setitimer(signal.ITIMER_PROF, longest)
        signal.setitimer(signal.ITIMER_REAL, WAITING + longest / SHARE)
        if not passes(items, k):
            os._exit(KILLED)
    os._exit(SURVIVES)


def run_control(number: int, items: Sequence[Item], job: Schedule, session: pytest.Session) -> None:
    """Runs the tests without a mutant, notes their times and those that fail, and ends the process."""
    enter_child(number, items, job, session)
    seconds, failed = {}, []
    for k, item in enumerate(items):
        begin = computed()
        if not passes(items, k):
            failed.append(item.nodeid)
        seconds[item.nodeid] = computed() - begin
    control_notes(number, job).write_text(json.dumps([seconds, failed]))
    os._exit(SURVIVES)


def control_notes(number: int, job: Schedule) -> Path:
    return job.reach.with_name(f"control{number}.json")


def folder_of(number: int, job: Schedule) -> Path:
    return job.status.parent / "temporary" / str(number)


def in_child(run: Callable[..., None], number: int, items: Sequence[Item], *rest: object) -> int:
    """The process in which `run` runs."""
    child = os.fork()
    if child == 0:
        try:
            run(number, items, *rest)
        finally:
            os._exit(KILLED)  # an error outside of a test, such as the lack of memory
    return child


def control(items: Sequence[Item], job: Schedule, session: pytest.Session) -> None:
    """Times of the tests in children, for those whose time is not known. A child takes whole files."""
    fresh = [item for item in items if item.nodeid not in job.seconds and item.nodeid not in job.failed]
    if not fresh:
        return
    tell(session, f"second pass: {len(fresh)} tests")
    numbers = {-k: part for k, part in enumerate(shares(fresh, job.processes)) if part}
    children = {in_child(run_control, number, part, job, session): number for number, part in numbers.items()}
    for child, number in children.items():
        _, code = os.waitpid(child, 0)
        if code != 0:
            raise SystemExit(f"mutants: the tests without a mutant end with {code} in a child process")
        seconds, failed = json.loads(control_notes(number, job).read_text())
        job.seconds |= seconds
        job.failed += failed
        for name in failed:
            tell(session, f"fails without a mutant in a child process: {name}")
        shutil.rmtree(folder_of(number, job), ignore_errors=True)
    job.save()


def shares(items: Sequence[Item], count: int) -> list[list[Item]]:
    """Tests of one file stay together: they share fixtures."""
    files = list(dict.fromkeys(item.location[0] for item in items))
    return [[item for item in items if files.index(item.location[0]) % count == k] for k in range(count)]


def at_present(number: int, job: Schedule) -> Path:
    """The file with the name of the test that runs."""
    return job.status / f"{number}.running"


def read_status(number: int, job: Schedule) -> dict[str, Any]:
    """What an earlier run found out about the mutant: `end`, `test`, `passed`."""
    path = job.status / str(number)
    return json.loads(path.read_text()) if path.exists() else {}


def note_end(number: int, code: int, seconds: float, passed: Sequence[str], job: Schedule) -> None:
    """Completes the file of the mutant: what came of the tests, and the last test that ran. `seconds`: of the
    child. `passed`: the tests that it has passed, if it has passed all that it was given."""
    path, present = job.status / str(number), at_present(number, job)
    last = present.read_text() if present.exists() else "before the first test"
    present.unlink(missing_ok=True)
    if os.WIFSIGNALED(code):
        name = signal.Signals(os.WTERMSIG(code)).name
        word = "time" if name in ("SIGPROF", "SIGALRM") else f"crash {name}"
    else:
        word = "survives" if os.WEXITSTATUS(code) == SURVIVES else "fails"
    if word == "survives":
        last = f"{len(passed)} tests"
        if not passed:
            last = "no test in which it differs" if number in job.touched else "no test"
    else:
        job.note_kill(number, last, seconds)
    kept = list(passed) if word == "survives" else []
    found = {"end": word, "test": last, "seconds": round(seconds, 2), "passed": kept, "core": job.core}
    path.with_suffix(".new").write_text(json.dumps(found))
    path.with_suffix(".new").replace(path)
    shutil.rmtree(folder_of(number, job), ignore_errors=True)


def learn(job: Schedule) -> None:
    """The tests that killed mutants in an earlier run."""
    for number in job.names:
        if (read := read_status(number, job)) and read["end"] != "survives":
            job.note_kill(number, read["test"], read.get("seconds", 0.0))


def run_children(items: Sequence[Item], job: Schedule, session: pytest.Session) -> None:
    running: dict[int, tuple[int, list[str], list[str]]] = {}
    learn(job)
    job.learn_hints()
    gc.freeze()  # else the first collection of each child copies all memory

    def wait_for_one() -> None:
        child, code, used = os.wait4(-1, 0)
        if child in running:
            number, earlier, now = running.pop(child)
            seconds = used.ru_utime + used.ru_stime
            note_end(number, code, seconds, [*earlier, *now], job)

    for k, number in enumerate(job.by_length()):
        passed = read_status(number, job).get("passed", [])
        tests = job.tests_of(number, items, passed)
        if k % TELL_EVERY == 0:
            tell(session, f"{k} of {len(job.numbers)} mutants begun")
        if not tests:
            note_end(number, SURVIVES, 0.0, passed, job)
            continue
        while len(running) >= job.processes:
            wait_for_one()
        child = in_child(run_child, number, tests, job, session)
        running[child] = number, passed, [item.nodeid for item in tests]
    while running:
        wait_for_one()


# ---- hooks of pytest ----


def read_job() -> Schedule:
    given = json.loads(Path(os.environ[JOB]).read_text())
    for name in ("names", "hints"):
        given[name] = {int(number): value for number, value in given[name].items()}
    for name in ("reach", "status"):
        given[name] = Path(given[name])
    job = Schedule(**given)
    job.load()
    return job


def pytest_configure() -> None:
    """Before test modules import the reference."""
    keep_solved(read_job().status.parent.parent / "solved")


def pytest_collection() -> None:
    """After conftest.py, before the test modules: a failing test need not look for a smaller example."""
    phases = [hypothesis.Phase.explicit, hypothesis.Phase.generate]
    hypothesis.settings.register_profile("mutants", hypothesis.settings(), phases=phases)
    hypothesis.settings.load_profile("mutants")


@pytest.hookimpl(tryfirst=True)
def pytest_runtestloop(session: pytest.Session) -> bool:
    import build_fmu

    job = read_job()
    items = session.items
    keep_compiled(build_fmu, job.status.parent / "compiled")
    marks_file = Path(os.environ[REACHED])
    with marks_file.open("r+b") as file, mmap.mmap(file.fileno(), 0) as marks:
        fresh = [item for item in items if item.nodeid not in job.reached]
        if fresh:
            first_pass(fresh, job, marks)
            job.save()
    control([item for item in items if item.nodeid not in job.failed], job, session)
    sound = [item for item in items if item.nodeid not in job.failed]
    run_children(sound, job, session)
    return True
