import ctypes
import sys
import zipfile

import pytest
from driver import FMU, ROOT, Driver, load
from hypothesis import settings

sys.path.insert(0, str(ROOT / "fmu_src"))
import build_fmu

settings.register_profile("short", max_examples=500, deadline=None, derandomize=True)
settings.register_profile("long", max_examples=20_000, deadline=None)
settings.load_profile("short")


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


@pytest.fixture(scope="session")
def core(tmp_path_factory):
    """The C core's pure functions (no FMI), to be called one by one."""
    library = tmp_path_factory.mktemp("core") / "libcore.so"
    sources = [ROOT / "fmu_src" / f"{name}.c" for name in ("contact", "oscillator")]
    flags = ["-O2", "-fPIC", "-shared", *build_fmu.TARGET]
    build_fmu.compile_c(build_fmu.ZIG, flags, sources, library)
    return ctypes.CDLL(str(library))
