"""Designs for the tests of the export, and exported FMUs as the drivers see them."""

import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import build_fmu
import driver
import driver3

from dualcam.scenario.scenario import Scenario

FOLDERS = {2: "linux64", 3: "x86_64-linux"}
FACTORY = {(v, d.models[n].identifier): d.models[n] for v, d in ((2, driver), (3, driver3)) for n in d.models}
IDENTIFIERS = {"forward": "DualCamForward", "inverse": "DualCamInverse"}


@dataclass(frozen=True)
class Design:
    """A stand-in for a design file."""

    parameters: Mapping[str, float | int | bool | str]
    model: str = "forward"
    name: str = "trial"
    title: str = ""
    scenario: Scenario | None = None


# Numbers that no shorter decimal represents, so that every bit is tested.
SPRING = {"spring.preload": 100.0 / 3.0, "spring.stiffness": 30000.1, "cam1.friction": 0.1 + 0.02}
HELIX = {"cam1.radius": 0.021, "cam2.lead_angle": 0.9, "inertia.shaft": 0.003, "contacts": 1, **SPRING}
ELLIPSE = {
    **SPRING,
    "cam1.profile": 2,
    "cam1.lead_angle": 0.6,
    "cam1.ellipse_curvature": 1,
    "cam1.ellipse_a": 0.1,
    "stop.upper": 0.9,
    "spring.stiffness2": 1e4 / 3.0,
    "shaft.damping": 0.01,
}
TABLES = {"cam1.profile": 3, "cam2.profile": 3, "stop.upper": 1.1, **SPRING}


def write_table(path: Path, slope: float, curvature: float) -> Path:
    """A groove z = slope psi + curvature psi^2."""
    points = [k * 0.05 - 0.1 for k in range(30)]
    rows = [f"{psi:.17g},{slope * psi + curvature * psi * psi:.17g}" for psi in points]
    path.write_text("psi_rad,z_m\n" + "\n".join(rows) + "\n")
    return path


def designs(folder: Path) -> dict[str, dict]:
    """Name -> parameters. Tables are written into `folder`."""
    tables = {
        "cam1.table": str(write_table(folder / "first groove.csv", 0.02, 0.002)),
        "cam2.table": str(write_table(folder / "zweite Nut ü.csv", 0.017, -0.001)),
    }
    return {"helix": HELIX, "ellipse": ELLIPSE, "table": TABLES | tables}


class Exported:
    """An exported FMU: its files, and what the drivers need."""

    def __init__(self, path: Path, fmi: int, folder: Path) -> None:
        self.path, self.fmi, self.folder = path, fmi, folder
        with zipfile.ZipFile(path) as archive:
            self.names = archive.namelist()
            archive.extractall(folder)
        self.drivers = driver if fmi == 2 else driver3
        (self.binary,) = (folder / "binaries" / FOLDERS[fmi]).iterdir()
        self.model = self.drivers.Model(self.binary.stem)
        self.model.fmu, self.model.xml = path, folder / "modelDescription.xml"

    @cached_property
    def library(self):
        return self.drivers.load(self.binary)

    @property
    def resources(self) -> str:
        """As a master of this version of FMI says where the resources are."""
        place = self.folder / "resources"
        return place.as_uri() if self.fmi == 2 else f"{place}/"

    def instance(self, **options):
        return self.drivers.Driver(self.library, model=self.model, **{"resources": self.resources, **options})


def factory_members(fmi: int, model: str) -> dict[str, bytes]:
    with zipfile.ZipFile(FACTORY[fmi, IDENTIFIERS[model]].fmu) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def compile_options(fmi: int, model: str, guid: str) -> list[str]:
    """Options with which fmu_src compiles to that FMU."""
    defines = [f"-DMODEL_BUILT=MODEL_{model.upper()}", f"-DFMI_VERSION={fmi}", f'-DMODEL_GUID="{guid}"']
    return ["-std=c17", "-O1", "-isystem", str(build_fmu.fmi_headers()), "-I", str(build_fmu.CORE), *defines]
