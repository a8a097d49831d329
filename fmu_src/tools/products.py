"""Makes the products, each only when an input has changed: libraries and FMUs."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Sequence
from pathlib import Path

from archive import validate, write_archive
from compiler import compile_library, universal
from fmus import Fmu, identity
from platforms import ALL, PLATFORMS_3, Platform, host_platform
from related_files import FOLDER, SMOKE_TEST, STATE, manifest, related_files
from serialized_state import serialized_state
from workspace import (
    BUILD,
    FLEET,
    build_program,
    fingerprint,
    headers,
    is_fresh,
    relative,
    say,
    set_stamp,
)


def build_library(fmu: Fmu, platform: Platform) -> Path:
    """The library of `fmu` for `platform`."""
    library = platform.library(fmu.identifier)
    defines = [*fmu.defines, *identity(fmu)]
    inputs = [*fmu.sources, *headers(), *build_program()]
    stamp = fingerprint(inputs, platform.folder, *platform.targets, *defines)
    if is_fresh(library, stamp):
        return library
    say(f"compile {relative(library)} ({len(fmu.sources)} files)")
    slices = []
    for target in platform.targets:
        part = BUILD / "parts" / f"fmi{fmu.version}" / target / library.name
        compile_library(platform, target, defines, fmu.sources, part)
        slices.append(part.read_bytes())
    library.parent.mkdir(parents=True, exist_ok=True)
    library.write_bytes(slices[0] if len(slices) == 1 else universal(slices))
    set_stamp(library, stamp)
    return library


def build_fleet(platform: Platform) -> Path:
    """The library of `dualcam.Fleet` for `platform`, one of FMI 3.0's."""
    library = BUILD / "fleet" / platform.folder / f"dualcam_fleet{platform.suffix}"
    sources = sorted(FLEET.glob("*.c"))
    stamp = fingerprint([*FLEET.glob("*.[ch]"), *build_program()], *platform.targets)
    if not is_fresh(library, stamp):
        say(f"compile {relative(library)} ({len(sources)} files)")
        compile_library(platform, platform.targets[0], [], sources, library)
        set_stamp(library, stamp)
    return library


def build_fleets(for_all: bool = False) -> list[Path]:
    """The library of `dualcam.Fleet` for this machine or, with `for_all`, for all platforms."""
    return [build_fleet(platform) for platform in (PLATFORMS_3 if for_all else (host_platform(3),))]


def build(fmu: Fmu, for_all: bool = False) -> None:
    """Makes the FMU for this machine or, with `for_all`, for all platforms. An up-to-date FMU for all
    platforms stays where only this machine is asked for."""
    every = ALL[fmu.version]
    platforms = every if for_all else (host_platform(fmu.version),)
    inputs = [*fmu.sources, *fmu.extra.values(), *headers(), *build_program()]

    def stamp(held: Sequence[Platform]) -> str:
        folders = [platform.folder for platform in held]
        texts = [*fmu.texts, *fmu.texts.values()]
        return fingerprint(inputs, fmu.description, *fmu.defines, *fmu.extra, *texts, *folders)

    if any(is_fresh(fmu.path, stamp(held)) for held in (platforms, every)):
        return
    members = {name: path.read_bytes() for name, path in fmu.extra.items()}
    members |= {name: text.encode() for name, text in fmu.texts.items()}
    members["modelDescription.xml"] = fmu.description.encode()
    for platform in platforms:
        library = build_library(fmu, platform)
        members[f"binaries/{platform.folder}/{library.name}"] = library.read_bytes()
    members |= _layered_standard(fmu, platforms)
    unfinished = fmu.path.with_suffix(f".{os.getpid()}.fmu")
    try:
        write_archive(unfinished, members)
        validate(unfinished)
        unfinished.replace(fmu.path)
    finally:
        unfinished.unlink(missing_ok=True)
    set_stamp(fmu.path, stamp(platforms))
    say(f"{relative(fmu.path)} ({fmu.path.stat().st_size // 1024} kB, valid)")


def _layered_standard(fmu: Fmu, platforms: Sequence[Platform]) -> dict[str, bytes]:
    """Manifest and serialized state, where this machine can make the state."""
    if f"{FOLDER}/{SMOKE_TEST}" not in fmu.texts:
        return {}
    host = host_platform(fmu.version)
    sets = [path for name, path in fmu.extra.items() if name.endswith(".ssv")]
    made = host.folder if host in platforms else None
    found = {f"{FOLDER}/fmi-ls-manifest.xml": manifest(related_files(fmu.identifier, sets, made)).encode()}
    if made is not None:
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch) / "binaries" / host.folder
            folder.mkdir(parents=True)
            shutil.copy(host.library(fmu.identifier), folder)
            (Path(scratch) / "modelDescription.xml").write_text(fmu.description, encoding="utf-8")
            found[f"{FOLDER}/{STATE}"] = serialized_state(Path(scratch), fmu.identifier)
    return found
