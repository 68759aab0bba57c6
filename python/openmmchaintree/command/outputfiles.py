"""Output files: checked before anything is computed, and written whole or not at all."""

import io
import json
import os
import secrets
import shutil
import sys
from contextlib import contextmanager
from pathlib import Path
from textwrap import indent

from ..errors import InputError

_STANDARD_OUTPUT = "-"

_PICTURES = (".png", ".pdf", ".svg")


class OutputError(Exception):
    """What kept an output from being written, in one sentence that names it."""


class Output:
    """A file that will be written, or standard output where its name is -.

    Attributes
    ----------
    name : str
        as the user gave it
    isStandardOutput : bool
    """

    @property
    def path(self):
        """The Path of the file itself, where its name is a link."""
        return self._path

    def __init__(self, name, overwrite=False):
        """Take a name; a file that exists is replaced only if overwrite says so."""
        self.name = name
        self.isStandardOutput = name == _STANDARD_OUTPUT
        self._overwrite = overwrite
        # A device or pipe holds nothing that could get lost, and must not be replaced by a file.
        self._isSpecial = os.path.exists(name) and not os.path.isfile(name)
        # A link stays one, to what is written.
        self._path = Path(name if self._isSpecial else os.path.realpath(name))

    def write(self, content):
        """Write a text, bytes, or texts that are yielded, whole; where that fails, what was there before stays.

        Raises
        ------
        OutputError
            if the file cannot be written
        """
        if isinstance(content, bytes):
            pieces = [content]
        else:
            pieces = (text.encode("utf-8") for text in ([content] if isinstance(content, str) else content))
        if self.isStandardOutput:
            sys.stdout.flush()
            sys.stdout.buffer.writelines(pieces)
            return
        with self.explainingErrors():
            if self._isSpecial:
                _writePieces(self._path, pieces)
            else:
                self._writeBeside(pieces)

    def _writeBeside(self, pieces):
        """Write a file beside the one that is wanted, and give it that one's name once it is whole."""
        temporary = self._temporaryPath()
        try:
            _writePieces(temporary, pieces)
            if self._overwrite and self._path.exists():
                shutil.copymode(self._path, temporary)
            elif not self._overwrite:
                self._path.open("xb").close()  # fails if another program has made it by now
            try:
                temporary.replace(self._path)
            except BaseException:
                if not self._overwrite:
                    self.remove()
                raise
        finally:
            temporary.unlink(missing_ok=True)

    def open(self):
        """Open the file for writing piece by piece, unbuffered.

        Raises
        ------
        OutputError
            if it cannot be opened
        """
        with self.explainingErrors():
            return io.FileIO(self._path, "w" if self._overwrite or self._isSpecial else "x")

    def openThere(self):
        """Open the file, which is there already, for reading and writing, unbuffered.

        Raises
        ------
        InputError
            if it is not there
        OutputError
            if it cannot be opened
        """
        if not self._path.is_file():
            raise InputError(f"{self.name}: there is no such file to go on with")
        with self.explainingErrors():
            return io.FileIO(self._path, "r+")

    def remove(self):
        """Remove the file."""
        if not self._isSpecial:
            self._path.unlink(missing_ok=True)

    @contextmanager
    def explainingErrors(self):
        """Make OSErrors OutputErrors, which name the file."""
        try:
            yield
        except FileExistsError as error:
            raise OutputError(f"{self.name}: exists by now, and was not overwritten") from error
        except OSError as error:
            raise OutputError(f"{self.name}: cannot be written ({error.strerror})") from error

    def isFile(self, path):
        """Whether it is the file that has this path."""
        path = Path(os.path.realpath(path))
        return path == self._path or (path.exists() and self._path.exists() and path.samefile(self._path))

    def needsOverwrite(self):
        """Whether a file is there that must not be replaced."""
        return self._path.is_file() and not self._overwrite

    def check(self):
        """Try whether it can be written, without changing it: nothing else holds for every user and file system.

        Raises
        ------
        InputError
            if it is a folder, or in none
        OutputError
            if it cannot be written
        """
        if self._path.is_dir() or self.name.endswith(os.sep):
            raise InputError(f"{self.name}: is a folder, not a file")
        if not self._path.parent.is_dir():
            raise InputError(f"{self.name}: there is no folder {Path(self.name).parent}")
        if self._isSpecial:
            return
        with self.explainingErrors():
            if self._path.exists():
                self._path.open("ab").close()
                path = self._temporaryPath()
            else:
                path = self._path
            path.open("xb").close()
            path.unlink()

    def _temporaryPath(self):
        return self._path.with_name(f".{secrets.token_hex(8)}.part")


def _writePieces(path, pieces):
    with path.open("wb") as file:
        file.writelines(pieces)


class Writing:
    """Outputs being written, so that one that fails does not take the others with it.

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

    def write(self, output, write):
        """Call a function that writes an Output, and note what became of it."""
        try:
            write(output)
        except OutputError as error:
            self.failures.append(error)
            return
        if not output.isStandardOutput:
            self.files.append(output.name)

    def describeFailures(self):
        """Return all failures in one line."""
        return "; ".join(map(str, self.failures))


def addOverwrite(parser):
    """Add the option without which no file is replaced."""
    parser.add_argument("--overwrite", action="store_true", help="replace output files that exist")


def checkOutputs(names, inputs, overwrite):
    """Return the Outputs that the user wants, as a dictionary by their kind.

    Parameters
    ----------
    names : dict
        the names by the kind of output, None for what is not wanted
    inputs : list of str
        the names of files that are read
    overwrite : bool
        whether files that exist are replaced

    Raises
    ------
    InputError
        if a name is empty, a folder's, an input's or another output's, or of a file that exists
    OutputError
        if a file cannot be written
    """
    outputs = {kind: _named(kind, name, overwrite) for kind, name in names.items() if name is not None}
    files = [output for output in outputs.values() if not output.isStandardOutput]
    if len(outputs) > len(files) + 1:
        raise InputError("standard output (-): is named for two outputs")
    for number, output in enumerate(files):
        if any(output.isFile(path) for path in inputs):
            raise InputError(f"{output.name}: would overwrite a file that is read")
        if any(output.isFile(other.name) for other in files[:number]):
            raise InputError(f"{output.name}: is named for two outputs")
        output.check()
    existing = [output.name for output in files if output.needsOverwrite()]
    if existing:
        words = "exists; --overwrite replaces it" if len(existing) == 1 else "exist; --overwrite replaces them"
        raise InputError(f"{', '.join(existing)}: {words}")
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
