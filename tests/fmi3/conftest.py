"""Fixtures of the FMI 3.0 tests."""

import zipfile

import build_fmu
import driver3
import pytest
from driver3 import FORWARD, Driver, models


@pytest.fixture(scope="session")
def unzipped3(tmp_path_factory):
    places = {}
    for model in models.values():
        places[model.identifier] = tmp_path_factory.mktemp(f"unzipped3-{model.identifier}")
        with zipfile.ZipFile(model.fmu) as archive:
            archive.extractall(places[model.identifier])
    return places


@pytest.fixture(scope="session")
def libraries3(unzipped3):
    platform = build_fmu.host_platform(3)
    return {
        name: driver3.load(place / "binaries" / platform.folder / platform.library(name).name)
        for name, place in unzipped3.items()
    }


@pytest.fixture
def make3(libraries3):
    """Instances of the FMI 3.0 FMUs, freed at the end of the test."""
    made = []

    def make_one(model=FORWARD, **options):
        made.append(Driver(libraries3[model.identifier], model, **options))
        assert made[-1].instance, made[-1].messages
        return made[-1]

    yield make_one
    for driver in made:
        driver.free()
