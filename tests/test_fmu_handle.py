"""dualcam.Fmu and dualcam.ContinuousFmu: names, values, runs, errors. What they must agree with is the FMU
called directly (tests/support/driver.py)."""

import ast
import gc
import importlib
import inspect
import math
import pkgutil
import re
import subprocess
import sys
import tomllib
import zipfile
from ctypes import c_char_p
from functools import partial
from importlib import metadata, util
from operator import attrgetter
from pathlib import Path

import numpy as np
import pytest
from driver import ROOT, models
from fmu_copies import edited, has_no_binary, without
from refusals import refused_by

import dualcam
from dualcam import ContinuousFmu, Fmu
from dualcam.common import version
from dualcam.common.moved import MOVED, NEW_PLACES
from dualcam.errors import FmuError, UnknownVariableError
from dualcam.fmi import RepeatedStart, library

FORWARD, INVERSE = (model.fmu for model in models.values())
THIRD = FORWARD.parent / "fmi3" / FORWARD.name
ELLIPSES = {"cam1.profile": 2, "cam2.profile": 2, "inertia.follower_mass": 0.3, "damper.c_load": 20.0}
refused = partial(refused_by, FmuError)
EACH_TYPE = {"contacts": 1, "ledger": False, "cam1.table": "some.csv", "spring.preload": 60.0}


@pytest.fixture(scope="module")
def shared():
    with Fmu(FORWARD) as fmu:
        yield fmu


@pytest.fixture
def fmu(shared):
    shared.start({"initial.theta": 0.5, "initial.omega": 2.0, "tau": 3.0})
    return shared


@pytest.fixture
def continuous():
    with ContinuousFmu(FORWARD) as fmu:
        yield fmu


# ---- values and runs ----


def test_it_is_the_package_of_this_folder():
    assert Path(dualcam.__file__).parent == Path(__file__).parents[1] / "dualcam"


def test_every_name_of_the_package_exists():
    assert all(hasattr(dualcam, name) for name in dualcam.__all__)
    with pytest.raises(AttributeError, match="nonsense"):
        dualcam.nonsense  # noqa: B018


@pytest.mark.parametrize("fmi", [2, 3])
def test_every_type_can_be_set_and_got(fmi):
    with Fmu("forward", fmi=fmi) as fmu:
        fmu.start(EACH_TYPE | {"cam1.profile": 1})
        assert {name: fmu.get(name) for name in EACH_TYPE} == EACH_TYPE
        assert [type(fmu.get(name)) for name in EACH_TYPE] == [int, bool, str, float]
        assert fmu.parameters == EACH_TYPE | {"cam1.profile": 1}
        with refused("cam1.friction", "-0.1", "allowed is"):
            fmu.start({"cam1.friction": -0.1})
        fmu.start()
        assert (fmu.get("spring.preload"), fmu.get("ledger"), fmu.parameters) == (50.0, True, {})


def test_every_variable_can_be_read(fmu, make_model):
    raw = make_model(models["DualCamForward"])
    raw.start({"initial.theta": 0.5, "initial.omega": 2.0, "tau": 3.0})
    assert fmu.names == [variable.name for variable in raw.model.listed]
    for name, first in zip(fmu.names, raw.model.by_index.values(), strict=True):
        found, expected = fmu.get(name), raw.get(first)
        assert found == (expected.decode() if isinstance(expected, bytes) else expected), name


def test_a_run_is_bit_for_bit_that_of_the_fmu_called_directly(fmu, make_model):
    raw = make_model(models["DualCamForward"])
    raw.start({"initial.theta": 0.5, "initial.omega": 2.0, "tau": 3.0})
    command, state = fmu.reals("tau", "F_ext"), fmu.reals("theta", "omega", "energy.heat_cam1")
    for k in range(300):
        inputs = [5.0 * math.sin(0.1 * k), float(k % 7)]
        command.values[:] = inputs
        command.write()
        fmu.step(1e-3)
        raw.set(dict(zip(command.names, inputs, strict=True)))
        raw.step(1e-3)
        read = state.read()
        assert read == [raw.get(name) for name in state.names]
        assert read == state.values.tolist()
        assert all(type(value) is float for value in read)
    assert fmu.time == pytest.approx(0.3)


def test_a_run_can_begin_anew_at_any_time_and_tolerance(shared):
    ends = []
    for time, tolerance in ((0.0, 1e-9), (7.0, 1e-9), (0.0, 1e-4)):
        shared.start(ELLIPSES | {"tau": 6.0}, time=time, tolerance=tolerance)
        assert shared.time == time
        for _ in range(10):
            shared.step(3e-3)
        ends.append(shared.get("theta"))
    assert ends[0] == ends[1]
    assert ends[0] != ends[2]
    assert ends[0] == pytest.approx(ends[2], rel=1e-3)


def test_derivatives_of_outputs_and_inputs(fmu):
    """The FMU takes a torque that is a parabola; what it puts out are omega and alpha."""
    command, state = fmu.reals("tau"), fmu.reals("theta", "omega")
    assert state.read_derivatives(1) == [fmu.get("omega"), fmu.get("alpha")]
    assert state.read_derivatives(2)[0] == fmu.get("alpha")
    ends = []
    for pieces in (1, 1000):
        fmu.start({"initial.theta": 0.5, "tau": 6.0})
        h = 0.01 / pieces
        for k in range(pieces):
            t = k * h
            command.values[0] = 6.0 + 50.0 * t + 4e3 * t**2
            command.write()
            command.write_derivatives(1, [50.0 + 8e3 * t])
            command.write_derivatives(2, [8e3])
            fmu.step(h)
        ends.append(state.read())
    assert ends[0] == pytest.approx(ends[1], rel=1e-9)


def test_partial_derivatives(fmu):
    """Two helices with equal radii and leads, only a shaft: alpha = (tau - rho (F0 + k z + F_ext))/J, with
    rho = (1 + mu)/(1 - mu) r/2 and z = r theta/2."""
    rho, J, k, lift = 0.01 * 1.14 / 0.86, 0.002, 5e4, 0.01
    found = fmu.jacobian(["alpha", "z", "v"], ["theta", "omega", "tau", "F_ext"])
    expected = [[-rho * k * lift / J, 0.0, 1.0 / J, -rho / J], [lift, 0.0, 0.0, 0.0], [0.0, lift, 0.0, 0.0]]
    assert found == pytest.approx(np.array(expected), rel=1e-12)
    seed = [0.5, -2.0, 3.0, 0.25]
    product = fmu.directional_derivative(["alpha", "z", "v"], ["theta", "omega", "tau", "F_ext"], seed)
    assert product == pytest.approx(found @ seed, rel=1e-14)


def test_a_restored_state_repeats_bit_for_bit(fmu):
    state, instant = fmu.save_state(), fmu.time
    ends = []
    for _ in range(3):
        fmu.restore_state(state)
        assert fmu.time == instant
        fmu.step(0.05)
        ends.append([fmu.get(name) for name in ("theta", "omega", "energy.residual", "events")])
    assert ends[0] == ends[1] == ends[2]


def test_prepared_runs_are_those_of_start(shared):
    values = ELLIPSES | {"spring.preload": 70.0}
    run = RepeatedStart(shared, values, ["initial.theta", "initial.omega", "tau"])
    found = []
    for start in ([0.3, 1.0, 4.0], [0.9, -2.0, 1.0], [0.3, 1.0, 4.0]):
        run.start(start)
        shared.step(5e-3)
        found.append([shared.get("theta"), shared.get("omega")])
    for start, ends in zip(([0.3, 1.0, 4.0], [0.9, -2.0, 1.0]), found, strict=False):
        shared.start(values | dict(zip(("initial.theta", "initial.omega", "tau"), start, strict=True)))
        shared.step(5e-3)
        assert ends == [shared.get("theta"), shared.get("omega")]
    assert found[0] == found[2]


# ---- model exchange ----


def test_model_exchange(continuous):
    """alpha of a helix in slip, rest inside the band, and the mode in between events."""
    continuous.start({"tau": 3.0})
    continuous.set_states_and_mode([0.5, 2.0])
    rho = 0.01 * 1.14 / 0.86
    assert continuous.derivatives() == pytest.approx([2.0, (3.0 - rho * 300.0) / 0.002], rel=1e-12)
    assert continuous.get("mode") == 2
    assert min(continuous.event_indicators()) > 0.0
    continuous.set_states([0.5, -1.0])
    assert continuous.get("mode") == 2  # until it is asked to decide
    assert min(continuous.event_indicators()) < 0.0
    continuous.enter_event_mode()
    assert continuous.states() == [0.5, 0.0]
    assert continuous.get("mode") == 1
    assert continuous.derivatives() == [0.0, 0.0]
    continuous.set_time(0.5)
    assert continuous.time == 0.5
    continuous.start()
    assert continuous.time == 0.0


def test_model_exchange_needs_inertia(continuous):
    with refused("inertia.shaft"):
        continuous.start({"inertia.shaft": 0.0})


def test_kinds_are_not_mixed(continuous, fmu):
    continuous.start()
    with refused("another instance"):
        continuous.restore_state(fmu.save_state())


def test_a_list_is_no_switch(fmu):
    with refused("ledger", "allowed are True and False"):
        fmu.start({"ledger": np.array([True, False])})


# ---- errors ----


@pytest.mark.parametrize(
    ("name", "mentions"),
    [
        ("thet", ("DualCamForward", "'thet'", "did you mean theta", "omega")),
        ("cam1.frction", ("cam1.friction", "cam1.radius")),
        ("Cam1.Friction", ("cam1.friction",)),
        ("xyzzy", ("'xyzzy'", "tau, F_ext, theta", "more")),
    ],
)
def test_an_unknown_name_is_told_what_exists(fmu, name, mentions):
    for call in (
        lambda: fmu.get(name),
        lambda: fmu.set(name, 1.0),
        lambda: fmu.reals("tau", name),
        lambda: fmu.start({name: 1.0}),
        lambda: fmu.jacobian([name], ["tau"]),
    ):
        with pytest.raises(UnknownVariableError) as caught:
            call()
        assert all(text in str(caught.value) for text in mentions), str(caught.value)


@pytest.mark.parametrize(
    ("name", "value", "mentions"),
    [
        ("cam1.friction", -0.1, ("cam1.friction", "-0.1", "allowed is")),
        ("cam1.friction", "much", ("cam1.friction", "much", "number")),
        ("cam1.friction", None, ("cam1.friction", "number")),
        ("contacts", 1.5, ("contacts", "whole")),
        ("contacts", 7, ("contacts", "7", "allowed is")),
        ("ledger", "false", ("ledger", "True and False")),
        ("cam1.table", 3, ("cam1.table", "text")),
        ("theta", 1.0, ("theta", "calculated", "initial.theta sets the start")),
        ("omega", 1.0, ("omega", "calculated", "initial.omega sets the start")),
        ("tau", math.nan, ("tau", "nan")),
    ],
)
def test_a_bad_value_is_told_what_is_allowed(shared, name, value, mentions):
    with refused(*mentions):
        shared.start({name: value})


def test_messages_are_the_fmus_own_words(fmu):
    with refused("fmi2SetReal: cam1.radius is fixed: allowed is to set it before the end"):
        fmu.set("cam1.radius", 0.03)
    with refused("fmi2SetRealInputDerivatives"):
        fmu.reals("tau").write_derivatives(1, [math.nan])
    with refused("Integer", "Real"):
        fmu.reals("contacts")
    with refused(r"names = \['tau', 'tau'\]: allowed is each variable once"):
        fmu.reals("tau", "tau")
    with refused("order 4"):
        fmu.reals("theta").read_derivatives(4)
    with refused("seed", r"\(1,\)"):
        fmu.directional_derivative(["alpha"], ["tau"], [1.0, 2.0])
    with refused('unknown category "100% #1"'):
        fmu._instance.call("fmi2SetDebugLogging", 1, 1, (c_char_p * 1)(b"100% #1"))
    fmu.step(1e-3)  # it goes on as before


WRONG_CALLS = {
    "step of text": (lambda fmu: fmu.step("a"), "step = 'a': allowed is a finite number > 0, in s"),
    "step of nothing": (lambda fmu: fmu.step(None), "step = None"),
    "step of several": (lambda fmu: fmu.step(np.array([1e-3, 1e-3])), "step = array"),
    "step of no number": (lambda fmu: fmu.step(math.nan), "step = nan"),
    "endless step": (lambda fmu: fmu.step(math.inf), "step = inf"),
    "negative step": (lambda fmu: fmu.step(-1.0), "step = -1.0: allowed is a finite number > 0"),
    "no step": (lambda fmu: fmu.step(0), "step = 0: "),
    "time as text": (lambda fmu: setattr(fmu, "time", "0"), "time = '0'"),
    "time of nan": (lambda fmu: setattr(fmu, "time", math.nan), "time = nan"),
    "start of a list": (lambda fmu: fmu.start([1]), r"start\(\[1\]\)"),
    "start of a number": (lambda fmu: fmu.start(0), r"start\(0\)"),
    "start at no time": (lambda fmu: fmu.start({}, None), "time = None"),
    "start at nan": (lambda fmu: fmu.start({}, math.nan), "time = nan"),
    "tolerance as text": (lambda fmu: fmu.start({}, 0.0, "1e-9"), "tolerance = '1e-9'"),
    "start value of a number": (lambda fmu: fmu.start({5: 1.0}), r"start\(\{5: 1.0\}\)"),
    "state of nothing": (lambda fmu: fmu.restore_state(None), r"restore_state\(None\): allowed is a state"),
    "value of nothing": (lambda fmu: fmu.get(None), "variable None"),
    "group of a list": (lambda fmu: fmu.reals(["tau"]), r"variable \['tau'\]"),
    "one name": (lambda fmu: fmu.jacobian("alpha", ["tau"]), "unknowns = 'alpha': allowed is a list"),
    "no names": (lambda fmu: fmu.directional_derivative(["alpha"], None, [1.0]), "knowns = None"),
    "order as text": (lambda fmu: fmu.reals("theta").read_derivatives("1"), "order '1'"),
    "order as list": (lambda fmu: fmu.reals("theta").read_derivatives([1]), r"order \[1\]"),
    "runs of nothing": (lambda fmu: RepeatedStart(None, {}, ["tau"]), r"RepeatedStart\(None"),
    "runs of one name": (lambda fmu: RepeatedStart(fmu, {}, "tau"), "names = 'tau'"),
    "FMU of nothing": (lambda fmu: Fmu(None), "FMU None: allowed are 'forward', 'inverse', or the path"),
    "FMU of a list": (lambda fmu: Fmu(["forward"]), "FMU \\['forward'\\]"),
    "version as list": (lambda fmu: Fmu("forward", fmi=[2]), r"fmi=\[2\]"),
    "version as float": (lambda fmu: Fmu("forward", fmi=2.0), "fmi=2.0"),
    "path of a list": (lambda fmu: dualcam.fmu_path(["forward"]), "kind="),
    "description of nothing": (lambda fmu: dualcam.fmi.read_model_description(None), "FMU None"),
}


@pytest.mark.parametrize("call", WRONG_CALLS)
def test_an_argument_of_a_wrong_kind_is_told_what_is_allowed(fmu, call):
    """No TypeError of ctypes and no AttributeError; the run goes on as before."""
    make, mention = WRONG_CALLS[call]
    with refused(mention, "allowed"):
        make(fmu)
    fmu.step(1e-3)
    assert fmu.time == 1e-3


def test_time_of_model_exchange_is_a_number(continuous):
    continuous.start()
    with refused("time = nan"):
        continuous.set_time(math.nan)
    with refused("time = '1'"):
        continuous.set_time("1")
    continuous.set_time(1.0)
    assert continuous.time == 1.0


def test_handles_say_what_they_are(continuous):
    with Fmu("forward", fmi=3) as fmu:
        assert repr(fmu) == "<Fmu DualCamForward, FMI 3.0, co-simulation, not started>"
        fmu.start(time=0.25)
        group, state = fmu.reals("tau", "theta"), fmu.save_state()
        assert repr(fmu) == "<Fmu DualCamForward, FMI 3.0, co-simulation, at 0.25 s>"
        assert (repr(group), repr(state)) == ("<Reals tau, theta>", "<FmuState at 0.25 s>")
        assert repr(RepeatedStart(fmu, {}, ["tau"])).startswith("<RepeatedStart of <Fmu DualCamForward")
    assert repr(fmu) == "<Fmu DualCamForward, FMI 3.0, co-simulation, closed>"
    assert repr(group) == "<Reals tau, theta, FMU closed>"
    assert repr(continuous).startswith("<ContinuousFmu DualCamForward, FMI 2.0, model exchange, ")


def test_a_start_that_cannot_work(shared):
    with refused("stop"):
        shared.start({"stop.lower": 1.0, "stop.upper": 0.5})
    shared.start()


def test_what_is_no_fmu(tmp_path):
    with refused("no file", "forward"):
        Fmu(tmp_path / "missing.fmu")
    text = tmp_path / "text.fmu"
    text.write_text("not a ZIP archive")
    with refused("text.fmu", "no FMU"):
        Fmu(text)
    empty = tmp_path / "empty.fmu"
    with zipfile.ZipFile(empty, "w"):
        pass
    with refused("empty.fmu", "modelDescription.xml"):
        Fmu(empty)
    invalid = tmp_path / "invalid.fmu"
    with zipfile.ZipFile(invalid, "w") as archive:
        archive.writestr("modelDescription.xml", "<fmiModelDescription/>")
    with refused("invalid.fmu", "modelDescription.xml"):
        Fmu(invalid)


def test_an_fmu_for_another_use_platform_or_version(tmp_path):
    with refused("has no model exchange"):
        ContinuousFmu(edited(FORWARD, tmp_path / "slave.fmu", without("ModelExchange")))
    with refused("bare.fmu", "library"):
        Fmu(edited(FORWARD, tmp_path / "bare.fmu", keeps=has_no_binary))
    with refused("GUID"):
        Fmu(edited(FORWARD, tmp_path / "foreign.fmu", lambda text: text.replace(b'guid="', b'guid="x', 1)))


# ---- life ----


def test_a_closed_fmu_refuses_every_call():
    with Fmu(FORWARD) as fmu:
        command = fmu.reals("tau")
        fmu.start()
        state = fmu.save_state()
        directory = Path(fmu._instance.directory)
        assert directory.exists()
    assert not directory.exists()
    fmu.close()
    for call in (
        command.read, command.write, fmu.save_state, fmu.start, lambda: fmu.step(1e-3),
        lambda: fmu.get("theta"), lambda: fmu.restore_state(state),
        lambda: command.write_derivatives(1, [0.0]), fmu.__enter__, lambda: fmu.time,
        lambda: setattr(fmu, "time", 0.0),
        lambda: command.values, lambda: setattr(command, "values", [1.0]),
    ):  # fmt: skip
        with refused("closed"):
            call()


def test_what_is_dropped_is_freed():
    fmu = Fmu(FORWARD)
    fmu.start()
    instance, directory = fmu._instance, Path(fmu._instance.directory)
    states = [fmu.save_state() for _ in range(3)]
    assert len(instance.states) == 3
    del states[:2]
    gc.collect()
    assert len(instance.states) == 1
    del fmu, states
    gc.collect()
    assert not instance.is_open
    assert not directory.exists()


def test_instances_share_nothing():
    with Fmu(FORWARD) as one, Fmu(FORWARD) as other, Fmu(INVERSE) as third:
        one.start({"initial.theta": 0.3, "tau": 2.0})
        other.start({"initial.theta": 0.6})
        third.start({"theta": 0.9})
        with refused("cam1.friction"):
            other.set("cam1.friction", -1.0)
        one.step(1e-3)
        assert [one.get("theta"), other.get("theta"), third.get("theta")] == [0.3, 0.6, 0.9]


# ---- names and versions ----


def test_paths_of_names():
    assert dualcam.fmu_path("forward") == FORWARD
    assert dualcam.fmu_path("inverse") == INVERSE
    assert dualcam.fmu_path("forward", fmi=3) == FORWARD.parent / "fmi3" / FORWARD.name
    with refused("backward", "'forward', 'inverse'"):
        dualcam.fmu_path("backward")
    with refused("fmi=1", "2 .* and 3"):
        dualcam.fmu_path("forward", fmi=1)


def test_an_installed_package_has_its_fmus_inside(tmp_path, monkeypatch):
    """The folder of the package comes first. Without it and without a build the error says how to make
    both."""
    monkeypatch.setattr(library, "PACKAGE", tmp_path / "dualcam")
    with refused("DualCamForward.fmu of FMI 3.0 is missing", r"build\.sh", "install"):
        dualcam.fmu_path("forward", fmi=3)
    for fmi, content in ((2, FORWARD), (3, THIRD)):
        inside = tmp_path / "dualcam" / "fmus" / f"fmi{fmi}" / FORWARD.name
        inside.parent.mkdir(parents=True)
        inside.write_bytes(content.read_bytes())
        assert dualcam.fmu_path("forward", fmi=fmi) == inside
        with Fmu("forward", fmi=fmi) as fmu:
            assert fmu.description.fmi_version == f"{fmi}.0"


def test_a_name_or_a_path_is_a_source():
    for source, options in (("forward", {}), (FORWARD, {}), (str(FORWARD), {}), (FORWARD, {"fmi": 2})):
        with Fmu(source, **options) as fmu:
            assert fmu.description.fmi_version == "2.0"
    with refused("FMI 2.0", "allowed is fmi = 2"):
        Fmu(FORWARD, fmi=3)
    models_of_names = [
        dualcam.linearize(source, 0.5, at_rest="loading") for source in ("forward", FORWARD, THIRD)
    ]
    assert all(np.array_equal(model.A, models_of_names[0].A) for model in models_of_names)
    assert dualcam.to_nonlinear_io_system("forward", period=1e-3).nstates == 2
    assert dualcam.CamHysteresis("forward", 0.5).dead_band > 0.0


def run_of(fmu):
    """All that a run gives in scenes with stick, slip, stops and tuning, number by number."""
    fmu.start(ELLIPSES | {"initial.theta": 0.3, "tau": 4.0})
    command, state, everything = fmu.reals("tau", "F_ext"), fmu.reals("theta", "omega", "z", "v"), []
    for k in range(40):
        command.values = [6.0 * math.sin(0.4 * k), 5.0 * k % 7]
        command.write()
        if k == 20:
            saved = fmu.save_state()
            fmu.set("cam1.friction", 0.12)
        fmu.step(2e-3)
        everything += [*state.read(), *state.read_derivatives(1), *state.read_derivatives(2)]
    fmu.restore_state(saved)
    fmu.step(2e-3)
    everything += [*state.read(), fmu.time]
    knowns = ["theta", "omega", "tau", "F_ext", "cam1.friction"]
    everything += fmu.jacobian(["alpha", "v"], knowns).ravel().tolist()
    everything += fmu.directional_derivative(["alpha"], ["tau", "F_ext"], [0.5, 2.0]).tolist()
    return everything


def test_fmi_3_is_fmi_2_bit_for_bit():
    with Fmu("forward") as second, Fmu("forward", fmi=3) as third:
        assert third.description.fmi_version == "3.0"
        assert run_of(second) == run_of(third)
        common = set(second.names) & set(third.names)
        for name in common:
            assert second.get(name) == third.get(name), name
            assert type(second.get(name)) is type(third.get(name))
        states = {"state.theta", "state.omega", "der(state.theta)", "der(state.omega)"}
        assert common == set(second.names) - states


def test_the_inverse_fmu_in_both_versions():
    torques = []
    for fmi in (2, 3):
        with Fmu("inverse", fmi=fmi) as fmu:
            fmu.start({"theta": 0.4, "omega": 3.0, "alpha": -10.0})
            fmu.step(1e-3)
            torques.append(fmu.get("tau"))
    assert torques[0] == torques[1]


def test_model_exchange_in_both_versions():
    found = []
    for fmi in (2, 3):
        with ContinuousFmu("forward", fmi=fmi) as fmu:
            fmu.start({"tau": 3.0}, time=0.25)
            values = [fmu.time]
            for state in ([0.5, 2.0], [0.5, -2.0], [0.7, 0.0]):
                fmu.set_states_and_mode(state)
                values += [*fmu.states(), *fmu.derivatives(), *fmu.event_indicators(), fmu.get("mode")]
            fmu.set_states([0.6, -1.0])
            fmu.set_time(0.5)
            found.append([*values, *fmu.derivatives(), fmu.time])
    assert found[0] == found[1]


def test_fmi_3_has_no_derivatives_of_inputs():
    with Fmu("forward", fmi=3) as fmu:
        fmu.start()
        with refused("FMI 3.0 has no derivatives of inputs"):
            fmu.reals("tau").write_derivatives(1, [1.0])


# ---- calls before start, and values ----


@pytest.mark.parametrize("fmi", [2, 3])
def test_before_start_nothing_can_be_read_or_stepped(fmi):
    with Fmu("forward", fmi=fmi) as fmu:
        group = fmu.reals("tau")
        calls = (
            group.read, group.write, lambda: fmu.get("theta"), lambda: fmu.real("theta"),
            lambda: fmu.set("tau", 1.0), lambda: fmu.step(1e-3), fmu.save_state,
            lambda: fmu.jacobian(["alpha"], ["tau"]), lambda: fmu.reals("theta").read_derivatives(1),
            lambda: group.write_derivatives(1, [0.0]),
        )  # fmt: skip
        for call in calls:
            with refused("no run has begun", r"call start\(\)"):
                call()
        fmu.start()
        fmu.step(1e-3)
        with refused("cam1.friction"):
            fmu.start({"cam1.friction": -1.0})
        for call in calls:
            with refused(r"last start\(\) failed", r"call start\(\)"):
                call()
        fmu.start()
        assert group.read() == [0.0]


@pytest.mark.parametrize("fmi", [2, 3])
def test_before_start_nothing_of_model_exchange_can_be_read(fmi):
    with ContinuousFmu("forward", fmi=fmi) as fmu:
        for call in (
            fmu.states, fmu.derivatives, fmu.event_indicators, fmu.enter_event_mode,
            lambda: fmu.set_states([0.0, 0.0]), lambda: fmu.set_time(1.0), lambda: fmu.get("theta"),
        ):  # fmt: skip
            with refused(r"call start\(\)"):
                call()
        fmu.start()
        with refused("states has shape", r"allowed is \(2,\)"):
            fmu.set_states([0.0])


def test_values_can_be_assigned(fmu):
    group = fmu.reals("tau", "F_ext")
    buffer = group.values
    group.values = [2.5, 7.0]
    assert group.values is buffer
    group.write()
    assert [fmu.get("tau"), fmu.get("F_ext")] == [2.5, 7.0]
    group.values = np.array([1, 2])
    group.write()
    assert fmu.reals("tau", "F_ext").read() == [1.0, 2.0]
    for values in ([1.0], [1.0, 2.0, 3.0], 4.0, [[1.0, 2.0]]):
        with refused("values has shape", r"allowed is \(2,\)"):
            group.values = values
    with refused("values has elements of type text", "allowed are real numbers"):
        group.values = ["a", "b"]
    assert group.values.tolist() == [1.0, 2.0]
    with refused("values has shape"):
        group.write_derivatives(1, [1.0])


def test_whole_numbers_that_the_type_does_not_have(shared):
    with refused("contacts = 4294967298", "Integer"):
        shared.start({"contacts": 2**32 + 2})


# ---- what is loaded ----


def printed(code):
    """What a new Python prints."""
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    return done.stdout.split()


def test_import_loads_no_other_package():
    """NumPy alone takes longer to load than all of `import dualcam`."""
    code = (
        "import sys; before = set(sys.modules); import dualcam; dir(dualcam);"
        "print(*{name.partition('.')[0] for name in set(sys.modules) - before})"
    )
    assert "dualcam" in printed(code)
    assert set(printed(code)) <= {"dualcam"} | sys.stdlib_module_names


def test_an_fmu_runs_without_fmpy():
    code = (
        "import sys, dualcam\n"
        "for fmi in (2, 3):\n"
        "    with dualcam.Fmu('forward', fmi=fmi) as fmu:\n"
        "        fmu.start({'tau': 5.0}); fmu.step(0.1); print(fmu.get('theta') > 0.0)\n"
        "dualcam.linearize, dualcam.study\n"
        "print([name for name in sys.modules if name.startswith(('fmpy', 'lxml', 'ziglang'))] == [])\n"
    )
    assert printed(code) == ["True"] * 3


def test_subpackages_need_no_further_import():
    code = (
        "import dualcam; print(dualcam.design.optimum.__name__, dualcam.study.Plan.__name__,"
        " dualcam.systems.__name__)"
    )
    assert printed(code) == ["optimum", "Plan", "dualcam.systems"]


NAMED_AS_PACKAGES = {"control", "gym", "mujoco"}  # modules that `from dualcam import *` leaves out


def test_the_modules_that_help_announces_are_attributes():
    announced = re.findall(r"^    dualcam\.(\w+) ", dualcam.__doc__, re.MULTILINE)
    assert {"design", "gradient", *NAMED_AS_PACKAGES} <= set(announced)
    for name in announced:
        code = f"import dualcam\ntry: print(dualcam.{name}.__name__)\nexcept ImportError as why: print(why)"
        found = " ".join(printed(code))
        assert found == f"dualcam.{name}" or f'pip install "dualcam[{name}]"' in found


def test_help_works_without_the_packages_of_some_rooms():
    """`help` and inspect.getmembers read each name that `dir` lists."""
    code = (
        "import inspect, pydoc, sys; sys.modules.update(gymnasium=None, mujoco=None); import dualcam\n"
        "names = [name for name, _ in inspect.getmembers(dualcam)]; pydoc.render_doc(dualcam)\n"
        "print('control' in names, 'gym' in names, 'mujoco' in names)\n"
        "try: dualcam.gym\nexcept ImportError as why: print(why)"
    )
    assert printed(code) == [
        "True",
        "False",
        "False",
        *["dualcam.gym", "needs", "gymnasium:", "pip", "install", '"dualcam[gym]"'],
    ]


def test_public_names():
    """`dir` lists them, and no module that is no room for users; type checkers see each one."""
    missing = {
        room for room, needed in (("gym", "gymnasium"), ("mujoco", "mujoco")) if not util.find_spec(needed)
    }
    assert set(dir(dualcam)) == {*dualcam.__all__, *NAMED_AS_PACKAGES} - missing and len(dir(dualcam)) <= 36
    assert {"Fleet", "__version__", "errors", "fmu_path"} <= set(dualcam.__all__)
    with pytest.raises(AttributeError, match="did you mean to_nonlinear_io_system"):
        dualcam.nlsys  # noqa: B018
    tree = ast.parse(Path(dualcam.__file__).read_text(encoding="utf-8"))
    (checked,) = [node for node in tree.body if isinstance(node, ast.If) and isinstance(node.test, ast.Name)]
    imported = {
        alias.name for node in checked.body if isinstance(node, ast.ImportFrom) for alias in node.names
    }
    assert imported | {"__version__"} == {*dualcam.__all__, *NAMED_AS_PACKAGES}
    assert (Path(dualcam.__file__).parent / "py.typed").is_file()


def test_old_paths_and_names_work_for_one_release():
    """Without the finders of an editable installation, which may know another checkout."""
    code = (
        "import sys, warnings; sys.meta_path[:] = [f for f in sys.meta_path if 'ditable' not in repr(f)]\n"
        "with warnings.catch_warnings(record=True) as caught:\n"
        "    warnings.simplefilter('always')\n"
        "    import dualcam.fmu; from dualcam.systems import motor; from dualcam.systems.gait import Walker\n"
        "    from dualcam.design import Finding; from dualcam.study import StudyError; dualcam.Reals\n"
        "print(dualcam.fmu.Fmu is dualcam.Fmu, motor.__name__, Finding.__name__)\n"
        "print(*(f'{one.category.__name__}:{one.filename}' for one in caught))"
    )
    assert printed(code)[:3] == ["True", "dualcam.systems.blocks.motor", "LimitViolation"]
    assert set(printed(code)[3:]) == {"DeprecationWarning:<string>"}
    for new in MOVED.values():
        assert util.find_spec(f"dualcam.{new}") is not None


@pytest.mark.parametrize("name", NEW_PLACES)
def test_a_name_that_has_moved_says_where(name):
    with pytest.warns(DeprecationWarning, match=rf"dualcam\.{name} is now dualcam\.\w+\.{name}\."):
        old = getattr(dualcam, name)
    assert old is attrgetter(NEW_PLACES[name])(dualcam) and name not in dir(dualcam)


def test_no_function_has_the_name_of_a_module_beside_it():
    for package in pkgutil.walk_packages(dualcam.__path__, "dualcam."):
        if package.ispkg:
            room = importlib.import_module(package.name)
            twins = {module.name for module in pkgutil.iter_modules(room.__path__)} & {*vars(room)}
            assert all(inspect.ismodule(getattr(room, name)) for name in twins), package.name


def test_version():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert dualcam.__version__ == project["version"]


def test_version_of_a_checkout_that_is_not_installed(monkeypatch):
    def missing(name):
        raise metadata.PackageNotFoundError(name)

    monkeypatch.setattr(metadata, "version", missing)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert version._version() == project["version"]
