"""The folders of the repository, and which products of a build are up to date.

A product is a file below build/. Beside each product stands a stamp, the hash of everything on which the
product depends. A product is made again only when its stamp has changed.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from filelock import FileLock

ROOT = Path(__file__).resolve().parent.parent.parent
CORE = ROOT / "fmu_src"
TOOLS = CORE / "tools"
FLEET = ROOT / "dualcam/fleet"  # with the C code of the library of dualcam.Fleet
WEB_ROOM = CORE / "web"  # C code of the modules for a browser, of no FMU
BUILD = ROOT / "build"
DESCRIPTIONS = ROOT / "modelDescription"
BARE = ROOT / "benchmarks/null_fmu"  # FMI 2.0 in its smallest form, also for FMUs of other builds


class BuildError(Exception):
    """A build that cannot go on; the message names the file or the command."""


def say(text: str) -> None:
    print(f"-- {text}", flush=True)


def relative(path: Path) -> str:
    """The name of a file within the repository, with slashes on every system."""
    return path.relative_to(ROOT).as_posix()


def place(version: int) -> Path:
    """The folder of the FMUs for one version of FMI."""
    return BUILD if version == 2 else BUILD / f"fmi{version}"


def headers() -> list[Path]:
    """Every file that a C file may include."""
    return [*CORE.rglob("*.h"), *CORE.glob("*.def"), *BARE.glob("*.h")]


def build_program() -> list[Path]:
    """The modules of the build on which the bytes of the products depend, for example by a compiler option.
    The other modules make members and texts, which are inputs themselves."""
    return [TOOLS / f"{name}.py" for name in ("archive", "compiler", "platforms", "products")]


@cache
def compiler_versions() -> list[str]:
    """Of the compiler and of the FMI headers."""
    return [importlib.metadata.version(package) for package in ("ziglang", "fmpy")]


def fingerprint(files: Iterable[Path], *words: str) -> str:
    """Hash of all on which a product depends: the files with their names, `words`, the compiler's version."""
    digest = hashlib.sha256()
    for path in sorted(files):
        digest.update(f"{relative(path)}\0".encode())
        digest.update(path.read_bytes() + b"\0")
    for word in (*words, *compiler_versions()):
        digest.update(f"{word}\0".encode())
    return digest.hexdigest()


def stamp_of(product: Path) -> Path:
    return product.with_name(product.name + ".stamp")


def is_fresh(product: Path, stamp: str) -> bool:
    """Does the product exist, made from what `stamp` is the fingerprint of?"""
    file = stamp_of(product)
    return product.exists() and file.exists() and file.read_text(encoding="utf-8") == stamp


def set_stamp(product: Path, stamp: str) -> None:
    stamp_of(product).write_text(stamp, encoding="utf-8")


def locked() -> FileLock:
    """A context in which no other process builds: parallel test workers may ask at the same time."""
    BUILD.mkdir(exist_ok=True)
    return FileLock(BUILD / "lock")
