"""Model exchange: a solver has to restart after each event, also where no state has a new value
(docs/use-model-exchange.md)."""

import numpy as np
import pytest
from driver import FORWARD, MODEL_EXCHANGE
from fmpy import simulate_fmu
from fmpy.fmi2 import FMU2Model
from fmpy.sundials import CVodeSolver

JUMPS = [(0.0, 2.0), (0.5, 2.0), (0.5, 5.0), (1.0, 5.0), (1.0, 1.0), (2.0, 1.0)]  # s, N.m
STICK, LOADING = 1, 2


def test_breakaway_gives_no_state_a_new_value_and_says_so(make_model):
    """FMI 2.0.5, section 3.2.2: valuesOfContinuousStatesChanged must be false then."""
    fmu = make_model(FORWARD, kind=MODEL_EXCHANGE)
    fmu.start({"initial.theta": 0.6, "tau": 3.0})
    fmu.settle()
    assert fmu.get("mode") == STICK
    fmu.set({"tau": 20.0})
    fmu.ok("fmi2EnterEventMode")
    assert not fmu.settle().valuesOfContinuousStatesChanged
    assert fmu.get("mode") == LOADING


def angles(kind):
    torque = np.array(JUMPS, dtype=[("time", float), ("tau", float)])
    settings = {"fmi_type": kind, "stop_time": 2.0, "output_interval": 0.01, "record_events": False}
    return simulate_fmu(str(FORWARD.fmu), **settings, input=torque, output=["theta"])["theta"]


@pytest.mark.parametrize(("restarts", "least", "largest"), [("always", 0.0, 1e-6), ("by the flag", 0.7, 0.9)])
def test_cvode_goes_wrong_where_it_restarts_by_the_flag_alone(monkeypatch, restarts, least, largest):
    """The page names 0.8 rad."""
    flags, update, reset = [True], FMU2Model.newDiscreteStates, CVodeSolver.reset

    def settle(model):
        found = update(model)
        flags.append(bool(found[3]))
        return found

    def perhaps(solver, time):
        if restarts == "always" or flags[-1]:
            reset(solver, time)

    monkeypatch.setattr(FMU2Model, "newDiscreteStates", settle)
    monkeypatch.setattr(CVodeSolver, "reset", perhaps)
    assert least <= abs(angles("ModelExchange") - angles("CoSimulation")).max() < largest
