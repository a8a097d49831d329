"""FMI 2.0: tunable parameters between steps."""

import pytest
from fmi2_inputs import drive, for_each


@for_each(variability=["tunable"])
def test_tunable_parameters_in_step_mode(fmu, name):
    fmu.start().step(0.01, **drive(fmu, 1.0))
    v = fmu.variables[name]
    value = v.start + (0.0625 if v.max > v.start else 0.0) if v.type == "Real" else int(v.min)
    fmu.set({name: value})
    assert fmu.get(name) == value
    fmu.step(0.01)


def test_tuning_acts_at_once(fmu):
    fmu.start()
    before = fmu.get("torque_load")
    fmu.set({"spring.preload": 2 * fmu.get("spring.preload")})
    assert fmu.get("torque_load") == pytest.approx(2 * before, rel=1e-14)
