"""Design files and study plans with random mistakes: each gives a design, a plan, or an error."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from study_cases import FORWARD, SOUND_PLAN, write_groove

from dualcam.design_file import TEMPLATES, read_design, write_template
from dualcam.errors import DualcamError
from dualcam.study import read_study

PLAN = SOUND_PLAN.lstrip()
for plain, richer in (
    ('"cam1.friction" = {{ from = 0.1,', '"cam1.friction" = {{ log = true, from = 0.1,'),
    ('"cam2.friction" = {{ from = 0.1, to = 0.2 }}', '"cam2.friction" = {{ values = [0.1, 0.14, 0.2] }}'),
    ('"cam1.friction", "cam2.friction"]', '"cam1.friction", "push"]'),
):
    assert plain in PLAN
    PLAN = PLAN.replace(plain, richer)

# What a mistake puts in the place of a value, of a key or of a part of a line.
ODD = [
    "true", "[]", "{}", "[[1]]", '""', '["a", 1, true]', "{time = [0], value = [1]}", '"a" * 3', "1979-05-27",
    "0x7f", "1e400", "-0.0", '"1e999 m"', '"10 mm^9^9"', '"9^9^9^9"', '"(((((1)))))"', '"theta@"', '"max("',
]  # fmt: skip
VALUES = st.one_of(
    st.integers().map(str),
    st.floats().map(repr),
    st.text(max_size=12).map(lambda text: json.dumps(text).replace("\x7f", "\\u007f")),
    st.sampled_from(ODD),
)
CHARACTERS = st.text(alphabet="[]{}\"'=.,#\n\\ @^*(0a\u00e9\x00", min_size=1, max_size=3)


KINDS = ("value", "value", "value", "key", "drop", "twice", "cut", "insert")
KEYS = ("x", '"tau"', "plan", "fmu", '"cam1.table"', "a.b.c")


def mistaken(draw, line):
    """The line with a mistake in it."""
    kind = draw(st.sampled_from(KINDS))
    name, equals, value = line.partition("=")
    if kind == "value" and equals:
        return f"{name}= {draw(VALUES)}"
    if kind == "key" and equals:
        return f"{draw(st.sampled_from(KEYS))} ={value}"
    if kind == "drop":
        return ""
    if kind == "twice":
        return f"{line}\n{line}"
    place = draw(st.integers(0, len(line)))
    return line[:place] if kind == "cut" else line[:place] + draw(CHARACTERS) + line[place:]


@st.composite
def mutated(draw, text):
    """The text with one to three mistakes in it."""
    lines = text.split("\n")
    for _ in range(draw(st.integers(1, 3))):
        at, other = (draw(st.integers(0, len(lines) - 1)) for _ in range(2))
        lines[at] = mistaken(draw, lines[at])
        if draw(st.integers(0, 7)) == 0:
            lines[at], lines[other] = lines[other], lines[at]
    return "\n".join(lines)


def read_or_error(read, path, text):
    """Any other error than one of this package fails the test, and so does an empty message."""
    path.write_bytes(text.encode("utf-8", "replace"))
    try:
        return read(path)
    except DualcamError as error:
        assert str(error).strip() and path.name in str(error), str(error)
        return None


EXHAUSTING = [
    *("x = " + "[" * 20_000, "x = " + "{a=" * 20_000, "a." * 20_000 + "b = 1"),  # deep
    *("x = 1" + "0" * 5000, "\x00"),
]
SHORT = settings.default.max_examples <= 1000
FEW = settings(max_examples=50 if SHORT else 5_000, deadline=None)


@pytest.fixture(scope="module")
def plan(tmp_path_factory):
    """The path of a plan, beside the table that it names."""
    folder = tmp_path_factory.mktemp("plan")
    write_groove(folder)
    path = folder / "mutated_plan.toml"
    path.write_text(PLAN.format(fmu=FORWARD))
    assert read_study(path).plan.count == 100
    return path


@FEW
@given(text=mutated(PLAN.format(fmu=FORWARD)))
def test_mistakes_in_a_plan_give_a_study_or_an_error(plan, text):
    study = read_or_error(read_study, plan, text)
    assert study is None or study.plan.count >= 1


@pytest.fixture(scope="module")
def templates(tmp_path_factory):
    folder = tmp_path_factory.mktemp("templates")
    return {
        name: write_template(name, folder / f"{name}.toml").read_text(encoding="utf-8") for name in TEMPLATES
    }


@FEW
@given(data=st.data())
def test_mistakes_in_a_design_give_a_design_or_an_error(templates, tmp_path_factory, data):
    text = data.draw(mutated(templates[data.draw(st.sampled_from(sorted(TEMPLATES)))]))
    read_or_error(read_design, tmp_path_factory.getbasetemp() / "mutated_design.toml", text)


@pytest.mark.parametrize("read", [read_study, read_design])
@pytest.mark.parametrize("text", EXHAUSTING)
def test_texts_that_wear_a_reader_out_are_refused(tmp_path, read, text):
    assert read_or_error(read, tmp_path / "long.toml", text) is None
