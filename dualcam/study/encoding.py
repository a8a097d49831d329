"""Files of runs: tables of columns as Parquet or CSV, as bytes."""

from __future__ import annotations

import csv
import importlib
import importlib.util
import io
import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dualcam.study.problem import StudyError

FORMATS = ("parquet", "csv")
METADATA = b"dualcam"  # key in the metadata of a Parquet schema
SAMPLE, FEW = 256, 64  # a column with fewer different values in a sample than FEW gets a dictionary
Column = NDArray[Any]


def default_format() -> str:
    """Parquet, where pyarrow is installed."""
    return "parquet" if importlib.util.find_spec("pyarrow") else "csv"


def check_format(file_format: str) -> None:
    """StudyError if there is no such format, or what writes it is not installed."""
    if file_format not in FORMATS:
        raise StudyError(f"file_format = {file_format!r}: allowed are {', '.join(FORMATS)}")
    if file_format == "parquet":
        pyarrow_module("pyarrow")


def pyarrow_module(name: str) -> Any:  # noqa: ANN401
    """A module of pyarrow. StudyError if pyarrow is not installed."""
    try:
        return importlib.import_module(name)
    except ImportError:
        raise StudyError(
            'Parquet files need pyarrow: pip install "dualcam[study]", or use format csv'
        ) from None


def encoded(columns: Mapping[str, Column], file_format: str, metadata: Mapping[str, Any]) -> bytes:
    """The file of these columns: numbers, texts, or series of shape (runs, instants). Parquet takes the
    metadata along."""
    return _parquet(columns, metadata) if file_format == "parquet" else _csv(columns)


def _parquet(columns: Mapping[str, Column], metadata: Mapping[str, Any]) -> bytes:
    pyarrow, parquet = pyarrow_module("pyarrow"), pyarrow_module("pyarrow.parquet")
    arrays = [_arrow(pyarrow, column) for column in columns.values()]
    fields = [pyarrow.field(name, array.type) for name, array in zip(columns, arrays, strict=True)]
    schema = pyarrow.schema(fields, {METADATA: json.dumps(metadata)})
    few = [name for name, column in columns.items() if _has_few_values(column)]
    sink = pyarrow.BufferOutputStream()
    parquet.write_table(
        pyarrow.table(arrays, schema=schema),
        sink,
        use_dictionary=few,
        compression={name: "snappy" if name in few else "none" for name in columns},
        write_page_checksum=True,
    )
    return bytes(sink.getvalue())


def _arrow(pyarrow: Any, column: Column) -> Any:  # noqa: ANN401
    if column.ndim == 1:
        return pyarrow.array(column)
    flat = pyarrow.array(np.ascontiguousarray(column).reshape(-1))
    return pyarrow.FixedSizeListArray.from_arrays(flat, column.shape[1])


def _has_few_values(column: Column) -> bool:
    """A dictionary of many values costs time and saves no bytes; nor does compression."""
    if column.ndim > 1 or column.dtype == np.int64:  # series; the numbers of the runs
        return False
    return column.dtype == object or len(np.unique(column[:: len(column) // SAMPLE + 1])) < FEW


def _csv(columns: Mapping[str, Column]) -> bytes:
    text = io.StringIO(newline="")
    writer = csv.writer(text)
    writer.writerow(columns)
    writer.writerows(zip(*(_cells(column) for column in columns.values()), strict=True))
    return text.getvalue().encode()


def _cells(column: Column) -> list[Any]:
    """A series is one cell, with its values between blanks."""
    return column.tolist() if column.ndim == 1 else [" ".join(map(repr, row)) for row in column.tolist()]


def columns_of_csv(
    content: bytes, wanted: Sequence[str] | None, texts: Sequence[str], series: Sequence[str]
) -> dict[str, Column]:
    """Columns of a CSV file of runs. `texts`: those that hold no numbers; `series`: those with several."""
    names, *rows = csv.reader(io.StringIO(content.decode(), newline=""))
    by_name = dict(zip(names, zip(*rows, strict=True), strict=True))
    chosen = [name for name in names if wanted is None or name in wanted]
    found: dict[str, Column] = {}
    for name in chosen:
        cells: Sequence[Any] = by_name[name]
        if name in series:
            cells = [cell.split() for cell in cells]
        kind = object if name in texts else np.int64 if name == "run" else np.float64
        found[name] = np.array(cells, dtype=kind)
    return found
