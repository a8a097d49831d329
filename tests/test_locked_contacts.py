"""Contacts that lock: in one direction no torque moves cam 2, and the edge of the stick band is infinite.

Two helices under a spring that is weaker the higher the follower is: F = F_0 - k2 z^2 is zero at
theta = FREE. Under F > 0 loading has a finite edge rho F, and releasing is locked. Under F < 0 loading is
locked. So a motion that loads ends at FREE, and nothing moves cam 2 from there. All numbers are closed forms.
"""

import ctypes
import math

import pytest
from driver import MODEL_EXCHANGE, models
from pin_equations import edge
from reference import DOUBLE, LOADING, RELEASING, STICK, WEDGED, Mechanism

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]
RADIUS, LEAD, MU = 0.02, (0.44, 0.58), (3.0, 0.17)
PRELOAD, FREE, STIFF = 50.0, 0.6, 20.0  # N, rad, N.m/rad: stiffer than the edge is steep
SLOPE = tuple(RADIUS * math.tan(lead) for lead in LEAD)
LIFT = SLOPE[0] * SLOPE[1] / sum(SLOPE)
FORCE = PRELOAD * FREE * 2.0 / 3.0  # N.rad, integral of the spring's force from 0 to FREE
WEAR = 1e-15


class Place:
    r, a = (RADIUS, RADIUS), SLOPE


RHO = edge(Place, MU, 1, 1.0)[0]  # m, torque per force at the edge that loads
PARAMETERS = {
    **{f"cam{i}.lead_angle": lead for i, lead in enumerate(LEAD, start=1)},
    **{f"cam{i}.friction": mu for i, mu in enumerate(MU, start=1)},
    "cam1.wear": WEAR,
    "spring.preload": PRELOAD,
    "spring.stiffness": 0.0,
    "spring.stiffness2": -PRELOAD / (LIFT * FREE) ** 2,
    "inertia.shaft": 0.0,
    "stop.upper": 1.0,
}
NEAR = 1e-9  # the default tolerance


def heat(fmu):
    return fmu.get("energy.heat_cam1") + fmu.get("energy.heat_cam2")


def test_only_one_direction_has_a_finite_edge():
    assert [
        edge(Place, MU, way, force)[0] for way, force in ((1, 1.0), (-1, 1.0), (1, -1.0), (-1, -1.0))
    ] == [
        RHO,
        -math.inf,
        math.inf,
        -RHO,
    ]


@pytest.mark.parametrize("ledger", [True, False])
@pytest.mark.parametrize("share", [1.2, 20.0])  # of the torque that holds the spring at theta = 0
def test_a_jump_of_the_torque_ends_where_the_contacts_lock(make_model, share, ledger):
    fmu = make_model(FORWARD).start(PARAMETERS | {"ledger": ledger})
    fmu.step(0.01, tau=share * RHO * PRELOAD)
    assert fmu.get("theta") == pytest.approx(FREE, rel=NEAR)
    assert fmu.get("mode") == WEDGED
    booked = float(ledger)
    assert fmu.get("energy.work_in") == pytest.approx(booked * RHO * FORCE, rel=NEAR)
    assert heat(fmu) == pytest.approx(booked * (RHO - LIFT) * FORCE, rel=NEAR)
    worn = WEAR * fmu.get("energy.heat_cam1") / MU[0] / fmu.get("contacts")
    assert fmu.get("wear.cam1") == pytest.approx(worn, rel=NEAR)


@pytest.mark.parametrize("ledger", [True, False])
def test_cam_2_on_an_elastic_shaft_stays_where_it_locks(make_model, ledger):
    fmu = make_model(INVERSE).start(PARAMETERS | {"shaft.stiffness": STIFF, "omega": 10.0, "ledger": ledger})
    fmu.step(0.1, theta=1.0)
    assert fmu.get("theta_cam") == pytest.approx(FREE, rel=NEAR)
    assert fmu.get("tau") == pytest.approx(STIFF * (1.0 - FREE), rel=NEAR)
    assert fmu.get("mode") == STICK
    booked = float(ledger)
    assert heat(fmu) == pytest.approx(booked * (RHO - LIFT) * FORCE, rel=NEAR)
    stored = 0.5 * STIFF * (1.0 - FREE) ** 2
    assert fmu.get("energy.work_in") == pytest.approx(booked * (RHO * FORCE + stored), rel=NEAR)
    fmu.step(0.1, theta=-1.0, omega=0.0)
    assert fmu.get("theta_cam") == pytest.approx(FREE, rel=NEAR)
    assert fmu.get("tau") == pytest.approx(STIFF * (-1.0 - FREE), rel=NEAR)
    by_theta = ctypes.c_double()
    one = (ctypes.c_double * 1)(1.0)
    references = INVERSE.references
    fmu.ok("GetDirectionalDerivative", references(["tau"]), 1, references(["theta"]), 1, one, by_theta)
    assert by_theta.value == STIFF


def test_under_a_pull_the_far_end_turns_alone(make_model):
    """F < 0 from the start: loading is locked, and the torque that releases is finite."""
    fmu = make_model(INVERSE).start(PARAMETERS | {"shaft.stiffness": STIFF, "theta": 0.2, "F_ext": -100.0})
    force = -100.0 + PRELOAD * (1.0 - (0.2 / FREE) ** 2)
    assert fmu.get("torque_load") == math.inf
    assert fmu.get("torque_release") == pytest.approx(RHO * force, rel=1e-14)
    assert fmu.get("efficiency") == 0.0
    fmu.step(0.1, theta=0.9)
    assert (fmu.get("theta_cam"), fmu.get("mode")) == (0.2, STICK)
    assert fmu.get("tau") == pytest.approx(STIFF * 0.7, rel=1e-14)


def test_a_locked_release_has_no_indicator_that_falls(make_model):
    """Model exchange, at rest under a load: the indicator of an infinite edge is 1 under any torque."""
    fmu = make_model(FORWARD, kind=MODEL_EXCHANGE)
    fmu.set(PARAMETERS | {"inertia.shaft": 1e-3, "initial.theta": 0.2})
    fmu.setup()
    fmu.enter("step mode")
    fmu.settle()
    for tau in (0.0, -1e3, -1e9):
        fmu.set({"tau": tau})
        _, load, release, *_ = fmu.vector("GetEventIndicators", 7)
        assert release == 1.0
        way = RHO * PRELOAD * (1.0 - (0.2 / FREE) ** 2) - tau
        assert load == pytest.approx(way, rel=1e-9)


# ---- without load ----

UNLOADED = PARAMETERS | {"spring.preload": 0.0, "spring.stiffness2": 0.0, "stop.lower": -1.0}
SHAFT, TORQUE = 1e-2, 0.4  # kg.m2, N.m
SPRING = 2e3  # N/m
LAWS = {
    "Coulomb": {},
    "by speed": {"cam1.friction_peak": 1.0 + 1e-12},
    "curved spring": {"spring.stiffness3": 1e-9},
}


def pushed(make_model, parameters, torque, h, **forces):
    fmu = make_model(FORWARD).start(UNLOADED | parameters)
    fmu.set({"tau": torque})
    if forces:
        fmu.set_derivatives(forces)
    fmu.step(h)
    return fmu


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("way", [1, -1])
def test_without_a_load_nothing_locks(make_model, way, law):
    """J alpha = tau."""
    h = 0.05
    fmu = pushed(make_model, law | {"inertia.shaft": SHAFT}, way * TORQUE, h)
    assert fmu.get("mode") == (LOADING if way > 0 else RELEASING)
    assert fmu.get("theta") == pytest.approx(way * TORQUE * h**2 / (2.0 * SHAFT), rel=NEAR)
    assert heat(fmu) == pytest.approx(0.0, abs=NEAR * TORQUE)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize("way", [1, -1])
def test_a_spring_without_preload_loads_either_way(make_model, way, law):
    """The spring pulls back from either side of its free length, and the edge rho F is finite on both sides:
    J alpha = tau - rho k z' theta."""
    h, stiffness = 0.05, RHO * SPRING * LIFT  # N.m/rad
    parameters = law | {"inertia.shaft": SHAFT, "spring.stiffness": SPRING}
    fmu = pushed(make_model, parameters, way * TORQUE, h)
    end = way * TORQUE / stiffness * (1.0 - math.cos(h * math.sqrt(stiffness / SHAFT)))
    assert fmu.get("theta") == pytest.approx(end, rel=NEAR)


@pytest.mark.parametrize("way", [1, -1])
def test_without_inertia_a_spring_without_preload_holds_the_torque(make_model, way):
    """tau = rho k z' theta"""
    torque = 0.25 * TORQUE
    fmu = pushed(make_model, {"spring.stiffness": SPRING}, way * torque, 0.05)
    assert fmu.get("theta") == pytest.approx(way * torque / (RHO * SPRING * LIFT), rel=NEAR)


# In this curved groove the height at theta = 0 is 3e-18 m instead of 0.
CURVED = {
    **{f"cam{i}.radius": r for i, r in enumerate((1.0, 0.1), start=1)},
    **{f"cam{i}.friction": mu for i, mu in enumerate((1.0, 0.0), start=1)},
    **{f"cam{i}.lead_angle": lead for i, lead in enumerate((0.25, 1.0), start=1)},
    **{"cam2.profile": 2, "cam2.ellipse_a": 0.5, "cam2.ellipse_b": 0.5, "cam2.ellipse_curvature": -1},
    "spring.stiffness": 1.0,
}


@pytest.mark.parametrize("way", [1, -1])
def test_a_jump_may_begin_where_rounding_locks_a_contact(make_model, way):
    """It ends where the torque is on the edge of the stick band. The step was refused."""
    torque = way * 1e-3
    fmu = pushed(make_model, CURVED, torque, 0.05)
    kin = Mechanism(UNLOADED | CURVED, DOUBLE).groove.at(fmu.get("theta"))

    class There:
        r, a = (1.0, 0.1), (kin.a1, kin.a2)

    assert edge(There, (1.0, 0.0), way, kin.z)[0] == pytest.approx(torque, rel=NEAR)
    assert fmu.get("energy.work_in") == pytest.approx(heat(fmu) + kin.z**2 / 2.0, rel=NEAR)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
@pytest.mark.parametrize(("rate", "mode"), [(30.0, WEDGED), (-30.0, RELEASING)])
def test_the_load_that_comes_tells_whether_the_contacts_lock(make_model, law, rate, mode):
    fmu = pushed(make_model, law | {"inertia.shaft": SHAFT}, -TORQUE, 0.05, F_ext=[rate])
    assert fmu.get("mode") == mode
    assert (fmu.get("theta") == 0.0) == (mode == WEDGED)


def test_a_spring_that_loads_on_both_sides_locks(make_model):
    """F = k2 z^2 > 0 wherever the follower goes."""
    parameters = {"inertia.shaft": SHAFT, "spring.stiffness2": 1e5}
    fmu = pushed(make_model, parameters, -TORQUE, 0.05)
    assert (fmu.get("mode"), fmu.get("theta")) == (WEDGED, 0.0)
