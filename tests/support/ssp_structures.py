"""The structure of an SSP package, as its SystemStructure.ssd has it."""

from __future__ import annotations

from collections.abc import Iterator
from xml.etree.ElementTree import Element

from dualcam.ssp.package import tag

Ends = dict[tuple[str, str], Element]


def connectors_of(structure: Element) -> Ends:
    """The connectors by the names of their component and their own."""
    return {
        (component.attrib["name"], connector.attrib["name"]): connector
        for component in structure.iter(tag("ssd:Component"))
        for connector in component.iter(tag("ssd:Connector"))
    }


def connections_of(structure: Element) -> Iterator[tuple[Element, Element]]:
    """The connectors at the start and the end of each connection; both have the same unit."""
    ends = connectors_of(structure)
    for connection in structure.iter(tag("ssd:Connection")):
        start, end = (
            ends[connection.attrib[f"{side}Element"], connection.attrib[f"{side}Connector"]]
            for side in ("start", "end")
        )
        assert start[0].attrib["unit"] == end[0].attrib["unit"]
        yield start, end
