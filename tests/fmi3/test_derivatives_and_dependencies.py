"""FMI 3.0: directional, adjoint and output derivatives, and dependencies."""

from ctypes import byref, c_double, c_int, c_size_t, c_uint

import driver as fmi2
import driver3
import numpy as np
import pytest
from driver3 import CONSTANT, DEPENDENT, FORWARD, INVERSE
from fmi3_scenes import FORCES, GENERAL, each_model

# ---- derivatives ----


MOVING = {
    FORWARD: {"initial.theta": 0.25, "initial.omega": 3.0, "tau": 4.0, **FORCES},
    INVERSE: {"theta": 0.25, "omega": 3.0, "alpha": 5.0, "F_ext": 2.0, **FORCES},
}
UNKNOWNS = {FORWARD: ["theta", "omega", "alpha", "z", "v"], INVERSE: ["tau", "z", "v"]}
KNOWNS = {
    FORWARD: ["tau", "F_ext", "theta", "omega", "cam1.friction", "spring.preload", "damper.c_load"],
    INVERSE: ["theta", "omega", "alpha", "F_ext", "cam2.friction", "spring.stiffness3"],
}


@each_model
def test_adjoint_is_the_transpose_of_directional(make_model, make3, model):
    fmu = make3(model).start(MOVING[model])
    old_model = fmi2.models[model.identifier]
    old = make_model(old_model).start(MOVING[model])
    rows, columns = UNKNOWNS[model], KNOWNS[model]
    unit = np.eye(len(columns))
    matrix = np.array([fmu.product("Directional", rows, columns, list(seed)) for seed in unit]).T
    assert np.count_nonzero(matrix) >= 8
    for seed, column in zip(unit, matrix.T, strict=True):
        found = (c_double * len(rows))()
        unknowns, knowns = old_model.references(rows), old_model.references(columns)
        arguments = (unknowns, len(rows), knowns, len(columns), driver3.reals(list(seed)), found)
        old.ok("fmi2GetDirectionalDerivative", *arguments)
        assert list(found) == list(column)
    transposed = [fmu.product("Adjoint", rows, columns, list(seed)) for seed in np.eye(len(rows))]
    assert np.array_equal(np.array(transposed), matrix)
    random = np.random.default_rng(1)
    for _ in range(5):
        left, right = random.normal(size=len(rows)), random.normal(size=len(columns))
        forward = left @ fmu.product("Directional", rows, columns, list(right))
        backward = right @ fmu.product("Adjoint", rows, columns, list(left))
        size = np.abs(left) @ np.abs(matrix) @ np.abs(right)
        assert forward == pytest.approx(backward, abs=1e-14 * size)


def test_output_derivatives_are_those_of_fmi2(make_model, make3):
    new, old = make3().start(GENERAL), make_model(fmi2.FORWARD).start(GENERAL)
    for one in (new, old):
        one.step(0.01, tau=4.0)
    for name in ("theta", "omega", "z", "v"):
        for order in (1, 2):
            assert new.output_derivative(name, order) == old.output_derivative(name, order) != 0.0


# ---- dependencies ----


@each_model
def test_dependencies_are_those_of_the_description_and_of_fmi2(make3, model):
    by_reference = {v.reference: name for name, v in model.variables.items()}
    kinds = {"constant": CONSTANT, "dependent": DEPENDENT}

    def listed(element: str) -> dict[str, dict[str, int]]:
        return {
            by_reference[int(u.attrib["valueReference"])]: {
                by_reference[int(known)]: kinds[kind]
                for known, kind in zip(
                    u.attrib["dependencies"].split(), u.attrib["dependenciesKind"].split(), strict=True
                )
            }
            for u in model.document.iter(element)
        }

    later = listed("Output") | listed("ContinuousStateDerivative") | listed("EventIndicator")
    first = listed("InitialUnknown")
    fmu = make3(model)
    assert {name: fmu.dependencies(name) for name in first} == first
    fmu.start()
    assert {name: fmu.dependencies(name) for name in later} == later
    old = fmi2.models[model.identifier]
    by_index = old.by_index
    structure = old.document.find("ModelStructure")
    for kind, mine in (("Outputs", later), ("Derivatives", later), ("InitialUnknowns", first)):
        for unknown in structure.find(kind) or ():
            names = {by_index[int(i)] for i in unknown.attrib["dependencies"].split()}
            assert set(mine[by_index[int(unknown.attrib["index"])]]) == names
    fmu.refused("GetNumberOfVariableDependencies", fmu.variables["mode"].reference, byref(c_size_t()))
    fmu.refused("GetNumberOfVariableDependencies", 10**6, byref(c_size_t()))
    fmu.refused("GetNumberOfVariableDependencies", fmu.variables["z"].reference, None, mentions=("NULL",))
    n, sizes, references = 1000, (c_size_t * 1000)(), (c_uint * 1000)()
    kinds_found = (c_int * 1000)()
    arguments = [fmu.variables["z"].reference, sizes, references, sizes, kinds_found, n]
    fmu.refused("GetVariableDependencies", *arguments, mentions=("nDependencies",))
    arguments[-1] = len(later["z"])
    for k in (1, 2, 3, 4):
        fmu.refused("GetVariableDependencies", *arguments[:k], None, *arguments[k + 1 :], mentions=("NULL",))
