"""The FMUs: the C files of each, the description of its variables, and its other members."""

from __future__ import annotations

import hashlib
import shutil
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import document
import members
import related_files
from compiler import compile_program, run
from workspace import (
    BARE,
    BUILD,
    CORE,
    DESCRIPTIONS,
    ROOT,
    TOOLS,
    WEB_ROOM,
    BuildError,
    fingerprint,
    headers,
    is_fresh,
    place,
    relative,
    say,
    set_stamp,
)

# Both FMUs are compiled from the same files, except fmi/model_<name>.c, which passes the FMI calls on.
MODELS = {"DualCamForward": "forward", "DualCamInverse": "inverse"}
# Files of one version of FMI alone, by the beginning of their names. FMI 3.0 asks FMUs for dependencies.
ONLY_IN = {2: ("fmi2",), 3: ("fmi3", "version3", "dependencies")}


@dataclass(frozen=True)
class Fmu:
    """One FMU before it is built.

    `sources` are its C files, `defines` the compiler options that select the model. `extra` (files) and
    `texts` (made by the build) are its members besides description and binaries, by name in the archive.
    """

    identifier: str
    sources: list[Path]
    description: str
    guid: str
    extra: dict[str, Path] = field(default_factory=dict)
    texts: dict[str, str] = field(default_factory=dict)
    defines: list[str] = field(default_factory=list)
    version: int = 2  # of FMI

    @property
    def path(self) -> Path:
        return place(self.version) / f"{self.identifier}.fmu"


def model_defines(identifier: str, version: int) -> list[str]:
    return [f"-DMODEL_BUILT=MODEL_{MODELS[identifier].upper()}", f"-DFMI_VERSION={version}"]


def identity(fmu: Fmu) -> list[str]:
    """Compiler options with the names by which a master checks that library and description agree."""
    return [f'-DMODEL_GUID="{fmu.guid}"', f"-DMODEL_IDENTIFIER={fmu.identifier}"]


def core_files(identifier: str, version: int, suffixes: Sequence[str]) -> list[Path]:
    """The files of one FMU in the rooms of fmu_src. Left out is `web`."""
    others = [f"model_{model}." for name, model in MODELS.items() if name != identifier]
    others += [beginning for v, names in ONLY_IN.items() if v != version for beginning in names]
    outside = {TOOLS, WEB_ROOM}
    files = [p for p in CORE.rglob("*") if p.suffix in suffixes and not outside & {*p.parents}]
    return sorted(p for p in files if not p.name.startswith(tuple(others)))


def core_sources(identifier: str, version: int = 2) -> list[Path]:
    return core_files(identifier, version, [".c"])


def names_of(sources: Sequence[Path]) -> list[str]:
    """The names of C files in the folder `sources` of the FMU: room/file."""
    return [source.relative_to(CORE).as_posix() for source in sources]


def emit_description(identifier: str, version: int, check: bool) -> str:
    """The modelDescription.xml of an FMU, written from variables.def by a program of the build.

    The committed file is rewritten where it differs.

    Raises
    ------
    BuildError
        With `check`, where the committed file differs.
    """
    committed = DESCRIPTIONS / ("" if version == 2 else f"fmi{version}") / f"{identifier}.xml"
    own = ("tools/emit.c", f"tools/emit_fmi{version}.c")
    emitter = [CORE / name for name in (*own, "fmi/variables.c", "fmi/dependencies.c", "model/fault.c")]
    fresh = BUILD / "description" / f"fmi{version}" / committed.name
    names = names_of(core_sources(identifier, version))
    defines = model_defines(identifier, version)
    stamp = fingerprint([*emitter, *headers()], *defines, *names)
    if not is_fresh(fresh, stamp):
        say(f"emit {relative(committed)}")
        no_guid_yet = '-DMODEL_GUID=""'  # the GUID is the hash of what this program prints
        program = compile_program(["-O1", *defines, no_guid_yet], emitter, f"emit_{identifier}_{version}")
        fresh.parent.mkdir(parents=True, exist_ok=True)
        fresh.write_bytes(run([program, *names], "emit").encode())
        set_stamp(fresh, stamp)
    if not committed.exists() or committed.read_bytes() != fresh.read_bytes():
        if check:
            raise BuildError(f"{relative(committed)} is out of date: run ./build.sh and commit it")
        committed.parent.mkdir(exist_ok=True)
        shutil.copyfile(fresh, committed)
        say(f"{relative(committed)} was missing or out of date: rewritten, commit it")
    return committed.read_text(encoding="utf-8")


def dual_cam(identifier: str, check: bool, version: int = 2) -> Fmu:
    """The FMU of one model for one version of FMI."""
    description = emit_description(identifier, version, check)
    guid = ET.fromstring(description).attrib["guid" if version == 2 else "instantiationToken"]
    sources, defines = core_sources(identifier, version), model_defines(identifier, version)
    icon = DESCRIPTIONS / "model.png"
    extra = {"documentation/licenses/license.txt": ROOT / "LICENSE", "terminalsAndIcons/icon.png": icon}
    extra |= {"model.png": icon} if version == 2 else {}
    extra |= members.reference(DESCRIPTIONS, identifier) | related_files.parameter_sets(DESCRIPTIONS)
    texts = members.sources(CORE, core_files(identifier, version, [".c", ".h", ".def"]))
    texts |= {
        "documentation/index.html": document.page(description, DESCRIPTIONS / "reference"),
        f"{related_files.FOLDER}/{related_files.SMOKE_TEST}": related_files.smoke_test(identifier),
        "documentation/fmi-ls-ref.html": related_files.PAGE,
        "sources/identity.h": members.identity_header(identifier, MODELS[identifier], guid, version),
        "terminalsAndIcons/terminalsAndIcons.xml": members.terminals(MODELS[identifier]),
    }
    if version == 3:
        texts["sources/buildDescription.xml"] = members.build_description(identifier, names_of(sources))
    return Fmu(identifier, sources, description, guid, extra, texts, defines, version)


def bare_fmu(
    like: Fmu, identifier: str, source: Path, what: str, settings: Mapping[str, float] | None = None
) -> Fmu:
    """An FMU for comparison: plain co-simulation without any capability, with the variables of `like` and
    with `settings` (name -> start value) as further parameters. The C file gets the value references as
    VR_group_name."""
    guid = hashlib.sha256(like.description.encode()).hexdigest()[:32]
    root = ET.fromstring(like.description)
    root.attrib.update(modelName=identifier, guid=guid, description=what)
    for kind in [*root.findall("ModelExchange"), *root.findall("CoSimulation")]:
        position = list(root).index(kind)
        root.remove(kind)
    root.insert(position, ET.Element("CoSimulation", modelIdentifier=identifier))
    references = {v.attrib["name"]: int(v.attrib["valueReference"]) for v in root.iter("ScalarVariable")}
    for name, start in (settings or {}).items():
        references[name] = 1 + max(references.values())
        variable = ET.Element("ScalarVariable", name=name, valueReference=str(references[name]))
        variable.attrib.update(causality="parameter", variability="fixed")
        ET.SubElement(variable, "Real", start=repr(start))
        next(root.iter("ModelVariables")).append(variable)
    ET.indent(root)
    description = '<?xml version="1.0" encoding="UTF-8"?>\n' + ET.tostring(root, encoding="unicode") + "\n"
    words = {name.replace(".", "_"): reference for name, reference in references.items()}
    defines = [f"-DVALUE_COUNT={1 + max(references.values())}"]
    defines += [f"-DVR_{w}={reference}" for w, reference in words.items() if w.isascii() and w.isidentifier()]
    return Fmu(identifier, [source], description, guid, defines=defines)


def null_fmu(like: Fmu) -> Fmu:
    """An FMU that does nothing: its cost is the cost of FMI itself."""
    return bare_fmu(like, "NullFmu", BARE / "null_fmu.c", "Does nothing: what FMI itself costs")


def hand_written_fmu(like: Fmu) -> Fmu:
    """A simulator with fixed steps, with which the benchmark of work and precision compares."""
    source = ROOT / "benchmarks/hand_written/hand_written.c"
    settings = {"solver.step": 1e-4, "solver.threshold": 1e-3}
    return bare_fmu(like, "HandWritten", source, "Fixed steps of semi-implicit Euler", settings)
