"""Circumstances of a measurement: command, date, machine, versions, commit and hash of the C core."""

from __future__ import annotations

import hashlib
import platform
import subprocess
import sys
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from benchmarks.harness.repository import ROOT

FACTS = ("command", "date", "machine", "versions", "commit", "core")
CHANGED = " with changes"
# Results are written into these folders. A change in them does not change the measured program.
WRITTEN = (":!benchmarks/results", ":!tests/verification/results", ":!docs")


def processor() -> str:
    """Name and number of the processors."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return f"{names[0]}, {len(names)} processors" if names else platform.processor()


def git(*words: str, root: Path = ROOT) -> subprocess.CompletedProcess[str]:
    return subprocess.run(["git", *words], cwd=root, capture_output=True, text=True)


def commit(root: Path = ROOT) -> str:
    """The commit that is checked out, and whether a file differs from it or is not in it. "unknown" without
    git.

    The commit that gets the results is always a later one: to amend the measured commit would take it out of
    the history (see is_in_history())."""
    try:
        revision = git("rev-parse", "--short=12", "HEAD", root=root)
        changed = git("status", "--porcelain", "--", ".", *WRITTEN, root=root)
    except OSError:
        return "unknown"
    if revision.returncode != 0 or changed.returncode != 0:
        return "unknown"
    return revision.stdout.strip() + (CHANGED if changed.stdout.strip() else "")


def is_in_history(recorded: str, root: Path = ROOT) -> bool:
    """Whether a recorded commit is clean and an ancestor of the commit that is checked out, or that one."""
    if recorded.endswith(CHANGED) or recorded == "unknown":
        return False
    try:
        return git("merge-base", "--is-ancestor", recorded, "HEAD", root=root).returncode == 0
    except OSError:
        return False


def core_of(root: Path = ROOT) -> str:
    """The hash of all C sources of a repository: results of another core do not hold for this one.

    It needs no history, so it also judges in a shallow clone."""
    core, found = root / "fmu_src", hashlib.sha256()
    for path in sorted(path for path in core.rglob("*") if path.suffix in (".c", ".h", ".def")):
        found.update(path.relative_to(core).as_posix().encode() + b"\0" + path.read_bytes())
    return found.hexdigest()[:12]


def version_of(package: str) -> str:
    try:
        return f"{package} {version(package)}"
    except PackageNotFoundError:
        return f"no {package}"


def circumstances(command: str, *packages: str) -> dict[str, str]:
    """Of this run of `./build.sh run command`. The keys are FACTS.

    `packages`: those whose versions matter, besides Python, FMPy and the compiler."""
    versions = [f"Python {platform.python_version()}", f"FMPy {version('fmpy')}", f"zig {version('ziglang')}"]
    return {
        "command": " ".join(["./build.sh run", *command.split(), *sys.argv[1:]]),
        "date": time.strftime("%Y-%m-%d"),
        "machine": f"{processor()}, {platform.machine()}, {' '.join(platform.libc_ver())}",
        "versions": ", ".join([*versions, *(version_of(package) for package in packages)]),
        "commit": commit(),
        "core": core_of(),
    }
