"""Motions that the contacts stop at once, however the time is cut into steps (docs/limits.md, Painlevé).

Oracles: a closed form up to the instant at which no flanks agree, or only those that brake; and the equation
of motion of section 6 up to the pole of its reactions, by DOP853.
"""

import math
from itertools import pairwise, product

import numpy as np
import pytest
from driver import OK, models
from reference import DOUBLE, Mechanism, write_table
from reference.grooves import Ellipse
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

LOADING, RELEASING = 2, 3
FORWARD = models["DualCamForward"]


def step(fmu, begin, end):
    """A mode of rest has no speed, even where the step ends as the contacts jam."""
    assert fmu.call("fmi2DoStep", begin, end - begin, 1) == OK, fmu.messages[-1].text
    fmu.time = end
    assert fmu.get("mode") in (LOADING, RELEASING) or fmu.get("omega") == 0.0


def factors(r, a, f):
    """P, Q and Delta of section 6 with the signed friction coefficients f."""
    rn, d = [r[i] * (a[i] + f[i] * r[i]) for i in (0, 1)], [r[i] - f[i] * a[i] for i in (0, 1)]
    return rn[0] * rn[1], d[0] * rn[1], d[0] * rn[1] + rn[0] * d[1]


class Braked:
    """A shaft without inertia and a heavy follower in helices. A torque releases. The axial force F on the
    follower is a parabola, positive for less than a time constant. The torque at the pin, T = tau - b omega,
    obeys dT/dt = c (rho F - T) with c = b/(rho m z'). Where T is zero the shaft begins to brake the follower.
    Contact 1 is locked, so no pair of flanks can do that: the follower stops. It starts again at once."""

    r, slope, mu = 0.03, (0.3, 0.8), (0.5, 0.1)
    mass, damping, tau, force, begin = 0.5, 0.02, -1.0, 5.0, 1.0

    def __init__(self):
        a = [self.r * s for s in self.slope]
        p, _, delta = factors((self.r, self.r), a, self.mu)
        self.rho, self.lift = p / delta, a[0] * a[1] / (a[0] + a[1])
        self.rate = self.damping / (self.rho * self.mass * self.lift)
        half = 1.005 / self.rate  # s, of the time in which F > 0
        time = np.polynomial.Polynomial([-2.0 * half, 1.0])
        self.load = self.force * (1.0 - time**2 / half**2)
        self.torque = self.rho * (
            self.load - self.load.deriv() / self.rate + self.load.deriv(2) / self.rate**2
        )
        self.jam = self.torque.roots()[0]  # s
        self.end = self.jam + 3.0 / self.rate

    def parameters(self):
        cams = {f"cam{i}.lead_angle": math.atan(s) for i, s in enumerate(self.slope, 1)}
        cams |= {f"cam{i}.radius": self.r for i in (1, 2)}
        cams |= {f"cam{i}.friction": mu for i, mu in enumerate(self.mu, 1)}
        return cams | {
            "spring.preload": 0.0,
            "spring.stiffness": 0.0,
            "shaft.damping": self.damping,
            "inertia.shaft": 0.0,
            "inertia.follower_mass": self.mass,
            "initial.theta": self.begin,
            "initial.omega": (self.tau - self.torque(0.0)) / self.damping,
            "tau": self.tau,
            "F_ext": self.load(0.0),
        }

    def at_end(self):
        """Angle, speed, and the heat of the contacts and of the shaft. After the jam T = tau exp(-c t) + the
        polynomial."""
        c, left, tau, b = self.rate, self.end - self.jam, self.tau, self.damping
        decay = math.exp(-c * left)
        travel = (tau * self.end - self.torque.integ()(self.end) - tau * (1.0 - decay) / c) / b
        return self.begin + travel, (tau - self.torque(self.end) - tau * decay) / b


BRAKED = Braked()


def cuts_around_the_jam():
    """Times as close to the jam as rounding lets them be."""
    near = [BRAKED.jam * (1.0 + side * 10.0**-n) for side in (-1, 1) for n in (16, 15, 13, 10)]
    return [0.0, *sorted({BRAKED.jam, *near}), BRAKED.end]


def random_cuts(end, count):
    rng = np.random.default_rng(0)
    return [[0.0, *np.sort(rng.uniform(0.0, end, 3)).tolist(), end] for _ in range(count)]


def test_a_follower_that_no_flanks_can_brake_stops(make_model):
    """The sign of a load that is rounding must not decide whether the follower stops."""
    found = []
    for cuts in [[0.0, BRAKED.end], cuts_around_the_jam(), *random_cuts(BRAKED.end, 40)]:
        fmu = make_model(FORWARD).start(BRAKED.parameters(), tolerance=1e-6)
        for begin, end in pairwise(cuts):
            fmu.set({"F_ext": BRAKED.load(begin)})
            fmu.set_derivatives({"F_ext": [BRAKED.load.deriv(k)(begin) for k in (1, 2)]})
            step(fmu, begin, end)
        found.append([fmu.get("theta"), fmu.get("omega")])
    assert found == [pytest.approx(BRAKED.at_end(), rel=1e-7)] * len(found)


class Pole:
    """A pull moves the follower, and no torque acts. Contact 2 bears on the other flank. Friction at cam 1
    grows with the speed. Delta of this pair of flanks falls to zero while the mechanism moves: the reactions
    are then infinite. Two other pairs agree at that instant, one with Delta > 0 and one with Delta < 0."""

    r, lead, ellipse, slope2 = (0.005, 0.08), 0.915, (0.01, 0.02), 0.05
    mu, branch, pull, inertia, fastest = (0.5, 0.5), 1.45, -2.0, 1e-4, 100.0
    flanks = (1, -1)

    def __init__(self):
        self.groove, self.a2 = Ellipse(self.r[0], self.lead, *self.ellipse, -1), self.r[1] * self.slope2

    def factors(self, theta, omega, flanks=flanks):
        gamma = brentq(
            lambda x: self.groove.derivatives(x, 0)[0] - self.a2 * (theta - x), -0.1, 1.0, xtol=1e-15
        )
        a = self.groove.derivatives(gamma, 0)[1], self.a2
        sliding = a[1] / (a[0] + a[1]) * math.hypot(self.r[0], a[0])
        mu = self.mu[0] + self.branch * sliding * omega, self.mu[1]
        return factors(self.r, a, [e * m for e, m in zip(flanks, mu, strict=True)])

    def jam(self):
        """Angle, speed and time of the pole. In the time s with dt = Delta ds the motion has no pole."""

        def rates(_, y):
            p, _, delta = self.factors(*y[:2])
            return [delta * y[1], -p * self.pull / self.inertia, delta]

        def falls(_, y):
            return self.factors(*y[:2])[2]

        falls.terminal, falls.direction = True, -1
        start = [0.0, self.fastest, 0.0]
        return solve_ivp(rates, (0.0, 1e9), start, "DOP853", rtol=1e-12, atol=1e-15, events=falls).y[:, -1]

    def parameters(self):
        return {
            "cam1.profile": 2,
            "cam1.ellipse_a": self.ellipse[0],
            "cam1.ellipse_b": self.ellipse[1],
            "cam1.ellipse_curvature": -1,
            "cam1.lead_angle": self.lead,
            "cam2.lead_angle": math.atan(self.slope2),
            **{f"cam{i}.radius": r for i, r in enumerate(self.r, 1)},
            **{f"cam{i}.friction": mu for i, mu in enumerate(self.mu, 1)},
            "cam1.friction_viscous": self.branch,
            "spring.preload": 0.0,
            "spring.stiffness": 0.0,
            "inertia.shaft": self.inertia,
            "initial.omega": self.fastest,
            "stop.upper": 1.0,
            "F_ext": self.pull,
        }


def test_infinite_reactions_stop_the_motion_where_other_flanks_agree(make_model):
    """The impact comes first, although the motion could go on along the other flanks."""
    pole, found = Pole(), []
    theta, omega, instant = pole.jam()
    assert omega > 0.8 * pole.fastest and pole.factors(theta, omega, (-1, 1))[2] > 0.0
    end = 1.2 * instant
    near = sorted({instant * (1.0 + side * 10.0**-n) for side in (-1, 1) for n in (15, 12, 9, 6)})
    for cuts in [[0.0, end], [0.0, *near, end], *random_cuts(end, 20)]:
        fmu = make_model(FORWARD).start(pole.parameters())
        for begin, after in pairwise(cuts):
            step(fmu, begin, after)
        found.append([fmu.get("omega"), fmu.get("theta")])
    assert found == [[0.0, pytest.approx(theta, abs=1e-9)]] * len(found)


class Slowing:
    """A shaft without torque and with hardly any inertia, and a follower without inertia. A pull F(t) moves
    the follower against its damper: c v = F to a share of 1e-10. The contacts carry that share: the force
    that slows the shaft. Contact 1 is locked. The pull falls until `turn`, by 1e-4 of its value. No pair of
    flanks can make the shaft faster then: of the four, one pair agrees with an axial load on the other side,
    and brakes. The mechanism stops in some 1e-7 s: a deviation from that balance grows by 1e8 per second."""

    r, slope, mu, damping, inertia, begin = 0.02, (0.1, 0.8), (0.2, 0.1), 1000.0, 1e-11, 1.0
    turn, end = 0.01, 0.1

    def __init__(self):
        a = [self.r * s for s in self.slope]
        self.lift = a[0] * a[1] / (a[0] + a[1])
        self.pull = 1.0 - 1e-4 + 1e-4 * np.polynomial.Polynomial([-1.0, 1.0 / self.turn]) ** 2

    def agreeing_flanks(self):
        """Of releasing under an axial load A > 0, with the sign of alpha: x_i = A r_j n_j/Delta."""
        a = [self.r * s for s in self.slope]
        for flanks in product((1, -1), repeat=2):
            p, _, delta = factors((self.r, self.r), a, [-e * m for e, m in zip(flanks, self.mu, strict=True)])
            n = [a[i] - flanks[i] * self.mu[i] * self.r for i in (0, 1)]
            if flanks[0] * n[1] / delta > 0 and flanks[1] * n[0] / delta > 0:
                yield flanks, -math.copysign(1, p / delta)

    def parameters(self):
        cams = {f"cam{i}.lead_angle": math.atan(s) for i, s in enumerate(self.slope, 1)}
        cams |= {f"cam{i}.radius": self.r for i in (1, 2)}
        cams |= {f"cam{i}.friction": mu for i, mu in enumerate(self.mu, 1)}
        return cams | {
            "cam1.friction_viscous": 1e-6,
            "spring.preload": 0.0,
            "spring.stiffness": 0.0,
            "damper.c_release": self.damping,
            "inertia.shaft": self.inertia,
            "initial.theta": self.begin,
            "initial.omega": -1.01 * self.pull(0.0) / (self.damping * self.lift),
            "F_ext": self.pull(0.0),
        }

    def angle(self, t):
        return self.begin - self.pull.integ()(t) / (self.damping * self.lift)

    def run(self, fmu, cuts):
        fmu.start(self.parameters())
        for begin, end in pairwise(cuts):
            fmu.set({"F_ext": self.pull(begin)})
            fmu.set_derivatives({"F_ext": [self.pull.deriv(k)(begin) for k in (1, 2)]})
            step(fmu, begin, end)
        return [fmu.get("theta"), fmu.get("omega")]


def cuts_of(motion):
    near = [motion.turn * (1.0 + side * 10.0**-n) for side in (-1, 1) for n in (3, 4)]
    equal = [np.linspace(0.0, motion.end, n + 1).tolist() for n in (1, 2, 7, 50, 400)]
    return [*equal, sorted([0.0, *near, motion.end]), *random_cuts(motion.end, 10)]


def test_a_shaft_that_no_flanks_can_drive_stops(make_model):
    """However small the load at the contacts is: the change of its sign counts, not its size. The load of
    1e-10 F is known to 1e-13 F, and with it the instant to 1e-3 of `turn`."""
    motion = Slowing()
    assert list(motion.agreeing_flanks()) == [((1, -1), 1)]
    theta, speed = motion.angle(motion.turn), -motion.parameters()["initial.omega"]
    found = [motion.run(make_model(FORWARD), cuts) for cuts in cuts_of(motion)]
    assert found == [[pytest.approx(theta, abs=1.1e-3 * motion.turn * speed), 0.0]] * len(found)


class Dwell:
    """The shaft turns the follower back along a dwell of cam 1, on which no friction acts. Friction locks the
    helix of cam 2. Where the dwell ends, gamma' = a_2/(a_1 + a_2) falls: cam 2 begins to turn in the
    follower. The follower's inertia I asks contact 2 for the torque -J alpha = J I gamma'' omega^2/(J + I).
    This torque is positive. The torque r_2 (a_2 x - mu r_2 |x|) of the locked contact is negative on both
    flanks: no motion goes on."""

    psi = tuple(0.56 * k for k in (-2, -1, 0, 1, 2, 3, 4, 5, 6))
    z = (-1e-6, 0.0, 0.0, 0.0, 1e-6, 5.63e-4, 5.63e-4, 5.65e-4, 5.65e-4)
    r, lead, mu, end = 0.04, 0.25, 0.303, 0.1

    def parameters(self, path):
        write_table(path, self.psi, self.z)
        assert self.mu > math.tan(self.lead)
        return {
            "cam1.profile": 3,
            "cam1.table": str(path),
            "cam1.radius": 0.01,
            "cam1.friction": 0.0,
            "cam2.radius": self.r,
            "cam2.lead_angle": self.lead,
            "cam2.friction": self.mu,
            "inertia.shaft": 1e-4,
            "inertia.follower": 2.4e-4,
            "spring.preload": 0.0,
            "spring.stiffness": 0.0,
            "stop.lower": -1.1,
            "stop.upper": 3.3,
            "initial.theta": 3.1,
            "initial.omega": -7.0,
        }

    def angle(self):
        """rad: psi_1 at the end of the dwell, and that of the height z on the helix."""
        return self.psi[-2] + self.z[-1] / (self.r * math.tan(self.lead))


def test_a_follower_that_a_locked_contact_cannot_turn_stops_at_the_end_of_a_dwell(make_model, tmp_path):
    """Found by `./build.sh fuzz`: a long step went on, since the load of contact 2 was on its flank again at
    the end of the step."""
    dwell, found = Dwell(), []
    for cuts in [[0.0, dwell.end], *random_cuts(dwell.end, 20)]:
        fmu = make_model(FORWARD).start(dwell.parameters(tmp_path / "dwell.csv"))
        for begin, end in pairwise(cuts):
            fmu.set({"F_ext": -1.0 - 50.0 * begin})
            fmu.set_derivatives({"F_ext": [-50.0]})
            step(fmu, begin, end)
        found.append([fmu.get("omega"), fmu.get("theta")])
    assert found == [[0.0, pytest.approx(dwell.angle(), rel=1e-9)]] * len(found)


# A stop throws a shaft back. Groove 1 rises so steeply that its contact locks on the way: Delta falls to
# zero, and the reactions grow there from 1e-5 N to infinity.
INTO_A_POLE = {
    "cam1.profile": 3,
    "cam1.radius": 1.3e-3,
    "cam1.friction": 0.1,
    "cam2.radius": 0.3,
    "cam2.lead_angle": 2.4e-5,
    "cam2.friction": 0.0,
    "spring.preload": 0.0,
    "spring.stiffness": 10.0,
    "damper.c_load": 0.0,
    "damper.c_release": 0.0,
    "inertia.shaft": 0.1,
    "inertia.follower_mass": 0.0,
    "stop.upper": 1.0,
    "stop.restitution": 0.5,
}


@pytest.mark.parametrize("steps", [1, 2, 10, 100, 1000])
def test_a_jam_at_infinite_reactions_gains_no_energy(make_model, tmp_path, steps):
    """Delta = 0 of releasing gives the angle of the jam. A step passed this angle by its rounding: the heat
    of contact 1 was -5.5 J."""
    table, torque = tmp_path / "pole.csv", 1.0
    write_table(table, [0.0, 0.2, 0.4, 0.6, 0.8, 1.01], [0.0, 4.3e-6, 1.36e-3, 1.36e-3, 1.36e-3, 2.72e-3])
    parameters = INTO_A_POLE | {"cam1.table": str(table)}
    fmu = make_model(FORWARD).start(parameters)
    fmu.set({"tau": torque})
    for k in range(steps):
        step(fmu, 0.56 * k / steps, 0.56 * (k + 1) / steps)
    mechanism = Mechanism(parameters, DOUBLE)

    def delta(theta):
        kin = mechanism.groove.at(theta)
        return factors((1.3e-3, 0.3), (kin.a1, kin.a2), (-0.1, 0.0))[2]

    jam = brentq(delta, 0.5, 0.95, xtol=1e-15)
    kinetic = torque * (0.5**2 - (1.0 - jam))  # J, thrown back by the stop, then braked by the torque
    assert fmu.get("energy.heat_cam1") == pytest.approx(kinetic, rel=1e-6)  # friction and spring: 1e-7
    assert abs(fmu.get("energy.residual")) <= 1e-12 * kinetic
    assert fmu.get("mode") == LOADING
