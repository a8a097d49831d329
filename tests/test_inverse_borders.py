"""Inverse dynamics at the borders of what is allowed: no load, dwells, motions beyond the stops, accounts
that overflow, parameters tuned to what an elastic shaft does not allow. Closed forms and messages."""

import ctypes
import math

import numpy as np
import pytest
from driver import models
from mechanisms import LIFT, PRELOAD, RHO, STIFFNESS
from reference import STICK, write_table
from scipy.integrate import quad

INVERSE = models["DualCamInverse"]
DEFAULT = 1e-9  # tolerance


@pytest.fixture(scope="session")
def model():
    return INVERSE


def heat(fmu):
    return fmu.get("energy.heat_cam1") + fmu.get("energy.heat_cam2")


# ---- no load, dwells ----


def test_efficiency_without_a_load_is_that_of_a_small_one(make):
    """At theta = 0 without preload both edges are 0, and their ratio is 0/0."""
    fmu = make().start({"spring.preload": 0.0, "theta": 0.0})
    assert (fmu.get("torque_load"), fmu.get("torque_release")) == (0.0, 0.0)
    assert fmu.get("efficiency") == pytest.approx(RHO[-1] / RHO[1], rel=1e-14)
    fmu.set({"theta": 1e-6})
    assert fmu.get("efficiency") == pytest.approx(RHO[-1] / RHO[1], rel=1e-14)


@pytest.mark.parametrize(("friction", "efficiency"), [(0.0, 1.0), (0.2, 0.0)])
def test_efficiency_on_a_dwell_without_friction_of_its_own(make, friction, efficiency):
    """Cam 1 is level and without friction: no torque is needed, and none moves the follower either way."""
    fmu = make().start({"cam1.lead_angle": 0.0, "cam1.friction": 0.0, "cam2.friction": friction})
    assert (fmu.get("torque_load"), fmu.get("torque_release")) == (0.0, 0.0)
    assert fmu.get("efficiency") == efficiency


# ---- beyond the stops ----


def jacobian(fmu, unknown, known):
    product, one = ctypes.c_double(), (ctypes.c_double * 1)(1.0)
    arguments = INVERSE.references([unknown]), 1, INVERSE.references([known]), 1, one, product
    return arguments, product


@pytest.mark.parametrize("unknown", ["tau", "z"])
def test_no_derivatives_beyond_a_stop(make, unknown):
    fmu = make().start({"stop.upper": 1.0, "theta": 0.5})
    fmu.set({"theta": 1.5})
    arguments, _ = jacobian(fmu, unknown, "theta")
    fmu.refused("GetDirectionalDerivative", *arguments, mentions=("theta = 1.5", "stop.upper"))


def test_a_motion_that_begins_beyond_a_stop_is_refused(make):
    """Its derivatives bring it back between the stops by the end of the step."""
    fmu = make().start({"stop.upper": 1.0, "theta": 0.9})
    fmu.set({"theta": 1.5})
    fmu.set_derivatives({"theta": [-10.0]})
    fmu.refused("fmi2DoStep", 0.0, 0.1, 1, mentions=("theta = 1.5", "stop.upper"))


def speed_with(roots, lead):
    """A speed with these zeros, and its value and derivatives at t = 0."""
    speed = np.poly1d(lead * np.poly(roots))
    return speed, [float(speed.deriv(k)(0.0)) if k else float(speed(0.0)) for k in range(len(roots) + 1)]


@pytest.mark.parametrize("side", [1, -1])
def test_cam_2_rests_at_a_stop_while_the_motion_swings_beyond(make, side):
    """A cubic speed: theta passes the stop, turns three times beyond, and comes back. Cam 2 rests meanwhile.
    The work on the way in and out is that of the edges of the stick band."""
    speed, (omega, *rates) = speed_with([0.03, 0.05, 0.08], -2e5 * side)
    theta = speed.integ()
    stops = (-1.0, 0.2) if side > 0 else (-0.2, 1.0)
    excess = [side * theta(t) for t in (0.03, 0.05, 0.08)]
    assert min(excess) > 0.2
    end = 0.11
    assert abs(theta(end)) < 0.2
    values = dict(zip(("stop.lower", "stop.upper"), stops, strict=True)) | {"inertia.shaft": 0.0}
    fmu = make().start(values | {"theta": 0.0, "omega": omega})
    fmu.set({"theta": 0.0, "omega": omega})
    fmu.set_derivatives({"omega": rates})
    fmu.step(end)
    assert fmu.get("theta_cam") == pytest.approx(theta(end), rel=DEFAULT)

    def spring(x):
        return PRELOAD + STIFFNESS * LIFT * x

    def torque(x, way):
        return RHO[way if spring(x) > 0.0 else -way] * spring(x)

    ways = [(0.0, 0.2 * side), (0.2 * side, float(theta(end)))]
    zero = -PRELOAD / (STIFFNESS * LIFT)  # where the other flanks bear
    work = sum(quad(torque, a, b, (1 if b > a else -1,), points=[zero])[0] for a, b in ways)
    assert fmu.get("energy.work_in") == pytest.approx(work, rel=100 * DEFAULT)
    lost = work - quad(lambda x: LIFT * spring(x), 0.0, float(theta(end)))[0]
    assert heat(fmu) == pytest.approx(lost, rel=100 * DEFAULT)


# ---- accounts ----


def test_an_account_that_overflows_is_refused(make):
    """The torque is a finite number, its work over the angle is none."""
    fmu = make().start({"shaft.damping": 1e304, "inertia.shaft": 0.0, "omega": 1e3, "stop.upper": 1e3})
    assert math.isfinite(fmu.get("tau"))
    fmu.set({"theta": 100.0})
    fmu.refused("fmi2DoStep", 0.0, 0.1, 1, mentions=("energy.work_in", "finite"))


# ---- an elastic shaft ----

STIFF = 20.0  # N.m/rad


def test_an_elastic_shaft_takes_no_friction_that_falls_with_the_speed(make):
    fmu = make().start({"shaft.stiffness": STIFF})
    fmu.refused_set({"cam1.friction_peak": 1.5}, mentions=("cam1.friction_peak", "elastic shaft"))


@pytest.mark.parametrize("ledger", [True, False])
def test_a_pull_that_grows_moves_cam_2_while_the_far_end_stands(make, ledger):
    """cam 2 stands on the edge that releases. A load that grows moves cam 2 back along this edge:
    K (theta - x) = rho_release (F_0 + k z' x + F_ext)."""
    theta, rate, h = 0.3, 500.0, 0.1
    fmu = make().start({"shaft.stiffness": STIFF, "theta": theta, "ledger": ledger})

    def place(pull):
        return (STIFF * theta - RHO[-1] * (PRELOAD + pull)) / (STIFF + RHO[-1] * STIFFNESS * LIFT)

    x = min(place(0.0), theta)
    assert fmu.get("theta_cam") == pytest.approx(x, rel=1e-12)
    fmu.set_rates(F_ext=rate)
    fmu.step(h)
    moved = min(place(rate * h), x)
    assert fmu.get("theta_cam") == pytest.approx(moved, rel=DEFAULT)
    assert fmu.get("tau") == pytest.approx(STIFF * (theta - moved), rel=DEFAULT)
    assert abs(fmu.get("energy.work_in")) <= DEFAULT  # the far end stands
    assert abs(fmu.get("energy.residual")) <= DEFAULT


def test_a_falling_pull_leaves_cam_2_at_rest(make):
    theta = 0.3
    fmu = make().start({"shaft.stiffness": STIFF, "theta": theta, "F_ext": 300.0})
    before = fmu.get("theta_cam")
    fmu.set_rates(F_ext=-100.0)
    fmu.step(0.1)
    assert (fmu.get("theta_cam"), fmu.get("mode")) == (before, STICK)
    arguments, product = jacobian(fmu, "z", "theta")
    fmu.ok("GetDirectionalDerivative", *arguments)
    assert product.value == 0.0  # cam 2 sticks
    arguments, product = jacobian(fmu, "tau", "theta")
    fmu.ok("GetDirectionalDerivative", *arguments)
    assert product.value == STIFF


@pytest.mark.parametrize("known", ["theta", "omega"])
def test_the_speed_of_an_elastic_shaft_has_no_derivatives(make, known):
    """v depends on the rate of theta, which is no known of the FMU."""
    fmu = make().start({"shaft.stiffness": STIFF, "theta": 0.3})
    arguments, _ = jacobian(fmu, "v", known)
    fmu.refused("GetDirectionalDerivative", *arguments, mentions=("v has no partial", "shaft.stiffness = 0"))


# ---- contacts without any load ----


@pytest.mark.parametrize("omega", [3.0, -3.0])
def test_torque_grows_from_contacts_that_carry_nothing(make, omega):
    """No preload, no inertia: at theta = 0 both contacts are idle. A little later the spring is compressed,
    or stretched: in both cases the motion loads it."""
    values = {"spring.preload": 0.0, "inertia.shaft": 0.0, "stop.lower": -1.0}
    fmu = make().start(values | {"omega": omega})
    assert fmu.get("tau") == 0.0
    fmu.step(1e-3, theta=0.0, omega=omega)
    fmu.set({"theta": 0.0, "omega": omega})
    assert fmu.output_derivative("tau", 1) == pytest.approx(RHO[1] * STIFFNESS * LIFT * omega, rel=1e-12)


def test_a_torque_that_no_motion_needs_has_no_derivatives(make):
    """Contact 1 locks: releasing has no torque."""
    locked = {"cam1.lead_angle": 0.44, "cam2.lead_angle": 0.58, "cam1.friction": 3.0, "cam2.friction": 0.17}
    fmu = make().start(locked | {"theta": 0.3, "omega": 1.0})
    fmu.set({"omega": -1.0})
    arguments, _ = jacobian(fmu, "tau", "theta")
    fmu.refused("GetDirectionalDerivative", *arguments, mentions=("wedge", "releasing"))


def test_cam_2_on_an_elastic_shaft_stays_where_the_contacts_lock(make):
    """A spring that weakens: F_0 = 0 at theta = 0.6. Beyond, no torque loads, and the far end turns alone."""
    radius, slope = (0.0382, 0.0278), (0.0382 * math.tan(0.131), 0.0278 * math.tan(0.1645))
    values = {f"cam{i}.radius": r for i, r in enumerate(radius, start=1)}
    values |= {"cam1.lead_angle": 0.131, "cam2.lead_angle": 0.1645, "cam1.friction": 0.4}
    lift, preload, end = slope[0] * slope[1] / sum(slope), 50.0, 0.6
    values |= {"cam2.friction": 0.051, "spring.preload": preload, "spring.stiffness": 0.0}
    values |= {"spring.stiffness2": -preload / (lift * end) ** 2, "shaft.stiffness": STIFF, "omega": 10.0}
    fmu = make().start(values)
    for theta in (1.0, -1.0):
        fmu.step(0.1, theta=theta, omega=0.0)
        assert fmu.get("theta_cam") == pytest.approx(end, rel=1e-9)
        assert fmu.get("tau") == pytest.approx(STIFF * (theta - end), rel=1e-9)
        assert fmu.get("mode") == STICK


def test_a_balance_without_a_solution_is_no_torque(make, tmp_path):
    """r = 1/2 m, a_i = 1/4 m, mu_1 = 1/2, mu_2 = 11/2: on the flanks (+, -) Delta is 0 to the last bit. Under
    the axial force 50 N and the moment -512 N.m no other pair has reactions on its flanks: x_i < 0 on (+, +),
    x_2 < 0 on (-, +) and x_2 > 0 on (-, -)."""
    write_table(tmp_path / "groove.csv", [k / 8 for k in range(-2, 40)], [k / 32 for k in range(-2, 40)])
    values = {"cam1.friction": 0.5, "cam2.friction": 5.5, "inertia.follower": 1.0, "spring.preload": 50.0}
    values |= {"spring.stiffness": 0.0, "stop.upper": 0.5, "theta": 0.0, "omega": 1.0}
    for i in (1, 2):
        values |= {f"cam{i}.profile": 3, f"cam{i}.table": str(tmp_path / "groove.csv"), f"cam{i}.radius": 0.5}
    fmu = make().start(values)
    fmu.set({"alpha": -1024.0})
    tau = INVERSE.references(["tau"])
    fmu.refused("GetReal", tau, 1, (ctypes.c_double * 1)(), mentions=("wedge", "loading"))
