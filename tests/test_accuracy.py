"""The FMU against the independent reference, over random scenes with helical grooves.

Every scene is solved in closed form at 60 digits (exact_scenes.py, data/exact_scenes.json.gz) and driven
through the FMU with communication steps cut at random. Allowed error: 1e-11 of the scene's largest angle,
speed, account.

Where the reference itself stands within rounding of a switch (Point.doubts: a train of bounces that fades
out, a speed that has died away, an event at the very end of an interval) the count of mode changes is a
matter of rounding, and is not compared in that interval and the next; what is measured still is.
"""

from itertools import pairwise

import numpy as np
import pytest
from driver import Driver
from exact_scenes import CHUNKS, SCENES, load
from general_scenes import FADING, MEASURED, STILL, Scene, nudged, scales, wrong_modes
from reference import INTEGERS, Point, simulate_exact

TOLERANCE = 1e-11
WORST = 1e-7  # where the last digit of the data is amplified that much; see ulp_response


@pytest.fixture(scope="module")
def chunks():
    return load()


def title(scene: Scene) -> str:
    return f"scene {scene.number}"


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
def test_random_scenes(chunk, make, chunks):
    wrong = []
    for scene in chunks[chunk]:
        rng = np.random.default_rng([chunk, len(scene.intervals)])
        found = verdict(make(), scene.params, scene.intervals, scene.points, rng)
        wrong += [f"{title(scene)}: {text}" for text in found[:4]]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("chunk", range(4))
def test_answer_does_not_depend_on_how_an_interval_is_cut(chunk, make, chunks):
    """The same scenes in whole intervals, and in 300 steps per interval."""
    for scene in chunks[chunk]:
        params, intervals, exact = scene.params, scene.intervals, scene.points
        whole = drive(make(), params, intervals, lambda duration: [0.0, duration])
        pieces = drive(make(), params, intervals, lambda duration: np.linspace(0.0, duration, 301))
        size, response, sure = scales(exact), None, True
        for number, (values, others, point) in enumerate(zip(whole, pieces, exact, strict=True)):
            for name in MEASURED:
                allowed = (1e-5 if name.startswith("peak.reaction") else TOLERANCE) * size[name]
                if abs(values[name] - others[name]) > allowed:
                    response = response or ulp_response(params, intervals, exact)
                    allowed += min(10 * response[number][name], WORST * size[name])
                assert abs(values[name] - others[name]) <= allowed, (title(scene), number, name)
            sure = sure and not point.doubts
            if sure:
                found = values["mode"], values["events"]
                assert found == (others["mode"], others["events"]), (title(scene), number)


def test_file_is_what_the_reference_computes(chunks):
    """The scene of each chunk with the fewest events, solved anew. Equal to the last digit: 60 digits are
    rounded once."""
    for scenes in chunks:
        scene = min(scenes, key=lambda s: (len(s.intervals) + s.points[-1].events, s.number))
        assert simulate_exact(scene.params, scene.intervals) == scene.points, title(scene)


def test_scenes_are_varied(chunks):
    """What the random scenes must exercise."""
    scenes = [scene for chunk in chunks for scene in chunk]
    assert [len(chunk) for chunk in chunks] == [SCENES] * CHUNKS
    points = [point for scene in scenes for point in scene.points]
    assert {1, 2, 3, 4, 5} <= {point.mode for point in points}
    assert {scene.regime for scene in scenes} == {"inertial", "viscous", "rate-independent"}
    assert min(point.z for point in points) < 0
    assert sum(bool(point.doubts) for point in points) < 0.2 * len(points)
