"""The command openmm-chaintree."""

import importlib
import io
import os
import sys

import openmm

from .. import __version__
from ..errors import InputError
from .arguments import Parser
from .outputs.output import OutputError
from .terminal import BAD_INPUT, INTERRUPTED, NOBODY_READS, TERMINATED, Terminated, interruptible, printError

_COMMANDS = {
    "sample": "sample the torsions of proteins and nucleic acids",
    "clashes": "find the clashes in a structure or trajectory",
    "repair": "remove the clashes of a model",
    "ensemble": "sample conformers of disordered proteins, a bead for each residue",
}

_OPTION_OF_CALL = {"setNativeEnergies(False)": "--no-native-energies"}


def main(arguments=None):
    """Run the command; return its exit status."""
    return runParsed(_parser(), arguments)


def runParsed(parser, arguments=None):
    """Parse the options and call the parser's function `run`; return the exit status.

    Errors of the user, of files and of OpenMM are reported in one line.
    """
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w")
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")  # Greek letters must not stop the report on any terminal
    try:
        with interruptible():
            os.getcwd()
            options = parser.parse_args(arguments)
            status = options.run(options)
            sys.stdout.flush()
            return status
    except BrokenPipeError:
        _dropStandardOutput()
        return NOBODY_READS
    except (InputError, OutputError, openmm.OpenMMException) as error:
        printError(_inOptions(str(error)), parser.prog)
        return BAD_INPUT
    except OSError as error:
        if not _hasFolder():
            printError("the working folder was removed: run the command in one that is there", parser.prog)
            return BAD_INPUT
        if error.filename is None:
            _dropStandardOutput()
        printError(f"{error.filename or 'standard output'}: {error.strerror or error}", parser.prog)
        return BAD_INPUT
    except Terminated:
        return TERMINATED
    except KeyboardInterrupt:
        return INTERRUPTED


def _inOptions(text):
    """Return an error text with command-line options in place of the library's calls."""
    for call, option in _OPTION_OF_CALL.items():
        text = text.replace(call, option)
    return text


def _hasFolder():
    try:
        os.getcwd()
    except OSError:
        return False
    return True


def _dropStandardOutput():
    """Discard unwritten output: Python flushes at exit and would report an error."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _parser():
    parser = Parser(
        prog="openmm-chaintree",
        description="Sample proteins in torsion space, and find clashes in structures and trajectories.",
    )
    version = f"openmm-chaintree {__version__}, OpenMM {openmm.Platform.getOpenMMVersion()}"
    parser.add_argument("--version", action="version", version=version)
    commands = parser.add_subparsers(required=True, metavar="command", parser_class=_CommandParser)
    for name, summary in _COMMANDS.items():
        commands.add_parser(name, help=summary).command = name
    return parser


class _CommandParser(Parser):
    """The parser of a command, whose module is imported only when the command is used."""

    def parse_known_args(self, args=None, namespace=None):
        command = importlib.import_module(f".{self.command}", __package__)
        command.addArguments(self)
        if hasattr(command, "applySettings"):
            try:
                command.applySettings(self, args)
            except InputError as error:
                self.error(str(error))
        options, others = super().parse_known_args(args, namespace)
        self.refuseUnknown(others)
        return options, others
