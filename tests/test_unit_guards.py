"""Warnings for values that look as if they were in another unit."""

import math
import warnings
from contextlib import suppress

import numpy as np
import pytest
from driver import ROOT

from dualcam import Fmu
from dualcam.common.unit_guards import RULES, table_warnings, unit_warnings
from dualcam.design import (
    Cycloid,
    Ellipse,
    Helix,
    Limits,
    Mechanism,
    Pin,
    Spring,
    Table,
    design_groove,
    propose_spring,
    synthesize,
)
from dualcam.design_file import TEMPLATES, read_design, write_template
from dualcam.errors import DesignError, UnitWarning
from dualcam.fmi.variables import all_parameters
from dualcam.systems.machines import car_door, elbow, knee

HELIX, SPRING = Helix(0.02, 0.7), Spring(50.0, 50e3)


def test_warnings_name_the_likely_unit_and_the_converted_value():
    strange = {
        "cam1.radius": 18,
        "cam2.ellipse_a": 50,
        "cam1.cycloid_rise": 25,
        "cam2.cycloid_angle": 80,
        "cam1.lead_angle": 45,
        "cam2.friction": 14,
        "cam1.stribeck_velocity": 5,
        "spring.stiffness": 32,
        "stop.upper": 75,
        "stop.lower": -20.0,
        "initial.theta": np.float64(30),
        "inertia.follower_mass": 300,
        "inertia.shaft": 2e3,
    }
    assert unit_warnings(strange) == [
        "cam1.radius = 18 m: this looks like millimetres; 18 mm is 0.018 m",
        "cam2.ellipse_a = 50 m: this looks like millimetres; 50 mm is 0.05 m",
        "cam1.cycloid_rise = 25 m: this looks like millimetres; 25 mm is 0.025 m",
        "cam2.cycloid_angle = 80 rad: this looks like degrees; 80 deg is 1.39626 rad",
        "cam1.lead_angle = 45 rad: this looks like degrees; 45 deg is 0.785398 rad",
        "cam2.friction = 14: this looks like percent or an angle; 14 % is 0.14",
        "cam1.stribeck_velocity = 5 m/s: this looks like mm/s; 5 mm/s is 0.005 m/s",
        "spring.stiffness = 32 N/m: this looks like N/mm; 32 N/mm is 32000 N/m",
        "stop.upper = 75 rad: this looks like degrees; 75 deg is 1.309 rad",
        "stop.lower = -20 rad: this looks like degrees; -20 deg is -0.349066 rad",
        "initial.theta = 30 rad: this looks like degrees; 30 deg is 0.523599 rad",
        "inertia.follower_mass = 300 kg: this looks like grams; 300 g is 0.3 kg",
        "inertia.shaft = 2000 kg.m2: this looks like kg.cm2 or kg.mm2; 2000 kg.cm2 is 0.2 kg.m2",
    ]


def test_what_can_be_meant_gets_no_warning():
    assert unit_warnings({name: variable.start for name, variable in all_parameters().items()}) == []
    assert unit_warnings({"spring.stiffness": 0.0, "stop.upper": 6.28, "cam1.friction": 1.0}) == []
    assert unit_warnings({"cam1.radius": math.nan, "cam2.radius": "18", "ledger": True, "unknown": 1e9}) == []


def test_rules_are_for_names_that_exist():
    known = {name.replace("cam1.", "cam.") for name in all_parameters()}
    others = (
        "pin.",
        "roller.",
        "helical_spring.",
        "limits.",
        "table.",
        "scenario.",
        "spring.free_length",
        "spring.solid_length",
    )
    assert {name for name in RULES if not name.startswith(others)} <= known


def caught(make):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        make()
    assert all(one.filename == __file__ for one in found), "the warning points at the user's line"
    return [str(one.message) for one in found if one.category is UnitWarning]


TABLE = np.linspace(0.0, 80.0, 9)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Helix(18, 0.7), ["radius = 18 m: this looks like millimetres"]),
        (lambda: Ellipse(0.02, 0.7, 50, 60), ["a = 50 m: this", "b = 60 m: this"]),
        (lambda: Cycloid(0.02, 20, 80), ["rise = 20 m: this", "angle = 80 rad: this"]),
        (lambda: Table(0.02, TABLE, 0.2 * TABLE), ["psi = 80 rad: this looks like deg", "z = 16 m: this"]),
        (lambda: Spring(50, 32), ["stiffness = 32 N/m: this looks like N/mm"]),
        (lambda: Mechanism((HELIX, HELIX), (14, 0.1), SPRING, 75), ["upper = 75 rad", "friction[0] = 14"]),
        (lambda: Pin(3, 8), ["radius = 3 m", "width = 8 m"]),
        (lambda: Pin(0.003, 0.008, modulus=210.0), ["modulus = 210 Pa: this looks like GPa"]),
        (lambda: Pin(0.003, 0.008, cam_modulus=210e3), ["cam_modulus = 210000 Pa: this looks like MPa"]),
        (lambda: Limits(pressure=1500), ["pressure = 1500 Pa: this looks like MPa"]),
    ],
)
def test_classes_warn(make, words):
    found = caught(make)
    assert len(found) == len(words) and all(word in text for word, text in zip(words, found, strict=True)), (
        found
    )


def caught_anywhere(make):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        with suppress(DesignError):
            make()
    return [str(one.message) for one in found if one.category is UnitWarning]


FORCE = Spring(400.0, 10e3)
DEGREES = np.linspace(0.0, 80.0, 9), np.full(9, 5.0)
SAMPLES = "torque: theta = 80 rad: this looks like degrees; 80 deg is 1.39626 rad"


@pytest.mark.parametrize(
    "make", [lambda: synthesize(DEGREES, 1.2, FORCE), lambda: propose_spring(DEGREES, 1.2, FORCE)]
)
def test_samples_of_a_torque_in_degrees_warn(make):
    assert caught(make) == [SAMPLES]


def test_samples_and_range_in_degrees_warn():
    found = caught_anywhere(lambda: synthesize(DEGREES, 80.0, FORCE))
    assert [text.partition(":")[0] for text in found] == ["upper = 80 rad", "torque"]


def test_a_file_of_a_torque_warns_once(tmp_path):
    path = tmp_path / "torque.csv"
    rows = [f"{theta / 10.0},5" for theta in range(0, 90, 10)]
    path.write_text("\n".join(["theta_rad,torque_Nm", *rows]))
    (text,) = caught_anywhere(lambda: design_groove(path, Spring(50.0, 10e3)))
    assert "torque.csv" in text and "looks like degrees" in text


def test_refused_angles_name_degrees():
    with pytest.raises(DesignError, match=r"this looks like degrees; 45 deg is 0\.785398 rad"):
        Helix(0.02, 45)
    with pytest.raises(DesignError, match=r"this looks like degrees; 80 deg is 1\.39626 rad"):
        Limits(lead_angle=(5, 80))


def test_lead_angle_of_a_table():
    psi = np.linspace(0.0, 1.4, 15)
    assert table_warnings(psi, 0.02 * psi, 0.02) == []
    (text,) = table_warnings(psi, 0.5 * psi, 0.02)
    assert "lead angle of the table reaches 87.71 deg on the radius 0.02 m: z looks like millimetres" in text


# ---- legal designs of this repository ----


def test_designs_of_the_systems_get_no_warning(tmp_path):
    plants = (
        elbow.plant_parameters(elbow.design_cam(), elbow.DESIGN_PAYLOAD),
        knee.plant_parameters(knee.design_cam().parameters(), knee.DESIGN_WALKER),
        car_door.plant_parameters(car_door.design()),
    )
    for plant in plants:
        assert unit_warnings(plant) == []
    for name in TEMPLATES:
        assert read_design(write_template(name, tmp_path / f"{name}.toml")).warnings == ()


def test_studies_get_no_warning():
    from dualcam.study.file.study_file import read_study

    plans = sorted((ROOT / "system_examples" / "study").glob("*.toml"))
    assert plans
    for path in plans:
        study = read_study(path)
        ends = [value for pair in study.plan.limits().values() for value in pair]
        names = [name for name in study.plan.limits() for _ in range(2)]
        assert unit_warnings(study.parameters) == []
        assert [
            text for name, end in zip(names, ends, strict=True) for text in unit_warnings({name: end})
        ] == []


@pytest.mark.parametrize("fmi", [2, 3])
def test_a_start_of_the_fmu_warns(fmi):
    def start():
        with Fmu("forward", fmi=fmi) as fmu:
            fmu.start({"cam1.radius": 18, "stop.upper": 75.0, "spring.stiffness": 32.0})

    found = caught(start)
    assert [text.partition(":")[0] for text in found] == [
        "cam1.radius = 18 m",
        "stop.upper = 75 rad",
        "spring.stiffness = 32 N/m",
    ]
