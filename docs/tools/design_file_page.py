"""Writes the table of keys in docs/design-file.md, and dualcam/design_file/design.schema.json for editors.

Run by `./build.sh run figures`. Both come from the schema of design files, which comes from the variables of
the FMUs. tests/test_design_file.py keeps both fresh."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

from dualcam.common.groove_laws import ALLOWED
from dualcam.design_file.schema import defaults, json_schema, known_keys
from dualcam.fmi.variables import all_parameters

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "design-file.md"
SCHEMA = ROOT / "dualcam" / "design_file" / "design.schema.json"
WORDS = {  # allowed values that the FMU's limits do not say
    "cam1.profile": ALLOWED,
    "cam1.ellipse_curvature": "-1 or +1",
    "cam1.table": "path of a file, in quotes",
    "contacts": "1 or 2",
}
BEGIN, END = "<!-- keys: generated -->\n", "<!-- end of keys -->\n"


def schema_text() -> str:
    """The JSON Schema as a file."""
    return json.dumps(json_schema(), indent=1, ensure_ascii=False) + "\n"


def rows() -> list[str]:
    """One row of the table for each key; cam1 stands for both cams."""
    parameters, keys = all_parameters(), known_keys()
    found = ["| key | unit | default | allowed | meaning |", "| --- | --- | --- | --- | --- |"]
    tables = {key.rpartition(".")[0] for key in keys}
    for key, text in keys.items():
        if key in tables or key.startswith("cam2."):
            continue
        unit = match[1] if (match := re.search(r" \[(.*)\]$", text)) else ""
        meaning = text.removesuffix(f" [{unit}]").replace("|", "or")
        start, allowed = _default(key), ""
        if key == "study":
            continue
        if key in parameters:
            variable = parameters[key]
            value = variable.start
            start = str(value).lower() if isinstance(value, bool) else f"{value:.6g}" if value != "" else ""
            allowed = WORDS.get(key) or variable.allowed().removesuffix(variable.in_unit)
        found.append(f"| `{key}` | {unit} | {start} | {allowed} | {meaning} |")
    return found


def _default(key: str) -> str:
    """The default of a key of [pin] or [limits], in the key's unit."""
    value = defaults().get(key, "")
    if key == "limits.lead_angle":
        return "[" + ", ".join(f"{angle:.6g}" for angle in value) + "], 5 to 80 deg"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else ""


def page() -> str:
    """docs/design-file.md with a fresh table."""
    text = PAGE.read_text(encoding="utf-8")
    before, rest = text.split(BEGIN)
    after = rest.split(END)[1]
    return before + BEGIN + "\n".join(rows()) + "\n" + END + after


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_known_args()
    SCHEMA.write_text(schema_text(), encoding="utf-8")
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
