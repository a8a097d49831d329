"""The related files (FMI-LS-REF) of an exported FMU: its documents, its reference result, its smoke test.

The parameter sets and the serialized state of the original FMU belong to other start values and to another
GUID. They are left out."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping

FOLDER = "extra/org.fmi-standard.fmi-ls-ref/"
PAGE = "documentation/fmi-ls-ref.html"
MANIFEST = f"{FOLDER}fmi-ls-manifest.xml"
SMOKE_TEST = f"{FOLDER}smoke-test.exp"
LEFT_OUT = ("parameter", "serialized-state")
DESCRIPTIONS = {
    "experiment/smoke-test": "A run of 1 s, with its result",
    "result": "Result of this FMU itself for the smoke test",
}


def exported_related_files(before: Mapping[str, bytes], identifier: str, exported: str) -> dict[str, bytes]:
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
