"""A file that grows piece by piece, and is sound after each, whatever may end the run."""

import os
import stat
import zlib

from ...errors import InputError


class GrowingFile:
    """The file of an Output, unbuffered. Closing it cuts off what is not complete.

    Attributes
    ----------
    size : int
        the number of bytes that are complete
    """

    def __init__(self, output):
        """Begin the file.

        Raises
        ------
        OutputError
            if it cannot be opened
        """
        self._output = output
        self._file = output.open()
        self.size = 0

    @classmethod
    def goOn(cls, output, size, header, what, normalize=bytes, checksum=None):
        """Go on with a file that is there, of which so many bytes count: what follows them is cut off.

        Parameters
        ----------
        output : Output
        size : int
        header : bytes
            what the file begins with
        what : str
            what it is, for errors
        normalize : callable
            makes of a header what of it never changes
        checksum : int or None
            what `zlib.crc32` gives for the bytes that count, if they never change

        Raises
        ------
        InputError
            if it is not what was written, or is shorter
        OutputError
            if it cannot be opened or cut off
        """
        growing = cls.__new__(cls)
        growing._output = output
        growing._file = output.openThere()
        try:
            with output.explainingErrors():
                isOurs = normalize(growing._file.read(len(header))) == normalize(header)
                isWhole = growing._file.seek(0, os.SEEK_END) >= size
                isAsWritten = checksum is None or growing._checksumOf(size) == checksum
            if not (isOurs and isWhole and isAsWritten):
                raise InputError(f"{output.name}: is not the {what} that the run has written")
            with output.explainingErrors():
                growing._file.truncate(size)
                growing._file.seek(size)
        except BaseException:
            growing._file.close()
            raise
        growing.size = size
        return growing

    def _checksumOf(self, size):
        checksum = self._file.seek(0)
        while size > 0 and (piece := self._file.read(min(size, 1 << 20))):
            checksum = zlib.crc32(piece, checksum)
            size -= len(piece)
        return checksum

    def append(self, data):
        """Add bytes; if that fails, the size stays as it is.

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
        """Wait until what was written is on the disk."""
        with self._output.explainingErrors():
            os.fsync(self._file.fileno())

    def close(self):
        """Close the file, without what is not complete."""
        with self._output.explainingErrors(), self._file:
            if stat.S_ISREG(os.fstat(self._file.fileno()).st_mode):  # a device has no size
                self._file.truncate(self.size)

    def remove(self):
        """Remove the file, after it was closed."""
        self._output.remove()
