"""The command line, as a stranger uses it: files in, files and text out, exit codes."""

import csv
import json
import math
import os
import re
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from driver import ROOT
from equal_radii import write_equal_radii
from fmpy.validation import validate_fmu
from lxml import etree

from dualcam import Fmu, export_ssp, fmu_path, read_design
from dualcam.cli import main
from dualcam.cli.commands import COMMANDS
from dualcam.cli.new import TEMPLATES
from dualcam.cli.output import say_where_it_runs
from dualcam.errors import DesignError
from dualcam.fmi.binary import binary_folders

SCHEMAS = Path(fmpy.__file__).parent / "ssp/schema"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder, the working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def design(folder):
    assert main(["new", "my.toml", "--from", "minimal"]) == 0
    return folder / "my.toml"


@pytest.fixture
def equal(folder):
    """The design with equal radii, as equal grooves need them."""
    return write_equal_radii(folder / "my.toml")


def spoken(capsys, *words, code=0):
    """What a command prints; its exit code is `code`."""
    capsys.readouterr()
    assert main(list(words)) == code
    return capsys.readouterr()


def answer(capsys, *words, code=0):
    """What a command prints with --json."""
    return json.loads(spoken(capsys, *words, "--json", code=code).out)


# ---- help, wrong use ----


@pytest.mark.parametrize("command", COMMANDS)
def test_each_command_shows_an_example(capsys, command):
    text = spoken(capsys, command, "--help").out
    assert "Example:" in text and f"dualcam {command}" in text


def test_help_lists_all_commands_and_loads_none(capsys):
    assert all(command in spoken(capsys, "--help").out for command in COMMANDS)
    program = (
        "import sys; from dualcam.cli import main; main(['--help']);"
        "heavy = {'numpy', 'matplotlib', 'rich', 'pydantic', 'pint', 'control'} & set(sys.modules);"
        "sys.exit(f'{heavy} loaded' if heavy else 0)"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize(
    "words, mention",
    [
        (["chek", "my.toml"], "Did you mean 'check'?"),
        (["check"], "DESIGN.toml"),
        (["export", "my.toml"], "--output"),
        (["export", "my.toml", "-o", "a.fmu", "--fmi", "1"], "'2', '3'"),
        (["new", "my.toml", "--from", "bike"], "robot"),
        (["band", "my.toml", "--points", "1"], "--points"),
        (["simulate", "my.toml", "-o", "a.csv", "--speed", "3"], "--speed"),
        (["info", "MyCam.fmu", "--fmi", "3"], "a file says its version itself"),
    ],
)
def test_wrong_use_has_exit_code_2_and_says_what_is_allowed(folder, capsys, words, mention):
    assert mention in spoken(capsys, *words, code=2).err


@pytest.mark.parametrize("command", ["check", "band", "simulate", "export", "report", "ssp"])
def test_a_missing_design_is_named(folder, capsys, command):
    ends = {"simulate": "csv", "export": "fmu", "report": "html", "ssp": "ssp"}
    output = ["-o", f"out.{ends[command]}"] if command in ends else []
    assert "absent.toml" in spoken(capsys, command, "absent.toml", *output, code=1).err
    assert "absent.toml" in answer(capsys, command, "absent.toml", *output, code=1)["error"]
    assert not list(folder.iterdir())


@pytest.mark.parametrize(
    "command, name", [("simulate", "out.csv"), ("export", "A.fmu"), ("report", "r.html")]
)
def test_a_missing_folder_of_the_output_is_named_before_the_work(design, capsys, command, name):
    said = spoken(capsys, command, "my.toml", "-o", f"no/such/{name}", code=1).err
    assert "does not exist" in said and "no/such" in said


def test_new_replaces_a_file_only_when_told(design, capsys):
    design.write_text("mine", encoding="utf-8")
    assert "--force" in spoken(capsys, "new", "my.toml", code=1).err
    assert design.read_text(encoding="utf-8") == "mine"
    spoken(capsys, "new", "my.toml", "--force")
    assert tomllib.loads(design.read_text(encoding="utf-8"))


# ---- from a template to an FMU ----


def test_what_a_user_wrote_is_kept(equal, capsys):
    """A design file and its tables; a result is replaced."""
    Path("groove.csv").write_text("psi_rad,z_m\n0,0\n0.3,0.006\n0.6,0.012\n0.8,0.016\n", encoding="utf-8")
    text = equal.read_text(encoding="utf-8").replace('"helix"', '"table"\ntable = "groove.csv"', 1)
    equal.write_text(text.replace('lead_angle = "45 deg"', "", 1), encoding="utf-8")
    kept = {path: path.read_bytes() for path in Path().iterdir()}
    for words in (["simulate", "my.toml", "-o", "./groove.csv"], ["band", "my.toml", "-o", "my.toml"]):
        assert "belongs to the design my.toml" in spoken(capsys, *words, code=1).err
    Path("fitted.toml").touch()
    assert "--force" in spoken(capsys, "identify", "no.csv", "my.toml", "-o", "fitted.toml", code=1).err
    Path("fitted.toml").unlink()
    assert {path: path.read_bytes() for path in Path().iterdir()} == kept
    for words in ("band my.toml -o out.csv", "simulate my.toml -o run.csv"):
        for _ in range(2):
            spoken(capsys, *words.split())
    torque = "theta_deg,torque_Nm\n0,1\n20,3\n50,6\n80,9\n"
    Path("torque.csv").write_text(torque, encoding="utf-8")
    words = ("--torque", "torque.csv", "-o", "torque.csv", "--force")
    assert "is read by this command" in spoken(capsys, "design", "my.toml", *words, code=1).err
    for command in ("band", "simulate"):
        said = spoken(capsys, command, "my.toml", "-o", "torque.csv", code=1).err
        assert "torque.csv exists, and its first line is not that of this result" in said
    assert Path("torque.csv").read_text(encoding="utf-8") == torque
    spoken(capsys, "design", "my.toml", "--torque", "5", "-o", "groove.csv", "--force")  # an old groove


@pytest.mark.filterwarnings("always::dualcam.errors.UnitWarning")
def test_a_torque_with_a_doubtful_unit_is_told_in_the_last_line(equal, capsys):
    Path("torque.csv").write_text("theta_rad,torque_Nm\n0,5\n20,5\n50,5\n80,5\n", encoding="utf-8")
    said = spoken(capsys, "design", "my.toml", "--torque", "torque.csv", "-o", "g.csv").out
    last = "But first clear up this warning: torque.csv: theta = 80 rad: this looks like degrees"
    assert said.splitlines()[-1].startswith(last)


def test_a_stop_below_0_is_refused_before_the_groove(design, capsys):
    text = design.read_text(encoding="utf-8")
    design.write_text(text.replace('lower = "0 deg"', 'lower = "-10 deg"'), encoding="utf-8")
    said = spoken(capsys, "design", "my.toml", "--torque", "5", "-o", "g.csv", code=1).err
    assert "stop.lower = -0.174533 rad: allowed is 0 or more" in said and not Path("g.csv").exists()


@pytest.mark.parametrize("template", TEMPLATES)
def test_each_template_is_checked_simulated_and_exported(folder, capsys, template):
    spoken(capsys, "new", "my.toml", "--from", template)
    verdict = answer(capsys, "check", "my.toml")
    assert verdict["good"] and not [f for f in verdict["findings"] if f["severity"] == "error"]
    assert "the design works" in spoken(capsys, "check", "my.toml").out
    spoken(capsys, "simulate", "my.toml", "-o", "out.csv", "--plot", "out.png")
    assert (folder / "out.png").read_bytes().startswith(b"\x89PNG")
    with (folder / "out.csv").open(encoding="utf-8") as file:
        rows = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    work = max(abs(row["energy.work_in"]) for row in rows) or max(row["energy.spring"] for row in rows)
    assert work > 0.0
    assert max(abs(row["energy.residual"]) for row in rows) <= 1e-6 * work  # the FMU's tolerance is 1e-9
    spoken(capsys, "export", "my.toml", "-o", "MyCam.fmu")
    assert not validate_fmu("MyCam.fmu")
    found = answer(capsys, "simulate", "my.toml", "-o", "again.csv", "--fmu", "MyCam.fmu")
    assert (folder / "again.csv").read_text(encoding="utf-8") == (folder / "out.csv").read_text(
        encoding="utf-8"
    )
    assert found["samples"] == len(rows)


def test_an_exported_fmu_has_the_name_of_its_file_and_the_values_of_the_design(design, capsys):
    design.write_text(
        design.read_text(encoding="utf-8").replace("friction = 0.14", "friction = 0.07", 1), encoding="utf-8"
    )
    for fmi in ("2", "3"):
        said = spoken(capsys, "export", "my.toml", "-o", f"My{fmi}.fmu", "--fmi", fmi).out
        info = answer(capsys, "info", f"My{fmi}.fmu")
        assert ("only for " in said) == (len(info["platforms"]) == 1)
        assert (info["model"], info["fmi"][0]) == (f"My{fmi}", fmi)
        start = {variable["name"]: variable["start"] for variable in info["variables"]}
        assert start["cam1.friction"] == 0.07
        with Fmu(f"My{fmi}.fmu") as fmu:
            fmu.start()
            assert fmu.real("cam1.friction") == 0.07


@pytest.mark.parametrize("fmi", [2, 3])
def test_an_fmu_for_this_machine_alone_is_called_so(folder, capsys, fmi):
    own = binary_folders(fmi)[0]
    for folders in ([own], [own, "x86-beos"]):
        with zipfile.ZipFile("part.fmu", "w") as part:
            for name in folders:
                part.writestr(f"binaries/{name}/Part.so", b"")
        capsys.readouterr()
        say_where_it_runs(Path("part.fmu"))
        said = capsys.readouterr().out
        assert (f"only for {own}: " in said and "./build.sh run all" in said) == (len(folders) == 1)


def test_a_simulation_is_that_of_another_master(design, capsys):
    """FMPy, which knows nothing of design files, plays the same torque through the FMU with 0.1 ms steps."""
    text = design.read_text(encoding="utf-8")
    torque = "inputs.tau = { time = [0.0, 0.2], value = [0.0, 6.0] }"
    scenario = f"[scenario]\nstop = 0.4\noutput_interval = 0.01\n{torque}\n"
    design.write_text(text.partition("[scenario]")[0] + scenario, encoding="utf-8")
    spoken(capsys, "simulate", "my.toml", "-o", "out.csv", "--variables", "theta,omega,tau,mode")
    found = np.genfromtxt("out.csv", delimiter=",", names=True)
    spoken(capsys, "export", "my.toml", "-o", "MyCam.fmu")
    signal = np.array([(0.0, 0.0), (0.2, 6.0), (0.4, 6.0)], dtype=[("time", float), ("tau", float)])
    other = fmpy.simulate_fmu(
        "MyCam.fmu", stop_time=0.4, output_interval=1e-4, input=signal, output=["theta"]
    )
    assert len(found) == 41
    assert np.max(found["theta"]) > 0.1
    # FMPy holds the torque over each step of 0.1 ms: the torque, and so the motion, lags by at most a step
    lag = np.max(np.abs(found["theta"] - other["theta"][::100]))
    assert lag <= 1e-4 * np.max(found["omega"])
    coarse = spoken(capsys, "simulate", "my.toml", "-o", "one.csv", "--variables", "theta").out
    assert "41 samples of 2 columns" in coarse


def test_samples_do_not_depend_on_the_output_interval(design, capsys):
    text = design.read_text(encoding="utf-8").partition("[scenario]")[0]
    columns = {}
    for interval in (0.1, 0.001):
        design.write_text(
            f"{text}[scenario]\nstop = 0.5\noutput_interval = {interval}\n"
            "[scenario.inputs]\ntau = { time = [0.0, 0.3, 0.3], value = [8.0, 8.0, 0.0] }\n",
            encoding="utf-8",
        )
        spoken(capsys, "simulate", "my.toml", "-o", "out.csv")
        columns[interval] = np.genfromtxt("out.csv", delimiter=",", names=True)
    fine = columns[0.001][::100]
    assert np.allclose(columns[0.1]["theta"], fine["theta"], rtol=0.0, atol=1e-11)
    assert np.allclose(columns[0.1]["energyheat_cam1"], fine["energyheat_cam1"], rtol=0.0, atol=1e-10)


# ---- the other commands ----


def test_band_is_that_of_the_fmu(design, capsys):
    found = answer(capsys, "band", "my.toml", "--points", "5", "--plot", "band.svg")
    columns = found["columns"]
    assert not found["self_locking"]
    with Fmu("forward") as fmu:
        for k, theta in enumerate(columns["theta_rad"]):
            start = tomllib.loads(design.read_text(encoding="utf-8"))
            given = {
                f"{group}.{key}": value
                for group in ("cam1", "cam2", "spring", "stop")
                for key, value in start.get(group, {}).items()
                if isinstance(value, float | int)
            }
            fmu.start({**given, "initial.theta": theta})
            for name, column in (("torque_release", "release_N.m"), ("torque_load", "load_N.m")):
                assert fmu.real(name) == pytest.approx(columns[column][k], rel=1e-11)
    assert "Not self-locking" in spoken(capsys, "band", "my.toml", "-o", "band.csv").out
    assert Path("band.csv").read_text(encoding="utf-8").startswith("theta_deg,")


def test_a_self_locking_design_is_called_so(design, capsys):
    text = design.read_text(encoding="utf-8").replace("friction = 0.14", "friction = 1.2", 1)
    design.write_text(text, encoding="utf-8")
    assert (
        "Self-locking from theta = 0 to 80 deg: there the spring"
        in spoken(capsys, "band", "my.toml", "--anyway").out
    )


def test_each_locked_range_is_named(design, capsys):
    """Cam 1 is level at both ends. Its contact locks where dz/dpsi <= mu r, cam 2 nowhere."""
    design.write_text(
        """\
cam1 = {radius = 0.02, profile = "cycloid", cycloid_rise = 0.02, cycloid_angle = 1.0, friction = 0.1}
cam2 = {radius = 0.03, profile = "helix", lead_angle = "45 deg", friction = 0.1}
spring = {preload = "50 N", stiffness = "50 N/mm"}
stop.upper = 1.6
limits = {self_locking = true, lead_angle = ["0 deg", "80 deg"]}
scenario = {stop = 0.1, inputs.tau = {time = [0, 0.1], value = [0, 1]}}
"""
    )
    psi = math.acos(1 - 0.1 * 0.02 / 0.02) / (2 * math.pi)  # rad, of cam 1
    ends = [at + 0.02 * (at - math.sin(2 * math.pi * at) / (2 * math.pi)) / 0.03 for at in (psi, 1 - psi)]
    first, last, stop = (math.degrees(theta) for theta in (*ends, 1.6))
    found = answer(capsys, "check", "my.toml")["numbers"]
    assert found["self_locking"]
    (begin, low), (high, end) = np.degrees(found["locked"])
    assert (begin, end) == (0.0, pytest.approx(stop))
    assert (low, high) == (pytest.approx(first, abs=0.02), pytest.approx(last, abs=0.02))
    spoken(capsys, "report", "my.toml", "-o", "my.html")
    for text in (
        spoken(capsys, "band", "my.toml").out,
        spoken(capsys, "check", "my.toml").out,
        Path("my.html").read_text(encoding="utf-8"),
    ):
        ranges = re.search(r"from theta = 0 to (.*) deg and from (.*) to (.*) deg: there the spring", text)
        assert [float(number) for number in ranges.groups()] == pytest.approx([first, last, stop], abs=0.03)


@pytest.mark.parametrize("fmu", ["forward", "inverse"])
def test_info_lists_all_variables(capsys, fmu):
    found = answer(capsys, "info", fmu)
    with Fmu(fmu) as handle:
        assert [variable["name"] for variable in found["variables"]] == handle.names
    assert "spring.preload" in spoken(capsys, "info", fmu, "--variables", "spring").out
    assert answer(capsys, "info", fmu, "--fmi", "3")["fmi"].startswith("3.")


@pytest.mark.parametrize("fmu", ["forward", "inverse"])
def test_info_is_a_page_and_all_is_the_rest(capsys, fmu):
    page = spoken(capsys, "info", fmu).out
    assert len(page.splitlines()) < 100
    assert "cam1.radius = 0.02 m" in page and "Radius of cam 1" not in page
    assert "Axial force on the follower" in page  # inputs and outputs have their descriptions
    assert "--all: each variable with" in page
    everything = spoken(capsys, "info", fmu, "--all").out
    assert "Radius of cam 1" in everything and "--all" not in everything
    names = [variable["name"] for variable in answer(capsys, "info", fmu)["variables"]]
    assert all(name in page for name in names)


def test_info_says_when_no_variable_is_found(capsys):
    text = spoken(capsys, "info", "--variables", "xxxx", code=1).err
    assert "DualCamForward has no variable with 'xxxx' in its name" in text
    assert "did you mean spring.preload" in spoken(capsys, "info", "--variables", "spring.prelod", code=1).err
    assert "xxxx" in answer(capsys, "info", "--variables", "xxxx", code=1)["error"]


@pytest.mark.parametrize("fmi", ["2", "3"])
def test_info_has_platforms_and_default_experiment(capsys, fmi):
    """As the archive and another reader of the description say."""
    found = answer(capsys, "info", "--fmi", fmi)
    with zipfile.ZipFile(found["file"]) as archive:
        folders = {name.split("/")[1] for name in archive.namelist() if name.startswith("binaries/")}
    assert set(found["platforms"]) == folders and found["warnings"] == []
    expected = fmpy.read_model_description(found["file"]).defaultExperiment
    read = found["default_experiment"]
    given = [read[name] for name in ("start_time", "stop_time", "step_size", "tolerance")]
    names = ("startTime", "stopTime", "stepSize", "tolerance")
    texts = [getattr(expected, name) for name in names]
    assert given == [None if text is None else float(text) for text in texts]
    text = spoken(capsys, "info", "--fmi", fmi).out
    assert all(folder in text for folder in folders) and f"stop {float(expected.stopTime):g} s" in text


@pytest.mark.parametrize("fmi", ["2", "3"])
def test_info_warns_of_start_values_that_were_edited(design, capsys, fmi):
    """The warning has the value with which the FMU starts."""
    (design.parent / "g.csv").write_text("psi_rad,z_m\n0,0\n0.5,0.01\n1,0.02\n1.5,0.03\n")
    design.write_text(
        design.read_text().replace('profile = "helix"', 'profile = "table"\ntable = "g.csv"', 1)
    )
    spoken(capsys, "export", "my.toml", "-o", "MyCam.fmu", "--fmi", fmi)
    assert answer(capsys, "info", "MyCam.fmu")["warnings"] == []
    changes = {"spring.preload": "77.5", "contacts": "1", "ledger": "false", "cam1.table": "other.csv"}
    edit_start_values("MyCam.fmu", "Edited.fmu", changes)
    found = answer(capsys, "info", "Edited.fmu")["warnings"]
    with Fmu("Edited.fmu") as fmu:
        fmu.start()
        expected = {name: fmu.get(name) for name in changes}
    assert expected["spring.preload"] == 50.0 and expected["cam1.table"] == "cam1.csv"
    assert len(found) == len(changes)
    for name, value in expected.items():
        (text,) = [text for text in found if text.startswith(f"{name}: ")]
        assert changes[name] in text.lower() and f"starts from {value!r}" in text
    said = spoken(capsys, "info", "Edited.fmu")
    words = "warning: spring.preload: modelDescription.xml says 77.5"
    assert words in said.err and words not in said.out


def edit_start_values(source, target, values):
    """A copy of an FMU with other start values in the XML alone."""
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == "modelDescription.xml":
                root = etree.fromstring(content)
                for variable, value in values.items():
                    (element,) = root.xpath("//*[@name=$name and @causality]", name=variable)
                    nodes = [element, *element.iter()]
                    (node,) = {node for node in nodes if "start" in node.attrib or node.tag == "Start"}
                    node.set("value" if node.tag == "Start" else "start", value)
                content = etree.tostring(root)
            new.writestr(name, content)


def test_info_of_an_fmu_of_another_project(capsys):
    """Its binary has no block of start values."""
    assert answer(capsys, "info", str(ROOT / "build/NullFmu.fmu"))["warnings"] == []


def test_a_report_is_one_file_with_its_pictures(design, capsys):
    spoken(capsys, "report", "my.toml", "-o", "r.html")
    page = Path("r.html").read_text(encoding="utf-8")
    for words in ("The design works", "Torque over the angle", "Reactions", "Energy balance", "Inputs"):
        assert words in page
    assert page.count("<svg") >= 3
    assert "http" not in page.replace('="http://www.w3.org/', "")  # but for the names of SVG's namespaces
    names = etree.HTML(page).xpath("//@id")
    assert len(names) == len(set(names))
    spoken(capsys, "report", "my.toml", "-o", "again.html")
    assert Path("again.html").read_text(encoding="utf-8") == page


def test_a_report_on_a_design_that_does_not_work_says_why(design, capsys):
    design.write_text(
        design.read_text(encoding="utf-8").replace("friction = 0.14", "friction = 1.2", 1), encoding="utf-8"
    )
    spoken(capsys, "report", "my.toml", "-o", "r.html", "--anyway")
    assert "does not work" in Path("r.html").read_text(encoding="utf-8")


def test_a_study_begins_with_the_values_of_the_design(design, capsys):
    text = design.read_text(encoding="utf-8").partition("[scenario]")[0]
    design.write_text(
        f"{text}[scenario]\nstop = 1e-3\n[study]\nresults = ['torque_load']\n"
        '[study.plan]\nkind = "grid"\n[study.plan.vary]\n'
        '"spring.preload" = { from = 50.0, to = 150.0, count = 3 }\n',
        encoding="utf-8",
    )
    words = ("study", "my.toml", "--out", "runs", "--workers", "0", "--format", "csv")
    assert "3 runs" in spoken(capsys, *words).out
    loads = {}
    for file in Path("runs/my").rglob("*.csv"):
        with file.open(encoding="utf-8") as lines:
            loads |= {float(r["spring.preload"]): float(r["torque_load"]) for r in csv.DictReader(lines)}
    assert set(loads) == {50.0, 100.0, 150.0}
    assert loads[100.0] - loads[50.0] == pytest.approx(loads[150.0] - loads[100.0], rel=1e-9)


def test_an_ssp_package_is_valid_and_holds_the_fmu(design, capsys):
    spoken(capsys, "ssp", "my.toml", "-o", "MyCam.ssp")
    kinds = {".ssd": "Description", ".ssv": "ParameterValues"}
    with zipfile.ZipFile("MyCam.ssp") as archive:
        assert "resources/MyCam.fmu" in archive.namelist()
        for name in archive.namelist():
            if Path(name).suffix in kinds:
                schema = etree.parse(str(SCHEMAS / f"SystemStructure{kinds[Path(name).suffix]}.xsd"))
                etree.XMLSchema(schema).assertValid(etree.fromstring(archive.read(name)))


def packaged(path):
    """Start values of the FMU in a package, by the name of the variable."""
    with zipfile.ZipFile(path) as archive:
        values = etree.fromstring(archive.read("resources/cam.ssv"))
    return {p.get("name"): p[0].get("value") for p in values.iter("{*}Parameter")}


def test_an_ssp_package_has_only_the_parameters_of_its_model(folder, capsys):
    """The forward FMU has no shaft.stiffness, the inverse FMU no initial.theta."""
    common = "[shaft]\nstiffness = 100.0\n[initial]\ntheta = 0.3\n[scenario]\nstop = 0.1\n"
    for name, torque_or_angle in (("f", "inputs.tau = 3.0"), ("i", "inputs.theta = 0.3")):
        Path(f"{name}.toml").write_text(f"{common}{torque_or_angle}\n", encoding="utf-8")
        spoken(capsys, "ssp", f"{name}.toml", "-o", f"{name}.ssp")
    assert packaged("f.ssp") == {"initial.theta": "0.3"}
    assert packaged("i.ssp") == {"shaft.stiffness": "100.0"}


@pytest.mark.parametrize(
    "path, step, mention",
    [
        ("a.zip", 1e-3, "end in .ssp"),
        ("a.ssp", -1.0, "step = -1.0: allowed is a finite number > 0, in s"),
        ("no/a.ssp", 1e-3, "folder"),
    ],
)
def test_an_ssp_package_that_cannot_be_is_refused(design, path, step, mention):
    with pytest.raises(DesignError, match=mention):
        export_ssp(read_design(design), path, step)


@pytest.mark.parametrize("lower, upper, start", [(0.1, 1.2, 0.1), (-1.2, -0.1, -0.1)])
def test_an_inverse_fmu_whose_stops_exclude_0_starts_at_the_nearest_stop(folder, capsys, lower, upper, start):
    stops = f"[spring]\npreload = 700\n[stop]\nlower = {lower}\nupper = {upper}\n"
    scenario = f"[scenario]\nstop = 0.1\ninputs.theta = {0.5 * (lower + upper)}\n"
    Path("my.toml").write_text(stops + scenario, encoding="utf-8")
    assert answer(capsys, "check", "my.toml")["good"]
    spoken(capsys, "export", "my.toml", "-o", "MyCam.fmu")
    with Fmu("MyCam.fmu") as fmu:
        fmu.start()
        assert fmu.real("theta") == start


# ---- nothing goes wrong silently ----


def test_unequal_radii_keep_groove_2(design, capsys):
    """Equal grooves need equal radii. The answer has the lines for cam 1 alone, and the radii stand."""
    wanted = Path("torque.csv")
    wanted.write_text("theta_deg,torque_Nm\n0,1\n20,3\n50,6\n80,9\n", encoding="utf-8")
    said = spoken(capsys, "design", "my.toml", "--torque", str(wanted), "-o", "groove.csv").out
    assert (
        "Replace the lines profile, lead_angle and table in your [cam1] of my.toml" in said
        and "[cam2]" not in said
    )
    said = spoken(capsys, "design", "my.toml", "--torque", "5", "-o", "g.csv", "--groove2", "equal", code=1)
    assert "equal grooves need equal radii" in said.err


def test_a_groove_is_found_from_the_folder_of_its_design_file(equal, folder, capsys):
    """`dualcam design` prints the path as the design file needs the path, wherever the command runs."""
    (folder / "designs").mkdir()
    text = equal.read_text(encoding="utf-8").replace('profile = "helix"', "")
    mine = folder / "designs" / "mine.toml"
    mine.write_text(text, encoding="utf-8")
    said = spoken(capsys, "design", "designs/mine.toml", "--torque", "5", "-o", "groove.csv").out
    lines = [line for line in said.splitlines() if line.startswith(("profile", "table"))]
    assert lines == ['profile = "table"', 'table = "../groove.csv"'] * 2
    for cam in ("cam1", "cam2"):
        text = text.replace(f"[{cam}]", "\n".join([f"[{cam}]", *lines[:2]]))
    mine.write_text(text, encoding="utf-8")
    load = answer(capsys, "band", "designs/mine.toml")["columns"]["load_N.m"]
    assert load == pytest.approx([5.0] * len(load), rel=1e-6)


def test_a_groove_that_cannot_work_is_called_so(equal, capsys):
    """The findings are those of `dualcam check` with the printed lines in the design file; the lead angle is
    the slope of the samples. Files for a workshop are refused."""
    words = ("design", "my.toml", "--torque", "500", "-o", "groove.csv", "--force")
    refused = answer(capsys, *words, "--export", "cut.csv", code=1)["findings"]
    assert not Path("groove.csv").exists() and not Path("cut_cam1.csv").exists()
    said = spoken(capsys, *words).out
    psi, z = np.loadtxt("groove.csv", delimiter=",", skiprows=1).T
    steepest = np.degrees(np.arctan((np.diff(z) / np.diff(psi)).max() / 0.02))
    shown = said.partition("lead angle ")[2].split()
    assert float(shown[2]) == pytest.approx(steepest, abs=0.2) and shown[3] == "deg"
    assert "does not work: `dualcam check` finds" in said.splitlines()[-1]
    found = answer(capsys, *words)
    text = equal.read_text(encoding="utf-8")
    for cam in ("cam1", "cam2"):
        text = text.replace(f"[{cam}]", f'[{cam}]\nprofile = "table"\ntable = "groove.csv"')
    text = re.sub('(profile = "helix"|lead_angle = ).*', "", text)
    equal.write_text(text, encoding="utf-8")
    checked = answer(capsys, "check", "my.toml", code=1)
    assert not found["good"] and len(found["findings"]) == len(checked["findings"]) > 0
    errors = [one for one in checked["findings"] if one["severity"] == "error"]
    for key in ("severity", "kind", "key", "change", "nearest"):
        assert [one[key] for one in found["findings"]] == [one[key] for one in checked["findings"]]
        assert [one[key] for one in refused] == [one[key] for one in errors]


@pytest.mark.parametrize(
    "words, mention",
    [
        (["simulate", "my.toml", "-o", "out.csv", "--plot", "p.xyz"], ".png, .svg or .pdf"),
        (["simulate", "my.toml", "-o", "out.csv", "--plot", "p.png", "--variables", "tau"], "add theta"),
        (["simulate", "my.toml", "-o", "out.csv", "--fmu", str(fmu_path("inverse"))], "no input tau"),
        (["band", "my.toml", "-o", "out.csv", "--plot", "p.xyz"], ".png, .svg or .pdf"),
        (["band", "my.toml", "--plot", "p.gif"], "p.gif: allowed are"),
        (["simulate", "my.toml", "-o", "out.csv", "--plot", "p.gif"], "p.gif: allowed are"),
        (["info", "--variables", "sprung"], "'sprung'"),
        (["study", "my.toml"], "this design file has no section [study]"),
    ],
)
def test_what_cannot_be_done_is_refused_before_anything_is_written(design, capsys, words, mention):
    assert mention in spoken(capsys, *words, code=1).err
    assert [path.name for path in Path().iterdir()] == ["my.toml"]


def test_a_study_leaves_out_parameters_of_the_other_model_and_a_byte_order_mark(design, capsys):
    text = design.read_text(encoding="utf-8").partition("[scenario]")[0]
    design.write_text(
        f"{text}[shaft]\nstiffness = 100.0\n[scenario]\nstop = 1e-3\n[study]\nresults = ['z']\n"
        "[study.plan]\nkind = 'grid'\n[study.plan.vary]\n'spring.preload' = { values = [50.0] }\n",
        encoding="utf-8-sig",
    )
    words = ("study", "my.toml", "--out", "runs", "--workers", "0", "--format", "csv")
    said = spoken(capsys, *words).out
    assert "1 of 1 runs, 0 failed" in said


def test_a_report_on_a_mechanism_that_jams_has_no_numbers_that_are_none(folder, capsys):
    Path("my.toml").write_text("cam1.friction = 1.2\ncam2.friction = 1.2\n", encoding="utf-8")
    said = spoken(capsys, "report", "my.toml", "-o", "r.html", "--anyway")
    assert "NaN" not in said.err
    page = Path("r.html").read_text(encoding="utf-8")
    assert "infinite: the mechanism jams" in page and ">nan" not in page


@pytest.mark.parametrize(
    "lines",
    ['[stop]\nupper = "-10 deg"\n', '[cam1]\nlead_angle = "86 deg"\n[cam2]\nlead_angle = "86 deg"\n'],
)
@pytest.mark.parametrize("command, name", [("view", "my.html"), ("export", "My.fmu")])
def test_a_design_that_the_fmu_refuses_is_refused_in_the_words_of_check(folder, capsys, command, name, lines):
    """With the line of the file and a value that works, and without a name of a C function."""
    (folder / "bad.toml").write_text(lines, encoding="utf-8")
    found = answer(capsys, "check", "bad.toml", code=1)["findings"]
    errors = [finding for finding in found if finding["severity"] == "error"]
    said = spoken(capsys, command, "bad.toml", "-o", name, code=1).err
    assert "bad.toml: 1 error" in said and "fmi2" not in said
    assert all(f"line {error['line']}: {error['text']}" in said for error in errors)
    assert answer(capsys, command, "bad.toml", "-o", name, code=1)["findings"] == errors
    assert not (folder / name).exists()


@pytest.mark.skipif(sys.platform != "linux", reason="/proc is a folder of Linux")
@pytest.mark.parametrize("command", ["view", "report"])
def test_a_folder_in_which_no_file_can_be_made_is_named(design, capsys, command):
    said = spoken(capsys, command, "my.toml", "-o", "/proc/x.html", code=1).err
    assert "/proc/x.html cannot be written" in said and "another folder" in said and "Errno" not in said


def test_the_findings_of_a_refused_file_are_data(folder, capsys):
    Path("my.toml").write_text("\ncam1.radius = 1979-05-27\n", encoding="utf-8")
    (finding,) = answer(capsys, "check", "my.toml", code=1)["findings"]
    assert (finding["key"], finding["line"], finding["value"]) == ("cam1.radius", 2, "1979-05-27")


def test_a_name_that_the_terminal_cannot_show_does_no_harm(design):
    design.rename("\u8bbe\u8ba1.toml")
    done = subprocess.run(
        [sys.executable, "-m", "dualcam", "check", "\u8bbe\u8ba1.toml"],
        capture_output=True,
        env={**os.environ, "PYTHONIOENCODING": "cp1252"},
    )
    assert done.returncode == 0, done.stderr
    assert b"the design works" in done.stdout


@pytest.mark.parametrize("torque", ["4", "4 N.m", "4Nm", "4000 N.mm"])
def test_a_torque_may_have_its_unit(equal, capsys, torque):
    said = spoken(capsys, "design", "my.toml", "--torque", torque, "-o", "groove.csv").out
    assert "Replace the lines profile, lead_angle and table in your [cam1] and [cam2] of my.toml:" in said
    assert (equal.parent / "groove.csv").exists()


@pytest.mark.parametrize(
    ("torque", "words"),
    [
        ("6,0", "a decimal comma: write 6.0"),
        ("6 N", "N is no unit of N.m: allowed is N.m or a multiple of N.m"),
        ("6 Newtonz", "unit 'Newtonz' is not known"),
        ("nix.csv", "torque file nix.csv: "),
    ],
)
def test_a_torque_that_is_none(design, capsys, torque, words):
    assert words in spoken(capsys, "design", "my.toml", "--torque", torque, "-o", "g.csv", code=1).err


def test_check_gives_the_key_numbers_of_a_good_design(design, capsys):
    """Equal helices of 45 deg: the efficiency is that of two wedges, tan(45 deg - rho)/tan(45 deg + rho)."""
    said = spoken(capsys, "check", "my.toml").out
    efficiency = ((1 - 0.14) / (1 + 0.14)) ** 2
    for words in (
        "torque to load: ",
        "torque given back: ",
        f"efficiency: {100 * efficiency:.4g} %",
        "self-locking: no",
        "friction: one motion under every load (unique)",
        f"stroke of the follower: {20 * np.radians(80) / 2:.4g} mm",
        "MPa, at theta = 80 deg on cam 1; limit 1500 MPa (the default); Young's modulus of the pin 210 GPa",
        "my.toml: the design works, the FMU starts.",
    ):
        assert words in said, said
    assert answer(capsys, "check", "my.toml")["numbers"]["pressure"]["cam"] == 1


def test_the_verdict_names_values_that_look_like_other_units(design, capsys):
    design.write_text(design.read_text().replace('width = "8 mm"', "width = 8"))
    said = spoken(capsys, "check", "my.toml").out.splitlines()
    assert said[-1] == "my.toml: the FMU starts, but 1 value looks like another unit: see the warnings."
    design.write_text("cam1.radius = 18\ncam2.radius = 22\nspring.preload = -1")
    said = spoken(capsys, "check", "my.toml", code=1).out.splitlines()
    assert said[0] == (
        "Check the units first: 2 values look like other units. The errors below can come from there."
    )
    assert said[1].startswith("! warning: line 1: cam1.radius = 18 m: this looks like millimetres")
    assert said[-1] == "my.toml: the design does not work, 1 error. The FMU starts."


def test_an_fmu_of_fmi_3_is_simulated_in_steps_of_the_scenario(design, capsys):
    """FMI 3.0 has no derivatives of inputs: the FMU gets the torque of the middle of each step."""
    head = design.read_text().partition("[scenario]")[0]
    torque = "inputs.tau = {time = [0.0, 0.2], value = [0.0, 6.0]}"
    scenario = f"[scenario]\nstop = 0.4\noutput_interval = 0.01\n{torque}\n"
    design.write_text(head + scenario)
    spoken(capsys, "export", "my.toml", "-o", "MyCam.fmu", "--fmi", "3")
    words = ("simulate", "my.toml", "--variables", "theta", "-o")
    assert "give step, in seconds" in spoken(capsys, *words, "no.csv", "--fmu", "MyCam.fmu", code=1).err
    spoken(capsys, *words, "ramp.csv")
    design.write_text(head + scenario + "step = 1e-4\n")
    spoken(capsys, *words, "steps.csv", "--fmu", "MyCam.fmu")
    ramp, steps = (
        np.genfromtxt(f"{name}.csv", delimiter=",", names=True)["theta"] for name in ("ramp", "steps")
    )
    assert np.max(ramp) > 0.5 and np.max(np.abs(ramp - steps)) < 1e-4  # rad
