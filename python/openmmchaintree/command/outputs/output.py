"""A file to write, checked before any computation, and written completely or not."""

import io
import os
import shutil
import sys
from contextlib import contextmanager, suppress
from pathlib import Path

from ...errors import InputError
from ...replicas.checkpointfile import nameTemporary
from ..terminal import printable

try:
    import fcntl
except ImportError:  # on Windows
    fcntl = None  # type: ignore[assignment]

_STANDARD_OUTPUT = "-"


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
                    made = identityOf(os.stat(self._prepared))
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
        self._made = identityOf(os.fstat(file.fileno()))
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
            if self._made is not None and identityOf(os.stat(self._path)) == self._made:
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
            raise OutputError(f"{self.name}: was made in the meantime, and was not overwritten") from error
        except OSError as error:
            raise OutputError(f"{self.name}: cannot be written ({error.strerror})") from error

    def requireFile(self):
        """Refuse a device or pipe, whose content cannot be read again."""
        if self._isSpecial:
            raise InputError(f"{self.name}: is not a regular file, and a run reads what it wrote")

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


def identitiesOf(path):
    """Return a set that two paths of the same file have in common."""
    path = os.path.realpath(path)
    try:
        found = os.stat(path)
    except OSError:
        return {path}
    return {path, identityOf(found)}


def identityOf(found):
    """Return the identity of a file from its `os.stat` result."""
    return found.st_dev, found.st_ino
