"""The car door example: weight, design, holding, closing speed and energy against facts from outside it."""

import math
import re
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "examples.md").read_text(encoding="utf-8")
FMU = ROOT / "build" / "DualCamForward.fmu"
sys.path.insert(0, str(ROOT / "system_examples"))

import car_door as example  # noqa: E402
from blocks import hinged_load, holding_torque, up_in_car  # noqa: E402

from dualcam import Fmu  # noqa: E402

BARE, CAM, UNDAMPED = example.BARE, example.CAM, example.UNDAMPED
ATTITUDES = example.ATTITUDES | example.BEYOND
MOTION, MOTOR, RATIO = example.MOTION, example.MOTOR, example.RATIO


@pytest.fixture(scope="module")
def results():
    return example.run(FMU)


@pytest.fixture(scope="module")
def slave():
    with Fmu(FMU) as one:
        yield one


# ---- the weight about the hinge ----


def weight_by_vectors(angle, pitch, roll):
    """Moment of the weight about the hinge, axis.(r x F): door turned about the hinge, car about its axes."""
    lower, upper = example.HINGE
    axis = (upper - lower) / np.linalg.norm(upper - lower)
    centre = Rotation.from_rotvec(angle * axis).apply(example.CENTRE - lower)
    car = Rotation.from_euler("X", roll) * Rotation.from_euler("Y", pitch)
    weight = np.array([0.0, 0.0, -9.81 * example.MASS])
    return car.apply(axis) @ np.cross(car.apply(centre), weight)


@pytest.mark.parametrize("attitude", ATTITUDES)
def test_weight_is_the_moment_about_the_hinge(attitude):
    load = example.weight(attitude)
    for angle in np.linspace(-0.3, 1.5, 37):
        assert load.torque(angle) == pytest.approx(weight_by_vectors(angle, *ATTITUDES[attitude]), abs=1e-12)


def test_weight_of_any_body_in_any_attitude():
    rng = np.random.default_rng(3)
    for _ in range(50):
        lower, upper, centre = rng.normal(size=(3, 3))
        pitch, roll, angle = rng.uniform(-1.0, 1.0, 3)
        load = hinged_load(2.0, (lower, upper), centre, up_in_car(pitch, roll))
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
        (example.LEVEL, (-6.0296, -6.3373, -4.4096)),
        (example.NOSE_UP, (-1.8978, -20.8881, -36.1709)),
        (example.NOSE_DOWN, (-9.9065, 8.4814, 27.5381)),
        (example.SIDE_DOWN, (13.3853, 11.5489, 5.1507)),
        (example.SIDE_UP, (-25.3724, -24.1477, -13.9171)),
    ],
)
def test_weight_agrees_with_the_sources_own_model(attitude, torques):
    """At 0, 30 and 67 deg, by the model that the data come from (jandaa/door-model, MIT), to its digits."""
    load = example.weight(attitude)
    for degrees, torque in zip((0.0, 30.0, 67.0), torques, strict=True):
        assert load.torque(math.radians(degrees)) == pytest.approx(torque, abs=5.1e-5)


def test_geometry_of_the_door():
    lower, upper = example.HINGE
    axis = (upper - lower) / np.linalg.norm(upper - lower)
    arm = np.linalg.norm(np.cross(axis, example.CENTRE - lower))
    assert pytest.approx(arm, abs=1e-5) == example.ARM
    assert pytest.approx(9.165 + 36.1736 * 0.0625, rel=1e-4) == example.DOOR_INERTIA
    assert example.hinge_tilt() == pytest.approx(2.06, abs=0.005)


def test_smallest_holding_torque():
    assert holding_torque((-2.0, 5.0), 1.0, margin=0.5) == 0.0
    assert holding_torque((-2.0, 5.0), 6.0, margin=0.5) == pytest.approx(-1.5)
    assert holding_torque((-2.0, 5.0), -4.0, margin=0.5) == pytest.approx(2.5)


# ---- the design ----


def edges(angle, friction=example.FRICTION):
    """The band about the hinge of two equal helices, N (r/2) tan(lambda +- phi) F, from the statics."""
    cam = example.design().cam
    lead, phi = cam.lead_angle[0], math.atan(friction)
    lift = 0.5 * example.RADIUS * math.tan(lead)  # of z by theta
    force = cam.preload + cam.stiffness * lift * RATIO * (example.OPEN - angle)
    arm = RATIO * 0.5 * example.RADIUS
    return -arm * math.tan(lead + phi) * force, -arm * math.tan(lead - phi) * force


def test_band_is_that_of_the_statics_and_of_the_fmu(slave):
    hold = example.design()
    door = example.Door(slave)
    for angle in (0.0, 0.5, example.OPEN):
        door.start(hold, example.weight(example.LEVEL), angle)
        closes, opens = -RATIO * slave.get("torque_load"), -RATIO * slave.get("torque_release")
        assert hold.band(angle) == pytest.approx((closes, opens), rel=1e-12)
        assert hold.band(angle) == pytest.approx(edges(angle), rel=1e-12)


def test_design_is_what_its_formulas_ask_for():
    closes, opens = example.design().band(example.OPEN)
    assert closes == pytest.approx(-1.1 * 36.1709, abs=1e-4)  # the source's largest torques, nose up and down
    assert opens == pytest.approx(1.1 * 27.5381, abs=1e-4)
    assert example.extremes() == pytest.approx((36.1709, 27.5381), abs=5e-5)
    lead = example.design().cam.lead_angle[0]
    assert 0.0 < lead < math.atan(example.FRICTION)  # locks itself: the weight changes its sign


def test_margin_pays_for_less_friction_and_a_heavier_door():
    for attitude in example.ATTITUDES.values():
        for angle in np.linspace(0.0, example.OPEN, 200):
            closes, opens = edges(angle, friction=0.95 * example.FRICTION)
            assert closes < 1.03 * weight_by_vectors(angle, *attitude) < opens


def test_damper_balances_hand_and_slope_at_the_limit(slave):
    """Fully open, nose up, closing at the limit under the hand: the acceleration is zero."""
    hold = example.design()
    start = {
        **hold.parameters(),
        "inertia.shaft": example.INERTIA / RATIO**2,
        "stop.upper": RATIO * example.OPEN,
        "initial.omega": RATIO * example.CLOSING_LIMIT,
    }
    slave.start(start)
    pushed = example.PUSH - weight_by_vectors(example.OPEN, *example.ATTITUDES[example.NOSE_UP])
    slave.set("tau", pushed / RATIO)
    assert slave.get("alpha") == pytest.approx(0.0, abs=1e-6)
    slave.set("tau", pushed / RATIO + 1.0)
    assert slave.get("alpha") == pytest.approx(RATIO**2 / example.INERTIA, rel=1e-6)


def test_a_damper_on_the_releasing_side_makes_a_locked_cam_faster(slave):
    """Why the damper acts while the door closes: z' D takes load off the contacts that brake."""
    braking = []
    for damping in (0.0, 1e5):
        slave.start(
            {
                **example.design().parameters(),
                "damper.c_release": damping,
                "inertia.shaft": example.INERTIA / RATIO**2,
                "stop.upper": RATIO * example.OPEN,
                "initial.theta": 1.0,
                "initial.omega": -1.0,
            }
        )
        braking.append(slave.get("alpha"))
    assert 0.0 < braking[1] < braking[0]


# ---- holds where let go ----


def test_holds_where_let_go(slave):
    """1000 angles in each of five attitudes: untouched after 10 s."""
    door, hold = example.Door(slave), example.design()
    for attitude in example.ATTITUDES:
        load = example.weight(attitude)
        for angle in np.linspace(0.0, example.OPEN, 1000):
            door.start(hold, load, angle)
            before = door.angle
            door.step(0.0, size=10.0)
            assert door.angle == before
            assert door.speed == 0.0


def test_moves_where_the_table_says_it_does_not_hold(slave):
    door, half = example.Door(slave), example.design().scaled(0.5)
    angles = np.linspace(0.01, example.OPEN - 0.01, 100)  # off the stops, which hold too
    stays = 0
    for attitude in example.ATTITUDES:
        load = example.weight(attitude)
        for angle in angles:
            door.start(half, load, angle)
            door.step(0.0)
            closes, opens = (0.5 * edge for edge in edges(angle))
            assert (door.speed == 0.0) == (closes < load.torque(angle) < opens)
            stays += door.speed == 0.0
    share = stays / (len(angles) * len(example.ATTITUDES))
    assert example.held_share(half) == pytest.approx(share, abs=0.02)


def test_trade_off():
    hold = example.design()
    shares = [example.held_share(hold.scaled(share), points=200) for share in example.TRADE_OFF]
    forces = [example.handle_force(hold.scaled(share), [example.LEVEL]) for share in example.TRADE_OFF]
    assert shares == sorted(shares)
    assert forces == sorted(forces)
    assert (shares[0], shares[-1]) == (0.0, 1.0)
    # Without the cam the hand works against the weight alone, at most 6.429 N.m on level ground (source).
    assert forces[0] == pytest.approx(6.429 / example.HANDLE, rel=1e-4)
    assert example.held_share(hold, [example.BOTH]) < 1.0


# ---- closed by hand ----


def closing(name, attitude, torque, duration):
    """Speed at the latch [rad/s], 0 if it stops on the way, and the largest speed: the door's own equation of
    motion, written down here and solved by DOP853. `torque` of the hand for `duration` [s]."""
    closes = edges(MOTION.end)[0] if name != BARE else 0.0
    if weight_by_vectors(MOTION.end, *ATTITUDES[attitude]) - torque > closes:
        return 0.0, 0.0  # too weak to start
    cam = example.design().cam
    pitch, roll = ATTITUDES[attitude]
    lead, phi = cam.lead_angle[0], math.atan(example.FRICTION)
    lift = 0.5 * example.RADIUS * math.tan(lead)
    arm = RATIO * 0.5 * example.RADIUS * math.tan(lead + phi)
    orifice = example.design().orifice if name == CAM else 0.0

    def motion(t, y, push):
        angle, speed = y  # speed < 0 closes
        force = cam.preload + cam.stiffness * lift * RATIO * (example.OPEN - angle)
        cam_torque = arm * (force + orifice * (lift * RATIO * speed) ** 2) if name != BARE else 0.0
        return [speed, (weight_by_vectors(angle, pitch, roll) - push + cam_torque) / example.INERTIA]

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
    for attitude in (example.LEVEL, example.NOSE_UP):
        for push in example.PUSHES[::2] + example.PUSHES[-1:]:
            slam = results.slams[attitude, name, push]
            latch, fastest = closing(name, attitude, push / example.PUSH_TIME, example.PUSH_TIME)
            assert slam.latch_speed == pytest.approx(latch, rel=2e-3)
            if not latch:
                assert slam.angle[-1] > 0.0
                assert slam.speed[-1] == 0.0
                assert np.max(-slam.speed) == pytest.approx(fastest, rel=2e-3)


def test_closing_speed_is_limited_under_a_hand_that_keeps_pushing(results):
    for attitude in example.ATTITUDES:
        hand = results.hands[attitude, CAM]
        latch, fastest = closing(CAM, attitude, example.PUSH, 10.0)
        assert np.max(-hand.speed) < example.CLOSING_LIMIT
        assert np.max(-hand.speed) == pytest.approx(fastest, rel=2e-3)
        assert hand.latch_speed == pytest.approx(latch, rel=2e-3)
        if latch:
            assert results.hands[attitude, UNDAMPED].latch_speed > latch
    assert results.hands[example.NOSE_UP, UNDAMPED].latch_speed > example.CLOSING_LIMIT


def test_slam_does_not_outrun_the_limit_by_the_time_it_is_at_the_latch(results):
    for (_, name, _), slam in results.slams.items():
        if name == CAM:
            assert slam.latch_speed < example.CLOSING_LIMIT


def test_plain_door_falls_shut_with_its_potential_energy(results):
    load = example.weight(example.NOSE_UP)
    fall = load.energy(MOTION.end) - load.energy(0.0)
    assert results.let_go[BARE].latch_speed == pytest.approx(
        math.sqrt(2.0 * fall / example.INERTIA), rel=1e-4
    )


def test_cam_stays_between_pushes(results):
    way = results.let_go[CAM]
    rests = [way.angle[round((begin - 0.01) / example.TICK)] for begin in example.NUDGE_TIMES] + [
        way.angle[-1]
    ]
    assert rests[0] == MOTION.end
    assert np.all(np.diff(rests) < -0.1)
    assert np.all(np.array(rests) > 0.0)
    for begin, rest in zip(example.NUDGE_TIMES[1:], rests[1:], strict=False):
        assert np.all(way.angle[round((begin - 0.2) / example.TICK) : round(begin / example.TICK)] == rest)


def test_pin_loads(results, slave):
    """Friction resists slow closing with half the spring on each cam, two pins each."""
    door, hold = example.Door(slave), example.design()
    door.start(hold, example.weight(example.LEVEL), 0.001)
    door.step(hold.band(0.0)[0] - example.weight(example.LEVEL).torque(0.0) - 0.1)
    assert door.pin_load() == pytest.approx(example.slow_pin_load(hold), rel=1e-3)
    axial = hold.cam.preload * (1.0 + example.SPRING_RISE)
    lead = hold.cam.lead_angle[0]
    per_pin = 0.25 * axial / (math.cos(lead) - example.FRICTION * math.sin(lead))
    assert example.slow_pin_load(hold) == pytest.approx(per_pin, rel=1e-12)
    hardest = results.slams[example.NOSE_UP, CAM, example.PUSHES[-1]]
    assert hardest.pin_load > 2.0 * example.slow_pin_load(hold)


# ---- the motor's cycle ----


def test_ledger_closes(results):
    for cycle in results.cycles.values():
        turned_over = np.sum(np.abs(cycle.motor_work)) + np.sum(np.abs(cycle.weight_work))
        assert np.max(np.abs(cycle.ledger["residual"])) <= 1e-12 * turned_over
        done = np.sum(cycle.motor_work) + np.sum(cycle.weight_work)
        assert cycle.ledger["work_in"][-1] == pytest.approx(done, abs=1e-9)


def test_weight_does_its_potential_and_no_work_over_a_cycle(results):
    for (attitude, _), cycle in results.cycles.items():
        load = example.weight(attitude)
        potential = load.energy(MOTION.start) - np.array([load.energy(angle) for angle in cycle.angle])
        assert np.cumsum(cycle.weight_work) == pytest.approx(potential, abs=1e-4)


def test_supply_pays_for_heat_and_work(results):
    for cycle in results.cycles.values():
        planned = np.diff(MOTION.sample(MOTION.dwell + example.TICK * np.arange(len(cycle.time) + 1))[1])
        mean = np.concatenate([[0.0], cycle.speed[:-1]]) + 0.5 * planned  # what the current loop is told
        electric = np.sum(cycle.motor_torque * mean) * example.TICK
        stored = 0.5 * MOTOR.inductance * (cycle.motor_torque[-1] / MOTOR.output_constant) ** 2
        paid = np.sum(cycle.motor_heat) + stored
        assert np.sum(cycle.supply_energy) == pytest.approx(paid + electric, abs=1e-5)
        assert np.sum(cycle.supply_energy) == pytest.approx(
            paid + np.sum(cycle.motor_work), rel=1e-4, abs=2e-3
        )


def test_heat_of_the_cam_is_the_area_of_its_band_and_its_drag(results):
    drag = example.design().drag
    for (_, name), cycle in results.cycles.items():
        heat = cycle.friction_heat + cycle.ledger["heat_damper"][-1]
        if name == BARE:
            assert heat == 0.0
            continue
        closes, opens = edges(
            0.5 * (MOTION.start + MOTION.end)
        )  # affine in the angle: the mean is the middle
        area = (opens - closes) * (MOTION.end - MOTION.start)
        closing_speed = np.maximum(0.0, -np.gradient(cycle.reference, example.TICK))
        dragged = drag * np.sum(closing_speed**3) * example.TICK
        assert heat == pytest.approx(area + dragged, rel=2e-3)


def test_motor_is_off_while_the_cam_holds(results):
    hold_ticks = slice(round((MOTION.move + 0.05) / example.TICK), round(7.0 / example.TICK))
    for (attitude, name), cycle in results.cycles.items():
        if name == BARE or attitude == example.BOTH:
            assert not np.any(cycle.off[hold_ticks])
            continue
        assert np.all(cycle.off[hold_ticks])
        assert cycle.off_share > 0.99 * MOTION.dwell / example.DURATION
        assert np.sum(np.abs(cycle.supply_energy[hold_ticks])) < 1e-12
        assert np.ptp(cycle.angle[hold_ticks]) == 0.0


def test_plain_door_is_held_by_current(results):
    for attitude in ATTITUDES:
        current = example.weight(attitude).torque(MOTION.end) / MOTOR.output_constant
        power = MOTOR.resistance * current**2
        assert results.cycles[attitude, BARE].hold_power == pytest.approx(power, rel=5e-3)


def test_beyond_the_design_the_motor_adds_what_is_missing(results):
    cycle = results.cycles[example.BOTH, CAM]
    torque = float(np.mean(cycle.motor_torque[cycle.holding]))
    weight = example.weight(example.BOTH).torque(MOTION.end)
    closes, _ = edges(MOTION.end)
    assert 0.0 < closes - weight < torque < 0.3 * -weight
    assert np.ptp(cycle.angle[cycle.holding]) == 0.0


def test_break_even_is_where_both_have_taken_the_same(results):
    for attitude in ATTITUDES:
        held = example.break_even(results, attitude)
        bare, cam = results.cycles[attitude, BARE], results.cycles[attitude, CAM]
        assert held > 0.0
        assert bare.move_energy + held * bare.hold_power == pytest.approx(
            cam.move_energy + held * cam.hold_power, rel=1e-9
        )


def test_limits_and_tracking(results):
    for cycle in results.cycles.values():
        assert np.max(cycle.peak_torque) <= MOTOR.peak_torque * (1 + 1e-12)
        assert math.sqrt(np.mean(cycle.motor_torque**2)) < MOTOR.rated_torque
        assert np.max(np.abs(cycle.speed)) < 1.05 * MOTION.peak_speed < MOTOR.peak_speed
        assert cycle.max_error < math.radians(0.1)


def test_table_of_the_page(results):
    """docs/examples.md shows the figures that the example prints."""
    rows = re.findall(r"^\| ([a-z][\w ]+) \| (plain door|cam) \| (.*) \|$", PAGE, re.MULTILINE)
    assert {(attitude, name) for attitude, name, _ in rows} == set(results.cycles)
    for attitude, name, cells in rows:
        cycle = results.cycles[attitude, name]
        measured = [f"{cycle.hold_power:.1f} W", f"{cycle.move_energy:.0f} J", f"{cycle.friction_heat:.0f} J"]
        measured += [f"{100 * cycle.off_share:.0f} %"]
        measured += [f"{example.break_even(results, attitude):.0f} s" if name == CAM else ""]
        assert [cell.strip() for cell in cells.split("|")] == measured


def test_text_of_the_page(results):
    """So do the figures between the tables."""
    hold, half = example.design(), example.design().scaled(0.5)
    moves = [
        results.cycles[attitude, CAM].move_energy / results.cycles[attitude, BARE].move_energy
        for attitude in ATTITUDES
    ]
    fastest = max(np.max(-results.hands[attitude, CAM].speed) for attitude in example.ATTITUDES)
    plain = max(results.hands[attitude, BARE].latch_speed for attitude in example.ATTITUDES)
    text = " ".join(PAGE.split())
    for phrase in (
        f"with at most {fastest:.1f} rad/s, where the plain door slams with {plain:.1f}.",
        f"moving takes {min(moves):.0f} to {max(moves):.0f} times the energy",
        f"needs {example.handle_force(hold, [example.LEVEL]):.0f} N at the handle instead of"
        f" {example.handle_force(hold.scaled(0.0), [example.LEVEL]):.0f}.",
        f"needs {example.handle_force(half, [example.LEVEL]):.0f} N and holds at"
        f" {100 * example.held_share(half):.0f} % of the angles",
    ):
        assert phrase in text


def test_command_line(tmp_path, capsys):
    output = tmp_path / "door.png"
    example.main(["--fmu", str(FMU), "--output", str(output)])
    printed = capsys.readouterr().out
    assert max(map(len, printed.splitlines()[:-1])) <= 110
    factor = float(re.search(r"Real-time factor of the 1 kHz loop: (\d+)", printed).group(1))
    assert factor > 1.0
    assert output.stat().st_size > 20_000
