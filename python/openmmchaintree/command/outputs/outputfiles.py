"""Output files, checked before any computation, and written completely or not."""

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
    """An output could not be written; the message is one sentence that names it."""


class Output:
    """A file to write, or standard output if its name is -.

    Attributes
    ----------
    name : str
        as the user gave it
    isStandardOutput : bool
    isDelayed : bool
        whether the written file gets its name only when `publish` is called
    """

    @property
    def path(self):
        """The Path of the file, with links resolved."""
        return self._path

    def __init__(self, name, overwrite=False):
        """Take a name; an existing file is replaced only if overwrite is true."""
        self.name = name
        self.isStandardOutput = name == _STANDARD_OUTPUT
        self.isDelayed = False
        self._overwrite = overwrite
        self._prepared = None  # the Path of the written file that does not have its name yet
        self._made = None  # identifies the file made here, in case another one takes its name
        self._held = None
        # A device or pipe has no content to lose, and must not be replaced by a file.
        self._isSpecial = os.path.exists(name) and not os.path.isfile(name)
        # Links are kept; their targets are written.
        self._path = Path(name if self._isSpecial else os.path.realpath(name))

    def write(self, content):
        """Write a text, bytes, or an iterable of texts; on failure, an existing file is unchanged.

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
        """Write a temporary file in the same folder."""
        self.forget()
        self._prepared = self._temporaryPath()
        try:
            with self._prepared.open("xb") as file:
                file.writelines(pieces)
        except BaseException:
            self.forget()
            raise

    def publish(self):
        """Give a delayed file its name.

        Raises
        ------
        OutputError
            if that is impossible
        """
        if self._prepared is None:
            return
        with self.explainingErrors():
            try:
                if self._overwrite and self._path.exists():
                    shutil.copymode(self._path, self._prepared)
                elif not self._overwrite:
                    with self._path.open("xb") as file:  # fails if another program has made it meanwhile
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
        """Remove a file that was written and not published."""
        if self._prepared is not None:
            self._prepared.unlink(missing_ok=True)
            self._prepared = None

    def _noteMade(self, file):
        self._made = _identity(os.fstat(file.fileno()))
        return file

    def open(self):
        """Open the file for unbuffered writing in pieces. Until it is closed, no other run can write it.

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
        """Open the existing file for reading and writing, as `open` does.

        Raises
        ------
        InputError
            if it does not exist
        OutputError
            if it cannot be opened
        """
        if not self._path.is_file():
            raise InputError(f"{self.name}: the file to continue is missing")
        with self.explainingErrors():
            return self._locked(io.FileIO(self._path, "r+"))

    def _locked(self, file):
        """Lock a file against other runs until it is closed, if its file system has locks; return it."""
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
        """Lock the file, if it exists, against other runs until `release`, even when it is closed.

        Raises
        ------
        OutputError
            if another run is writing it
        """
        if not self._isSpecial:
            with suppress(FileNotFoundError, PermissionError):
                self._held = self._locked(io.FileIO(self._path, "r+"))

    def release(self):
        """Release the lock of `hold`."""
        if self._held is not None:
            self._held.close()
            self._held = None

    def remove(self):
        """Remove the file if it was made here: another run may have replaced it."""
        with suppress(FileNotFoundError):
            if self._made is not None and _identity(os.stat(self._path)) == self._made:
                self._path.unlink()

    def removeFormer(self):
        """Remove the file of a former run, which this one replaces."""
        if not self._isSpecial:
            self._path.unlink(missing_ok=True)

    @contextmanager
    def explainingErrors(self):
        """Convert OSErrors to OutputErrors, which name the file."""
        try:
            yield
        except FileExistsError as error:
            raise OutputError(f"{self.name}: exists by now, and was not overwritten") from error
        except OSError as error:
            raise OutputError(f"{self.name}: cannot be written ({error.strerror})") from error

    def needsOverwrite(self):
        """Whether the file exists and must not be replaced."""
        return self._path.is_file() and not self._overwrite

    def check(self):
        """Test by trying whether the file can be written, without changing it: only this works on every file system.

        Raises
        ------
        InputError
            if it is a folder, or its folder does not exist
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
    """Return a text as bytes. Bytes of names that are not text become escapes, from which JSON restores the name."""
    return text.encode("utf-8", "backslashreplace")


def _openOrMake(path, flags):
    return os.open(path, flags | os.O_CREAT, 0o666)


def _identities(path):
    """Return a set that two paths of the same file have in common."""
    path = os.path.realpath(path)
    try:
        found = os.stat(path)
    except OSError:
        return {path}
    return {path, _identity(found)}


def _identity(found):
    """Return the identity of a file from its `os.stat` result."""
    return found.st_dev, found.st_ino


@contextmanager
def lockedFolders(outputs):
    """Lock the folders of some Outputs, so that no other run checks or begins files in them.

    Waits for other runs, if the file systems have locks.
    """
    folders = {}
    for folder in {output.path.parent for output in outputs if not output.isStandardOutput}:
        with suppress(OSError):  # a folder that is missing
            folders[_identity(os.stat(folder))] = folder
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
                raise OutputError(f"{output.name}: exists by now, and was not overwritten")
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
