"""Friction tables (cam1.friction_table): law, motion, derivatives, states.

The law is checked against a curve of SciPy (reference/friction.py), slip against DOP853 restarted at every
sample, runs with rest and reversals against the reference simulator."""

import math
from pathlib import Path

import numpy as np
import pytest
import test_model_exchange as exchange
import test_output_derivatives as output_derivatives
import test_step_sensitivity as step_sensitivity
from driver import models
from helix_balance import MASSES, check_directional_derivatives, check_imposed_motion, drawn_motion
from reference import simulate
from reference.friction import TableLaw
from reference.scene import Interval
from scipy.integrate import solve_ivp

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]
STRIBECK = [0.0, 0.005, 0.02, 0.05, 0.1, 0.2], [0.2, 0.17, 0.12, 0.11, 0.115, 0.13]
GROWING = [0.0, 0.01, 0.05, 0.2], [0.1, 0.11, 0.15, 0.2]
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-9, 1e-11)


def write(path: Path, v, mu) -> str:
    rows = [f"{float(a)!r},{float(b)!r}\n" for a, b in zip(v, mu, strict=True)]
    path.write_text("v_m_s,mu\n" + "".join(rows), encoding="utf-8")
    return str(path)


@pytest.fixture
def tables(tmp_path):
    """Both cams with the table of samples, as parameters of an FMU."""

    def of(samples=STRIBECK, name="law") -> dict:
        path = write(tmp_path / f"{name}.csv", *samples)
        return {"cam1.friction_table": path, "cam2.friction_table": path}

    return of


def drawn(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Samples that rise, fall and stay."""
    count = int(rng.integers(3, 9))
    v = np.concatenate([[0.0], np.cumsum(10 ** rng.uniform(-2.5, -1, count - 1))])
    mu = np.clip(0.15 * np.exp(rng.normal(0, 0.4, count)), 0.02, 0.5)
    if rng.random() < 0.3:
        mu[-2] = mu[-1]
    return v, mu


# ---- the law ----


def test_law_is_that_of_scipy(make_model, tmp_path):
    rng = np.random.default_rng(1)
    for number in range(60):
        v, mu = drawn(rng)
        law = TableLaw(v, mu)
        fmu = make_model(INVERSE).start(
            {"cam1.friction_table": write(tmp_path / "t.csv", v, mu), "theta": 0.5}
        )
        fmu.set({"omega": 1.0})
        arm = fmu.get("cam1.sliding_speed")
        speeds = np.concatenate([rng.uniform(0, 1.3 * v[-1], 30), v[1:] * (1 - 1e-9), v[1:] * (1 + 1e-9)])
        for speed in speeds:
            fmu.set({"omega": speed / arm})
            found = fmu.get("cam1.friction_coefficient")
            assert found == pytest.approx(law.at(fmu.get("cam1.sliding_speed")), rel=1e-12), (number, speed)
            beside = mu[max(np.searchsorted(v, speed * (1 - 1e-12)) - 1, 0) :][:2]
            assert beside.min() * (1 - 1e-12) <= found <= beside.max() * (1 + 1e-12)
        fmu.set({"omega": 0.0})
        assert fmu.get("cam1.friction_coefficient") == mu[0]


def test_curve_is_twice_differentiable():
    rng = np.random.default_rng(2)
    for _ in range(30):
        curve = TableLaw(*drawn(rng)).curve
        for order in range(3):
            part = curve.derivative(order) if order else curve
            for x in curve.x[1:-1]:
                scale = np.abs(part(np.linspace(curve.x[0], curve.x[-1], 400))).max()
                assert abs(part(x * (1 + 1e-13)) - part(x * (1 - 1e-13))) <= 1e-6 * scale
        assert abs(curve.derivative(1)(curve.x[-1])) + abs(curve.derivative(2)(curve.x[-1])) <= 1e-9 * scale


def test_torque_of_an_imposed_motion(make_model, tables):
    rng = np.random.default_rng(3)
    for _ in range(60):
        p = tables() | {"contacts": int(rng.integers(1, 3)), "spring.stiffness2": 1e5}
        for i in (1, 2):
            p |= {f"cam{i}.radius": rng.uniform(0.01, 0.03), f"cam{i}.lead_angle": rng.uniform(0.4, 1.0)}
        p |= {"inertia.follower_mass": rng.uniform(0, 3), "inertia.follower": rng.uniform(0, 1e-3)}
        p |= {"shaft.damping": rng.uniform(0, 0.01), "damper.c_load": rng.uniform(0, 50)}
        check_imposed_motion(make_model, p, drawn_motion(rng), 1e-11)


def test_band_has_the_coefficients_at_rest(make_model, tables):
    for model in (FORWARD, INVERSE):
        at = {"initial.theta": 0.5} if model is FORWARD else {"theta": 0.5}
        table = make_model(model).start(tables() | at)
        coulomb = make_model(model).start({"cam1.friction": 0.2, "cam2.friction": 0.2} | at)
        for name in ("torque_load", "torque_release", "efficiency", "cam2.friction_coefficient"):
            assert table.get(name) == coulomb.get(name)


def test_other_friction_parameters_are_not_used(make_model, tables):
    fmu, other = (make_model(FORWARD).start(tables()) for _ in range(2))
    other.set({"cam1.friction": 0.7, "cam2.friction_peak": 3.0, "cam1.friction_viscous": 1.0})
    for one in (fmu, other):
        one.step(0.05, tau=7.0)
    assert fmu.get("theta") == other.get("theta") > 0
    for name in ("cam1.friction", "cam2.friction_peak", "cam1.stribeck_velocity", "cam1.friction_viscous"):
        assert fmu.partial("alpha", name) == 0.0


# ---- motion ----


def slip(p: dict, tau: float, duration: float, start: tuple[float, float]) -> np.ndarray | None:
    """theta and omega after slip in helices in one direction, written from the equations of mechanism.md;
    None if the cam comes to rest."""
    laws = [TableLaw(*np.loadtxt(p[f"cam{i}.friction_table"], delimiter=",", skiprows=1).T) for i in (1, 2)]
    r, a = [0.02, 0.02], [0.02 * math.tan(p[f"cam{i}.lead_angle"]) for i in (1, 2)]
    turn = [a[1] / sum(a), a[0] / sum(a)]
    arm = [t * math.hypot(x, y) for t, x, y in zip(turn, r, a, strict=True)]
    dz, mass, inertia = a[0] * turn[0], p["inertia.follower_mass"], p["inertia.follower"]

    def rates(_: float, y: np.ndarray) -> list[float]:
        mu = [law.at(x * y[1]) for law, x in zip(laws, arm, strict=True)]
        n, d = [a[i] + mu[i] * r[i] for i in (0, 1)], [r[i] - mu[i] * a[i] for i in (0, 1)]
        delta, product = r[1] * d[0] * n[1] + r[0] * d[1] * n[0], r[0] * r[1] * n[0] * n[1]
        force, torque = 50 + 50000 * dz * y[0], tau - p["shaft.damping"] * y[1]
        resistance = 0.002 * delta + product * mass * dz + d[0] * r[1] * n[1] * inertia * turn[0]
        return [y[1], (delta * torque - product * force) / resistance]

    def crossing(speed: float):
        event = lambda _, y: y[1] - speed  # noqa: E731
        event.terminal = True
        return event

    speeds = sorted({k / x for law, x in zip(laws, arm, strict=True) for k in law.curve.x})
    t, y = 0.0, np.array(start)
    while t < duration:
        events = [crossing(s) for s in speeds if abs(y[1] - s) > 1e-12 * s]
        found = solve_ivp(rates, (t, duration), y, method="DOP853", rtol=3e-14, atol=1e-15, events=events)
        t, y = found.t[-1], found.y[:, -1].copy()
        if found.status == 1:
            y[1] = min(speeds, key=lambda s, w=y[1]: abs(s - w))
            if y[1] == 0.0:
                return None
    return y


@pytest.fixture(scope="module")
def scenes(tmp_path_factory):
    """Random tables, masses and torques, with the solution."""
    rng, folder, found = np.random.default_rng(7), tmp_path_factory.mktemp("tables"), []
    while len(found) < 24:
        p = {"inertia.follower_mass": rng.uniform(0, 2), "inertia.follower": rng.uniform(0, 1e-4)}
        p["shaft.damping"] = rng.uniform(0, 0.01)
        for i in (1, 2):
            p[f"cam{i}.friction_table"] = write(folder / f"{len(found)}-{i}.csv", *drawn(rng))
            p[f"cam{i}.lead_angle"] = rng.uniform(0.6, 1.0)
        start, tau, duration = (0.1, rng.uniform(0.1, 10)), rng.uniform(8, 20), rng.uniform(0.004, 0.02)
        end = slip(p, tau, duration, start)
        if end is not None and end[0] < 1.39:
            found.append(
                (p | dict(zip(("initial.theta", "initial.omega"), start, strict=True)), tau, duration, end)
            )
    return found


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_slip(make_model, scenes, tolerance):
    for number, (p, tau, duration, end) in enumerate(scenes):
        for pieces in (1, 7):
            fmu = make_model(FORWARD).start(p, tolerance=tolerance)
            for _ in range(pieces):
                fmu.step(duration / pieces, tau=tau)
            size = np.maximum(np.abs(end), [p["initial.theta"], p["initial.omega"]])
            error = np.abs([fmu.get("theta"), fmu.get("omega")] - end) / size
            assert error.max() <= 10 * tolerance, (number, pieces)
            energy = max(abs(fmu.get(f"energy.{n}")) for n in ("work_in", "kinetic", "spring"))
            assert abs(fmu.get("energy.residual")) <= 10 * tolerance * energy, number


@pytest.mark.parametrize("loads", [0, 2])
@pytest.mark.parametrize("torque, axial", [(300.0, 0.0), (0.0, -1000.0)])
def test_a_step_to_a_sample_takes_inputs_at_its_own_times(make_model, tmp_path, loads, torque, axial):
    """A table of mu = 0.1 everywhere is Coulomb's law. A ramp of the torque, N.m/s, or of F_ext, N/s, makes
    theta a cubic of time. The length of a step that ends at a sample is one of its unknowns."""
    mu, r, J, preload, omega, duration = 0.1, 0.02, 0.002, 50.0, 0.5, 0.04
    slopes = [math.tan(lead) for lead in (0.8, 0.7)]
    rho = 1.0 / sum((1.0 - mu * s) / (r * (s + mu)) for s in slopes)
    sliding = r * slopes[1] / sum(slopes) * math.hypot(1.0, slopes[0])  # m, v_1/omega
    jerk = (torque - rho * axial) / J
    speed = omega + jerk * duration**2 / 2
    end = omega * duration + jerk * duration**3 / 6, speed
    p = {"spring.preload": preload, "spring.stiffness": 0.0, "inertia.shaft": J, "initial.omega": omega}
    p |= {"cam1.lead_angle": 0.8, "cam2.lead_angle": 0.7, "cam2.friction": mu, "stop.upper": 10.0}
    p |= {"initial.theta": 0.0, "contacts": 1, "tau": rho * preload, "shaft.damping": 0.0}
    p |= {f"damper.{name}": 0.0 for name in ("c_load", "c_release", "q_load", "q_release")}
    for share in np.linspace(0.02, 0.98, 25):
        sample, path = sliding * (omega + share * (speed - omega)), tmp_path / f"{share}.csv"
        rows = [[v, *load, mu] for load in ([1.0], [9.0])[:loads] or [[]] for v in (0.0, sample, 2 * sample)]
        text = "\n".join(",".join(map(repr, map(float, row))) for row in rows)
        path.write_text(f"v_m_s,{'R_N,' * (loads > 0)}mu\n{text}\n", encoding="utf-8")
        fmu = make_model(FORWARD).start(p | {"cam1.friction_table": str(path)})
        fmu.set_rates(tau=torque, F_ext=axial)
        fmu.step(duration)
        assert (fmu.get("theta"), fmu.get("omega")) == pytest.approx(end, rel=1e-8), share


CURVED = {"cam1.profile": 2, "cam1.lead_angle": 0.8, "cam2.profile": 2, "cam2.lead_angle": 0.7}


@pytest.mark.parametrize("groove", [{}, CURVED])
def test_rest_breakaway_and_reversal(make_model, tables, groove):
    p = tables() | groove | {"inertia.follower_mass": 0.5}
    torques = [3.0, 9.0, 4.0, 6.0, 0.0, 12.0, 1.0]
    intervals = [
        Interval(0.0025, tau) for tau in torques for _ in range(16)
    ]  # short: the samples are not seen
    points = simulate(p, intervals)[15::16]
    assert {point.mode for point in points} >= {1, 2, 3} or {point.mode for point in points} >= {1, 3, 4}
    for tolerance in (1e-4, 1e-6, 1e-8):
        fmu = make_model(FORWARD).start(p | {"tau": torques[0]}, tolerance=tolerance)
        for tau, point in zip(torques, points, strict=True):
            fmu.step(0.04, tau=tau)
            assert (fmu.get("mode"), fmu.get("events")) == (point.mode, point.events)
            assert abs(fmu.get("theta") - point.theta) <= 10 * tolerance * 1.4
            assert abs(fmu.get("omega") - point.omega) <= 10 * tolerance * 50
            assert abs(fmu.get("energy.residual")) <= 10 * tolerance


def test_wear_and_heat(make_model, tables):
    """dV/dt = K R v and dQ/dt = mu R v, summed over short steps by the trapezoidal rule."""
    p = tables() | {"initial.theta": 0.2, "initial.omega": 3.0, "cam1.wear": 2e-13}
    fmu, rates, h = make_model(FORWARD).start(p), [], 1e-4
    fmu.step(h, tau=6.0)
    before = fmu.get("wear.cam1"), fmu.get("energy.heat_cam1")
    for _ in range(100):
        worn = fmu.get("cam1.reaction") * fmu.get("cam1.sliding_speed")
        rates.append((2e-13 * worn, fmu.get("cam1.friction_power")))
        fmu.step(h, tau=6.0)
    worn = fmu.get("cam1.reaction") * fmu.get("cam1.sliding_speed")
    sums = np.trapezoid([*rates, (2e-13 * worn, fmu.get("cam1.friction_power"))], dx=h, axis=0)
    assert fmu.get("wear.cam1") - before[0] == pytest.approx(sums[0], rel=1e-4)
    assert fmu.get("energy.heat_cam1") - before[1] == pytest.approx(sums[1], rel=1e-4)


def test_inverse_ledger(make_model, tables):
    fmu = make_model(INVERSE).start(tables(STRIBECK))
    for k in range(1, 41):
        angle = k * math.pi / 20
        fmu.step(0.01, theta=0.5 * (1 - math.cos(angle)), omega=2.5 * math.pi * math.sin(angle))
    heat = fmu.get("energy.heat_cam1")
    assert heat > 0.01
    assert abs(fmu.get("energy.residual")) <= 1e-8 * heat


# ---- derivatives ----


@pytest.mark.parametrize("omega", [0.3, 4.0, -1.0])
def test_directional_derivatives(make_model, tables, omega):
    check_directional_derivatives(make_model, tables() | MASSES, omega, ["cam1.friction", "spring.stiffness"])


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("groove", ["helices", "ellipses"])
def test_output_derivatives(make_model, tables, groove, direction):
    base = output_derivatives.LINEAR | output_derivatives.CURVED | output_derivatives.GROOVES[groove]
    values = (
        base | output_derivatives.REGIMES["inertial"] | tables(([0, 0.1, 1.0, 3.0], [0.2, 0.16, 0.1, 0.12]))
    )
    output_derivatives.check_slip(make_model, values, direction, 0.3 * output_derivatives.H["inertial"])


@pytest.mark.parametrize("name", ["slip", "to rest", "breakaway"])
def test_step_sensitivity(make_model, tables, name):
    step_sensitivity.check(make_model, step_sensitivity.scenes_of_law(tables())[name])


# ---- model exchange, states ----


def test_cvode_sees_no_chatter(calls, tables):
    exchange.check_no_chatter(tables(), calls, 4_000)


calls = exchange.calls


def test_states_resets_and_bytes(make_model, tables, tmp_path):
    fmu = make_model(FORWARD).start(tables())
    fmu.step(0.02, tau=7.0)
    state = fmu.take()
    content, runs = fmu.to_bytes(state), []
    for _ in range(2):
        fmu.restore(state)
        fmu.time = 0.02
        fmu.step(0.02, tau=11.0)
        runs.append(fmu.everything())
    assert runs[0] == runs[1]
    assert content == fmu.to_bytes(state)
    other = make_model(FORWARD)
    other.set(tables(GROWING, "other"))
    other.start()
    _, there = other.try_from_bytes(content)
    other.restore(there)
    other.time = 0.02
    other.step(0.02, tau=11.0)
    assert other.get("theta") == fmu.get("theta")
    fmu.ok("fmi2Reset")
    fmu.start()  # Coulomb's law again
    assert fmu.get("cam1.friction_coefficient") == 0.14


def test_a_state_whose_table_is_gone_is_refused_and_changes_nothing(make_model, tables, tmp_path):
    fmu = make_model(FORWARD).start(tables())
    fmu.step(0.02, tau=7.0)
    content = fmu.to_bytes(fmu.take())
    other = make_model(FORWARD).start(tables(GROWING, "other"))
    _, there = other.try_from_bytes(content)
    for broken in (None, "v_m_s,mu\n0,0.1\n"):
        (tmp_path / "law.csv").unlink() if broken is None else (tmp_path / "law.csv").write_text(broken)
        before = other.everything()
        other.refused("fmi2SetFMUstate", there, mentions=("cam1.friction_table",))
        assert other.everything() == before
    other.step(0.02, tau=7.0)
    law = TableLaw(*map(np.array, GROWING))
    assert other.get("cam1.friction_coefficient") == pytest.approx(
        law.at(other.get("cam1.sliding_speed")), rel=1e-12
    )
    fmu.restore(fmu.take())  # the instance has read its table
    fmu.step(0.02, tau=7.0)


def test_tuning_keeps_the_table(make_model, tables):
    fmu = make_model(FORWARD).start(tables())
    fmu.step(0.01, tau=7.0)
    fmu.set({"spring.preload": 60.0, "cam1.friction": 0.3})
    fmu.step(0.01)
    law = TableLaw(*map(np.array, STRIBECK))
    assert fmu.get("cam1.friction_coefficient") == pytest.approx(
        law.at(fmu.get("cam1.sliding_speed")), rel=1e-12
    )
