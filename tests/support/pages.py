"""The pages README.md, CONTRIBUTING.md, CHANGELOG.md and docs/*.md, and the scripts of docs."""

import importlib.util
import sys

from driver import ROOT

DOCS = ROOT / "docs"
TOP = [ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")]
FRONT = DOCS / "index.md"  # of the documentation site: tests/test_site.py
OF_DOCS = sorted(path for path in DOCS.glob("*.md") if path != FRONT)
PAGES = {path.relative_to(ROOT).as_posix(): path for path in [*TOP, *OF_DOCS]}
TEXTS = {name: path.read_text(encoding="utf-8") for name, path in PAGES.items()}


def load(path):
    """A script as a module."""
    name = f"{path.stem}_script"
    spec = importlib.util.spec_from_file_location(name, path)
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
