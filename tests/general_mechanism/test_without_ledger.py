"""Without accounts (`ledger` false) the motion is the same bit for bit; other cases that few scenes reach."""

import math

import pytest
from driver import ERROR

ELLIPSES = {"cam1.profile": 2, "cam2.profile": 2, "stop.upper": 0.6}
REGIMES = {
    "inertial": {},
    "viscous": {"inertia.shaft": 0.0, "damper.c_load": 200.0, "damper.c_release": 300.0},
    "rate-independent": {"inertia.shaft": 0.0},
}
GROOVES = {"helices": {}, "ellipses": ELLIPSES}
ACCOUNTS = ["work_in", "spring", "heat_cam1", "heat_cam2", "heat_damper", "work_tuning"]


def play(fmu, parameters):
    """Torque up to the stop and back, a softer spring on the way; angle, speed and mode after each step."""
    fmu.start(parameters | {"tau": 0.0})
    seen = []
    for k in range(40):
        if k == 25:
            fmu.set({"spring.stiffness": 45e3, "cam2.friction": 0.16})
        fmu.step(2e-3, tau=12.0 * math.sin(math.pi * k / 39.0))
        seen.append([fmu.get(name) for name in ("theta", "omega", "mode", "events", "z")])
    return seen


@pytest.mark.parametrize("grooves", GROOVES)
@pytest.mark.parametrize("regime", REGIMES)
def test_the_motion_is_the_same_without_accounts(make, regime, grooves):
    parameters = REGIMES[regime] | GROOVES[grooves]
    kept, bare = make(), make()
    motion = play(kept, parameters)
    assert play(bare, parameters | {"ledger": False}) == motion
    assert len({row[2] for row in motion}) >= 3  # modes
    assert kept.get("energy.heat_cam1") > 0.0 and kept.get("peak.torque") > 0.0
    assert [bare.get(f"energy.{name}") for name in ACCOUNTS if name != "spring"] == [0.0] * (
        len(ACCOUNTS) - 1
    )
    assert [bare.get(name) for name in ("peak.torque", "peak.omega", "peak.reaction1")] == [0.0, 0.0, 0.0]


def test_efficiency_without_friction_and_where_a_cam_locks(make):
    no_friction = {"cam1.friction": 0.0, "cam2.friction": 0.0}
    assert make().start(no_friction).get("efficiency") == pytest.approx(1.0, rel=1e-14)
    one = make().start({"cam1.friction": 0.0})
    expected = one.get("torque_release") / one.get("torque_load")
    assert 0.0 < expected < 1.0
    assert one.get("efficiency") == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize("name", ["tau", "F_ext"])
def test_an_input_that_overflows_within_the_step_is_refused(make, name):
    fmu, other = make().start({"tau": 3.0}), make().start({"tau": 3.0})
    for one in (fmu, other):
        one.step(0.01)
    before = fmu.everything()
    fmu.set_derivatives({name: [1e308]})
    assert fmu.call("DoStep", fmu.time, 1e3, True) == ERROR
    assert all(word in fmu.messages[-1].text for word in (name, "not finite", "1e+308"))
    assert fmu.everything() == before
