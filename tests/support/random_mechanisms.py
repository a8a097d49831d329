"""Random mechanisms with any grooves, random inputs, and steps of the FMU under these inputs."""

from itertools import pairwise

import numpy as np
from pin_equations import ACCOUNTS, KINDS, Pin, polynomial, random_groove, spring_force


def random_mechanism(rng, folder, pair=None, regime="inertial"):
    """Grooves and the FMU's parameters; a mechanism of these sizes swings within some 10 ms and reaches its
    stops."""
    lower, upper = float(rng.choice([0.0, -rng.uniform(0.2, 0.8)])), rng.uniform(0.6, 1.4)
    kinds = pair or rng.choice(KINDS, 2)
    reach = max(upper, -lower) * 1.02
    name = f"{rng.integers(2**40):x}"
    pin = Pin(*(random_groove(rng, kind, reach, folder / f"{name}-{i}.csv") for i, kind in enumerate(kinds)))
    travel = max(pin.at(upper).z, -pin.at(lower).z)
    force = 10.0 ** rng.uniform(1.5, 2.5)

    def some(share, draw):
        return float(draw()) if rng.random() < share else 0.0

    values = pin.values | {
        "cam1.friction": some(0.9, lambda: rng.uniform(0.02, 0.3)),
        "cam2.friction": some(0.9, lambda: rng.uniform(0.02, 0.3)),
        "spring.preload": force * rng.uniform(0.0, 0.5),
        "spring.stiffness": force / travel * rng.uniform(0.3, 1.0),
        "spring.stiffness2": some(0.7, lambda: force / travel**2 * rng.uniform(-0.3, 0.6)),
        "spring.stiffness3": some(0.7, lambda: force / travel**3 * rng.uniform(-0.2, 0.6)),
        "stop.lower": lower,
        "stop.upper": upper,
        "stop.restitution": some(0.6, lambda: rng.uniform(0.1, 0.7)),
        "initial.theta": rng.uniform(lower, upper),
        "inertia.shaft": 0.0,
        "contacts": int(rng.integers(1, 3)),
    }
    lift = pin.at(0.5 * (lower + upper)).lift
    if regime == "inertial":
        shaft = force * lift * 10.0 ** rng.uniform(-4, -2.5)
        values |= {
            "inertia.shaft": shaft,
            "inertia.follower_mass": some(0.6, lambda: shaft / lift**2 * rng.uniform(0.05, 0.5)),
            "inertia.follower": some(0.6, lambda: shaft * rng.uniform(0.05, 0.5)),
            "initial.omega": some(0.4, lambda: rng.uniform(-10.0, 10.0)),
        }
    if regime != "rate-independent":
        speed = 20.0 * lift  # m/s
        for name in ("load", "release"):
            values[f"damper.c_{name}"] = force / speed * rng.uniform(0.02, 0.5)
            values[f"damper.q_{name}"] = some(0.8, lambda: force / speed**2 * rng.uniform(0.02, 0.5))
        values["shaft.damping"] = some(0.5, lambda: force * lift / 20.0 * rng.uniform(0.01, 0.2))
    return pin, values


def random_inputs(rng, values, pin, h, curved=True):
    """tau and F_ext over a step of h: value and derivatives at the start of the step."""
    place = pin.at(values["stop.upper"])
    force = spring_force(values, place.z)
    tau = force * place.lift * rng.choice([0.0, rng.uniform(-1.0, 0.5), rng.uniform(0.0, 2.0)])
    pull = force * rng.choice([0.0, 0.0, rng.uniform(-1.5, 0.5)])
    orders = rng.integers(0, 4) if curved else 0
    shares = rng.uniform(-1.0, 1.0, (2, orders))
    tau_way, pull_way = abs(tau) + 0.2 * force * place.lift, abs(pull)
    return {
        "tau": [float(tau), *(float(s) * tau_way / h ** (k + 1) for k, s in enumerate(shares[0]))],
        "F_ext": [float(pull), *(float(s) * pull_way / h ** (k + 1) for k, s in enumerate(shares[1]))],
    }


def step(fmu, h, inputs):
    fmu.set({name: u[0] for name, u in inputs.items()})
    rates = {name: u[1:] for name, u in inputs.items() if any(u[1:])}
    if rates:
        fmu.set_derivatives(rates)
    fmu.step(h)


def run_on(fmu, inputs, start, end, pieces):
    """Steps from `start` to `end` under `inputs`, polynomials in the time from 0 on."""
    for t, later in pairwise(np.linspace(start, end, pieces + 1)):
        now = {
            name: [polynomial(u[k:], t) for k in range(len(u))] for name, u in inputs.items()
        }  # derivatives of the Taylor polynomial
        step(fmu, float(later - t), now)


def reactions(fmu):
    """Reactions of both cams, each summed over its contacts, N."""
    return tuple(fmu.get("contacts") * fmu.get(f"cam{i}.reaction") for i in (1, 2))


def turned_over(fmu):
    return sum(abs(fmu.get(name)) for name in ACCOUNTS)
