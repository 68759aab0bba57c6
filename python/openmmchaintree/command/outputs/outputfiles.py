"""The output files of a run: checked, begun and written together."""

import json
import os
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from textwrap import indent

from ...errors import InputError
from ...notes import listFirst
from .output import Output, OutputError, fcntl, identitiesOf, identityOf

_PICTURES = (".png", ".pdf", ".svg")


@contextmanager
def lockedFolders(outputs):
    """Lock the folders of some Outputs, so that no other run checks or begins files in them.

    Waits for other runs, if the file systems have locks.
    """
    folders = {}
    for folder in {output.path.parent for output in outputs if not output.isStandardOutput}:
        with suppress(OSError):  # a folder that is missing
            folders[identityOf(os.stat(folder))] = folder
    with ExitStack() as stack:
        for _, folder in sorted(folders.items()) if fcntl is not None else ():  # in the same order in all runs
            with suppress(OSError):  # a file system without locks
                descriptor = os.open(folder, os.O_RDONLY)
                stack.callback(os.close, descriptor)
                fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield


@contextmanager
def beginning(outputs):
    """Begin to write Outputs that were checked earlier, with their folders locked.

    Raises
    ------
    OutputError
        if another run has taken one of them since; no file was touched
    """
    files = [output for output in outputs if not output.isStandardOutput]
    with lockedFolders(files):
        for output in files:
            output.checkFree()
            if output.needsOverwrite():
                raise OutputError(f"{output.name}: was made in the meantime, and was not overwritten")
        yield


class Writing:
    """Writes Outputs; a failure of one does not affect the others.

    As a context manager it gives all of them their names together at its end, so that they belong to one run.

    Attributes
    ----------
    files : list of str
        the names of the files that were written
    failures : list of OutputError
    """

    def __init__(self):
        """Begin with nothing written."""
        self.files = []
        self.failures = []
        self._isDelayed = False
        self._delayed = []

    def __enter__(self):
        self._isDelayed = True
        return self

    def __exit__(self, kind, error, traceback):
        delayed, self._delayed, self._isDelayed = self._delayed, [], False
        try:
            with lockedFolders(delayed):
                for output in delayed if kind is None else ():
                    self.write(output, lambda output: output.publish())
        finally:
            for output in delayed:
                output.forget()

    def write(self, output, write):
        """Call a function that writes an Output, and record success or failure."""
        output.isDelayed = self._isDelayed and not output.isStandardOutput
        try:
            write(output)
        except OutputError as error:
            self.failures.append(error)
            return
        if output.isDelayed:
            self._delayed.append(output)
        elif not output.isStandardOutput:
            self.files.append(output.name)

    def describeFailures(self):
        """Return all failures in one line."""
        return "; ".join(dict.fromkeys(map(str, self.failures)))


def addOverwrite(parser):
    """Add the option that allows replacing files."""
    parser.add_argument("--overwrite", action="store_true", help="replace output files that exist")


def checkOutputs(names, inputs, overwrite):
    """Return the requested Outputs, as a dictionary by kind.

    Parameters
    ----------
    names : dict
        the names by kind of output, None for outputs that are not requested
    inputs : list of str
        the names of input files
    overwrite : bool
        whether existing files are replaced

    Raises
    ------
    InputError
        if a name is empty, or that of a folder, an input, another output, or an existing file
    OutputError
        if a file cannot be written
    """
    outputs = {kind: _named(kind, name, overwrite) for kind, name in names.items() if name is not None}
    files = [output for output in outputs.values() if not output.isStandardOutput]
    if len(outputs) > len(files) + 1:
        raise InputError("standard output (-): is named for two outputs")
    areRead = set().union(*map(identitiesOf, inputs))
    areWritten = set()
    with lockedFolders(files):
        for output in files:
            identities = identitiesOf(output.path)
            if identities & areRead:
                raise InputError(f"{output.name}: would overwrite a file that is read")
            if identities & areWritten:
                raise InputError(f"{output.name}: is named for two outputs")
            areWritten |= identities
            output.check()
    existing = [output.name for output in files if output.needsOverwrite()]
    if existing:
        words = "exists; --overwrite replaces it" if len(existing) == 1 else "exist; --overwrite replaces them"
        raise InputError(f"{listFirst(existing)}: {words}")
    return outputs


def _named(kind, name, overwrite):
    if not name:
        raise InputError(f"the name of the {kind} file is empty")
    return Output(name, overwrite)


def checkPicture(output):
    """Refuse a picture in a format that is not known."""
    if Path(output.name).suffix.lower() not in _PICTURES:
        raise InputError(f"{output.name}: a picture's name ends in {', '.join(_PICTURES)}")


def asJSON(content):
    """Return plain dictionaries and lists as JSON."""
    return json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def asJSONWith(content, name, items):
    """Yield the JSON of a dictionary whose last entry is a list, of which items are yielded one by one, in pieces."""
    yield asJSON(content).removesuffix("\n}\n") + f",\n  {json.dumps(name)}: ["
    separator = "\n"
    for item in items:
        yield separator + indent(asJSON(item).removesuffix("\n"), 4 * " ")
        separator = ",\n"
    yield "]\n}\n" if separator == "\n" else "\n  ]\n}\n"
