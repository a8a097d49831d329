"""Builds the documentation site with Sphinx, then checks its links; with `links` also those to other sites.

Warnings are errors. The site needs no server: its front page opens from disk.
"""

from __future__ import annotations

import argparse
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import check_site

DOCS = Path(__file__).resolve().parent.parent
SITE = DOCS.parent / "build" / "docs"
# Extensions write them beside the pages. A page of a name that is gone would stay.
WRITTEN = (DOCS / "api" / "generated", DOCS / "gallery", DOCS / "site")


def sphinx(builder: str, target: Path) -> int:
    """Exit code of Sphinx with that builder; all pages are read anew, so that no warning is missed."""
    for folder in WRITTEN:
        shutil.rmtree(folder, ignore_errors=True)
    options = ["-W", "--keep-going", "-q", "-E", "-b", builder, "-d", f"{target}-pages"]
    return subprocess.run([sys.executable, "-m", "sphinx", *options, str(DOCS), str(target)]).returncode


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line; returns the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    parser.add_argument("task", nargs="?", choices=["links"], help="check the links to other sites as well")
    parser.add_argument("--output", type=Path, default=SITE, help="folder of the site (default: build/docs)")
    options = parser.parse_args(arguments)
    site = options.output.resolve()
    shutil.rmtree(site, ignore_errors=True)
    if sphinx("html", site) or check_site.main([str(site)]):
        return 1
    if options.task == "links" and sphinx("linkcheck", site.parent / "docs-links"):
        return 1
    print(f"Front page: {site / 'index.html'}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
