"""The text file of a reporter."""

import os
from typing import TextIO


class ReporterFile:
    """A file that a reporter opens by its name, and then closes at its own end, or that the user has opened.

    Attributes
    ----------
    text : TextIO
    needsHeading : bool
        whether there are no lines to which the reporter adds
    """

    def __init__(self, file: str | os.PathLike[str] | TextIO, append: bool):
        """Open a file by its name, to add to it or to replace it; or take an open one."""
        self._isOurs = False
        if isinstance(file, (str, os.PathLike)):
            self.text: TextIO = open(file, "a" if append else "w", newline="")
            self._isOurs = True
        else:
            self.text = file
        self.needsHeading = not (append and self._isOurs and self.text.tell() > 0)

    def __del__(self):
        if self._isOurs:
            self.text.close()
