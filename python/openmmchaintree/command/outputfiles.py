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
from ..notes import listFirst

try:
    import fcntl
except ImportError:  # on Windows
    fcntl = None  # type: ignore[assignment]

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
            pieces = (encoded(text) for text in ([content] if isinstance(content, str) else content))
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
        """Open the file for writing piece by piece, unbuffered. Until it is closed no other run writes it.

        Raises
        ------
        OutputError
            if it cannot be opened
        """
        with self.explainingErrors():
            if self._isSpecial:
                return io.FileIO(self._path, "w")
            if not self._overwrite:
                return self._locked(io.FileIO(self._path, "x"))
            file = self._locked(io.FileIO(self._path, "r+", opener=_openOrMake))
            try:
                file.truncate()
            except BaseException:
                file.close()
                raise
            return file

    def openThere(self):
        """Open the file, which is there already, for reading and writing, as `open` does.

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
            return self._locked(io.FileIO(self._path, "r+"))

    def _locked(self, file):
        """Return a file, which no other run writes until it is closed, as far as its file system can tell."""
        try:
            if fcntl is not None:
                fcntl.flock(file.fileno(), fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            file.close()
            raise OutputError(f"{self.name}: another run is writing it") from error
        except OSError:  # a file system without locks
            pass
        return file

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
            if it cannot be written, or another run is writing it
        """
        if self._path.is_dir() or self.name.endswith(os.sep):
            raise InputError(f"{self.name}: is a folder, not a file")
        if not self._path.parent.is_dir():
            raise InputError(f"{self.name}: there is no folder {Path(self.name).parent}")
        if self._isSpecial:
            return
        with self.explainingErrors():
            if self._path.exists():
                self._locked(self._path.open("ab")).close()
                path = self._temporaryPath()
            else:
                path = self._path
            path.open("xb").close()
            path.unlink()

    def _temporaryPath(self):
        return self._path.with_name(f".{secrets.token_hex(8)}.part")


def encoded(text):
    """Return a text as bytes. What a name has that is no text becomes an escape, which JSON reads as the name again."""
    return text.encode("utf-8", "backslashreplace")


def _openOrMake(path, flags):
    return os.open(path, flags | os.O_CREAT, 0o666)


def _identities(path):
    """Return what two paths of the same file have in common."""
    path = os.path.realpath(path)
    try:
        found = os.stat(path)
    except OSError:
        return {path}
    return {path, (found.st_dev, found.st_ino)}


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
        return "; ".join(dict.fromkeys(map(str, self.failures)))


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
    areRead = set().union(*map(_identities, inputs))
    areWritten = set()
    for output in files:
        identities = _identities(output.path)
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
