"""Child processes of the fork server: tests with a mutant in force, and the same tests without one.

The child of a mutant runs only the tests in which the mutant makes a difference, up to the first failure
(schedule.py). A pass without a mutant has noted how long each test takes, and tests that fail there are left
out. An end by failure, crash or time counts once it is confirmed. The test must pass in a process of its own
without a mutant: fixtures and results that other tests leave behind could be the cause. An end by time must
happen once more, in a process of its own with no other child beside it, and with a longer limit: the first
limit knows no fixtures that other tests had made, and no other work on the machine. A mutant whose end is
not confirmed meets the other tests, too.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import json
import os
import resource
import shutil
import signal
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest
from _pytest.runner import runtestprotocol

from verification.strength.schedule import Item, Schedule
from verification.strength.switch import ACTIVE, SYMBOL

WAITING = 120.0  # s by the clock, on top, for one test that waits without computing
SHARE = 0.05  # of a processor that a test has at least, on a machine with other work
TELL_EVERY = 20  # mutants
MEMORY = 4 << 30  # bytes, of a child
PASSED, FAILED, BROKEN = 0, 1, 2  # exit codes; BROKEN: an error outside of a test
SURVIVES, FAILS, TIME = "survives", "fails", "time"  # ends of a mutant, beside "crash SIGSEGV" and the like


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


# ---- inside of a child ----


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


def run_child(
    number: int, items: Sequence[Item], limits: Sequence[float], job: Schedule, session: pytest.Session
) -> None:
    """Runs the tests of one mutant and ends the process. Signals end it where a test takes more than its
    limit of processor time, or much more by the clock."""
    enter_child(number, items, job, session)
    status = at_present(number, job)
    for k, (item, limit) in enumerate(zip(items, limits, strict=True)):
        status.write_text(item.nodeid)
        signal.setitimer(signal.ITIMER_PROF, limit)
        signal.setitimer(signal.ITIMER_REAL, WAITING + limit / SHARE)
        if not passes(items, k):
            os._exit(FAILED)
    os._exit(PASSED)


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
    os._exit(PASSED)


# ---- children, seen from the server ----


def at_present(number: int, job: Schedule) -> Path:
    """The file with the name of the test that runs."""
    return job.status / f"{number}.running"


def control_notes(number: int, job: Schedule) -> Path:
    return job.reach.with_name(f"control{number}.json")


def folder_of(number: int, job: Schedule) -> Path:
    return job.status.parent / "temporary" / str(number)


def in_child(run: Callable[..., None], number: int, items: Sequence[Item], *rest: object) -> int:
    """The process in which `run` runs, with a group of its own for the programs that its tests start."""
    child = os.fork()
    if child == 0:
        try:
            os.setpgid(0, 0)
            run(number, items, *rest)
        finally:
            os._exit(BROKEN)
    return child


def end_group(child: int) -> None:
    """Programs that a test of this child has started and left running would slow down other tests."""
    with contextlib.suppress(ProcessLookupError):
        os.killpg(child, signal.SIGKILL)


def read_controls(children: dict[int, int], job: Schedule) -> tuple[dict[str, float], list[str]]:
    """Waits for control runs, `children` by their numbers: s of each test, and those that fail."""
    seconds: dict[str, float] = {}
    failed: list[str] = []
    for number, child in children.items():
        _, code = os.waitpid(child, 0)
        end_group(child)
        if code != 0:
            raise SystemExit(f"mutants: the tests without a mutant end with {code} in a child process")
        found = json.loads(control_notes(number, job).read_text())
        seconds |= found[0]
        failed += found[1]
        shutil.rmtree(folder_of(number, job), ignore_errors=True)
    return seconds, failed


def control(items: Sequence[Item], job: Schedule, session: pytest.Session) -> None:
    """Times of the tests in children, for those whose time is not known. A child takes whole files."""
    fresh = [item for item in items if item.nodeid not in job.seconds and item.nodeid not in job.failed]
    if not fresh:
        return
    tell(session, f"second pass: {len(fresh)} tests")
    numbers = {-k: part for k, part in enumerate(shares(fresh, job.processes)) if part}
    children = {n: in_child(run_control, n, part, job, session) for n, part in numbers.items()}
    seconds, failed = read_controls(children, job)
    job.seconds |= seconds
    job.failed += failed
    for name in failed:
        tell(session, f"fails without a mutant in a child process: {name}")
    job.save()


def shares(items: Sequence[Item], count: int) -> list[list[Item]]:
    """Tests of one file stay together: they share fixtures."""
    files = list(dict.fromkeys(item.location[0] for item in items))
    return [[item for item in items if files.index(item.location[0]) % count == k] for k in range(count)]


# ---- what came of a mutant ----


def read_status(number: int, job: Schedule) -> dict[str, Any]:
    """What has been found out about the mutant: `end`, `test`, `passed`, `confirmed`."""
    path = job.status / str(number)
    return json.loads(path.read_text()) if path.exists() else {}


def write_status(number: int, found: dict[str, Any], job: Schedule) -> None:
    path = job.status / str(number)
    path.with_suffix(".new").write_text(json.dumps(found))
    path.with_suffix(".new").replace(path)


def end_of(number: int, code: int, job: Schedule) -> tuple[str, str]:
    """What came of the tests by the exit code of the child, and the last test that ran."""
    present = at_present(number, job)
    if not present.exists() and code != 0:
        raise SystemExit(f"mutants: the child of mutant {number} ends with {code} before its first test")
    last = present.read_text() if present.exists() else ""
    present.unlink(missing_ok=True)
    shutil.rmtree(folder_of(number, job), ignore_errors=True)
    if os.WIFSIGNALED(code):
        name = signal.Signals(os.WTERMSIG(code)).name
        return TIME if name in ("SIGPROF", "SIGALRM") else f"crash {name}", last
    words = {PASSED: SURVIVES, FAILED: FAILS}
    return words.get(os.WEXITSTATUS(code), "crash of pytest"), last


def note_survival(number: int, passed: Sequence[str], job: Schedule) -> None:
    last = f"{len(passed)} tests"
    if not passed:
        last = "no test in which it differs" if number in job.touched else "no test"
    found = {"end": SURVIVES, "test": last, "passed": list(passed), "core": job.core, "confirmed": True}
    write_status(number, found, job)


def note_kill(number: int, end: str, test: str, before: Sequence[str], seconds: float, job: Schedule) -> None:
    """`seconds`: of the child. `before`: tests that the mutant has passed before."""
    found = {"end": end, "test": test, "seconds": round(seconds, 2), "passed": list(before), "core": job.core}
    write_status(number, found | {"confirmed": False}, job)
    if end != TIME:
        job.note_kill(number, test, seconds)


# ---- is the end of a mutant certain? ----


def seconds_alone(item: Item, job: Schedule, session: pytest.Session) -> float:
    """s of a test without a mutant, in a process of its own. A test that fails there is left out."""
    if item.nodeid not in job.alone:
        seconds, failed = read_controls({0: in_child(run_control, 0, [item], job, session)}, job)
        job.alone |= seconds
        job.failed += failed
        for name in failed:
            tell(session, f"fails without a mutant and without other tests: {name}")
        job.save()
    return job.alone[item.nodeid]


def happens_again(number: int, item: Item, usual: float, job: Schedule, session: pytest.Session) -> str:
    """The end of a mutant that meets one test, with a longer limit."""
    child = in_child(run_child, number, [item], [job.longer_limit(usual)], job, session)
    _, code = os.waitpid(child, 0)
    end_group(child)
    return end_of(number, code, job)[0]


def is_confirmed(number: int, items: Sequence[Item], job: Schedule, session: pytest.Session) -> bool:
    """Where the end of a mutant is not certain, its file says which tests it has passed."""
    found = read_status(number, job)
    if found.get("confirmed"):
        return True
    (item,) = (item for item in items if item.nodeid == found["test"])
    usual = seconds_alone(item, job, session)
    if item.nodeid in job.failed:
        write_status(number, found | {"end": "", "test": ""}, job)
        return False
    if found["end"] == TIME:
        found["end"] = happens_again(number, item, usual, job, session)
        if found["end"] != SURVIVES:
            job.note_kill(number, item.nodeid, usual)
    if found["end"] == SURVIVES:
        tell(session, f"mutant {number} takes no longer than it may: {item.nodeid}")
        job.seconds[item.nodeid] = max(usual, job.seconds[item.nodeid])
        found["passed"].append(item.nodeid)
        write_status(number, found | {"end": "", "test": ""}, job)
        return False
    write_status(number, found | {"confirmed": True}, job)
    return True


# ---- all mutants ----


def learn(job: Schedule) -> None:
    """The tests that killed mutants in an earlier run."""
    for number in job.names:
        read = read_status(number, job)
        if read.get("confirmed") and read["end"] != SURVIVES:
            job.note_kill(number, read["test"], read.get("seconds", 0.0))


def play(numbers: Sequence[int], items: Sequence[Item], job: Schedule, session: pytest.Session) -> None:
    """Lets each mutant meet its tests, up to the first failure."""
    running: dict[int, tuple[int, list[str], list[str]]] = {}

    def wait_for_one() -> None:
        child, code, used = os.wait4(-1, 0)
        if child not in running:
            return
        end_group(child)
        number, earlier, now = running.pop(child)
        end, last = end_of(number, code, job)
        if end == SURVIVES:
            note_survival(number, [*earlier, *now], job)
        else:
            before = [*earlier, *now[: now.index(last)]]
            note_kill(number, end, last, before, used.ru_utime + used.ru_stime, job)

    try:
        for k, number in enumerate(numbers):
            passed = read_status(number, job).get("passed", [])
            tests = job.tests_of(number, items, passed)
            if k % TELL_EVERY == 0:
                tell(session, f"{k} of {len(numbers)} mutants begun")
            if not tests:
                note_survival(number, passed, job)
                continue
            while len(running) >= job.processes:
                wait_for_one()
            child = in_child(run_child, number, tests, job.limits_of(tests), job, session)
            running[child] = number, passed, [item.nodeid for item in tests]
        while running:
            wait_for_one()
    finally:
        for child in running:
            end_group(child)


def run_children(items: Sequence[Item], job: Schedule, session: pytest.Session) -> None:
    """At most as many turns as there are tests: a mutant whose end is not confirmed has passed one more, or
    a test is left out."""
    learn(job)
    job.learn_hints()
    gc.freeze()  # else the first collection of each child copies all memory
    numbers = job.by_length()
    while numbers:
        play(numbers, [item for item in items if item.nodeid not in job.failed], job, session)
        tell(session, "ends by failure or time are confirmed")
        numbers = [number for number in numbers if not is_confirmed(number, items, job, session)]
