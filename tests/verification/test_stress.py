"""A small part of the stress table (tests/verification/stress), and its own judges."""

from dataclasses import replace

import general_scenes
import numpy as np
import pytest
from driver import load

from verification.stress import forces, judges
from verification.stress.at_random import random_scene
from verification.stress.drive import drive, equal_cuts, prepare
from verification.stress.families import FAMILIES, RANDOM
from verification.stress.judges import judge, largest_error, sizes_of
from verification.stress.laws import random_law, random_load
from verification.stress.mechanisms import Tables

SHARE = {"tolerances": 60, "lead": 40, "friction": 40, "dwell": 60}
PATIENCE = 2  # seconds for one reference


@pytest.fixture(scope="module")
def libraries():
    return prepare().load()


def wrong(scenes, libraries) -> list[str]:
    """What is wrong, and with which scene."""
    return [f"{s.label}: {text}" for s in scenes for text in judge(s, libraries).problems]


@pytest.mark.parametrize("name", FAMILIES)
def test_some_of_each_row(name, libraries, tmp_path, monkeypatch):
    monkeypatch.setattr(judges, "PATIENCE", PATIENCE)
    scenes = list(FAMILIES[name](Tables(tmp_path)))
    chosen = [s for s in scenes if len(s.intervals) < 10][:: SHARE.get(name, 25)]
    assert chosen
    assert not wrong(chosen, libraries)


@pytest.mark.parametrize(("name", "seed"), [("fuzz", 1), ("fuzz_laws", 3)])
def test_some_at_random(name, seed, libraries, tmp_path):
    assert not wrong(RANDOM[name](Tables(tmp_path), 60, seed), libraries)


@pytest.mark.parametrize(
    ("make", "number"), [(random_scene, 314), *((random_law, n) for n in (722, 1180, 2346, 2378, 2718))]
)
def test_a_change_of_flanks_does_not_depend_on_cuts(make, number, libraries, tmp_path):
    """1180: the load comes back above the speed of a jam, again and again, and no flanks agree: rounding must
    not choose flanks that press against each other. 2346: after the change the motion leaves an unstable
    balance. 2378: a reaction passes zero where two pairs of flanks agree. 722: the other reaction passes zero
    too, and is less than its rounding. 314, 2718: tests/test_jams_in_motion.py."""
    verdict = judge(make(Tables(tmp_path), number), libraries)
    assert verdict.judged and not verdict.problems


LOADED = {
    "a short time in the stick band": (248, 2, -0.053684250),
    "a pair of flanks that loses its motion": (338, 2, 1.0430582216990865),
}


@pytest.mark.parametrize("name", LOADED)
def test_motion_under_load_laws_does_not_depend_on_cuts(name, libraries, tmp_path):
    """One interval of a scene, which begins at rest, in one step and in ten."""
    number, interval, theta = LOADED[name]
    scene = random_load(Tables(tmp_path), number)
    start = {"initial.theta": theta, "initial.omega": 0.0}
    scene = replace(scene, params=scene.params | start, intervals=[scene.intervals[interval]])
    whole, cut = (drive(libraries[False], scene, equal_cuts(n)) for n in (1, 10))
    size = sizes_of(whole.largest, whole.turnover)
    for trace in (whole, cut):
        assert not trace.refusal and not trace.problems
        assert largest_error(scene, trace.read, whole.read, size)[0] <= 1e-7
        assert trace.read[-1]["events"] == whole.read[-1]["events"]


RARE = {
    "another pair of flanks goes on with the motion": (random_load, 106),
    "another pair of flanks is an unstable balance": (random_load, 176),
    "friction at rest serves in motion without inertia and dampers": (random_load, 229),
    "contacts wedge for another reason": (random_load, 260),
    "no part of a refused Lobatto step is worth a trial": (random_load, 279),
    "the torque comes back into the stick band inside a step": (random_load, 299),
    "rest ends where an edge becomes infinite": (random_load, 344),
    "contacts let go within a step": (random_law, 8),
    "the search finds a motion that begins backwards": (random_load, 141),
    "a pair on which more torque gives less acceleration": (random_load, 332),
    "that pair accelerates the motion backwards": (random_load, 309),
    "Newton's method loses the reactions": (random_load, 318),
    "a quiet step passes the place where Newton's method loses the reactions": (random_load, 101),
    "the answer of Newton's method does not settle": (random_load, 1002),
    "the edge that a motion meets is infinite": (random_law, 130),
    "the step past a zero is not solved": (random_law, 143),
    "rest inside the band under friction that grows with the speed": (random_law, 192),
    "contacts wedge inside the band on a dwell": (random_scene, 259),
}


@pytest.mark.parametrize("name", RARE)
def test_rare_ways_do_not_depend_on_cuts(name, libraries, tmp_path):
    """Of 1400 random scenes, one to eleven take such a way through the C code."""
    make, number = RARE[name]
    verdict = judge(make(Tables(tmp_path), number), libraries)
    assert verdict.judged and not verdict.problems


@pytest.mark.parametrize(
    "number",
    [
        pytest.param(178, id="small reactions that Newton's method has found are not lost"),
        pytest.param(1002, id="without inertia of the shaft both reactions are searched"),
    ],
)
def test_answers_do_not_depend_on_the_steps(binaries, tmp_path, number):
    """In the library of the FMU itself."""
    library = load(binaries["DualCamForward"])
    scene = random_load(Tables(tmp_path), number)
    whole, cut = (drive(library, replace(scene, steps=steps)) for steps in (1, 7))
    assert not whole.refusal and not cut.refusal
    for name in ("theta", "omega"):
        assert cut.read[-1][name] == pytest.approx(whole.read[-1][name], rel=1e-7)


def test_grooves_of_too_many_polynomials_are_refused(libraries, tmp_path):
    trace = drive(libraries[False], random_load(Tables(tmp_path), 329))
    assert "describing the grooves in between takes more than" in trace.refusal and not trace.problems


@pytest.mark.parametrize("number", [248, 266])
def test_a_torque_that_no_speed_balances_is_refused(number, libraries, tmp_path):
    trace = drive(libraries[False], random_load(Tables(tmp_path), number))
    assert "no speed balances the torque" in trace.refusal and not trace.problems


def test_changed_data_stay_within_their_limits():
    """Else the changed scene is refused, and nothing seems to amplify what changed."""
    rng, scene = np.random.default_rng(3), {"stop.restitution": 1.0, "cam1.radius": 0.02}
    changed = [general_scenes.nudged(scene, [], rng, 1e-9)[0] for _ in range(20)]
    assert {c["stop.restitution"] for c in changed} == {1.0 - 1e-9, 1.0}
    assert {c["cam1.radius"] for c in changed} == {0.02 * (1.0 - 1e-9), 0.02 * (1.0 + 1e-9)}


def test_a_wrong_reference_is_noticed(libraries, tmp_path):
    scene = next(forces.stiffness(Tables(tmp_path)))
    verdict = judge(scene, libraries)
    assert verdict.judged and not verdict.problems
    changed = scene.params | {"cam1.friction": 0.14 + 1e-6}
    assert judge(replace(scene, instead=changed), libraries).problems
