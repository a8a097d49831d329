"""Files of packages of the npm registry, as pyproject.toml pins them in [tool.dualcam.web]: the version, the
integrity that the registry gives for the package's archive, and the files that are used.

An archive is downloaded once, into build/npm. The environment variables of other programs count:
`npm_config_registry` names another registry, `HTTPS_PROXY` a proxy, `SSL_CERT_FILE` the certificates.
"""

from __future__ import annotations

import base64
import hashlib
import io
import os
import shutil
import tarfile
import tomllib
import urllib.request
from dataclasses import dataclass
from http.client import HTTPException
from pathlib import Path

from workspace import BUILD, ROOT, BuildError, fingerprint, is_fresh, relative, say, set_stamp

REGISTRY = "https://registry.npmjs.org"
DOWNLOADS = BUILD / "npm"
LONGEST = 20.0  # s without an answer from the registry


@dataclass(frozen=True)
class Package:
    """A pinned package. `files` are names in its archive, below the folder `package`."""

    name: str
    version: str
    integrity: str  # "sha512-" and the hash of the archive in base64
    files: tuple[str, ...]

    @property
    def url(self) -> str:
        """Where the registry has the archive."""
        settings = {name.lower(): value for name, value in os.environ.items()}  # npm takes any case
        registry = settings.get("npm_config_registry") or REGISTRY
        return f"{registry.rstrip('/')}/{self.name}/-/{self.name}-{self.version}.tgz"

    @property
    def archive(self) -> Path:
        """Where the downloaded archive is kept."""
        return DOWNLOADS / f"{self.name}-{self.version}.tgz"

    def is_intact(self, content: bytes) -> bool:
        """Is this the archive that is pinned?"""
        digest = base64.b64encode(hashlib.sha512(content).digest()).decode()
        return self.integrity == f"sha512-{digest}"


def pinned(name: str) -> Package:
    """The package `name` of [tool.dualcam.web]."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    row = project["tool"]["dualcam"]["web"][name]
    return Package(name, row["version"], row["integrity"], tuple(row["files"]))


def download(package: Package) -> bytes:
    """The archive of the package from the registry.

    Raises
    ------
    BuildError
        The registry cannot be reached, or has another archive than the pinned one.
    """
    say(f"download {package.url}")
    advice = (
        "The page of `dualcam view` needs this package. Build again with a network, or name a registry that"
        " can be reached in the environment variable npm_config_registry, or a proxy in HTTPS_PROXY, or put"
        f" the file {package.archive.name} into {relative(DOWNLOADS)}"
    )
    try:
        with urllib.request.urlopen(package.url, timeout=LONGEST) as answer:
            content: bytes = answer.read()
    except (OSError, ValueError, HTTPException) as error:  # no network, no such file, no address, a cut
        raise BuildError(f"{package.url} was not downloaded: {error}. {advice}") from error
    if not package.is_intact(content):
        raise BuildError(
            f"{package.url} is not the archive that pyproject.toml pins ({package.integrity}). {advice}"
        )
    return content


def archive_of(package: Package) -> bytes:
    """The archive of the package: a downloaded one if there is one, else from the registry."""
    if package.archive.is_file():
        kept = package.archive.read_bytes()
        if package.is_intact(kept):
            return kept
    content = download(package)
    DOWNLOADS.mkdir(parents=True, exist_ok=True)
    unfinished = package.archive.with_suffix(f".{os.getpid()}")
    unfinished.write_bytes(content)
    unfinished.replace(package.archive)
    return content


def used_files(package: Package) -> dict[str, bytes]:
    """Name without folder -> content, of the files that are used."""
    found = {}
    with tarfile.open(fileobj=io.BytesIO(archive_of(package)), mode="r:gz") as archive:
        for file in package.files:
            try:
                member = archive.extractfile(f"package/{file}")
            except KeyError:
                member = None
            if member is None:
                raise BuildError(f"{package.archive.name} has no file {file}, which pyproject.toml names")
            found[Path(file).name] = member.read()
    return found


def install(name: str, folder: Path) -> Path:
    """Writes the used files of a package into `folder`/`name`, without their folders; returns that folder.

    Raises
    ------
    BuildError
        The archive cannot be had, or lacks a file.
    """
    package, place = pinned(name), folder / name
    stamp = fingerprint([], package.name, package.version, package.integrity, *package.files)
    if is_fresh(place, stamp) and all((place / Path(file).name).is_file() for file in package.files):
        return place
    contents = used_files(package)
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    for name, content in contents.items():
        (place / name).write_bytes(content)
    set_stamp(place, stamp)
    return place
