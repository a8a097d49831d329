"""Studies in a world that does not help: other FMUs, damaged files, folders in use, plans with slips, scripts
and clusters that cannot work. What cannot be done is told, with what, its value and what is allowed."""

import itertools
import json
import math
import multiprocessing
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from driver import ROOT
from fmu_copies import edited, has_no_binary, without
from refusals import refused_by
from study_cases import (
    DESIGN,
    FORWARD,
    PLAN,
    SLOW_PLAN,
    closed,
    cluster_of,
    every_run_once,
    refused,
    runs_of,
    study,
)
from study_laws import murderous, slow

from dualcam.__main__ import main
from dualcam.errors import FmuError
from dualcam.study import Controller, Plan, Scenario, Study, Vary, read_results, read_study
from dualcam.study.run import processes
from dualcam.study.run.workers import DIED
from dualcam.study.store.storage import Folder
from dualcam.study.store.store import FINISHED, RECORD

# ---- another FMU ----


def test_any_other_fmu(tmp_path, decay):
    """Closed form: x0 exp(-rate t), x0 - rate t. Starts from an output that is exact; one instance makes
    all, which is reset before every run."""
    vary = {
        "x": Vary(values=(1.0, 2.5, -3.0)),
        "rate": Vary(0.5, 4.0, count=4),
        "law": Vary(values=(1, 2)),
        "frozen": Vary(values=(0, 1)),
    }
    results = ["x@0.25", "x@0.5", "law", "resets"]
    one = Study(decay, Plan("grid", vary), Scenario(0.5, step=0.125), results)
    one.run(tmp_path, workers=1, runs_per_file=10)
    found = every_run_once(tmp_path, one)
    for row, (x0, rate, law, frozen) in zip(found, one.plan.rows(0, one.plan.count), strict=True):
        for time_at, x in zip((0.25, 0.5), row, strict=False):
            exact = x0 * math.exp(-rate * time_at) if law == 1 else x0 - rate * time_at
            assert x == pytest.approx(x0 if frozen else exact, rel=1e-14, abs=1e-15)
    assert np.all(np.diff(found[:, 3]) == 1)


def test_fatal_runs_of_another_fmu_cost_a_new_instance_each(decay):
    one = Study(
        decay,
        Plan("table", {"rate": Vary()}, table=[[1.0], [-1.0], [2.0], [-2.0], [3.0]]),
        Scenario(0.25, step=0.125),
        ["x", "resets"],
    )
    block = runs_of(one)
    assert block.messages == {1: "it grows", 3: "it grows"}
    assert block.values[::2, 0] == pytest.approx(np.exp([-0.25, -0.5, -0.75]), rel=1e-14)
    assert np.ptp(block.values[::2, 1]) == 0


@pytest.mark.parametrize(
    "plan, scenario, results, mentions",
    [
        ({"x": Vary(1, 2)}, Scenario(0.3, step=0.125), ["x"], ["0.3", "0.125"]),
        ({"x": Vary(1, 2)}, Scenario(0.25), ["x"], ["steps of one length", "step"]),
        ({"x": Vary(1, 2)}, Scenario(0.25, step=0.125), ["x@0.2"], ["0.2", "0.125"]),
        ({"rate": Vary(1, 6)}, Scenario(0.25, step=0.125), ["x"], ["rate", "6", "5"]),
        ({"resets": Vary(1, 6)}, Scenario(0.25, step=0.125), ["x"], ["resets", "local"]),
        ({"law": Vary(1, 2)}, Scenario(0.25, step=0.125), ["x"], ["law", "Enumeration", "whole"]),
        ({"law": Vary(values=(1, 3))}, Scenario(0.25, step=0.125), ["x"], ["law", "3", "2"]),
    ],
)
def test_what_the_other_fmu_cannot_do(tmp_path, decay, plan, scenario, results, mentions):
    with refused(*mentions):
        Study(decay, Plan("latin", plan, runs=4) if "law" not in plan else Plan("grid", {
            name: Vary(v.low, v.high, 2, values=v.values) for name, v in plan.items()
        }), scenario, results).run(tmp_path / "out", workers=0)  # fmt: skip


def damage(path):
    """Zeros in the middle of the compressed binary."""
    content = bytearray(path.read_bytes())
    start = content.find(b"binaries/linux64") + 3000
    content[start : start + 200] = bytes(200)
    path.write_bytes(content)


def of_version_1(description):
    return description.replace(b'fmiVersion="2.0"', b'fmiVersion="1.0"')


@pytest.mark.parametrize(
    "make, mentions",
    [
        (lambda path: edited(FORWARD, path, without("CoSimulation")), ["no co-simulation"]),
        (lambda path: edited(FORWARD, path, keeps=has_no_binary), ["library"]),
        (lambda path: damage(edited(FORWARD, path)), ["cannot be unpacked"]),
        (lambda path: path.write_bytes(FORWARD.read_bytes()[:5000]), ["no FMU", "ZIP"]),
        (lambda path: path.mkdir(), ["no file"]),
        (lambda path: edited(FORWARD, path, of_version_1), ["FMI 1.0", "allowed are 2.0 and 3.0"]),
    ],
)
def test_an_fmu_that_is_none_to_run(tmp_path, make, mentions):
    path = tmp_path / "bad one.fmu"
    make(path)
    with refused_by(FmuError, "bad one.fmu", *mentions):
        study(fmu=path).run(tmp_path / "out", workers=0)
    assert not (tmp_path / "out").exists()


# ---- plans with slips ----


@pytest.mark.parametrize(
    "old, new, mentions",
    [
        ('results = ["efficiency", "theta"]', 'results = "theta"', ["results = 'theta'", "list"]),
        ('results = ["efficiency", "theta"]', "results = [1]", ["results", "[1]"]),
        ("runs = 64", "runs = 64.0", ["runs = 64.0", "whole"]),
        ("runs = 64", "runs = 64\nseed = -1", ["seed = -1", "0 or more"]),
        ("runs = 64", "runs = 1099511627776", ["runs = 1099511627776", "100,000,000"]),
        ("from = 0.6", 'from = "low"', ["cam1.lead_angle", "from = 'low'", "number"]),
        ("from = 0.6", "from = nan", ["cam1.lead_angle", "nan", "finite"]),
        ("from = 0.6", "from = -0.6", ["cam1.lead_angle", "-0.6", "FMU allows"]),
        ("from = 0.6, to = 0.9", "values = []", ["cam1.lead_angle", "at least one"]),
        ("from = 0.6, to = 0.9", "values = [0.6, inf]", ["cam1.lead_angle", "inf", "finite"]),
        ("from = 0.6, to = 0.9", "values = [0.6], to = 0.9", ["cam1.lead_angle", "to", "values"]),
        ('same_as = "cam1.friction"', 'same_as = "cam1.friction", to = 1', ["cam2.friction", "to", "same"]),
        ('x = "cam1.lead_angle"', "x = 3", ["plot map", "x = 3", "text"]),
        ('of = ["efficiency"]', "of = []", ["plot sobol", "at least one"]),
        ('of = ["efficiency"]', 'of = ["efficiency"]\nhighlight = 1', ["plot sobol", "highlight"]),
        ('y = "theta"', 'y = "theta"\nbest = "max"', ["plot pareto", "best = 'max'", "max, min"]),
        (
            'kind = "parallel"',
            'kind = "parallel"\nhighlight = 7',
            ["plot parallel", "highlight = 7", "at most 1"],
        ),
        ('kind = "sobol"', 'kind = ["sobol"]', ["['sobol']", "did you mean sobol"]),
        ("stop = 0.1", "stop = 0.1\nstep = 0", ["step = 0", "above 0"]),
        ("stop = 0.1", "stop = inf", ["stop = inf", "finite"]),
        ("runs = 64", "runs = 0", ["small.toml", "power of 2"]),
        ("stop = 0.1", "", ["lacks stop"]),
        ("stop = 0.1", 'stop = "soon"', ["small.toml"]),
        ('kind = "map"', 'kind = "globe"', ["globe", "map"]),
        ("[plan]", "[plan", ["TOML"]),
        ("{fmu}", "nowhere.fmu", ["nowhere.fmu"]),
        ("stop = 0.1", 'stop = 0.1\ncontroller.create_law = "os:none"', ["controller", "lacks", "period"]),
    ],
)
def test_a_slip_in_a_plan_is_named_before_anything_is_made(tmp_path, capsys, old, new, mentions):
    plan, out = tmp_path / "small.toml", tmp_path / "out"
    assert old in PLAN
    plan.write_text(PLAN.replace(old, new).format(fmu=FORWARD))
    assert main(["study", str(plan), "--out", str(out), "--workers", "0"]) == 1
    said = capsys.readouterr().err
    assert all(mention in said for mention in mentions), said
    assert not out.exists()


@pytest.mark.parametrize("words, mentions", [
    (["--figure", "all.gnp"], ["all.gnp", ".png"]),
    (["--figure", "all.gif"], ["all.gif", ".png"]),
    (["--scheduler", ""], ["no Dask scheduler"]),
    (["--scheduler", "carrier-pigeon://me"], ["no Dask scheduler", "carrier-pigeon"]),
    (["--out", "/dev/full"], ["/dev/full"]),
    (["--out", "/proc/study"], ["/proc/study"]),
])  # fmt: skip
def test_a_slip_on_the_command_line(tmp_path, capsys, words, mentions):
    plan = tmp_path / "small.toml"
    plan.write_text(PLAN.format(fmu=FORWARD))
    assert main(["study", str(plan), "--out", str(tmp_path / "out"), *words]) == 1
    said = capsys.readouterr().err
    assert all(mention in said for mention in mentions), said
    assert not list(tmp_path.rglob("runs-*"))


@pytest.mark.parametrize(
    "words", [["--workers", "-1"], ["--runs-per-file", "0"], ["--format", "xlsx"], ["--speed", "9"]]
)
def test_an_option_out_of_range_is_wrong_use(tmp_path, capsys, words):
    plan = tmp_path / "small.toml"
    plan.write_text(PLAN.format(fmu=FORWARD))
    assert main(["study", str(plan), "--out", str(tmp_path / "out"), *words]) == 2
    assert words[0] in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_picture_without_plots_is_refused_before_the_runs(tmp_path, capsys):
    plan = tmp_path / "small.toml"
    plan.write_text(PLAN.partition("[[plots]]")[0].format(fmu=FORWARD))
    words = ["study", str(plan), "--out", str(tmp_path / "out"), "--figure", str(tmp_path / "all.png")]
    assert main(words) == 1
    assert "no plots" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "content, mentions",
    [
        ("", ["empty"]),
        ("cam1.radius\n", ["0 runs"]),
        ("cam1.radius\n0.02\nnan\n", ["line 3", "cam1.radius", "'nan'", "finite"]),
        ("cam1.radius,cam1.radius\n0.02,0.03\n", ["two columns cam1.radius"]),
        ("cam1.radius,cam2.radius\n0.02\n", ["line 2", "column 2", "cam2.radius", "no value"]),
        ("cam1.radius;cam2.radius\n0,02;0,03;1\n", ["line 2", "3 values", "2 columns"]),
        ("cam1.radius\n0.02\n\nwide\n", ["line 4", "wide"]),
    ],
)
def test_a_table_with_slips(tmp_path, content, mentions):
    path = tmp_path / "designs.csv"
    path.write_text(content)
    with refused(*mentions):
        Plan.from_csv(path)


def test_a_table_as_spreadsheets_write_it(tmp_path):
    path = tmp_path / "designs.csv"
    path.write_bytes("\ufeffcam1.radius, contacts\r\n0.02, 1\r\n\r\n".encode())
    plan = Plan.from_csv(path)
    assert plan.names == ["cam1.radius", "contacts"]
    assert plan.rows(0, 1).tolist() == [[0.02, 1.0]]


@pytest.mark.parametrize("wrong, mentions", [
    (lambda: study(results="theta"), ["results = 'theta'", "list"]),
    (lambda: Plan("latin", DESIGN, runs=2.5), ["runs = 2.5", "whole"]),
    (lambda: Plan("sobol", DESIGN, runs=4, seed="x"), ["seed = 'x'", "whole"]),
    (lambda: Plan("grid", {"a": Vary(0, 1, count=2.5)}), ["a:", "2.5", "whole"]),
    (lambda: Plan("grid", {n: Vary(0, 1, count=1000) for n in "abcd"}), ["1000000000000", "1,000,000,000"]),
    (lambda: Scenario(1.0, controller=Controller("law", 0.1, ["theta"], ["tau"])), ["'law'", "function"]),
    (lambda: Scenario(1.0, controller=Controller(slow, 0.1, ["theta"], ["tau", "F_ext", "tau"])), ["once"]),
    (lambda: Scenario(1.0, controller=Controller(slow, 0.1, ["z", "z"], ["tau"])), ["reads", "once"]),
    (lambda: runs_of(study(scenario=closed(slow, 1.0, 1e-9))), ["1e-09", "1,000,000 steps"]),
    (lambda: runs_of(study(scenario=Scenario(1e20), results=["theta@0.5"])), ["theta@0.5", "same as 0 s"]),
])  # fmt: skip
def test_slips_in_python(wrong, mentions):
    with refused(*mentions):
        wrong()


# ---- results in trouble ----


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_damaged_results_are_told_and_made_again(tmp_path, form):
    pytest.importorskip("pyarrow") if form == "parquet" else None
    one = study()
    one.run(tmp_path, workers=0, file_format=form, runs_per_file=16)
    paths = sorted(tmp_path.glob("runs/*"))
    good = [path.read_bytes() for path in paths]
    flipped = bytearray(good[2])
    flipped[len(flipped) // 3] ^= 1
    for path, content in zip(paths, (good[0][:-20], b"", flipped), strict=False):
        path.write_bytes(content)
    with refused("damaged", paths[0].name, "again"):
        read_results(tmp_path)
    one.run_to_files(tmp_path, workers=0)
    assert [path.read_bytes() for path in paths] == good
    assert np.array_equal(every_run_once(tmp_path, one), runs_of(one).values)


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_a_study_that_goes_on_reads_no_file_that_is_as_it_was(tmp_path, monkeypatch, form):
    """By size and time. A copy, which has another time, is read; so is what rotted on the disk, by
    read_results."""
    pytest.importorskip("pyarrow") if form == "parquet" else None
    one, read = study(), []
    expected = one.run(tmp_path, workers=0, file_format=form, runs_per_file=16)
    plain = Folder.read
    monkeypatch.setattr(Folder, "read", lambda self, name: (read.append(name), plain(self, name))[1])
    path = tmp_path / f"runs/runs-000000016.{form}"
    one.run_to_files(tmp_path, workers=0)
    assert not [name for name in read if "runs-" in name]
    content, times = path.read_bytes(), (path.stat().st_atime_ns, path.stat().st_mtime_ns)
    os.utime(path, ns=(0, 0))
    one.run_to_files(tmp_path, workers=0)
    assert [name for name in read if "runs-" in name] == [f"runs/{path.name}"]
    rotten = bytearray(content)
    rotten[len(rotten) // 3] ^= 1
    path.write_bytes(rotten)
    os.utime(path, ns=times)
    with refused("damaged", path.name, "delete the file and run the study again"):
        read_results(tmp_path)
    path.unlink()
    one.run_to_files(tmp_path, workers=0)
    assert path.read_bytes() == content
    assert np.array_equal(read_results(tmp_path)["theta"], expected["theta"])


def test_a_record_without_times_is_read(tmp_path):
    """As earlier versions wrote it."""
    one = study()
    one.run_to_files(tmp_path, workers=0, runs_per_file=16)
    finished = json.loads((tmp_path / FINISHED).read_text())
    (tmp_path / FINISHED).write_text(json.dumps({key: entry[:3] for key, entry in finished.items()}))
    before = {path: path.stat().st_ino for path in (tmp_path / "runs").iterdir()}
    one.run_to_files(tmp_path, workers=0)
    assert {path: path.stat().st_ino for path in (tmp_path / "runs").iterdir()} == before
    every_run_once(tmp_path, one)


def test_other_files_in_the_folder_do_no_harm(tmp_path):
    one = study()
    for name in ("runs-000000000.csv", "runs-notes-1.csv", "runs-000000000.unfinished", "notes.parquet"):
        (tmp_path / name).write_text("something else")
    one.run_to_files(tmp_path, workers=0)
    assert np.array_equal(every_run_once(tmp_path, one), runs_of(one).values)


def test_a_record_that_is_none_is_told(tmp_path):
    study().run(tmp_path, workers=0)
    for content in ("{}", "[1", "3", '{"study": {}, "chunk": 0, "format": "csv"}'):
        (tmp_path / RECORD).write_text(content)
        with refused("study.json cannot be read"):
            study().run(tmp_path, workers=0)


def test_what_differs_from_the_study_before_is_named(tmp_path):
    study().run(tmp_path, workers=0)
    with refused("another study", "plan: runs", "plan: seed", "another folder"):
        study(Plan("latin", DESIGN, runs=65, seed=2)).run(tmp_path, workers=0)
    with refused("results"):
        study(results=["theta"]).run(tmp_path, workers=0)


def test_a_study_of_which_nothing_was_made_holds_no_folder(tmp_path):
    """Such as one whose scheduler did not answer."""
    one, other = study(), study(results=["theta"])
    with refused("no Dask scheduler"):
        one.run_to_files(tmp_path, scheduler="tcp://")
    other.run_to_files(tmp_path, workers=0)
    every_run_once(tmp_path, other)


def test_a_grid_of_given_values_goes_on(tmp_path):
    """A range that is not given is NaN, which equals nothing."""
    one = study(Plan("grid", {"contacts": Vary(values=(1, 2)), "cam1.friction": Vary(0.1, 0.2, count=4)}))
    one.run_to_files(tmp_path, workers=0, runs_per_file=3)
    next(tmp_path.glob("runs/runs-000000003.*")).unlink()
    one.run_to_files(tmp_path, workers=0)
    every_run_once(tmp_path, one)


def test_two_studies_at_once_in_one_folder(tmp_path):
    """The second is refused, also if both are the same; it goes on when the first has been killed."""
    plan, out = tmp_path / "small.toml", tmp_path / "out"
    plan.write_text(SLOW_PLAN.format(fmu=FORWARD))
    words = [str(plan), "--out", str(out), "--workers", "1", "--format", "csv", "--runs-per-file", "4"]
    with subprocess.Popen(
        [sys.executable, "-m", "dualcam", "study", *words],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    ) as first:
        while not list(out.glob("small/runs/*")):
            assert first.poll() is None
            time.sleep(0.005)
        one = read_study(plan)
        with refused("another process", "wait"):
            one.run_to_files(out / "small", workers=0)
        assert first.poll() is None
        first.send_signal(signal.SIGKILL)
    one.run_to_files(out / "small", workers=0, on_file_written=lambda: None)
    every_run_once(out / "small", one)


# ---- processes and clusters that cannot work ----

SCRIPT = """
from dualcam.study import Plan, Scenario, Study, Vary
plan = Plan("latin", {{"cam1.friction": Vary(0.1, 0.2)}}, runs=8)
Study({fmu!r}, plan, Scenario(0.1), ["theta"]).run({out!r}, workers=1)
"""


def test_a_script_without_a_main_guard_is_told_what_to_do(tmp_path):
    script, out = tmp_path / "script.py", tmp_path / "out"
    script.write_text(SCRIPT.format(fmu=str(FORWARD), out=str(out)))
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, script], env=environment, capture_output=True, text=True, timeout=100
    )
    assert done.returncode == 1
    assert "__name__" in done.stderr.splitlines()[-1]
    assert not list(out.glob("runs/*"))


def test_a_controller_that_cannot_travel_is_told(tmp_path):
    one = study(scenario=closed(lambda: lambda now, seen: [0.0]), results=["theta"])
    with refused("cannot be sent", "workers = 0"):
        one.run(tmp_path, workers=1)


def test_workers_that_die_of_every_run(tmp_path):
    one = study(Plan("latin", DESIGN, runs=2), closed(murderous), ["theta"])
    table = one.run(tmp_path, workers=2, runs_per_file=2)
    every_run_once(tmp_path, one)
    assert list(table["message"]) == [DIED] * 2


class Interruption:
    """Ctrl-C, KeyboardInterrupt in this thread, at the n-th line that is executed in the file of that name or
    in what it calls; it counts the lines."""

    def __init__(self, file, place=math.inf):
        self.file, self.place, self.lines = str(file), place, 0

    def __enter__(self):
        self.before = sys.gettrace()
        sys.settrace(self.trace)
        return self

    def __exit__(self, *error):
        sys.settrace(self.before)

    def trace(self, frame, event, argument):
        inside = frame.f_code.co_filename == self.file or frame.f_back.f_trace == self.trace
        if inside and event == "line":
            self.lines += 1
            if self.lines == self.place:
                raise KeyboardInterrupt
        return self.trace if inside else None


def ended(processes, seconds=20.0):
    deadline = time.monotonic() + seconds
    while any(process.is_alive() for process in processes) and time.monotonic() < deadline:
        time.sleep(0.05)
    return not any(process.is_alive() for process in processes)


def test_an_interruption_anywhere_ends_a_study_of_processes(tmp_path, monkeypatch):
    """And no process, no folder of an unpacked FMU is left; what is written is whole."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    Path(tempfile.tempdir).mkdir()
    one = study(Plan("latin", DESIGN, runs=16))
    with Interruption(processes.__file__) as quiet:
        one.run_to_files(tmp_path / "whole", workers=2, runs_per_file=2)
    assert quiet.lines > 500
    for number, place in enumerate(np.random.default_rng(7).integers(1, quiet.lines, 4)):
        before, out = set(multiprocessing.active_children()), tmp_path / f"out{number}"
        with suppress(KeyboardInterrupt), Interruption(processes.__file__, place):
            one.run_to_files(out, workers=2, runs_per_file=2)
        assert ended(set(multiprocessing.active_children()) - before)
        one.run_to_files(out, workers=0)
        assert np.array_equal(every_run_once(out, one), every_run_once(tmp_path / "whole", one))
    assert not list(Path(tempfile.tempdir).iterdir())


def test_processes_killed_at_any_moment_lose_no_run(tmp_path):
    """By somebody else: it is not the run that kills."""
    one = study()
    chunks = itertools.count()

    def kill():
        if next(chunks) in (3, 4):
            for process in multiprocessing.active_children():
                process.kill()

    one.run_to_files(tmp_path, workers=2, runs_per_file=8, on_file_written=kill)
    assert np.array_equal(every_run_once(tmp_path, one), runs_of(one).values)


def test_a_cluster_without_workers_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr("dualcam.study.run.cluster.NO_WORKERS_FOR", 1)
    with cluster_of(n_workers=0) as empty, refused("has no workers", "same command"):
        study().run_to_files(tmp_path, scheduler=empty.scheduler_address)
    assert not list(tmp_path.glob("runs/*"))


def test_a_cluster_that_loses_its_workers_is_told_and_nothing_is_lost(tmp_path, monkeypatch):
    monkeypatch.setattr("dualcam.study.run.cluster.NO_WORKERS_FOR", 2)
    one = study(Plan("latin", DESIGN, runs=60), closed(slow, 0.1, 0.02), ["theta"])
    chunks = []

    def dismiss():
        chunks.append(1)
        if len(chunks) == 2:
            dying.scale(0)

    with cluster_of(n_workers=2) as dying, refused("has no workers", "kept"):
        one.run_to_files(
            tmp_path, scheduler=dying.scheduler_address, runs_per_file=3, on_file_written=dismiss
        )
    assert 2 <= len(list(tmp_path.glob("runs/*"))) < 20
    one.run_to_files(tmp_path, workers=0)
    every_run_once(tmp_path, one)


def test_workers_without_the_package_are_told(tmp_path):
    absent = "import sys; sys.modules['dualcam.study.run.runner'] = None"
    with cluster_of(n_workers=1, preload=absent) as bare, refused("cannot take", "dualcam"):
        study().run_to_files(tmp_path, scheduler=bare.scheduler_address)
