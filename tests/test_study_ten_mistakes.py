"""Plans with ten mistakes of all kinds get ten messages at once: what the schema, the numbers, the FMU's
variables, files and times say stands in one list."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from study_cases import FORWARD

from dualcam.__main__ import main
from dualcam.study import StudyError, read_study

SOUND = """
fmu = "{fmu}"
results = ["theta@0.2", "efficiency", "top = max(theta, every=0.01)", "rest = 1 - top"]
[parameters]
"cam2.radius" = "21 mm"
"cam1.profile" = 3
"stop.upper" = 1.0
[plan]
kind = "latin"
runs = 100
seed = 3
[plan.vary]
peak = {{ distribution = "normal", mean = "8 N.m", std = 1.0, from = 5 }}
push = {{ from = "100 ms", to = "200 ms" }}
wire = {{ from = "1.9 mm", to = "2.1 mm" }}
coils = {{ values = [4, 5], weights = [1, 3] }}
"cam1.radius" = {{ from = "19 mm", to = "21 mm" }}
"spring.preload" = {{ distribution = "lognorm", arguments = {{ s = 0.5, scale = "60 N" }}, to = 200 }}
"cam1.friction" = {{ from = 0.1, to = 0.2 }}
"cam2.friction" = {{ from = 0.1, to = 0.2 }}
"cam2.lead_angle" = {{ from = "40 deg", to = "50 deg" }}
"cam1.friction_peak" = {{ from = 1.0, to = 1.2 }}
"cam2.friction_peak" = {{ same_as = "cam1.friction_peak" }}
"cam1.table" = {{ table = "groove.csv", deviation = "0.01 mm", correlation_length = "10 deg", count = 3 }}
[plan.derived]
"spring.stiffness" = "'79 GPa' * wire^4 / (8 * '20 mm'^3 * coils)"
[plan.constraints]
soft = "spring.stiffness < 5400"
[[plan.correlation]]
of = ["cam1.friction", "cam2.friction"]
rank = 0.8
[[plan.correlation]]
of = ["cam1.radius", "spring.preload"]
pearson = 0.3
[scenario]
stop = 0.4
tolerance = 1e-9
inputs.tau = {{ time = [0.0, "push", "push"], value = ["peak", "peak", 0.0] }}
inputs.F_ext = {{ time = [0.0, 0.1, 0.2], value = [0.0, 1.0, 0.0] }}
[[plots]]
kind = "pareto"
x = "efficiency"
y = "top"
"""


@dataclass(frozen=True)
class Mistake:
    """What is replaced in SOUND, by what, and what is told.

    `key`: of several mistakes with the same key only one can be made. `needs`: keys that must be sound, since
    the mistake shows in values that follow from theirs."""

    key: str
    old: str
    new: str
    told: tuple[str, ...]
    needs: frozenset[str]


def mistake(key, old, new, *told, needs=()):
    return Mistake(key, old, new, told, frozenset(needs))


MISTAKES = [
    # what the schema refuses
    mistake("seed", "seed = 3", "seed = 3.5", "plan: seed = 3.5: allowed is a whole number"),
    mistake("runs", "runs = 100", "rums = 100", "plan has rums: did you mean runs?"),
    mistake("tolerance", "tolerance = 1e-9", "tolerence = 1e-9", "scenario has tolerence", "tolerance?"),
    mistake("weights", "weights = [1, 3]", 'weights = "even"', "coils: weights = 'even'", "list of numbers"),
    # numbers, distributions, correlations
    mistake("kind", 'kind = "latin"', 'kind = "lattin"', "kind = 'lattin'", "did you mean latin"),
    mistake("peak", '"normal", mean', '"nomal", mean', "peak: distribution = 'nomal'", "normal"),
    mistake("peak", "std = 1.0, ", "", "peak: distribution normal lacks std"),
    mistake("push", 'from = "100 ms"', 'from = "300 ms"', "push: from 0.3 to 0.2", "first below the second"),
    mistake("push", 'to = "200 ms"', 'to = "200 N"', "push: from = '100 ms', to = '200 N'", "ms and N"),
    mistake("wire", 'from = "1.9 mm"', 'from = "1.9 ells"', "wire: from = '1.9 ells'", "not known"),
    mistake("rank", "rank = 0.8", "rank = 1.7", "correlation: rank = 1.7", "above -1 and below 1"),
    mistake("rank", '["cam1.friction",', '["cam1.frction",', "cam1.frction does not", "mean cam1.friction"),
    mistake("pearson", "pearson = 0.3", "pearson = 0.9999", "these distributions allow"),
    mistake("same", '"cam1.friction_peak" }}', '"cam1.frction_peak" }}', "cam1.frction_peak does not vary"),
    # formulas
    mistake("derived", "/ (8 *", "/ (8 + *", "derived: spring.stiffness", "is no formula"),
    mistake("derived", "'79 GPa'", "-'79 GPa'", "derived, is -", "100 %", needs=["wire", "weights"]),
    mistake("soft", 'soft = "spring.stiffness', 'soft = "spring.stifness', "constraints: soft", "stifness"),
    mistake("tau", '["peak", "peak"', '["peak", "paek"', "scenario: a formula uses paek", "mean peak?"),
    # the FMU's variables
    mistake("lead", '"40 deg"', '"40 mm"', "cam2.lead_angle: from = '40 mm'", "rad or a multiple"),
    mistake("lead", '"cam2.lead_angle"', '"cam2.lead_angel"', "cam2.lead_angel is no variable", "lead_angle"),
    mistake("friction", '"cam2.friction" = {{ from = 0.1', '"cam2.friction" = {{ from = -0.1', "33.3 %"),
    mistake("radius", '"cam2.radius" = "21 mm"', '"cam2.radios" = "21 mm"', "cam2.radios", "cam2.radius"),
    mistake("radius", '"cam2.radius" = "21 mm"', '"cam2.radius" = "21 s"', "cam2.radius = '21 s'", "length"),
    mistake("radius", '"cam2.radius" = "21 mm"', '"cam2.radius" = -0.02', "cam2.radius = -0.02", "allows"),
    mistake("input", "inputs.F_ext", "inputs.F_est", "F_est", "did you mean F_ext"),
    mistake("result", '"efficiency", "top', '"efficency", "top', "efficency", "did you mean efficiency"),
    # files and times
    mistake("table", '"groove.csv"', '"grove.csv"', "no file grove.csv in the folder", "mean groove.csv"),
    mistake("table", '"groove.csv"', '"fallen.csv"', "cam1.table", "fallen.csv"),
    mistake("at", '"theta@0.2"', '"theta@0.9"', "result 'theta@0.9'", "a time from 0 to 0.4 s"),
    mistake("top", "every=0.01", "every=-1", "result 'top = max(theta, every=-1)'", "every=SECONDS"),
    mistake("order", "[0.0, 0.1, 0.2]", "[0, 0.2, 0.1]", "times must increase: 0.1 s comes after 0.2 s"),
    # pictures
    mistake("plot", 'y = "top"', 'y = "topp"', "plot pareto: 'topp' is no column", "did you mean top"),
]  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With a groove table, and one that falls."""
    place = tmp_path_factory.mktemp("plans")
    psi = np.linspace(0.0, 1.0, 41)
    for name, z in (("groove", 0.02 * psi), ("fallen", 0.02 * (psi - psi**2))):
        table = np.column_stack([psi, z])
        np.savetxt(place / f"{name}.csv", table, "%.17g", ",", header="psi_rad,z_m", comments="")
    return place


def told(path, read=read_study):
    """All messages about a file."""
    try:
        read(path)
    except StudyError as error:
        return list(error.problems)
    return []


def problems(folder, mistakes, sound=SOUND, read=read_study):
    """All messages about a plan with these mistakes."""
    text = sound
    for each in mistakes:
        assert text.count(each.old) == 1, each
        text = text.replace(each.old, each.new)
    path = folder / "plan.toml"
    path.write_text(text.format(fmu=FORWARD))
    return told(path, read)


def assert_told_once_each(found, mistakes):
    left = list(found)
    for each in mistakes:
        own = [problem for problem in left if all(word in problem for word in each.told)]
        assert len(own) == 1, (each, found)
        left.remove(own[0])
    assert not left, left


def test_the_plan_without_a_mistake_is_sound(folder):
    assert problems(folder, []) == []


@pytest.mark.parametrize("one", MISTAKES, ids=lambda one: one.told[0])
def test_one_mistake_gets_one_message(folder, one):
    assert_told_once_each(problems(folder, [one]), [one])


def chosen(*words):
    """Mistakes by a word of what is told."""
    found = [next(each for each in MISTAKES if any(word in text for text in each.told)) for word in words]
    assert len({each.key for each in found}) == len(words)
    return found


TEN = {
    "former stages mixed": chosen(
        "seed", "nomal", "rank = 1.7", "is no formula", "40 mm", "cam2.radios", "F_est", "grove.csv",
        "theta@0.9", "comes after",
    ),
    "names with a slip": chosen(
        "rums", "tolerence", "lattin", "cam1.frction does", "cam1.frction_peak", "stifness", "paek",
        "cam2.lead_angel", "efficency", "topp",
    ),
    "values that cannot be": chosen(
        "even", "lacks std", "push: from 0.3", "1.9 ells", "these distributions", "33.3 %", "21 s",
        "fallen.csv", "every=-1", "comes after",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", TEN)
def test_ten_mistakes_get_ten_messages(folder, name):
    found = problems(folder, TEN[name])
    assert len(found) == 10
    assert_told_once_each(found, TEN[name])


def test_the_command_tells_them(folder, tmp_path, capsys):
    problems(folder, TEN["former stages mixed"])
    assert main(["study", str(folder / "plan.toml"), "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert "plan.toml: 10 mistakes" in said and said.count("\n") == 11
    assert not (tmp_path / "out").exists()


@st.composite
def subsets(draw):
    """Mistakes of different keys."""
    keys = draw(st.sets(st.sampled_from(sorted({each.key for each in MISTAKES})), min_size=2, max_size=12))
    found = [draw(st.sampled_from([each for each in MISTAKES if each.key == key])) for key in sorted(keys)]
    return [each for each in found if not each.needs & keys]


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(mistakes=subsets())
def test_any_mistakes_get_their_messages_and_no_others(folder, mistakes):
    assert_told_once_each(problems(folder, mistakes), mistakes)
