"""Time derivatives of outputs (fmi2GetRealOutputDerivatives) of both FMUs against differences of order 8 of
the outputs themselves, and against closed forms."""

import math
from ctypes import c_double, c_int

import numpy as np
import pytest
from driver import Driver, models
from pin_equations import write_table
from random_mechanisms import run_on, step
from reference import LOADING, LOWER_STOP, RELEASING, STICK

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]
MOTION = ("theta", "omega", "z", "v")
AROUND, AHEAD = np.arange(-4.0, 5.0), np.arange(1.0, 10.0)
KNOTS = np.linspace(-0.1, 0.8, 10)  # rad, of the table: in both cams, so at twice that theta

ELLIPSES = {"cam1.profile": 2, "cam2.profile": 2, "cam1.lead_angle": 0.8, "cam2.lead_angle": 0.7}
GROOVES = {
    "helices": {"cam1.lead_angle": 0.6, "cam2.lead_angle": 0.9},
    "ellipses": ELLIPSES | {"cam1.ellipse_curvature": 1},
    "mixed": ELLIPSES | {"cam1.profile": 1},
    "tables": {"cam1.profile": 3, "cam2.profile": 3},
}
LINEAR = {
    "cam2.radius": 0.025,
    "cam2.friction": 0.1,
    "stop.lower": -0.1,
    "spring.preload": 50.0,
    "spring.stiffness": 2e4,
    "inertia.shaft": 0.0,
}
WEDGING = {  # one contact locks and the other one does not
    **{"cam1.lead_angle": 0.05, "cam2.lead_angle": 0.31},
    **{"cam1.friction": 0.74, "cam2.friction": 0.1, "cam2.radius": 0.02},
}
CURVED = {"spring.stiffness2": 1e5, "spring.stiffness3": 1e7}
DAMPED = {f"damper.{name}": value for name, value in {"c_load": 80.0, "c_release": 60.0}.items()}
MASSES = {"inertia.shaft": 0.002, "inertia.follower_mass": 0.3, "inertia.follower": 3e-4}
LINEAR_REGIMES = {
    "inertial": MASSES | DAMPED | {"shaft.damping": 0.01},
    "viscous": DAMPED | {"shaft.damping": 0.02},
    "rate-independent": {},
}
REGIMES = {
    **LINEAR_REGIMES,
    "viscous, quadratic": DAMPED | {"damper.q_load": 100.0, "damper.q_release": 80.0, "shaft.damping": 0.02},
}
H = {"inertial": 2e-3, "viscous": 2e-4, "viscous, quadratic": 2e-4, "rate-independent": 2e-3}  # s


@pytest.fixture
def grooves(tmp_path):
    """Parameters of grooves by kind."""
    path = write_table(tmp_path / "groove.csv", KNOTS, [0.02 * x + 0.004 * math.sin(2.0 * x) for x in KNOTS])
    table = {"cam1.table": path, "cam2.table": path}
    return GROOVES | {"tables": GROOVES["tables"] | table}


def difference(nodes, values, h: float, order: int) -> float:
    """Derivative at 0 of the polynomial through values at h nodes."""
    powers = np.vander(nodes, increasing=True).T
    weights = np.linalg.solve(powers, math.factorial(order) * np.eye(len(nodes))[order])
    return math.fsum(np.asarray(values) * weights) / h**order


def derivatives(fmu: Driver, names) -> dict:
    return {(name, order): fmu.output_derivative(name, order) for name in names for order in (1, 2)}


def refused_derivative(fmu: Driver, name: str, *mentions: str) -> float:
    """What the refused call leaves of 7.0."""
    arguments = INVERSE.references([name]), 1, (c_int * 1)(1), (c_double * 1)(7.0)
    fmu.refused("fmi2GetRealOutputDerivatives", *arguments, mentions=mentions)
    return arguments[-1][0]


def assert_close(found: dict, nodes, samples: dict, h: float, tolerance: float = 1e-6) -> None:
    """`samples`: values at h nodes."""
    for (name, order), value in found.items():
        expected = difference(nodes, samples[name], h, order)
        size = max(abs(expected), 0.01 * float(np.ptp(samples[name])) / h**order)
        assert abs(value - expected) <= tolerance * size, (name, order, value, expected)


# ---- forward ----


def later(inputs: dict, t: float) -> dict:
    """The same polynomials from t on."""
    return {
        name: [
            sum(u[i] * t ** (i - k) / math.factorial(i - k) for i in range(k, len(u))) for k in range(len(u))
        ]
        for name, u in inputs.items()
    }


def along(fmu: Driver, inputs: dict, times) -> dict:
    """Outputs at these times from now on; then as before."""
    state, start = fmu.take(), fmu.time
    samples: dict = {name: [] for name in MOTION}
    for t in times:
        step(fmu, float(t), inputs)
        for name in MOTION:
            samples[name].append(fmu.get(name))
        fmu.restore(state)
        fmu.time = start
    fmu.free_state(state)
    return samples


def check_between_events(fmu: Driver, inputs: dict, h: float, mode: int) -> None:
    """Central differences about 5 h from now."""
    samples = along(fmu, inputs, (AROUND + 5.0) * h)
    step(fmu, 5.0 * h, inputs)
    assert fmu.get("mode") == mode
    events, found = fmu.get("events"), derivatives(fmu, MOTION)
    assert_close(found, AROUND, samples, h)
    assert found["theta", 1] == pytest.approx(fmu.get("omega"), rel=1e-13)
    assert found["z", 1] == pytest.approx(fmu.get("v"), rel=1e-13)
    assert found["theta", 2] == found["omega", 1] == fmu.get("alpha") != 0.0
    assert found["z", 2] == found["v", 1]
    run_on(fmu, later(inputs, 5.0 * h), 0.0, 5.0 * h, 1)
    assert fmu.get("events") == events


def check_ahead(fmu: Driver, inputs: dict, h: float) -> None:
    """One-sided differences from now on; these inputs are set already."""
    found = derivatives(fmu, MOTION)
    assert_close(found, AHEAD, along(fmu, inputs, AHEAD * h), h)


def slipping(make_model, values: dict, direction: int) -> tuple[Driver, dict]:
    """An FMU that slips, and inputs that keep it so."""
    theta = 0.45 if direction > 0 else 0.55
    start = {"initial.theta": theta, "initial.omega": 2.0 * direction}
    fmu = make_model(FORWARD).start(values | start, tolerance=1e-12)
    edge = fmu.get("torque_load" if direction > 0 else "torque_release")
    resisted = any(values.get(name, 0.0) for name in ("inertia.shaft", "shaft.damping"))
    fmu.step(1e-4, tau=edge * (1.0 + 0.2 * direction if resisted else 1.0 + 0.05 * direction), F_ext=1.0)
    return fmu, {
        "tau": [fmu.get("tau"), 2.0 * edge * direction, edge, -5.0 * edge * direction],
        "F_ext": [1.0, -5.0 * direction, 60.0, 300.0],
    }


def check_slip(make_model, values: dict, direction: int, h: float) -> None:
    """Between events, in slip of one direction."""
    fmu, inputs = slipping(make_model, values, direction)
    check_between_events(fmu, inputs, h, LOADING if direction > 0 else RELEASING)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize("groove", GROOVES)
def test_while_it_slips(make_model, grooves, groove, regime, direction):
    check_slip(make_model, LINEAR | CURVED | grooves[groove] | REGIMES[regime], direction, H[regime])


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("regime", LINEAR_REGIMES)
def test_while_it_slips_in_closed_form(make_model, regime, direction):
    fmu, inputs = slipping(make_model, LINEAR | GROOVES["helices"] | REGIMES[regime], direction)
    ramps = {name: u[:2] for name, u in inputs.items()}
    if regime != "rate-independent":
        check_between_events(fmu, ramps, H[regime], LOADING if direction > 0 else RELEASING)


def test_ahead_of_a_start(make_model, grooves):
    """From rest beyond the edge of the band: speed, or acceleration, comes at once."""
    for regime in ("inertial", "viscous", "viscous, quadratic"):
        for groove in grooves.values():
            for direction in (1, -1):
                values = LINEAR | CURVED | groove | REGIMES[regime] | {"initial.theta": 0.45}
                fmu = make_model(FORWARD).start(values, tolerance=1e-12)
                edge = fmu.get("torque_load" if direction > 0 else "torque_release")
                inputs = {"tau": [edge * (1.0 + 0.3 * direction), edge, 20.0], "F_ext": [0.0, 2.0]}
                fmu.set({"tau": inputs["tau"][0]})
                fmu.set_derivatives({"tau": inputs["tau"][1:], "F_ext": inputs["F_ext"][1:]})
                check_ahead(fmu, inputs, 0.3 * H[regime])


@pytest.mark.parametrize("regime", REGIMES)
def test_ahead_of_a_knot(make_model, grooves, regime):
    """A table's third derivative jumps at its knots: what counts is the piece that comes next."""
    found = []
    for direction in (1, -1):
        values = LINEAR | CURVED | grooves["tables"] | REGIMES[regime]
        knot = 2.0 * float(KNOTS[4])
        start = {"initial.theta": knot, "initial.omega": 2.0 * direction}
        fmu = make_model(FORWARD).start(values | start, tolerance=1e-12)
        edge = fmu.get("torque_load" if direction > 0 else "torque_release")
        resisted = regime != "rate-independent"
        tau = edge * (1.0 + 0.2 * direction) if resisted else edge
        inputs = {"tau": [tau, 2.0 * edge * direction, edge], "F_ext": [0.0, 0.0, 30.0]}
        fmu.set({"tau": tau})
        fmu.set_derivatives({"tau": inputs["tau"][1:], "F_ext": inputs["F_ext"][1:]})
        assert fmu.get("mode") == (LOADING if direction > 0 else RELEASING)
        check_ahead(fmu, inputs, 0.3 * H[regime])
        found.append(fmu.output_derivative("v", 2))
    assert abs(found[0]) != pytest.approx(abs(found[1]), rel=1e-3)


def test_at_rest_nothing_moves(make_model, grooves):
    """Inside the band and pressed into a stop, whatever the inputs' derivatives."""
    for regime in REGIMES.values():
        for theta, tau in ((0.45, 1.0), (-0.1, 0.0), (-0.1, -5.0)):
            values = LINEAR | grooves["mixed"] | regime | {"initial.theta": theta}
            fmu = make_model(FORWARD).start(values)
            fmu.set({"tau": 0.5 * (fmu.get("torque_load") + fmu.get("torque_release")) if tau > 0 else tau})
            fmu.set_derivatives({"tau": [-1.0, 2.0], "F_ext": [1.0]})
            assert fmu.get("mode") == (STICK if tau > 0 else LOWER_STOP)
            assert set(derivatives(fmu, MOTION).values()) == {0.0}


@pytest.mark.parametrize("direction", [1, -1])
def test_where_a_ramp_reaches_the_edge(make_model, direction):
    """Torque on the edge of the band, about to leave it: at rest now, and one order later it is not. By
    hand: J alpha' = tau' with inertia, B alpha = tau' without, theta' = tau'/K without damping."""
    lift, mu = 0.01, 0.14
    rho = lift * ((1 + mu) / (1 - mu)) ** direction
    values = {"inertia.shaft": 0.0, "initial.theta": 0.5, "cam1.friction": mu, "cam2.friction": mu}
    edge, rate = rho * (50.0 + 50e3 * lift * 0.5), 3.0 * direction
    stiffness, damping = rho * 50e3 * lift, 0.02 + rho * 70.0 * lift
    for more, expected in (
        ({"inertia.shaft": 0.002}, [0.0, 0.0, rate / 0.002]),
        (
            {"shaft.damping": 0.02, "damper.c_load": 70.0, "damper.c_release": 70.0},
            [0.0, rate / damping, -stiffness * rate / damping**2],
        ),
        ({}, [rate / stiffness, 0.0, 0.0]),
    ):
        for curved in (False, True):  # the closed form, and what there is for curved inputs
            fmu = make_model(FORWARD).start(values | more)
            fmu.set({"tau": edge})
            fmu.set_derivatives({"tau": [rate, 0.0, 1e-9] if curved else [rate]})
            assert fmu.get("mode") == (LOADING if direction > 0 else RELEASING)
            found = derivatives(fmu, ("theta", "omega", "z", "v"))
            sizes = [abs(rate / stiffness), 1.0, 1.0]
            for order, (value, size) in enumerate(zip(expected, sizes, strict=True)):
                tolerance = 1e-9 * max(abs(value), size)
                pairs = [("theta", order + 1), ("omega", order)]
                for name, k in pairs:
                    if k in (1, 2):
                        assert found[name, k] == pytest.approx(value, abs=tolerance)
                        other = {"theta": "z", "omega": "v"}[name]
                        assert found[other, k] == pytest.approx(lift * value, abs=lift * tolerance)


@pytest.mark.parametrize("direction", [1, -1])
def test_along_the_edge_on_helices(make_model, direction):
    """Without inertia and damping theta = ((tau/rho - F_ext) - F0)/(k z'), with all derivatives."""
    lift, mu, k = 0.01, 0.14, 50e3
    rho = lift * ((1 + mu) / (1 - mu)) ** direction
    fmu = make_model(FORWARD).start({"inertia.shaft": 0.0, "initial.theta": 0.5})
    fmu.set({"tau": rho * (50.0 + k * lift * 0.5)})
    tau, F_ext = [3.0 * direction, -20.0, 700.0], [-4.0 * direction, 90.0, -1000.0]
    fmu.set_derivatives({"tau": tau, "F_ext": F_ext})
    theta = [(t / rho - f) / (k * lift) for t, f in zip(tau, F_ext, strict=True)]
    expected = [theta[0], theta[1], theta[1], theta[2]]
    found = derivatives(fmu, MOTION)
    assert list(found.values()) == pytest.approx([*expected, *(lift * x for x in expected)], rel=1e-11)


# ---- inverse ----

TORQUE = ("tau", "z", "v")


def imposed(motion: dict, t: float) -> dict:
    """theta, omega, alpha and F_ext at t; `motion` has Taylor polynomials of theta and F_ext."""
    theta, F_ext = (np.polynomial.Polynomial(motion[name]) for name in ("theta", "F_ext"))
    return {
        "theta": float(theta(t)),
        "omega": float(theta.deriv()(t)),
        "alpha": float(theta.deriv(2)(t)),
        "F_ext": float(F_ext(t)),
    }


def given(motion: dict) -> dict:
    """What fmi2SetRealInputDerivatives is to give for it."""
    theta, F_ext = (np.polynomial.Polynomial(motion[name]) for name in ("theta", "F_ext"))
    return {
        "alpha": [float(theta.deriv(3)(0.0)), float(theta.deriv(4)(0.0))],
        "F_ext": [float(F_ext.deriv(k)(0.0)) for k in (1, 2)],
    }


def moved_to(coefficients: list, shift: float) -> list:
    """The same polynomial in t, t = 0 being where t = shift was."""
    p = np.polynomial.Polynomial(coefficients)(np.polynomial.Polynomial([shift, 1.0]))
    return [float(c) for c in p.coef]


def read_along(fmu: Driver, motion: dict, times) -> dict:
    """Outputs along the motion, without a step; then as at time 0."""
    samples: dict = {name: [] for name in TORQUE}
    for t in times:
        fmu.set(imposed(motion, float(t)))
        for name in TORQUE:
            samples[name].append(fmu.get(name))
    fmu.set(imposed(motion, 0.0))
    return samples


@pytest.mark.parametrize("F_ext", [10.0, -700.0])
@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("regime", REGIMES)
@pytest.mark.parametrize("groove", GROOVES)
def test_torque_along_a_motion(make_model, grooves, groove, regime, direction, F_ext):
    motion = {"theta": [0.5, 3.0 * direction, 20.0, -700.0, 4000.0], "F_ext": [F_ext, 200.0, -3000.0]}
    h = 1e-3
    fmu = make_model(INVERSE)
    fmu.set(imposed(motion, 0.0))
    fmu.start(LINEAR | CURVED | grooves[groove] | REGIMES[regime] | MASSES)
    fmu.set_derivatives(given(motion))
    samples = read_along(fmu, motion, AROUND * h)
    found = derivatives(fmu, TORQUE)
    assert_close(found, AROUND, samples, h)
    assert found["z", 1] == fmu.get("v")
    assert found["z", 2] == found["v", 1]


def inverse_at(make_model, values: dict, motion: dict) -> Driver:
    fmu = make_model(INVERSE)
    fmu.set(imposed(motion, 0.0))
    fmu.start(values)
    return fmu


RICH = LINEAR | CURVED | GROOVES["ellipses"] | REGIMES["viscous, quadratic"] | MASSES


@pytest.mark.parametrize("name", ["theta", "omega", "alpha"])
def test_whichever_derivatives_are_given(make_model, name):
    """The derivatives of a cubic theta, or those of its omega or alpha; before and after a step."""
    motion = {"theta": [0.5, 3.0, 10.0, -50.0], "F_ext": [10.0, 200.0, -3000.0]}
    theta = np.polynomial.Polynomial(motion["theta"])
    rates = {
        "theta": [float(theta.deriv(k)(0.0)) for k in (1, 2, 3)],
        "omega": [float(theta.deriv(k)(0.0)) for k in (2, 3)],
        "alpha": [float(theta.deriv(3)(0.0))],
    }
    fmu, h = inverse_at(make_model, RICH, motion), 1e-3
    fmu.set_derivatives({name: rates[name], "F_ext": given(motion)["F_ext"]})
    assert_close(derivatives(fmu, TORQUE), AROUND, read_along(fmu, motion, AROUND * h), h)
    fmu.step(0.02)
    assert fmu.get("theta") == pytest.approx(float(theta(0.02)), rel=1e-14)
    found = derivatives(fmu, TORQUE)
    assert_close(found, AROUND, read_along(fmu, motion, 0.02 + AROUND * h), h)
    fmu.set(imposed(motion, 0.02))
    fmu.step(0.01, **imposed({"theta": [0.7, 2.0], "F_ext": [9.0]}, 0.0))
    straight = {"theta": [0.7, 2.0], "F_ext": [9.0]}
    found = derivatives(fmu, TORQUE)
    assert_close(found, AROUND, read_along(fmu, straight, AROUND * h), h)


def test_a_quartic_of_omega_goes_on_after_the_step(make_model):
    motion = {"theta": [0.5, 3.0, 10.0, -50.0, 900.0], "F_ext": [10.0]}
    omega = np.polynomial.Polynomial(motion["theta"]).deriv()
    fmu, h = inverse_at(make_model, RICH, motion), 1e-3
    fmu.set_derivatives({"omega": [float(omega.deriv(k)(0.0)) for k in (1, 2, 3)]})
    for t in (0.0, 0.02):
        assert_close(derivatives(fmu, TORQUE), AROUND, read_along(fmu, motion, t + AROUND * h), h)
        fmu.step(0.02 - t if t == 0.0 else 0.01)


@pytest.mark.parametrize("before", [1, -1])
@pytest.mark.parametrize("start", [[0.0, 0.0, 12.0, 300.0], [0.0, 0.0, 0.0, 40.0, 900.0], [0.0, 0.0, -12.0]])
def test_ahead_of_a_rest(make_model, before, start):
    """Where the speed is zero, what counts is the direction in which it starts, not the one that was."""
    fmu = inverse_at(make_model, RICH, {"theta": [0.5 - 0.1 * before], "F_ext": [10.0]})
    fmu.step(0.1, theta=0.5, omega=0.0)
    motion, h = {"theta": [0.5, *start[1:]], "F_ext": [10.0, -30.0, 500.0]}, 1e-3
    fmu.set(imposed(motion, 0.0))
    fmu.set_derivatives(given(motion))
    found = derivatives(fmu, TORQUE)
    assert_close(found, AHEAD, read_along(fmu, motion, AHEAD * h), h)


@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("rate", [400.0, -400.0])
def test_ahead_of_a_change_of_flanks(make_model, way, rate):
    """No load at all now; which flanks bear is told by how it goes on."""
    values = LINEAR | GROOVES["ellipses"] | {"spring.preload": 0.0, "spring.stiffness": 1e3}
    motion = {"theta": [0.0, 2.0 * way], "F_ext": [0.0, rate, 1000.0]}
    fmu, h = inverse_at(make_model, values, motion), 1e-3
    fmu.set_derivatives(given(motion))
    found = derivatives(fmu, TORQUE)
    assert found["tau", 1] != 0.0
    assert_close(found, AHEAD, read_along(fmu, motion, AHEAD * h), h)


@pytest.mark.parametrize("load", [60.0, -60.0])  # N
@pytest.mark.parametrize("way", [1, -1])
@pytest.mark.parametrize("rate", [400.0, -400.0])
def test_ahead_of_a_change_of_one_flank(make_model, way, rate, load):
    """Contact 2 carries all of the load at first. By section 3 of docs/mechanism.md its torque is
    F r_2 tan(lambda_2 + e_2 sigma phi_2). The follower's inertia I gamma' alpha takes this torque, and
    contact 1 carries nothing. Then F_ext puts a load on contact 1, on one flank or on the other."""
    lead, radius, friction, inertia = (0.6, 0.9), (0.02, 0.025), 0.1, 0.03
    slope = [r * math.tan(x) for r, x in zip(radius, lead, strict=True)]
    torque = load * radius[1] * math.tan(lead[1] + way * math.copysign(math.atan(friction), load))
    alpha = torque / (inertia * slope[1] / sum(slope))
    values = {f"cam{i + 1}.radius": radius[i] for i in range(2)} | {"cam1.friction": friction}
    values |= {f"cam{i + 1}.lead_angle": lead[i] for i in range(2)} | {"cam2.friction": friction}
    values |= {
        "spring.preload": load,
        "spring.stiffness": 0.0,
        "inertia.follower": inertia,
        "inertia.shaft": 0.0,
    }
    motion = {"theta": [0.4, 2.0 * way, alpha / 2.0], "F_ext": [0.0, rate]}
    fmu, h = inverse_at(make_model, values, motion), 1e-3
    assert fmu.get("tau") == pytest.approx(torque, rel=1e-12)
    assert fmu.get("cam1.reaction") == pytest.approx(0.0, abs=1e-12 * abs(load))
    fmu.set_derivatives(given(motion))
    found = derivatives(fmu, ["tau"])
    assert_close(found, AHEAD, read_along(fmu, motion, AHEAD * h), h)


@pytest.mark.parametrize("rate", [4000.0, -4000.0])
@pytest.mark.parametrize("way", [1, -1])
def test_ahead_of_a_load_on_locked_contacts(make_model, way, rate):
    """No load at all now, and cam 1 locks. Under a load of one sign that follows, the contacts wedge, and the
    torque has no rate. Under a load of the other sign two pairs of flanks agree."""
    values = LINEAR | WEDGING | {"spring.preload": 0.0, "spring.stiffness": 0.0}
    motion = {"theta": [0.5, way], "F_ext": [0.0, rate]}
    fmu, h = inverse_at(make_model, values, motion), 1e-3
    assert fmu.get("tau") == 0.0
    fmu.set_derivatives(given(motion))
    if way * rate < 0.0:
        refused_derivative(fmu, "tau", "tau")
        return
    found = derivatives(fmu, ["tau"])
    assert_close(found, AHEAD, read_along(fmu, motion, AHEAD * h), h)


@pytest.mark.parametrize("groove", GROOVES)
@pytest.mark.parametrize("direction", [1, -1])
def test_elastic_shaft_dragging(make_model, grooves, groove, direction):
    """Cam 2 slips along the edge of the band, tau = K (theta - theta_cam)."""
    values = LINEAR | CURVED | grooves[groove] | {"shaft.stiffness": 60.0}
    fmu = inverse_at(make_model, values, {"theta": [0.5 - 0.4 * direction], "F_ext": [10.0]})
    fmu.step(0.1, theta=0.5, omega=direction)
    motion = {
        "theta": [0.5 + 0.03 * direction, 2.0 * direction, 20.0, -90.0, 3000.0],
        "F_ext": [10.0, 50.0, -900.0],
    }
    h = 1e-3
    fmu.set(imposed(motion, 0.0))
    fmu.set_derivatives(given(motion))
    assert fmu.get("mode") == (LOADING if direction > 0 else RELEASING)
    found = derivatives(fmu, TORQUE)
    samples = read_along(fmu, motion, AROUND * h)
    assert fmu.get("v") == pytest.approx(found["z", 1], rel=1e-12)
    assert found["v", 1] == found["z", 2]
    position = {"tau": samples["tau"], "z": samples["z"]}
    assert_close({key: value for key, value in found.items() if key[0] != "v"}, AROUND, position, h)
    assert found["v", 2] == pytest.approx(difference(AROUND, samples["z"], h, 3), rel=1e-5)


def test_elastic_shaft_after_a_step(make_model):
    """A step that ends in slip leaves cam 2 on the edge that F_ext has come to: as if moved there at once."""
    values = LINEAR | CURVED | GROOVES["ellipses"] | {"shaft.stiffness": 60.0}
    start = {"theta": [0.2], "F_ext": [10.0]}
    end = {"theta": [0.55, 2.0, 20.0, -90.0, 3000.0], "F_ext": [12.0, 50.0, -900.0]}
    moved, at_once = (inverse_at(make_model, values, start) for _ in range(2))
    h = 0.02
    before = {name: moved_to(end[name], -h) for name in end}
    moved.set(imposed(before, 0.0))
    moved.set_derivatives(given(before))
    moved.step(h)
    at_once.set(imposed(end, 0.0))
    at_once.set_derivatives(given(end))
    assert moved.get("mode") == LOADING
    found, expected = derivatives(moved, TORQUE), derivatives(at_once, TORQUE)
    assert found == pytest.approx(expected, rel=1e-9)
    assert moved.get("v") == pytest.approx(found["z", 1], rel=1e-12)


def test_elastic_shaft_stuck(make_model):
    values = LINEAR | GROOVES["ellipses"] | MASSES | {"shaft.stiffness": 60.0}
    fmu = inverse_at(make_model, values, {"theta": [0.5], "F_ext": [0.0]})
    fmu.step(0.1, theta=0.502, omega=0.02)
    fmu.set({"alpha": 7.0})
    assert fmu.get("mode") == STICK
    assert list(derivatives(fmu, TORQUE).values()) == [1.2, 420.0, 0.0, 0.0, 0.0, 0.0]


def test_elastic_shaft_ahead_of_a_rest(make_model):
    """At rest on the upper edge: cam 2 follows upward, downward the shaft gives way; F_ext can free it."""
    values = LINEAR | GROOVES["helices"] | {"cam2.radius": 0.02, "shaft.stiffness": 60.0}
    fmu = inverse_at(make_model, values, {"theta": [0.2], "F_ext": [0.0]})
    fmu.step(0.1, theta=0.6, omega=0.0)
    assert fmu.get("tau") == pytest.approx(fmu.get("torque_load"), rel=1e-12)
    rho = fmu.get("torque_load") / fmu.get("spring.force")
    lift = fmu.get("z") / fmu.get("theta_cam")
    edge = rho * 2e4 * lift  # N.m/rad
    fmu.set({"alpha": 5.0})
    assert fmu.output_derivative("tau", 1) == 0.0
    assert fmu.output_derivative("tau", 2) == pytest.approx(60.0 * 5.0 * edge / (60.0 + edge), rel=1e-10)
    assert fmu.output_derivative("v", 1) == pytest.approx(lift * 60.0 * 5.0 / (60.0 + edge), rel=1e-10)
    fmu.set({"alpha": -5.0})
    assert fmu.output_derivative("tau", 2) == -300.0
    assert fmu.output_derivative("v", 1) == 0.0
    fmu.set({"alpha": 0.0})
    fmu.set_rates(F_ext=-30.0)
    found = derivatives(fmu, TORQUE)
    assert found["v", 2] == pytest.approx(0.0, abs=1e-9)
    assert fmu.get("v") == pytest.approx(found["z", 1], rel=1e-12)
    assert found["z", 1] == pytest.approx(lift * rho * 30.0 / (60.0 + edge), rel=1e-10)
    assert found["tau", 1] == pytest.approx(-60.0 * rho * 30.0 / (60.0 + edge), rel=1e-10)


def test_at_stops_and_where_it_is_refused(make_model):
    """At a stop, pressed into it, the polynomial goes on beyond; beyond it nothing is known."""
    fmu = inverse_at(make_model, RICH | {"stop.upper": 1.0}, {"theta": [1.0, 3.0], "F_ext": [0.0]})
    assert all(math.isfinite(value) for value in derivatives(fmu, TORQUE).values())
    assert fmu.output_derivative("tau", 1) != 0.0
    fmu.set({"theta": 1.1})
    for name in TORQUE:
        assert refused_derivative(fmu, name, "theta", "stop.upper") == 7.0


def test_wedged_motion_has_no_torque_and_no_rate_of_it(make_model):
    """No pair of flanks carries a release."""
    fmu = inverse_at(make_model, LINEAR | WEDGING, {"theta": [0.5, -1.0], "F_ext": [0.0]})
    refused_derivative(fmu, "tau", "wedge")
    assert fmu.output_derivative("z", 1) == fmu.get("v") != 0.0
    assert fmu.output_derivative("v", 2) == pytest.approx(0.0, abs=1e-12)


def test_at_rest_before_a_wedge(make_model):
    """alpha would start it in the direction that wedges: what counts is the direction that tau is for."""
    fmu = inverse_at(make_model, LINEAR | WEDGING, {"theta": [0.5, 1.0], "F_ext": [0.0]})
    fmu.set({"omega": 0.0, "alpha": -1.0})
    assert fmu.get("torque_release") == -math.inf
    rho, lift = fmu.get("torque_load") / fmu.get("spring.force"), fmu.get("z") / 0.5
    assert fmu.get("tau") == pytest.approx(fmu.get("torque_load"), rel=1e-12)
    assert fmu.output_derivative("tau", 2) == pytest.approx(-rho * 2e4 * lift, rel=1e-11)
