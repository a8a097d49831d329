"""Arrays that are no real numbers: durations become seconds where times are wanted, all else is refused."""

import datetime
import math
from decimal import Decimal

import numpy as np
import pint
import pytest

import dualcam
from dualcam.common.arrays import TIME, TRUTH, number_of, real_array
from dualcam.design import Helix, Mechanism, Spring, Table, synthesize
from dualcam.design.hertz import Pin, hertz_pressure
from dualcam.errors import DualcamError
from dualcam.gradient import DifferentiableFleet
from dualcam.identification import Recording
from dualcam.study import History, Plan, Vary

NANOSECONDS = np.arange(30) * 10_000_000  # every 10 ms
REFUSED = {
    "durations": (np.array([1, 2], "timedelta64[ns]"), r"timedelta64\[ns\].*np.timedelta64\(1, 's'\)"),
    "dates": (np.array(["2024-01-01"], "datetime64[s]"), r"datetime64\[s\].*t - t\[0\]"),
    "durations of Python": ([datetime.timedelta(seconds=1)], "object, such as datetime.timedelta"),
    "booleans": (np.array([True, False]), "bool: allowed are real numbers"),
    "a boolean among numbers": ([True, 2.0], "bool: allowed are real numbers. As numbers"),
    "a boolean in a row": ([[0.5, 1], (2.0, np.True_)], "bool: allowed are real numbers"),
    "a row of booleans": ([np.array([0.5]), np.array([True])], "bool: allowed are real numbers"),
    "text": (["1.0", "2.0"], "text, such as '1.0': allowed are real numbers"),
    "complex": ([1.0 + 0.0j], "complex128"),
    "objects": ([Decimal("0.1")], "object, such as Decimal"),
    "nothing": (None, "object, such as None"),
    "masked": (np.ma.masked_array([1.0, 2.0], [False, True]), "x has masked values"),
    "a unit": (pint.Quantity(np.array([1.0, 2.0]), "ms"), "x = .*millisecond.* has a unit"),
    "ragged": ([[1.0], [2.0, 3.0]], "x is no array of real numbers"),
}


@pytest.mark.parametrize("wrong", REFUSED)
def test_what_is_no_real_number_is_refused(wrong):
    values, message = REFUSED[wrong]
    with pytest.raises(DualcamError, match=message):
        real_array(values, "x")


def test_real_numbers_of_any_type():
    own = np.array([0.5, 1.0])
    assert real_array(own, "x") is own
    for values in (own.astype(np.float32), [0.5, 1], (0.5, 1.0), np.ma.masked_array(own), own[::-1][::-1]):
        assert real_array(values, "x").tolist() == [0.5, 1.0]
    assert real_array(np.array([3, 4], np.uint8), "x").dtype == np.float64
    assert real_array([[True, 2.0], [False, 3.0]], "x", kinds=TRUTH).tolist() == [[1.0, 2.0], [0.0, 3.0]]
    assert real_array([True, False], "x", kinds=TRUTH).tolist() == [1.0, 0.0]


@pytest.mark.parametrize("unit, per_second", [("ns", 10**9), ("us", 10**6), ("ms", 1000), ("s", 1)])
def test_durations_become_seconds(unit, per_second):
    given = np.array([0, per_second, 3 * per_second], f"timedelta64[{unit}]")
    assert real_array(given, "time", kinds=TIME).tolist() == [0.0, 1.0, 3.0]


@pytest.mark.parametrize(
    "value", [np.timedelta64(5, "ns"), "1", True, None, math.nan, 10**400, [1.0], pint.Quantity(1.0, "s")]
)
def test_what_is_no_number(value):
    with pytest.raises(DualcamError, match=r"h = .*: allowed is a finite number"):
        number_of(value, "h")


# ---- wherever a user hands in arrays ----


def test_a_recording_with_durations_is_that_with_seconds():
    seconds, theta = NANOSECONDS / 1e9, np.linspace(0.1, 0.4, 30)
    durations = NANOSECONDS.astype("timedelta64[ns]")
    expected = Recording.from_arrays(seconds, theta, 3.0 + theta)
    found = Recording.from_arrays(durations, theta, 3.0 + theta)
    assert found.time == pytest.approx(expected.time, rel=1e-15)
    with pytest.raises(dualcam.errors.IdentificationError, match="theta has elements of type timedelta64"):
        Recording.from_arrays(seconds, durations, theta)
    with pytest.raises(dualcam.errors.IdentificationError, match=r"time has elements of type datetime64"):
        Recording.from_arrays(np.datetime64("2024-01-01") + durations, theta, theta)


def test_a_recording_of_pandas():
    pandas = pytest.importorskip("pandas")
    theta = pandas.Series(np.linspace(0.1, 0.4, 30))
    time = pandas.Series(pandas.to_timedelta(NANOSECONDS / 1e9, unit="s"))
    assert Recording.from_arrays(time, theta, theta).time == pytest.approx(NANOSECONDS / 1e9, rel=1e-15)


DURATIONS = np.array([1, 2, 3, 4], "timedelta64[ns]")
SPRING = Spring(preload=50.0, stiffness=50e3)
MECHANISM = Mechanism((Helix(0.02, 0.7), Helix(0.02, 0.7)), (0.14, 0.14), SPRING, 1.2)
PLACES = {
    "table": lambda wrong: Table(0.02, wrong, [0.0, 1e-3, 2e-3, 3e-3]),
    "torque": lambda wrong: synthesize((wrong, [5.0] * 4), 1.2, SPRING),
    "mechanism": lambda wrong: MECHANISM.torque(wrong, "loading"),
    "groove": lambda wrong: MECHANISM.grooves[0].at(wrong),
    "spring": SPRING.force,
    "load": lambda wrong: hertz_pressure(wrong, Pin(3e-3, 6e-3)),
    "efficiency": lambda wrong: dualcam.design.efficiency((wrong, 0.7), (0.14, 0.14)),
    "values of a study": lambda wrong: Plan("grid", {"spring.preload": Vary(values=wrong)}),
    "weights": lambda wrong: Plan("random", {"tau": Vary(values=[1, 2, 3, 4], weights=wrong)}, runs=3),
    "table of a study": lambda wrong: Plan("table", {"tau": Vary()}, table=np.asarray(wrong)[:, None]),
    "column of a study": lambda wrong: Plan.from_columns({"tau": wrong}),
}


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("wrong", [DURATIONS, [datetime.timedelta(k) for k in range(4)]])
def test_no_duration_is_taken_for_numbers(place, wrong):
    with pytest.raises(DualcamError, match="allowed are real numbers"):
        PLACES[place](wrong)


@pytest.mark.parametrize("place", [name for name in PLACES if name != "table of a study"])
def test_no_boolean_is_taken_for_a_number(place):
    with pytest.raises(DualcamError, match="type bool: allowed are real numbers"):
        PLACES[place]([True, 2.0, 3.0, 4.0])


@pytest.mark.parametrize("wrong", [DURATIONS, list(DURATIONS)])
def test_no_duration_is_taken_for_a_history(wrong):
    assert any("allowed are real numbers" in text for text in History(wrong, [1.0] * 4).problems())


def test_values_of_a_study_in_an_array():
    plan = Plan("grid", {"spring.preload": Vary(values=np.array([50.0, 60.0]))})
    assert plan.rows(0, 2).tolist() == [[50.0], [60.0]]


SCALARS = {
    "start": lambda fmu: fmu.start({"tau": np.timedelta64(5, "ns")}),
    "truth": lambda fmu: fmu.start({"tau": True}),
    "set": lambda fmu: fmu.set("tau", np.timedelta64(5, "ns")),
    "whole number": lambda fmu: fmu.start({"contacts": np.timedelta64(2, "ns")}),
    "group": lambda fmu: setattr(fmu.reals("tau", "F_ext"), "values", DURATIONS[:2]),
    "seed": lambda fmu: fmu.directional_derivative(["alpha"], ["tau"], DURATIONS[:1]),
    "step": lambda fmu: fmu.step(np.timedelta64(1_000_000, "ns")),
    "time": lambda fmu: setattr(fmu, "time", np.timedelta64(1, "ns")),
}


@pytest.mark.parametrize("call", SCALARS)
def test_no_duration_reaches_an_fmu(call):
    with dualcam.Fmu("forward") as fmu:
        fmu.start({"initial.theta": 0.5, "tau": 3.0})
        with pytest.raises(DualcamError, match="allowed"):
            SCALARS[call](fmu)


def test_no_duration_reaches_a_fleet():
    two, values = DURATIONS[:2], {"tau": np.timedelta64(5, "ns")}
    for parameters in (values, {"tau": two}, {"contacts": two}, {"tau": np.array([True, False])}):
        with pytest.raises(dualcam.errors.FmuError, match=r"(tau|contacts) has elements of type"):
            dualcam.Fleet("forward", 2, parameters=parameters)
    with dualcam.Fleet("forward", 2) as fleet:
        for call in (
            lambda: fleet.step(two[:, None], 1e-3),
            lambda: fleet.rollout(two[:, None, None], 1e-3),
            lambda: fleet.set("tau", two),
            lambda: fleet.reset(parameters={"tau": two}),
            lambda: fleet.step([[1.0], [2.0]], np.timedelta64(1, "ns")),
        ):
            with pytest.raises(dualcam.errors.FmuError, match="allowed"):
                call()
        assert fleet.times.tolist() == [0.0, 0.0]


def test_a_run_with_gradients_names_the_argument_that_is_wrong():
    start, u, p = [[0.4, 0.0]], np.full((1, 5, 1), 5.0), [[0.14]]
    with DifferentiableFleet("forward", 1, 1e-3, parameters=["cam1.friction"]) as fleet:
        for arguments, message in (
            (([0.4, 0.0], u, p), r"start has shape \(2,\): allowed is \(1, 2\)"),
            (([["a", "b"]], u, p), "start has elements of type text"),
            ((start, u), r"p is missing: allowed is an array of shape \(1, 1\) with cam1.friction"),
            ((start, u, [0.14]), r"p has shape \(1,\): allowed is \(1, 1\)"),
            ((start, DURATIONS[None, :, None], p), "u has elements of type timedelta64"),
        ):
            with pytest.raises(dualcam.errors.FmuError, match=message):
                fleet.rollout(*arguments)
        with pytest.raises(dualcam.errors.FmuError, match=r"by_states has shape \(1, 5\)"):
            fleet.rollout(start, u, p).gradient(np.zeros((1, 5)))
