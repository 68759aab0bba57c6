"""The parsers of the commands, for the page that lists their options; the text after the options, as on other pages."""

from docutils import nodes
from openmmchaintree.command import clashes, ensemble, repair, sample
from openmmchaintree.command.arguments import Parser


def setup(app):
    app.connect("doctree-read", _setText)
    return {"parallel_read_safe": True}


def sampleParser():
    return _parserOf("sample", sample)


def clashesParser():
    return _parserOf("clashes", clashes)


def repairParser():
    return _parserOf("repair", repair)


def ensembleParser():
    return _parserOf("ensemble", ensemble)


def _parserOf(name, command):
    parser = Parser(prog=f"openmm-chaintree {name}")
    command.addArguments(parser)
    return parser


def _setText(app, doctree):
    """Make paragraphs and examples of the text after the options, which is one block of code."""
    for block in list(doctree.findall(nodes.literal_block)):
        text = block.astext()
        if "sphinx-argparse-cli-wrap" in block["classes"] and "\n\n" in text:
            block.replace_self([_partOf(part) for part in text.strip("\n").split("\n\n")])


def _partOf(text):
    if text.startswith("  "):
        example = "\n".join(line.removeprefix("  ") for line in text.split("\n"))
        return nodes.literal_block(example, example, language="none")
    return nodes.paragraph(text, text.replace("\n", " "))
