"""Packs the Python package `dualcam` and the FMUs into a wheel: a build backend (PEP 517) around setuptools.

    python -m pip wheel --no-deps --wheel-dir dist .

A wheel holds the FMUs of FMI 2.0 and FMI 3.0 for all platforms and the files for a page in a browser, so that
an installation needs no compiler. The build of the wheel downloads three.js, once.
An editable installation (`pip install -e .`) compiles nothing; its FMUs are those in build/. It also installs
the developers' modules: Python finds the folders that pyproject.toml lists as `pythonpath` of the tests.
"""

from __future__ import annotations

import base64
import hashlib
import os
import shutil
import tomllib
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from setuptools import build_meta
from setuptools.build_meta import (
    build_sdist,
    get_requires_for_build_editable,
    get_requires_for_build_sdist,
    prepare_metadata_for_build_editable,
    prepare_metadata_for_build_wheel,
)
from setuptools.command.build import build
from setuptools.command.build_py import build_py

__all__ = [
    "BuildIntoFolder",
    "BuildPackageWithFmus",
    "build_editable",
    "build_sdist",
    "build_wheel",
    "get_requires_for_build_editable",
    "get_requires_for_build_sdist",
    "get_requires_for_build_wheel",
    "prepare_metadata_for_build_editable",
    "prepare_metadata_for_build_wheel",
]

ROOT = Path(__file__).resolve().parent.parent.parent
STAGING = ROOT / "build" / "package"  # what setuptools copies together before it packs
# Folders in the wheel; dualcam/fmi/library.py looks there.
FMUS = Path("dualcam") / "fmus"
WEB = Path("dualcam") / "web"
FLEET = Path("dualcam") / "fleet" / "lib"
FIRST_DATE = "315532800"  # s since 1970: 1 January 1980, the earliest date in a zip file
Settings = Mapping[str, str | list[str] | None] | None


def pyproject() -> dict[str, Any]:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def module_folders() -> list[str]:
    """The folders of the developers' modules, relative to the repository."""
    return pyproject()["tool"]["pytest"]["ini_options"]["pythonpath"]


def build_editable(
    wheel_directory: str, config_settings: Settings = None, metadata_directory: str | None = None
) -> str:
    """As setuptools builds it, with a file that names the folders of the developers' modules.

    Returns the name of the wheel."""
    name = build_meta.build_editable(wheel_directory, config_settings, metadata_directory)
    folders = "".join(f"{(ROOT / folder).resolve()}\n" for folder in module_folders())
    add_to_wheel(Path(wheel_directory) / name, "dualcam_development.pth", folders.encode())
    return name


def add_to_wheel(wheel: Path, name: str, content: bytes) -> None:
    """Adds a file to a wheel and to the wheel's list of files."""
    with zipfile.ZipFile(wheel) as archive:
        members = {member: archive.read(member) for member in archive.namelist()}
    digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).decode().rstrip("=")
    (record,) = (member for member in members if member.endswith(".dist-info/RECORD"))
    members[record] += f"{name},sha256={digest},{len(content)}\n".encode()
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        for member, data in (members | {name: content}).items():
            archive.writestr(member, data)


def get_requires_for_build_wheel(config_settings: Settings = None) -> list[str]:
    """The packages that a build needs besides setuptools: those of the extra `build` in pyproject.toml."""
    return [
        *build_meta.get_requires_for_build_wheel(config_settings),
        *pyproject()["project"]["optional-dependencies"]["build"],
    ]


def build_wheel(
    wheel_directory: str, config_settings: Settings = None, metadata_directory: str | None = None
) -> str:
    """Builds the FMUs and then the wheel; returns the name of the wheel.

    The same sources give the same bytes: all files have one date and no permissions of this machine.
    """
    os.environ.setdefault("SOURCE_DATE_EPOCH", FIRST_DATE)
    umask = os.umask(0o022)
    try:
        return build_meta.build_wheel(wheel_directory, config_settings, metadata_directory)
    finally:
        os.umask(umask)


class BuildIntoFolder(build):
    """setuptools' command `build`, with its folder inside build/ and empty at the start: setuptools itself
    would pack files of an earlier build that the project no longer has."""

    def initialize_options(self) -> None:
        super().initialize_options()
        self.build_base = str(STAGING)

    def run(self) -> None:
        shutil.rmtree(STAGING, ignore_errors=True)
        super().run()


class BuildPackageWithFmus(build_py):
    """setuptools' command `build_py`, which copies the package, then the FMUs and the files for a page."""

    def run(self) -> None:
        super().run()
        if self.editable_mode:
            return
        package = Path(self.build_lib)
        copy_fmus(package / FMUS)
        copy_web(package / WEB)
        copy_fleet_libraries(package / FLEET)
        for file in package.rglob("*"):
            if file.is_file():
                file.chmod(0o644)


def copy_fmus(folder: Path) -> None:
    """Builds the FMUs for all platforms and copies them to `folder`/fmi2 and `folder`/fmi3."""
    import build_fmu  # needs the packages of get_requires_for_build_wheel

    with build_fmu.locked():
        for version in build_fmu.ALL:
            there = folder / f"fmi{version}"
            there.mkdir(parents=True)
            for model in build_fmu.MODELS:
                fmu = build_fmu.dual_cam(model, check=False, version=version)
                build_fmu.build(fmu, for_all=True)
                shutil.copyfile(fmu.path, there / fmu.path.name)


def copy_fleet_libraries(folder: Path) -> None:
    """Builds the libraries of `dualcam.Fleet` for all platforms and copies each to a folder of its own."""
    import build_fmu

    with build_fmu.locked():
        for library in build_fmu.build_fleets(for_all=True):
            there = folder / library.parent.name
            there.mkdir(parents=True)
            shutil.copyfile(library, there / library.name)


def copy_web(folder: Path) -> None:
    """Builds the files for a page in a browser and copies them to `folder`: WebAssembly and three.js."""
    import build_fmu

    folder.mkdir(parents=True)
    with build_fmu.locked():
        for model in build_fmu.MODELS:
            module = build_fmu.build_wasm(build_fmu.dual_cam(model, check=False))
            shutil.copyfile(module, folder / module.name)
        shutil.copytree(build_fmu.build_three(), folder / "three")
