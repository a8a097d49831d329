"""Writes docs/paper.md and its pictures: see the package's text.

Every number of the page is computed in this package, through the FMUs where possible. The page has no date,
so that a test can write the page anew and compare.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from case_studies.paper.budget import budget_section
from case_studies.paper.fmus import FmuResults
from case_studies.paper.friction import explanation, varying_friction
from case_studies.paper.measurements import friction_laws, measurements, uncertainty
from case_studies.paper.pictures import PICTURES
from case_studies.paper.theory import efficiency_section, errata, opening, torque_section, verdicts
from dualcam import Fmu

ROOT = Path(__file__).resolve().parents[2]
SECTIONS = (
    *(verdicts, efficiency_section, torque_section, errata, uncertainty, budget_section, measurements),
    *(friction_laws, varying_friction, explanation),
)


def page(fmus: FmuResults) -> str:
    """The text of docs/paper.md."""
    return "\n".join([opening(), *(section(fmus) for section in SECTIONS)])


def main(arguments: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(prog="paper", description="Writes docs/paper.md and its pictures")
    parser.add_argument("--output", type=Path, default=ROOT / "docs", help="folder of paper.md and pictures")
    options = parser.parse_args(arguments)
    build = ROOT / "build"
    options.output.mkdir(parents=True, exist_ok=True)
    with Fmu(build / "DualCamInverse.fmu") as inverse, Fmu(build / "DualCamForward.fmu") as forward:
        fmus = FmuResults(inverse, forward)
        (options.output / "paper.md").write_text(page(fmus), encoding="utf-8")
        for name, draw in PICTURES.items():
            draw(fmus).savefig(options.output / f"paper_{name}.png", dpi=100)
    print(f"Written: {options.output / 'paper.md'} and {len(PICTURES)} pictures beside it")


if __name__ == "__main__":
    main()
