"""The row of a long fuzzing run, from what pytest prints."""

from verification.fuzz_runs import earlier, row_of

PRINTED = """\
..F.                                                                     [100%]
tests/test_properties.py::test_a:
    - 20000 passing, 0 failing, and 211 invalid test cases
tests/test_properties.py::test_b:
    - 11 passing, 2 failing, and 3 invalid test cases
    - 0 passing, 7 failing, and 40 invalid test cases
=========================== short test summary info ============================
FAILED tests/test_properties.py::test_b - AssertionError: theta
================== 1 failed, 3 passed in 3601.00s (1:00:01) ===================
"""


def test_a_row_counts_examples_and_names_the_tests_that_failed():
    assert row_of(PRINTED, 45001, 3601.0) == {
        "seed": "45001",
        "minutes": "60",
        "tests": "4",
        "examples": "20020",
        "findings": "1",
        "failed": "test_b",
    }


def test_a_run_without_findings_names_none():
    text = PRINTED.replace("FAILED", "").replace("1 failed, 3 passed", "4 passed")
    assert (row_of(text, 1, 60.0)["findings"], row_of(text, 1, 60.0)["failed"]) == ("0", "")


def test_there_are_no_earlier_rows_without_a_file(tmp_path):
    assert earlier(tmp_path / "fuzz_runs.csv") == []
