"""The inputs of the fuzzed programs: an archive for each program, and the mended findings apart."""

import base64
import tomllib
import zipfile
from collections.abc import Mapping
from pathlib import Path

CORPUS = Path(__file__).resolve().parents[1] / "fuzz_corpus"
DATE = (1980, 1, 1, 0, 0, 0)  # of all members: the same inputs give the same archive


def findings_of(program: str) -> dict[str, bytes]:
    """The mended findings of a program such as "DualCamForward-fmi3", by name."""
    findings = tomllib.loads((CORPUS / "findings.toml").read_text(encoding="utf-8"))
    return {name: base64.b64decode(text) for name, text in findings.get(program, {}).items()}


def inputs_of(program: str, folder: Path) -> list[Path]:
    """Writes all inputs of a program into `folder`; their files."""
    with zipfile.ZipFile(CORPUS / f"{program}.zip") as archive:
        inputs = {name: archive.read(name) for name in archive.namelist()}
    inputs |= {f"{program}-{name}": content for name, content in findings_of(program).items()}
    for name, content in inputs.items():
        (folder / name).write_bytes(content)
    return [folder / name for name in inputs]


def write_archive(program: str, inputs: Mapping[str, bytes]) -> None:
    """Replaces the archive of a program. `inputs`: content by name."""
    with zipfile.ZipFile(CORPUS / f"{program}.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in sorted(inputs.items()):
            member = zipfile.ZipInfo(name, DATE)
            member.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(member, content)
