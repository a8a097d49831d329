"""`dualcam identify`: what the residuals ask for, and doubts of a recording that the model does not explain.

The recordings come from the closed form in tests/reference/bench.py, with a fault that is known."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from equal_radii import write_equal_radii
from reference.bench import Bench, record, sines

from dualcam import identify
from dualcam.__main__ import main
from dualcam.common.unit_guards import torque_factor_warnings
from dualcam.design_file import read_design
from dualcam.errors import IdentificationError
from dualcam.identification import Recording

SPRING = ["friction", "spring.preload", "spring.stiffness"]
BENCH = Bench(friction=(0.17, 0.17), preload=62.0, stiffness=47e3)
TIME = np.linspace(0.0, 20.0, 801)
FAST = sines(TIME, 0.7, (0.4, 0.1, 0.05), (0.11, 0.53, 1.37))


@pytest.fixture(scope="module")
def design(tmp_path_factory):
    """Grooves of the bench, with other friction and spring."""
    return read_design(write_equal_radii(tmp_path_factory.mktemp("design") / "my.toml"))


def recording(bench, motion, offset=0.0, seed=1, noise=0.05):
    time, theta, tau = record(bench, TIME, motion, noise, 1e-3, seed)
    return Recording.from_arrays(time, theta, tau + offset)


@pytest.mark.parametrize("offset", [-0.3, 0.1, 0.2, 0.4])
def test_a_zero_error_of_the_torque_sensor_is_named(design, offset):
    """The fit without the offset gives wrong values with narrow intervals; the fit with it does not."""
    data = recording(BENCH, sines(TIME), offset)
    found = identify(data, design, SPRING)
    assert not found["spring.preload"].low < 62.0 < found["spring.preload"].high
    one = next(one for one in found.missing if one.name == "torque_offset")
    assert one.change == pytest.approx(offset, abs=0.05)
    assert one.half_width < abs(offset)
    (warning,) = [text for text in found.warnings() if "Lack of fit" in text]
    assert "torque_offset" in warning
    again = identify(data, design, [*SPRING, "torque_offset"])
    assert not again.missing
    assert again["torque_offset"].value == pytest.approx(offset, abs=0.05)
    half = 0.5 * (again["spring.preload"].high - again["spring.preload"].low)
    assert abs(again["spring.preload"].value - 62.0) < 1.5 * half


def test_a_wrong_preload_that_is_held_is_named_beside_the_inertia(design):
    """The inertia takes over what the preload lacks."""
    data = recording(BENCH, FAST)
    found = identify(data, design, ["friction", "spring.stiffness", "inertia.shaft"])
    assert "spring.preload" in {one.name for one in found.missing}
    assert any("Lack of fit" in text for text in found.warnings())


def test_a_held_value_that_moves_the_inertia_is_named(design):
    """Said: the change by 10 % of the held stiffness. Shown: the difference of two fits, 1 % apart."""
    data = replace(recording(Bench(shaft=0.01), FAST), omega=FAST[1])  # hardly a sample without direction
    found = identify(data, design, ["inertia.shaft"])
    (lever,) = [one for one in found.levers if one.held_name == "spring.stiffness"]
    more = replace(design, parameters=design.parameters | {"spring.stiffness": 50.05e3})
    change = identify(data, more, ["inertia.shaft"])["inertia.shaft"].value - found["inertia.shaft"].value
    assert change == pytest.approx(0.01 * lever.change, rel=0.1)
    (warning,) = [text for text in found.warnings() if "depends on values that are held" in text]
    assert warning.startswith("inertia.shaft") and "spring.stiffness = 5e+04 N/m" in warning


def test_a_part_of_the_torque_below_the_noise_is_named(design):
    found = identify(recording(Bench(shaft=0.008), FAST), design, ["inertia.shaft"])
    one = found["inertia.shaft"]
    assert one.part == pytest.approx(one.value * np.sqrt(np.mean(FAST[2][found.slips] ** 2)), rel=0.2)  # N.m
    assert one.part < found.noise
    assert any("inertia.shaft makes" in text and "less than the noise" in text for text in found.warnings())


def test_equal_cams_are_exchangeable(design):
    """The torque of the closed form with both values swapped is the same, so no interval is given."""
    swapped = [replace(BENCH, friction=pair).torque(*FAST) for pair in ((0.25, 0.1), (0.1, 0.25))]
    assert swapped[0] == pytest.approx(swapped[1], rel=1e-12)
    found = identify(
        recording(replace(BENCH, preload=40.0), sines(TIME), noise=0.01),
        design,
        ["cam1.friction", "cam2.friction"],
    )
    assert {one.interval for one in found.parameters} == {"not determined"}
    assert any("exchangeable" in text and "Fit friction, one value" in text for text in found.warnings())


def test_a_limit_inside_of_the_interval_is_no_wish_for_more(design):
    found = identify(recording(BENCH, FAST, seed=3), design, [*SPRING, "friction_viscous"])
    one = found["friction_viscous"]
    assert one.low == 0.0 and one.status == "known"
    if one.limit is not None:
        assert any("the limit 0 is inside the 95 % interval" in text for text in found.warnings())
    assert not any("ask for a value beyond" in text for text in found.warnings())


# ---- units and signs ----


@pytest.mark.parametrize(
    "factor, unit, likely",
    [
        (0.01, "N.cm", "N.m, not N.cm"),
        (1e3, "N.m", "N.mm, not N.m"),
        (100.0, "N.m", "N.cm, not N.m"),
        (1e-3, "mN.m", "N.m, not mN.m"),
        (30.0, "N.mm", "is the torque in N.mm"),
    ],
)
def test_factors_between_units_of_torque(factor, unit, likely):
    for scatter in (0.7, 1.0, 1.4):
        (text,) = torque_factor_warnings(factor * scatter, unit)
        assert likely in text
    assert not torque_factor_warnings(2.0, unit) and not torque_factor_warnings(float("nan"), unit)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_equal_radii(tmp_path / "my.toml")
    return tmp_path


def write(data, header):
    columns = np.column_stack([data.time, np.degrees(data.theta), data.tau])
    np.savetxt("bench.csv", columns, "%.6f", ",", header=header, comments="")


def test_a_slip_in_the_unit_of_torque(folder, capsys):
    write(recording(BENCH, sines(TIME)), "time_s,theta_deg,tau_Ncm")
    assert main(["identify", "bench.csv", "my.toml"]) == 0
    said = capsys.readouterr().err
    assert "looks like N.m, not N.cm" in said and "Lack of fit" not in said


def test_a_refused_design_does_not_hide_the_result(folder, capsys):
    """Torques of a bench in N.m under the header N.cm: the check refuses the spring that is fitted."""
    write(recording(BENCH, sines(TIME), -3.0), "time_s,theta_deg,tau_Ncm")
    words = ["identify", "bench.csv", "my.toml", "-o", "fitted.toml", "--report", "bench.html"]
    assert main(words) == 1
    said = capsys.readouterr()
    assert "spring.preload" in said.out and "bench.html" in said.out and "fitted.toml" not in said.out
    warned, refused = said.err.find("looks like N.m, not N.cm"), said.err.find("fitted.toml is not written")
    assert 0 <= warned < refused
    assert Path("bench.html").exists() and not Path("fitted.toml").exists()
    assert main([*words, "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["files"] == {"report": "bench.html"} and found["warnings"] and found["parameters"]
    assert "fitted.toml is not written" in found["error"] and found["findings"] == []


@pytest.mark.parametrize("viscous", [0.0, 0.5])
def test_a_slip_in_the_unit_of_time(folder, capsys, viscous):
    """With viscous friction the FMU jams at such speeds at once; without, in the search."""
    text = (
        Path("my.toml")
        .read_text()
        .replace("friction = 0.14", f"friction = 0.14\nfriction_viscous = {viscous}")
    )
    Path("my.toml").write_text(text)
    write(recording(BENCH, sines(TIME)), "time_ms,theta_deg,tau_Nm")
    assert main(["identify", "bench.csv", "my.toml", "-o", "fitted.toml"]) == 1
    said = capsys.readouterr().err
    assert "duration of 0.02 s" in said and "is the time in s? Then name the column time_s" in said
    assert not Path("fitted.toml").exists()


# ---- the fitted design, and the page ----


def test_what_is_not_determined_keeps_its_start(folder):
    steady = (0.1 + 0.06 * TIME, np.full(801, 0.06), np.zeros(801))  # loading only
    found = identify(recording(BENCH, steady), "my.toml", SPRING)
    path = found.write_design("fitted.toml")
    before, after = (read_design(name) for name in ("my.toml", path))
    assert before.parameters == after.parameters
    lines = [line for line in path.read_text().splitlines() if "not determined by the recording" in line]
    assert len(lines) == 4  # friction of two cams, preload, stiffness
    assert all("N/m" not in line for line in lines)
    page = found.write_report("r.html").read_text(encoding="utf-8")
    assert "friction and spring.preload and spring.stiffness: not determined. Their correlations" in page
    assert (
        '<div class="numbers">' in page
        and ".numbers td { overflow-wrap: normal; white-space: nowrap }" in page
    )


def test_a_design_that_the_check_refuses_is_not_written(folder):
    """A negative preload from a recording with a large zero error."""
    found = identify(recording(BENCH, sines(TIME), -3.0), "my.toml", SPRING)
    assert found["spring.preload"].value < 0.0
    with pytest.raises(IdentificationError, match=r"`dualcam check` would refuse"):
        found.write_design("fitted.toml")
    assert not Path("fitted.toml").exists()


def test_marks_of_the_legend_are_larger_than_the_points(design):
    axes = identify(recording(BENCH, sines(TIME)), design, SPRING).plot().axes[0]
    marks = [mark.get_markersize() for mark in axes.get_legend().legend_handles]
    assert len(marks) == 4 and min(marks) > 2.0 * max(line.get_markersize() for line in axes.get_lines())


def test_a_long_fit_tells_its_progress(design):
    told = []
    identify(recording(BENCH, sines(TIME)), design, SPRING, progress=told.append)
    assert "801 samples" in told[0] and any(text.startswith("fit: run ") for text in told)
