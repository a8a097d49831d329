"""Random scenes of the domain against the event-driven reference, and scenes far outside it."""

import pytest

from verification.domain.domain import SELF_LOCKING, UNIQUE
from verification.domain.play import judge, judge_far

TOLERANCE = 1e-9
# Seeds of scenes whose class is far from its border.
WITH_ONE_ANSWER = (
    0,
    3,
    4,
    6,
    8,
    9,
    10,
    12,
    15,
    16,
    21,
    22,
    23,
    24,
    25,
    26,
    27,
    28,
    31,
    32,
    33,
    34,
    35,
    36,
    37,
    38,
    39,
    40,
    41,
    42,
    43,
    44,
    45,
    46,
    48,
    49,
    50,
    53,
    55,
    56,
    57,
    60,
    61,
    62,
    63,
    64,
    65,
    66,
    67,
    68,
    69,
    70,
    71,
    73,
    74,
    75,
    77,
    79,
    80,
    81,
)
WITH_A_LOCKED_CONTACT = (
    96,
    210,
    211,
    244,
    262,
    274,
    284,
    285,
    286,
    289,
    314,
    346,
    352,
    371,
    379,
    399,
    494,
    536,
    543,
    575,
    588,
    690,
    692,
    780,
    733,
    740,
    741,
    767,
    770,
    771,
)


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
