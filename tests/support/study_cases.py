"""A parameter study, and checks of its runs, that several tests share."""

import itertools
from functools import partial

import numpy as np
import pytest
from driver import models
from refusals import refused_by

from dualcam.design import Table
from dualcam.errors import StudyError
from dualcam.study import Controller, History, Plan, Scenario, Study, Vary, read_results
from dualcam.study.run.runner import Runner

refused = partial(refused_by, StudyError)
FORWARD, INVERSE = (model.fmu for model in models.values())
DESIGN = {
    "cam1.radius": Vary(0.015, 0.03),
    "cam2.lead_angle": Vary(0.55, 1.0),
    "cam1.friction": Vary(0.05, 0.2),
    "spring.stiffness": Vary(1e4, 8e4, log=True),
}
PUSH = Scenario(0.4, {"tau": History([0.0, 0.2, 0.2], [8.0, 8.0, 0.0])})
RESULTS = ["theta@0.2", "efficiency", "energy.work_in", "events", "theta", "peak.reaction1"]


def study(plan=None, scenario=PUSH, results=RESULTS, fmu=FORWARD, **more):
    return Study(fmu, plan or Plan("latin", DESIGN, runs=64), scenario, results, **more)


def runs_of(one, rows=None):
    runner = Runner(one.job())
    block = runner.run(one.plan.rows(0, one.plan.count) if rows is None else rows)
    runner.close()
    return block


def closed(make, stop=0.05, period=1e-3):
    return Scenario(stop, controller=Controller(make, period, ["theta", "omega"], ["tau"]))


class Stop(Exception):
    pass


def stop():
    raise Stop


def after(count, action):
    """To be called after each file; acts after that many."""
    numbers = itertools.count(1)
    return lambda: action() if next(numbers) == count else None


def cluster_of(**more):
    """A Dask cluster on this machine; without Dask the test is skipped."""
    distributed = pytest.importorskip("distributed", reason="dask.distributed is not installed")
    return distributed.LocalCluster(threads_per_worker=1, dashboard_address=None, **more)


def every_run_once(folder, one):
    table = read_results(folder)
    assert np.array_equal(table["run"], np.arange(one.plan.count))
    rows = np.column_stack([table[name] for name in one.plan.names])
    assert np.array_equal(rows, one.plan.rows(0, one.plan.count))
    return np.column_stack([table[name] for name in one.results])


def write_groove(folder):
    """The table that SOUND_PLAN names."""
    psi = np.linspace(0.0, 1.0, 41)
    Table(0.02, psi, 0.02 * psi).write(folder / "groove.csv")


# A plan without a mistake, in which tests put some; `format` gives the FMU, write_groove() the table.
SOUND_PLAN = """
fmu = "{fmu}"
results = ["theta@0.2", "efficiency", "top = max(theta, every=0.01)", "rest = 1 - top"]
[parameters]
"cam2.radius" = "21 mm"
"cam1.profile" = 3
"stop.upper" = 1.0
[plan]
kind = "latin"
runs = 100
seed = 3
[plan.vary]
peak = {{ distribution = "normal", mean = "8 N.m", std = 1.0, from = 5 }}
push = {{ from = "100 ms", to = "200 ms" }}
wire = {{ from = "1.9 mm", to = "2.1 mm" }}
coils = {{ values = [4, 5], weights = [1, 3] }}
"cam1.radius" = {{ from = "19 mm", to = "21 mm" }}
"spring.preload" = {{ distribution = "lognorm", arguments = {{ s = 0.5, scale = "60 N" }}, to = 200 }}
"cam1.friction" = {{ from = 0.1, to = 0.2 }}
"cam2.friction" = {{ from = 0.1, to = 0.2 }}
"cam2.lead_angle" = {{ from = "40 deg", to = "50 deg" }}
"cam1.friction_peak" = {{ from = 1.0, to = 1.2 }}
"cam2.friction_peak" = {{ same_as = "cam1.friction_peak" }}
"cam1.table" = {{ table = "groove.csv", deviation = "0.01 mm", correlation_length = "10 deg", count = 3 }}
[plan.derived]
"spring.stiffness" = "'79 GPa' * wire^4 / (8 * '20 mm'^3 * coils)"
[plan.constraints]
soft = "spring.stiffness < 5400"
[[plan.correlation]]
of = ["cam1.friction", "cam2.friction"]
rank = 0.8
[[plan.correlation]]
of = ["cam1.radius", "spring.preload"]
pearson = 0.3
[scenario]
stop = "400 ms"
tolerance = 1e-9
inputs.tau = {{ time = [0.0, "push", "push"], value = ["peak", "peak", 0.0] }}
inputs.F_ext = {{ time = [0.0, 0.1, 0.2], value = [0.0, 1.0, 0.0] }}
[[plots]]
kind = "pareto"
x = "efficiency"
y = "top"
"""

PLAN = """
fmu = "{fmu}"
results = ["efficiency", "theta"]
[plan]
kind = "indices"
runs = 64
[plan.vary]
"cam1.lead_angle" = {{ from = 0.6, to = 0.9 }}
"cam1.friction" = {{ from = 0.1, to = 0.2 }}
"cam2.friction" = {{ same_as = "cam1.friction" }}
[scenario]
stop = 0.1
inputs.tau = {{ time = [0.0, 0.05, 0.05], value = [8.0, 8.0, 0.0] }}
[[plots]]
kind = "sobol"
of = ["efficiency"]
[[plots]]
kind = "map"
x = "cam1.lead_angle"
y = "cam1.friction"
z = "efficiency"
[[plots]]
kind = "pareto"
x = "efficiency"
y = "theta"
[[plots]]
kind = "parallel"
axes = ["cam1.lead_angle", "cam1.friction", "efficiency"]
"""

SLOW_PLAN = """
fmu = "{fmu}"
results = ["efficiency", "theta"]
[plan]
kind = "latin"
runs = 256
[plan.vary]
"cam1.lead_angle" = {{ from = 0.6, to = 0.9 }}
"cam1.friction" = {{ from = 0.1, to = 0.2 }}
[scenario]
stop = 0.01
controller.create_law = "study_laws:brief"
controller.period = 0.01
controller.reads = ["theta"]
controller.writes = ["tau"]
"""
