"""The documentation site: Sphinx builds it without a warning, no link is broken, every page and every public
name is on it.

The build takes about half a minute and needs the extra `docs`. All other tests need none.
"""

import faulthandler
import importlib
import importlib.util
import pkgutil
import re
import runpy
import subprocess
import sys
import tomllib

import pytest
from driver import ROOT
from pages import DOCS, FRONT, OF_DOCS, load

import dualcam
from dualcam import design, study, systems

check_site = load(DOCS / "tools" / "check_site.py")
run_page = load(DOCS / "tools" / "run_page.py")
LONGEST = 280  # s of processor time
needs_sphinx = pytest.mark.skipif(
    importlib.util.find_spec("sphinx_gallery") is None, reason="needs the extra `docs`"
)
API = {path.stem: path.read_text(encoding="utf-8") for path in (DOCS / "api").glob("*.rst")}
TOCTREE = re.compile(r"^```\{toctree\}\n(.*?)^```", re.MULTILINE | re.DOTALL)
ANSWERS = ("command-line", "stick-band", "masters", "trust", "README")  # what a new user looks for first


def limit_processor_time() -> None:
    import resource

    resource.setrlimit(resource.RLIMIT_CPU, (LONGEST, LONGEST))


@needs_sphinx
def test_site_builds_without_a_warning(tmp_path):
    """With the gallery's scripts, which run, and with the living page. The limit is processor time, so that
    the load of the machine does not count; the limit of pytest by the clock is lifted."""
    script = DOCS / "tools" / "build_site.py"
    faulthandler.cancel_dump_traceback_later()
    done = subprocess.run(
        [sys.executable, script, "--output", tmp_path / "site"],
        capture_output=True,
        text=True,
        preexec_fn=None if sys.platform == "win32" else limit_processor_time,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "none broken" in done.stdout
    pages = {path.relative_to(tmp_path / "site").as_posix() for path in (tmp_path / "site").rglob("*.html")}
    assert {f"{path.stem}.html" for path in [*OF_DOCS, FRONT]} <= pages
    assert {"_static/view.html", "search.html", "site/changelog.html", "gallery/index.html"} <= pages
    assert {f"gallery/{path.stem}.html" for path in (DOCS / "gallery_scripts").glob("plot_*.py")} <= pages


# ---- pages ----


def toctree(text):
    """The entries of the toctree of a page."""
    return [line for body in TOCTREE.findall(text) for line in body.split() if not line.startswith(":")]


def test_every_page_is_in_one_section(extension):
    """The sections are the headings of the list of pages, which the front page names."""
    sections = extension["sections"](extension["LIST"].read_text(encoding="utf-8"))
    listed = [name for text in sections.values() for name in toctree(text)]
    assert {f"../{path.stem}" for path in OF_DOCS} <= set(listed)
    assert len(set(listed)) == len(listed)
    assert toctree(FRONT.read_text(encoding="utf-8")) == [f"site/{name}" for name in sections]
    assert {"overview", "contributing", "changelog", "../api/index", "../gallery/index"} <= set(listed)


def test_an_earlier_address_leads_to_a_page(extension):
    pages = {path.stem for path in OF_DOCS}
    assert set(extension["MOVED"].values()) <= pages and not set(extension["MOVED"]) & pages


def test_front_page_leads_to_each_answer_and_each_tutorial():
    text = FRONT.read_text(encoding="utf-8")
    first = text.partition(":::{living-page}")[0]
    tutorials = sorted(path.stem for path in DOCS.glob("tutorial-*.md"))
    assert re.findall(r"\]\(([\w-]+)\.md(?:#[\w-]+)?\)", first) == [*ANSWERS, "install"]
    assert set(ANSWERS) | set(tutorials) <= set(re.findall(r"^:link: ([\w/-]+)", text, re.MULTILINE))
    for name in re.findall(r"^:link: ([\w/-]+)$", text, re.MULTILINE):
        assert (DOCS / f"{name}.md").is_file() or name == "gallery/index"


def test_commands_of_the_front_page_run(tmp_path):
    run_page.run_page(FRONT, tmp_path)
    assert {"my.toml", "out.csv", "out.png", "my.html", "MyCam.fmu"} <= {
        path.name for path in tmp_path.iterdir()
    }


def test_cited_version_is_this_one():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    page, reference = (
        (ROOT / name).read_text(encoding="utf-8") for name in ("docs/README.md", "CITATION.cff")
    )
    assert re.findall(r"version\s*=?\s*\{?([\d.]+\d)", page) == [project["version"]] * 2
    (date,) = re.findall(r"date\s*= \{(.*)\}", page)
    assert re.search(r"^date-released: (.*)$", reference, re.MULTILINE)[1] == date
    title = re.search(r"^ {4}title: (.*)$", reference, re.MULTILINE)[1]  # of the paper
    assert title in page and title in " ".join(page.replace("> ", "").split())


# ---- Python API ----


def listed_names(page):
    """Names in the autosummaries of a page."""
    return set(re.findall(r"^   ([A-Za-z_]\w*)$", API[page], re.MULTILINE))


@pytest.mark.parametrize("page, module", [("index", dualcam), ("design", design), ("study", study)])
def test_every_public_name_is_on_the_page(page, module):
    """A module of dualcam.__all__ stands by its own names; a name of dualcam is not repeated."""
    elsewhere = set() if module is dualcam else set(dualcam.__all__)
    modules = {entry.name for entry in pkgutil.iter_modules(dualcam.__path__)}
    public = {name for name in module.__all__ if not name.startswith("_")} - elsewhere - modules
    assert public <= listed_names(page)


def test_every_module_of_systems_is_on_the_page():
    found = pkgutil.walk_packages(systems.__path__, "dualcam.systems.")
    modules = {entry.name.rpartition(".")[2] for entry in found if not entry.ispkg}
    assert modules == listed_names("systems")


# ---- the check of links ----

GOOD = '<p id="top"><a href="#top">up</a> <a href="b.html#one">b</a> <img src="p.png" alt="p"></p>'


@pytest.fixture
def site(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "a.html").write_text(GOOD)
    (tmp_path / "b.html").write_text('<h1 id="one">b</h1><a href="sub/">folder</a>')
    (tmp_path / "sub/index.html").write_text('<a href="../a.html#top">a</a> <a href="https://x.org/#y">x</a>')
    (tmp_path / "p.png").write_bytes(b"")
    return tmp_path


def test_check_finds_nothing_in_a_good_site(site):
    assert check_site.check(site) == []


@pytest.mark.parametrize(
    "html, message",
    [
        ('<a href="c.html">c</a>', "c.html: no such file"),
        ('<a href="b.html#two">b</a>', "b.html#two: no anchor 'two' there"),
        ('<a href="#lost">lost</a>', "#lost: no anchor 'lost' there"),
        ('<a href="../other.html">out</a>', "../other.html: leads out of the site"),
        ('<img src="q.png" alt="q">', "q.png: no such file"),
        ('<img src="p.png">', "picture without alt text: p.png"),
        ('<img srcset="p.png, q.png 2x" alt="two sizes">', "q.png: no such file"),
        ('<iframe src="view.html"></iframe>', "view.html: no such file"),
        ('<script src="https://cdn.org/x.js"></script>', "asks another server for https://cdn.org/x.js"),
        ('<link rel="stylesheet" href="//cdn.org/x.css">', "asks another server for //cdn.org/x.css"),
    ],
)
def test_check_finds_what_is_broken(site, html, message):
    (site / "more.html").write_text(html)
    (found,) = check_site.check(site)
    assert found.startswith("more.html: ") and message in found
    assert check_site.main([str(site)]) == 1


# ---- the site's own extension of Sphinx ----


@pytest.fixture(scope="module")
def extension():
    pytest.importorskip("sphinx", reason="needs the extra `docs`")
    return runpy.run_path(str(DOCS / "tools" / "site_extension.py"))


def test_links_of_pages_outside_of_docs(extension):
    """README.md is a page of the site; what has no page stays a file."""
    target, page = extension["site_target"], DOCS / "site" / "overview.md"
    assert target(ROOT / "docs/trust.md", page) == "../trust.md"
    assert target(ROOT / "CHANGELOG.md", page) == "changelog.md"
    assert target(ROOT / "CITATION.cff", DOCS / "README.md") == "../CITATION.cff"
