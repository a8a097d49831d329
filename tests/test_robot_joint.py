"""The robot joint: data, blocks of dualcam.systems and results against facts from outside."""

import math
from dataclasses import replace
from pathlib import Path

import control
import numpy as np
import pytest

from dualcam import Fmu
from dualcam.systems.blocks.current_loop import CurrentLoop
from dualcam.systems.blocks.gravity import GravityLoad
from dualcam.systems.blocks.helical_cam import HelicalCam, fit_spring
from dualcam.systems.blocks.motions import PickAndPlace
from dualcam.systems.blocks.motor import AK80_6 as MOTOR
from dualcam.systems.blocks.position_controller import lqi_gains
from dualcam.systems.machines import elbow
from dualcam.systems.machines.robot_arm import ELBOW_SPEED_LIMIT, arm_inertia
from system_examples import robot_joint as example

ROOT = Path(__file__).resolve().parent.parent
FMU = ROOT / "build" / "DualCamForward.fmu"
BARE, CAM, NAIVE = example.BARE, example.CAM, example.NAIVE


@pytest.fixture(scope="module")
def results():
    return example.run(FMU)


# ---- data ----


@pytest.mark.parametrize(("payload", "torque"), [(0.0, 6.35), (1.5, 9.5), (3.0, 12.6)])
def test_gravity_with_the_arm_horizontal(payload, torque):
    assert elbow.horizontal_torque(payload) == pytest.approx(torque, rel=0.005)


def test_inertia_is_that_of_point_masses_plus_the_forearms_own():
    points = 1.437 * 0.1632**2 + (0.871 + 0.805 + 0.261 + 1.5) * 0.2132**2
    assert arm_inertia(1.5) - points == pytest.approx(6.5446e-3, rel=1e-4)


def test_motor_figures_agree_with_each_other():
    assert pytest.approx(0.34e-3, rel=0.02) == MOTOR.electrical_time_constant
    assert pytest.approx(2.186e-3, rel=1e-3) == MOTOR.inertia
    assert MOTOR.output_constant * MOTOR.peak_speed < MOTOR.voltage  # the voltage reaches the rated top speed


# ---- current loop ----


def loop():
    return CurrentLoop(MOTOR, bandwidth=1e3, rate=20e3, control_period=1e-3)


def test_current_loop_has_the_designed_pole_and_a_cancelled_winding():
    pi = loop()
    winding = control.c2d(control.tf([1], [MOTOR.inductance, MOTOR.resistance]), pi.sample_period)
    z = control.tf([1, 0], [1], pi.sample_period)
    closed = control.feedback(winding * (pi.proportional + pi.integral / (z - 1)))
    poles = np.sort(control.poles(closed).real)
    assert poles == pytest.approx(sorted([math.exp(-2 * math.pi / 20), pi.pole]), rel=1e-9)
    assert control.zeros(closed).real == pytest.approx(pi.pole, rel=1e-9)


def test_current_step_is_the_closed_form():
    pi, torque = loop(), 3.0
    pi.samples = 1  # look after every sample of the PI
    reference = torque / MOTOR.output_constant
    for k in range(1, 30):
        pi.run(torque, speed=2.0)
        expected = reference * (1 - math.exp(-2 * math.pi * 1e3 * k / 20e3))
        assert pi.current == pytest.approx(expected, rel=1e-12)


def test_current_loop_accounts_for_every_joule():
    pi, speed = loop(), 4.0
    rng = np.random.default_rng(1)
    supplied = heat = work = 0.0
    for torque in rng.uniform(-15.0, 15.0, 200):
        tick = pi.run(torque, speed)
        supplied, heat, work = supplied + tick.energy, heat + tick.heat, work + tick.torque * speed * 1e-3
    stored = 0.5 * MOTOR.inductance * pi.current**2
    assert supplied == pytest.approx(heat + work + stored, rel=1e-12)


def test_motor_keeps_its_limits():
    pi = loop()
    for torque in (1e3, -1e3, 1e3):
        for _ in range(5):
            assert pi.run(torque, speed=0.0).peak_torque <= MOTOR.peak_torque * (1 + 1e-12)
    weak = CurrentLoop(replace(MOTOR, voltage=1.0), bandwidth=1e3, rate=20e3, control_period=1e-3)
    for _ in range(100):
        last = weak.run(12.0, speed=0.0)
    all_the_voltage_gives = 1.0 / MOTOR.resistance * MOTOR.output_constant
    assert last.torque == pytest.approx(all_the_voltage_gives)
    for _ in range(3):
        last = weak.run(1.0, speed=0.0)
    assert last.torque == pytest.approx(1.0, rel=0.01)  # nothing wound up meanwhile


# ---- position controller, motion, loads ----


def test_lqi_gains_become_butterworth_as_the_period_shrinks():
    w = 2 * math.pi * 8.0
    assert lqi_gains(8.0, dt=1e-3) == lqi_gains(8.0, period=1e-3)
    with pytest.raises(ValueError, match="period and dt mean the same"):
        lqi_gains(8.0, period=1e-3, dt=1e-3)
    assert lqi_gains(8.0, 1e-6) == pytest.approx((2 * w**2, 2 * w, w**3), rel=1e-4)


def test_lqi_places_the_sampled_poles_at_the_bandwidth():
    period, w = 1e-3, 2 * math.pi * 8.0
    k = np.array([lqi_gains(8.0, period)])
    plant = np.array([[1, period, 0], [0, 1, 0], [period, 0, 1]])
    poles = np.linalg.eigvals(plant - np.array([[period**2 / 2], [period], [0]]) @ k)
    assert np.abs(np.log(poles)) / period == pytest.approx(w, rel=0.01)


def test_motion_is_consistent_and_rests_at_its_ends():
    motion = PickAndPlace(start=0.2, end=1.2, move=0.8, dwell=0.3)
    time = np.linspace(0.0, 2 * motion.period, 200_001)
    theta, omega = motion.sample(time)
    assert np.max(np.abs(np.gradient(theta, time) - omega)) < 1e-6
    assert np.max(np.abs(omega)) == pytest.approx(motion.peak_speed, rel=1e-6)
    assert np.max(np.abs(np.gradient(omega, time))) == pytest.approx(motion.peak_acceleration, rel=1e-4)
    assert (theta.min(), theta.max()) == pytest.approx((0.2, 1.2))
    assert theta[time < 0.3] == pytest.approx(0.2)
    assert theta[-1] == pytest.approx(0.2)


def test_gravity_torque_is_minus_the_slope_of_its_energy():
    load = GravityLoad(moment=0.7, lean=0.2)
    for angle in (0.0, 0.5, 1.3):
        slope = (load.energy(angle + 1e-6) - load.energy(angle - 1e-6)) / 2e-6
        assert load.torque(angle) == pytest.approx(-slope, rel=1e-8)


def test_helix_statics_at_the_optimum():
    cam = HelicalCam((0.02, 0.02), (math.pi / 4,) * 2, (0.14, 0.14), preload=100.0)
    assert cam.band(0.3) == pytest.approx((0.75438596491228, 1.32558139534884), rel=1e-12)
    assert cam.efficiency == pytest.approx((0.86 / 1.14) ** 2, rel=1e-12)


def test_spring_design_recovers_an_affine_load():
    cam = fit_spring(elbow.HELIX, lambda angle: 2.0 + 5.0 * angle, 0.0, 1.4)
    for angle in (0.0, 0.6, 1.4):
        assert 0.5 * sum(cam.band(angle)) == pytest.approx(2.0 + 5.0 * angle, rel=1e-9)


def test_design_load_lies_inside_the_stick_band_everywhere():
    cam, load = elbow.design_cam(), elbow.weight(elbow.DESIGN_PAYLOAD)
    for angle in np.linspace(0.0, elbow.RANGE, 50):
        release, edge = cam.band(angle)
        assert release < load.torque(angle) < edge


# ---- the joint ----


def test_fmu_and_controller_agree_on_the_stick_band():
    cam = elbow.design_cam()
    with Fmu(FMU) as slave:
        for angle in (0.0, 0.7, 1.3):
            slave.start({**cam.parameters(), "initial.theta": angle})
            assert cam.band(angle) == pytest.approx((slave.get("torque_release"), slave.get("torque_load")))


def test_energy_closes(results):
    for result in results.values():
        assert (
            np.max(np.abs(result.full_record.ledger["residual"]))
            <= 1e-12 * result.full_record.transferred_energy
        )


def test_work_into_the_cam_is_the_motors_and_gravitys(results):
    for result in results.values():
        done = np.sum(result.full_record.motor_work) + np.sum(result.full_record.load_work)
        assert result.full_record.ledger["work_in"][-1] == pytest.approx(done, abs=1e-9)


def test_gravity_does_no_work_over_a_cycle_and_its_potential_in_between(results):
    for (payload, _), result in results.items():
        if not result.lifts:
            continue
        work = np.cumsum(result.full_record.load_work)
        load = elbow.weight(payload)
        potential = load.energy(elbow.MOTION.start) - np.array(
            [load.energy(x) for x in result.full_record.angle]
        )
        assert work == pytest.approx(potential, abs=1e-5)


def test_supply_pays_for_motor_heat_and_friction_only(results):
    for result in results.values():
        if result.lifts:
            assert result.electric_energy == pytest.approx(result.joule_heat + result.friction_heat, rel=2e-3)


def test_friction_heat_is_the_area_of_the_band(results):
    cam = elbow.design_cam()
    first, last = cam.band(elbow.MOTION.start), cam.band(elbow.MOTION.end)
    width = 0.5 * (first[1] - first[0] + last[1] - last[0])
    area = width * (elbow.MOTION.end - elbow.MOTION.start)
    assert elbow.friction_heat_of_slow_cycle(cam) == pytest.approx(area, rel=1e-12)
    for (_, joint), result in results.items():
        if joint == CAM:
            assert result.friction_heat == pytest.approx(area, rel=1e-3)
        if joint == BARE:
            assert result.friction_heat == 0.0


def test_limits_are_kept(results):
    for result in results.values():
        assert np.max(result.full_record.peak_torque) <= MOTOR.peak_torque * (1 + 1e-12)
        assert np.max(np.abs(result.full_record.speed)) < ELBOW_SPEED_LIMIT < MOTOR.peak_speed
        assert np.min(result.full_record.angle) >= 0.0
        assert np.max(result.full_record.angle) <= elbow.RANGE


def test_tracking(results):
    for (_, joint), result in results.items():
        if result.lifts and joint != NAIVE:
            assert result.max_error < elbow.REST.tolerance
    assert results[1.5, NAIVE].max_error > 10 * results[1.5, CAM].max_error


def test_motor_alone_cannot_carry_3_kg(results):
    assert [key for key, result in results.items() if not result.lifts] == [(3.0, BARE)]
    assert elbow.horizontal_torque(3.0) > MOTOR.peak_torque


def test_cam_saves_motor_heat(results):
    for payload in (0.0, 1.5):
        assert results[payload, CAM].joule_heat < 0.5 * results[payload, BARE].joule_heat
    rated = MOTOR.rated_torque / MOTOR.output_constant
    assert results[1.5, BARE].rms_current > rated > results[1.5, CAM].rms_current


def test_cam_costs_what_the_text_says(results):
    assert results[0.0, CAM].largest_torque > results[0.0, BARE].largest_torque
    assert results[1.5, CAM].max_error > results[1.5, BARE].max_error
    assert results[1.5, NAIVE].joule_heat > 2 * results[1.5, CAM].joule_heat


def test_holding_is_free_inside_the_band(results):
    assert results[1.5, CAM].hold_current < 1e-3
    weight = elbow.horizontal_torque(1.5) * math.sin(math.radians(10) + elbow.MOTION.end)
    assert results[1.5, BARE].hold_current == pytest.approx(weight / MOTOR.output_constant, rel=1e-3)
    assert results[0.0, CAM].hold_current > 1.0  # too light for this spring
