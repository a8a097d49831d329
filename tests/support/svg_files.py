"""Comparison of pictures that matplotlib has written as SVG files."""

import re
from pathlib import Path

import numpy as np
import pytest

NUMBER = re.compile(r"-?\d+\.\d+(?:e[-+]\d+)?")


def split(svg: str):
    """Version of matplotlib; text without numbers; numbers."""
    version = re.search(r"Matplotlib v([\d.]+)", svg)[1]
    return version, NUMBER.sub("#", svg), np.array([float(found) for found in NUMBER.findall(svg)])


def assert_same_picture(drawn: Path, committed: Path) -> None:
    """To 1e-3 pt, if one version of matplotlib has drawn both; else nothing is compared."""
    new, old = split(drawn.read_text()), split(committed.read_text())
    if new[0] == old[0]:
        assert new[1] == old[1], committed.name
        assert new[2] == pytest.approx(old[2], abs=1e-3), committed.name
