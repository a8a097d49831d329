"""dualcam.gym: tasks as environments. The oracles are gymnasium's own checker and vector environment, the
FMU's ledger of energy, and the closed loop of dualcam.systems with one handle and Python's floats."""

import subprocess
import sys
import warnings
from dataclasses import replace

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from dualcam import Fmu
from dualcam.errors import DualcamError, FleetError, FmuError, TaskError
from dualcam.gym import Batch, CarDoorTask, ElbowTask, KneeTask
from dualcam.gym.knee_task import WALKER, most_drive
from dualcam.systems.blocks.axis import CamAxis
from dualcam.systems.blocks.current_loop import CONTROL_PERIOD, CurrentLoop
from dualcam.systems.blocks.motor_bank import MotorBank
from dualcam.systems.machines import car_door, elbow, knee
from dualcam.systems.machines.swing import measured_swing

TASKS = {"Elbow": ElbowTask, "Knee": KneeTask, "CarDoor": CarDoorTask}
MODES = list(AutoresetMode)
LEDGER = ("spring", "kinetic", "heat_cam1", "heat_cam2", "heat_damper", "heat_shaft", "heat_stop")


def id_of(name):
    return f"dualcam/{name}-v0"


@pytest.fixture(params=TASKS)
def name(request):
    return request.param


def numbers(count, task, seed=1):
    return np.random.default_rng(seed).random((count, task.draws))


def same(one, other):
    """Whether two results of a vector environment agree bit for bit, infos included."""
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(same(a, b) for a, b in zip(one, other, strict=True))
    if one.dtype == object:
        return all(np.array_equal(a, b) for a, b in zip(one, other, strict=True))
    return one.dtype == other.dtype and np.array_equal(one, other)


# ---- gymnasium's own rules ----


def test_gymnasium_finds_no_fault(name):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        environment = gymnasium.make(id_of(name))
        check_env(environment.unwrapped)
        environment.close()
        environment.close()


def test_the_extra_is_named_where_gymnasium_is_absent():
    code = "import sys; sys.modules['gymnasium'] = None; import dualcam.gym"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert 'pip install "dualcam[gym]"' in run.stderr


@pytest.mark.parametrize("push", ["random", "bang", "flip"])
def test_observations_stay_in_their_space(name, push):
    environment = gymnasium.make_vec(id_of(name), num_envs=200)
    seen, _ = environment.reset(seed=5)
    environment.action_space.seed(5)
    for k in range(120):
        actions = environment.action_space.sample()
        if push == "flip":
            actions = np.full((200, 1), 1.0 if k % 9 < 5 else -1.0)
        if push == "bang":  # the largest torque, in the direction of the motion
            actions = np.where(seen[:, 1:2] < 0.0, -1.0, 1.0)
        seen, *_ = environment.step(actions)
        assert environment.observation_space.contains(seen)
    environment.close()


# ---- seeds and vectors ----


def run_of(environment, steps, seed=7):
    """All results of a run with random actions."""
    environment.action_space.seed(seed)
    results = [environment.reset(seed=seed)]
    for _ in range(steps):
        results.append(environment.step(environment.action_space.sample()))
    environment.close()
    return results


def test_a_seed_gives_the_same_run_bit_for_bit(name):
    first, second = (run_of(gymnasium.make_vec(id_of(name), num_envs=4), 40) for _ in range(2))
    assert all(same(a, b) for a, b in zip(first, second, strict=True))
    other = run_of(gymnasium.make_vec(id_of(name), num_envs=4), 1, seed=8)
    assert not same(first[0][0], other[0][0])


def episodes(environment, mode, steps, seed):
    """All results of a run in which ended episodes begin anew in the way of the mode."""
    random = np.random.default_rng(seed)
    results = [environment.reset(seed=seed)]
    for _ in range(steps):
        actions = random.uniform(-1.0, 1.0, (environment.num_envs, 1))
        results.append(environment.step(actions))
        ended = results[-1][2] | results[-1][3]
        if mode is AutoresetMode.DISABLED and ended.any():
            results.append(environment.reset(options={"reset_mask": ended}))
    environment.close()
    return results


@pytest.mark.parametrize("mode", MODES, ids=lambda mode: mode.name)
def test_the_fleet_equals_single_environments_in_every_mode(name, mode):
    count, steps, limit = 3, 95 if name == "Knee" else 25, 10
    singles = gymnasium.make_vec(
        id_of(name), num_envs=count, vectorization_mode="sync", vector_kwargs={"autoreset_mode": mode},
        max_episode_steps=limit if name != "Knee" else None,
    )  # fmt: skip
    fleet = gymnasium.make_vec(
        id_of(name), num_envs=count, autoreset_mode=mode, threads=2,
        **({"max_episode_steps": limit} if name != "Knee" else {}),
    )  # fmt: skip
    assert isinstance(singles, SyncVectorEnv) and not isinstance(fleet, SyncVectorEnv)
    assert singles.observation_space == fleet.observation_space
    assert singles.action_space == fleet.action_space
    expected, found = (episodes(environment, mode, steps, 3) for environment in (singles, fleet))
    ends = sum(int((result[2] | result[3]).sum()) for result in found if len(result) == 5)
    assert ends >= count
    for one, other in zip(expected, found, strict=True):
        assert same(one, other)


def test_the_knee_ends_by_itself_and_the_others_are_truncated(name):
    environment = gymnasium.make_vec(id_of(name), num_envs=3, max_episode_steps=100)
    results = episodes(environment, None, 100, 1)
    terminated, truncated = (np.any([result[k] for result in results[1:]], axis=0) for k in (2, 3))
    assert terminated.all() == (name == "Knee")
    assert truncated.all() == (name != "Knee")
    assert not any((result[2] | result[3]).any() for result in results[1:70])


def test_an_instance_does_not_depend_on_the_size_of_its_batch(name):
    task, count = TASKS[name](), 300
    drawn, torques = numbers(count, task), np.random.default_rng(2).uniform(-9.0, 9.0, (20, count))
    rows = []
    for part in (slice(0, count), slice(3, 5), slice(4, 5)):
        with Batch(task, len(drawn[part])) as batch:
            batch.reset(drawn[part])
            for torque in torques:
                seen, outcome = batch.step(torque[part])
        rows.append(
            [*seen[{0: 4, 3: 1, 4: 0}[part.start]], *(t[{0: 4, 3: 1, 4: 0}[part.start]] for t in outcome)]
        )
    assert rows[0] == rows[1] == rows[2]


# ---- physics ----


@pytest.mark.parametrize("voltage", [24.0, 6.0])
def test_a_bank_of_motors_is_the_current_loop(voltage):
    """The loop runs sample by sample. At 6 V most periods meet a limit, and the bank must see that."""
    motor = replace(car_door.MOTOR, voltage=voltage)
    random, bank, speed = np.random.default_rng(2), MotorBank(motor, 30), np.zeros(30)
    loops = [CurrentLoop(motor) for _ in range(30)]
    for k in range(100):
        wanted = random.uniform(-100.0, 100.0, 30) * (k % 20 < 15)
        speed = np.clip(speed + random.uniform(-0.3, 0.3, 30), -8.0, 8.0)
        found = bank.run(wanted, speed)
        for i, loop in enumerate(loops):
            period = loop.run(float(wanted[i]), float(speed[i]))
            for name in ("torque", "peak_torque", "heat", "energy"):
                assert getattr(found, name)[i] == pytest.approx(getattr(period, name), rel=1e-9, abs=1e-9)
        assert bank.current == pytest.approx([loop.current for loop in loops], abs=1e-9)


def test_the_elbow_is_the_closed_loop_of_the_blocks():
    task = ElbowTask()
    with Batch(task, 1) as batch, Fmu("forward") as fmu:
        batch.reset(numbers(1, task))
        scene = {key: float(value[0]) for key, value in batch.scene.items()}
        axis, loop = CamAxis(fmu), CurrentLoop(task.motor)
        start = elbow.plant_parameters(elbow.design_cam(), scene["payload"])
        start |= {f"cam{i}.friction": scene["friction"] for i in (1, 2)}
        axis.start(start, scene["start"])
        for torque in np.random.default_rng(3).uniform(-12.0, 12.0, 40):
            (seen,), outcome = batch.step([torque])
            heat = 0.0
            for _ in range(task.periods):
                motor = loop.run(float(torque), axis.speed)
                axis.step(motor.torque, elbow.weight(scene["payload"]), CONTROL_PERIOD)
                heat += motor.heat
            expected = [axis.angle, axis.speed, scene["target"], motor.torque]
            assert seen == pytest.approx(expected, rel=1e-11, abs=1e-11)
            assert outcome.motor_heat[0] == pytest.approx(heat, rel=1e-11)


def test_the_energy_of_supply_and_load_is_in_the_ledger_of_the_fmu(name):
    """Supply and load give what the winding, the inductance and the FMU's accounts take."""
    loads, angles, count = [], [], 30

    class Watched(TASKS[name]):
        def load_torque(self, scene, angle, period):
            loads.append(super().load_torque(scene, angle, period))
            return loads[-1]

        def wanted(self, scene, period):
            angles.append(self.gear.angle(batch.fleet.get("theta")))
            return super().wanted(scene, period)

    task = Watched()
    random, supplied, heat, impact = np.random.default_rng(4), *np.zeros((3, count))
    with Batch(task, count) as batch:
        batch.reset(numbers(count, task))
        stored = sum(batch.fleet.get(f"energy.{account}") for account in LEDGER)
        angles.append(batch.scene["start"])
        for _ in range(50):
            share = random.uniform(-1.0, 1.0, count) + np.linspace(-1.0, 1.0, count)
            _, outcome = batch.step(share * task.motor.peak_torque)
            supplied += outcome.energy_drawn - outcome.energy_returned
            heat += outcome.motor_heat
            impact += outcome.impact
        magnetic = 0.5 * task.motor.inductance * batch.motors.current**2
        taken = sum(batch.fleet.get(f"energy.{account}") for account in LEDGER) - stored
        stop_heat = batch.fleet.get("energy.heat_stop")
    load_work = np.sum(np.array(loads) * np.diff(angles, axis=0), axis=0)
    assert impact == pytest.approx(stop_heat, rel=1e-12, abs=1e-12)
    assert supplied.max() > 1.0 and impact.max() > 0.1  # J: the motor worked, and stops were hit
    assert supplied + load_work == pytest.approx(heat + magnetic + taken, rel=1e-9, abs=1e-9)


def test_the_reward_is_minus_the_weighted_terms(name):
    task, count = TASKS[name](energy_weight=2.0, error_weight=30.0, impact_weight=5.0), 20
    with Batch(task, count) as batch:
        batch.reset(numbers(count, task))
        for torque in np.random.default_rng(5).uniform(-12.0, 12.0, (40, count)):
            _, outcome = batch.step(torque)
            cost = 2.0 * outcome.energy_drawn + 30.0 * outcome.squared_error + 5.0 * outcome.impact
            assert -outcome.reward == pytest.approx(cost, rel=1e-14)


def test_a_load_inside_the_band_rests_without_current():
    task = ElbowTask(payload=(1.5, 1.5), friction=(0.14, 0.14))  # the cam's design
    with Batch(task, 50) as batch:
        first = batch.reset(numbers(50, task))
        for _ in range(20):
            seen, outcome = batch.step(np.zeros(50))
        held = seen[:, 0] == first[:, 0]
        assert held.mean() > 0.9
        assert not outcome.energy_drawn[held].any()


def test_the_door_weighs_what_the_example_says():
    task = CarDoorTask(
        mass=(car_door.MASS,) * 2, pitch=(car_door.PITCH,) * 2, roll=(0.0, 0.0), friction=(0.19, 0.19)
    )
    scene, angle = task.draw(numbers(3, task)), np.array([0.1, 0.5, 1.0])
    weight = car_door.weight(car_door.NOSE_UP)
    assert task.load_torque(scene, angle, np.zeros(3, int)) == pytest.approx(
        [weight.torque(a) for a in angle]
    )
    assert task.start_values(scene)["inertia.shaft"] == pytest.approx(car_door.INERTIA / car_door.RATIO**2)


def test_the_knee_is_driven_as_the_example_says():
    task = KneeTask(shank=(1.0, 1.0), cadence=(1.0, 1.0))
    scene = task.draw(numbers(1, task))
    swing = measured_swing(WALKER, 1.0, knee.MOTOR.inertia)
    for period in (0, 100, 300, 417):
        at = np.array([period])
        assert task.wanted(scene, at)[0] == pytest.approx(swing.angle[period], abs=1e-12)
        two = [WALKER.pendulum.drive(swing.hinge[k], 0.4 + swing.extension)[0] for k in (period, period + 1)]
        found = task.load_torque(scene, np.array([0.4]), at)[0]
        assert min(two) - 1e-6 <= found <= max(two) + 1e-6 or abs(found - np.mean(two)) < 1e-3
        assert abs(found) < most_drive()
    assert len(swing.time) - 1 == 418


# ---- bad input ----

BAD_ACTIONS = [
    (np.full((3, 1), np.nan), "nan"),
    (np.array([[0.0], [np.inf], [0.0]]), r"action\[1, 0\] = inf"),
    (np.zeros(3), r"shape \(3,\): allowed is \(3, 1\)"),
    (np.zeros((2, 1)), "allowed is"),
    ([["a"], ["b"], ["c"]], "real numbers"),
    ([[1.0], [1.0, 2.0], [0.0]], "real numbers"),
    (None, "real numbers"),
]


@pytest.mark.parametrize(("actions", "message"), BAD_ACTIONS)
def test_wrong_actions_of_many_move_nothing(actions, message):
    environment = gymnasium.make_vec(id_of("Elbow"), num_envs=3)
    environment.reset(seed=1)
    with pytest.raises(TaskError, match=message):
        environment.step(actions)
    assert not environment.unwrapped.batch.fleet.times.any()
    environment.close()


@pytest.mark.parametrize("action", [[np.nan], [0.0, 0.0], 0.0, "up", None])
def test_wrong_actions_of_one(action):
    environment = gymnasium.make(id_of("Elbow")).unwrapped
    environment.reset(seed=1)
    with pytest.raises(DualcamError, match="allowed"):
        environment.step(action)
    environment.close()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"payload": (2.0, 1.0)}, r"payload = \(2.0, 1.0\): allowed is \(low, high\) with 0 <= low"),
        ({"payload": (0.5, 9.0)}, "<= 3 kg"),
        ({"payload": 1.0}, "payload = 1.0"),
        ({"friction": (0.1, float("nan"))}, "friction"),
        ({"energy_weight": -1.0}, "energy_weight = -1.0: allowed is a finite number >= 0"),
        ({"error_weight": float("inf")}, "error_weight"),
    ],
)
def test_wrong_options_of_a_task(options, message):
    with pytest.raises(TaskError, match=message):
        gymnasium.make(id_of("Elbow"), **options)


def test_wrong_arguments_of_a_vector():
    with pytest.raises(TaskError, match="autoreset_mode = 'never': allowed are"):
        gymnasium.make_vec(id_of("Elbow"), num_envs=2, autoreset_mode="never")
    with pytest.raises(FmuError, match="max_episode_steps = 0: allowed is a whole number > 0"):
        gymnasium.make_vec(id_of("Elbow"), num_envs=2, max_episode_steps=0)
    with pytest.raises(FmuError, match="count = 0"):
        gymnasium.make_vec(id_of("Elbow"), num_envs=0)
    environment = gymnasium.make_vec(
        id_of("Elbow"), num_envs=2, autoreset_mode="Disabled", max_episode_steps=1
    )
    with pytest.raises(TaskError, match="call reset first"):
        environment.step(np.zeros((2, 1)))
    with pytest.raises(TaskError, match="seed has 3 entries"):
        environment.reset(seed=[1, 2, 3])
    environment.reset(seed=1)
    for mask in (np.zeros(2, bool), np.ones(3, bool), [1, 0]):
        with pytest.raises(TaskError, match="reset_mask"):
            environment.reset(options={"reset_mask": mask})
    environment.step(np.zeros((2, 1)))
    with pytest.raises(TaskError, match="instance 0 has ended"):
        environment.step(np.zeros((2, 1)))
    environment.close()
    environment.close()


def test_wrong_arguments_of_a_batch():
    task = ElbowTask()
    with Batch(task, 2) as batch:
        with pytest.raises(TaskError, match="call reset first"):
            batch.step(np.zeros(2))
        with pytest.raises(TaskError, match="first reset begins all"):
            batch.reset(numbers(2, task), [True, False])
        with pytest.raises(TaskError, match=r"numbers has shape \(3, 4\)"):
            batch.reset(numbers(3, task))
        with pytest.raises(TaskError, match="0 <= number < 1"):
            batch.reset(np.full((2, task.draws), np.nan))
        batch.reset(numbers(2, task))
        with pytest.raises(TaskError, match="chosen"):
            batch.reset(numbers(2, task), [0, 1])
        with pytest.raises(TaskError, match="torque of instance 1 = nan"):
            batch.step([0.0, np.nan])
        with pytest.raises(TaskError, match=r"shape \(2, 1\)"):
            batch.step(np.zeros((2, 1)))
    with pytest.raises(FmuError, match="closed"):
        batch.step(np.zeros(2))


def test_a_failed_instance_ends_all_episodes(monkeypatch):
    with Batch(ElbowTask(), 2) as batch:
        batch.reset(numbers(2, batch.task))

        def refuse(*arguments):
            raise FleetError("instance 1: refused", (1,))

        monkeypatch.setattr(batch.fleet, "step", refuse)
        with pytest.raises(FleetError, match="instance 1"):
            batch.step(np.zeros(2))
        monkeypatch.undo()
        with pytest.raises(TaskError, match="call reset first"):
            batch.step(np.zeros(2))
        batch.reset(numbers(2, batch.task))
        batch.step(np.zeros(2))
