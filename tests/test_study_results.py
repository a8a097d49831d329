"""What comes out of a study: readings against a plain loop over the handle, and files that others read."""

import csv
import json
import math
import re
import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
from pages import TEXTS
from study_cases import DESIGN, FORWARD, PUSH, refused, study

from dualcam import Fmu
from dualcam.study import History, Plan, Results, Scenario, Vary, read_results
from dualcam.study.run.readings import Readings
from dualcam.study.store import encoding

parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed")

PLAN = Plan("grid", {"cam1.friction": Vary(0.08, 0.2, count=3), "spring.preload": Vary(values=[50.0, 60.0])})
RESULTS = [
    "theta",
    "theta@end",
    "omega@0.03",
    "series(theta, every=0.01)",
    "late = series(omega, at=[0.025, 0.05])",
    "top = max(omega, every=0.01)",
    "min(omega, count=6)",
    "mean(theta, every=0.02)",
    "way = integral(omega, every=0.01)",
    "lost = 1 - energy.spring@0.03 / energy.work_in@0.03",
    "both = 2 * top + sqrt(cam1.friction) - `omega@0.03`",
    "over = max(theta, every=0.01) - max(0.1, mean(theta, every=0.02))",
    "rise = theta@end - theta@0.03",
    "larger = max(theta, -2 * omega@0.03)",  # of two values, not of samples
]
RAMP = Scenario(0.055, {"tau": History([0.0, 0.055], [2.0, 9.0])})
GRID = (0.0, 0.01, 0.02, 0.03, 0.04, 0.05, 0.055)  # every 0.01 s, and the end


def by_hand(friction, preload):
    """Values at many instants, by the handle alone; the torque is given by its derivative."""
    instants = sorted({*GRID, 0.025, *np.linspace(0.0, 0.055, 6)[:-1].tolist()})
    seen, omega, spring, work = {}, {}, {}, {}
    with Fmu(FORWARD) as fmu:
        fmu.start({"cam1.friction": friction, "spring.preload": preload, "tau": 2.0})
        torque = fmu.reals("tau")
        for start, end in zip([0.0, *instants], instants, strict=False):
            if end > start:
                fmu.set("tau", 2.0 + 7.0 * start / 0.055)
                torque.write_derivatives(1, [7.0 / 0.055])
                fmu.step(end - start)
            seen[end], omega[end] = fmu.real("theta"), fmu.real("omega")
            spring[end], work[end] = fmu.real("energy.spring"), fmu.real("energy.work_in")
    theta = [seen[t] for t in GRID]
    speed = [omega[t] for t in GRID]
    steps = np.diff(GRID)
    third = [0.0, 0.02, 0.04, 0.055]
    middle = sum((b - a) * (seen[a] + seen[b]) / 2.0 for a, b in pairwise(third))
    return {
        "theta": seen[0.055],
        "theta@end": seen[0.055],
        "rise": seen[0.055] - seen[0.03],
        "omega@0.03": omega[0.03],
        "series(theta, every=0.01)": theta,
        "late": [omega[0.025], omega[0.05]],
        "top": max(speed),
        "min(omega, count=6)": min(omega[t] for t in (*np.linspace(0.0, 0.055, 6)[:-1].tolist(), 0.055)),
        "mean(theta, every=0.02)": middle / 0.055,
        "way": float(np.sum(steps * (np.array(speed[1:]) + speed[:-1]) / 2.0)),
        "lost": 1.0 - spring[0.03] / work[0.03],
        "over": max(theta) - max(0.1, middle / 0.055),
        "larger": max(seen[0.055], -2.0 * omega[0.03]),
        "both": 2.0 * max(speed) + math.sqrt(friction) - omega[0.03],
    }


@pytest.mark.parametrize("form", ["parquet", "csv"])
def test_readings_are_those_of_a_plain_loop(tmp_path, form):
    table = study(PLAN, RAMP, RESULTS).run(tmp_path, workers=0, file_format=form, runs_per_file=4)
    assert set(table) == {"run", *PLAN.names, *by_hand(0.1, 50.0), "message"}
    for row in range(PLAN.count):
        expected = by_hand(table["cam1.friction"][row], table["spring.preload"][row])
        for name, value in expected.items():
            assert table[name][row] == pytest.approx(value, rel=1e-9, abs=1e-12), name
    assert table.series["series(theta, every=0.01)"] == pytest.approx(GRID, abs=1e-15)


def test_a_failed_run_has_no_results_at_all(tmp_path):
    """An ellipse that is too small for the stroke; a formula of the plan's values alone is empty, too."""
    plan = Plan("table", {"cam1.ellipse_a": Vary()}, table=[[0.05], [0.001]])
    results = ["series(theta, every=0.2)", "max(theta, every=0.2)", "half = cam1.ellipse_a / 2"]
    table = study(plan, PUSH, ["theta", *results], parameters={"cam1.profile": 2}).run(tmp_path, workers=0)
    assert "cam1.ellipse_a = 0.001" in table["message"][1]
    for name in ("theta", results[0], results[1], "half"):
        assert np.all(np.isfinite(table[name][0])) and np.all(np.isnan(table[name][1]))


@pytest.mark.parametrize("text, mentions", [
    ("", ["empty"]),
    ("max(theta)", ["every=SECONDS", "at="]),
    ("max(theta, 0.01)", ["every=SECONDS", "at="]),
    ("top = max(theta, 1e-2)", ["every=SECONDS", "at="]),
    ("max(theta, every=0)", ["every=SECONDS"]),
    ("max(theta, every=1e-9)", ["4e-07"]),
    ("max(theta, each=0.1)", ["every=SECONDS"]),
    ("series(theta, at=[0.2, 0.1])", ["increasing"]),
    ("series(theta, at=[0.1, 0.5])", ["0.4 s"]),
    ("series(theta, count=1)", ["2 or more"]),
    ("integral(theta, at=[0.1])", ["two or more"]),
    ("cam1.friction = 2 * theta", ["another column"]),
    ("message = 2 * theta", ["another column"]),
    ("x = 2 * series(theta, every=0.1)", ["series is no part"]),
    ("x = 2 * max(theta, every=-1)", ["every=SECONDS"]),
    ("x = 2 * s", ["s is a series"]),
    ("x = 2 *", ["no formula"]),
    ("theta = 1 + 1", ["twice"]),
])  # fmt: skip
def test_a_result_that_is_none_is_told(text, mentions):
    with refused("result", *mentions):
        study(results=["theta", "s = series(theta, every=0.1)", text])


def test_all_slips_in_results_are_told_at_once():
    with refused("2 mistakes", "max", "mean"):
        study(results=["theta", "max(theta)", "mean(theta)"])


def test_what_a_formula_reads_must_be_a_variable(tmp_path):
    with pytest.raises(ValueError, match="thetta"):
        study(results=["x = 2 * thetta"]).run(tmp_path, workers=0)


def test_all_texts_of_the_page_are_results(tmp_path):
    """docs/use-study-results.md has the one list of kinds."""
    table = TEXTS["docs/use-study-results.md"].partition("| text | result |")[2].partition("\n\n")[0]
    texts = [text for row in table.splitlines()[2:] for text in re.findall(r'`"([^"]+)"`', row.split("|")[1])]
    assert len(texts) >= 11 and "theta@end" in texts
    found = study(scenario=Scenario(0.25, {"tau": History([0.0, 0.25], [2.0, 9.0])}), results=texts)
    columns = found.run(tmp_path, workers=0)
    assert all(np.isfinite(columns[text.split(" = ")[0]]).all() for text in texts)


def test_samples_need_runs_of_one_length():
    with refused("needs runs of one length"):
        Readings(["max(theta, every=0.1)"], "2 * half", ["half"])


def whole(tmp_path):
    return study(PLAN, RAMP, RESULTS).run(tmp_path, workers=0, runs_per_file=4)


def test_pyarrow_duckdb_and_dask_read_the_files_as_they_lie(tmp_path):
    dataset = pytest.importorskip("pyarrow.dataset")
    table = whole(tmp_path)
    lying = dataset.dataset(tmp_path / "runs")
    read = lying.to_table(use_threads=False).sort_by("run")
    assert read["theta"].to_pylist() == table["theta"].tolist()
    assert read["late"].to_pylist() == table["late"].tolist()
    facts = json.loads(lying.schema.metadata[b"dualcam"], parse_constant=lambda text: pytest.fail(text))
    assert (
        facts["study"]["plan"]["vary"]
        == json.loads((tmp_path / "study.json").read_text())["study"]["plan"]["vary"]
    )
    assert facts["study"]["results"] == RESULTS
    assert facts["versions"]["dualcam"] and facts["series"]["late"] == [0.025, 0.05]
    duckdb = pytest.importorskip("duckdb")
    query = f"select run, theta, late[2] from '{tmp_path}/runs/*.parquet' order by run"
    assert duckdb.sql(query).fetchall() == [
        (k, table["theta"][k], table["late"][k, 1]) for k in range(PLAN.count)
    ]
    frames = pytest.importorskip("dask.dataframe")
    frame = frames.read_parquet(tmp_path / "runs").compute(scheduler="synchronous").set_index("run")
    assert frame.sort_index()["top"].tolist() == table["top"].tolist()


def test_pandas_and_xarray_have_the_same_numbers(tmp_path):
    pytest.importorskip("pandas")
    pytest.importorskip("xarray")
    table = whole(tmp_path)
    frame = table.to_pandas()
    assert frame.index.name == "run" and frame.attrs["versions"]["dualcam"]
    assert frame["theta@0.01"].tolist() == table["series(theta, every=0.01)"][:, 1].tolist()
    assert frame["late@0.05"].tolist() == table["late"][:, 1].tolist()
    table.to_csv(tmp_path / "table.csv")
    with (tmp_path / "table.csv").open(newline="") as file:
        names, *lines = csv.reader(file)
    assert names == ["run", *frame.columns]
    place = names.index("late@0.05")
    assert [float(line[place]) for line in lines] == table["late"][:, 1].tolist()
    cube = table.to_xarray()
    assert cube["theta"].dims == ("cam1.friction", "spring.preload")
    at = cube.sel({"cam1.friction": 0.2, "spring.preload": 60.0})
    row = int(np.flatnonzero((table["cam1.friction"] == 0.2) & (table["spring.preload"] == 60.0))[0])
    assert float(at["top"]) == table["top"][row]
    assert at["series(theta, every=0.01)"].sel(time=0.03).item() == table["series(theta, every=0.01)"][row, 3]
    assert at["late"].dims == ("time of late",)
    assert json.loads(cube.attrs["study"])["results"] == RESULTS


def test_other_plans_have_the_dimension_run(tmp_path):
    pytest.importorskip("xarray")
    found = study(Plan("latin", DESIGN, runs=8), results=["theta"]).run(tmp_path, workers=0).to_xarray()
    assert found["theta"].dims == ("run",)
    assert set(DESIGN) <= set(found.coords)


def test_what_is_not_installed_is_told(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    with refused("pandas", "pip install"):
        Results({"run": np.arange(2)}).to_pandas()


NO_PANDAS = """
import sys
from study_cases import study
one = study(results=["theta", "series(omega, every=0.1)"])
table = one.run(sys.argv[1], workers=0, file_format="parquet")
assert table["theta"].size == 64 and table["theta"].flags.writeable
print("pandas" in sys.modules)
"""


def test_parquet_is_written_and_read_without_pandas(tmp_path):
    """The import takes up to two seconds."""
    words = [sys.executable, "-c", NO_PANDAS, str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=100)
    assert (done.stdout, done.stderr) == ("False\n", "")


def test_texts_and_messages_come_back_as_they_were(tmp_path):
    """Of more than one byte in UTF-8; empty ones; as pyarrow reads them, too."""
    texts = np.array(["", "Größe", "θ > 1", "", "a" * 1000, "θ > 1"], dtype=object)
    numbers = np.array([1.0, math.nan, -0.0, math.inf, 2.0, 3.0])
    columns = {"run": np.arange(6), "message": texts, "x": numbers}
    path = tmp_path / "some.parquet"
    path.write_bytes(encoding.encoded(columns, "parquet", "{}"))
    found = encoding.columns_of_parquet(str(path), None)
    assert [column.dtype for column in found.values()] == [column.dtype for column in columns.values()]
    assert found["x"].tobytes() == numbers.tobytes() and found["run"].tolist() == list(range(6))
    assert found["message"].tolist() == texts.tolist()
    assert parquet.read_table(path)["message"].to_pylist() == texts.tolist()
    assert list(encoding.columns_of_parquet(str(path), ["x"])) == ["x"]


def test_a_damaged_page_is_found_where_it_is_read(tmp_path):
    columns = {"run": np.arange(600), "x": np.random.default_rng(1).random(600)}
    content = bytearray(encoding.encoded(columns, "parquet", "{}"))
    content[content.index(columns["x"].tobytes()) + 3] ^= 1
    path = tmp_path / "some.parquet"
    path.write_bytes(content)
    assert encoding.columns_of_parquet(str(path), ["run"])["run"].tolist() == list(range(600))
    with pytest.raises(OSError, match="CRC"):
        encoding.columns_of_parquet(str(path), None)


def test_only_columns_of_few_values_have_a_dictionary(tmp_path):
    """Of random numbers a dictionary costs time and saves nothing."""
    plan = Plan("latin", {"cam1.friction": Vary(0.08, 0.2), "contacts": Vary(values=(1, 2))}, runs=2000)
    study(plan, PUSH, ["theta"]).run_to_files(tmp_path, workers=0, runs_per_file=2000)
    group = parquet.read_metadata(next((tmp_path / "runs").iterdir())).row_group(0)
    columns = [group.column(k) for k in range(group.num_columns)]
    with_one = {each.path_in_schema for each in columns if each.has_dictionary_page}
    assert with_one >= {"contacts", "message"}
    assert not with_one & {"run", "cam1.friction"}
    assert read_results(tmp_path)["contacts"].tolist() == plan.rows(0, 2000)[:, 1].tolist()
