"""The table of programs that `./build.sh run` shows, and the words of build.sh."""

import importlib.util
import re
import subprocess
import tomllib

import pytest
from driver import ROOT

import programs
from programs import PROGRAMS, Program

EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"]


def run(*words):
    return subprocess.run([ROOT / "build.sh", *words], capture_output=True, text=True)


@pytest.mark.parametrize("program", PROGRAMS.values(), ids=PROGRAMS)
def test_what_a_program_names_is_there(program):
    for words in programs.commands_of(program, []):
        if words[0] == "-m":
            assert importlib.util.find_spec(words[1])
        else:
            assert (ROOT / words[0]).is_file()
    assert set(program.extras.split(",")) <= set(EXTRAS)
    assert set(program.tools) <= set(programs.TOOLS)


def test_each_name_stands_once_and_each_row_fits_a_terminal():
    assert len(PROGRAMS) == sum(map(len, programs.TABLE.values()))
    assert max(map(len, programs.table().split("\n"))) <= 120
    assert all(program.question in programs.table() for program in PROGRAMS.values())


@pytest.mark.parametrize("wrong, nearest", [("stickslop", "stickslip"), ("fuzz-call", "fuzz-calls")])
def test_an_unknown_name_is_answered_by_the_nearest(wrong, nearest):
    with pytest.raises(SystemExit, match=f"no program '{wrong}'; the nearest is {nearest}"):
        programs.main([wrong])


def test_a_missing_program_of_the_system_is_named_with_its_package(monkeypatch):
    monkeypatch.setattr(programs.shutil, "which", lambda name: None)
    with pytest.raises(SystemExit, match="Chromium is missing: install package chromium"):
        programs.run(PROGRAMS["view"], [])


def test_arguments_go_to_the_last_command_and_replace_the_ones_that_stand_there(capfd):
    before = ("-c print('first')",)
    program = Program("x", "?", 0, "-c print('last')", build=None, before=before, arguments="plain")
    assert programs.commands_of(program, []) == [["-c", "print('first')"], ["-c", "print('last')", "plain"]]
    assert programs.commands_of(program, ["own"])[-1] == ["-c", "print('last')", "own"]
    assert programs.run(program, []) == 0
    assert [line for line in capfd.readouterr().out.split("\n") if line[:2] != "=="] == ["first", "last", ""]


def test_the_first_command_that_fails_ends_a_program():
    failing = Program("x", "?", 0, "-c raise", build=None, before=("-c exit(3)",))
    assert programs.run(failing, []) == 3


def test_refresh_goes_on_after_a_failure_and_lists_it_at_the_end(monkeypatch, capfd):
    """Also where a program of the system is missing."""
    known = {
        name: Program(name, "?", 0, f"-c {code}", build=None) for name, code in (("a", "exit(3)"), ("c", "1"))
    }
    known["b"] = Program("b", "?", 0, "-c 1", build=None, tools=("Chromium",))
    monkeypatch.setattr(programs, "PROGRAMS", known)
    monkeypatch.setattr(programs.shutil, "which", lambda name: None)
    assert programs.refresh([("a", "", 0.1), ("b", "", 0.1), ("c", "", 0.1)]) == 1
    said = capfd.readouterr().out
    assert "[2/3] b: FAILED" in said and "[3/3] c: done" in said and "install package chromium" in said
    assert said.rstrip().endswith("These failed:\n  a: exit code 3\n  b: exit code 1")
    assert programs.refresh([("c", "", 0.1)]) == 0


def with_their_own(extras):
    """These extras, and those that they name."""
    named = {
        name for extra in extras for pin in EXTRAS[extra] for name in re.findall(r"dualcam\[(.*)\]", pin)
    }
    more = {extra for names in named for extra in names.split(",")}
    return {*extras, *(with_their_own(more) if more else ())}


def test_refresh_runs_known_programs_in_less_than_an_hour():
    """Cheap ones first, the pages last, with the extras of all."""
    names = [name for name, *_ in programs.REFRESH]
    minutes = [step[2] for step in programs.REFRESH]
    every = programs.REFRESH + programs.LONG_REFRESH
    assert sum(minutes) <= PROGRAMS["refresh"].minutes < 60
    assert minutes[:-1] == sorted(minutes[:-1]) and names[-1] == "figures"
    needed = {extra for name, *_ in every for extra in PROGRAMS[name].extras.split(",")}
    assert needed <= with_their_own(PROGRAMS["refresh"].extras.split(","))


def test_an_unknown_command_of_build_sh_shows_the_usage():
    done = run("tets")
    assert done.returncode == 2 and "unknown command: tets" in done.stderr and "usage:" in done.stderr


def test_help_names_every_command():
    named = re.findall(r"^  (\S+) ", run("help").stdout, re.MULTILINE)
    assert named == ["(none)", "test", "check", "wheel", "docs", "run", "help"]


LISTS = ("default_tier.txt", "verification/strength/tests.txt", "verification/strength/branch_tests.txt")


@pytest.mark.parametrize("name", LISTS)
def test_each_line_of_a_list_of_tests_names_some(name):
    for line in (ROOT / "tests" / name).read_text().split():
        path, _, test = line.partition("::")
        assert (ROOT / path).exists(), line
        assert not test or f"def {test.partition('[')[0]}(" in (ROOT / path).read_text(), line
