"""Writes the tables of docs/study-plan.md, and dualcam/study/plan.schema.json for editors.

Run by `./build.sh run figures`. All come from the schema of plans. tests/test_study_plan_page.py keeps them
fresh."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from dualcam.common import entries
from dualcam.scenario.formula import ARGUMENTS, FUNCTIONS
from dualcam.study.file.schema import json_schema, model_of

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "study-plan.md"
SCHEMA = ROOT / "dualcam" / "study" / "plan.schema.json"
VALUES = {  # of a kind of value, by its words in messages
    entries.NUMBER.words: "number",
    entries.WHOLE.words: "whole number",
    entries.SWITCH.words: "true or false",
    entries.TEXT.words: "text",
    entries.TABLE.words: "table",
    entries.QUANTITY.words: "number, or text with a unit",
    entries.SCENARIO_NUMBER.words: "number, text with a unit, or formula",
    entries.VALUES.words: "list of numbers or texts",
    entries.NUMBER.listed().words: "list of numbers",
    entries.TEXT.listed().words: "list of texts",
    entries.SCENARIO_NUMBER.listed().words: "list of numbers, texts with a unit, or formulas",
    entries.NUMBERS_BY_NAME.words: "table of formulas",
    entries.QUANTITIES_BY_NAME.words: "table of numbers, or of texts with a unit",
    "a list of tables": "list of tables",
}
ANY_NAME = ("plan.vary", "scenario.inputs", "optimise.constraints", "optimise.tolerances")


def schema_text() -> str:
    """The JSON Schema as a file."""
    return json.dumps(json_schema(), indent=1, ensure_ascii=False) + "\n"


def keys(model: Any, prefix: str = "") -> Iterator[tuple[str, Any]]:  # noqa: ANN401
    """All keys, dotted, with their fields; NAME stands for any name."""
    for name, field in model.model_fields.items():
        key = f"{prefix}{name}"
        yield key, field
        inner = _inner(field.annotation)
        if inner is not None:
            yield from keys(inner, f"{key}.NAME." if key in ANY_NAME else f"{key}.")


def _inner(kind: Any) -> Any:  # noqa: ANN401
    """The table within a type such as a list of tables; None for other types."""
    while not hasattr(kind, "model_fields"):
        if hasattr(kind, "__metadata__"):
            kind = kind.__origin__
        elif getattr(kind, "__args__", None):
            kind = kind.__args__[-1]
        else:
            return None
    return kind


def rows() -> list[str]:
    """One row of the table for each key."""
    found = ["| key | value | meaning |", "| --- | --- | --- |"]
    for key, field in keys(model_of("Plan")):
        extra = field.json_schema_extra
        needed = " (needed)" if extra["needed"] else ""
        found.append(f"| `{key}` | {VALUES[extra['words']]} | {field.description}{needed} |")
    return found


def functions() -> list[str]:
    """One row for each function of formulas."""
    found = ["| function | values |", "| --- | --- |"]
    for name in FUNCTIONS:
        low, high = ARGUMENTS.get(name, (1, 1))
        found.append(f"| `{name}` | {low if low == high else f'{low} or more'} |")
    return found


def page() -> str:
    """docs/study-plan.md with fresh tables."""
    text = PAGE.read_text(encoding="utf-8")
    for name, table in (("keys", rows()), ("functions", functions())):
        begin, end = f"<!-- {name}: generated -->\n", f"<!-- end of {name} -->\n"
        before, rest = text.split(begin)
        text = before + begin + "\n".join(table) + "\n" + end + rest.split(end)[1]
    return text


def main() -> None:
    argparse.ArgumentParser(description=__doc__).parse_known_args()
    SCHEMA.write_text(schema_text(), encoding="utf-8")
    PAGE.write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
