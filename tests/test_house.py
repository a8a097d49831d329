"""The structure of the source tree: rooms of fmu_src and dualcam, words, lengths, imports of Python files.

The rules are the tables at the top of support/house.py, and the docstrings of the rooms of dualcam
(support/python_rooms.py). Each check runs on this repository, on a small tree
that keeps all rules, and on one small tree for each way to break a rule.
"""

from pathlib import Path

import house
import pytest
import python_rooms
from driver import ROOT
from house import MAIN_HEADER, MAY_INCLUDE, MOST_PAIRS, circle, is_abandoned, words_of
from longest_files import LONGEST_FILES

CHECKS = {**house.CHECKS, **python_rooms.CHECKS}


@pytest.mark.parametrize("check", CHECKS)
def test_this_repository(check):
    found = CHECKS[check](ROOT)
    assert not found, "\n" + "\n".join(found)


def test_the_longest_files_of_tests_exist():
    names = {path.name for path in (ROOT / "tests").rglob("test_*.py")}
    assert set(LONGEST_FILES) - names == set(), "rename them in tests/support/longest_files.py too"


def test_messages_print_the_shortest_digits():
    """By shortest_decimal() of fault.h: 17 digits show 0.1 as 0.10000000000000001."""
    files = sorted((ROOT / "fmu_src").rglob("*.[ch]"))
    assert [file.name for file in files if "%.17g" in file.read_text(encoding="utf-8")] == []


# ---- small trees ----


def write(root: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        path = root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def include(name: str) -> str:
    return f'#include "{name}"\n'


def header(room: str) -> str:
    """A main header that describes its room."""
    allowed = ", ".join(MAY_INCLUDE[room]) or "no other room"
    return f"/* This room holds what the tests of the checker need. May include: {allowed}. */\n"


@pytest.fixture
def tree(tmp_path) -> Path:
    """Keeps every rule; each room includes the main headers of all rooms from which it may."""
    write(tmp_path, {f"fmu_src/{name}": header(room) for room, name in MAIN_HEADER.items()})
    for room, others in MAY_INCLUDE.items():
        lines = [include(MAIN_HEADER[other]) for other in (room, *others) if other in MAIN_HEADER]
        write(tmp_path, {f"fmu_src/{room}/work.c": "".join(lines) + include("variables.def")})
    write(
        tmp_path,
        {
            "fmu_src/variables.def": "VARIABLE(theta)\n",
            "fmu_src/tools/build.py": "import sys\n\nsys.path.append('.')\n",
            "dualcam/__init__.py": "from dualcam.upper import near\n",
            "dualcam/timing.py": "import os.path\n",
            "dualcam/lower/__init__.py": '"""A room.\n\nMay import no other room.\n"""\n',
            "dualcam/lower/deep.py": "import dualcam\nfrom dualcam import timing\n",
            "dualcam/upper/__init__.py": '"""A room.\n\nMay import lower.\n"""\n',
            "dualcam/upper/near.py": "from dualcam.lower import deep\nfrom . import far\n",
            "dualcam/upper/far.py": "",
            "benchmarks/harness/timing.py": "import dualcam\n",
            "benchmarks/cost.py": "from benchmarks.harness import timing\n",
            "tests/test_benchmarks.py": "import benchmarks.cost\n",
            "benchmarks/mechanisms.py": "import dualcam\n",
            "tests/support/mechanisms.py": "import dualcam\n",
            "tests/test_timing.py": "import mechanisms\nfrom dualcam import timing\n",
            "system_examples/joint.py": "import dualcam\n",
            "system_examples/parts/one.py": "from . import two\nimport two\n",
            "system_examples/parts/two.py": "LINES = 1\n" * 800,
        },
    )
    return tmp_path


def found_in(root: Path) -> dict[str, list[str]]:
    """The messages of each check that found something."""
    return {name: found for name, check in CHECKS.items() if (found := check(root))}


def test_a_tree_that_keeps_every_rule(tree):
    assert found_in(tree) == {}


VIOLATIONS = {
    "include downwards that is not allowed": (
        "includes",
        {"fmu_src/inverse/more.c": include(MAIN_HEADER["forward"])},
        "room inverse may not include room forward",
    ),
    "closed form on the geometry": (
        "includes",
        {"fmu_src/closed_form/more.h": include(MAIN_HEADER["geometry"])},
        "room closed_form may not include room geometry",
    ),
    "tools on the mechanism": (
        "includes",
        {"fmu_src/tools/more.c": include(MAIN_HEADER["forward"])},
        "room tools may not include room forward",
    ),
    "include without a room": (
        "includes",
        {"fmu_src/model/more.c": include("model.h")},
        'fmu_src/model/more.c includes "model.h", which names no room',
    ),
    "include of an unknown room": (
        "includes",
        {"fmu_src/model/more.c": include("cellar/wine.h")},
        'includes "cellar/wine.h", which names no room',
    ),
    "include of a file that is not there": (
        "includes",
        {"fmu_src/model/more.c": "# include" + ' "numerics/lost.h" /* spaces count not */\n'},
        'includes "numerics/lost.h", which does not exist',
    ),
    "circle between pairs of one room": (
        "circles",
        {
            "fmu_src/forward/a.h": "",
            "fmu_src/forward/b.h": "",
            "fmu_src/forward/a.c": include("forward/a.h") + include("forward/b.h"),
            "fmu_src/forward/b.c": include("forward/b.h") + include("forward/a.h"),
        },
        "circle: forward/a -> forward/b -> forward/a",
    ),
    "circle between headers": (
        "circles",
        {
            "fmu_src/model/a.h": include("model/b.h"),
            "fmu_src/model/b.h": include("model/c.h"),
            "fmu_src/model/c.h": include("model/a.h"),
        },
        "circle: model/a -> model/b -> model/c -> model/a",
    ),
    "C file of 501 lines": (
        "lengths",
        {"fmu_src/model/long.c": "\n" * 501},
        "long.c has 501 lines, more than 500",
    ),
    "loop without a bound": (
        "loops",
        {"fmu_src/model/loop.c": "while (x < y) x = f(x); /* it ends */\n"},
        "fmu_src/model/loop.c:1: a loop without a bound: while (x < y)",
    ),
    "endless for": ("loops", {"fmu_src/model/loop.c": "for (int n = 0;; n++) f(n);\n"}, "without a bound"),
    "do without a bound": (
        "loops",
        {"fmu_src/model/loop.c": "do {\n    f();\n} while (g());\n"},
        "fmu_src/model/loop.c:1: a loop without a bound: do {",
    ),
    "header of 501 lines": ("lengths", {"fmu_src/model/long.h": "\n" * 501}, "long.h has 501 lines"),
    "C file of a test of 801 lines": (
        "lengths",
        {"tests/native/long.c": "\n" * 801},
        "801 lines, more than 800",
    ),
    "tool of 501 lines": ("lengths", {"fmu_src/tools/long.py": "\n" * 501}, "501 lines, more than 500"),
    "module of 501 lines": ("lengths", {"dualcam/long.py": "\n" * 501}, "501 lines, more than 500"),
    "test of 801 lines": ("lengths", {"tests/test_long.py": "\n" * 801}, "801 lines, more than 800"),
    "example of 801 lines": ("lengths", {"system_examples/long.py": "\n" * 801}, "801 lines, more than 800"),
    "benchmark of 501 lines": ("lengths", {"benchmarks/long.py": "\n" * 501}, "501 lines, more than 500"),
    "room of too many pairs": (
        "room sizes",
        {f"fmu_src/model/part{k}.{end}": "" for k in range(MOST_PAIRS - 1) for end in "ch"},
        "fmu_src/model has 17 pairs of files, more than 16",
    ),
    "C file outside the rooms": ("rooms", {"fmu_src/lost.c": ""}, "fmu_src/lost.c is in no room"),
    "header below a room": (
        "rooms",
        {"fmu_src/model/deep/lost.h": ""},
        "fmu_src/model/deep/lost.h is in no room",
    ),
    "unknown room": ("rooms", {"fmu_src/cellar/wine.c": ""}, "fmu_src/cellar/wine.c is in no room"),
    "main header that starts with code": (
        "main headers",
        {"fmu_src/platform/platform.h": "#pragma once\n" + header("platform")},
        "fmu_src/platform/platform.h does not start with a comment",
    ),
    "main header of few words": (
        "main headers",
        {"fmu_src/platform/platform.h": "/* Memory and files. */\n"},
        "does not start with a comment that says what room platform is for",
    ),
    "main header that leaves out a room": (
        "main headers",
        {"fmu_src/numerics/root.h": header("platform")},
        "fmu_src/numerics/root.h: the first comment, on what may be included, lacks platform",
    ),
    "main header that leaves out an exception": (
        "main headers",
        {"fmu_src/inverse/inverse.h": "/* Torque for an imposed motion. May include every room below. */\n"},
        "fmu_src/inverse/inverse.h: the first comment, on what may be included, lacks forward",
    ),
    "abandoned word in the name of a C file": (
        "words",
        {"fmu_src/collocation/leap.c": ""},
        "fmu_src/collocation/leap.c: abandoned word in the file's name",
    ),
    "abandoned word in the name of a tool": (
        "words",
        {"fmu_src/tools/draw_walks.py": ""},
        "fmu_src/tools/draw_walks.py: abandoned word",
    ),
    "abandoned word in a function": (
        "words",
        {"fmu_src/model/more.c": "void find_glide(double theta);\n"},
        "fmu_src/model/more.c: abandoned words in find_glide",
    ),
    "abandoned word in a type": (
        "words",
        {"fmu_src/model/more.h": "typedef struct BearingForce { double x; } BearingForce;\n"},
        "abandoned words in BearingForce",
    ),
    "abandoned word in a constant": ("words", {"fmu_src/model/more.h": "enum { KNOBS = 3 };\n"}, "KNOBS"),
    "abandoned word in the list of variables": (
        "words",
        {"fmu_src/variables.def": 'VARIABLE(twist, "a leap")\n'},
        "fmu_src/variables.def: abandoned words in twist",
    ),
    "sys.path in a test": (
        "sys.path",
        {"tests/test_more.py": "import sys\n\nsys.path.insert(0, '.')\n"},
        "tests/test_more.py uses sys.path",
    ),
    "path of sys in an example": (
        "sys.path",
        {"system_examples/more.py": "from sys import argv, path\n"},
        "system_examples/more.py uses sys.path",
    ),
    "import upwards": (
        "python rooms",
        {
            "dualcam/lower/more.py": "def f():\n    from dualcam.upper.far import g\n",
        },
        "dualcam.lower.more imports dualcam.upper.far: room lower may not import room upper",
    ),
    "package that does not say what it may import": (
        "python rooms",
        {"dualcam/other/__init__.py": '"""A package."""\n'},
        "dualcam/other/__init__.py does not say what the room may import",
    ),
    "room that may import itself by others": (
        "python rooms",
        {"dualcam/lower/__init__.py": '"""A room.\n\nMay import upper.\n"""\n'},
        "circle of rooms: lower -> upper -> lower",
    ),
    "room that may import no room": (
        "python rooms",
        {"dualcam/lower/__init__.py": '"""A room.\n\nMay import cellar.\n"""\n'},
        "dualcam/lower may import cellar, which is no room",
    ),
    "circle between modules": (
        "python circles",
        {
            "dualcam/lower/a.py": "from dualcam.lower.b import f\n",
            "dualcam/lower/b.py": "def f():\n    import dualcam.lower.a\n",
        },
        "circle: dualcam.lower.a -> dualcam.lower.b -> dualcam.lower.a",
    ),
    "benchmarks from the package": (
        "benchmarks apart",
        {"dualcam/more.py": "from benchmarks.harness import timing\n"},
        "dualcam/more.py imports benchmarks.harness.timing, part of benchmarks",
    ),
    "a module of benchmarks from an example": (
        "benchmarks apart",
        {"system_examples/more.py": "def main():\n    import harness.timing\n"},
        "system_examples/more.py imports harness.timing, part of benchmarks",
    ),
    "benchmarks from another test": (
        "benchmarks apart",
        {"tests/test_more.py": "import cost\n"},
        "tests/test_more.py imports cost, part of benchmarks",
    ),
    "an example from an example": (
        "examples apart",
        {"system_examples/more.py": "import joint\n"},
        "system_examples/more.py imports joint, another example",
    ),
    "an example from an example, by full name": (
        "examples apart",
        {"system_examples/more.py": "from system_examples.parts import one\n"},
        "imports system_examples.parts.one, another example",
    ),
    "an example from an example, relatively": (
        "examples apart",
        {"system_examples/parts/more.py": "from .. import joint\n"},
        "system_examples/parts/more.py imports ..joint, another example",
    ),
}


@pytest.mark.parametrize("violation", VIOLATIONS)
def test_a_violation_is_found(tree, violation):
    """It is found by its check with a message that names file and reason, and by no other check."""
    check, files, message = VIOLATIONS[violation]
    write(tree, files)
    found = found_in(tree)
    assert list(found) == [check]
    assert any(message in line for line in found[check]), found


def test_an_include_upwards_is_found(tree):
    """Such an include closes a circle of rooms, since the upper room includes the lower one."""
    write(tree, {"fmu_src/model/more.c": include(MAIN_HEADER["contact"])})
    assert found_in(tree) == {
        "includes": [
            'fmu_src/model/more.c includes "contact/contact.h": room model may not include room contact'
        ],
        "circles": ["circle: contact -> geometry -> model -> contact"],
    }


def test_a_missing_main_header_is_found(tree):
    (tree / "fmu_src/sensitivity/sensitivity.h").rename(tree / "fmu_src/sensitivity/other.h")
    found = found_in(tree)["main headers"]
    assert found == ["fmu_src/sensitivity/sensitivity.h is missing: the main header of room sensitivity"]


def test_comments_and_texts_are_no_code(tree):
    """An include in a comment is none, and neither comments nor texts hold identifiers."""
    commented = f"/* a leap\n{include(MAIN_HEADER['forward'])} */\n// twist\n"
    text = commented + 'const char *TEXT = "walk \\" course";\n'
    write(tree, {"fmu_src/model/more.c": text, "tests/test_more.py": 'SCRIPT = "sys.path.insert(0)"\n'})
    assert found_in(tree) == {}


def test_every_table_of_the_rules_is_consistent():
    """Rooms may include only rooms that exist, and never in a circle."""
    assert all(other in MAY_INCLUDE for others in MAY_INCLUDE.values() for other in others)
    assert circle(MAY_INCLUDE) == []
    rooms = list(MAY_INCLUDE)
    for room, others in MAY_INCLUDE.items():
        assert all(rooms.index(other) < rooms.index(room) for other in others)
    assert "forward" not in MAY_INCLUDE["inverse"]
    assert set(MAY_INCLUDE["closed_form"]) <= {
        "model",
        "elementary",
        "numerics",
        "contact",
        "platform",
        "geometry",
    }


@pytest.mark.parametrize(
    ("identifier", "words"),
    [
        ("find_glide", ["find", "glide"]),
        ("BearingForces", ["bearing", "forces"]),
        ("KNOB_COUNT", ["knob", "count"]),
        ("FMUState2x", ["fmu", "state", "x"]),
    ],
)
def test_words_of_an_identifier(identifier, words):
    assert words_of(identifier) == words


@pytest.mark.parametrize("identifier", ["sidewalk", "coursework", "of_course_not_a", "twisted", "leaping"])
def test_only_whole_words_are_abandoned(identifier):
    assert is_abandoned(identifier) == ("of_course" in identifier)
