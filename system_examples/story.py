"""What the examples have in common as programs: their command line, and how findings are printed."""

from __future__ import annotations

import argparse
import textwrap
from collections.abc import Mapping, Sequence
from pathlib import Path

BUILD = Path(__file__).resolve().parent.parent / "build"


def command_line(
    doc: str, picture: str, arguments: Sequence[str] | None, model: str = "DualCamForward"
) -> tuple[Path, Path]:
    """The FMU to use and the picture to write: those in `build`, unless the arguments name others."""
    parser = argparse.ArgumentParser(description=doc.partition("\n")[0])
    parser.add_argument("--fmu", type=Path, default=BUILD / f"{model}.fmu")
    parser.add_argument("--output", type=Path, default=BUILD / picture, help="picture to write")
    options = parser.parse_args(arguments)
    return options.fmu, options.output


def bullets(points: Mapping[str, Sequence[str]]) -> str:
    """Lists of points under their titles, as lines of text."""
    lines = []
    for title, items in points.items():
        lines.append(title)
        lines += [textwrap.fill(item, 105, initial_indent="- ", subsequent_indent="  ") for item in items]
    return "\n".join(lines)
