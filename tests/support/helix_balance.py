"""Helices on the flanks that bear, by the linear balance of docs/mechanism.md, section 3, with any friction
law; and checks of an FMU against it."""

import math

import numpy as np
import pytest
from driver import Driver, models
from reference.friction import FrictionLaw
from reference.parameters import DEFAULTS

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]
MASSES = {"inertia.follower_mass": 1.0, "inertia.follower": 1e-4, "cam2.radius": 0.025}


class Helices:
    """Both contacts of helical cams on the flanks that support the load, in one direction."""

    def __init__(self, p: dict, sigma: int, theta_rate: float = 0.0) -> None:
        full = DEFAULTS | p
        self.ends, self.sigma = full["contacts"], sigma
        self.r = [full[f"cam{i}.radius"] for i in (1, 2)]
        self.s = [math.tan(full[f"cam{i}.lead_angle"]) for i in (1, 2)]
        a = [r * s for r, s in zip(self.r, self.s, strict=True)]
        self.turn = [a[1] / sum(a), a[0] / sum(a)]  # of the pin in each groove, over that of cam 2
        self.dz = a[0] * self.turn[0]
        self.laws = [FrictionLaw.of_cam(full, i) for i in (1, 2)]
        self.h = [math.hypot(1.0, s) for s in self.s]
        sliding = [t * r * h for t, r, h in zip(self.turn, self.r, self.h, strict=True)]
        self.speeds = [abs(theta_rate) * x for x in sliding]

    def coefficients(self, force: float) -> list[float]:
        """Under N_i = |F| a_j hypot(r_i, a_i)/(n r_i (a_1 + a_2)), j the other cam."""
        loads = [abs(force) * t * h / self.ends for t, h in zip(self.turn, self.h, strict=True)]
        return [law.at(v, load) for law, v, load in zip(self.laws, self.speeds, loads, strict=True)]

    def reactions(self, mu: list[float], axial: float, moment: float = 0.0) -> np.ndarray:
        """R_i of one contact: the axial balance, and T_2 - T_1 = `moment`."""
        of_each = zip(mu, self.s, self.h, strict=True)
        axials = [self.ends * (1 - self.sigma * m * s) / h for m, s, h in of_each]
        first, second = self.torques_per_reaction(mu)
        return np.linalg.solve([axials, [-first, second]], [axial, moment])

    def torques_per_reaction(self, mu: list[float]) -> list[float]:
        """T_i/R_i"""
        of_each = zip(self.r, self.s, self.h, mu, strict=True)
        return [self.ends * r * (s + self.sigma * m) / h for r, s, h, m in of_each]

    def edge(self, force: float) -> float:
        """The edge of the stick band under F_0 = `force`."""
        mu = self.coefficients(force)
        return self.torques_per_reaction(mu)[1] * self.reactions(mu, force)[1]


def drawn_motion(rng: np.random.Generator) -> dict:
    return {
        "theta": rng.uniform(0.1, 1.2),
        "omega": rng.choice([-1, 1]) * 10 ** rng.uniform(-2, 1.3),
        "alpha": rng.uniform(-100, 100),
        "F_ext": rng.uniform(-20, 50),
    }


def check_imposed_motion(make_model, p: dict, motion: dict, rel: float = 1e-12) -> None:
    """Torque, reactions, coefficients and powers on the flanks e that bear the reactions found on them; e
    turns the sign of the friction."""
    theta, omega, alpha, force = motion.values()
    cams = Helices(p, 1 if omega > 0 else -1, omega)
    z, v = cams.dz * theta, cams.dz * omega
    axial = 50 + 50000 * z + p["spring.stiffness2"] * z**2 + force
    axial += v * (p["damper.c_load"] if omega > 0 else 0.0)
    mu = cams.coefficients(axial)
    axial += p["inertia.follower_mass"] * cams.dz * alpha
    for e in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        signed = [sign * m for sign, m in zip(e, mu, strict=True)]
        reactions = cams.reactions(signed, axial, p["inertia.follower"] * cams.turn[0] * alpha)
        if min(e * reactions) >= 0.0:
            break
    else:
        raise AssertionError("wedged")
    torque = cams.torques_per_reaction(signed)[1] * reactions[1]
    torque += p["shaft.damping"] * omega + 0.002 * alpha
    fmu = make_model(INVERSE).start(p | motion)
    assert fmu.get("tau") == pytest.approx(torque, rel=rel, abs=1e-12)
    for i, (reaction, m, speed) in enumerate(zip(reactions, mu, cams.speeds, strict=True), 1):
        assert fmu.get(f"cam{i}.reaction") == pytest.approx(reaction, rel=rel)
        assert fmu.get(f"cam{i}.friction_coefficient") == pytest.approx(m, rel=0.01 * rel)
        power = m * abs(reaction) * p["contacts"] * speed
        assert fmu.get(f"cam{i}.friction_power") == pytest.approx(power, rel=rel)


def slope(make_one, known: str, at: float, unknown: str) -> float:
    """A central difference of order 4."""
    size = 1e-4 * max(abs(at), 1e-3)
    values = [make_one(known, at + k * size).get(unknown) for k in (-2, -1, 1, 2)]
    return (values[0] - 8 * values[1] + 8 * values[2] - values[3]) / (12 * size)


def check_directional_derivatives(make_model, values: dict, omega: float, more=(), rel: float = 1e-5) -> None:
    """Of alpha in the forward FMU and of tau in the inverse one, by states, inputs and `more`."""
    for model, unknown, own in ((FORWARD, "alpha", {"tau": 5.0}), (INVERSE, "tau", {"alpha": 3.0})):
        prefix = "initial." if model is FORWARD else ""
        start = values | {f"{prefix}theta": 0.4, f"{prefix}omega": omega} | own

        def one(name: str, value: float, start=start, model=model, prefix=prefix) -> Driver:
            key = prefix + name if name in ("theta", "omega") else name
            return make_model(model).start(start | {key: value})

        fmu = make_model(model).start(start)
        for known in ["theta", "omega", *own, "F_ext", *more]:
            if known.endswith(("_peak", "_viscous", "c_load")) and fmu.get(known) in (0.0, 1.0):
                continue  # a difference would leave the range
            found, expected = fmu.partial(unknown, known), slope(one, known, fmu.get(known), unknown)
            assert found == pytest.approx(expected, rel=rel, abs=1e-7 * abs(fmu.get(unknown))), known
