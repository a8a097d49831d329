"""Scenarios, laws and groove tables that vary from run to run: each run is that of a study with the same
numbers fixed, or of the FMU driven by hand."""

import math
import warnings

import numpy as np
import pytest
from resolved_run import resolve
from study_cases import FORWARD, INVERSE, refused, runs_of, study

from dualcam import Fmu
from dualcam.__main__ import main
from dualcam.errors import DualcamWarning
from dualcam.study import Controller, History, Plan, Scenario, Vary, read_results, read_study
from dualcam.study.plan.profiles import RandomProfiles
from dualcam.study.plan.texts import GivenTexts
from dualcam.study.run.first_runs import check
from dualcam.study.run.runner import Runner

PEAK, END = Vary(4.0, 9.0), Vary(0.05, 0.3)
FRICTION = Vary(0.08, 0.2)
RESULTS = ["theta@0.1", "efficiency", "energy.work_in", "theta", "theta@0"]


def one_by_one(one):
    """The results of a study with fixed numbers for each run."""
    plan, found = one.plan, []
    with Fmu(one.path) as fmu:
        known = set(fmu.names)
    for row in plan.rows(0, plan.count):
        run = resolve(plan.names, row, one.scenario, known, plan.texts, plan.constraints)
        assert not run.violated and not run.scenario.names
        own = one.parameters | run.start_values
        fixed = {name: value for name, value in own.items() if name != "cam2.friction"}
        still = Plan("grid", {"cam2.friction": Vary(values=(own.get("cam2.friction", 0.14),))})
        block = runs_of(study(still, run.scenario, one.results, one.path, parameters=fixed))
        assert not block.messages
        found.append(block.values[0])
    return np.array(found)


SCENARIOS = {
    "amplitude": ({"peak": PEAK}, Scenario(0.4, {"tau": History([0, 0.2, 0.2], ["peak", "peak", 0.0])})),
    "two amplitudes": (
        {"peak": PEAK, "rest": Vary(0.0, 2.0)},
        Scenario(0.4, {"tau": History([0, 0.2, 0.4], ["peak + rest", "2 * rest", 0.5])}),
    ),
    "smooth amplitude": (
        {"peak": PEAK},
        Scenario(0.4, {"tau": History([0, 0.2, 0.4], [0.0, "peak", 0.0], "smooth")}),
    ),
    "jump": (
        {"peak": PEAK, "end": END},
        Scenario(0.4, {"tau": History([0, "end", "end"], ["peak", "peak", 0.0])}),
    ),
    "ramp": (
        {"peak": PEAK, "end": END},
        Scenario(0.4, {"tau": History([0, "end / 2", "end", 0.4], [0.0, "peak", "peak", 0.0])}),
    ),
    "stop": ({"end": END}, Scenario("end + 0.1", {"tau": History([0, "end"], [5.0, 8.0])})),
    "smooth times": (
        {"peak": PEAK, "end": END},
        Scenario(0.4, {"tau": History([0, "end", 0.4], [0.0, "peak", 0.0], "smooth")}),
    ),
    "two inputs": (
        {"peak": PEAK, "end": END},
        Scenario(
            0.4,
            {"tau": History([0, "end"], ["peak", 0.0]), "F_ext": History([0.05, "0.05 + end"], [0.0, 20.0])},
        ),
    ),
    "sine": (
        {"peak": PEAK, "f": Vary(1.0, 5.0)},
        Scenario(0.4, {"tau": History(shape="sine", amplitude="peak", frequency="f", mean=3.0)}),
    ),
    "constant": ({"peak": PEAK}, Scenario(0.4, {"tau": History([0.0], ["peak"])})),
    "no input": ({"end": END}, Scenario("end + 0.1")),
}


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_run_is_that_of_its_numbers(name):
    """To rounding: times and values are the same, but for the order of sums."""
    vary, scenario = SCENARIOS[name]
    plan = Plan("latin", {"cam1.friction": FRICTION, **vary}, runs=24, seed=3)
    one = study(plan, scenario, RESULTS, parameters={"initial.theta": 0.2})
    block = runs_of(one)
    assert not block.messages
    assert np.allclose(block.values, one_by_one(one), rtol=1e-9, atol=1e-12)
    backward = runs_of(one, plan.rows(0, 24)[::-1])
    assert np.array_equal(backward.values[::-1], block.values)


def test_runs_are_those_of_the_fmu_driven_by_hand():
    """Bit for bit where the torque is constant between jumps at times that vary."""
    vary, scenario = SCENARIOS["jump"]
    plan = Plan("random", {"cam1.friction": FRICTION, **vary}, runs=16, seed=8)
    found = runs_of(study(plan, scenario, ["theta", "energy.work_in"])).values
    for (friction, peak, end), row in zip(plan.rows(0, 16), found, strict=True):
        with Fmu(FORWARD) as fmu:
            fmu.start({"cam1.friction": friction, "tau": peak})
            fmu.step(end)
            fmu.set("tau", 0.0)
            fmu.step(0.4 - end)
            assert row.tolist() == [fmu.real("theta"), fmu.real("energy.work_in")]


def test_a_start_value_of_the_fmu_may_stand_in_formulas_too():
    """The torque begins at the load torque of each run's preload, by the closed form of section 3."""
    scenario = Scenario(0.1, {"tau": History([0.0], ["1.02 * spring.preload * 0.01 * 1.14 / 0.86"])})
    plan = Plan("grid", {"spring.preload": Vary(values=(40.0, 60.0, 80.0))})
    found = runs_of(study(plan, scenario, ["tau", "torque_load@0", "theta"])).values
    assert np.all(found[:, 0] > found[:, 1]) and np.all(found[:, 0] < 1.05 * found[:, 1])
    assert np.all(found[:, 2] > 0.0)


def test_a_sine_is_one():
    """Cubic pieces: the value to 1.2e-5 of the amplitude, also of a derivative."""
    wave = History(shape="sine", mean=0.5, amplitude=0.3, frequency=2.0, phase=0.4)
    inputs = {"theta": wave, "omega": History(derivative_of="theta"), "alpha": History(derivative_of="omega")}
    rate = 4.0 * math.pi
    for step in Scenario(0.7, inputs).steps([0.3], True, False):
        for time_in in np.linspace(0.0, step.size, 5):
            angle = rate * (step.time + time_in) + 0.4
            exact = (
                0.5 + 0.3 * math.sin(angle),
                0.3 * rate * math.cos(angle),
                -0.3 * rate**2 * math.sin(angle),
            )
            for order, (name, value) in enumerate(zip(inputs, (exact[0], exact[1], exact[2]), strict=True)):
                name = ("theta", "omega", "alpha")[order]
                found = step.values[name] + sum(
                    step.rates.get((name, k), 0.0) * time_in**k / math.factorial(k) for k in (1, 2, 3)
                )
                assert abs(found - value) < 1.3e-5 * 0.3 * rate**order


def test_the_inverse_fmu_follows_a_motion_whose_duration_varies():
    """Of two equal helices: tau = (F0 + k z)/(2 kappa) + J alpha, sections 3 and 6, moving up."""
    inputs = {
        "theta": History([0.0, "end"], [0.0, "far"], "smooth"),
        "omega": History(derivative_of="theta"),
        "alpha": History(derivative_of="omega"),
    }
    plan = Plan("grid", {"end": Vary(0.4, 0.8, count=3), "far": Vary(0.5, 1.0, count=3)})
    one = study(plan, Scenario("end", inputs), ["tau@0.2", "theta@0.2"], INVERSE)
    kappa = 0.86 / (0.02 * 1.14)
    for (end, far), (tau, theta) in zip(plan.rows(0, 9), runs_of(one).values, strict=True):
        share = 0.2 / end
        exact = far * (3.0 * share**2 - 2.0 * share**3)
        alpha = far * (6.0 - 12.0 * share) / end**2
        assert theta == pytest.approx(exact, rel=1e-12)
        force = 50.0 + 50_000.0 * 0.01 * exact
        assert tau == pytest.approx(force / (2.0 * kappa) + 0.002 * alpha, rel=1e-9)


@pytest.mark.parametrize("saves_state", [True, False])
def test_many_arrangements_of_steps_in_one_study(saves_state, monkeypatch):
    """More than are kept: times of readings before, at and after the jumps."""
    monkeypatch.setattr(Runner, "LAYOUTS", 2)
    plan = Plan("latin", {"a": Vary(0.0, 0.4), "b": Vary(0.0, 0.4), "peak": PEAK}, runs=60)
    scenario = Scenario(
        0.4,
        {
            "tau": History([0.0, "min(a, b)", "max(a, b)"], ["peak", "peak", 0.0]),
            "F_ext": History(["a"], [0]),
        },
    )
    one = study(plan, scenario, [*RESULTS, "theta@0.2", "theta@0.3"])
    runner = Runner(one.job(), saves_state)
    block = runner.run(plan.rows(0, 60))
    runner.close()
    assert not block.messages
    assert np.allclose(block.values, one_by_one(one), rtol=1e-9, atol=1e-12)


def test_numbers_that_are_no_scenario_concern_their_run_alone():
    """Every second run ends before it begins, or is read after its end."""
    plan = Plan("table", {"end": Vary()}, table=[[0.3], [-0.1], [0.2], [0.05], [0.4], [0.0]])
    scenario = Scenario("end", {"tau": History([0.0, "end"], [8.0, 8.0])})
    block = runs_of(study(plan, scenario, ["theta@0.1"]))
    assert set(block.messages) == {1, 3, 5}
    assert "stop = -0.1" in block.messages[1] and "theta@0.1" in block.messages[3]
    assert np.all(np.isfinite(block.values[::2]))
    backwards = Scenario(0.4, {"tau": History(["end", 0.25], [8.0, "1 / (end - 0.4)"])})
    block = runs_of(study(plan, backwards, ["theta"]))
    assert set(block.messages) == {0, 4}
    assert "tau: times must increase" in block.messages[0] and "finite" in block.messages[4]
    one = study(plan, scenario, ["theta@0.1"])
    with pytest.warns(
        DualcamWarning, match="50 % of the first 6 runs are refused, such as run 1: scenario: stop"
    ):
        check(one.job(), plan).close()


# ---- laws ----


def create_pd(stiffness, damping, target=0.5):
    return lambda now, seen: [stiffness * (target - seen[0]) - damping * seen[1]]


def create_named(name, gain):
    signs = {"push": 1.0, "pull": -1.0}
    return lambda now, seen: [signs[name] * gain]


def test_a_law_gets_the_values_of_its_run():
    control = Controller(
        create_pd, "1 / rate", ["theta", "omega"], ["tau"],
        {"stiffness": "gain", "damping": "0.1 * sqrt(gain)", "target": 0.4},
    )  # fmt: skip
    vary = {"gain": Vary(10.0, 30.0), "rate": Vary(values=(500.0, 1000.0)), "initial.theta": Vary(0.1, 0.9)}
    plan = Plan("latin", vary, runs=8)
    found = runs_of(study(plan, Scenario(0.05, controller=control), ["theta", "tau"])).values
    for (gain, rate, start), row in zip(plan.rows(0, 8), found, strict=True):
        with Fmu(FORWARD) as fmu:
            fmu.start({"initial.theta": start})
            law = create_pd(gain, 0.1 * math.sqrt(gain), 0.4)
            for k in range(round(0.05 * rate)):
                fmu.set("tau", law(0.0, [fmu.real("theta"), fmu.real("omega")])[0])
                fmu.time = k / rate
                fmu.step(1.0 / rate)
            assert row == pytest.approx([fmu.real("theta"), fmu.real("tau")], rel=1e-9)


def test_a_law_gets_texts():
    control = Controller(create_named, 1e-3, ["theta"], ["tau"], {"name": "way", "gain": "gain"})
    vary = {"way": Vary(values=("push", "pull")), "gain": Vary(values=(3.0, 5.0))}
    plan = Plan("grid", vary)
    found = runs_of(study(plan, Scenario(0.01, controller=control), ["tau"])).values
    assert found[:, 0].tolist() == [3.0, 5.0, -3.0, -5.0]


def test_a_law_that_refuses_its_arguments_concerns_its_run_alone():
    control = Controller(create_named, 1e-3, ["theta"], ["tau"], {"name": "way", "gain": 1.0})
    plan = Plan("grid", {"way": Vary(values=("push", "sideways", "pull"))})
    block = runs_of(study(plan, Scenario(0.01, controller=control), ["tau"]))
    assert block.messages == {1: "controller: KeyError: 'sideways'"}


def looked_at(scenario, plan):
    """What is said before the first run."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        check(study(plan, scenario, ["theta"]).job(), plan).close()
    return [str(one.message) for one in caught if one.category is DualcamWarning]


@pytest.mark.parametrize(
    ("period", "said"),
    [
        (0.25, ["controller.period = 0.25 s does not divide the run of 0.6 s", "last time at 0.5 s, 0.1 s"]),
        (2.0, ["controller.period = 2 s is longer than the run of 0.6 s", "last time at 0 s, 0.6 s"]),
        ("length", ["scenario, 50 %, such as run 1: controller.period = 0.4 s does not divide"]),
        (0.2, []),
        (0.6, []),
        (1e-4, []),
    ],
)
def test_a_period_that_does_not_divide_the_run_is_said(period, said):
    gains = {"stiffness": "10 * length", "damping": 0.1}
    control = Controller(create_pd, period, ["theta", "omega"], ["tau"], gains)
    plan = Plan("grid", {"length": Vary(values=(0.3, 0.4))})
    texts = looked_at(Scenario(0.6, controller=control), plan)
    texts = [text for text in texts if "controller.period" in text]
    assert len(texts) == bool(said)
    assert all(part in text for part in said for text in texts)


@pytest.mark.parametrize("number", ["1", "2 * 0.5"])
def test_a_number_in_quotes_without_a_unit_is_refused(number):
    """It is a formula in which nothing varies, so nobody would compute it."""
    allowed = "allowed is a number, such as 1, a number with its unit in quotes, or a formula"
    control = Controller(create_pd, number, ["theta", "omega"], ["tau"])
    with refused("controller.period = ", allowed):
        Scenario(2.0, controller=control)
    with refused("stop = ", allowed):
        Scenario(number)
    with refused("tau: ", allowed):
        Scenario(2.0, {"tau": History([0.0, number], [0.0, 1.0])})


# ---- groove tables ----


def groove(path, slope):
    psi = np.linspace(0.0, 1.0, 41)
    np.savetxt(
        path,
        np.column_stack([psi, slope * psi]),
        fmt="%.17g",
        delimiter=",",
        header="psi_rad,z_m",
        comments="",
    )
    return str(path)


TABLE = {"cam1.profile": 3, "stop.upper": 1.0}


def test_groove_tables_vary_with_numbers(tmp_path):
    """A straight table is a helix: theta as of the lead angle atan(slope/radius)."""
    slopes = (0.015, 0.02, 0.025)
    tables = Vary(values=tuple(groove(tmp_path / f"{k}.csv", slope) for k, slope in enumerate(slopes)))
    plan = Plan("latin", {"cam1.table": tables, "peak": PEAK, "cam1.friction": FRICTION}, runs=30)
    scenario = SCENARIOS["amplitude"][1]
    found = runs_of(study(plan, scenario, ["theta@0.1", "efficiency"], parameters=TABLE))
    rows = plan.rows(0, 30).copy()
    rows[:, 0] = [math.atan(slopes[int(place)] / 0.02) for place in rows[:, 0]]
    vary = {"cam1.lead_angle": Vary(), "peak": Vary(), "cam1.friction": Vary()}
    helices = runs_of(
        study(
            Plan("table", vary, table=rows),
            scenario,
            ["theta@0.1", "efficiency"],
            parameters={"stop.upper": 1.0},
        )
    )
    assert not found.messages and not helices.messages
    assert np.allclose(found.values, helices.values, rtol=1e-7)


def test_a_table_travels_with_its_content(tmp_path, monkeypatch):
    """To a machine that does not see the file."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    texts = GivenTexts.of([groove(tmp_path / "far.csv", 0.02), "plain"])
    (tmp_path / "far.csv").rename(tmp_path / "gone.csv")
    assert texts[0] != str(tmp_path / "far.csv") and texts[1] == "plain"
    with open(texts[0]) as file:
        assert file.read() == (tmp_path / "gone.csv").read_text()


def test_a_table_that_the_fmu_refuses_is_told_before_the_study(tmp_path):
    (tmp_path / "bad.csv").write_text("psi_rad,z_m\n0,0\n0.5,-0.1\n1,0.1\n1.2,0.2\n")
    tables = Vary(values=(groove(tmp_path / "good.csv", 0.02), str(tmp_path / "bad.csv"), "nowhere.csv"))
    one = study(Plan("grid", {"cam1.table": tables}), results=["theta"], parameters=TABLE)
    with refused("2 mistakes", "bad.csv", "nowhere.csv"):
        one.run(tmp_path / "out", workers=0)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("parameters, warned", [
    ({}, True), ({"cam1.profile": 2}, True), ({"cam1.profile": 3, "stop.upper": 1.0}, False),
])  # fmt: skip
def test_tables_that_no_run_reads_are_told(tmp_path, recwarn, parameters, warned):
    """The FMU reads a table where the profile is 3."""
    tables = Vary(values=[groove(tmp_path / f"{name}.csv", 0.02) for name in ("one", "two")])
    one = study(Plan("grid", {"cam1.table": tables}), results=["theta"], parameters=parameters)
    one.run_to_files(tmp_path / "out", workers=0)
    said = [str(each.message) for each in recwarn if "no run reads" in str(each.message)]
    assert len(said) == warned
    assert all("cam1.table varies" in text and 'Give "cam1.profile" = 3' in text for text in said)


def test_the_error_of_a_profile_moves_the_efficiency():
    """The efficiency at rest is that of a helix with the slope of the table where the pin is, in each run."""
    psi = np.linspace(0.0, 1.0, 201)
    tables = RandomProfiles(psi, 0.03 * psi, 1e-5, 0.2, count=6, seed=4)
    plan = Plan("grid", {"cam1.table": Vary(values=tables)})
    fixed = TABLE | {"initial.theta": 0.8}
    found = runs_of(study(plan, Scenario(1e-6), ["efficiency", "gamma"], parameters=fixed))
    assert not found.messages
    for place, (efficiency, gamma) in enumerate(found.values):
        slope = np.gradient(tables.height(place), psi)
        angle = math.atan(np.interp(gamma, psi, slope) / 0.02)
        helix = study(
            Plan("grid", {"cam1.lead_angle": Vary(values=(angle,))}), Scenario(1e-6), ["efficiency"],
            parameters={"initial.theta": 0.8, "stop.upper": 1.0},
        )  # fmt: skip
        assert efficiency == pytest.approx(runs_of(helix).values[0, 0], rel=2e-4)
    assert np.ptp(found.values[:, 0]) > 1e-4


# ---- one plan for all ----

WHOLE = """
fmu = "{fmu}"
results = ["theta@0.1", "efficiency", "energy.heat_cam1", "swing = max(theta, every=0.05)"]
parameters = {{ "cam1.profile" = 3, "stop.upper" = 1.0 }}
[plan]
kind = "sobol"
runs = 256
[plan.vary]
peak = {{ distribution = "normal", mean = "6 N.m", std = 1.0, from = "3 N.m" }}
push = {{ from = "50 ms", to = "250 ms" }}
"cam1.table" = {{ values = ["flat.csv", "steep.csv"], weights = [1, 3] }}
"cam1.friction" = {{ distribution = "normal", mean = 0.14, std = 0.02, from = 0.05, to = 0.25 }}
"cam2.friction" = {{ from = 0.1, to = 0.18 }}
[plan.derived]
"spring.preload" = "50 + 100 * (cam1.friction - 0.14)"
[plan.constraints]
likely = "cam1.friction + cam2.friction < 0.36"
[[plan.correlation]]
of = ["cam1.friction", "cam2.friction"]
rank = 0.7
[scenario]
stop = "400 ms"
inputs.tau = {{ time = [0.0, "push", "push"], value = ["peak", "peak", 0.0] }}
"""


@pytest.fixture
def whole(tmp_path):
    groove(tmp_path / "flat.csv", 0.018)
    groove(tmp_path / "steep.csv", 0.024)
    path = tmp_path / "whole.toml"
    path.write_text(WHOLE.format(fmu=FORWARD))
    return path


def test_one_plan_here_on_processes_and_on_a_cluster(whole, tmp_path):
    """It varies amplitude, duration, table and friction with a correlation; the results are bit for bit the
    same."""
    one = read_study(whole)
    here = one.run(tmp_path / "here", workers=0)
    assert set(here["message"]) == {""}
    assert len(here["run"]) == 256
    one.run(tmp_path / "processes", workers=2, runs_per_file=40)
    folders = ["processes"]
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
    with distributed.LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=None) as cluster:
        one.run(tmp_path / "cluster", scheduler=cluster.scheduler_address, runs_per_file=40)
    for name in [*folders, "cluster"]:
        table = read_results(tmp_path / name)
        assert all(np.array_equal(table[key], here[key]) for key in here if key != "message")
    assert here["spring.preload"] == pytest.approx(50.0 + 100.0 * (here["cam1.friction"] - 0.14), rel=1e-14)
    assert np.all(here["cam1.friction"] + here["cam2.friction"] < 0.36)
    assert np.all(here["peak"] >= 3.0)


def test_old_and_new_keys_give_the_facts_that_a_folder_remembers(whole):
    """A study that was begun by numbers alone goes on: its facts have no new entries."""
    plain = study(Plan("latin", {"cam1.friction": Vary(0.1, 0.2)}, runs=4)).facts()
    assert set(plain["plan"]) == {"kind", "vary", "runs", "seed", "table", "same_as"}
    assert plain["plan"]["vary"] == {"cam1.friction": [0.1, 0.2, 0, False, []]}
    assert set(plain["scenario"]["inputs"]["tau"]) == {"time", "value", "shape", "derivative_of"}
    other = read_study(whole).facts()
    whole.write_text(whole.read_text().replace("rank = 0.7", "rank = 0.6"))
    assert read_study(whole).facts()["plan"]["correlations"] != other["plan"]["correlations"]
    groove(whole.parent / "flat.csv", 0.019)
    assert read_study(whole).facts()["plan"]["vary"]["cam1.table"] != other["plan"]["vary"]["cam1.table"]


def test_the_rows_of_a_study_are_those_of_its_plan(whole, tmp_path):
    one = read_study(whole)
    one.run(tmp_path / "out", workers=0, runs_per_file=100)
    table = read_results(tmp_path / "out")
    rows = one.plan.rows(0, 256)
    for name, column in zip(one.plan.names, rows.T, strict=True):
        texts = one.plan.texts.get(name)
        expected = column.tolist() if texts is None else [texts[int(place)] for place in column]
        assert table[name].tolist() == expected


def test_pictures_have_names_that_the_fmu_does_not_have(whole, tmp_path):
    """With their unit; a column of texts cannot be drawn."""
    text = (
        whole.read_text()
        .replace("push = {{", "push = {{ ")
        .replace('to = "250 ms" }', 'to = "250 ms", unit = "s" }')
    )
    plots = '[[plots]]\nkind = "pareto"\nx = "{x}"\ny = "swing"\ncolor = "peak"\n'
    whole.write_text(text.replace("runs = 256", "runs = 16") + plots.format(x="push"))
    assert main(["study", str(whole), "--out", str(tmp_path / "out"), "--workers", "0"]) == 0
    assert (tmp_path / "out/whole/whole.png").read_bytes().startswith(b"\x89PNG")
    whole.write_text(text + plots.format(x="cam1.table"))
    with refused("plot pareto", "cam1.table", "no column of numbers"):
        read_study(whole)
