"""The structure of the source tree: rooms of fmu_src and dualcam, which include which, loops, lengths.

The rules are the tables at the top of support/house.py, and the docstrings of the rooms of dualcam
(support/python_rooms.py).
"""

import house
import pytest
import python_rooms
from driver import ROOT
from house import MAY_INCLUDE, circle

CHECKS = {**house.CHECKS, **python_rooms.CHECKS}


@pytest.mark.parametrize("check", CHECKS)
def test_this_repository(check):
    found = CHECKS[check](ROOT)
    assert not found, "\n" + "\n".join(found)


def test_messages_print_the_shortest_digits():
    """By shortest_decimal() of fault.h: 17 digits show 0.1 as 0.10000000000000001."""
    files = sorted((ROOT / "fmu_src").rglob("*.[ch]"))
    assert [file.name for file in files if "%.17g" in file.read_text(encoding="utf-8")] == []


# What each check finds in a tree with one mistake for each: a check that finds nothing is no check.
MISTAKES = {
    "fmu_src/model/more.c": '#include "forward/main.h"\nwhile (x < y)\n    x = f(x);\n',
    "fmu_src/forward/main.h": '#include "model/main.h"\n',
    "fmu_src/model/main.h": '/* so\n#include "fmi/main.h"\n*/\n',
    "fmu_src/lost.c": "",
    "dualcam/lower/__init__.py": '"""A room.\n\nMay import no other room.\n"""\n',
    "dualcam/lower/near.py": "def f():\n    from dualcam.upper.far import g\n",
    "dualcam/upper/__init__.py": '"""A room.\n\nMay import lower.\n"""\n',
    "dualcam/upper/far.py": "from dualcam.lower import near\n",
}
FOUND = {
    "rooms": "fmu_src/lost.c is in no room",
    "includes": 'fmu_src/model/more.c includes "forward/main.h": room model may not include room forward',
    "circles": "circle: forward -> model -> forward",
    "loops": "fmu_src/model/more.c:2: a loop without a bound: while (x < y)",
    "python rooms": "dualcam.lower.near imports dualcam.upper.far: room lower may not import room upper",
    "python circles": "circle: dualcam.lower.near -> dualcam.upper.far -> dualcam.lower.near",
}


@pytest.mark.parametrize("check", FOUND)
def test_a_mistake_is_found(tmp_path, check):
    for name, text in MISTAKES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    found = [line for line in CHECKS[check](tmp_path) if not line.endswith("has no C file")]
    assert found == [FOUND[check]]


def test_every_table_of_the_rules_is_consistent():
    """Rooms may include only rooms that exist, and never in a circle."""
    assert all(other in MAY_INCLUDE for others in MAY_INCLUDE.values() for other in others)
    assert circle(MAY_INCLUDE) == []
    rooms = list(MAY_INCLUDE)
    for room, others in MAY_INCLUDE.items():
        assert all(rooms.index(other) < rooms.index(room) for other in others)
    assert "forward" not in MAY_INCLUDE["inverse"]
