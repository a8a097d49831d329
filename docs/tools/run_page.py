"""Runs a page as its reader would: saves files, runs commands and code, in the page's order, in one folder.

    python docs/tools/run_page.py docs/tutorial-system-engineer.md --folder somewhere
    python docs/tools/run_page.py docs/tutorial-system-engineer.md --pictures    # those of the page, to docs

What a fenced block means:

    "Save these lines as `name`" above
                the block becomes a file
    sh          commands: `dualcam`, `python`, `pythonfmu` run, with exit code 0 or that of a comment
                `# exit code 1`; `./build.sh` does not run, because the tests run the same programs; any other
                command needs the mark below
    python      runs, unless saved as a file; numbers in comments beside print() must be printed; where the
                page says "one Python session" the blocks share their names
    text, and "Output" begins the paragraph above
                these lines are in the output of the last command or code; a line of three points stands for
                lines left out
    toml, powershell, other text
                not run here

The mark `<!-- not run: reason -->` above a block keeps the block from being run.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

FENCE = re.compile(r"^( *)```(\w*)\n(.*?)^\1```$", re.MULTILINE | re.DOTALL)
SAVE = re.compile(r"\bSave\s+these\s+lines\s+as\s+`([^`]+)`")
SESSION = re.compile(r"\bone\s+Python\s+session\b")
MARK = re.compile(r"<!-- not run: [^\n]+ -->")
LEFT_OUT = re.compile(r"^\s*\.\.\.\s*$", re.MULTILINE)
PICTURE = re.compile(r"!\[[^\]]*\]\(([\w.]+\.png)\)")
NUMBER = re.compile(r"-?\d+\.\d+(?:e[-+]\d+)?")
RUNS = ("dualcam", "python", "pythonfmu")
KNOWN_ELSEWHERE = ("./build.sh",)
SECONDS = 120.0


class PageError(Exception):
    """What the page says is not what happens."""


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    language: str
    code: str
    line: int
    above: str  # the paragraph above

    @property
    def is_marked(self) -> bool:
        """Whether the block is not to be run."""
        return bool(MARK.search(self.above))

    @property
    def file(self) -> str | None:
        """The name under which the reader saves the block."""
        found = SAVE.search(self.above)
        return found[1] if found else None

    @property
    def is_output(self) -> bool:
        """Whether the block shows what the commands above print."""
        return self.language == "text" and self.above.startswith("Output")

    @property
    def commands(self) -> list[str]:
        """The commands of a block in sh, with their comments."""
        return [line for line in self.code.splitlines() if line.strip() and line[0] != "#"]


def blocks_of(text: str) -> list[Block]:
    """The blocks of a page in order."""
    found = []
    for match in FENCE.finditer(text):
        before = text[: match.start()]
        above = before.rstrip("\n").rpartition("\n\n")[2]
        found.append(Block(match[2], match[3], before.count("\n") + 1, above.strip()))
    return found


def is_run(command: str) -> bool:
    """Whether this program can run the command."""
    return command.split()[0] in RUNS


def is_one_piece(text: str) -> bool:
    """Whether a page has files, commands or one session, so that its blocks belong together."""
    blocks = blocks_of(text)
    shells = [block for block in blocks if block.language == "sh" and not block.is_marked]
    commands = any(is_run(command) for block in shells for command in block.commands)
    return commands or any(block.file for block in blocks) or bool(SESSION.search(text))


def compare_numbers(code: str, printed: str, where: str = "") -> None:
    """PageError if a number in a comment beside a print() is not printed, to its digits."""
    numbers = [float(word) for word in NUMBER.findall(printed)]
    for comment in re.findall(r"^\s*print\(.*\)  # (.*)$", code, re.MULTILINE):
        for said in NUMBER.findall(comment):
            tolerance = 0.51 * 10.0 ** -len(said.partition(".")[2].partition("e")[0])
            if "e" in said:
                tolerance *= 10.0 ** int(said.partition("e")[2])
            if not any(abs(value - float(said)) <= tolerance for value in numbers):
                raise PageError(f"{where}{said} is not printed; printed: {printed}")


def compare_output(shown: str, printed: str, to_end: bool = False) -> None:
    """PageError if lines of the page are not in the output, or, with `to_end`, if the output goes on. Spaces
    and line breaks do not count. A line of three points stands for lines that are left out."""
    plain = " ".join(printed.split())
    for part in LEFT_OUT.split(shown):
        wanted = " ".join(part.split())
        if wanted not in plain:
            raise PageError(f"the page shows\n{part}\nand this is printed:\n{printed}")
    if to_end and not plain.endswith(" ".join(LEFT_OUT.split(shown)[-1].split())):
        raise PageError(f"the page shows\n{shown}\nand more is printed:\n{printed}")


def run_dualcam(words: list[str], expected: int = 0) -> str:
    """Output of a `dualcam` command with the exit code `expected`."""
    from dualcam.__main__ import main

    printed = io.StringIO()
    with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(printed):
        code = main(words)
    if code != expected:
        raise PageError(f"dualcam {shlex.join(words)}: exit code {code}: {printed.getvalue()}")
    return printed.getvalue()


def run_command(command: str) -> str:
    """Output of a line of a block in sh. The comment `# exit code 1` allows that exit code."""
    program, *words = shlex.split(command, comments=True)
    if program == "dualcam":
        return run_dualcam(words, int(command.endswith("# exit code 1")))
    module = [] if program == "python" else ["-m", program]
    environment = {**os.environ, "MPLBACKEND": "Agg"}
    done = subprocess.run(
        [sys.executable, *module, *words],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=SECONDS,
    )
    if done.returncode != 0:
        raise PageError(f"{command}: exit code {done.returncode}: {done.stdout}")
    if program == "python" and words[0].endswith(".py"):
        compare_numbers(Path(words[0]).read_text(encoding="utf-8"), done.stdout, f"{command}: ")
    return done.stdout


def run_code(code: str, names: dict[str, Any] | None = None) -> str:
    """Output of a block in Python, which knows `names` and adds its own names to these."""
    script = Path("block.py")
    script.write_text(code, encoding="utf-8")
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        left = runpy.run_path(str(script), init_globals=names)
    if names is not None:
        names |= {name: value for name, value in left.items() if not name.startswith("__")}
    compare_numbers(code, printed.getvalue())
    return printed.getvalue()


def run_blocks(blocks: list[Block], names: dict[str, Any] | None) -> Iterator[Block]:
    """Runs the blocks in the present folder; gives each one before. Blocks in Python share `names`."""
    printed, is_code = "", False
    for block in blocks:
        yield block
        if block.is_marked:
            continue
        if block.file:
            Path(block.file).write_text(block.code, encoding="utf-8")
        elif block.is_output:
            compare_output(block.code, printed, to_end=is_code)
        elif block.language == "sh":
            is_code = False
            printed = "".join(run_command(command) for command in block.commands if is_run(command))
        elif block.language == "python":
            is_code = True
            printed = run_code(block.code, names)


def run_page(page: Path, folder: Path) -> None:
    """Run a page in a folder, which then has all that the page makes.

    Parameters
    ----------
    page : Path
        A page in Markdown.
    folder : Path
        An empty folder.

    Raises
    ------
    PageError
        A command or a block of code fails, or prints something else than the page shows. The message has the
        line of the page.
    """
    text = page.read_text(encoding="utf-8")
    names: dict[str, Any] | None = {} if SESSION.search(text) else None
    block = None
    with contextlib.chdir(folder):
        try:
            for block in run_blocks(blocks_of(text), names):  # noqa: B007, for the message
                pass
        except Exception as error:
            raise PageError(f"{page.name}, block at line {block.line if block else 0}: {error}") from error


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("page", type=Path)
    parser.add_argument("--folder", type=Path, help="run here, and keep what the page makes")
    parser.add_argument("--pictures", action="store_true", help="copy the page's pictures beside the page")
    words = parser.parse_args()
    with TemporaryDirectory() as temporary:
        folder = words.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        run_page(words.page.resolve(), folder)
        if words.pictures:
            for name in PICTURE.findall(words.page.read_text(encoding="utf-8")):
                if (folder / name).is_file():
                    shutil.copy(folder / name, words.page.parent / name)
                    print(words.page.parent / name)


if __name__ == "__main__":
    main()
