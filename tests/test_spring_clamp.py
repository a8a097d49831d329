"""The spring clamp that warms up: grease, network, closed loop and page against facts from outside them."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import CubicSpline

from dualcam import Fmu
from dualcam.errors import DesignError, DualcamError
from dualcam.systems.blocks.grease import CELSIUS, BaseOil, GreasedContact
from dualcam.systems.blocks.thermal_network import ThermalState, TwoMassNetwork
from dualcam.systems.machines import clamp
from dualcam.systems.machines.clamp import GREASE, HALL, MOTION, NETWORK
from system_examples import spring_clamp as example

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
FMU = ROOT / "build" / "DualCamForward.fmu"
WARMING, COLD = example.WARMING, example.COLD


@pytest.fixture(scope="module")
def results():
    return example.run(FMU)


# ---- the grease ----


def walther(oil, temperature):
    """Kinematic viscosity by ASTM D341, from the two numbers of a data sheet [mm2/s]."""
    heights = [math.log10(math.log10(nu + 0.7)) for nu in (oil.viscosity_40, oil.viscosity_100)]
    slope = (heights[0] - heights[1]) / math.log10(373.15 / 313.15)
    return 10.0 ** (10.0 ** (heights[0] - slope * math.log10(temperature / 313.15))) - 0.7


OILS = [(110.0, 11.0), (100.0, 11.4), (220.0, 19.0), (46.0, 6.8), (32.0, 5.4)]


@pytest.mark.parametrize("numbers", OILS)
def test_viscosity_is_that_of_the_data_sheet(numbers):
    oil = BaseOil(*numbers, density=900.0)
    for celsius, nu in zip((40.0, 100.0), numbers, strict=True):
        assert oil.viscosity(CELSIUS + celsius) == pytest.approx(900.0 * nu * 1e-6, rel=1e-12)
    assert oil.viscosity(CELSIUS) == pytest.approx(900.0 * walther(oil, CELSIUS) * 1e-6, rel=1e-12)


@pytest.mark.parametrize("numbers", OILS)
def test_vogels_law_and_astm_d341_agree_to_two_percent(numbers):
    oil = BaseOil(*numbers, density=900.0)
    for celsius in range(0, 121, 5):
        expected = 900.0 * walther(oil, CELSIUS + celsius) * 1e-6
        assert oil.viscosity(CELSIUS + celsius) == pytest.approx(expected, rel=0.021)


def test_vogels_pole_is_where_mineral_oils_have_theirs():
    """About -95 degC: the constant of A. Cameron, Principles of Lubrication (1966)."""
    for numbers in OILS:
        assert -106.0 < BaseOil(*numbers).vogel[2] - CELSIUS < -90.0


def test_friction_depends_on_viscosity_times_speed():
    """So a temperature that halves the viscosity is the same as half the speed: one Stribeck curve."""
    for temperature in (HALL, CELSIUS + 23.0, CELSIUS + 70.0):
        ratio = GREASE.oil.relative_viscosity(temperature)
        for speed in (0.0, 1e-3, 0.01, 0.06):
            same = GREASE.coefficient(ratio * speed, CELSIUS + 40.0)
            assert GREASE.coefficient(speed, temperature) == pytest.approx(same, rel=1e-12)


def test_friction_is_that_of_the_fmu():
    with Fmu(FMU) as fmu:
        for temperature in (HALL, CELSIUS + 20.0):
            fmu.start(clamp.plant_parameters(temperature) | {"tau": 25.0})
            fmu.step(1e-6)
            assert fmu.real("cam1.friction_coefficient") > GREASE.kinetic
            for _ in range(40):
                fmu.step(5e-3)
                sliding = fmu.real("cam1.sliding_speed")
                if fmu.real("omega") == 0.0:
                    break
                assert abs(sliding) == pytest.approx(clamp.sliding_speed(fmu.real("omega")), rel=1e-12)
                expected = GREASE.coefficient(abs(sliding), temperature)
                assert fmu.real("cam1.friction_coefficient") == pytest.approx(expected, rel=1e-12)
                assert fmu.real("cam2.friction_coefficient") == pytest.approx(expected, rel=1e-12)


def test_a_thicker_oil_is_the_same_contact_at_a_higher_speed():
    """The rule of docs/use-temperature.md for another oil: one Stribeck curve over viscosity times speed."""
    old, new = BaseOil(110.0, 11.0, 900.0), BaseOil(220.0, 19.0, 880.0)
    ratio = new.viscosity(CELSIUS + 40.0) / old.viscosity(CELSIUS + 40.0)
    first = GreasedContact(old, 0.08, 1.5, 0.02, 0.25)
    second = GreasedContact(new, 0.08, 1.5, 0.02 / ratio, 0.25 * ratio)
    for temperature in (CELSIUS + 5.0, CELSIUS + 40.0, CELSIUS + 90.0):
        speed_ratio = new.viscosity(temperature) / old.viscosity(temperature)
        for speed in (1e-3, 0.02, 0.06):
            expected = first.coefficient(speed_ratio * speed, temperature)
            assert second.coefficient(speed, temperature) == pytest.approx(expected, rel=1e-12)


def test_torque_over_temperature_of_the_page():
    """docs/use-temperature.md: by hand, two helices of 45 deg with z = 0.01 m/rad theta, 50 N + 50 kN/m z."""
    page = (ROOT / "docs" / "use-temperature.md").read_text(encoding="utf-8")
    contact = GreasedContact(BaseOil(110.0, 11.0), 0.08, 1.5, 0.02, 0.25)
    shown = re.findall(r"^(\d+) degC: mu = ([\d.]+), ([\d.]+) N\.m$", page, re.MULTILINE)
    assert len(shown) == 5
    for celsius, coefficient, torque in shown:
        mu = contact.coefficient(0.01 * math.sqrt(2.0) * 2.0, CELSIUS + float(celsius))
        assert mu == pytest.approx(float(coefficient), abs=5.1e-4)
        expected = 0.01 * (1.0 + mu) / (1.0 - mu) * (50.0 + 50e3 * 0.01 * 0.7)
        assert expected == pytest.approx(float(torque), abs=5.1e-3)


# ---- the thermal network ----


def housing_rise(network, power):
    """Temperature of the housing above the air under a constant power from a cold start, in closed form.

    The roots of the characteristic polynomial, and the constants from value and slope at the start."""
    a = network.contact_conductance / network.contact_capacity
    b = network.contact_conductance / network.housing_capacity
    c = network.air_conductance / network.housing_capacity
    first, second = np.roots([1.0, a + b + c, a * c])
    settled = power / network.air_conductance
    # T(0) = 0 and T'(0) = 0: both masses start as warm as the air
    share = settled * second / (first - second)
    return lambda t: settled + share * np.exp(first * t) - (settled + share) * np.exp(second * t)


@pytest.mark.parametrize("duration", [1.0, 60.0, 1800.0, 36000.0])
def test_network_under_constant_power_is_the_closed_form(duration):
    power = 4.0
    state = NETWORK.advance(NETWORK.start(), power, duration)
    rise = housing_rise(NETWORK, power)
    assert state.housing - NETWORK.air == pytest.approx(rise(duration), rel=1e-9, abs=1e-10)
    lost, _ = quad(lambda t: NETWORK.air_conductance * rise(t), 0.0, duration, epsabs=1e-9, epsrel=1e-12)
    assert state.heat_out == pytest.approx(lost, rel=1e-9, abs=1e-9)
    assert state.heat_in == power * duration
    balance = state.heat_in - state.heat_out - NETWORK.stored(state)
    assert abs(balance) < 1e-11 * state.heat_in + 1e-9


def test_network_from_any_state_is_the_solution_of_its_equations():
    network = TwoMassNetwork(30.0, 200.0, 2.0, 0.7, air=290.0)
    begin = ThermalState(350.0, 300.0, 10.0, 5.0)

    def rates(_, y):
        across = network.contact_conductance * (y[0] - y[1])
        away = network.air_conductance * (y[1] - network.air)
        return [(6.0 - across) / network.contact_capacity, (across - away) / network.housing_capacity, away]

    end = solve_ivp(rates, (0.0, 90.0), [350.0, 300.0, 5.0], rtol=1e-11, atol=1e-9, method="DOP853").y[:, -1]
    found = network.advance(begin, 6.0, 90.0)
    assert (found.contact, found.housing, found.heat_out) == pytest.approx(tuple(end), rel=1e-8)
    halves = network.advance(network.advance(begin, 6.0, 30.0), 6.0, 60.0)
    assert found == pytest.approx(halves, rel=1e-12)


def test_network_settles_where_all_heat_leaves():
    settled = NETWORK.settled(5.0)
    far = NETWORK.advance(NETWORK.start(), 5.0, 1e6)
    assert (far.contact, far.housing) == pytest.approx((settled.contact, settled.housing), rel=1e-12)
    assert NETWORK.air_conductance * (settled.housing - NETWORK.air) == pytest.approx(5.0, rel=1e-12)
    assert NETWORK.advance(NETWORK.start(), 5.0, 0.0)[:2] == (NETWORK.air, NETWORK.air)


# ---- the closed loop ----


def test_heat_of_the_fmu_is_heat_in_the_masses_and_in_the_air(results):
    for record in results.values():
        end = record.thermal[-1]
        assert end.heat_in == pytest.approx(record.ledger_heat, rel=1e-12)
        assert sum(record.friction_heat) == pytest.approx(record.ledger_heat, rel=1e-12)
        kept = NETWORK.stored(end)
        assert end.heat_out + kept == pytest.approx(record.ledger_heat, rel=1e-11)
        assert 0.1 < end.heat_out / record.ledger_heat < 0.9
        assert abs(record.ledger_residual) < 1e-11 * record.ledger_heat


def screw_torque(theta, omega, temperature):
    """Textbook formula of a screw, tan(lead angle +- friction angle), half of the way for each cam."""
    mu = GREASE.coefficient(0.5 * abs(omega) * 0.025 / math.cos(math.pi / 4.0), temperature)
    force = clamp.PRELOAD + clamp.STIFFNESS * 0.5 * 0.025 * theta
    return 0.5 * 0.025 * math.tan(math.pi / 4.0 + math.copysign(math.atan(mu), omega)) * force


def test_torque_at_mid_stroke_is_that_of_a_screw_at_the_temperature(results):
    record = results[WARMING]
    for k in range(0, len(record.friction_heat), 7):
        temperature = record.thermal[k].contact
        for middle, direction in ((record.loading[k], 1.0), (record.releasing[k], -1.0)):
            assert math.copysign(1.0, middle.omega) == direction
            expected = screw_torque(middle.theta, middle.omega, temperature)
            found, formula = clamp.steady_middle(middle, temperature)
            assert found == pytest.approx(expected, rel=1e-9)
            assert formula == pytest.approx(expected, rel=1e-12)


def test_cold_friction_repeats_each_cycle_and_heats_as_a_constant_power(results):
    record = results[COLD]
    heats = np.array(record.friction_heat[1:])
    assert np.ptp(heats) < 1e-7
    assert np.ptp([middle.torque for middle in record.loading[1:]]) < 1e-6
    rise = housing_rise(NETWORK, float(heats[0]) / MOTION.period)
    for k in (100, 600, 1200):
        assert record.thermal[k].housing - HALL == pytest.approx(rise(k * MOTION.period), rel=1e-4)


def test_friction_falls_while_the_clamp_warms_up(results):
    warm, cold = results[WARMING], results[COLD]
    assert warm.friction_heat[0] == pytest.approx(cold.friction_heat[0], rel=1e-12)
    for falling in (warm.friction_heat[1:], [m.torque for m in warm.loading], warm.largest_error[1:]):
        assert np.all(np.diff(falling) < 0.0)
    assert np.all(np.diff([m.torque for m in warm.releasing]) > 0.0)
    assert np.all(np.diff([state.contact for state in warm.thermal]) > 0.0)
    assert warm.thermal[-1].contact < cold.thermal[-1].contact


def test_warm_up_is_that_of_the_heat_at_each_temperature(results):
    """Cycles at fixed temperatures give the power over the temperature. SciPy integrates the network with
    that power, without cycles."""
    temperatures = HALL + np.linspace(0.0, 20.0, 9)
    power = []
    with Fmu(FMU) as fmu:
        for temperature in temperatures:
            record, loop = clamp.WarmUp(), clamp.Clamp(fmu, float(temperature), clamp.Servo())
            loop.cycle(record)
            loop.cycle(record)
            power.append(record.friction_heat[-1] / MOTION.period)
    power_at = CubicSpline(temperatures, power)

    def rates(_, y):
        across = NETWORK.contact_conductance * (y[0] - y[1])
        away = NETWORK.air_conductance * (y[1] - NETWORK.air)
        return [
            (power_at(y[0]) - across) / NETWORK.contact_capacity,
            (across - away) / NETWORK.housing_capacity,
        ]

    minutes = np.array([5.0, 20.0, 60.0])
    expected = solve_ivp(rates, (0.0, 3600.0), [HALL, HALL], t_eval=60.0 * minutes, rtol=1e-8).y
    for column, minute in enumerate(minutes):
        state = results[WARMING].thermal[round(60.0 * minute / MOTION.period)]
        assert state[:2] == pytest.approx(tuple(expected[:, column]), abs=0.1)


def test_the_stick_band_stays_while_the_clamp_warms_up():
    """The boundary layer carries the load at rest."""
    bands = []
    with Fmu(FMU) as fmu:
        loop = clamp.Clamp(fmu, HALL, clamp.Servo())
        for temperature in (HALL, HALL + 20.0):
            loop.warm_to(temperature)
            bands.append((fmu.real("torque_release"), fmu.real("torque_load")))
    assert bands[0] == bands[1]
    static = math.atan(0.12)
    expected = [0.0125 * 500.0 * math.tan(math.pi / 4.0 + sign * static) for sign in (-1.0, 1.0)]
    assert bands[0] == pytest.approx(tuple(expected), rel=1e-12)


def test_fmi_3_gives_the_same_run():
    ends = []
    for version in (2, 3):
        with Fmu("forward", fmi=version) as fmu:
            ends.append(clamp.run(fmu, 10).thermal[-1])
    assert ends[0] == ends[1]


# ---- bad input ----


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (lambda: BaseOil(0.0, 11.0), "viscosity_40"),
        (lambda: BaseOil(10.0, 11.0), "viscosity_40"),
        (lambda: BaseOil(110.0, math.nan), "viscosity_100"),
        (lambda: BaseOil(110.0, 11.0, density=-1.0), "density"),
        (lambda: GREASE.oil.viscosity(CELSIUS - 30.0), "temperature"),
        (lambda: GREASE.law(CELSIUS + 130.0), "0 to 120 degC"),
        (lambda: GREASE.coefficient(0.0, math.nan), "temperature"),
        (lambda: GREASE.oil.viscosity(40.0), r"temperature = 40 K: is this degC\? Add 273.15"),
        (lambda: BaseOil("110", 11.0), "viscosity_40 = '110'.*without quotes"),
        (lambda: BaseOil(110.0, None), "viscosity_100 = None"),
        (lambda: GreasedContact(GREASE.oil, 0.1, 0.9, 0.02, 0.0), "peak"),
        (lambda: GreasedContact(GREASE.oil, 0.1, 1.5, 0.0, 0.0), "stribeck_velocity"),
        (lambda: GreasedContact(GREASE.oil, 0.1, 1.5, 0.02, -1.0), "viscous"),
        (lambda: TwoMassNetwork(0.0, 1.0, 1.0, 1.0, 300.0), "contact_capacity"),
        (lambda: TwoMassNetwork(1.0, 1.0, 1.0, math.inf, 300.0), "air_conductance"),
        (lambda: TwoMassNetwork(1.0, 1.0, 1.0, 1.0, 5.0), r"air = 5 K: is this degC\? .* air = 278.15"),
        (lambda: TwoMassNetwork(1.0, 1.0, 1.0, 1.0, -20.0), r"is this degC\? .* air = 253.15"),
        (lambda: TwoMassNetwork(1.0, 1.0, 1.0, 1.0, "5 degC"), "air = '5 degC'"),
        (lambda: NETWORK.advance(NETWORK.start(), 1.0, -1.0), "duration"),
        (lambda: NETWORK.advance(NETWORK.start(), math.nan, 1.0), "power"),
    ],
)
def test_bad_input_is_named(wrong, told):
    with pytest.raises(DesignError, match=told):
        wrong()


def test_the_clamp_needs_the_forward_fmu():
    with Fmu("inverse") as fmu, pytest.raises(DualcamError):
        clamp.run(fmu, 1)


# ---- page and command ----


def test_table_of_the_page(results):
    """docs/examples.md shows the figures that the example prints."""
    rows = re.findall(r"^\| (follows|stays cold) \| (\d+) min \| (.*) \|$", PAGE, re.MULTILINE)
    names = {"follows": WARMING, "stays cold": COLD}
    assert {(case, int(minute)) for case, minute, _ in rows} == {
        (case, minute)
        for case, minutes in (("follows", example.MINUTES), ("stays cold", (0, 20, 60)))
        for minute in minutes
    }
    for case, minute, cells in rows:
        record = results[names[case]]
        assert [cell.strip() for cell in cells.split("|")] == example.result_row(
            record, example.cycle_at(int(minute), record)
        )
