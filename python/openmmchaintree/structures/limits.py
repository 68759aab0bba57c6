"""Limits of the memory and time that files and options may require: a few bytes can stand for gigabytes."""

import os
from typing import NamedTuple

from ..errors import InputError

_MEGABYTE = 10**6


class Limit(NamedTuple):
    """A limit, and the environment variable that raises it."""

    variable: str
    usual: int
    unit: str = ""

    @property
    def value(self):
        """The limit in its unit.

        Raises
        ------
        InputError
            if the environment variable is set, but not to a whole number above 0
        """
        text = os.environ.get(self.variable, str(self.usual))
        try:
            value = int(text)
        except ValueError:
            value = 0
        if value < 1:
            raise InputError(f"{self.variable}={text}: is not a whole number above 0")
        return value

    def check(self, value, what):
        """Raise an InputError if a value is above the limit; `what` begins its text, such as "x.pdb: has"."""
        if value > self.value:
            limit = f"{self.value:,}{self.unit}"
            raise InputError(f"{what} more than {limit}; the environment variable {self.variable} raises this limit")


MEMORY = Limit("CHAINTREE_MAX_MEGABYTES", 256, " MB")


def checkMemory(size, what):
    """Raise an InputError if a size in bytes is above the limit of memory; `what` begins its text."""
    MEMORY.check(size / _MEGABYTE, what)


def readAtMost(file, what):
    """Return all bytes of a binary file, as a bytearray; see `checkMemory`."""
    content = bytearray()
    while piece := file.read(1 << 20):
        content += piece
        checkMemory(len(content), what)
    return content
