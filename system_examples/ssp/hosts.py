"""Runs the programs of tests/verification/masters/hosts that play an SSP package in a master."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from system_examples.ssp.coupling import Columns
from verification.masters import install, players

Words = Sequence[str | Path]
Host = Callable[[Words, Path], Columns]


def ecos(words: Words, file: Path) -> Columns:
    """The rows that ecos writes to `file`. Arguments: its hosts/package.py. Missing or Failed."""
    venv = install.package("ecospy", "tbb")  # ecospy lacks the library tbb
    command = [venv / "bin/python", players.HOSTS / "ecos_ssp.py", *words]
    players.insist(command, file.parent, LD_LIBRARY_PATH=str(venv / "lib"))
    return players.read(file)


def libcosim(words: Words, file: Path) -> Columns:
    """The rows that libcosim writes to `file`. Arguments: its hosts/package.py. Missing or Failed."""
    venv = install.package("libcosimpy")
    players.insist([venv / "bin/python", players.HOSTS / "libcosim_ssp.py", *words], file.parent)
    return players.read(file)
