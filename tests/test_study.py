"""Parameter studies. The runs must be those of the FMU driven by hand, and the closed forms; the plans those
of SciPy; and no interruption, killed worker or full disk may lose or repeat a run."""

import io
import itertools
import json
import math
import os
import re
import resource
import signal
import subprocess
import sys
import time
from contextlib import closing
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from driver import ROOT
from refusals import refused_by
from scipy.interpolate import CubicSpline
from scipy.stats import qmc, sobol_indices
from study_cases import (
    DESIGN,
    FORWARD,
    PLAN,
    PUSH,
    RESULTS,
    SLOW_PLAN,
    Stop,
    after,
    closed,
    cluster_of,
    every_run_once,
    refused,
    runs_of,
    stop,
    study,
)
from study_laws import deadly, slow

import dualcam
from dualcam import Fmu
from dualcam.__main__ import main
from dualcam.study import Controller, History, Plan, Scenario, Vary, plots, read_results, read_study
from dualcam.study.run.first_runs import takes_less_than
from dualcam.study.run.runner import Runner
from dualcam.study.run.workers import AHEAD, DIED, InThisProcess
from dualcam.study.study import _progress

NULL = ROOT / "build/NullFmu.fmu"
BALANCE = ["spring", "kinetic", "heat_cam1", "heat_cam2", "heat_damper", "heat_shaft", "heat_stop"]


def by_hand(names, rows):
    """The scenario PUSH and RESULTS, through the handle of one instance that is opened for each row anew."""
    found = []
    for row in rows:
        with Fmu(FORWARD) as fmu:
            fmu.start(dict(zip(names, row.tolist(), strict=True)) | {"tau": 8.0})
            fmu.step(0.2)
            middle = fmu.real("theta")
            fmu.set("tau", 0.0)
            fmu.step(0.2)
            found.append([middle, *(fmu.get(name) for name in RESULTS[1:])])
    return np.array(found, float)


# ---- plans ----


def test_grid_is_the_product_last_fastest():
    plan = Plan(
        "grid", {"a": Vary(1.0, 3.0, count=3), "b": Vary(values=(5, 7)), "c": Vary(1, 100, count=3, log=True)}
    )
    expected = list(itertools.product([1.0, 2.0, 3.0], [5.0, 7.0], [1.0, 10.0, 100.0]))
    assert plan.count == 18
    assert np.allclose(plan.rows(0, 18), expected, rtol=1e-15)


def test_latin_hypercube_meets_every_stratum_once():
    shares = (Plan("latin", {"a": Vary(2.0, 4.0), "b": Vary(-1.0, 0.0)}, runs=50).rows(0, 50) - [2, -1]) / [
        2,
        1,
    ]
    assert all(sorted(np.floor(column * 50)) == list(range(50)) for column in shares.T)


def test_sobol_sequence_is_scipys():
    expected = qmc.Sobol(2, rng=3).random_base2(6)[:50] * [2, 1] + [2, -1]
    plan = Plan("sobol", {"a": Vary(2.0, 4.0), "b": Vary(-1.0, 0.0)}, runs=50, seed=3)
    assert np.allclose(plan.rows(0, 50), expected, rtol=1e-15)


@pytest.mark.parametrize("kind", ["grid", "latin", "sobol", "indices", "table"])
def test_rows_do_not_depend_on_how_they_are_cut(kind):
    vary = {"a": Vary(1.0, 2.0, count=4), "b": Vary(3.0, 4.0, count=4)}
    plan = Plan(kind, vary, runs=16, table=np.random.default_rng(1).random((30, 2)), same_as={"c": "b"})
    whole = plan.rows(0, plan.count)
    assert whole.shape == (plan.count, 3)
    assert np.array_equal(whole[:, 2], whole[:, 1])
    pieces = [plan.rows(start, start + 7) for start in range(0, plan.count, 7)]
    assert np.array_equal(np.concatenate(pieces), whole)
    lows, highs = np.array(list(plan.limits().values())).T
    assert np.all((lows <= whole) & (whole <= highs))


def ishigami(x):
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


def test_sobol_indices_of_ishigamis_function():
    """Closed form: Ishigami and Homma 1990."""
    plan = Plan("indices", {name: Vary(-math.pi, math.pi) for name in "abc"}, runs=4096)
    one = study(plan)
    values = ishigami(plan.rows(0, plan.count))
    v1, v2, v13 = (1 + 0.1 * math.pi**4 / 5) ** 2 / 2, 49 / 8, 0.01 * math.pi**8 * (1 / 18 - 1 / 50)
    first = np.array([v1, v2, 0.0]) / (v1 + v2 + v13)
    total = np.array([v1 + v13, v2, v13]) / (v1 + v2 + v13)
    found, ends = plots.indices(one, values), plots.spread(one, values)
    assert np.all(np.abs(found.first_order - first) < 0.01)
    assert np.all(np.abs(found.total_order - total) < 0.01)
    for (low, high), exact in zip(ends, (first, total), strict=True):
        assert np.all((low - 0.01 < exact) & (exact < high + 0.01))


def test_intervals_of_sobol_indices_are_as_wide_as_scipys():
    plan = Plan("indices", {name: Vary(-math.pi, math.pi) for name in "abc"}, runs=512)
    values = ishigami(plan.rows(0, plan.count))
    parts = values.reshape(5, 512)
    exact = sobol_indices(func={"f_A": parts[:1], "f_B": parts[1:2], "f_AB": parts[2:, None]}, n=512)
    scipys = exact.bootstrap(n_resamples=500, confidence_level=0.95)
    for ends, other in zip(
        plots.spread(study(plan), values), (scipys.first_order, scipys.total_order), strict=True
    ):
        wide = np.ravel(other.confidence_interval.high - other.confidence_interval.low)
        assert np.all(np.abs(ends[1] - ends[0] - wide) < 0.3 * wide)  # 200 and 500 resamples of the same runs


# ---- scenarios ----


def test_constant_pieces_are_one_step_each_and_readings_cut_them():
    assert [(s.time, s.size) for s in PUSH.steps([], True, False)] == [(0.0, 0.2), (0.2, 0.2)]
    assert [s.values["tau"] for s in PUSH.steps([0.2, 0.3], False, False)] == [8.0, 0.0, 0.0]
    assert all(not s.rates for s in PUSH.steps([], True, False))


def test_polynomials_of_the_steps_are_the_spline_and_its_derivatives():
    knots, values = [0.0, 0.1, 0.3, 0.7], [0.1, 0.4, 0.2, 0.9]
    inputs = {
        "omega": History(derivative_of="theta"),
        "theta": History(knots, values, "smooth"),
        "alpha": History(derivative_of="omega"),
    }
    spline = CubicSpline(knots, values, bc_type="clamped")
    for step in Scenario(0.7, inputs).steps([0.05, 0.4], True, False):
        for time_in in np.linspace(0.0, step.size, 5):
            for order, name in enumerate(inputs := ("theta", "omega", "alpha")):
                rates = [step.rates.get((name, k), 0.0) for k in (1, 2, 3)]
                value = step.values[name] + sum(
                    r * time_in**k / math.factorial(k) for k, r in enumerate(rates, 1)
                )
                assert value == pytest.approx(spline(step.time + time_in, order), abs=1e-11)
    assert inputs


def test_without_input_derivatives_values_are_held_from_the_middle():
    ramp = Scenario(0.4, {"tau": History([0.1, 0.3], [0.0, 4.0])}, step=0.1)
    steps = ramp.steps([], False, False)
    assert [s.values["tau"] for s in steps] == pytest.approx([0.0, 1.0, 3.0, 4.0])
    with refused("step"):
        Scenario(0.4, ramp.inputs).steps([], False, False)
    with refused("0.25", "multiple"):
        ramp.steps([0.25], False, True)
    with refused("stop", "multiple"):
        Scenario(0.45, step=0.1).steps([], False, True)


# ---- runs ----


def test_runs_are_those_of_the_fmu_driven_by_hand():
    one = study()
    block = runs_of(one)
    assert not block.messages
    rows = one.plan.rows(0, 8)
    assert np.array_equal(block.values[:8], by_hand(one.plan.names, rows))


@pytest.mark.parametrize("saves_state", [True, False])
def test_a_run_does_not_depend_on_those_before_it(saves_state):
    """Integers, Booleans and fixed parameters of every type; both ways to begin; more runs than a batch."""
    vary = {
        "contacts": Vary(values=(1, 2)),
        "ledger": Vary(values=(0, 1)),
        "cam1.friction": Vary(0.1, 0.2, count=300),
    }
    fixed = {"cam2.profile": 2, "cam1.table": "unused.csv", "spring.preload": 60.0}
    one = study(
        Plan("grid", vary), results=["peak.reaction1", "theta", "contacts", "ledger"], parameters=fixed
    )
    rows = one.plan.rows(0, one.plan.count)
    runner = Runner(one.job(), saves_state)
    forward, backward = runner.run(rows), runner.run(rows[::-1])
    assert not forward.messages
    assert np.array_equal(forward.values, backward.values[::-1])
    assert np.array_equal(forward.values[:, 2:], rows[:, :2])
    assert np.all(forward.values[rows[:, 1] == 0.0, 0] == 0.0)  # no peaks without accounts
    assert np.all(forward.values[rows[:, 1] == 1.0, 0] > 0.0)


def test_energy_balances_in_every_run():
    names = ["energy.work_in", *(f"energy.{part}" for part in BALANCE)]
    values = runs_of(study(results=[*names, "energy.spring@0"])).values
    stored = values[:, 1:8].sum(axis=1) - values[:, 8]
    assert np.all(np.abs(values[:, 0] - stored) < 1e-10 * np.abs(values[:, 0]))


def test_efficiency_is_best_at_45_degrees():
    """Closed form: ((1 - mu)/(1 + mu))^2 at pi/4 for both, whatever the radii."""
    angles = tuple(math.pi / 4 + step for step in (-0.2, -0.1, 0.0, 0.1, 0.2))
    vary = {f"cam{k}.lead_angle": Vary(values=angles) for k in (1, 2)}
    fixed = {"cam1.radius": 0.017, "cam2.radius": 0.025, "initial.theta": 0.5}
    one = study(Plan("grid", vary), Scenario(1e-3), ["efficiency"], parameters=fixed)
    values = runs_of(one).values[:, 0]
    assert np.argmax(values) == 12
    assert values[12] == pytest.approx((0.86 / 1.14) ** 2, rel=1e-13)


def test_a_ramp_by_derivatives_is_the_limit_of_small_steps():
    ramp = {"tau": History([0.0, 0.2, 0.4], [0.0, 8.0, 0.0])}
    reads = [f"theta@{0.4 * k / 400:.17g}" for k in range(1, 400)]
    plan = Plan("latin", DESIGN, runs=4)
    few = runs_of(study(plan, Scenario(0.4, ramp), ["theta", "energy.work_in"])).values
    many = runs_of(study(plan, Scenario(0.4, ramp), [*reads, "theta", "energy.work_in"])).values[:, -2:]
    assert np.allclose(few, many, rtol=1e-9)


def test_any_fmu_even_one_without_states_and_input_derivatives():
    plan = Plan("latin", {"cam1.radius": Vary(0.01, 0.02)}, runs=1100)
    one = study(
        plan, Scenario(0.4, {"tau": History([0.0, 0.4], [0.0, 4.0])}, step=0.1), ["tau", "cam1.radius"], NULL
    )
    block = runs_of(one)
    assert np.allclose(block.values[:, 0], 3.5, rtol=1e-15)
    assert np.array_equal(block.values[:, 1:], plan.rows(0, 1100))


@pytest.mark.parametrize("saves_state", [True, False])
def test_fmi_3_makes_the_runs_of_fmi_2(saves_state):
    """With start values of each type, a tuned parameter and a controller."""
    plan = Plan("latin", DESIGN, runs=16)
    parameters = {"contacts": 1, "ledger": True, "cam1.profile": 2, "cam2.profile": 2}
    for scenario in (PUSH, closed(proportional)):
        found = []
        for source in ("forward", dualcam.fmu_path("forward", fmi=3)):
            runner = Runner(
                study(plan, scenario, RESULTS[1:], source, parameters=parameters).job(), saves_state
            )
            block = runner.run(plan.rows(0, plan.count))
            runner.close()
            assert block.messages == {}
            found.append(block.values)
        assert np.array_equal(*found)
        assert np.all(np.isfinite(found[0]))


def test_an_fmi_3_fmu_takes_no_derivatives_of_inputs():
    ramp = Scenario(0.1, {"tau": History([0.0, 0.1], [0.0, 8.0])})
    with refused("takes no derivatives of inputs", "give step"):
        Runner(study(scenario=ramp, results=["theta"], fmu=dualcam.fmu_path("forward", fmi=3)).job())


def test_a_failed_run_is_a_row_with_the_fmus_message():
    """An ellipse that is too small for the stroke, between good ones."""
    table = [[0.05, 0.1], [0.001, 0.1], [0.05, 0.1]]
    vary = {"cam1.ellipse_a": Vary(), "cam1.friction": Vary()}
    for state in (True, False):
        runner = Runner(study(Plan("table", vary, table=table), parameters={"cam1.profile": 2}).job(), state)
        block = runner.run(np.array(table))
        runner.close()
        assert set(block.messages) == {1}
        assert "cam1.ellipse_a = 0.001" in block.messages[1]
        assert np.all(np.isnan(block.values[1]))
        assert np.array_equal(block.values[0], block.values[2])


def test_memory_does_not_grow_with_the_runs(tmp_path):
    """Of 40,000 runs with their results on disk; ./build.sh run rate looks at more. The first tenth, when
    buffers are made, is left out; it goes up and down from chunk to chunk."""
    seen = []

    def look():
        seen.append(int(Path("/proc/self/statm").read_text().split()[1]) * resource.getpagesize())

    study(Plan("latin", DESIGN, runs=40_000)).run_to_files(
        tmp_path, 0, file_format="csv", runs_per_file=400, on_file_written=look
    )
    assert len(seen) == 100
    assert max(seen[-20:]) - max(seen[10:30]) < 2**20


# ---- closed loop ----


def proportional():
    return lambda now, seen: [20.0 * (0.5 - seen[0]) - 0.05 * seen[1]]


def moody():
    def law(now, seen):
        if seen[0] > 0.7:
            raise RuntimeError("too far")
        return [0.0]

    return law


STARTS = Plan("grid", {"initial.theta": Vary(0.1, 1.0, count=10)})


def test_a_controller_closes_the_loop():
    found = runs_of(study(STARTS, closed(proportional), ["theta", "tau"])).values
    for start, row in zip(STARTS.rows(0, 10)[:, 0], found, strict=True):
        with Fmu(FORWARD) as fmu:
            fmu.start({"initial.theta": start})
            for k in range(50):
                fmu.set("tau", proportional()(0.0, [fmu.real("theta"), fmu.real("omega")])[0])
                fmu.time = k * 1e-3
                fmu.step(1e-3)
            assert row == pytest.approx([fmu.real("theta"), fmu.real("tau")], rel=1e-9)


def test_a_controller_that_fails_concerns_its_run_alone():
    block = runs_of(study(STARTS, closed(moody), ["theta"]))
    assert set(block.messages) == {7, 8, 9}
    assert block.messages[9] == "controller: RuntimeError: too far"
    assert np.all(np.isfinite(block.values[:7]))


def returning(value, writes):
    """A run whose law returns the value."""
    control = Controller(lambda: lambda now, seen: value, 1e-3, ["theta"], writes)
    return runs_of(study(STARTS, Scenario(0.01, controller=control), ["tau", "F_ext"]), np.array([[0.1]]))


@pytest.mark.parametrize("value, writes, mention", [
    ([3.0], ["tau", "F_ext"], "the law returned 1 value, writes has 2: tau, F_ext"),
    (3.0, ["tau", "F_ext"], "the law returned 1 value, writes has 2: tau, F_ext"),
    ((1.0, 2.0, 3.0), ["tau", "F_ext"], "the law returned 3 values, writes has 2: tau, F_ext"),
    (np.ones(2), ["tau"], "the law returned 2 values, writes has 1: tau"),
    ([], ["tau"], "the law returned 0 values, writes has 1: tau"),
    ([True], ["tau"], "type bool: allowed are real numbers"),
    (np.array([1.0, 2.0]) > 1.5, ["tau", "F_ext"], "type bool: allowed are real numbers"),
    (["3.2"], ["tau"], "type text, such as '3.2': allowed are real numbers"),
    (None, ["tau"], "type object, such as None: allowed are real numbers"),
    ([1.0, None], ["tau", "F_ext"], "allowed are real numbers"),
])  # fmt: skip
def test_a_law_that_returns_no_number_for_each_input(value, writes, mention):
    text = returning(value, writes).messages[0]
    assert text.startswith("controller: ") and mention in text


@pytest.mark.parametrize("value", [[3, 5.0], (3.0, 5.0), np.array([3.0, 5.0]), np.array([[3], [5]])])
def test_a_law_that_returns_a_number_for_each_input(value):
    assert returning(value, ["tau", "F_ext"]).values.tolist() == [[3.0, 5.0]]
    for one in (value[0], np.array(value[:1])):
        assert returning(one, ["tau"]).values[0, 0] == 3.0


def test_short_studies_are_made_in_this_process(tmp_path, monkeypatch):
    """A worker process costs more than 64 runs. Runs of a controller that sleeps take 0.1 s each. An FMU that
    is no part of the package could end this process: its runs are made elsewhere."""
    made = []

    def noted(task, runner, count, scheduler):
        made.append(count)
        return InThisProcess(task, runner)

    monkeypatch.setattr("dualcam.study.study.workers_for", noted)
    study(fmu="forward").run_to_files(tmp_path / "short")
    study(Plan("latin", DESIGN, runs=4)).run_to_files(tmp_path / "foreign")
    assert made == [0, min(os.cpu_count(), 4)]
    one = study(STARTS, closed(slow, 0.1, 0.02), ["theta"], fmu="forward")
    with closing(Runner(one.job())) as runner:
        assert not takes_less_than(2.0, runner, one.plan, 1000)
        assert takes_less_than(2.0, runner, one.plan, 1)


def progress_line(now, made):
    """What the progress shows in the end, without colours, after `made`, where `now()` is the clock."""
    from rich.console import Console

    text = io.StringIO()
    made(Console(file=text, force_terminal=True, width=120, get_time=now))
    return re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", text.getvalue()).rstrip().splitlines()[-1]


def test_progress_tells_rate_and_time_left():
    """By a clock of the test: of 10 runs 2 are there before, and each of the next takes half a second."""
    seconds = [100.0]

    def five_runs(console):
        with _progress(console, 10, 2) as advance:
            for run in range(5):
                seconds[0] += 0.5
                advance(1, int(run == 3))

    line = progress_line(lambda: seconds[0], five_runs)
    assert "7 of 10 runs, 1 failed 2 runs/s 0:00:02" in line  # 3 runs are left: 1.5 s, shown as 2 s


def test_a_study_shows_its_progress(tmp_path):
    def whole(console):
        study(STARTS, closed(proportional), ["theta"]).run_to_files(
            tmp_path, 0, runs_per_file=1, console=console
        )

    assert "10 of 10 runs, 0 failed" in progress_line(time.monotonic, whole)


# ---- folders, processes, interruptions ----


without_pyarrow = pytest.mark.skipif(find_spec("pyarrow") is None, reason="pyarrow is not installed")
FORMATS = ["csv", pytest.param("parquet", marks=without_pyarrow)]


@pytest.mark.parametrize("form", FORMATS)
def test_an_interrupted_study_goes_on_where_it_was(tmp_path, form):
    one = study()
    with pytest.raises(Stop):
        one.run_to_files(
            tmp_path, workers=0, file_format=form, runs_per_file=10, on_file_written=after(3, stop)
        )
    made = {path: path.stat().st_mtime_ns for path in tmp_path.glob("runs/*")}
    assert len(made) == 3
    (tmp_path / "runs/.runs-000000030.csv-0.unfinished").write_bytes(b"half a chunk")
    table = one.run(tmp_path, workers=0, file_format="csv", runs_per_file=7)
    assert all(path.stat().st_mtime_ns == when for path, when in made.items())
    assert np.array_equal(every_run_once(tmp_path, one), runs_of(one).values)
    assert set(table["message"]) == {""}


def test_an_interrupted_study_of_processes_ends_at_once_and_goes_on(tmp_path):
    one = study()
    with pytest.raises(Stop):
        one.run_to_files(tmp_path, workers=2, runs_per_file=2, on_file_written=after(2, stop))
    assert 2 <= len(list(tmp_path.glob("runs/*.*"))) <= 2 + 2 * AHEAD
    one.run(tmp_path, workers=0)
    assert np.array_equal(every_run_once(tmp_path, one), runs_of(one).values)


def test_a_run_that_kills_its_process_is_a_failed_row(tmp_path):
    one = study(STARTS, closed(deadly), ["theta"])
    table = one.run(tmp_path, workers=1, runs_per_file=2)
    every_run_once(tmp_path, one)
    assert dict(enumerate(table["message"])) == dict.fromkeys(range(10), "") | {3: DIED}
    assert np.sum(np.isfinite(table["theta"])) == 9


def test_parquet_without_pyarrow_is_refused_and_csv_then_taken(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with refused("pyarrow", "pip install", "csv"):
        study().run(tmp_path, workers=0, file_format="parquet")
    study().run(tmp_path, workers=0, file_format="csv")
    every_run_once(tmp_path, study())


def test_a_full_disk_loses_nothing(tmp_path):
    """The limit on a file's size gives the same OSError from the same call as a disk without room."""
    one, limits = study(), resource.getrlimit(resource.RLIMIT_FSIZE)
    fill = after(3, lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (300, limits[1])))
    try:
        with refused("cannot write", "kept"):
            one.run_to_files(tmp_path, workers=0, file_format="csv", runs_per_file=10, on_file_written=fill)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert len(list(tmp_path.iterdir())) == 4
    one.run(tmp_path, workers=0)
    assert np.array_equal(every_run_once(tmp_path, one), runs_of(one).values)


# ---- a cluster ----


def test_a_cluster_whose_worker_is_killed_loses_no_run(tmp_path):
    plan = Plan("latin", DESIGN, runs=60)
    one = study(plan, closed(slow, 0.1, 0.02), ["theta", "energy.work_in"])
    with cluster_of(n_workers=2, processes=True) as cluster:
        worker = next(iter(cluster.workers.values()))
        kill = after(2, lambda: os.kill(worker.pid, signal.SIGKILL))
        one.run_to_files(tmp_path, scheduler=cluster.scheduler_address, runs_per_file=3, on_file_written=kill)
    found = every_run_once(tmp_path, one)
    still = study(plan, Scenario(0.1, {"tau": History([0.0], [8.0])}), ["theta", "energy.work_in"])
    assert np.allclose(found, runs_of(still).values, rtol=1e-12)


def test_a_run_that_kills_its_worker_is_a_failed_row(tmp_path):
    dask = pytest.importorskip("dask")
    starts = Plan("grid", {"initial.theta": Vary(0.1, 1.0, count=4)})  # 0.4 is the second
    one = study(starts, closed(deadly), ["theta"])
    with dask.config.set({"distributed.scheduler.allowed-failures": 0}), cluster_of(n_workers=2) as cluster:
        one.run_to_files(tmp_path, scheduler=cluster.scheduler_address, runs_per_file=1)
    every_run_once(tmp_path, one)
    assert read_results(tmp_path)["message"].tolist() == ["", DIED, "", ""]


def test_a_cluster_that_goes_away_is_told_and_nothing_is_lost(tmp_path, monkeypatch):
    monkeypatch.setattr("dualcam.study.run.cluster.UNREACHABLE_AFTER", "2s")
    one = study(Plan("latin", DESIGN, runs=60), closed(slow, 0.1, 0.02), ["theta"])
    with cluster_of(n_workers=1) as cluster, refused("does not answer any more", "kept"):
        one.run_to_files(
            tmp_path,
            scheduler=cluster.scheduler_address,
            runs_per_file=3,
            on_file_written=after(2, cluster.close),
        )
    assert len(list(tmp_path.glob("runs/*"))) >= 2
    one.run_to_files(tmp_path, workers=0)
    every_run_once(tmp_path, one)


def test_a_scheduler_that_does_not_answer_is_told(tmp_path, monkeypatch):
    pytest.importorskip("distributed", reason="dask.distributed is not installed")
    monkeypatch.setattr("dualcam.study.run.cluster.UNREACHABLE_AFTER", "1s")
    with refused("no Dask scheduler", "127.0.0.1:9"):
        study().run(tmp_path, scheduler="tcp://127.0.0.1:9")
    assert not list(tmp_path.glob("runs/*"))


# ---- what is wrong is told before any run ----


@pytest.mark.parametrize(
    "wrong, mentions",
    [
        (lambda: Plan("latin", DESIGN, runs=0), ["0 runs"]),
        (lambda: Plan("table", {"a": Vary()}, table=np.empty((0, 1))), ["0 runs"]),
        (lambda: Plan("grid", DESIGN), ["cam1.radius", "count"]),
        (lambda: Plan("grid", {}), ["vary"]),
        (lambda: Plan("latin", {"a": Vary(-1.0, 1.0, log=True)}, runs=3), ["logarithmic"]),
        (lambda: Plan("indices", DESIGN, runs=100), ["power of 2"]),
        (lambda: Plan("latin", DESIGN, runs=4, same_as={"b": "c"}), ["the same as c"]),
        (lambda: Plan("table", {"a": Vary()}, table=[[math.nan]]), ["finite"]),
        (lambda: Scenario(0.0), ["stop"]),
        (lambda: Scenario(1.0, {"tau": History([1.0], [0.0, 1.0])}), ["tau", "2 values"]),
        (lambda: Scenario(1.0, {"omega": History(derivative_of="theta")}), ["theta"]),
        (lambda: closed(proportional, period=0.0), ["period"]),
    ],
)
def test_plans_and_scenarios_that_make_no_sense(wrong, mentions):
    with refused(*mentions):
        wrong()


@pytest.mark.parametrize(
    "wrong, mentions",
    [
        (lambda: study(Plan("latin", {"contacts": Vary(1, 2)}, runs=4)), ["contacts", "whole"]),
        (lambda: study(Plan("latin", {"efficiency": Vary(0, 1)}, runs=4)), ["efficiency", "cannot be set"]),
        (lambda: study(results=[]), ["result"]),
        (lambda: study(results=["theta", "theta"]), ["twice"]),
        (lambda: study(results=["cam1.table"]), ["cam1.table", "String"]),
        (lambda: study(parameters={"cam1.radius": 0.02}), ["cam1.radius", "fixed too"]),
        (lambda: study(parameters={"cam2.radius": -1.0}), ["cam2.radius", "-1"]),
        (lambda: study(parameters={"tau": 1.0}), ["tau", "history"]),
        (lambda: study(scenario=Scenario(1.0, {"theta": History([0], [0])})), ["theta", "inputs"]),
        (lambda: study(fmu="nowhere.fmu"), ["nowhere.fmu"]),
    ],
)
def test_what_the_fmu_does_not_have_or_allow(tmp_path, wrong, mentions):
    with refused_by(ValueError, *mentions):
        wrong().run(tmp_path / "out", workers=0)
    assert not (tmp_path / "out").exists()


# ---- pictures and the command line ----


def test_the_front_is_that_of_brute_force():
    x, y = np.random.default_rng(5).integers(0, 30, (2, 400)).astype(float)
    for best in itertools.product(("max", "min"), repeat=2):
        gain = np.column_stack([x if best[0] == "max" else -x, y if best[1] == "max" else -y])
        kept = {tuple(g) for g in gain if not np.any(np.all(gain >= g, axis=1) & np.any(gain > g, axis=1))}
        found = plots.front(x, y, best)
        assert {tuple(gain[k]) for k in found} == kept
        assert len(found) == len(kept)


def test_the_command_runs_draws_and_goes_on(tmp_path, capsys):
    plan, out = tmp_path / "small.toml", tmp_path / "out"
    plan.write_text(PLAN.format(fmu=FORWARD))
    words = ["study", str(plan), "--out", str(out), "--workers", "0", "--format", "csv"]
    assert main(words) == 0
    assert "256 runs" in capsys.readouterr().out
    picture = out / "small/small.png"
    assert picture.read_bytes().startswith(b"\x89PNG")
    made = {path: path.stat().st_mtime_ns for path in (out / "small").glob("runs/*")}
    assert main([*words, "--figure", str(tmp_path / "all.png")]) == 0
    assert all(path.stat().st_mtime_ns == when for path, when in made.items())
    assert (tmp_path / "all.png").exists()


@pytest.mark.filterwarnings("error::RuntimeWarning")
def test_pictures_of_what_is_constant_logarithmic_or_failed(tmp_path):
    """No warning, whatever the results; axes are as the variables vary."""
    vary = {"cam1.ellipse_a": Vary(0.01, 0.1, log=True), "cam1.friction": Vary(0.1, 0.2)}
    pictures = [
        {"kind": "map", "x": "cam1.friction", "y": "cam1.ellipse_a", "z": "energy.heat_damper"},
        {"kind": "pareto", "x": "theta", "y": "energy.heat_damper"},
        {
            "kind": "parallel",
            "axes": ["cam1.ellipse_a", "theta", *["cam1.friction"] * 10, "energy.heat_damper"],
        },
    ]
    results, fixed = ["theta", "energy.heat_damper"], {"cam1.profile": 2}
    one = study(Plan("latin", vary, runs=40), PUSH, results, parameters=fixed, plots=pictures)
    still = Plan("indices", {name: DESIGN[name] for name in ("cam1.radius", "cam1.friction")}, runs=8)
    two = study(still, PUSH, results, plots=[{"kind": "sobol", "of": results}])
    studies = [(one, tmp_path / "one"), (two, tmp_path / "two")]
    for each, folder in studies:
        table = each.run(folder, workers=0)
        assert not np.any(table["energy.heat_damper"] > 0.0)
    assert 0 < np.sum(read_results(tmp_path / "one")["message"] != "") < 40
    plots.draw(studies, tmp_path / "all.png")
    assert (tmp_path / "all.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("signal_number, code", [(signal.SIGINT, 130), (signal.SIGKILL, -signal.SIGKILL)])
def test_a_killed_command_leaves_no_processes_and_goes_on(tmp_path, signal_number, code):
    plan, out = tmp_path / "small.toml", tmp_path / "out"
    plan.write_text(SLOW_PLAN.format(fmu=FORWARD))
    words = [str(plan), "--out", str(out), "--workers", "2", "--format", "csv", "--runs-per-file", "4"]
    command = [sys.executable, "-m", "dualcam", "study", *words]
    with subprocess.Popen(
        command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        # a shell's background jobs ignore SIGINT, and what they start inherits that
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    ) as process:
        while len(list(out.glob("small/runs/*.csv"))) < 5:
            assert process.poll() is None
            time.sleep(0.005)
        process.send_signal(signal_number)
        process.communicate(timeout=20)  # waits for the pipes, which the workers have too
    assert process.returncode == code
    one, made = read_study(plan), set((out / "small").glob("runs/*.csv"))
    assert 5 <= len(made) < 64
    one.run_to_files(out / "small", workers=0)
    still = study(one.plan, Scenario(0.01, {"tau": History([0.0], [8.0])}), one.results)
    assert np.allclose(every_run_once(out / "small", one), runs_of(still).values, rtol=1e-12)


@pytest.mark.parametrize(
    "plan", sorted((ROOT / "system_examples/study").glob("*.toml")), ids=lambda path: path.stem
)
def test_the_examples_can_be_run(plan):
    one = read_study(plan)
    assert not runs_of(one, one.plan.rows(0, 2000)).messages
    assert json.dumps(one.facts())
