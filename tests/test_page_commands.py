"""The commands, files and outputs on README.md, CONTRIBUTING.md and docs/*.md.

docs/tools/run_page.py runs a page as its reader would. Here it runs all pages that have files or commands.
"""

import codeop
from pathlib import Path

import pytest
from pages import DOCS, TEXTS, load

from dualcam.study import read_results

run_page = load(DOCS / "tools" / "run_page.py")
BLOCKS = {name: run_page.blocks_of(text) for name, text in TEXTS.items()}


RUN = [
    name
    for name, text in TEXTS.items()
    if run_page.is_one_piece(text) or any(block.is_output for block in BLOCKS[name])
]
STUDIES = "docs/use-studies.md"
# They show the size of an exported FMU, which holds the binaries of all platforms.
OF_ALL_PLATFORMS = ("docs/tutorial-mechanism-designer.md", "docs/tutorial-system-engineer.md")


def marked(page):
    return pytest.param(page, marks=[pytest.mark.platforms] * (page in OF_ALL_PLATFORMS))


@pytest.mark.parametrize("page", [marked(name) for name in RUN if name != STUDIES])
def test_page_runs_as_its_reader_runs_it(page, tmp_path):
    run_page.run_page(DOCS.parent / page, tmp_path)


def test_studies_of_the_page(tmp_path):
    """The best efficiency is that of the closed form, ((1 - mu)/(1 + mu))^2 at 45 deg."""
    run_page.run_page(DOCS.parent / STUDIES, tmp_path)
    table = read_results(tmp_path / "study_results" / "angles")
    assert table["efficiency"].max() == pytest.approx((0.92 / 1.08) ** 2, rel=1e-12)
    assert len((tmp_path / "angles.csv").read_text().splitlines()) == 1 + 63
    assert len(read_results(tmp_path / "study_results" / "my_study")["run"]) == 200
    made, gains = (read_results(tmp_path / "study_results" / name) for name in ("made", "gains"))
    assert len(made["run"]) == 512 and len(gains["run"]) == 16
    assert made["spring.stiffness"] == pytest.approx(79e9 * made["wire"] ** 4 / (32 * made["coil"] ** 3))
    assert set(made["message"]) == set(gains["message"]) == {""}
    for name in ("angles", "my_study"):
        assert set(read_results(tmp_path / "study_results" / name)["message"]) == {""}
        assert (tmp_path / "study_results" / name / f"{name}.png").is_file()


def test_a_python_block_shows_its_output_to_the_end():
    """A page that shows one line of three is refused; three points stand for what is left out."""
    printed = "1.0\none spring\nanother spring\n"
    run_page.compare_output("one spring\nanother\nspring\n", printed, to_end=True)
    run_page.compare_output("one spring\n...\n", printed, to_end=True)
    run_page.compare_output("one spring\n", printed)
    with pytest.raises(run_page.PageError, match="more is printed"):
        run_page.compare_output("one spring\n", printed, to_end=True)


def commands():
    return [
        (name, block, command)
        for name, blocks in BLOCKS.items()
        for block in blocks
        if block.language == "sh" and not block.is_marked
        for command in block.commands
    ]


@pytest.mark.parametrize("page, block, command", commands(), ids=lambda x: x if isinstance(x, str) else "")
def test_every_command_is_run_or_known(page, block, command):
    """Of `./build.sh WORD` tests/test_pages.py looks for the word. Others have a mark with the reason."""
    assert run_page.is_run(command) or command.split()[0] in run_page.KNOWN_ELSEWHERE


PASTED = [
    (name, block)
    for name, blocks in BLOCKS.items()
    if name.startswith("docs/tutorial-")
    for block in blocks
    if block.language == "python" and not block.file
]


@pytest.mark.parametrize("page, block", PASTED, ids=[f"{name}-{block.line}" for name, block in PASTED])
def test_blocks_of_the_tutorials_can_be_pasted_into_the_prompt(page, block):
    """The prompt ends a loop only at an empty line. The tutorials ask for Enter after the block."""
    compile_statement, statement = codeop.CommandCompiler(), []
    for line in [*block.code.rstrip().splitlines(), ""]:
        statement.append(line)
        if compile_statement("\n".join(statement), "page", "single") is not None:
            statement = []
    assert statement == []


TOML = [(name, block) for name, blocks in BLOCKS.items() for block in blocks if block.language == "toml"]


@pytest.mark.parametrize("page, block", TOML, ids=[f"{name}-{block.file}" for name, block in TOML])
def test_every_toml_block_is_a_file_that_a_command_reads(page, block):
    """That command runs with its page."""
    commands = [words for other in BLOCKS[page] if other.language == "sh" for words in other.commands]
    assert block.file and any(block.file in words.split() for words in commands)


PAGE = """# A page

Save these lines as `one.py`:

```python
print(0.25)  # 0.25
```

```sh
python one.py
```

Output:

```text
0.25
```

```python
from pathlib import Path

print(Path("one.py").stat().st_size / 3)  # {number}
```

<!-- not run: there is no such command -->
```sh
nothing
```
"""


@pytest.mark.parametrize(
    "before, after, message",
    [
        ("0.25\n```\n\n```python", "0.26\n```\n\n```python", "block at line 15: the page shows"),
        ("{number}", "6.68", "6.68 is not printed"),
        ("print(0.25)", "print(1/0)", "block at line 9: python one.py: exit code 1"),
        ("# 0.25", "# 0.4", "block at line 9: python one.py: 0.4 is not printed"),
    ],
)
def test_runner_finds_what_is_wrong(before, after, message, tmp_path):
    page = tmp_path / "page.md"
    page.write_text(PAGE.replace(before, after).replace("{number}", "6.67"))
    folder = tmp_path / "folder"
    folder.mkdir()
    with pytest.raises(run_page.PageError) as error:
        run_page.run_page(page, folder)
    assert message in str(error.value)


def test_runner_runs_a_right_page(tmp_path):
    page = tmp_path / "page.md"
    page.write_text(PAGE.replace("{number}", "6.67"))
    folder = tmp_path / "folder"
    folder.mkdir()
    run_page.run_page(page, folder)
    assert {path.name for path in folder.iterdir()} == {"one.py", "block.py"}


def test_pictures_of_the_tutorials_are_those_of_their_commands():
    """Each picture beside a tutorial is written by a command or a line of code on the page."""
    for path in DOCS.glob("tutorial-*.md"):
        text = path.read_text(encoding="utf-8")
        code = "".join(block.code for block in run_page.blocks_of(text))
        pictures = run_page.PICTURE.findall(text)
        assert pictures
        assert [name for name in pictures if name not in code] == []
        assert all(Path(DOCS / name).is_file() for name in pictures)
