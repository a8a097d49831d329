"""The judge of cuts (tests/support/cut_dependence.py) sees what it looks for."""

import random
from dataclasses import replace

import pytest
from cut_dependence import NUDGE, Outcome, Scene, judge, nudged
from driver import Driver

PARAMETERS = {"cam1.friction": 0.1, "cam2.friction": 0.2, "spring.preload": 100.0, "spring.stiffness": 1e4}
PARAMETERS |= {"spring.stiffness2": 0.0, "spring.stiffness3": 0.0, "stop.lower": 0.0, "stop.upper": 1.2}
PARAMETERS |= {"cam1.radius": 0.02, "cam2.radius": 0.03, "cam1.lead_angle": 0.6, "cam2.lead_angle": 0.7}
PARAMETERS |= {"cam1.profile": 1, "cam2.profile": 1, "inertia.shaft": 1e-3, "inertia.follower_mass": 0.0}
PARAMETERS |= {"inertia.follower": 0.0, "initial.theta": 0.3}
SCENE = Scene(PARAMETERS, [(0.02, [1.5], [0.0]), (0.03, [0.2, 1.0], [10.0])], [0.3, 0.7])


class CountingDriver(Driver):
    """An FMU whose angle is larger by `drift` after each step."""

    drift = 0.0

    def __init__(self, library):
        super().__init__(library)
        self.steps = 0

    def call(self, function, *arguments):
        self.steps += function == "fmi2DoStep"
        return super().call(function, *arguments)

    def get(self, name):
        return super().get(name) + (self.drift * self.steps if name == "theta" else 0.0)


@pytest.mark.parametrize(("drift", "outcome"), [(0.0, Outcome.AGREES), (1e-4, Outcome.DEPENDS)])
def test_a_drift_with_each_step_is_found(library, drift, outcome):
    made = []

    def make():
        made.append(CountingDriver(library))
        made[-1].drift = drift
        return made[-1]

    verdict = judge(make, SCENE)
    for fmu in made:
        fmu.free()
    assert verdict.outcome is outcome
    assert ("theta after interval 0" in verdict.text) is (outcome is Outcome.DEPENDS)


def test_each_number_of_a_nudge_has_its_own_sign():
    scene = nudged(SCENE, random.Random(1))
    floats = [name for name, value in PARAMETERS.items() if isinstance(value, float) and value]
    shares = {name: scene.parameters[name] / PARAMETERS[name] - 1.0 for name in floats}
    assert 0.0 < abs(shares.pop("stop.upper")) < 1e-15  # a place: by a rounding
    assert all(abs(share) == pytest.approx(NUDGE, rel=1e-6) for share in shares.values())
    assert {share > 0.0 for share in shares.values()} == {True, False}
    assert scene.parameters["cam1.profile"] == 1


def test_the_start_stays_between_nudged_stops():
    """The start at a stop is nudged with the stop: a motion leaves an unstable balance by this rounding."""
    for number in range(8):
        at_stop = replace(SCENE, parameters=PARAMETERS | {"initial.theta": 0.0})
        values = nudged(at_stop, random.Random(number)).parameters
        assert values["stop.lower"] != 0.0
        assert values["initial.theta"] == max(0.0, values["stop.lower"])
