"""FMI 2.0: derivatives of inputs and of outputs."""

import math
from ctypes import c_int

import pytest
from driver import OK, STEP, UNKNOWN_REFERENCE, to_c
from fmi2_inputs import FREE, INERTIA, LIFT, SWING, for_each, for_forward


@for_forward
def test_an_input_with_a_rate(fmu):
    fmu.start(FREE)
    fmu.set({"tau": 1.0})
    fmu.set_rates(tau=3.0)
    fmu.step(2.0)
    assert fmu.get("tau") == 7.0
    assert fmu.get("omega") == pytest.approx((1.0 * 2 + 3.0 * 2**2 / 2) / INERTIA, rel=1e-14)
    assert fmu.get("theta") == pytest.approx((1.0 * 2**2 / 2 + 3.0 * 2**3 / 6) / INERTIA, rel=1e-14)


@for_forward
def test_rates_of_two_inputs_in_two_calls(fmu):
    fmu.start(FREE)
    fmu.set_rates(tau=3.0)
    fmu.set_rates(F_ext=2.0)
    fmu.step(2.0)
    assert (fmu.get("tau"), fmu.get("F_ext")) == (6.0, 4.0)


@for_forward
def test_a_rate_lasts_one_step(fmu):
    fmu.start(FREE)
    fmu.set_rates(tau=1.0)
    fmu.step(1.0)
    omega = fmu.get("omega")
    fmu.step(1.0)
    assert fmu.get("tau") == 1.0
    assert fmu.get("omega") - omega == pytest.approx(1.0 / INERTIA, rel=1e-14)


@for_forward
def test_a_value_leaves_the_rate_alone(fmu):
    fmu.start(FREE)
    fmu.set_rates(tau=1.0)
    fmu.step(1.0, tau=5.0)
    assert fmu.get("tau") == 6.0


@for_forward
def test_tuning_leaves_the_rate_alone(fmu):
    fmu.start(FREE)
    fmu.set_rates(tau=1.0)
    fmu.set({"spring.preload": 0.0})
    assert fmu.try_set({"spring.preload": 0.0, "tau": 5.0}) == OK
    fmu.step(1.0)
    assert fmu.get("tau") == 6.0


@for_forward
def test_rates_are_zero_unless_set_again(fmu):
    fmu.start(FREE)
    fmu.set_rates(tau=1.0, F_ext=1.0)
    fmu.step(1.0)
    fmu.set_rates(F_ext=1.0)
    fmu.step(1.0)
    assert (fmu.get("tau"), fmu.get("F_ext")) == (1.0, 2.0)


@for_forward
def test_rates_may_come_before_the_start(fmu):
    fmu.set(FREE)
    fmu.set_rates(tau=1.0)
    fmu.enter(STEP).step(1.0)
    assert fmu.get("tau") == 1.0


@pytest.mark.parametrize("order", [0, -1, 4, 2**31 - 1, -(2**31)])
def test_refuses_orders_of_inputs(fmu, order):
    arguments = fmu.model.references(["F_ext"]), 1, (c_int * 1)(order), to_c("Real", [1.0])
    fmu.refused("fmi2SetRealInputDerivatives", *arguments, mentions=("F_ext", str(order), "1 to 3"))


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_refuses_rates_that_are_not_finite(fmu, value):
    arguments = fmu.model.references(["F_ext"]), 1, (c_int * 1)(1), to_c("Real", [value])
    fmu.refused("fmi2SetRealInputDerivatives", *arguments, mentions=("F_ext",))


@pytest.mark.parametrize("name", ["z", "cam1.radius", "contacts", UNKNOWN_REFERENCE])
def test_refuses_rates_of_what_is_no_input(fmu, name):
    arguments = fmu.model.references([name]), 1, (c_int * 1)(1), to_c("Real", [1.0])
    fmu.refused("fmi2SetRealInputDerivatives", *arguments, mentions=(str(name),))


@for_forward
def test_rates_are_set_all_or_none(fmu):
    fmu.start(FREE)
    arguments = fmu.model.references(["tau", "F_ext"]), 2, (c_int * 2)(1, 4), to_c("Real", [1.0, 1.0])
    fmu.refused("fmi2SetRealInputDerivatives", *arguments)
    fmu.step(1.0)
    assert fmu.get("tau") == 0.0


@for_forward
def test_output_derivatives(fmu):
    fmu.start(SWING)
    fmu.step(0.07, tau=4.0)
    theta, omega = fmu.get("theta"), fmu.get("omega")
    stiffness = 50000.0 * LIFT**2
    alpha = (4.0 - LIFT * 20.0 - stiffness * theta) / INERTIA
    jerk = -stiffness * omega / INERTIA
    expected = {
        ("theta", 1): omega,
        ("theta", 2): alpha,
        ("omega", 1): alpha,
        ("omega", 2): jerk,
        ("z", 1): LIFT * omega,
        ("z", 2): LIFT * alpha,
        ("v", 1): LIFT * alpha,
        ("v", 2): LIFT * jerk,
    }
    actual = {key: fmu.output_derivative(*key) for key in expected}
    assert actual == pytest.approx(expected, rel=1e-12)
    assert fmu.get("alpha") == actual["theta", 2]


@for_forward
def test_output_derivatives_after_a_ramp(fmu):
    fmu.start(FREE)
    fmu.set_rates(tau=3.0)
    fmu.step(1.0)
    assert fmu.output_derivative("omega", 2) == pytest.approx(3.0 / INERTIA, rel=1e-14)
    fmu.step(1.0)
    assert fmu.output_derivative("omega", 2) == 0.0


@pytest.mark.parametrize("order", [0, -1, 3, 2**31 - 1])
@for_each(causality=["output"])
def test_refuses_orders_of_outputs(fmu, name, order):
    arguments = fmu.model.references([name]), 1, (c_int * 1)(order), to_c("Real", [0.0])
    fmu.refused("fmi2GetRealOutputDerivatives", *arguments, mentions=(name, str(order)))


@pytest.mark.parametrize("name", ["F_ext", "alpha", "cam1.radius", "contacts", UNKNOWN_REFERENCE])
def test_refuses_derivatives_of_what_is_no_output(fmu, name):
    arguments = fmu.model.references([name]), 1, (c_int * 1)(1), to_c("Real", [0.0])
    fmu.refused("fmi2GetRealOutputDerivatives", *arguments, mentions=(str(name),))


def test_derivatives_of_all_orders(fmu):
    """value[k] is the k-th derivative: F = 1 + 2 t + 3 t^2/2 + 4 t^3/6."""
    fmu.set({"F_ext": 1.0})
    fmu.start({"inertia.shaft": 0.0})
    fmu.set_derivatives({"F_ext": [2.0, 3.0, 4.0]})
    fmu.step(0.5)
    assert fmu.get("F_ext") == pytest.approx(1 + 2 * 0.5 + 3 * 0.25 / 2 + 4 * 0.125 / 6, rel=1e-15)
    after = fmu.get("F_ext")
    fmu.step(0.5)
    assert fmu.get("F_ext") == after
