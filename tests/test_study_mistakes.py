"""Mistakes in distributions and in plans from Python: each is told with key, value, what is allowed and what
works. Mistakes in plan files: test_study_ten_mistakes.py."""

import re

import numpy as np
import pytest
from scipy.stats import norm
from study_cases import FORWARD, SOUND_PLAN, refused, study, write_groove

from dualcam.errors import StudyError
from dualcam.study import Correlation, History, Plan, Scenario, Vary, read_study


def told(path):
    with pytest.raises(StudyError) as caught:
        read_study(path)
    return caught.value


def test_a_study_of_a_design_may_have_its_own_scenario(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text("""
[cam1]
radius = "25 mm"
[scenario]
stop = 0.1
[study]
results = ["theta"]
plan = {kind = "grid", vary.peak = {values = ["3 N.m", 8]}}
scenario = {stop = 0.2, inputs.tau = "peak"}
""")
    one = read_study(path)
    assert one.scenario.stop == 0.2 and one.parameters["cam1.radius"] == 0.025
    assert one.plan.rows(0, 2).tolist() == [[3.0], [8.0]]


# ---- shares ----


@pytest.mark.parametrize("mean, std, low", [(0.1, 0.1, ""), (0.05, 0.03, ""), (0.1, 0.1, "-0.05")])
def test_a_distribution_outside_of_the_range_says_which_share(tmp_path, mean, std, low):
    """By the normal distribution's function: the FMU allows 0 to 10."""
    path = tmp_path / "plan.toml"
    write_groove(tmp_path)
    cut = f", from = {low}" if low else ""
    text = SOUND_PLAN.replace(
        '"cam1.friction" = {{ from = 0.1, to = 0.2 }}',
        f'"cam1.friction" = {{{{ distribution = "normal", mean = {mean}, std = {std}{cut} }}}}',
    )
    path.write_text(text.format(fmu=FORWARD))
    below = norm(mean, std).cdf(0.0)
    least = norm(mean, std).cdf(float(low)) if low else 0.0
    share = 100.0 * (below - least) / (1.0 - least)
    error = told(path)
    assert f"{share:.3g} % of the runs would be refused: the FMU allows 0 to 10" in str(error)
    assert "give from = 0" in str(error)
    path.write_text(path.read_text().replace(f"std = {std}{cut}", f"std = {std}, from = 0.0"))
    assert read_study(path).plan.limits()["cam1.friction"][0] == 0.0


def test_a_tail_that_no_run_reaches_is_allowed():
    """Below 0 by 7 standard deviations: 1e-12 of the runs."""
    usual = Vary(distribution="normal", arguments={"mean": 0.14, "std": 0.02})
    one = study(Plan("latin", {"cam1.friction": usual}, runs=100))
    assert one.plan.share_outside("cam1.friction", 0.0, 10.0) == pytest.approx(norm.cdf(-7.0), rel=1e-9)
    from dualcam.study.run.first_runs import check

    check(one.job(), one.plan).close()


# ---- plans from Python ----


@pytest.mark.parametrize("wrong, mentions", [
    (lambda: Vary(0.1, 0.2, arguments={"mean": 1.0}), ["mean without distribution"]),
    (lambda: Vary(0.1, 0.2, log=True, distribution="norm", arguments={"loc": 0, "scale": 1}), ["log"]),
    (lambda: Vary(values=(1, 2), distribution="norm"), ["values and distribution norm"]),
    (lambda: Vary(values=(1, 2), weights=(1,)), ["1 weights of 2 values"]),
    (lambda: Vary(values=(1, 2), weights=(0, 0)), ["weights = [0.0, 0.0]", "not all 0"]),
    (lambda: Vary(0.1, 0.2, weights=(1, 2)), ["weights without values"]),
    (lambda: Vary(distribution="beta", arguments={"a": 1, "c": 2}), ["no argument c", "a, b, loc"]),
    (lambda: Vary(distribution="beta", arguments={"a": 1, "b": float("nan")}), ["b = nan", "finite"]),
    (lambda: Vary(distribution="normal", arguments={"mean": 1, "std": 0}), ["std = 0"]),
])  # fmt: skip
def test_values_that_make_no_sense(wrong, mentions):
    with refused("plan: a: ", *(re.escape(word) for word in mentions)):
        Plan("latin", {"a": wrong()}, runs=4)


def test_a_plan_from_python_tells_all_mistakes():
    with pytest.raises(StudyError) as caught:
        Plan(
            "hexagon", {"a": Vary(2.0, 1.0), "b": Vary(1.0, 2.0)}, runs=4, seed=-1, same_as={"b": "c"},
            derived={"d": "a + x"}, constraints={"e": "a <"}, on_violation="leave",
        )  # fmt: skip
    assert len(caught.value.problems) == 7
    with pytest.raises(StudyError) as caught:
        Scenario(-1.0, {"tau": History([1.0, 0.0], [0.0, 1.0]), "F_ext": History([0], ["1 +"])}, step=0.0)
    assert len(caught.value.problems) == 4


def test_morris_and_unbounded_distributions():
    vary = {"a": Vary(distribution="normal", arguments={"mean": 1.0, "std": 0.1})}
    with refused("a: Morris takes both ends", "give from and to"):
        Plan("morris", vary, runs=4)
    cut = {"a": Vary(0.5, 1.5, distribution="normal", arguments={"mean": 1.0, "std": 0.1})}
    assert np.ptp(Plan("morris", cut, runs=4).rows(0, 8)) > 0.1


@pytest.mark.parametrize("runs, kind, mentions", [
    (60, "fast", ["runs = 60", "at least 65"]),
    (100, "saltelli", ["runs = 100", "power of 2"]),
])  # fmt: skip
def test_arrangements_of_wrong_size(runs, kind, mentions):
    with refused(*mentions):
        Plan(kind, {"a": Vary(0.0, 1.0)}, runs)


@pytest.mark.parametrize("kind", ["random", "latin", "sobol", "indices", "saltelli", "morris", "fast"])
def test_a_plan_too_large_to_be_drawn_is_refused_before_it_takes_memory(kind):
    """Found by `./build.sh run fuzz`: a plan of 168,741,473 runs took all memory of the machine."""
    runs = 2**27
    with refused(f"runs = {runs}", "allowed are 100,000,000", "a grid needs no table") as caught:
        Plan(kind, {"a": Vary(0.0, 1.0), "b": Vary(0.0, 1.0)}, runs)
    allowed = int(re.search(r"here up to runs = (\d+)", str(caught.value))[1])
    assert 1 < allowed < runs


def test_a_correlation_that_cannot_be():
    vary = {"a": Vary(0.0, 1.0), "t": Vary(values=("x", "y"))}
    for pair, mentions in (
        (("a", "t"), ["t varies over texts"]),
        (("a", "a"), ["a with itself"]),
        (("a", "z"), ["z does not vary"]),
    ):
        with refused(*mentions):
            Plan("latin", vary, 4, correlations=[Correlation(*pair, 0.5)])
    with refused("twice"):
        both = [Correlation("a", "b", 0.5), Correlation("b", "a", 0.4)]
        Plan("latin", {"a": Vary(0.0, 1.0), "b": Vary(0.0, 1.0)}, 4, correlations=both)


@pytest.mark.parametrize("wrong, mentions", [
    ({"cam1.table": Vary(0.0, 1.0)}, ["cam1.table is a String", "values"]),
    ({"cam1.radius": Vary(values=("a", "b"))}, ["cam1.radius is Real", "given are texts"]),
    ({"contacts": Vary(distribution="normal", arguments={"mean": 1.5, "std": 0.1}, low=1.1, high=1.9)},
     ["contacts is Integer", "whole"]),
    ({"gain": Vary(1.0, 2.0)}, ["gain is no variable of the FMU, and no formula uses gain"]),
])  # fmt: skip
def test_values_that_the_fmu_does_not_take(tmp_path, wrong, mentions):
    with refused(*mentions):
        study(Plan("latin", wrong, runs=4)).run(tmp_path, workers=0)


def test_whole_numbers_of_a_distribution_are_allowed(tmp_path):
    vary = Vary(1, 2, distribution="randint", arguments={"low": 1, "high": 3})
    table = study(Plan("latin", {"contacts": vary}, runs=64), results=["contacts"]).run(tmp_path, workers=0)
    assert sorted(set(table["contacts"])) == [1.0, 2.0] and set(table["message"]) == {""}
