"""dualcam.Fleet. What every instance must agree with, bit for bit, is the same FMU alone in a dualcam.Fmu."""

import gc
import math
import threading

import numpy as np
import pytest
from driver import ROOT, models
from pythonfmu.builder import FmuBuilder
from refusals import refused_by

import dualcam
from dualcam import Fleet, Fmu
from dualcam.errors import FleetError, FmuError, UnknownVariableError

FORWARD, INVERSE = (model.fmu for model in models.values())
LIGHT = {"inertia.shaft": 0.01}
STEP = 1e-3  # s


def refused(*mentions, error=FmuError):
    """Expects an error that says all of this."""
    return refused_by(error, *mentions)


def alone(source, start, inputs, outputs, u, h):
    """Outputs of one instance after each step, shape (steps, m)."""
    with Fmu(source) as fmu:
        fmu.start(start)
        written, read = fmu.reals(*inputs), fmu.reals(*outputs)
        rows = []
        for values in u:
            written.values = values
            written.write()
            fmu.step(h)
            rows.append(read.read())
    return np.array(rows)


def history(count, steps):
    """Torques that load, stick, release and meet the stops, shape (count, steps, 1), N.m."""
    time = np.arange(steps) * STEP
    rates = np.linspace(5.0, 40.0, count)[:, None]
    return (7.0 * np.sin(rates * time))[:, :, None]


# ---- each instance is as if alone ----

MECHANISMS = {
    "helices": {},
    "ellipses": {"cam1.profile": 2, "cam2.profile": 2, "inertia.follower_mass": 0.3, "damper.c_load": 20.0},
}


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("mechanism", MECHANISMS)
def test_every_instance_is_bit_for_bit_as_if_alone(mechanism, threads):
    count, steps = 40, 120
    stiffness, u = np.linspace(40e3, 60e3, count), history(count, steps)
    outputs = ["theta", "omega", "energy.residual", "peak.reaction1"]
    start = LIGHT | MECHANISMS[mechanism]
    fleet = Fleet(
        FORWARD, count, outputs=outputs, parameters=start | {"spring.stiffness": stiffness}, threads=threads
    )
    with fleet:
        stepped = np.stack([fleet.step(np.ascontiguousarray(u[:, k]), STEP) for k in range(steps)], axis=1)
        fleet.reset()
        rolled = fleet.rollout(u, STEP)
    assert np.array_equal(stepped, rolled)
    for i in range(0, count, 13):
        own = alone(FORWARD, start | {"spring.stiffness": stiffness[i]}, ["tau"], outputs, u[i], STEP)
        assert np.array_equal(rolled[i], own)
    assert len(np.unique(rolled[:, -1, 0])) > count / 2  # they do differ


def test_parameters_of_every_type_per_instance(tmp_path):
    table = tmp_path / "groove.csv"
    angle = np.linspace(0.0, 1.6, 30)
    rows = "".join(f"{a!r},{0.02 * a + 0.001 * a * a!r}\n" for a in angle.tolist())
    table.write_text("psi_rad,z_m\n" + rows)
    each = {
        "cam1.profile": np.array([1, 3]),
        "cam1.table": ["", str(table)],
        "ledger": [True, False],
        "cam2.lead_angle": [0.7, 0.8],
    }
    u = np.full((2, 50, 1), 6.0)
    with Fleet("forward", 2, parameters=LIGHT | each) as fleet:
        rolled = fleet.rollout(u, STEP)
        assert fleet.get("cam1.profile").tolist() == [1, 3]
        assert fleet.get("ledger").tolist() == [True, False]
    for i in range(2):
        own = {name: values[i] for name, values in each.items()}
        assert np.array_equal(rolled[i], alone(FORWARD, LIGHT | own, ["tau"], ["theta", "omega"], u[i], STEP))


def test_the_inverse_fmu_and_other_ports():
    names, wanted = ["theta", "omega", "alpha", "F_ext"], ["tau", "z", "v"]
    u = np.random.default_rng(1).uniform([0.1, -2.0, -5.0, -3.0], [1.3, 2.0, 5.0, 3.0], (5, 30, 4))
    with Fleet("inverse", 5, names, wanted) as fleet:
        rolled = fleet.rollout(u, STEP)
    for i in range(5):
        assert np.array_equal(rolled[i], alone(INVERSE, {}, names, wanted, u[i], STEP))


@pytest.mark.parametrize("threads", [1, 2])
def test_an_fmu_of_pythonfmu(tmp_path, threads):
    """Its steps run in Python, which the fleet does not hold."""
    script = ROOT / "tests" / "support" / "integrator_slave.py"
    fmu = FmuBuilder.build_FMU(script, dest=tmp_path)
    gains, u = np.array([1.0, -2.0, 0.5]), np.random.default_rng(1).normal(size=(3, 40, 1))
    with Fleet(fmu, 3, inputs=["u"], outputs=["y"], parameters={"gain": gains}, threads=threads) as fleet:
        found = fleet.rollout(u, 0.01)
    expected = np.cumsum(0.01 * gains[:, None] * u[:, :, 0], axis=1)
    assert np.array_equal(found[:, :, 0], expected)


def test_start_time_and_tolerance():
    parameters = LIGHT | MECHANISMS["ellipses"]
    with Fleet(FORWARD, 1, parameters=parameters, time=2.5, tolerance=1e-4) as fleet, Fmu(FORWARD) as fmu:
        fmu.start(parameters, time=2.5, tolerance=1e-4)
        torque = fmu.reals("tau")
        torque.values = [5.0]
        torque.write()
        fmu.step(0.05)
        assert fleet.step([[5.0]], 0.05)[0, 0] == fmu.real("theta")
        assert fleet.times.tolist() == [2.55]


def test_a_fleet_without_inputs_or_outputs():
    with Fleet(FORWARD, 3, inputs=[], outputs=["theta"], parameters=LIGHT | {"tau": 5.0}) as fleet:
        assert fleet.rollout(np.zeros((3, 10, 0)), STEP)[0, -1, 0] > 0.0
    with Fleet(FORWARD, 3, outputs=[]) as fleet:
        assert fleet.step(np.zeros((3, 1)), STEP).shape == (3, 0)


def test_arrays_are_used_as_they_are():
    u, out = np.full((4, 1), 5.0), np.full((4, 2), math.nan)
    with Fleet(FORWARD, 4, parameters=LIGHT) as fleet:
        assert fleet.step(u, STEP, out) is out
        again = fleet.step([[5]] * 4, STEP)  # whole numbers in lists will do, too
        assert np.isfinite(out).all() and (again[:, 0] > out[:, 0]).all()


# ---- runs, values, states ----


def test_reset_of_some():
    u = np.full((3, 1), 6.0)
    with Fleet(FORWARD, 3, parameters=LIGHT) as fleet:
        first = fleet.step(u, STEP)
        second = fleet.step(u, STEP)
        fleet.reset([1], {"initial.theta": 0.3})
        assert fleet.times.tolist() == [2 * STEP, 0.0, 2 * STEP]
        assert fleet.get("theta").tolist() == [second[0, 0], 0.3, second[0, 0]]
        fleet.reset(np.array([True, False, False]))
        fleet.set("tau", 6.0)
        third = fleet.step(u, STEP)
        assert third[0].tolist() == first[0].tolist()
        fleet.reset()  # instance 1 keeps its own start value
        assert fleet.get("theta").tolist() == [0.0, 0.3, 0.0]
        fleet.reset(parameters={"initial.theta": [0.1, 0.2, 0.4]})
        assert fleet.get("theta").tolist() == [0.1, 0.2, 0.4]


def test_set_of_some():
    with Fleet(FORWARD, 3, parameters=LIGHT) as fleet:
        fleet.set("cam1.friction", [0.1, 0.2, 0.3], [0, 2])
        assert fleet.get("cam1.friction").tolist() == [0.1, 0.14, 0.3]


def test_states_of_some():
    u = history(4, 60)
    with Fleet(FORWARD, 4, parameters=LIGHT) as fleet:
        fleet.rollout(u[:, :20].copy(), STEP)
        state = fleet.save([0, 2])
        assert repr(state) == "<FleetState of 2 instances>"
        first = fleet.rollout(u[:, 20:40].copy(), STEP)
        fleet.restore(state)
        assert np.allclose(fleet.times, [0.02, 0.04, 0.02, 0.04])
        again = fleet.rollout(u[:, 20:40].copy(), STEP)
        assert np.array_equal(again[[0, 2]], first[[0, 2]])
        assert not np.array_equal(again[1], first[1])
        fleet.restore(state, [2])
        with refused("instance 1 was not saved"):
            fleet.restore(state, [1])
    del state
    gc.collect()


def test_a_state_of_another_fleet_is_refused():
    with Fleet(FORWARD, 2) as one, Fleet(FORWARD, 2) as other:
        with refused("allowed is a FleetState from save of this fleet"):
            one.restore(other.save())
        with refused("restore"):
            one.restore("yesterday")


# ---- failures ----


REFUSED = {
    "one of many": ("cam1.friction", [0.1, -1.0, 0.2], (1,), "instance 1: .*cam1.friction = -1"),
    "not a number": ("tau", math.nan, (0, 1, 2), "tau = nan"),
    "fixed": ("inertia.shaft", 0.1, (0, 1, 2), "inertia.shaft is fixed"),
}


@pytest.mark.parametrize("wrong", REFUSED)
@pytest.mark.parametrize("threads", [1, 3])
def test_a_refused_value_changes_nothing(wrong, threads):
    name, values, instances, mention = REFUSED[wrong]
    u = history(3, 40)
    with Fleet(FORWARD, 3, parameters=LIGHT, threads=threads) as fleet:
        expected = fleet.rollout(u, STEP)
        fleet.reset()
        first = fleet.rollout(u[:, :20].copy(), STEP)
        with refused(mention, "no instance has changed", error=FleetError) as found:
            fleet.set(name, values)
        assert found.value.instances == instances
        assert not fleet.failed.any()
        assert np.array_equal(np.hstack([first, fleet.rollout(u[:, 20:].copy(), STEP)]), expected)


def test_a_refused_reset_changes_nothing():
    u = np.full((3, 1), 6.0)
    with Fleet(FORWARD, 3, parameters=LIGHT) as fleet:
        fleet.step(u, STEP)
        theta = fleet.get("theta")
        with refused("instance 2: .*cam1.radius", "no instance has changed", error=FleetError):
            fleet.reset(parameters={"cam1.radius": [0.02, 0.03, -1.0], "initial.theta": 0.4})
        assert np.array_equal(fleet.get("theta"), theta) and fleet.times.tolist() == [STEP] * 3
        fleet.reset()  # with the earlier start values
        assert fleet.get("theta").tolist() == [0.0, 0.0, 0.0]
        assert fleet.get("cam1.radius").tolist() == [0.02, 0.02, 0.02]


def failing_fleet(count):
    """A fleet in which a step fails where the instance's friction is negative."""
    return Fleet(FORWARD, count, inputs=["tau", "cam1.friction"], parameters=LIGHT)


def test_a_loop_goes_on_without_the_instance_that_fails():
    """Its angle is NaN, and so is the torque that a controller makes of it."""
    state, reports, target = np.zeros((3, 2)), [], 0.6  # rad
    with failing_fleet(3) as fleet:
        for period in range(400):
            torque = 4.0 + 20.0 * (target - state[:, 0]) - 0.8 * state[:, 1]  # N.m
            friction = np.full(3, 0.14)
            friction[1] = -1.0 if period == 50 else 0.14
            try:
                state = fleet.step(np.column_stack([torque, friction]), STEP)
            except FleetError as error:
                reports.append((period, error.instances))
                state = error.outputs
        assert reports == [(50, (1,))]
        assert fleet.failed.tolist() == [False, True, False]
        assert np.isnan(state[1]).all() and math.isnan(fleet.get("theta")[1])
        assert np.allclose(state[[0, 2], 0], target, atol=0.1)  # friction leaves an error
        assert np.array_equal(state[0], state[2])
        fleet.reset([1])
        assert not fleet.failed.any()
        assert np.isfinite(fleet.step(np.full((3, 2), 0.14), STEP)).all()


def test_an_instance_that_goes_on_gets_no_torque_that_is_not_finite():
    with failing_fleet(3) as fleet:
        with pytest.raises(FleetError):
            fleet.step([[5.0, 0.14], [5.0, -1.0], [5.0, 0.14]], STEP)
        with refused("tau of instance 2 = nan: .*no instance was stepped"):
            fleet.step([[5.0, 0.14], [math.nan, 0.14], [math.nan, 0.14]], STEP)
        assert fleet.times.tolist() == [STEP, 0.0, STEP]


def test_a_fleet_without_an_instance_that_works_says_so():
    with failing_fleet(2) as fleet:
        u = np.full((2, 2), -1.0)
        with refused("2 of 2 instances failed", error=FleetError):
            fleet.step(u, STEP)
        with refused("all instances have failed", "reset or restore", error=FleetError) as found:
            fleet.step(u, STEP)
        assert found.value.instances == (0, 1) and np.isnan(found.value.outputs).all()
        with refused("no instance has changed", error=FleetError):
            fleet.reset(parameters={"cam1.radius": [0.02, -1.0]})
        assert fleet.failed.all()
        fleet.reset()
        assert np.isfinite(fleet.step(np.full((2, 2), 0.14), STEP)).all()


def test_an_fmu_that_fails_in_one_instance(decay):
    """The FMU refuses steps of another length, with fmi2Discard."""
    with Fleet(decay, 2, inputs=[], outputs=["x"], parameters={"rate": [1.0, 2.0]}) as fleet:
        moved = fleet.step(np.zeros((2, 0)), 0.125)
        assert moved[:, 0].tolist() == [math.exp(-0.125), math.exp(-0.25)]
        with refused("2 of 2 instances failed", "fmi2Discard", error=FleetError) as found:
            fleet.step(np.zeros((2, 0)), 0.1)
        assert found.value.instances == (0, 1) and np.isnan(found.value.outputs).all()
        fleet.reset()
        assert np.array_equal(fleet.step(np.zeros((2, 0)), 0.125), moved)
        with refused("cannot save its state"):
            fleet.save()


def test_outputs_of_the_others_are_in_the_error():
    """An input that the FMU refuses in the middle of a rollout."""
    with Fleet(FORWARD, 2, inputs=["cam1.friction"], parameters=LIGHT | {"tau": 6.0}) as fleet:
        u = np.full((2, 10, 1), 0.14)
        u[1, 4] = -1.0
        with refused("instance 1: ", error=FleetError) as found:
            fleet.rollout(u, STEP)
        outputs = found.value.outputs
    assert (
        np.isfinite(outputs[0]).all() and np.isfinite(outputs[1, :4]).all() and np.isnan(outputs[1, 4:]).all()
    )
    assert np.array_equal(outputs[0, :4], outputs[1, :4])


def test_after_fatal_nothing_is_called(decay):
    fleet = Fleet(decay, 2, inputs=[], outputs=["x"], parameters={"rate": [1.0, -1.0]})
    with refused("fmi2Fatal"):
        fleet.step(np.zeros((2, 0)), 0.125)
    with refused("fmi2Fatal"):
        fleet.reset()
    fleet.close()


def test_many_failures_are_told_in_short():
    with Fleet(FORWARD, 100) as fleet:
        with refused("100 of 100 instances failed", "and 97 more", error=FleetError) as found:
            fleet.set("cam1.friction", -1.0)
        assert found.value.instances == tuple(range(100))
        assert len(found.value.reasons) == 16


def test_a_start_value_that_one_instance_refuses():
    with refused("instance 2: .*cam1.radius", error=FleetError):
        Fleet(FORWARD, 3, parameters={"cam1.radius": [0.02, 0.03, -0.02]})


# ---- wrong use: one error, and no instance has moved ----

WRONG_INPUTS = {
    "shape": (np.zeros((3, 2)), "u has shape \\(3, 2\\): allowed is \\(3, 1\\)"),
    "rows": (np.zeros((2, 1)), "allowed is \\(3, 1\\)"),
    "ragged": ([[1.0], [2.0, 3.0], [4.0]], "real numbers"),
    "text": ([["a"], ["b"], ["c"]], "real numbers"),
    "complex": (np.zeros((3, 1), complex), "complex128"),
    "nothing": (None, "u "),
    "nan": ([[1.0], [math.nan], [2.0]], "tau of instance 1 = nan: .*no instance was stepped"),
    "infinite": ([[1.0], [2.0], [math.inf]], "tau of instance 2 = inf"),
}


@pytest.mark.parametrize("wrong", WRONG_INPUTS)
def test_wrong_inputs_move_nobody(wrong):
    u, mention = WRONG_INPUTS[wrong]
    with Fleet(FORWARD, 3, parameters=LIGHT) as fleet:
        fleet.step(np.full((3, 1), 6.0), STEP)
        before = fleet.get("theta")
        with refused(mention):
            fleet.step(u, STEP)
        assert np.array_equal(fleet.get("theta"), before) and fleet.times.tolist() == [STEP] * 3
        assert not fleet.failed.any()
        fleet.step(np.full((3, 1), 6.0), STEP)


def test_wrong_histories():
    with Fleet(FORWARD, 2) as fleet:
        with refused("allowed is \\(2, 1, 1\\)"):
            fleet.rollout(np.zeros((2, 1)), STEP)
        with refused("real numbers"):
            fleet.rollout([[[1.0]], [[1.0], [2.0]]], STEP)
        u = np.zeros((2, 7, 1))
        u[1, 3] = math.nan
        with refused("tau of instance 1 in step 3 = nan"):
            fleet.rollout(u, STEP)
        assert fleet.rollout(np.zeros((2, 0, 1)), STEP).shape == (2, 0, 2)


def test_both_names_of_the_step():
    with Fleet(FORWARD, 1) as fleet, Fmu(FORWARD) as fmu:
        for name in ("step", "h"):
            fleet.step([[1.0]], **{name: STEP})
            fleet.rollout([[[1.0]]], **{name: STEP})
        fmu.start()
        for name in ("step", "size"):
            fmu.step(**{name: 2.0 * STEP})
        for call in (
            *(lambda: fleet.step([[1.0]], STEP, h=STEP), lambda: fleet.rollout([[[1.0]]], STEP, h=STEP)),
            lambda: fmu.step(STEP, size=STEP),
        ):
            with refused("step = 0.001 and ", "they mean the same"):
                call()
        assert fleet.times[0] == pytest.approx(fmu.time) == pytest.approx(4.0 * STEP)


@pytest.mark.parametrize("h", [0.0, -1.0, math.nan, math.inf, "1", None])
def test_wrong_steps(h):
    with Fleet(FORWARD, 1) as fleet, refused("step = ", "finite number > 0"):
        fleet.step([[1.0]], h)


WRONG_BUFFERS = {
    "rows": np.zeros((2, 2)),
    "float32": np.zeros((1, 2), np.float32),
    "columns": np.zeros((1, 1)),
    "list": [[0.0, 0.0]],
    "strided": np.zeros((1, 4))[:, ::2],
    "read-only": np.broadcast_to(0.0, (1, 2)),
}


@pytest.mark.parametrize("wrong", WRONG_BUFFERS)
def test_wrong_buffers(wrong):
    with Fleet(FORWARD, 1) as fleet, refused("out: allowed is a writeable"):
        fleet.step([[1.0]], STEP, WRONG_BUFFERS[wrong])


WRONG_FLEETS = {
    "count": ({"count": 0}, "count = 0"),
    "half": ({"count": 1.5}, "count = 1.5"),
    "threads": ({"threads": 0}, "threads = 0"),
    "too many": ({"threads": 1000}, "from 1 to 256"),
    "input": ({"inputs": ["taw"]}, "no variable 'taw'.*tau"),
    "input twice": ({"inputs": ["tau", "F_ext", "tau"]}, "inputs = .*: allowed is each variable once"),
    "integer port": ({"outputs": ["mode"]}, "mode is Integer"),
    "one text": ({"inputs": "tau"}, "list of names"),
    "parameter": ({"parameters": {"cam1.fricton": 0.1}}, "cam1.friction"),
    "shape": ({"parameters": {"cam1.friction": [0.1, 0.2, 0.3]}}, "cam1.friction has shape \\(3,\\)", "(2,)"),
    "kind": ({"parameters": {"contacts": [1, 1.5]}}, "instance 1: contacts = 1.5"),
    "no dict": ({"parameters": [1, 2]}, "allowed is a dict"),
    "tolerance": ({"tolerance": -1.0}, "tolerance = -1.0"),
}


@pytest.mark.parametrize("wrong", WRONG_FLEETS)
def test_wrong_fleets(wrong):
    arguments, mention = WRONG_FLEETS[wrong][:2]
    with refused(mention):
        Fleet(**{"fmu": FORWARD, "count": 2} | arguments)


def test_other_files(tmp_path):
    with refused("FMI 3.0: allowed is FMI 2.0"):
        Fleet(FORWARD.parent / "fmi3" / FORWARD.name, 2)
    with refused("there is no file"):
        Fleet(tmp_path / "no.fmu", 2)


def test_other_names():
    with Fleet(FORWARD, 2) as fleet:
        with refused("no variable 'thata'.*theta", error=UnknownVariableError):
            fleet.get("thata")
        with refused("is String"):
            fleet.get("cam1.table")
        with refused("from 0 to 1"):
            fleet.reset([2])
        with refused("from 0 to 1"):
            fleet.save(["a"])


def test_a_closed_fleet():
    fleet = Fleet(FORWARD, 2)
    state = fleet.save()
    fleet.close()
    fleet.close()
    assert repr(fleet) == "<Fleet of 2 DualCamForward, closed>"
    for call in (
        *(fleet.reset, fleet.save, fleet.__enter__, lambda: fleet.restore(state)),
        *(lambda: fleet.step(np.zeros((2, 1)), STEP), lambda: fleet.get("theta")),
        *(lambda: fleet.times, lambda: fleet.failed),
    ):
        with refused("this fleet is closed"):
            call()


def test_a_dropped_fleet_removes_its_files():
    fleet = Fleet(FORWARD, 2)
    folder = fleet._core._unpacked.folder
    assert folder.is_dir()
    del fleet
    gc.collect()
    assert not folder.exists()


def test_two_threads_on_one_fleet():
    """The second call is refused; no instance is stepped twice at once."""
    count = 200
    u = np.full((count, 400, 1), 6.0)
    answers = []
    with Fleet(FORWARD, count, parameters=LIGHT | MECHANISMS["ellipses"]) as fleet:

        def roll():
            try:
                answers.append(fleet.rollout(u, STEP))
            except FmuError as error:
                answers.append(str(error))

        workers = [threading.Thread(target=roll) for _ in range(4)]
        for worker in workers:
            worker.start()
        for worker in workers:
            worker.join()
        rolled = [answer for answer in answers if isinstance(answer, np.ndarray)]
        assert rolled
        assert {answer for answer in answers if isinstance(answer, str)} <= {
            "this fleet is at work in another thread: one call at a time"
        }
        assert np.allclose(fleet.times, 0.4 * len(rolled))


def test_the_library_of_a_checkout_is_found():
    from dualcam.fmi.library import fleet_library_path

    assert fleet_library_path().is_relative_to(ROOT)
    assert dualcam.Fleet is Fleet
