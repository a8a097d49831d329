"""FMI 3.0: states, derivatives and event indicators of model exchange."""

import math
from ctypes import byref, c_bool, c_double, c_size_t

import driver3
import pytest
from driver3 import FORWARD, INVERSE
from fmi3_scenes import FORCES, each_model
from mechanisms import INERTIA, LIFT, PRELOAD, RHO, STIFFNESS


def test_states_rates_and_indicators(make3):
    fmu = make3(exchange=True).initialize({"initial.theta": 0.3, "tau": 4.0})
    numbers = [c_size_t(), c_size_t()]
    fmu.ok("GetNumberOfContinuousStates", byref(numbers[0]))
    fmu.ok("GetNumberOfEventIndicators", byref(numbers[1]))
    assert [n.value for n in numbers] == [2, 7]
    assert fmu.settle()["moved"] is False
    fmu.ok("EnterContinuousTimeMode")
    fmu.ok("SetTime", 0.5)
    assert fmu.get("time") == 0.5
    fmu.ok("SetContinuousStates", driver3.reals([0.31, 2.0]), 2)
    states, rates, nominals, indicators = [(c_double * n)() for n in (2, 2, 2, 7)]
    fmu.ok("GetContinuousStates", states, 2)
    fmu.ok("GetContinuousStateDerivatives", rates, 2)
    fmu.ok("GetNominalsOfContinuousStates", nominals, 2)
    fmu.ok("GetEventIndicators", indicators, 7)
    assert list(states) == [0.31, 2.0] and list(nominals) == [1.0, 10.0]
    alpha = (4.0 - RHO[1] * (PRELOAD + STIFFNESS * LIFT * 0.31)) / INERTIA
    assert list(rates) == [2.0, pytest.approx(alpha, rel=1e-13)]
    assert fmu.get("alpha") == pytest.approx(alpha, rel=1e-13)
    listed = [u.attrib["valueReference"] for u in FORWARD.document.iter("EventIndicator")]
    names = {str(v.reference): n for n, v in FORWARD.variables.items()}
    assert [fmu.get(names[reference]) for reference in listed] == list(indicators)
    assert fmu.get("indicator.velocity") == pytest.approx(2.0, abs=1e-9)
    assert fmu.get("indicator.upper_stop") == pytest.approx(1.3963 - 0.31, abs=1e-9)
    assert fmu.get("indicator.lower_stop") == fmu.get("indicator.load") == 1.0
    fmu.ok("SetContinuousStates", driver3.reals([0.31, -1e-3]), 2)
    assert fmu.get("indicator.velocity") < 0.0
    flags = [c_bool(True), c_bool(True)]
    fmu.ok("CompletedIntegratorStep", True, *map(byref, flags))
    assert not any(flag.value for flag in flags)
    fmu.ok("EnterEventMode")
    assert fmu.settle()["moved"] is True
    assert fmu.get("omega") == 0.0
    other = make3(INVERSE, exchange=True).initialize()
    other.ok("GetNumberOfContinuousStates", byref(numbers[0]))
    other.ok("GetNumberOfEventIndicators", byref(numbers[1]))
    assert [n.value for n in numbers] == [0, 1]


@each_model
def test_indicators_depend_on_what_the_structure_says(make3, model):
    """In model exchange, over modes and states: of the rest the derivative is zero."""
    known = {
        name: set(make3(model).dependencies(name)) for name in model.variables if name.startswith("indicator")
    }
    seen: dict = {name: set() for name in known}
    inputs = model.names(causality=["input"])
    for theta, omega, tau in ((0.3, 3.0, 5.0), (0.3, -3.0, 0.0), (0.3, 0.0, 2.5)):
        fmu = make3(model, exchange=True)
        values = {"initial.theta": theta, "initial.omega": omega, "tau": tau}
        fmu.initialize(values | FORCES if model is FORWARD else {"theta": theta, "omega": omega, **FORCES})
        fmu.settle()
        fmu.ok("EnterContinuousTimeMode")
        before = {name: fmu.get(name) for name in known}

        def note(changed, before=before, fmu=fmu):
            for name in known:
                if abs(fmu.get(name) - before[name]) > 1e-9:
                    seen[name].add(changed)

        for name in inputs:
            value = fmu.get(name)
            fmu.set({name: value + 1e-3})
            note(name)
            fmu.set({name: value})
        for state, change in (("theta", (1e-4, 0.0)), ("omega", (0.0, 1e-3))) if model is FORWARD else ():
            for sign in (1, 0):
                values = [theta + sign * change[0], omega + sign * change[1]]
                fmu.ok("SetContinuousStates", driver3.reals(values), 2)
                if sign:
                    note(state)
    assert seen == known


def test_states_by_value_reference_are_the_continuous_states(make3):
    """FMI 3.0.2, section 3.2: in continuous-time mode alone."""
    fmu, other = (make3(exchange=True).initialize({"initial.omega": 1.0, "tau": 20.0}) for _ in range(2))
    fmu.refused_set({"theta": 0.5}, mentions=("theta", "calculated"))
    for each in (fmu, other):
        each.settle()
        each.ok("EnterContinuousTimeMode")
    for theta, omega, tau in ((0.7, 3.0, 20.0), (0.2, -1.0, 5.0), (50.0, 1e3, 0.0)):
        assert fmu.try_set({"theta": theta, "tau": tau, "omega": omega}) == 0
        other.ok("SetContinuousStates", driver3.reals([theta, omega]), 2)
        other.set({"tau": tau})
        assert fmu.everything() == other.everything()
    fmu.refused_set({"tau": 1.0, "omega": math.nan}, mentions=("omega",))
    fmu.refused_set({"theta": 1.0, "v": 1.0}, mentions=("v", "calculated"))


def test_indicators_that_are_no_numbers_are_refused(make3):
    """The axial force is infinite, and the edge of the stick band less the torque no number."""
    fmu = make3(exchange=True).initialize({"cam1.profile": 2, "cam2.profile": 2, "stop.upper": 0.6})
    fmu.settle()
    fmu.set({"F_ext": -1.7e308, "spring.preload": -1.7e308, "tau": -1e308})
    fmu.refused("GetEventIndicators", (c_double * 7)(), 7, mentions=("element 1 is no number",))
    fmu.set({"F_ext": 0.0})
    fmu.ok("GetEventIndicators", (c_double * 7)(), 7)
