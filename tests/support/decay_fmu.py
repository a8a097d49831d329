"""An FMU that is not the cam's: tests/native/other_fmu.c."""

import zipfile
from pathlib import Path

import build_fmu
from driver import ROOT

DECAY = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="decay" guid="decay">
  <CoSimulation modelIdentifier="decay" canHandleVariableCommunicationStepSize="false"/>
  <TypeDefinitions>
    <SimpleType name="Law">
      <Enumeration><Item name="exponential" value="1"/><Item name="linear" value="2"/></Enumeration>
    </SimpleType>
  </TypeDefinitions>
  <ModelVariables>
    <ScalarVariable name="x" valueReference="0" causality="output" variability="continuous" initial="exact">
      <Real start="1"/>
    </ScalarVariable>
    <ScalarVariable name="rate" valueReference="1" causality="parameter" variability="fixed">
      <Real start="1" max="5"/>
    </ScalarVariable>
    <ScalarVariable name="law" valueReference="0" causality="parameter" variability="fixed">
      <Enumeration declaredType="Law" start="1" min="1" max="2"/>
    </ScalarVariable>
    <ScalarVariable name="resets" valueReference="1" causality="local" variability="discrete">
      <Integer/>
    </ScalarVariable>
    <ScalarVariable name="frozen" valueReference="0" causality="parameter" variability="fixed">
      <Boolean start="false"/>
    </ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="1"/></Outputs></ModelStructure>
</fmiModelDescription>
"""


def make_decay_fmu(folder: Path) -> Path:
    """The FMU, in a place whose name has all that names can have."""
    library, path = folder / "decay.so", folder / "an other [FMU] ünd #1 %20" / "décay.fmu"
    path.parent.mkdir()
    flags = ["-O2", "-fPIC", "-shared", '-DMODEL_GUID="decay"', "-DVALUE_COUNT=2", *build_fmu.TARGET]
    build_fmu.compile_c(build_fmu.ZIG, flags, [ROOT / "tests/native/other_fmu.c"], library)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", DECAY)
        archive.write(library, "binaries/linux64/decay.so")
    return path
