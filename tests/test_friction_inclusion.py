"""The forces of both FMUs satisfy the law of friction (docs/mechanism.md, section 9): the residual.

Friction coefficients come from the law in Python (reference/friction.py), kinematics from SciPy
(pin_equations.py), forces from the FMU. Random mechanisms run with laws of Stribeck, lubricated branches and
friction tables. The residual is read at every communication point and just after every event in a step.
"""

import math
from dataclasses import dataclass
from itertools import product

import numpy as np
import pytest
from driver import OK, models
from pin_equations import damper_force, polynomial, spring_force
from random_mechanisms import random_inputs, random_mechanism, reactions
from reference import LOADING, LOWER_STOP, RELEASING, STICK, UPPER_STOP
from reference.friction import FrictionLaw
from test_friction_table import drawn, write

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]
ROUNDING = 1e-11  # of the terms: torque and load at rest tie within 2e-12 of their size; theta and z round
LAW = {
    "friction_peak": 1.0, "stribeck_velocity": 0.01, "stribeck_exponent": 2, "friction_viscous": 0.0,
    "friction_load_exponent": 0.0, "friction_load": 100.0,
}  # fmt: skip


def random_law(rng, folder):
    """A law for each cam: Stribeck's, a lubricated branch, or a table, and perhaps one over the load."""
    drawn_laws = {}
    for i in (1, 2):
        kind = rng.choice(["stribeck", "branch", "table", "coulomb"], p=[0.4, 0.25, 0.25, 0.1])
        cam = dict(LAW)
        if kind == "stribeck":
            cam |= {
                "friction_peak": float(rng.uniform(1.0, 3.0)),
                "stribeck_velocity": float(10.0 ** rng.uniform(-3.0, -0.5)),
                "stribeck_exponent": int(rng.integers(1, 3)),
            }
        if kind in ("stribeck", "branch"):
            cam["friction_viscous"] = float(10.0 ** rng.uniform(-3.0, -0.3))
        if rng.random() < 0.3:
            cam["friction_load_exponent"] = float(rng.uniform(-0.4, 0.4))
            cam["friction_load"] = float(10.0 ** rng.uniform(1.0, 3.0))
        drawn_laws |= {f"cam{i}.{name}": value for name, value in cam.items()}
        drawn_laws[f"cam{i}.friction_table"] = ""
        if kind == "table":
            path = folder / f"law-{rng.integers(2**40):x}.csv"
            drawn_laws[f"cam{i}.friction_table"] = write(path, *drawn(rng))
    return drawn_laws


@dataclass(frozen=True)
class Forces:
    """What the FMU says at one instant, and the place of the pin."""

    place: object
    theta: float
    omega: float
    alpha: float
    tau: float
    F_ext: float
    reaction: tuple  # N, total of each cam

    @classmethod
    def of(cls, fmu, pin):
        theta, omega, alpha, tau, pull = (fmu.get(n) for n in ("theta", "omega", "alpha", "tau", "F_ext"))
        return cls(pin.at(theta), theta, omega, alpha, tau, pull, reactions(fmu))

    def sliding(self, i):
        """m/s, signed: of the pin in groove i."""
        turn = self.place.turn if i == 0 else 1.0 - self.place.turn
        return self.omega * turn * self.place.length(i)


def laws_of(values):
    return [FrictionLaw.of_cam(values, i) for i in (1, 2)]


def coefficients(forces, values):
    """mu of each contact, under N_i = |F| a_j hypot(r_i, a_i)/(n r_i (a_1 + a_2)) of one of its ends."""
    place = forces.place
    force = spring_force(values, place.z) + forces.F_ext
    force += damper_force(values, place.lift * forces.omega)
    shares = place.turn, 1.0 - place.turn
    loads = [abs(force) * shares[i] * place.length(i) / place.r[i] / values["contacts"] for i in (0, 1)]
    return [law.at(abs(forces.sliding(i)), loads[i]) for i, law in enumerate(laws_of(values))]


def slip_residual(forces, values, direction):
    """How far the forces miss the law, relative to the size of the terms.

    Contact i presses the pin with the normal force R_i and rubs it with mu_i(|v_i|) |R_i| against the
    sliding. These forces must balance the torque of cam 2, the moment and the axial load of the follower."""
    place = forces.place
    mu = coefficients(forces, values)
    torques, axials = [], []
    for i in (0, 1):
        r, a, length = place.r[i], place.a[i], place.length(i)
        normal, friction = forces.reaction[i], direction * mu[i] * abs(forces.reaction[i])
        torques.append(r * (normal * a + friction * r) / length)
        axials.append((normal * r - friction * a) / length)
    omega2, mass, twist = forces.omega**2, values["inertia.follower_mass"], values["inertia.follower"]
    torque = [forces.tau, -values["shaft.damping"] * forces.omega, -values["inertia.shaft"] * forces.alpha]
    moment = [twist * place.turn * forces.alpha, twist * place.turn_bent * omega2]
    load = [
        spring_force(values, place.z),
        forces.F_ext,
        damper_force(values, place.lift * forces.omega),
        mass * place.lift * forces.alpha,
        mass * place.lift_bent * omega2,
    ]
    steep = max(abs(f) * (1.0 + m) for f, m in zip(forces.reaction, mu, strict=True))
    size_of_load = sum(map(abs, [*load, *axials])) + steep
    size_of_torque = sum(map(abs, [*torque, *moment, *torques])) + size_of_load * max(place.a)
    return max(
        abs(math.fsum([*torque, -torques[1]])) / size_of_torque,
        abs(math.fsum([*torque, *(-m for m in moment), -torques[0]])) / size_of_torque,
        abs(math.fsum([*load, *(-a for a in axials)])) / size_of_load,
    )


def holding_loads(place, i, mu, torque):
    """The axial forces, as intervals, with which contact i can hold `torque` inside its cone of friction:
    |F_t| <= mu_s |N| with N the normal force, of either sign, and F_t the force along the groove."""
    r, a = place.r[i], place.a[i]
    # with length = hypot(r, a): T/r = (N a + F r)/length, A = (N r - F a)/length; F = f N with |f| <= mu
    edges = []
    for f in (-mu, mu):
        if a + f * r == 0.0:
            edges.append(math.copysign(math.inf, torque))
        else:
            edges.append(torque / r * (r - f * a) / (a + f * r))
    low, high = min(edges), max(edges)
    crosses = (a - mu * r) * (a + mu * r) <= 0.0  # the cone holds the direction without torque
    if not crosses:
        return [(low, high)]
    return [(-math.inf, low), (high, math.inf)]


def can_hold(place, mu, torque, load, slack):
    """Are there forces inside both cones of friction that balance torque and axial load?"""
    first, second = (holding_loads(place, i, mu[i], torque) for i in (0, 1))
    return any(a + c - slack <= load <= b + d + slack for (a, b), (c, d) in product(first, second))


def rest_is_held(forces, values, mode):
    """At rest both contacts stay inside their cones, with the static coefficients. A stop takes the torque
    that presses into the stop."""
    place, mu = forces.place, coefficients(forces, values)
    if forces.omega != 0.0:
        return False
    load = spring_force(values, place.z) + forces.F_ext
    terms = spring_force({n: abs(v) for n, v in values.items() if "spring" in n}, abs(place.z))
    size = terms + abs(forces.F_ext) + abs(forces.tau) / min(place.lift, *place.a)
    slack = ROUNDING * size
    if mode == LOWER_STOP:
        held = [t for t in (forces.tau, place.lift * load) if t >= forces.tau]
        return forces.theta == values["stop.lower"] and any(can_hold(place, mu, t, load, slack) for t in held)
    if mode == UPPER_STOP:
        held = [t for t in (forces.tau, place.lift * load) if t <= forces.tau]
        return forces.theta == values["stop.upper"] and any(can_hold(place, mu, t, load, slack) for t in held)
    return can_hold(place, mu, forces.tau, load, slack)


class Watch:
    """Follows an FMU and judges its forces at every communication point and just after every event."""

    def __init__(self, fmu, pin, values):
        self.fmu, self.pin, self.values = fmu, pin, values
        self.seen, self.events, self.varied = dict.fromkeys(range(1, 7), 0), 0, 0

    def judge(self):
        fmu, values = self.fmu, self.values
        mode, forces = fmu.get("mode"), Forces.of(self.fmu, self.pin)
        self.seen[mode] += 1
        where = (values, forces, mode)
        if mode not in (LOADING, RELEASING):
            assert rest_is_held(forces, values, mode), where
            return
        direction = 1 if mode == LOADING else -1
        assert direction * forces.omega >= 0.0, where
        for i, (law, mu) in enumerate(zip(laws_of(values), coefficients(forces, values), strict=True)):
            assert fmu.get(f"cam{i + 1}.friction_coefficient") == pytest.approx(mu, rel=1e-11), where
            self.varied += abs(mu - law.static) > 1e-3 * law.static
        assert slip_residual(forces, values, direction) <= ROUNDING, where

    def advance(self, inputs, start, end):
        """One step of the FMU. `inputs`: polynomials of the time from 0 on. False if the step is refused."""
        now = {name: [polynomial(u[k:], start) for k in range(len(u))] for name, u in inputs.items()}
        self.fmu.set({name: u[0] for name, u in now.items()})
        rates = {name: u[1:] for name, u in now.items() if any(u[1:])}
        if rates:
            self.fmu.set_derivatives(rates)
        if self.fmu.call("fmi2DoStep", self.fmu.time, end - start, 1) != OK:
            return False
        self.fmu.time += end - start
        return True

    def first_event(self, inputs, start, end):
        """Ends a step just after its first event; the time of the event, or `end` if there is none; None if
        the step is refused."""
        fmu = self.fmu
        state, time, count = fmu.take(), fmu.time, fmu.get("events")
        if not self.advance(inputs, start, end):
            return None
        before, after = start, end
        while fmu.get("events") > count and after - before > 1e-12 * (end - start) + 1e-15 * end:
            middle = 0.5 * (before + after)
            fmu.restore(state)
            fmu.time = time
            assert self.advance(inputs, start, middle)
            before, after = (before, middle) if fmu.get("events") > count else (middle, after)
            if fmu.get("events") == count:
                fmu.restore(state)
                fmu.time = time
                assert self.advance(inputs, start, after)
        self.events += fmu.get("events") > count
        fmu.free_state(state)
        return after

    def follow(self, inputs, h, stops=3):
        """A step of h, interrupted just after its first events. False if it is refused."""
        t = 0.0
        for _ in range(stops):
            reached = self.first_event(inputs, t, h)
            if reached is None:
                return False
            self.judge()
            t = reached
            if t >= h:
                return True
        done = self.advance(inputs, t, h)
        if done:
            self.judge()
        return done


def test_forward_forces_obey_the_law(make_model, tmp_path):
    rng = np.random.default_rng([18, 8])
    seen, events, varied, refused = dict.fromkeys(range(1, 7), 0), 0, 0, 0
    for _ in range(40):
        pin, values = random_mechanism(rng, tmp_path, regime="inertial")
        values = {"inertia.follower_mass": 0.0, "inertia.follower": 0.0, **values}
        values |= random_law(rng, tmp_path)
        watch = Watch(make_model(FORWARD).start(values), pin, values)
        for _ in range(12):
            h = 10.0 ** rng.uniform(-4, -1.5)
            if not watch.follow(random_inputs(rng, values, pin, h), h):
                refused += 1
                break
        for mode, count in watch.seen.items():
            seen[mode] += count
        events += watch.events
        varied += watch.varied
    assert min(seen[mode] for mode in (STICK, LOADING, RELEASING, LOWER_STOP, UPPER_STOP)) >= 3, seen
    assert events >= 100, events
    assert varied >= 100, varied
    assert refused <= 4, refused


def test_inverse_forces_obey_the_law(make_model, tmp_path):
    """With a rigid shaft: imposed motion of either direction."""
    rng = np.random.default_rng([18, 18])
    varied = judged = 0
    for _ in range(40):
        pin, values = random_mechanism(rng, tmp_path)
        values = {"inertia.follower_mass": 0.0, "inertia.follower": 0.0, **values}
        values |= random_law(rng, tmp_path)
        given = {
            n: v for n, v in values.items() if n not in ("initial.theta", "initial.omega", "stop.restitution")
        }
        fmu = make_model(INVERSE).start({n: v for n, v in given.items() if n in INVERSE.variables})
        for _ in range(20):
            theta = rng.uniform(values["stop.lower"], values["stop.upper"])
            omega = float(rng.normal(0.0, 5.0))
            motion = {"theta": theta, "omega": omega, "alpha": rng.normal(0.0, 300.0)}
            fmu.set(motion | {"F_ext": rng.uniform(0.0, 0.3) * spring_force(values, pin.at(theta).z)})
            forces = Forces.of(fmu, pin)
            if fmu.get("mode") not in (LOADING, RELEASING):
                continue  # no pair of flanks agrees with the imposed motion
            laws = laws_of(values)
            varied += any(
                abs(law.at(abs(forces.sliding(i))) - law.static) > 1e-3 * law.static
                for i, law in enumerate(laws)
            )
            judged += 1
            assert slip_residual(forces, values, int(np.sign(omega))) <= ROUNDING, (values, forces)
    assert judged >= 700, judged
    assert varied >= 300, varied
