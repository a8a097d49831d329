"""The WebAssembly component in the FMUs of FMI 3.0 against the native library, in the host wasmtime.

A plain build holds no component: run ./build.sh run all.
"""

import re
import xml.etree.ElementTree as ET
import zipfile

import build_fmu
import pytest
from component_host import CALLBACKS, Handle, Host, Refused, Run, component_of
from driver3 import models
from exported_fmus import HELIX, Design, designs
from fmi3_scenes import GENERAL, wave
from webassembly.core import callers, filler
from webassembly.encoding import signed, unsigned

import dualcam
from dualcam.errors import ExportError
from dualcam.export import export_fmu
from dualcam.export.component_files import with_files
from dualcam.model_description import read_model_description

FORWARD, INVERSE = (model.fmu for model in models.values())
LARGEST = 419_000  # bytes: two interfaces with the names of 150 functions
BOUNCING = {"inertia.shaft": 0.01, "stop.restitution": 0.4}
DAMPED = {"inertia.shaft": 0.002, "shaft.damping": 0.02}
NAMES = ("theta", "omega", "z", "v", "alpha", "gamma", "cam1.reaction", "torque_load", "energy.residual")


@pytest.fixture(scope="module", params=[FORWARD, INVERSE], ids=lambda fmu: fmu.stem)
def fmu(request):
    return request.param


@pytest.fixture(scope="module")
def content():
    return component_of(FORWARD)


@pytest.fixture(scope="module")
def description():
    return read_model_description(FORWARD)


@pytest.fixture
def one(content, description) -> Handle:
    """An instance of the forward FMU in initialization mode."""
    handle = Host(content).instantiate(description.guid)
    handle.enter_initialization_mode(None, 0.0, None)
    return handle


def references(description) -> dict[str, int]:
    return {v.name: v.value_reference for v in description.variables}


# ---- what the draft demands ----


def test_the_manifest_is_valid_under_both_names(fmu):
    """The draft names the file manifest.xml, FMI 3.0 names it fmi-ls-manifest.xml."""
    etree = pytest.importorskip("lxml.etree")
    component_of(fmu)
    schema = etree.XMLSchema(
        file=str(build_fmu.fmi_headers().parent / "schema/fmi3/fmi3LayeredStandardManifest.xsd")
    )
    with zipfile.ZipFile(fmu) as archive:
        for name in ("manifest.xml", "fmi-ls-manifest.xml"):
            text = archive.read(f"extra/org.modelica.fmi-ls-wasm/{name}")
            schema.assertValid(etree.fromstring(text))
            words = {key.rpartition("}")[2]: value for key, value in ET.fromstring(text).attrib.items()}
            assert words["fmi-ls-name"] == "org.modelica.fmi-ls-wasm"
            assert words["fmi-ls-description"] == "FMI Layered Standard for WebAssembly"
            assert re.fullmatch(r"\d+\.\d+\.\d+", words["fmi-ls-version"])


def test_the_host_provides_types_and_callbacks_alone(fmu):
    """No function of an operating system: any host of the draft can load the component."""
    host = Host(component_of(fmu))
    kind = host.component.type
    assert set(kind.imports(host.engine)) == {"fmi:fmi3/types@3.0.0", CALLBACKS}
    interfaces = ("common", "co-simulation", "model-exchange")
    assert set(kind.exports(host.engine)) == {f"fmi:fmi3/{name}@3.0.0" for name in interfaces}


def fmi_functions() -> set[str]:
    """The functions of FMI 3.0 by the standard's header, spelt as in the draft: fmi3DoStep is do-step."""
    text = (build_fmu.fmi_headers() / "fmi3FunctionTypes.h").read_text()
    names = [n.replace("FMU", "Fmu").replace("UInt", "Uint") for n in re.findall(r"\bfmi3(\w+)TYPE\b", text)]
    return {
        re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "-", n.replace("FMU", "Fmu").replace("UInt", "Uint")).lower()
        for n in names
    }


# By the draft a state is always serialised, and the host drops a handle.
LEFT_OUT = {
    "free-instance",
    "free-fmu-state",
    "serialized-fmu-state-size",
    "serialize-fmu-state",
    "deserialize-fmu-state",
}
SCHEDULED = {"instantiate-scheduled-execution", "activate-model-partition"}
CO_SIMULATION = {"instantiate-co-simulation", "do-step"}
MODEL_EXCHANGE = {
    *("instantiate-model-exchange", "enter-continuous-time-mode", "set-time", "set-continuous-states"),
    *("get-continuous-state-derivatives", "get-event-indicators", "get-continuous-states"),
    *(
        "get-nominals-of-continuous-states",
        "get-number-of-event-indicators",
        "get-number-of-continuous-states",
    ),
    "completed-integrator-step",
}


@pytest.mark.parametrize(
    ("interface", "without", "besides"),
    [("co-simulation", MODEL_EXCHANGE, {"set-input-derivatives"}), ("model-exchange", CO_SIMULATION, set())],
)
def test_each_function_of_fmi_is_there(content, interface, without, besides):
    host = Host(content)
    instance = host.component.type.exports(host.engine)[f"fmi:fmi3/{interface}@3.0.0"]
    exported = instance.ty.exports(host.engine)
    functions = {name.partition(".")[2] for name in exported if name.startswith("[")}
    callbacks = {name for name in fmi_functions() if name.endswith(("-callback", "-update"))}
    expected = fmi_functions() - callbacks - LEFT_OUT - SCHEDULED - without - {"get-version"}
    assert functions == expected | besides


def test_size(fmu):
    assert len(component_of(fmu)) <= LARGEST


def test_version(content):
    assert Host(content).call("common", "get-version") == "3.0"


# ---- the same numbers ----


def compare(component: Run, native: dualcam.Fmu, names) -> None:
    mine = [component.get(name) for name in names]
    assert mine == [native.get(name) for name in names]


def load_and_release(t: float) -> float:
    """Torque, N.m, under which a damped mechanism loads, releases in two parts, and meets the stop."""
    return 5.0 if t < 0.1 else 3.5 if t < 0.2 else 0.0


@pytest.mark.parametrize(
    ("parameters", "torque", "passed"),
    [
        (DAMPED, load_and_release, {1, 2, 3, 4}),
        (BOUNCING, wave, {2, 3}),
        (GENERAL, wave, {1, 2, 3}),
        (HELIX, wave, {2, 3}),
    ],
    ids=["damped", "bouncing", "ellipse", "own"],
)
def test_forward_run(content, description, parameters, torque, passed):
    """Stick, slip in both directions and the lower stop: state, forces, mode and number of events."""
    modes = set()
    with dualcam.Fmu(FORWARD) as native:
        native.start(parameters)
        run = Run(content, description, parameters)
        for k in range(300):
            for either in (native, run):
                either.set("tau", torque(k * 1e-3))
                either.step(1e-3)
            modes.add(run.get("mode"))
            compare(run, native, (*NAMES, "mode", "events"))
    assert passed <= modes


def test_inverse_run():
    with dualcam.Fmu(INVERSE) as native:
        native.start()
        run = Run(component_of(INVERSE), native.description)
        for k in range(100):
            for name, value in (
                ("theta", 0.01 * k),
                ("omega", 10.0),
                ("alpha", 2.0 - 0.1 * k),
                ("F_ext", 0.2 * k),
            ):
                native.set(name, value)
                run.set(name, value)
            native.step(1e-3)
            run.step(1e-3)
            compare(run, native, ("tau", "z", "v", "mode"))


def test_early_return_at_a_mode_change(content, description):
    """The step ends at the event; the host handles the event and goes on."""
    handle = Host(content).instantiate(description.guid, event_mode=True, early_return=True)
    handle.enter_initialization_mode(None, 0.0, None)
    tau = references(description)["tau"]
    handle.set_float64([tau], [5.0])
    handle.exit_initialization_mode()
    handle.update_discrete_states()
    handle.enter_step_mode()
    ends = []
    for _ in range(8):
        end = handle.do_step(ends[-1] if ends else 0.0, 0.5, True)
        ends.append(getattr(end, "last-successful-time"))
        if getattr(end, "early-return"):
            assert getattr(end, "event-handling-needed")
            handle.enter_event_mode()
            assert not getattr(handle.update_discrete_states(), "new-discrete-states-needed")
            handle.enter_step_mode()
    assert 0 < ends[0] < 0.5 and ends == sorted(ends)


def test_model_exchange(content, description):
    host, vr = Host(content), references(description)
    handle = host.instantiate(description.guid, "model-exchange")
    handle.set_float64([vr["tau"]], [3.0])
    handle.enter_initialization_mode(1e-6, 0.0, 1.0)
    handle.exit_initialization_mode()
    handle.update_discrete_states()
    handle.enter_continuous_time_mode()
    handle.set_continuous_states([0.5, 2.0])
    handle.enter_event_mode()
    handle.update_discrete_states()
    handle.enter_continuous_time_mode()
    with dualcam.ContinuousFmu(FORWARD) as native:
        native.start({"tau": 3.0})
        native.set_states_and_mode([0.5, 2.0])
        rates, indicators = native.derivatives(), native.event_indicators()
    assert handle.get_continuous_states() == [0.5, 2.0]
    assert handle.get_continuous_state_derivatives() == rates
    assert handle.get_event_indicators() == indicators
    assert handle.get_number_of_continuous_states() == len(rates)
    assert handle.get_number_of_event_indicators() == len(indicators)
    assert len(handle.get_nominals_of_continuous_states()) == len(rates)
    handle.set_time(0.01)
    end = handle.completed_integrator_step(True)
    assert not getattr(end, "enter-event-mode") and not getattr(end, "terminate-simulation")
    handle.terminate()


def test_derivatives_and_dependencies(content, description):
    """d(alpha)/d(tau) is 1/inertia at z' of the start, forwards and transposed; the kinds of dependency."""
    run, vr = Run(content, description, {"tau": 5.0}), references(description)
    run.step(0.01)
    alpha, tau = [vr["alpha"]], [vr["tau"]]
    (slope,) = run.handle.get_directional_derivative(alpha, tau, [1.0])
    assert slope > 0
    assert run.handle.get_adjoint_derivative(alpha, tau, [1.0]) == [slope]
    assert run.handle.get_output_derivatives([(vr["theta"], 1), (vr["theta"], 2)]) == pytest.approx(
        run.reals(["omega", "alpha"])
    )
    rows = run.handle.get_variable_dependencies(vr["z"])
    assert len(rows) == run.handle.get_number_of_variable_dependencies(vr["z"])
    found = {getattr(row, "independent-value-reference"): row.kind for row in rows}
    assert found[vr["theta"]] == "dependent"


def test_every_type_can_be_set_and_got(one, description):
    vr = references(description)
    one.set_float64([vr["spring.preload"], vr["spring.stiffness"]], [60.0, 4e4])
    assert one.get_float64([vr["spring.stiffness"], vr["spring.preload"]]) == [4e4, 60.0]
    one.set_int32([vr["contacts"]], [1])
    assert one.get_int32([vr["contacts"]]) == [1]
    one.set_boolean([vr["ledger"]], [False])
    assert one.get_boolean([vr["ledger"]]) == [False]
    one.set_string([vr["cam1.table"]], ["Nut ü.csv"])
    assert one.get_string([vr["cam1.table"], vr["cam2.table"]]) == ["Nut ü.csv", ""]
    assert one.get_int8([]) == one.get_clock([]) == one.get_interval_decimal([]) == []


# ---- states, life and memory ----


def test_a_restored_state_repeats_bit_for_bit_in_another_instance(content, description):
    first, second = (Run(content, description, {"tau": 5.0}) for _ in range(2))
    first.step(0.01)
    state = first.handle.get_fmu_state()
    second.handle.set_fmu_state(state)
    second.time = first.time
    for run in (first, second):
        run.step(0.02)
    assert first.reals(NAMES) == second.reals(NAMES)
    with pytest.raises(Refused, match="fmi3DeserializeFMUState"):
        second.handle.set_fmu_state(state[:-1])
    assert first.reals(NAMES) == second.reals(NAMES)


def test_many_instances_calls_and_refusals_keep_no_memory(content, description):
    """200 instances in half a megabyte besides code, data and stack."""
    host, vr = Host(content, memory=3 << 19), references(description)
    everything = [v.value_reference for v in description.variables if v.kind == "real"]
    for _ in range(200):
        handle = host.instantiate(description.guid)
        handle.set_string([vr["cam1.table"]], ["x" * 100])
        handle.get_float64(everything)
        handle.reset()
        handle.set_fmu_state(handle.get_fmu_state())
        with pytest.raises(Refused):
            handle.get_float64([9999])
        handle.drop()
        with pytest.raises(Refused):
            host.instantiate("another token")
    host.log.clear()


def test_instances_are_independent(content, description):
    host, vr = Host(content), references(description)
    first, second = (host.instantiate(description.guid) for _ in range(2))
    first.set_float64([vr["spring.preload"]], [77.0])
    assert second.get_float64([vr["spring.preload"]]) == [50.0]
    first.drop()
    assert second.get_float64([vr["spring.preload"]]) == [50.0]


# ---- refusals ----


def test_a_refusal_gives_the_message_of_the_fmu(one, description):
    vr = references(description)["cam1.friction"]
    with pytest.raises(Refused, match=r"'error'.*'one', 'error', 'logStatusError'.*cam1.friction"):
        one.set_float64([vr], [-1.0])
    assert one.get_float64([vr]) == [0.14]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda one: one.get_int32([1]), "fmi3GetInt32"),
        (lambda one: one.set_float64([1, 2], [0.0]), "nValues = 1"),
        (lambda one: one.set_input_derivatives([(0, 1)], [1.0]), "set-input-derivatives"),
        (lambda one: one.get_clock([0]), "fmi3GetClock"),
        (lambda one: one.set_binary([0], [b"x"]), "fmi3SetBinary"),
        (lambda one: one.do_step(0.0, 0.1, True), "fmi3DoStep"),
        (lambda one: one.enter_configuration_mode(), "fmi3EnterConfigurationMode"),
        (lambda one: one.get_directional_derivative([0], [1], []), "nSeed"),
    ],
)
def test_calls_that_are_refused(one, call, message):
    with pytest.raises(Refused, match=message):
        call(one)
    one.exit_initialization_mode()  # the instance goes on


def test_intermediate_variables_are_refused(content, description):
    with pytest.raises(Refused, match="required-intermediate-variables: allowed is the empty list"):
        Host(content).instantiate(description.guid, required=[0])


# ---- exported FMUs ----


def test_an_exported_fmu_starts_from_the_design_in_webassembly_too(tmp_path, content):
    """GUID and start values in the component are those of the description, without an edit by the host."""
    target = export_fmu(Design(HELIX), tmp_path / "Own.fmu", fmi=3)
    description = read_model_description(target)
    run = Run(component_of(target), description)
    for variable in description.variables:
        if variable.start is not None and variable.causality == "parameter":
            assert run.get(variable.name) == variable.start, variable.name
    with dualcam.Fmu(target) as native:
        native.start()
        for either in (native, run):
            either.set("tau", 5.0)
            either.step(0.05)
        compare(run, native, NAMES)


@pytest.fixture(scope="module")
def with_tables(tmp_path_factory):
    """The FMU of a design with two groove tables, and its component."""
    folder = tmp_path_factory.mktemp("tables")
    target = export_fmu(Design(designs(folder)["table"]), folder / "Tables.fmu", fmi=3)
    return target, component_of(target)


def test_a_component_holds_the_tables_of_its_design(with_tables):
    """The host shows no file, and the numbers are those of the native library with the FMU's resources."""
    target, content = with_tables
    modes = set()
    with dualcam.Fmu(target) as native:
        native.start()
        run = Run(content, native.description)
        for k in range(300):
            for either in (native, run):
                either.set("tau", wave(k * 1e-3))
                either.step(1e-3)
            modes.add(run.get("mode"))
            compare(run, native, (*NAMES, "mode", "events"))
    assert {2, 3} <= modes


def test_tables_are_read_again_by_each_instance_and_reset(with_tables):
    target, content = with_tables
    description = read_model_description(target)
    host, vr = Host(content), references(description)
    results = set()
    for _ in range(20):
        handle = host.instantiate(description.guid)
        for _ in range(2):
            handle.enter_initialization_mode(None, 0.0, None)
            handle.exit_initialization_mode()
            handle.set_float64([vr["tau"]], [5.0])
            handle.do_step(0.0, 0.05, True)
            results.add(tuple(handle.get_float64([vr["theta"], vr["omega"]])))
            handle.reset()
        handle.drop()
    assert len(results) == 1


def test_a_table_that_the_component_does_not_hold_is_refused(content, description, with_tables):
    """In the project's own component there is no table at all."""
    for binary, token in (
        (content, description.guid),
        (with_tables[1], read_model_description(with_tables[0]).guid),
    ):
        run = Host(binary).instantiate(token)
        vr = references(description)
        run.set_int32([vr["cam1.profile"]], [3])
        run.set_string([vr["cam1.table"]], ["other.csv"])
        run.enter_initialization_mode(None, 0.0, None)
        with pytest.raises(Refused, match=r'cam1.table = "other.csv": this file cannot be opened') as refused:
            run.exit_initialization_mode()
        assert "absolute" not in str(refused.value)  # a component has no other files


@pytest.mark.parametrize("size", [0, 1, 65536, 300_000])
def test_a_component_with_files_of_any_size_is_valid(content, description, size):
    files = {"cam1.csv": b"1" * size, "cam2.csv": b"2" * 100}
    changed = with_files(content, files)
    assert changed.count(files["cam1.csv"]) and changed.count(files["cam2.csv"]) == 1
    Host(changed).instantiate(description.guid).drop()
    assert with_files(content, {}) == content


@pytest.mark.parametrize(
    ("files", "message"),
    [
        (dict.fromkeys("abcde", b""), "5 tables for one component: allowed are up to 4"),
        ({"a" * 32: b""}, "has a name of 32 bytes: allowed are up to 31"),
    ],
)
def test_files_that_a_component_cannot_hold(content, files, message):
    with pytest.raises(ExportError, match=message):
        with_files(content, files)


def test_a_component_of_another_project_is_refused(content):
    with pytest.raises(ExportError, match="0 places for tables, allowed is one"):
        with_files(content.replace(b"dualcam table files", b"another table files"), {"a": b""})


# ---- the encoder ----


@pytest.mark.parametrize(
    ("number", "plain", "with_sign"),
    [
        (0, "00", "00"),
        (63, "3f", "3f"),
        (64, "40", "c000"),
        (127, "7f", "ff00"),
        (624485, "e58e26", "e58e26"),
    ],
)
def test_numbers(number, plain, with_sign):
    """624485 is the example of the DWARF standard."""
    assert (unsigned(number).hex(), signed(number).hex()) == (plain, with_sign)


def test_negative_numbers():
    assert [signed(n).hex() for n in (-1, -64, -65, -123456)] == ["7f", "40", "bf7f", "c0bb78"]


def test_small_modules_are_valid():
    import wasmtime
    from webassembly.core import Late

    functions = [Late("one", ("i32", "f64")), Late("two", ())]
    engine = wasmtime.Engine()
    exports = {e.name for e in wasmtime.Module(engine, callers(functions)).exports}
    imports = {i.name for i in wasmtime.Module(engine, filler(functions, "begin")).imports}
    assert (exports, imports) == ({"one", "two", "table"}, {"one", "two", "begin", "table"})
