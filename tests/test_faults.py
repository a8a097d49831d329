"""The FMUs in hosts that do not help (native/faults/): unusual arithmetic, no memory, small stacks, loggers
that do not return, several threads. Each check drives the binaries of both versions of FMI."""

import os
import platform
import re
import shutil
import subprocess

import build_fmu
import pytest
from driver import ROOT, models
from driver3 import models as models3

pytestmark = pytest.mark.skipif(platform.system() != "Linux", reason="the driver replaces functions of glibc")

FOLDER = ROOT / "tests/native"
USED = ("derivatives", "run", "scenes", "support")  # of the lifecycle test
DESCRIPTIONS = [*models.values(), *models3.values()]


@pytest.fixture(scope="session")
def program():
    """One program for all FMUs: the environment tells it the GUID."""
    product = build_fmu.BUILD / "native" / "faults"
    sources = [*(FOLDER / "faults").glob("*.c"), *(FOLDER / "lifecycle" / f"{name}.c" for name in USED)]
    guid = '-DMODEL_GUID=getenv("MODEL_GUID")'
    flags = [*build_fmu.TARGET, "-O1", "-g", "-w", "-rdynamic", "-pthread", guid]
    with build_fmu.locked():
        stamp = build_fmu.fingerprint([*sources, *FOLDER.rglob("*.h")], *flags)
        if not build_fmu.is_fresh(product, stamp):
            build_fmu.compile_c(build_fmu.ZIG, flags, sorted(sources), product)
            build_fmu.set_stamp(product, stamp)
    return product


@pytest.fixture(params=DESCRIPTIONS, ids=repr)
def check(request, program, tmp_path):
    """Runs a check of the driver with the FMU under test; returns what the driver prints."""
    model = request.param
    version = 3 if model.FOLDER == "fmi3" else 2
    binary = build_fmu.host_platform(version).library(model.identifier)
    references = [f"{v.name}={v.reference}" for v in model.variables.values()]

    def run(name: str, **environment: str) -> str:
        command = [program, tmp_path, name, binary, *references]
        variables = {**os.environ, "MODEL_GUID": model.guid, **environment}
        done = subprocess.run(command, capture_output=True, text=True, env=variables)
        assert done.returncode == 0, f"exit {done.returncode}\n{done.stdout}\n{done.stderr[-5000:]}"
        assert "all as it must be" in done.stdout
        return done.stdout

    return run


def test_arithmetic_of_the_host_changes_nothing(check):
    check("arithmetic")


def test_an_allocation_that_fails_is_a_refused_call(check):
    """Each allocation of a life in turn, alone and with all later ones."""
    failed = int(check("memory").split()[0])
    assert failed > 200


def test_a_thread_with_a_stack_of_64_kB_is_enough(check):
    """The page about hosts names the deepest call: 31 kB."""
    assert int(re.search(r"deepest call: (\d+)", check("stack"))[1]) < 32_000


def test_loggers_that_leave_or_call_back_do_no_harm(check):
    check("loggers")


def test_threads_give_the_bits_of_a_run_alone(check):
    check("threads")


@pytest.fixture(scope="module")
def german(tmp_path_factory):
    """The folder of a locale with a decimal comma, which is made here: few machines have one."""
    folder = tmp_path_factory.mktemp("locale")
    command = ["localedef", "-i", "de_DE", "-f", "UTF-8", folder / "de_DE.UTF-8"]
    if shutil.which("localedef") is None or subprocess.run(command, capture_output=True).returncode != 0:
        pytest.skip("localedef cannot make the locale de_DE.UTF-8")
    return folder


def test_a_decimal_comma_of_the_host_changes_no_number(check, german):
    """Tables are read again under the locale."""
    check("locale", LOCPATH=str(german), LC_ALL="de_DE.UTF-8")
