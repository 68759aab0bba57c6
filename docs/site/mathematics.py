"""Renders formulas as MathML, which browsers typeset without scripts, fonts or a network."""

import re

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.errors import ExtensionError

# A command, or a mark of columns, that latex2mathml leaves as it is.
_UNKNOWN = re.compile(r"\\[a-zA-Z]+|>&<")


def setup(app):
    app.add_html_math_renderer("mathml", (_visitInline, None), (_visitBlock, None))
    return {"parallel_read_safe": True}


def _visitInline(translator, node):
    translator.body.append(_toMathML(node, translator.builder.current_docname, "inline"))
    raise nodes.SkipNode


def _visitBlock(translator, node):
    formula = _toMathML(node, translator.builder.current_docname, "block")
    translator.body.append(f'<div class="formula">{formula}</div>\n')
    raise nodes.SkipNode


def _toMathML(node, page, display):
    formula = convert(node.astext(), display=display)
    if unknown := _UNKNOWN.search(formula):
        raise ExtensionError(f"{page}: {unknown[0]} in ${node.astext()}$ is not known to latex2mathml")
    return formula
