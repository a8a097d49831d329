"""Every call ends after a bounded number of operations and gives finite values or a reason, whatever
parameters, inputs, states and steps are: from 0 and 5e-324 to 1.8e308, of both signs.

    python -m pytest tests/test_extreme_values.py --hypothesis-profile long    # minutes instead of seconds
"""

import math
from itertools import product

import pytest
from driver import CO_SIMULATION, ERROR, MODEL_EXCHANGE, OK, models
from extreme_scenes import MECHANISMS, WORD, is_allowed
from fuelled_fmu import FuelledModule
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from law_strategies import decades
from reference import write_table

# Operations of WebAssembly in one call, by the limits of fmu_src/model/work.h: 10^7 evaluations of 2,050 each
# and 100,000 segments of 7e4 beside their evaluations, and a fifth of room
FUEL = 33_000_000_000
# Friction tables and groove tables stand in a folder that the module sees as its root.
TABLES = {
    "friction table": {"cam1.friction_table": "/friction.csv"},
    "table over the load": {"cam2.friction_table": "/loads.csv", "inertia.shaft": 0.0, "shaft.damping": 0.1},
    "groove table": {"cam1.profile": 3, "cam1.table": "/groove.csv"},
    "groove table without inertia": {"cam2.profile": 3, "cam2.table": "/groove.csv", "inertia.shaft": 0.0},
    "elastic shaft": {"shaft.stiffness": 1e3},
    "elastic shaft and table": {"shaft.stiffness": 100.0, "cam1.profile": 3, "cam1.table": "/groove.csv"},
}
REASONS = (WORD, "must", "jam", "level")
LARGEST = 1.7976931348623157e308
SMALL = [0.0, 5e-324, 1e-310, 2.3e-308, 1e-300, 1e-200, 1e-154, 1e-16]
LARGE = [1.0, 1e16, 1e154, 1e200, 1e300, 1e305, 1e308, LARGEST]
SIZES = st.one_of(st.sampled_from(SMALL + LARGE), decades(-300, 300), decades(-12, 12), decades(-2, 2))
EXTREME = st.tuples(SIZES, st.sampled_from([1.0, -1.0])).map(lambda pair: pair[0] * pair[1])
USUAL = st.sampled_from([0.0, 1.0, -1.0, 8.0, -20.0])
VALUE = st.one_of(USUAL, EXTREME)
STEP = st.one_of(st.sampled_from([1e-3, 0.1, 1.0]), SIZES.filter(bool))


def setting(variable):
    """A parameter with an extreme value inside its range."""

    def inside(value):
        value = -value if value < variable.min else value
        return variable.name, min(max(value, variable.min), variable.max)

    return EXTREME.map(inside)


def settings_of(model, **wanted):
    chosen = [v for v in model.variables.values() if v.type == "Real" and v.causality == "parameter"]
    chosen = [v for v in chosen if all(getattr(v, name) == value for name, value in wanted.items())]
    return st.lists(st.sampled_from(chosen).flatmap(setting), max_size=3)


def moments(model):
    """Inputs with their derivatives, a step, parameters tuned before, states of model exchange."""
    angle = st.one_of(st.sampled_from([0.0, 0.1, 0.7, 1.3963]), EXTREME)
    inputs = {
        name: st.tuples(angle if name == "theta" else VALUE, st.lists(VALUE, max_size=3))
        for name in model.names(type=["Real"], causality=["input"])
    }
    state = st.tuples(angle, VALUE)
    return st.tuples(st.fixed_dictionaries(inputs), STEP, settings_of(model, variability="tunable"), state)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tables")
    write_table(folder / "groove.csv", [0.0, 0.5, 0.8, 1.2, 2.0], [0.0, 0.01, 0.01, 0.03, 0.04])
    speeds, loads = ((0.0, 0.2), (0.01, 0.15), (0.1, 0.12)), (10.0, 100.0, 1000.0)
    lines = ["v_m_s,mu", *(f"{v},{mu}" for v, mu in speeds)]
    (folder / "friction.csv").write_text("\n".join(lines) + "\n")
    lines = ["v_m_s,R_N,mu", *(f"{v},{R},{mu * (R / 100.0) ** 0.1}" for (v, mu), R in product(speeds, loads))]
    (folder / "loads.csv").write_text("\n".join(lines) + "\n")
    return folder


@pytest.fixture(scope="module", params=models)
def fmu(request, folder):
    return FuelledModule(models[request.param], FUEL, folder)


of_forward = pytest.mark.parametrize("fmu", ["DualCamForward"], indirect=True)


def check_values(fmu) -> None:
    """All that can be read is finite or refused."""
    model, read = fmu.model, {}
    reals, outputs = model.names(type=["Real"]), model.names(type=["Real"], causality=["output"])
    read |= {name: fmu.get([name]) for name in reals}
    read |= {(name, order): fmu.output_derivative(name, order) for name, order in product(outputs, (1, 2))}
    knowns = model.names(type=["Real"], causality=["input"]) + model.names(
        type=["Real"], variability=["tunable"]
    )
    read |= {pair: fmu.partial_derivative(*pair) for pair in product(outputs, knowns)}
    for name, values in read.items():
        for value in values or ():
            assert is_allowed(name, value), (name, value)


def check_reason(fmu, status: int) -> None:
    assert status == OK or any(word in fmu.message() for word in REASONS), fmu.message()


def set_inputs(fmu, inputs) -> None:
    for name, (value, rates) in inputs.items():
        fmu.set(name, value)
        if rates:
            fmu.set_derivatives(name, rates)


def co_simulate(fmu, steps) -> None:
    time = 0.0
    for inputs, h, tuned, _ in steps:
        for name, value in tuned:
            check_reason(fmu, fmu.set(name, value))
        set_inputs(fmu, inputs)
        check_values(fmu)
        status = fmu.call("DoStep", time, h, 1)
        check_reason(fmu, status)
        time += h if status == OK else 0.0
        check_values(fmu)


def exchange(fmu, moments) -> None:
    """A solver that tries extreme states, and events there."""
    states = int(fmu.model.identifier == "DualCamForward") * 2
    indicators = int(fmu.model.document.attrib["numberOfEventIndicators"])
    fmu.call("NewDiscreteStates", fmu.write("d", [0.0] * 5))
    for inputs, h, _, state in moments:
        fmu.call("EnterContinuousTimeMode")
        fmu.call("SetTime", h)
        for name, (value, _) in inputs.items():
            fmu.set(name, value)
        if states:
            fmu.call("SetContinuousStates", fmu.write("d", state), states)
        for function, count in (("GetDerivatives", states), ("GetEventIndicators", indicators)):
            assert all(map(math.isfinite, fmu.vector(function, count) or ())), function
        check_values(fmu)
        fmu.call("CompletedIntegratorStep", 1, fmu.write("i", [0]), fmu.write("i", [0]))
        fmu.call("EnterEventMode")
        fmu.call("NewDiscreteStates", fmu.write("d", [0.0] * 5))


@settings(
    max_examples=max(1, settings.default.max_examples // 12),
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
@given(st.data())
def test_every_call_ends_with_finite_values_or_a_reason(fmu, data):
    model = fmu.model
    name = data.draw(st.sampled_from([*MECHANISMS, *TABLES]), label="mechanism")
    given = (MECHANISMS | TABLES)[name] | dict(data.draw(settings_of(model), label="parameters"))
    kind = data.draw(st.sampled_from([CO_SIMULATION, CO_SIMULATION, MODEL_EXCHANGE]), label="kind")
    fmu.begin(kind)
    why = fmu.start({n: v for n, v in given.items() if n in model.variables})
    if why:
        assert kind == MODEL_EXCHANGE or any(word in why for word in REASONS), why
        return
    drawn = data.draw(st.lists(moments(model), min_size=1, max_size=3), label="moments")
    exchange(fmu, drawn) if kind == MODEL_EXCHANGE else co_simulate(fmu, drawn)


@of_forward
def test_rest_under_load_laws_ends_in_a_step_below_the_normal_numbers(fmu):
    """A rounding of the time, 2^-52 of the step, is 0 there: a search must not add that for ever."""
    fmu.begin()
    assert not fmu.start(MECHANISMS["ellipse"])
    law = [("cam2.friction_load_exponent", 3e-10), ("spring.stiffness3", 0.01), ("cam1.friction_load", 1e308)]
    first = {"tau": (1.0, [1.0, -1.9435644155768824e-12]), "F_ext": (1.0, [-5.907950824416377e-07])}
    second = {"tau": (0.0, [1e308, 1.7976931348623157e308]), "F_ext": (-1e-310, [])}
    more = [("cam1.friction", 0.03162277660168379), ("damper.c_release", 0.01)]
    co_simulate(fmu, [(first, 1e300, law, None), (second, 2.3e-308, more, None)])


@of_forward
def test_derivatives_of_a_step_with_many_segments_are_bounded(fmu):
    """1e5 rad/s in one step of 1 s: nearly the most evaluations that a step may take."""
    fmu.begin()
    assert not fmu.start(MECHANISMS["without friction"])
    fmu.set("cam2.friction_viscous", 5e-324)
    fmu.set("spring.stiffness", 1e11)
    assert fmu.call("DoStep", 0.0, 1.0, 1) == OK
    for name in ("step.dtheta_dtau", "step.domega_dcam1.friction"):
        value = fmu.get([name])
        assert value is not None and math.isfinite(value[0])


@of_forward
def test_a_step_with_the_most_segments_is_bounded(fmu):
    """Elastic bounces under a torque that grows like t^2: collocation steps between 100,000 impacts."""
    for growth in (1e14, 1e18, 1e25, 1e30):
        fmu.begin()
        assert not fmu.start(MECHANISMS["stiff"])
        fmu.set_derivatives("tau", [0.0, growth])
        assert fmu.call("DoStep", 0.0, 0.1, 1) == ERROR
        assert "segments" in fmu.message()
