"""The tools that make mutants and mark branches, on small texts in C."""

import subprocess
import sys

import pytest
from driver import ROOT

pytest.importorskip("tree_sitter_c", reason="needs the extra `strength`")

from verification.strength import decisions, judgements, sites, switch

CORE = ROOT / "fmu_src"
CODE = """\
static double power(double force, double speed) { return force * speed; }
static int count(int n) {
    int found = 0;
    for (int k = 0; k < n; k++) {
        if (k == 3) continue;
        found += k;
    }
    return found;
}
static double work(double a, double b) {
    static const double SCALE = 2.0;
    if (a < b && !(b > 10.0)) return -power(a, b);
    return SCALE;
}
"""


def sites_of_text(folder, text):
    path = folder / "small.c"
    path.write_text(text)
    return sites.sites_of(path, "model/small.c", sites.signatures_of(sites.parse(text.encode())))


def test_each_kind_of_mistake_is_found_where_it_can_be_made(tmp_path):
    found = {(s.function, s.kind, s.original, s.mutated) for s in sites_of_text(tmp_path, CODE)}
    assert found >= {
        ("power", "arithmetic", "force * speed", "force / speed"),
        ("count", "comparison", "k < n", "k <= n"),
        ("count", "comparison", "k < n", "k > n"),
        ("count", "condition", "(k == 3)", "!((k == 3))"),
        ("count", "statement", "continue;", ""),
        ("count", "sign", "found += k", "found -= k"),
        ("count", "constant", "3", "(3 + 1)"),
        ("work", "logic", "a < b && !(b > 10.0)", "a < b || !(b > 10.0)"),
        ("work", "sign", "-power(a, b)", "power(a, b)"),
        ("work", "arguments", "power(a, b)", "power(b, a)"),
        ("work", "constant", "10.0", "(10.0 * 1.5)"),
    }
    assert not [s for s in found if s[2] == "2.0"]  # the initializer must stay a constant


def run(folder, header, text, code):
    """Compiles the changed text as a library and calls it in a process of its own; what the code prints."""
    place = folder / header
    place.parent.mkdir(parents=True, exist_ok=True)
    source, library = folder / "changed.c", folder / "changed.so"
    source.write_bytes(text)
    command = ["-m", "ziglang", "cc", "-shared", "-fPIC", "-I", folder, source, "-o", library]
    subprocess.run([sys.executable, *command], check=True)
    made = subprocess.run([sys.executable, "-c", code, library], capture_output=True, text=True, check=True)
    return made.stdout.split()


CALLS = (
    CODE.replace("static double", "double")
    .replace("static int", "int")
    .replace("    double SCALE", "    static double SCALE")
)
CALLED = """
import ctypes, os, sys
def called(**environment):
    os.environ.update(environment)
    library = ctypes.CDLL(sys.argv[1])
    library.work.restype, library.work.argtypes = ctypes.c_double, [ctypes.c_double, ctypes.c_double]
    return library
"""


@pytest.mark.skipif(sys.platform != "linux", reason="the marks stand in a file that Linux maps")
def test_a_switch_puts_one_mutant_in_force(tmp_path):
    found = {s.identity[1:5]: s for s in sites_of_text(tmp_path, CALLS)}
    wanted = {
        1: found["count", "constant", "3", "(3 + 1)"],
        2: found["count", "statement", "continue;", ""],
        3: found["work", "arguments", "power(a, b)", "power(b, a)"],
        4: found["work", "sign", "-power(a, b)", "power(a, b)"],  # around the last one
    }
    (tmp_path / "platform").mkdir()
    (tmp_path / switch.HEADER).write_text(switch.header_text(5))
    code = CALLED + (
        "library = called(DUALCAM_MUTANT='0')\n"
        "for number in range(5):\n"
        "    ctypes.c_int.in_dll(library, 'mutant_active').value = number\n"
        "    print(library.count(6), library.work(2.0, 3.0))\n"
    )
    printed = run(tmp_path, switch.HEADER, switch.switched(CALLS.encode(), wanted), code)
    assert printed == ["12", "-6.0", "11", "-6.0", "15", "-6.0", "12", "-6.0", "12", "6.0"]


@pytest.mark.skipif(sys.platform != "linux", reason="the marks stand in a file that Linux maps")
def test_marks_tell_whether_a_mistake_ever_makes_a_difference(tmp_path):
    found = {s.identity[1:5]: s for s in sites_of_text(tmp_path, CALLS)}
    wanted = {
        1: found["count", "comparison", "k < n", "k <= n"],  # n turns, then the loop ends: they differ
        2: found["work", "comparison", "a < b", "a <= b"],  # never called with equal numbers
        3: found["work", "arguments", "power(a, b)", "power(b, a)"],  # cannot be computed beside: counts
    }
    (tmp_path / "platform").mkdir()
    (tmp_path / switch.HEADER).write_text(switch.header_text(4))
    marks = tmp_path / "marks"
    marks.write_bytes(bytes(4))
    code = CALLED + (
        f"library = called(DUALCAM_MUTANT='-1', DUALCAM_REACHED={str(marks)!r})\n"
        "print(library.count(6), library.work(2.0, 3.0), library.work(3.0, 2.0))\n"
    )
    assert run(tmp_path, switch.HEADER, switch.switched(CALLS.encode(), wanted), code) == [
        "12",
        "-6.0",
        "2.0",
    ]
    both = switch.REACHED_BIT | switch.DIFFERS_BIT
    assert list(marks.read_bytes()) == [0, both, switch.REACHED_BIT, both]


@pytest.mark.skipif(sys.platform != "linux", reason="the marks stand in a file that Linux maps")
def test_marks_tell_branches_and_what_decides_alone(tmp_path):
    core = tmp_path / "core"
    (core / "platform").mkdir(parents=True)
    path = core / "small.c"
    path.write_text(CALLS)
    found = decisions.write(core, [path])
    decision = next(d for d in found if len(d.conditions) == 2)
    assert decision.conditions == ("a < b", "b > 10.0")
    marks = tmp_path / "marks"

    def measured(*arguments):
        marks.write_bytes(bytes(found[-1].place + found[-1].size))
        code = CALLED + f"called(DUALCAM_BRANCHES={str(marks)!r})\n"
        code += "".join(f"print(called().work(*{pair}))\n" for pair in arguments)
        printed = run(core, decisions.HEADER, path.read_bytes(), code)
        assert printed == [str(-a * b if a < b and not b > 10.0 else 2.0) for a, b in arguments]
        return marks.read_bytes()

    seen = measured((1.0, 2.0), (2.0, 1.0))
    assert [taken for _, _, taken in decision.branches(seen)] == [True, True, True, False]
    assert [alone for _, alone in decision.independent(seen)] == [True, False]
    seen = measured((1.0, 2.0), (2.0, 1.0), (1.0, 20.0))
    assert all(taken for _, _, taken in decision.branches(seen))
    assert all(alone for _, alone in decision.independent(seen))


def test_a_verdict_by_hand_holds_only_for_the_code_that_was_judged(tmp_path):
    """`nth` counts equal mistakes: an edit of the function moves the number to another place."""

    def place(text):
        wanted = ("model/small.c", "work", "sign", "-power(a, b)", "power(a, b)", "1")
        (site,) = (s for s in sites_of_text(tmp_path, text) if s.identity == wanted)
        return site

    site = place(CODE)
    verdict = judgements.Judgement("if (a < b && !(b > 10.0)) return -power(a, b);", "cost only", "as it is")
    known = {site.identity: verdict}
    assert judgements.judgement_of(site, known) is verdict
    assert judgements.without_place(known, [site]) == []
    moved = place("\n/* a comment */\n" + CODE)
    assert moved.line == site.line + 2 and judgements.judgement_of(moved, known) is verdict
    edited = place(CODE.replace("b > 10.0", "b > 11.0"))
    assert judgements.judgement_of(edited, known) is None
    (text,) = judgements.without_place(known, [edited])
    assert "model/small.c work() sign 1: `-power(a, b)` -> `power(a, b)`" in text and "b > 11.0" in text
    (text,) = judgements.without_place(known, [])
    assert "there is no such place" in text
    row = dict(zip(judgements.IDENTITY, site.identity, strict=True)) | {"mutant": "7", "verdict": "killed"}
    assert judgements.refuted(known, [row]) == ["7: model/small.c work() is judged: cost only"]
    assert judgements.refuted(known, [row | {"verdict": "cost only"}]) == []
