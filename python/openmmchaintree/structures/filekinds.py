"""What an XML file contains, by its first element."""

from xml.etree import ElementTree


def rootOfXML(path):
    """Return the name of the first element of an XML file, or None if the file is no XML; OSError: it can't be read."""
    with open(path, "rb") as file:
        try:
            return next(ElementTree.iterparse(file, events=("start",)))[1].tag
        except (ElementTree.ParseError, StopIteration, ValueError):
            return None
