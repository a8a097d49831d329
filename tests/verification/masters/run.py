"""Plays the same scenes in other masters than FMPy and compares; lets checkers look at the FMUs.

    ./build.sh run masters                         all, written to docs/masters.md
    ./build.sh run masters --only ecos,fmi-sim   some

Masters are installed into build/masters. One that cannot be is skipped, with the reason. A master must agree
with FMPy at every communication point in every output that it shows, to the digits that it prints. The exit
code is 1 if one that ran does not.
"""

from __future__ import annotations

import argparse
import platform
import shutil
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from benchmarks.harness.circumstances import core_of, processor
from benchmarks.harness.old_figures import with_line
from verification.masters import install, players, scenes
from verification.masters.install import (
    FMI4J,
    FMI_SIM,
    MAESTRO,
    VDMCHECK,
    Failed,
    Missing,
    pins,
    say,
    version_of,
)
from verification.masters.scenes import (
    FLUNG,
    FLUNG_GENERAL,
    FORWARD,
    INVERSE,
    PROFILE,
    ROOT,
    SCENES,
    Result,
    Scene,
)

CS, ME = "CoSimulation", "ModelExchange"
# A step is a constant, a difference of times or whole nanoseconds: at any time the sums of the steps are some
# 2e-16 s apart, half a unit in the last place of 1.5 s. Speeds change by up to 4000 rad/s2.
ROUNDING = 1e-12
SIX_DECIMALS = 0.5e-6 + ROUNDING
HEAD = ("master", "version", "what it ran", "largest difference", "allowed", "verdict")


@dataclass(frozen=True)
class Play:
    """Scenes in a master."""

    master: str
    version: str
    player: Callable[[Scene, Path, Path], Result]
    played: tuple[Scene, ...] = SCENES
    fmi: str = "2.0"
    kind: str = CS
    allowed: float = ROUNDING
    reference: Callable[..., Result] = scenes.reference

    @property
    def what(self) -> str:
        names = ", ".join(scene.name for scene in self.played)
        return f"FMI {self.fmi[0]} {'CS' if self.kind == CS else 'ME, Euler'}: {names}"

    def largest(self) -> tuple[float, str]:
        """Difference from FMPy, and where."""
        found = [self.one(scene) for scene in self.played]
        return max(found)

    def one(self, scene: Scene) -> tuple[float, str]:
        path = built(scene.model, self.fmi, self.kind)
        say(f"{self.master} {self.version}, {self.what.split(':')[0]}: {scene.name}")
        scene.prepare()
        with tempfile.TemporaryDirectory() as folder:
            result = self.player(scene, path, Path(folder))
        reference = self.reference(scene, path) if self.kind == CS else self.reference(scene, path, self.kind)
        value, output = difference(result, reference)
        return value, f"{output} in {scene.name}"


@dataclass(frozen=True)
class Check:
    """A checker of the archive and its XML, or of an environment made of the FMU."""

    master: str
    version: str
    checker: Callable[[Path], None]
    fmi: str = "2.0"
    models: tuple[str, ...] = (FORWARD, INVERSE)

    @property
    def what(self) -> str:
        return f"FMI {self.fmi[0]}: check of {', '.join(self.models)}"

    def findings(self) -> None:
        for model in self.models:
            path = built(model, self.fmi)
            say(f"{self.master} {self.version}: {model}, FMI {self.fmi[0]}")
            self.checker(path)


DYNAMIC = (PROFILE, FLUNG)
ROWS: tuple[Play | Check, ...] = (
    Play("ecos", pins()["ecospy"], players.ecos),
    Play("ecos", pins()["ecospy"], players.ecos, fmi="3.0"),
    Play("ecos, its CSV file", pins()["ecospy"], players.ecos_csv, allowed=SIX_DECIMALS),
    Play("libcosim", pins()["libcosimpy"], players.libcosim),
    Play("FMI4j", version_of(FMI4J[0]), players.fmi4j),
    Play(
        "Maestro",
        version_of(MAESTRO),
        players.maestro,
        (FLUNG, FLUNG_GENERAL),
        reference=players.maestro_reference,
    ),
    Play("fmi-sim", FMI_SIM, players.fmi_sim),
    Play("fmi-sim", FMI_SIM, players.fmi_sim_me, DYNAMIC, kind=ME),
    Play("fmi-sim", FMI_SIM, players.fmi_sim, fmi="3.0"),
    Play("fmi-sim", FMI_SIM, players.fmi_sim_me, DYNAMIC, fmi="3.0", kind=ME),
    Play("FMPy, `compile`", version("fmpy"), players.compiled),
    Play("FMPy, `compile`", version("fmpy"), players.compiled, fmi="3.0"),
    Play(
        "FMPy, `simulate_ssp`",
        version("fmpy"),
        players.fmpy_ssp,
        DYNAMIC,
        reference=players.fmpy_ssp_reference,
    ),
    Play("fmucontainer", pins()["fmu-manipulation-toolbox"], players.fmucontainer, DYNAMIC),
    Check("FMPy, notebook", pins()["fmpy"], players.notebook),
    Check("FMPy, notebook", pins()["fmpy"], players.notebook, "3.0"),
    Check("fmugym", pins()["fmugym"], players.fmugym, models=(FORWARD,)),
    Check("fmugym", pins()["fmugym"], players.fmugym, "3.0", (FORWARD,)),
    Check("VDMCheck2", version_of(VDMCHECK), players.vdmcheck),
    Check("fmutool", pins()["fmu-manipulation-toolbox"], players.fmutool),
    Check("fmutool", pins()["fmu-manipulation-toolbox"], players.fmutool, fmi="3.0"),
)


@dataclass(frozen=True)
class Outcome:
    row: Play | Check
    verdict: str
    difference: str = ""
    allowed: str = ""
    wrong: bool = False

    def cells(self) -> list[str]:
        return [self.row.master, self.row.version, self.row.what, self.difference, self.allowed, self.verdict]


def built(model: str, fmi: str, kind: str = CS) -> Path:
    """The FMU, if there is one of that FMI version that has this interface."""
    path = scenes.fmu(model, fmi)
    if not path.exists():
        raise Missing(f"not built: {path.relative_to(ROOT)}")
    with zipfile.ZipFile(path) as archive:
        description = ElementTree.fromstring(archive.read("modelDescription.xml"))
    if description.find(kind) is None:
        raise Missing(f"not built: {path.relative_to(ROOT)} has no {kind}")
    return path


def difference(result: Result, expected: Result) -> tuple[float, str]:
    """The largest between two results, in SI units, and of which output."""
    common = [name for name in expected if name in result]
    if not common:
        raise Failed(f"shows none of {', '.join(expected)}")
    for name in common:
        if len(result[name]) != len(expected[name]):
            raise Failed(f"{len(result[name])} communication points, not {len(expected[name])}")
    found = []
    for name in common:
        apart = np.abs(result[name] - expected[name])
        found.append((float(np.max(np.where(np.isnan(apart), np.inf, apart))), name))
    return max(found)


def outcome(row: Play | Check) -> Outcome:
    try:
        if isinstance(row, Check):
            row.findings()
            return Outcome(row, "finds nothing")
        value, where = row.largest()
    except Missing as reason:
        return Outcome(row, f"skipped: {reason}")
    except Failed as reason:
        return Outcome(row, f"**fails**: {reason}", wrong=True)
    agrees = value <= row.allowed
    verdict = "agrees" if agrees else f"**differs**: {where}"
    return Outcome(row, verdict, f"{value:.1e}", f"{row.allowed:.1e}", not agrees)


def table(outcomes: Iterable[Outcome]) -> list[str]:
    rows = [list(HEAD), *(o.cells() for o in outcomes)]
    widths = [max(len(row[i]) for row in rows) for i in range(len(HEAD))]
    lines = [" | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) for row in rows]
    lines.insert(1, " | ".join("-" * width for width in widths))
    return [f"| {line} |" for line in lines]


def tool(name: str, *words: str) -> str:
    """First line of what it prints about its version."""
    if shutil.which(name) is None:
        return f"no {name}"
    done = install.attempt([name, *words], 60)
    return (done.stdout + done.stderr).strip().split("\n")[0]


def markdown(outcomes: list[Outcome]) -> str:
    facts = {
        "command": "./build.sh run masters",
        "machine": f"{processor()}, {platform.machine()}, {' '.join(platform.libc_ver())}",
        "versions": f"Python {platform.python_version()}, FMPy {version('fmpy')}, "
        f"{tool('java', '-version')}, {tool('cargo', '--version')}, core {core_of()}",
    }
    page = Path(__file__).with_name("page.md").read_text()
    listed = [f"- *{scene.name}*, {scene.model}, {scene.duration} s: {scene.text}." for scene in SCENES]
    head, tail = page.split("<!-- scenes and table -->\n")
    body = [*listed, "", *table(outcomes), "", *(f"{name}: {value}  " for name, value in facts.items())]
    return head + "\n".join(body) + "\n" + tail


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--only", help="names of masters, with commas; nothing is written then")
    chosen = parser.parse_args().only
    rows = [
        row
        for row in ROWS
        if chosen is None or any(n in row.master.lower() for n in chosen.lower().split(","))
    ]
    outcomes = [outcome(row) for row in rows]
    print(*table(outcomes), sep="\n")
    if chosen is None:
        (ROOT / "docs/masters.md").write_text(with_line(markdown(outcomes)))
        say("written to docs/masters.md")
    return int(any(o.wrong for o in outcomes))


if __name__ == "__main__":
    sys.exit(main())
