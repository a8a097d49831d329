"""dualcam.design: a constant torque, proposals of springs, what friction does to a designed groove (in the
FMU), and angles that look like degrees."""

import math
import re
import warnings

import numpy as np
import pytest
from driver import models

from dualcam import ContinuousFmu
from dualcam.design import Helix, Spring, propose_spring, synthesize
from dualcam.errors import DesignError, UnitWarning

UPPER = 1.2
HELIX = Helix(0.02, math.pi / 4)


@pytest.fixture(scope="module")
def forward():
    with ContinuousFmu(models["DualCamForward"].fmu) as fmu:
        yield fmu


# ---- constant torque ----


@pytest.mark.parametrize("torque", [5, 5.0, np.float64(5.0), np.float32(5.0), np.int64(5)])
@pytest.mark.parametrize("groove2", [None, HELIX])
def test_a_number_is_the_same_torque_at_each_angle(torque, groove2):
    spring = Spring(400.0, 10e3)
    design = synthesize(torque, UPPER, spring, groove2=groove2)
    same = synthesize(lambda theta: 5.0 + 0.0 * theta, UPPER, spring, groove2=groove2)
    assert (design.table.z == same.table.z).all()
    angles = np.linspace(0.0, UPPER, 300)
    assert design.torque(angles) == pytest.approx(5.0, rel=1e-6)
    assert design.largest_error <= 1e-7
    assert abs(design.error(design.largest_error_at)) == pytest.approx(design.largest_error, rel=1e-6)


@pytest.mark.parametrize(
    ("torque", "text"),
    [
        (math.nan, "torque nan N.m: allowed is a finite number"),
        (0.0, "allowed is a torque > 0 at some angle"),
        (-5.0, "negative.* A torque that loads the spring is positive: is the sign wrong"),
        (True, "torque = True: allowed is a number"),
        ("5", "torque = '5': allowed is a number"),
        (None, "torque = None: allowed is a number"),
    ],
)
def test_refused_torques(torque, text):
    with pytest.raises(DesignError, match=text):
        synthesize(torque, UPPER, Spring(400.0, 10e3))


# ---- proposals ----

WEAK, WITHOUT_PRELOAD = Spring(50.0, 2e3), Spring(0.0, 10e3)
TASKS = {
    "no preload": (5.0, WITHOUT_PRELOAD, {}),
    "negative preload": (5.0, Spring(-20.0, 10e3), {}),
    "weak, helix": (5.0, WEAK, {"groove2": HELIX}),
    "weak, releasing": (lambda theta: 2.0 + theta, WEAK, {"direction": "releasing", "groove2": HELIX}),
    "strong, rises from nearly 0": (lambda theta: 0.05 + theta, Spring(900.0, 10e3), {"groove2": HELIX}),
    "falls": (lambda theta: 6.0 - 3.0 * theta, WEAK, {"direction": "frictionless", "groove2": HELIX}),
    "no preload, steep": (lambda theta: 90.0 * theta, WITHOUT_PRELOAD, {"groove2": HELIX}),
    "softening": (1.5, Spring(100.0, 0.0, -2e6), {"groove2": HELIX}),
}  # fmt: skip


@pytest.mark.parametrize("name", TASKS)
def test_each_proposal_of_a_refusal_works(name):
    """The refusal names springs; each one gives the torque."""
    torque, spring, options = TASKS[name]
    with pytest.raises(DesignError, match=r"This would work: ") as caught:
        synthesize(torque, UPPER, spring, **options)
    text = str(caught.value).partition("This would work: ")[2]
    found = re.findall(r"spring\.(preload|stiffness) = ([\d.e+-]+) (?:N/m|N)\b", text)
    proposals = [{key: float(value)} for key, value in found]
    if " with " in text:
        proposals = [proposals[0] | proposals[1]]
    assert proposals
    for values in proposals:
        given = {"preload": spring.preload, "stiffness": spring.stiffness}
        if len(values) == 1:
            given |= {"stiffness2": spring.stiffness2, "stiffness3": spring.stiffness3}
        design = synthesize(torque, UPPER, Spring(**given | values), **options)
        angles = np.linspace(0.0, UPPER, 100)
        assert np.abs(design.error(angles)).max() < 1e-6


@pytest.mark.parametrize("vary", ["preload", "stiffness", "both"])
@pytest.mark.parametrize("name", ["weak, helix", "falls", "weak, releasing"])
def test_proposed_spring(name, vary):
    """It works, leaves alone what is not to vary, and no spring nearby has lead angles nearer to 45 deg."""
    torque, spring, options = TASKS[name]
    try:
        proposal = propose_spring(torque, UPPER, spring, vary=vary, **options)
    except DesignError as error:  # a preload cannot be replaced: no stiffness has a force at z = 0
        assert vary == "stiffness" and "no spring of that kind" in str(error)
        with pytest.raises(DesignError, match=r"theta = 0 rad: .* too high"):
            synthesize(torque, UPPER, Spring(spring.preload, 1e6), **options)
        return
    made = proposal.spring
    assert (made.stiffness == spring.stiffness) is (vary == "preload")
    assert (made.preload == spring.preload) is (vary == "stiffness")

    def distance(spring):
        design = synthesize(torque, UPPER, spring, **options)
        slope = design.mechanism.configuration(design.mechanism.angles()).slope[0]
        return np.abs(np.arctan(slope / 0.02) - math.pi / 4).max()

    best = distance(made)
    low, high = proposal.lead_angle
    assert max(math.pi / 4 - low, high - math.pi / 4) == pytest.approx(best, rel=1e-9)
    if vary == "preload":
        for factor in (0.7, 1.4):
            other = Spring(made.preload * factor, made.stiffness, made.stiffness2, made.stiffness3)
            try:
                assert distance(other) > best
            except DesignError:
                continue


def test_no_proposal_where_no_spring_helps():
    """A groove 2 that locks itself, and a torque that is negative."""
    for torque, options, text in (
        (0.5, {"direction": "releasing", "groove2": Helix(0.02, 0.1)}, "groove 2 locks"),
        (lambda theta: 0.5 - theta, {"groove2": HELIX}, "negative|too low"),
    ):
        with pytest.raises(DesignError, match=text) as caught:
            synthesize(torque, UPPER, Spring(50.0, 50e3), **options)
        assert "would work" not in str(caught.value)
        with pytest.raises(DesignError, match="no spring of that kind"):
            propose_spring(torque, UPPER, Spring(50.0, 50e3), **options)
    with pytest.raises(DesignError, match="vary = 'radius': allowed are preload, stiffness, both"):
        propose_spring(5.0, UPPER, WEAK, vary="radius")


# ---- friction ----


@pytest.mark.parametrize("direction", ["loading", "releasing", "frictionless"])
@pytest.mark.parametrize("friction", [(0.14, 0.14), (0.4, 0.3)])
def test_torque_band_is_the_fmus(forward, tmp_path, direction, friction):
    """torque_load, torque_release and efficiency of the forward FMU at rest, at 40 angles."""
    spring = propose_spring(2.0, UPPER, Spring(100.0, 10e3), direction=direction, friction=friction).spring
    design = synthesize(2.0, UPPER, spring, direction=direction, friction=friction)
    effect = design.torque_band(points=40)
    forward.start(design.mechanism.parameters(tmp_path))
    group, found = forward.reals("torque_load", "torque_release", "efficiency"), []
    for theta in effect.theta:
        forward.set_states_and_mode((theta, 0.0))
        found.append(group.read())
    load, release, efficiency = np.array(found).T
    assert effect.load == pytest.approx(load, rel=1e-9)
    assert effect.release == pytest.approx(release, rel=1e-9, abs=1e-9)
    assert effect.efficiency == pytest.approx(efficiency, rel=1e-9)
    assert effect.self_locking is bool((release <= 0.0).any()) and not effect.jams
    wanted = {"loading": effect.load, "releasing": effect.release, "frictionless": effect.frictionless}
    assert wanted[direction] == pytest.approx(2.0, rel=1e-6)
    # without friction the same grooves lie between the edges, by the FMU
    forward.start({**design.mechanism.parameters(tmp_path), "cam1.friction": 0.0, "cam2.friction": 0.0})
    forward.set_states_and_mode((effect.theta[20], 0.0))
    assert effect.frictionless[20] == pytest.approx(forward.real("torque_load"), rel=1e-9)


def test_summary_says_what_friction_does():
    design = synthesize(5.0, UPPER, Spring(400.0, 10e3))
    text, effect = design.summary(), design.torque_band()
    assert "wanted torque of slow loading: 5 N.m from theta = 0 to 1.2 rad" in text
    assert f"releasing gives {effect.release.min():.4g} to {effect.release.max():.4g} N.m back" in text
    assert f"efficiency (releasing over loading) {effect.efficiency.min():.4g} to" in text
    assert "not self-locking" in text
    flat = synthesize(1.0, UPPER, Spring(100.0, 1e4), friction=(0.4, 0.4))
    locked = flat.torque_band()
    first = locked.theta[np.argmax(locked.release <= 0.0)]
    assert 0.0 < first < UPPER
    ((begin, end),) = locked.locked
    assert 0.0 <= first - begin <= locked.theta[1] and end == UPPER
    assert f"self-locking from theta = {round(begin, 4):g} to 1.2 rad" in flat.summary()
    assert (locked.efficiency[locked.theta >= first] <= 0.0).all()


def test_summary_of_a_design_that_jams():
    """Releasing works, loading does not: steep grooves with much friction."""
    design = synthesize(1.5, UPPER, Spring(100.0, 3e3), direction="releasing", friction=(0.5, 0.5))
    assert design.torque_band().jams
    assert "the FMU refuses this mechanism" in design.summary()


# ---- degrees ----


def test_upper_in_degrees():
    with pytest.warns(UnitWarning, match=r"upper = 60 rad: this looks like degrees; 60 deg is 1.0472 rad"):
        design = synthesize(5.0, 60, Spring(400.0, 500.0))
    assert design.mechanism.upper == 60.0
    with pytest.warns(UnitWarning, match="degrees"):
        propose_spring(5.0, 75.0, Spring(400.0, 500.0))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        synthesize(5.0, 6.28, Spring(400.0, 10e3))
