"""dualcam's reader of modelDescription.xml against FMPy's, for every FMU of this repository and for foreign
ones; and what it refuses."""

import zipfile

import fmpy
import pytest
from driver import ROOT
from fmpy.model_description import read_model_description as read_by_fmpy

from dualcam.errors import FmuError
from dualcam.fmi import read_model_description
from dualcam.fmi.binary import binary_folders, library_suffix, platform_tuple
from dualcam.fmi.model_description import parse_model_description

FMUS = [*sorted((ROOT / "build").glob("*.fmu")), *sorted((ROOT / "build/fmi3").glob("*.fmu"))]
XML = sorted((ROOT / "modelDescription").rglob("*.xml"))

EVERYTHING_2 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="all" guid="{1}" numberOfEventIndicators="3">
  <ModelExchange modelIdentifier="all_me" needsExecutionTool="true"/>
  <CoSimulation modelIdentifier="all_cs" canInterpolateInputs="1" maxOutputDerivativeOrder="2"
    canGetAndSetFMUstate="true" canSerializeFMUstate="false" providesDirectionalDerivative="true"/>
  <UnitDefinitions><Unit name="m"/><Unit name="mm"/></UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Length"><Real unit="m" min="0" max="1e3"/></SimpleType>
    <SimpleType name="Law"><Enumeration><Item name="one" value="1"/></Enumeration></SimpleType>
  </TypeDefinitions>
  <DefaultExperiment startTime="1" stopTime="2.5" stepSize="1e-3" tolerance="1e-6"/>
  <ModelVariables>
    <ScalarVariable name="a" valueReference="7" causality="parameter" variability="fixed"
      description="&lt;one&gt;">
      <Annotations/><Real declaredType="Length" start="0.5"/>
    </ScalarVariable>
    <ScalarVariable name="b" valueReference="8" causality="input">
      <Real declaredType="Length" unit="mm" min="-1" start="1"/>
    </ScalarVariable>
    <ScalarVariable name="c" valueReference="1" causality="parameter" variability="tunable">
      <Enumeration declaredType="Law" start="1"/>
    </ScalarVariable>
    <ScalarVariable name="d" valueReference="2" variability="discrete"><Boolean/></ScalarVariable>
    <ScalarVariable name="e" valueReference="3" causality="parameter" variability="fixed">
      <String start=" text "/>
    </ScalarVariable>
    <ScalarVariable name="t" valueReference="4" causality="independent"><Real/></ScalarVariable>
    <ScalarVariable name="x" valueReference="5" causality="output"><Real/></ScalarVariable>
    <ScalarVariable name="der(x)" valueReference="6"><Real derivative="7"/></ScalarVariable>
    <ScalarVariable name="k" valueReference="9" variability="constant"><Integer start="-4"/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="7"/></Outputs><Derivatives><Unknown index="8"/></Derivatives>
  </ModelStructure>
</fmiModelDescription>
"""
EVERYTHING_3 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="all" instantiationToken="{1}">
  <ModelExchange modelIdentifier="all" canGetAndSetFMUState="true"/>
  <CoSimulation modelIdentifier="all" canSerializeFMUState="1" providesDirectionalDerivatives="true"/>
  <TypeDefinitions>
    <Float64Type name="Length" unit="m" min="0"/>
    <EnumerationType name="Law"><Item name="one" value="1"/></EnumerationType>
  </TypeDefinitions>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent"/>
    <Float64 name="a" valueReference="1" causality="parameter" declaredType="Length" start="0.5" max="2">
      <Alias name="also a" description="another name"/>
    </Float64>
    <Float32 name="b" valueReference="2" causality="input" start="1.5"/>
    <UInt8 name="c" valueReference="3" causality="parameter" start="255"/>
    <Int64 name="d" valueReference="4" causality="output"/>
    <Enumeration name="law" valueReference="5" causality="parameter" declaredType="Law" start="1"/>
    <Boolean name="f" valueReference="6" causality="input" start="true"/>
    <String name="g" valueReference="7" causality="parameter"><Start value="some text"/></String>
    <Binary name="h" valueReference="8" causality="input"><Start value="00ff"/></Binary>
    <Float64 name="m" valueReference="9" causality="input" start="1 2"><Dimension start="2"/></Float64>
    <Float64 name="x" valueReference="10" causality="output"/>
    <Float64 name="der(x)" valueReference="11" derivative="10"/>
    <Float64 name="root" valueReference="12"/>
  </ModelVariables>
  <ModelStructure>
    <Output valueReference="10"/><ContinuousStateDerivative valueReference="11"/>
    <EventIndicator valueReference="12"/>
  </ModelStructure>
</fmiModelDescription>
"""
READ = {"real": float, "integer": int, "boolean": lambda text: text in ("true", "1"), "string": str}


def typed(variable, text):
    """An attribute of FMPy, which is text."""
    kept = text is not None and variable.kind in READ and not variable.is_array
    return READ[variable.kind](text) if kept else None


def agree(own, other):
    """All of `own` is that of FMPy's description."""
    assert (own.fmi_version, own.model_name, own.guid) == (other.fmiVersion, other.modelName, other.guid)
    assert own.description == (other.description or "")
    states, indicators = other.numberOfContinuousStates, other.numberOfEventIndicators
    assert (own.state_count, own.event_indicator_count) == (states, indicators)
    for use, theirs in (
        (own.co_simulation, other.coSimulation),
        (own.model_exchange, other.modelExchange),
    ):
        assert (use is None) == (theirs is None)
        if use is not None:
            agree_on_use(use, theirs)
    experiment, theirs = own.default_experiment, other.defaultExperiment
    for name, text in (
        ("start_time", "startTime"),
        ("stop_time", "stopTime"),
        ("step_size", "stepSize"),
        ("tolerance", "tolerance"),
    ):
        text = getattr(theirs, text, None)
        assert getattr(experiment, name) == (None if text is None else float(text))
    listed = [(variable.name, variable) for variable in other.modelVariables]
    aliases = {alias.name: variable for variable in other.modelVariables for alias in variable.aliases}
    order = [variable.name for variable in own.variables if variable.name not in aliases]
    assert order == [name for name, _ in listed if name not in aliases]
    by_name = dict(listed) | aliases
    assert len(own.variables) == len(by_name)
    for variable in own.variables:
        agree_on_variable(variable, by_name[variable.name])


def agree_on_use(own, other):
    assert own.model_identifier == other.modelIdentifier
    assert own.needs_execution_tool == other.needsExecutionTool
    assert own.can_save_state == other.canGetAndSetFMUstate
    assert own.can_serialize_state == other.canSerializeFMUstate
    if hasattr(other, "canInterpolateInputs"):
        assert own.can_interpolate_inputs == other.canInterpolateInputs
        assert own.can_handle_variable_steps == other.canHandleVariableCommunicationStepSize
        assert own.max_output_derivative_order == other.maxOutputDerivativeOrder


def agree_on_variable(own, other):
    declared = other.declaredType
    assert (own.value_reference, own.type) == (other.valueReference, other.type), own.name
    assert (own.causality, own.variability) == (other.causality, other.variability), own.name
    assert own.initial == other.initial, own.name
    assert own.start == typed(own, other.start), own.name
    assert own.is_array == bool(other.dimensions)
    assert own.declared_type == (declared and declared.name)
    assert own.unit == (other.unit or (declared and declared.unit))
    for name in ("min", "max"):
        text = getattr(other, name)
        expected = text if text is not None else getattr(declared, name, None)
        assert getattr(own, name) == typed(own, expected), own.name


@pytest.mark.parametrize("path", FMUS, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_fmus_of_this_repository(path):
    own = read_model_description(path)
    agree(own, read_by_fmpy(path))
    assert {v.description for v in own.variables} == {
        v.description or "" for v in read_by_fmpy(path).modelVariables
    }


@pytest.mark.parametrize("path", XML, ids=lambda path: f"{path.parent.name}-{path.stem}")
def test_committed_descriptions(path):
    agree(parse_model_description(path.read_bytes()), read_by_fmpy(str(path)))


@pytest.mark.parametrize("text", [EVERYTHING_2, EVERYTHING_3], ids=["2", "3"])
def test_foreign_descriptions(tmp_path, text):
    path = tmp_path / "modelDescription.xml"
    path.write_text(text)
    agree(parse_model_description(text.encode()), read_by_fmpy(str(path), validate=False))


def test_what_the_declared_type_gives():
    variables = {v.name: v for v in parse_model_description(EVERYTHING_2).variables}
    assert (variables["a"].unit, variables["a"].min, variables["a"].max) == ("m", 0.0, 1e3)
    assert (variables["b"].unit, variables["b"].min, variables["b"].max) == ("mm", -1.0, 1e3)
    assert variables["a"].description == "<one>"
    assert variables["e"].start == " text "


def test_aliases_are_variables():
    variables = {v.name: v for v in parse_model_description(EVERYTHING_3).variables}
    assert variables["also a"].value_reference == variables["a"].value_reference
    assert (variables["also a"].description, variables["also a"].start) == ("another name", 0.5)


def replaced(old, new, text=EVERYTHING_2):
    assert old in text
    return text.replace(old, new, 1)


@pytest.mark.parametrize(
    ("text", "mention"),
    [
        ("", "no valid modelDescription.xml"),
        ("<fmiModelDescription", "no valid modelDescription.xml"),
        ("<other/>", "<other>"),
        ("<fmiModelDescription/>", "'fmiVersion' is missing"),
        (replaced('fmiVersion="2.0"', 'fmiVersion="1.0"'), "FMI 1.0: allowed are 2.0 and 3.0"),
        (replaced(' guid="{1}"', ""), "'guid' is missing"),
        (replaced('start="0.5"', 'start="half"'), "variable a: start = 'half' is no real number"),
        (replaced('<Integer start="-4"/>', '<Integer start="1.5"/>'), "variable k: start = '1.5'"),
        (replaced('name="b"', 'name="a"'), "variable a is there twice"),
        (replaced('valueReference="8"', 'valueReference="eight"'), "eight"),
        (replaced("<Boolean/>", ""), "variable d has no type"),
        (replaced('declaredType="Law"', 'declaredType="Rule"'), "Rule, which is not defined"),
        (replaced('maxOutputDerivativeOrder="2"', 'maxOutputDerivativeOrder="two"'), "two"),
        (replaced("<Float64 name=", "<Float16 name=", EVERYTHING_3), "Float16"),
    ],
)
def test_what_is_not_valid(text, mention):
    with pytest.raises(FmuError) as caught:
        parse_model_description(text)
    assert mention in str(caught.value)


def test_the_message_names_the_file(tmp_path):
    path = tmp_path / "bad.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", "<other/>")
    with pytest.raises(FmuError, match=r"bad\.fmu.*<other>"):
        read_model_description(path)


# ---- platforms ----


def test_platform_of_this_machine():
    assert binary_folders(2)[0] == fmpy.platform
    assert platform_tuple() == fmpy.platform_tuple
    assert library_suffix() == fmpy.sharedLibraryExtension


@pytest.mark.parametrize(
    ("system", "machine", "pointer", "second", "third", "suffix"),
    [
        ("linux", "x86_64", 8, ("linux64", "x86_64-linux"), "x86_64-linux", ".so"),
        ("linux", "x86_64", 4, ("linux32", "x86-linux"), "x86-linux", ".so"),
        ("linux", "i686", 4, ("linux32", "x86-linux"), "x86-linux", ".so"),
        ("linux", "aarch64", 8, ("aarch64-linux",), "aarch64-linux", ".so"),
        ("win32", "AMD64", 8, ("win64", "x86_64-windows"), "x86_64-windows", ".dll"),
        ("win32", "AMD64", 4, ("win32", "x86-windows"), "x86-windows", ".dll"),
        ("win32", "ARM64", 8, ("aarch64-windows",), "aarch64-windows", ".dll"),
        ("darwin", "x86_64", 8, ("darwin64", "x86_64-darwin"), "x86_64-darwin", ".dylib"),
        ("darwin", "arm64", 8, ("darwin64", "aarch64-darwin"), "aarch64-darwin", ".dylib"),
    ],
)
def test_folders_of_other_platforms(monkeypatch, system, machine, pointer, second, third, suffix):
    """The names are those of FMI 2.0, section 2.3, and FMI 3.0, section 2.5.1.4.1."""
    monkeypatch.setattr("dualcam.fmi.binary.sys.platform", system)
    monkeypatch.setattr("dualcam.fmi.binary.platform.machine", lambda: machine)
    monkeypatch.setattr("dualcam.fmi.binary.struct.calcsize", lambda kind: pointer)
    assert binary_folders(2) == second
    assert binary_folders(3) == (third,)
    assert library_suffix() == suffix
