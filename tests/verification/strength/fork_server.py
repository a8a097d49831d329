"""A pytest plugin: runs the tests once, then once again for each mutant, in a child process.

    DUALCAM_MUTANTS_JOB=job.json python -m pytest -p verification.strength.fork_server TESTS

The first pass has no mutant in force. It notes in which places each test makes a difference. The rest happens
in child processes (children.py), which begin with all that the first pass has imported and compiled.
"""

from __future__ import annotations

import functools
import hashlib
import importlib
import json
import mmap
import os
import pickle
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from types import ModuleType
from typing import Any

import hypothesis
import pytest
from _pytest.runner import runtestprotocol

from verification.strength.children import control, failed_in, run_children, tell
from verification.strength.schedule import Item, Schedule
from verification.strength.switch import DIFFERS_BIT, REACHED

JOB = "DUALCAM_MUTANTS_JOB"
TELL_EVERY = 200  # tests

# ---- the first pass ----


def first_pass(items: Sequence[Item], job: Schedule, marks: mmap.mmap) -> None:
    for k, item in enumerate(items):
        marks[:] = bytes(len(marks))
        reports = runtestprotocol(item, nextitem=items[(k + 1) % len(items)], log=False)
        job.reached[item.nodeid] = [n for n, mark in enumerate(marks[:]) if mark & DIFFERS_BIT]
        job.touched = sorted({*job.touched, *(n for n, mark in enumerate(marks[:]) if mark)})
        if failed_in(reports):
            job.failed.append(item.nodeid)
            tell(item, f"fails without a mutant: {item.nodeid}")
        if k % TELL_EVERY == 0:
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
    run_children(items, job, session)
    return True
