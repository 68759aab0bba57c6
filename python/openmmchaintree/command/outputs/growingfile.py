"""A file that is written in pieces and valid after each piece, however the run ends."""

import os
import stat
import zlib

from ...errors import InputError


class GrowingFile:
    """The unbuffered file of an Output; a context manager that closes it. Closing removes an incomplete piece.

    Attributes
    ----------
    size : int
        the number of complete bytes
    """

    def begin(self, output):
        """Begin the file.

        Raises
        ------
        OutputError
            if it cannot be opened
        """
        self._output = output
        self._file = output.open()
        self.size = 0

    def resume(self, output, size, header, what, normalize=bytes, checksum=None):
        """Resume an existing file: keep its first `size` bytes and remove the rest.

        Parameters
        ----------
        output : Output
        size : int
        header : bytes
            the beginning of the file
        what : str
            the kind of file, for errors
        normalize : callable
            removes the variable parts of a header
        checksum : int or None
            `zlib.crc32` of the kept bytes, if these never change

        Raises
        ------
        InputError
            if it is not the file that was written, or is shorter
        OutputError
            if it cannot be opened or truncated
        """
        self._output = output
        self._file = output.openThere()
        try:
            with output.explainingErrors():
                isOurs = normalize(self._file.read(len(header))) == normalize(header)
                isWhole = self._file.seek(0, os.SEEK_END) >= size
                isAsWritten = checksum is None or self._checksumOf(size) == checksum
            if not (isOurs and isWhole and isAsWritten):
                raise InputError(f"{output.name}: is not the {what} that the run has written")
            with output.explainingErrors():
                self._file.truncate(size)
                self._file.seek(size)
        except BaseException:
            self._file.close()
            raise
        self.size = size

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.close()

    def _checksumOf(self, size):
        checksum = self._file.seek(0)
        while size > 0 and (piece := self._file.read(min(size, 1 << 20))):
            checksum = zlib.crc32(piece, checksum)
            size -= len(piece)
        return checksum

    def append(self, data):
        """Add bytes; on failure the size does not change.

        Raises
        ------
        OutputError
            if they cannot be written
        """
        rest = data
        with self._output.explainingErrors():
            while rest:
                rest = rest[self._file.write(rest) :]
        self.size += len(data)

    def replace(self, place, data):
        """Write bytes over those at a place."""
        with self._output.explainingErrors():
            os.pwrite(self._file.fileno(), data, place)

    def sync(self):
        """Wait until all written data is on disk."""
        with self._output.explainingErrors():
            os.fsync(self._file.fileno())

    def close(self):
        """Close the file without an incomplete piece."""
        with self._output.explainingErrors(), self._file:
            if stat.S_ISREG(os.fstat(self._file.fileno()).st_mode):  # a device has no size
                self._file.truncate(self.size)

    def remove(self):
        """Remove the file, after it was closed."""
        self._output.remove()
