"""docs/paper.md says what its script computes, and what it computes agrees with independent formulas."""

import math
import re

import mpmath
import numpy as np
import pytest
from driver import ROOT
from scipy.integrate import quad, simpson
from scipy.optimize import minimize

from case_studies.paper import __main__ as paper
from case_studies.paper import fmus, published, readings
from case_studies.paper.budget import QUANTITY, measurement, model, names
from case_studies.paper.cams import Pair, Statics, pair
from case_studies.paper.efficiency import beyond_one, efficiency, searched_optimum
from case_studies.paper.fits import best, others
from case_studies.paper.friction import ANGLE, at_speed, load_law, speed_law, turn_rate
from case_studies.paper.measurements import needed_friction
from case_studies.paper.printed import Case
from case_studies.paper.published import (
    DIRECTIONS,
    GREASES,
    LOADING,
    PAIRS,
    PUBLISHED,
    RADII,
    RANGE,
    RELEASING,
)
from case_studies.paper.readings import rms
from case_studies.paper.varying import FrictionLaw, turning
from dualcam import Fmu
from dualcam.design import Helix, optimum

PAGE = ROOT / "docs" / "paper.md"
each_pair = pytest.mark.parametrize("name", PAIRS)
each_grease = pytest.mark.parametrize("mu", GREASES)
each_way = pytest.mark.parametrize("way", DIRECTIONS)


@pytest.fixture(scope="module")
def work():
    build = ROOT / "build"
    with Fmu(build / "DualCamInverse.fmu") as inverse, Fmu(build / "DualCamForward.fmu") as forward:
        yield fmus.FmuResults(inverse, forward)


def balance(lead, radii, friction, way, force=1):
    """Reactions (totals) and torque from force and moment vectors at the two contacts, by mpmath.

    The pin moves along (x, z): cam 1's groove goes (cos, sin), cam 2's, as the cam sees the pin come from the
    other side, (-cos, sin); normals point up, friction is against the motion along the groove."""
    m, unit = mpmath, ((1, 0), (-1, 0))
    rows = m.matrix(2, 2)
    pull = []
    for i, (side, _) in enumerate(unit):
        along = (side * m.cos(lead[i]), m.sin(lead[i]))
        normal = (-side * m.sin(lead[i]), m.cos(lead[i]))
        on_pin = [n - way * friction[i] * a for n, a in zip(normal, along, strict=True)]
        rows[0, i], rows[1, i] = on_pin[1], radii[i] * on_pin[0]
        pull.append(radii[i] * on_pin[0])
    reactions = m.lu_solve(rows, m.matrix([force, 0]))
    return reactions[0], reactions[1], pull[1] * reactions[1]


def eta(lead, radii, friction):
    return balance(lead, radii, friction, RELEASING)[2] / balance(lead, radii, friction, LOADING)[2]


# ---- the page ----


def test_page_is_what_the_script_computes(work):
    assert PAGE.read_text(encoding="utf-8") == paper.page(work)


def test_pictures_are_all_there_and_drawn(work):
    named = set(re.findall(r"\]\((paper_\w+\.png)\)", PAGE.read_text(encoding="utf-8")))
    assert named == {f"paper_{name}.png" for name in paper.PICTURES}
    for name, draw in paper.PICTURES.items():
        assert (ROOT / "docs" / f"paper_{name}.png").read_bytes().startswith(b"\x89PNG")
        assert draw(work).axes


# ---- efficiency ----


@pytest.mark.parametrize(("mu", "best"), [(0.14, 0.5690981841), (0.19, 0.4633147377)])
def test_optimum_of_equal_friction(work, mu, best):
    x, y, found = work.best_on_grid(mu)
    assert (x, y) == pytest.approx((math.pi / 4, math.pi / 4), abs=1e-12)
    assert found == pytest.approx(best, abs=5e-11)
    with mpmath.workdps(40):
        exact = eta(
            (mpmath.pi / 4,) * 2, (mpmath.mpf("0.013"), mpmath.mpf("0.03")), (mpmath.mpf(str(mu)),) * 2
        )
        assert abs(float(exact) - best) < 5e-11


def test_efficiency_of_formula_and_fmu_is_that_of_the_balance(work):
    random = np.random.default_rng(3)
    for _ in range(60):
        lead = tuple(map(float, random.uniform(0.3, 1.1, 2)))
        radii = tuple(map(float, random.uniform(0.01, 0.03, 2)))
        friction = tuple(map(float, random.uniform(0.05, 0.25, 2)))
        exact = float(eta(lead, radii, friction))
        assert float(efficiency(lead, friction, radii)) == pytest.approx(exact, rel=1e-12)
        assert fmus.efficiency_of_fmu(work.inverse, lead, friction, radii) == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize(("friction", "radii"), [((0.14, 0.19), (0.02, 0.025)), ((0.25, 0.08), (0.03, 0.01))])
def test_optimum_of_unequal_friction(work, friction, radii):
    """Gradient zero and Hessian negative, by differences of the balance; a search comes to the same."""
    found = optimum(friction, radii)
    (x, y), best = found.lead_angle, found.efficiency
    with mpmath.workdps(40):

        def value(a, b):
            return eta((a, b), tuple(map(mpmath.mpf, radii)), tuple(map(mpmath.mpf, friction)))

        slopes = [mpmath.diff(value, (x, y), n) for n in ((1, 0), (0, 1))]
        xx, xy, yy = (mpmath.diff(value, (x, y), n) for n in ((2, 0), (1, 1), (0, 2)))
        assert max(map(abs, slopes)) < 1e-14
        assert xx < 0 < xx * yy - xy**2
        assert float(value(x, y)) == pytest.approx(best, abs=1e-14)
    assert searched_optimum(friction, radii) == pytest.approx((x, y, best), abs=1e-6)
    assert fmus.efficiency_of_fmu(work.inverse, (x, y), friction, radii) == pytest.approx(best, abs=1e-12)


def product_of_sines(x, y, phi):
    """Efficiency for equal radii, from cot a + cot b = sin(a + b)/(sin a sin b)."""
    return (np.sin(x + y + 2 * phi) * np.sin(x - phi) * np.sin(y - phi)) / (
        np.sin(x + y - 2 * phi) * np.sin(x + phi) * np.sin(y + phi)
    )


def test_pole_and_corner():
    mu, phi = GREASES[0], math.atan(GREASES[0])
    for x in (0.02, 0.1, 0.13):
        near = [abs(float(efficiency((x, 2 * phi - x + d), (mu, mu), (0.02, 0.02)))) for d in (-1e-9, 1e-9)]
        assert min(near) > 1e5
    share, smaller = beyond_one(mu)
    assert smaller < phi

    axis = (np.arange(2500) + 0.5) / 2500 * 0.5 * math.pi
    x, y = np.meshgrid(axis, axis)
    assert share == pytest.approx(np.mean(np.abs(product_of_sines(x, y, phi)) > 1), abs=5e-5)
    both = np.minimum(x, y) > phi
    assert np.max(np.abs(product_of_sines(x, y, phi)[both])) < 1


# ---- torque and reactions ----


def place(cams, theta):
    """Lead angles and stroke where both grooves have the same height: arcs of circles given by the angle of
    its tangent, x = size (sin - sin lead), z = size (cos lead - cos) when steepening, else mirrored."""
    m = mpmath

    def at(arc, tangent):
        turn = arc.bending * arc.a * (m.sin(tangent) - m.sin(arc.lead_angle)) / arc.radius
        return turn, arc.bending * arc.a * (m.cos(arc.lead_angle) - m.cos(tangent))

    def gap(first, second):
        (turn1, z1), (turn2, z2) = at(cams.inner, first), at(cams.outer, second)
        return [turn1 + turn2 - theta, z1 - z2]

    found = m.findroot(gap, (cams.inner.lead_angle, cams.outer.lead_angle))
    return (found[0], found[1]), at(cams.inner, found[0])[1]


@each_pair
def test_curves_are_those_of_the_balance(work, name):
    cams = pair(name)
    _, stroke = place(cams, RANGE)
    assert cams.stroke == pytest.approx(float(stroke), rel=1e-13)
    for index in (0, 20, 41, 56):
        lead, z = place(cams, work.angle[index])
        force = cams.force * (cams.preload + (1 - cams.preload) * z / stroke)
        for mu in GREASES:
            for way in DIRECTIONS:
                drawn = work.curves[name, mu, way]
                r1, r2, torque = balance(lead, RADII, (mu, mu), way, force)
                assert drawn.torque[index] == pytest.approx(float(torque), rel=1e-10)
                reactions = [reaction[index] for reaction in drawn.reactions]
                assert reactions == pytest.approx([float(r1) / 2, float(r2) / 2], rel=1e-10)


@each_pair
@each_grease
def test_formula_meets_the_fmu_everywhere(work, name, mu):
    statics = Statics(pair(name), work.angle)
    for way in DIRECTIONS:
        drawn = work.curves[name, mu, way]
        assert np.max(np.abs(drawn.torque - statics.torque(way, mu))) < 1e-9
        for mine, theirs in zip(statics.reactions(way, mu), drawn.reactions, strict=True):
            assert np.max(np.abs(mine - theirs)) < 1e-9
    assert statics.torque(LOADING).max() == pytest.approx(published.TORQUE, rel=1e-6)


@each_pair
@each_grease
def test_heat_is_the_area_and_the_friction_power(work, name, mu):
    up, down = (work.curves[name, mu, way] for way in DIRECTIONS)
    assert work.heat[name, mu] == pytest.approx(simpson(up.torque - down.torque, x=work.angle), rel=1e-6)
    power = sum(
        mu * published.CONTACTS * reaction * sliding
        for drawn in (up, down)
        for reaction, sliding in zip(drawn.reactions, drawn.sliding, strict=True)
    )
    assert work.heat[name, mu] == pytest.approx(simpson(power, x=work.angle), rel=1e-6)


@each_pair
def test_which_cam_turns_does_not_matter(work, name):
    cams = pair(name)
    swapped = Pair(cams.outer, cams.inner, cams.preload, cams.force)
    drawn = fmus.curve(work.inverse, swapped, GREASES[0], LOADING, work.angle)
    assert drawn.torque == pytest.approx(work.curves[name, GREASES[0], LOADING].torque, rel=1e-10)


@each_pair
def test_other_pairs_keep_to_the_published_facts(work, name):
    assert len(work.others[name]) == published.OTHERS
    for cams, up, down in work.others[name]:
        assert cams.inner.lead_angle == published.ARCS[name][0]
        assert (cams.outer.a < cams.inner.a) == (name == "A")
        assert up.max() == pytest.approx(published.TORQUE, rel=1e-3)
        assert np.all(down < up)


# ---- errata ----


@each_way
def test_torque_of_two_helices(work, way):
    case = Case()
    exact = float(balance(case.lead, case.radii, (case.friction,) * 2, way, case.force)[2])
    fmu = dict(zip(DIRECTIONS, fmus.torques_of_fmu(work, case), strict=True))
    assert [case.correct(way), case.balance(way), fmu[way]] == pytest.approx([exact] * 3, rel=1e-12)


def test_printed_formulas_are_off_as_the_page_says():
    level = Case(radii=(0.02, 0.02))
    t1, t2 = level.tangents()
    assert abs(level.printed_3()) / level.correct() == pytest.approx((t1 + t2) / abs(t1 - t2), rel=1e-12)
    assert level.tangential() == pytest.approx(level.correct(), rel=1e-12)
    assert level.swapped() == pytest.approx(level.correct(), rel=1e-12)
    # Without friction the work put in must be what the force takes: T = F z', z' = a1 a2/(a1 + a2).
    free = Case(friction=0.0)
    a1, a2 = (r * math.tan(x) for r, x in zip(free.radii, free.lead, strict=True))
    assert free.correct() == pytest.approx(free.force * a1 * a2 / (a1 + a2), rel=1e-12)
    assert abs(free.tangential() / free.correct() - 1) > 0.1
    assert abs(free.swapped() / free.correct() - 1) > 0.02


def test_sign_of_friction_and_of_the_damper(work):
    case = Case()
    pulled, speed = fmus.pull_of_fmu(work, case)
    force = case.force + published.PULL
    assert pulled == pytest.approx(force * case.correct(RELEASING) / case.force, rel=1e-12)
    assert pulled - force * speed > 0 > force * case.correct(LOADING) / case.force - force * speed
    damper, torque = fmus.damper_of_fmu(work, case)
    assert damper == pytest.approx(-published.QUADRATIC * published.SPEED**2, rel=1e-12)
    assert torque == pytest.approx((case.force + damper) * case.correct(RELEASING) / case.force, rel=1e-12)


# ---- uncertainty, readings, friction ----


def test_budget():
    budget = readings.uncertainty_budget()
    assert budget.as_sine == pytest.approx(0.0524, abs=5e-5)
    assert budget.as_cosine == pytest.approx(2 * math.sin(published.TILT / 2) ** 2, rel=1e-10)
    assert math.hypot(budget.rest, budget.as_cosine) * published.TORQUE == pytest.approx(0.029, rel=1e-12)
    mean = quad(lambda x: 1 - math.cos(x), 0, published.TILT)[0] / published.TILT
    square = quad(lambda x: (1 - math.cos(x)) ** 2, 0, published.TILT)[0] / published.TILT
    assert budget.bias == pytest.approx(mean, rel=1e-9)
    assert budget.spread == pytest.approx(math.sqrt(square - mean**2), rel=1e-6)


DENSITIES = {  # of the distance from the line, and where it ends
    "anywhere, all alike": (lambda u: 1.0, 1.0),
    "rather near the line (triangular)": (lambda u: 2.0 - 2.0 * u, 1.0),
    "in the near half": (lambda u: 2.0, 0.5),
    "in the near quarter": (lambda u: 4.0, 0.25),
}


@pytest.mark.parametrize("draw", readings.DRAWS)
def test_readings_against_the_integral(draw):
    density, end = DENSITIES[draw]
    assert quad(density, 0, end)[0] == pytest.approx(1, rel=1e-12)
    share = math.sqrt(quad(lambda u: u**2 * density(u), 0, end)[0])
    many = np.linspace(1.0, 4.0, 400)
    found, _ = readings.readings(many, draw, series=500)
    assert found.exact == pytest.approx(share * rms(many), rel=1e-12)
    assert found.mean == pytest.approx(found.exact, rel=2e-3)
    assert found.low < found.exact < found.high


@each_pair
@each_grease
def test_part_of_the_band_that_the_published_rmse_needs(name, mu):
    band = readings.band_at_readings(name, mu)
    for error in PUBLISHED[name].values():
        part = readings.share_needed(error, band)
        assert 0 < part < 1
        assert math.sqrt(np.mean(quad(lambda u: u**2, 0, part)[0] / part * band**2)) == pytest.approx(error)


@each_pair
@each_grease
@each_way
def test_the_fmu_with_the_friction_found_has_the_published_rmse(work, name, mu, way):
    statics = Statics(pair(name), work.angle)
    for sign in (1, -1):
        friction = readings.friction_for(statics, mu, way, PUBLISHED[name][way], sign)
        assert sign * (friction - mu) > 0
        other = fmus.curve(work.inverse, pair(name), friction, way, work.angle)
        assert rms(other.torque - work.curves[name, mu, way].torque) == pytest.approx(
            PUBLISHED[name][way], rel=1e-8
        )


@each_way
def test_error_of_friction_that_falls_with_the_load(way):
    """Equal helices of 45 deg under one force carry one load: both laws agree there, up to the 1.01^(-n/2) of
    docs/mechanism.md, section 9."""
    helix = Helix(0.02, math.pi / 4)
    statics = Statics(Pair(helix, helix, preload=1.0, force=600.0), np.linspace(0.0, 0.5, 5))
    mu = 0.14 * 1.01 ** (-1 / 4)
    ratio = ((1 + way * mu) / (1 - way * mu)) / ((1 + way * 0.14) / (1 - way * 0.14))
    expected = abs(ratio - 1) * statics.torque(way, 0.14)[0]
    assert readings.law_error(statics, 0.14, 1 / 2, way) == pytest.approx([expected] * 3, rel=1e-6)


def test_what_the_words_on_friction_claim(work):
    _, factors = needed_friction(work)
    for mu in GREASES:
        loading, releasing = (factors["B", mu, way] for way in DIRECTIONS)
        assert loading == pytest.approx(releasing, rel=0.04)  # the two directions agree in pair B,
        assert min(loading, releasing) > GREASES[1] / GREASES[0]
        assert factors["A", mu, RELEASING] > 1.2 * factors["A", mu, LOADING]  # not in pair A,
        statics = Statics(pair("B"), work.angle)  # and worse in pair B with less friction
        less = [readings.friction_for(statics, mu, way, PUBLISHED["B"][way], -1) for way in DIRECTIONS]
        assert less[1] > (2.0 if mu == GREASES[0] else 1.15) * less[0]
    for way in DIRECTIONS:
        assert max(readings.law_error(statics, GREASES[0], 1 / 2, way)) < PUBLISHED["B"][way]
    grease = rms(statics.torque(LOADING, GREASES[1]) - statics.torque(LOADING, GREASES[0]))
    assert grease < PUBLISHED["B"][LOADING]


def test_what_the_words_on_readings_claim():
    for name in PAIRS:
        for mu in GREASES:
            found, ratio = readings.readings(readings.band_at_readings(name, mu), "anywhere, all alike")
            assert max(PUBLISHED[name].values()) < found.exact
            assert max(PUBLISHED[name].values()) / min(PUBLISHED[name].values()) > ratio[1]


@pytest.mark.parametrize("ratio", [1.05, 1.29, 3.0])
def test_largest_change_of_a_stribeck_curve(ratio):
    speed = np.linspace(1e-3, 10, 200_001)
    assert readings.largest_change(ratio) == pytest.approx(
        np.max(np.exp(-speed) - np.exp(-ratio * speed)), rel=1e-7
    )


# ---- the budget by Monte Carlo ----


def test_budget_by_monte_carlo():
    """Mean of the cosine and moments of the product in closed form; the model's budget to first order."""
    budget, torque = readings.uncertainty_budget(), measurement()
    cosine = 1.0 - budget.bias
    exact = math.hypot(cosine * budget.rest, budget.spread, budget.rest * budget.spread)
    assert torque.standard_deviation[0] / published.TORQUE == pytest.approx(exact, rel=0.01)
    error = published.TORQUE * exact / math.sqrt(len(torque.values))
    assert torque.mean[0] == pytest.approx(published.TORQUE * cosine, abs=4.0 * error)
    assert torque.budget.standard_uncertainty[0] == pytest.approx(published.TORQUE * budget.rest, rel=1e-12)
    assert torque.standard_deviation[0] < published.UNCERTAINTY * published.TORQUE  # on the safe side


@each_pair
@each_way
def test_what_the_words_on_tolerances_claim(work, name, way):
    found = model(name)[QUANTITY[way]]
    middle = model(name).nearest(0.5 * RANGE)
    first, second = found.budget.standard_uncertainty[middle], found.standard_deviation[middle]
    assert first == pytest.approx(second, rel=0.02)
    assert max(found.budget.contribution[:, middle]) == found.budget.contribution[0, middle] > 50.0
    assert len(names()) == len(found.budget.names)
    # friction's part by another derivative: the FMU's torque at both ends
    angle = np.array([model(name).theta[middle]])
    h = 1e-5
    ends = [
        fmus.curve(work.inverse, pair(name), GREASES[0] + sign * h, way, angle).torque[0] for sign in (1, -1)
    ]
    slope = (ends[0] - ends[1]) / (2 * h)
    assert found.budget.sensitivity[0, middle] == pytest.approx(slope, rel=1e-2)  # the FMU has no clearance


# ---- friction that varies ----


@each_pair
@each_grease
@each_way
@pytest.mark.parametrize("sliding", [0.001, 0.01, 0.1])
def test_friction_over_speed_is_that_of_the_fmu(work, name, mu, way, sliding):
    angle = np.linspace(0.0, RANGE, 8)
    statics = Statics(pair(name), angle)
    speed = turn_rate(statics, sliding)
    for law in (speed_law(mu), FrictionLaw(mu, 1.6, 0.003, 1), FrictionLaw(mu, viscous=0.5)):
        mine = turning(statics, law, way, speed)
        drawn = fmus.curve(work.inverse, pair(name), mu, way, angle, speed, law)
        assert mine.torque == pytest.approx(drawn.torque, rel=1e-11)
        for both in zip(mine.reactions, drawn.reactions, strict=True):
            assert both[0] == pytest.approx(both[1], rel=1e-11)
        for both in zip(mine.sliding, drawn.sliding, strict=True):
            assert both[0] == pytest.approx(both[1], rel=1e-11)


@each_pair
@each_way
@pytest.mark.parametrize("exponent", [-2 / 3, -1 / 3, 1 / 3, 2 / 3])
def test_friction_over_load_solves_the_balance(name, way, exponent):
    """`balance` at the coefficients of the law under the reactions without friction."""
    angle = np.linspace(0.0, RANGE, 5)
    cams, statics = pair(name), Statics(pair(name), angle)
    law = FrictionLaw(GREASES[1], 1.3, 0.01, 2, 0.3, exponent, 200.0)
    found = turning(statics, law, way, 0.5)
    for k, theta in enumerate(angle):
        lead, z = place(cams, float(theta))
        force = cams.spring.force(float(z))
        friction = [float(mu[k]) for mu in found.friction]
        loads = balance(lead, RADII, [0.0, 0.0], way, float(force))[:2]
        r1, r2, torque = balance(lead, RADII, friction, way, float(force))
        assert found.torque[k] == pytest.approx(float(torque), rel=1e-10)
        assert [float(r1) / 2, float(r2) / 2] == pytest.approx([r[k] for r in found.reactions], rel=1e-10)
        for mu, load, v in zip(friction, loads, found.sliding, strict=True):
            fall = 1.0 + 0.3 * math.exp(-((v[k] / 0.01) ** 2))
            pressed = ((float(load) / 2 / 200.0) ** 2 + 0.01) ** (exponent / 2)
            exact = GREASES[1] * fall * pressed + 0.3 * v[k]
            assert mu == pytest.approx(exact, rel=1e-10)


def test_a_contact_locks_where_friction_reaches_its_slope():
    statics = Statics(pair("B"), np.array([RANGE]))
    slope = min(float(one[0]) for one in statics.slopes)
    assert np.isnan(turning(statics, FrictionLaw(1.01 * slope), RELEASING).torque).all()
    assert np.isfinite(turning(statics, FrictionLaw(0.9 * slope), RELEASING).torque).all()
    grown = turning(statics, FrictionLaw(0.8 * slope, load_exponent=0.5, load=10.0), RELEASING)
    assert np.isnan(grown.torque).all()


@each_grease
def test_what_the_words_on_friction_that_varies_claim(mu):
    at_rest = {
        (name, way): abs(
            np.mean(at_speed(name, mu, way, 0.0).torque - Statics(pair(name), ANGLE).torque(way, mu))
        )
        for name in PAIRS
        for way in DIRECTIONS
    }
    for (name, way), change in at_rest.items():
        assert (change > PUBLISHED[name][way]) == ((name, way) == ("A", LOADING))
    speeds = [np.mean(speed_law(mu).at(np.array(v), np.array(published.LOAD))) for v in published.SLIDING]
    assert speeds[0] == max(speeds) and min(speeds) == speeds[3] and speeds[4] > speeds[3]
    for exponent, sign in ((-1 / 3, -1), (1 / 3, 1)):
        for name in PAIRS:
            for way in DIRECTIONS:
                line = Statics(pair(name), ANGLE)
                change = turning(line, load_law(mu, exponent), way).torque - line.torque(way, mu)
                assert sign * way * change[0] < 0.0 < sign * way * change[-1]
    # pair B by a factor alone, pair A by no law, both by none
    assert best("B", mu, 0.0, 0.0).misfit < 1.1
    assert best("B", mu, 0.0, 0.0).factor > published.PEAK
    assert best("A", mu, -1 / 3, 1 / 3).misfit > 1.3
    assert best("A", mu, 0.0, 1 / 3).misfit > best("A", mu, -1 / 3, 0.0).misfit
    assert best("AB", mu, -2 / 3, 2 / 3).misfit > 1.5
    assert others(mu, 1 / 3).together.min() > 1.25


@each_grease
@pytest.mark.parametrize("which", ["A", "B", "AB"])
def test_the_law_that_comes_nearest_is_found_by_a_search_too(mu, which):
    """Nelder and Mead from there find nothing better than the grid's width."""

    def miss(x):
        worst = 0.0
        for name in which:
            statics = Statics(pair(name), np.linspace(0.0, RANGE, 29))
            for way in DIRECTIONS:
                law = FrictionLaw(mu * x[0], load_exponent=x[1], load=published.LOAD)
                error = rms(turning(statics, law, way).torque - statics.torque(way, mu))
                worst = max(worst, abs(math.log(error / PUBLISHED[name][way])))
        return worst if abs(x[1]) <= 1 / 3 + 1e-12 else 9.0

    grid = best(which, mu, -1 / 3, 1 / 3)
    start = [grid.factor, 0.999 * grid.exponent]
    simplex = [start, [start[0] + 0.02, start[1]], [start[0], 0.95 * start[1] + 0.01]]
    found = minimize(miss, start, method="Nelder-Mead", options={"initial_simplex": simplex, "maxfev": 120})
    assert math.exp(found.fun) > grid.misfit - 0.005
    assert math.exp(miss([grid.factor, grid.exponent])) == pytest.approx(grid.misfit, rel=1e-6)
