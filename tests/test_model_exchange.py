"""FMI 2.0 model exchange: a solver outside, events by indicators. What it must agree with is co-simulation,
which other tests hold against references."""

import ctypes
import itertools
import math
from collections import Counter

import numpy as np
import pytest
from driver import CO_SIMULATION, MODEL_EXCHANGE, OK, models
from fmpy import fmi2, simulate_fmu
from scipy.integrate import solve_ivp

FORWARD, INVERSE = models.values()
STATES = {FORWARD: 2, INVERSE: 0}
INDICATORS = {FORWARD: 7, INVERSE: 1}

ELLIPSES = {
    "cam1.profile": 2, "cam1.lead_angle": 0.82, "cam2.profile": 2, "cam2.lead_angle": 0.7,
    "inertia.follower_mass": 0.3, "inertia.follower": 1e-4, "damper.c_load": 40.0, "damper.q_release": 200.0,
    "initial.theta": 0.1,
}  # fmt: skip
LOCKING = {"cam1.lead_angle": 0.1, "initial.theta": 0.5}
BOUNCING = {"stop.restitution": 0.6, "initial.theta": 0.8, "initial.omega": 5.0}
UP_AND_DOWN = [(0.0, 0.0), (0.05, 12.0), (0.3, 3.0), (0.6, 30.0), (0.8, -5.0)]

# Parameters, and torque over time: it stays from one point to the next.
SCENES = {
    "helices": ({}, UP_AND_DOWN),
    "helices, soft and damped": (
        {"spring.stiffness": 5e3, "damper.c_load": 300.0, "damper.c_release": 50.0, "shaft.damping": 0.01},
        UP_AND_DOWN,
    ),
    "no friction": ({"cam1.friction": 0.0, "cam2.friction": 0.0, "shaft.damping": 0.02}, UP_AND_DOWN),
    "bounces": (BOUNCING, [(0.0, 2.0), (0.5, 14.0)]),
    "ellipses with a heavy follower": (ELLIPSES, UP_AND_DOWN),
    "a contact locks": (LOCKING, [(0.0, 0.0), (0.05, 3.0), (0.3, -3.0), (0.6, 6.0), (0.8, -5.0)]),
    "no preload": ({"spring.preload": 0.0}, UP_AND_DOWN),
}
OUTPUTS = ["theta", "omega", "z", "v", "mode", "events"]
INTERVAL = 0.01


def each_scene(function):
    return pytest.mark.parametrize(("values", "torque"), SCENES.values(), ids=SCENES)(function)


# ---- FMPy's CVode ----


def staircase(torque):
    """As FMPy's input: two rows where it jumps."""
    ends = [t for t, _ in torque[1:]] + [1.0]
    rows = [(t, tau, 0.0) for (start, tau), end in zip(torque, ends, strict=True) for t in (start, end)]
    return np.array(rows, dtype=[("time", float), ("tau", float), ("F_ext", float)])


def simulate(kind, values, torque, tolerance):
    step = INTERVAL if kind == "CoSimulation" else None
    return simulate_fmu(
        str(FORWARD.fmu), fmi_type=kind, input=staircase(torque), start_time=0, stop_time=1, step_size=step,
        output_interval=INTERVAL, relative_tolerance=tolerance, start_values=values, output=OUTPUTS,
        record_events=False,
    )  # fmt: skip


@pytest.fixture
def calls(monkeypatch):
    """How often FMPy enters event mode and asks for derivatives."""
    counted: Counter = Counter()
    for name in ("enterEventMode", "getDerivatives"):
        original = getattr(fmi2.FMU2Model, name)

        def call(self, *arguments, name=name, original=original):
            counted[name] += 1
            return original(self, *arguments)

        monkeypatch.setattr(fmi2.FMU2Model, name, call)
    return counted


SIZE = {"theta": 1.0, "omega": 20.0, "z": 0.02, "v": 0.5}


@each_scene
def test_cvode_agrees_with_co_simulation(values, torque, calls):
    """To some tens of the tolerance, which holds for one step; CVode starts at order 1 after each event, so
    a tolerance 1000 times smaller makes the error at least 30 times smaller. No chatter: no more events than
    mode changes and ends of pieces of the torque."""
    wanted = simulate("CoSimulation", values, torque, 1e-11)
    error = {}
    for tolerance in (1e-6, 1e-9):
        calls.clear()
        found = simulate("ModelExchange", values, torque, tolerance)
        assert list(found["time"]) == list(wanted["time"])
        error[tolerance] = {name: np.abs(found[name] - wanted[name]).max() / SIZE[name] for name in SIZE}
        assert calls["enterEventMode"] <= wanted["events"][-1] + 2 * len(torque)
        assert calls["getDerivatives"] <= 2_000
    for name in SIZE:
        assert error[1e-6][name] <= 150e-6
        assert error[1e-9][name] <= error[1e-6][name] / 30.0


def check_no_chatter(values: dict, calls: Counter, most_derivatives: int) -> None:
    """CVode agrees with co-simulation, in few events and evaluations, through stick, slip and reversals."""
    torque = [(0.0, 0.0), (0.05, 12.0), (0.3, 3.0), (0.6, 30.0), (0.8, -5.0)]
    wanted = simulate("CoSimulation", values, torque, 1e-11)
    found = simulate("ModelExchange", values, torque, 1e-9)
    for name, size in SIZE.items():
        assert np.abs(found[name] - wanted[name]).max() / size <= 1e-5
    assert calls["enterEventMode"] <= wanted["events"][-1] + 2 * len(torque)
    assert calls["getDerivatives"] <= most_derivatives


# ---- a solver of our own, which applies inputs at every instant ----


class Exchange:
    """Model exchange as a textbook has it: DOP853 between events, which are roots of the indicators."""

    def __init__(self, fmu, values, inputs):
        self.fmu, self.inputs, self.model = fmu, inputs, fmu.model
        self.entered = 0
        fmu.set(values)
        fmu.setup()
        fmu.ok("fmi2EnterInitializationMode")
        self.apply(0.0)
        fmu.ok("fmi2ExitInitializationMode")
        fmu.settle()

    def apply(self, t):
        names = list(self.inputs)
        assert self.fmu.try_set({name: self.inputs[name](t) for name in names}) == OK

    def put(self, t, x):
        self.fmu.ok("fmi2SetTime", t)
        self.apply(t)
        self.fmu.set_vector("fmi2SetContinuousStates", list(x))

    def rates(self, t, x):
        self.put(t, x)
        return self.fmu.vector("fmi2GetDerivatives", 2)

    def indicators(self, t, x):
        self.put(t, x)
        return self.fmu.vector("fmi2GetEventIndicators", 7)

    def states(self):
        return self.fmu.vector("fmi2GetContinuousStates", 2)

    def completed(self):
        enter, end = ctypes.c_int(7), ctypes.c_int(7)
        self.fmu.ok("fmi2CompletedIntegratorStep", 1, ctypes.byref(enter), ctypes.byref(end))
        assert (enter.value, end.value) == (0, 0)

    def advance(self, start, end):
        """From one communication point to the next."""
        roots = [lambda t, x, i=i: self.indicators(t, x)[i] for i in range(7)]
        for root in roots:
            root.terminal = True
        t = start
        while t < end:
            solved = solve_ivp(
                self.rates, (t, end), self.states(), "DOP853",
                rtol=3e-14, atol=1e-14, events=roots, max_step=2e-3,
            )  # fmt: skip
            assert solved.success
            t = solved.t[-1]
            self.put(t, solved.y[:, -1])
            self.completed()
            if solved.status == 1:
                self.event()

    def event(self):
        self.entered += 1
        self.fmu.ok("fmi2EnterEventMode")
        self.fmu.settle()


def wave(t):
    return 4.0 + 14.0 * math.sin(9.0 * t)


@each_scene
def test_another_solver_agrees_with_co_simulation(make_model, values, torque):
    """A torque that goes through the stick band slowly; in steps so short that a cubic is exact to 1e-8."""
    inputs = {"tau": wave, "F_ext": lambda t: 3.0 * math.cos(5.0 * t)}
    exchange = Exchange(make_model(FORWARD, kind=MODEL_EXCHANGE), values, inputs)
    whole = make_model(FORWARD)
    whole.set(values)
    whole.set({name: value(0.0) for name, value in inputs.items()})
    whole.start(tolerance=1e-12)
    h, tau, F_ext = 1e-3, 9.0, 5.0
    for k in range(500):
        t = k * h
        phase, other = tau * t, F_ext * t
        whole.set({name: value(t) for name, value in inputs.items()})
        whole.set_derivatives(
            {
                "tau": [126.0 * math.cos(phase), -1134.0 * math.sin(phase), -10206.0 * math.cos(phase)],
                "F_ext": [-15.0 * math.sin(other), -75.0 * math.cos(other), 375.0 * math.sin(other)],
            }
        )
        whole.step(h)
        if k % 10 == 9:
            exchange.advance(t - 9 * h, t + h)
            theta, omega = exchange.states()
            assert theta == pytest.approx(whole.get("theta"), abs=1e-9)
            assert omega == pytest.approx(whole.get("omega"), abs=1e-7)
    assert whole.get("events") >= 3
    if "stop.restitution" not in values:  # when the last bounce is over is a matter of rounding
        assert exchange.fmu.get("events") == whole.get("events")
    assert exchange.entered <= whole.get("events") + 2


@pytest.mark.parametrize("restitution", [0.5, 0.9])
def test_bounces_come_to_an_end(make_model, restitution):
    values = BOUNCING | {"stop.restitution": restitution}
    exchange = Exchange(make_model(FORWARD, kind=MODEL_EXCHANGE), values, {"tau": lambda t: 14.0})
    for k in range(60):
        exchange.advance(k * INTERVAL, (k + 1) * INTERVAL)
    assert exchange.states() == [1.3963, 0.0]
    assert exchange.fmu.get("mode") == 5
    # each bounce is restitution^2 as high as the one before, down from 0.1 rad to the rounding of an angle
    assert exchange.entered <= 2 * math.log(1e-16) / math.log(restitution**2) + 4


# ---- what is read in continuous time ----


def slipping(make_model, values=None, tau=20.0):
    """In continuous time, in the middle of a motion."""
    fmu = make_model(FORWARD, kind=MODEL_EXCHANGE)
    fmu.start({"initial.theta": 0.6, "initial.omega": 4.0, "tau": tau} | (values or {}))
    fmu.settle()
    return fmu


def directional(fmu, unknowns, knowns, seed):
    result = (ctypes.c_double * len(unknowns))()
    model = fmu.model
    fmu.ok(
        "fmi2GetDirectionalDerivative", model.references(unknowns), len(unknowns), model.references(knowns),
        len(knowns), (ctypes.c_double * len(seed))(*seed), result,
    )  # fmt: skip
    return list(result)


@pytest.mark.parametrize("values", [{}, ELLIPSES | {"initial.theta": 0.6}], ids=["helices", "ellipses"])
@pytest.mark.parametrize("omega", [4.0, -3.0])
def test_directional_derivatives_are_those_of_the_rates(make_model, values, omega):
    fmu = slipping(make_model, values | {"initial.omega": omega})
    x = fmu.vector("fmi2GetContinuousStates", 2)

    def alpha(theta, speed, tau, F_ext):
        fmu.set_vector("fmi2SetContinuousStates", [theta, speed])
        fmu.set({"tau": tau, "F_ext": F_ext})
        return fmu.vector("fmi2GetDerivatives", 2)[1]

    here = [*x, 20.0, 0.0]
    for i, (name, h) in enumerate((("theta", 1e-3), ("omega", 1e-2), ("tau", 1e-1), ("F_ext", 1.0))):
        weights = {1: 3 / 4, 2: -3 / 20, 3: 1 / 60}  # the central difference of order 6
        difference = 0.0
        for k, weight in weights.items():
            for side in (1, -1):
                moved = list(here)
                moved[i] += side * k * h
                difference += side * weight * alpha(*moved) / h
        assert alpha(*here) == pytest.approx(fmu.get("alpha"), rel=1e-14)
        assert directional(fmu, ["omega", "alpha"], [name], [1.0]) == pytest.approx(
            [float(name == "omega"), difference], rel=1e-6, abs=1e-6
        )


def test_the_mode_is_frozen_between_events(make_model):
    """A solver tries states beyond an event; the equations go on smoothly there."""
    fmu = slipping(make_model)
    rate = {}
    for omega in (1e-6, -1e-6):
        fmu.set_vector("fmi2SetContinuousStates", [0.6, omega])
        rate[omega] = fmu.vector("fmi2GetDerivatives", 2)[1]
        assert fmu.get("mode") == 2
    assert rate[1e-6] == pytest.approx(rate[-1e-6], rel=1e-6)
    fmu.set({"tau": -50.0})
    assert fmu.get("mode") == 2
    fmu.set_vector("fmi2SetContinuousStates", [0.6, -1e-3])
    assert fmu.vector("fmi2GetEventIndicators", 7)[0] < 0.0
    fmu.ok("fmi2EnterEventMode")
    assert fmu.settle().valuesOfContinuousStatesChanged  # to rest, and at once the other way
    assert fmu.get("mode") == 3
    assert fmu.get("omega") == 0.0
    assert min(fmu.vector("fmi2GetEventIndicators", 7)) > 0.0


# ---- states by value reference: FMI 2.0.1, section 3.2.3, rule 5 ----


def test_states_by_value_reference_are_the_continuous_states(make_model):
    fmu, other = slipping(make_model), slipping(make_model)
    for theta, omega, tau in ((0.7, 3.0, 20.0), (0.2, -1.0, 5.0), (1.2, 0.0, -3.0), (50.0, 1e3, 0.0)):
        assert fmu.try_set({"theta": theta, "tau": tau, "omega": omega}) == OK
        other.set_vector("fmi2SetContinuousStates", [theta, omega])
        other.set({"tau": tau})
        assert fmu.everything() == other.everything()
    for name, value in (("theta", 0.4), ("omega", 2.0)):  # one alone leaves the other
        before = dict(zip(("theta", "omega"), fmu.vector("fmi2GetContinuousStates", 2), strict=True))
        fmu.set({name: value})
        assert fmu.vector("fmi2GetContinuousStates", 2) == list((before | {name: value}).values())


def test_states_by_value_reference_are_refused_elsewhere(make_model):
    """The whole call is refused, its input too; a state must be finite, and other outputs stay calculated."""
    stepping = make_model(FORWARD)
    calculated = ("theta", "calculated")
    stepping.refused_set({"theta": 0.5}, mentions=calculated)
    stepping.start()
    stepping.refused_set({"theta": 0.5}, mentions=calculated)
    fmu = slipping(make_model)
    fmu.refused_set({"tau": 3.0, "z": 0.01}, mentions=("z", "calculated"))
    for value in (math.nan, math.inf, -math.inf):
        fmu.refused_set({"tau": 3.0, "theta": value}, mentions=("theta",))
    fmu.refused_set({"omega": 1.0, "spring.stiffness": 1e4}, mentions=("spring.stiffness", "event mode"))
    fmu.ok("fmi2EnterEventMode")
    fmu.refused_set({"omega": 0.5}, mentions=("omega", "calculated"))


def test_a_solver_that_looks_far_beyond_a_stop_finds_finite_rates(make_model):
    for values in ({}, ELLIPSES | {"initial.theta": 0.6}):
        fmu = slipping(make_model, values)
        for theta, omega in itertools.product((-1e3, -0.01, 1.41, 50.0), (-1e3, 3.0)):
            fmu.set_vector("fmi2SetContinuousStates", [theta, omega])
            assert all(map(math.isfinite, fmu.vector("fmi2GetDerivatives", 2)))
            assert all(map(math.isfinite, fmu.vector("fmi2GetEventIndicators", 7)))


def test_landing_on_a_stop_and_bouncing_off(make_model):
    fmu = slipping(make_model, {"stop.restitution": 0.5}, tau=0.0)
    fmu.set_vector("fmi2SetContinuousStates", [1.3963 + 1e-9, 2.0])
    assert min(fmu.vector("fmi2GetEventIndicators", 7)) < 0.0
    fmu.ok("fmi2EnterEventMode")
    assert fmu.settle().valuesOfContinuousStatesChanged
    assert fmu.vector("fmi2GetContinuousStates", 2) == [1.3963, -1.0]
    assert fmu.get("mode") == 3


def test_the_accounts_are_not_kept(make_model):
    """They are integrals over steps, which are the solver's: of states are spring and kinetic energy."""
    fmu = make_model(FORWARD, kind=MODEL_EXCHANGE)
    Exchange(fmu, {"initial.omega": 3.0}, {"tau": lambda t: 5.0}).advance(0.0, 0.02)
    assert fmu.get("energy.spring") > 0.0
    assert fmu.get("energy.kinetic") > 0.0
    for name in fmu.model.names(causality=["local"]):
        if name.startswith(("energy.", "peak.")) and name not in ("energy.spring", "energy.kinetic"):
            assert fmu.get(name) == 0.0, name


@pytest.mark.parametrize("model", models.values(), ids=repr)
def test_nominals_are_those_of_the_xml(make_model, model):
    fmu = make_model(model, kind=MODEL_EXCHANGE)
    nominal = {"theta": 1.0, "omega": 10.0}
    states = STATES[model]
    assert fmu.vector("fmi2GetNominalsOfContinuousStates", states) == list(nominal.values())[:states]


# ---- states ----


def test_a_restored_state_repeats_bit_for_bit(make_model):
    fmu = slipping(make_model)
    state = fmu.take()
    seen = []
    for _ in range(2):
        fmu.restore(state)
        fmu.ok("fmi2SetTime", 0.1)
        fmu.set_vector("fmi2SetContinuousStates", [0.7, -1e-3])
        fmu.ok("fmi2EnterEventMode")
        fmu.settle()
        seen.append(fmu.everything())
    assert seen[0] == seen[1]
    fmu.free_state(state)


def test_a_state_of_co_simulation_is_refused(make_model):
    there = make_model(FORWARD, kind=CO_SIMULATION).start()
    here = slipping(make_model)
    state = there.take()
    here.refused("fmi2SetFMUstate", state, mentions=("co-simulation",))
    there.free_state(state)


# ---- the inverse FMU has no states: its outputs follow its inputs, and the direction changes at events ----


def test_inverse_keeps_its_direction_until_an_event(make_model):
    fmu = make_model(INVERSE, kind=MODEL_EXCHANGE)
    fmu.start({"theta": 0.5, "omega": 1.0})
    fmu.settle()
    loading = fmu.get("tau")
    assert fmu.vector("fmi2GetEventIndicators", 1)[0] > 0.0
    fmu.set({"omega": -1e-6})
    assert fmu.get("tau") == pytest.approx(loading, rel=1e-6)
    assert fmu.vector("fmi2GetEventIndicators", 1)[0] < 0.0
    fmu.ok("fmi2EnterEventMode")
    fmu.settle()
    assert fmu.get("tau") == pytest.approx(fmu.get("torque_release"), rel=1e-6)
    assert fmu.get("tau") < 0.9 * loading
    assert fmu.vector("fmi2GetEventIndicators", 1)[0] > 0.0


def swing(t):
    cos, sin = math.cos(6.0 * t), math.sin(6.0 * t)
    return {"theta": 0.6 - 0.5 * cos, "omega": 3.0 * sin, "alpha": 18.0 * cos}


@pytest.mark.parametrize("values", [{}, {"shaft.stiffness": 40.0}, ELLIPSES | {"initial.theta": None}])
def test_inverse_agrees_with_co_simulation(make_model, values):
    """At the end of each step; the accounts too, since the same motion was imposed."""
    values = {name: value for name, value in values.items() if value is not None}
    exchange, whole = make_model(INVERSE, kind=MODEL_EXCHANGE), make_model(INVERSE)
    for fmu in (exchange, whole):
        fmu.start(values | swing(0.0))
    exchange.settle()
    enter, end = ctypes.c_int(), ctypes.c_int()
    for k in range(1, 101):
        t = k * 0.01
        whole.step(0.01, **swing(t))
        exchange.ok("fmi2SetTime", t)
        exchange.set(swing(t))
        exchange.ok("fmi2CompletedIntegratorStep", 1, ctypes.byref(enter), ctypes.byref(end))
        if exchange.vector("fmi2GetEventIndicators", 1)[0] <= 0.0:
            exchange.ok("fmi2EnterEventMode")
            exchange.settle()
        for name in ("tau", "z", "v", "energy.work_in", "energy.heat_cam1", "energy.residual", "events"):
            assert exchange.get(name) == pytest.approx(whole.get(name), rel=1e-9, abs=1e-9), (name, t)


# ---- bad calls ----


@pytest.mark.parametrize("missing", [[], ["damper.c_load"]], ids=["play", "viscous"])
def test_without_inertia_there_is_no_model_exchange(make_model, missing):
    fmu = make_model(FORWARD, kind=MODEL_EXCHANGE)
    assert "inertia" in fmu.refused_start({"inertia.shaft": 0.0} | dict.fromkeys(missing, 10.0))
    fmu.set({"inertia.shaft": 0.001})
    fmu.ok("fmi2ExitInitializationMode")


def test_states_of_impossible_parameters_do_not_exist(make_model):
    fmu = make_model(FORWARD, kind=MODEL_EXCHANGE)
    fmu.set({"stop.upper": -1.0})
    fmu.ok("fmi2EnterInitializationMode")
    room = (ctypes.c_double * 7)()
    for function, n in (("GetContinuousStates", 2), ("GetDerivatives", 2), ("GetEventIndicators", 7)):
        fmu.refused(function, room, n, mentions=("stop.upper",))
    fmu.set({"stop.upper": 1.0})
    assert fmu.vector("GetContinuousStates", 2) == [0.0, 0.0]


@pytest.mark.parametrize("model", models.values(), ids=repr)
def test_vectors_of_another_length_are_refused(make_model, model):
    fmu = make_model(model, kind=MODEL_EXCHANGE)
    fmu.start()
    fmu.settle()
    room = (ctypes.c_double * 20)()
    counts = {"fmi2GetEventIndicators": INDICATORS[model]}
    for function in ("fmi2SetContinuousStates", "fmi2GetContinuousStates", "fmi2GetDerivatives",
                     "fmi2GetNominalsOfContinuousStates", "fmi2GetEventIndicators"):  # fmt: skip
        right = counts.get(function, STATES[model])
        for n in (right + 1, max(right - 1, 0), 2**63):
            if n != right:
                fmu.refused(function, room, n, mentions=(str(right),))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_bad_states_and_times_are_refused(make_model, bad):
    fmu = slipping(make_model)
    fmu.refused("fmi2SetContinuousStates", (ctypes.c_double * 2)(0.5, bad), 2, mentions=("omega",))
    fmu.refused("fmi2SetContinuousStates", (ctypes.c_double * 2)(bad, 0.5), 2, mentions=("theta",))
    fmu.refused("fmi2SetTime", bad, mentions=("time",))
    fmu.refused_set({"tau": bad}, mentions=("tau",))


def test_a_ramp_needs_too_many_steps_of_cvode_in_fmpy():
    """As docs/use-model-exchange.md says: 500 steps do not reach the next output, 5 ms later."""
    torque = np.array([(0.0, 0.0), (1.0, 10.0), (2.0, 0.0)], dtype=[("time", float), ("tau", float)])
    with pytest.raises(Exception, match="mxstep steps taken before reaching tout"):
        simulate_fmu(
            str(models["DualCamForward"].fmu), fmi_type="ModelExchange", stop_time=2.0, output_interval=5e-3,
            input=torque, output=["theta"],
        )  # fmt: skip
