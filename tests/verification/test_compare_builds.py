"""tests/verification/builds: a build is equal to itself, and what differs is found."""

import dataclasses
import math
from functools import partial

import pytest
from driver import ROOT

from verification.builds import compare as compare_builds
from verification.builds import scenes
from verification.builds.compare import NEW, OLD, Group, Job, groups, judge, run
from verification.builds.play import compare, play

BUILD = ROOT / "build"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("comparison")


@pytest.fixture(scope="module")
def job(folder):
    fmus, names, missing = compare_builds.load({OLD: BUILD, NEW: BUILD}, folder)
    assert not missing
    return Job(fmus, names, folder, tolerance=0.0, patience=10.0)


def record(job, scene):
    key = scene.model, scene.version
    return play(job.fmus[OLD, *key], job.names[key], scene)


def test_a_build_is_equal_to_itself(job):
    for group in groups(helical=10, general=5, share=0.01):
        outcome = run(job, group)
        assert outcome.scenes == group.count and outcome.values > 0
        assert outcome.differences == 0, outcome.shown


def test_the_command_says_so(capsys):
    given = [str(BUILD), str(BUILD), "--quick", "--only", "coarse"]
    assert compare_builds.main(given) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split(":")[0][:10] for line in lines[2:6]] == ["tests/data"] * 4
    assert " 0 differences" in lines[-1]


@pytest.mark.parametrize(
    "scene",
    [
        scenes.known_scene(3, None),
        scenes.curved_scene(4, None),
        dataclasses.replace(scenes.known_scene(0, None), use="exchange"),
    ],
    ids=lambda scene: scene.title,
)
def test_another_parameter_is_found(job, scene):
    """The last digit of the spring's preload."""
    preload = math.nextafter(50.0, math.inf)
    other = dataclasses.replace(scene, parameters={**scene.parameters, "spring.preload": preload})
    old, same, new = record(job, scene), record(job, scene), record(job, other)
    assert compare(scene.title, old, same) == []
    found = compare(scene.title, old, new)
    assert any(difference.what.startswith("spring.force") for difference in found)
    assert all(difference.scene == scene.title and not difference.mended for difference in found)
    outcome = judge(scene, old, new, 0.0)
    assert outcome.differences == len(found) and scene.title in outcome.shown[0]
    assert compare(scene.title, old, new, tolerance=1e-6) == []


def test_a_step_that_only_one_build_refuses(job):
    scene = scenes.known_scene(0, None)
    moves = [*scene.moves[:2], dataclasses.replace(scene.moves[2], length=-1.0), *scene.moves[3:]]
    good, bad = record(job, scene), record(job, dataclasses.replace(scene, moves=moves))
    found = compare(scene.title, bad, good)
    assert [difference.mended for difference in found] == [True]
    assert "refuses" in str(found[0]) and "fmi2DoStep" in str(found[0])
    outcome = judge(scene, bad, good, 0.0)
    assert (outcome.differences, len(outcome.apart)) == (0, 1)
    outcome = judge(scene, good, bad, 0.0)
    assert outcome.differences > 0 and outcome.apart == []


def test_a_scene_that_takes_too_long_is_reported_apart(job, monkeypatch):
    monkeypatch.setattr(compare_builds, "TIME_OF_MOVE", 0.0)
    impatient = dataclasses.replace(job, patience=1e-3)
    fine = scenes.KNOWN_SCENES // 2  # the first of those in steps of 1 ms, about 800 of them
    outcome = run(impatient, Group("slow", 2, lambda k, folder: scenes.known_scene(fine + k, folder)))
    assert outcome.scenes == 2 and outcome.differences == 0
    assert [text.count("out of time") for text in outcome.apart] == [2, 2]


def test_a_new_build_that_hangs_differs(job):
    assert compare_builds._judge_ended("scene", {NEW: "out of time"}).differences == 1
    assert compare_builds._judge_ended("scene", {OLD: "out of time"}).differences == 0


def test_scenes_are_the_same_again(tmp_path):
    for make in (partial(scenes.random_scene, True), scenes.inverse_scene, scenes.exchange_scene):
        assert make(5, tmp_path) == make(5, tmp_path)
        assert make(5, tmp_path) != make(6, tmp_path)
