"""What the two XML formats share: reading that is bounded and follows no entity."""

from __future__ import annotations

from lxml import etree

from orchard_cli.errors import Fault, InputError

KML = "http://www.opengis.net/kml/2.2"


def parsed(data: bytes, what: str) -> etree._Element:
    """The root of an XML document. Raises InputError for what is none."""
    parser = etree.XMLParser(resolve_entities=False, no_network=True, huge_tree=False)
    try:
        return etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise InputError(Fault(what, f"is not XML: {error}")) from error


def text(element: etree._Element, path: str, names: dict[str, str]) -> str:
    """The text at a path below an element. Raises InputError where there is none."""
    found = element.findtext(path, namespaces=names)
    if found is None:
        raise InputError(Fault(path, "is missing in the file"))
    return str(found)


def rendered(root: etree._Element) -> bytes:
    """The bytes of a document."""
    return bytes(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True))
