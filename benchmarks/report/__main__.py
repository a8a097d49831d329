"""The command: writes the page, and names results whose commit is not in the history."""

from __future__ import annotations

import argparse
from pathlib import Path

from benchmarks import report
from benchmarks.harness.circumstances import is_in_history
from benchmarks.harness.markdown import read
from benchmarks.harness.old_figures import with_line
from benchmarks.harness.repository import DOCS, RESULTS
from benchmarks.report.page import FILES, page


def main() -> None:
    parser = argparse.ArgumentParser(description=(report.__doc__ or "").split("\n")[0])
    parser.add_argument("--results", type=Path, default=RESULTS)
    parser.add_argument("--page", type=Path, default=DOCS / "performance.md")
    arguments = parser.parse_args()
    arguments.page.write_text(with_line(page(arguments.results.resolve(), arguments.page.resolve().parent)))
    print(f"written: {arguments.page}")
    for name in FILES:
        commit = read(arguments.results, name)[0]["commit"]
        if not is_in_history(commit):
            print(f"{name}.csv: commit {commit} is not in the history: measure again before it is published")


if __name__ == "__main__":
    main()
