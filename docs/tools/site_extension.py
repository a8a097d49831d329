"""The parts of the documentation site that no extension of Sphinx offers.

Sections from the list of pages (docs/README.md), pages from outside of docs/ (README.md, CONTRIBUTING.md,
CHANGELOG.md) with their links, addresses of pages that have moved, blocks of docstrings, the living page,
pictures that open in full size, and links from source code back to the API.
"""

from __future__ import annotations

import inspect
import os
import re
from collections.abc import Callable, Mapping
from html import escape
from itertools import groupby
from pathlib import Path
from typing import Any, ClassVar

from docutils import nodes
from docutils.parsers.rst import directives
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.inspect import stringify_signature

import dualcam
from benchmarks.harness.old_figures import with_line

DOCS = Path(__file__).resolve().parent.parent
ROOT = DOCS.parent
# The pages of the site that show a file of the repository's root, or what is made of a file.
PAGE_OF = {
    DOCS / "gallery_scripts/GALLERY_HEADER.rst": DOCS / "gallery/index.rst",
    ROOT / "README.md": DOCS / "site/overview.md",
    ROOT / "CONTRIBUTING.md": DOCS / "site/contributing.md",
    ROOT / "CHANGELOG.md": DOCS / "site/changelog.md",
}
LIST = DOCS / "README.md"
SECTION = re.compile(r"^## ([^\n]*)\n(.*?)(?=^##|\Z)", re.MULTILINE | re.DOTALL)
ROW = re.compile(r"^\|[^|]*\| \[[^\]]*\]\(([^)#]+)", re.MULTILINE)
# Addresses of earlier pages, without .html. Somebody may have kept them.
MOVED = {
    "accuracy": "trust",
    "reliability": "trust",
    "stress": "trust-tables",
    "elementary-functions": "trust-tables",
    "test-strength": "development",
    "use-study-clusters": "use-study-results",
    "ssp": "use-ssp",
    "use-casadi": "use-python-control",
    "cite": "README",
    "use-fmi3": "use-co-simulation",
}
LIVING_PAGE = "_static/view.html"
SHOWN = re.compile(r"<!-- text of (\S+) -->\n")
LINK = re.compile(r"\]\((?!\w+:)([^)#\s]+)((?:#[^)\s]*)?)\)")
COLUMNS = re.compile(r"^\S(.*\S)? {3,}\S")
BACK_LINK = re.compile(r'href="([^"#]*/)([\w.]+)\.html#([\w.]+)"')
FILE_AS_TEXT = re.compile(r"\[(?:docs/)?([\w-]+)\.md\]\((?=[^)]+\.md(#?))")
PICTURE = re.compile(r'<p>(<img [^>]*src="([^"]+)"[^>]*>)')
IMAGE = re.compile(r'<img src="([^"]+)" alt="([^"]*)"[^>]*>')


def sections(text: str) -> dict[str, str]:
    """The pages of docs/site that the list of pages makes: one for each heading, with its rows."""
    pages = {}
    for title, rows in SECTION.findall(text):
        targets = [site_target(DOCS / path, DOCS / "site/page.md") for path in ROW.findall(rows)]
        listed = "\n".join(target.removesuffix(".md").removesuffix(".rst") for target in targets)
        shown = LINK.sub(r"](../\1\2)", rows).strip()
        pages[title.lower()] = f"# {title}\n\n{shown}\n\n```{{toctree}}\n:hidden:\n\n{listed}\n```\n"
    return pages


def write_sections(_: Sphinx) -> None:
    """docs/site: the sections, and a page for each file of the root."""
    pages = {DOCS / f"site/{name}.md": text for name, text in sections(LIST.read_text("utf-8")).items()}
    for file, page in PAGE_OF.items():
        if page.parent == DOCS / "site":
            pages[page] = f"<!-- text of ../../{file.name} -->\n"
    (DOCS / "site").mkdir(exist_ok=True)
    for page, text in pages.items():
        page.write_text(text, encoding="utf-8")


def write_moved(app: Sphinx, failure: Exception | None) -> None:
    """A page at each earlier address that leads to the new one."""
    if failure is None and app.builder.format == "html":
        for old, new in MOVED.items():
            text = f"""<!DOCTYPE html><meta charset="utf-8"><title>Moved</title>
<meta http-equiv="refresh" content="0; url={new}.html"><a href="{new}.html">This page has moved.</a>
"""
            (Path(app.outdir) / f"{old}.html").write_text(text, encoding="utf-8")


def show_file(app: Sphinx, name: str, source: list[str]) -> None:
    """Put the text of the file in place of the comment that names the file, mend the links, and say where
    figures are older than the core."""
    page = Path(app.env.doc2path(name))
    base = page.parent
    text = source[0]
    shown = SHOWN.search(text)
    if shown:
        file = (base / shown[1]).resolve()
        app.env.note_dependency(str(file))
        text = text.replace(shown[0], IMAGE.sub(r"![\2](\1)", file.read_text(encoding="utf-8")))
        base = file.parent
    text = LINK.sub(lambda link: f"]({site_target(base / link[1], page)}{link[2]})", text)
    text = with_line(text)
    # In place of a file's name: the title of the page; to a section of a page: the name without its ending.
    source[0] = FILE_AS_TEXT.sub(lambda link: f"[{link[1]}](" if link[2] else "[](", text)


def site_target(file: Path, page: Path) -> str:
    """The path by which `page` of the site links to `file`."""
    resolved = Path(os.path.normpath(file))
    return os.path.relpath(PAGE_OF.get(resolved, resolved), page.parent).replace(os.sep, "/")


# ---- docstrings ----


def mark_blocks(_: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]) -> None:
    """Make literal blocks of what docstrings indent below a blank line, or lay out in columns.

    Such a block is code or a table in plain text. reStructuredText takes it for a quotation.
    """
    marked: list[str] = []
    margin, in_block, announced = 0, False, False  # margin: indent of the latest line of text
    for paragraph in split_paragraphs(lines):
        first, last = indent_of(paragraph[0]), indent_of(paragraph[-1])
        columns = COLUMNS.match(paragraph[0]) is not None
        in_block = columns or first > margin + (0 if in_block else 3)
        if in_block and not announced:
            marked += [" " * margin + "::", ""]
        marked += ["    " + line for line in paragraph] if columns else paragraph
        marked.append("")
        announced = in_block or paragraph[-1].endswith("::")
        margin = margin if in_block else last
    lines[:] = marked


def types_as_written(
    _: Sphinx, what: str, name: str, thing: Callable[..., object], *more: object
) -> tuple[str, str] | None:
    """A signature with the types as the source names them: Array, not what NumPy makes of it."""
    own = str(getattr(thing, "__module__", "")).startswith("dualcam")
    if not own or what not in ("class", "function", "method"):
        return None
    signature = inspect.signature(thing)
    listed = list(signature.parameters.values())
    bound = what == "method" and listed[:1] and listed[0].name in ("self", "cls")
    written = signature.replace(parameters=listed[bool(bound) :])
    shown = stringify_signature(written, show_return_annotation=False, unqualified_typehints=True)
    result = "" if what == "class" else written.return_annotation
    return shown, result if isinstance(result, str) else ""


def leave_out(_: Sphinx, what: str, name: str, thing: object, skip: bool, options: object) -> bool:
    """Whether a member is left out: fields of a NamedTuple, which the section Attributes describes."""
    return skip or (getattr(thing, "__doc__", "") or "").startswith("Alias for field number")


def split_paragraphs(lines: list[str]) -> list[list[str]]:
    """Lines between blank lines."""
    groups = groupby(lines, key=lambda line: bool(line.strip()))
    return [list(group) for is_text, group in groups if is_text]


def indent_of(line: str) -> int:
    """Number of spaces before the text."""
    return len(line) - len(line.lstrip())


# ---- the living page ----


class LivingPage(SphinxDirective):
    """A frame with the page of `dualcam view`, and a picture of the page for readers without scripts."""

    option_spec: ClassVar = {"title": directives.unchanged_required, "picture": directives.unchanged_required}

    def run(self) -> list[nodes.Node]:
        """Called by docutils."""
        page, title = LIVING_PAGE, escape(self.options["title"])
        picture = f"_static/{self.options['picture']}"
        text = (
            f'<iframe class="living-page" src="{page}" title="{title}"></iframe>\n'
            f'<noscript><p class="living-page-still"><img src="{picture}" alt="{title}"></p></noscript>\n'
            f'<p class="living-page-links"><a href="{page}">Open this page in the whole window</a>. The page'
            " needs no network: save it, send it.</p>"
        )
        return [nodes.raw("", text, format="html")]


def write_living_page(app: Sphinx, failure: Exception | None) -> None:
    """Write the page of the default mechanism into the built site."""
    if failure is None and app.builder.format == "html":
        dualcam.write_view(None, Path(app.outdir) / LIVING_PAGE)


# ---- HTML ----


def link_pictures(_: Sphinx, name: str, __: str, context: dict[str, Any], ___: object) -> None:
    """Let each picture of a page lead to its file: a phone shows the page's picture too small to read."""
    if "body" in context:
        context["body"] = PICTURE.sub(r'<p><a href="\2">\1</a>', context["body"])


def mend_back_links(app: Sphinx, name: str, _: str, context: dict[str, Any], __: object) -> None:
    """Let the links of a page of source code lead to the name by which the API documents the thing.

    sphinx.ext.viewcode keeps one module's name per file, but a file has names of `dualcam` and of its room.
    """
    if name.startswith("_modules/"):
        objects = app.env.domaindata["py"]["objects"]
        context["body"] = BACK_LINK.sub(lambda link: back_link(link, objects), context["body"])


def back_link(link: re.Match[str], objects: Mapping[str, Any]) -> str:
    """The link with the anchor that its page has."""
    folder, page, anchor = link.groups()
    known = [full for full, entry in objects.items() if entry.docname.endswith(f"/{page}")]
    for full in known if anchor not in known else ():
        own = full.removeprefix(page.rpartition(".")[0])  # as .Plan.rows, whatever module has it
        if full.startswith(page) and anchor.endswith(own):
            anchor = full
            break
    return f'href="{folder}{page}.html#{anchor}"'


def setup(app: Sphinx) -> dict[str, Any]:
    """Called by Sphinx."""
    app.add_directive("living-page", LivingPage)
    app.connect("builder-inited", write_sections)
    app.connect("build-finished", write_living_page)
    app.connect("build-finished", write_moved)
    app.connect("source-read", show_file)
    app.connect("autodoc-process-docstring", mark_blocks, priority=400)  # before numpydoc
    app.connect("autodoc-process-signature", types_as_written)
    app.connect("autodoc-skip-member", leave_out)
    app.connect("html-page-context", mend_back_links)
    app.connect("html-page-context", link_pictures)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
