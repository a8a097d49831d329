"""The programs of the examples and of the case studies: what they print fits a terminal, and a picture is
drawn."""

import re

import pytest
from driver import ROOT

import case_studies.car_door
import case_studies.prosthetic_knee
import case_studies.robot_joint
import system_examples.car_door
import system_examples.prosthetic_knee
import system_examples.robot_joint
from system_examples import spring_clamp

# What a program prints, as regular expressions.
PROGRAMS = [
    (system_examples.robot_joint, ["does not lift"]),
    (case_studies.robot_joint, []),
    (system_examples.prosthetic_knee, []),
    (case_studies.prosthetic_knee, ["Where it does not", "times real time"]),
    (system_examples.car_door, []),
    (case_studies.car_door, [r"Real-time factor of the 1 kHz loop: ([2-9]|\d\d)"]),
    (spring_clamp, []),
]


@pytest.mark.parametrize("program, words", PROGRAMS, ids=lambda one: getattr(one, "__name__", ""))
def test_a_program_prints_its_words_and_draws_its_picture(tmp_path, capsys, monkeypatch, program, words):
    run, output = spring_clamp.run, tmp_path / "picture.png"
    monkeypatch.setattr(spring_clamp, "run", lambda path: run(path, cycles=5))
    program.main(["--fmu", str(ROOT / "build/DualCamForward.fmu"), "--output", str(output)])
    printed = capsys.readouterr().out
    assert all(re.search(word, printed) for word in words)
    assert max(map(len, printed.splitlines()[:-1]), default=0) <= 110
    assert str(output) in printed
    assert output.stat().st_size > 20_000
