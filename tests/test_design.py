"""dualcam.design: the best lead angles, grooves for a wanted torque (run in the FMU), strength."""

import math
import re

import matplotlib
import numpy as np
import pytest
from driver import ROOT, models
from matplotlib.figure import Figure
from scipy.integrate import quad
from scipy.optimize import brentq, minimize

from dualcam import ContinuousFmu, Fmu
from dualcam.design import (
    Cycloid,
    Ellipse,
    Helix,
    Limits,
    Mechanism,
    Pin,
    Spring,
    Table,
    assess,
    band_factors,
    curvature,
    efficiency,
    efficiency_map,
    hertz_pressure,
    optimum,
    synthesize,
    torque_band,
)
from dualcam.errors import DesignError

matplotlib.use("Agg")
FORWARD, INVERSE = (model.fmu for model in models.values())
UPPER = 1.3963
LINEAR, CUBIC, SOFTENING, BARE = (
    Spring(50, 50e3),
    Spring(80, 20e3, 4e5, 3e7),
    Spring(150, 3e4, -4e5),
    Spring(0, 4e4),
)
HELIX = Helix(0.02, math.pi / 4)
PAIR = Mechanism((HELIX, HELIX), (0.1, 0.1), LINEAR, UPPER)
QUASI_STATIC = {"inertia.shaft": 0.0}


@pytest.fixture(scope="module")
def forward():
    with ContinuousFmu(FORWARD) as fmu:
        yield fmu


@pytest.fixture(scope="module")
def inverse():
    with Fmu(INVERSE) as fmu:
        yield fmu


def slow_torque(fmu, parameters, angles, speed=1e-3):
    """tau of DualCamInverse along the angles in their order, at that speed [rad/s]."""
    step = (angles[1] - angles[0]) / speed
    fmu.start({**parameters, **QUASI_STATIC, "theta": angles[0], "omega": speed})
    motion, torque = fmu.reals("theta", "omega"), fmu.reals("tau")
    found = []
    for angle in angles[1:]:
        motion.values[:] = angle, speed
        motion.write()
        fmu.step(step)
        found.append(torque.read()[0])
    return np.array(found)


def read_at(fmu, parameters, angles, *names):
    """Variables of DualCamForward at rest at the angles, shape (names, angles)."""
    fmu.start(parameters)
    group, found = fmu.reals(*names), []
    for angle in angles:
        fmu.set_states_and_mode((angle, 0.0))
        found.append(group.read())
    return np.array(found).T


# ---- lead angles ----


@pytest.mark.parametrize(("mu", "eta"), [(0.14, 0.5690981841), (0.19, 0.4633147377)])
def test_optimum_of_equal_friction(mu, eta):
    for radius in ((1.0, 1.0), (0.02, 0.05)):
        best = optimum((mu, mu), radius)
        assert best.efficiency == pytest.approx(eta, abs=5e-11)
        assert best.lead_angle == pytest.approx((math.pi / 4, math.pi / 4), abs=1e-15)
    assert optimum((0.0, 0.0)).efficiency == 1.0


@pytest.mark.parametrize(
    ("friction", "radius"),
    [
        ((0.14, 0.14), (0.02, 0.03)),
        ((0.1, 0.2), (0.02, 0.03)),
        ((0.4, 0.02), (0.05, 0.01)),
        ((0.9, 0.3), (1, 1)),
    ],
)
def test_optimum_by_search(friction, radius):
    """By a grid over all that is driven back, then by simplex, of kappa written with trigonometry."""
    phi = np.arctan(friction)

    def eta(lead):
        up, down = (sum(1 / (np.tan(lead[i] + s * phi[i]) * radius[i]) for i in range(2)) for s in (1, -1))
        return up / down

    grids = [np.linspace(p, math.pi / 2 - p, 202)[1:-1] for p in phi]
    mesh = np.meshgrid(*grids, indexing="ij")
    values = eta(mesh)
    j, k = np.unravel_index(np.argmax(values), values.shape)
    found = minimize(
        lambda x: -eta(x),
        (grids[0][j], grids[1][k]),
        method="Nelder-Mead",
        options={"xatol": 1e-9, "fatol": 1e-16},
    )
    best = optimum(friction, radius)
    assert best.lead_angle == pytest.approx(found.x, abs=1e-6)
    assert best.efficiency == pytest.approx(-found.fun, abs=1e-13)
    assert values.max() <= best.efficiency
    assert efficiency(best.lead_angle, friction, radius) == pytest.approx(best.efficiency, rel=1e-14)


@pytest.mark.parametrize(
    "friction", [(0.1, 0.0), (0.0, 0.1), (1.0, 1.0), (2.0, 0.7), (-0.1, 0.1), (math.nan, 0.1)]
)
def test_no_optimum(friction):
    with pytest.raises(DesignError, match="friction"):
        optimum(friction)


def test_efficiency_is_the_fmus(forward):
    """Driven back, one contact locked, both locked; jammed pairs are refused by the FMU."""
    rng = np.random.default_rng(5)
    compared = set()
    for _ in range(60):
        lead, mu = rng.uniform(0.03, 1.5, 2), rng.uniform(0.0, 0.6, 2)
        radius = rng.uniform(0.01, 0.05, 2)
        ours = float(efficiency(lead, mu, radius))
        release, load = (float(x) for x in band_factors(radius * np.tan(lead), mu, radius))
        parameters = {f"cam{i + 1}.{n}": v[i] for i in range(2) for n, v in
                      (("lead_angle", lead), ("friction", mu), ("radius", radius))}  # fmt: skip
        if not math.isfinite(load):
            with pytest.raises(ValueError, match="jam when loading"):
                forward.start(parameters)
            compared.add("jammed")
            continue
        found = read_at(
            forward, parameters, [0.3], "efficiency", "torque_release", "torque_load", "spring.force"
        )[:, 0]
        assert ours == pytest.approx(found[0], rel=1e-12)
        assert [release * found[3], load * found[3]] == pytest.approx(found[1:3], rel=1e-12)
        compared.add(int((lead <= np.arctan(mu)).sum()))
    assert compared == {0, 1, 2, "jammed"}


def test_efficiency_map():
    way = efficiency_map((0.1, 0.2), (0.02, 0.03), points=89)
    j, k = 50, 30
    single = efficiency((way.lead_angle[k], way.lead_angle[j]), (0.1, 0.2), (0.02, 0.03))
    assert way.efficiency[j, k] == pytest.approx(single, rel=1e-15)
    best = optimum((0.1, 0.2), (0.02, 0.03))
    assert best.efficiency - 1e-3 < way.efficiency.max() <= best.efficiency
    figure = Figure()
    axes = figure.subplots()
    figure.colorbar(way.draw(axes))
    figure.canvas.draw()
    assert "lead angle" in axes.get_xlabel()


# ---- grooves ----


def numeric_curvature(groove, psi, h):
    """Of the path through five points, by differences of fourth order."""
    x, z = np.array([[groove.radius * (psi + k * h), groove.at(psi + k * h).z] for k in range(-2, 3)]).T
    first = (z[0] - 8 * z[1] + 8 * z[3] - z[4]) / (12 * h * groove.radius)
    second = (-z[0] + 16 * z[1] - 30 * z[2] + 16 * z[3] - z[4]) / (12 * (h * groove.radius) ** 2)
    assert x[4] > x[0]
    return second / (1 + first**2) ** 1.5


@pytest.mark.parametrize("bending", [-1, 1])
@pytest.mark.parametrize(("a", "b"), [(0.05, 0.05), (0.04, 0.09)])
def test_curvature_of_ellipse(bending, a, b):
    """a b/(a^2 sin^2 t + b^2 cos^2 t)^(3/2) at the ellipse's parameter t; 1/a of a circle."""
    ellipse = Ellipse(0.02, 0.6, a, b, bending)
    for psi in (0.0, 0.2, 0.5):
        S = math.sin(math.atan(a / b * math.tan(0.6))) + bending * 0.02 * psi / a  # x/a along the ellipse
        exact = bending * a * b / (b**2 * S**2 + a**2 * (1 - S**2)) ** 1.5
        assert curvature(ellipse, psi) == pytest.approx(exact, rel=1e-12)
        assert numeric_curvature(ellipse, psi, 1e-3) == pytest.approx(exact, rel=1e-6)
    if a == b:
        assert curvature(ellipse, 0.3) == pytest.approx(bending / a, rel=1e-12)


def test_cycloid_is_the_fmus(forward):
    """z and both derivatives by theta, against a helix so steep that theta is the angle in the cycloid."""
    cycloid, steep = Cycloid(0.02, 0.015, 1.2), Helix(0.02, 1.5)
    mechanism = Mechanism((cycloid, steep), (0.1, 0.1), LINEAR, 1.2)
    given = mechanism.parameters_without_tables()
    angles = np.linspace(0.0, 1.2, 61)
    z, gamma, load = read_at(forward, given, angles, "z", "gamma", "torque_load")
    assert np.abs(cycloid.at(gamma).z - z).max() <= 1e-16
    assert np.abs(mechanism.configuration(angles).z - z).max() <= 1e-15
    assert np.abs(mechanism.torque(angles, "loading") - load).max() <= 1e-12 * load.max()
    for end, height in ((-0.5, 0.0), (0.0, 0.0), (1.2, 0.015), (9.0, 0.015)):
        assert tuple(map(float, cycloid.at(end))) == (height, 0.0, 0.0)
    assert [numeric_curvature(cycloid, x, 1e-3) for x in (0.2, 0.9)] == pytest.approx(
        [float(curvature(cycloid, x)) for x in (0.2, 0.9)], rel=1e-5
    )


def test_curvature_of_helix_and_table():
    assert (curvature(HELIX, np.linspace(-1, 1, 5)) == 0.0).all()
    ellipse, psi = Ellipse(0.02, 0.6, 0.05, 0.05, 1), np.linspace(0.0, 1.0, 400)
    table = Table(0.02, psi, ellipse.at(psi).z)
    assert curvature(table, 0.5013) == pytest.approx(20.0, rel=1e-6)


@pytest.mark.parametrize("kind", ["smooth", "dwell", "four", "rough"])
def test_table_is_the_fmus_curve(forward, tmp_path, kind):
    """Torque of the FMU at both edges with rough tables, where every branch of the rule acts."""
    rng = np.random.default_rng(11)
    count = {"four": 4}.get(kind, 15)
    psi = np.sort(np.append(rng.uniform(0.02, 1.4, count - 2), [0.0, 1.5]))
    rise = rng.uniform(0.2, 1.0, count - 1) ** (6 if kind == "rough" else 1)
    rise[5:7] *= kind != "dwell"
    z = np.append(0.0, np.cumsum(rise * np.diff(psi) if kind != "smooth" else np.diff(np.sin(psi)))) * 0.02
    mechanism = Mechanism((Table(0.02, psi, z), Helix(0.03, 0.9)), (0.1, 0.15), LINEAR, 1.3)
    angles = np.linspace(0.0, 1.3, 40)
    found = read_at(
        forward, mechanism.parameters(tmp_path), angles, "torque_release", "torque_load", "z", "gamma"
    )
    release, load = mechanism.band(angles)
    configuration = mechanism.configuration(angles)
    for ours, theirs in zip((release, load, configuration.z, configuration.psi[0]), found, strict=True):
        assert ours == pytest.approx(theirs, rel=1e-9, abs=1e-10)
    again = Table.read(tmp_path / "groove1.csv", 0.02)
    assert (again.psi == psi).all() and (again.z == z).all()


@pytest.mark.parametrize("centre", [0.3, 0.5])
def test_pin_in_a_steep_groove(centre):
    """A groove with a nearly upright stretch, where Newton's method alone goes to and fro between its two
    sides: gamma by bisection."""
    psi = np.linspace(0.0, 1.0, 2001)
    steep = Table(0.03, psi, 0.002 * psi + 0.01 * (np.tanh((psi - centre) / 0.01) + 1.0))
    mechanism = Mechanism((steep, HELIX), (0.1, 0.1), LINEAR, 1.8)
    angles = np.linspace(0.0, 1.8, 301)
    gamma = mechanism.configuration(angles).psi[0]
    for theta, ours in zip(angles, gamma, strict=True):
        root = brentq(lambda g, t=theta: float(steep.at(g).z - HELIX.at(t - g).z), -1.0, 1.0, xtol=1e-15)
        assert ours == pytest.approx(root, abs=1e-13)


@pytest.mark.parametrize(
    ("psi", "z", "word"),
    [
        ([0, 1, 2], [0, 1, 2], "n >= 4"),
        ([0, 1, 1, 2], [0, 1, 2, 3], "increase"),
        ([0, 1, 2, 3], [0, 1, 0.5, 2], "decreases"),
        ([1, 2, 3, 4], [0, 1, 2, 3], "psi = 0"),
    ],
)
def test_bad_tables(psi, z, word):
    with pytest.raises(DesignError, match=word):
        Table(0.02, psi, z)


def test_bad_grooves(tmp_path):
    for make in (
        lambda: Helix(0.0, 0.5),
        lambda: Helix(0.02, 1.6),
        lambda: Ellipse(0.02, 0.5, -1.0, 0.05),
        lambda: Ellipse(0.02, 0.5, 0.05, 0.05, 2),
        lambda: Ellipse(0.02, 0.5, 0.05, math.inf),
        lambda: Cycloid(0.02, 0.0, 1.0),
        lambda: Cycloid(0.02, 0.02, math.inf),
    ):
        with pytest.raises(DesignError, match="allowed"):
            make()
    (tmp_path / "x.csv").write_text("a,b\n1,2\n")
    with pytest.raises(DesignError, match="psi_rad,z_m"):
        Table.read(tmp_path / "x.csv", 0.02)


# ---- the inverse problem ----

ANGLES = np.linspace(0.0, UPPER, 12)
OWN_TABLE = Table(0.025, np.linspace(0.0, 1.5, 60), 0.02 * np.sin(np.linspace(0.0, 1.5, 60)))
UNEQUAL = {"friction": (0.1, 0.2)}
SLIPPERY = {"friction": (0.0, 0.05)}
CASES = {
    "constant, loading, equal": (lambda t: 2.0, LINEAR, "loading", {}),
    "sine, loading, helix": (lambda t: 1 + 2 * np.sin(t), LINEAR, "loading", {"groove2": HELIX}),
    "sine, releasing, helix": (lambda t: 0.6 + np.sin(t), LINEAR, "releasing", {"groove2": HELIX}),
    "sine, loading, ellipse": (lambda t: 1 + 2 * np.sin(t), LINEAR, "loading",
                               {"groove2": Ellipse(0.025, 0.8, 0.05, 0.05, -1)}),
    "releasing, ellipse, cubic": (lambda t: 0.6 + 0.8 * t**2, CUBIC, "releasing",
                                  {"groove2": Ellipse(0.02, 0.7, 0.06, 0.05, 1), **UNEQUAL}),
    "loading, own table, softening": (lambda t: 1.8 + 0.5 * np.cos(3 * t), SOFTENING, "loading",
                                      {"groove2": OWN_TABLE, **UNEQUAL}),
    "releasing, equal, unequal friction": (lambda t: 0.3 + np.sin(t), LINEAR, "releasing", UNEQUAL),
    "loading, equal, cubic": (lambda t: 1.5 + t, CUBIC, "loading", UNEQUAL),
    "frictionless, equal": (lambda t: 1.0 + np.sin(2 * t), LINEAR, "frictionless", {}),
    "frictionless, level start": (np.sin, LINEAR, "frictionless", {"groove2": HELIX}),
    "releasing from zero": (np.sin, LINEAR, "releasing", {"groove2": HELIX}),
    "no preload, helix": (lambda t: 2 * np.sin(t), BARE, "loading", {"groove2": HELIX}),
    "no preload, equal, releasing": (lambda t: 2 * np.sin(t), BARE, "releasing", SLIPPERY),
    "no preload, releasing, rough groove 2": (lambda t: 0.9 * np.sin(t), BARE, "releasing",
                                              {"groove2": Helix(0.03, math.pi / 3), "friction": (0.05, 0.3)}),
    "samples": ((ANGLES, 1.5 + 0.5 * np.sin(2 * ANGLES)), LINEAR, "loading", {"groove2": HELIX}),
    "kink": (lambda t: 1 + abs(t - 0.5), LINEAR, "loading", {"groove2": HELIX, "kinks": [0.5]}),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_groove_runs_in_the_fmu(inverse, forward, tmp_path, name):
    """tau in slow motion, and the edges of the stick band at rest, within 1e-6 of what was wanted; below
    1/1000 of the largest torque within 1e-9 of that."""
    torque, spring, direction, options = CASES[name]
    design = synthesize(torque, UPPER, spring, direction=direction, **options)
    parameters = design.mechanism.parameters(tmp_path)
    if direction == "frictionless":
        parameters |= {"cam1.friction": 0.0, "cam2.friction": 0.0}
    wanted = design.wanted(np.linspace(0.0, UPPER, 501))
    scale = np.maximum(np.abs(wanted), 1e-3 * wanted.max())
    angles, backwards = np.linspace(0.0, UPPER, 501), direction == "releasing"
    if backwards:
        found = slow_torque(inverse, parameters, angles[::-1], -1e-3)[::-1]
        off = (found - wanted[:-1]) / scale[:-1]
    else:
        off = (slow_torque(inverse, parameters, angles) - wanted[1:]) / scale[1:]
    assert np.abs(off).max() < 1e-6
    edge = "torque_release" if backwards else "torque_load"
    few = slice(0, None, 20)
    found = read_at(forward, parameters, angles[few], edge)[0]
    assert np.abs((found - wanted[few]) / scale[few]).max() < 1e-6
    assert np.abs(design.error(angles)).max() < 1e-6
    assert design.largest_error <= 1e-7


def random_task(number):
    """A wanted torque of four random waves, in reach of the spring at the start, for a random spring, range,
    friction and groove 2."""
    random = np.random.default_rng(number)
    upper, radius, preload = (
        random.uniform(0.2, 2.5),
        10 ** random.uniform(-2.5, -0.5),
        10 ** random.uniform(0, 3.5),
    )
    reach = radius * upper
    stiffness = random.uniform(0.3, 10.0) * preload / reach
    spring = Spring(
        preload,
        stiffness,
        random.uniform(-0.3, 0.3) * stiffness / reach,
        random.uniform(0, 0.5) * stiffness / reach**2,
    )
    second, lead = radius * random.uniform(0.5, 2.0), random.uniform(0.4, 1.1)
    angles = np.linspace(0.0, 1.2 * upper, 30)
    waves = 0.06 * random.uniform(-1, 1) * upper * np.sin(random.uniform(1, 5) * angles / upper)
    a, b = second * upper * random.uniform(3.0, 6.0, 2)
    groove2 = (
        None,
        Helix(second, lead),
        Ellipse(second, lead, a, b, int(random.choice([-1, 1]))),
        Table(second, angles, second * math.tan(lead) * (angles + waves)),
    )[number % 4]
    share, turns, phase = (
        random.normal(size=4),
        random.uniform(0.5, 8.0, 4) / upper,
        random.uniform(0, 6.3, 4),
    )
    height, base = 10 ** random.uniform(-2.0, -0.5), preload * radius * random.uniform(0.3, 0.7)

    def wanted(theta):
        return base * (1.0 + height * np.sin(np.multiply.outer(theta, turns) + phase) @ share)

    options = {"groove2": groove2, "friction": tuple(random.uniform(0.0, 0.3, 2)), "radius": radius}
    return wanted, upper, spring, ("loading", "releasing", "frictionless")[number % 3], options


@pytest.mark.filterwarnings("ignore::dualcam.errors.UnitWarning")  # random sizes
def test_random_torques_run_in_the_fmu_or_are_refused(inverse, tmp_path):
    """As above for random ones. A refusal names the place, and a torque that cannot be there."""
    made = 0
    for number in range(36):
        torque, upper, spring, direction, options = random_task(number)
        try:
            design = synthesize(torque, upper, spring, direction=direction, **options)
        except DesignError as error:
            assert re.match(r"theta = [\d.e-]+ rad: (torque .* allowed is|groove 2 (ends|locks))", str(error))
            continue
        parameters = design.mechanism.parameters(tmp_path)
        if direction == "frictionless":
            parameters |= {"cam1.friction": 0.0, "cam2.friction": 0.0}
        angles = np.linspace(0.0, upper, 201)
        if direction == "releasing":
            angles = angles[::-1]
        wanted = torque(angles[1:])
        try:
            found = slow_torque(inverse, parameters, angles, math.copysign(1e-3, angles[1] - angles[0]))
        except ValueError as error:  # a mechanism that releases so, but jams when it is loaded
            assert direction == "releasing" and "jam when loading" in str(error)
            assert any(
                "jam" in str(one) for one in assess(design.mechanism, Pin(radius=1e-4, width=0.01)).findings
            )
            continue
        assert np.abs(found / wanted - 1.0).max() < 1e-6, number
        made += 1
    assert made >= 18


def test_a_function_of_one_angle_will_do():
    """The same as that of arrays."""
    for one, all_at_once in (
        (lambda t: 1.0 + math.sin(t), lambda t: 1.0 + np.sin(t)),
        (lambda t: 1, lambda t: 1.0 + 0 * t),
    ):
        designs = [synthesize(torque, UPPER, LINEAR, groove2=HELIX) for torque in (one, all_at_once)]
        assert designs[0].table.z == pytest.approx(designs[1].table.z, rel=1e-12)


@pytest.mark.parametrize("name", ["frictionless, equal", "frictionless, level start"])
def test_without_friction_by_energy(name):
    """The work of the wanted torque is in the spring."""
    torque, spring, direction, options = CASES[name]
    design = synthesize(torque, UPPER, spring, direction=direction, **options)
    for theta in (0.1, 0.5, 1.0, UPPER):
        work = quad(torque, 0.0, theta, epsabs=1e-14)[0]
        assert spring.energy(design.mechanism.configuration(theta).z) == pytest.approx(work, rel=1e-8)


def test_helix_is_found_again():
    """The torque of a pair of helices asks for that pair."""
    first, second = 0.02 * math.tan(0.6), 0.03 * math.tan(0.9)
    lift = first * second / (first + second)
    for direction, sign in (("loading", 1), ("releasing", -1), ("frictionless", 0)):
        leads = zip((0.6, 0.9), (0.1, 0.2), (0.02, 0.03), strict=True)
        rho = 1 / sum(1 / (r * math.tan(lead + sign * math.atan(mu))) for lead, mu, r in leads)
        design = synthesize(
            lambda t, rho=rho: rho * LINEAR.force(lift * t),
            UPPER, LINEAR, direction=direction, groove2=Helix(0.03, 0.9), friction=(0.1, 0.2),
        )  # fmt: skip
        assert design.table.z == pytest.approx(0.02 * math.tan(0.6) * design.table.psi, rel=1e-11, abs=1e-16)


def test_middle_of_the_way_without_friction():
    """A frictionless design lies between the edges that its friction makes."""
    design = synthesize(lambda t: 0.6 + np.sin(t), UPPER, LINEAR, direction="frictionless", groove2=HELIX)
    angles = np.linspace(0.0, UPPER, 50)
    release, load = design.mechanism.band(angles)
    assert (release < 0.6 + np.sin(angles)).all() and (0.6 + np.sin(angles) < load).all()


BAD = {
    "too high": (lambda t: 0.3 + 2 * t, LINEAR, "releasing", {"groove2": Ellipse(0.02, 0.4, 0.05, 0.05, -1)},
                 r"torque [\d.]+ N\.m while releasing is too high.*spring's [\d.]+ N allowed is 0 to [\d.]+"),
    "too low": (lambda t: 1 - t, LINEAR, "loading", {"groove2": HELIX}, r"too low: .* allowed is 0\.\d+ to "),
    "negative": (lambda t: 0.5 - t, LINEAR, "releasing", {"groove2": HELIX}, "theta = 0.5 rad.* negative"),
    "negative, equal": (lambda t: 0.5 - t, LINEAR, "frictionless", {}, "theta = 0.5.*(negative|loose)"),
    "locked": (lambda t: 0.5, LINEAR, "releasing", {"groove2": Helix(0.02, 0.1)}, "groove 2 locks"),
    "end of groove 2": (lambda t: 1 + 3 * t, LINEAR, "loading", {"groove2": Table(
        0.02, np.linspace(0, 0.4, 9), 0.02 * np.linspace(0, 0.4, 9))}, "groove 2 ends.*allowed is 0 to 0.4"),
    "weak spring": (lambda t: 1.5, Spring(100, 0.0, -2e6), "loading", {"groove2": HELIX},
                    "too high|spring force"),
    "no preload": (lambda t: 1.0, BARE, "loading", {}, "theta = 0 .*preload"),
    "no preload, steep": (lambda t: 90 * t, BARE, "loading", {"groove2": HELIX}, "rad at theta = 0.*allowed"),
    "no preload, locked": (lambda t: t, BARE, "releasing", {"groove2": Helix(0.02, 0.1)}, "groove 2 locks"),
    "negative preload": (lambda t: 1.0, Spring(-1, 1e4), "loading", {}, "preload.*allowed"),
    "not a number": (lambda t: np.where(t < 1, 1.0, np.nan), LINEAR, "loading", {}, "torque nan.*allowed"),
    "jump": (lambda t: 1.0 + (t > 0.7), LINEAR, "loading", {"groove2": HELIX}, r"0\.[67].*continuous"),
    "short samples": (([0, 0.2, 0.5, 1], [1, 1, 1, 1]), LINEAR, "loading", {},
                      r"to 1 rad \(0 to 57.2958 deg\): .* cover 0 to upper = 1.3963 rad \(80.0021 deg\)"),
    "few samples": (([0, 2], [1, 1]), LINEAR, "loading", {}, "n >= 4"),
    "samples not numbers": (([0, 1, 2, 3], [1, 1, 1, math.nan]), LINEAR, "loading", {}, "finite"),
    "direction": (lambda t: 1.0, LINEAR, "up", {}, "allowed are loading, releasing"),
    "friction": (lambda t: 1.0, LINEAR, "loading", {"friction": (0.1, -0.1)}, "friction.*allowed"),
    "radius": (lambda t: 1.0, LINEAR, "loading", {"radius": 0.0}, "radius.*allowed"),
    "one friction": (lambda t: 1.0, LINEAR, "loading", {"friction": 0.14}, "= 0.14: allowed are two"),
    "much friction": (lambda t: 1.0, LINEAR, "loading", {"friction": (5, 5), "groove2": HELIX},
                      "5 and 5 .* jam"),
    "zero": (lambda t: 0.0, LINEAR, "releasing", {"groove2": HELIX}, "torque 0 .* > 0 at some angle"),
    "stiffness": (lambda t: 1.0, Spring(50, -10.0), "loading", {}, r"stiffness = -10.0: allowed .* >= 0"),
    "contacts": (lambda t: 1.0, LINEAR, "loading", {"contacts": 3}, "contacts = 3: allowed are 1 and 2"),
    "tolerance": (lambda t: 1.0, LINEAR, "loading", {"tolerance": math.nan}, "tolerance = nan: allowed"),
    "groove 2": (lambda t: 1.0, LINEAR, "loading", {"groove2": "helix"}, "groove2 = 'helix': allowed"),
    "a word": ("2.0", LINEAR, "loading", {}, "'2.0': allowed is a number .* a function .* or samples"),
    "infinite": (math.inf, LINEAR, "loading", {}, "torque inf N.m: allowed is a finite"),
    "complex": (lambda t: 1j + t, LINEAR, "loading", {}, "the function fails .* allowed"),
    "fails": (lambda t: 1 / 0, LINEAR, "loading", {}, "the function fails .*division by zero.* allowed"),
    "other shape": (lambda t: np.ones(7), LINEAR, "loading", {}, "the function fails .* allowed"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be(name):
    torque, spring, direction, options, message = BAD[name]
    with pytest.raises(DesignError, match=message):
        synthesize(torque, UPPER, spring, direction=direction, **options)


def test_samples_that_end_at_the_rounded_angle_are_continued():
    """80 deg is 3.7e-5 rad less than 1.3963 rad. The continued samples are those of the straight line."""
    angles = np.radians([0.0, 20.0, 40.0, 60.0, 80.0])
    assert angles[-1] < UPPER
    given, line = (
        synthesize(torque, UPPER, LINEAR) for torque in ((angles, 1.0 + angles), lambda t: 1.0 + t)
    )
    assert given.table.z == pytest.approx(line.table.z, rel=1e-12, abs=1e-16)


def test_limits_in_a_message_are_the_limits():
    """The torque is refused at the angle where it leaves what the message says is allowed."""
    with pytest.raises(DesignError) as caught:
        synthesize(lambda t: 1 - t, UPPER, LINEAR, groove2=HELIX)
    theta, torque, force, lowest = (
        float(re.search(pattern, str(caught.value))[1])
        for pattern in (r"theta = ([\d.]+)", r"torque ([\d.]+)", r"spring's ([\d.]+)", r"is ([\d.]+) to")
    )
    assert torque == pytest.approx(1 - theta, rel=1e-5) and torque == pytest.approx(lowest, rel=1e-5)
    # a level groove 1 against mu = 0.14, groove 2 at 45 deg
    assert lowest == pytest.approx(force / (1 / (0.14 * 0.02) + 0.86 / (0.02 * 1.14)), rel=1e-5)


# ---- strength ----

PIN = Pin(radius=0.003, width=0.008)


def test_hertz_by_hand():
    """Steel on steel: E* = 210e9/(2 (1 - 0.09)) = 115.3846 GPa; 200 N on 8 mm are 25 kN/m;
    sqrt(25e3 x 115.3846e9/(pi 0.003)) = 553.23 MPa. In a bend of 27 mm radius the flank has 30 or 24 mm."""
    assert pytest.approx(115.384615e9, rel=1e-8) == PIN.contact_modulus
    assert hertz_pressure(200.0, PIN) == pytest.approx(553.23e6, rel=1e-5)
    # radii 3 mm and -30 mm in contact: 1/R = 1/3 - 1/30
    hollow, ball = 1 / (1 / 0.003 - 1 / 0.030), 1 / (1 / 0.003 + 1 / 0.024)
    assert hertz_pressure(200.0, PIN, 1 / 0.027) == pytest.approx(
        553.23e6 * math.sqrt(0.003 / hollow), rel=1e-5
    )
    assert hertz_pressure(200.0, PIN, -1 / 0.027) == pytest.approx(
        553.23e6 * math.sqrt(0.003 / ball), rel=1e-5
    )
    assert hertz_pressure(200.0, PIN, -1 / 0.003) == math.inf
    brass = Pin(0.003, 0.008, cam_modulus=100e9, cam_poisson=0.35)
    assert 1 / brass.contact_modulus == pytest.approx(0.91 / 210e9 + 0.8775 / 100e9)
    for bad in ({"radius": 0.0}, {"width": math.nan}, {"poisson": 0.6}, {"cam_modulus": -1.0}):
        with pytest.raises(DesignError, match="allowed"):
            Pin(**{"radius": 0.003, "width": 0.008, **bad})


def test_loads_are_the_fmus(inverse, tmp_path):
    """Reactions per contact of slow loading and releasing in DualCamInverse."""
    design = synthesize(
        lambda t: 0.8 + 5 * np.sin(t), UPPER, LINEAR, groove2=Helix(0.025, 0.8), friction=(0.1, 0.2)
    )
    report = assess(design.mechanism, PIN, points=21)
    angle, seen = report.theta[10], []
    for speed in (1e-3, -1e-3):
        inverse.start(
            {**design.mechanism.parameters(tmp_path), **QUASI_STATIC, "theta": angle, "omega": speed}
        )
        inverse.step(1e-9)
        seen.append([inverse.real("cam1.reaction"), inverse.real("cam2.reaction")])
    assert report.load[:, 10] == pytest.approx(np.max(seen, axis=0), rel=1e-6)
    assert report.pressure[1] == pytest.approx(hertz_pressure(report.load[1], PIN), rel=1e-12)
    assert report.good and report.require() is report


def test_first_place_that_fails():
    """Ellipses of radius 50 mm flatten from 45 deg: sin(lambda) = sin(45 deg) - r psi/a, r/a = 0.4."""
    ellipse = Ellipse(0.02, math.pi / 4, 0.05, 0.05, -1)
    mechanism = Mechanism((ellipse, ellipse), (0.14, 0.14), LINEAR, UPPER)

    def findings(pin=PIN, **limits):
        return {f.what: f for f in assess(mechanism, pin, Limits(**limits), points=2001).findings}

    def reaches(lead):
        return (math.sin(math.pi / 4) - math.sin(lead)) / 0.4 * 2

    assert not findings()
    found = findings(lead_angle=(math.radians(30), math.radians(80)))
    assert set(found) == {"lead angle of groove 1", "lead angle of groove 2"}
    low = found["lead angle of groove 1"]
    assert low.theta == pytest.approx(reaches(math.radians(30)), abs=2e-9) and low.value < 30
    end = math.degrees(math.asin(math.sin(math.pi / 4) - 0.4 * UPPER / 2))
    assert low.text == (
        f"lead angle of groove 1 reaches {end:.6g} deg at theta = {math.degrees(UPPER):.4g} deg: allowed is"
        " 30 to 80 deg; outside from theta = 59.33 deg"
    )
    # the pins' loads grow with the spring's force
    report = assess(mechanism, PIN, points=2001)
    limit = float(report.pressure[0, 1200])
    first = findings(pressure=limit)["contact pressure of groove 1"]
    assert first.theta == pytest.approx(report.theta[1200], abs=2e-9)
    undercut = findings(pin=Pin(0.051, 0.008))["undercut: curvature of groove 2"]
    assert undercut.theta == 0.0 and undercut.value == pytest.approx(20.0)
    assert not any("undercut" in what for what in findings(pin=Pin(0.0499, 0.008), pressure=math.inf))


def test_self_locking_and_jam():
    ellipse = Ellipse(0.02, math.pi / 4, 0.05, 0.05, -1)
    mechanism = Mechanism((ellipse, HELIX), (0.4, 0.4), LINEAR, UPPER)
    report = assess(mechanism, PIN, points=2001)
    locked = next(f for f in report.findings if "locking" in f.what)
    assert math.degrees(math.atan(0.4)) == pytest.approx(locked.value, abs=1e-6)
    assert not [f for f in assess(mechanism, PIN, Limits(self_locking=True)).findings if "locking" in f.what]
    with pytest.raises(DesignError, match="self-locking"):
        report.require()
    jammed = Mechanism((Helix(0.02, 1.3), Helix(0.02, 1.3)), (0.4, 0.4), LINEAR, UPPER)
    assert "jam" in str(assess(jammed, PIN).findings[0])
    pulled = Mechanism((HELIX, HELIX), (0.1, 0.1), Spring(100, -1e4), UPPER)
    weak = assess(pulled, PIN, points=1001).findings[0]
    assert weak.what == "spring force" and weak.theta == pytest.approx(1.0, abs=2e-9)


# ---- the example ----


def test_example(tmp_path, capsys, monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "system_examples")
    import designed_groove

    designed_groove.main(["--fmu", str(INVERSE), "--output", str(tmp_path / "picture.png")])
    assert (tmp_path / "picture.png").stat().st_size > 50_000
    errors = [float(x) for x in re.findall(r"largest error in the FMU ([\d.e-]+)", capsys.readouterr().out)]
    assert len(errors) == 2 and max(errors) < 1e-6


@pytest.mark.parametrize("wrong, message", [
    (lambda: optimum((0.1,)), r"friction = \(0.1,\): allowed are two"),
    (lambda: efficiency((0.7, 0.7), (-1.0, 0.1)), r"friction\[0\] = -1.0: allowed"),
    (lambda: efficiency((0.7, 0.7), (0.1, 0.1), (0.0, 1.0)), r"radius\[0\] = 0.0: allowed"),
    (lambda: efficiency_map((0.1, 0.1), points=1), "points = 1: allowed"),
    (lambda: Limits(lead_angle=(1.0, 0.5)), r"lead_angle = \(1.0, 0.5\): allowed"),
    (lambda: Limits(pressure=math.nan), "pressure = nan: allowed"),
    (lambda: Spring(50, 1e3, math.nan), "stiffness2 = nan: allowed"),
    (lambda: Mechanism((HELIX, HELIX), (0.1, -0.1), LINEAR, UPPER), r"friction = \(0.1, -0.1\): allowed"),
    (lambda: Mechanism((HELIX, HELIX), (math.nan, 0.1), LINEAR, UPPER), r"friction = \(nan, 0.1\): allowed"),
    (lambda: Mechanism((HELIX, HELIX), (0.1, 0.1), LINEAR, 0.0), "upper = 0.0 rad: allowed"),
    (lambda: Helix(0.02, 45.0), "lead_angle = 45.0: allowed .* degrees; 45 deg is 0.785398 rad"),
    (lambda: assess(Mechanism((HELIX, HELIX), (0.1, 0.1), LINEAR, UPPER), Pin(0.003, 0.008), points=0),
     "points = 0: allowed"),
    (lambda: torque_band(PAIR, [0.1, 0.2]), r"points = \[0.1, 0.2\]: allowed is a whole number, 2 or more"),
    (lambda: torque_band(PAIR, np.linspace(0.0, 1.0, 5)), "points = array.*: how many angles"),
    (lambda: efficiency_map((0.1, 0.1), points=[2, 3]), r"points = \[2, 3\]: allowed is a whole number"),
    (lambda: assess(PAIR, Pin(0.003, 0.008), points=[2, 3]), r"points = \[2, 3\]: allowed is a whole number"),
])  # fmt: skip
def test_what_makes_no_sense(wrong, message):
    with pytest.raises(DesignError, match=message):
        wrong()


@pytest.mark.parametrize("friction", [(0.0, 0.1), (2.0, 2.0)])
def test_a_map_without_an_optimum_is_drawn_without_it(friction):
    axes = Figure().add_subplot()
    efficiency_map(friction, points=20).draw(axes)
    assert not axes.texts


def test_a_mechanism_has_two_grooves():
    groove = Helix(0.02, 0.7)
    with pytest.raises(DesignError, match="1 grooves: allowed are 2"):
        Mechanism((groove,), (0.1, 0.1), Spring(50.0, 1e4), 1.0)


READ_AT = {
    "band": lambda theta: PAIR.band(theta),
    "torque": lambda theta: PAIR.torque(theta, "loading"),
    "configuration": lambda theta: PAIR.configuration(theta),
    "curvature": lambda theta: PAIR.curvature(theta),
}


@pytest.mark.parametrize("name", READ_AT)
@pytest.mark.parametrize("theta, message", [
    (2.0, r"theta = 2 rad: allowed are angles between the stops, 0 to 1\.3963 rad$"),
    (-1e-6, r"theta = -1e-06 rad: allowed are angles between the stops"),
    (45, r"theta = 45 rad: .*; this looks like degrees; 45 deg is 0\.785398 rad"),
    ([0, 20, 40, 60, 80], r"theta = 80 rad: .*this looks like degrees; 80 deg is 1\.39626 rad"),
])  # fmt: skip
def test_angles_beyond_the_stops_are_refused(name, theta, message):
    with pytest.raises(DesignError, match=message):
        READ_AT[name](theta)


def test_rounding_at_a_stop_is_no_angle_beyond_it():
    ends = PAIR.band([0.0, UPPER])
    assert PAIR.band([-2e-16, UPPER * (1.0 + 1e-12)]) == pytest.approx(np.array(ends), rel=1e-9)
    assert PAIR.band([]) == pytest.approx(np.empty((2, 0)))


def test_a_designed_torque_ends_at_the_stop():
    design = synthesize(5.0, 1.2, Spring(400.0, 10e3))
    for wrong in (design.torque, design.error):
        with pytest.raises(DesignError, match=r"between the stops, 0 to 1\.2 rad; this looks like degrees"):
            wrong(45.0)
