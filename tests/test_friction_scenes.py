"""The FMU against the independent reference, over scenes with friction that depends on the sliding speed.

The scenes and their solutions are in data/friction_scenes.json.gz (friction_scenes.py): helices, ellipses and
tables, laws of Tustin and Gauss, lubricated branches. Allowed error: ten times the
tolerance, as in test_general_accuracy.py.
"""

from functools import partial

import numpy as np
import pytest
from driver import models
from friction_scenes import FILE, WANTED
from general_scenes import MEASURED, Scene, load, scales
from reference import simulate
from test_general_accuracy import TOLERANCES, allowed_errors, cuts, drive, short_cuts, title, verdict

CHUNKS = 8


@pytest.fixture
def model():
    return models["DualCamForward"]


@pytest.fixture(scope="module")
def scenes(tmp_path_factory) -> list[Scene]:
    return load(tmp_path_factory.mktemp("tables"), FILE)


@pytest.mark.parametrize("chunk", range(CHUNKS))
@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_friction_scenes(tolerance, chunk, make, scenes):
    wrong = []
    for scene in scenes[chunk::CHUNKS]:
        rng = np.random.default_rng([chunk, scene.number])
        found = verdict(make(), scene, tolerance, partial(cuts, rng))
        wrong += [f"{title(scene)}: {text}" for text in found[:4]]
    assert not wrong, "\n".join(wrong)


def test_in_short_steps(make, scenes):
    wrong = []
    for scene in scenes[::20]:
        found = verdict(make(), scene, None, partial(short_cuts, np.random.default_rng(scene.number)))
        wrong += [f"{title(scene)}: {text}" for text in found[:4]]
    assert not wrong, "\n".join(wrong)


def test_answer_hardly_depends_on_how_an_interval_is_cut(make, scenes):
    for scene in scenes[5::20]:
        if any(p.doubts for p in scene.points):
            continue
        whole, _ = drive(make(), scene, 1e-9, lambda duration: [0.0, duration])
        pieces, _ = drive(make(), scene, 1e-9, lambda duration: np.linspace(0.0, duration, 41))
        allowed = allowed_errors(scene, 1e-9)
        for number, (values, others) in enumerate(zip(whole, pieces, strict=True)):
            assert (values["mode"], values["events"]) == (others["mode"], others["events"]), (
                title(scene),
                number,
            )
            for name in MEASURED:
                assert abs(values[name] - others[name]) <= allowed[name], (title(scene), number, name)


def test_file_is_what_the_reference_computes(scenes):
    chosen = sorted(scenes, key=lambda s: (len(s.intervals) + s.points[-1].events, s.number))[:4]
    for scene in chosen:
        size = scales(scene.points)
        for point, kept in zip(simulate(scene.params, scene.intervals), scene.points, strict=True):
            assert (point.mode, point.events, point.doubts) == (kept.mode, kept.events, kept.doubts)
            for name in MEASURED:
                assert abs(point.value(name) - kept.value(name)) <= 1e-12 * size[name], (title(scene), name)


def test_scenes_are_varied(scenes):
    assert len(scenes) == WANTED
    cams = [(s.params, f"cam{i}.") for s in scenes for i in (1, 2)]
    assert {p.get(f"{cam}stribeck_exponent") for p, cam in cams} >= {1, 2}
    assert sum(p.get(f"{cam}friction_viscous", 0.0) > 0 for p, cam in cams) > 100
    assert {point.mode for s in scenes for point in s.points} >= {1, 2, 3, 4, 5}
