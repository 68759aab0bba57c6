"""How much a file or an option may ask for: a few bytes can stand for gigabytes."""

import os
from typing import NamedTuple

from ..errors import InputError

_MEGABYTE = 10**6


class Limit(NamedTuple):
    """A limit, and the environment variable that raises it."""

    variable: str
    usual: int
    unit: str

    @property
    def value(self):
        """The limit in its unit.

        Raises
        ------
        InputError
            if the environment variable is set to no whole number above 0
        """
        text = os.environ.get(self.variable, str(self.usual))
        try:
            value = int(text)
        except ValueError:
            value = 0
        if value < 1:
            raise InputError(f"{self.variable}={text}: is not a whole number above 0")
        return value

    def refuse(self, what):
        """Raise an InputError that says that something is above the limit, and how to raise it."""
        raise InputError(
            f"{what} more than {self.value:,}{self.unit}; the environment variable {self.variable} raises this limit"
        )


MEMORY = Limit("CHAINTREE_MAX_MEGABYTES", 256, " MB")
REPLICAS = Limit("CHAINTREE_MAX_REPLICAS", 10000, "")
PROCESSES = Limit("CHAINTREE_MAX_PROCESSES", max(64, 4 * (os.cpu_count() or 1)), "")


def checkMemory(size, what):
    """Refuse what takes so many bytes, if they are too many; `what` says of what they are, such as "x.pdb: has".

    Raises
    ------
    InputError
        if it is above the limit
    """
    if size > MEMORY.value * _MEGABYTE:
        MEMORY.refuse(what)


def readAtMost(file, what):
    """Return all bytes of a binary file, as a bytearray; see `checkMemory`."""
    content = bytearray()
    while piece := file.read(1 << 20):
        content += piece
        checkMemory(len(content), what)
    return content
