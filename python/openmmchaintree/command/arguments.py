"""Reads command-line arguments; every error is one line."""

import argparse
import os
import re
import sys
from decimal import Decimal

from ..errors import InputError
from ..nearnames import didYouMean, nearestName
from ..notes import listFirst
from .terminal import BAD_INPUT, printError

_MOST_DIGITS = 20  # of whole numbers

_SECONDS = {"s": 1, "min": 60, "h": 3600, "d": 86400}
_DURATION_PART = re.compile(r"(\d+(?:\.\d*)?)\s*(s|min|h|d)?")
_DURATION = re.compile(rf"\d+(\.\d*)?|({_DURATION_PART.pattern.removesuffix('?')}\s*)+")
_LONGEST_DURATION = 10 * 365 * 86400  # s


class Parser(argparse.ArgumentParser):
    """A parser that reports each error in one line."""

    def parse_args(self, args=None, namespace=None):
        options, others = self.parse_known_args(args, namespace)
        self.refuseUnknown(others)
        return options

    def refuseUnknown(self, arguments):
        """Refuse arguments that are not recognized, and suggest the option that the first one is like."""
        if not arguments:
            return
        known = [name[2:] for action in self._actions for name in action.option_strings if name.startswith("--")]
        wrong = next((name[2:].split("=")[0] for name in arguments if name.startswith("--")), "")
        near = nearestName(wrong, known)
        advice = "" if near is None else f"; did you mean --{near}?"
        self.error(f"unrecognized arguments: {listFirst(arguments)}{advice}")

    def _check_value(self, action, value):
        """Add the nearest choice to the error of a wrong one."""
        try:
            super()._check_value(action, value)
        except argparse.ArgumentError as error:
            error.message += didYouMean(str(value), map(str, action.choices))
            raise

    def error(self, message):
        printError(message, self.prog)
        sys.exit(BAD_INPUT)


def numberIn(least, largest, read=float, kind="a number", form="g"):
    """Return a function that reads a number in a range.

    read : makes a number of this kind from a text; form : the format of numbers in errors
    """

    def readInRange(text):
        try:
            value = read(text)
        except (ValueError, ArithmeticError):
            raise argparse.ArgumentTypeError(f"{text!r} is not {kind}") from None
        if not least <= value <= largest:
            raise argparse.ArgumentTypeError(f"{value:{form}} is not in the range {least:{form}} to {largest:{form}}")
        return value

    return readInRange


def _readWhole(text):
    """Return the whole number of a text such as 1000000, 2_000_000 or 1.5e6."""
    value = Decimal(text)
    if not value.is_finite() or value != value.to_integral_value():
        raise ValueError
    return int(value) if value.adjusted() < _MOST_DIGITS else 10**_MOST_DIGITS


def _wholeNumberIn(least, largest):
    return numberIn(least, largest, _readWhole, "a whole number", "d")


def duration(text):
    """Return the seconds of a text such as 90, 45s, 30min, 1.5h or 1h30min."""
    parts = _DURATION.fullmatch(text.strip()) and _DURATION_PART.findall(text)
    if not parts:
        raise argparse.ArgumentTypeError(f"{text!r} is not a time such as 30min, 1.5h or 90 (seconds)")
    seconds = sum(float(number) * _SECONDS[unit or "s"] for number, unit in parts)
    if not 0 < seconds <= _LONGEST_DURATION:
        raise argparse.ArgumentTypeError(f"{text!r} has to be above 0, and at most ten years")
    return seconds


positive = _wholeNumberIn(1, 10**15)
notNegative = _wholeNumberIn(0, 10**15)
frameCount = _wholeNumberIn(1, 10**9)  # limited by the headers of trajectories
seed = _wholeNumberIn(1, 2**31 - 1)
sampleSize = _wholeNumberIn(1, 10**5)


def positiveUpTo(limit):
    """Return a function that reads a whole number above 0, up to a Limit."""

    def read(text):
        value = positive(text)
        try:
            limit.check(value, f"{value} is")
        except InputError as error:
            raise argparse.ArgumentTypeError(str(error)) from error
        return value

    return read


def listOf(names):
    """Return a function that reads a list of the names, separated by commas."""

    def read(text):
        chosen = text.split(",")
        for name in chosen:
            if name not in names:
                raise argparse.ArgumentTypeError(f"{name!r} is not one of {', '.join(names)}{didYouMean(name, names)}")
        return chosen

    return read


def refuseWithout(options, needed, *names):
    """Refuse the named options if they are given, since they need others that are not given."""
    for name in names:
        value = getattr(options, name)
        if value is not None and value is not False:
            raise InputError(f"--{name.replace('_', '-')} needs {needed}")


def addStructure(parser):
    """Add the argument that names the structure."""
    parser.add_argument(
        "structure",
        nargs="?",
        help="a PDB, mmCIF, BinaryCIF, gro, SDF or Mol2 file, plain or compressed (default: the villin headpiece in "
        "OpenMM's package)",
    )


def addPeriodic(parser, whose):
    """Add the option that lets periodic images count; whose : in words, where the box is read."""
    parser.add_argument(
        "--periodic",
        action="store_true",
        help=f"let atoms count in all images of the periodic box {whose} (default: images do not count)",
    )


def addScheduler(parser, what):
    """Add the option for a scheduler whose workers do a job, described by `what`."""
    parser.add_argument(
        "--scheduler",
        metavar="ADDRESS",
        help=f"run {what} on the workers of a Dask scheduler, such as tcp://host:8786; needs the package distributed",
    )


def checkWorkers(options):
    """Refuse a number of workers beside a scheduler."""
    if options.workers is not None and options.scheduler is not None:
        raise InputError("--workers and --scheduler cannot be used together: a scheduler has its own workers")


def usableCores():
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
