"""Reading arguments: every error is one line."""

import argparse
import sys

from .status import BAD_INPUT
from .terminal import printError


class Parser(argparse.ArgumentParser):
    """A parser that reports an error in one line."""

    def error(self, message):
        printError(message, self.prog)
        sys.exit(BAD_INPUT)


def positive(text):
    """Read a whole number above 0."""
    return wholeNumber(text, 1, 10**15)


def seed(text):
    """Read the seed of a random number generator."""
    return wholeNumber(text, 1, 2**31 - 1)


def wholeNumber(text, least, largest):
    """Read a whole number of a range."""
    try:
        value = int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is not a whole number") from None
    if not least <= value <= largest:
        raise argparse.ArgumentTypeError(f"{value} is not in the range {least} to {largest}")
    return value
