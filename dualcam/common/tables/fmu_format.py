"""The one format of tables that the FMU reads: a fixed header, then plain numbers between commas."""

from __future__ import annotations

import re
from collections.abc import Collection

import numpy as np
from numpy.typing import ArrayLike

GROOVE_HEADER = "psi_rad,z_m"
FRICTION_HEADERS = ("v_m_s,mu", "v_m_s,R_N,mu")
PLAIN = r"[ \t\r]*[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?[ \t\r]*"


def fmu_text(header: str, *columns: ArrayLike) -> str:
    """The text of a table for the FMU, with all digits. `columns`: of shape (n,), in SI units."""
    rows = zip(*(np.asarray(column, dtype=float).tolist() for column in columns), strict=True)
    return "".join([f"{header}\n", *(f"{','.join(map(repr, row))}\n" for row in rows)])


def is_fmu_text(text: str, headers: Collection[str]) -> bool:
    """Whether the FMU reads this text, which was in UTF-8, as it is."""
    first, *rows = text.removeprefix("\ufeff").rstrip(" \t\r\n").split("\n")
    header = first.strip(" \t\r")
    row = re.compile(",".join([PLAIN] * (header.count(",") + 1)), re.ASCII)
    return header in headers and all(map(row.fullmatch, rows))
