"""Batches of runs in C: bit for bit the runs with calls from Python, also where runs fail or warn."""

import time
from itertools import pairwise

import numpy as np
import pytest
from study_cases import FORWARD, INVERSE, PUSH, study
from test_study_scenarios import SCENARIOS, groove

import dualcam
from dualcam.study import History, Plan, Scenario, Study, Vary
from dualcam.study.run import batch
from dualcam.study.run.runner import Runner

FMI3 = dualcam.fmu_path("forward", fmi=3)
FRICTION = Vary(0.08, 0.2)
RESULTS = ["theta@0.1", "efficiency", "events", "ledger", "theta", "theta@0"]


def both(one, saves_state=True):
    """Blocks of the same rows, with the calls from C and from Python."""
    rows, blocks = one.plan.rows(0, one.plan.count), []
    for in_c in (True, False):
        runner = Runner(one.job(), saves_state, in_c)
        blocks.append(runner.run(rows))
        runner.close()
    return blocks


def assert_same(one, saves_state=True):
    in_c, by_python = both(one, saves_state)
    assert np.array_equal(in_c.values, by_python.values, equal_nan=True)
    assert in_c.messages == by_python.messages
    return in_c


@pytest.mark.parametrize("saves_state", [True, False])
@pytest.mark.parametrize("name", SCENARIOS)
def test_scenarios(name, saves_state):
    """Constant, stepwise, ramps, curves and sines, at fixed times and at times that vary."""
    vary, scenario = SCENARIOS[name]
    plan = Plan("latin", {"cam1.friction": FRICTION, "ledger": Vary(values=(0, 1)), **vary}, runs=40, seed=3)
    fixed = {"initial.theta": 0.2, "contacts": 1, "cam2.profile": 2}
    assert not assert_same(study(plan, scenario, RESULTS, parameters=fixed), saves_state).messages


@pytest.mark.parametrize("saves_state", [True, False])
@pytest.mark.parametrize("fmu, scenario", [
    (FMI3, SCENARIOS["jump"][1]),
    (FMI3, Scenario(0.4, {"tau": History([0, "end"], [5.0, "peak"])}, step=0.01)),
    (INVERSE, Scenario(0.4, {"theta": History([0, "end", 0.4], [0.0, "0.05 * peak", 0.2], "smooth")})),
])  # fmt: skip
def test_other_fmus_of_the_cam(fmu, scenario, saves_state):
    plan = Plan("latin", {"cam1.friction": FRICTION, **SCENARIOS["jump"][0]}, runs=40, seed=3)
    results = ["theta@0.1", "efficiency"] if fmu == INVERSE else RESULTS
    assert not assert_same(study(plan, scenario, results, fmu), saves_state).messages


def test_two_inputs_of_different_types_and_groove_tables(tmp_path, decay):
    tables = tuple(groove(tmp_path / f"{k}.csv", slope) for k, slope in enumerate((0.015, 0.02, 0.025)))
    vary = {"cam1.table": Vary(values=tables), "cam1.friction": FRICTION, "peak": Vary(4.0, 9.0)}
    inputs = {"tau": History([0.0], ["peak"]), "F_ext": History([0.0, 0.2], [0.0, "2 * peak"])}
    fixed = {"cam1.profile": 3, "stop.upper": 1.0}
    one = study(Plan("latin", vary, runs=30), Scenario(0.4, inputs), RESULTS, parameters=fixed)
    assert not assert_same(one).messages
    vary = {"law": Vary(values=(1, 2)), "frozen": Vary(values=(0, 1)), "x": Vary(values=(1.0, 2.0))}
    other = Study(decay, Plan("grid", vary), Scenario(0.5, step=0.125), ["x@0.25", "x", "law", "frozen"])
    assert not assert_same(other).messages


@pytest.mark.parametrize("saves_state", [True, False])
@pytest.mark.parametrize("fmu", [FORWARD, FMI3])
def test_failed_runs(fmu, saves_state):
    """At the beginning, in a row, and at the end of a batch: their messages are those of one run each."""
    ellipse = np.where(np.isin(np.arange(1100), [0, 5, 6, 7, 500, 999, 1000, 1099]), 0.001, 0.05)
    plan = Plan("table", {"cam1.ellipse_a": Vary()}, table=ellipse[:, None])
    one = study(plan, PUSH, ["theta"], fmu, parameters={"cam1.profile": 2})
    block = assert_same(one, saves_state)
    assert sorted(block.messages) == [0, 5, 6, 7, 500, 999, 1000, 1099]
    assert len(set(block.messages.values())) == 1


def test_warnings_and_fatal_runs(decay):
    """A warning is no failure, and no message of a later run; after a fatal run another instance goes on."""
    rates = np.ones(60)
    rates[[3, 4, 20]], rates[[5, 30, 59]] = 4.8, -1.0
    plan = Plan("table", {"rate": Vary()}, table=rates[:, None])
    block = assert_same(Study(decay, plan, Scenario(0.25, step=0.125), ["x"]))
    assert block.messages == dict.fromkeys((5, 30, 59), "it grows")
    assert block.values[3, 0] == pytest.approx(np.exp(-4.8 * 0.25), rel=1e-14)


def test_a_call_from_python_is_short(monkeypatch):
    """Ctrl-C waits for its end: the clock is looked at between calls, and few runs are made at first."""
    ranges, clock = [], iter(0.02 * k for k in range(10_000))  # s; a call takes 0.02 s whatever it does
    runner = Runner(study().job())
    make = runner._loop.runs_make

    class Watched:
        def runs_make(self, calls, count, component, first, last, end):
            ranges.append(last - first)
            make(calls, count, component, first, last, end)

    runner._loop = Watched()
    monkeypatch.setattr(batch.time, "perf_counter", lambda: next(clock))
    rows = study().plan.rows(0, 64)
    assert np.array_equal(runner.run(rows).values, Runner(study().job(), in_c=False).run(rows).values)
    monkeypatch.setattr(batch.time, "perf_counter", time.perf_counter)
    assert ranges[0] == 1 and sum(ranges) == 64
    assert all(more <= 2.5 * before + 1 for before, more in pairwise(ranges))


def test_without_the_library_runs_are_made_from_python(monkeypatch):
    """As on a platform for which there is none."""

    def missing():
        raise dualcam.errors.FmuError("the library of dualcam.Fleet is missing")

    expected = Runner(study().job()).run(study().plan.rows(0, 8)).values
    monkeypatch.setattr(batch, "native", missing)
    runner = Runner(study().job())
    assert runner._loop is None
    assert np.array_equal(runner.run(study().plan.rows(0, 8)).values, expected)
