"""The FMU against the independent reference, over random scenes with helical grooves.

Every scene is solved in closed form at 60 digits (reference.simulate_exact) and driven through the FMU with
communication steps cut at random. Allowed error: 1e-11 of the scene's largest angle, speed, account.

Where the reference itself stands within rounding of a switch (Point.doubts: a train of bounces that fades
out, a speed that has died away, an event at the very end of an interval) the count of mode changes is a
matter of rounding, and is not compared in that interval and the next; what is measured still is.
"""

import math
from itertools import pairwise

import numpy as np
import pytest
from driver import Driver
from general_scenes import FADING, MEASURED, STILL, nudged, scales, wrong_modes
from reference import INTEGERS, Point, Refused, random_scene, simulate_exact

TOLERANCE = 1e-11
WORST = 1e-7  # where the last digit of the data is amplified that much; see ulp_response
CHUNKS, SCENES = 24, 10  # 240 scenes
AMBIGUOUS = "several flank pairs are consistent"  # no unique motion (Painleve's paradox)


def well_posed_scenes(chunk):
    """Random scenes that have one answer: not wedged while moving, no paradox."""
    found = 0
    for number in range(10 * SCENES):
        params, intervals = random_scene(np.random.default_rng([chunk, number]))
        try:
            exact = simulate_exact(params, intervals)
        except Refused:
            continue
        if any(AMBIGUOUS in point.doubts for point in exact):
            continue
        yield f"scene {chunk}, {number}", params, intervals, exact
        found += 1
        if found == SCENES:
            return


def cuts(rng, duration):
    """Times at which the interval is cut; steps of about 0.1 ms to 1 s."""
    most = max(1, int(duration / 1e-4))
    steps = min(most, int(rng.choice([1, 1, 2, 5, 20, 100])))
    return [0.0, *np.sort(rng.uniform(0.0, duration, steps - 1)), duration]


def drive(fmu: Driver, params, intervals, cut) -> list[dict]:
    values = {name: int(value) if name in INTEGERS else float(value) for name, value in params.items()}
    fmu.start(values | {"tau": intervals[0].tau, "F_ext": intervals[0].F_ext})
    read = []
    for i in intervals:
        times = cut(i.duration)
        for start, end in pairwise(times):
            fmu.set({"tau": i.tau + i.tau_rate * start, "F_ext": i.F_ext + i.F_ext_rate * start})
            if i.tau_rate or i.F_ext_rate:
                fmu.set_rates(tau=i.tau_rate, F_ext=i.F_ext_rate)
            fmu.step(float(end - start))
        read.append({name: fmu.get(name) for name in [*MEASURED, "mode", "events"]})
    return read


def ulp_response(params, intervals, exact: list[Point]) -> list[dict[str, float]]:
    """How far each value moves, at each point, when the data change in their last digit: what no double
    precision program can beat. Large only where chance events (a graze, a long train of bounces) amplify."""
    rng = np.random.default_rng(1)
    found = [dict.fromkeys(MEASURED, 0.0) for _ in exact]
    for _ in range(3):
        others = simulate_exact(*nudged(params, intervals, rng))
        for response, point, other in zip(found, exact, others, strict=True):
            for name in MEASURED:
                response[name] = max(response[name], abs(point.value(name) - other.value(name)))
    return found


def errors(read: list[dict], exact: list[Point], response: list[dict[str, float]] | None = None) -> list[str]:
    """All that is wrong, in words."""
    wrong, size, faded, still = [], scales(exact), False, False
    for number, (values, point) in enumerate(zip(read, exact, strict=True)):
        faded = faded or FADING in point.doubts
        still = still or STILL in point.doubts  # then contacts may carry what they do at rest
        for name in MEASURED:
            if still and name.startswith("peak.reaction"):
                continue
            # bounces whose height is rounding have speeds, thus reactions, of its square root
            allowed = (1e-5 if faded and name.startswith("peak.reaction") else TOLERANCE) * size[name]
            allowed += min(10 * response[number][name], WORST * size[name]) if response else 0.0
            if not abs(values[name] - point.value(name)) <= allowed:
                wrong.append(f"interval {number}: {name} {values[name]!r}, not {point.value(name)!r}")
    return wrong + wrong_modes(read, exact)


def verdict(fmu: Driver, params, intervals, exact: list[Point], rng) -> list[str]:
    try:
        read = drive(fmu, params, intervals, lambda duration: cuts(rng, duration))
    except AssertionError as failure:
        return [str(failure).splitlines()[0]]
    wrong = errors(read, exact)
    return wrong and errors(read, exact, ulp_response(params, intervals, exact))


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_random_scenes(chunk, make):
    wrong = []
    for title, params, intervals, exact in well_posed_scenes(chunk):
        rng = np.random.default_rng([chunk, len(intervals)])
        wrong += [f"{title}: {text}" for text in verdict(make(), params, intervals, exact, rng)[:4]]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("chunk", range(4))
def test_answer_does_not_depend_on_how_an_interval_is_cut(chunk, make):
    """The same scenes in whole intervals, and in 300 steps per interval."""
    for title, params, intervals, exact in well_posed_scenes(chunk):
        whole = drive(make(), params, intervals, lambda duration: [0.0, duration])
        pieces = drive(make(), params, intervals, lambda duration: np.linspace(0.0, duration, 301))
        size, response, sure = scales(exact), None, True
        for number, (values, others, point) in enumerate(zip(whole, pieces, exact, strict=True)):
            for name in MEASURED:
                allowed = (1e-5 if name.startswith("peak.reaction") else TOLERANCE) * size[name]
                if abs(values[name] - others[name]) > allowed:
                    response = response or ulp_response(params, intervals, exact)
                    allowed += min(10 * response[number][name], WORST * size[name])
                assert abs(values[name] - others[name]) <= allowed, (title, number, name)
            sure = sure and not point.doubts
            if sure:
                found = values["mode"], values["events"]
                assert found == (others["mode"], others["events"]), (title, number)


def test_scenes_are_varied():
    """What the random scenes must exercise, counted over a part of them."""
    modes, doubts, regimes, lowest = [], 0, set(), math.inf
    for chunk in range(2):
        for _, params, _, exact in well_posed_scenes(chunk):
            modes += [point.mode for point in exact]
            doubts += sum(bool(point.doubts) for point in exact)
            inertia = sum(value for name, value in params.items() if name.startswith("inertia."))
            drag = sum(v for n, v in params.items() if n.startswith("damper.") or n == "shaft.damping")
            regimes.add("inertial" if inertia else "viscous" if drag else "quasi-static")
            lowest = min(lowest, *(point.z for point in exact))
    assert {1, 2, 3, 4, 5} <= set(modes)
    assert regimes == {"inertial", "viscous", "quasi-static"}
    assert lowest < 0
    assert doubts < 0.2 * len(modes)
