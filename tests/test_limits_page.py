"""docs/limits.md lists the messages of refused steps as the FMU writes them."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
PAGE = (ROOT / "docs/limits.md").read_text(encoding="utf-8")
SECTION = PAGE.split("## When a step is refused")[1].split("\n## ")[0]
MESSAGES = re.findall(r'^\| "(.+?)" \|', SECTION, flags=re.MULTILINE)


@pytest.fixture(scope="module")
def texts_of_the_core() -> str:
    """The C sources, with the parts of each string joined."""
    code = "".join(path.read_text(encoding="utf-8") for path in sorted((ROOT / "fmu_src").rglob("*.c")))
    return re.sub(r'"\s*\n\s*"', "", code)


def test_the_section_has_a_table():
    assert len(MESSAGES) >= 10


@pytest.mark.parametrize("message", MESSAGES)
def test_the_fmu_writes_the_message(message, texts_of_the_core):
    for part in message.split("..."):
        assert part.strip() in texts_of_the_core
