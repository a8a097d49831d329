"""Installs the masters into build/masters; versions of Python packages are those of pyproject.toml, group
`masters`, all others are pinned here."""

from __future__ import annotations

import http.client
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
import urllib.request
import zipfile
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import build_fmu
import ziglang
from build_fmu import ROOT

FOLDER = build_fmu.BUILD / "masters"
CENTRAL = "https://repo1.maven.org/maven2"

# group:artifact:version[:classifier], as in Maven
MAESTRO = "org.into-cps.maestro:maestro:3.1.1:jar-with-dependencies"
VDMCHECK = "org.into-cps.vdmcheck.fmi2:vdmcheck2:1.1.3:distribution-static"
FMI4J = [
    "info.laht.fmi4j:fmi-import:0.38.0",
    "info.laht.fmi4j:fmi-md:0.38.0",  # and what these two need:
    "org.jetbrains.kotlin:kotlin-stdlib:1.7.10",
    "org.slf4j:slf4j-api:1.7.25",
    "javax.xml.bind:jaxb-api:2.3.1",
    "javax.activation:javax.activation-api:1.2.0",
    "org.glassfish.jaxb:jaxb-runtime:2.3.3",
    "org.glassfish.jaxb:txw2:2.3.3",
    "com.sun.istack:istack-commons-runtime:3.0.11",
]
FMI_SIM = "0.7.0"  # on crates.io

Words = Sequence[str | Path]


class Missing(Exception):
    """Why a master cannot be installed here."""


class Failed(Exception):
    """What went wrong in a master that is installed."""


def say(text: str) -> None:
    print(f"== {text}", flush=True)


def version_of(coordinates: str) -> str:
    return coordinates.split(":")[2]


@cache
def pins() -> dict[str, str]:
    """Package to version, of the group `masters`."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    return dict(pin.split("==") for pin in project["optional-dependencies"]["masters"])


def program(name: str, what: str) -> str:
    found = shutil.which(name)
    if found is None:
        raise Missing(f"no {name} ({what})")
    return found


def attempt(
    command: Words, limit: float, folder: Path | None = None, **variables: str
) -> subprocess.CompletedProcess[str]:
    words, environment = [str(word) for word in command], os.environ | variables
    return subprocess.run(words, capture_output=True, text=True, timeout=limit, env=environment, cwd=folder)


def complaint(done: subprocess.CompletedProcess[str]) -> str:
    """The first line that speaks of an error, or else the last line."""
    lines = [line.strip() for line in (done.stderr + done.stdout).splitlines() if line.strip()]
    telling = [
        line for line in lines if re.search("error|exception|invalid|panicked|refused", line, re.IGNORECASE)
    ]
    return (telling or lines[-1:] or ["no message"])[0][:200]


def run(command: Words, what: str, limit: float) -> None:
    """A part of an installation."""
    try:
        done = attempt(command, limit)
    except subprocess.TimeoutExpired:
        raise Missing(f"{what}: not done after {limit:.0f} s") from None
    if done.returncode != 0:
        raise Missing(f"{what}: {complaint(done)}")


@cache
def environment() -> Path:
    """The virtual environment for the masters from PyPI."""
    folder = FOLDER / "venv"
    if not (folder / "bin/python").exists():
        run([sys.executable, "-m", "venv", "--clear", folder], "making a virtual environment", 300)
    return folder


@cache
def package(*names: str) -> Path:
    """Has these packages in the virtual environment, which is returned."""
    folder = environment()
    wanted = [f"{name}=={pins()[name]}" for name in names]
    words = ["-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    run([folder / "bin/python", *words, *wanted], f"pip install {' '.join(wanted)}", 600)
    return folder


def site(folder: Path) -> Path:
    return next(folder.glob("lib/python3*/site-packages"))


def artifact(coordinates: str, suffix: str = "jar") -> Path:
    """The file from Maven Central, downloaded once."""
    group, name, version, *classifier = coordinates.split(":")
    file = "-".join([name, version, *classifier]) + f".{suffix}"
    path = FOLDER / "maven" / file
    if not path.exists():
        say(f"download {file}")
        address = f"{CENTRAL}/{group.replace('.', '/')}/{name}/{version}/{file}"
        try:
            with urllib.request.urlopen(address, timeout=60) as response:
                content = response.read()
        except (OSError, http.client.HTTPException) as error:
            raise Missing(f"{address}: {error}") from None
        path.parent.mkdir(parents=True, exist_ok=True)
        part = path.with_suffix(".part")
        part.write_bytes(content)
        part.replace(path)
    return path


@cache
def java(least: int, compiler: bool = False) -> str:
    found = program("java", f"Java {least} or newer")
    text = attempt([found, "-version"], 60).stderr
    number = re.search(r'version "(?:1\.)?(\d+)', text)
    if number is None or int(number[1]) < least:
        raise Missing(f"no Java {least} or newer")
    if compiler:
        program("javac", f"a JDK {least} or newer")
    return found


@cache
def vdmcheck() -> Path:
    """Its script."""
    java(11)
    for name in ("bash", "awk", "realpath"):
        program(name, "VDMCheck2.sh calls it")
    folder = FOLDER / "vdmcheck"
    with zipfile.ZipFile(artifact(VDMCHECK, "zip")) as archive:
        archive.extractall(folder)
    script = next(folder.glob("*/VDMCheck2.sh"))
    script.chmod(0o755)  # it looks for itself with `which`
    return script


@cache
def fmi_sim() -> Path:
    """The program; compiling it takes some minutes."""
    folder = FOLDER / "fmi-sim"
    found = folder / "bin/fmi-sim"
    installed = folder / ".crates.toml"
    if found.exists() and installed.exists() and f"fmi-sim {FMI_SIM} " in installed.read_text():
        return found
    cargo = program("cargo", "Rust")
    # Its build reads FMI's headers with libclang, and these need the compiler's own: zig has them
    libclang = site(package("libclang")) / "clang/native"
    headers = Path(ziglang.__file__).parent / "lib/include"
    settings = {
        "LIBCLANG_PATH": str(libclang),
        "BINDGEN_EXTRA_CLANG_ARGS": shlex.quote(f"-I{headers}"),
        "CARGO_TARGET_DIR": str(folder / "target"),
    }
    say("compile fmi-sim (some minutes)")
    words = [cargo, "install", "fmi-sim", "--version", FMI_SIM, "--locked", "--root", str(folder)]
    if subprocess.run(words, env=os.environ | settings).returncode != 0:  # shows what it is at
        raise Missing("cargo install fmi-sim fails: see what it says above")
    shutil.rmtree(folder / "target", ignore_errors=True)
    return found
