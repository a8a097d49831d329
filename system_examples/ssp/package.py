"""The example systems as packages in the build's folder."""

from __future__ import annotations

from pathlib import Path

from dualcam import ssp
from system_examples.ssp.parts import BUILD

FOLDER = BUILD / "ssp"


class ExampleSystem(ssp.System):
    """A system with a place for its package."""

    @property
    def path(self) -> Path:
        """The package."""
        return FOLDER / f"{self.name}.ssp"

    def write(self) -> Path:
        """Write the package to its place."""
        FOLDER.mkdir(parents=True, exist_ok=True)
        return self.save(self.path)
