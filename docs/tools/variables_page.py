"""Writes docs/variables.md: all variables of both FMUs, from modelDescription/fmi3/*.xml.

Run by `./build.sh run figures`. The XML is made from fmu_src/variables.def, and tests keep the XML fresh. The
FMI 3.0 files are read because they also list the time and the event indicators. FMI 2.0 has the other
variables under the same names and value references (tests/test_pages.py)."""

from __future__ import annotations

import argparse
import re
import xml.etree.ElementTree as ElementTree
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
FMUS = {"DualCamForward": "forward", "DualCamInverse": "inverse"}
KINDS = {"Float64": "", "Int32": "integer", "Int64": "integer", "Boolean": "boolean", "String": "text"}
# A sign is -1 or +1: the XML gives the range only.
SIGN = re.compile(r'VARIABLE\(\w+, (?:EACH\(\d+, \d+\)|\d+), SIGN, \w+, \w+, [^,]+, "([^"]+)"')
ONLY_FMI3 = re.compile(r"time|indicator\.\w+")  # names that the FMI 2.0 files do not have

INTRODUCTION = """# All variables of the FMUs

Read this page to look up a variable. Page [interface.md](interface.md) explains how the variables are used.

- All values are in SI units. The FMUs also name display units (deg, rpm, mm, ...).
- Column *start*: the value without any setting. Column *allowed*: the range; another value is refused.
- Column *FMU*: `both`, or the FMU that has the variable.
- Column *ref*: the value reference, the number by which FMI calls name the variable; forward/inverse FMU
  where the two differ.
- FMI 2.0 and FMI 3.0 have the same names and value references. `time` and `indicator.*` exist in FMI 3.0
  only. The FMI 2.0 file of the forward FMU names the states of model exchange `state.theta`, `state.omega`,
  `der(state.theta)` and `der(state.omega)` in addition.
"""

END = """## Where this page comes from

The script `docs/tools/variables_page.py` (`./build.sh run figures`) writes the page from
`modelDescription/fmi3/*.xml`, which come from `fmu_src/variables.def`. Test `tests/test_pages.py` fails where
the page is old.
"""


@dataclass(frozen=True)
class Variable:
    """One variable of one FMU, as the XML has it."""

    name: str
    reference: str
    causality: str
    variability: str
    kind: str  # "" for a real number
    unit: str
    start: str
    allowed: str
    description: str

    def row_without_reference(self) -> tuple[str, ...]:
        return (self.name, self.causality, self.unit, self.start, self.allowed, self.description)


@dataclass(frozen=True)
class Section:
    """A table of the page."""

    title: str
    belongs: Callable[[Variable], bool]
    words: str
    settable: bool  # start value and range are shown


SECTIONS = (
    Section(
        "Inputs",
        lambda v: v.causality == "input",
        "May be set at any time. Between two steps they stay as they are.",
        True,
    ),
    Section("Outputs", lambda v: v.causality == "output", "", False),
    Section(
        "Tunable parameters",
        lambda v: v.variability == "tunable",
        "May be set before the start, and between two steps.",
        True,
    ),
    Section(
        "Fixed parameters",
        lambda v: v.causality == "parameter" and v.variability == "fixed",
        "May be set before the start only.",
        True,
    ),
    Section(
        "Values to be read",
        lambda v: v.causality == "local" and not ONLY_FMI3.fullmatch(v.name),
        "Computed when they are read, and only then.",
        False,
    ),
    Section("FMI 3.0 only", lambda v: bool(ONLY_FMI3.fullmatch(v.name)), "", False),
)


def rounded(number: str) -> str:
    """At most 6 digits, and nothing where there is no number."""
    return f"{float(number):.6g}" if number else ""


def limits(low: str, high: str) -> str:
    """The allowed range in words; "" where every value is allowed."""
    if low and high:
        return f"{rounded(low)} to {rounded(high)}"
    return f"≥ {rounded(low)}" if low else f"≤ {rounded(high)}" if high else ""


def read_variable(element: ElementTree.Element, signs: set[str]) -> Variable:
    get: Callable[[str], str] = lambda name: element.get(name, "")  # noqa: E731
    kind = KINDS[element.tag]
    text = element.find("Start")
    start = get("start")
    if kind == "text":
        start = f'"{text.get("value", "") if text is not None else start}"'
    elif kind != "boolean":
        start = rounded(start)
    causality = get("causality")
    allowed = limits(get("min"), get("max")) if causality in ("parameter", "input") else ""
    if get("name") in signs:
        allowed = "-1 or 1"
    return Variable(
        get("name"),
        get("valueReference"),
        causality,
        get("variability"),
        kind,
        get("unit") or kind,
        start,
        allowed,
        get("description"),
    )


def read_variables(model: str) -> list[Variable]:
    """In the order of the file."""
    tree = ElementTree.parse(ROOT / "modelDescription" / "fmi3" / f"{model}.xml")
    variables = tree.getroot().find("ModelVariables")
    assert variables is not None
    signs = set(SIGN.findall((ROOT / "fmu_src" / "variables.def").read_text(encoding="utf-8")))
    return [read_variable(element, signs) for element in variables]


def merged(lists: dict[str, list[Variable]]) -> list[tuple[Variable, dict[str, str]]]:
    """Each variable once, with its value reference by FMU. Variables that differ in meaning stay apart."""
    found: dict[tuple[str, ...], tuple[Variable, dict[str, str]]] = {}
    for fmu, variables in lists.items():
        for variable in variables:
            _, references = found.setdefault(variable.row_without_reference(), (variable, {}))
            references[fmu] = variable.reference
    return list(found.values())


def cells(section: Section, variable: Variable, references: dict[str, str]) -> list[str]:
    both = len(references) == len(FMUS)
    numbers = dict.fromkeys(references.values())
    row = [f"`{variable.name}`", variable.unit]
    if section.settable:
        row += [variable.start, variable.allowed]
    return [*row, "both" if both else next(iter(references)), "/".join(numbers), variable.description]


def text_of(section: Section, variables: list[tuple[Variable, dict[str, str]]]) -> str:
    middle = ["start", "allowed"] if section.settable else []
    head = ["name", "unit", *middle, "FMU", "ref", "meaning"]
    chosen = [(variable, references) for variable, references in variables if section.belongs(variable)]
    rows = [head, ["---"] * len(head), *(cells(section, *row) for row in chosen)]
    table = "\n".join("| " + " | ".join(row) + " |" for row in rows)
    return f"## {section.title}\n\n" + (f"{section.words}\n\n" if section.words else "") + table + "\n"


def page() -> str:
    """The text of docs/variables.md."""
    variables = merged({word: read_variables(model) for model, word in FMUS.items()})
    return "\n".join([INTRODUCTION, *(text_of(section, variables) for section in SECTIONS), END])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=Path, default=ROOT / "docs")
    directory: Path = parser.parse_args().output
    directory.mkdir(parents=True, exist_ok=True)
    (directory / "variables.md").write_text(page(), encoding="utf-8")


if __name__ == "__main__":
    main()
