"""dualcam.design.workflow: torque curves as people have them, and the groove table that comes out."""

import math
import re
import warnings

import numpy as np
import pytest

from dualcam.design import Helix, Spring, Table, synthesize
from dualcam.design.workflow import TorqueCurve, design_groove
from dualcam.errors import DesignError, DualcamWarning

SPRING = Spring(400.0, 10e3)
DEGREES = np.linspace(0.0, 70.0, 15)
TORQUE = 4.0 + np.sin(np.radians(DEGREES))


def write(path):
    """The samples in degrees and N.m."""
    rows = np.stack([DEGREES, TORQUE], 1).tolist()
    path.write_text("\n".join(["theta_deg,torque_Nm", *(f"{a},{b}" for a, b in rows)]), encoding="utf-8")
    return path


def test_a_curve_says_what_was_read(tmp_path):
    """docs/tables.md has all formats, tests/test_human_tables.py their tests."""
    curve = TorqueCurve.read(write(tmp_path / "torque.csv"))
    assert curve.theta == pytest.approx(np.radians(DEGREES), rel=1e-14) and (curve.torque == TORQUE).all()
    assert str(curve).startswith("15 samples, angles read as deg, torques as N.m: theta = 0 to 1.222 rad")


def test_groove_from_a_file(tmp_path):
    """Is that of the samples; the table that is written is the groove."""
    path = write(tmp_path / "torque.csv")
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


def test_refused_files(tmp_path):
    path = tmp_path / "torque.csv"
    with pytest.raises(DesignError, match=r"there is no torque file .*torque.csv: check folder and name"):
        design_groove(path, SPRING)
    path.write_text("theta_deg,torque_Nm\n0,1\n1,1\n", encoding="utf-8")
    with pytest.raises(DesignError, match=r"torque.csv: 2 lines of numbers: allowed are 4 or more"):
        design_groove(path, SPRING)


def test_file_that_is_no_text(tmp_path):
    (tmp_path / "torque.csv").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(DesignError, match=r"torque.csv: .*no column of theta"):
        design_groove(tmp_path / "torque.csv", SPRING)
