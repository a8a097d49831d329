"""All commands judge the design first, and what `dualcam check` calls good, every command can do."""

import json
from pathlib import Path

import pytest

import dualcam
from dualcam.cli import main

STUDY = """
[study]
results = ["z"]
[study.plan]
kind = "grid"
vary."cam1.friction" = { values = [0.12, 0.14] }
"""
# Command -> its words after the design file, and what it writes.
COMMANDS = {
    "band": (["--plot", "out.svg"], "out.svg"),
    "simulate": (["-o", "out.csv"], "out.csv"),
    "export": (["-o", "Out.fmu"], "Out.fmu"),
    "view": (["-o", "out.html"], "out.html"),
    "report": (["-o", "out.html"], "out.html"),
    "ssp": (["-o", "out.ssp"], "out.ssp"),
    "design": (["--export", "out.dxf"], "out_cam1.dxf"),
    "study": (["--workers", "0", "--format", "csv"], "study_results"),
}
REFUSED = {
    "a spring that pulls": (
        'preload = "50 N"',
        "preload = -80",
        "spring force at theta = 0 deg is -80 N: allowed is > 0",
    ),
    "a spring at its solid length": (
        "[spring]",
        '[spring]\nfree_length = "40 mm"\nsolid_length = "30 mm"',
        "spring at solid length: at stop.upper = 1.39626 rad its deflection is preload/stiffness + z ="
        " 14.96 mm",
    ),
    "stops beyond a table": (
        'profile = "helix"',
        'profile = "table"\ntable = "short.csv"',
        "stop.upper: groove 1 ends",
    ),
}


@pytest.fixture
def design(tmp_path, monkeypatch):
    """A design with all sections that commands need."""
    monkeypatch.chdir(tmp_path)
    assert main(["new", "my.toml", "--from", "minimal"]) == 0
    Path("short.csv").write_text("psi_rad,z_m\n0,0\n0.1,0.002\n0.2,0.004\n0.3,0.006\n", encoding="utf-8")
    path = tmp_path / "my.toml"
    path.write_text(path.read_text(encoding="utf-8") + STUDY, encoding="utf-8")
    return path


def changed(design, old, new):
    text = design.read_text(encoding="utf-8")
    assert old in text, text
    design.write_text(text.replace(old, new, 1), encoding="utf-8")


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("case", REFUSED)
def test_a_design_that_check_refuses_is_refused_by_each_command(design, capsys, case, command):
    old, new, words = REFUSED[case]
    changed(design, old, new)
    more, written = COMMANDS[command]
    capsys.readouterr()
    assert main([command, "my.toml", *more]) == 1
    said = capsys.readouterr()
    lines = [line for line in said.err.splitlines() if not line.startswith("dualcam: warning:")]
    assert lines[0].startswith("dualcam: my.toml: 1 error")
    assert words in said.err and "--anyway" in said.err and said.out == ""
    assert not Path(written).exists()


def test_the_functions_go_on_with_a_design_that_does_not_work(design):
    """As docs/command-line.md says; `check_design` tells."""
    changed(design, 'preload = "50 N"', "preload = -80")
    assert not dualcam.check_design(design).good
    assert dualcam.simulate(design)["time"][-1] == 2.0
    for make, name in (
        (dualcam.export_fmu, "Out.fmu"),
        (dualcam.export_ssp, "out.ssp"),
        (dualcam.write_report, "report.html"),
        (dualcam.write_view, "view.html"),
    ):
        make(design, name)
        assert Path(name).exists()


def test_anyway_promises_of_a_jam_what_it_does(design, capsys):
    changed(design, "friction = 0.14", "friction = 1.1")
    changed(design, "friction = 0.14", "friction = 0.99")
    capsys.readouterr()
    assert main(["export", "my.toml", "-o", "Out.fmu"]) == 1
    assert "--anyway goes on with this design in commands that do not start" in capsys.readouterr().err
    assert main(["export", "my.toml", "-o", "Out.fmu", "--anyway"]) == 1
    assert "the contacts jam" in capsys.readouterr().err and not Path("Out.fmu").exists()
    for command in ("band", "report"):
        more, written = COMMANDS[command]
        assert main([command, "my.toml", *more, "--anyway"]) == 0 and Path(written).exists()


@pytest.mark.parametrize("command", COMMANDS)
def test_anyway_goes_on_and_says_so_first(design, capsys, command):
    changed(design, 'preload = "50 N"', "preload = -80")
    more, written = COMMANDS[command]
    capsys.readouterr()
    assert main([command, "my.toml", *more, "--anyway"]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("my.toml: 1 error; --anyway goes on\n  line ")
    assert "spring force at theta = 0 deg is -80 N" in said.out
    assert Path(written).exists()


def test_json_stands_alone_where_a_command_goes_on_anyway(design, capsys):
    changed(design, 'preload = "50 N"', "preload = -80")
    capsys.readouterr()
    assert main(["ssp", "my.toml", "-o", "out.ssp", "--anyway", "--json"]) == 0
    said = capsys.readouterr()
    assert json.loads(said.out)["ssp"] == "out.ssp" and "--anyway goes on" in said.err


@pytest.mark.parametrize("command", COMMANDS)
def test_a_warning_is_said_once_on_the_error_output(design, capsys, command):
    """A value that looks like another unit, and a parameter that the model of the scenario does not have."""
    changed(design, 'stiffness = "50 N/mm"', "stiffness = 50")
    changed(design, "[study]", "[shaft]\nstiffness = 100.0\n[study]")
    more, written = COMMANDS[command]
    capsys.readouterr()
    assert main([command, "my.toml", *more]) == 0
    said = capsys.readouterr()
    for words in ("this looks like N/mm; 50 N/mm is 50000 N/m", "shaft.stiffness = 100.0 is not used"):
        assert said.err.count(words) == 1 and words not in said.out
    assert Path(written).exists()


# ---- what `dualcam check` refuses, because a command could not do it ----


@pytest.mark.parametrize(
    "text, words",
    [
        (
            "scenario = {stop = 1.0, output_interval = 0}",
            "scenario.output_interval = 0.0 s: allowed is a finite number above 0",
        ),
        (
            "scenario = {stop = 1.0, output_interval = 1e-9}",
            "scenario.output_interval = 1e-09 s gives 1e+09 samples: allowed are up to 2,000,000",
        ),
        (
            'title = "D:\\bench\\front"',
            'title = "D:\\bench\\front": allowed is text without control characters',
        ),
    ],
)
def test_what_a_command_cannot_do_is_refused_by_check(tmp_path, capsys, text, words):
    path = tmp_path / "my.toml"
    path.write_text(f"{text}\n", encoding="utf-8")
    assert main(["check", str(path)]) == 1
    assert f"line 1: {words}" in capsys.readouterr().err


def test_check_says_of_an_empty_file_that_all_values_are_defaults(tmp_path, capsys):
    path = tmp_path / "empty.toml"
    path.write_text("", encoding="utf-8")
    assert main(["check", str(path)]) == 0
    said = capsys.readouterr().out
    assert "! warning: no parameter is given: every value is the default of the FMU" in said
    assert said.splitlines()[-1].endswith("the design works, the FMU starts, 2 warnings.")


def test_a_motion_away_from_zero_is_good_for_every_command(tmp_path, monkeypatch):
    """The forward model of the page then starts at the nearest stop."""
    monkeypatch.chdir(tmp_path)
    motion = "inputs.theta = {time = [0.0, 1.0], value = [0.6, 1.0]}"
    Path("my.toml").write_text(f"stop.lower = 0.5\n[scenario]\nstop = 1.0\n{motion}\n", encoding="utf-8")
    for command in ("check", *COMMANDS):
        more, _ = COMMANDS.get(command, ([], ""))
        if command not in ("study", "design"):  # which need a section of their own
            assert main([command, "my.toml", *more]) == 0, command


@pytest.mark.parametrize(
    "old, new",
    [
        ('title = "', 'title = "\u00fc <&> \u8bbe\u8ba1 \'" #"'),
        ("contacts = 2", "contacts = 1"),
        ("output_interval = 0.005", "output_interval = 1e300"),
        ("[scenario]", "[scenario]\nstep = 1e-2\ntolerance = 1e-6"),
    ],
)
def test_what_check_calls_good_every_command_can_do(design, capsys, old, new):
    text = design.read_text(encoding="utf-8")
    design.write_text(text.replace(old, new, 1) if old in text else f"{new}\n{text}", encoding="utf-8")
    assert main(["check", "my.toml"]) == 0
    for command, (more, written) in COMMANDS.items():
        assert main([command, "my.toml", *more]) == 0, (command, capsys.readouterr().err)
        assert Path(written).exists()
