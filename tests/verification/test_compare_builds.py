"""tests/verification/compare_builds.py: a build is equal to itself, and what differs is found."""

import dataclasses
import math

import pytest
from driver import ROOT

from verification.compare_builds import (
    REFUSED,
    Build,
    compare,
    differences,
    groove_scene,
    groups,
    inverse_scene,
    main,
    play,
)

BUILD = ROOT / "build"


@pytest.fixture(scope="module")
def build(tmp_path_factory):
    return Build(BUILD, tmp_path_factory.mktemp("build"))


def test_a_build_is_equal_to_itself(build, tmp_path):
    assert [compare(group, build, build, tmp_path, 0.0) for group in groups(9, 0.02)] == [0] * 6


def test_the_command_says_so(capsys):
    assert main([str(BUILD), "--quick", "--count", "30", "--only", "helices"]) == 0
    group, last = capsys.readouterr().out.splitlines()
    assert group.split()[2:4] == ["3", "scenes"] and last.startswith("0 differences")


@pytest.mark.parametrize("make", [groove_scene, inverse_scene])
def test_the_last_digit_of_a_parameter_is_found(build, tmp_path, make):
    scene = make(3, tmp_path)
    preload = math.nextafter(scene.parameters["spring.preload"], math.inf)
    other = dataclasses.replace(scene, parameters=scene.parameters | {"spring.preload": preload})
    old, new = play(build, scene), play(build, other)
    assert "spring.force" in {name for name, _ in differences(old, new, 0.0)}
    assert len(old) > 3 and differences(old, play(build, scene), 0.0) == []
    assert "spring.force" not in {name for name, _ in differences(old, new, 1e-6)}


def test_a_step_that_one_build_refuses_is_found(build, tmp_path):
    scene = groove_scene(0, tmp_path)
    steps = [*scene.steps[:2], dataclasses.replace(scene.steps[2], length=-1.0)]
    good, bad = play(build, scene), play(build, dataclasses.replace(scene, steps=steps))
    assert bad[-1] == {REFUSED: True} and len(bad) == 4
    assert differences(good[:4], bad, 0.0)[0][0] == REFUSED


def test_scenes_are_the_same_again(tmp_path):
    assert inverse_scene(5, tmp_path) == inverse_scene(5, tmp_path) != inverse_scene(6, tmp_path)
