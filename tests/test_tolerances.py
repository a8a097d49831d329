"""dualcam.design.tolerances against closed forms, geometry without derivatives, and the FMU."""

import math

import matplotlib
import numpy as np
import pytest
from driver import models
from matplotlib.figure import Figure
from scipy.optimize import brentq, minimize_scalar
from scipy.stats import beta, cauchy, chi2, expon, norm, t, uniform

from dualcam import Fmu, read_design
from dualcam.design import Cycloid, Ellipse, Helix, Mechanism, Spring, Table
from dualcam.design.tolerances import Limit, Tolerance, analyse, analysis, propagate, yield_of
from dualcam.design_file import write_template
from dualcam.errors import DesignError, DualcamError

matplotlib.use("Agg")
INVERSE = models["DualCamInverse"].fmu
UPPER = 1.3963
MU = 0.14
PLAIN = Mechanism((Helix(0.02, math.pi / 4),) * 2, (MU, MU), Spring(50.0, 5e4), UPPER)
ARCS = Mechanism(
    (Ellipse(0.02, 0.8203, 0.12, 0.11), Ellipse(0.025, 0.7, 0.08, 0.09, 1)),
    (0.14, 0.12),
    Spring(290.0, 5e4, 3e5, 2e7),
    UPPER,
)
GREASE = Tolerance(("cam1.friction", "cam2.friction"), norm(MU, 0.01))
ANGLES = np.array([0.0, 0.4, 1.0, UPPER])


def table():
    psi = np.linspace(-0.2, 1.2, 60)
    return Table(0.018, psi, 0.017 * psi + 0.002 * np.sin(1.5 * psi))


@pytest.fixture(scope="module")
def inverse():
    with Fmu(INVERSE) as fmu:
        yield fmu


def deviation_is_plausible(found, exact, samples):
    """The square of a standard deviation of normal values over the exact one is chi-squared."""
    low, high = chi2.ppf([1e-5, 1 - 1e-5], samples - 1) / (samples - 1)
    return low <= (found / exact) ** 2 <= high


# ---- propagation ----


def test_a_linear_function_of_normal_inputs():
    """Standard deviation sqrt((2 u_a)^2 + (3 u_b)^2), normal: first order is exact."""
    tolerances = [Tolerance("a", norm(5.0, 0.4)), Tolerance("b", norm(-1.0, 0.1))]
    found = propagate(lambda x: 2.0 * x["a"] - 3.0 * x["b"] + 1.0, tolerances, 40_000)
    exact = math.hypot(0.8, 0.3)
    assert found.budget.value == pytest.approx(14.0, rel=1e-15)
    assert found.budget.standard_uncertainty == pytest.approx(exact, rel=1e-15)
    assert found.budget.sensitivity[:, 0] == pytest.approx([2.0, -3.0], rel=1e-15)
    assert found.budget.contribution[:, 0] == pytest.approx([64 / 0.73, 9 / 0.73], rel=1e-14)
    assert deviation_is_plausible(found.standard_deviation[0], exact, 40_000)
    assert abs(found.mean[0] - 14.0) < 5.0 * exact / math.sqrt(40_000)
    for level in found.levels:
        low, high = found.percentile_interval(level, 0.9999)
        assert low[0] < norm(14.0, exact).ppf(level / 100.0) < high[0]
    assert found.agrees().all()


def test_a_product_of_normal_inputs():
    """Variance of a b: (mu_a u_b)^2 + (mu_b u_a)^2 + (u_a u_b)^2. First order leaves out the last term."""
    a, b = norm(2.0, 0.8), norm(3.0, 0.9)
    found = propagate(lambda x: x["a"] * x["b"], [Tolerance("a", a), Tolerance("b", b)], 100_000)
    first = math.hypot(2.0 * 0.9, 3.0 * 0.8)
    assert found.budget.standard_uncertainty == pytest.approx(first, rel=1e-15)
    exact = math.hypot(first, 0.8 * 0.9)
    # not normal: the spread of the variance has the fourth moment, estimated from the values
    values = found.values[:, 0]
    error = math.sqrt((np.mean((values - values.mean()) ** 4) - exact**4) / len(values))
    assert abs(values.var() - exact**2) < 4.0 * error
    assert exact**2 - first**2 > 4.0 * error  # first order is told apart
    assert not found.agrees(2).any()


def test_where_the_derivative_is_zero_first_order_sees_nothing():
    """1 - cos(x), x uniform within +-d: mean 1 - sin(d)/d."""
    d = 0.3
    found = propagate(lambda x: np.cos(x["x"]), [Tolerance.within("x", -d, d, "uniform")], 20_000)
    assert found.budget.standard_uncertainty == 0.0
    assert np.isnan(found.budget.contribution).all()
    mean, square = math.sin(d) / d, 0.5 + math.sin(2 * d) / (4 * d)
    spread = math.sqrt(square - mean**2)
    assert abs(found.mean[0] - mean) < 5.0 * spread / math.sqrt(20_000)
    assert found.standard_deviation[0] == pytest.approx(spread, rel=0.02)
    assert not found.agrees().any()


def test_few_samples_have_no_interval_of_an_outer_percentile():
    found = propagate(lambda x: x["x"], [Tolerance("x", norm())], 100)
    with pytest.raises(DesignError, match="more samples are needed for an interval, about 400"):
        found.percentile_interval(99.0)


def test_interval_of_a_percentile_holds_the_true_one_as_often_as_said():
    """The median of a uniform distribution in 400 series: 90 % intervals, binomial bounds of 1e-5."""
    hits = sum(
        low[0] < 0.5 < high[0]
        for seed in range(400)
        for low, high in [
            propagate(lambda x: x["x"], [Tolerance("x", uniform())], 200, seed).percentile_interval(50.0, 0.9)
        ]
    )
    assert 334 <= hits <= 395


def test_limits_on_a_drawing():
    """GUM 4.3.7, 4.3.9: a/sqrt(3), a/sqrt(6); no value of a normal one beyond the limits."""
    for shape, exact in (("uniform", 3.0), ("triangular", 6.0)):
        assert Tolerance.within("x", 1.0, 1.2, shape).standard_uncertainty == pytest.approx(
            0.1 / math.sqrt(exact), rel=1e-12
        )
    found = Tolerance.within("x", 1.0, 1.2)
    assert found.mean == pytest.approx(1.1, rel=1e-14)
    assert found.distribution.support() == pytest.approx((1.0, 1.2), rel=1e-14)
    # a truncated normal distribution: variance 1 - 2 c pdf(c)/(2 cdf(c) - 1)
    exact = 1.0 - 6.0 * norm.pdf(3.0) / (2.0 * norm.cdf(3.0) - 1.0)
    assert found.standard_uncertainty == pytest.approx(0.1 / 3.0 * math.sqrt(exact), rel=1e-10)
    assert Tolerance.named("x", "norm", loc=2.0, scale=0.5).standard_uncertainty == 0.5


# ---- the mechanism ----


def all_tolerances(mechanism):
    """A tolerance of 2 % on everything that the FMU knows."""
    found = []
    for i, groove in enumerate(mechanism.grooves, 1):
        own = {**groove.parameters(), "friction": mechanism.friction[i - 1]}
        names = [name for name in own if name not in ("profile", "ellipse_curvature")]
        found += [Tolerance(f"cam{i}.{name}", norm(own[name], 0.02 * own[name])) for name in names]
    for name, value in mechanism.spring.parameters().items():
        if value:
            found.append(Tolerance(name, norm(value, 0.02 * value)))
    return found


def torques_of_fmu(fmu, parameters, theta):
    """torque_load, torque_release, z at rest."""
    fmu.start({**parameters, "inertia.shaft": 0.0, "theta": theta, "omega": 0.0})
    return [fmu.real(name) for name in ("torque_load", "torque_release", "z")]


MIXED = [
    PLAIN,
    ARCS,
    Mechanism((table(), Helix(0.02, 0.7)), (0.1, 0.2), Spring(100.0, 3e4), 1.2),
    Mechanism((Ellipse(0.02, 0.5, 0.05, 0.06), table()), (0.2, 0.1), Spring(100.0, 3e4), 0.9),
    Mechanism((Helix(0.02, 0.6), Cycloid(0.025, 0.03, 1.6)), (0.1, 0.15), Spring(100.0, 3e4), 1.2),
    # groove 1 locks itself in about half of the samples
    Mechanism((Helix(0.02, 0.14), Helix(0.03, 0.9)), (0.14, 0.14), Spring(100.0, 3e4), 1.2),
]


@pytest.mark.parametrize("mechanism", MIXED)
def test_samples_are_those_of_the_fmu(mechanism, inverse, tmp_path):
    theta = np.linspace(0.0, mechanism.upper, 4)
    found = analyse(mechanism, all_tolerances(mechanism), theta, samples=8)
    nominal = mechanism.parameters(tmp_path)
    for row in range(8):
        drawn = {name: values[row] for name, values in found.parameters.items()}
        for k, angle in enumerate(theta):
            exact = torques_of_fmu(inverse, {**nominal, **drawn}, angle)
            mine = [found[name].values[row, k] for name in ("load", "release", "z")]
            assert mine == pytest.approx(exact, rel=1e-11, abs=1e-15)


@pytest.mark.parametrize("mechanism", MIXED[:4])
def test_sensitivities_are_the_differences_of_the_fmu(mechanism, inverse, tmp_path):
    tolerances = all_tolerances(mechanism)
    theta = 0.6 * mechanism.upper
    found = analyse(mechanism, tolerances, [theta], samples=2)
    nominal = mechanism.parameters(tmp_path)
    for j, tolerance in enumerate(tolerances):
        h = 1e-5 * tolerance.mean
        ends = [
            torques_of_fmu(inverse, {**nominal, tolerance.name: tolerance.mean + s * h}, theta)
            for s in (1, -1)
        ]
        for name, high, low in zip(("load", "release", "z"), *ends, strict=True):
            scale = abs(found[name].budget.value[0] / tolerance.mean)
            assert found[name].budget.sensitivity[j, 0] == pytest.approx(
                (high - low) / (2.0 * h), rel=1e-7, abs=1e-8 * scale
            )


def test_parameters_that_share_a_value():
    found = analyse(PLAIN, [GREASE], ANGLES, samples=50)
    assert (found.parameters["cam1.friction"] == found.parameters["cam2.friction"]).all()
    # two equal helices of 45 deg: T = F r/2 (1 + mu)/(1 - mu), dT/dmu = F r/(1 - mu)^2
    force = 50.0 + 5e4 * 0.01 * ANGLES
    budget = found["load"].budget
    assert budget.sensitivity[0] == pytest.approx(force * 0.02 / (1.0 - MU) ** 2, rel=1e-13)
    assert budget.names == ("cam1.friction = cam2.friction",)
    mu = found.parameters["cam1.friction"][:, None]
    assert found["release"].values == pytest.approx(force * 0.01 * (1.0 - mu) / (1.0 + mu), rel=1e-13)
    assert found["efficiency"].values == pytest.approx(((1 - mu) / (1 + mu)) ** 2 + 0 * force, rel=1e-13)


def test_yield_of_one_parameter_is_the_normal_distribution():
    """T_load = F r/2 (1 + mu)/(1 - mu) <= T is mu <= (T - a)/(T + a) with a = F r/2."""
    limit, a = 4.05, (50.0 + 5e4 * 0.005) * 0.01
    exact = norm(MU, 0.01).cdf((limit - a) / (limit + a))
    found = analyse(PLAIN, [GREASE], [0.5], 20_000, limits=[Limit("load", most=limit)], confidence=0.9999)
    low, high = found.total_yield.interval
    assert 0.7 < exact < 0.95
    assert low < exact < high and high - low < 0.03
    # Clopper and Pearson by quantiles of the beta distribution
    k, n, tail = found.total_yield.good, 20_000, 0.5e-4
    assert low == pytest.approx(beta.ppf(tail, k, n - k + 1), rel=1e-9)
    assert high == pytest.approx(beta.ppf(1.0 - tail, k + 1, n - k), rel=1e-9)


def test_yield_of_several_limits():
    limits = [
        Limit("load", most=lambda theta: 1.0 + 6.5 * theta),
        Limit("release", least=np.full(len(ANGLES), 0.3)),
        Limit("efficiency", least=0.55, most=0.6),
    ]
    found = analyse(PLAIN, [GREASE], ANGLES, 2000, limits=limits)
    mu = found.parameters["cam1.friction"]
    each = [
        np.all([found["load"].values[:, k] <= 1.0 + 6.5 * x for k, x in enumerate(ANGLES)], axis=0),
        found["release"].values.min(axis=1) >= 0.3,
        (((1 - mu) / (1 + mu)) ** 2 >= 0.55) & (((1 - mu) / (1 + mu)) ** 2 <= 0.6),
    ]
    assert [one.good for one in found.yields] == [int(one.sum()) for one in each]
    assert found.total_yield.good == int(np.all(each, axis=0).sum())
    assert 0 < found.total_yield.good < 2000
    text = str(found)
    assert all(str(one) in text for one in (*found.yields, found.total_yield))
    assert yield_of(np.ones(10, bool), "all").interval[1] == 1.0


def test_mechanisms_that_lock_or_jam_count_as_bad():
    """mu = tan(lead) locks, mu = 1/tan(lead) jams, with both grooves alike."""
    steep = Mechanism((Helix(0.02, math.atan(2.0)),) * 2, (0.3, 0.3), Spring(50.0, 5e4), 1.0)
    spread = Tolerance(("cam1.friction", "cam2.friction"), uniform(0.1, 0.6))
    found = analyse(steep, [spread], 5, 4000, limits=[Limit("load", most=1e6)])
    jams = found.parameters["cam1.friction"] >= 0.5
    assert found.jamming == jams.mean() == pytest.approx(1.0 - found.total_yield.share)
    assert 0.2 < found.jamming < 0.5
    flat = Mechanism((Helix(0.02, math.atan(0.2)),) * 2, (0.15, 0.15), Spring(50.0, 5e4), 1.0)
    spread = Tolerance(("cam1.friction", "cam2.friction"), uniform(0.1, 0.2))
    found = analyse(flat, [spread], 5, 4000, limits=[Limit("release", least=0.0)])
    assert found.locking == pytest.approx(1.0 - found.total_yield.share)
    assert found.locking == (found.parameters["cam1.friction"] >= 0.2).mean()
    assert "lock themselves" in str(found)


# ---- clearance ----


def lowest(groove, clearance, psi):
    """The least height of the pin's centre that is not nearer than allowed to the lower flank: a distance
    of clearance/2 from the centre of the groove, in the unwrapped plane, found by search."""

    def distance(z):
        def at(u):
            return math.hypot(groove.radius * (u - psi), float(groove.at(u).z) - z)

        reach = clearance / groove.radius
        return minimize_scalar(at, bounds=(psi - reach, psi + reach), options={"xatol": 1e-12}).fun

    centre = float(groove.at(psi).z)
    return brentq(lambda z: distance(z) - 0.5 * clearance, centre - 3.0 * clearance, centre, xtol=1e-13)


def test_clearance_lowers_the_pin():
    """Where the two lowest heights meet, found by search."""
    mechanism = Mechanism(ARCS.grooves, ARCS.friction, ARCS.spring, UPPER)
    gaps = (4e-4, 2e-4)
    tolerances = [Tolerance(f"cam{i}.clearance", norm(c, 1e-12)) for i, c in enumerate(gaps, 1)]
    found = analyse(mechanism, tolerances, [0.3, 1.1], samples=2)
    for k, theta in enumerate((0.3, 1.1)):

        def gap(gamma, theta=theta):
            first, second = mechanism.grooves
            return lowest(first, gaps[0], gamma) - lowest(second, gaps[1], theta - gamma)

        gamma = brentq(gap, 0.1 * theta, 0.9 * theta, xtol=1e-13)
        exact = lowest(mechanism.grooves[0], gaps[0], gamma)
        assert found["z"].budget.value[k] == pytest.approx(exact, abs=2e-11)
        assert float(mechanism.configuration(theta).z) - exact > 1e-4


def test_clearance_of_helices():
    """The pin sinks by (a2 h1 + a1 h2)/(a1 + a2), h = c/(2 cos lead); cam 2 plays by c/(r sin lead)."""
    first, second = Helix(0.02, 0.7), Helix(0.03, 0.5)
    mechanism = Mechanism((first, second), (0.1, 0.1), Spring(100.0, 2e4), 1.0)
    names = ("cam1.clearance", "cam2.clearance")
    tolerances = [Tolerance.within(name, 0.0, 2e-4, "uniform") for name in names]
    found = analyse(mechanism, tolerances, [0.2, 0.8], samples=20)
    c1, c2 = (found.parameters[name][:, None] for name in names)
    a1, a2 = 0.02 * math.tan(0.7), 0.03 * math.tan(0.5)
    h1, h2 = c1 / (2 * math.cos(0.7)), c2 / (2 * math.cos(0.5))
    drop = mechanism.configuration([0.2, 0.8]).z - (a2 * h1 + a1 * h2) / (a1 + a2)
    assert found["z"].values == pytest.approx(drop, rel=1e-12)
    backlash = c1 / (0.02 * math.sin(0.7)) + c2 / (0.03 * math.sin(0.5)) + 0.0 * drop
    assert found["backlash"].values == pytest.approx(backlash, rel=1e-10)
    sensitivity = found["backlash"].budget.sensitivity
    assert sensitivity[0] == pytest.approx(1 / (0.02 * math.sin(0.7)), rel=1e-10)
    # the slopes stay, the spring relaxes
    force = mechanism.spring.force(found["z"].values) / mechanism.spring.force(
        mechanism.configuration([0.2, 0.8]).z
    )
    release, load = mechanism.band([0.2, 0.8])
    assert found["load"].values == pytest.approx(force * load, rel=1e-12)
    assert found["release"].values == pytest.approx(force * release, rel=1e-12)


def test_backlash_of_arcs_is_the_turn_between_the_flanks():
    """At the same height, the pin on the upper flanks is the pin under the mirrored grooves: the place of the
    lower flank with a negative clearance."""
    mechanism = Mechanism(ARCS.grooves, ARCS.friction, ARCS.spring, UPPER)
    c = 3e-4
    tolerances = [Tolerance(f"cam{i}.clearance", norm(c, 1e-12)) for i in (1, 2)]
    found = analyse(mechanism, tolerances, [0.7], samples=2)
    z, turn = found["z"].budget.value[0], 0.0
    for groove in mechanism.grooves:
        low = brentq(lambda psi, g=groove: lowest(g, c, psi) - z, 0.0, 0.9, xtol=1e-13)

        def highest(psi, g=groove):  # the mirror image of `lowest` about the centre's place
            mirrored = Mirrored(g)
            return -lowest(mirrored, c, -psi)

        turn += low - brentq(lambda psi, f=highest: f(psi) - z, 0.0, 0.9, xtol=1e-13)
    assert found["backlash"].budget.value[0] == pytest.approx(turn, rel=1e-6)


class Mirrored:
    """The groove turned by half a turn in its plane: upper and lower flank change places."""

    def __init__(self, groove):
        self.groove, self.radius = groove, groove.radius

    def at(self, psi):
        point = self.groove.at(-psi)
        return point._replace(z=-point.z)


def test_a_scaled_groove_is_a_scaled_table():
    psi = np.linspace(-0.1, 1.0, 30)
    z = 0.02 * psi + 0.003 * psi**2
    mechanism = Mechanism((Table(0.02, psi, z), Helix(0.02, 0.8)), (0.1, 0.1), Spring(80.0, 3e4), 1.0)
    found = analyse(mechanism, [Tolerance("cam1.groove_scale", norm(1.0, 0.03))], [0.5], samples=5)
    for scale, load in zip(found.parameters["cam1.groove_scale"], found["load"].values[:, 0], strict=True):
        scaled = (Table(0.02, psi, scale * z), mechanism.grooves[1])
        exact = Mechanism(scaled, (0.1, 0.1), mechanism.spring, 1.0).band(0.5)[1]
        assert load == pytest.approx(float(exact), rel=1e-11)


# ---- use ----


def test_the_same_seed_gives_the_same_mechanisms(monkeypatch):
    more = [GREASE, Tolerance("spring.preload", norm(50.0, 2.0))]
    first = analyse(PLAIN, more, ANGLES, 300, seed=4)
    monkeypatch.setattr(analysis, "BLOCK", 41)
    again = analyse(PLAIN, more, ANGLES, 300, seed=4)
    assert (first["load"].values == again["load"].values).all()
    alone = analyse(PLAIN, [GREASE], ANGLES, 300, seed=4)
    assert (alone.parameters["cam1.friction"] == first.parameters["cam1.friction"]).all()
    assert (analyse(PLAIN, more, ANGLES, 300, seed=5)["load"].values != first["load"].values).all()


def test_a_design_file_is_analysed(tmp_path):
    design = read_design(write_template("minimal", tmp_path / "my.toml"))
    mechanism = design.mechanism()
    mu = Tolerance.within("cam1.friction", 0.9 * mechanism.friction[0], 1.1 * mechanism.friction[0])
    found = analyse(design, [mu], samples=10)
    assert len(found.theta) == 57
    assert found["load"].budget.value == pytest.approx(mechanism.band(found.theta)[1], rel=1e-12)


def test_pictures():
    found = analyse(PLAIN, [GREASE, Tolerance("spring.preload", norm(50.0, 2.0))], samples=200)
    left, right = Figure().subplots(1, 2)
    found.draw_band(left)
    found.draw_budget(right, angle=0.7)
    line = left.lines[0]
    assert line.get_ydata() == pytest.approx(np.median(found["load"].values, axis=0))
    bars = [bar.get_width() for bar in right.patches]
    k = found.nearest(0.7)
    wanted = [*found["load"].budget.contribution[:, k], *found["release"].budget.contribution[:, k]]
    assert bars == pytest.approx(wanted)
    assert [label.get_text() for label in right.get_yticklabels()] == list(found["load"].budget.names)


# ---- bad input ----

PRELOAD = Tolerance("spring.preload", norm(50.0, 2.0))
SHORT = Mechanism((Ellipse(0.02, 0.6, 0.05, 0.05),) * 2, (0.1, 0.1), Spring(50.0, 5e4), 2.9)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: analyse(PLAIN, [Tolerance("cam1.fricton", norm(0.1, 0.01))]), "did you mean cam1.friction"),
        (lambda: analyse(PLAIN, [Tolerance("cam1.ellipse_a", norm(0.1, 0.01))]), "allowed are cam1.radius"),
        (lambda: analyse(PLAIN, [Tolerance("cam1.friction", norm(0.05, 0.02))]), "0.621 %"),
        (lambda: analyse(PLAIN, [Tolerance("cam1.lead_angle", norm(1.5, 0.1))]), "less than pi/2"),
        (lambda: analyse(PLAIN, [Tolerance("cam1.clearance", norm(0.0, 1e-5))]), "50 % of the distribution"),
        (lambda: analyse(PLAIN, [GREASE, Tolerance("cam1.friction", norm(0.1, 0.01))]), "two tolerances"),
        (lambda: analyse(PLAIN, []), "at least one"),
        (lambda: analyse(PLAIN, GREASE), "a list of Tolerance"),
        (lambda: analyse(PLAIN, [norm(0.1, 0.01)]), "is no Tolerance"),
        (lambda: analyse("my.toml", [GREASE]), "read_design"),
        (lambda: analyse(PLAIN, [GREASE], samples=1), "from 2 to 10000000"),
        (lambda: analyse(PLAIN, [GREASE], samples=1e4), "a whole number"),
        (lambda: analyse(PLAIN, [GREASE], seed=-1), "seed"),
        (lambda: analyse(PLAIN, [GREASE], angles=[2.0]), "from 0 to 1.3963 rad"),
        (lambda: analyse(PLAIN, [GREASE], angles=1), "2 or more"),
        (lambda: analyse(PLAIN, [GREASE], angles="all"), "angles"),
        (lambda: analyse(PLAIN, [GREASE], percentiles=[101.0]), "0 to 100"),
        (lambda: analyse(PLAIN, [GREASE], percentiles=[]), "at least one"),
        (lambda: analyse(PLAIN, [GREASE], confidence=1.0), "confidence"),
        (lambda: analyse(PLAIN, [GREASE], limits=[3.0]), "a list of Limit"),
        (lambda: analyse(PLAIN, [GREASE], limits=[Limit("load", most=[1.0, 2.0])]), "57 numbers"),
        (lambda: analyse(PLAIN, [GREASE], limits=[Limit("load", most=math.nan)]), "NaN"),
        (lambda: analyse(PLAIN, [GREASE], limits=[Limit("load", least=lambda x: 1 / 0)]), "ZeroDivision"),
        (lambda: analyse(PLAIN, [GREASE])["torque"], "allowed are load, release"),
        (lambda: Limit("torque", most=1.0), "allowed are load, release"),
        (lambda: Limit("load"), "least, most, or both"),
        (lambda: analyse(SHORT, [PRELOAD]), "a groove ends before the last angle"),
        (lambda: analyse(PLAIN, [Tolerance("spring.preload", norm(10.0, 20.0))]), "spring force is below 0"),
        (lambda: analyse(PLAIN, [Tolerance(("cam1.friction", "cam2.friction"), norm(1.2, 0.01))]), "jams"),
        (lambda: Tolerance("x", cauchy()), "mean of the distribution is nan"),
        (lambda: Tolerance("x", t(1.5)), "standard deviation of the distribution is inf"),
        (lambda: Tolerance("x", norm), "with its numbers"),
        (lambda: Tolerance("x", 0.1), "Tolerance.within"),
        (lambda: Tolerance((), norm()), "a name"),
        (lambda: Tolerance(3, norm()), "a name"),
        (lambda: Tolerance("x", norm([1.0, 2.0])), "single numbers"),
        (lambda: analyse(PLAIN, [GREASE], samples=500_000), "350877 samples"),
        (lambda: analyse(PLAIN, [GREASE], samples=10**15), "350877 samples"),
        (lambda: propagate(lambda x: x["x"], [Tolerance("x", norm())], 10**15), "from 2 to 10000000"),
        (lambda: analyse(PLAIN, [GREASE], limits=Limit("load", most=1.0)), "a list of Limit"),
        (lambda: analyse(PLAIN, [GREASE], angles=np.int64(1)), "2 or more"),
        (lambda: Tolerance(("x", "x"), norm()), "twice"),
        (lambda: Tolerance.named("x", "nrom", loc=1.0), "did you mean norm"),
        (lambda: Tolerance.named("x", "norm", mean=1.0), "loc, scale"),
        (lambda: Tolerance.named("x", "norm", scale=-1.0), "no such distribution"),
        (lambda: Tolerance.within("x", 2.0, 1.0), "that grow"),
        (lambda: Tolerance.within("cam1.radius", "19.98 mm", 0.02), "cam1.radius: limit '19.98 mm': allowed"),
        (
            lambda: analyse(PLAIN, [Tolerance.within("cam1.radius", -0.02e-3, 0.02e-3)]),
            "limits are values of the parameter, not deviations from the nominal value",
        ),
        (
            lambda: analyse(PLAIN, [Tolerance.within("cam1.lead_angle", 44.5, 45.5)]),
            "the mean, 45: this looks like degrees; 45 deg is 0.785398 rad",
        ),
        (lambda: Limit("load", least=9, most=2), "least = 9 and most = 2: allowed is least <= most"),
        (lambda: analyse(PLAIN, [GREASE], percentiles=(0.05, 0.5, 0.95)), "in percent, such as (5, 50, 95)"),
        (lambda: Tolerance.within("x", 1.0, 2.0, "gauss"), "normal, uniform, triangular"),
        (lambda: propagate(lambda x: x["y"], [Tolerance("x", norm())]), "KeyError"),
        (lambda: propagate(lambda x: np.abs(x["x"]), [Tolerance("x", norm())]), "complex numbers"),
        (lambda: propagate(lambda x: np.zeros((3, 2)), [Tolerance("x", norm())]), "(3, 2)"),
        (lambda: propagate(lambda x: x["x"] / (x["x"] > 0.5), [Tolerance("x", expon())]), "no finite value"),
        (lambda: propagate(np.sin, [Tolerance("x", norm())]), "the model fails"),
        (lambda: propagate(lambda x: x["x"], [Tolerance("x", norm())], 10).agrees(0), "digits"),
    ],
)  # fmt: skip
def test_bad_input_is_refused_with_words(call, words):
    with pytest.raises(DesignError) as error, np.errstate(divide="ignore"):
        call()
    assert isinstance(error.value, DualcamError)
    assert words in str(error.value)
