"""Files of runs: tables of columns as Parquet or CSV, as bytes."""

import csv
import importlib.util
import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dualcam.common.mistakes import StudyError, optional_module

FORMATS = ("parquet", "csv")
METADATA = b"dualcam"  # key in the metadata of a Parquet schema
SAMPLE, FEW = 64, 48  # a column with fewer different values in a sample than FEW gets a dictionary
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
    """A module of pyarrow."""
    advice = 'Parquet files need pyarrow: pip install "dualcam[study]", or use format csv'
    return optional_module(name, advice)


def encoded(columns: Mapping[str, Column], file_format: str, metadata: str) -> memoryview | bytes:
    """The file of these columns: numbers, texts, or series of shape (runs, instants). Parquet takes the
    metadata along, a text of JSON."""
    return _parquet(columns, metadata) if file_format == "parquet" else _csv(columns)


# ---- Parquet ----


def _parquet(columns: Mapping[str, Column], metadata: str) -> memoryview:
    """Without pyarrow.array() and to_numpy(), which import pandas. No column has nulls: Arrow then writes no
    levels, which take a third of the time."""
    pyarrow, parquet = pyarrow_module("pyarrow"), pyarrow_module("pyarrow.parquet")
    arrays = [_arrow(pyarrow, column) for column in columns.values()]
    typed = zip(columns, arrays, strict=True)
    fields = [pyarrow.field(name, array.type, nullable=False) for name, array in typed]
    table = pyarrow.Table.from_arrays(arrays, schema=pyarrow.schema(fields, {METADATA: metadata}))
    few = [name for name, column in columns.items() if _has_few_values(column)]
    sink = pyarrow.BufferOutputStream()
    with parquet.ParquetWriter(
        sink,
        table.schema,
        use_dictionary=few or False,
        compression={name: "snappy" if name in few else "none" for name in columns},
        # Of random numbers the least and the greatest are those of the plan in each file.
        write_statistics=["run", *few],
        write_page_checksum=True,
        write_batch_size=max(len(table), 1),
    ) as writer:
        writer.write_table(table, row_group_size=max(len(table), 1))
    return memoryview(sink.getvalue())


def _arrow(pyarrow: Any, column: Column) -> Any:  # noqa: ANN401
    if column.dtype == object:
        return _arrow_of_texts(pyarrow, column)
    flat = np.ascontiguousarray(column).reshape(-1)
    kind = pyarrow.from_numpy_dtype(column.dtype)
    array = pyarrow.Array.from_buffers(kind, len(flat), [None, pyarrow.py_buffer(flat)])
    return array if column.ndim == 1 else pyarrow.FixedSizeListArray.from_arrays(array, column.shape[1])


def _arrow_of_texts(pyarrow: Any, column: Column) -> Any:  # noqa: ANN401
    """Most messages are empty, most texts are there many times."""
    texts = column.tolist()
    known = {text: text.encode() for text in set(texts)}
    ends = np.zeros(len(texts) + 1, np.int32)
    content = b""
    if known.keys() != {""}:
        parts = [known[text] for text in texts]
        content = b"".join(parts)
        np.cumsum([len(part) for part in parts], out=ends[1:])
    buffers = [None, pyarrow.py_buffer(ends), pyarrow.py_buffer(content)]
    return pyarrow.Array.from_buffers(pyarrow.string(), len(texts), buffers)


def _has_few_values(column: Column) -> bool:
    """A dictionary of many values costs time and saves no bytes; nor does compression."""
    if column.ndim > 1 or column.dtype == np.int64:  # series; the numbers of the runs
        return False
    return column.dtype == object or len(set(column[:: len(column) // SAMPLE + 1].tolist())) < FEW


def columns_of_parquet(source: Any, wanted: Sequence[str] | None) -> dict[str, Column]:  # noqa: ANN401
    """Columns of a Parquet file, a path or an open file. OSError or ValueError if it is damaged."""
    # With threads Arrow can abort or hang the process at its end (apache/arrow, issues 33975 and 34314).
    parquet = pyarrow_module("pyarrow.parquet")
    with parquet.ParquetFile(source, pre_buffer=False, page_checksum_verification=True) as file:
        names = file.schema_arrow.names
        chosen = names if wanted is None else [name for name in names if name in wanted]
        table = file.read(chosen, use_threads=False)
    return {name: _numpy(table[name].combine_chunks()) for name in chosen}


def _numpy(array: Any) -> Column:  # noqa: ANN401
    width = getattr(array.type, "list_size", None)
    if width is not None:
        return _numpy(array.flatten()).reshape(-1, width)
    if str(array.type) == "string":
        return np.array(array.to_pylist(), dtype=object)
    return np.from_dlpack(array)


# ---- CSV ----


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
