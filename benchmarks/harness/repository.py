"""Folders of the repository."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BENCHMARKS = ROOT / "benchmarks"
RESULTS = BENCHMARKS / "results"
VERIFICATION = ROOT / "tests" / "verification"  # what judges the core and the tests
DOCS = ROOT / "docs"
