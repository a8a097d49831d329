"""A small part of the stress table (tests/verification/stress), and its own judges."""

from dataclasses import replace

import general_scenes
import numpy as np
import pytest

from verification.stress import forces, judges
from verification.stress.drive import prepare
from verification.stress.families import FAMILIES, RANDOM
from verification.stress.judges import judge
from verification.stress.mechanisms import Tables
from verification.stress.scene import Verdict
from verification.stress.table import Row, published

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


def test_changed_data_stay_within_their_limits():
    """Else the changed scene is refused, and nothing seems to amplify what changed."""
    rng, scene = np.random.default_rng(3), {"stop.restitution": 1.0, "cam1.radius": 0.02}
    changed = [general_scenes.nudged(scene, [], rng, 1e-9)[0] for _ in range(20)]
    assert {c["stop.restitution"] for c in changed} == {1.0 - 1e-9, 1.0}
    assert {c["cam1.radius"] for c in changed} == {0.02 * (1.0 - 1e-9), 0.02 * (1.0 + 1e-9)}


def test_a_row_of_results_lists_messages_and_wrong_runs(tmp_path):
    scene = next(forces.stiffness(Tables(tmp_path)))
    row = Row("stiffness")
    for verdict in (Verdict(refusal="the contacts jam when loading"), Verdict(problems=["lost 1 J"])):
        row.add(scene, verdict)
    found = published(row)
    assert (found["runs"], found["right"], found["wrong"], found["refused"]) == ("2", "0", "1", "1")
    assert found["messages"] == '1 "the contacts jam when loading at theta = ..."'
    assert found["wrong runs"] == f"{scene.label}: lost 1 J"


def test_a_wrong_reference_is_noticed(libraries, tmp_path):
    scene = next(forces.stiffness(Tables(tmp_path)))
    verdict = judge(scene, libraries)
    assert verdict.judged and not verdict.problems
    changed = scene.params | {"cam1.friction": 0.14 + 1e-6}
    assert judge(replace(scene, instead=changed), libraries).problems
