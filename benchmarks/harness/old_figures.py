"""Says below the title of a page that its figures are older than the C core, and takes that line away again.

    python -m benchmarks.harness.old_figures

The results of a page are the CSV files that it names. Each row of them has the hash of the C sources that
were measured. Pages that are written without a CSV file name that hash themselves, as `core HASH`.
"""

from __future__ import annotations

import csv
import re
from pathlib import Path

from benchmarks.harness.circumstances import core_of
from benchmarks.harness.repository import DOCS, ROOT

FILE = re.compile(r"`((?:benchmarks|tests/verification)/results/\w+\.csv)`")
OWN = re.compile(r"\bcore ([0-9a-f]{12})\b")
TITLE = re.compile(r"\A((?:---\n.*?^---\n+)?# [^\n]*\n\n)", re.MULTILINE | re.DOTALL)
NEW = "all results are new; are numbers that stand there by hand theirs?"
LINE = re.compile(r"^> \*\*Older than the core:\*\* [^\n]*\n\n", re.MULTILINE)


def measured_core(path: Path) -> str:
    """The hash in the last row of a CSV file, or in a line `# core: HASH` at its end."""
    with path.open(newline="", encoding="utf-8") as file:
        last = list(csv.DictReader(file))[-1]
    return last.get("core") or next(iter(last.values())).removeprefix("# core: ")


def old_results(text: str, core: str) -> list[str]:
    """Names of the results of a page that are those of another core."""
    files = [ROOT / name for name in dict.fromkeys(FILE.findall(text))]
    old = [path.name for path in files if measured_core(path) != core]
    return old + ["this page" for found in OWN.findall(text) if found != core]


def without_line(text: str) -> str:
    return LINE.sub("", text, count=1)


def with_line(text: str, core: str | None = None) -> str:
    """The text of a page. It has the line if it has results of another core than `core`, that of today."""
    text = without_line(text)
    if not (FILE.search(text) or OWN.search(text)):
        return text
    old = old_results(text, core or core_of())
    if not old:
        return text
    line = (
        f"> **Older than the core:** the figures of {', '.join(old)} were measured with earlier C code. "
        "`./build.sh run refresh` measures them anew.\n\n"
    )
    return TITLE.sub(lambda title: title[1] + line, text, count=1)


def main() -> None:
    core = core_of()
    for page in (ROOT / "README.md", *sorted(DOCS.glob("*.md"))):
        text = page.read_text(encoding="utf-8")
        fresh = with_line(text, core)
        if fresh != text:
            page.write_text(fresh, encoding="utf-8")
            said = "has old figures" if LINE.search(fresh) else NEW
            print(f"{page.relative_to(ROOT)}: {said}")


if __name__ == "__main__":
    main()
