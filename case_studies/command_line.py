"""Command line and lists of findings of the reports."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

BUILD = Path(__file__).resolve().parent.parent / "build"


def parse(doc: str | None, picture: str, arguments: Sequence[str] | None) -> argparse.Namespace:
    """`fmu` to use and `output`, the picture to write: those in build/, unless the arguments name others."""
    parser = argparse.ArgumentParser(description=(doc or "").partition("\n")[0])
    parser.add_argument("--fmu", type=Path, default=BUILD / "DualCamForward.fmu")
    parser.add_argument("--output", type=Path, default=BUILD / picture, help="picture to write")
    return parser.parse_args(arguments)


def bullets(points: Mapping[str, Sequence[str]]) -> str:
    """Lists of points under their titles, as lines of text of at most 105 characters."""
    lines = []
    for title, items in points.items():
        lines.append(title)
        lines += [textwrap.fill(item, 105, initial_indent="- ", subsequent_indent="  ") for item in items]
    return "\n".join(lines)
