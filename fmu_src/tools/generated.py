"""What the scripts that compute tables of C have in common: their command line.

python fmu_src/tools/make_....py [--check]

(none)   writes the files that differ from what the script computes
--check  writes nothing; a file that differs is an error
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping
from pathlib import Path


def head_of(script: str) -> str:
    """First lines of a table that `script`, the __file__ of a program, computes."""
    said = f"/* Written by {Path(script).name}, which says what these numbers are. */"
    return f"{said}\n/* clang-format off */\n\n"


def write_or_check(compute: Callable[[], Mapping[Path, str]], script: str) -> int:
    """The main function of `script`. `compute` returns files and what they should hold. Returns the exit
    code."""
    parser = argparse.ArgumentParser(description="Writes tables of C")
    parser.add_argument("--check", action="store_true", help="only compare with the committed files")
    check = parser.parse_args().check
    stale = {
        path: body
        for path, body in compute().items()
        if not path.exists() or path.read_text(encoding="utf-8") != body
    }
    for path, body in stale.items():
        if check:
            print(f"{path.name} is out of date: run {Path(script).name}", file=sys.stderr)
        else:
            path.write_text(body, encoding="utf-8", newline="\n")
    return int(check and bool(stale))
