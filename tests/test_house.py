"""The structure of the source tree: rooms of fmu_src and dualcam, which include which, loops, lengths.

The rules are the tables at the top of support/house.py, and the docstrings of the rooms of dualcam
(support/python_rooms.py). Each check runs on this repository, on a small tree
that keeps all rules, and on one small tree for each way to break a rule.
"""

from pathlib import Path

import house
import pytest
import python_rooms
from driver import ROOT
from house import MAY_INCLUDE, MOST_PAIRS, circle

CHECKS = {**house.CHECKS, **python_rooms.CHECKS}


@pytest.mark.parametrize("check", CHECKS)
def test_this_repository(check):
    found = CHECKS[check](ROOT)
    assert not found, "\n" + "\n".join(found)


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


@pytest.fixture
def tree(tmp_path) -> Path:
    """Keeps every rule; each room includes a header of all rooms from which it may."""
    for room, others in MAY_INCLUDE.items():
        lines = [include(f"{other}/main.h") for other in (room, *others)] + [include("variables.def")]
        write(tmp_path, {f"fmu_src/{room}/main.h": "", f"fmu_src/{room}/work.c": "".join(lines)})
    write(
        tmp_path,
        {
            "dualcam/__init__.py": "from dualcam.upper import near\n",
            "dualcam/timing.py": "import os.path\n",
            "dualcam/lower/__init__.py": '"""A room.\n\nMay import no other room.\n"""\n',
            "dualcam/lower/deep.py": "import dualcam\nfrom dualcam import timing\n",
            "dualcam/upper/__init__.py": '"""A room.\n\nMay import lower.\n"""\n',
            "dualcam/upper/near.py": "from dualcam.lower import deep\nfrom . import far\n",
            "dualcam/upper/far.py": "",
            "system_examples/two.py": "LINES = 1\n" * 800,
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
        {"fmu_src/inverse/more.c": include("forward/main.h")},
        "room inverse may not include room forward",
    ),
    "closed form on the geometry": (
        "includes",
        {"fmu_src/closed_form/more.h": include("geometry/main.h")},
        "room closed_form may not include room geometry",
    ),
    "tools on the mechanism": (
        "includes",
        {"fmu_src/tools/more.c": include("forward/main.h")},
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
    "C file of a test of 801 lines": (
        "lengths",
        {"tests/native/long.c": "\n" * 801},
        "801 lines, more than 800",
    ),
    "test of 801 lines": ("lengths", {"tests/test_long.py": "\n" * 801}, "801 lines, more than 800"),
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
    write(tree, {"fmu_src/model/more.c": include("contact/main.h")})
    assert found_in(tree) == {
        "includes": [
            'fmu_src/model/more.c includes "contact/main.h": room model may not include room contact'
        ],
        "circles": ["circle: contact -> geometry -> model -> contact"],
    }


def test_an_include_in_a_comment_is_none(tree):
    write(tree, {"fmu_src/model/more.c": f"/* so\n{include('forward/main.h')} */\n"})
    assert found_in(tree) == {}


def test_every_table_of_the_rules_is_consistent():
    """Rooms may include only rooms that exist, and never in a circle."""
    assert all(other in MAY_INCLUDE for others in MAY_INCLUDE.values() for other in others)
    assert circle(MAY_INCLUDE) == []
    rooms = list(MAY_INCLUDE)
    for room, others in MAY_INCLUDE.items():
        assert all(rooms.index(other) < rooms.index(room) for other in others)
    assert "forward" not in MAY_INCLUDE["inverse"]
