"""Prevents line breaks in numbers of tables, such as before a negative exponent, on narrow screens."""

import re

from docutils import nodes

_NUMBERS = re.compile(r"[-−+±]?\d[^a-df-zA-Z]*")  # with an exponent, a range in brackets, a list


def setup(app):
    app.connect("doctree-read", _keepNumbers)
    return {"parallel_read_safe": True}


def _keepNumbers(app, doctree):
    for entry in doctree.findall(nodes.entry):
        text = entry.astext()
        if len(text) < 30 and _NUMBERS.fullmatch(text):
            entry["classes"].append("number")
