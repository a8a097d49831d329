"""FMI 3.0: intermediate update."""

import math
from ctypes import byref, c_bool, c_double

import driver as fmi2
import pytest
from driver import ERROR
from fmi3_scenes import BOUNCING, ELLIPSES, GENERAL, events_of, frequency, wave
from mechanisms import PRELOAD, RHO
from reference import LOADING, STICK


def test_intermediate_update_is_at_each_change_and_at_the_end(make3):
    seen = []

    def look(fmu, time, asks, may_read, finished, may_end):
        assert (asks, may_read, finished) == (False, True, True)
        assert fmu.get("time") == time
        seen.append((time, fmu.get("mode"), fmu.get("theta"), fmu.get("energy.residual"), may_end))

    fmu = make3(update=look, required=("theta",)).start(BOUNCING)
    plain = make3(events=True, early=True).start(BOUNCING)
    changes = []
    for k in range(10):
        torque = wave(0.05 * k)
        seen.clear()
        assert fmu.step(0.05, tau=torque) == (False, False)
        changes = events_of(plain, plain.time + 0.05, 0.05, lambda _, torque=torque: torque)
        inner = [(time, mode) for time, mode in changes if time < fmu.time - 1e-9]
        assert [mode for _, mode, *_ in seen[:-1]] == [mode for _, mode in inner]
        assert [time for time, *_ in seen[:-1]] == pytest.approx([time for time, _ in inner], rel=1e-12)
        assert seen[-1][0] == fmu.time and seen[-1][2] == fmu.get("theta")
        assert all(abs(residual) < 1e-13 and not may_end for *_, residual, may_end in seen)


def test_looking_on_changes_nothing(make3):
    fmu, plain = make3(update=lambda *_: None).start(GENERAL), make3().start(GENERAL)
    for k in range(20):
        for one in (fmu, plain):
            one.step(0.05, tau=wave(0.05 * k))
    assert fmu.everything() == plain.everything()
    assert fmu.get("events") > 20


@pytest.mark.parametrize(
    ("wanted", "ends"), [(-1.0, 0.0), (0.02, 0.02), (9.0, 0.2 - 0.054), (math.nan, 0.0), (math.inf, 0.146)]
)
def test_a_master_may_end_the_step(make3, wanted, ends):
    """At the first change, at pi/w = 0.0546 s, it asks to end `wanted` later; what is past is at once."""
    rest = math.pi / frequency(1)
    asked = []

    def look(_fmu, time, _asks, _may_read, _finished, may_end):
        if not may_end:
            return None
        asked.append(time)
        return time + wanted

    fmu = make3(update=look, early=True).start()
    event, early = fmu.step(0.2, tau=2.0)
    assert asked == [pytest.approx(rest, rel=1e-13)]
    assert not event and early == (ends < 0.1)
    assert fmu.time == pytest.approx(rest + ends if early else 0.2, rel=1e-13)
    other = make3().start()
    other.step(fmu.time, tau=2.0)
    assert fmu.get("theta") == other.get("theta")
    assert fmu.step(0.2 - 0.05) == (False, False)


def test_a_request_to_end_counts_only_where_it_may(make3):
    fmu = make3(update=lambda _fmu, time, *_: time).start()
    assert fmu.step(0.2, tau=2.0) == (False, False)
    assert fmu.time == 0.2


def cubic(t: float) -> float:
    return 1.0 + 40.0 * t - 300.0 * t**2 + 600.0 * t**3


def test_inputs_given_inside_a_step_are_cubics(make_model, make3):
    """As FMI 2.0's derivatives of inputs."""
    times = []

    def give(fmu, time, asks, may_read, finished, _may_end):
        assert may_read == finished == (not asks)
        if asks:
            times.append(time)
            fmu.set({"tau": cubic(time), "F_ext": 10.0 * time})

    for scene, tolerance in ((ELLIPSES, 1e-10), ({"inertia.shaft": 0.0}, 1e-12), ({}, 1e-8)):
        new, old = (
            make3(update=give, required=("tau", "F_ext", "theta")).start(scene),
            make_model(fmi2.FORWARD),
        )
        old.start(scene)
        for k in range(6):
            t, times[:] = 0.05 * k, []
            new.step(0.05, tau=cubic(t), F_ext=10.0 * t)
            assert times == pytest.approx([t + 0.05 / 3, t + 0.1 / 3, t + 0.05], rel=1e-14)
            rates = [40.0 - 600.0 * t + 1800.0 * t**2, -600.0 + 3600.0 * t, 3600.0]
            old.set({"tau": cubic(t), "F_ext": 10.0 * t})
            old.set_derivatives({"tau": rates, "F_ext": [10.0]})
            old.step(0.05)
            for name in ("theta", "omega", "energy.work_in"):
                assert new.get(name) == pytest.approx(old.get(name), rel=tolerance, abs=tolerance)
            assert new.get("tau") == pytest.approx(cubic(t + 0.05), rel=1e-12)
        assert new.get("theta") > 0.05


def test_a_ramp_given_inside_a_step_is_one_to_rounding(make_model, make3):
    """It stays the closed form, as a constant does, bit for bit."""
    slope = 30.0
    new = make3(
        update=lambda f, t, asks, *_: f.set({"tau": slope * t}) if asks else None, required=("tau",)
    ).start()
    old = make_model(fmi2.FORWARD).start()
    for k in range(3):
        new.step(0.025, tau=slope * 0.025 * k)
        old.set({"tau": slope * 0.025 * k})
        old.set_rates(tau=slope)
        old.step(0.025)
    assert new.get("theta") == pytest.approx(old.get("theta"), rel=1e-13) and new.get("theta") > 0.1
    constant, plain = make3(update=lambda *_: None, required=("tau",)).start(), make3().start()
    for one in (constant, plain):
        one.step(0.3, tau=2.0)
    assert constant.everything() == plain.everything()


def test_a_sampled_step_with_events_ends_early(make3):
    """A ramp: at rest until tau reaches T_load at z = 0."""
    slope = 10.0
    fmu = make3(
        update=lambda f, t, asks, *_: f.set({"tau": slope * t}) if asks else None,
        required=("tau",), events=True, early=True,
    ).start()  # fmt: skip
    assert fmu.step(1.0) == (True, True)
    # on the lower stop the torque first comes into the stick band, then leaves it
    assert fmu.get("mode") == STICK
    assert fmu.time == pytest.approx(RHO[-1] * PRELOAD / slope, rel=1e-12)
    assert fmu.get("tau") == pytest.approx(slope * fmu.time, rel=1e-12)
    fmu.handle_event()
    fmu.step(1.0)
    assert fmu.get("mode") == LOADING and fmu.time == pytest.approx(RHO[1] * PRELOAD / slope, rel=1e-12)


def test_bad_inputs_inside_a_step_are_refused(make3):
    def give(fmu, _time, asks, *_):
        if asks:
            assert fmu.try_set({"tau": math.nan}) == ERROR
            assert "tau" in fmu.messages[-1].text

    fmu, plain = make3(update=give, required=("tau",)).start(), make3().start()
    for one in (fmu, plain):
        one.step(0.2, tau=2.0)
    assert len(fmu.messages) == 3
    assert fmu.everything() == plain.everything()


def test_a_refused_step_with_visits_changes_nothing(make3):
    """Nothing resists on a dwell: the step is refused after the master has given inputs."""
    fmu = make3(update=lambda f, _t, asks, *_: f.set({"tau": 1e308}) if asks else None, required=("tau",))
    fmu.start()
    before = fmu.everything()
    flags, number = [c_bool() for _ in range(3)], c_double()
    fmu.set({"tau": -1e308})
    expected = fmu.everything()
    assert fmu.call("DoStep", 0.0, 1e-3, True, *map(byref, flags), byref(number)) == ERROR
    assert "finite" in fmu.messages[-1].text
    assert fmu.everything() == expected
    fmu.set({"tau": 0.0})
    assert fmu.everything() == before
