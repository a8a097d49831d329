"""FMI 2.0: values that a variable takes or refuses."""

import math
from ctypes import c_char_p

import pytest
from fmi2_inputs import SETTABLE, for_each


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@for_each(causality=SETTABLE, type=["Real"])
def test_refuses_what_is_not_finite(fmu, name, value):
    fmu.refused_set({name: value}, mentions=(name, "nan" if value != value else "inf"))


@for_each(lambda v: math.isfinite(v.min), causality=["parameter"], type=["Real"])
def test_refuses_below_min(fmu, name):
    v = fmu.variables[name]
    fmu.set({name: v.min})
    assert fmu.get(name) == v.min
    fmu.refused_set({name: math.nextafter(v.min, -math.inf)}, mentions=(name,))
    fmu.refused_set({name: v.min - 1.25}, mentions=(f"{v.min - 1.25!r}"[:5],))


@for_each(lambda v: math.isfinite(v.max), causality=["parameter"], type=["Real"])
def test_refuses_above_max(fmu, name):
    v = fmu.variables[name]
    fmu.set({name: v.max})
    assert fmu.get(name) == v.max
    fmu.refused_set({name: math.nextafter(v.max, math.inf)}, mentions=(name,))


@for_each(causality=["parameter"], type=["Integer"])
def test_refuses_integers_outside(fmu, name):
    v = fmu.variables[name]
    for value in (v.min, v.max):
        fmu.set({name: int(value)})
        assert fmu.get(name) == value
    for value in (v.min - 1, v.max + 1, 2**31 - 1, -(2**31)):
        fmu.refused_set({name: int(value)}, mentions=(name, str(int(value))))


@pytest.mark.parametrize("cam", ["cam1", "cam2"])
def test_curvature_is_a_sign(fmu, cam):
    fmu.refused_set({f"{cam}.ellipse_curvature": 0}, mentions=("-1 or +1",))


TEXTS = ["groove.csv", " ", "/a/b c.csv", "Größe %s%n", "x" * 1023]


@for_each(type=["String"])
def test_tables_are_any_text(fmu, name):
    """A helix does not read a groove table. A friction table is read at the start."""
    for value in (*TEXTS, ""):
        fmu.set({name: value})
        assert fmu.get(name) == value
    fmu.set({name: TEXTS[-1] if name.endswith(".table") else ""})
    fmu.start()


@for_each(type=["String"])
@pytest.mark.parametrize("value", ["x" * 1024, "x" * 100_000, "ü" * 512])
def test_refuses_long_tables(fmu, name, value):
    fmu.refused_set({name: value}, mentions=(name, '""', "1023"))


@for_each(type=["String"])
def test_an_old_text_leaves_no_trace(make, name):
    fmu, new = make(), make()
    fmu.set({name: "x" * 1000})
    for driver in (fmu, new):
        driver.set({name: "short"})
    assert fmu.state_bytes() == new.state_bytes()


@for_each(type=["String"])
def test_refuses_null_string(fmu, name):
    fmu.refused("fmi2SetString", fmu.model.references([name]), 1, (c_char_p * 1)(None), mentions=(name,))


@pytest.mark.parametrize("value", [1, -1, 2, -(2**31)])
def test_any_nonzero_boolean_is_true(fmu, value):
    fmu.set({"ledger": False})
    fmu.set({"ledger": value})
    assert fmu.get("ledger") is True
    fmu.set({"ledger": 0})
    assert fmu.get("ledger") is False
