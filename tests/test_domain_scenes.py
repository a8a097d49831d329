"""Random scenes of the domain against the event-driven reference, and scenes far outside it."""

import pytest

from verification.domain.domain import SELF_LOCKING, UNIQUE
from verification.domain.play import judge, judge_far
from verification.domain.scenes import draw_scene

TOLERANCE = 1e-9
# Seeds of scenes whose contacts may lock, far from the border of the class.
WITH_A_LOCKED_CONTACT = (
    *(96, 210, 211, 244, 262, 274, 284, 285, 286, 289, 314, 346, 352, 371, 379),
    *(399, 494, 536, 543, 575, 588, 690, 692, 780, 733, 740, 741, 767, 770, 771),
)


def has_one_answer(seed):
    """Far from the border of the class."""
    verdict = draw_scene(seed).verdict
    return verdict.kind == UNIQUE and not verdict.border


WITH_ONE_ANSWER = list(filter(has_one_answer, range(65)))


def test_there_are_sixty_scenes_with_one_answer():
    assert len(WITH_ONE_ANSWER) == 60


@pytest.mark.parametrize("seed", WITH_ONE_ANSWER)
def test_scenes_with_one_answer(library, seed):
    outcome = judge(library, seed, TOLERANCE)
    assert (outcome.kind, outcome.problems, outcome.refusal) == (UNIQUE, [], "")


@pytest.mark.parametrize("seed", WITH_A_LOCKED_CONTACT)
def test_self_locking_scenes_follow_the_rule(library, seed):
    outcome = judge(library, seed, TOLERANCE)
    assert (outcome.kind, outcome.problems, outcome.refusal) == (SELF_LOCKING, [], "")


@pytest.mark.parametrize("seed", range(100))
def test_scenes_far_outside_are_finite_and_gain_no_energy(library, seed):
    assert judge_far(library, seed, TOLERANCE).problems == []
