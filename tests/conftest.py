import zipfile

import pytest
from driver import FMU, Driver, load


@pytest.fixture(scope="session")
def unzipped(tmp_path_factory):
    if not FMU.exists():
        pytest.exit(f"{FMU} is missing: run ./build.sh first", returncode=1)
    directory = tmp_path_factory.mktemp("DualCamForward")
    with zipfile.ZipFile(FMU) as archive:
        archive.extractall(directory)
    return directory


@pytest.fixture(scope="session")
def binary(unzipped):
    return unzipped / "binaries" / "linux64" / "DualCamForward.so"


@pytest.fixture(scope="session")
def library(binary):
    return load(binary)


@pytest.fixture
def make(library):
    """Instances, freed at the end of the test."""
    made = []

    def make_one(**options):
        made.append(Driver(library, **options))
        assert made[-1].component
        return made[-1]

    yield make_one
    for driver in made:
        driver.free()


@pytest.fixture
def fmu(make):
    return make()
