"""Files of friction tables: what the FMU refuses and accepts, design files, export."""

import zipfile

import pytest
from driver import models
from test_friction_table import GROWING, STRIBECK, tables, write

from dualcam import Fmu, fmu_path
from dualcam.design_file import read_design
from dualcam.design_file.friction_tables import read_friction_table
from dualcam.errors import DesignError, DesignFileError
from dualcam.export import export_fmu

FORWARD, INVERSE = models["DualCamForward"], models["DualCamInverse"]
tables = tables  # a fixture

# ---- refusals ----

GOOD = "v_m_s,mu\n0,0.2\n0.01,0.15\n0.1,0.12\n"
ACCEPTED = {
    "byte order mark": "\ufeff" + GOOD,
    "CRLF": GOOD.replace("\n", "\r\n"),
    "blanks": GOOD.replace(",", " , ").replace("v_m_s , mu", "v_m_s,mu") + "\n\n",
}
REFUSED = {
    "empty": ("", ["line 1", "v_m_s,mu"]),
    "header": (GOOD.replace("v_m_s", "v"), ["line 1", '"v,mu"', '"v_m_s,mu"']),
    "decimal comma": ("v_m_s,mu\n0;0,2\n0,01;0,15\n", ["line 2", "two finite numbers", "0.01,0.12"]),
    "a third column": (GOOD.replace("0.15", "0.15,7"), ["line 3", "0.01,0.15,7"]),
    "nan": (GOOD.replace("0.15", "nan"), ["line 3", "finite"]),
    "inf": (GOOD.replace("0.1,", "inf,"), ["line 4", "finite"]),
    "first speed": (GOOD.replace("\n0,", "\n0.001,"), ["line 2", "v_m_s = 0.001", "must be 0"]),
    "speeds": (GOOD.replace("0.1,", "0.01,"), ["line 4", "v_m_s = 0.01", "> 0.01"]),
    "zero": (GOOD.replace("0.12", "0"), ["line 4", "mu = 0", "> 0", "<= 10"]),
    "negative": (GOOD.replace("0.12", "-0.1"), ["line 4", "mu = -0.1", "> 0"]),
    "large": (GOOD.replace("0.12", "11"), ["line 4", "mu = 11", "<= 10"]),
    "two points": ("v_m_s,mu\n0,0.2\n0.1,0.1\n", ["2 points", "at least 3"]),
    "too many": ("v_m_s,mu\n" + "".join(f"{k},0.1\n" for k in range(2001)), ["at most 2000"]),
    "too close": ("v_m_s,mu\n0,0.2\n1e-310,0.1\n2e-310,0.3\n", ["close"]),
}


def digits(text: str) -> str:
    return text.replace("0.01000000000000000021", "0.01").replace("0.10000000000000001", "0.1")


@pytest.mark.parametrize("name", ACCEPTED)
def test_accepted_files(make_model, tmp_path, name):
    (tmp_path / "t.csv").write_bytes(ACCEPTED[name].encode())
    fmu = make_model(FORWARD).start({"cam2.friction_table": str(tmp_path / "t.csv")})
    assert fmu.get("cam2.friction_coefficient") == 0.2


@pytest.mark.parametrize("name", REFUSED)
def test_refused_files(make_model, tmp_path, name):
    text, mentions = REFUSED[name]
    (tmp_path / "t.csv").write_text(text)
    for model in (FORWARD, INVERSE):
        fmu = make_model(model)
        message = digits(fmu.refused_start({"cam2.friction_table": str(tmp_path / "t.csv")}))
        for part in ("cam2.friction_table", "t.csv", *mentions):
            assert part in message, message
        fmu.ok("fmi2Reset")
        fmu.start()


def test_missing_files(make_model, tmp_path):
    for path, resources, mention in (
        ("none.csv", "", "must be absolute"),
        ("none.csv", tmp_path.as_uri(), "cannot be opened"),
        (str(tmp_path / "none.csv"), "", "cannot be opened"),
    ):
        fmu = make_model(FORWARD, resources=resources or None)
        assert mention in fmu.refused_start({"cam1.friction_table": path})


def test_relative_to_the_resources(make_model, tmp_path):
    write(tmp_path / "law.csv", *STRIBECK)
    fmu = make_model(FORWARD, resources=tmp_path.as_uri()).start({"cam1.friction_table": "law.csv"})
    assert fmu.get("cam1.friction_coefficient") == 0.2


@pytest.mark.parametrize("omega", [0.0, 1.0])
def test_speeds_close_to_the_least_number(make_model, tmp_path, omega):
    """The samples lie in the last octaves above zero, and the coefficient is the same at all of them."""
    (tmp_path / "t.csv").write_text("v_m_s,mu\n0,0.2\n1e-305,0.2\n2e-305,0.2\n")
    values = {"cam1.friction_table": str(tmp_path / "t.csv"), "initial.omega": omega}
    fmu = make_model(FORWARD).start(values)
    assert abs(fmu.get("cam1.friction_coefficient")) == 0.2


IMPOSSIBLE = {
    "falls without inertia": (
        FORWARD,
        STRIBECK,
        {"inertia.shaft": 0.0},
        ["cam1.friction_table", "needs an inertia", "inertia.shaft > 0"],
    ),
    "falls with an elastic shaft": (
        INVERSE,
        STRIBECK,
        {"shaft.stiffness": 50.0},
        ["cam1.friction_table", "needs an inertia", "shaft.stiffness = 0"],
    ),
    "grows without inertia": (
        FORWARD,
        GROWING,
        {"inertia.shaft": 0.0},
        ["cam1.friction_table", "needs an inertia", "inertia.shaft > 0"],
    ),
    "jams at rest": (FORWARD, ([0, 1, 2], [3, 0.1, 0.1]), {}, ["jam", "friction_table", "mu up to 3"]),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_impossible(make_model, tables, name):
    model, samples, values, mentions = IMPOSSIBLE[name]
    fmu = make_model(model)
    message = digits(fmu.refused_start(tables(samples) | values))
    for part in mentions:
        assert part in message, message


# ---- design files and export ----

DESIGN = """
title = "Grease"
[cam1]
friction_table = "law.csv"
[cam2]
friction = 0.1
friction_table = "law.csv"
[scenario]
stop = 0.1
inputs.tau = {time = [0, 0.05, 0.1], value = [0, 9, 0]}
"""


@pytest.fixture
def design(tmp_path):
    write(tmp_path / "law.csv", *STRIBECK)
    (tmp_path / "my.toml").write_text(DESIGN)
    return tmp_path / "my.toml"


def test_design_file(design):
    read = read_design(design)
    assert read.parameters["cam1.friction_table"] == str(design.parent / "law.csv")
    assert [w.key for w in read.warnings] == ["cam2.friction"]
    assert read.mechanism().friction == (0.2, 0.2)
    assert "cam2.friction_table" in read.friction_note()
    (design.parent / "law.csv").write_text("v_m_s,mu\n0,0.2\n0.1,-1\n0.2,0.1\n")
    with pytest.raises(DesignFileError, match=r"friction_table.*law.csv.*line 3: mu = -1 must be > 0"):
        read_design(design)
    (design.parent / "law.csv").unlink()
    with pytest.raises(DesignFileError, match=r"friction_table.*no friction table .*law.csv"):
        read_design(design)


@pytest.mark.parametrize("fmi", [2, 3])
def test_export(design, tmp_path, fmi):
    """The exported FMU has both tables inside and gives the same motion, bit for bit."""
    made = export_fmu(read_design(design), tmp_path / "My.fmu", fmi=fmi)
    with zipfile.ZipFile(made) as archive:
        files = {n: archive.read(f"resources/{n}") for n in ("cam1_friction.csv", "cam2_friction.csv")}
    assert set(files.values()) == {(tmp_path / "law.csv").read_bytes()}
    (tmp_path / "law.csv").rename(tmp_path / "other.csv")
    table = {f"cam{i}.friction_table": str(tmp_path / "other.csv") for i in (1, 2)}
    with Fmu(made) as exported, Fmu(fmu_path("forward", fmi=fmi)) as fmu:
        exported.start()
        fmu.start(table)
        for one in (exported, fmu):
            one.set("tau", 9.0)
            one.step(0.05)
        assert exported.get("cam1.friction_table") == "cam1_friction.csv"
        for name in ("theta", "cam2.friction_coefficient", "energy.heat_cam1"):
            assert exported.real(name) == fmu.real(name)
        assert exported.real("theta") > 0


FOR_THE_FMU_ALONE = ("too close", "a third column", "decimal comma")  # a design file may have decimal commas


@pytest.mark.parametrize("name", [name for name in REFUSED if name not in FOR_THE_FMU_ALONE])
def test_design_files_refuse_what_the_fmu_refuses(tmp_path, name):
    text, mentions = REFUSED[name]
    (tmp_path / "t.csv").write_text(text)
    with pytest.raises(DesignError) as refused:
        read_friction_table(tmp_path / "t.csv")
    assert mentions[0].removeprefix("at most ") in str(refused.value)
