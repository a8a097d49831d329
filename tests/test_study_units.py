"""Numbers of plans as texts with a unit; files without a study; the plan in the help of `dualcam study`."""

import math
import re
import textwrap
import tomllib
import warnings
from contextlib import suppress

import pytest
from study_cases import refused

from dualcam.__main__ import main
from dualcam.cli.study import PLAN
from dualcam.design_file import write_template
from dualcam.errors import DesignFileError, StudyError, UnitWarning
from dualcam.study import read_results, read_study

SCENARIO = "[scenario]\nstop = 0.1\ninputs.tau = 8.0\n"
VARIED = """
"cam1.lead_angle" = {from = "40 deg", to = "50 deg", count = 3}
"cam2.lead_angle" = {same_as = "cam1.lead_angle"}
"spring.stiffness" = {from = "20 N/mm", to = 8e4, count = 2, log = true}
"spring.preload" = {values = ["0.05 kN", 60]}
"cam1.friction" = {values = ["8 %", 0.14]}
contacts = {values = [1, 2]}
ledger = {values = [true, false]}
"""
EXPECTED = {
    "cam1.lead_angle": (math.radians(40.0), math.radians(50.0)),
    "cam2.lead_angle": (math.radians(40.0), math.radians(50.0)),
    "spring.stiffness": (2e4, 8e4),
    "spring.preload": (50.0, 60.0),
    "cam1.friction": (0.08, 0.14),
    "contacts": (1.0, 2.0),
    "ledger": (0.0, 1.0),
}


@pytest.fixture
def plan(tmp_path):
    """Writes a plan with these lines in plan.vary and [parameters]."""

    def write(varied, parameters="", fmu="forward"):
        path = tmp_path / "plan.toml"
        path.write_text(
            f'fmu = "{fmu}"\nresults = ["theta"]\n[parameters]\n{parameters}\n'
            '[scenario]\nstop = 0.1\n[plan]\nkind = "grid"\n[plan.vary]\n' + varied
        )
        return path

    return write


@pytest.fixture
def design(tmp_path):
    """Writes a design file with these lines in study.plan.vary."""

    def write(varied):
        path = tmp_path / "my.toml"
        path.write_text(
            f"""{SCENARIO}[study]\nresults = ["theta"]\nplan.kind = "grid"\n[study.plan.vary]\n{varied}"""
        )
        return path

    return write


@pytest.mark.parametrize("kind", ["plan", "design"])
def test_texts_with_a_unit_are_numbers_in_the_unit_of_the_fmu(request, kind):
    """Factors of the units by hand: pi/180, 1e3, 1e-2."""
    limits = read_study(request.getfixturevalue(kind)(VARIED)).plan.limits()
    assert limits.keys() == EXPECTED.keys()
    for name, pair in EXPECTED.items():
        assert limits[name] == pytest.approx(pair, rel=1e-15), name


def test_a_study_of_texts_is_that_of_numbers(plan):
    """Two files for one study have equal facts: a study begun with one continues with the other."""
    texts = read_study(plan('"cam1.radius" = {values = ["20 mm", "3 cm"]}')).facts()
    numbers = read_study(plan('"cam1.radius" = {values = [0.02, 0.03]}')).facts()
    assert texts == numbers


def test_parameters_of_a_plan_may_be_texts(plan):
    varied = '"cam1.radius" = {values = [0.02]}'
    given = read_study(
        plan(varied, '"stop.upper" = "90 deg"\n"cam1.table" = "20 mm"\ncontacts = 1')
    ).parameters
    assert given == {"stop.upper": pytest.approx(0.5 * math.pi), "cam1.table": "20 mm", "contacts": 1}
    with refused("parameters: stop.upper = '90 mm'", "allowed is rad"):
        read_study(plan(varied, '"stop.upper" = "90 mm"'))


SLIPS = [
    ('"cam1.lead_angle" = {from = "40 mm", to = 1, count = 2}', ["cam1.lead_angle: from = '40 mm'", "rad"]),
    ('"cam1.lead_angle" = {from = 0.1, to = "50", count = 2}', ["to = '50'", "no unit in the quotes"]),
    ('"cam1.radius" = {values = [0.02, "20 ells"]}', ["values = '20 ells'", "not known"]),
    ('"cam1.lead_angel" = {values = ["40 deg"]}', ["cam1.lead_angel is no variable", "cam1.lead_angle"]),
    ('contacts = {values = ["2"]}', ["contacts is no real variable", "number"]),
    ('"cam1.radius" = {from = true, to = 1, count = 2}', ["from = True", "number, or text with a unit"]),
]


@pytest.mark.parametrize(("varied", "mentions"), SLIPS)
def test_a_slip_in_a_text_is_named(plan, design, varied, mentions):
    with refused(*mentions):
        read_study(plan(varied))
    with pytest.raises(DesignFileError) as caught:
        read_study(design(varied))
    assert all(mention in str(caught.value) for mention in mentions)


@pytest.mark.parametrize("entry, mentions", [
    ('{from = "5 mm", to = "9 N.m"}', ["from = '5 mm', to = '9 N.m'", "mm and N.m measure different things"]),
    ('{values = ["5 mm", 0.01, "1 s"]}', ["values = '5 mm', values = '1 s'", "mm and s"]),
    ('{distribution = "normal", mean = "5 mm", std = "1 deg"}', ["std = '1 deg'", "mm and deg"]),
    ('{distribution = "expon", arguments = {scale = "1 N"}, to = "9 m"}', ["to = '9 m', scale = '1 N'"]),
    ('{from = 1, to = 2, unit = "ells"}', ["unit = 'ells' is not known"]),
    ('{from = "5 mm", to = 0.01}', []),
    ('{from = "5 mm", to = "1 in"}', []),
    ('{distribution = "lognorm", arguments = {s = "15 %", scale = "3 mm"}, to = "9 mm"}', []),
])  # fmt: skip
def test_units_of_an_own_name_are_of_one_kind(plan, entry, mentions):
    """The FMU does not say the unit of a name that it does not have."""
    path = plan(f'own = {entry}\n[plan.derived]\n"cam1.radius" = "0.02 + 0 * own"')
    path.write_text(path.read_text().replace('kind = "grid"', 'kind = "random"\nruns = 4'))
    if mentions:
        with refused(*mentions):
            read_study(path)
    else:
        assert read_study(path).plan.count == 4


# ---- files without a study ----


def test_a_design_without_a_study_says_what_to_add(tmp_path, capsys):
    """With the lines that the message proposes the same file is a study."""
    path = write_template("minimal", tmp_path / "my.toml")
    assert main(["study", str(path), "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert "no section [study]" in said and "docs/use-studies.md" in said
    lines = re.search(r"^\[study\].*?(?=^docs/)", said, re.MULTILINE | re.DOTALL)[0]
    path.write_text(f"{path.read_text()}\n{lines}")
    assert main(["study", str(path), "--out", str(tmp_path / "out"), "--workers", "0"]) == 0
    assert len(read_results(tmp_path / "out" / "my")["run"]) == 4


def test_a_plan_with_a_slip_is_no_design(tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(f'fmu = "forward"\nresults = ["theta"]\n{SCENARIO}')
    with refused("the file lacks plan"):
        read_study(path)
    path.write_text(f'results = ["theta"]\n{SCENARIO}')
    with refused("the file lacks fmu, plan"):
        read_study(path)


def test_the_plan_in_the_help_runs(tmp_path, capsys):
    assert main(["study", "--help"]) == 0
    said = capsys.readouterr().out
    assert all(line.strip() in said for line in PLAN.splitlines())
    path = tmp_path / "plan.toml"
    path.write_text(textwrap.dedent(f"  {PLAN}"))
    assert tomllib.loads(path.read_text())["fmu"] == "forward"
    assert main(["study", str(path), "--out", str(tmp_path / "out"), "--workers", "0"]) == 0
    assert len(read_results(tmp_path / "out" / "plan")["run"]) == 8


# ---- numbers that look like another unit ----


def unit_warnings_of(path):
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        with suppress(StudyError):
            read_study(path)
    mine = [one for one in found if one.category is UnitWarning]
    of_plan = [one for one in mine if str(one.message).startswith("plan:")]
    assert all(one.filename == __file__ for one in of_plan), "the warning points at the user's line"
    return [str(one.message) for one in mine]


STRANGE = [
    ('"spring.stiffness" = {from = 1, to = 4, count = 2}', ["spring.stiffness = 4 N/m: this looks like N"]),
    ('"spring.stiffness" = {values = [2, 4e4]}', ["spring.stiffness = 2 N/m: this looks like N/mm"]),
    ('"initial.theta" = {from = 0, to = 80, count = 2}', ["initial.theta = 80 rad: this looks like degrees"]),
    ('"stop.upper" = {values = [75, 80]}', ["stop.upper = 80 rad: this looks like degrees"]),
    ('"cam1.lead_angle" = {from = 35, to = 50, count = 2}', ["cam1.lead_angle = 50 rad: this looks like"]),
    (
        '"cam1.friction" = {values = [8, 14]}\n"cam2.friction" = {same_as = "cam1.friction"}',
        ["cam1.friction = 14: this looks like percent"],
    ),
    ('stiff = {values = [1, 2]}\n"spring.stiffness" = {same_as = "stiff"}', ["spring.stiffness = 2 N/m"]),
    ('"spring.stiffness" = {values = ["2 N/m", "4 N/m"]}', []),
    ('"spring.stiffness" = {from = 1e4, to = 4e4, count = 2}', []),
    ('"cam1.radius" = {values = ["20 mm", "3 cm"]}', []),
    ('k = {values = [1, 2]}\n[plan.derived]\n"spring.stiffness" = "2 * k"', []),
]


@pytest.mark.parametrize(("varied", "words"), STRANGE)
def test_extreme_values_of_a_plan_get_the_unit_warning(plan, varied, words):
    found = unit_warnings_of(plan(varied))
    assert len(found) == len(words), found
    assert all(f"plan: {word}" in text for word, text in zip(words, found, strict=True)), found


def test_a_distribution_without_ends_gets_the_unit_warning(plan):
    path = plan('"spring.stiffness" = {distribution = "normal", mean = 30, std = 2}')
    path.write_text(path.read_text().replace('kind = "grid"', 'kind = "random"\nruns = 4'))
    (text,) = unit_warnings_of(path)
    assert "plan: spring.stiffness = 3" in text and "N/mm" in text


@pytest.mark.filterwarnings("default::dualcam.errors.UnitWarning")
def test_the_section_of_a_design_warns_once(design, capsys):
    path = design('"spring.stiffness" = {from = 1, to = 4, count = 2}')
    assert len(unit_warnings_of(path)) == 1
    assert main(["study", str(path), "--out", str(path.with_name("out")), "--workers", "0"]) == 0
    assert capsys.readouterr().err.count("looks like N/mm") == 1


def test_a_table_of_runs_warns_once(plan):
    path = plan("")
    text = path.read_text().partition("[plan]")[0] + '[plan]\nkind = "table"\ntable = "runs.csv"\n'
    path.write_text(text)
    path.with_name("runs.csv").write_text("spring.stiffness\n2\n4\n")
    (text,) = unit_warnings_of(path)
    assert "spring.stiffness = 4 N/m" in text
