"""Configuration of the documentation site; `./build.sh docs` builds it."""

from __future__ import annotations

import os
import sys
import tomllib
from pathlib import Path

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
# The gallery imports system_examples, and this file its extension of docs/tools.
sys.path[:0] = [str(ROOT), str(DOCS / "tools")]
os.environ.setdefault("MPLBACKEND", "agg")

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

project = PROJECT["name"]
author = PROJECT["authors"][0]["name"]
project_copyright = f"2026, {author}. {PROJECT['license']}"
release = PROJECT["version"]
version = release

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.viewcode",
    "numpydoc",
    "sphinx_design",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "site_extension",
]
templates_path = ["_templates"]
# Written by sphinx-gallery and read by itself; README.md is the index of pages where there is no site.
exclude_patterns = ["gallery/*.ipynb", "gallery/*.py", "gallery_scripts", "_templates", "figures", "tools"]
default_role = "code"
highlight_language = "text"
suppress_warnings = ["config.cache"]

# ---- pages in Markdown ----

myst_enable_extensions = ["colon_fence", "deflist", "attrs_block", "attrs_inline"]
myst_heading_anchors = 4  # anchors as GitHub makes them

# ---- Python API ----

autosummary_generate = True
autosummary_imported_members = True
autodoc_typehints = "signature"  # docstrings give units and shapes
autodoc_member_order = "bysource"
maximum_signature_line_length = 60  # beyond, each parameter has a line of its own
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

# ---- examples ----

sphinx_gallery_conf = {
    "examples_dirs": "gallery_scripts",
    "gallery_dirs": "gallery",
    "filename_pattern": r"[\\/]plot_",
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "capture_repr": (),  # what print() writes is enough
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "write_computation_times": False,  # that page would ask other servers for scripts
    "remove_config_comments": True,
    "plot_gallery": "True",
}

# ---- look ----

html_theme = "pydata_sphinx_theme"
html_title = f"dualcam {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "logo": {"text": "dualcam"},
    "navbar_align": "left",
    "header_links_before_dropdown": 8,
    "show_prev_next": True,
    "navigation_with_keys": False,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "show_toc_level": 2,
    "navigation_depth": 3,
}
html_context = {"default_mode": "auto"}  # light or dark, as the reader's system is
html_sidebars = {"index": []}

# ---- links to other sites: `./build.sh docs links` ----

linkcheck_timeout = 20
linkcheck_retries = 2
