"""dualcam.design.workflow: torque curves as people have them, and the groove table that comes out."""

import math
import re
import warnings

import numpy as np
import pytest

from dualcam.design import DesignError, Helix, Spring, Table, synthesize
from dualcam.design.workflow import TorqueCurve, design_groove
from dualcam.errors import DualcamWarning

SPRING = Spring(400.0, 10e3)
DEGREES = np.linspace(0.0, 70.0, 15)
TORQUE = 4.0 + np.sin(np.radians(DEGREES))


def write(path, header, rows, sign=",", decimal=".", bom=""):
    lines = [sign.join(repr(float(value)).replace(".", decimal) for value in row) for row in rows]
    path.write_text(bom + "\n".join([header, *lines]) + "\n", encoding="utf-8")
    return path


FILES = {
    "degrees": ("theta_deg,torque_Nm", np.stack([DEGREES, TORQUE], 1), {}),
    "radians": ("angle [rad],torque [N.m]", np.stack([np.radians(DEGREES), TORQUE], 1), {}),
    "semicolons, decimal commas, BOM": (
        "Winkel (°);Moment (N·mm)",
        np.stack([DEGREES, 1e3 * TORQUE], 1),
        {"sign": ";", "decimal": ",", "bom": "\ufeff"},
    ),
    "tabs": ("theta_rad\ttorque_mNm", np.stack([np.radians(DEGREES), 1e3 * TORQUE], 1), {"sign": "\t"}),
    "other order, other columns": (
        "time_s,torque / Nm,force_N,theta / deg",
        np.stack([DEGREES, TORQUE, DEGREES, DEGREES], 1),
        {},
    ),
    "blank in the unit": ("theta [deg],torque [N m]", np.stack([DEGREES, TORQUE], 1), {}),
    "kilonewtons": ("theta [degrees],torque [kN.m]", np.stack([DEGREES, 1e-3 * TORQUE], 1), {}),
}


@pytest.mark.parametrize("name", FILES)
def test_curve_in_si_units(tmp_path, name):
    header, rows, options = FILES[name]
    curve = TorqueCurve.read(write(tmp_path / "torque.csv", header, rows, **options))
    assert curve.theta == pytest.approx(np.radians(DEGREES), rel=1e-14)
    assert curve.torque == pytest.approx(TORQUE, rel=1e-14)
    assert f"angles read as {curve.angle_unit}" in str(curve) and "to 1.222 rad" in str(curve)


def test_groove_from_a_file(tmp_path):
    """Is that of the samples; the table that is written is the groove."""
    path = write(tmp_path / "torque.csv", "theta_deg,torque_Nm", np.stack([DEGREES, TORQUE], 1))
    design = design_groove(path, SPRING, table=tmp_path / "groove.csv", groove2=Helix(0.02, 0.8))
    same = synthesize(
        (np.radians(DEGREES), TORQUE), float(np.radians(70.0)), SPRING, groove2=Helix(0.02, 0.8)
    )
    assert (design.table.z == same.table.z).all()
    assert design.mechanism.upper == pytest.approx(math.radians(70.0), rel=1e-15)
    assert design.torque(np.radians(DEGREES)) == pytest.approx(TORQUE, rel=1e-6)
    written = Table.read(tmp_path / "groove.csv", 0.02)
    assert (written.psi == design.table.psi).all() and (written.z == design.table.z).all()
    shorter = design_groove(path, SPRING, 1.0, groove2=Helix(0.02, 0.8))
    assert shorter.mechanism.upper == 1.0


def test_falling_samples_name_the_sample():
    samples = [0.0, 0.2, 0.1, 0.3], [5.0] * 4
    with pytest.raises(DesignError, match=r"theta\[2\] = 0.1 rad is not above theta\[1\] = 0.2 rad"):
        synthesize(samples, 0.3, SPRING)


def many(count, noise=0.0, decimals=16):
    """Samples of 4 N.m + sin(theta) on 70 deg, with noise."""
    theta = np.linspace(0.0, math.radians(70.0), count)
    noisy = 4.0 + np.sin(theta) + noise * np.random.default_rng(1).normal(size=count)
    return theta, np.round(noisy, decimals)


@pytest.mark.parametrize("count, decimals", [(401, 16), (2000, 6), (600_000, 5), (600_000, 16)])
def test_many_smooth_samples_give_a_groove(count, decimals):
    """Also rounded ones: the torque is theirs to 1e-5 of the largest. The table of the groove is small."""
    theta, torque = many(count, decimals=decimals)
    design = synthesize((theta, torque), theta[-1], SPRING, groove2=Helix(0.02, 0.8))
    assert (
        np.abs(design.torque(theta[::97]) - torque[::97]).max()
        < (1e-5 if decimals < 16 else 2e-7) * torque.max()
    )
    assert len(design.table.psi) < 1000


def test_a_kink_among_many_samples_is_no_noise():
    theta = many(5000)[0]
    torque = np.minimum(4.0 + theta, 4.2)
    design = synthesize((theta, torque), theta[-1], SPRING, groove2=Helix(0.02, 0.8))
    assert design.torque(theta[::7]) == pytest.approx(torque[::7], rel=1e-6)


@pytest.mark.parametrize("count, noise", [(401, 0.02), (2000, 0.005), (3000, 1.5e-5), (600_000, 0.02)])
def test_many_noisy_samples_are_refused_with_the_number_that_will_do(count, noise):
    theta, torque = many(count, noise)
    with pytest.raises(
        DesignError, match=r"noisy or too fine.* smooth the samples, or thin them to"
    ) as caught:
        synthesize((theta, torque), theta[-1], SPRING)
    points = float(re.search(r"about ([\d,]+) points", str(caught.value))[1].replace(",", ""))
    assert points == pytest.approx(math.sqrt(torque.max() / noise), rel=0.3)
    few = theta[:: int(count / points)], 4.0 + np.sin(theta[:: int(count / points)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        synthesize(few, few[0][-1], SPRING)


def test_some_noisy_samples_are_a_warning():
    theta, torque = many(81, 0.02)
    with pytest.warns(DualcamWarning, match=r"81 samples with a noise of about 0.0[123] N.m are noisy"):
        synthesize((theta, torque), theta[-1], Spring(800.0, 1e3), direction="frictionless")


def test_groove_from_a_number(tmp_path):
    design = design_groove(5.0, SPRING, 1.2, direction="releasing", friction=(0.1, 0.1), contacts=1)
    assert design.torque([0.0, 1.2]) == pytest.approx(5.0, rel=1e-6)
    assert design.direction == "releasing" and design.mechanism.contacts == 1
    with pytest.raises(DesignError, match=r"torque = 5.0 N.m without upper: allowed is the end"):
        design_groove(5.0, SPRING)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "there is no torque file .*torque.csv: check folder and name"),
        ("", "is empty"),
        (
            "theta,torque\n0,1\n",
            r"header 'theta, torque': column 'theta': no unit; column 'torque': no unit.*such as theta_deg",
        ),
        ("theta_deg,torque\n0,1\n", "column 'torque': no unit.*torque_Nm; units of torque are N.m, N.mm"),
        ("beta_deg,gamma_deg,torque_Nm\n0,0,1\n", "'beta_deg' and 'gamma_deg' are both theta"),
        ("theta_deg,torque_Nm\n0,1\n1,x\n", r"line 3, column 2 \(torque_Nm\): 'x': allowed is a finite"),
        ("theta_deg,torque_Nm\n0,1\n1\n", r"line 3, column 2 \(torque_Nm\): no value"),
        ("theta_deg,torque_Nm\n", "0 lines of numbers"),
        ("theta_deg,torque_Nm\n0,1\n1,1\n", "torque.csv: 2 lines of numbers: allowed are 4 or more"),
        ("theta_deg,torque_Nm\n0,1\n1,1\n2,nan\n3,1\n", "finite"),
    ],
)
def test_refused_files(tmp_path, text, message):
    path = tmp_path / "torque.csv"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(DesignError, match=message):
        design_groove(path, SPRING)


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_files_of_spreadsheets(tmp_path, encoding):
    """The same file as four programs save the file: 60 deg is pi/3 rad."""
    text = "angle [°];torque [N.mm]\r\n0;1000\r\n20;1500\r\n40;1750,5\r\n60;2000\r\n"
    (tmp_path / "torque.csv").write_bytes(text.encode(encoding))
    curve = TorqueCurve.read(tmp_path / "torque.csv")
    assert curve.theta[-1] == pytest.approx(math.pi / 3.0)
    assert curve.torque.tolist() == [1.0, 1.5, 1.7505, 2.0]


def test_file_that_is_no_text(tmp_path):
    (tmp_path / "torque.csv").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(DesignError, match=r"torque.csv: .*no column of theta"):
        design_groove(tmp_path / "torque.csv", SPRING)
