"""The file from which a run is resumed: counts, and a checkpoint of each replica."""

import json
import os
import secrets
import zipfile
import zlib
from hashlib import sha256
from pathlib import Path

from ..errors import InputError
from ..structures.limits import checkMemory

# Version 2 has no history and no stages.
_VERSION, _OLDEST_VERSION = 3, 2

# Exceptions of reading wrong bytes.
_DAMAGES = (
    *(zipfile.BadZipFile, zlib.error, EOFError, KeyError, ValueError),
    *(NotImplementedError, RuntimeError),  # from unknown compression or encryption, and deep JSON
    *(TypeError, AttributeError, OverflowError),  # from JSON of other types
)
_HEADER = "run.json"
_LARGEST_HEADER = 10**8  # bytes
_MOST_REPLICAS = 10**6

# Our checkpoints hold random bits, so decompression enlarges them by less than this factor.
_LARGEST_RATIO = 20


def nameTemporary():
    """Return a unique name for a file until it is complete."""
    return f".{secrets.token_hex(8)}.part"


def writeCheckpoint(path, header, checkpoints, temporaryName=None):
    """Write a dictionary of plain values and the checkpoints of replicas, None for none.

    Even if the process or the machine stops, the file is either the former or the new one. A failure leaves no others.

    temporaryName : str, from `nameTemporary`, the file's name until it is complete; None: a new one. A run keeps this
        name, to recognize a file left by a kill.
    """
    held = {str(replica): checkpoint for replica, checkpoint in enumerate(checkpoints) if checkpoint is not None}
    digests = {name: sha256(checkpoint).hexdigest() for name, checkpoint in held.items()}
    path = Path(path)
    temporary = path.with_name(temporaryName or nameTemporary())
    temporary.unlink(missing_ok=True)  # left by a run that was killed while writing
    try:
        with open(temporary, "xb") as file:
            with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
                text = json.dumps({"version": _VERSION, "digests": digests, **header})
                for name, content in ((_HEADER, text), *held.items()):
                    # A ZipInfo has the format's first date; a clock may be outside the format's range.
                    archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED, compresslevel=1)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    if os.name == "nt":  # folders cannot be opened there
        return
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def readCheckpoint(path):
    """Read a file of `writeCheckpoint`; return its dictionary, and a dictionary of checkpoints by replica.

    Raises
    ------
    InputError
        if there is no such file, or it is damaged or of another version
    """
    try:
        with open(path, "rb") as file, zipfile.ZipFile(file) as archive:
            _checkSizes(path, file, archive)
            header = json.loads(archive.read(_HEADER))
            if not _OLDEST_VERSION <= header["version"] <= _VERSION:
                raise InputError(f"{path}: is of another version of openmm-chaintree")
            checkpoints = {str(_replica(name)): archive.read(name) for name in header["digests"]}
        for name, checkpoint in checkpoints.items():
            if sha256(checkpoint).hexdigest() != header["digests"][name]:
                raise ValueError(f"the checkpoint of replica {name} is not what was written")
    except InputError:
        raise
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error
    except _DAMAGES as error:
        raise InputError(f"{path}: is not a checkpoint of this command, or damaged ({error})") from error
    return header, {int(name): checkpoint for name, checkpoint in checkpoints.items()}


def _checkSizes(path, file, archive):
    """Refuse an archive that would take more memory than our own checkpoints, unless there is enough."""
    size = sum(entry.file_size for entry in archive.infolist())
    if size > _LARGEST_RATIO * os.fstat(file.fileno()).st_size:
        checkMemory(size, f"{path}: holds, decompressed,")
    if archive.getinfo(_HEADER).file_size > _LARGEST_HEADER:
        raise ValueError(f"{_HEADER} has more than {_LARGEST_HEADER:,} bytes")


def _replica(name):
    """Return the number of a replica by its name."""
    number = int(name)
    if str(number) != name or not 0 <= number < _MOST_REPLICAS:
        raise ValueError(f"{name!r} is not a number of a replica")
    return number
