"""The parsers of the commands, for the pages that list their options."""

from openmmchaintree.command import clashes, sample
from openmmchaintree.command.arguments import Parser


def sampleParser():
    return _parserOf("sample", sample)


def clashesParser():
    return _parserOf("clashes", clashes)


def _parserOf(name, command):
    parser = Parser(prog=f"openmm-chaintree {name}")
    command.addArguments(parser)
    return parser
