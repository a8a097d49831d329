"""An answer does not depend on how an interval is cut into steps, in general grooves.

Closed forms for the causes that random scenes have shown (docs/limits.md, "Found by random scenes"), and
some of these scenes, `data/cut_scenes.json`, each with the name of its cause.
"""

import json
import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from driver import FORWARD, OK
from reference import LOADING, STICK, WEDGED, write_table

CUTS = [[], [0.3], [0.01, 0.2, 0.45, 0.99], list(np.arange(1, 50) / 50)]
NEAR = 1e-9  # the default tolerance
TIE = 2e-12  # a smaller share of the terms of a balance of torques counts as zero
ENERGIES = ["work_in", "work_ext", "spring", "kinetic", "heat_cam1", "heat_cam2", "heat_damper", "heat_shaft"]
SCENES = json.loads((Path(__file__).parent / "data" / "cut_scenes.json").read_text())


def part_of(u, t):
    """The derivatives at t of the polynomial with the derivatives u at 0."""
    return [sum(u[k + j] * t**j / math.factorial(j) for j in range(len(u) - k)) for k in range(len(u))]


def run(fmu, h, cuts, **inputs):
    """One interval of h seconds under polynomials, cut at these shares of the interval."""
    for begin, end in pairwise([0.0, *cuts, 1.0]):
        now = {name: part_of(u, begin * h) for name, u in inputs.items()}
        fmu.set({name: u[0] for name, u in now.items()})
        rates = {name: u[1:] for name, u in now.items() if u[1:]}
        if rates:
            fmu.set_derivatives(rates)
        status = fmu.call("fmi2DoStep", fmu.time, (end - begin) * h, 1)
        assert status == OK, fmu.messages[-1].text
        fmu.time += (end - begin) * h


@pytest.fixture(scope="module")
def level(tmp_path_factory):
    """A groove that is level for psi in [-0.09, 0.054] rad, between two knots that no double represents."""
    path = tmp_path_factory.mktemp("level") / "groove.csv"
    psi = [-0.37712288276247774 + k * 0.14369745055544070 for k in range(5)]
    write_table(path, psi, [0.0, 4.25e-6, 4.013e-5, 4.013e-5, 4.05e-5])
    return {"cam1.profile": 3, "cam1.table": str(path), "stop.lower": -0.37, "stop.upper": 0.19}


@pytest.mark.parametrize("cuts", CUTS)
def test_a_locked_contact_does_not_jam_on_a_dwell(make_model, level, cuts):
    """Level groove: the axial load passes no torque to cam 2. Its damping b alone resists: omega = tau/b."""
    damping, h, rate = 0.7, 0.1, 5.0
    parameters = {
        "cam1.friction": 0.0,
        "cam2.friction": 0.3,
        "cam2.lead_angle": 0.12,
        "inertia.shaft": 0.0,
        "shaft.damping": damping,
        "damper.c_load": 10.0,
        "spring.preload": 0.0,
        "spring.stiffness": 0.0,
    }
    fmu = make_model(FORWARD).start(level | parameters)
    run(fmu, h, cuts, tau=[0.0, rate], F_ext=[-1000.0])
    assert fmu.get("mode") == LOADING
    assert fmu.get("theta") == pytest.approx(rate * h**2 / (2.0 * damping), rel=NEAR)


@pytest.mark.parametrize("cuts", CUTS)
def test_loads_that_turn_soon_after_the_start_take_no_speed(make_model, level, cuts):
    """On the dwell of cam 1 its friction f = -e mu alone loads the contacts, by the inertia I of the
    follower. The axial forces balance, x1 + x2 = 0, and so do the moments, f r1 x1 + I alpha = a2 x2. So
    J alpha = tau - I alpha a2/(a2 + f r1), with x1 = -I alpha/(a2 + f r1) on the flank e. The torque begins
    with its second derivative and changes its sign at 0.8 h, and with it the flank."""
    J, inertia, mu, lead, h = 2e-4, 2e-9, 0.2, 0.24, 4e-4
    parameters = {
        "cam2.lead_angle": lead,
        "cam1.friction": mu,
        "cam2.friction": 0.0,
        "inertia.shaft": J,
        "inertia.follower": inertia,
        "inertia.follower_mass": 1000.0,
        "damper.c_release": 1e7,
        "spring.preload": 0.0,
        "initial.omega": -0.4,
    }
    fmu = make_model(FORWARD).start(level | parameters)
    tau = [0.0, 0.0, -0.1 / h**2, 0.375 / h**3]
    r1, a2 = fmu.get("cam1.radius"), fmu.get("cam2.radius") * math.tan(lead)
    run(fmu, h, cuts, tau=tau)
    impulse = np.polynomial.Polynomial([u / math.factorial(k) for k, u in enumerate(tau)]).integ()
    braking, driving = (J + inertia * a2 / (a2 + f * r1) for f in (-mu, mu))
    change = impulse(0.8 * h) / braking + (impulse(h) - impulse(0.8 * h)) / driving
    assert fmu.get("omega") == pytest.approx(-0.4 + change, rel=NEAR)


def test_a_motion_ends_where_a_contact_locks(make_model):
    """Without torque an axial pull moves the follower against its damper, and no contact bears a load. Rest
    is possible as well where the slope of groove 1, which flattens, has fallen to mu1: rest then ends the
    motion (docs/mechanism.md, section 6). S/sqrt(1 - S^2) = mu a/b at that place of the ellipse."""
    mu, lead, a, b = 0.2, 0.4, 0.03, 0.02
    parameters = {
        "cam1.profile": 2,
        "cam1.lead_angle": lead,
        "cam1.ellipse_a": a,
        "cam1.ellipse_b": b,
        "cam1.ellipse_curvature": -1,
        "cam2.lead_angle": 0.5,
        "cam1.friction": mu,
        "cam2.friction": 0.1,
        "spring.preload": 0.0,
        "spring.stiffness": 0.0,
        "inertia.shaft": 0.0,
        "damper.c_load": 50.0,
        "stop.upper": 0.9,
    }
    S0, S = math.sin(math.atan(a / b * math.tan(lead))), math.sin(math.atan(mu * a / b))
    for cuts in CUTS:
        fmu = make_model(FORWARD).start(parameters)
        z = b * (math.sqrt(1.0 - S * S) - math.sqrt(1.0 - S0 * S0))
        theta = (S0 - S) * a / fmu.get("cam1.radius") + z / (fmu.get("cam2.radius") * math.tan(0.5))
        run(fmu, 0.01, cuts, tau=[0.0], F_ext=[-500.0])
        assert fmu.get("theta") == pytest.approx(theta, rel=NEAR)
        assert fmu.get("mode") == STICK


@pytest.mark.parametrize("cuts", CUTS)
def test_a_steep_groove_does_not_hide_the_torque_of_a_flat_one(make_model, tmp_path, cuts):
    """A helix of 1e5 m/rad above a table of 1e-9 m/rad: the torque at the pin is a2 F. This torque is far
    below the rounding of the steep slope times F, and moves the shaft: J alpha = tau - a2 F."""
    slope, force, J, h = 1e-9, 8000.0, 67.0, 0.07
    path = tmp_path / "flat.csv"
    write_table(path, [-0.2, 0.0, 0.2, 0.4, 0.8], [slope * psi for psi in (0.0, 0.2, 0.4, 0.6, 1.0)])
    parameters = {
        "cam1.radius": 0.6,
        "cam1.lead_angle": math.pi / 2 - 5e-6,
        "cam2.profile": 3,
        "cam2.table": str(path),
        "cam1.friction": 0.0,
        "cam2.friction": 0.0,
        "spring.preload": force,
        "spring.stiffness": 0.0,
        "inertia.shaft": J,
        "stop.lower": -0.18,
        "stop.upper": 0.7,
    }
    fmu = make_model(FORWARD).start(parameters)
    run(fmu, h, cuts, tau=[0.0, 0.0, 0.0, 12.0 * slope * force / h**3])
    change = slope * force * h * (0.5 - 1.0) / J
    assert fmu.get("omega") == pytest.approx(change, rel=NEAR, abs=0.0)


@pytest.mark.parametrize("ties", [-10.0, -0.4, 0.4, 10.0])
def test_a_torque_within_a_tie_of_its_balance_is_rest(make_model, level, ties):
    """Without friction a torque a1 a2/(a1 + a2) F holds the axial load F. A torque beyond it by less than TIE
    of the terms of the balance moves nothing; a larger one does, J alpha = the excess."""
    parameters = {
        "cam1.friction": 0.0,
        "cam2.friction": 0.0,
        "cam2.lead_angle": 0.24,
        "spring.preload": 1000.0,
        "spring.stiffness": 0.0,
        "inertia.shaft": 1e-3,
        "initial.theta": 0.12,
    }
    fmu = make_model(FORWARD).start(level | parameters)
    balance, h = fmu.get("torque_load"), 1e-3
    excess = ties * TIE * 2.0 * balance
    run(fmu, h, [0.5], tau=[balance + excess], F_ext=[0.0])
    if abs(ties) < 1.0:
        assert fmu.get("omega") == 0.0
    assert fmu.get("omega") == pytest.approx(excess * h / 1e-3, abs=TIE * 2.0 * balance * h / 1e-3)


def test_a_load_that_grows_on_a_level_place_moves_nothing(make_model, tmp_path):
    """The groove of cam 2 is level at its beginning, where the mechanism rests at its lower stop. The axial
    load passes no torque to cam 2 there, T = rho F_0 with rho = 0: a pull that grows moves nothing."""
    path = tmp_path / "begins_level.csv"
    psi = [k * 0.12367910474118893 for k in range(7)]
    write_table(path, psi, [0.0, 2.7e-5, 2.7e-5, 2.7e-5, 3.295e-3, 3.316e-3, 3.401e-3])
    parameters = {
        "cam2.profile": 3,
        "cam2.table": str(path),
        "cam1.friction": 0.0137,
        "cam2.friction": 0.0,
        "spring.preload": 0.0,
        "inertia.shaft": 0.008,
        "stop.upper": 0.7,
    }
    for cuts in CUTS:
        fmu = make_model(FORWARD).start(parameters)
        run(fmu, 0.009, cuts, tau=[0.0], F_ext=[117.0, -9e5])
        assert (fmu.get("theta"), fmu.get("omega")) == (0.0, 0.0)


KNOT = 0.1  # rad, where the dwell of cam 2 ends


@pytest.fixture(scope="module")
def ends(tmp_path_factory):
    """A dwell of cam 2 up to KNOT, and a shaft with inertia alone. On the dwell the pin stands still in cam
    1, whose contact is locked and bears no load: J alpha = tau. Past the dwell a pull F < 0 bears on cam 2,
    x_2 < 0, and passes the torque a_2 x_2 < 0 to contact 1. While loading neither flank of contact 1 takes
    the torque: n_1 = a_1 + e mu r_1 is positive on e = 1 and asks for x_1 < 0, and is negative on e = -1 and
    asks for x_1 > 0. So the contacts jam at KNOT. While releasing flank e = -1 takes the torque."""
    path = tmp_path_factory.mktemp("ends") / "groove.csv"
    write_table(path, [k * KNOT for k in range(4)], [0.0, 0.0, 2e-4, 6e-4])
    return {
        "cam1.lead_angle": 0.37,
        "cam1.friction": 0.5,
        "cam2.profile": 3,
        "cam2.table": str(path),
        "cam2.friction": 0.0,
        "spring.preload": 0.0,
        "spring.stiffness": 0.0,
        "inertia.shaft": 0.003,
        "stop.upper": 0.25,
    }


@pytest.mark.parametrize("cuts", CUTS)
def test_contacts_that_jam_at_the_end_of_a_dwell_rest_there(make_model, ends, cuts):
    """The angle of rest has all digits, however the step before has come to the end of the dwell."""
    fmu = make_model(FORWARD).start(ends | {"initial.omega": 1.6})
    run(fmu, 0.1, cuts, tau=[0.05], F_ext=[-26.0])
    assert (fmu.get("mode"), fmu.get("omega")) == (WEDGED, 0.0)
    assert fmu.get("theta") == pytest.approx(KNOT, rel=NEAR)


@pytest.mark.parametrize("cuts", CUTS)
def test_contacts_at_the_end_of_a_dwell_hold_a_torque_that_begins_slowly(make_model, ends, cuts):
    """The torque begins with its second derivative, the angle with t^4, and the jamming load with t^8."""
    fmu = make_model(FORWARD).start(ends | {"initial.theta": KNOT})
    run(fmu, 1e-3, cuts, tau=[0.0, 0.0, 8e5], F_ext=[-26.0])
    assert (fmu.get("mode"), fmu.get("omega")) == (WEDGED, 0.0)
    assert fmu.get("theta") == pytest.approx(KNOT, rel=NEAR)


@pytest.mark.parametrize("distance", [1e-8, 1e-9, 1e-10, 1e-11, 1e-12])
def test_a_load_that_falls_to_zero_at_a_dwell_jams_nothing(make_model, ends, distance):
    """The motion enters the dwell from the side on which contact 1 bears: J alpha = tau from there on."""
    h, torque, speed = 0.01, 0.05, -5.0
    fmu = make_model(FORWARD).start(ends | {"initial.theta": KNOT + distance, "initial.omega": speed})
    run(fmu, h, [], tau=[torque], F_ext=[-26.0])
    assert fmu.get("omega") == pytest.approx(speed + torque * h / 0.003, rel=NEAR)


@pytest.mark.parametrize("place", [math.nextafter(KNOT, 0.0), KNOT, math.nextafter(KNOT, 1.0)])
def test_contacts_at_the_end_of_a_dwell_let_a_torque_go_back(make_model, ends, place):
    """Past the dwell a locked contact holds each torque that pulls back. On the dwell it bears no load, and
    J alpha = tau: rounding of the angle must not tell the one side from the other."""
    h, torque = 0.01, -0.05
    fmu = make_model(FORWARD).start(ends | {"initial.theta": place})
    run(fmu, h, [], tau=[torque], F_ext=[26.0])
    assert fmu.get("omega") == pytest.approx(torque * h / 0.003, rel=NEAR)


@pytest.mark.parametrize("scene", SCENES, ids=lambda scene: f"{scene['cause']}-{scene['scene']}")
def test_scenes_do_not_depend_on_cuts(make_model, tmp_path, scene):
    """Angle, mode and speed agree to ten times the tolerance, of the larger stop and of the fastest speed.
    The residual of the energies is a millionth of those turned over, and the rounding of the angle. So is
    what the heat of a contact loses. Contacts that have jammed have no speed."""
    parameters = dict(scene["parameters"])
    for i in (1, 2):
        if f"cam{i}.table" in parameters:
            rows = parameters[f"cam{i}.table"]
            write_table(tmp_path / f"cam{i}.csv", *zip(*rows, strict=True))
            parameters[f"cam{i}.table"] = str(tmp_path / f"cam{i}.csv")
        if parameters.get(f"cam{i}.friction_table"):
            path = tmp_path / f"friction{i}.csv"
            path.write_text("".join(",".join(row) + "\n" for row in parameters[f"cam{i}.friction_table"]))
            parameters[f"cam{i}.friction_table"] = str(path)
    ends, lost = [], 0.0
    for cuts in ([], scene["cuts"], list(np.arange(1, 20) / 20)):
        fmu, heats = make_model(FORWARD).start(parameters), np.zeros(2)
        for h, taus, forces in scene["curves"]:
            tau = [scene["torque_unit"] * u / h**k for k, u in enumerate(taus)]
            run(fmu, h, cuts, tau=tau, F_ext=[u / h**k for k, u in enumerate(forces)])
            before, heats = heats, np.array([fmu.get(f"energy.heat_cam{i}") for i in (1, 2)])
            lost = max(lost, *(before - heats))
            assert fmu.get("mode") != WEDGED or fmu.get("omega") == 0.0
        ends.append({name: fmu.get(name) for name in ("theta", "omega", "mode", "energy.residual")})
    turned_over = sum(abs(fmu.get(f"energy.{name}")) for name in ENERGIES)
    way, speed = max(map(abs, (fmu.get("stop.lower"), fmu.get("stop.upper")))), fmu.get("peak.omega")
    for end in ends[1:]:
        assert end["mode"] == ends[0]["mode"]
        assert end["theta"] == pytest.approx(ends[0]["theta"], abs=10.0 * NEAR * way)
        assert end["omega"] == pytest.approx(ends[0]["omega"], abs=10.0 * NEAR * speed)
    rounding = 1e-14 * fmu.get("peak.torque") * way
    assert max(lost, *(abs(end["energy.residual"]) for end in ends)) <= 1e-6 * turned_over + rounding
