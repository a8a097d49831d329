"""Values of the runs: distributions against scipy.stats, correlations within their sampling error,
arrangements against SciPy and SALib, formulas and constraints against the same written in Python."""

import math

import numpy as np
import pytest
from scipy import stats
from study_cases import refused, runs_of, study

from dualcam.scenario.formula import Formula, is_formula
from dualcam.study import Correlation, Plan, Scenario, Vary
from dualcam.study.plan.correlation import Copula
from dualcam.study.plan.distribution import Distribution, names
from dualcam.study.plan.profiles import RandomProfiles

LEAST_P = 1e-3  # of a test of Kolmogorov and Smirnov with a fixed seed
SHARES = np.linspace(0.001, 0.999, 199)

# ---- distributions ----

KINDS = {
    "normal": ({"mean": 0.14, "std": 0.02}, stats.norm(0.14, 0.02)),
    "norm": ({"loc": 2.0, "scale": 3.0}, stats.norm(2.0, 3.0)),
    "lognorm": ({"s": 0.3, "scale": 5.0}, stats.lognorm(0.3, scale=5.0)),
    "weibull_min": ({"c": 1.7, "loc": 1.0, "scale": 2.0}, stats.weibull_min(1.7, 1.0, 2.0)),
    "beta": ({"a": 2.0, "b": 5.0}, stats.beta(2.0, 5.0)),
    "triang": ({"c": 0.3, "loc": -1.0, "scale": 4.0}, stats.triang(0.3, -1.0, 4.0)),
    "t": ({"df": 4.0}, stats.t(4.0)),
    "expon": ({"scale": 2.0}, stats.expon(scale=2.0)),
    "poisson": ({"mu": 6.0}, stats.poisson(6.0)),
}


@pytest.mark.parametrize("name", KINDS)
def test_values_are_scipys_quantiles(name):
    arguments, exact = KINDS[name]
    assert np.allclose(Distribution(name, arguments).at(SHARES), exact.ppf(SHARES), rtol=1e-12)
    assert Vary(distribution=name, arguments=arguments).limits() == tuple(exact.support())


@pytest.mark.parametrize("kind", ["random", "latin", "sobol"])
def test_samples_are_of_their_distribution(kind):
    """The test of Kolmogorov and Smirnov, of each distribution, whole and truncated."""
    vary = {name: Vary(distribution=name, arguments=a) for name, (a, _) in KINDS.items() if name != "poisson"}
    vary["cut"] = Vary(0.1, 0.17, distribution="normal", arguments={"mean": 0.14, "std": 0.02})
    plan = Plan(kind, vary, runs=2048, seed=4)
    exact = [KINDS[name][1] for name in vary if name != "cut"]
    exact.append(stats.truncnorm(-2.0, 1.5, 0.14, 0.02))
    for column, each in zip(plan.rows(0, plan.count).T, exact, strict=True):
        assert stats.kstest(column, each.cdf).pvalue > LEAST_P


@pytest.mark.parametrize("low, high", [(6.0, 9.0), (-9.0, -6.0), (8.0, math.nan), (-0.5, 3.0)])
def test_a_truncated_tail_is_exact(low, high):
    """By the quantiles of scipy.stats.truncnorm; far out, where the share of the whole is 1e-9."""
    ends = (-math.inf if math.isnan(low) else low, math.inf if math.isnan(high) else high)
    found = Distribution("norm", {"loc": 0.0, "scale": 1.0}, low, high)
    exact = stats.truncnorm(*ends)
    assert np.allclose(found.at(SHARES), exact.ppf(SHARES), rtol=1e-9)
    for value in (-1.0, 0.0, 6.5, 8.5):
        assert found.share_below(value) == pytest.approx(exact.cdf(value), rel=1e-9, abs=1e-15)
        assert found.share_above(value) == pytest.approx(exact.sf(value), rel=1e-9, abs=1e-15)


def test_a_truncated_count_has_the_probabilities_of_the_whole_in_proportion():
    cut = Distribution("poisson", {"mu": 3.0}, 2.0, 5.0)
    shares = (np.arange(200_000) + 0.5) / 200_000
    values, counts = np.unique(cut.at(shares), return_counts=True)
    exact = stats.poisson(3.0).pmf([2, 3, 4, 5])
    assert values.tolist() == [2.0, 3.0, 4.0, 5.0]
    assert np.allclose(counts / 200_000, exact / exact.sum(), atol=1e-5)
    assert cut.is_whole


def test_weights_are_shares():
    plan = Plan("sobol", {"a": Vary(values=(1.0, 5.0, 7.0), weights=(1, 0, 3))}, runs=1024)
    values, counts = np.unique(plan.rows(0, 1024), return_counts=True)
    assert values.tolist() == [1.0, 7.0] and counts.tolist() == [256, 768]


def test_a_grid_of_a_distribution_has_the_middles_of_equal_probability():
    plan = Plan("grid", {"a": Vary(distribution="norm", arguments={"loc": 0, "scale": 1}, count=5)})
    assert np.allclose(plan.rows(0, 5)[:, 0], stats.norm.ppf([0.1, 0.3, 0.5, 0.7, 0.9]), rtol=1e-12)


def test_most_distributions_of_scipy_are_known():
    assert {"norm", "weibull_min", "genextreme", "binom", "normal"} <= set(names())
    assert len(names()) > 100


@pytest.mark.parametrize("vary, least, most, share", [
    (Vary(0.0, 2.0), 0.5, 1.0, 0.75),
    (Vary(1.0, 100.0, log=True), 10.0, math.inf, 0.5),
    (Vary(values=(1, 2, 3, 4)), 2.0, 3.0, 0.5),
    (Vary(values=(1, 2), weights=(1, 9)), 1.5, 3.0, 0.1),
    (Vary(distribution="normal", arguments={"mean": 0.1, "std": 0.1}), 0.0, math.inf, stats.norm.cdf(-1.0)),
    (Vary(distribution="poisson", arguments={"mu": 2.0}), 1.0, 3.0,
     1.0 - stats.poisson.pmf([1, 2, 3], 2.0).sum()),
])  # fmt: skip
def test_the_share_outside_of_a_range(vary, least, most, share):
    assert vary.share_outside(least, most) == pytest.approx(share, rel=1e-12)


# ---- correlation ----

FRICTION = Vary(distribution="normal", arguments={"mean": 0.14, "std": 0.02})
SKEW = Vary(distribution="lognorm", arguments={"s": 0.8})


@pytest.mark.parametrize("kind", ["random", "latin", "sobol"])
@pytest.mark.parametrize("value", [-0.9, -0.3, 0.6])
def test_the_rank_correlation_is_the_stated_one(kind, value):
    """Within 4 standard errors of Fisher's transform, whatever the distributions."""
    vary = {"a": FRICTION, "b": SKEW, "c": Vary(1.0, 2.0)}
    plan = Plan(kind, vary, runs=4096, seed=1, correlations=[Correlation("a", "b", value)])
    rows = plan.rows(0, plan.count)
    found = stats.spearmanr(rows).statistic
    error = 4.0 * 1.06 / math.sqrt(4096 - 3)
    assert abs(math.atanh(found[0, 1]) - math.atanh(value)) < error
    assert abs(found[0, 2]) < error and abs(found[1, 2]) < error
    assert stats.kstest(rows[:, 1], stats.lognorm(0.8).cdf).pvalue > LEAST_P


def test_the_pearson_correlation_of_lognormal_values_is_the_closed_form():
    """(exp(R s1 s2) - 1)/sqrt((exp(s1^2) - 1)(exp(s2^2) - 1)) for the correlation R of the logarithms."""
    one, other = (Vary(distribution="lognorm", arguments={"s": s}) for s in (0.8, 0.5))
    for value in (-0.3, 0.4, 0.8):
        plan = Plan(
            "random", {"a": one, "b": other}, 8, correlations=[Correlation("a", "b", value, "pearson")]
        )
        rank = Copula(plan.vary, plan.correlations).matrix[0, 1]
        exact = (math.exp(rank * 0.4) - 1.0) / math.sqrt((math.exp(0.64) - 1.0) * (math.exp(0.25) - 1.0))
        assert exact == pytest.approx(value, rel=1e-7)


def test_correlations_that_contradict_each_other_are_told_with_what_would_work():
    vary = {name: FRICTION for name in "abc"}
    pairs = [Correlation("a", "b", 0.9), Correlation("b", "c", 0.9), Correlation("a", "c", -0.9)]
    with refused("contradict each other", "eigenvalue", "times 0.5"):
        Plan("random", vary, 8, correlations=pairs)
    less = [Correlation(each.first, each.second, 0.5 * each.value) for each in pairs]
    assert Plan("random", vary, 8, correlations=less).rows(0, 8).shape == (8, 3)
    with refused("pearson = -0.9", "these distributions allow"):
        Plan("random", {"a": SKEW, "b": SKEW}, 8, correlations=[Correlation("a", "b", -0.9, "pearson")])


# ---- arrangements ----


@pytest.mark.parametrize("kind, runs, count", [
    ("random", 10, 10), ("indices", 8, 40), ("saltelli", 8, 64), ("morris", 10, 40), ("fast", 70, 210),
])  # fmt: skip
def test_the_shape_of_each_arrangement(kind, runs, count):
    plan = Plan(kind, {name: Vary(1.0, 2.0) for name in "abc"}, runs)
    rows = plan.rows(0, plan.count)
    assert plan.count == count and rows.shape == (count, 3)
    assert np.array_equal(np.concatenate([plan.rows(k, k + 7) for k in range(0, count, 7)]), rows)
    assert np.all((rows >= 1.0) & (rows <= 2.0))


def test_a_trajectory_of_morris_changes_one_name_at_a_time():
    plan = Plan("morris", {name: Vary(0.0, 1.0) for name in "abcd"}, runs=6, levels=4)
    steps = np.diff(plan.rows(0, plan.count).reshape(6, 5, 4), axis=1)
    assert np.all(np.sum(steps != 0.0, axis=2) == 1)
    assert np.allclose(np.abs(steps[steps != 0.0]), 2.0 / 3.0, rtol=1e-12)


def test_saltelli_with_half_of_the_runs_has_no_second_order():
    plan = Plan("saltelli", {name: Vary(0.0, 1.0) for name in "abc"}, runs=8, second_order=False)
    assert plan.count == 8 * 5


def ishigami(x):
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


V1, V2, V13 = (1 + 0.1 * math.pi**4 / 5) ** 2 / 2, 49 / 8, 0.01 * math.pi**8 * (1 / 18 - 1 / 50)
FIRST = np.array([V1, V2, 0.0]) / (V1 + V2 + V13)
TOTAL = np.array([V1 + V13, V2, V13]) / (V1 + V2 + V13)
ANGLES = {name: Vary(-math.pi, math.pi) for name in "abc"}


def test_salib_finds_the_indices_of_ishigamis_function_in_the_rows():
    """Closed form: Ishigami and Homma 1990, with the second order of a and c."""
    sobol = pytest.importorskip("SALib.analyze.sobol")
    plan = Plan("saltelli", ANGLES, runs=4096)
    found = sobol.analyze(plan.salib_problem(), ishigami(plan.rows(0, plan.count)))
    assert np.all(np.abs(found["S1"] - FIRST) < 0.01)
    assert np.all(np.abs(found["ST"] - TOTAL) < 0.01)
    assert abs(found["S2"][0, 2] - V13 / (V1 + V2 + V13)) < 0.02


@pytest.mark.parametrize("kind, module, options", [
    ("saltelli", "sobol", {}), ("morris", "morris", {"num_levels": 4}), ("fast", "fast_sampler", {}),
])  # fmt: skip
def test_the_rows_are_those_of_salibs_samplers(kind, module, options):
    sampler = pytest.importorskip(f"SALib.sample.{module}")
    plan = Plan(kind, ANGLES, runs=128, seed=6)
    exact = sampler.sample(plan.salib_problem(), 128, seed=6, **options)
    assert np.allclose(plan.rows(0, plan.count), exact, atol=1e-14)


@pytest.mark.filterwarnings("ignore:FAST confidence intervals")
def test_fast_and_morris_take_the_rows():
    """FAST: first order of the closed form, of the angles without interaction. Morris: exact of a linear
    function."""
    fast, morris = pytest.importorskip("SALib.analyze.fast"), pytest.importorskip("SALib.analyze.morris")
    plan = Plan("fast", ANGLES, runs=2049, seed=1)
    found = fast.analyze(plan.salib_problem(), ishigami(plan.rows(0, plan.count)))
    assert np.all(np.abs(np.array(found["S1"]) - FIRST)[:2] < 0.01)
    plan = Plan("morris", {"a": Vary(0.0, 2.0), "b": Vary(1.0, 4.0)}, runs=10)
    rows = plan.rows(0, plan.count)
    found = morris.analyze(plan.salib_problem(), rows, 3.0 * rows[:, 0] - rows[:, 1])
    assert np.allclose(found["mu"], [6.0, -3.0], rtol=1e-9)  # per range
    assert np.allclose(found["sigma"], 0.0, atol=1e-9)


SALIB = {
    "num_vars": 7,
    "names": list("abcdefg"),
    "bounds": [[1, 2], [1, 100], [0.1, 0.02], [0.0, 0.2, 0.1, 0.05], [1, 3, 0.25], [0.5, 0.2], [1.5, 2.0]],
    "dists": ["unif", "logunif", "norm", "truncnorm", "triang", "lognorm", "weibull"],
}


def test_a_problem_of_salib_gives_salibs_values():
    """Of each of its distributions, and back."""
    util = pytest.importorskip("SALib.util")
    plan = Plan.from_salib(SALIB, "latin", runs=64, seed=3)
    shares = np.random.default_rng(2).random((50, 7))
    exact = util.scale_samples(shares.copy(), SALIB | {"sample_scaled": False})
    found = np.column_stack([vary.at(s) for vary, s in zip(plan.vary.values(), shares.T, strict=True)])
    assert np.allclose(found, exact, rtol=1e-9)
    back = plan.salib_problem()
    assert back["dists"] == SALIB["dists"] and back["names"] == SALIB["names"]
    for one, other in zip(back["bounds"], SALIB["bounds"], strict=True):
        assert np.allclose(one[: len(other)], other, rtol=1e-12)


@pytest.mark.parametrize("change, mentions", [
    ({"dists": ["uniform"] * 7}, ["a: dists = 'uniform'", "unif"]),
    ({"groups": ["x"] * 7}, ["groups"]),
    ({"bounds": [[1, 2]]}, ["7 names, 1 bounds"]),
    ({"dists": ["truncnorm"] * 7}, ["truncnorm has 4 numbers"]),
])  # fmt: skip
def test_a_problem_of_salib_that_is_none(change, mentions):
    with refused(*mentions):
        Plan.from_salib(SALIB | change, "latin", runs=64)


def test_plans_without_salib_say_what_to_do(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "SALib.sample.morris", None)
    with refused("pip install SALib", "indices"):
        Plan("morris", ANGLES, runs=4).rows(0, 1)


def test_tables_of_parquet_and_columns_have_texts(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    (tmp_path / "one.csv").write_text("psi_rad,z_m\n0,0\n")
    table = {"cam1.radius": [0.02, 0.03, 0.04], "cam1.table": ["one.csv", "other", "one.csv"]}
    parquet.write_table(pyarrow.table(table), tmp_path / "runs.parquet")
    (tmp_path / "runs.csv").write_text("cam1.radius,cam1.table\n0.02,one.csv\n0.03,other\n0.04,one.csv\n")
    for plan in (
        Plan.from_parquet(tmp_path / "runs.parquet"),
        Plan.from_csv(tmp_path / "runs.csv", texts=["cam1.table"]),
        Plan.from_columns(table, tmp_path),
    ):
        assert plan.rows(0, 3).tolist() == [[0.02, 0.0], [0.03, 1.0], [0.04, 0.0]]
        assert [plan.texts["cam1.table"][k] for k in (0, 1)] == [str(tmp_path / "one.csv"), "other"]


# ---- formulas ----

VALUES = {"x": np.array([0.5, 2.0, -3.0]), "cam1.radius": np.array([0.01, 0.02, 0.03]), "n": 4.0}


@pytest.mark.parametrize("text, exact", [
    ("2*x^2 - 3", lambda x, r: 2 * x**2 - 3),
    ("-x^2", lambda x, r: -(x**2)),
    ("cam1.radius / (1 + n) * 1e3", lambda x, r: r / 5 * 1e3),
    ("sqrt(abs(x)) + sin(pi*cam1.radius)", lambda x, r: np.sqrt(np.abs(x)) + np.sin(np.pi * r)),
    ("max(x, 0, cam1.radius)", lambda x, r: np.maximum(np.maximum(x, 0), r)),
    ("where(x > 0 and x < 1, 10, -10)", lambda x, r: np.where((x > 0) & (x < 1), 10.0, -10.0)),
    ("0 < x <= 2", lambda x, r: (x > 0) & (x <= 2)),
    ("not x > 1 or n == 5", lambda x, r: ~(x > 1)),
    ("atan2(x, cam1.radius) % 1", lambda x, r: np.arctan2(x, r) % 1),
    ("'20 mm' * n", lambda x, r: np.full(3, 0.08)),
    ("`cam1.radius` + exp(1)", lambda x, r: r + np.e),
    ("2^0.5^2", lambda x, r: np.full(3, 2 ** (0.5**2))),
    ("(-8)^n", lambda x, r: np.full(3, 4096.0)),
])  # fmt: skip
def test_formulas_are_those_of_python(text, exact):
    found = Formula(text).numbers(VALUES, 3)
    assert np.allclose(found, exact(VALUES["x"], VALUES["cam1.radius"]), rtol=1e-14)


@pytest.mark.parametrize("text", [
    "__import__('os').system('true')", "x.__class__.__bases__()", "[x for x in (1,)]", "lambda: 1", "x; y",
    "x = 1", "open('/etc/passwd')",
    "(1).real", "x[0]", "f'{x}'", "x if x else 1", "sin()", "sin(x, x)", "max(*x)",
    "sqrt(x=1)", "", "8 N.m", "x +", "'20 ells'", "'20'", "1j", "-" * 70 + "x", "x" * 1001, "None",
    "sin", "x + {1}", "x @ x", "x | x", "await x", "x\ny", "None.x()", "b'x'",
])  # fmt: skip
def test_what_is_no_formula_is_refused(text):
    """Nothing but computing is possible, whatever a file says; `sin` alone is a name."""
    if text == "sin":
        assert Formula(text).names == ("sin",)
        return
    assert not is_formula(text)
    with refused("allowed"):
        Formula(text)


def test_a_huge_power_is_no_hang():
    assert Formula("9^9^9^9")({}) == math.inf
    assert math.isnan(Formula("log(-1)")({}))
    assert not Formula("log(-1) < 1").truth({}, 1)[0]


def test_derived_values_and_constraints_are_those_of_numpy():
    vary = {"wire": Vary(1.8e-3, 2.2e-3), "coil": Vary(0.018, 0.022), "turns": Vary(values=(4, 5, 6))}
    derived = {
        "index": "coil / wire",  # after its use below
        "spring.preload": "50 + 0 * index",
        "spring.stiffness": "'79 GPa' * wire^4 / (8 * coil^3 * turns)",
    }
    plan = Plan("latin", vary, 500, derived=derived, constraints={"index": "9 < index < 11"}, seed=5)
    rows = plan.rows(0, 500)
    wire, coil, turns = rows[:, :3].T
    assert plan.names == ["wire", "coil", "turns", "index", "spring.preload", "spring.stiffness"]
    assert np.allclose(rows[:, 3], coil / wire, rtol=1e-15)
    assert np.allclose(rows[:, 5], 79e9 * wire**4 / (8 * coil**3 * turns), rtol=1e-14)
    assert np.all((rows[:, 3] > 9) & (rows[:, 3] < 11))
    bad, looked, _ = plan.sampler.violating()
    first = Plan("latin", vary, 500, seed=5).rows(0, 500)
    ratio = first[:, 1] / first[:, 0]
    assert (bad, looked) == (int(np.sum((ratio <= 9) | (ratio >= 11))), 500)
    assert np.array_equal(np.concatenate([plan.rows(k, k + 90) for k in range(0, 500, 90)]), rows)


def test_runs_drawn_again_are_of_the_conditional_distribution():
    """x uniform in [0, 1] given x < 0.3 is uniform in [0, 0.3]."""
    plan = Plan("random", {"x": Vary(0.0, 1.0)}, 3000, constraints={"low": "x < 0.3"})
    assert stats.kstest(plan.rows(0, 3000)[:, 0], stats.uniform(0.0, 0.3).cdf).pvalue > LEAST_P


@pytest.mark.parametrize("more", [{"on_violation": "mark"}, {"kind": "grid"}])
def test_runs_that_violate_a_constraint_are_marked(more):
    vary = {"cam1.friction": Vary(0.1, 0.2, count=8), "cam2.friction": Vary(0.1, 0.2, count=8)}
    kind = more.pop("kind", "latin")
    rule = {"least": "cam1.friction + cam2.friction > 0.25"}
    plan = Plan(kind, vary, 0 if kind == "grid" else 64, constraints=rule, **more)
    block = runs_of(study(plan, Scenario(0.01), ["efficiency", "cam1.friction"]))
    bad = plan.rows(0, 64).sum(axis=1) <= 0.25
    assert 0 < bad.sum() < 64
    assert set(block.messages) == set(np.flatnonzero(bad))
    assert (
        "least: cam1.friction + cam2.friction > 0.25 is not true for" in block.messages[int(np.argmax(bad))]
    )
    assert np.array_equal(np.isnan(block.values[:, 0]), bad)
    assert np.array_equal(block.values[~bad, 1], plan.rows(0, 64)[~bad, 0])


# ---- tolerances of groove tables ----

PSI = np.linspace(0.0, 1.0, 51)


def test_errors_of_profiles_have_the_stated_covariance():
    """The mean over 4000 tables of e(psi) e(psi') within 5 standard errors of s^2 exp(-d^2/(2 l^2))."""
    tables = RandomProfiles(PSI, 0.02 * PSI, deviation=2e-5, correlation_length=0.15, count=1, seed=9)
    errors = np.array([tables.height(k) for k in range(4000)]) - 0.02 * PSI
    found = errors.T @ errors / 4000
    exact = 4e-10 * np.exp(-((PSI[:, None] - PSI) ** 2) / (2 * 0.15**2))
    assert np.all(np.abs(found - exact) < 5.0 * 4e-10 * math.sqrt(2.0 / 4000))
    assert np.all(np.abs(errors.mean(axis=0)) < 5.0 * 2e-5 / math.sqrt(4000))
    assert stats.kstest(errors[:, 20] / 2e-5, "norm").pvalue > LEAST_P


def test_a_table_is_written_with_all_its_digits_and_once():
    tables = RandomProfiles(PSI, 0.02 * PSI, 2e-5, 0.15, count=3, seed=2)
    path = tables[1]
    psi, z = np.loadtxt(path, delimiter=",", skiprows=1).T
    assert np.array_equal(psi, PSI) and np.array_equal(z, tables.height(1))
    assert tables[1] == path and tables[2] != path
    assert RandomProfiles(PSI, 0.02 * PSI, 2e-5, 0.15, count=3, seed=2)[1] == path


@pytest.mark.parametrize("deviation, length, count, mentions", [
    (0.0, 0.1, 5, ["deviation = 0", "above 0"]),
    (1e-5, 0.01, 5, ["correlation_length = 0.01", "0.02 rad apart", "0.04 rad or more"]),
    (1e-5, 0.1, 0, ["count = 0"]),
    (2e-3, 0.1, 20, ["% of the tables would fall", "0.02 m/rad", "smaller deviation"]),
])  # fmt: skip
def test_profiles_that_cannot_be(deviation, length, count, mentions):
    with refused(*mentions):
        RandomProfiles(PSI, 0.02 * PSI, deviation, length, count)
