"""Without inertia the damper can hold the pin on flanks on which the spring's load does not press any more
(docs/mechanism.md, section 6): rest begins where the torque is back inside the stick band."""

import math

import pytest
from reference import STICK, Interval, simulate

LOCKING = {  # both contacts lock: the band holds torques of both signs
    **{f"cam{i}.{name}": value for i in (1, 2) for name, value in (("lead_angle", 0.1), ("friction", 0.2))},
    "inertia.shaft": 0.0,
    "damper.c_load": 2000.0,
    "damper.c_release": 2000.0,
    "initial.theta": 0.1,
    "spring.preload": 1.0,
    "spring.stiffness": 10.0,
    "stop.upper": 50.0,
    "stop.lower": -50.0,
}
ELLIPSES = {
    "cam1.profile": 2,
    "cam1.radius": 0.02,
    "cam1.lead_angle": 0.1,
    "cam1.ellipse_a": 2.0,
    "cam1.ellipse_b": 0.3,
}
GROOVES = {
    "helices": {},
    "nonlinear spring": {"spring.stiffness2": 1e-3},
    "ellipse and helix": ELLIPSES | {"stop.upper": 12.0, "stop.lower": -1.0},
}


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("pieces", [1, 2, 7, 300])
@pytest.mark.parametrize("grooves", GROOVES)
def test_axial_load_changes_its_sign_in_the_step(make, grooves, pieces, direction):
    """F_ext falls through the spring's force. The damper's load then keeps the flanks, and the mirrored band
    widens until it holds the torque: the speed ends with a jump."""
    parameters = LOCKING | GROOVES[grooves]
    if direction < 0:
        parameters = parameters | {"initial.theta": 4.0 if grooves != "ellipse and helix" else 8.0}
    duration = 0.1
    tau, start, rate = direction * 0.2, direction * 20.0, direction * -3000.0
    (wanted,) = simulate(parameters, [Interval(duration, tau, F_ext=start, F_ext_rate=rate)])
    fmu = make().start(parameters | {"tau": tau, "F_ext": start})
    for k in range(pieces):
        fmu.set({"F_ext": start + rate * duration * k / pieces})
        fmu.set_rates(F_ext=rate)
        fmu.step(duration / pieces)
    assert wanted.mode == STICK and not wanted.doubts
    assert abs(wanted.theta - parameters["initial.theta"]) > 1.0
    assert (fmu.get("mode"), fmu.get("omega"), fmu.get("events")) == (STICK, 0.0, wanted.events)
    assert fmu.get("theta") == pytest.approx(wanted.theta, rel=1e-8)
    assert fmu.get("energy.work_in") == pytest.approx(wanted.value("energy.work_in"), rel=1e-8)


@pytest.mark.parametrize("F_ext, rests", [(-1000.0, True), (-200.0, False)])
def test_axial_load_jumps_over_the_band(make, F_ext, rests):
    """Between two steps F_ext turns the axial load around. The mirrored band reaches up to
    |F_0| r tan(atan(mu) - lambda)/2: beyond tau at the larger load, below tau at the smaller one."""
    parameters = LOCKING | GROOVES["nonlinear spring"] | {"tau": 0.2, "F_ext": 20.0}
    fmu = make().start(parameters)
    for _ in range(3):
        fmu.step(0.001)
    theta, load = fmu.get("theta"), abs(F_ext + 1.0 + 10.0 * fmu.get("z"))
    assert fmu.get("omega") > 0.0
    assert (0.5 * load * 0.02 * math.tan(math.atan(0.2) - 0.1) > 0.2) == rests
    fmu.set({"F_ext": F_ext})
    fmu.step(0.001)
    assert (fmu.get("theta") == theta) == (fmu.get("omega") == 0.0) == rests
    assert (fmu.get("mode") == STICK) == rests
