"""The helical spring against textbook examples, tables of wire makers and calculations by hand."""

import math

import numpy as np
import pytest

from dualcam.design import HelicalSpring, find_springs, tensile_strength
from dualcam.design.spring_steel import DIAMETERS
from dualcam.errors import DesignError, UnitWarning

INCH, POUND = 0.0254, 4.4482216
KPSI = 1e3 * POUND / INCH**2


def spring(**others):
    values = {"wire_diameter": 0.004, "coil_diameter": 0.028, "active_coils": 6.0, "grade": "SH"} | others
    return HelicalSpring(**values)


# ---- wire ----

# Least tensile strength [MPa] by diameter [mm] in tables of EN 10270-1 that wire makers publish.
PUBLISHED = {
    "SM": {0.3: 2370, 0.5: 2200, 1.0: 1980, 1.5: 1850, 2.0: 1760, 3.0: 1630, 4.0: 1530, 6.0: 1400, 8.0: 1310,
           10.0: 1240, 13.0: 1160, 17.0: 1070, 20.0: 1020},
    "DM": {0.3: 2370, 0.32: 2350, 0.34: 2330},
    "SH": {0.3: 2660, 0.32: 2640, 0.34: 2610},
    "DH": {0.3: 2660, 0.32: 2640, 0.34: 2610},
}  # fmt: skip


@pytest.mark.parametrize(
    "grade, diameter, strength", [(grade, *row) for grade, rows in PUBLISHED.items() for row in rows.items()]
)
def test_tensile_strength_is_within_one_percent_of_the_tables(grade, diameter, strength):
    assert tensile_strength(grade, 1e-3 * diameter) == pytest.approx(1e6 * strength, rel=0.01)


def test_diameters_grow_and_have_a_strength():
    assert list(DIAMETERS) == sorted(set(DIAMETERS))
    strengths = [tensile_strength("DM", d) for d in DIAMETERS]
    assert strengths == sorted(strengths, reverse=True)


# ---- rate and stress ----


def test_rate_is_that_of_a_twisted_wire():
    """Work of the force = energy of torsion in a wire of length pi D n with the torque F D/2."""
    one = spring()
    length, polar = math.pi * 0.028 * 6.0, math.pi * 0.004**4 / 32.0
    deflection = (0.028 / 2.0) ** 2 * length / (one.shear_modulus * polar)  # per newton
    assert one.rate == pytest.approx(1.0 / deflection, rel=1e-12)


def test_stress_is_that_of_a_twisted_wire():
    torque, polar = 300.0 * 0.014, math.pi * 0.004**4 / 32.0
    assert spring().stress(300.0) == pytest.approx(torque * 0.002 / polar, rel=1e-12)


@pytest.mark.parametrize("index", [4.0, 6.0, 9.0, 12.0, 20.0])
def test_correction_is_close_to_that_of_wahl(index):
    """Another factor for the same curvature; textbooks give a difference of at most 1.4 %."""
    wahl = (4.0 * index - 1.0) / (4.0 * index - 4.0) + 0.615 / index
    assert spring(coil_diameter=index * 0.004).correction == pytest.approx(wahl, rel=0.014)


def test_music_wire_spring_of_the_textbook():
    """Shigley's Mechanical Engineering Design, problem 10-3: wire 2.5 mm, outer diameter 31 mm, 13 active
    coils, G = 81 GPa: C = 11.4, rate 1.314 N/mm, K_B = 1.117, and 167.9 N at the stress 871.2 MPa."""
    one = spring(
        wire_diameter=0.0025, coil_diameter=0.0285, active_coils=13.0, shear_modulus=81e9, total_coils=14.0
    )
    assert one.index == pytest.approx(11.4)
    assert one.rate == pytest.approx(1314.0, rel=5e-4)
    assert one.correction == pytest.approx(1.117, rel=5e-4)
    assert one.corrected_stress(167.9) == pytest.approx(871.2e6, rel=1e-3)
    assert one.solid_length == pytest.approx(0.035)


def test_lengths_and_mass_by_hand():
    one = spring()  # 8 coils of 4 mm; gap 0.0015 * 28^2/4 + 0.4 = 0.694 mm for each of 6 active coils
    assert one.solid_length == pytest.approx(0.032)
    assert one.least_length == pytest.approx(0.032 + 1.5 * 6.0 * 0.694e-3)
    assert one.mass == pytest.approx(7850.0 * 8.0 * math.pi * 0.028 * math.pi * 0.002**2)


# ---- fatigue ----


def test_strength_of_the_textbook():
    """Shigley, problem 10-24, Goodman with Zimmerli's data: S_ut = 244.363 kpsi gives S_se = 52.706 kpsi, the
    amplitude of the line through the point, extended to mean stress 0."""
    wire = spring(grade=None, tensile_strength=244.363 * KPSI)
    cycle = wire.fatigue(10.0, 100.0)
    at_zero = cycle.strength / (1.0 - cycle.knee / cycle.shear_strength)
    assert at_zero == pytest.approx(52.706 * KPSI, rel=2e-3)  # 35 and 55 kpsi are 241 and 379 MPa
    assert cycle.shear_strength == pytest.approx(163.723 * KPSI, rel=1e-4)


def test_the_line_passes_through_the_measurements_of_zimmerli():
    for peened, (amplitude, mean) in {False: (241e6, 379e6), True: (398e6, 534e6)}.items():
        one = spring(shot_peened=peened)
        force = 1.0 / one.corrected_stress(1.0)  # N per Pa
        cycle = one.fatigue(force * (mean - amplitude), force * (mean + amplitude))
        assert (cycle.amplitude, cycle.mean) == pytest.approx((amplitude, mean))
        assert cycle.safety == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("least", [0.0, 60.0, 120.0, 300.0, 450.0])
@pytest.mark.parametrize("peened", [False, True])
def test_safety_is_the_factor_up_to_the_line(least, peened):
    """Amplitude and mean stress times the safety lie on the line of three points: (0, amplitude), Zimmerli's
    point, (shear strength, 0)."""
    one = spring(shot_peened=peened)
    cycle, (amplitude, mean) = (
        one.fatigue(least, 480.0),
        {False: (241e6, 379e6), True: (398e6, 534e6)}[peened],
    )
    allowed = np.interp(
        cycle.safety * cycle.mean, [0.0, mean, 0.67 * one.strength], [amplitude, amplitude, 0.0]
    )
    assert cycle.safety * cycle.amplitude == pytest.approx(allowed, rel=1e-12)
    assert (cycle.upper - cycle.lower) * 480.0 == pytest.approx(cycle.upper * (480.0 - least))


def test_safety_where_the_mean_stress_has_no_effect():
    """Shigley's Mechanical Engineering Design (8th edition), example 10-4(b), Zimmerli's data with Sines: the
    mean stress is below Zimmerli's, n_f = 35/29.7 = 1.18."""
    wire = HelicalSpring(0.092 * INCH, 0.4705 * INCH, 21.0, tensile_strength=284.1 * KPSI)
    assert wire.fatigue(5.0 * POUND, 35.0 * POUND).safety == pytest.approx(1.18, abs=0.005)


@pytest.mark.parametrize("peened", [False, True])
@pytest.mark.parametrize("least", [0.0, 100.0, 200.0, 350.0])
def test_a_weaker_wire_is_never_safer(peened, least):
    """Down to just above the weakest wire that Zimmerli's strength allows."""
    weakest = {False: 379e6, True: 534e6}[peened] / 0.67
    wires = [
        spring(grade=None, tensile_strength=strength, shot_peened=peened)
        for strength in np.geomspace(1.0001 * weakest, 3e9, 60)
    ]
    safeties = [one.fatigue(least, 400.0).safety for one in wires]
    assert (np.diff(safeties) >= -1e-12).all() and safeties[0] < safeties[-1] * (1.0 + 1e-9)


def test_special_cycles():
    assert math.isinf(spring().fatigue(0.0, 0.0).safety)
    still = spring().fatigue(300.0, 300.0)
    assert still.safety == pytest.approx(still.shear_strength / still.upper)
    given = spring(fatigue_strength=400e6).fatigue(0.0, 200.0)
    assert given.strength == 400e6


# ---- buckling ----


def test_slenderness_below_which_no_spring_buckles():
    """Shigley, 10-12: L_0 < (pi D/alpha) sqrt(2 (E - G)/(2 G + E)); alpha = 0.5 between parallel plates."""
    elastic, shear = 206e9, 81.5e9
    longest = math.pi * 0.028 / 0.5 * math.sqrt(2.0 * (elastic - shear) / (2.0 * shear + elastic))
    assert math.isinf(spring().buckling_deflection(0.999 * longest))
    assert 0.0 < spring().buckling_deflection(1.001 * longest) < longest
    assert math.isinf(spring(guided=True).buckling_deflection(3.0 * longest))


def test_a_long_spring_buckles_like_a_column():
    """For L_0 far above D Euler's force between clamped ends is left. The coil has the bending stiffness
    E d^4 L_0/(32 n D (2 + nu)): S. Timoshenko, Strength of Materials, helical springs under bending."""
    one, length = spring(active_coils=200.0), 3.0
    poisson = 206.0 / (2.0 * 81.5) - 1.0
    bending = 206e9 * 0.004**4 * length / (32.0 * 200.0 * 0.028 * (2.0 + poisson))
    force = math.pi**2 * bending / (length / 2.0) ** 2
    assert one.rate * one.buckling_deflection(length) == pytest.approx(force, rel=0.01)


# ---- refusals ----


@pytest.mark.parametrize(
    "values, words",
    [
        ({"wire_diameter": -0.004}, "wire_diameter = -0.004: allowed is a number from 1e-06 to 1 in m"),
        ({"coil_diameter": 0.003}, "coil_diameter = 0.003 m: allowed is more than wire_diameter = 0.004 m"),
        ({"active_coils": 1.5}, "active_coils = 1.5: allowed is a number from 2 to 10000"),
        ({"active_coils": math.nan}, "active_coils = nan: allowed is a number from 2 to 10000"),
        ({"total_coils": 5.0}, "total_coils = 5: allowed is active_coils = 6 or more"),
        (
            {"grade": None},
            'no material: give grade = "DH", or SL, SM, DM or SH of EN 10270-1, or tensile_strength',
        ),
        ({"grade": "music"}, "grade = 'music': allowed are SL, SM, DM, SH, DH of EN 10270-1"),
        ({"wire_diameter": 0.022, "coil_diameter": 0.2}, "grade SH is known from 0.3 to 20 mm"),
        ({"grade": "SL", "wire_diameter": 0.0009}, "grade SL is known from 1 to 10 mm"),
        ({"grade": None, "tensile_strength": 500e6}, "tensile_strength = 5e+08 Pa: too low for Zimmerli"),
        ({"fatigue_strength": 0.0}, "fatigue_strength = 0: allowed is a number from 1000 to 1e+11 in Pa"),
    ],
)
def test_refused_springs(values, words):
    with pytest.raises(DesignError) as error:
        spring(**values)
    assert words in str(error.value)


@pytest.mark.parametrize("forces", [(-1.0, 100.0), (200.0, 100.0), (0.0, math.inf), (math.nan, 1.0)])
def test_refused_forces(forces):
    with pytest.raises(DesignError, match="allowed are 0 <= least <= largest, finite"):
        spring().fatigue(*forces)


def test_refused_length():
    with pytest.raises(DesignError, match=r"free_length = 0.0: allowed is a finite number > 0 in m"):
        spring().buckling_deflection(0.0)


def test_other_units_are_guessed():
    with pytest.raises(DesignError, match=r"this looks like MPa; 1800 MPa is 1.8e"):
        spring(grade=None, tensile_strength=1800.0)
    with pytest.raises(DesignError, match=r"this looks like GPa; 81.5 GPa is 8.15e"):
        spring(shear_modulus=81.5)
    with pytest.warns(UnitWarning, match="coil_diameter = 28 m: this looks like millimetres"):
        spring(coil_diameter=28.0)


# ---- search ----

TASK = {"preload": 150.0, "stiffness": 40e3, "stroke": 0.017}
SPACE = {"outer_diameter": 0.045, "inner_diameter": 0.018, "free_length": 0.09}


@pytest.fixture(scope="module")
def found():
    return find_springs(**TASK, **SPACE, grade="SH", shot_peened=True, safety=1.3, count=100)


def test_each_spring_found_does_the_task(found):
    largest = 150.0 + 40e3 * 0.017
    assert len(found) >= 2
    assert [one.mass for one in found] == sorted(one.mass for one in found)
    for one in found:
        index = one.coil_diameter / one.wire_diameter
        assert one.wire_diameter in DIAMETERS and 4.0 <= index <= 20.0
        assert 81.5e9 * one.wire_diameter**4 / (
            8.0 * one.coil_diameter**3 * one.active_coils
        ) == pytest.approx(40e3)
        assert one.fatigue(150.0, largest).safety >= 1.3
        assert 1.3 * one.stress(largest) <= 0.56 * tensile_strength("SH", one.wire_diameter)
        assert one.coil_diameter + one.wire_diameter <= 0.045
        assert one.coil_diameter - one.wire_diameter >= 0.018
        free = one.least_length + largest / 40e3
        assert free <= 0.09 and one.buckling_deflection(free) > largest / 40e3


def test_no_spring_tried_at_random_is_lighter(found):
    largest, rng = 150.0 + 40e3 * 0.017, np.random.default_rng(3)
    tried = 0
    for d, half_coils in zip(rng.choice(DIAMETERS, 4000), rng.integers(4, 41, 4000), strict=True):
        coil = (81.5e9 * d**4 / (8.0 * 0.5 * half_coils * 40e3)) ** (1.0 / 3.0)
        if not 4.0 <= coil / d <= 20.0:
            continue
        one = HelicalSpring(d, coil, 0.5 * half_coils, grade="SH", shot_peened=True)
        free = one.least_length + largest / 40e3
        fits = coil + d <= 0.045 and coil - d >= 0.018 and free <= 0.09
        lasts = one.fatigue(150.0, largest).safety >= 1.3 and 1.3 * one.stress(largest) <= one.allowed_stress
        if fits and lasts and one.buckling_deflection(free) > largest / 40e3:
            tried += 1
            assert one.mass >= found[0].mass * (1.0 - 1e-12)
    assert tried > 5


@pytest.mark.parametrize(
    "values, words",
    [
        ({"stroke": 0.0}, "stroke = 0.0: allowed is a finite number > 0"),
        ({"stiffness": -1.0}, "stiffness = -1.0: allowed is a finite number > 0"),
        ({"preload": math.nan}, "preload = nan: allowed is a finite force >= 0 in N"),
        ({"grade": "X"}, "grade = 'X': allowed are SL, SM, DM, SH, DH of EN 10270-1"),
        ({"outer_diameter": 0.004}, "most fail by"),
        ({"stiffness": 1e9}, "no spring of grade DH in standard wire diameters carries 150 to"),
    ],
)
def test_refused_tasks(values, words):
    with pytest.raises(DesignError) as error:
        find_springs(**TASK | values)
    assert words in str(error.value)
