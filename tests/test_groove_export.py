"""`dualcam design --export`, and export_groove: files, options, and what is refused."""

import json
import sys
import warnings

import ezdxf
import numpy as np
import pytest
from equal_radii import write_equal_radii

from dualcam import read_design
from dualcam.__main__ import main
from dualcam.design import GrooveCut, Helix, Mechanism, Spring, export_groove
from dualcam.errors import DesignError, DualcamWarning


@pytest.fixture
def design(tmp_path, monkeypatch):
    """A design file in an empty folder: two equal helices of 45 deg, pin of 6 mm."""
    monkeypatch.chdir(tmp_path)
    write_equal_radii(tmp_path / "my.toml")
    return tmp_path


def run(capsys, *words, code=0):
    capsys.readouterr()
    assert main(["design", "my.toml", *words]) == code
    return capsys.readouterr()


def names(folder):
    return {path.name for path in folder.iterdir()} - {"my.toml"}


def points(path):
    return np.genfromtxt(path, delimiter=",", names=True)


# ---- the command ----


def test_each_file_is_for_one_cam(design, capsys):
    said = run(capsys, "--export", "groove.csv", "--export", "drawings.dxf").out
    written = {"groove_cam1.csv", "groove_cam2.csv", "drawings_cam1.dxf", "drawings_cam2.dxf"}
    assert names(design) == written
    assert all(f"{name} written" in said for name in written)
    assert "groove 1 is right-handed and groove 2 is left-handed" in said
    assert "Pin of diameter 6 mm, run-out 0 mm" in said


def test_one_cam_has_the_name_that_was_given(design, capsys):
    said = run(capsys, "--export", "groove.csv", "--cam", "2", "--loading", "clockwise").out
    assert names(design) == {"groove.csv"} and "groove 2 is right-handed: cam 2 turns clockwise" in said
    rows = points("groove.csv")
    assert rows["centre_y_m"][-1] > 0.0
    assert rows["z_m"][-1] == pytest.approx(0.02 * np.radians(40.0), rel=1e-12)


@pytest.mark.parametrize("cam, hand", [(1, "right"), (2, "left")])
def test_a_table_of_points_is_named_by_cam_hand_and_number_of_grooves(design, capsys, cam, hand):
    """The points of the second groove of the solid and of the drawing are half a turn away."""
    said = run(capsys, "--cam", str(cam), "--export", "D.csv", "--export", "D.dxf").out
    grooves = "one of 2 equal grooves, the other one is at 180 deg"
    assert f"D.csv written: cam {cam}, {hand}-handed, {grooves}\n" in said and "D.dxf written\n" in said
    text = (design / "my.toml").read_text()
    (design / "my.toml").write_text("contacts = 1\n" + text)
    said = run(capsys, "--cam", str(cam), "--export", "D.csv", "--force").out
    assert f"D.csv written: cam {cam}, {hand}-handed, the only groove\n" in said


def test_pin_and_run_out_of_the_command(design, capsys):
    run(capsys, "--export", "groove.csv", "--cam", "1", "--pin-diameter", "5 mm", "--run-out", "0.002")
    rows = points("groove.csv")
    wanted = GrooveCut(read_design("my.toml").mechanism(), 1, 0.0025, 0.002).flanks(rows["psi_rad"])
    assert rows["upper_z_m"] == pytest.approx(wanted.upper.z, abs=1e-15)
    turned = 0.002 * np.sqrt(0.5) / 0.02  # on a helix of 45 deg
    assert rows["psi_rad"][[0, -1]] == pytest.approx([-turned, np.radians(40.0) + turned], rel=1e-12)


def test_a_run_out_is_straight_also_where_the_table_goes_on(design, capsys):
    """The table steepens beyond the stop; the run-out keeps the slope at the stop, as the help says."""
    psi = np.linspace(0.0, 1.0, 41)
    rows = "".join(
        f"{p!r},{z!r}\n" for p, z in zip(psi.tolist(), (0.02 * psi + 0.01 * psi**2).tolist(), strict=True)
    )
    (design / "table.csv").write_text("psi_rad,z_m\n" + rows)
    cams = "".join(f'[cam{k}]\nradius = 0.02\nprofile = "table"\ntable = "table.csv"\n' for k in (1, 2))
    (design / "my.toml").write_text(cams + "[stop]\nupper = 1.0\n[pin]\nradius = 0.003\nwidth = 0.008\n")
    run(capsys, "--export", "g.csv", "--cam", "1", "--run-out", "3 mm")
    rows = points("g.csv")
    beyond = rows["psi_rad"] > 0.5
    stop = 0.02 * 0.5 + 0.01 * 0.25
    assert beyond.any()
    straight = stop + 0.03 * (rows["psi_rad"][beyond] - 0.5)
    assert rows["z_m"][beyond] == pytest.approx(straight, abs=1e-9)
    said = run(capsys, "--help").out
    assert "straight at the lead angle of the stop" in " ".join(said.split())


def test_the_groove_of_a_wanted_torque_is_cut(design, capsys):
    """With and without its table; both describe the same groove."""
    run(capsys, "--torque", "5", "--export", "cut.csv", "--cam", "1")
    assert names(design) == {"cut.csv"}
    said = run(capsys, "--torque", "5", "-o", "table.csv", "--export", "cut.csv", "--force").out
    assert "Replace the lines profile, lead_angle and table" in said and "cut_cam2.csv written" in said
    table, cut = points("table.csv"), points("cut.csv")
    assert cut["psi_rad"][-1] == pytest.approx(table["psi_rad"][-1], rel=1e-9)
    assert cut["z_m"][-1] == pytest.approx(table["z_m"][-1], rel=1e-9)


def test_the_result_as_data(design, capsys):
    found = json.loads(run(capsys, "--export", "groove.csv", "--json").out)
    assert found == {"files": ["groove_cam1.csv", "groove_cam2.csv"]}
    both = json.loads(run(capsys, "--torque", "5", "--export", "g.dxf", "--cam", "1", "--json").out)
    assert both["files"] == ["g.dxf"] and both["self_locking"] is False and both["table"] is None


@pytest.mark.parametrize(
    "words, mention",
    [
        ([], "nothing to do: give --torque and --output"),
        (["-o", "t.csv"], "nothing to do: give --torque and --output"),
        (["-o", "t.csv", "--export", "g.csv"], "give --torque and --output together"),
        (["--torque", "5"], "give --torque and --output together"),
        (["--export", "g.csv", "--cam", "3"], "'1', '2', 'both'"),
        (["--export", "g.csv", "--depth", "8 mm"], "--depth is the size of a solid"),
        (["--export", "g.dxf", "--outer-diameter", "50 mm"], "--outer-diameter is the size of a solid"),
        (["--torque", "5", "-o", "t.csv", "--run-out", "3 mm"], "--run-out belongs to --export"),
    ],
)
def test_wrong_use(design, capsys, words, mention):
    assert mention in run(capsys, *words, code=2).err
    assert names(design) == set()


@pytest.mark.parametrize(
    "words, mention",
    [
        (["--export", "g.stl"], "g.stl: allowed endings are .csv, .dxf, .step, .stp"),
        (["--export", "nowhere/g.csv"], "the folder nowhere does not exist"),
        (["--export", "g.csv", "--pin-diameter", "6 deg"], '--pin-diameter "6 deg"'),
        (["--export", "g.csv", "--pin-diameter", "6"], "= 6 m: allowed is more than 0 and less"),
        (["--export", "g.csv", "--pin-diameter", "6"], "cam 1, 40 mm. A number without unit is in m"),
        (["--export", "g.csv", "--pin-diameter", "6"], 'write for example --pin-diameter "6 mm"'),
        (["--export", "g.csv", "--pin-diameter", "50"], 'write for example --pin-diameter "6 mm"'),
        (["--export", "g.csv", "--pin-diameter", "nan"], "--pin-diameter = nan m"),
        (
            ["--export", "g.csv", "--pin-diameter", "-6 mm"],
            "--pin-diameter = -0.006 m: allowed is more than 0",
        ),
        (["--export", "g.csv", "--run-out", "nan"], "run_out = nan m"),
        (["--export", "g.csv", "--export", "g.csv"], "g_cam1.csv is written twice"),
        (["--torque", "5e9", "--export", "g.csv"], "torque"),
    ],
)
def test_what_cannot_be_done_is_refused_before_anything_is_written(design, capsys, words, mention):
    assert mention in run(capsys, *words, code=1).err
    assert names(design) == set()


def test_a_file_is_replaced_only_when_told(design, capsys):
    (design / "g_cam2.csv").write_text("mine")
    assert "g_cam2.csv exists" in run(capsys, "--export", "g.csv", code=1).err
    assert names(design) == {"g_cam2.csv"} and (design / "g_cam2.csv").read_text() == "mine"
    run(capsys, "--export", "g.csv", "--force")
    assert points("g_cam2.csv")["z_m"][0] == 0.0


def test_a_design_without_a_pin(design, capsys):
    text = (design / "my.toml").read_text().partition("[pin]")[0]
    (design / "my.toml").write_text(text)
    assert "has no [pin]" in run(capsys, "--export", "g.csv", code=1).err
    run(capsys, "--export", "g.csv", "--pin-diameter", "6 mm")
    assert names(design) == {"g_cam1.csv", "g_cam2.csv"}


@pytest.mark.parametrize(
    "module, file, mention",
    [
        ("ezdxf", "g.dxf", 'pip install "dualcam[dxf]"'),
        ("OCP.BRepAlgoAPI", "g.step", 'pip install "dualcam[cad]"'),
    ],
)
def test_a_missing_library_is_named_before_anything_is_written(
    design, capsys, monkeypatch, module, file, mention
):
    monkeypatch.setitem(sys.modules, module, None)  # as if it were not installed
    said = run(capsys, "--export", "g.csv", "--export", file, code=1).err
    assert mention in said and f"--export {file}: " in said and "No file is written" in said
    assert names(design) == set()
    run(capsys, "--export", "g.csv")


# ---- the function ----

HELICES = tuple(Helix(radius, 0.7) for radius in (0.02, 0.03))
CAM = Mechanism((HELICES[0], HELICES[1]), (0.14, 0.14), Spring(50.0, 5e4), 1.2, contacts=1)


def test_a_pin_with_one_end_has_one_groove(tmp_path):
    for file in export_groove(CAM, tmp_path / "g.dxf", 0.003):
        drawing = ezdxf.readfile(file).modelspace()
        assert len(drawing.query('LWPOLYLINE[layer=="CENTRE"]')) == 1
        assert any("1 groove," in text.dxf.text for text in drawing.query("TEXT"))


@pytest.mark.parametrize("cams", [(), (3,), (1, 1), (1, 2, 2)])
def test_cams_that_are_not_there(tmp_path, cams):
    with pytest.raises(DesignError, match=r"allowed are \(1,\), \(2,\) and \(1, 2\)"):
        export_groove(CAM, tmp_path / "g.csv", 0.003, cams=cams)


def test_a_solid_needs_a_depth_and_walls_that_fit(tmp_path):
    pytest.importorskip("OCP.STEPControl", reason='pip install "dualcam[cad]"')
    with pytest.raises(DesignError, match="a solid needs depth"):
        export_groove(CAM, tmp_path / "g.step", 0.003)
    with pytest.warns(DualcamWarning, match=r"cam 1 \(radius 14 to 26 mm\) and cam 2 \(radius 24 to 36 mm\)"):
        export_groove(CAM, tmp_path / "g.step", 0.003, depth=0.012)
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # walls of 15 to 25 mm and 25 to 35 mm touch
        assert len(export_groove(CAM, tmp_path / "h.step", 0.003, depth=0.01)) == 2
