"""FMI 2.0: tunable parameters between steps."""

import math

import pytest
from driver import VALUE
from fmi2_inputs import drive, for_each


@for_each(variability=["tunable"], causality=["parameter"])
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


BEHIND = {"Real": math.nan, "Integer": 99}  # no allowed value


@pytest.mark.parametrize("kind", BEHIND)
def test_an_array_of_tunables_is_read_to_its_end_and_no_further(fmu, kind):
    """In a run, where the new values are tried before they are taken."""
    *taken, behind = fmu.model.names(type=[kind], variability=["tunable"], causality=["parameter"])[:4]
    fmu.start()
    kept = fmu.get(behind)
    other = {name: 1 if kind == "Integer" else 1.5 * fmu.get(name) for name in taken}
    values = (VALUE[kind] * (len(taken) + 1))(*other.values(), BEHIND[kind])
    fmu.ok(f"Set{kind}", fmu.model.references([*taken, behind]), len(taken), values)
    assert {name: fmu.get(name) for name in taken} == other
    assert fmu.get(behind) == kept
