"""Workers that write the files of runs themselves, folders that are stores, and what goes wrong there.
Whatever happens, every run is there once."""

import json
import os
import pickle
import resource
import subprocess
import sys
from contextlib import suppress

import numpy as np
import pytest
from filelock import FileLock
from study_cases import (
    DESIGN,
    FORWARD,
    PLAN,
    PUSH,
    Stop,
    after,
    cluster_of,
    every_run_once,
    refused,
    runs_of,
    stop,
    study,
)

from dualcam import Fmu
from dualcam.study import Evaluator, Plan, Vary, read_results
from dualcam.study.run.chunk import Files
from dualcam.study.run.runner import Runner
from dualcam.study.store.store import FINISHED, RECORD

RLIMIT = resource.RLIMIT_FSIZE
fsspec = pytest.importorskip("fsspec", reason="fsspec is not installed")
pytest.importorskip("pyarrow", reason="pyarrow is not installed")


@pytest.fixture
def store():
    """URL of a store in the memory of this process, which is empty."""
    files = fsspec.filesystem("memory")
    with suppress(FileNotFoundError):
        files.rm("/studies", recursive=True)
    yield "memory://studies/one"
    with suppress(FileNotFoundError):
        files.rm("/studies", recursive=True)


# ---- stores ----


@pytest.mark.parametrize("form", ["parquet", "csv"])
def test_a_study_in_a_store_goes_on_where_it_was(store, form):
    one = study()
    with pytest.raises(Stop):
        one.run_to_files(store, workers=0, file_format=form, runs_per_file=10, on_file_written=after(3, stop))
    files = fsspec.filesystem("memory")
    assert sorted(files.ls("/studies/one/runs", detail=False)) == [
        f"/studies/one/runs/runs-{k:09d}.{form}" for k in (0, 10, 20)
    ]
    files.pipe_file(f"/studies/one/runs/runs-000000010.{form}", b"damaged")
    one.run_to_files(store, workers=0)
    assert np.array_equal(every_run_once(store, one), runs_of(one).values)


def test_workers_that_do_not_see_the_store_send_their_files(store):
    """The memory of this process is not that of the workers."""
    one = study()
    one.run_to_files(store, workers=2, runs_per_file=8)
    assert np.array_equal(every_run_once(store, one), runs_of(one).values)


def test_a_client_of_any_kind_and_workers_that_write_into_a_store(store):
    """Threads of this process see its memory."""
    distributed = pytest.importorskip("distributed")
    one = study()
    with cluster_of(n_workers=2, processes=False) as cluster, distributed.Client(cluster) as client:
        one.run_to_files(store, scheduler=client, runs_per_file=8)
        assert client.status == "running"
        assert client.submit(lambda: 7).result() == 7
    assert np.array_equal(every_run_once(store, one), runs_of(one).values)


@pytest.mark.parametrize("place, mentions", [
    ("pigeon://loft/one", ["pigeon://loft/one", "fsspec"]),
    ("s3://bucket/one", ["s3"]),
])  # fmt: skip
def test_a_store_that_cannot_be_used_is_told(monkeypatch, place, mentions):
    monkeypatch.setitem(__import__("sys").modules, "s3fs", None)
    with refused(*mentions):
        study().run_to_files(place, workers=0)


# ---- who writes ----


def test_processes_write_their_files_and_the_study_the_record(tmp_path, monkeypatch):
    """In this process nothing makes the content of a file."""
    monkeypatch.setattr(Files, "content", lambda *_: pytest.fail("the study itself has made a file"))
    one = study()
    one.run_to_files(tmp_path, workers=2, runs_per_file=8)
    assert np.array_equal(every_run_once(tmp_path, one), runs_of(one).values)
    finished = json.loads((tmp_path / FINISHED).read_text())
    assert sorted(map(int, finished)) == list(range(0, 64, 8))
    assert all(failed == 0 for _, _, failed, _ in finished.values())
    names = {path.name for path in tmp_path.iterdir()}
    assert names <= {RECORD, FINISHED, ".lock", "runs"}  # the mark of the study is gone


def test_random_numbers_travel_while_they_are_few(tmp_path, monkeypatch):
    """Workers make many of them by themselves, and the same ones."""
    for sent, is_there in ((1_000_000, True), (1000, False)):
        monkeypatch.setattr("dualcam.study.plan.sampler.SENT", sent)
        one = study()
        one.plan.rows(0, 1)
        files = pickle.loads(pickle.dumps(Files(None, "csv", one.plan, one.readings, {}, "mark")))
        assert ("_shares" in vars(files.plan.sampler)) == is_there
        assert np.array_equal(files.plan.rows(0, 64), one.plan.rows(0, 64))


def test_a_file_that_was_written_and_not_recorded_is_there_once(tmp_path):
    """As where the study is killed between both; the same runs make the same bytes."""
    one = study()
    one.run_to_files(tmp_path, workers=0, runs_per_file=8)
    before = {path: path.read_bytes() for path in (tmp_path / "runs").iterdir()}
    finished = json.loads((tmp_path / FINISHED).read_text())
    for content in (json.dumps({"0": finished["0"]}), "{", ""):
        (tmp_path / FINISHED).write_text(content)
        one.run_to_files(tmp_path, workers=0)
        assert {path: path.read_bytes() for path in (tmp_path / "runs").iterdir()} == before
    every_run_once(tmp_path, one)


def test_files_of_runs_without_their_record_are_refused(tmp_path):
    """Another size of files would have runs twice."""
    study().run_to_files(tmp_path, workers=0, runs_per_file=8)
    (tmp_path / RECORD).unlink()
    with refused("without study.json", "another"):
        study().run_to_files(tmp_path, workers=0, runs_per_file=10)


def test_a_folder_of_another_version_is_told(tmp_path):
    study().run_to_files(tmp_path, workers=0)
    record = json.loads((tmp_path / RECORD).read_text())
    (tmp_path / RECORD).write_text(json.dumps(record | {"layout": 1}))
    with refused("another version"):
        read_results(tmp_path)


# ---- workers and disks that fail ----


def test_a_worker_that_finds_the_disk_full_loses_nothing(tmp_path):
    """The limit on a file's size, which processes inherit, gives an OSError as a disk without room does. The
    FMU's binary stays below the limit, the series of a file of runs do not."""
    results = ["theta", *(f"series({name}, count=21)" for name in ("alpha", "torque_load", "cam1.reaction"))]
    one, limits = study(Plan("latin", DESIGN, runs=6000), results=results), resource.getrlimit(RLIMIT)
    with pytest.raises(Stop):
        one.run_to_files(tmp_path, workers=0, runs_per_file=2000, on_file_written=after(1, stop))
    try:
        resource.setrlimit(RLIMIT, (600_000, limits[1]))
        with refused("cannot write", "runs-00000", "kept"):
            one.run_to_files(tmp_path, workers=2)
    finally:
        resource.setrlimit(RLIMIT, limits)
    assert [path.name for path in (tmp_path / "runs").iterdir()] == ["runs-000000000.parquet"]
    one.run_to_files(tmp_path, workers=0)
    table = read_results(tmp_path)
    assert np.array_equal(table["run"], np.arange(6000))
    assert np.array_equal(table["theta"], runs_of(one).values[:, one.readings.raw.index("theta")])


def test_a_process_of_a_study_loads_neither_scipy_nor_pydantic():
    """Each process imports dualcam.study before it computes: SciPy alone takes half a second. The names of
    optimisations and of files are loaded at their first use."""
    program = (
        "import sys, dualcam.study.run.chunk as _;"
        "print({'scipy', 'pydantic', 'dualcam.design'} & set(sys.modules));"
        "from dualcam.study import *; assert all(map(callable, (optimise, read_optimisation, read_study)))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("set()\n", "")
    with pytest.raises(AttributeError, match="no attribute 'optimize'"):
        __import__("dualcam.study").study.optimize  # noqa: B018


# ---- rows that are asked for ----


@pytest.mark.parametrize("workers", [0, 2])
def test_rows_one_after_another_are_the_runs_of_a_study(workers):
    one = study()
    rows, expected = one.plan.rows(0, 64), runs_of(one).values
    with Evaluator(one, workers) as evaluate:
        assert evaluate.names == one.plan.names and evaluate.results == list(one.results)
        assert np.array_equal(evaluate(rows[:40]).values, expected[:40])
        assert np.array_equal(evaluate(rows[40:]).values, expected[40:])
        assert evaluate(rows[:0]).values.shape == (0, 6)
        with refused("allowed is", "4"):
            evaluate(rows[:, :3])


def test_rows_on_a_cluster_with_formulas_and_failures():
    distributed = pytest.importorskip("distributed")
    plan = Plan("latin", {"cam1.ellipse_a": Vary(0.04, 0.05)}, runs=1)
    results = ["theta", "twice = 2 * theta@0.2", "series(theta, at=[0.1, 0.2])"]
    one = study(plan, PUSH, results, parameters={"cam1.profile": 2})
    with (
        cluster_of(n_workers=1, processes=False) as cluster,
        distributed.Client(cluster) as client,
        Evaluator(one, scheduler=client) as evaluate,
    ):
        block = evaluate([[0.05], [0.001], [0.045]])
    assert set(block.messages) == {1} and "0.001" in block.messages[1]
    assert np.all(np.isnan(block.values[1])) and np.all(np.isfinite(block.values[[0, 2]]))
    assert np.array_equal(block.values[:, 1], 2.0 * block.values[:, 3], equal_nan=True)


# ---- groove tables ----


def table_files(folder, count):
    psi = np.linspace(0.0, 1.6, 9)
    for k in range(count):
        lines = [
            f"{a!r},{b!r}" for a, b in zip(psi.tolist(), (psi * (0.02 + 1e-3 * k)).tolist(), strict=True)
        ]
        (folder / f"groove{k}.csv").write_text("\n".join(["psi_rad,z_m", *lines]))
    return [str(folder / f"groove{k}.csv") for k in range(count)]


def test_runs_of_one_groove_table_follow_each_other(tmp_path, monkeypatch):
    """Each table is read once in a file of runs; results and their order are those of single runs."""
    paths = table_files(tmp_path, 3)
    vary = {"cam1.friction": Vary(0.08, 0.2), "cam1.table": Vary(values=paths)}
    one = study(Plan("latin", vary, runs=30), PUSH, ["theta@0.2", "theta"], parameters={"cam1.profile": 3})
    seen, plain = [], Runner._run
    monkeypatch.setattr(Runner, "_run", lambda self, rows: (seen.append(rows[:, 1]), plain(self, rows))[1])
    table = one.run(tmp_path / "out", workers=0, runs_per_file=30)
    assert np.count_nonzero(np.diff(seen[-1])) == 2
    assert set(table["cam1.table"]) == set(paths)
    for row in range(0, 30, 7):
        with Fmu(FORWARD) as fmu:
            names = ("cam1.friction", "cam1.table")
            fmu.start({name: table[name][row] for name in names} | {"cam1.profile": 3, "tau": 8.0})
            fmu.step(0.2)
            assert table["theta@0.2"][row] == pytest.approx(fmu.real("theta"), rel=1e-9)


def test_files_have_enough_runs_for_each_table(tmp_path):
    vary = {"cam1.friction": Vary(0.08, 0.2), "cam1.table": Vary(values=table_files(tmp_path, 3))}
    one = study(Plan("latin", vary, runs=400), PUSH, ["theta"], parameters={"cam1.profile": 3})
    one.run_to_files(tmp_path / "out", workers=0)
    assert len(list((tmp_path / "out" / "runs").iterdir())) == 7  # of 60 runs, 20 for each table


KEEPS = """
import os, signal, sys
from dualcam.study.plan.texts import kept_file
assert kept_file("one.csv", b"one") == kept_file("one.csv", b"one")
path = kept_file("two.csv", b"two")
assert path.read_bytes() == b"two"
if sys.argv[1] == "killed":
    os.kill(os.getpid(), signal.SIGKILL)
print(len(list(path.parent.parent.iterdir())), flush=True)
if sys.argv[1] == "terminated":
    sys.exit(1)  # as a worker
if sys.argv[1] == "forks" and not os.fork():
    sys.exit(0)
if sys.argv[1] == "forks":
    os.wait()
    assert path.read_bytes() == b"two"
"""


def test_tables_that_travelled_are_deleted(tmp_path):
    """At the end of the process that wrote them; after a crash by the next one. Those of a process that lives
    stay."""

    def ended(how):
        done = subprocess.run(
            [sys.executable, "-c", KEEPS, how],
            env=os.environ | {"TMPDIR": str(tmp_path)},
            capture_output=True,
            text=True,
            timeout=100,
        )
        return done.stdout, done.stderr

    def left():
        return [path for path in tmp_path.rglob("*") if path.is_file()]

    for how in ("finished", "terminated", "forks"):
        assert ended(how) == ("2\n", ""), how  # the folder and its lock
        assert left() == []
    ended("killed")
    assert sorted(path.suffix for path in left()) == [".csv", ".csv", ".lock"]
    with FileLock(next(tmp_path.rglob("*.lock"))):  # it lives
        assert ended("finished") == ("4\n", "")
    assert len(left()) >= 2
    assert ended("finished") == ("2\n", "")
    assert left() == []


def test_the_command_writes_into_a_store(store, tmp_path, monkeypatch, capsys):
    """The picture is in the present folder."""
    from dualcam.__main__ import main

    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(PLAN.format(fmu=FORWARD))
    assert main(["study", "small.toml", "--out", store, "--workers", "0"]) == 0
    assert f"256 runs in {store}/small" in capsys.readouterr().out
    assert len(read_results(f"{store}/small")["run"]) == 256
    assert (tmp_path / "small.png").is_file()
