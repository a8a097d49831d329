"""The sampling controller of the elbow: rollouts one by one, weights by closed forms, filter, study."""

import csv
import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from driver import ROOT
from scipy.special import softmax
from scipy.stats import binom

from dualcam import Fmu
from dualcam.errors import DualcamError
from dualcam.systems.blocks.axis import CamAxis
from dualcam.systems.blocks.axis_bank import AxisBank
from dualcam.systems.blocks.path_integral import (
    Noise,
    PathIntegralPlanner,
    effective_size,
    path_integral_weights,
    shaped_basis,
    spline_basis,
    temperature_of,
)
from dualcam.systems.machines import elbow
from dualcam.systems.machines import elbow_controllers as controllers
from dualcam.systems.machines.elbow_controllers import CAM, COUNT, PERIOD, Lqi, Mppi, estimator, informed
from dualcam.systems.machines.payload_filter import Belief, systematic_draw
from system_examples import sampling_elbow as example

PAGE, TABLE = ROOT / "docs/use-sampling-control.md", ROOT / "benchmarks/results/sampling_elbow.csv"
PARAMETERS = elbow.plant_parameters(CAM, elbow.DESIGN_PAYLOAD)


def belief_of(angle, speed, payload, friction):
    return Belief(*(np.atleast_1d(np.asarray(value, float)) for value in (angle, speed, payload, friction)))


def alone(angle, speed, payload, friction, torques):
    """Angles [rad] of one FMU under a history of torques, one step of 10 ms each."""
    start = PARAMETERS | {"inertia.shaft": elbow.inertia(payload)}
    start |= {"cam1.friction": friction, "cam2.friction": friction}
    weight, angles = elbow.weight(np.array([payload])), []
    with Fmu("forward") as fmu:
        axis = CamAxis(fmu)
        axis.start(start, angle, speed)
        for torque in torques:
            middle = np.array([axis.angle + 0.5 * PERIOD * axis.speed])
            axis.set_torque(torque + float(weight.torque(middle)[0]))
            axis.advance(PERIOD)
            angles.append(axis.angle)
    return angles


# ---- rollouts ----


def test_each_rollout_is_the_run_of_one_fmu_bit_for_bit():
    """From stick, from slip both ways, and into both end stops."""
    start = belief_of([0.6, 0.7, 0.8], [0.0, 2.0, -1.5], [1.5, 2.4, 0.6], [0.14, 0.17, 0.11])
    planner = Mppi(informed(1.5, 0.14), np.random.default_rng(1), plans=16, hypotheses=3)
    plans = planner.planner.candidates()
    plans[1], plans[2] = 12.0, -12.0  # N.m
    angles = planner.rollouts(start, plans)
    assert angles.shape == (17, 3, controllers.HORIZON)
    assert angles.max() == elbow.RANGE and angles.min() == 0.0
    for i in (0, 1, 2, 5, 16):
        for j in range(3):
            expected = alone(*(values[j] for values in start), [0.0, *plans[i]])
            assert angles[i, j].tolist() == expected[1:]


def test_a_bank_moves_as_axes_alone():
    payload = np.array([0.5, 1.5, 2.5])
    with AxisBank(3, PARAMETERS) as bank:
        bank.start(np.full(3, 0.9), np.array([0.0, 1.0, -1.0]), {"inertia.shaft": elbow.inertia(payload)})
        for _ in range(20):
            bank.step(np.array([-5.0, 2.0, 0.0]), elbow.weight(payload), PERIOD)
        for i, (speed, torque) in enumerate(((0.0, -5.0), (1.0, 2.0), (-1.0, 0.0))):
            assert bank.angle[i] == alone(0.9, speed, payload[i], 0.14, [torque] * 20)[-1]


def test_costs_are_heat_and_squared_error():
    start = belief_of(0.7, 0.0, 1.5, 0.14)
    planner = Mppi(informed(1.5, 0.14), np.random.default_rng(1), plans=16)
    plans = np.array([np.full(controllers.HORIZON, 3.0), np.zeros(controllers.HORIZON)])
    for plan, cost in zip(plans, planner.costs(start, 120, plans), strict=True):
        angles = np.array(alone(0.7, 0.0, 1.5, 0.14, [0.0, *plan])[1:])
        goal, _ = elbow.MOTION.sample(PERIOD * (122 + np.arange(controllers.HORIZON)))
        heat = np.sum(0.170 * (plan / (6.0 * 0.091)) ** 2) * PERIOD  # R i^2
        assert cost == pytest.approx(heat + 1e6 * PERIOD * np.sum((angles - goal) ** 2), rel=1e-12)


# ---- weights and plans ----


def test_weights_are_those_of_the_closed_form():
    costs = np.random.default_rng(1).uniform(1e3, 1e3 + 5.0, 50)
    for temperature in (1e-3, 0.3, 1e4):
        weights = path_integral_weights(costs, temperature)
        np.testing.assert_allclose(weights, softmax(-costs / temperature), rtol=1e-9, atol=1e-300)
        assert effective_size(weights) == pytest.approx(np.sum(weights) ** 2 / np.sum(weights**2))


@pytest.mark.parametrize("size", [1.5, 3.0, 20.0])
def test_the_temperature_gives_the_wanted_effective_size(size):
    costs = np.random.default_rng(2).lognormal(0.0, 2.0, 64)
    assert effective_size(path_integral_weights(costs, temperature_of(costs, size))) == pytest.approx(size)


def test_a_temperature_that_no_costs_allow_is_that_at_the_end_of_the_range():
    assert temperature_of(np.full(5, 2.0), 3.0) == 1.0
    assert np.isfinite(temperature_of(np.array([1.0, 1.0, 1.0, 5.0]), 2.0))  # three are equally good
    assert np.isfinite(temperature_of(np.array([1.0, 2.0]), 9.0))  # there are only two


def test_the_mean_of_many_plans_is_that_of_the_gaussian_integral():
    """Deviations of covariance S about m, cost (u - c)' Q (u - c)/2, temperature T: the weighted mean tends
    to (S^-1 + Q/T)^-1 (S^-1 m + Q/T c)."""
    random = np.random.default_rng(3)
    q, basis, centre = (
        np.array([[3.0, 1.0], [1.0, 2.0]]),
        np.array([[0.6, 0.0], [0.2, 0.4]]),
        np.array([0.5, -0.3]),
    )
    count, temperature = 400_000, 0.7
    plans = Noise(basis, np.ones(count)).draw(random)
    weights = path_integral_weights(
        0.5 * np.einsum("ij,jk,ik->i", plans - centre, q, plans - centre), temperature
    )
    precision = np.linalg.inv(basis @ basis.T)
    expected = np.linalg.solve(precision + q / temperature, q @ centre / temperature)
    deviation = np.sqrt(np.sum(weights[:, None] ** 2 * (plans - expected) ** 2, axis=0))
    assert np.all(np.abs(weights @ plans - expected) < 4.0 * deviation)
    assert np.all(deviation < 2e-3)


def test_shaped_noise_costs_the_same_in_every_direction():
    q = np.diag([1.0, 4.0, 9.0, 16.0]) + 0.5
    basis = shaped_basis(spline_basis(4, 3), q)
    np.testing.assert_allclose(basis.T @ q @ basis, np.eye(3), atol=1e-12)


def test_plans_come_in_pairs_and_within_the_limit():
    planner = PathIntegralPlanner([Noise(np.eye(4), np.full(6, 5.0))], 2.0, 3.0, np.random.default_rng(1))
    plans = planner.candidates()
    assert plans.shape == (planner.count, 4) == (13, 4)
    assert np.array_equal(plans[0], np.zeros(4)) and np.array_equal(plans[1:7], -plans[7:])
    assert np.abs(plans).max() == 2.0
    planner.plan = np.arange(4.0)
    planner.shift()
    assert planner.plan.tolist() == [1.0, 2.0, 3.0, 3.0]


def test_costs_and_readings_that_are_no_numbers_are_refused_and_change_nothing():
    planner = PathIntegralPlanner([Noise(np.eye(2), np.ones(1))], 2.0, 2.0, np.random.default_rng(1))
    planner.plan = np.array([1.0, 2.0])
    with pytest.raises(DualcamError, match=r"costs\[1\] = nan: allowed are finite numbers"):
        planner.update(planner.candidates(), np.array([1.0, np.nan, 2.0]))
    with pytest.raises(DualcamError, match=r"costs has shape \(2,\): allowed is \(3,\), one per plan"):
        planner.update(planner.candidates(), np.zeros(2))
    assert planner.plan.tolist() == [1.0, 2.0]
    for limit, size, message in (
        (0.0, 3.0, "limit = 0.0"),
        (np.nan, 3.0, "limit = nan"),
        (1.0, 1.0, "size = 1.0"),
    ):
        with pytest.raises(DualcamError, match=f"{message}: allowed is a finite number >"):
            PathIntegralPlanner([Noise(np.eye(2), np.ones(1))], limit, size, np.random.default_rng(1))
    belief = informed(1.5, 0.14)
    before = belief.mean()
    with pytest.raises(DualcamError, match="measured = inf: allowed is a finite number"):
        belief.update(0.0, np.inf)
    assert belief.mean() == before


def test_a_reading_far_from_all_particles_does_no_harm():
    """An encoder that jumps by a radian: all numbers stay finite, and the filter goes on."""
    belief = estimator(np.random.default_rng(8))
    for angle in (0.02, 1.2, 0.02, 2.5, -1.0, 0.02):
        belief.update(3.0, angle)
        mean = belief.mean()
        assert all(np.all(np.isfinite(values)) for values in mean) and belief.weights.sum() == pytest.approx(
            1.0
        )
        assert 0.5 <= mean.payload[0] <= 2.5 and 0.10 <= mean.friction[0] <= 0.18


def test_the_cost_of_the_plan_falls_where_model_and_state_are_exact():
    """From a plan of no torque: out of stick at the bottom, and amid the motion upwards."""
    for angle, speed, period in ((elbow.MOTION.end, 0.0, 290), (0.75, -2.3, 350)):
        controller = Mppi(informed(1.5, 0.14), np.random.default_rng(4))
        start, costs = belief_of(angle, speed, 1.5, 0.14), []
        for _ in range(30):
            plans = controller.planner.candidates()
            now = controller.costs(start, period, plans)
            controller.planner.update(plans, now)
            costs.append(now[0])
        assert min(costs[1:4]) < costs[0] and costs[9] < 0.2 * costs[0]
        assert max(costs[20:]) < 0.05 * costs[0]


# ---- filter ----


def test_the_filter_that_is_told_all_predicts_exactly():
    """To rounding: an instance that begins anew every period loses what the FMU keeps beyond 53 bits."""
    belief = informed(2.1, 0.12)
    torques = [0.0] * 5 + [6.0] * 12 + [-9.0] * 20
    angles = alone(float(controllers.ANGLES[0]), 0.0, 2.1, 0.12, torques)
    for torque, angle in zip(torques, angles, strict=True):
        belief.update(torque, angle)
        assert belief.mean().angle[0] == pytest.approx(angle, abs=1e-14)
    assert belief.mean().payload[0] == 2.1 and belief.mean().friction[0] == 0.12


@pytest.mark.parametrize(("payload", "friction"), [(0.6, 0.17), (1.4, 0.11), (2.4, 0.14)])
def test_payload_and_friction_are_found_from_both_directions(payload, friction):
    belief = estimator(np.random.default_rng(5))
    torques = [0.0] * 10 + [3.0] * 15 + [-4.0] * 30 + [3.0] * 20
    for torque, angle in zip(
        torques, alone(float(controllers.ANGLES[0]), 0.0, payload, friction, torques), strict=True
    ):
        belief.update(torque, COUNT * round(angle / COUNT))
    mean = belief.mean()
    assert abs(mean.payload[0] - payload) < 0.15 and abs(mean.friction[0] - friction) < 0.012


def test_a_resting_arm_tells_little():
    """As long as no particle would slip, all keep their weight."""
    belief = estimator(np.random.default_rng(6))
    angle = COUNT * round(float(controllers.ANGLES[0]) / COUNT)
    for _ in range(50):
        belief.update(0.0, angle)
    assert belief.weights.max() < 2.0 / 64
    assert np.all(belief.draw(8).speed == 0.0) and belief.mean().speed[0] == 0.0


def test_numbers_are_drawn_by_weight():
    weights = np.array([0.05, 0.5, 0.0, 0.45])
    for seed in range(20):
        drawn = np.bincount(systematic_draw(weights, 10, np.random.default_rng(seed)), minlength=4)
        assert np.all(np.abs(drawn - 10 * weights) < 1.0) and drawn.sum() == 10


# ---- closed loops ----

DRAW = np.array([[1.5, 0.14]])


def test_an_informed_plan_follows_the_cycle_and_rests_without_current():
    mppi = example.run_block("MPPI, informed", DRAW, 0)
    cost, heat, error, end, current, off = mppi.figures[0]
    assert (current, off) == (0.0, 100.0)
    assert np.all(mppi.torques[0, :900] == 0.0) and np.all(mppi.angles[0, :900] == controllers.ANGLES[0])
    assert np.ptp(mppi.angles[0, example.LATE_REST[500:]]) == 0.0
    assert error < 1.0 and end < 1.0  # mrad
    assert cost == pytest.approx(heat + 4.0 * error**2)
    assert np.all(mppi.torques[0, 1950:2000] == 0.0)  # off 50 ms before the arrival
    assert 1e3 * (mppi.angles[0, 1999] - controllers.ANGLES[2000]) == pytest.approx(-0.4, abs=0.1)


def test_the_estimate_costs_its_error_at_the_beginning_of_the_way_down():
    """As the page says: several times that of the informed plans in the first half, alike in the second."""
    draws = np.array([[1.52, 0.176], [0.79, 0.176]])
    error = {}
    for name in ("MPPI, estimate", "MPPI, informed"):
        angles = example.run_block(name, draws, 0, periods=2000).angles
        square = (angles - controllers.ANGLES[1:2001])[:, 1000:].reshape(2, 2, 500) ** 2
        error[name] = np.sqrt(square.mean(axis=(0, 2)))  # rad, of both halves
    first, second = error["MPPI, estimate"] / error["MPPI, informed"]
    assert first > 2.0 and 0.5 < second < 2.0


def test_plans_find_the_edge_of_the_stick_band_where_gravity_lies_outside():
    """With the arm horizontal; the numbers are those of the page."""
    payload, friction = 0.6, 0.11
    edge, _ = replace(CAM, friction=(friction, friction)).band(elbow.MOTION.end)
    least = edge - elbow.weight(payload).torque(elbow.MOTION.end)  # N.m that keep the arm from sliding back
    page = PAGE.read_text(encoding="utf-8")
    assert f"{payload} kg with a friction of {friction} need {least:.2f} N.m" in page.replace("\n", " ")
    for name, most in (("MPPI, informed", 1.1), ("LQI, informed", 1.6)):
        held = example.run_block(name, np.array([[payload, friction]]), 0).torques[0, 2500:3000]
        shown = re.search(
            rf"informed {name[:4].strip(',')} (?:holds )?with ([\d.]+) N\.m", page.replace("\n", " ")
        )
        assert shown is not None and np.median(held) == pytest.approx(float(shown[1]), abs=0.02)
        assert least - 1e-3 < np.median(held) < most


def test_seeds_and_blocks_reproduce_the_loops_bit_for_bit():
    draws = np.array([[0.7, 0.12], [2.2, 0.16]])
    both = example.run_block("MPPI, estimate", draws, 6, periods=1060)
    second = example.run_block("MPPI, estimate", draws[1:], 7, periods=1060)
    other = example.run_block("MPPI, estimate", draws[1:], 8, periods=1060)
    assert np.array_equal(both.torques[1:], second.torques) and np.array_equal(both.angles[1:], second.angles)
    assert not np.array_equal(second.torques, other.torques)
    assert np.any(second.torques != 0.0)


def test_the_lqi_takes_the_estimate():
    belief = informed(2.2, 0.11)
    lqi = Lqi(belief=belief)
    assert lqi.controller.load.moment == elbow.weight(elbow.DESIGN_PAYLOAD).moment
    for k in range(11):
        lqi.torque(float(controllers.ANGLES[0]), k)
    assert lqi.controller.load.moment == elbow.weight(2.2).moment
    assert lqi.controller.cam.friction == (0.11, 0.11)


def test_figures_of_loops_with_known_ones():
    """Half a milliradian of error, 2 W at rest and 4 W else, off in the first rest."""
    heat = np.full((1, 4000), 4e-3)
    heat[:, example.LATE_REST] = 2e-3
    torques = np.ones((1, 4000))
    torques[:, :1500] = 0.0
    angles = controllers.ANGLES[None, 1:4001] + 5e-4
    expected = [14.0 + 4.0 * 0.25, 14.0, 0.5, 0.5, np.sqrt(2.0 / 0.170), 50.0]
    np.testing.assert_allclose(example.figures_of(heat, angles, torques), [expected], rtol=1e-9)


def test_the_interval_of_a_median_is_that_of_the_order_statistics():
    """Without a bootstrap: the ranks between which the population's median lies in 95 % of samples."""
    sample = np.sort(np.random.default_rng(7).normal(1.0, 1.0, 400))
    low, high = binom.ppf((0.025, 0.975), 400, 0.5).astype(int)
    middle, *interval = example.median_difference(sample)
    assert middle == 0.5 * (sample[199] + sample[200])
    assert sample[low - 4] <= interval[0] <= sample[low + 4]
    assert sample[high - 4] <= interval[1] <= sample[high + 4]
    assert example.median_difference(np.zeros(5)) == (0.0, 0.0, 0.0)


def test_a_small_study_reports_and_draws(monkeypatch, tmp_path, capsys):
    quick = {
        "LQI, informed": lambda payload, friction, random: Lqi(payload, friction),
        "LQI again": lambda payload, friction, random: Lqi(payload, friction),
        "MPPI, estimate": lambda payload, friction, random: Mppi(estimator(random, 8), random, plans=8),
    }
    monkeypatch.setattr(example, "PAIRS", (("LQI again", "LQI, informed"), ("MPPI, estimate", "LQI again")))
    monkeypatch.setattr(example, "CONTROLLERS", quick)
    monkeypatch.setattr(example, "ProcessPoolExecutor", lambda workers, context: ThreadPoolExecutor(workers))
    picture, table = tmp_path / "picture.png", tmp_path / "table.csv"
    example.main(["--draws", "2", "--workers", "1", "--picture", str(picture), "--table", str(table)])
    assert picture.is_file()
    with table.open(newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    printed = capsys.readouterr().out
    assert example.report([(*row[:3], *map(float, row[3:6])) for row in rows[1:]]) in printed
    difference = next(row for row in rows if row[1] == "LQI again - LQI, informed" and "heat" in row[2])
    assert difference[3:6] == ["0.0", "0.0", "0.0"]
