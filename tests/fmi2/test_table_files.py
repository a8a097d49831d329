"""FMI 2.0: files of groove tables."""

import os
from pathlib import Path

import pytest
from fmi2_inputs import drive, run


def write_table(path, slope=0.02, last=2.0):
    """A straight groove, sampled."""
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = [f"{psi},{slope * psi}" for psi in (k * last / 20 for k in range(21))]
    path.write_text("\n".join(["psi_rad,z_m", *rows]) + "\n")


TABLE = {"cam1.profile": 3, "cam1.table": "groove.csv"}


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """With tables under names that a URI can hold in several ways; the working directory is elsewhere."""
    for name in ("res", "with blank", "50% ä", "C:/res", "%zz"):
        write_table(tmp_path / name / "groove.csv")
    monkeypatch.chdir(tmp_path)
    return str(tmp_path)


@pytest.mark.parametrize(
    "location",
    [
        "file://{}/res",
        "file://{}/res/",
        "file://{}/res///",
        "file:///{}/res",
        "file:{}/res",
        "file:{}/res/",
        "file://localhost{}/res",
        "FILE://LOCALHOST{}/res",
        "file://{}/%72es",
        "file://{}/with%20blank",
        "file://{}/with blank",
        "file://{}/50%25%20%C3%A4",
        "file://{}/50%25%20%c3%a4/",
        "file://{}/50% ä",
        "file:///C:/res",
        "file:/C:/res/",
        "file:///C%3A/res",
        "file://{}/%zz",  # no code: the percent sign alone stays
        "file:///.{}/res",
    ],
)
def test_tables_relative_to_the_resources(make, folder, location):
    fmu = make(resources=location.format(folder)).start(TABLE | {"stop.upper": 1.3})
    fmu.step(0.1, **drive(fmu, 1.0))
    assert fmu.get("spring.force") > 50.0


@pytest.mark.parametrize(
    "location",
    [
        *(None, "", "{}/res", "res", "http://localhost{}/res"),
        *("file://elsewhere{}/res", "file:res", "file://res", "file:"),
    ],
)
def test_without_resources_a_relative_table_is_refused(make, folder, location):
    fmu = make(resources=location and location.format(folder))
    text = fmu.refused_start(TABLE)
    assert "cam1.table" in text and "groove.csv" in text
    fmu.set({"cam1.table": f"{folder}/res/groove.csv"})
    fmu.ok("fmi2ExitInitializationMode")


@pytest.mark.parametrize("content", ["", "psi_rad,z_m\n0,0\n", "psi_rad,z_m\n0,0\n1,0.02\n2,0.01\n3,0.03\n"])
def test_refuses_bad_tables(make, tmp_path, content):
    (tmp_path / "groove.csv").write_text(content)
    fmu = make(resources=f"file://{tmp_path}")
    assert "cam1.table" in fmu.refused_start(TABLE)


@pytest.mark.parametrize("make_path", [os.mkdir, os.mkfifo])
def test_refuses_what_is_no_file(make, tmp_path, make_path):
    """To open a pipe would wait for a writer."""
    make_path(tmp_path / "groove.csv")
    fmu = make(resources=f"file://{tmp_path}")
    assert "cam1.table" in fmu.refused_start(TABLE)


def test_a_state_needs_its_table(make, folder):
    fmu = make(resources=f"file://{folder}/res").start(TABLE)
    fmu.step(0.1, **drive(fmu, 1.0))
    state = fmu.take()
    content = fmu.to_bytes(state)
    (Path(folder) / "res" / "groove.csv").unlink()
    first = run(fmu, 4)
    fmu.restore(state)  # has read it
    fmu.time = 0.1
    assert run(fmu, 4) == first
    other = make(resources=f"file://{folder}/res")
    _, state_there = other.try_from_bytes(content)
    other.refused("fmi2SetFMUstate", state_there, mentions=("cam1.table",))
    other.start().step(0.1, **drive(other, 0.3))
    other.refused("fmi2SetFMUstate", state_there, mentions=("cam1.table",))
    other.step(0.1, **drive(other, 0.4))
    write_table(Path(folder) / "res" / "groove.csv")
    other.restore(state_there)
    other.time = 0.1
    assert run(other, 4) == first
    for driver, held in ((fmu, state), (other, state_there)):
        driver.free_state(held)


def test_reset_reads_the_table_again(make, folder):
    fmu = make(resources=f"file://{folder}/res").start(TABLE)
    (Path(folder) / "res" / "groove.csv").unlink()
    fmu.ok("fmi2Reset")
    assert "cam1.table" in fmu.refused_start(TABLE)


def test_a_table_relative_to_the_root(make, folder):
    """The slash of the root is no last slash to drop."""
    make(resources="file:///").start(
        TABLE | {"cam1.table": f"{folder[1:]}/res/groove.csv", "stop.upper": 1.3}
    )


@pytest.mark.parametrize("location", ["file:///C:/", "file:///~nowhere", "file:///1/nowhere"])
def test_resources_that_are_no_folder_are_named(make, location):
    fmu = make(resources=location)
    assert "groove.csv" in fmu.refused_start(TABLE)


@pytest.mark.parametrize("path", ["a" + "ä" * 200, "ä" * 200, b"\x80" * 200], ids=["odd", "even", "no text"])
def test_a_long_path_is_cut_between_characters(make, path):
    """A message shows "?" for each byte that is no plain text: an ä has two."""
    fmu = make()
    values = TABLE | {"cam1.table": path}
    for name, value in values.items():
        assert fmu.try_set({name: value}) == 0
    quoted = fmu.refused_start().split('"')[1]
    assert len(quoted) <= 120
    assert quoted.strip("a?") == "" and quoted.count("?") % 2 == 0


def test_a_byte_that_no_terminal_shows_is_no_part_of_a_message(make):
    fmu = make()
    assert '"a?b.csv"' in fmu.refused_start(TABLE | {"cam1.table": "a\x7fb.csv"})


def test_a_table_without_its_origin_is_refused(make, tmp_path):
    """z counts from psi = 0."""
    for psi in ((-2.0, -1.5, -1.0, -0.5), (0.5, 1.0, 1.5, 2.0)):
        rows = [f"{x},{0.02 * x}" for x in psi]
        (tmp_path / "groove.csv").write_text("\n".join(["psi_rad,z_m", *rows]))
        fmu = make(resources=f"file://{tmp_path}")
        assert "must include 0" in fmu.refused_start(TABLE)
