"""dualcam.Fmu with an FMU of FMI 3.0 that is no cam: types that the cam does not have, arrays, an FMU that
ends the simulation. The FMU is tests/native/other_fmu3.c."""

import zipfile

import build_fmu
import pytest
from driver import ROOT

from dualcam import ContinuousFmu, Fmu
from dualcam.errors import FmuError
from dualcam.fmi.binary import library_suffix, platform_tuple

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="other" instantiationToken="{token}">
  <CoSimulation modelIdentifier="other" canHandleVariableCommunicationStepSize="true"/>
  <TypeDefinitions>
    <EnumerationType name="Law"><Item name="one" value="1"/></EnumerationType>
  </TypeDefinitions>
  <ModelVariables>
    <Float64 name="x" valueReference="0" causality="output"/>
    <Float32 name="single" valueReference="1" causality="input" start="1.5"/>
    <Int8 name="small" valueReference="2" causality="input" start="-3"/>
    <UInt64 name="large" valueReference="3" causality="input" start="7"/>
    <Enumeration name="choice" valueReference="4" causality="input" declaredType="Law" start="1"/>
    <Boolean name="flag" valueReference="5" causality="input" start="false">
      <Alias name="also flag"/>
    </Boolean>
    <String name="text" valueReference="6" causality="input"><Start value="start"/></String>
    <Float64 name="vector" valueReference="7" causality="input" start="1 2"><Dimension start="2"/></Float64>
    <Binary name="bytes" valueReference="8" causality="input"><Start value="00"/></Binary>
  </ModelVariables>
  <ModelStructure><Output valueReference="0"/></ModelStructure>
</fmiModelDescription>
"""
STARTS = {"single": 1.5, "small": -3, "large": 7, "choice": 1, "flag": False, "text": "start"}
OTHERS = {"single": 0.25, "small": 127, "large": 2**64 - 1, "choice": -5, "flag": True, "text": "ünd #1 %20"}


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    path = tmp_path_factory.mktemp("other3") / f"other{library_suffix()}"
    flags = ["-O2", "-fPIC", "-shared", *build_fmu.TARGET]
    build_fmu.compile_c(build_fmu.ZIG, flags, [ROOT / "tests/native/other_fmu3.c"], path)
    return path


@pytest.fixture
def path(library, tmp_path):
    return made(library, tmp_path / "other FMU.fmu", "other")


def made(library, path, token):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", DESCRIPTION.format(token=token))
        archive.write(library, f"binaries/{platform_tuple()}/{library.name}")
    return path


def test_each_type(path):
    with Fmu(path) as fmu:
        fmu.start()
        assert {name: fmu.get(name) for name in STARTS} == STARTS
        assert [type(fmu.get(name)) for name in STARTS] == [float, int, int, int, bool, str]
        fmu.start(OTHERS)
        assert {name: fmu.get(name) for name in OTHERS} == OTHERS
        assert fmu.get("also flag") is True
        fmu.start()
        assert {name: fmu.get(name) for name in STARTS} == STARTS


@pytest.mark.parametrize(
    ("name", "value", "mention"),
    [
        ("small", 128, "small = 128: allowed are whole numbers of the type Int8"),
        ("large", -1, "large = -1: allowed are whole numbers of the type UInt64"),
        ("small", 0.5, "allowed are whole numbers"),
        ("text", 1.0, "allowed is text"),
        ("vector", 1.0, "vector is an array"),
        ("bytes", 1, "bytes is of the type Binary"),
    ],
)
def test_values_that_a_type_does_not_have(path, name, value, mention):
    with Fmu(path) as fmu, pytest.raises(FmuError, match=mention):
        fmu.start({name: value})


def test_groups_hold_doubles(path):
    with Fmu(path) as fmu:
        fmu.start(time=0.25)
        assert fmu.reals("x").read() == [0.25]
        for name, what in (("single", "Float32"), ("vector", "an array"), ("small", "Int8")):
            with pytest.raises(FmuError, match=f"{name} is {what}"):
                fmu.reals(name)


def test_an_fmu_that_ends_the_simulation(path):
    with Fmu(path) as fmu:
        fmu.start()
        fmu.step(0.75)
        assert (fmu.time, fmu.get("x")) == (0.75, 0.75)
        with pytest.raises(FmuError, match="ends the simulation"):
            fmu.step(0.5)


def test_what_the_fmu_cannot_do(path, library, tmp_path):
    with Fmu(path) as fmu:
        fmu.start()
        with pytest.raises(FmuError, match="cannot save its state"):
            fmu.save_state()
        with pytest.raises(FmuError, match="no directional derivatives"):
            fmu.jacobian(["x"], ["x"])
    with pytest.raises(FmuError, match="has no model exchange"):
        ContinuousFmu(path)
    with pytest.raises(FmuError, match=r"made no instance: what was given is not 100 % as FMI 3\.0 says"):
        Fmu(made(library, tmp_path / "strange.fmu", "unknown"))
