"""Grooves and parameters that cannot work are refused at the start, with a reason."""

import math

import numpy as np
import pytest
from pin_equations import ELLIPSE, TABLE, ellipse, write_table


def start_refused(fmu, values, *words):
    """fmi2ExitInitializationMode fails with one message that holds all of these; a reset brings it back."""
    text = fmu.refused_start(values)
    assert fmu.messages[-1].category == "logStatusError"
    for word in (*words, "must"):
        assert word in text, text
    assert text == text.strip() and len(text) < 700 and "%" not in text
    fmu.ok("fmi2Reset")
    fmu.start({"tau": 5.0})
    fmu.step(1e-3)
    return text


def number_after(text, label):
    """`label = 1.25`, wherever it is in the text."""
    return float(text.split(f"{label} = ")[1].split()[0].rstrip(":;,"))


@pytest.mark.parametrize("cam", [1, 2])
@pytest.mark.parametrize("kappa", [-1, 1])
def test_ellipse_left_before_a_stop(fmu, cam, kappa):
    """S reaches 0 (flattening) or 1 (steepening) at psi = -kappa S0 a/r or (1 - S0) a/r, upwards; and
    downwards the other one. The message names the cam and the stop."""
    lead, a, b, r = 0.7, 0.03, 0.03, 0.02
    S0 = math.sin(math.atan(a / b * math.tan(lead)))
    values = {
        f"cam{cam}.{n}": v
        for n, v in (("profile", ELLIPSE), ("lead_angle", lead), ("ellipse_a", a), ("ellipse_b", b))
    }
    values[f"cam{cam}.ellipse_curvature"] = kappa
    groove = ellipse(r, lead, a, b, kappa)
    up = (1 - S0 if kappa > 0 else S0) * a / r
    down = (S0 if kappa > 0 else 1 - S0) * a / r
    other = 0.02  # slope of the helix, m/rad
    # theta = psi + z(psi)/other, whichever cam is the ellipse
    upper, lower = (x + groove.z(x * (1 - 1e-15)) / other for x in (up, -down))
    for stop, reach, room in (("stop.upper", upper, 0.02), ("stop.lower", lower, -0.02)):
        near = {"stop.upper": 0.5 * upper} | {stop: reach + room}
        text = start_refused(fmu, values | near, f"cam{cam}", "ellips", stop)
        assert number_after(text, "psi") == pytest.approx(up if room > 0 else -down, abs=1e-8)
        # where it is vertical the FMU does without the last 1e-10 of S, which is 1e-5 of sqrt(1 - S^2)
        assert number_after(text, "theta") == pytest.approx(reach, abs=1e-4)
        fmu.ok("fmi2Reset")
        fmu.start(values | near | {stop: reach - 0.2 * room})
        fmu.ok("fmi2Reset")


def test_a_jam_at_the_lower_stop_is_named_there(fmu):
    """kappa_1 + kappa_2 <= 0 from tan(lambda) = 1/mu on, which here is below the lead angle at psi = 0."""
    lead = math.atan(1.0 / 0.9) + 0.05
    cam = {"profile": ELLIPSE, "lead_angle": lead, "ellipse_a": 0.1, "ellipse_b": 0.1, "friction": 0.9}
    values = {f"cam{i}.{n}": v for i in (1, 2) for n, v in cam.items()} | {"stop.upper": 0.1}
    text = start_refused(fmu, values, "jam when loading", "cam1.friction = 0.9")
    assert number_after(text, "theta") == 0.0


GOOD = "psi_rad,z_m\n0,0\n0.5,0.01\n1,0.02\n1.5,0.03\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (GOOD.replace("1,0.02", "0.5,0.02"), ("line 4", "psi_rad = 0.5")),
        (GOOD.replace("1,0.02", "1,0.005"), ("line 4", "z_m = 0.005")),
        (GOOD.replace("1.5,0.03\n", ""), ("3 points",)),
        (GOOD.replace("0.01", "nan"), ("line 3", "nan")),
        (GOOD.replace("0.01", "inf"), ("line 3", "inf")),
        (GOOD.replace("psi_rad,z_m", "angle,height"), ("line 1", "angle,height", "psi_rad,z_m")),
        (GOOD.replace("1,0.02", "1;0.02"), ("line 4", "1;0.02")),
        ("", ("psi_rad,z_m",)),
        (None, ("cannot be opened",)),
    ],
)
@pytest.mark.parametrize("cam", [1, 2])
def test_bad_table_at_the_start(fmu, tmp_path, cam, text, words):
    path = tmp_path / "groove.csv"
    if text is not None:
        path.write_text(text)
    values = {f"cam{cam}.profile": TABLE, f"cam{cam}.table": str(path)}
    start_refused(fmu, values, f"cam{cam}.table", str(path), *words)
    path.write_text(GOOD)
    fmu.ok("fmi2Reset")
    fmu.start(values)


@pytest.mark.parametrize("cam", [1, 2])
def test_table_left_before_a_stop(fmu, tmp_path, cam):
    """It ends at psi = 1 and begins at -0.5, with slope 0.02 m/rad as the helix beside it: theta from -1 to
    2."""
    path = tmp_path / "groove.csv"
    write_table(path, np.linspace(-0.5, 1.0, 16), 0.02 * np.linspace(-0.5, 1.0, 16))
    values = {f"cam{cam}.profile": TABLE, f"cam{cam}.table": str(path)}
    start_refused(fmu, values | {"stop.upper": 2.1}, f"cam{cam}", "stop.upper", "2.1")
    fmu.ok("fmi2Reset")
    start_refused(fmu, values | {"stop.lower": -1.1}, f"cam{cam}", "stop.lower", "-1.1")
    fmu.ok("fmi2Reset")
    fmu.start(values | {"stop.lower": -0.99, "stop.upper": 1.99})


def test_jam_inside_the_stop_range(fmu):
    """Two equal steepening ellipses: gamma = phi = theta/2, and kappa_1 + kappa_2 = 0 where both lead angles
    reach pi/2 - atan mu, tan = 1/mu, S = 1/sqrt(1 + (b mu/a)^2)."""
    mu, a, b, r, lead = 0.3, 0.05, 0.05, 0.02, 0.9
    S0, S1 = math.sin(math.atan(a / b * math.tan(lead))), 1 / math.hypot(1.0, b / a * mu)
    jam = 2 * (S1 - S0) * a / r
    values = {f"cam{i}.{n}": v for i in (1, 2) for n, v in ellipse(r, lead, a, b, 1).parameters.items()}
    values |= {"cam1.friction": mu, "cam2.friction": mu}
    text = start_refused(fmu, values | {"stop.upper": jam + 0.01}, "jam", "cam1", "cam2", "stop.upper")
    assert jam <= number_after(text, "theta") <= jam + 0.01  # a place at which they do jam
    fmu.ok("fmi2Reset")
    fmu.start(values | {"stop.upper": jam - 1e-6})
    assert fmu.get("torque_load") < math.inf
    # and tuning the friction up to a jam is refused, with nothing changed
    text = fmu.refused_set({"cam1.friction": 0.31}, mentions=("jam",))
    assert number_after(text, "theta") < jam
    fmu.step(1e-3, tau=1.0)


def test_samples_reach_a_stop_but_for_rounding(fmu, tmp_path):
    """Both cams turn by the same angle, so that samples up to psi = 1 reach theta = 2 rad."""
    path = tmp_path / "straight.csv"
    psi = np.linspace(-0.25, 1.0, 6)
    write_table(path, psi, 0.02 * psi)
    values = {f"cam{i}.{n}": v for i in (1, 2) for n, v in (("profile", TABLE), ("table", str(path)))}
    fmu.start(values | {"stop.upper": 2.0 + 2e-12})
    fmu.ok("fmi2Reset")
    start_refused(fmu, values | {"stop.upper": 2.0 + 4e-12}, "the samples must reach as far as the stops")


def test_pin_that_nothing_fixes(fmu, tmp_path):
    """Both slopes zero: at psi = 0 of two tables that begin flat; both helices level."""
    path = tmp_path / "flat.csv"
    psi = np.linspace(0.0, 2.0, 21)
    write_table(path, psi, 0.02 * np.maximum(psi - 0.3, 0.0))
    values = {f"cam{i}.{n}": v for i in (1, 2) for n, v in (("profile", TABLE), ("table", str(path)))}
    start_refused(fmu, values, "cam1", "cam2", "theta")
    fmu.ok("fmi2Reset")
    write_table(path, psi, 0.02 * (np.minimum(psi, 0.5) + np.maximum(psi - 0.8, 0.0)))  # level from 0.5 on
    text = start_refused(fmu, values | {"stop.upper": 2.0}, "cam1", "cam2")
    assert 1.0 <= number_after(text, "theta") <= 1.6  # both cams turn by the same angle
    assert number_after(text, "z") == pytest.approx(0.01)
    fmu.ok("fmi2Reset")
    helices = {"cam1.lead_angle": 0.0, "cam2.lead_angle": 0.0}
    start_refused(fmu, helices, "cam1.lead_angle = 0", "cam2.lead_angle = 0")
    fmu.ok("fmi2Reset")
    level = {
        "cam1.profile": ELLIPSE,
        "cam1.lead_angle": 0.0,
        "cam1.ellipse_curvature": 1,
        "cam2.lead_angle": 0.0,
    }
    assert number_after(start_refused(fmu, level, "cam1", "cam2"), "theta") == 0.0
