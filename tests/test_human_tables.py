"""Tables as people write them, read by each of the five readers: the exact numbers, or the refusal."""

import math
import warnings
from fractions import Fraction

import numpy as np
import pytest

from dualcam.common.tables import in_unit, read_columns
from dualcam.design import Table
from dualcam.design.workflow import TorqueCurve
from dualcam.design_file.friction_tables import read_friction_table
from dualcam.errors import DesignError, IdentificationError, StudyError, TableError, UnitWarning
from dualcam.identification import read_recording
from dualcam.study import Plan, read_study

# ---- what may stand in a file: the torques 1, 1.13, 2.5, 4 N.m at 0, 10, 20, 30 deg ----

DEGREES, TORQUES = [0.0, 10.0, 20.0, 30.0], [1.0, 1.13, 2.5, 4.0]
ROWS = "0;1\n10;1,13\n20;2,5\n30;4\n"
POINTS = ROWS.replace(",", ".").replace(";", ",")

READ = {
    "commas": f"theta_deg,torque_Nm\n{POINTS}",
    "semicolons and decimal commas": f"theta_deg;torque_Nm\n{ROWS}",
    "tabs": f"theta_deg\ttorque_Nm\n{ROWS}".replace(";", "\t"),
    "blanks": f"theta_deg torque_Nm\n{ROWS}".replace(";", "   "),
    "blanks in the header's units": f"theta [deg]  torque / N.m\n{ROWS}".replace(";", "   "),
    "comma and blank": f"theta_deg, torque_Nm\n{POINTS}".replace(",", ", "),
    "header with another separator than the rows": f"theta_deg,torque_Nm\n{ROWS}",
    "sep= line": f"sep=;\ntheta_deg;torque_Nm\n{ROWS}",
    "sep= line with another sign": f'"sep=|"\ntheta_deg|torque_Nm\n{ROWS}'.replace(";", "|"),
    "the comma as both, in pairs": "theta_deg,torque_Nm\n0,0,1,0\n10,0,1,13\n20,0,2,5\n30,0,4,0\n",
    "the comma as both, told by a sign": "theta_deg,torque_Nm\n0,+1,0\n10,0,1,13\n20,+2,5\n30,+4,0\n",
    "the comma as both, in quotes": 'theta_deg,torque_Nm\n0,"1"\n"10","1,13"\n"20,0","2,5"\n30,"4"\n',
    "quoted header": f'"theta_deg","torque_Nm"\n{POINTS}',
    "separator in a quoted header": f'"theta, measured [deg]","torque, loading [Nm]"\n{POINTS}',
    "single quotes": f"'theta_deg','torque_Nm'\n{POINTS}".replace("10", "'10'"),
    "Windows": f"theta_deg;torque_Nm\n{ROWS}".replace("\n", "\r\n"),
    "old Macintosh": f"theta_deg;torque_Nm\n{ROWS}".replace("\n", "\r"),
    "comments": f"# made by hand\n\ntheta_deg;torque_Nm\n# data\n{ROWS}".replace("1,13", "1,13  # high"),
    "header behind #, as numpy.savetxt writes it": f"# theta_deg,torque_Nm\n{POINTS}",
    "empty columns of a spreadsheet": f"theta_deg;torque_Nm;;\n{ROWS}".replace("\n", ";;\n"),
    "a row of units": f"theta;torque\ndeg;Nm\n{ROWS}",
    "a row of units in brackets": f"theta;torque;\n[deg];[N m];\n{ROWS}".replace("Moment", "torque"),
    "preamble": f"Bench 7;operator Miller\nDate;2024-03-01\nRate;1000\n\ntheta_deg;torque_Nm\n{ROWS}",
    "Winkel [Grad]": f"Winkel [Grad];Drehmoment [Nm]\n{ROWS}",
    "units in words": f"Angle in degrees;Torque (newton metres)\n{ROWS}",
    "degree sign": f"Winkel [°];Moment [N·m]\n{ROWS}",
    "capitals": f"THETA_DEG;TORQUE_NM\n{ROWS}",
    "torque_Ncm": "theta_deg,torque_Ncm\n0,100\n10,113\n20,250\n30,400\n",
    "torque in N.mm": "theta_deg,torque [N mm]\n0,1000\n10,1130\n20,2500\n30,4000\n",
    "torque in mNm": "theta_deg,torque_mNm\n0,1000\n10,1130\n20,2500\n30,4000\n",
    "radians and kilonewtons": "angle [rad],torque [kN.m]\n0,.001\n0.17453292519943295,.00113\n"
    "0.3490658503988659,.0025\n0.5235987755982988,.004\n",
    "a text column in front": "run,theta_deg,torque_Nm\nup,0,1\nup,10,1.13\nup,20,2.5\nup,30,4\n",
    "a text column between": "theta_deg;run;torque_Nm\n0;up, slow;1\n10;b;1,13\n20;c;2,5\n30;d;4\n",
    "texts with #": "theta_deg,torque_Nm,run\n0,1,run #1\n10,1.13,run #1\n20,2.5,run #2\n30,4,\n",
    "other order, other columns": "time_s,torque_Nm,theta_deg\n0,1,0\n1,1.13,10\n2,2.5,20\n3,4,30\n",
    "theta beside another angle": "theta_deg,gamma_deg,torque_Nm\n0,9,1\n10,9,1.13\n20,9,2.5\n30,9,4\n",
    "minus signs of a word processor": f"torque_Nm;x;theta_deg\n{ROWS}".replace(";", ";\u22121,0;").replace(
        "torque_Nm;\u22121,0;x;\u22121,0;theta_deg", "theta_deg;x_m;torque_Nm"
    ),
    "angles in gon": "Winkel [gon];Moment [Nm]\n0;1\n11,111111111111111;1,13\n22,222222222222222;2,5\n"
    "33,333333333333333;4\n",
    "exponents": "theta_deg,torque_Nm\n0e0,1E0\n1e1,113e-2\n+20,.25e1\n30.,4\n",
}


@pytest.fixture
def file(tmp_path):
    def write(content):
        path = tmp_path / "table.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


@pytest.mark.parametrize("name", READ)
def test_the_numbers_of_every_format(file, name):
    curve = TorqueCurve.read(file(READ[name]))
    assert curve.theta.tolist() == pytest.approx(np.radians(DEGREES).tolist(), rel=1e-15)
    assert curve.torque.tolist() == TORQUES


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "latin-1"])
def test_the_numbers_of_every_encoding(file, encoding):
    curve = TorqueCurve.read(file(READ["degree sign"].encode(encoding)))
    assert curve.torque.tolist() == TORQUES and curve.theta[-1] == pytest.approx(math.pi / 6)


HEAD = "theta_deg,torque_Nm\n"
BOTH = "the comma seems to be separator and decimal sign"
UNITS = ["units of theta are rad, deg, mrad, turn, gon", "units of torque are N.m, N.mm, N.cm, mN.m, kN.m"]
REFUSED = {
    "the comma as both": (f"{HEAD}0,1,13\n10,1,25\n20,1,31\n30,1,4\n", ["line 2, '0,1,13'", BOTH]),
    "the comma as both in one line": (f"{HEAD}0,1\n10,1,25\n20,2\n30,4\n", ["line 3", "2 ways"]),
    "the comma as both beside points": (
        f"{HEAD}0,1\n10,1,25\n20,2.5\n30,4\n",
        ["line 3", "3 values between commas, 2 columns", "Is the decimal sign a comma?"],
    ),
    "thousands in quotes": (f'{HEAD}0,1\n10,"1,130"\n20,2\n30,4\n', ["line 3, column 2", "write 1130"]),
    "thousands": ("theta_deg;torque_Nm\n0;0,5\n10;1.331,2\n20;2\n30;4\n", ["line 3, column 2", "1331,2"]),
    "point among commas": ("theta_deg;torque_Nm\n0;0,5\n10;1.5\n20;2\n30;4\n", ["line 3, column 2", "'1.5'"]),
    "falling angle": (
        f"{HEAD}0,1\n20,1\n10,1\n30,1\n",
        ["line 4, column 1: theta = 10 deg: allowed is more than 20 deg, the value of line 3"],
    ),
    "lines are counted with comments": (f"#\n\n{HEAD}0,1\n# x\n1,y\n2,1\n3,1\n", ["line 6, column 2", "'y'"]),
    "text": (f"{HEAD}0,1\n1,x\n2,1\n3,1\n", ["line 3, column 2 (torque_Nm): 'x'", "finite number"]),
    "nan": (f"{HEAD}0,1\n1,1\n2,nan\n3,1\n", ["line 4, column 2 (torque_Nm): 'nan'"]),
    "underscores": (f"{HEAD}0,1\n1,1\n2,1_0\n3,1\n", ["line 4, column 2", "'1_0'"]),
    "missing value": (f"{HEAD}0,1\n1\n2,\n3,1\n", ["line 3, column 2", "line 4", "no value"]),
    "a gap between blanks": (
        "theta_deg run torque_Nm n\n0 a 1 7\n1   1 7\n2 a 1 7\n3 a 1 7\n",
        ["line 3", "3 values between spaces, 4 columns"],
    ),
    "decimal commas around a text of two words": (
        "theta_deg run torque_Nm\n0,5 slow up 1,5\n1,5 slow up 1,5\n",
        ["line 2", "4 values between spaces, 3 columns"],
    ),
    "many faults": (HEAD + "x,1\n" * 9, ["line 2", "line 4", "and 6 more"]),
    "no unit": (f"theta,torque\n{POINTS}", ["line 1", "'theta': no unit", "'torque': no unit", *UNITS]),
    "unknown unit": (f"theta_deg,torque [lbf.ft]\n{POINTS}", ["unit 'lbf.ft' is not known", UNITS[1]]),
    "mega is not milli": (f"theta_deg,torque [MNm]\n{POINTS}", ["unit 'MNm' is not known"]),
    "unit of another kind": (f"theta_mm,torque_Nm\n{POINTS}", ["'theta_mm': mm is no unit of theta"]),
    "two angles": (f"alpha_deg,beta_deg,torque_Nm\n{POINTS}", ["'alpha_deg' and 'beta_deg' are both"]),
    "no header": (POINTS, ["there is no header", "theta_deg,torque_Nm"]),
    "empty": ("", ["the file is empty", "theta_deg,torque_Nm"]),
    "header alone": (HEAD, ["0 lines of numbers", "4 or more"]),
    "two tables in a file": (f"theta,torque\n{POINTS}{HEAD}{POINTS}", ["line 1", "'theta': no unit"]),
    "a table, then another": (f"{HEAD}{POINTS}{HEAD}{POINTS}", ["line 6, column 1 (theta_deg): 'theta_deg'"]),
    "workbook": (b"PK\x03\x04...", ["workbook", "save the sheet as CSV"]),
}


@pytest.mark.parametrize("name", REFUSED)
def test_a_refusal_names_file_line_and_column(file, name):
    content, words = REFUSED[name]
    path = file(content)
    with pytest.raises(DesignError) as caught:
        TorqueCurve.read(path)
    for part in (str(path), *words):
        assert part in str(caught.value)


def test_points_that_may_separate_thousands_are_told(file):
    """Where semicolons separate columns and no number tells that the point is the decimal sign."""
    head, rows = "Winkel [Grad];Moment [N.mm]\n", "0;1.145\n5;1.706\n10;2.255\n15;2.795\n"
    with pytest.warns(
        UnitWarning, match="1.145 was read with a decimal point.* separate thousands, write 1145"
    ):
        curve = TorqueCurve.read(file(head + rows))
    assert curve.torque[0] == 0.001145
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for plain in (rows.replace("5;", "5.0;"), rows.replace("2.795", "0.795"), rows.replace(".", "")):
            TorqueCurve.read(file(head + plain))
        TorqueCurve.read(file((head + rows).replace(";", ",")))


def test_degrees_below_a_header_of_radians_are_told(file):
    with pytest.warns(UnitWarning, match="theta = 30 rad: this looks like degrees; 30 deg is 0.523599 rad"):
        TorqueCurve.read(file(f"theta_rad,torque_Nm\n{POINTS}"))
    rows = "".join(f"{k},{k},2\n" for k in range(30))
    with pytest.warns(UnitWarning, match=r"table.csv: theta = 29 rad: this looks like degrees"):
        read_recording(file(f"time_s,theta_rad,tau_Nm\n{rows}"))
    with pytest.warns(UnitWarning, match="psi = 30 rad: this looks like degrees"):
        Table.read(file("psi_rad,z_mm\n0,0\n10,1\n20,2\n30,3\n"), 0.02)
    friction = read_friction_table(file("v_m_s,mu\n0,.2\n9,.1\n20,.1\n"))
    assert friction.warnings == ("v = 20 m/s: this looks like mm/s; 20 mm/s is 0.02 m/s",)
    with pytest.warns(UnitWarning, match="cam1.lead_angle = 45 rad: this looks like degrees"):
        Plan.from_csv(file("cam1.lead_angle\n40\n45\n"))


# ---- recordings ----


def recording(header, row):
    return header + "\n" + "".join(row.format(k, 0.5 * k, 2 + 0.1 * k) + "\n" for k in range(25))


RECORDINGS = {
    "text column in front": recording("run,time_s,theta_deg,tau_Nm", "loading,{0}.0,{1:.1f},{2:.1f}"),
    "German": recording("Zeit [s];Winkel [Grad];Drehmoment [Ncm]", "{0};{1:.1f};{2:.1f}").replace(".", ","),
    "sep=": recording("sep=;\ntime_ms;angle_deg;torque_Nm", "{0}000;{1:.1f};{2:.1f}"),
    "row of units": recording("run,time,theta,tau\n-,s,deg,Nm", "loading,{0},{1:.1f},{2:.1f}"),
    "torque_load is no torque": recording("time_s,theta_deg,tau_Nm,torque_load_Nm", "{0},{1:.1f},{2:.1f},7"),
}


@pytest.mark.parametrize("name", RECORDINGS)
def test_recordings(file, name):
    found = read_recording(file(RECORDINGS[name]))
    factor = 0.01 if name == "German" else 1.0
    assert found.time.tolist() == list(range(25))
    assert found.theta == pytest.approx(np.radians(0.5 * np.arange(25)), rel=1e-15)
    assert found.tau == pytest.approx(factor * (2 + 0.1 * np.arange(25)), rel=1e-14)
    assert found.omega is None and found.F_ext is None


def test_names_of_the_fmu_need_no_unit(file):
    """As `dualcam simulate` writes them. Other names, as Theta, are refused without unit."""
    header = "time,theta,tau,torque_load"
    assert read_recording(file(recording(header, "{0},{1:.1f},{2:.1f},9"))).theta[24] == 12.0
    with pytest.raises(IdentificationError, match="column 'Theta': no unit"):
        read_recording(file(recording(header.replace("theta", "Theta"), "{0},{1:.1f},{2:.1f},9")))


def test_a_long_recording_is_read(file):
    """Longer than the FMU's tables may be: 600,000 lines, 17 MB."""
    lines = "".join(f"{k}.000001,{k % 50}.0000001,2.00001\n" for k in range(600_000))
    found = read_recording(file("time_s,theta_deg,tau_Nm\n" + lines))
    assert len(found) == 600_000 and found.time[-1] == 599_999.000001


def test_a_recording_with_ambiguous_commas_is_refused(file):
    text = recording("time_s,theta_deg,tau_Nm", "{0},{0},2,13")
    with pytest.raises(IdentificationError, match=f"line 2.*4 values between commas, 3 columns.*{BOTH}"):
        read_recording(file(text))


# ---- grooves ----

GROOVES = {
    "columns in any order": "z_mm,psi_deg\n0,0\n4.1,20\n8.2,45\n14,80\n",
    "text column": "point;psi [Grad];Hub [mm]\nA;0;0\nB;20;4,1\nC;45;8,2\nD;80;14\n",
    "the comma as both": "psi_deg,z_mm\n0,0,0,0\n20,0,4,1\n45,0,8,2\n80,0,14,0\n",
    "row of units": "psi;z\ndeg;mm\n0;0\n20;4,1\n45;8,2\n80;14\n",
    "preamble and other columns": "Probe 3\n\npsi_deg,z_mm,x_mm\n0,0,9\n20,4.1,9\n45,8.2,9\n80,14,9\n",
}


@pytest.mark.parametrize("name", GROOVES)
def test_grooves(file, name):
    """Millimetres are rounded once: 4.1 mm is the number 0.0041."""
    table = Table.read(file(GROOVES[name]), 0.02)
    assert table.psi == pytest.approx(np.radians([0, 20, 45, 80]), rel=1e-15)
    assert table.z.tolist() == [0.0, 0.0041, 0.0082, 0.014]


@pytest.mark.parametrize("values", [[4.1, 8.2, 0.3], [4.1, 1.7e-11, 3.3e8], [1e300]])
@pytest.mark.parametrize("factor", ["1e-3", "1e-2", "1e-6", "0.0254", "1000"])
def test_conversion_rounds_once(values, factor):
    found = in_unit(np.array(values), float(factor))
    assert found.tolist() == [float(Fraction(repr(value)) * Fraction(factor)) for value in values]


# ---- friction ----

FRICTIONS = {
    "FMU": "v_m_s,mu\n0,0.2\n0.01,0.15\n0.1,0.12\n",
    "German": "Geschwindigkeit [mm/s];Reibwert\n0;0,2\n10;0,15\n100;0,12\n",
    "percent": "# grease\nv_mm/s\tmu_%\n0\t20\n10\t15\n100\t12\n",
    "text column": "sample;v [m/s];mu [-]\nA;0;0,2\nA;0,01;0,15\nA;0,1;0,12\n",
}


@pytest.mark.parametrize("name", FRICTIONS)
def test_friction(file, name):
    table = read_friction_table(file(FRICTIONS[name]))
    assert table.by_load == [[(0.0, 0.0, 0.2), (0.01, 0.0, 0.15), (0.1, 0.0, 0.12)]]
    assert table.static_samples[1][0] == 0.2 and table.is_fmu_format == (name == "FMU")
    assert table.fmu_text() == FRICTIONS["FMU"].replace("\n0,", "\n0.0,")


def test_friction_over_the_load(file):
    text = "Last [kN];v [m/s];mu\n" + "".join(
        f"{load};{v};{mu}\n" for load, mu in ((0.1, 0.2), (0.4, 0.1)) for v in (0, 1, 2)
    )
    table = read_friction_table(file(text))
    assert [samples[0].load for samples in table.by_load] == [100.0, 400.0]
    assert table.fmu_text().splitlines()[:2] == ["v_m_s,R_N,mu", "0.0,100.0,0.2"]


def test_a_friction_table_of_a_spreadsheet_works_in_a_design(file, tmp_path):
    """The FMU itself takes the table that the design file gives it."""
    from dualcam import Fmu
    from dualcam.design_file import read_design

    file(FRICTIONS["German"])
    (tmp_path / "my.toml").write_text('[cam1]\nfriction_table = "table.csv"\n')
    design = read_design(tmp_path / "my.toml")
    assert design.mechanism().friction[0] == 0.2
    assert "columns are separated by semicolons" in design.notes[0]
    with Fmu("forward") as fmu:
        fmu.start(design.parameters)
        assert fmu.get("cam1.friction_coefficient") == 0.2


# ---- runs of a study ----

RUNS = {
    "commas": "cam1.radius,contacts\n0.02,1\n0.03,2\n",
    "semicolons": "cam1.radius;contacts\n0,02;1\n0,03;2\n",
    "as spreadsheets write it": "\ufeffcam1.radius, contacts\r\n0.02, 1\r\n\r\n0.03, 2\r\n",
    "sep= and comments": "sep=;\n# runs\ncam1.radius;contacts\n0,02;1\n# second\n0,03;2\n",
    "numpy.savetxt": "# cam1.radius contacts\n0.02 1\n0.03 2\n",
    "preamble": "designs of March\ncam1.radius\tcontacts\n0,02\t1\n0,03\t2\n",
}


@pytest.mark.parametrize("name", RUNS)
def test_runs(file, name):
    plan = Plan.from_csv(file(RUNS[name]))
    assert plan.names == ["cam1.radius", "contacts"]
    assert plan.rows(0, 2).tolist() == [[0.02, 1.0], [0.03, 2.0]]


@pytest.mark.parametrize(
    "text",
    ["cam1.lead_angle [deg];cam1.radius [mm]\n45;18,1\n", "cam1.lead_angle;cam1.radius\ndeg;mm\n45;18,1\n"],
)
def test_units_of_runs(file, tmp_path, text):
    """In a plan of an FMU, whose units are known; Plan.from_csv knows no FMU."""
    path = file(text)
    (tmp_path / "plan.toml").write_text(
        'fmu = "forward"\nresults = ["theta"]\nplan.table = "table.csv"\n[scenario]\nstop = 0.1\n'
    )
    (row,) = read_study(tmp_path / "plan.toml").plan.rows(0, 1)
    assert row.tolist() == [pytest.approx(math.pi / 4), 0.0181]
    with pytest.raises(StudyError, match=r"cam1.lead_angle.*: allowed are values in the FMU's units"):
        Plan.from_csv(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("cam1.radius,contacts\n0.02,1\nlarge,2\n", r"line 3, column 1 \(cam1.radius\): 'large'"),
        ("cam1.radius,contacts\n0.02,1,5\n", "line 2, '0.02,1,5': 3 values"),
        ("cam1.radius,cam1.radius\n1,2\n", "two columns cam1.radius"),
        ("cam1.radius\n", "0 runs"),
        ("cam1.radius\n0.02\nnan\n", r"line 3, column 1 \(cam1.radius\): 'nan'.*finite"),
        ("cam1.radius,cam2.radius\n0.02\n", r"line 2, column 2 \(cam2.radius\): no value"),
        ("", "is empty"),
        ("1,2\n", "no header"),
    ],
)
def test_runs_that_cannot_be_read(file, text, words):
    with pytest.raises(StudyError, match=words):
        Plan.from_csv(file(text))


def test_names_with_brackets_are_no_units(file):
    """FMI names such as der(x) and x[1]."""
    assert list(read_columns(file("der(x),y[1]\n1,2\n"), "table of runs")) == ["der(x)", "y[1]"]
    with pytest.raises(TableError, match="there is no table of runs"):
        read_columns(file("").with_name("no.csv"), "table of runs")
