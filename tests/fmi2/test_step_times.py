"""FMI 2.0: communication points, step sizes, and times of the experiment."""

import math

import pytest
from driver import STEP
from fmi2_inputs import FREE, INERTIA, drive, for_forward, last_time


@pytest.mark.parametrize("start", [0.0, -3.0, 1e6, 1e-300])
@pytest.mark.parametrize("h", [1e-9, 1e-3, 0.1, 7.3])
def test_lands_on_tc_plus_h(fmu, start, h):
    fmu.start(time=start)
    assert last_time(fmu) == start
    for _ in range(5):
        fmu.step(h)
        assert last_time(fmu) == fmu.time


def test_time_starts_at_zero_without_setup(fmu):
    fmu.enter(STEP).refused("fmi2DoStep", 1.0, 0.1, 1, mentions=("1", "0"))
    fmu.step(0.1)
    assert last_time(fmu) == 0.1


def test_rounding_of_the_masters_time(fmu):
    fmu.start()
    fmu.ok("fmi2DoStep", 0.0, 0.3, 1)
    fmu.ok("fmi2DoStep", 0.1 + 0.2, 0.001, 1)
    assert last_time(fmu) == 0.1 + 0.2 + 0.001 != 0.3 + 0.001


def test_rounding_near_zero_is_relative_to_the_step(fmu):
    fmu.start()
    fmu.ok("fmi2DoStep", 1e-17, 0.1, 1)


@pytest.mark.parametrize("t", [0.3 + 1e-9, 0.2, 0.0, -0.3, 1e300, math.nan, math.inf, -math.inf])
def test_refuses_another_time(fmu, t):
    fmu.start().step(0.3, **drive(fmu, 1.2))
    text = fmu.refused("fmi2DoStep", t, 0.1, 1, mentions=(f" {t:.9g}:", " 0.3"))
    assert "currentCommunicationPoint" in text
    fmu.step(0.1)


@pytest.mark.parametrize("h", [0.0, -0.0, -0.1, math.nan, math.inf, -math.inf])
def test_refuses_step_sizes(fmu, h):
    fmu.start().step(0.3, **drive(fmu, 1.2))
    fmu.refused("fmi2DoStep", fmu.time, h, 1, mentions=(f"communicationStepSize = {h:.9g}:",))
    fmu.step(0.1)


@for_forward
def test_a_step_that_fails_changes_nothing(fmu):
    fmu.start(FREE | {"stop.lower": -1e308, "stop.upper": 1e308})
    fmu.set_rates(tau=3.0)
    fmu.step(1.0)
    fmu.set({"tau": 1e300})
    rate = fmu.output_derivative("omega", 2)
    assert rate == pytest.approx(3.0 / INERTIA, rel=1e-14)
    fmu.refused("fmi2DoStep", 1.0, 1e10, 1, mentions=("step", "tau"))
    fmu.set({"tau": 1e300})  # derivatives are computed anew
    assert fmu.output_derivative("omega", 2) == rate
    fmu.step(1.0, tau=0.0)


def test_refuses_time_beyond_numbers(fmu):
    fmu.start(time=1.7e308).refused("fmi2DoStep", 1.7e308, 1.7e308, 1)


@pytest.mark.parametrize(
    "wrong, word",
    [
        ((1, 0.0, 0.0, 0, 0.0), "tolerance"),
        ((-1, -1e-6, 0.0, 0, 0.0), "tolerance"),
        ((1, math.nan, 0.0, 0, 0.0), "tolerance"),
        ((0, 0.0, math.nan, 0, 0.0), "startTime"),
        ((0, 0.0, math.inf, 0, 0.0), "startTime"),
        ((0, 0.0, 0.0, 1, math.nan), "stopTime"),
        ((0, 0.0, 2.0, -1, 1.0), "stopTime"),
    ],
)
def test_refuses_experiments(fmu, wrong, word):
    fmu.refused("fmi2SetupExperiment", *wrong, mentions=(word,))


@pytest.mark.parametrize(
    "good", [(0, math.nan, 0.0, 0, math.nan), (1, 1e-4, 0.0, 1, 0.0), (-1, 1e-9, 5.0, -1, 6.0)]
)
def test_accepts_experiments(fmu, good):
    fmu.ok("fmi2SetupExperiment", *good)
    assert last_time(fmu) == good[2]


@for_forward
def test_a_step_below_the_rounding_of_the_time_goes_on_in_a_time_that_stands_still(fmu):
    fmu.start(FREE, time=1e300)
    fmu.step(0.001, tau=3.0)
    fmu.step(0.001)
    assert last_time(fmu) == 1e300
    assert fmu.get("omega") == pytest.approx(3.0 * 0.002 / INERTIA, rel=1e-12)
