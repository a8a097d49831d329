"""Friction tables over speed and load (columns v_m_s, R_N, mu): law, motion, derivatives, refusals. The law
is checked against SciPy (reference/friction.py), the motion against the reference simulator."""

import math

import numpy as np
import pytest
import test_output_derivatives as output_derivatives
from driver import models
from helix_balance import check_directional_derivatives
from reference import DOUBLE, Mechanism, simulate
from reference.friction import LoadedTableLaw, TableLaw
from reference.parameters import DEFAULTS
from reference.scene import Interval

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


def nominal_loads(values, fmu) -> tuple[float, float]:
    """N of one contact at both cams, from the angle and the axial load."""
    mechanism = Mechanism({name: value for name, value in values.items() if name in DEFAULTS}, DOUBLE)
    force = sum(fmu.get(name) for name in ("spring.force", "damper.force", "F_ext"))
    return mechanism.nominal_loads(mechanism.groove.at(fmu.get("theta")), force)


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
        values = {"cam1.friction_table": path}
        fmu = make_model(INVERSE).start(values | {"theta": 0.5})
        for omega in (0.0, *rng.uniform(0, 30, 15)):
            fmu.set({"omega": omega, "theta": rng.uniform(0, 1.3), "F_ext": rng.uniform(0, 300)})
            load, _ = nominal_loads(values, fmu)
            expected = law.at(fmu.get("cam1.sliding_speed"), load)
            assert fmu.get("cam1.friction_coefficient") == pytest.approx(expected, rel=1e-11)
            outside.add("below" if load < loads[0] else "above" if load > loads[-1] else "inside")
    assert outside == {"below", "inside", "above"}


def test_beyond_the_loads_mu_stays_at_the_last_value(make_model, table):
    """Lead angle 45 deg, two pin ends: N = F/(2 sqrt(2))."""
    found = {}
    for load in (1.0, 30.0, 500.0, 5000.0):
        force = 2 * math.sqrt(2) * load
        fmu = make_model(INVERSE).start(both(table) | {"spring.preload": 0.0, "F_ext": force})
        found[load] = fmu.get("cam1.friction_coefficient")
    assert found[1.0] == pytest.approx(found[30.0], rel=1e-13)
    assert found[5000.0] == pytest.approx(found[500.0], rel=1e-13)
    assert found[30.0] > found[500.0]


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


@pytest.mark.parametrize("seed", [2, 11])
def test_slip_past_the_loads(make_model, tmp_path, seed):
    """The nominal load passes two loads of the table."""
    speeds, loads = [0.0, 0.03, 0.08, 0.14, 0.3], [27.0, 79.0, 150.0]
    path = write(
        tmp_path / "law.csv", speeds, loads, drawn(np.random.default_rng(seed), speeds, loads, power=-0.4)
    )
    p = both(path) | {"initial.theta": 0.2, "initial.omega": 4.0, "inertia.follower_mass": 0.5}
    torques, tolerance = [10.0, 12.0, 14.0, 16.0, 18.0, 20.0], 1e-8
    points = simulate(p, [Interval(0.003, tau) for tau in torques])
    fmu, passed = make_model(FORWARD).start(p | {"tau": torques[0]}, tolerance=tolerance), []
    for tau, point in zip(torques, points, strict=True):
        fmu.step(0.003, tau=tau)
        assert abs(fmu.get("omega") - point.omega) <= 2 * tolerance * abs(point.omega)
        passed.append(nominal_loads(p, fmu)[0])
    assert min(passed) < loads[1] and max(passed) > loads[2]


@pytest.mark.parametrize("omega", [0.3, 4.0, -1.0])
def test_directional_derivatives(make_model, table, omega):
    values = both(table) | {"inertia.follower_mass": 1.0, "cam2.radius": 0.025}
    check_directional_derivatives(make_model, values, omega, ["cam1.friction", "spring.stiffness"], 2e-5)


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
    at = nominal_loads(values, fmu)
    assert all((loads[0] < x) == (share < 10.0) and (x < loads[-1]) == (share > 0.1) for x in at)
    mode = 2 if direction > 0 else 3
    h = 0.1 * output_derivatives.H["inertial"]  # at a speed of the table higher derivatives jump
    output_derivatives.check_between_events(fmu, inputs, h, mode)


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
    message = fmu.refused_start({"cam2.friction_table": str(tmp_path / "t.csv")})
    message = message.replace("0.20000000000000001", "0.2").replace("0.10000000000000001", "0.1")
    for part in ("cam2.friction_table", "t.csv", *mentions):
        assert part in message, message
