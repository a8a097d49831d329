"""Friction that depends on the load, on a dwell. First: of cam 1, without friction there.

The level groove passes no torque, so the follower turns with the shaft, and contact 2 bears I alpha alone.
Whatever its friction, (J + I) alpha = tau - b omega. From rest, with T = (J + I)/b and w = tau/b,

    theta = w t - w T (1 - exp(-t/T)).

The load of contact 2 falls with exp(-t/T) to rounding and below.
"""

import math

import pytest
from driver import FORWARD
from reference import LOADING, RELEASING, write_table
from scipy.integrate import quad
from test_cuts_of_general_grooves import run

KNOTS = [-0.37712288276247774 + k * 0.14369745055544070 for k in range(5)]  # rad; no double is a sum of these
HEIGHTS = [0.0, 4.25e-6, 4.013e-5, 4.013e-5, 4.05e-5]  # m
NEAR = 1e-9  # the default tolerance


@pytest.fixture(scope="module")
def dwell(tmp_path_factory):
    """Level for psi_1 from KNOTS[2] to KNOTS[3]."""
    path = tmp_path_factory.mktemp("dwell") / "groove.csv"
    write_table(path, KNOTS, HEIGHTS)
    level = {"cam1.profile": 3, "cam1.table": str(path), "stop.lower": -0.37, "stop.upper": 0.19}
    return level | {"cam1.friction": 0.0, "spring.preload": 0.0, "spring.stiffness": 0.0}


def expected(parameters, tau, t):
    damping = parameters["shaft.damping"]
    settling = (parameters["inertia.shaft"] + parameters["inertia.follower"]) / damping
    return tau / damping * (t + settling * math.expm1(-t / settling))


@pytest.mark.parametrize("exponent", [-1 / 3, 2 / 3])
@pytest.mark.parametrize("settled", range(12, 40, 3))
def test_a_load_that_fades_away_does_not_end_the_motion(make_model, dwell, settled, exponent):
    """A communication point falls where the load has fallen by exp(-settled), before a long step. The error
    of this step stays the same until the step is as short as T: this is not rounding, and the contacts do not
    jam. Nor does contact 2 jump to the other flank, where another answer of the balance loads the contact."""
    parameters = dwell | {
        "cam2.friction": 0.1,
        "cam2.lead_angle": 0.12,
        "cam2.friction_load_exponent": exponent,
        "inertia.shaft": 3.5e-6,
        "inertia.follower": 5e-8,
        "inertia.follower_mass": 1e-3,
        "shaft.damping": 1.0,
    }
    fmu = make_model(FORWARD).start(parameters)
    for h in (settled * 3.55e-6, 0.3):
        fmu.step(h, tau=0.1, F_ext=1.0)
    assert fmu.get("mode") == LOADING
    assert fmu.get("theta") == pytest.approx(expected(parameters, 0.1, fmu.time), rel=NEAR)


def test_a_load_that_fades_away_jams_no_contact(make_model, dwell):
    """Friction falls with the load. Where loads are rounding, no pair of flanks agrees with its rates."""
    parameters = dwell | {
        "cam2.friction": 0.27,
        "cam2.lead_angle": 0.72,
        "cam2.friction_load_exponent": -0.23,
        "cam2.friction_load": 0.04,
        "inertia.shaft": 9.5e-4,
        "inertia.follower": 7.6e-9,
        "inertia.follower_mass": 0.0125,
        "shaft.damping": 0.9,
    }
    fmu = make_model(FORWARD).start(parameters)
    for h in (0.02, 0.2):
        fmu.step(h, tau=-0.0675, F_ext=-777.0)
    assert fmu.get("mode") == RELEASING
    assert fmu.get("theta") == pytest.approx(expected(parameters, -0.0675, fmu.time), rel=NEAR)


LEAVING = {
    "stiff": (
        {
            "cam2.friction": 0.41723710695231936,
            "cam2.lead_angle": 1.0020900399683175,
            "cam2.friction_load_exponent": 0.8589405597038768,
            "inertia.shaft": 0.0022120531948367286,
            "inertia.follower": 2.9131287620065205e-06,
            "inertia.follower_mass": 0.021581037062723085,
            "shaft.damping": 0.7759002357556917,
            "spring.stiffness": 100.0,
        },
        (0.0849569137686555, 0.2981441624770423),
        (0.12735183894688518, 2.6381257846698265),
    ),
    "stribeck": (
        {
            "cam2.friction": 0.031814830998487115,
            "cam2.lead_angle": 0.5681634393596439,
            "cam2.friction_load_exponent": 0.7631916004234354,
            "cam2.friction_peak": 1.0774833329630498,
            "cam2.stribeck_velocity": 0.0012279458315404175,
            "cam2.friction_viscous": 0.40021418683282595,
            "inertia.shaft": 1.1552669732513018e-05,
            "inertia.follower": 1.0410779434771117e-05,
            "inertia.follower_mass": 0.00015427800799752575,
            "shaft.damping": 0.0037969635478549515,
        },
        (0.19530786260285285, 0.5205950036729063),
        (0.0002982157170304569, -0.020530045889775125),
    ),
}


@pytest.mark.parametrize("scene", LEAVING)
def test_a_contact_takes_the_flank_that_its_load_grows_to(make_model, dwell, scene):
    """Just beyond the dwell the load of contact 2 grows from nothing, at a rate that is rounding for the
    decision of the mode. The located change of flanks tells the flank."""
    values, steps, (tau, force) = LEAVING[scene]
    parameters = dwell | {"cam2.friction_load": 1e4} | values
    fmu = make_model(FORWARD).start(parameters)
    for h in steps:
        fmu.step(h, tau=tau, F_ext=force)
    end = expected(parameters, tau, fmu.time)
    slope = 2.0 * (HEIGHTS[4] - HEIGHTS[3]) / (KNOTS[4] - KNOTS[3])  # m/rad, at most, beyond the dwell
    beyond = (end - KNOTS[3]) / (tau / parameters["shaft.damping"])  # s
    assert beyond > 0.0
    assert fmu.get("theta") == pytest.approx(
        end, rel=NEAR, abs=slope * abs(force) / parameters["shaft.damping"] * beyond
    )


class LevelCam2:
    """Cam 2 is level and turns in the follower, which cam 1 holds. A pull F(t) < 0 fades. Contact 2 passes on
    friction alone, a torque >= 0. Friction that grows with the load locks contact 1 while the coefficient
    exceeds tan(lead). Below that load contact 1 asks for a negative torque: no pair of flanks has an answer.
    The contacts jam, although F is zero 8e-8 s later."""

    radius, lead, mu, exponent, speed, end = 3e-3, 5e-4, 4e-3, 0.5, 0.5, 0.03
    start, rate = -400.0, 2e5  # N, N/s

    def parameters(self, path):
        write_table(path, [-0.5, 0.0, 1.0, 1.5], [-1e-3, 0.0, 0.0, 1e-3])
        return {
            "cam1.radius": self.radius,
            "cam1.lead_angle": self.lead,
            "cam1.friction": self.mu,
            "cam1.friction_load": 1.0,
            "cam1.friction_load_exponent": self.exponent,
            "cam2.profile": 3,
            "cam2.table": str(path),
            "cam2.radius": 0.2,
            "cam2.friction": 0.3,
            "inertia.shaft": 1.0,
            "spring.preload": 0.0,
            "spring.stiffness": 0.0,
            "contacts": 1,
            "stop.upper": 1.0,
            "initial.theta": 0.1,
            "initial.omega": self.speed,
        }

    def jam(self):
        """s: R = F_load (tan(lead)/mu)^(1/nu), and F = -R/cos(lead) there."""
        reaction = (math.tan(self.lead) / self.mu) ** (1.0 / self.exponent)
        return (-reaction / math.cos(self.lead) - self.start) / self.rate

    def torque(self, t):
        """N.m, by which contact 1 brakes: r (a + f r) x with the axial force (r - a f) x = F."""
        load, rise = -(self.start + self.rate * t), math.tan(self.lead)
        reaction = load
        for _ in range(60):  # R = F cos(lead)^-1/(1 + mu tan(lead)) converges: the exponent is below 1
            mu = self.mu * reaction**self.exponent
            reaction = load / (math.cos(self.lead) * (1.0 + mu * rise))
        return self.radius * load * (mu - rise) / (1.0 + mu * rise)

    def angle(self):
        """rad, at the jam; J = 1 kg.m2."""
        t = self.jam()
        braked = quad(lambda s: (t - s) * self.torque(s), 0.0, t, epsabs=1e-14)[0]
        return 0.1 + self.speed * t - braked


@pytest.mark.parametrize("parts", [1, 2, 3, 5, 7, 64])
def test_contacts_jam_shortly_before_the_load_is_zero(make_model, tmp_path, parts):
    """Found by `./build.sh fuzz`: the load of contact 1, which is zero just after, hid that of contact 2."""
    scene = LevelCam2()
    fmu = make_model(FORWARD).start(scene.parameters(tmp_path / "level.csv"))
    run(fmu, scene.end, [k / parts for k in range(1, parts)], F_ext=[scene.start, scene.rate])
    assert fmu.get("omega") == 0.0
    assert fmu.get("theta") == pytest.approx(scene.angle(), abs=NEAR)
