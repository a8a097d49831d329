"""The FMU itself warns of parameters that look as if they were in another unit, whatever master sets them."""

import subprocess
import sys

import pytest
from driver import ROOT
from fmpy import simulate_fmu

from dualcam import fmu_path
from dualcam.common.unit_guards import unit_warning

WARNING, CATEGORY = 1, b"logStatusWarning"  # fmi2Warning and fmi3Warning


def played(model, fmi, start, **options):
    """Messages as (status, category, text) of 10 ms by FMPy."""
    said = []

    def logger(*message):
        said.append(message[-3:])

    fmu = str(fmu_path(model, fmi))
    simulate_fmu(fmu, stop_time=0.01, step_size=1e-3, start_values=start, logger=logger, **options)
    return said


@pytest.mark.parametrize("interface", ["CoSimulation", "ModelExchange"])
@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize("model", ["forward", "inverse"])
def test_a_stop_in_degrees_and_a_radius_in_millimetres_are_named(model, fmi, interface):
    said = played(model, fmi, {"stop.upper": 70.0, "cam1.radius": 18.0}, fmi_type=interface)
    assert said == [
        (WARNING, CATEGORY, text)
        for text in (
            b"cam1.radius = 18 m: this looks like millimetres; 18 mm is 0.018 m",
            b"stop.upper = 70 rad: this looks like degrees; 70 deg is 1.2217304763960306 rad",
        )
    ]


@pytest.mark.parametrize("fmi", [2, 3])
@pytest.mark.parametrize(
    "name, value, text",
    [
        ("cam1.friction", 5.0, "cam1.friction = 5: this looks like percent or an angle; 5 % is 0.05"),
        ("spring.stiffness", 32.0, "spring.stiffness = 32 N/m: this looks like N/mm; 32 N/mm is 32000 N/m"),
        (
            "inertia.follower_mass",
            300.0,
            "inertia.follower_mass = 300 kg: this looks like grams; 300 g is 0.3 kg",
        ),
        (
            "cam2.stribeck_velocity",
            5.0,
            "cam2.stribeck_velocity = 5 m/s: this looks like mm/s; 5 mm/s is 0.005 m/s",
        ),
        ("stop.upper", 6.28, None),
        ("cam1.radius", 1.0, None),
        ("spring.stiffness", 0.0, None),
    ],
)
def test_the_fmu_says_what_python_says(fmi, name, value, text):
    said = [message.decode() for _, _, message in played("inverse", fmi, {name: value})]
    assert [message.replace("%%", "%") for message in said] == ([] if text is None else [text])
    assert unit_warning(name, value) == text


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_default_mechanism_has_no_warning(fmi):
    assert played("forward", fmi, {}) == played("inverse", fmi, {}) == []


def test_both_tables_are_one():
    command = [sys.executable, str(ROOT / "fmu_src/tools/make_unit_guards.py"), "--check"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
