"""Files of groove tables as people have them: Table.read."""

import math

import numpy as np
import pytest

from dualcam.design import Table
from dualcam.design.groove_files import read_groove
from dualcam.errors import DesignError, UnitWarning

DEGREES = np.array([0.0, 20.0, 45.0, 60.0, 80.0])
MILLIMETRES = np.array([0.0, 4.5, 9.25, 12.0, 14.0])
NUMBERS = list(zip(DEGREES.tolist(), MILLIMETRES.tolist(), strict=True))


def lines(delimiter=";", decimal=","):
    return "".join(f"{p}{delimiter}{z}\n".replace(".", decimal) for p, z in NUMBERS)


@pytest.fixture
def file(tmp_path):
    def write(content):
        path = tmp_path / "groove.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


def test_what_was_guessed_is_said(file):
    assert Table.read(file("psi [deg];z [mm]\n" + lines()), 0.02).notes == (
        "columns are separated by semicolons",
        "the decimal sign is a comma",
        "the header says deg and mm",
    )
    assert Table.read(file("psi_rad,z_m\n0,0\n0.1,0.01\n0.2,0.02\n0.3,0.03\n"), 0.02).notes == ()


def test_given_units_need_no_header(file):
    path = file(lines())
    table = Table.read(path, 0.02, units=("deg", "mm"), delimiter=";", decimal=",")
    assert table.psi[-1] == pytest.approx(math.radians(80)) and table.z[-1] == pytest.approx(0.014)
    assert table.notes == ()
    with pytest.raises(DesignError, match="no header, so the units are not known: add a first line such as"):
        Table.read(path, radius=0.02)


def test_units_against_the_header(file):
    """Units that are given count more than the header."""
    table = Table.read(file("psi_rad,z_m\n" + lines(",", ".")), 0.02, units=("deg", "mm"))
    assert table.psi[-1] == pytest.approx(math.radians(80))


def test_a_right_header_over_wrong_numbers_is_warned(file):
    with pytest.warns(UnitWarning) as found:
        Table.read(file("psi_rad,z_m\n" + lines(",", ".")), 0.02)
    texts = " ".join(str(one.message) for one in found)
    assert "psi = 80 rad: this looks like degrees; 80 deg is 1.39626 rad" in texts
    assert "z = 14 m: this looks like millimetres; 14 mm is 0.014 m" in texts
    with pytest.warns(UnitWarning, match=r"lead angle of the table reaches 8\d.* z looks like millimetres"):
        Table.read(file("psi_rad,z_m\n0,0\n0.5,0.2\n1,0.5\n1.4,0.9\n"), 0.02)


def test_origin_between_samples(file):
    """The FMU takes such a table too: z counts from psi = 0."""
    table = Table.read(file("psi_rad,z_m\n-0.1,0\n0.1,0.002\n0.2,0.003\n0.3,0.004\n"), 0.02)
    assert float(table.at(0.0).z) == 0.0


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "the file is empty: line 1 must be a header such as psi_deg,z_mm"),
        ("psi_rad,z_m\n", "0 lines of numbers: allowed are 4 or more"),
        (
            "psi,z\n0,0\n",
            "column 'psi': no unit; column 'z': no unit. Allowed is a header such as psi_deg,z_mm",
        ),
        ("Winkel [Altgrad];Hub [mm]\n0;0\n", "unit 'Altgrad' is not known. Allowed is a header such as"),
        ("psi_deg,z_mm\n0,0\n30,1\n20,2\n40,3\n", "psi = 20 deg: allowed is more than 30 deg, the value of"),
        (
            "psi_rad,z_m\n0,0\n1,1e-3\n0.5,2e-3\n2,3e-3\n",
            "line 4, column 1: psi = 0.5 rad: allowed is more than 1 rad",
        ),
        (
            "psi_rad,z_m\n0,0\n1,2e-3\n2,1e-3\n3,3e-3\n",
            "line 4, column 2: z = 0.001 m: allowed is at least 0.002 m",
        ),
        ("psi_rad,z_m\n0,0\n1,1\n2,2\n", "3 lines of numbers: allowed are 4 or more"),
        ("psi_rad,z_m\n1,0\n2,1\n3,2\n4,3\n", "psi goes from 1 to 4 rad: psi = 0 must be among them"),
    ],
)
def test_refusals_name_file_line_column_and_value(file, text, words):
    path = file(text)
    with pytest.raises(DesignError) as caught:
        Table.read(path, 0.02)
    assert str(caught.value).startswith(f"{path}: ") and words in str(caught.value)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"units": ("degree", "mm")}, r'such as \("deg", "mm"\)'),
        ({"units": "deg"}, "allowed are an angle"),
        ({"delimiter": "|"}, "delimiter = '|': allowed"),
        ({"decimal": ";"}, "decimal = ';': allowed"),
        ({"decimal": ",", "delimiter": ","}, "both a comma"),
    ],
)
def test_options_that_do_not_exist(file, options, words):
    with pytest.raises(DesignError, match=words.replace("|", r"\|")):
        Table.read(file(lines()), 0.02, **options)


def test_missing_file(tmp_path):
    with pytest.raises(DesignError, match=r"there is no groove table .*nix\.csv"):
        Table.read(tmp_path / "nix.csv", 0.02)
    with pytest.raises(DesignError, match="is a folder"):
        Table.read(tmp_path, 0.02)


FMU_READS = {
    "plain": "psi_rad,z_m\n0,0\n0.1,0.01\n0.2,0.02\n0.3,0.03\n",
    "Windows": "psi_rad,z_m\r\n0,0\r\n0.1, 0.01\r\n0.2,0.02\r\n0.3,0.03\r\n\r\n",
    "mark": "\ufeffpsi_rad,z_m\n0,0\n0.1,0.01\n0.2,0.02\n0.3,0.03",
    "comment": "psi_rad,z_m\n# x\n0,0\n0.1,0.01\n0.2,0.02\n0.3,0.03\n",
    "blank line": "psi_rad,z_m\n0,0\n\n0.1,0.01\n0.2,0.02\n0.3,0.03\n",
    "header first": "\npsi_rad,z_m\n0,0\n0.1,0.01\n0.2,0.02\n0.3,0.03\n",
    "quotes": 'psi_rad,z_m\n"0",0\n0.1,0.01\n0.2,0.02\n0.3,0.03\n',
    "more columns": "psi_rad,z_m\n0,0,\n0.1,0.01,\n0.2,0.02,\n0.3,0.03,\n",
    "spaces": "psi_rad,z_m\n0 0\n0.1 0.01\n0.2 0.02\n0.3 0.03\n",
    "old Macintosh": "psi_rad,z_m\r0,0\r0.1,0.01\r0.2,0.02\r0.3,0.03\r",
    "utf-16": "psi_rad,z_m\n0,0\n0.1,0.01\n0.2,0.02\n0.3,0.03\n".encode("utf-16"),
}


@pytest.mark.parametrize("name", FMU_READS)
def test_what_is_called_the_fmus_format_is_what_the_fmu_reads(file, name):
    from dualcam import Fmu
    from dualcam.errors import FmuError
    from dualcam.fmi.library import fmu_path

    path = file(FMU_READS[name])
    with Fmu(fmu_path("forward")) as fmu:
        try:
            fmu.start({"cam1.profile": 3, "cam1.table": str(path), "stop.upper": 0.3})
            reads = True
        except FmuError:
            reads = False
    assert read_groove(path).is_fmu_format == reads
