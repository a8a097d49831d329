"""Design files: what is read, what is refused, and the text that a user then sees."""

import json
import math
import os
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from driver import ROOT, models
from hypothesis import given, settings
from hypothesis import strategies as st

from dualcam.common.written_units import quantity
from dualcam.design import Helix, Mechanism
from dualcam.design_file import TEMPLATES, json_schema, read_design, write_template
from dualcam.errors import DesignError, DesignFileError, DualcamError
from dualcam.fmi.variables import all_parameters, inputs_of, parameters_of
from dualcam.systems.machines import car_door, elbow, knee


@pytest.fixture
def read(tmp_path):
    """Reads a text as a design file."""

    def run(text):
        path = tmp_path / "my.toml"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_design(path)

    return run


@pytest.fixture
def refusal(read):
    """The text of the error of a design file."""

    def run(text):
        with pytest.raises(DesignFileError) as caught:
            read(text)
        return str(caught.value)

    return run


# ---- variables ----


@pytest.mark.parametrize("model", ["forward", "inverse"])
def test_variables_are_those_of_the_model_description(model):
    """Names, units, limits and start values against modelDescription.xml as another reader gives them."""
    variables = models[f"DualCam{model.capitalize()}"].variables
    ours = {**parameters_of(model), **inputs_of(model)}
    theirs = {name: v for name, v in variables.items() if v.causality in ("parameter", "input")}
    assert set(ours) == set(theirs)
    for name, variable in ours.items():
        read = theirs[name]
        assert (variable.least, variable.greatest, variable.start) == (read.min, read.max, read.start)
        assert variable.unit == (read.unit or "")


# ---- what is read ----


def test_every_parameter_of_both_fmus(read):
    """Each parameter can be given and comes back; nested tables and dotted keys are the same."""
    values = {
        name: variable.start for name, variable in all_parameters().items() if not name.endswith("table")
    }
    dotted = "\n".join(f"{name} = {json.dumps(value)}" for name, value in values.items())
    assert read(dotted).parameters == values
    groups = {}
    for name, value in values.items():
        group, _, last = name.rpartition(".")
        groups.setdefault(group, []).append(f"{last} = {json.dumps(value)}")
    nested = "\n".join(groups.pop("")) + "\n"
    nested += "\n".join(f"[{group}]\n" + "\n".join(lines) for group, lines in groups.items())
    design = read(nested)
    assert design.parameters == values
    assert "shaft.stiffness" not in design.parameters_for("forward")
    assert "initial.theta" not in design.parameters_for("inverse")


def test_units(read):
    design = read(
        """
        contacts = 1
        cam1 = {radius = "18 mm", lead_angle = "45 deg", friction = "14 %", profile = "helix"}
        cam2.radius = "0.79 in"
        spring = {preload = "0.05 kN", stiffness = "50 N/mm", free_length = "4 cm", solid_length = 0.02}
        inertia.shaft = "20 kg.cm^2"
        damper = {c_load = "3 N.s/mm", q_load = "2 N s²/m²"}
        shaft.damping = "0.1 N.m.s/rad"
        stop.upper = "0.25 turn"
        initial.omega = "30 rpm"
        [scenario]
        stop = "1500 ms"
        inputs.tau = {time = ["0 ms", 1.0], value = ["500 N.mm", 2], shape = "linear"}
        inputs.F_ext = "0.2 kN"
        [pin]
        radius = "3 mm"
        width = 0.008
        modulus = "210 GPa"
        [limits]
        lead_angle = ["5 deg", 1.2]
        pressure = "1500 MPa"
        """
    )
    assert design.parameters == {
        **{"cam1.radius": 0.018, "cam1.lead_angle": math.radians(45), "cam1.friction": 0.14},
        **{"cam1.profile": 1, "cam2.radius": pytest.approx(0.79 * 0.0254), "contacts": 1},
        **{"spring.preload": 50.0, "spring.stiffness": 50e3, "inertia.shaft": pytest.approx(0.002)},
        **{"damper.c_load": 3e3, "damper.q_load": 2.0, "shaft.damping": 0.1},
        **{"stop.upper": pytest.approx(math.pi / 2), "initial.omega": pytest.approx(math.pi)},
    }
    assert design.spring_limits == (0.04, 0.02)
    assert design.scenario.stop == 1.5 and design.scenario.inputs["tau"].time == (0.0, 1.0)
    assert design.scenario.inputs["tau"].value == (0.5, 2.0)
    assert design.scenario.inputs["F_ext"].value == (200.0,)
    assert (design.pin.radius, design.pin.modulus) == (0.003, 210e9)
    assert design.limits.lead_angle == (math.radians(5), 1.2) and design.limits.pressure == 1.5e9
    assert design.model == "forward" and not design.warnings


def test_imposed_angle_makes_an_inverse_design(read):
    design = read('[scenario]\nstop = 1.0\ninputs.theta = {time = [0, 1], value = [0, 60], unit = "deg"}')
    assert design.model == "inverse"
    assert design.scenario.inputs["theta"].value == pytest.approx((0.0, math.radians(60)))
    assert design.scenario.inputs["omega"].derivative_of == "theta"
    assert design.scenario.inputs["alpha"].derivative_of == "omega"


def test_mechanism_has_the_defaults_of_the_fmu(read):
    mechanism = read("stop.lower = -0.2").mechanism()
    assert isinstance(mechanism, Mechanism) and mechanism.grooves == (Helix(0.02, math.pi / 4),) * 2
    start = {name: variable.start for name, variable in parameters_of("forward").items()}
    assert mechanism.parameters_without_tables().items() <= (start | {"stop.lower": -0.2}).items()


def test_study_table(read):
    varied = '{"cam1.friction" = {values = [0.1, 0.2]}}'
    text = f'[study]\nresults = ["theta"]\nplan = {{kind = "grid", vary = {varied}}}'
    assert read(text).study["plan"]["kind"] == "grid"


# ---- the ten typical mistakes, in the words that a user sees ----


def test_mistake_degrees(read, refusal):
    (warning,) = read("stop.upper = 75").warnings
    assert str(warning) == "line 1: stop.upper = 75 rad: this looks like degrees; 75 deg is 1.309 rad"
    text = refusal("[cam1]\nlead_angle = 45\n")
    assert "line 2: cam1.lead_angle = 45: allowed is a number from 0 to 1.5708 in rad" in text
    assert "this looks like degrees; 45 deg is 0.785398 rad" in text


@pytest.mark.parametrize(
    "text",
    [
        'stop.upper = "1000 deg"',
        'cam1.radius = "1.5 m"',
        'limits.lead_angle = ["5 deg", "80 deg"]',
        '[scenario]\nstop = "5 min"',
        '[scenario]\nstop = 1\ninputs.theta = {time = [0, 1], value = ["0 deg", "900 deg"]}',
        '[scenario]\nstop = 1\ninputs.theta = {time = [0, 1], value = [0, 900], unit = "deg"}',
    ],
)
def test_a_written_unit_is_not_doubted(read, text):
    assert read(text).warnings == ()


def test_a_value_out_of_range_with_its_unit_is_not_called_another_unit(refusal):
    text = refusal('[cam1]\nlead_angle = "450 deg"\n')
    assert "allowed is a number from 0 to 1.5708 in rad" in text and "looks like" not in text


def test_mistake_millimetres(read):
    found = read("cam1.radius = 18\nspring.stiffness = 32\n[pin]\nradius = 3\nwidth = 8").warnings
    assert [str(one).partition(": this")[0] for one in found] == [
        *("line 1: cam1.radius = 18 m", "line 2: spring.stiffness = 32 N/m"),
        *("line 4: pin.radius = 3 m", "line 5: pin.width = 8 m"),
    ]
    assert "millimetres; 18 mm is 0.018 m" in found[0].text
    assert "N/mm; 32 N/mm is 32000 N/m" in found[1].text
    assert not read("spring.stiffness = 0").warnings  # a spring of preload alone is meant


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("cam1.raduis = 0.02", "cam1.raduis is no key: did you mean cam1.radius?"),
        ("lead_angle = 0.7", "lead_angle is no key: did you mean cam1.lead_angle or cam2.lead_angle?"),
        ("cam1.preload = 50", "cam1.preload is no key: did you mean spring.preload?"),
        ("spring.k = 50e3", "spring.k is no key: did you mean spring.stiffness?"),
        ("cam1.static_friction = 0.2", "cam1.static_friction is no key: did you mean cam1.friction_peak?"),
        ("cam1.stribeck_speed = 0.01", "cam1.stribeck_speed is no key: did you mean cam1.stribeck_velocity?"),
        ("cam2.v_stribeck = 0.01", "cam2.v_stribeck is no key: did you mean cam2.stribeck_velocity?"),
        (
            "cam1.friction_peak = 0.21",
            "cam1.friction_peak = 0.21: allowed is a number from 1 to 100; the value is the ratio of the",
        ),
        ("cam3.radius = 0.02", "cam3 is no key: did you mean cam"),
        ("scenario.duration = 2.0", "scenario.duration is no key: did you mean scenario.stop?"),
        ("Contacts = 2", "Contacts is no key: did you mean contacts?"),
        ("stop.zzz = 2", "stop.zzz is no key: allowed in [stop] are lower, upper, restitution"),
        (
            "scenario.inputs.torque = 2",
            "scenario.inputs.torque is no key: did you mean scenario.inputs.tau?",
        ),
        ("scenario.controller = 2", "scenario.controller is no key: a controller belongs to a study plan"),
    ],
)
def test_mistake_wrong_key(refusal, line, words):
    assert f"line 1: {words}" in refusal(line)


def test_mistake_missing_file(tmp_path, refusal):
    (tmp_path / "mine.toml").write_text("")
    with pytest.raises(DesignFileError, match=r"no such file: did you mean mine\.toml\?; `dualcam new"):
        read_design(tmp_path / "mime.toml")
    with pytest.raises(DesignFileError, match="no such file; `dualcam new"):
        read_design(tmp_path / "nofile.toml")
    with pytest.raises(DesignFileError, match="this is a folder: give the path of a design file"):
        read_design(tmp_path)
    text = refusal('cam1.profile = "table"\ncam1.table = "nix.csv"')
    assert "line 2: cam1.table = 'nix.csv': there is no groove table" in text


def test_mistake_byte_order_mark(read, refusal):
    assert read(b"\xef\xbb\xbfcam1.radius = 0.03\r\n").parameters == {"cam1.radius": 0.03}
    assert 'UTF-16: save the file as "UTF-8"' in refusal("cam1.radius = 0.03".encode("utf-16"))
    assert "line 2: the text is not UTF-8" in refusal(b"# x\ntitle = '\xb0'")


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("\nstop.upper = 1,3", 2, "A decimal comma? Write a decimal point: 1.5, not 1,5"),
        ('cam1.table = "C:\\data\\new.csv"', 1, "A path with backslashes? Write / or single quotes"),
        ("stop.upper = 75 deg", 1, 'A unit without quotes? Write the value in quotes: "45 deg"'),
        ("ledger = True", 1, "A switch? Write true or false in small letters"),
        ("cam1.friction = .14", 1, "Write 0.5, not .5"),
        ("cam1.friction =", 1, "A key without a value?"),
        ("title: x", 1, "A colon after the key? Write key = value"),
        ("contacts = 2\ncontacts = 1", 2, "The same key or table twice?"),
        (
            "[cam1]\nradius = 0.02\n[cam1]\nfriction = 0.1",
            3,
            "The table [cam1] twice? Put all its lines below",
        ),
        ("title = door", 1, "Text without quotes?"),
        ("; comment", 1, "Comments begin with #"),
        ("[cam1\nradius = 1", 1, "A missing ] ?"),
        ("title = \u201cdoor\u201d", 1, "Curly quotes?"),
    ],
)
def test_mistake_in_the_syntax(refusal, text, line, words):
    found = refusal(text)
    assert f"line {line}: this is no TOML" in found and words in found


def test_mistake_wrong_units_in_quotes(refusal):
    text = refusal(
        'cam1 = {radius = "20 deg", friction = "8 deg"}\nstop.upper = "45"\ncam2.radius = "1,5 mm"\n'
        'cam2.friction = "0.1"\nspring.stiffness = "50 N"\nspring.preload = "50 Newtonz"\n'
        'initial.omega = "3 Hz"'
    )
    for words in (
        'line 1: cam1.radius = "20 deg": deg is no unit of length',
        'line 1: cam1.friction = "8 deg": deg is no unit of a plain number',
        'line 2: stop.upper = "45": no unit in the quotes: write "45 deg", or 45 without quotes in rad',
        'line 3: cam2.radius = "1,5 mm": a decimal comma: write 1.5 mm',
        'line 4: cam2.friction = "0.1": a number in quotes: write 0.1 without quotes',
        'line 5: spring.stiffness = "50 N": N is no unit of N/m',
        "line 6: spring.preload = \"50 Newtonz\": unit 'Newtonz' is not known",
        'line 7: initial.omega = "3 Hz": Hz is no unit of rad/s',
    ):
        assert words in text
    assert text.splitlines()[0].endswith("my.toml: 8 errors")


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('cam1.lead_angle = "40 grad"', 'write "40 deg" for degrees, or "40 gon" for gon (100 gon = 90 deg)'),
        ('stop.upper = "75 Grad"', "unit 'Grad' can mean degrees or gon: write \"75 deg\" for degrees"),
        ('initial.omega = "20 Grad/s"', 'write "20 deg/s" for degrees'),
        ('scenario.inputs.theta = {time = [0], value = [40], unit = "grad"}', 'write "40 deg"'),
        ('stop.upper = "75 Mrad"', "unit 'Mrad' is not allowed for an angle: allowed are rad, mrad and deg"),
        ('stop.upper = "75 krad"', "not allowed for an angle"),
        ('pin.diameter = "6 mm"', 'pin.radius is half of the diameter: write pin.radius = "3 mm"'),
        ("cam1.diameter = 0.036", "cam1.radius is half of the diameter: write cam1.radius = 0.018"),
        ("pin.diameter = true", "pin.radius is half of the diameter"),
    ],
)
def test_mistake_of_german_words_and_diameters(refusal, line, words):
    assert words in refusal(line)


def test_milliradians_and_gon_are_meant(read):
    found = read('stop.upper = "1200 mrad"\ncam1.lead_angle = "50 gon"').parameters
    assert found == pytest.approx({"stop.upper": 1.2, "cam1.lead_angle": 0.7853981633974483}, rel=1e-15)


def test_mistake_an_fmu_for_a_design(refusal):
    assert "this is an FMU or another zip archive: give the design file" in refusal(b"PK\x03\x04\xff\xff")


# ---- all errors at once ----


def test_all_errors_at_once(refusal):
    """Of the schema, of tables, scenario, pin, limits and study, in the order of the lines."""
    text = refusal(
        """cam1.radius = true
cam2 = 3
contacts = 3
ledger = "yes"
title = 5
[spring]
free_length = 0.02
[scenario]
inputs = {tau = 2.0, theta = 1.0}
[pin]
radius = 0.003
[limits]
lead_angle = [0.5, 0.2]
[study]
nonsense = 1
"""
    ).splitlines()
    assert text[0].endswith("11 errors")
    starts = (
        *("line 1: cam1.radius = true: allowed is a number", "line 2: cam2 = 3: allowed is a table [cam2]"),
        *("line 3: contacts = 3: allowed is a whole number from 1 to 2", 'line 4: ledger = "yes": allowed'),
        *("line 5: title = 5: allowed is text in quotes", "line 7: spring.free_length is given"),
        *("line 8: [scenario] lacks stop", "line 9: [scenario] has tau and theta"),
        *("line 10: [pin] lacks width", "line 12: [limits] lead_angle", "line 14: [study] 2 mistakes"),
    )
    assert text[-2:] == [
        "  study has nonsense: allowed are results, plan, scenario, plots",
        "  study lacks plan, results",
    ]
    assert all(line.strip().startswith(start) for line, start in zip(text[1:-2], starts, strict=True)), text


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("cam1.radius = nan", "cam1.radius = nan: allowed is a number from 1e-06 to 1000 in m"),
        ("cam1.radius = inf", "allowed is a number"),
        (f"cam1.radius = 1{'0' * 400}", "allowed is a number"),
        (f"cam1.radius = 1{'0' * 5000}", "this is no TOML"),
        ("x = " + "[" * 20000, "nested too deeply"),
        ('cam1.profile = "circle"', '1 or "helix", 2 or "ellipse", 3 or "table", 4 or "cycloid"'),
        ("cam1.cycloid_rise = 0", "cam1.cycloid_rise = 0: allowed is a number from 1e-06 to 1000 in m"),
        ("cam1.cycloid_angle = 2e3", "this looks like degrees; 2000 deg is 34.9066 rad"),
        ("cam1.ellipse_curvature = 0", "allowed is -1 (the groove flattens) or +1"),
        ("cam1.profile = 3", 'give its path, cam1.table = "groove.csv"'),
        ("[scenario]\nstop = -1", "scenario.stop = -1: allowed is a number >= 0 in s"),
        ("[scenario]\nstop = 0", "stop = 0.0: allowed is a finite number above 0"),
        ("[scenario]\nstop = 1\ninputs.tau = {time = [0, 1], value = [1]}", "1 values at 2 times"),
        ("[scenario]\nstop = 1\ninputs.tau = {time = [1, 0], value = [1, 2]}", "times must increase"),
        ("[scenario]\nstop = 1\ninputs.tau = {time = [0, 'x'], value = [1, 2]}", "number 2 of 2, 'x'"),
        ("[scenario]\nstop = 1\ninputs.omega = 1.0", "omega without theta"),
        ("[pin]\nradius = 0\nwidth = 1", "radius = 0.0: allowed is a finite number > 0"),
        ("[limits]\nlead_angle = [5, 80]", "this looks like degrees; 5 deg is 0.0872665 rad"),
        ("[spring]\nfree_length = 0.02\nsolid_length = 0.03", "allowed is less than spring.free_length"),
        ('[study]\nresults = ["theta"]\nplan = {kind = "gird"}', "kind = 'gird': did you mean grid?"),
    ],
)
def test_other_refusals(refusal, text, words):
    assert words in refusal(text)


# ---- groove tables ----


def test_table_in_the_fmus_format_is_used_as_it_is(read, tmp_path):
    (tmp_path / "g.csv").write_text("psi_rad,z_m\n0,0\n0.5,0.01\n1,0.02\n1.5,0.03\n")
    design = read('cam1 = {profile = "table", table = "g.csv"}')
    assert design.parameters["cam1.table"] == str(tmp_path / "g.csv") and not design.notes


def test_table_in_another_format_is_converted(read, tmp_path, monkeypatch):
    """The FMU gets a file that it reads; the original stays; the same samples give the same path."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    text = "psi [deg];z [mm]\r\n0;0\r\n30;10,5\r\n60;21\r\n90;31,5\r\n"
    (tmp_path / "g.csv").write_bytes(text.encode())
    design = read('cam1 = {profile = "table", table = "g.csv"}')
    assert (tmp_path / "g.csv").read_bytes() == text.encode()
    path = Path(design.parameters["cam1.table"])
    assert path.is_absolute() and path.read_text().startswith("psi_rad,z_m\n0.0,0.0\n")
    assert float(path.read_text().split()[-1].split(",")[1]) == 0.0315
    assert any("the header says deg and mm" in note for note in design.notes)
    assert len(design.notes) == 1 and str(path) not in design.notes[0]
    assert read('cam1 = {profile = "table", table = "g.csv"}').parameters == design.parameters


@pytest.mark.parametrize("home", ["/proc/none", ""])
def test_a_converted_table_needs_no_home(tmp_path, home):
    """A process whose cache folder cannot be made, or that has no home at all, as in containers."""
    (tmp_path / "g.csv").write_text("psi [deg];z [mm]\n0;0\n30;10,5\n60;21\n90;31,5\n")
    (tmp_path / "my.toml").write_text('cam1 = {profile = "table", table = "g.csv"}')
    program = (
        "import os\n"
        f"os.path.expanduser = lambda path: path.replace('~', {home!r} or '~')\n"
        "import dualcam\n"
        "design = dualcam.read_design('my.toml')\n"
        "print(dualcam.check_design(design).starts, design.parameters['cam1.table'])"
    )
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    environment = {name: value for name, value in os.environ.items() if not name.startswith("XDG")}
    environment |= {"TMPDIR": str(scratch), "TEMP": str(scratch), "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    starts, table = done.stdout.split()
    assert starts == "True" and Path(table).is_relative_to(scratch) and Path(table).is_file()
    assert {path.name for path in tmp_path.iterdir()} == {"g.csv", "my.toml", "scratch"}


def test_table_with_a_right_header_and_wrong_numbers(read, tmp_path):
    (tmp_path / "g.csv").write_text("psi_rad,z_m\n0,0\n20,4\n40,8\n80,16\n")
    found = [str(one) for one in read('cam1 = {profile = "table", table = "g.csv"}').warnings]
    assert any("psi = 80 rad: this looks like degrees" in text for text in found)
    assert any("z = 16 m: this looks like millimetres; 16 mm is 0.016 m" in text for text in found)


def test_table_that_is_not_used(read, refusal, tmp_path):
    (tmp_path / "g.csv").write_text("psi_rad,z_m\n0,0\n0.5,0.01\n1,0.02\n1.5,0.03\n")
    (warning,) = read('cam1.table = "g.csv"').warnings
    assert warning.text == (
        'cam1.table is not used: the groove of cam1 is a helix. cam1.table belongs to cam1.profile = "table"'
    )
    text = refusal('cam1.profile = 3\ncam2.table = "g.csv"')
    assert "cam1.profile = 3 (table) without cam1.table" in text and "swapped" in text


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("cycloid_rise = 0.02", ["cycloid_rise is not used: the groove of cam2 is a helix"]),  # the default
        (
            'profile = "cycloid"\nlead_angle = "40 deg"\nellipse_a = 0.05',
            [
                "lead_angle is not used: the groove of cam2 is a cycloid. cam2.lead_angle belongs to"
                ' cam2.profile = "helix" or "ellipse"',
                "ellipse_a is not used: the groove of cam2 is a cycloid",
            ],
        ),
        (
            "profile = 2\nlead_angle = 0.7\ncycloid_angle = 1.0",
            ["cycloid_angle is not used: the groove of cam2 is an"],
        ),
        (
            'profile = "table"\ntable = "g.csv"\nlead_angle = 0.7',
            ["lead_angle is not used: the groove of cam2 is a table"],
        ),
        ("profile = 2\nlead_angle = 0.7\nellipse_curvature = 1\nfriction = 0.1", []),
    ],
)
def test_keys_of_another_groove_law_get_a_warning(read, tmp_path, text, words):
    (tmp_path / "g.csv").write_text("psi_rad,z_m\n0,0\n0.5,0.01\n1,0.02\n1.5,0.03\n")
    found = read(f"[cam2]\n{text}").warnings
    for warning, each in zip(found, words, strict=True):
        assert warning.text.startswith(f"cam2.{each}") and warning.kind == "unused"
        assert text.splitlines()[warning.line - 2].startswith(warning.key.removeprefix("cam2."))


def test_keys_of_a_refused_groove_law_get_no_warning(refusal):
    assert "is not used" not in refusal('cam1.profile = "spiral"\ncam1.cycloid_rise = 0.02')


# ---- templates ----


@pytest.mark.parametrize("name", TEMPLATES)
def test_templates(tmp_path, name):
    path = write_template(name, tmp_path / "my.toml")
    design = read_design(path)
    assert design.name == "my" and design.title and design.scenario and design.pin and not design.warnings
    with pytest.raises(DesignError, match="exists already"):
        write_template(name, path)
    assert write_template(name, path, overwrite=True) == path
    with pytest.raises(DesignError, match="allowed are minimal, robot, knee, door"):
        write_template("bicycle", path)
    with pytest.raises(DualcamError, match="Make its folder first"):
        write_template(name, tmp_path / "nowhere" / "my.toml")


def plants():
    """The designs of dualcam.systems."""
    return {
        "robot": elbow.plant_parameters(elbow.design_cam(), elbow.DESIGN_PAYLOAD),
        "knee": knee.plant_parameters(knee.design_cam().parameters(), knee.DESIGN_WALKER),
        "door": car_door.plant_parameters(car_door.design()),
    }


def test_templates_are_the_designs_of_the_systems(tmp_path):
    for name, plant in plants().items():
        design = read_design(write_template(name, tmp_path / f"{name}.toml"))
        for parameter, value in plant.items():
            if not parameter.endswith("radius"):
                assert design.value(parameter) == pytest.approx(value, rel=2e-3), (name, parameter)
        curvature = sum(1.0 / plant[f"cam{i}.radius"] for i in (1, 2))  # torque and stroke depend on it alone
        assert sum(1.0 / design.value(f"cam{i}.radius") for i in (1, 2)) == pytest.approx(curvature, rel=2e-3)


@pytest.mark.parametrize("name", [name for name in TEMPLATES if name != "minimal"])
def test_cams_of_templates_nest(tmp_path, name):
    """The body of a cam reaches from half the pin's width below its radius to as much above it."""
    design = read_design(write_template(name, tmp_path / "my.toml"))
    inner, outer = (design.value(f"cam{i}.radius") for i in (1, 2))
    assert inner + 0.5 * design.pin.width <= outer - 0.5 * design.pin.width


# ---- schema ----


def test_schema_is_fresh():
    script = runpy.run_path(str(ROOT / "docs" / "tools" / "design_file_page.py"))
    stored = (ROOT / "dualcam" / "design_file" / "design.schema.json").read_text(encoding="utf-8")
    assert stored == script["schema_text"]()
    assert json.loads(stored) == json_schema()
    assert (ROOT / "docs" / "design-file.md").read_text(encoding="utf-8") == script["page"]()


# ---- any input ----

OTHER_KEYS = (
    *("cam1", "pin", "pin.radius", "limits.lead_angle", "scenario", "scenario.stop", "scenario.inputs"),
    *("scenario.inputs.tau", "study.plan", "study.results", "title", "x", "spring.free_length"),
)
KEYS = st.sampled_from([*all_parameters(), *OTHER_KEYS])
NUMBERS = st.one_of(st.integers(), st.floats(), st.sampled_from([0, 1, 2, 3, 0.5, -1]))
TEXTS = st.one_of(
    st.text(max_size=20),
    st.from_regex(r"[0-9]{1,3}(\.[0-9]{1,2})? ?[a-zA-Z%./^*()0-9 -]{0,9}", fullmatch=True),
    st.sampled_from(
        ["45 deg", "9**9**9 m", "1e308 km", "3 dB", "0x10 m", "1 m^9", "(1) m", "5 degC", "1 count"]
    ),
)
VALUES = st.recursive(
    st.one_of(NUMBERS, TEXTS, st.booleans()),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(st.sampled_from(["time", "value", "unit", "kind"]), inner),
    ),
    max_leaves=5,
)


def toml(value):
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {toml(one)}" for key, one in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml, value)) + "]"
    if isinstance(value, float):
        return "nan" if math.isnan(value) else str(value)
    if isinstance(value, str):  # TOML takes no surrogates and writes DEL as an escape
        return json.dumps(value).replace("\x7f", "\\u007f")
    return json.dumps(value)


def design_or_error(path, content):
    path.write_bytes(content)
    try:
        design = read_design(path)
    except DualcamError as error:
        assert isinstance(error, DesignFileError) and error.findings and str(error)
        return
    assert all(isinstance(value, float | int | bool | str) for value in design.parameters.values())


@settings(max_examples=150, deadline=None)
@given(entries=st.dictionaries(KEYS, VALUES, max_size=4))
def test_any_values_give_a_design_or_an_error(tmp_path_factory, entries):
    text = "\n".join(f"{key} = {toml(value)}" for key, value in entries.items())
    design_or_error(tmp_path_factory.getbasetemp() / "any.toml", text.encode("utf-8", "replace"))


@settings(max_examples=150, deadline=None)
@given(
    content=st.one_of(
        st.binary(max_size=80), st.text(max_size=80).map(lambda t: t.encode("utf-8", "replace"))
    )
)
def test_any_bytes_give_a_design_or_an_error(tmp_path_factory, content):
    design_or_error(tmp_path_factory.getbasetemp() / "any.toml", content)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("7 Nm", "N.m", 7.0),
        ("700 Nmm", "N.m", 0.7),
        ("3 kgcm2", "kg.m2", 3e-4),
        ("5 Nm/rad", "N.m/rad", 5.0),
        ("50 N/mm", "N/m", 5e4),
        ("180 \u00ba", "rad", math.pi),
    ],
)
def test_units_as_people_write_them(text, unit, value):
    assert quantity(text, unit) == pytest.approx(value, rel=1e-15)
