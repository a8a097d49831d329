"""Random mechanisms over many decades for hypothesis, inputs that are curves, and steps of the FMU under such
inputs."""

import math
from pathlib import Path

from driver import OK, Driver
from hypothesis import assume, note
from hypothesis import strategies as st
from law_strategies import decades, friction_laws, or_zero
from reference import Grooves, write_table

LEAST = 1e-6  # N.m: a T_load below is the rounding of F_0 = 0


def signed(strategy):
    return st.tuples(strategy, st.sampled_from([-1.0, 1.0])).map(lambda pair: pair[0] * pair[1])


ANGLES = st.one_of(st.floats(0.01, 1.5), decades(-6, 0), decades(-6, -1).map(lambda x: math.pi / 2 - x))
PARAMETERS = st.fixed_dictionaries(
    {
        "cam1.radius": decades(-3, 0),
        "cam2.radius": decades(-3, 0),
        "cam1.lead_angle": ANGLES,
        "cam2.lead_angle": ANGLES,
        "cam1.friction": or_zero(decades(-3, 0.3)),
        "cam2.friction": or_zero(decades(-3, 0.3)),
        "spring.preload": or_zero(signed(decades(-3, 4))),
        "spring.stiffness": or_zero(decades(-2, 8)),
        "damper.c_load": or_zero(decades(-3, 7)),
        "damper.c_release": or_zero(decades(-3, 7)),
        "inertia.shaft": or_zero(decades(-9, 3)),
        "inertia.follower_mass": or_zero(decades(-6, 3)),
        "inertia.follower": or_zero(decades(-9, 1)),
        "shaft.damping": or_zero(decades(-6, 3)),
        "stop.lower": or_zero(decades(-2, 1).map(lambda x: -x)),
        "stop.upper": decades(-2, 1),
        "stop.restitution": st.floats(0.0, 0.98),
        "initial.omega": or_zero(signed(decades(-2, 2))),
    }
)


# What grooves of any shape and nonlinear elements add. An ellipse is drawn by where it starts, S0 in (0,
# 1), and how far it gets, so that hardly any is left before a stop; a table by the rises between its
# points, some of them 0; a cycloid by how far it gets. A cycloid begins at the lower stop, and is one of two.
SHAPES = st.fixed_dictionaries(
    {
        "profile": st.sampled_from([1, 2, 2, 3, 3, 4]),
        "start": st.floats(0.02, 0.98),
        "reach": st.floats(1.01, 30.0),
        "curvature": st.sampled_from([-1, 1]),
        "rises": st.lists(or_zero(decades(-3, 0)), min_size=3, max_size=9),
    }
)
NONLINEAR = st.fixed_dictionaries(
    {
        "spring.stiffness2": or_zero(signed(decades(2, 7))),
        "spring.stiffness3": or_zero(signed(decades(3, 9))),
        "damper.q_load": or_zero(decades(0, 6)),
        "damper.q_release": or_zero(decades(0, 6)),
    }
)


def grooved(parameters, shapes, folder):
    """`parameters` with these grooves."""
    found = dict(parameters)
    cycloids = [shape["profile"] for shape in shapes].count(4)
    assume(cycloids == 0 or (cycloids == 1 and parameters["stop.lower"] == 0.0))
    most = max(parameters["stop.upper"], -parameters["stop.lower"])
    for i, shape in enumerate(shapes, start=1):
        cam, radius = f"cam{i}.", parameters[f"cam{i}.radius"]
        found[cam + "profile"], lead = shape["profile"], parameters[f"cam{i}.lead_angle"]
        if shape["profile"] == 2:
            S0, kappa = shape["start"], shape["curvature"]
            room = min(S0, 1.0 - S0) if parameters["stop.lower"] < 0 else S0 if kappa < 0 else 1.0 - S0
            a = shape["reach"] * radius * most / room
            b = a * math.tan(lead) * math.sqrt(1.0 - S0 * S0) / S0  # sin(atan(a/b tan lead)) = S0
            sizes = {cam + "ellipse_a": a, cam + "ellipse_b": b}
            assume(all(1e-6 <= size <= 1e3 for size in sizes.values()))
            found |= sizes | {cam + "ellipse_curvature": kappa}
        if shape["profile"] == 4:
            angle = shape["reach"] * most
            sizes = {cam + "cycloid_angle": angle, cam + "cycloid_rise": radius * math.tan(lead) * angle}
            assume(all(1e-6 <= size <= 1e3 for size in sizes.values()))
            found |= sizes
        if shape["profile"] == 3:
            low, count = 1.01 * min(parameters["stop.lower"], 0.0), len(shape["rises"])
            step = (1.01 * parameters["stop.upper"] - low) / count
            z = [radius * math.tan(lead) * step * math.fsum(shape["rises"][:k]) for k in range(count + 1)]
            path = folder / f"groove{i}.csv"
            write_table(path, [low + k * step for k in range(count)] + [1.01 * parameters["stop.upper"]], z)
            found[cam + "table"] = str(path)
    return found


# Sizes that belong to one machine, and grooves of any shape.
MODERATE = st.fixed_dictionaries(
    {
        **{f"cam{i}.radius": decades(-2.3, -1) for i in (1, 2)},
        **{f"cam{i}.lead_angle": st.floats(0.1, 1.4) for i in (1, 2)},
        **{f"cam{i}.friction": or_zero(decades(-2, -0.3)) for i in (1, 2)},
        "spring.preload": or_zero(signed(decades(0, 3))),
        "spring.stiffness": or_zero(decades(2, 5)),
        "damper.c_load": or_zero(decades(0, 4)),
        "damper.c_release": or_zero(decades(0, 4)),
        "inertia.shaft": or_zero(decades(-4, 0)),
        "inertia.follower_mass": or_zero(decades(-2, 1)),
        "inertia.follower": or_zero(decades(-5, -2)),
        "shaft.damping": or_zero(decades(-3, 0)),
        "stop.lower": or_zero(decades(-1, 0.3).map(lambda x: -x)),
        "stop.upper": decades(-1, 0.5),
        "stop.restitution": st.floats(0.0, 0.8),
        "initial.omega": or_zero(signed(decades(-1, 1.3))),
    }
)
GENERAL = st.tuples(MODERATE, st.tuples(SHAPES, SHAPES), NONLINEAR)
EXTREME = st.tuples(st.one_of(MODERATE, PARAMETERS), st.tuples(SHAPES, SHAPES), NONLINEAR)


def general(scene, folder):
    """Parameters of a scene drawn from GENERAL."""
    linear, shapes, nonlinear = scene
    return grooved(linear | nonlinear, shapes, folder)


def general_with_laws(data, scene, folder):
    """As general(), in every second scene with friction laws. A failing test prints the tables."""
    parameters = general(scene, folder)
    if data.draw(st.booleans(), label="friction laws"):
        parameters |= data.draw(friction_laws(parameters, folder), label="laws")
    for name, value in parameters.items():
        if name.endswith("table") and value:
            note(f"{name}:\n{Path(value).read_text()}")
    return parameters


TORQUES = or_zero(signed(decades(-1, 1.5)))  # in units of T_load at the start
FORCES = or_zero(signed(decades(-1, 4)))
STEPS = st.lists(
    st.tuples(decades(-6, 1), TORQUES, TORQUES, FORCES, FORCES), min_size=1, max_size=12
)  # h, tau, its rate, F_ext, its rate
CURVES = st.lists(
    st.tuples(decades(-5, 0), *[st.lists(kind, min_size=1, max_size=4) for kind in (TORQUES, FORCES)]),
    min_size=1,
    max_size=6,
)  # h; what the derivatives of tau and of F_ext, of orders 0, 1, ... amount to over h

CUTS = st.lists(st.floats(0.01, 0.99), min_size=1, max_size=4, unique=True)  # shares of an interval


def unit_of_torque(fmu: Driver, least: float = 0.0) -> float:
    torque = abs(fmu.get("torque_load"))
    return torque if least < torque < math.inf else 1.0


def step(fmu: Driver, torque_unit: float, h, tau, tau_rate, force, force_rate) -> int:
    fmu.set({"tau": tau * torque_unit, "F_ext": force})
    if tau_rate or force_rate:
        fmu.set_rates(tau=tau_rate * torque_unit, F_ext=force_rate)
    status = fmu.call("fmi2DoStep", fmu.time, h, 1)
    if status == OK:
        fmu.time += h
    return status


def curve(fmu: Driver, torque_unit: float, h, taus, forces, part=(0.0, 1.0)) -> int:
    """That part of a step of h."""
    start, end = part[0] * h, part[1] * h
    inputs = {}
    for name, shares, unit in (("tau", taus, torque_unit), ("F_ext", forces, 1.0)):
        u = [unit * share / h**k for k, share in enumerate(shares)]
        inputs[name] = [
            sum(u[k + j] * start**j / math.factorial(j) for j in range(len(u) - k)) for k in range(len(u))
        ]
    fmu.set({name: u[0] for name, u in inputs.items()})
    rates = {name: u[1:] for name, u in inputs.items() if u[1:]}
    if rates:
        fmu.set_derivatives(rates)
    status = fmu.call("fmi2DoStep", fmu.time, end - start, 1)
    if status == OK:
        fmu.time += end - start
    return status


def slopes(fmu: Driver, grooves) -> list[float]:
    """m/rad, of both grooves where the FMU stands."""
    gamma, theta = fmu.get("gamma"), fmu.get("theta")
    angles = zip(grooves, (gamma, theta - gamma), strict=True)
    return [g.derivatives(x, Grooves._index(g, x))[1] for g, x in angles]


def inertia_felt(fmu: Driver, parameters, grooves) -> float:
    """kg.m^2, twice the kinetic energy per omega^2 where the FMU stands. The follower turns at most as far as
    cam 2."""
    a1, a2 = slopes(fmu, grooves)
    lift = a1 * a2 / (a1 + a2)
    J, m, inertia = (parameters[f"inertia.{name}"] for name in ("shaft", "follower_mass", "follower"))
    return J + m * lift * lift + inertia
