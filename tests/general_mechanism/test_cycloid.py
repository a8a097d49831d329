"""A cycloidal groove in motion, from its level start on."""

import pytest
from reference import HEATS, Interval, simulate

CYCLOID = {
    "cam1.profile": 4,
    "cam1.cycloid_rise": 0.018,
    "cam1.cycloid_angle": 1.1,
    "cam2.radius": 0.025,
    "cam2.lead_angle": 0.6,
    "cam2.friction": 0.1,
    "spring.stiffness": 2e4,
    "spring.stiffness3": 1e7,
    "stop.upper": 1.6,
}
HEAVY = {
    "inertia.follower_mass": 0.4,
    "inertia.follower": 1e-4,
    "shaft.damping": 0.01,
    "damper.c_load": 30.0,
    "damper.q_release": 40.0,
}
SWAPPED = {f"cam{3 - int(n[3])}{n[4:]}" if n.startswith("cam") else n: v for n, v in CYCLOID.items()}
GROOVES = {"cam 1": CYCLOID, "cam 2": SWAPPED}
SCENES = {"inertia": {}, "all forces": HEAVY, "without inertia": {"inertia.shaft": 0.0}}
INTERVALS = [
    Interval(0.05, 9.0),
    Interval(0.1, 14.0, tau_rate=-250.0),
    Interval(0.08, -3.0, F_ext=15.0, F_ext_rate=100.0),
    Interval(0.2, 6.0, tau_rate=30.0, F_ext=-10.0),
]


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("cam", GROOVES)
def test_up_and_back(make, cam, scene):
    parameters = GROOVES[cam] | SCENES[scene]
    wanted = simulate(parameters, INTERVALS)
    assert max(point.theta for point in wanted) > 1.0 and min(point.theta for point in wanted) < 0.5
    first = {"tau": INTERVALS[0].tau, "F_ext": INTERVALS[0].F_ext}
    fmu = make().start(parameters | first, tolerance=1e-11)
    for interval, point in zip(INTERVALS, wanted, strict=True):
        fmu.set({"tau": interval.tau, "F_ext": interval.F_ext})
        fmu.set_rates(tau=interval.tau_rate, F_ext=interval.F_ext_rate)
        fmu.step(interval.duration)
        assert (fmu.get("mode"), fmu.get("events")) == (point.mode, point.events)
        for name in ("theta", "z", *(f"energy.{heat}" for heat in HEATS)):
            assert fmu.get(name) == pytest.approx(point.value(name), rel=1e-8, abs=1e-10), name
        assert fmu.get("omega") == pytest.approx(point.omega, rel=1e-8, abs=1e-8)
