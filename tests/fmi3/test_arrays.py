"""FMI 3.0: arrays of values and of seeds, of all types, in one call and not one element further."""

import ctypes
import math
from ctypes import c_bool, c_double

import driver as fmi2
import pytest
from driver import OK
from driver3 import FORWARD, INVERSE, VALUE
from fmi3_scenes import FORCES, each_model

GUARD = 77.0  # behind the end of an array


def other_value(variable, k):
    """An allowed value that is not the start value, another one for each variable."""
    if variable.type == "Boolean":
        return not variable.start
    if variable.type == "String":
        return f"table{k}.csv"
    if variable.type == "Int32":
        return int(variable.max if variable.start != variable.max else variable.min)
    value = variable.start * (1.0 + 1e-3 * (k + 1)) + (0.0 if variable.start else 1e-4 * (k + 1))
    return min(max(value, variable.min), variable.max)


@each_model
@pytest.mark.parametrize("kind", VALUE)
def test_values_of_one_type_are_set_and_read_in_one_call(make3, model, kind):
    fmu, settable = make3(model), model.names(type=[kind], causality=["parameter", "input"])
    wanted = {name: other_value(model.variables[name], k) for k, name in enumerate(settable)}
    assert all(value != model.variables[name].start for name, value in wanted.items())
    assert fmu.try_set(wanted) == OK
    assert {name: fmu.get(name) for name in wanted} == wanted  # one by one
    status, read = fmu.try_get(list(wanted))
    assert status == OK
    assert [v.decode() if isinstance(v, bytes) else v for v in read] == list(wanted.values())  # in one call


@each_model
def test_a_boolean_is_one_byte_and_the_last_of_several_counts(make3, model):
    fmu, references = make3(model), model.references(["ledger"] * 3)
    for given in ((True, False, True), (False, True, False)):
        fmu.ok("SetBoolean", references, 3, (c_bool * 3)(*given), 3)
        read = (ctypes.c_uint8 * 4)(9, 9, 9, 9)
        fmu.ok("GetBoolean", references, 3, ctypes.cast(read, ctypes.POINTER(c_bool)), 3)
        assert list(read) == [given[-1]] * 3 + [9]


@each_model
def test_a_ledger_that_is_switched_off_keeps_no_accounts(make3, model):
    inputs = {FORWARD: {"tau": 6.0}, INVERSE: {"theta": 0.1, "omega": 1.0}}[model]
    end = {FORWARD: {}, INVERSE: {"theta": 0.15}}[model]
    kept = {}
    for ledger in (True, False):
        fmu = make3(model).start({"ledger": ledger, **inputs})
        fmu.step(0.05, **end)
        fmu.step(0.05, **end)
        kept[ledger] = fmu.get("energy.heat_cam1")
    assert kept[True] > 0.0
    assert kept[False] == 0.0


MOVING = {
    FORWARD: {"initial.theta": 0.25, "initial.omega": 3.0, "tau": 4.0, **FORCES},
    INVERSE: {"theta": 0.25, "omega": 3.0, "alpha": 5.0, "F_ext": 2.0, **FORCES},
}
UNKNOWNS = {FORWARD: ["alpha", "v", "omega"], INVERSE: ["tau", "v"]}
KNOWNS = {FORWARD: ["tau", "cam1.friction", "spring.stiffness"], INVERSE: ["theta", "cam2.friction", "F_ext"]}


def guarded(values):
    """An array whose next element is no number: a sum that reads the element is none, either."""
    return (c_double * (len(values) + 1))(*values, math.nan)


@each_model
@pytest.mark.parametrize("kind", ["Directional", "Adjoint"])
def test_derivatives_read_and_write_no_element_too_many(make3, model, kind):
    fmu, rows, columns = make3(model).start(MOVING[model]), UNKNOWNS[model], KNOWNS[model]
    seeds, found = (columns, rows) if kind == "Directional" else (rows, columns)
    seed = [1.0 + k for k in range(len(seeds))]
    # A known or an unknown too many would change the sums as well.
    more = [model.references([*names, "F_ext" if names is columns else "z"]) for names in (rows, columns)]
    out = (c_double * (len(found) + 1))(*[GUARD] * (len(found) + 1))
    fmu.ok(
        f"Get{kind}Derivative",
        *(more[0], len(rows), more[1], len(columns)),
        *(guarded(seed), len(seed), out, len(found)),
    )
    matrix = [fmu.product("Directional", [row], [column], [1.0])[0] for row in rows for column in columns]
    entry = {pair: matrix[k] for k, pair in enumerate((row, column) for row in rows for column in columns)}
    for name, value in zip(found, out, strict=False):
        pairs = [(name, s) if kind == "Directional" else (s, name) for s in seeds]
        terms = [entry[pair] * s for pair, s in zip(pairs, seed, strict=True)]
        assert value == pytest.approx(math.fsum(terms), abs=1e-14 * sum(map(abs, terms)))
    assert out[len(found)] == GUARD


@pytest.mark.parametrize("model", fmi2.models.values(), ids=repr)
def test_derivatives_of_fmi2_read_and_write_no_element_too_many(make_model, model):
    three = {FORWARD.identifier: FORWARD, INVERSE.identifier: INVERSE}[model.identifier]
    fmu, rows, columns = make_model(model).start(MOVING[three]), UNKNOWNS[three], KNOWNS[three]
    seed, out = guarded([1.0, 2.0, 3.0]), (c_double * (len(rows) + 1))(*[GUARD] * (len(rows) + 1))
    unknowns, knowns = model.references([*rows, "z"]), model.references([*columns, "F_ext"])
    fmu.ok("GetDirectionalDerivative", unknowns, len(rows), knowns, len(columns), seed, out)
    assert all(math.isfinite(value) and value != GUARD for value in out[:-1])
    assert out[len(rows)] == GUARD
