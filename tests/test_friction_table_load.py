"""Friction tables over speed and load (columns v_m_s, R_N, mu): law, motion, derivatives, refusals. The law
is checked against SciPy (reference/friction.py), the motion against the reference simulator."""

import math

import numpy as np
import pytest
import test_output_derivatives as output_derivatives
from driver import models
from reference import simulate
from reference.friction import LoadedTableLaw, TableLaw
from reference.scene import Interval
from test_friction_table import check_directional_derivatives

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]
SPEEDS, LOADS = [0.0, 0.05, 0.2, 0.5, 1.0], [30.0, 80.0, 200.0, 500.0]


def write(path, speeds, loads, mu) -> str:
    """`mu`: [load][speed]"""
    rows = [
        f"{float(v)!r},{float(load)!r},{float(m)!r}\n"
        for load, row in zip(loads, mu, strict=True)
        for v, m in zip(speeds, row, strict=True)
    ]
    path.write_text("v_m_s,R_N,mu\n" + "".join(rows), encoding="utf-8")
    return str(path)


def drawn(rng: np.random.Generator, speeds, loads, power: float = -0.3, noise: float = 0.04) -> np.ndarray:
    """[load][speed]"""
    base = 0.15 * np.exp(rng.normal(0, 0.3, len(speeds)))
    scatter = np.exp(rng.normal(0, noise, (len(loads), len(speeds))))
    return base * (np.array(loads)[:, None] / 100) ** power * scatter


def both(path: str) -> dict:
    return {"cam1.friction_table": path, "cam2.friction_table": path}


@pytest.fixture
def table(tmp_path):
    return write(tmp_path / "law.csv", SPEEDS, LOADS, drawn(np.random.default_rng(4), SPEEDS, LOADS))


def test_law_is_that_of_scipy(make_model, tmp_path):
    """Also beyond the loads and the speeds of the table."""
    rng = np.random.default_rng(3)
    outside = set()
    for _ in range(25):
        loads = 30 * np.cumprod(rng.uniform(1.5, 3, int(rng.integers(2, 7))))
        speeds = np.concatenate([[0.0], np.cumsum(10 ** rng.uniform(-2.5, -1, 5))])
        path = write(tmp_path / "t.csv", speeds, loads, drawn(rng, speeds, loads))
        law = TableLaw.read(path)
        assert isinstance(law, LoadedTableLaw)
        fmu = make_model(INVERSE).start({"cam1.friction_table": path, "theta": 0.5})
        for omega in (0.0, *rng.uniform(0, 30, 15)):
            fmu.set({"omega": omega, "theta": rng.uniform(0, 1.3), "F_ext": rng.uniform(0, 300)})
            speed, reaction = fmu.get("cam1.sliding_speed"), fmu.get("cam1.reaction")
            expected = law.at(speed, reaction)
            assert fmu.get("cam1.friction_coefficient") == pytest.approx(expected, rel=1e-11)
            outside.add("below" if reaction < loads[0] else "above" if reaction > loads[-1] else "inside")
    assert outside == {"below", "inside", "above"}


def test_a_power_of_the_load_is_the_analytic_law(make_model, tmp_path):
    """A table of a power law gives the analytic law with that load exponent, at rest and in motion."""
    mu = 0.12 * (np.array(LOADS)[:, None] / 100) ** -0.25 * np.ones((1, len(SPEEDS)))
    path = write(tmp_path / "power.csv", SPEEDS, LOADS, mu)
    law = {
        f"cam{i}.{n}": v for i in (1, 2) for n, v in (("friction", 0.12), ("friction_load_exponent", -0.25))
    }
    for model, at in (
        (FORWARD, {"initial.theta": 0.5}),
        (INVERSE, {"theta": 0.4, "omega": 3.0, "alpha": 50.0}),
    ):
        one, other = make_model(model).start(both(path) | at), make_model(model).start(law | at)
        names = ["torque_load", "torque_release", "cam1.friction_coefficient"]
        for name in [*names, *(["tau"] if model is INVERSE else [])]:
            assert one.get(name) == pytest.approx(other.get(name), rel=1e-10), name
    one, other = (make_model(FORWARD).start(p | {"tau": 7.0}) for p in (both(path), law))
    for fmu in (one, other):
        fmu.step(0.05, tau=7.0)
    assert one.get("theta") == pytest.approx(other.get("theta"), rel=1e-7)
    assert one.get("energy.heat_cam1") == pytest.approx(other.get("energy.heat_cam1"), rel=1e-7)


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    rng, folder, found = np.random.default_rng(5), tmp_path_factory.mktemp("tables"), []
    for number in range(3):
        path = write(folder / f"{number}.csv", SPEEDS, LOADS, drawn(rng, SPEEDS, LOADS))
        p = both(path) | {
            "initial.theta": 0.2,
            "initial.omega": rng.uniform(0, 5),
            "inertia.follower_mass": 0.5,
        }
        tau = rng.uniform(4, 12)
        found.append((p | {"tau": tau}, tau, simulate(p, [Interval(0.0005, tau)] * 24)[-1]))
    return found


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
def test_slip(make_model, scenes, tolerance):
    for p, tau, point in scenes:
        for pieces in (1, 5):
            fmu = make_model(FORWARD).start(p, tolerance=tolerance)
            for _ in range(pieces):
                fmu.step(0.012 / pieces, tau=tau)
            assert fmu.get("mode") == point.mode
            assert abs(fmu.get("omega") - point.omega) <= 10 * tolerance * max(abs(point.omega), 1.0)
            assert abs(fmu.get("theta") - point.theta) <= 10 * tolerance
            assert abs(fmu.get("energy.residual")) <= 10 * tolerance * 2


# A scene at random in which a first guess of the loads misses a close load of the table.
CLOSE_LOADS = [
    45.0,
    54.4,
    83.0,
    120.0,
    156.0,
    222.0,
    277.0,
    334.0,
    515.0,
    731.0,
    849.0,
    1340.0,
    1450.0,
    1720.0,
]
CLOSE_MU = """
    .292 .404 .328 .452 .178  .297 .415 .338 .487 .201  .322 .475 .383 .581 .219  .382 .504 .425 .611 .244
    .413 .538 .466 .658 .276  .474 .625 .535 .751 .291  .502 .698 .541 .796 .328  .539 .72  .57  .844 .346
    .609 .781 .636 .996 .373  .637 .913 .696 1.05 .423  .722 .916 .76  1.15 .437  .851 1.07 .874 1.29 .541
    .881 1.1  .837 1.37 .52   .88  1.2  .956 1.53 .549"""
CLOSE = {
    "initial.theta": 0.2,
    "initial.omega": 9.72,
    "inertia.follower_mass": 0.5,
    "spring.preload": 63.1,
    "cam1.lead_angle": 0.953,
    "cam2.lead_angle": 0.723,
}


def test_a_step_keeps_to_the_loads_of_its_law(make_model, tmp_path):
    """A step takes the law between two loads. A step whose reaction starts beyond them is not accepted."""
    tau, tolerance, h, steps = 6.79, 1e-4, 1.2e-4, 50
    mu = np.array(CLOSE_MU.split(), dtype=float).reshape(len(CLOSE_LOADS), len(SPEEDS))
    p = CLOSE | both(write(tmp_path / "close.csv", SPEEDS, CLOSE_LOADS, mu))
    end = simulate(p, [Interval(h * steps, tau)])[-1]
    fmu = make_model(FORWARD).start(p | {"tau": tau}, tolerance=tolerance)
    for _ in range(steps):
        fmu.step(h, tau=tau)
    assert fmu.get("omega") == pytest.approx(end.omega, rel=tolerance)
    assert fmu.get("theta") == pytest.approx(end.theta, rel=tolerance)


def test_a_step_whose_guess_of_the_loads_is_too_high(make_model, tmp_path):
    """In the second step a first guess of the reaction is above a load of the table, the reaction below."""
    speeds, loads = [0.0, 0.03, 0.08, 0.14, 0.3], [13.0, 17.9, 33.4, 41.0, 56.9, 85.4, 167.0, 272.0, 518.0]
    mu = """
    .28 .59 .56 .26 .39  .26 .54 .48 .25 .36  .24 .52 .48 .23 .34  .23 .52 .46 .21 .32  .21 .47 .43 .18 .33
    .2  .45 .44 .18 .31  .19 .41 .35 .17 .28  .17 .36 .33 .16 .23  .16 .34 .32 .14 .21"""
    rows = np.array(mu.split(), dtype=float).reshape(len(loads), len(speeds))
    p = both(write(tmp_path / "law.csv", speeds, loads, rows)) | {
        "initial.theta": 0.772,
        "initial.omega": -7.31,
        "inertia.follower_mass": 0.5,
        "cam1.lead_angle": 0.444,
        "cam2.lead_angle": 0.689,
    }
    tau, tolerance, h = 12.0, 1e-8, 1.5e-4
    end = simulate(p, [Interval(2 * h, tau)])[-1]
    fmu = make_model(FORWARD).start(p | {"tau": tau}, tolerance=tolerance)
    for _ in range(2):
        fmu.step(h, tau=tau)
    assert fmu.get("omega") == pytest.approx(end.omega, rel=tolerance)
    assert fmu.get("theta") == pytest.approx(end.theta, rel=tolerance)


@pytest.mark.parametrize("seed", [2, 11])
def test_slip_past_the_loads(make_model, tmp_path, seed):
    """The reactions pass two loads of the table. At the start of some steps, mu at the middle load gives a
    first guess of the reactions beyond the next load."""
    speeds, loads = [0.0, 0.03, 0.08, 0.14, 0.3], [27.0, 79.0, 200.0]
    path = write(
        tmp_path / "law.csv", speeds, loads, drawn(np.random.default_rng(seed), speeds, loads, power=-0.4)
    )
    p = both(path) | {"initial.theta": 0.2, "initial.omega": 4.0, "inertia.follower_mass": 0.5}
    torques, tolerance = [10.0, 12.0, 14.0, 16.0, 18.0, 20.0], 1e-8
    points = simulate(p, [Interval(0.003, tau) for tau in torques])
    fmu, reactions = make_model(FORWARD).start(p | {"tau": torques[0]}, tolerance=tolerance), []
    for tau, point in zip(torques, points, strict=True):
        fmu.step(0.003, tau=tau)
        assert abs(fmu.get("omega") - point.omega) <= 2 * tolerance * abs(point.omega)
        reactions.append(fmu.get("cam1.reaction"))
    assert min(reactions) < loads[1] and max(reactions) > loads[2]


@pytest.mark.parametrize("omega", [0.3, 4.0, -1.0])
def test_directional_derivatives(make_model, table, omega):
    values = both(table) | {"inertia.follower_mass": 1.0, "cam2.radius": 0.025}
    check_directional_derivatives(make_model, values, omega, 2e-5)


@pytest.mark.parametrize("share, slow", [(1.0, 1.0), (0.03, 1.0), (10.0, 1.0), (0.7, 0.3)])
@pytest.mark.parametrize("direction", [1, -1])
def test_output_derivatives(make_model, tmp_path, direction, share, slow):
    """Within the loads of the table, above and below them; in its first and in its second range of speed."""
    base = output_derivatives.LINEAR | output_derivatives.CURVED | output_derivatives.GROOVES["ellipses"]
    loads, mu = share * np.array(LOADS), drawn(np.random.default_rng(4), SPEEDS, LOADS)
    path = write(tmp_path / "t.csv", slow * np.array(SPEEDS), loads, mu)
    values = base | output_derivatives.REGIMES["inertial"] | both(path)
    fmu, inputs = output_derivatives.slipping(make_model, values, direction)
    assert all((fmu.get(f"cam{i}.sliding_speed") < slow * SPEEDS[1]) == (slow == 1.0) for i in (1, 2))
    reactions = [fmu.get(f"cam{i}.reaction") for i in (1, 2)]
    assert all((loads[0] < r) == (share < 10.0) and (r < loads[-1]) == (share > 0.1) for r in reactions)
    mode = 2 if direction > 0 else 3
    h = 0.1 * output_derivatives.H["inertial"]  # at a speed of the table higher derivatives jump
    output_derivatives.check_between_events(fmu, inputs, h, mode)


def test_a_restored_run_repeats(make_model, table):
    fmu = make_model(FORWARD).start(both(table))
    fmu.step(0.02, tau=7.0)
    state, runs = fmu.take(), []
    for _ in range(2):
        fmu.restore(state)
        fmu.time = 0.02
        fmu.step(0.02, tau=11.0)
        runs.append(fmu.everything())
    assert runs[0] == runs[1]


HEAD = "v_m_s,R_N,mu\n"
GRID = [(v, r, 0.1) for r in (50, 100) for v in (0, 0.1, 0.2)]
REFUSED = {
    "two numbers": (HEAD + "0,0.1\n", ["line 2", "three finite numbers", "0.01,100,0.12"]),
    "one load": (GRID[:3], ["one load", "leave out the column R_N"]),
    "loads fall": ([*GRID[3:], *GRID[:3]], ["line 5", "R_N = 50", "> 100"]),
    "no load": ([(0, 0, 0.1)], ["line 2", "R_N = 0", "> 0"]),
    "by speed first": ([GRID[0], GRID[3], GRID[1]], ["line 3", "R_N = 100"]),
    "a missing speed": ([*GRID[:4], GRID[5]], ["line 6", "v_m_s = 0.2", "0.1"]),
    "a missing line": (GRID[:5], ["5 points", "6"]),
    "a line too many": ([*GRID, (0.3, 100, 0.1)], ["line 8", "3 speeds of the first load"]),
    "too many loads": ([(v, r, 0.1) for r in range(1, 18) for v in (0, 1, 2)], ["at most 16"]),
    "a steep power": (
        [*GRID[:3], *((v, 100, 0.3) for v in (0, 0.1, 0.2))],
        ["power 1.58", "R_N = 50 to 100", "-0.9 to 0.9"],
    ),
}


def text_of(rows) -> str:
    return rows if isinstance(rows, str) else HEAD + "".join(f"{v},{r},{mu}\n" for v, r, mu in rows)


@pytest.mark.parametrize("name", REFUSED)
def test_refused_files(make_model, tmp_path, name):
    rows, mentions = REFUSED[name]
    (tmp_path / "t.csv").write_text(text_of(rows))
    fmu = make_model(FORWARD)
    fmu.set({"cam2.friction_table": str(tmp_path / "t.csv")})
    fmu.ok("fmi2EnterInitializationMode")
    message = fmu.refused_start().replace("0.20000000000000001", "0.2").replace("0.10000000000000001", "0.1")
    for part in ("cam2.friction_table", "t.csv", *mentions):
        assert part in message, message


def test_steep_load_law_of_scipy_is_finite():
    law = LoadedTableLaw(
        np.array([50.0, 100.0]), [TableLaw(np.array([0, 1, 2.0]), np.full(3, m)) for m in (0.1, 0.15)]
    )
    assert math.isfinite(law.at(0.5, 1e-300)) and law.at(0.5, 200.0) == pytest.approx(0.225)
