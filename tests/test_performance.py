"""The benchmarks of the FMU's speed measure the quantities that they name. No time is tested."""

import csv
import ctypes
import os
import platform
import shutil
import subprocess
import sys
from dataclasses import replace

import matplotlib.image
import numpy as np
import pytest
from driver import ROOT
from rich.console import Console

from benchmarks import bench
from benchmarks.harness import circumstances, core, inputs, instructions, steps
from benchmarks.harness.core import LOOP_LIMITS, loop_limit
from benchmarks.harness.fmu import LOWER, RELEASING, STICK, Slave
from benchmarks.harness.inputs import InputRun, Inputs
from benchmarks.harness.markdown import rounded
from benchmarks.harness.repository import RESULTS
from benchmarks.step_cost import evaluation
from benchmarks.step_cost.measure import prepare
from benchmarks.step_cost.scenes import general_scenes, straight_scenes
from benchmarks.worst_step import bound, results
from benchmarks.worst_step.history import History
from benchmarks.worst_step.scenes import Levels, random_inputs, scenes
from benchmarks.worst_step.study import study

SCENES = {scene.name: scene for scene in scenes()}
QUIET = Console(quiet=True)
counts = pytest.mark.skipif(
    not instructions.available(), reason="valgrind is not installed (Debian: valgrind)"
)
PLAIN_GLIBC = "glibc.cpu.hwcaps=-AVX512F,-AVX512VL,-AVX512BW"  # see manual of glibc, Tunables
is_x86 = sys.platform == "linux" and platform.machine() == "x86_64"


def run_of(name, count):
    parameters = SCENES[name].parameters
    return InputRun(parameters, random_inputs(count, Levels.of(parameters)))


def run_alone(test):
    """A test of this file in a process of its own, whose memcpy and exp are those for older processors."""
    command = [sys.executable, "-m", "pytest", "-q", "-n", "0", f"{__file__}::{test}"]
    environment = os.environ | {"GLIBC_TUNABLES": PLAIN_GLIBC}
    made = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert made.returncode == 0, made.stdout


@pytest.fixture(scope="module")
def single_step(tmp_path_factory):
    """The processor's own count of instructions."""
    library = tmp_path_factory.mktemp("single_step") / "single_step.so"
    flags = ["-O2", "-fPIC", "-shared", "-include", "stddef.h"]
    core.compile_c(flags, [ROOT / "tests/native/single_step.c"], library)
    loop = ctypes.CDLL(str(library)).count_traps
    loop.restype = ctypes.c_uint64
    return loop


@counts
@pytest.mark.skipif(not is_x86, reason="x86-64 under Linux has the trap flag")
@pytest.mark.parametrize("name", ["helices", "ellipses"])
def test_callgrind_counts_what_the_processor_executes(name, request):
    """In the same run without a saved state, of steps with and without mode changes. The loop around the
    calls, which callgrind leaves out, is the same for all. In a process whose C library may take no
    instructions that callgrind's processor lacks: its memcpy would be shorter."""
    if os.environ.get("GLIBC_TUNABLES") != PLAIN_GLIBC:
        run_alone(request.node.name)
        return
    single_step = request.getfixturevalue("single_step")
    run = run_of(name, 1500)
    changes = np.diff(run.record()[0][:, 1], prepend=0)
    chosen = np.sort(np.concatenate([np.flatnonzero(changes == n)[-2:] for n in (0, 1)]))
    counted, executed = run.count(chosen), []
    run.slave.fmu.setFMUState(run.state)
    here = 0
    for k in chosen.tolist():
        run.run("run_steps", first=here, end=k)
        here = k + 1
        executed.append(
            single_step(run.loops.run_steps, ctypes.byref(run.instance), ctypes.byref(run.part(k, here)))
        )
    around = np.array(executed) - counted
    assert counted.min() > 300 and counted.max() > 5000
    assert np.all(around > 0) and np.all(around < 150)


@counts
def test_as_many_more_steps_take_as_many_more_instructions():
    """At rest, where each step does the same. One of an FMU that does nothing takes some, always the same."""
    scene = next(s for s in straight_scenes() if s.name == "stuck")
    loops = steps.load_loops()
    run, _ = prepare(scene, loops)
    null = steps.StepBlock(loops, Slave(core.NULL), run.torque, run.steps, 0.0)

    def of(made, count):
        job = made.job()
        return {**job, **{name: job[name][: 8 * count] for name in ("steps", "torques")}}

    lengths = (200, 500, 800)
    jobs = [of(made, n) for made in (run, null) for n in lengths]
    at_rest, nothing = np.array(instructions.count(steps.library(), jobs)).reshape(2, 3)
    assert np.diff(at_rest, 2) == pytest.approx(0, abs=0.001 * at_rest[0])
    assert nothing.tolist() == [n * (nothing[0] // 200) for n in lengths]
    assert 20 < nothing[0] / 200 < at_rest[0] / 200 < 1000


LAW_AT_REST = {  # of no effect with the peak and the viscous slope of Coulomb's law
    f"cam{i}.{name}": value
    for i in (1, 2)
    for name, value in (("stribeck_velocity", 0.05), ("stribeck_exponent", 1), ("friction_load", 30.0))
}


@counts
@pytest.mark.parametrize("name", ["slip undamped", "stuck", "ellipses", "tables, all forces"])
def test_coulombs_law_does_not_pay_for_the_other_laws(name):
    """Parameters that Coulomb's law does not use change no instruction count."""
    scene = next(s for s in (*straight_scenes(), *general_scenes()) if s.name == name)
    loops = steps.load_loops()
    other = replace(scene, parameters=scene.parameters | LAW_AT_REST)
    jobs = [prepare(one, loops)[0].job() for one in (scene, other)]
    coulomb, with_law = instructions.count(steps.library(), jobs)
    assert with_law == coulomb


@pytest.mark.parametrize("name", SCENES)
def test_the_long_run_has_everything_in_it(name):
    run = run_of(name, 20_000)
    history = History.of(*run.record(), run.inputs)
    missing = {kind for kind, mask in history.kinds().items() if not mask.any()}
    assert missing == ({"impact, upper stop", "impact, lower stop"} if name == "no inertia" else set())
    assert history.changes.min() == 0 and history.changes.max() > 1


def test_the_history_is_what_a_master_sees():
    run = run_of("ellipses", 400)
    integers, reals = run.record()
    slave, given = run.slave, run.inputs
    slave.fmu.setFMUState(run.state)
    for k in range(len(given)):
        slave.set({"tau": given.tau[k], "F_ext": given.force[k]})
        if given.tau_rate[k] != 0.0:
            slave.fmu.setRealInputDerivatives([slave.references["tau"]], [1], [given.tau_rate[k]])
        slave.fmu.doStep(k * inputs.STEP, inputs.STEP)
        assert (slave.integer("mode"), slave.integer("events")) == tuple(integers[k])
        assert [slave.real(name) for name in inputs.READ] == reals[k].tolist()


def test_a_step_is_told_by_its_kinds():
    """Two steps of a ball that falls on the lower stop and one that stays stuck, written by hand."""
    integers = np.array([[STICK, 0], [RELEASING, 1], [LOWER, 4]], dtype=np.int32)
    reals = np.array([[1.0, 0.0, 0.0, 5.0, 5.0], [0.9, -1.0, 0.0, 5.0, 5.0], [0.0, 0.0, 0.2, 5.0, 5.0]])
    given = Inputs(np.array([1.0, -1.0, -1.0]), np.zeros(3), np.zeros(3))
    history = History.of(integers, reals, given)
    kinds = {kind: mask.tolist() for kind, mask in history.kinds().items() if mask.any()}
    assert kinds == {
        "stick throughout": [True, False, False],
        "breakaway, releasing": [False, True, False],
        "impact, lower stop": [False, False, True],
        "rests at the lower stop": [False, False, True],
        "input jumps": [False, True, False],
    }
    assert history.story(2) == "releasing to lower stop, 3 mode changes, impact"


def test_the_priced_evaluation_is_the_fmus_acceleration():
    slave = Slave()
    start = {"initial.omega": 3.0, "initial.theta": 0.5, "tau": evaluation.TORQUE}
    slave.set(evaluation.parameters() | start)
    slave.initialise()
    priced = ctypes.byref(evaluation.mechanism()), ctypes.c_double(0.5), ctypes.c_double(3.0)
    assert evaluation.load().acceleration(*priced) == pytest.approx(slave.real("alpha"), rel=1e-9)


def test_the_bound_finds_all_limits_in_the_sources():
    assert all(loop_limit(name) > 0 for name in LOOP_LIMITS)
    made = bound.bound()
    assert 1e6 < made.work < made.evaluations_per_step < 1e8 and bound.bound_of_closed_form() > 1000
    assert made.segments == 100_000  # the message of a refused step has the number, too
    assert "at most %d segments" in core.source_text("forward/step")


def test_without_valgrind_there_are_times_only(monkeypatch, tmp_path):
    monkeypatch.setattr(instructions, "available", lambda: False)
    made = study(SCENES["helices"], 500, 2, 5, QUIET)
    rows = list(results.rows_of(made))
    assert all(row["instructions_worst"] == "" for row in rows)
    whole = next(row for row in rows if row["what"] == "all")
    assert whole["steps"] == "500" and float(whole["ns_worst"]) >= float(whole["ns_median"]) > 0.0
    results.picture([made], circumstances.circumstances("worst"), tmp_path / "worst.png")
    assert (tmp_path / "worst.png").exists()


@pytest.mark.long
def test_all_parts_write_numbers_pictures_and_circumstances(tmp_path):
    """All but the comparison with other solvers, which takes a minute at its quickest."""
    folder = tmp_path / "results"
    shutil.copytree(RESULTS, folder)
    parts = [part for part in bench.PARTS if part.command != "precision"]
    for part in parts:
        (folder / f"{part.name}.csv").unlink()
        (folder / f"{part.name}.png").unlink(missing_ok=True)
    words = [sys.executable, "-m", "benchmarks.bench", "--quick", "--folder", folder]
    done = subprocess.run(
        [*words, *(part.command for part in parts)], cwd=ROOT, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert (folder / "performance.md").read_text().startswith("# How fast")
    for part in parts:
        with (folder / f"{part.name}.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert rows and all(row[fact] for row in rows for fact in circumstances.FACTS)
        assert {row["command"].split()[1] for row in rows} == {part.command}
        if part.drawn:
            height, width, _ = matplotlib.image.imread(folder / f"{part.name}.png").shape
            assert width > 1000 and height > 400


def test_an_unknown_part_is_refused():
    words = [sys.executable, "-m", "benchmarks.bench", "nonsense"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, env=os.environ)
    assert done.returncode == 2 and "no such part: nonsense" in done.stderr


@pytest.mark.parametrize(
    "value, text", [("0", "0"), ("1234.5", "1,230"), ("0.012345", "0.0123"), ("2.5e6", "2.5e6")]
)
def test_numbers_have_three_digits(value, text):
    assert rounded(value) == text
