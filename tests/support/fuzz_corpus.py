"""The inputs of the fuzzed programs: one archive a program, and each finding that is mended as a file."""

import zipfile
from collections.abc import Mapping
from pathlib import Path

CORPUS = Path(__file__).resolve().parents[1] / "fuzz_corpus"
FINDINGS = CORPUS / "findings"
DATE = (1980, 1, 1, 0, 0, 0)  # of all members: the same inputs give the same archive


def findings_of(program: str) -> list[Path]:
    """Files of the mended findings of a program such as "DualCamForward-fmi3"."""
    return sorted((FINDINGS / program).glob("*"))


def inputs_of(program: str, folder: Path) -> list[Path]:
    """Files of all inputs of a program: its archive, unpacked into `folder`, and its findings."""
    with zipfile.ZipFile(CORPUS / f"{program}.zip") as archive:
        unpacked = [Path(archive.extract(name, folder)) for name in archive.namelist()]
    return [*unpacked, *findings_of(program)]


def write_archive(program: str, inputs: Mapping[str, bytes]) -> None:
    """Replaces the archive of a program. `inputs`: content by name."""
    with zipfile.ZipFile(CORPUS / f"{program}.zip", "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in sorted(inputs.items()):
            member = zipfile.ZipInfo(name, DATE)
            member.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(member, content)
