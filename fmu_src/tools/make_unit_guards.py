"""Writes unit_guards.def: values of the FMUs' parameters that look as if they were in another unit.

    python fmu_src/tools/make_unit_guards.py [--check]

The rules stand in dualcam/common/unit_guards.csv, from which the Python package reads them, too. Rules of
design files alone are left out.
"""

from __future__ import annotations

import csv
import re
import sys
from pathlib import Path

import generated

ROOT = Path(__file__).resolve().parents[2]
RULES = ROOT / "dualcam/common/unit_guards.csv"
VARIABLES = ROOT / "fmu_src/variables.def"
TABLE = ROOT / "fmu_src/unit_guards.def"
PARAMETER = re.compile(r'VARIABLE\((\w+), (?:EACH\(\d+, \d+\)|\d+), REAL, (\w+), PARAMS, [^,]+, "([^"]+)"')


def rows() -> list[str]:
    """One row for each parameter and rule."""
    found = []
    with RULES.open(newline="", encoding="utf-8") as file:
        rules = list(csv.DictReader(file))
    for model, identifier, name in PARAMETER.findall(VARIABLES.read_text(encoding="utf-8")):
        for rule in rules:
            if rule["name"] == re.sub(r"^cam[12]\.", "cam.", name):
                texts = f'"{rule["likely"]}", "{rule["other_unit"]}"'
                numbers = f"{rule['side'].upper()}, {rule['limit']}, {texts}, {rule['per_unit']}"
                found.append(f"UNIT_GUARD({model}, {identifier}, {numbers})")
    return found


def table() -> dict[Path, str]:
    return {TABLE: generated.head_of(__file__) + "\n".join(rows()) + "\n"}


if __name__ == "__main__":
    sys.exit(generated.write_or_check(table, __file__))
