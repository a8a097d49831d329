"""Functions that take a design: a DesignFile or the path of its file, and nothing else."""

import math
import warnings
from types import ModuleType

import numpy as np
import pytest

import dualcam
from dualcam import Fmu
from dualcam.cli.commands import COMMANDS
from dualcam.design_file import as_design, read_design, write_template
from dualcam.errors import DesignError, DesignFileError, DualcamError, DualcamWarning
from dualcam.study import History, Scenario


@pytest.fixture
def path(tmp_path):
    return write_template("minimal", tmp_path / "my.toml")


TAKERS = {
    "simulate": (dualcam.simulate, ""),
    "check_design": (dualcam.check_design, ""),
    "export_fmu": (dualcam.export_fmu, "MyCam.fmu"),
    "write_report": (dualcam.write_report, "my.html"),
    "export_ssp": (dualcam.export_ssp, "MyCam.ssp"),
    "write_view": (dualcam.write_view, "my.html"),
}
each_taker = pytest.mark.parametrize("name", TAKERS)


def result_of(name, design, folder):
    """What a function makes of a design: its value, or the bytes of the written file."""
    call, file = TAKERS[name]
    if file:
        return call(design, folder / file).read_bytes()
    return call(design)


@each_taker
def test_a_path_is_as_good_as_the_design_of_the_file(path, tmp_path, name):
    expected = result_of(name, read_design(path), tmp_path)
    for source in (path, str(path)):
        found = result_of(name, source, tmp_path)
        if name == "simulate":
            assert found.names == expected.names and np.array_equal(found.values, expected.values)
        else:
            assert found == expected


@each_taker
@pytest.mark.parametrize("design", [None, 5, ["my.toml"], {"cam1.radius": 0.02}], ids=repr)
def test_what_is_no_design_is_refused(tmp_path, name, design):
    if name == "write_view" and design is None:
        return  # the default mechanism
    with pytest.raises(DesignError, match="allowed is a design from read_design, or the path"):
        result_of(name, design, tmp_path)


@each_taker
def test_a_missing_file_is_named(tmp_path, name):
    with pytest.raises(DesignError, match=r"absent\.toml"):
        result_of(name, tmp_path / "absent.toml", tmp_path)


@pytest.mark.parametrize("name", ["export_fmu", "write_report", "export_ssp", "write_view"])
def test_what_is_no_path_of_a_result_is_refused(path, name):
    with pytest.raises(DualcamError, match=r"None: allowed is the path of a file"):
        TAKERS[name][0](path, None)


def test_other_arguments_of_a_wrong_kind(path, tmp_path):
    with pytest.raises(DualcamError, match="None: allowed is the path of a file"):
        read_design(None)
    with pytest.raises(DualcamError, match="variables = 'theta': allowed is a list of names"):
        dualcam.simulate(path, "theta")
    with pytest.raises(DualcamError, match=r"parameters = \[1\]: allowed is a dict"):
        dualcam.simulate(path, parameters=[1])
    for step in (math.nan, 0.0, "1e-3"):
        with pytest.raises(DualcamError, match=f"step = {step!r}: allowed is a finite number > 0"):
            dualcam.export_ssp(path, tmp_path / "MyCam.ssp", step)


def test_warnings_of_a_file_are_not_lost(path, tmp_path):
    """A function whose result has no findings gives Python warnings, at the line of its caller."""
    path.write_text(path.read_text().replace('stiffness = "50 N/mm"', "stiffness = 50"))
    (finding,) = read_design(path).warnings
    with pytest.warns(DualcamWarning) as caught:
        dualcam.simulate(path)
    assert [str(one.message) for one in caught] == [f"{path}: {finding}"]
    assert caught[0].filename == __file__
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert finding in dualcam.check_design(path).findings
        dualcam.write_report(path, tmp_path / "my.html")
        assert as_design(read_design(path)).warnings == (finding,)


def test_a_refused_file_lists_its_errors(path):
    path.write_text("[cam1]\nradius = -1\nfriction = -1\n")
    with pytest.raises(DesignFileError, match="2 errors"):
        dualcam.simulate(path)


# ---- trajectories ----


def test_a_trajectory_is_read_like_a_dict(path):
    names = ("theta", "tau")
    run = dualcam.simulate(path, names)
    assert list(run) == list(run.keys()) == list(run.names) == ["time", *names]
    assert len(run) == 3 and "tau" in run and "omega" not in run and 0 not in run
    columns = dict(run)
    assert columns.keys() == set(run) and all(columns[name] is not None for name in run)
    assert all(np.array_equal(columns[name], run.values[:, k]) for k, name in enumerate(run))
    assert repr(run) == f"<Trajectory of {len(run.values):,} samples: time, theta, tau>"
    last = dict(zip(run, run.values[-1], strict=True))
    assert last["time"] == run["time"][-1]


# ---- modules with the name of an action ----

MODULES = [name for name in COMMANDS if isinstance(getattr(dualcam, name, None), ModuleType)]


@pytest.mark.parametrize("name", MODULES)
def test_a_module_with_the_name_of_a_command_says_what_to_call(name):
    """The message names a function that exists."""
    with pytest.raises(DualcamError, match=rf"dualcam\.{name} is a module: call dualcam\.(\w+)") as caught:
        getattr(dualcam, name)("my.toml")
    called = str(caught.value).split("call dualcam.")[1].partition("(")[0]
    found = dualcam
    for part in called.split("."):
        found = getattr(found, part)
    assert callable(found)


def test_no_module_has_the_name_of_a_check():
    assert not hasattr(dualcam, "check") and dualcam.checking.check_design is dualcam.check_design


# ---- scenarios with FMUs ----

PUSH = Scenario(0.2, {"tau": History([0.0, 0.1, 0.2], [0.0, 8.0, 2.0])})


def test_an_fmu_runs_a_scenario_as_a_design_does(path):
    """By name, by path and by a handle, which begins again and stays open; bit for bit."""
    design = read_design(path)
    wanted = dualcam.simulate(design, ["tau", "theta"], scenario=PUSH, output_interval=0.05)
    assert wanted["time"].tolist() == [0.0, 0.05, 0.1, 0.15000000000000002, 0.2]
    given = {"scenario": PUSH, "parameters": design.parameters_for("forward"), "output_interval": 0.05}
    with Fmu(dualcam.fmu_path("forward")) as handle:
        handle.start()
        handle.step(0.1)
        for source in ("forward", dualcam.fmu_path("forward"), handle, handle):
            assert np.array_equal(dualcam.simulate(source, ["tau", "theta"], **given).values, wanted.values)
        assert handle.get("tau") == 2.0
    run = dualcam.simulate("forward", scenario=PUSH)
    assert run.names == ("time", "tau", "F_ext", "theta", "omega", "z", "v") and len(run.values) == 1001


def test_a_scenario_chooses_the_model(path):
    """Of a design whose own scenario is one of the forward model."""
    turned = {"theta": History([0.0, 0.2], [0.1, 0.5]), "omega": History(derivative_of="theta")}
    scenario = Scenario(0.2, {**turned, "alpha": History(derivative_of="omega")})
    run = dualcam.simulate(path, ["theta", "tau"], scenario=scenario)
    assert run["theta"][-1] == 0.5 and run["tau"].min() > 0.0


def test_scenarios_that_do_not_suit_an_fmu_are_refused(path):
    with pytest.raises(DesignError, match="forward: an FMU has no scenario: give one, such as scenario="):
        dualcam.simulate("forward")
    with pytest.raises(DesignError, match="has no input theta, which the scenario gives: the inputs of this"):
        dualcam.simulate("forward", scenario=Scenario(0.2, {"theta": History([0.0], [0.1])}))
    with pytest.raises(DesignError, match=r"fmu = 'my\.fmu' beside the FMU forward: fmu is the"):
        dualcam.simulate("forward", scenario=PUSH, fmu="my.fmu")
