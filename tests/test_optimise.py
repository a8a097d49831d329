"""Optimisation: optima, fronts and percentiles against closed forms and plain Monte Carlo; no interruption
may lose or repeat a design."""

import csv
import json
import math
import re
import sys
from contextlib import closing

import numpy as np
import pytest
from driver import ROOT
from scipy.integrate import quad
from scipy.stats import uniform
from study_cases import FORWARD, refused

from case_studies import optimised_designs
from dualcam.__main__ import main
from dualcam.checking import check_design
from dualcam.design_file import read_design
from dualcam.errors import DualcamError, StudyError
from dualcam.scenario.formula import formula
from dualcam.study import Deviation, FmuRuns, Optimisation, Scenario, Vary, optimise, read_optimisation
from dualcam.study.file import schema
from dualcam.study.optimisation.evaluation import DesignEvaluator, percentile
from dualcam.study.optimisation.evolution import hypervolume
from dualcam.study.optimisation.optimum import unbeaten
from dualcam.study.optimisation.record import BATCHES, Record
from dualcam.study.optimisation.run import facts
from dualcam.systems.machines import elbow, knee

REST = Scenario(1e-3)
ANGLES = {"cam1.lead_angle": Vary(0.3, 1.2), "cam2.lead_angle": Vary(0.3, 1.2)}
SAME = {"cam2.lead_angle": "cam1.lead_angle"}
MU, RADIUS, PRELOAD = 0.14, 0.02, 50.0
PHI = math.atan(MU)


def task(objectives, vary=ANGLES, parameters=None, **more):
    return Optimisation(FmuRuns(FORWARD, REST, parameters or {}), vary, objectives, **more)


# ---- closed forms ----


@pytest.mark.parametrize("method", ["slsqp", "evolution"])
def test_best_lead_angles_of_unequal_friction(method):
    """docs/mechanism.md, section 8: tan lambda_i = mu_i/mu_e, eta = ((1 - mu_e)/(1 + mu_e))^2."""
    mu, radius = (0.2, 0.08), (0.018, 0.025)
    parameters = {"cam1.friction": mu[0], "cam2.friction": mu[1]}
    parameters |= {"cam1.radius": radius[0], "cam2.radius": radius[1]}
    found = optimise(task({"efficiency": "maximise"}, parameters=parameters, method=method, budget=1200))
    effective = math.sqrt(
        (mu[0] / radius[0] + mu[1] / radius[1]) / (1 / (mu[0] * radius[0]) + 1 / (mu[1] * radius[1]))
    )
    exact = [math.atan(each / effective) for each in mu]
    assert list(found.design.values()) == pytest.approx(exact, abs=1e-5)
    assert found.objectives["efficiency"] == pytest.approx(
        ((1 - effective) / (1 + effective)) ** 2, rel=1e-10
    )
    assert found.feasible and not found.active and not found.violated


def test_objectives_take_the_named_results():
    """A result by its name is the formula that the result stands for."""
    one = {"cam1.lead_angle": Vary(0.3, 1.2)}
    results = ["twice = 2 * efficiency", "shown = max(twice, torque_load)"]
    best = optimise(task({"twice": "maximise"}, one, same_as=SAME, results=results, method="slsqp"))
    plain = optimise(task({"2 * efficiency": "maximise"}, one, same_as=SAME, method="slsqp"))
    assert best.design == plain.design
    lead = best.design["cam1.lead_angle"]
    assert best.results["twice"] == pytest.approx(2.0 * efficiency(lead), rel=1e-10)
    assert best.results["shown"] == pytest.approx(max(2.0 * efficiency(lead), loading(lead)), rel=1e-10)


def test_a_series_is_no_result_of_an_optimum():
    with refused("a series is not shown", "one value"):
        task({"efficiency": "maximise"}, results=["series(theta, every=0.001)"])


def loading(lead):
    """Torque of two equal helices at theta = 0 [N.m]: F r tan(lambda + phi)/2."""
    return PRELOAD * RADIUS * np.tan(lead + PHI) / 2.0


def efficiency(lead):
    return np.tan(lead - PHI) / np.tan(lead + PHI)


@pytest.mark.parametrize("method", ["slsqp", "evolution"])
def test_most_torque_with_an_efficiency_of_a_half(method):
    """efficiency = e where sin(2 lambda) = sin(2 phi) (1 + e)/(1 - e): of the two angles the larger one."""
    one = {"cam1.lead_angle": Vary(0.3, 1.2)}
    wanted = task(
        {"torque_load": "maximise"}, one, same_as=SAME, method=method, constraints={"efficiency": (0.5, None)}
    )
    found = optimise(wanted)
    lead = 0.5 * (math.pi - math.asin(math.sin(2.0 * PHI) * 1.5 / 0.5))
    assert found.design["cam1.lead_angle"] == pytest.approx(lead, abs=2e-6)
    assert found.design["cam2.lead_angle"] == found.design["cam1.lead_angle"]
    assert found.objectives["torque_load"] == pytest.approx(loading(lead), rel=5e-6)
    assert found.constraints["efficiency"] == pytest.approx(0.5, rel=1e-6)
    assert found.active == ["efficiency is at its least value, 0.5"]


def test_optimum_on_a_bound():
    bounds = {name: Vary(0.3, 0.7) for name in ANGLES}  # below pi/4, where the optimum is
    found = optimise(task({"efficiency": "maximise"}, bounds, method="slsqp"))
    assert list(found.design.values()) == [0.7, 0.7]
    assert found.objectives["efficiency"] == pytest.approx(efficiency(0.7), rel=1e-12)
    assert len(found.active) == 2 and "cam1.lead_angle is at its upper bound, 0.7 rad" in found.active


def test_values_to_choose_from_and_a_range_in_the_logarithm():
    vary = {
        "cam1.lead_angle": Vary(values=[0.5, 0.75, 1.0]),
        "spring.preload": Vary(1.0, 1000.0, log=True),
    }
    goal = "efficiency - abs(log(spring.preload / 40))"
    found = optimise(task({goal: "maximise"}, vary, same_as=SAME, budget=1000, seed=3))
    assert found.design["cam1.lead_angle"] == 0.75
    assert found.design["spring.preload"] == pytest.approx(40.0, rel=1e-3)


def test_front_of_efficiency_and_torque():
    """Equal angles are best. So the front is efficiency(lambda), loading(lambda) from 45 deg on."""
    wanted = {"efficiency": "maximise", "torque_load": "maximise"}
    found = optimise(task(wanted, {name: Vary(0.3, 1.2) for name in ANGLES}, budget=3000, population=60))
    eta, torque = found.front["efficiency"], found.front["torque_load"]
    leads = np.arctan(2.0 * torque / (PRELOAD * RADIUS)) - PHI  # of equal angles with these torques
    assert np.all(leads >= math.pi / 4 - 1e-3)
    assert np.all(eta <= efficiency(leads) + 1e-9)
    assert np.max(efficiency(leads) - eta) < 1e-3
    assert np.all(np.diff(eta) < 0.0) and np.all(np.diff(torque) > 0.0)
    low = efficiency(1.2), loading(math.pi / 4)
    exact = quad(lambda lead: (loading(lead) - low[1]) * -slope(efficiency, lead), math.pi / 4, 1.2)[0]
    size = [efficiency(math.pi / 4) - low[0], loading(1.2) - low[1]]
    losses = np.column_stack([(low[0] - eta) / size[0], (low[1] - torque) / size[1]])
    inside = losses[np.all(losses <= 0.0, axis=1)]
    assert 0.98 < hypervolume(inside, 0.0) / (exact / np.prod(size)) <= 1.0
    assert found.history[-1].tolist() == [found.evaluated, 1.0]


def slope(function, x, step=1e-6):
    return (function(x + step) - function(x - step)) / (2.0 * step)


def test_front_with_a_constraint_and_failed_designs():
    """Schaffer's problem: sqrt(f1) + sqrt(f2) = 2 between its ends; x >= 0.5, and nothing below -1."""
    wanted = {"f1": "minimise", "f2": "minimise"}
    found = optimise(
        Optimisation(schaffer, {"x": Vary(-3.0, 3.0)}, wanted, {"x": (0.5, None)}, budget=600, population=30)
    )
    f1, f2 = found.front["f1"], found.front["f2"]
    assert np.sqrt(f1) + np.sqrt(f2) == pytest.approx(2.0, abs=0.02)  # the last one may be beyond the end
    assert f1.min() >= 0.25 * (1.0 - 1e-5) and len(f1) > 30
    assert hypervolume(np.column_stack([f1, f2]), 4.0) == pytest.approx(schaffers_volume(), rel=5e-3)
    assert found.failed == sum(found.messages.values()) > 0
    assert list(found.messages) == ["x is below -1"]


def schaffers_volume():
    return quad(lambda f1: 4.0 - (2.0 - math.sqrt(f1)) ** 2, 0.25, 4.0)[0]


def schaffer(design):
    x = design["x"]
    if x < -1.0:
        raise DualcamError("x is below -1")
    return {"f1": x**2, "f2": (x - 2.0) ** 2}


def test_unbeaten_designs_are_those_of_all_pairs():
    losses = np.random.default_rng(2).integers(0, 12, (200, 3)).astype(float)
    kept = unbeaten(losses)
    for place, one in enumerate(losses):
        beaten = any(np.all(other <= one) and np.any(other < one) for other in losses)
        equal_before = any(np.array_equal(one, losses[k]) for k in kept if k != place)
        assert (place in kept) == (not beaten and not equal_before)


# ---- parts as made ----


def test_percentile_of_parts_is_that_of_plain_monte_carlo():
    """Efficiency falls with friction, so that 90 % of the parts are as good as the one with the friction that
    90 % stay below."""
    spread = Deviation(0.05, "uniform")
    one = task(
        {"efficiency": "maximise"},
        constraints={"torque_load": (None, 9.0)},
        tolerances={"cam1.friction": spread, "cam1.lead_angle": Deviation(0.02)},
        percentile=90.0,
        samples=4000,
    )
    evaluator = DesignEvaluator(one)
    batch = evaluator.evaluate(np.array([[0.5, 0.4]]))
    evaluator.close()
    random = np.random.default_rng(8)
    count = 20_000
    friction = MU + random.uniform(-0.05, 0.05, count)
    lead = 0.75 + 0.02 / 3.0 * np.clip(random.standard_normal(count), -3.0, 3.0)
    phi, other = np.arctan(friction), 0.66
    arms = [
        1.0 / (1.0 / np.tan(lead + way * phi) + 1.0 / np.tan(other + way * PHI)) * RADIUS
        for way in (1.0, -1.0)
    ]
    eta, torque = arms[1] / arms[0], PRELOAD * arms[0]
    assert batch.objectives[0, 0] == pytest.approx(np.percentile(eta, 10.0), abs=5e-4)
    assert batch.constraints[0, 0] == pytest.approx(np.percentile(torque, 90.0), rel=2e-3)
    designed = [1.0 / np.tan(0.75 + way * PHI) + 1.0 / np.tan(other + way * PHI) for way in (1.0, -1.0)]
    assert batch.results[0, 0] == pytest.approx(designed[0] / designed[1], rel=1e-12)


def test_percentile_is_numpys_and_counts_what_failed_as_worst():
    values = np.random.default_rng(1).random((3, 40))
    for level in (5.0, 50.0, 95.0, 99.9):
        assert np.allclose(percentile(values, level), np.percentile(values, level, axis=1), rtol=1e-14)
    values[0, :4] = np.nan  # a tenth
    assert percentile(values, 90.0)[0] == np.inf
    assert percentile(values, 80.0)[0] == np.percentile(np.where(np.isnan(values[0]), 9.0, values[0]), 80.0)


def test_deviations_are_those_of_the_distribution_and_common_to_all_designs():
    one = task(
        {"efficiency": "maximise"}, tolerances={"cam1.lead_angle": Deviation(0.02, "uniform")}, same_as={}
    )
    evaluator = DesignEvaluator(one)
    made = evaluator.made(np.array([[0.5, 0.6], [0.8, 0.9]]))
    evaluator.close()
    moved = made[:, 1:, 0] - made[:, :1, 0]
    assert np.allclose(moved[0], moved[1], atol=1e-15)
    strata = np.floor(uniform(-0.02, 0.04).cdf(moved[0]) * one.samples)
    assert sorted(strata) == list(range(one.samples))  # a Latin hypercube
    assert np.allclose(made[:, :, 1], np.broadcast_to([[0.84], [1.11]], made.shape[:2]))


def test_robust_optimum_keeps_a_distance_from_the_limit():
    """Ninety-five per cent of the parts have a lead angle below 0.6 + 0.05 of its 95 % point."""
    one = {"cam1.lead_angle": Vary(0.3, 1.2)}
    wanted = task(
        {"torque_load": "maximise"},
        one,
        same_as=SAME,
        method="slsqp",
        constraints={"cam1.lead_angle": (None, 0.6)},
        tolerances={"cam1.lead_angle": Deviation(0.05, "uniform")},
        samples=200,
    )
    found = optimise(wanted)
    assert found.design["cam1.lead_angle"] == pytest.approx(0.6 - 0.05 * 0.9, abs=5e-4)


def test_what_happens_by_chance_and_what_is_derived():
    """The torque is F0 r tan(lambda + phi)/2 of two equal cams with the friction of each part."""
    grease = Vary(distribution="uniform", arguments={"loc": 0.1, "scale": 0.1})
    same = SAME | {"cam2.friction": "cam1.friction"}
    model = FmuRuns(FORWARD, REST, {}, {"spring.preload": "100 * size"}, {"large enough": "size > 0.4"})
    vary = {"cam1.lead_angle": Vary(0.3, 1.2), "size": Vary(0.2, 2.0), "cam1.friction": grease}
    limits = {"torque_load": (None, 0.8), "spring.preload": (60.0, 60.0)}
    goals = {"torque_load": "maximise"}
    one = Optimisation(model, vary, goals, limits, same_as=same, percentile=90.0, samples=500, method="slsqp")
    found = optimise(one)
    assert found.design["size"] == pytest.approx(0.6, abs=1e-6)
    assert found.design["spring.preload"] == pytest.approx(60.0, abs=1e-4)
    assert "cam1.friction" not in found.design and "cam2.friction" not in found.design
    lead = math.atan(2.0 * 0.8 / (60.0 * RADIUS)) - math.atan(0.19)  # 90 % of the parts have less friction
    assert found.design["cam1.lead_angle"] == pytest.approx(lead, abs=1e-3)
    worst = 60.0 * RADIUS / 2.0 * math.tan(lead + math.atan(0.11))  # 90 % have more
    assert found.objectives["torque_load"] == pytest.approx(worst, rel=2e-3)
    exact = 60.0 * RADIUS / 2.0 * math.tan(found.design["cam1.lead_angle"] + math.atan(0.15))  # the median
    assert found.results["torque_load"] == pytest.approx(exact, rel=1e-6)
    assert list(found.messages) and all("large enough" in text for text in found.messages)


def test_texts_to_choose_from():
    """Groove tables of lead angles 0.5, pi/4 and 1: the middle one gives the best efficiency."""
    found = optimise(
        Optimisation(
            by_name, {"table": Vary(values=["flat", "middle", "steep"])}, {"eta": "maximise"}, budget=60
        )
    )
    assert found.design == {"table": "middle"} and found.evaluated <= 60
    assert set(found.designs["table"].tolist()) == {"flat", "middle", "steep"}


def by_name(design):
    return {"eta": float(efficiency({"flat": 0.5, "middle": math.pi / 4, "steep": 1.0}[design["table"]]))}


# ---- interruptions ----


class Stopped(Exception):
    pass


class Counted:
    """A function with a limit of calls: 0.5 |x|^2 + |y - 0.3|, not for x above 0.9."""

    def __init__(self, calls=None):
        self.designs, self.calls = [], calls

    __module__, __qualname__ = "models", "bowl"

    def __call__(self, design):
        if self.calls is not None and len(self.designs) >= self.calls:
            raise Stopped
        self.designs.append(tuple(design.values()))
        if design["x"] > 0.9:
            raise DualcamError("x is above 0.9")
        return {"bowl": 0.5 * design["x"] ** 2 + abs(design["y"] - 0.3), "tilt": design["x"] + design["y"]}


def bowl(function, method, budget=240):
    wanted = {"bowl": "minimise"} | ({"tilt": "maximise"} if method == "nsga2" else {})
    vary = {"x": Vary(-1.0, 1.0), "y": Vary(0.1, 10.0, log=True)}
    limits = {} if method == "nsga2" else {"tilt": (0.4, None)}
    return Optimisation(function, vary, wanted, limits, method=method, budget=budget, population=20, seed=5)


def assert_same(one, other):
    assert one.design == other.design and one.results == other.results
    assert one.evaluated == other.evaluated and one.messages == other.messages
    assert np.array_equal(one.history, other.history)
    for name, column in one.designs.items():
        assert np.array_equal(column, other.designs[name], equal_nan=name != "message")


@pytest.mark.parametrize("method", ["slsqp", "evolution", "nsga2"])
def test_a_search_that_was_interrupted_ends_as_one_that_was_not(method, tmp_path):
    whole = Counted()
    expected = optimise(bowl(whole, method), tmp_path / "whole")
    assert len(set(whole.designs)) == len(whole.designs) == expected.evaluated <= 240
    parts = [Counted(calls) for calls in (0, 37, 80, None)]
    for part in parts[:-1]:
        with pytest.raises(Stopped):
            optimise(bowl(part, method), tmp_path / "parts")
    last = optimise(bowl(parts[-1], method), tmp_path / "parts")
    assert_same(last, expected)
    assert (tmp_path / "parts" / BATCHES).read_bytes() == (tmp_path / "whole" / BATCHES).read_bytes()
    nothing = Counted(0)
    assert_same(optimise(bowl(nothing, method), tmp_path / "parts"), expected)


def test_a_line_that_was_cut_is_evaluated_again(tmp_path):
    expected = optimise(bowl(Counted(), "evolution"), tmp_path)
    path = tmp_path / BATCHES
    content = path.read_bytes()
    path.write_bytes(content[: 2 * len(content) // 3])
    assert_same(optimise(bowl(Counted(), "evolution"), tmp_path), expected)
    assert path.read_bytes() == content


def test_another_search_in_the_folder_is_refused(tmp_path):
    optimise(bowl(Counted(), "slsqp", budget=30), tmp_path)
    with refused("holds another search", "other budget"):
        optimise(bowl(Counted(), "slsqp", budget=40), tmp_path)
    with pytest.raises(
        StudyError, match=r"^[^:]* holds another search \(other method\): give another folder"
    ):
        optimise(bowl(Counted(), "evolution", budget=30), tmp_path)


def test_one_search_at_a_time_in_a_folder(tmp_path):
    task = bowl(Counted(), "slsqp", budget=30)
    with closing(Record(tmp_path, facts(task), {})), refused("another process is searching in"):
        optimise(task, tmp_path)
    assert optimise(task, tmp_path).evaluated == 30


def test_the_seed_decides():
    one, two = (optimise(bowl(Counted(), "evolution")) for _ in range(2))
    assert_same(one, two)


def test_processes_find_the_same():
    expected = optimise(Optimisation(schaffer, {"x": Vary(-3.0, 3.0)}, {"f1 + f2": "minimise"}, budget=60))
    found = optimise(
        Optimisation(schaffer, {"x": Vary(-3.0, 3.0)}, {"f1 + f2": "minimise"}, budget=60), workers=2
    )
    assert_same(found, expected)
    assert found.design["x"] == pytest.approx(1.0, abs=1e-6)


# ---- what cannot be ----


def test_all_mistakes_at_once():
    mistakes = (
        "budget = 0: allowed is a whole number, 1 or more",
        "percentile = 100: allowed is between 0 and 100 %",
        "method slsqp has one objective, here are 2",
        "cam1.lead_angle: from 1.2 to 0.3",
        "constraint torque_load from 2 to 1: the first must not be above the second",
        "efficiency = 'more': allowed are minimise, maximise",
        "is no formula",
        "start: cam2.radius is not designed",
        "tolerances: cam1.friction: plus_minus = -1",
    )
    with refused(*mistakes):
        task(
            {"efficiency": "more", "theta +": "minimise"},
            {"cam1.lead_angle": Vary(1.2, 0.3)},
            constraints={"torque_load": (2.0, 1.0)},
            method="slsqp",
            budget=0,
            percentile=100.0,
            start={"cam2.radius": 0.02},
            tolerances={"cam1.friction": Deviation(-1.0)},
        )
    with refused("there is no objective", "nothing is designed"):
        task({}, {})


def test_unknown_results():
    with pytest.raises(DualcamError, match="efficency"):
        optimise(task({"efficency": "maximise"}))
    with refused("the model gives no f3: allowed are f1, f2"):
        optimise(Optimisation(schaffer, {"x": Vary(0.0, 1.0)}, {"f3": "minimise"}))


@pytest.mark.parametrize("method", ["slsqp", "evolution"])
def test_constraints_that_no_design_keeps(method):
    bounds = {name: Vary(0.3, 0.7) for name in ANGLES}
    found = optimise(
        task(
            {"torque_load": "maximise"},
            bounds,
            method=method,
            budget=400,
            constraints={"efficiency": (0.6, None)},
        )
    )
    assert not found.feasible and found.infeasible == found.evaluated
    assert list(found.design.values()) == pytest.approx([0.7, 0.7], abs=1e-3)  # the nearest one
    reached = found.constraints["efficiency"]
    assert reached == pytest.approx(efficiency(0.7), rel=1e-4)
    assert found.violated == [
        f"efficiency = {reached:.6g}: allowed is at least 0.6, which it misses by {0.6 - reached:.3g}"
    ]


def test_designs_that_the_fmu_refuses_are_counted():
    """The mechanism jams where the lead angle is above 90 deg less the angle of friction: a sixth of the
    bounds."""
    wide = {"cam1.lead_angle": Vary(0.7, 1.57)}
    found = optimise(
        task({"efficiency": "maximise"}, wide, same_as=SAME, budget=400, start={"cam1.lead_angle": 1.0})
    )
    assert found.failed >= 3 and found.failed == sum(found.messages.values())
    assert all("kappa" in text for text in found.messages)
    assert found.design["cam1.lead_angle"] == pytest.approx(math.pi / 4, abs=1e-4)


def test_no_design_can_be_evaluated():
    with refused("none of 20 designs could be evaluated", "x is below -1"):
        optimise(
            Optimisation(schaffer, {"x": Vary(-3.0, -2.0)}, {"f1": "minimise"}, budget=40, method="evolution")
        )


def test_pymoo_is_named_where_it_lacks(monkeypatch):
    monkeypatch.setitem(sys.modules, "pymoo.algorithms.moo.nsga2", None)
    with refused("several objectives need pymoo", r"dualcam\[optimise\]"):
        optimise(Optimisation(schaffer, {"x": Vary(0.0, 1.0)}, {"f1": "minimise", "f2": "minimise"}))


@pytest.mark.parametrize("text", ["", "1 +", "a b", "f x", "x = 1"])
def test_no_formulas(text):
    with refused("no formula"):
        formula(text)


def test_formula_has_the_fields_names_and_rules():
    heat = formula("2 * energy.heat_cam1@0.5 ^ 2 - max(theta@1e-3, pi, `der(h) x`)")
    assert heat.names == ("energy.heat_cam1@0.5", "theta@1e-3", "der(h) x")
    values = {
        name: np.array(numbers)
        for name, numbers in zip(heat.names, ([1.0, 3.0], [9.0, 0.0], [0.0, 4.0]), strict=True)
    }
    assert heat(values).tolist() == [2.0 - 9.0, 18.0 - 4.0]


# ---- files ----

PLAN = """
fmu = "forward"
results = ["torque_release"]
[parameters]
"spring.preload" = "60 N"
[plan.vary]
"cam1.lead_angle" = {from = "20 deg", to = "70 deg"}
"cam2.lead_angle" = {same_as = "cam1.lead_angle"}
[scenario]
stop = 0.001
inputs.tau = {time = [0.0, 0.001], value = [0.0, 1.0]}
[optimise]
objectives.torque_load = "maximise"
constraints.efficiency = {from = 0.5}
method = "slsqp"
start."cam1.lead_angle" = "30 deg"
"""


def test_a_plan_by_the_command_line(tmp_path, capsys):
    path = tmp_path / "torque.toml"
    path.write_text(PLAN)
    out = tmp_path / "out"
    assert main(["study", str(path), "--out", str(out)]) == 0
    text = capsys.readouterr().out
    assert "efficiency is at its least value, 0.5" in text and "designs evaluated" in text
    degrees = float(re.search(r"cam2.lead_angle = ([\d.]+) deg\n", text)[1])  # the unit of the file
    assert re.search(r"torque_load = [\d.]+ N.m \(maximise\)", text)
    folder = out / "torque"
    lead = 0.5 * (math.pi - math.asin(math.sin(2.0 * PHI) * 1.5 / 0.5))
    best = read_design(folder / "best.toml")
    assert best.parameters["cam1.lead_angle"] == pytest.approx(lead, abs=2e-6)
    assert math.radians(degrees) == pytest.approx(lead, abs=4e-6)
    assert best.parameters["cam1.lead_angle"] == best.parameters["cam2.lead_angle"]
    assert best.parameters["spring.preload"] == 60.0
    assert best.scenario.stop == 0.001
    page = (folder / "optimum.html").read_text(encoding="utf-8")
    for words in (
        "The best design keeps all constraints",
        "torque_release",
        "deg",
        "dualcam check best.toml",
    ):
        assert words in page
    assert main(["check", str(folder / "best.toml")]) == 0
    rows = (folder / "designs.csv").read_text().splitlines()
    facts = json.loads((folder / "optimisation.json").read_text())
    assert rows[0].startswith("cam1.lead_angle,cam2.lead_angle,torque_load,efficiency,torque_release")
    assert facts["task"]["method"] == "slsqp" and "scipy" in facts["versions"]


def test_a_design_file_with_an_optimisation(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(
        """
[cam1]
lead_angle = "40 deg"
friction = 0.1
[scenario]
stop = 0.001
[study.plan.vary]
"cam1.lead_angle" = {from = "20 deg", to = "70 deg"}
"cam2.lead_angle" = {from = "20 deg", to = "70 deg"}
[study.optimise]
objectives = {efficiency = "maximise", torque_load = "maximise"}
constraints.torque_load = {to = "0.9 N.m"}
tolerances."cam1.friction" = {plus_minus = 0.02, shape = "uniform"}
tolerances."cam1.lead_angle" = {plus_minus = "1 deg"}
samples = 16
"""
    )
    one = read_optimisation(path)
    assert one.method_used == "nsga2"
    assert one.tolerances["cam1.lead_angle"].plus_minus == pytest.approx(math.radians(1.0))
    assert one.constraints == {"torque_load": (None, 0.9)}
    evaluator = DesignEvaluator(one)
    begins = evaluator.design(evaluator.start())
    evaluator.close()
    assert begins["cam1.lead_angle"] == pytest.approx(math.radians(40.0))


def test_the_best_design_keeps_the_sections_of_its_design_file(tmp_path, capsys):
    """All but [study], the path of a table absolute: so `dualcam check` judges the optimum as it judges the
    start. The mass is free under an efficiency of slow motion. The spring wire is too weak."""
    folder = tmp_path / "designs"
    folder.mkdir()
    (folder / "friction.csv").write_text("v_m_s,mu\n0,0.12\n0.1,0.1\n1,0.1\n")
    path = folder / "my.toml"
    path.write_text(
        """
title = 'A "best" spring'
[cam1]
radius = "20 mm"
lead_angle = "40 deg"
friction_table = "friction.csv"
[spring]
preload = "100 N"
free_length = "60 mm"
solid_length = "31 mm"
[helical_spring]
wire_diameter = "2 mm"
coil_diameter = "30 mm"
active_coils = 4.5
grade = "DH"
[pin]
radius = "3 mm"
width = "8 mm"
[limits]
lead_angle = ["10 deg", "70 deg"]
pressure = "1200 MPa"
[scenario]
stop = 0.001
output_interval = 1e-4
inputs.F_ext = 2.0
[study.plan.vary]
"cam1.lead_angle" = {from = "20 deg", to = "70 deg"}
"cam2.lead_angle" = {same_as = "cam1.lead_angle"}
"inertia.follower_mass" = {from = "0.1 kg", to = "1 kg"}
[study.optimise]
objectives.efficiency = "maximise"
method = "slsqp"
"""
    )
    assert main(["study", str(path), "--out", str(tmp_path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    file = tmp_path / "my/best.toml"
    start, best = read_design(path), read_design(file)
    for section in ("pin", "helical_spring", "spring_limits", "limits", "output_interval", "title"):
        assert getattr(best, section) == getattr(start, section) is not None, section
    assert best.scenario.inputs["F_ext"].value == (2.0,)
    assert best.study is None
    kept = {name: value for name, value in start.parameters.items() if name != "cam1.lead_angle"}
    assert {name: best.parameters[name] for name in kept} == kept
    assert best.parameters["cam1.friction_table"] == str(folder / "friction.csv")
    assert set(best.parameters) - set(kept) == {"cam1.lead_angle", "cam2.lead_angle", "inertia.follower_mass"}
    assert "inertia.follower_mass has no influence on the goal" in said
    assert "inertia.follower_mass has no influence on the goal" in file.read_text(encoding="utf-8")
    assert "cam1.lead_angle has no influence" not in said
    refused = {error.kind for error in check_design(file).errors}
    assert refused == {error.kind for error in check_design(path).errors} != set()
    assert "best.toml: `dualcam check` refuses this design: " in said


def test_what_does_not_influence_the_goal_is_named_and_holds_nothing_back():
    """The lead angle and the spring decide the torque at rest, the inertia does not."""
    vary = {
        "cam1.lead_angle": Vary(0.4, 1.2),
        "spring.preload": Vary(50.0, 150.0),
        "inertia.shaft": Vary(0.1, 1.0),
    }
    goal, limit = {"torque_load": "maximise"}, {"efficiency": (0.5, None)}
    found = optimise(Optimisation(FmuRuns("forward", Scenario(0.001)), vary, goal, limit, "slsqp"))
    assert found.without_influence == ["inertia.shaft"]
    assert not any(text.startswith("inertia.shaft") for text in found.holding)
    words = "inertia.shaft has no influence on the goal; any value that keeps the constraints is as good"
    assert found.idle_words() == [words]


def test_the_page_names_every_key():
    shown = set(re.findall(r"^\| `([\w.]+)` \|", (ROOT / "docs/use-optimise.md").read_text(), re.MULTILINE))
    keys = set(schema.OPTIMISE.model_fields)
    keys |= {f"constraints.NAME.{key}" for key in schema.GOAL_LIMITS.model_fields}
    assert keys | {f"tolerances.NAME.{key}" for key in schema.TOLERANCE.model_fields} <= shown


def test_all_mistakes_of_a_stage_of_a_file_at_once(tmp_path):
    path = tmp_path / "wrong.toml"
    fmu = PLAN.replace("torque_release", "torque_releas").replace("spring.preload", "spring.prelod")
    values = fmu.replace('"20 deg"', '"80 deg"').replace('"slsqp"', '"slspq"')
    schema = values.replace("from = 0.5", "form = 0.5").replace('"slspq"', '"slspq"\nbudgets = 1')
    for text, told in (
        (fmu, ["no variable 'torque_releas'", "spring.prelod"]),
        (values, ["plan: cam1.lead_angle: from 1.39626 to 1.22173", "optimise: method = 'slspq'"]),
        (schema, ["optimise has budgets: did you mean budget", "efficiency has form: did you mean from"]),
    ):
        path.write_text(text)
        with refused("2 mistakes", *told):
            read_optimisation(path)


def test_two_workers_find_the_same_by_the_command_line(tmp_path):
    path = tmp_path / "torque.toml"
    path.write_text(PLAN)
    for workers in ("0", "2"):
        assert main(["study", str(path), "--out", str(tmp_path / workers), "--workers", workers]) == 0
    one, two = ((tmp_path / workers / "torque" / BATCHES).read_bytes() for workers in ("0", "2"))
    assert one == two


@pytest.mark.parametrize("shape", ["linear", "sine"])
def test_the_best_design_of_a_scenario_with_formulas(tmp_path, shape):
    """A design file has the numbers of this design; a sine is left out."""
    points = {
        "linear": 'time = [0.0, "rise"], value = [0.1, 0.5]',
        "sine": "mean = 0.3, amplitude = 0.1, frequency = 1.0",
    }
    text = PLAN.replace('"forward"', '"inverse"').replace("0.001\n", "'2 * rise'\n")
    text = text.replace("[optimise]", "[optimise]\nbudget = 20")
    text = re.sub("inputs.tau = .*", f'inputs.theta = {{{points[shape]}, shape = "{shape}"}}', text)
    path = tmp_path / "rising.toml"
    path.write_text(text.replace("[plan.vary]", '[plan.vary]\nrise = {from = 0.2, to = 0.4, unit = "s"}'))
    assert main(["study", str(path), "--out", str(tmp_path)]) == 0
    best = read_design(tmp_path / "rising/best.toml")
    assert best.parameters["cam1.lead_angle"] == best.parameters["cam2.lead_angle"]
    assert (best.scenario is None) == (shape == "sine")
    if best.scenario is not None:
        assert best.model == "inverse"
        assert best.scenario.stop == 2.0 * best.scenario.inputs["theta"].time[1]


def test_a_plan_with_mistakes(tmp_path, capsys):
    path = tmp_path / "wrong.toml"
    path.write_text(PLAN.replace("from = 0.5", "form = 0.5"))
    assert main(["study", str(path), "--out", str(tmp_path / "out")]) == 1
    assert "optimise: constraint efficiency has form: did you mean from" in " ".join(
        capsys.readouterr().err.split()
    )


def test_a_plan_whose_constraints_no_design_keeps(tmp_path, capsys):
    path = tmp_path / "far.toml"
    path.write_text(PLAN.replace("from = 0.5", "from = 0.9"))
    assert main(["study", str(path), "--out", str(tmp_path / "out")]) == 1
    text = " ".join(capsys.readouterr().err.split())
    assert "designs keeps all constraints" in text and "which it misses by 0.33" in text
    assert "None of" in (tmp_path / "out/far/optimum.html").read_text(encoding="utf-8")


# ---- the case study ----


def case_study():
    with (ROOT / "case_studies/optimised_designs.csv").open(newline="") as file:
        return {
            (row["system"], row["design"], row["quantity"]): float(row["value"])
            for row in csv.DictReader(file)
        }


def test_numbers_of_the_page_are_those_of_the_script():
    found, page = case_study(), (ROOT / "docs/use-optimise.md").read_text(encoding="utf-8")
    lines = {
        "first subject": "heat, first subject",
        "first subject, 95 % of the parts": "heat of 95 % of the parts, first subject",
        "second subject, not used in the search": "heat, second subject",
    }
    for words, quantity in lines.items():
        values = (found["knee", design, quantity] for design in ("hand-made", "optimum", "robust optimum"))
        assert f"| {words} | {' | '.join(f'{value:.2f} J' for value in values)} |" in page
    for words, quantity in {
        "1.5 kg": "heat_1.5kg",
        "without payload": "heat_0kg",
        "3 kg": "heat_3kg",
    }.items():
        values = (found["elbow", design, quantity] for design in ("hand-made", "optimum"))
        assert f"| {words} | {' | '.join(f'{value:.2f} J' for value in values)} |" in page


@pytest.mark.parametrize("design", ["hand-made", "optimum", "robust optimum"])
def test_designs_of_the_script_give_their_heat(design):
    """Values are kept to six digits."""
    found = case_study()
    values = {name: found["knee", design, name] for name in optimised_designs.KNEE}
    heat = optimised_designs.knee_of(values)
    assert heat["heat"] == pytest.approx(found["knee", design, "heat, first subject"], rel=1e-3)


def test_hand_made_designs_are_those_of_the_systems():
    """The parameters of the case study make the cams of the examples."""
    values = optimised_designs.hand_made_knee()
    cam, same = knee.design_cam(), knee.elliptical_cam(*values.values(), knee.FRICTION)
    for name, value in cam.parameters().items():
        assert same.parameters()[name] == pytest.approx(value, rel=1e-12)
    assert list(optimised_designs.hand_made_elbow().values())[2:] == [
        elbow.design_cam().preload,
        elbow.design_cam().stiffness,
    ]
