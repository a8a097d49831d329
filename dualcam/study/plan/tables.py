"""Tables of runs: CSV and Parquet files, numbers and texts."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from dualcam.common.arrays import TRUTH, Array, real_array
from dualcam.common.mistakes import StudyError, optional_module
from dualcam.errors import TableError
from dualcam.study.plan.texts import GivenTexts
from dualcam.study.plan.vary import Vary

if TYPE_CHECKING:
    from dualcam.common.tables import Converter


def read_csv(
    path: Path, texts: Collection[str] = (), converted: Converter | None = None
) -> dict[str, Sequence[Any] | Array]:
    """Columns by name; those of `texts` have texts. StudyError for a file that is no such table."""
    from dualcam.common.tables import read_columns  # which only runs from such a file need

    try:
        return dict(read_columns(path, "table of runs", texts, converted))
    except TableError as error:
        raise StudyError(f"plan: {error}") from error


def read_parquet(path: Path) -> dict[str, Sequence[Any] | Array]:
    """Columns by name. StudyError for a file that is no Parquet file, or if pyarrow is not installed."""
    advice = "a table in Parquet needs pyarrow: pip install pyarrow, or take CSV"
    parquet = optional_module("pyarrow.parquet", advice)
    try:
        table = parquet.read_table(path, use_threads=False, pre_buffer=False)
    except (OSError, ValueError) as error:
        raise StudyError(f"plan: {path} cannot be read as Parquet: {error}") from error
    return {name: table[name].to_pylist() for name in table.column_names}


def places(
    columns: Mapping[str, Sequence[Any] | Array], folder: Path | None = None
) -> tuple[dict[str, Vary], Array]:
    """What varies, and the table of a plan: of texts, as paths relative to `folder`, their places."""
    if len({len(values) for values in columns.values()}) > 1:
        lengths = ", ".join(f"{name} {len(values)}" for name, values in columns.items())
        raise StudyError(f"plan: columns of different lengths: {lengths}: allowed is one length")
    vary, table = {}, []
    for name, values in columns.items():
        if len(values) and all(isinstance(value, str) for value in values):
            different = list(dict.fromkeys(values))
            vary[name] = Vary(values=GivenTexts.of(different, folder))
            place = {text: float(k) for k, text in enumerate(different)}
            table.append(np.array([place[value] for value in values]))
        else:
            vary[name] = Vary()
            table.append(real_array(values, f"plan: column {name}", StudyError, kinds=TRUTH))
    return vary, np.column_stack(table) if table else np.empty((0, 0))
