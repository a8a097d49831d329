"""Checks the built site: every link, anchor and picture leads somewhere, and no page asks another server for
anything.

Read from the HTML alone, so raw HTML and what extensions write is checked too.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

# Attributes by which a browser fetches a file when the page opens, without a click.
FETCHED = {
    "img": ("src", "srcset"),
    "script": ("src",),
    "link": ("href",),
    "iframe": ("src",),
    "object": ("data",),
    "source": ("src", "srcset"),
    "video": ("src", "poster"),
}
NOT_FETCHED_RELS = {"canonical", "author", "search", "index", "next", "prev", "up"}


@dataclass
class Page(HTMLParser):
    """Anchors, links and fetched files of one page."""

    path: Path
    anchors: set[str] = field(default_factory=set)
    links: list[str] = field(default_factory=list)
    fetched: list[str] = field(default_factory=list)
    without_text: list[str] = field(default_factory=list)  # pictures that a screen reader cannot read

    def __post_init__(self) -> None:
        super().__init__()
        self.feed(self.path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Called by HTMLParser."""
        values = {name: value for name, value in attrs if value is not None}
        self.anchors.update(values[name] for name in ("id", "name") if name in values)
        if tag in ("a", "area") and "href" in values:
            self.links.append(values["href"])
        if tag == "link" and NOT_FETCHED_RELS & set(values.get("rel", "").split()):
            return
        for attribute in FETCHED.get(tag, ()):
            self.fetched += [
                part.split()[0] for part in values.get(attribute, "").split(", ") if part.strip()
            ]
        if tag == "img" and "alt" not in values:
            self.without_text.append(values.get("src", "?"))


@cache
def read(path: Path) -> Page:
    """The page at that path, parsed once."""
    return Page(path)


def problems_of(page: Page, root: Path) -> list[str]:
    """What is wrong with a page of the site at `root`, in words."""
    name = page.path.relative_to(root).as_posix()
    found = [f"{name}: picture without alt text: {source}" for source in page.without_text]
    for address in page.fetched:
        parts = urlsplit(address)
        if parts.scheme in ("http", "https") or (parts.netloc and parts.scheme != "data"):
            found.append(f"{name}: asks another server for {address}")
    for address in [*page.links, *page.fetched]:
        reason = why_broken(address, page, root)
        if reason:
            found.append(f"{name}: {address}: {reason}")
    return found


def why_broken(address: str, page: Page, root: Path) -> str:
    """Why a link within the site leads nowhere; empty if the link is good or leaves the site."""
    parts = urlsplit(address)
    if parts.scheme or parts.netloc:
        return ""
    target = page.path
    if parts.path:
        target = (page.path.parent / unquote(parts.path)).resolve()
        if target.is_dir():
            target /= "index.html"
    if not target.is_relative_to(root):
        return "leads out of the site"
    if not target.is_file():
        return "no such file"
    anchor = unquote(parts.fragment)
    if anchor and target.suffix == ".html" and anchor not in read(target).anchors:
        return f"no anchor {anchor!r} there"
    return ""


def check(root: Path) -> list[str]:
    """Everything that is wrong with the site at `root`, one line each."""
    root = root.resolve()
    pages = [path for path in sorted(root.rglob("*.html")) if "_static" not in path.relative_to(root).parts]
    return [problem for path in pages for problem in dict.fromkeys(problems_of(read(path), root))]


def main(arguments: Sequence[str] | None = None) -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n\n")[0])
    parser.add_argument("site", type=Path, help="folder of the built site")
    found = check(parser.parse_args(arguments).site)
    print("\n".join(found) or "links, anchors and pictures of the site: none broken")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
