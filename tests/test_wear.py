"""Wear of grooves and pin against the FMU, against roots and energies found another way, and by hand."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from dualcam import Fmu
from dualcam.design import Ellipse, Helix, Mechanism, Pin, Spring, Table, wear
from dualcam.errors import DesignError

PIN = Pin(radius=0.003, width=0.008, wear=2e-15)
RATES = (3e-15, 1e-15)
SPRING = Spring(80.0, 30e3)
STEEP = Ellipse(0.022, 0.6, 0.05, 0.06, +1)
FLAT = Ellipse(0.022, 0.6, 0.04, 0.05, -1)
MECHANISMS = {
    "helices": Mechanism((Helix(0.02, 0.7), Helix(0.025, 0.9)), (0.14, 0.1), SPRING, 1.2),
    "ellipses": Mechanism((STEEP, FLAT), (0.1, 0.12), SPRING, 1.0),
    "below zero": Mechanism(
        (Helix(0.02, 0.7), Helix(0.02, 0.8)), (0.1, 0.1), Spring(400.0, 2e4), 0.8, 1, -0.5
    ),
    "self-locking": Mechanism((Helix(0.02, 0.1), Helix(0.02, 0.9)), (0.14, 0.1), SPRING, 1.2),
}


@pytest.fixture(params=MECHANISMS)
def mechanism(request):
    return MECHANISMS[request.param]


def volumes_of_the_fmu(mechanism, folder, rates):
    """Wear that the inverse FMU books in one slow cycle from stop to stop and back."""
    steps, low, high = 400, mechanism.lower, mechanism.upper
    angles = low + (high - low) * np.abs(1.0 - np.abs(np.linspace(-1.0, 1.0, 2 * steps + 1)))
    with Fmu("inverse") as fmu:
        found = mechanism.parameters(folder) | {"cam1.wear": rates[0], "cam2.wear": rates[1]}
        fmu.start(found | {"theta": low})
        before = [fmu.real(f"wear.cam{i}") for i in (1, 2)]
        for start, end in pairwise(angles):
            fmu.set("theta", start)
            fmu.set("omega", (end - start) / 0.01)
            fmu.step(0.01)
        return np.array([fmu.real(f"wear.cam{i}") for i in (1, 2)]) - before


def test_volume_is_that_of_the_fmu(mechanism, tmp_path):
    found = wear(mechanism, PIN, RATES)
    assert found.volume == pytest.approx(volumes_of_the_fmu(mechanism, tmp_path, RATES), rel=1e-5)
    work = found.volume / RATES
    assert found.pin_volume == pytest.approx(PIN.wear * work, rel=1e-12)


def test_depth_times_width_along_the_groove_is_the_volume(mechanism, tmp_path):
    """The integral of depth, width and arc length of both flanks is the volume that the FMU books."""
    found = wear(mechanism, PIN, RATES)
    slope = mechanism.configuration(found.theta).slope
    for i, groove in enumerate(mechanism.grooves):
        arc = np.hypot(groove.radius, slope[i])
        depth = found.depth[i] + found.other_depth[i]
        volume = PIN.width * np.trapezoid(depth * arc, found.psi[i])
        assert volume == pytest.approx(volumes_of_the_fmu(mechanism, tmp_path, RATES)[i], rel=2e-5)


def test_path_is_twice_the_arc_length():
    """Of an ellipse of equal semi-axes, a circle: radius times the change of the lead angle."""
    circle = Ellipse(0.02, 0.5, 0.05, 0.05, -1)
    found = wear(Mechanism((circle, circle), (0.1, 0.1), SPRING, 1.0), PIN, RATES)
    ends = np.arctan(circle.at(np.array([0.0, 0.5])).slope / 0.02)
    assert found.path == pytest.approx(2.0 * 0.05 * (ends[0] - ends[1]), rel=1e-10)


def test_the_other_flank_wears_only_while_a_locked_cam_releases():
    locked = wear(MECHANISMS["self-locking"], PIN, RATES)
    assert (locked.other_depth[0] == 0.0).all() or (locked.other_depth[1] == 0.0).all()
    assert (locked.other_depth > 0.0).any()
    assert not wear(MECHANISMS["helices"], PIN, RATES).other_depth.any()


# ---- life and pin ----


def test_life_is_where_the_depth_is_reached(mechanism):
    found = wear(mechanism, PIN, RATES)
    life = found.life(0.05e-3)
    assert life.groove1 * found.largest[0] == pytest.approx(0.05e-3)
    assert life.groove2 * found.largest[1] == pytest.approx(0.05e-3)
    assert found.pin_depth(life.pin).max() == pytest.approx(0.05e-3)
    assert life.cycles == min(life.groove1, life.groove2, life.pin)
    assert getattr(life, life.part.replace(" ", "")) == life.cycles


def test_a_part_without_rate_lasts_for_ever():
    life = wear(MECHANISMS["helices"], replace(PIN, wear=0.0), (0.0, 1e-15)).life(1e-4)
    assert math.isinf(life.groove1) and math.isinf(life.pin) and life.part == "groove 2"


def test_the_flat_has_the_worn_volume():
    """The segment that a flat cuts from a round pin, by its exact area."""
    found = wear(MECHANISMS["helices"], PIN, RATES)
    cycles = 2e5
    for depth, volume in zip(found.pin_depth(cycles), cycles * found.pin_volume, strict=True):
        half = math.acos(1.0 - depth / PIN.radius)
        segment = PIN.radius**2 * (half - math.sin(half) * math.cos(half))
        # the parabola for the circle makes 0.15 depth/radius
        assert segment * PIN.width == pytest.approx(volume, rel=0.2 * depth / PIN.radius)


def test_each_flat_is_on_its_own_groove():
    """Groove 1 bulges, groove 2 is straight, where the relative radius is that of the pin. The formula of
    docs/design-quantities.md by hand; the flat of one groove knows nothing of the other groove."""
    straight = Helix(0.022, math.pi / 4)
    bent = Ellipse(0.022, math.pi / 4, 0.04, 0.04, -1)  # a circle: its curvature is -1/0.04 everywhere
    found = wear(Mechanism((bent, straight), (0.12, 0.12), SPRING, 1.0), PIN, RATES)
    radius = [0.003 * (1.0 - 0.003 / 0.04), 0.003]
    for depth, volume, rho in zip(found.pin_depth(1e6), 1e6 * found.pin_volume, radius, strict=True):
        by_hand = (3.0 * volume / (4.0 * 0.008 * math.sqrt(2.0 * rho))) ** (2.0 / 3.0)
        assert depth == pytest.approx(by_hand, rel=1e-9)
    life = found.life(0.05e-3).pin
    assert found.pin_depth(life).max() == pytest.approx(0.05e-3)


def test_a_pin_that_turns_wears_all_around():
    found = wear(MECHANISMS["helices"], PIN, RATES, turns=True)
    depth = found.pin_depth(1e6)
    ring = math.pi * (PIN.radius**2 - (PIN.radius - depth) ** 2) * PIN.width
    assert ring == pytest.approx(1e6 * found.pin_volume, rel=0.02)
    assert found.pin_depth(found.life(1e-5).pin).max() == pytest.approx(1e-5)
    assert (depth < wear(MECHANISMS["helices"], PIN, RATES).pin_depth(1e6)).all()


# ---- worn mechanism ----

CYCLES = 2e5


def worn_grooves(found):
    """The worn grooves as functions, by another interpolation than that of the package."""
    depth = CYCLES * found.depth + found.pin_depth(CYCLES)[:, None]
    functions = []
    for i, groove in enumerate(found.mechanism.grooves):
        lead = np.arctan(groove.at(found.psi[i]).slope / groove.radius)
        way = PchipInterpolator(found.psi[i], depth[i] / np.cos(lead), extrapolate=True)
        functions.append(lambda psi, groove=groove, way=way: float(groove.at(psi).z - way(psi)))
    return functions


@pytest.mark.parametrize("name", ["helices", "ellipses"])
def test_the_follower_sinks_to_where_the_worn_grooves_meet(name):
    found = wear(MECHANISMS[name], PIN, RATES)
    worn, (one, two) = found.after(CYCLES), worn_grooves(found)
    for k in (90, 360, 630):
        theta = float(worn.theta[k])
        new = float(found.mechanism.configuration(theta).psi[0])
        gamma = brentq(lambda g, theta=theta: one(g) - two(theta - g), new - 0.02, new + 0.02, xtol=1e-15)
        fresh = float(found.mechanism.configuration(theta).z)
        assert worn.drop[k] == pytest.approx(fresh - one(gamma), rel=1e-6)
        slope = found.mechanism.configuration(theta).slope
        lead = np.arctan(slope / found.mechanism.radius)
        sunk = (CYCLES * found.depth[:, k] + found.pin_depth(CYCLES)) / np.cos(lead)
        first_order = (slope[1] * sunk[0] + slope[0] * sunk[1]) / slope.sum()
        assert worn.drop[k] == pytest.approx(first_order, rel=0.02)


@pytest.mark.parametrize("name", ["helices", "ellipses"])
def test_without_friction_the_torque_is_the_slope_of_the_stored_energy(name):
    found = wear(replace(MECHANISMS[name], friction=(0.0, 0.0)), PIN, RATES)
    worn = found.after(CYCLES)
    assert worn.load == pytest.approx(worn.release)
    z = found.mechanism.configuration(worn.theta).z - worn.drop
    for first, last in ((100, 300), (300, 700)):
        work = np.trapezoid(worn.load[first : last + 1], worn.theta[first : last + 1])
        stored = float(SPRING.energy(z[last]) - SPRING.energy(z[first]))
        assert work == pytest.approx(stored, rel=1e-6)


def test_torque_with_friction_is_that_of_the_fmu_with_worn_grooves(tmp_path):
    """The FMU with tables of the worn grooves and the preload that is left. Both grooves begin with one lead
    angle and one coefficient, so that both are lowered alike at theta = 0, where a table begins."""
    cam = Mechanism((STEEP, FLAT), (0.1, 0.1), SPRING, 1.0)
    found = wear(cam, replace(PIN, wear=0.0), (2e-15, 2e-15))
    worn = found.after(CYCLES)
    depth = CYCLES * found.depth
    tables = []
    for i, groove in enumerate(cam.grooves):
        psi = np.append(found.psi[i], found.psi[i, -1] + 0.002)  # the worn pin reaches a little farther
        way = depth[i] * np.hypot(1.0, groove.at(found.psi[i]).slope / groove.radius)
        assert way[0] == pytest.approx(depth[0, 0] * math.hypot(1.0, math.tan(0.6)))
        beyond = way[-1] + 0.002 * (way[-1] - way[-2]) / (psi[-2] - psi[-3])
        tables.append(Table(groove.radius, psi, groove.at(psi).z - np.append(way, beyond) + way[0]))
    left = replace(SPRING, preload=SPRING.preload - worn.preload_loss)
    with Fmu("inverse") as fmu:
        fmu.start(replace(cam, grooves=tuple(tables), spring=left).parameters(tmp_path))
        for k in (60, 200, 400, 600, 700):
            fmu.set("theta", float(worn.theta[k]))
            assert fmu.real("torque_load") == pytest.approx(worn.load[k], rel=2e-5)
            assert fmu.real("torque_release") == pytest.approx(worn.release[k], rel=2e-5)
            assert fmu.real("torque_load") < 0.999 * worn.new_load[k]


def test_no_cycles_change_nothing(mechanism):
    worn = wear(mechanism, PIN, RATES).after(0.0)
    assert worn.preload_loss == 0.0 and np.abs(worn.drop).max() < 1e-15
    assert worn.load == pytest.approx(worn.new_load, rel=1e-12)


def test_preload_loss_by_hand():
    """Two helices of lead angle 45 deg, 50 N at theta = 0; the pin does not wear. Normal force of one
    of two contacts F/2 sqrt(2)/(2 (1 -+ mu)), depth K (N_load + N_release)/L, along the axis sqrt(2) times
    as much."""
    groove = Helix(0.02, math.pi / 4)
    cam = Mechanism((groove, groove), (0.14, 0.14), Spring(50.0, 5e4), 1.3963)
    normal = [50.0 / 4.0 * math.sqrt(2.0) / (1.0 - sign * 0.14) for sign in (1, -1)]
    sunk = math.sqrt(2.0) * 1e6 * 1e-15 * sum(normal) / 0.008
    worn = wear(cam, Pin(0.003, 0.008), (1e-15, 1e-15)).after(1e6)
    assert worn.preload_loss == pytest.approx(5e4 * sunk, rel=1e-9)


# ---- dwell and refusals ----


def test_a_dwell_wears_only_where_the_pin_slides():
    """Groove 1 is level beyond psi = 0.5 rad, where the pin of groove 2 stands still."""
    psi = np.linspace(0.0, 1.0, 101)
    rise = np.array([quad(lambda p: 0.02 * max(0.0, min(1.0, (0.5 - p) / 0.4)), 0.0, p)[0] for p in psi])
    rise = np.maximum.accumulate(rise)  # but for the error of the integrals
    cam = Mechanism((Table(0.02, psi, rise), Helix(0.02, 0.8)), (0.1, 0.1), SPRING, 1.0)
    found = wear(cam, replace(PIN, radius=0.001), RATES)
    assert np.isfinite(found.volume).all() and np.isfinite(found.depth).all()
    worn = found.after(1e4)
    assert np.isfinite(worn.load).all() and (worn.drop > 0.0).all()


@pytest.mark.parametrize(
    "call, words",
    [
        (
            lambda cam: wear(cam, PIN, (-1e-15, 0.0)),
            "wear rates = (-1e-15, 0.0): allowed are two finite numbers",
        ),
        (lambda cam: wear(cam, PIN, (math.nan, 0.0)), "wear rates"),
        (lambda cam: wear(cam, PIN, RATES, points=4), "points = 4: allowed is a whole number, 5 or more"),
        (
            lambda cam: wear(cam, PIN, RATES).life(0.0),
            "allowed depth = 0.0: allowed is a finite number > 0 in m",
        ),
        (lambda cam: wear(cam, PIN, RATES).after(-1.0), "cycles = -1.0: allowed is a finite number >= 0"),
        (lambda cam: wear(cam, PIN, RATES).after(math.inf), "cycles = inf"),
        (
            lambda cam: wear(cam, PIN, RATES).after(1e9),
            "allowed is up to a quarter of the pin's radius, 0.75 mm",
        ),
        (lambda cam: wear(cam, PIN, RATES).pin_depth(-2.0), "cycles = -2.0"),
        (
            lambda cam: wear(replace(cam, spring=Spring(0.01, 5e4)), PIN, RATES).after(1e6),
            "the spring is slack; allowed are fewer cycles",
        ),
        (
            lambda cam: wear(replace(cam, grooves=(Helix(0.02, 0.0),) * 2), PIN, RATES),
            "both grooves are level at one angle",
        ),
        (
            lambda cam: wear(replace(cam, grooves=(FLAT, FLAT)), Pin(0.06, 0.008), RATES),
            "pin.radius = 0.06 m: a flank is undercut",
        ),
    ],
)
def test_refusals(call, words):
    with pytest.raises(DesignError) as error:
        call(MECHANISMS["helices"])
    assert words in str(error.value)
