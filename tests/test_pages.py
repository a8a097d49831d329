"""README.md, the pages beside it, and docs/*.md: their code runs, what they name exists, what is generated is
fresh."""

import ast
import re
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
import python_rooms
from driver import ROOT, models
from pages import DOCS, OF_DOCS, PAGES, TEXTS, load
from svg_files import assert_same_picture

from benchmarks.harness.old_figures import measured_core, with_line, without_line
from dualcam.__main__ import main
from dualcam.design_file.schema import known_keys
from programs import PROGRAMS

CORE = ROOT / "fmu_src"
README = TEXTS["README.md"]
BLOCK = re.compile(r"(<!-- not run: [^\n]+ -->\n)?```python\n(.*?)```", re.DOTALL)
BLOCKS = [(name, code) for name, text in TEXTS.items() for mark, code in BLOCK.findall(text) if not mark]
run_page = load(DOCS / "tools" / "run_page.py")
# Readers copy one block, so it must run alone. Where blocks belong together: tests/test_page_commands.py.
ALONE = [(name, code) for name, code in BLOCKS if not run_page.is_one_piece(TEXTS[name])]
LINK = re.compile(r"(?:\]\(|<img src=\")([^)\"\s]+)[)\"]")


def blocks_of(page, word):
    return [code for name, code in BLOCKS if name == page and word in code]


@pytest.fixture
def run_block(tmp_path, monkeypatch):
    """Runs a block; returns what it leaves."""

    def run(code):
        script = tmp_path / "block.py"
        script.write_text(code)
        monkeypatch.chdir(ROOT)
        return runpy.run_path(str(script))

    return run


# ---- code blocks ----


@pytest.mark.parametrize("page, code", ALONE, ids=[f"{name}-{i}" for i, (name, _) in enumerate(ALONE)])
def test_block_runs_and_prints_what_it_says(tmp_path, monkeypatch, page, code):
    """Each number beside a print() is printed, to its digits."""
    monkeypatch.chdir(tmp_path)
    run_page.run_code(code)


@pytest.mark.parametrize("page, code", BLOCKS, ids=[f"{name}-{i}" for i, (name, _) in enumerate(BLOCKS)])
def test_blocks_need_no_files_of_a_clone(page, code):
    """Who installs the package has no folder build."""
    assert not re.findall(r"[\"'](?:build|docs|tests|system_examples|fmu_src)\b[^\"']*[\"']", code)


def test_findings_on_the_page_are_those_of_check(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "my.toml"]) == 0
    path = Path("my.toml")
    path.write_text(path.read_text().replace('lead_angle = "45 deg"', 'lead_angle = "6 deg"', 1))
    capsys.readouterr()
    assert main(["check", "my.toml"]) == 1
    said = capsys.readouterr()
    shown = " ".join(TEXTS["docs/command-line.md"].split())
    lines = (said.out + said.err).splitlines()
    assert len(lines) == 2
    assert all(" ".join(line.split()) in shown for line in lines), lines


def test_fmpy_block_ends_in_mode_2(run_block):
    (block,) = blocks_of("README.md", "fmpy")
    assert run_block(block)["result"][-1]["mode"] == 2


def test_python_control_block(run_block, capsys):
    """Ten statements; at the end of the step the torque is the edge of the band, which would hold that angle
    after a move up: rho (F0 + k z)."""
    (block,) = blocks_of("docs/use-python-control.md", "control.nlsys")
    left = run_block(block)
    assert len([node for node in ast.parse(block).body if not isinstance(node, ast.Import)]) <= 10
    theta, tau = map(float, re.search(r"# ([\d.]+) rad, ([\d.]+) N\.m", block).groups())
    printed = [float(word) for word in capsys.readouterr().out.split()]
    assert printed == pytest.approx([theta, tau], abs=5e-5)
    assert left["theta"][-1] == pytest.approx(0.6, abs=1e-3)
    assert left["tau"][-1] == pytest.approx(0.01 * 1.14 / 0.86 * (50.0 + 500.0 * left["theta"][-1]), rel=1e-2)


# ---- the robot joint ----


@pytest.fixture(scope="module")
def robot_joint():
    """Results of system_examples/robot_joint.py by payload in kg and name of the joint."""
    from system_examples import robot_joint

    names = {
        "no cam": robot_joint.BARE,
        "cam": robot_joint.CAM,
        "cam, friction unknown to the controller": robot_joint.NAIVE,
    }
    results = robot_joint.run(ROOT / "build" / "DualCamForward.fmu")
    by_key = {key: name for name, key in names.items()}
    return {(payload, by_key[key]): result for (payload, key), result in results.items()}


COLUMNS = {
    "RMS current": lambda result: (result.rms_current, 2),
    "motor heat": lambda result: (result.joule_heat, 1),
    "friction heat": lambda result: (result.friction_heat, 2),
    "peak torque": lambda result: (result.largest_torque, 2),
    "hold current, arm horizontal": lambda result: (result.hold_current, 2),
    "largest error": lambda result: (1e3 * result.max_error, 2),
}


@pytest.mark.parametrize("page, complete", [("README.md", False), ("docs/examples.md", True)])
def test_table_of_the_robot_joint(robot_joint, page, complete):
    """The table's figures are those that system_examples/robot_joint.py prints."""
    text = TEXTS[page]
    head = re.search(r"^\| payload \| joint \| (.*) \|$", text, re.MULTILINE)[1].split(" | ")
    rows = re.findall(r"^\| ([\d.]+) kg \| ([^|]+?) \| (.*) \|$", text, re.MULTILINE)
    assert len(rows) == len(robot_joint) if complete else rows
    assert not complete or head == list(COLUMNS)
    for payload, joint, cells in rows:
        result = robot_joint[float(payload), joint]
        if "does not lift" in cells:
            assert not result.lifts
            continue
        shown = [float(cell.split()[0]) if cell.strip() else 0.0 for cell in cells.split("|")]
        measured = [COLUMNS[name](result) for name in head]
        assert shown == [abs(round(value, digits)) for value, digits in measured]


# ---- names, links, length ----


@pytest.mark.parametrize("page", PAGES)
def test_variables_named_exist(page):
    pattern = r"`((?:cam[12]|spring|damper|inertia|stop|shaft|initial|energy|peak|step)\.\w+)`"
    known = set(known_keys()).union(*(m.variables for m in models.values()))
    assert {name for name in re.findall(pattern, TEXTS[page]) if name not in known} == set()


def anchor(heading):
    """As GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    links = LINK.findall(TEXTS[page])
    assert links
    for link in links:
        if link.startswith("https://"):
            continue
        path, _, section = link.partition("#")
        target = PAGES[page].parent / path if path else PAGES[page]
        assert target.is_file(), link
        if section:
            headings = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), re.MULTILINE)
            assert section in [anchor(heading) for heading in headings], link


def test_index_names_every_page():
    linked = {link.partition("#")[0] for link in LINK.findall(TEXTS["docs/README.md"])}
    assert {path.name for path in OF_DOCS} <= linked


@pytest.mark.parametrize("page", PAGES)
def test_files_named_exist(page):
    """Scripts, tests, results and folders of the project."""
    roots = "tests|benchmarks|dualcam|system_examples|fmu_src|masters|modelDescription|docs"
    named = set(re.findall(rf"`((?:{roots})/[\w./-]+)`", TEXTS[page]))
    assert {name for name in named if not (ROOT / name).exists()} == set()


@pytest.mark.parametrize("page", PAGES)
def test_commands_named_exist(page):
    usage = (ROOT / "build.sh").read_text(encoding="utf-8")
    commands = set(re.findall(r"^  (\w+) ", usage, re.MULTILINE))
    assert set(re.findall(r"\./build\.sh (\w+)", TEXTS[page])) <= commands
    assert set(re.findall(r"\./build\.sh run ([a-z][\w-]*)", TEXTS[page])) <= set(PROGRAMS)


# ---- architecture.md ----

PYTHON_PACKAGE = TEXTS["docs/architecture.md"].split("\n## The Python package\n")[1]


def test_picture_of_the_rooms_is_fresh(tmp_path):
    script = DOCS / "figures" / "architecture.py"
    subprocess.run(
        [sys.executable, script, "--output", tmp_path], check=True, timeout=120, capture_output=True
    )
    for name in ("architecture.svg", "architecture_python.svg"):
        assert_same_picture(tmp_path / name, DOCS / name)


def test_python_rooms_are_those_of_the_tree_in_order():
    """In the order of the table each room imports rooms of earlier rows."""
    allowed = python_rooms.may_import(ROOT)
    rows = [
        name.replace("/", ".") for name in re.findall(r"^\| `([\w/]+)` \| ", PYTHON_PACKAGE, re.MULTILINE)
    ]
    assert set(rows) == set(allowed) - {"systems"}  # a folder of two rooms
    for room in rows[:-1]:
        assert {other for other in allowed[room] if rows.index(other) >= rows.index(room)} == set()
    assert rows[-1] == "cli"
    assert set(load(DOCS / "figures" / "architecture.py").PYTHON_ROOMS) == set(rows)


# ---- variables.md ----


def test_page_of_variables_is_fresh():
    """And has all variables of both FMUs."""
    script = load(DOCS / "tools" / "variables_page.py")
    assert script.page() == TEXTS["docs/variables.md"]
    rows = set(re.findall(r"^\| `([\w.]+)` \|", TEXTS["docs/variables.md"], re.MULTILINE))
    for model in script.FMUS:
        assert {variable.name for variable in script.read_variables(model)} <= rows


# ---- limits.md ----

REFUSALS = TEXTS["docs/limits.md"].split("## When a step is refused")[1].split("\n## ")[0]


def test_the_fmu_writes_the_messages_of_the_page_of_limits():
    code = "".join(path.read_text(encoding="utf-8") for path in sorted(CORE.rglob("*.c")))
    texts = re.sub(r'"\s*\n\s*"', "", code)  # the parts of each string joined
    messages = re.findall(r'^\| "(.+?)" \|', REFUSALS, re.MULTILINE)
    assert len(messages) >= 10
    parts = [part.strip() for message in messages for part in message.split("...")]
    assert [part for part in parts if part not in texts] == []


# ---- pages of results ----


def test_the_pages_of_trust_are_those_of_the_results():
    """But for the line that says that they are old."""
    script = load(DOCS / "tools" / "trust_page.py")
    for name, text in script.PAGES.items():
        assert without_line(text()) == without_line((DOCS / name).read_text(encoding="utf-8"))


PAGE = "# Title\n\nText.\n\n`benchmarks/results/loop.csv`\n"


def test_a_page_says_that_its_figures_are_older_than_the_core():
    """Below the title, once, and no longer after a run with this core."""
    measured = measured_core(ROOT / "benchmarks/results/loop.csv")
    old = with_line(PAGE, "another")
    assert old.startswith("# Title\n\n> **Older than the core:** the figures of loop.csv were measured")
    assert with_line(old, "another") == old and without_line(old) == PAGE
    assert with_line(old, measured) == with_line(PAGE, measured) == PAGE
    assert "this page" in with_line("# Title\n\nversions, core 0123456789ab\n", "another")


@pytest.mark.parametrize(
    "file",
    [
        path
        for folder in ("benchmarks", "tests/verification")
        for path in (ROOT / folder).glob("results/*.csv")
    ],
    ids=lambda path: path.stem,
)
def test_results_name_the_core_that_they_measured(file):
    assert re.fullmatch("[0-9a-f]{12}", measured_core(file))
