"""Partial derivatives (fmi2GetDirectionalDerivative) against differences of the FMUs themselves."""

import math
from ctypes import c_double

import numpy as np
import pytest
from driver import Driver, models, to_c
from mechanisms import FOLLOWER, FORCES, GROOVES

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]
TUNABLE = {
    "cam1.friction": 0.1,
    "cam2.friction": 0.1,
    "spring.preload": 50.0,
    "spring.stiffness": 2e4,
    **FORCES,
}  # with sizes
MASSES = FOLLOWER | {"inertia.shaft": 0.002}


def difference(f, x: float, size: float) -> float:
    """Central, of order 6."""
    h = 1e-3 * size
    weights = {1: 45.0, 2: -9.0, 3: 1.0}
    return math.fsum(w * (f(x + k * h) - f(x - k * h)) for k, w in weights.items()) / (60.0 * h)


def alpha_with(fmu: Driver, name: str):
    """alpha as a function of that variable, which is then set back."""

    def alpha(value: float) -> float:
        before = fmu.get(name)
        fmu.set({name: value})
        found = fmu.get("alpha")
        fmu.set({name: before})
        return found

    return alpha


def assert_close(found: float, expected: float, scale: float) -> None:
    assert abs(found - expected) <= 1e-6 * max(abs(expected), 1e-6 * scale), (found, expected)


@pytest.mark.parametrize("groove", GROOVES)
@pytest.mark.parametrize("omega", [3.0, -3.0])
@pytest.mark.parametrize("F_ext", [10.0, -400.0])
def test_acceleration_while_slipping(make_model, groove, omega, F_ext):
    values = TUNABLE | MASSES | GROOVES[groove]

    def at(theta: float, speed: float) -> Driver:
        fmu = make_model(FORWARD)
        start = {"initial.theta": theta, "initial.omega": speed, "tau": 2.0, "F_ext": F_ext}
        return fmu.start(values | start)

    fmu = at(0.6, omega)
    assert fmu.get("mode") == (2 if omega > 0 else 3)
    scale = abs(fmu.get("alpha"))

    for name, size in (TUNABLE | {"tau": 2.0, "F_ext": 100.0}).items():
        expected = difference(alpha_with(fmu, name), fmu.get(name), size)
        assert_close(fmu.partial("alpha", name), expected, scale / size)
    expected = difference(lambda theta: at(theta, omega).get("alpha"), 0.6, 0.1)
    assert_close(fmu.partial("alpha", "theta"), expected, scale)
    expected = difference(lambda speed: at(0.6, speed).get("alpha"), omega, 1.0)
    assert_close(fmu.partial("alpha", "omega"), expected, scale)
    for name in ("z", "v"):
        expected = difference(lambda theta, n=name: at(theta, omega).get(n), 0.6, 0.1)
        assert_close(fmu.partial(name, "theta"), expected, abs(fmu.get(name)))
        expected = difference(lambda speed, n=name: at(0.6, speed).get(n), omega, 1.0)
        assert_close(fmu.partial(name, "omega"), expected, abs(fmu.get(name)))
        assert fmu.partial(name, "tau") == 0.0


def test_outputs_follow_states_alone(make_model):
    """No direct feedthrough: what is put out does not depend on inputs, at rest alpha neither."""
    fmu = make_model(FORWARD).start({"initial.theta": 0.5, "tau": 2.5})
    assert fmu.get("mode") == 1
    for unknown in ("theta", "omega", "z", "v", "alpha"):
        assert fmu.partial(unknown, "tau") == fmu.partial(unknown, "F_ext") == 0.0
    assert fmu.partial("theta", "theta", 2.5) == 2.5
    assert fmu.partial("omega", "omega") == 1.0


@pytest.mark.parametrize("groove", GROOVES)
@pytest.mark.parametrize("omega", [3.0, -3.0])
@pytest.mark.parametrize("F_ext", [10.0, -400.0])
def test_torque_of_the_imposed_motion(make_model, groove, omega, F_ext):
    motion = {"theta": 0.6, "omega": omega, "alpha": 20.0, "F_ext": F_ext}
    sizes = TUNABLE | {"theta": 0.1, "omega": 1.0, "alpha": 10.0, "F_ext": 100.0}
    check_inverse(make_model, TUNABLE | MASSES | GROOVES[groove], motion, sizes, ("tau", "z", "v"))


@pytest.mark.parametrize("groove", GROOVES)
@pytest.mark.parametrize("theta", [0.505, 0.62, 0.7, 0.3])
def test_torque_of_an_elastic_shaft(make_model, groove, theta):
    """Where cam 2 slips tau is the edge of the stick band; where it sticks, the shaft alone gives way."""
    values = TUNABLE | GROOVES[groove] | {"shaft.stiffness": 60.0}
    motion = {"theta": theta, "omega": math.copysign(1.0, theta - 0.5), "alpha": 0.0, "F_ext": 10.0}
    sizes = {"theta": 0.01}
    if abs(theta - 0.5) > 0.1:  # it slips; stuck where it started, it is on the edge of the band: a kink
        sizes["F_ext"] = 10.0
    check_inverse(make_model, values, motion, sizes, ("tau", "z"), start=0.5)


def check_inverse(make_model, values, motion, sizes, unknowns, start=None):
    fmu = make_model(INVERSE)
    first = motion if start is None else motion | {"theta": start, "omega": 0.0}
    fmu.start(values | first)
    if start is not None:
        fmu.set(motion)

    def output_with(unknown: str, name: str):
        def output(value: float) -> float:
            before = fmu.get(name)
            fmu.set({name: value})
            found = fmu.get(unknown)
            fmu.set({name: before})
            return found

        return output

    for unknown in unknowns:
        scale = abs(fmu.get(unknown))
        for name, size in sizes.items():
            expected = difference(output_with(unknown, name), fmu.get(name), size)
            assert_close(fmu.partial(unknown, name), expected, scale / size)


def test_a_combination_is_linear(make_model):
    fmu = make_model(FORWARD).start(MASSES | {"initial.theta": 0.5, "initial.omega": 2.0, "tau": 3.0})
    names, seeds = ["tau", "F_ext", "theta"], [0.5, -3.0, 0.25]
    result = (c_double * 2)()
    references = fmu.model.references
    arguments = references(["alpha", "v"]), 2, references(names), 3, to_c("Real", seeds), result
    fmu.ok("fmi2GetDirectionalDerivative", *arguments)
    for found, unknown in zip(result, ("alpha", "v"), strict=True):
        parts = [fmu.partial(unknown, name, seed) for name, seed in zip(names, seeds, strict=True)]
        assert found == pytest.approx(math.fsum(parts), rel=1e-14)
    state = np.array([fmu.get(n) for n in ("theta", "omega", "alpha")])
    assert np.all(np.isfinite(state))


@pytest.mark.parametrize(
    ("unknown", "known", "seed", "mentions"),
    [
        ("energy.spring", "tau", 1.0, ("energy.spring", "outputs")),
        ("z", "cam1.radius", 1.0, ("cam1.radius", "tunable")),
        ("z", "tau", math.nan, ("tau", "finite")),
        ("contacts", "tau", 1.0, ("contacts", "Real")),
        ("z", 12345, 1.0, ("12345",)),
    ],
)
def test_refuses_what_has_no_derivative(make_model, unknown, known, seed, mentions):
    fmu = make_model(FORWARD).start({"initial.theta": 0.5})
    before = fmu.get("z")
    result = (c_double * 1)(7.0)
    references = fmu.model.references
    arguments = references([unknown]), 1, references([known]), 1, to_c("Real", [seed]), result
    fmu.refused("fmi2GetDirectionalDerivative", *arguments, mentions=mentions)
    assert result[0] == 7.0
    assert fmu.get("z") == before


VISCOUS = {"inertia.shaft": 0.0, "shaft.damping": 0.01}
RATES = {"tau": [40.0], "F_ext": [-900.0]}


@pytest.mark.parametrize("groove", GROOVES)
@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("forces", ["closed form", "any"])
def test_acceleration_without_inertia(make_model, groove, direction, forces):
    """alpha is how the speed, which the forces give, changes along the motion and with the inputs' rates."""
    quadratic = ("spring.stiffness2", "spring.stiffness3", "damper.q_load", "damper.q_release")
    linear = {name: 0.0 for name in quadratic if forces == "closed form"}
    values = TUNABLE | VISCOUS | GROOVES[groove] | linear
    tau = 4.0 if direction > 0 else 0.2

    def at(theta: float) -> Driver:
        fmu = make_model(FORWARD).start(values | {"initial.theta": theta, "tau": tau})
        fmu.set_derivatives(RATES)
        return fmu

    fmu = at(0.6)
    assert fmu.get("mode") == (2 if direction > 0 else 3)
    scale = abs(fmu.get("alpha"))

    for name, size in (TUNABLE | {"tau": 2.0, "F_ext": 100.0}).items():
        if name in linear:
            continue
        expected = difference(alpha_with(fmu, name), fmu.get(name), size)
        assert_close(fmu.partial("alpha", name), expected, scale / size)
    expected = difference(lambda theta: at(theta).get("alpha"), 0.6, 0.1)
    assert_close(fmu.partial("alpha", "theta"), expected, scale)
    assert fmu.partial("alpha", "omega") == 0.0


def test_acceleration_by_the_quadratic_part_of_a_linear_damper(make_model):
    """Zero now, and yet alpha depends on it: against a mechanism that has a little of it."""
    start = TUNABLE | VISCOUS | {"initial.theta": 0.6, "tau": 4.0, "damper.q_load": 0.0}
    found = []
    for q in (0.0, *(k * 0.05 for k in range(1, 8))):
        fmu = make_model(FORWARD).start(start | {"damper.q_load": q})
        fmu.set_derivatives(RATES)
        found.append(fmu.get("alpha"))
        if q == 0.0:
            expected = fmu.partial("alpha", "damper.q_load")
    nodes = np.arange(8.0)
    weights = np.linalg.solve(np.vander(nodes, increasing=True).T, np.eye(8)[1])
    assert expected == pytest.approx(math.fsum(weights * found) / 0.05, rel=1e-6)


def test_unknowns_may_come_twice_and_in_any_order(make_model):
    values = {"initial.theta": 0.5, "initial.omega": 2.0, "tau": 3.0}
    fmu = make_model(FORWARD).start(MASSES | FORCES | GROOVES["mixed"] | values)
    unknowns, knowns = ["v", "alpha", "theta", "alpha", "z", "omega", "v"], ["tau", "theta", "omega"]
    seed = [0.5, -2.0, 3.0]
    references, found = fmu.model.references, (c_double * len(unknowns))()
    fmu.ok(
        "fmi2GetDirectionalDerivative",
        *(references(unknowns), len(unknowns), references(knowns), len(knowns), to_c("Real", seed), found),
    )
    for unknown, value in zip(unknowns, found, strict=True):
        terms = [fmu.partial(unknown, known, by) for known, by in zip(knowns, seed, strict=True)]
        assert value == pytest.approx(math.fsum(terms), rel=1e-15)


def test_where_one_row_does_not_exist_none_is_written(make_model):
    fmu = make_model(FORWARD).start({"inertia.shaft": 0.0, "initial.theta": 0.5, "tau": 4.0})
    result = to_c("Real", [7.0, 7.0])
    references = fmu.model.references
    arguments = references(["z", "alpha"]), 2, references(["theta"]), 1, to_c("Real", [1.0]), result
    fmu.refused("fmi2GetDirectionalDerivative", *arguments, mentions=("alpha",))
    assert list(result) == [7.0, 7.0]


def test_where_the_angle_follows_the_torque_it_is_no_state(make_model):
    fmu = make_model(FORWARD).start({"inertia.shaft": 0.0, "initial.theta": 0.5, "tau": 4.0})
    result = (c_double * 1)()
    references = fmu.model.references
    arguments = references(["alpha"]), 1, references(["tau"]), 1, to_c("Real", [1.0]), result
    fmu.refused("fmi2GetDirectionalDerivative", *arguments, mentions=("alpha", "inertia.shaft", "damping"))
    fmu.set({"tau": 2.5})
    assert fmu.get("mode") == 1
    assert fmu.partial("alpha", "tau") == 0.0
