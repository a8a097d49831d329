import ctypes
import zipfile

import build_fmu
import house
import pytest
from decay_fmu import make_decay_fmu
from driver import ROOT, Driver, layout_code, load, models
from hypothesis import settings
from hypothesis.internal.conjecture import providers

# Helpers whose failed assertions pytest shows with values, as it does in test files.
pytest.register_assert_rewrite("control_cases", "fmi3_scenes", "helix_balance", "state_table", "study_cases")

# Hypothesis also tries constants out of the source of whatever modules are loaded: then the derandomized
# profile would depend on which tests ran before in the same process.
if hasattr(providers, "_get_local_constants"):
    providers._get_local_constants = lambda: providers._local_constants

settings.register_profile("short", max_examples=250, deadline=None, derandomize=True)
settings.register_profile("long", max_examples=20_000, deadline=None)
settings.load_profile("short")


def pytest_addoption(parser):
    parser.addoption("--count-skips", action="store_true", help="fail if more is skipped than most_skipped")
    parser.addini("most_skipped", "tests that continuous integration may skip", type="int", default=0)


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session):
    """A runner that lost a program skips its tests: that is no success."""
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")  # not in a process of xdist
    if reporter is None or not session.config.getoption("count_skips"):
        return
    skipped, most = len(reporter.stats.get("skipped", [])), session.config.getini("most_skipped")
    if skipped > most and session.exitstatus == pytest.ExitCode.OK:
        reporter.write_line(
            f"{skipped} tests are skipped, allowed are {most} (most_skipped in pyproject.toml)"
        )
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.fixture(scope="session")
def binaries(tmp_path_factory):
    """The shared library of each FMU, by model identifier."""
    platform, found = build_fmu.host_platform(2), {}
    for name, model in models.items():
        if not model.fmu.exists():
            pytest.exit(f"{model.fmu} is missing: run ./build.sh first", returncode=1)
        directory = tmp_path_factory.mktemp(name)
        with zipfile.ZipFile(model.fmu) as archive:
            archive.extractall(directory)
        found[name] = directory / "binaries" / platform.folder / platform.library(name).name
    return found


@pytest.fixture(scope="session")
def libraries(binaries):
    return {name: load(binary) for name, binary in binaries.items()}


@pytest.fixture(scope="session")
def model():
    """The FMU under test: forward, unless a module says otherwise."""
    return models["DualCamForward"]


@pytest.fixture
def binary(binaries, model):
    return binaries[model.identifier]


@pytest.fixture
def library(libraries, model):
    return libraries[model.identifier]


@pytest.fixture
def make_model(libraries):
    """Instances of any FMU, freed at the end of the test."""
    made = []

    def make_one(model, **options):
        made.append(Driver(libraries[model.identifier], model=model, **options))
        assert made[-1].instance
        return made[-1]

    yield make_one
    for driver in made:
        driver.free()


@pytest.fixture
def make(make_model, model):
    """Instances of the FMU under test."""
    return lambda **options: make_model(model, **options)


@pytest.fixture
def fmu(make):
    return make()


@pytest.fixture(scope="session")
def core(tmp_path_factory):
    """Compiles a room of the C core and the rooms below, whose functions are then called one by one.
    `headers`: names like "contact/contact"; the last one names the highest room."""

    rooms_in_order = list(house.MAY_INCLUDE)

    def compiled(headers, structures, code=""):
        directory = tmp_path_factory.mktemp("core")
        shim, library = directory / "shim.c", directory / "libcore.so"
        includes = "".join(f'#include "{name}.h"\n' for name in headers)
        shim.write_text("#include <stddef.h>\n" + includes + layout_code(structures) + code)
        highest = rooms_in_order.index(headers[-1].partition("/")[0])
        rooms = [ROOT / "fmu_src" / room for room in rooms_in_order[: highest + 1]]
        sources = sorted(source for room in rooms for source in room.glob("*.c"))
        flags = ["-O2", "-fPIC", "-shared", *build_fmu.TARGET, str(shim)]
        build_fmu.compile_c(build_fmu.ZIG, flags, sources, library)
        return ctypes.CDLL(str(library))

    return compiled


@pytest.fixture(scope="session")
def decay(tmp_path_factory):
    """An FMU that is not the cam's."""
    return make_decay_fmu(tmp_path_factory.mktemp("other"))
