"""FMI 3.0: contacts that jam while cam 2 moves, at an event of the master and within a step.

Under a pull (F < 0) loading is locked. A pull that begins while cam 2 loads stops the motion at once. Its
kinetic energy becomes heat of the contacts."""

import math

import pytest
from mechanisms import INERTIA

PRELOAD = 50.0
SLOPE = tuple(0.02 * math.tan(lead) for lead in (0.44, 0.58))
LIFT = SLOPE[0] * SLOPE[1] / sum(SLOPE)
PARAMETERS = {
    "cam1.lead_angle": 0.44, "cam2.lead_angle": 0.58, "cam1.friction": 3.0, "cam2.friction": 0.17,
    "spring.preload": PRELOAD, "spring.stiffness": 0.0, "stop.upper": 10.0, "initial.omega": 4.0,
}  # fmt: skip


def heat(fmu):
    return fmu.get("energy.heat_cam1") + fmu.get("energy.heat_cam2")


@pytest.mark.parametrize("tau", [1.0, 2.0])
def test_a_pull_set_in_event_mode_stops_cam_2(make3, tau):
    fmu = make3(events=True).start(PARAMETERS)
    fmu.step(0.01, tau=tau)
    omega, before = fmu.get("omega"), heat(fmu)
    kinetic = fmu.get("energy.kinetic")
    assert omega > 0.0 and kinetic == pytest.approx(0.5 * INERTIA * omega**2, rel=1e-14)
    fmu.ok("EnterEventMode")
    fmu.set({"F_ext": -2.0 * PRELOAD})
    fmu.settle()
    assert fmu.get("omega") == fmu.get("energy.kinetic") == 0.0
    assert heat(fmu) - before == pytest.approx(kinetic, rel=1e-12)
    fmu.ok("EnterStepMode")
    theta = fmu.get("theta")
    fmu.step(0.01)
    assert (fmu.get("theta"), fmu.get("omega")) == (theta, 0.0)


@pytest.mark.parametrize("options", [{}, {"events": True}, {"events": True, "early": True}], ids=str)
def test_a_jam_within_a_step_is_one_event_with_the_rest_after_it(make3, options):
    """A spring that weakens with the height: F is zero at theta = 0.6, where loading locks. tau alone then
    holds cam 2 there: the work is tau times the angle, all of it heat but for the energy of the spring."""
    free, tau = 0.6, 2.0
    weak = {"spring.stiffness2": -PRELOAD / (LIFT * free) ** 2}
    fmu = make3(**options).start(PARAMETERS | weak)
    event, early = fmu.step(1.0, tau=tau)
    assert fmu.get("theta") == pytest.approx(free, rel=1e-8)
    assert (fmu.get("omega"), event, early) == (0.0, event, "early" in options)
    stored = LIFT * PRELOAD * free * 2.0 / 3.0
    first = 0.5 * INERTIA * PARAMETERS["initial.omega"] ** 2
    assert fmu.get("energy.work_in") == pytest.approx(tau * free, rel=1e-8)
    assert heat(fmu) == pytest.approx(tau * free + first - stored, rel=1e-8)
