"""Output files: checked before anything is computed, and written whole or not at all."""

import io
import json
import os
import shutil
import sys
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from textwrap import indent

from ...errors import InputError
from ...notes import listFirst
from ...replicas.checkpointfile import nameTemporary
from ..terminal import printable

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
    isDelayed : bool
        whether what is written gets the file's name only when `publish` is called
    """

    @property
    def path(self):
        """The Path of the file itself, where its name is a link."""
        return self._path

    def __init__(self, name, overwrite=False):
        """Take a name; a file that exists is replaced only if overwrite says so."""
        self.name = name
        self.isStandardOutput = name == _STANDARD_OUTPUT
        self.isDelayed = False
        self._overwrite = overwrite
        self._prepared = None  # the Path of what is written, but has not got its name yet
        self._made = None  # tells the file that we have made from another one of its name
        self._held = None
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
            texts = [content] if isinstance(content, str) else content
            pieces = (encoded(printable(text) if self.isStandardOutput else text) for text in texts)
        if self.isStandardOutput:
            sys.stdout.flush()
            sys.stdout.buffer.writelines(pieces)
            return
        with self.explainingErrors():
            if self._isSpecial:
                with self._path.open("wb") as file:
                    file.writelines(pieces)
            else:
                self._prepare(pieces)
                if not self.isDelayed:
                    self.publish()

    def _prepare(self, pieces):
        """Write a file beside the one that is wanted."""
        self.forget()
        self._prepared = self._temporaryPath()
        try:
            with self._prepared.open("xb") as file:
                file.writelines(pieces)
        except BaseException:
            self.forget()
            raise

    def publish(self):
        """Give what was written and delayed the name that is wanted.

        Raises
        ------
        OutputError
            if that cannot be done
        """
        if self._prepared is None:
            return
        with self.explainingErrors():
            try:
                if self._overwrite and self._path.exists():
                    shutil.copymode(self._path, self._prepared)
                elif not self._overwrite:
                    with self._path.open("xb") as file:  # fails if another program has made it by now
                        self._noteMade(file)
                try:
                    made = _identity(os.stat(self._prepared))
                    self._prepared.replace(self._path)
                    self._made = made
                except BaseException:
                    if not self._overwrite:
                        self.remove()
                    raise
            finally:
                self.forget()

    def forget(self):
        """Remove what was written and not published."""
        if self._prepared is not None:
            self._prepared.unlink(missing_ok=True)
            self._prepared = None

    def _noteMade(self, file):
        self._made = _identity(os.fstat(file.fileno()))
        return file

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
                return self._noteMade(self._locked(io.FileIO(self._path, "x")))
            file = self._locked(io.FileIO(self._path, "r+", opener=_openOrMake))
            try:
                self._noteMade(file).truncate()
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

    def hold(self):
        """Let no other run write the file that is there, if there is one, until `release`, though it is closed.

        Raises
        ------
        OutputError
            if another run is writing it
        """
        if not self._isSpecial:
            with suppress(FileNotFoundError, PermissionError):
                self._held = self._locked(io.FileIO(self._path, "r+"))

    def release(self):
        """Hold the file no longer."""
        if self._held is not None:
            self._held.close()
            self._held = None

    def remove(self):
        """Remove the file, if it is the one that was made here: another run may have made another one since."""
        with suppress(FileNotFoundError):
            if self._made is not None and _identity(os.stat(self._path)) == self._made:
                self._path.unlink()

    def removeFormer(self):
        """Remove the file of a former run, which this one replaces."""
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
        self.checkFree()
        with self.explainingErrors():
            if self._path.exists():
                path = self._temporaryPath()
            else:
                path = self._path
            path.open("xb").close()
            path.unlink()

    def checkFree(self):
        """Refuse a file that another run is writing."""
        with self.explainingErrors(), suppress(FileNotFoundError):
            if not self._isSpecial:
                self._locked(io.FileIO(self._path, "r+")).close()

    def _temporaryPath(self):
        return self._path.with_name(nameTemporary())


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
    return {path, _identity(found)}


def _identity(found):
    """Return what tells a file from another one of its name, by what `os.stat` says of it."""
    return found.st_dev, found.st_ino


@contextmanager
def lockedFolders(outputs):
    """Let no other run look at files in the folders of some Outputs, or begin them, meanwhile.

    It waits for others, as far as their file systems can tell of them.
    """
    folders = {}
    for folder in {output.path.parent for output in outputs if not output.isStandardOutput}:
        with suppress(OSError):  # a folder that is missing
            folders[_identity(os.stat(folder))] = folder
    with ExitStack() as stack:
        for _, folder in sorted(folders.items()) if fcntl is not None else ():  # in the order of all runs
            with suppress(OSError):  # a file system without locks
                descriptor = os.open(folder, os.O_RDONLY)
                stack.callback(os.close, descriptor)
                fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield


@contextmanager
def beginning(outputs):
    """Begin to write Outputs that were checked a while ago, while no other run can, unless one has meanwhile.

    Raises
    ------
    OutputError
        if one of them is another run's by now; nothing was touched
    """
    files = [output for output in outputs if not output.isStandardOutput]
    with lockedFolders(files):
        for output in files:
            output.checkFree()
            if output.needsOverwrite():
                raise OutputError(f"{output.name}: exists by now, and was not overwritten")
        yield


class Writing:
    """Outputs being written, so that one that fails does not take the others with it.

    As a context manager it gives them their names at its end, all at a time, so that they are those of one run.

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
        """Call a function that writes an Output, and note what became of it."""
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
    with lockedFolders(files):
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
