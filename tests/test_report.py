"""The report on a design: its numbers against independent ones, its inputs, its words."""

import math
import re

import numpy as np
import pytest
from lxml import etree

from dualcam.cli import main
from dualcam.design_file import read_design
from dualcam.report.inputs import input_tables
from dualcam.report.page import report_page
from dualcam.report.summary import largest_loads, residual_words, span_words
from dualcam.simulation.run import Trajectory

HELICES = """\
title = "Elbow <left> & right"
description = "A trial of the report."
[cam1]
radius = "20 mm"
lead_angle = "40 deg"
friction = 0.12
[cam2]
radius = "20 mm"
lead_angle = "50 deg"
friction = 0.1
[spring]
preload = 60
stiffness = "35 N/mm"
free_length = "70 mm"
solid_length = "38 mm"
[stop]
upper = "75 deg"
[pin]
radius = "3 mm"
width = "8 mm"
cam_modulus = "110 GPa"
[limits]
pressure = "900 MPa"
[scenario]
stop = 1.0
inputs.tau = { time = [0.0, 0.5, 0.5, 1.0], value = [0.0, 8.0, 0.0, 0.0] }
"""


@pytest.fixture
def design(tmp_path):
    path = tmp_path / "elbow.toml"
    path.write_text(HELICES)
    return read_design(path)


def by_hand():
    """Largest reaction [N] and pressure [Pa] of each cam, at 75 deg while loading: two helices, by hand."""
    r, contacts, theta = 0.02, 2, math.radians(75.0)
    s = [math.tan(math.radians(angle)) for angle in (40.0, 50.0)]
    mu = [0.12, 0.1]
    a = [r * slope for slope in s]
    force = 60.0 + 35e3 * a[0] * a[1] / (a[0] + a[1]) * theta
    kappa = [(1 - m * t) / (r * (t + m)) for m, t in zip(mu, s, strict=True)]
    torque = force / sum(kappa)
    reactions = [torque * math.hypot(1, t) / (r * (t + m)) / contacts for t, m in zip(s, mu, strict=True)]
    modulus = 1 / ((1 - 0.3**2) / 210e9 + (1 - 0.3**2) / 110e9)
    return reactions, [math.sqrt(n / 0.008 * modulus / (math.pi * 0.003)) for n in reactions]


def test_largest_loads_are_those_of_a_calculation_by_hand(design):
    loads = largest_loads(design.mechanism(), design.pin)
    reactions, pressures = by_hand()
    assert loads.reaction.value == pytest.approx(max(reactions), rel=1e-12)
    assert loads.pressure.value == pytest.approx(max(pressures), rel=1e-12)
    assert loads.reaction.cams == loads.pressure.cams == (1 + int(np.argmax(reactions)),)
    assert math.degrees(loads.reaction.theta) == pytest.approx(75.0)
    assert largest_loads(design.mechanism(), None).pressure is None


def test_both_cams_are_named_where_they_carry_the_same(design):
    design.parameters.update({"cam1.lead_angle": 0.8, "cam2.lead_angle": 0.8, "cam1.friction": 0.1})
    assert largest_loads(design.mechanism(), design.pin).pressure.cams == (1, 2)


def words_of(page):
    return re.sub(r"\s+", " ", " ".join(etree.HTML(page).itertext()))


def test_the_report_has_the_numbers_that_are_asked_for(design):
    words = words_of(report_page(design))
    reactions, pressures = by_hand()
    cam = 1 + int(np.argmax(reactions))
    place = f"at theta = 75 deg, cam {cam}"
    assert f"largest reaction {max(reactions):.4g} N on one contact {place} (2 contacts share" in words
    assert f"largest contact pressure {max(pressures) / 1e6:.4g} MPa {place}" in words
    assert "allowed contact pressure 900 MPa Young's moduli pin 210 GPa, cams 110 GPa" in words
    assert "line contact by Hertz" in words
    assert "motion under friction one motion under every load (unique)" in words
    assert "F_ext is an external axial force on the follower" in words


def test_the_title_stands_in_the_page_and_no_picture_repeats_the_heading(design):
    page = etree.HTML(report_page(design))
    assert page.findtext(".//h1") == design.title
    assert design.title in page.findtext(".//title")
    drawn = ["".join(svg.itertext()) for svg in page.iter("svg")]
    assert len(drawn) == 4
    assert not [text for text in drawn if design.title in text or "elbow" in text]
    assert design.description in words_of(report_page(design))


def test_the_heat_of_the_run_is_the_sum_of_its_accounts(design):
    rows = {row[0]: row[1] for row in cells(report_page(design)) if len(row) == 2}
    energy = {name: float(value.split()[0]) for name, value in rows.items() if value.endswith(" J")}
    heats = [value for name, value in energy.items() if "heat" in name and name != "all heat of this run"]
    assert energy["all heat of this run"] == pytest.approx(sum(heats), rel=1e-4)
    work, ends = energy["work of the torque at the shaft"], energy["spring"] + energy["motion"]
    assert energy["all heat of this run"] == pytest.approx(work - ends, rel=1e-4)


def cells(page):
    return [[(cell.text or "") for cell in row.iter("td")] for row in etree.HTML(page).iter("tr")]


def test_inputs_are_complete_with_units(design):
    rows = {row[0]: row[1:] for rows in input_tables(design).values() for row in rows}
    assert rows["cam1.lead_angle"] == ("0.698132", "rad", "40 deg")
    assert rows["cam1.radius"] == ("0.02", "m", "20 mm")
    assert rows["spring.stiffness"] == ("35000", "N/m", "35 N/mm")
    assert rows["contacts (default)"][0] == "2"
    assert rows["spring.free_length"][2] == "70 mm" and rows["spring.solid_length"][2] == "38 mm"
    assert rows["pin.width"][2] == "8 mm" and rows["pin.cam_modulus"][2] == "110 GPa"
    assert rows["limits.pressure"][2] == "900 MPa"
    assert rows["scenario.stop"] == ("1", "s", "")
    assert rows["scenario.inputs.tau at 1 s (linear)"] == ("0", "N.m", "")
    assert not [name for name in rows if "ellipse" in name or "table" in name]  # no helix uses these
    shown = cells(report_page(design))
    assert [list((name, *row)) in shown for name, row in rows.items()] == [True] * len(rows)


def test_axes_of_loads_begin_at_zero(design):
    from dualcam.plots.design import plot_contact, plot_strength

    mechanism = design.mechanism()
    axes = [*plot_strength(mechanism, design.pin).axes, *plot_contact(mechanism, design.pin, 1e9).axes]
    assert [plot.get_ylim()[0] for plot in axes] == [0.0, 0.0, 0.0, 0.0]
    assert all(plot.get_xlabel().endswith("[deg]") for plot in axes)


@pytest.mark.parametrize(
    "values, words",
    [
        ([63.81, 63.82], "63.8 %"),
        ([55.0, 63.8], "55 to 63.8 %"),
        ([math.nan, 7.0], "7 %"),
        ([math.nan], "none"),
    ],
)
def test_one_number_where_both_ends_are_equal(values, words):
    assert span_words(np.array(values), "%") == words


@pytest.mark.parametrize(
    "residual, work, words",
    [
        (-1.08442e-15, 3.2, "0 (rounding)"),
        (0.0, 0.0, "0 (rounding)"),
        (-3.2e-9, 3.2, "3.2e-09 J, 1e-09 of the largest energy"),
        (0.1, 0.0, "0.1 J"),
    ],
)
def test_a_residual_is_related_to_the_work(residual, work, words):
    names = ("time", "energy.work_in", "energy.residual")
    assert residual_words(Trajectory(names, np.array([[0.0, 0.0, 0.0], [1.0, work, residual]]))) == words


def test_band_tells_the_largest_loads(design, capsys):
    reactions, pressures = by_hand()
    assert main(["band", str(design.path)]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert f"Largest reaction: {max(reactions):.4g} N on one contact at theta = 75 deg" in said
    assert f"Largest contact pressure (Hertz): {max(pressures) / 1e6:.4g} MPa at theta = 75 deg" in said
    assert "pin 210 GPa, cams 110 GPa" in said
    design.path.write_text(re.sub(r"\[pin\][^\[]*", "", HELICES))
    assert main(["band", str(design.path)]) == 0
    assert "no section [pin]" in capsys.readouterr().out
