"""What an FMU carries for other tools by the layered standard FMI-LS-REF: a list of documents and results, a
smoke test, parameter sets and a serialized state.

Sources: https://github.com/modelica/fmi-ls-ref and, for the smoke test, the format of
https://github.com/modelica/ma-hs-experiments
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from string import Template
from xml.sax.saxutils import quoteattr

NAME = "org.fmi-standard.fmi-ls-ref"
VERSION = "1.0.0-alpha.1"
DESCRIPTION = "Layered Standard providing information on related files included in an FMU."
FOLDER = f"extra/{NAME}"
SMOKE_TEST = "smoke-test.exp"
STATE = "loaded.state"
STOP_TIME, STEP = 1.0, 0.01  # s, of modelDescription/reference

PAGE = Template(Path(__file__).with_suffix(".html").read_text(encoding="utf-8")).substitute(
    version=VERSION, folder=FOLDER, smoke_test=SMOKE_TEST, state=STATE, step=f"{STEP:g}"
)


@dataclass(frozen=True)
class Related:
    """One file: its address relative to the manifest."""

    source: str
    kind: str  # MIME type
    role: str
    description: str

    @property
    def element(self) -> str:
        attributes = {
            "type": self.kind,
            "source": self.source,
            "role": self.role,
            "description": self.description,
        }
        return f"  <Related {' '.join(f'{name}={quoteattr(text)}' for name, text in attributes.items())}/>"


def manifest(files: Iterable[Related]) -> str:
    related = "\n".join(file.element for file in files)
    return f"""\
<?xml version="1.0" encoding="UTF-8"?>
<fmiReferences xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
    fmi-ls:fmi-ls-name="{NAME}"
    fmi-ls:fmi-ls-version="{VERSION}"
    fmi-ls:fmi-ls-description="{DESCRIPTION}">
{related}
</fmiReferences>
"""


def smoke_test(identifier: str) -> str:
    """The reference result as an experiment."""
    return f"""\
<?xml version="1.0" encoding="UTF-8"?>
<Experiments name="Smoke test" description="The run of the reference result">
  <Experiment name="Reference" tolerance="1e-9">
    <TransientSimulation startTime="0" stopTime="{STOP_TIME:g}" stepSize="{STEP:g}"/>
    <Stimuli source="../reference/{identifier}_in.csv"/>
    <References source="../reference/{identifier}_ref.csv"/>
  </Experiment>
</Experiments>
"""


def parameter_sets(descriptions: Path) -> dict[str, Path]:
    """Name in the archive -> file."""
    return {f"{FOLDER}/{path.name}": path for path in sorted((descriptions / "parameter_sets").glob("*.ssv"))}


def title_of(parameter_set: Path) -> str:
    """The comment in the second line of a parameter set."""
    comment = parameter_set.read_text(encoding="utf-8").splitlines()[1]
    return comment.removeprefix("<!-- ").removesuffix(" -->")


def related_files(identifier: str, sets: Iterable[Path], state_platform: str | None) -> list[Related]:
    """All related files. `state_platform`: where the serialized state was made; None: there is none."""
    files = [
        Related(
            "../../documentation/index.html", "text/html", "document", "Equations, figures, all variables"
        ),
        Related("../reference/README.txt", "text/plain", "document", "How to play the reference result"),
        Related(
            SMOKE_TEST,
            "application/x-ma-hs-experiments",
            "experiment/smoke-test",
            "A run of 1 s, with the result of an independent program",
        ),
        Related(
            f"../reference/{identifier}_ref.csv",
            "text/csv",
            "result",
            "Result of an independent program for the smoke test",
        ),
    ]
    files += [
        Related(path.name, "application/x-ssp-parameter-set", "parameter", title_of(path)) for path in sets
    ]
    if state_platform is not None:
        role = f"serialized-state/{state_platform}"
        text = "The mechanism after one step of 0.2 s under constant inputs"
        files.append(Related(STATE, "application/octet-stream", role, text))
    return files
