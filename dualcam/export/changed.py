"""An FMU of this project with other start values: in the XML, the binaries and the C sources."""

import hashlib
import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import PurePosixPath
from typing import NamedTuple

from dualcam.errors import ExportError
from dualcam.export.description import AGAIN, TOKEN, Description, number_text, typed
from dualcam.export.reference import FOLDER as REFERENCE_FOLDER
from dualcam.export.scenario import FILE as SCENARIO_FILE
from dualcam.export.start_block import MARK, replace_start_values
from dualcam.fmi.model_description import XML, Scalar

Members = Mapping[str, bytes]  # of an FMU: name in the archive -> content
PAGE, BINARIES, RESOURCES, SOURCES = "documentation/index.html", "binaries/", "resources/", "sources/"
VARIABLES = f"{SOURCES}variables.def"
NAMED = (f"{SOURCES}identity.h", f"{SOURCES}buildDescription.xml")  # these files name the model
# Related files (FMI-LS-REF): the documents, the reference result, the smoke test.
RELATED, RELATED_PAGE = "extra/org.fmi-standard.fmi-ls-ref/", "documentation/fmi-ls-ref.html"
MANIFEST, SMOKE_TEST = f"{RELATED}fmi-ls-manifest.xml", f"{RELATED}smoke-test.exp"
# Members that hold the start values, or results of a run from them.
OF_START_VALUES = (
    BINARIES, SOURCES, REFERENCE_FOLDER, RELATED, RELATED_PAGE, PAGE, SCENARIO_FILE,
)  # fmt: skip
# Roles of related files that belong to other start values and another GUID.
LEFT_OUT = ("parameter", "serialized-state")
DESCRIPTIONS = {
    "experiment/smoke-test": "A run of 1 s, with its result",
    "result": "Result of this FMU itself for the smoke test",
}


class Change(NamedTuple):
    """What differs from the original FMU."""

    identifier: str  # the model's name in C
    root: Mapping[str, str]  # attributes of the XML's root
    start: Mapping[str, Scalar]  # tables by their names in the FMU's resources
    tables: Mapping[str, bytes]  # file name in the FMU's resources -> content
    stop: float | None = None  # end of the default experiment [s]; None: as before


def is_own(members: Members) -> bool:
    """Whether the FMU is of this project: its binaries hold the block of start values."""
    return any(name.startswith(BINARIES) and MARK in content for name, content in members.items())


def restarted(members: Members, values: Mapping[str, float]) -> Members:
    """An FMU of this project that starts from other values, without pages and results of the former ones."""
    description = Description(members[XML])
    start = {name: typed(description.variables[name], value) for name, value in values.items()}
    if all(description.variables[name].start == number_text(value) for name, value in start.items()):
        return members
    return changed_members(members, Change(description.identifier, {}, start, {}))


def changed_members(before: Members, change: Change) -> dict[str, bytes]:
    """All members but those that a run from the new start values would give."""
    description = Description(before[XML])
    token = TOKEN[description.fmi]

    def edited(guid: str) -> bytes:
        root = {**change.root, token: guid}
        return description.edited(root, change.identifier, change.start, change.stop)

    guid = _guid(edited(""), change.tables)
    members = {name: content for name, content in before.items() if not name.startswith(OF_START_VALUES)}
    members[XML] = edited(guid)
    members |= _binaries(change, before, description, guid)
    renamed = {description.identifier: change.identifier, description.token: guid}
    members |= exported_sources(before, renamed, change.start)
    return members | {RESOURCES + name: content for name, content in change.tables.items()}


def _guid(description: bytes, tables: Mapping[str, bytes]) -> str:
    """A hash of the description without GUID, and of the tables: equal FMUs have equal GUIDs."""
    digest = hashlib.sha256(description)
    for name in sorted(tables):
        digest.update(hashlib.sha256(tables[name]).digest())
    h = digest.hexdigest()
    return f"{{{h[:8]}-{h[8:12]}-{h[12:16]}-{h[16:20]}-{h[20:32]}}}"


def _binaries(change: Change, before: Members, description: Description, guid: str) -> dict[str, bytes]:
    """The binaries for all platforms, under the new name."""
    references = {name: description.variables[name].reference for name in change.start}
    texts = {references[n]: value for n, value in change.start.items() if isinstance(value, str)}
    numbers = {references[n]: float(v) for n, v in change.start.items() if not isinstance(v, str)}
    found = {}
    for name, content in before.items():
        place = PurePosixPath(name)
        if name.startswith(BINARIES) and place.stem == description.identifier:
            renamed = str(place.with_name(change.identifier + place.suffix))
            try:
                found[renamed] = replace_start_values(content, guid, numbers, texts)
            except ExportError as error:
                raise ExportError(f"{name} of the project's FMU: {error}") from error
    return found


def exported_sources(
    members: Members, names: Mapping[str, str], start: Mapping[str, Scalar]
) -> dict[str, bytes]:
    """The members below sources/ with other names and start values."""
    found = {name: content for name, content in members.items() if name.startswith(SOURCES)}
    for name in NAMED:
        if name in found:
            text = found[name].decode()
            for old, new in names.items():
                text = text.replace(old, new)
            found[name] = text.encode()
    found[VARIABLES] = _with_start_values(found[VARIABLES].decode(), start).encode()
    return found


def _with_start_values(rows: str, start: Mapping[str, Scalar]) -> str:
    """variables.def with other values in the column `start`, which is the fourth one after the name."""
    for name, value in start.items():
        row = rf'("{re.escape(name)}",\s*(?:PARAMETER|INPUT),\s*\w+,\s*\w+,\s*)("[^"]*"|[^,"]+)(?=,)'
        match = re.search(row, rows)
        if match is None:
            raise ExportError(f"{VARIABLES} without a row of {name}: {AGAIN}")
        rows = rows[: match.start(2)] + _literal(value) + rows[match.end(2) :]
    return rows


def _literal(value: Scalar) -> str:
    """A constant in C."""
    if isinstance(value, str):
        return f'"{value}"'
    return str(int(value)) if isinstance(value, bool) else repr(value)


def exported_related_files(before: Members, identifier: str, exported: str) -> dict[str, bytes]:
    """The members of the exported FMU, by name in the archive, from those of the original FMU."""
    if MANIFEST not in before:
        return {}
    ET.register_namespace("fmi-ls", "http://fmi-standard.org/fmi-ls-manifest")
    root = ET.fromstring(before[MANIFEST])
    for related in list(root):
        role = related.attrib["role"]
        if role.startswith(LEFT_OUT):
            root.remove(related)
        related.set("source", related.attrib["source"].replace(identifier, exported))
        related.set("description", DESCRIPTIONS.get(role, related.attrib["description"]))
    ET.indent(root)
    smoke_test = before[SMOKE_TEST].replace(identifier.encode(), exported.encode())
    return {
        MANIFEST: ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n",
        SMOKE_TEST: smoke_test,
    }
