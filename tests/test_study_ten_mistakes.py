"""One mistake in a plan file gets one message. Many mistakes get all messages of a stage at once: what the
schema refuses; else what is wrong with values, files and formulas; else what the FMU does not have or allow;
else the columns of pictures."""

from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from study_cases import FORWARD, SOUND_PLAN, write_groove

from dualcam.__main__ import main
from dualcam.errors import DesignFileError, StudyError
from dualcam.study import read_optimisation, read_study


@dataclass(frozen=True)
class Mistake:
    """What is replaced in the plan, by what, and what is told, in which stage.

    `key`: of several mistakes with the same key only one can be made. `needs`: keys that must be sound, since
    the mistake shows in values that follow from theirs."""

    stage: int
    key: str
    old: str
    new: str
    told: tuple[str, ...]
    needs: frozenset[str]


SCHEMA, VALUES, FMU, PICTURES = range(4)


def mistake(stage, key, old, new, *told, needs=()):
    return Mistake(stage, key, old, new, told, frozenset(needs))


schema, values, fmu, pictures = (partial(mistake, stage) for stage in range(4))
alone = partial(mistake, SCHEMA, "")


def told_first(mistakes):
    """Those of the first stage with any."""
    return [each for each in mistakes if each.stage == min(one.stage for one in mistakes)]


MISTAKES = [
    # what the schema refuses
    schema("seed", "seed = 3", "seed = 3.5", "plan: seed = 3.5: allowed is a whole number"),
    schema("runs", "runs = 100", "rums = 100", "plan has rums: did you mean runs?"),
    schema("tolerance", "tolerance = 1e-9", "tolerence = 1e-9", "scenario has tolerence", "tolerance?"),
    schema("weights", "weights = [1, 3]", 'weights = "even"', "coils: weights = 'even'", "list of numbers"),
    # numbers, distributions, correlations
    values("kind", 'kind = "latin"', 'kind = "lattin"', "kind = 'lattin'", "did you mean latin"),
    values("peak", '"normal", mean', '"nomal", mean', "peak: distribution = 'nomal'", "normal"),
    values("peak", "std = 1.0, ", "", "peak: distribution normal lacks std"),
    values("push", 'from = "100 ms"', 'from = "300 ms"', "push: from 0.3 to 0.2", "first below the second"),
    values("push", 'to = "200 ms"', 'to = "200 N"', "push: from = '100 ms', to = '200 N'", "ms and N"),
    values("wire", 'from = "1.9 mm"', 'from = "1.9 ells"', "wire: from = '1.9 ells'", "not known"),
    values("rank", "rank = 0.8", "rank = 1.7", "correlation: rank = 1.7", "above -1 and below 1"),
    values("rank", '["cam1.friction",', '["cam1.frction",', "cam1.frction does not", "mean cam1.friction"),
    values("pearson", "pearson = 0.3", "pearson = 0.9999", "these distributions allow"),
    values("same", '"cam1.friction_peak" }}', '"cam1.frction_peak" }}', "cam1.frction_peak does not vary"),
    values("same", '{{ from = 1.0, to = 1.2 }}', '{{ from = 1.3, to = 1.2 }}', "_peak: from 1.3"),
    # formulas
    values("derived", "/ (8 *", "/ (8 + *", "derived: spring.stiffness", "is no formula"),
    fmu("derived", "'79 GPa'", "-'79 GPa'", "derived, is -", "100 %", "Change the formula",
        needs=["wire", "weights"]),
    values("soft", 'soft = "spring.stiffness', 'soft = "spring.stifness', "constraints: soft", "stifness"),
    fmu("tau", '["peak", "peak"', '["peak", "paek"', "scenario: a formula uses paek", "mean peak?"),
    # the FMU's variables
    values("lead", '"40 deg"', '"40 mm"', "cam2.lead_angle: from = '40 mm'", "rad or a multiple"),
    fmu("lead", '"cam2.lead_angle"', '"cam2.lead_angel"', "cam2.lead_angel is no variable", "lead_angle"),
    fmu("friction", '"cam2.friction" = {{ from = 0.1', '"cam2.friction" = {{ from = -0.1', "33.3 %"),
    fmu("radius", '"cam2.radius" = "21 mm"', '"cam2.radios" = "21 mm"', "cam2.radios", "cam2.radius"),
    values("radius", '"cam2.radius" = "21 mm"', '"cam2.radius" = "21 s"', "cam2.radius = '21 s'", "length"),
    fmu("radius", '"cam2.radius" = "21 mm"', '"cam2.radius" = -0.02', "cam2.radius = -0.02", "allows"),
    fmu("input", "inputs.F_ext", "inputs.F_est", "F_est", "did you mean F_ext"),
    fmu("result", '"efficiency", "top', '"efficency", "top', "efficency", "did you mean efficiency"),
    # files and times
    values("table", '"groove.csv"', '"grove.csv"', "no file grove.csv in the folder", "mean groove.csv"),
    values("table", '"groove.csv"', '"fallen.csv"', "cam1.table", "fallen.csv"),
    fmu("at", '"theta@0.2"', '"theta@0.9"', "result 'theta@0.9'", "a time from 0 to 0.4 s"),
    values("top", "every=0.01", "every=-1", "'top = max(theta, every=-1)'", "every=SEC", needs=["order"]),
    values("order", "[0.0, 0.1, 0.2]", "[0, 0.2, 0.1]", "times must increase: 0.1 s comes after 0.2 s"),
    # pictures
    pictures("plot", 'y = "top"', 'y = "topp"', "plot pareto: 'topp' is no column", "did you mean top"),
]  # fmt: skip


ALONE = [  # tables and keys on which much depends, and mistakes that are tried without others
    alone("[scenario]", "[scenarix]", "the file has scenarix: did you mean scenario?"),
    alone("[scenario]\nstop", "[scenario]\nstopp", "scenario has stopp: did you mean stop"),
    alone("[plan.vary]", "[plan.varx]", "plan has varx: did you mean vary?"),
    alone("[plan.derived]", "[plan.derivedd]", "plan has derivedd: did you mean derived?"),
    alone('time = [0.0, "push", "push"]', "time = 1.0",
          "tau: time = 1.0: allowed is a list of one or more of"),
    alone('value = ["peak", "peak", 0.0]', 'valu = ["peak", "peak", 0]', "tau has valu: did you mean value?"),
    alone('inputs.tau = {{ time = [0.0, "push", "push"], value = ["peak", "peak", 0.0] }}',
          "inputs.tau = true", "scenario: inputs: tau = True: allowed is a table"),
    alone('peak = {{ distribution = "normal", mean = "8 N.m", std = 1.0, from = 5 }}', "peak = 3",
          "plan: vary: peak = 3: allowed is a table"),
    alone('kind = "latin"', "kind = 3", "plan: kind = 3: allowed is a text"),
    alone('fmu = "{fmu}"', 'fmu = "forwrd"', "forwrd", "forward"),
    alone('"efficiency", "top', '"thetta@0.1", "efficiency", "top', "no variable 'thetta'"),
    alone('x = "efficiency"', 'xx = "efficiency"', "plot pareto has xx: did you mean x?"),
    alone("rank = 0.8", 'rank = "much"', "correlation 1: rank = 'much': allowed is a number"),
    alone('stop = "400 ms"', 'stop = "400 mm"', "stop = '400 mm'", "no unit of time", "10 ms"),
    alone('kind = "latin"', "", "plan lacks kind"),
    alone('kind = "latin"', 'kind = "latin"\nlevels = 3.5', "levels = 3.5", "whole number"),
    alone('kind = "latin"', 'kind = "fast"', "correlation in a plan of kind fast", "random, latin, sobol"),
    alone("std = 1.0", "sdt = 1.0", "plan: peak has sdt", "did you mean std"),
    alone("std = 1.0", "std = -1.0", "peak", "std = -1", "scipy.stats allows no such values"),
    alone("from = 5", "from = 50, to = 60", "peak", "no probability"),
    alone('wire = {{ from = "1.9 mm"', 'wire = {{ log = 1, from = "1.9 mm"', "wire: log = 1",
          "true or false"),
    alone('wire = {{ from = "1.9 mm"', 'wire = {{ values = [1e-3], from = "1.9 mm"', "values has from, to"),
    alone("[plan.vary]", '[plan.vary]\n"cam1.radios" = {{ values = [1] }}', "cam1.radios", "cam1.radius"),
    alone('"cam2.friction" = {{ from = 0.1, to = 0.2 }}', '"cam2.friction" = 0.1', "cam2.friction = 0.1"),
    alone('of = ["cam1.friction", ', "of = [", "correlation of cam2.friction", "two names"),
    alone("rank = 0.8", "rank = 0.8\npearson = 0.7", "one of rank and pearson"),
    alone("rank = 0.8", "rang = 0.8", "correlation 1 has rang", "did you mean rank"),
    alone("[plan.constraints]", "[plan.constraints]\nhard = 'wire > thickness'", "hard", "thickness"),
    alone("[plan.derived]", "[plan.derived]\nwire = 'push'", "wire varies and is derived"),
    alone("[plan.derived]", "[plan.derived]\na = 'b'\nb = 'a'", "a, b use each other in a circle"),
    alone('value = ["peak", "peak", 0.0]', 'value = ["peak", 0.0]', "tau", "2 values at 3 times"),
    alone("inputs.tau = {{ time", "inputs.tau = {{ shape = 'wavy', time", "tau", "shape 'wavy'", "sine"),
    alone("inputs.tau = {{ time", "inputs.tau = {{ amplitude = 3, time", "tau", "belong to shape"),
    alone("[parameters]", "[parameters]\npush = 0.2", "push"),
    alone('"cam2.radius" = "21 mm"', '"cam1.friction" = 0.1', "cam1.friction varies and is fixed too"),
    alone('"cam2.radius" = "21 mm"', '"tau" = 0.1', "tau has a history and a value of its own"),
    alone("runs = 100", "runs = 100\non_violation = 'forget'", "on_violation = 'forget'", "redraw, mark"),
    alone("[plan.derived]", "[plan.derived]\npi = '3'", "pi is a constant"),
]  # fmt: skip
ALONE_IN_SEARCH = [
    alone("[optimise]", "[optimisy]", "the file has optimisy: did you mean optimise?"),
    alone("[plan.vary]", "[plan.varx]", "plan has varx: did you mean vary?"),
    alone('"cam1.lead_angle" = {{ from', '"cam1.lead_angel" = {{ from', "cam1.lead_angel is no variable"),
    alone('objectives."torque_load@0.0005" = "maximise"', "objectives = 3",
          "objectives = 3: allowed is a table"),
]  # fmt: skip

SEARCH = """
fmu = "{fmu}"
results = ["torque_release"]
[parameters]
"spring.preload" = "60 N"
[plan.vary]
"cam1.lead_angle" = {{ from = "20 deg", to = "70 deg" }}
"cam2.lead_angle" = {{ same_as = "cam1.lead_angle" }}
"cam1.radius" = {{ from = "15 mm", to = "25 mm" }}
"spring.stiffness" = {{ values = [4e4, 5e4] }}
"cam1.friction" = {{ distribution = "normal", mean = 0.14, std = 0.01 }}
[plan.constraints]
slender = "cam1.radius < 1"
[scenario]
stop = 0.001
inputs.tau = {{ time = [0.0, 0.001], value = [0.0, 1.0] }}
[optimise]
objectives."torque_load@0.0005" = "maximise"
constraints.efficiency = {{ from = 0.5 }}
constraints."peak.reaction1" = {{ from = "1 N", to = "200 N" }}
tolerances."cam2.radius" = {{ plus_minus = "0.1 mm", shape = "uniform" }}
method = "evolution"
budget = 100
percentile = 90
start."cam1.lead_angle" = "30 deg"
"""
BOUNDS = ["angle", "same", "radius", "chance", "slender"]  # without it no bounds of a start
MISTAKES_OF_SEARCH = [
    values("fixed", '"60 N"', '"60 mm"', "spring.preload = '60 mm'", "force"),
    values("angle", '"20 deg"', '"80 deg"', "cam1.lead_angle: from 1.39626 to 1.22173", needs=["start"]),
    values("same", 'same_as = "cam1.lead_angle"', 'same_as = "cam1.led_angle"', "cam1.led_angle does not"),
    values("radius", '"15 mm"', '"15 N"', "cam1.radius: from = '15 N'", "length"),
    fmu("choice", "[4e4, 5e4]", "[4e4, -1]", "spring.stiffness from -1 to 40000", "the FMU allows 0"),
    values("chance", '"normal"', '"nomal"', "distribution = 'nomal'", "did you mean normal"),
    values("slender", '"cam1.radius < 1"', '"cam1.radius <"', "constraints: slender", "is no formula"),
    values("stop", "stop = 0.001", 'stop = "1 mm"', "stop = '1 mm'", "no unit of time", needs=["at"]),
    values("order", "[0.0, 0.001]", "[0.001, 0.0]", "times must increase: 0 s comes after 0.001 s"),
    fmu("at", "torque_load@0.0005", "torque_load@0.5", "torque_load@0.5", "from 0 to 0.001 s"),
    values("way", '"maximise"', '"maximize"', "'maximize': did you mean maximise"),
    schema("limit", "efficiency = {{ from", "efficiency = {{ form", "has form: did you mean from?"),
    fmu("other", "constraints.efficiency", "constraints.efficency", "'efficency'", "mean efficiency"),
    values("force", '"1 N"', '"300 N"', "peak.reaction1 from 300 to 200", "first must not"),
    values("made", '"0.1 mm"', '"-0.1 mm"', "tolerances: cam2.radius: plus_minus = -0.0001", "above 0"),
    values("made", '"uniform"', '"unifrom"', "tolerances: cam2.radius: shape = 'unifrom'", "mean uniform"),
    values("method", '"evolution"', '"evoluton"', "optimise: method = 'evoluton'", "did you mean evolution"),
    schema("budget", "budget = 100", "budgets = 100", "optimise has budgets: did you mean budget?"),
    values("percentile", "percentile = 90", "percentile = 100", "percentile = 100", "between 0 and 100 %"),
    values("start", '"30 deg"', '"10 deg"', "start: cam1.lead_angle = 10 deg", "20 deg to 70", needs=BOUNDS),
    fmu("result", '"torque_release"', '"torque_releas"', "no variable 'torque_releas'"),
]  # fmt: skip

PLANS = {"study": (SOUND_PLAN, read_study), "search": (SEARCH, read_optimisation)}
each_plan = pytest.mark.parametrize("plan", PLANS)
EACH = {
    f"{plan}, {' '.join(one.told)}": (plan, one)
    for plan, mistakes in (
        ("study", MISTAKES + ALONE), ("search", MISTAKES_OF_SEARCH + ALONE_IN_SEARCH),
    )
    for one in mistakes
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """With a groove table, and one that falls."""
    place = tmp_path_factory.mktemp("plans")
    write_groove(place)
    psi = np.linspace(0.0, 1.0, 41)
    table = np.column_stack([psi, 0.02 * (psi - psi**2)])
    np.savetxt(place / "fallen.csv", table, "%.17g", ",", header="psi_rad,z_m", comments="")
    return place


def told(path, read=read_study):
    """All messages about a file."""
    try:
        read(path)
    except StudyError as error:
        return list(error.problems)
    return []


def problems(folder, mistakes, plan="study"):
    """All messages about a plan with these mistakes."""
    text, read = PLANS[plan]
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


@pytest.mark.parametrize("plan, changes", [
    ("study", []), ("study", [alone("'20 mm'^3", "'20 m'^3")]), ("search", []),  # a soft spring is allowed
])  # fmt: skip
def test_a_plan_without_a_mistake_is_sound(folder, plan, changes):
    assert problems(folder, changes, plan) == []


@pytest.mark.parametrize("name", EACH)
def test_one_mistake_gets_one_message(folder, name):
    """And what follows from a refused table or key is not told."""
    plan, one = EACH[name]
    assert_told_once_each(problems(folder, [one], plan), [one])


def chosen(*words):
    """Mistakes by a word of what is told."""
    found = [next(each for each in MISTAKES if any(word in text for text in each.told)) for word in words]
    assert len({each.key for each in found}) == len(words)
    return found


MANY = {
    "schema": chosen("seed", "rums", "tolerence", "even"),
    "names and texts": chosen(
        "lattin", "nomal", "cam1.frction does", "cam1.frction_peak", "stifness", "is no formula", "1.9 ells",
        "40 mm", "21 s", "grove.csv", "comes after",
    ),
    "values that cannot be": chosen(
        "lacks std", "push: from 0.3", "1.9 ells", "rank = 1.7", "these distributions", "21 s", "fallen.csv",
        "every=-1",
    ),
    "fmu": chosen(
        "derived, is -", "paek", "cam2.lead_angel", "33.3 %", "cam2.radios", "F_est", "efficency",
        "theta@0.9",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", MANY)
def test_all_mistakes_of_a_stage_get_their_messages(folder, name):
    assert_told_once_each(problems(folder, MANY[name]), MANY[name])


def test_a_stage_begins_where_the_one_before_finds_nothing(folder):
    stages = [*list(MANY.values())[::3], chosen("topp")]
    for k in range(2):
        one = [stage[0] for stage in stages[k:]]
        assert_told_once_each(problems(folder, one), one[:1])


def test_the_command_tells_them(folder, tmp_path, capsys):
    problems(folder, MANY["names and texts"])
    assert main(["study", str(folder / "plan.toml"), "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert "plan.toml: 11 mistakes" in said and said.count("\n") == 12
    assert not (tmp_path / "out").exists()


@st.composite
def subsets(draw, mistakes):
    """Mistakes of different keys."""
    keys = draw(st.sets(st.sampled_from(sorted({each.key for each in mistakes})), min_size=2, max_size=12))
    found = [draw(st.sampled_from([each for each in mistakes if each.key == key])) for key in sorted(keys)]
    return [each for each in found if not each.needs & keys]


@pytest.mark.parametrize("stage", [SCHEMA, VALUES, FMU])
def test_all_mistakes_of_a_stage_of_a_search_get_their_messages(folder, stage):
    """Of the mistakes that do not depend on each other."""
    own = {each.key: each for each in MISTAKES_OF_SEARCH if each.stage == stage and not each.needs}
    found = problems(folder, list(own.values()), "search")
    assert_told_once_each(found, list(own.values()))


@each_plan
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_any_mistakes_get_their_messages_and_no_others(folder, plan, data):
    mistakes = data.draw(subsets(MISTAKES if plan == "study" else MISTAKES_OF_SEARCH))
    assert_told_once_each(problems(folder, mistakes, plan), told_first(mistakes))


PAIR = [("one", SOUND_PLAN, ("rank = 0.8", "rank = 1.7")), ("two", SEARCH, ("= 90", "= 100"))]


def test_the_command_tells_the_mistakes_of_all_files(folder, tmp_path, capsys):
    """Before the first run of any of them."""
    for name, text, words in PAIR:
        (folder / f"{name}.toml").write_text(text.replace(*words).format(fmu=FORWARD))
    paths = [str(folder / f"{name}.toml") for name in ("one", "two")]
    assert main(["study", *paths, "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert "one.toml: plan: correlation: rank = 1.7" in said and "two.toml: optimise: percentile" in said
    assert not (tmp_path / "out").exists()


# ---- design files ----

DESIGN = """
[cam1]
radius = "25 ells"
lead_angle = "40 deg"
[scenario]
stop = 0.1
[study]
results = ["thetta", "theta@0.5"]
[study.plan]
kind = "lattin"
runs = 10
[study.plan.vary]
"cam1.friction" = {from = -0.1, to = 0.2}
"cam2.frction" = {from = 0.1, to = 0.2}
push = {from = "5 mm", to = "9 N.m"}
"""


@pytest.mark.parametrize("optimise", [False, True])
def test_a_design_file_tells_its_own_mistakes_and_those_of_its_study(tmp_path, optimise):
    """Of the study those of a stage: the schema first, then values, then what the FMU says."""
    path = tmp_path / "my.toml"
    text = DESIGN + ('[study.optimise]\nobjectives.efficency = "maximise"' if optimise else "")
    values = ["mm and N.m"] + ([] if optimise else ["did you mean latin"])
    sound = text.replace("5 mm", "5 N.m").replace("lattin", "latin").replace("push", '"cam1.friction_peak"')
    sound = sound.replace('"5 N.m", to = "9 N.m"', "1.0, to = 1.2")
    fmu = ["'thetta'", "theta@0.5", "cam1.friction from -0.1", "cam2.frction"]
    fmu += ["'efficency'"] if optimise else []
    slips = text.replace("runs = 10", "run = 10").replace('frction" = {from', 'frction" = {form')
    for content, words in ((slips, ["runs?", "from?"]), (text, values), (sound, fmu)):
        path.write_text(content)
        with pytest.raises(DesignFileError) as caught:
            (read_optimisation if optimise else read_study)(path)
        said = str(caught.value)
        count = [f"{len(words)} mistakes"] if len(words) > 1 else []
        assert all(word in said for word in ["2 errors", "25 ells", *words, *count]), said
