"""The results of a study as tables: NumPy arrays, pandas, xarray."""

from __future__ import annotations

import importlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from dualcam.study.chunk import RUNS, name_of
from dualcam.study.encoding import Column, columns_of_csv, pyarrow_module
from dualcam.study.problem import StudyError
from dualcam.study.storage import Storage, storage_at
from dualcam.study.store import RECORD, finished_in, is_sound, record_in


class Results(dict[str, Column]):
    """The table of a study: columns by name, with a value for each run.

    A dict of NumPy arrays. `study` says what study the runs are of, `versions` what made them.

    Parameters
    ----------
    columns : mapping of str to ndarray, shape (runs,) or (runs, instants)
        Columns by name. Series have a second axis.
    study : mapping
        Plan, scenario, results, parameters and the checksum of the FMU.
    versions : mapping of str to str
        Python and packages that made the first runs.

    Examples
    --------
    >>> import numpy as np
    >>> from dualcam.study import Results
    >>> table = Results({"run": np.array([0, 1]), "theta": np.array([0.1, 0.2])}, {}, {})
    >>> table["theta"].max()
    np.float64(0.2)
    """

    def __init__(
        self, columns: Mapping[str, Column], study: Mapping[str, Any], versions: Mapping[str, str]
    ) -> None:
        super().__init__(columns)
        self.study = study
        self.versions = versions

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
        pandas = _module("pandas")
        flat = {name: column for key, column in self.items() for name, column in self._flat(key, column)}
        frame = pandas.DataFrame(flat)
        frame.attrs = {"study": dict(self.study), "versions": dict(self.versions)}
        return frame.set_index("run") if "run" in flat else frame

    def _flat(self, name: str, column: Column) -> list[tuple[str, Column]]:
        if column.ndim == 1:
            return [(name, column)]
        return [(f"{name}[{k}]", column[:, k]) for k in range(column.shape[1])]


def _module(name: str) -> Any:  # noqa: ANN401
    try:
        return importlib.import_module(name)
    except ImportError:
        raise StudyError(f'{name} is not installed: pip install "dualcam[study]"') from None


def read_results(folder: str | Path, columns: Sequence[str] | None = None) -> Results:
    """The results of a study as one table, in the order of the runs.

    Parameters
    ----------
    folder : str or Path
        Folder of the study, or URL of a store that fsspec knows.
    columns : sequence of str, optional
        Names of columns. None: all.

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
    names = _finished_files(storage, record)
    if not names:
        raise StudyError(f"{folder} holds no runs yet")
    wanted = None if columns is None else list(dict.fromkeys(columns))
    read = _read_parquet if record["format"] == "parquet" else _read_csv
    found = read(storage, names, wanted)
    if lacking := [name for name in wanted or () if name not in found]:
        raise StudyError(f"{folder} has no column {', '.join(lacking)}")
    return Results(found, record["study"], record["versions"])


def _finished_files(storage: Storage, record: Mapping[str, Any]) -> list[str]:
    """In the order of their runs. StudyError if one is damaged."""
    finished, sizes = finished_in(storage), storage.sizes(RUNS)
    names = []
    for start in sorted(finished, key=int):
        name = name_of(range(int(start), int(start) + 1), record["format"])
        if not is_sound(storage, name, finished[start], sizes):
            raise StudyError(f"{storage}/{name} is damaged: run the study again, which makes these runs anew")
        names.append(name)
    return names


def _read_parquet(storage: Storage, names: Sequence[str], wanted: Sequence[str] | None) -> dict[str, Column]:
    dataset = pyarrow_module("pyarrow.dataset")
    places = [storage.place(name) for name in names]
    # With threads Arrow can abort or hang the process at its end (apache/arrow, issues 33975 and 34314).
    scan = dataset.ParquetFragmentScanOptions(pre_buffer=False, page_checksum_verification=True)
    whole = dataset.dataset(
        [path for path, _ in places],
        filesystem=places[0][1],
        format=dataset.ParquetFileFormat(default_fragment_scan_options=scan),
    )
    chosen = None if wanted is None else [name for name in wanted if name in whole.schema.names]
    table = whole.to_table(columns=chosen, use_threads=False)
    return {name: _column(table[name]) for name in table.column_names}


def _column(column: Any) -> Column:  # noqa: ANN401
    width = getattr(column.type, "list_size", None)
    if width is None:
        return np.asarray(column.to_numpy(zero_copy_only=False))
    flat = column.combine_chunks().flatten().to_numpy(zero_copy_only=False)
    return np.asarray(flat).reshape(-1, width)


def _read_csv(storage: Storage, names: Sequence[str], wanted: Sequence[str] | None) -> dict[str, Column]:
    parts = [columns_of_csv(storage.read(name), wanted, ["message"]) for name in names]
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
