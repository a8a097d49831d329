"""The results of a study as tables: NumPy arrays, pandas, xarray."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dualcam.common.mistakes import StudyError, optional_module
from dualcam.study.run.chunk import RUNS, checksum, name_of
from dualcam.study.store.encoding import Column, columns_of_csv, columns_of_parquet, encoded
from dualcam.study.store.storage import Storage, storage_at
from dualcam.study.store.store import RECORD, finished_in, is_sound, record_in

NO_TABLES = '{} is not installed: pip install "dualcam[tables]"'


class Results(dict[str, Column]):
    """The table of a study: columns by name, with a value for each run.

    A dict of NumPy arrays, of shape (runs,), or (runs, instants) for a series.

    Parameters
    ----------
    columns : Columns by name.
    study : Plan, scenario, results, parameters and the checksum of the FMU, by name.
    versions : Python and packages that made the first runs, by name.
    series : The times [s] of each series, shape (instants,), by its name.

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.study import Results
    >>> table = Results({"run": np.array([0, 1]), "theta": np.array([0.1, 0.2])})
    >>> float(table["theta"].max()), table.to_pandas()["theta"].mean().round(3).item()
    (0.2, 0.15)
    >>> float(table.to_xarray()["theta"].sel(run=1))
    0.2
    """

    def __init__(
        self,
        columns: Mapping[str, Column],
        study: Mapping[str, Any] | None = None,
        versions: Mapping[str, str] | None = None,
        series: Mapping[str, Column] | None = None,
    ) -> None:
        super().__init__(columns)
        self.study = dict(study or {})
        self.versions = dict(versions or {})
        self.series = dict(series or {})

    def to_pandas(self) -> Any:  # noqa: ANN401
        """The table for pandas.

        Returns
        -------
        pandas.DataFrame
            Index `run`. A series has a column for each instant, `name@time`. `attrs` has `study` and
            `versions`.

        Raises
        ------
        StudyError
            pandas is not installed.
        """
        pandas = optional_module("pandas", NO_TABLES.format("pandas"))
        frame = pandas.DataFrame(self._flat())
        frame.attrs = {"study": self.study, "versions": self.versions}
        return frame.set_index("run") if "run" in self else frame

    def to_csv(self, path: str | Path) -> None:
        """Write the table as one CSV file.

        Parameters
        ----------
        path : str or Path
            The file: a line of names, then a line for each run. A series has a column for each instant,
            `name@time`.

        Raises
        ------
        StudyError
            The file cannot be written.
        """
        try:
            Path(path).write_bytes(encoded(self._flat(), "csv", ""))
        except OSError as error:
            raise StudyError(f"cannot write {path}: {error.strerror or error}") from error

    def _flat(self) -> dict[str, Column]:
        """With a column for each instant of a series."""
        flat: dict[str, Column] = {}
        for name, column in self.items():
            if column.ndim == 1:
                flat[name] = column
            else:
                variable = name.partition("(")[2].partition(",")[0] if "(" in name else name
                times = self.series[name].tolist()
                flat |= {f"{variable}@{time:.12g}": column[:, k] for k, time in enumerate(times)}
        return flat

    def to_xarray(self) -> Any:  # noqa: ANN401
        """The table for xarray.

        Returns
        -------
        xarray.Dataset
            Of a grid: a dimension for each value that varies, so that `table.sel(...)` and `.plot()` work. Of
            other plans: the dimension `run`, with the values that vary as its coordinates. A series has the
            dimension `time` [s] besides, or `time of NAME` where series have other times than the first one.
            `attrs` has `study` and `versions` as JSON.

        Raises
        ------
        StudyError
            xarray is not installed, or `run` is not among the columns.
        """
        xarray = optional_module("xarray", NO_TABLES.format("xarray"))
        if "run" not in self:
            raise StudyError("these columns are without run: read it, too")
        dimensions = self._grid()
        shape = [len(values) for values in dimensions.values()]
        plan = self.study.get("plan", {})
        varied = [*plan.get("vary", {}), *plan.get("same_as", {}), *plan.get("derived", {})]
        variables: dict[str, Any] = {}
        times: dict[str, Column] = {}
        for name in [name for name in self if name not in dimensions]:
            column, axes = self[name], list(dimensions)
            if column.ndim > 1:
                axes.append(_time_axis(name, self.series[name], times))
            variables[name] = (axes, column.reshape(*shape, *column.shape[1:]))
        given = {name: each for name, each in variables.items() if name in varied}
        return xarray.Dataset(
            {name: each for name, each in variables.items() if name not in varied},
            coords={**dimensions, **times, **given},
            attrs={"study": json.dumps(self.study), "versions": json.dumps(self.versions)},
        )

    def _grid(self) -> dict[str, Column]:
        """The dimensions: what varies, in the order of the plan, if the runs are a whole grid."""
        plan = self.study.get("plan", {})
        names = list(plan.get("vary", {}))
        if plan.get("kind") == "grid" and all(name in self for name in names):
            points = {name: np.array(list(dict.fromkeys(self[name].tolist()))) for name in names}
            whole = np.meshgrid(*points.values(), indexing="ij")
            if whole[0].size == len(self["run"]) and all(
                np.array_equal(each.ravel(), self[name]) for name, each in zip(names, whole, strict=True)
            ):
                return points
        return {"run": self["run"]}


def _time_axis(name: str, instants: Column, times: dict[str, Column]) -> str:
    """The dimension with these instants, noted in `times`."""
    for axis, known in times.items():
        if np.array_equal(known, instants):
            return axis
    axis = f"time of {name}" if times else "time"
    times[axis] = instants
    return axis


def read_results(folder: str | Path, columns: Sequence[str] | None = None) -> Results:
    """The results of a study as one table, in the order of the runs.

    Parameters
    ----------
    folder : Folder of the study, or URL of a store that fsspec knows.
    columns : Names of columns. None: all.

    Returns
    -------
    Results
        A dict of columns by name: `run` (number of the run, from 0), the values that vary and the results in
        the FMU's units, and `message` (why the run failed, or empty). Results of a failed run are NaN.

    Raises
    ------
    StudyError
        The folder holds no runs, a file is damaged, or there is no such column.

    Examples
    --------
    >>> import tempfile
    >>> from dualcam.study import Plan, Scenario, Study, Vary, read_results
    >>> plan = Plan("grid", {"spring.preload": Vary(values=[50.0, 60.0])})  # N
    >>> study = Study("forward", plan, Scenario(0.1), ["torque_load"])
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     _ = study.run(folder, workers=0)
    ...     table = read_results(folder, ["run", "torque_load"])
    >>> table["torque_load"].round(4).tolist()  # N.m
    [0.6628, 0.7953]
    """
    storage = storage_at(folder)
    record = record_in(storage)
    if record is None:
        raise StudyError(f"{folder} holds no study: there is no {RECORD}")
    checksums = _finished_files(storage, record)
    if not checksums:
        raise StudyError(f"{folder} holds no runs yet")
    wanted = None if columns is None else list(dict.fromkeys(columns))
    parts = [_columns(storage, name, crc, wanted, record) for name, crc in checksums.items()]
    found = {name: np.concatenate([part.pop(name) for part in parts]) for name in list(parts[0])}
    if lacking := [name for name in wanted or () if name not in found]:
        raise StudyError(f"{folder} has no column {', '.join(lacking)}")
    series = {name: np.array(times) for name, times in record["series"].items() if name in found}
    return Results(found, record["study"], record["versions"], series)


def _finished_files(storage: Storage, record: Mapping[str, Any]) -> dict[str, str]:
    """Names and checksums, in the order of their runs. StudyError if one is not as it was written."""
    finished, listed = finished_in(storage), storage.listing(RUNS)
    checksums = {}
    for start in sorted(finished, key=int):
        name = name_of(range(int(start), int(start) + 1), record["format"])
        if not is_sound(storage, name, finished[start], listed):
            raise StudyError(f"{storage}/{name} is damaged: run the study again, which makes these runs anew")
        checksums[name] = finished[start][1]
    return checksums


def _columns(
    storage: Storage, name: str, crc: str, wanted: Sequence[str] | None, record: Mapping[str, Any]
) -> dict[str, Column]:
    """Columns of a file of runs. StudyError if it is damaged: size and time are as they were, so that a study
    that goes on does not notice. Arrow checks the pages that it reads."""
    if record["format"] == "csv":
        content = storage.read(name)
        if checksum(content) == crc:
            return columns_of_csv(content, wanted, record["texts"], list(record["series"]))
    else:
        try:
            return columns_of_parquet(storage.open(name), wanted)
        except (OSError, ValueError):  # pyarrow.ArrowInvalid is a ValueError
            if checksum(storage.read(name)) == crc:
                raise
    raise StudyError(
        f"{storage}/{name} is damaged: delete the file and run the study again, which makes these runs anew"
    )
