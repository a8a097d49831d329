"""The car door: weight, design, holding, closing speed and energy against facts from outside it."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from case_studies import car_door as report
from dualcam import Fmu
from dualcam.systems.blocks.gravity import hinged_load, vertical_in_car
from dualcam.systems.blocks.helical_cam import holding_torque
from dualcam.systems.machines import car_door
from dualcam.systems.machines.car_door import MOTION, MOTOR, RATIO
from system_examples import car_door as example

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
FMU = ROOT / "build" / "DualCamForward.fmu"
STEP = 1e-3  # s, control period
BARE, CAM, UNDAMPED = report.BARE, report.CAM, report.UNDAMPED
ATTITUDES = car_door.ATTITUDES | car_door.ATTITUDES_NOT_DESIGNED_FOR


@pytest.fixture(scope="module")
def results():
    return report.run(FMU)


@pytest.fixture(scope="module")
def slave():
    with Fmu(FMU) as one:
        yield one


# ---- the weight about the hinge ----


def weight_by_vectors(angle, pitch, roll):
    """Moment of the weight about the hinge, axis.(r x F): door turned about the hinge, car about its axes."""
    lower, upper = car_door.HINGE
    axis = (upper - lower) / np.linalg.norm(upper - lower)
    centre = Rotation.from_rotvec(angle * axis).apply(car_door.CENTRE - lower)
    car = Rotation.from_euler("X", roll) * Rotation.from_euler("Y", pitch)
    weight = np.array([0.0, 0.0, -9.81 * car_door.MASS])
    return car.apply(axis) @ np.cross(car.apply(centre), weight)


@pytest.mark.parametrize("attitude", ATTITUDES)
def test_weight_is_the_moment_about_the_hinge(attitude):
    load = car_door.weight(attitude)
    for angle in np.linspace(-0.3, 1.5, 37):
        assert load.torque(angle) == pytest.approx(weight_by_vectors(angle, *ATTITUDES[attitude]), abs=1e-12)


def test_weight_of_any_body_in_any_attitude():
    rng = np.random.default_rng(3)
    for _ in range(50):
        lower, upper, centre = rng.normal(size=(3, 3))
        pitch, roll, angle = rng.uniform(-1.0, 1.0, 3)
        load = hinged_load(2.0, (lower, upper), centre, vertical_in_car(pitch, roll))
        axis = (upper - lower) / np.linalg.norm(upper - lower)
        car = Rotation.from_matrix(Rotation.from_euler("XY", [roll, pitch]).as_matrix())

        def height(turn, car=car, axis=axis, arm=centre - lower):
            return car.apply(Rotation.from_rotvec(turn * axis).apply(arm))[2]

        h = 0.02  # sixth-order central difference of the potential energy
        slope = sum(
            c * (height(angle + k * h) - height(angle - k * h)) / h
            for k, c in ((1, 3 / 4), (2, -3 / 20), (3, 1 / 60))
        )
        assert load.torque(angle) == pytest.approx(-2.0 * 9.81 * slope, abs=1e-8)


@pytest.mark.parametrize(
    ("attitude", "torques"),
    [
        (car_door.LEVEL, (-6.0296, -6.3373, -4.4096)),
        (car_door.NOSE_UP, (-1.8978, -20.8881, -36.1709)),
        (car_door.NOSE_DOWN, (-9.9065, 8.4814, 27.5381)),
        (car_door.SIDE_DOWN, (13.3853, 11.5489, 5.1507)),
        (car_door.SIDE_UP, (-25.3724, -24.1477, -13.9171)),
    ],
)
def test_weight_agrees_with_the_sources_own_model(attitude, torques):
    """At 0, 30 and 67 deg, by the model that the data come from (jandaa/door-model, MIT), to its digits."""
    load = car_door.weight(attitude)
    for degrees, torque in zip((0.0, 30.0, 67.0), torques, strict=True):
        assert load.torque(math.radians(degrees)) == pytest.approx(torque, abs=5.1e-5)


def test_geometry_of_the_door():
    lower, upper = car_door.HINGE
    axis = (upper - lower) / np.linalg.norm(upper - lower)
    arm = np.linalg.norm(np.cross(axis, car_door.CENTRE - lower))
    assert pytest.approx(arm, abs=1e-5) == car_door.ARM
    assert pytest.approx(9.165 + 36.1736 * 0.0625, rel=1e-4) == car_door.DOOR_INERTIA
    assert car_door.hinge_tilt() == pytest.approx(2.06, abs=0.005)


def test_smallest_holding_torque():
    assert holding_torque((-2.0, 5.0), 1.0, margin=0.5) == 0.0
    assert holding_torque((-2.0, 5.0), 6.0, margin=0.5) == pytest.approx(-1.5)
    assert holding_torque((-2.0, 5.0), -4.0, margin=0.5) == pytest.approx(2.5)


# ---- the design ----


def edges(angle, friction=car_door.FRICTION):
    """The band about the hinge of two equal helices, N (r/2) tan(lambda +- phi) F, from the statics."""
    cam = car_door.design().cam
    lead, phi = cam.lead_angle[0], math.atan(friction)
    lift = 0.5 * car_door.RADIUS * math.tan(lead)  # of z by theta
    force = cam.preload + cam.stiffness * lift * RATIO * (car_door.OPEN - angle)
    arm = RATIO * 0.5 * car_door.RADIUS
    return -arm * math.tan(lead + phi) * force, -arm * math.tan(lead - phi) * force


def test_band_is_that_of_the_statics_and_of_the_fmu(slave):
    hold = car_door.design()
    door = car_door.door_axis(slave)
    for angle in (0.0, 0.5, car_door.OPEN):
        door.start(car_door.plant_parameters(hold), angle)
        closes, opens = -RATIO * slave.get("torque_load"), -RATIO * slave.get("torque_release")
        assert hold.band(angle) == pytest.approx((closes, opens), rel=1e-12)
        assert hold.band(angle) == pytest.approx(edges(angle), rel=1e-12)


def test_design_is_what_its_formulas_ask_for():
    closes, opens = car_door.design().band(car_door.OPEN)
    assert closes == pytest.approx(-1.1 * 36.1709, abs=1e-4)  # the source's largest torques, nose up and down
    assert opens == pytest.approx(1.1 * 27.5381, abs=1e-4)
    assert car_door.extreme_weight_torques() == pytest.approx((36.1709, 27.5381), abs=5e-5)
    lead = car_door.design().cam.lead_angle[0]
    assert 0.0 < lead < math.atan(car_door.FRICTION)  # locks itself: the weight changes its sign


def test_margin_pays_for_less_friction_and_a_heavier_door():
    for attitude in car_door.ATTITUDES.values():
        for angle in np.linspace(0.0, car_door.OPEN, 200):
            closes, opens = edges(angle, friction=0.95 * car_door.FRICTION)
            assert closes < 1.03 * weight_by_vectors(angle, *attitude) < opens


def test_damper_balances_hand_and_slope_at_the_limit(slave):
    """Fully open, nose up, closing at the limit under the hand: the acceleration is zero."""
    hold = car_door.design()
    start = {
        **hold.parameters(),
        "inertia.shaft": car_door.INERTIA / RATIO**2,
        "stop.upper": RATIO * car_door.OPEN,
        "initial.omega": RATIO * car_door.CLOSING_LIMIT,
    }
    slave.start(start)
    pushed = car_door.PUSH - weight_by_vectors(car_door.OPEN, *car_door.ATTITUDES[car_door.NOSE_UP])
    slave.set("tau", pushed / RATIO)
    assert slave.get("alpha") == pytest.approx(0.0, abs=1e-6)
    slave.set("tau", pushed / RATIO + 1.0)
    assert slave.get("alpha") == pytest.approx(RATIO**2 / car_door.INERTIA, rel=1e-6)


def test_a_damper_on_the_releasing_side_makes_a_locked_cam_faster(slave):
    """Why the damper acts while the door closes: z' D takes load off the contacts that brake."""
    braking = []
    for damping in (0.0, 1e5):
        slave.start(
            {
                **car_door.design().parameters(),
                "damper.c_release": damping,
                "inertia.shaft": car_door.INERTIA / RATIO**2,
                "stop.upper": RATIO * car_door.OPEN,
                "initial.theta": 1.0,
                "initial.omega": -1.0,
            }
        )
        braking.append(slave.get("alpha"))
    assert 0.0 < braking[1] < braking[0]


# ---- holds where let go ----


def test_holds_where_let_go(slave):
    """1000 angles in each of five attitudes: untouched after 10 s."""
    door, hold = car_door.door_axis(slave), car_door.design()
    for attitude in car_door.ATTITUDES:
        load = car_door.weight(attitude)
        for angle in np.linspace(0.0, car_door.OPEN, 1000):
            door.start(car_door.plant_parameters(hold), angle)
            before = door.angle
            door.step(0.0, load, size=10.0)
            assert door.angle == before
            assert door.speed == 0.0


def test_moves_where_the_table_says_it_does_not_hold(slave):
    door, half = car_door.door_axis(slave), car_door.design().with_spring_force(0.5)
    angles = np.linspace(0.01, car_door.OPEN - 0.01, 100)  # off the stops, which hold too
    stays = 0
    for attitude in car_door.ATTITUDES:
        load = car_door.weight(attitude)
        for angle in angles:
            door.start(car_door.plant_parameters(half), angle)
            door.step(0.0, load, STEP)
            closes, opens = (0.5 * edge for edge in edges(angle))
            assert (door.speed == 0.0) == (closes < load.torque(angle) < opens)
            stays += door.speed == 0.0
    share = stays / (len(angles) * len(car_door.ATTITUDES))
    assert car_door.share_of_angles_held(half) == pytest.approx(share, abs=0.02)


def test_trade_off():
    hold = car_door.design()
    shares = [
        car_door.share_of_angles_held(hold.with_spring_force(share), points=200)
        for share in example.SPRING_SHARES
    ]
    forces = [
        car_door.handle_force(hold.with_spring_force(share), [car_door.LEVEL])
        for share in example.SPRING_SHARES
    ]
    assert shares == sorted(shares)
    assert forces == sorted(forces)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    # Without the cam the hand works against the weight alone, at most 6.429 N.m on level ground (source).
    assert forces[0] == pytest.approx(6.429 / car_door.HANDLE, rel=1e-4)
    assert car_door.share_of_angles_held(hold, [car_door.BOTH]) < 1.0


# ---- closed by hand ----


def closing(name, attitude, torque, duration):
    """Speed at the latch [rad/s], 0 if it stops on the way, and the largest speed: the door's own equation of
    motion, written down here and solved by DOP853. `torque` of the hand for `duration` [s]."""
    closes = edges(MOTION.end)[0] if name != BARE else 0.0
    if weight_by_vectors(MOTION.end, *ATTITUDES[attitude]) - torque > closes:
        return 0.0, 0.0  # too weak to start
    cam = car_door.design().cam
    pitch, roll = ATTITUDES[attitude]
    lead, phi = cam.lead_angle[0], math.atan(car_door.FRICTION)
    lift = 0.5 * car_door.RADIUS * math.tan(lead)
    arm = RATIO * 0.5 * car_door.RADIUS * math.tan(lead + phi)
    orifice = car_door.design().orifice if name == CAM else 0.0

    def motion(t, y, push):
        angle, speed = y  # speed < 0 closes
        force = cam.preload + cam.stiffness * lift * RATIO * (car_door.OPEN - angle)
        cam_torque = arm * (force + orifice * (lift * RATIO * speed) ** 2) if name != BARE else 0.0
        return [speed, (weight_by_vectors(angle, pitch, roll) - push + cam_torque) / car_door.INERTIA]

    def shut(t, y, push):
        return y[0]

    def rests(t, y, push):
        return y[1] + 1e-9

    shut.terminal = rests.terminal = True
    rests.direction = 1.0
    state, fastest = [MOTION.end, -1e-8], 0.0
    for push, span in ((torque, duration), (0.0, 10.0)):
        done = solve_ivp(
            motion,
            (0.0, span),
            state,
            "DOP853",
            args=(push,),
            events=(shut, rests),
            rtol=1e-9,
            atol=1e-12,
            max_step=0.01,
        )
        state = done.y[:, -1]
        fastest = max(fastest, -np.min(done.y[1]))
        if done.status == 1:
            break
    return (0.0 if done.t_events[1].size else -state[1]), fastest


@pytest.mark.parametrize("name", [BARE, UNDAMPED, CAM])
def test_slams_arrive_as_the_equation_of_motion_says(results, name):
    for attitude in (car_door.LEVEL, car_door.NOSE_UP):
        for push in report.PUSHES[::2] + report.PUSHES[-1:]:
            slam = results.slams[attitude, name, push]
            latch, fastest = closing(name, attitude, push / report.PUSH_TIME, report.PUSH_TIME)
            assert slam.latch_speed == pytest.approx(latch, rel=2e-3)
            if not latch:
                assert slam.angle[-1] > 0.0
                assert slam.speed[-1] == 0.0
                assert np.max(-slam.speed) == pytest.approx(fastest, rel=2e-3)


def test_closing_speed_is_limited_under_a_hand_that_keeps_pushing(results):
    for attitude in car_door.ATTITUDES:
        hand = results.hands[attitude, CAM]
        latch, fastest = closing(CAM, attitude, car_door.PUSH, 10.0)
        assert np.max(-hand.speed) < car_door.CLOSING_LIMIT
        assert np.max(-hand.speed) == pytest.approx(fastest, rel=2e-3)
        assert hand.latch_speed == pytest.approx(latch, rel=2e-3)
        if latch:
            assert results.hands[attitude, UNDAMPED].latch_speed > latch
    assert results.hands[car_door.NOSE_UP, UNDAMPED].latch_speed > car_door.CLOSING_LIMIT


def test_slam_does_not_outrun_the_limit_by_the_time_it_is_at_the_latch(results):
    for (_, name, _), slam in results.slams.items():
        if name == CAM:
            assert slam.latch_speed < car_door.CLOSING_LIMIT


def test_plain_door_falls_shut_with_its_potential_energy(results):
    load = car_door.weight(car_door.NOSE_UP)
    fall = load.energy(MOTION.end) - load.energy(0.0)
    assert results.let_go[BARE].latch_speed == pytest.approx(
        math.sqrt(2.0 * fall / car_door.INERTIA), rel=1e-4
    )


def test_cam_stays_between_pushes(results):
    closed = results.let_go[CAM]
    rests = [closed.angle[round((begin - 0.01) / STEP)] for begin in report.NUDGE_TIMES] + [closed.angle[-1]]
    assert rests[0] == MOTION.end
    assert np.all(np.diff(rests) < -0.1)
    assert np.all(np.array(rests) > 0.0)
    for begin, rest in zip(report.NUDGE_TIMES[1:], rests[1:], strict=False):
        assert np.all(closed.angle[round((begin - 0.2) / STEP) : round(begin / STEP)] == rest)


def test_pin_loads(results, slave):
    """Friction resists slow closing with half the spring on each cam, two pins each."""
    door, hold = car_door.door_axis(slave), car_door.design()
    level = car_door.weight(car_door.LEVEL)
    door.start(car_door.plant_parameters(hold), 0.001)
    door.step(hold.band(0.0)[0] - level.torque(0.0) - 0.1, level, STEP)
    assert door.largest_pin_force() == pytest.approx(report.slow_pin_load(hold), rel=1e-3)
    axial = hold.cam.preload * (1.0 + car_door.SPRING_RISE)
    lead = hold.cam.lead_angle[0]
    per_pin = 0.25 * axial / (math.cos(lead) - car_door.FRICTION * math.sin(lead))
    assert report.slow_pin_load(hold) == pytest.approx(per_pin, rel=1e-12)
    hardest = results.slams[car_door.NOSE_UP, CAM, report.PUSHES[-1]]
    assert hardest.pin_load > 2.0 * report.slow_pin_load(hold)


# ---- the motor's cycle ----


def test_ledger_closes(results):
    for cycle in results.cycles.values():
        run = cycle.record
        transferred = np.sum(np.abs(run.motor_work)) + np.sum(np.abs(run.load_work))
        assert np.max(np.abs(run.ledger["residual"])) <= 1e-12 * transferred
        done = np.sum(run.motor_work) + np.sum(run.load_work)
        assert run.ledger["work_in"][-1] == pytest.approx(done, abs=1e-9)


def test_weight_does_its_potential_and_no_work_over_a_cycle(results):
    for (attitude, _), cycle in results.cycles.items():
        load = car_door.weight(attitude)
        potential = load.energy(MOTION.start) - np.array([load.energy(angle) for angle in cycle.record.angle])
        assert np.cumsum(cycle.record.load_work) == pytest.approx(potential, abs=1e-4)


def test_supply_pays_for_heat_and_work(results):
    for cycle in results.cycles.values():
        planned = np.diff(MOTION.sample(MOTION.dwell + STEP * np.arange(len(cycle.record.time) + 1))[1])
        mean = (
            np.concatenate([[0.0], cycle.record.speed[:-1]]) + 0.5 * planned
        )  # what the current loop is told
        electric = np.sum(cycle.record.motor_torque * mean) * STEP
        stored = 0.5 * MOTOR.inductance * (cycle.record.motor_torque[-1] / MOTOR.output_constant) ** 2
        paid = np.sum(cycle.record.motor_heat) + stored
        assert np.sum(cycle.record.supply_energy) == pytest.approx(paid + electric, abs=1e-5)
        assert np.sum(cycle.record.supply_energy) == pytest.approx(
            paid + np.sum(cycle.record.motor_work), rel=1e-4, abs=2e-3
        )


def test_heat_of_the_cam_is_the_area_of_its_band_and_its_damping(results):
    damping = car_door.design().damping
    for (_, name), cycle in results.cycles.items():
        heat = cycle.record.friction_heat + cycle.record.ledger["heat_damper"][-1]
        if name == BARE:
            assert heat == 0.0
            continue
        closes, opens = edges(
            0.5 * (MOTION.start + MOTION.end)
        )  # affine in the angle: the mean is the middle
        area = (opens - closes) * (MOTION.end - MOTION.start)
        closing_speed = np.maximum(0.0, -np.gradient(cycle.record.reference, STEP))
        damped = damping * np.sum(closing_speed**3) * STEP
        assert heat == pytest.approx(area + damped, rel=2e-3)


def test_motor_is_off_while_the_cam_holds(results):
    hold_ticks = slice(round((MOTION.move + 0.05) / STEP), round(7.0 / STEP))
    for (attitude, name), cycle in results.cycles.items():
        if name == BARE or attitude == car_door.BOTH:
            assert not np.any(cycle.motor_off[hold_ticks])
            continue
        assert np.all(cycle.motor_off[hold_ticks])
        assert cycle.motor_off_share > 0.99 * MOTION.dwell / car_door.DURATION
        assert np.sum(np.abs(cycle.record.supply_energy[hold_ticks])) < 1e-12
        assert np.ptp(cycle.record.angle[hold_ticks]) == 0.0


def test_plain_door_is_held_by_current(results):
    for attitude in ATTITUDES:
        current = car_door.weight(attitude).torque(MOTION.end) / MOTOR.output_constant
        power = MOTOR.resistance * current**2
        assert results.cycles[attitude, BARE].hold_power == pytest.approx(power, rel=5e-3)


def test_beyond_the_design_the_motor_adds_what_is_missing(results):
    cycle = results.cycles[car_door.BOTH, CAM]
    torque = float(np.mean(cycle.record.motor_torque[cycle.holding]))
    weight = car_door.weight(car_door.BOTH).torque(MOTION.end)
    closes, _ = edges(MOTION.end)
    assert 0.0 < closes - weight < torque < 0.3 * -weight
    assert np.ptp(cycle.record.angle[cycle.holding]) == 0.0


def test_break_even_is_where_both_have_taken_the_same(results):
    for attitude in ATTITUDES:
        held = report.pays_off(results, attitude)
        bare, cam = results.cycles[attitude, BARE], results.cycles[attitude, CAM]
        assert held > 0.0
        assert bare.move_energy + held * bare.hold_power == pytest.approx(
            cam.move_energy + held * cam.hold_power, rel=1e-9
        )


def test_limits_and_tracking(results):
    for cycle in results.cycles.values():
        assert np.max(cycle.record.peak_torque) <= MOTOR.peak_torque * (1 + 1e-12)
        assert math.sqrt(np.mean(cycle.record.motor_torque**2)) < MOTOR.rated_torque
        assert np.max(np.abs(cycle.record.speed)) < 1.05 * MOTION.peak_speed < MOTOR.peak_speed
        assert cycle.record.max_error < math.radians(0.1)


def test_table_of_the_page(results):
    """docs/examples.md shows the figures that the example prints."""
    rows = re.findall(r"^\| ([a-z][\w ]+) \| (plain door|cam) \| (.*) \|$", PAGE, re.MULTILINE)
    assert {(attitude, name) for attitude, name, _ in rows} == set(results.cycles)
    for attitude, name, cells in rows:
        cycle = results.cycles[attitude, name]
        measured = [
            f"{cycle.hold_power:.1f} W",
            f"{cycle.move_energy:.0f} J",
            f"{cycle.record.friction_heat:.0f} J",
        ]
        measured += [f"{100 * cycle.motor_off_share:.0f} %"]
        measured += [f"{report.pays_off(results, attitude):.0f} s" if name == CAM else ""]
        assert [cell.strip() for cell in cells.split("|")] == measured


def test_example_and_report_run_the_same_cycles(results):
    cycles = example.run(FMU)
    assert {case: cycle.move_energy for case, cycle in cycles.items()} == {
        case: cycle.move_energy for case, cycle in results.cycles.items()
    }
