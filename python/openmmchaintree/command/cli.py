"""The command openmm-chaintree."""

import io
import os
import sys

import openmm

from ..errors import InputError
from . import benchmark, clashes, sample
from .arguments import Parser
from .status import BAD_INPUT, INTERRUPTED, NOBODY_READS
from .terminal import printError


def main(arguments=None):
    """Run the command; return its exit status."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # Greek letters must not stop the report on any terminal
    options = _parser().parse_args(arguments)
    try:
        status = options.run(options)
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        # Python flushes at its end, too, and would complain.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return NOBODY_READS
    except (InputError, openmm.OpenMMException) as error:
        printError(error)
        return BAD_INPUT
    except OSError as error:
        printError(f"{error.filename}: {error.strerror}" if error.filename else error)
        return BAD_INPUT
    except KeyboardInterrupt:
        return INTERRUPTED


def _parser():
    parser = Parser(
        prog="openmm-chaintree",
        description="Sampling of proteins in torsion space, the clashes of structures and trajectories, and how fast "
        "both are found.",
    )
    commands = parser.add_subparsers(required=True, metavar="command", parser_class=Parser)
    for command in (sample, clashes, benchmark):
        command.addParser(commands)
    return parser
