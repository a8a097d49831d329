"""The version of this package."""

import tomllib
from importlib import metadata
from pathlib import Path


def _version() -> str:
    """The installed version, or that of the pyproject.toml of a checkout that is not installed."""
    try:
        return metadata.version("dualcam")
    except metadata.PackageNotFoundError:
        project = Path(__file__).resolve().parents[2] / "pyproject.toml"
        if not project.is_file():
            return "unknown"
        return str(tomllib.loads(project.read_text(encoding="utf-8"))["project"]["version"])


__version__ = _version()
