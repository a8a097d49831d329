"""Slip that slows down into speeds at which friction changes steeply: helices, against the reference
simulator (reference/simulation.py)."""

import pytest
from driver import models
from reference import STICK, Interval, simulate
from test_friction_table import write

FORWARD = models["DualCamForward"]
ACCOUNTS = ("work_in", "kinetic", "spring", "heat_cam1", "heat_cam2")


def both(**values: tuple[float, float]) -> dict[str, float]:
    """Parameters of the two cams."""
    return {f"cam{i}.{name}": pair[i - 1] for name, pair in values.items() for i in (1, 2)}


SCENES = {
    "a fall over 0.6 mm/s": (
        both(
            lead_angle=(0.94, 0.73),
            friction=(0.18, 0.12),
            friction_peak=(2.3, 2.3),
            stribeck_velocity=(6e-4, 5e-4),
            stribeck_exponent=(2, 2),
            friction_viscous=(0.1, 0.1),
        )
        | {
            "inertia.shaft": 1e-3,
            "shaft.damping": 5e-3,
            "spring.stiffness": 35e3,
            "initial.theta": 0.25,
            "initial.omega": -0.29,
        },
        Interval(0.003, 4.6),
        3,
        1e-8,
    ),
    # Delta of the friction coefficients passes zero at 0.024 rad/s. Both reactions change with the load and
    # stay finite: this is no jam
    "Delta passes zero": (
        both(
            lead_angle=(0.955, 0.798),
            friction=(0.1095, 0.1836),
            friction_peak=(1.745, 2.168),
            stribeck_velocity=(1.78e-3, 0.01204),
            stribeck_exponent=(1, 2),
            friction_viscous=(0.1, 0.1),
            friction_load_exponent=(-0.271, -0.287),
            friction_load=(59382.0, 1715.0),
        )
        | {
            "inertia.shaft": 1.105e-5,
            "inertia.follower_mass": 1.0,
            "spring.stiffness": 667.5,
            "initial.theta": 0.43375,
            "initial.omega": 0.0366,
        },
        Interval(2.698e-4, 5.957),
        17,
        1e-3,
    ),
    # the tangent Delta passes zero too, at 0.525 rad/s; the inertia stays above zero
    "the tangent Delta passes zero": (
        both(
            lead_angle=(0.9335, 0.7032),
            friction=(0.1788, 0.1864),
            friction_peak=(2.926, 2.402),
            stribeck_velocity=(0.01693, 0.05243),
            stribeck_exponent=(2, 2),
            friction_viscous=(0.0, 0.1),
            friction_load_exponent=(-0.2567, -0.1706),
            friction_load=(36702.0, 316.6),
        )
        | {
            "inertia.shaft": 3.383e-4,
            "inertia.follower_mass": 1.0,
            "spring.stiffness": 6627.0,
            "initial.theta": 0.73533,
            "initial.omega": 6.0719,
        },
        Interval(0.027188, 0.69054),
        7,
        1e-6,
    ),
    "samples of a table": (
        both(lead_angle=(0.95, 0.6))
        | {
            "inertia.shaft": 3e-4,
            "shaft.damping": 5e-3,
            "inertia.follower_mass": 1.0,
            "initial.theta": 0.143,
            "initial.omega": -0.48,
        },
        Interval(0.026, 2.06),
        13,
        1e-8,
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_slip_that_slows_down(make_model, tmp_path, name):
    values, interval, pieces, tolerance = SCENES[name]
    if "table" in name:
        low = write(tmp_path / "low.csv", [0.0, 0.01, 0.03, 0.06], [0.15, 0.1, 0.2, 0.12])
        values = values | {"cam1.friction_table": low, "cam2.friction_table": low}
    (wanted,) = simulate(values, [interval])
    fmu = make_model(FORWARD).start(values, tolerance=tolerance)
    for _ in range(pieces):
        fmu.step(interval.duration / pieces, tau=interval.tau, F_ext=interval.F_ext)
    assert not wanted.doubts
    assert fmu.get("mode") == wanted.mode
    start, speed = values["initial.theta"], abs(values["initial.omega"])
    assert abs(fmu.get("theta") - wanted.theta) <= 10 * tolerance * abs(wanted.theta - start)
    assert abs(fmu.get("omega") - wanted.omega) <= 10 * tolerance * max(abs(wanted.omega), speed)
    energy = max(abs(wanted.value(f"energy.{account}")) for account in ACCOUNTS)
    for account in ACCOUNTS:
        found = fmu.get(f"energy.{account}")
        assert abs(found - wanted.value(f"energy.{account}")) <= 10 * tolerance * energy, account
    assert abs(fmu.get("energy.residual")) <= 10 * tolerance * energy


def test_the_energy_closes_below_the_load_at_which_friction_levels_off(make_model):
    """F_ext takes nearly all of the spring's load: the reactions fall below a hundredth of friction_load."""
    values = both(
        lead_angle=(0.943, 0.925),
        friction=(0.17, 0.11),
        friction_peak=(2.51, 1.27),
        stribeck_velocity=(0.0847, 5.99e-3),
        stribeck_exponent=(1, 2),
        friction_viscous=(0.1, 0.1),
        friction_load_exponent=(-0.288, -0.255),
        friction_load=(22.5e3, 190.0),
    ) | {
        "inertia.shaft": 6.21e-4,
        "inertia.follower_mass": 1.0,
        "spring.stiffness": 492.0,
        "initial.theta": 0.27,
        "initial.omega": 0.26,
    }
    tolerance = 1e-3
    fmu = make_model(FORWARD).start(values, tolerance=tolerance)
    fmu.step(0.02, tau=3.24, F_ext=-40.0)
    heat = fmu.get("energy.heat_cam1")
    assert fmu.get("mode") == STICK
    assert heat > 0.0
    assert abs(fmu.get("energy.residual")) <= 10 * tolerance * heat
