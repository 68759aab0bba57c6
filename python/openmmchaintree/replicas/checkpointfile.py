"""The file that a run goes on from: what is counted, and a checkpoint of each replica."""

import json
import os
import zipfile
import zlib
from hashlib import sha256
from pathlib import Path

from ..errors import InputError

_VERSION = 2

# What reading raises where bytes are wrong.
_DAMAGES = (
    *(zipfile.BadZipFile, zlib.error, EOFError, KeyError, ValueError),
    *(NotImplementedError, RuntimeError),  # of compression and encryption that are not ours
)
_HEADER = "run.json"


def writeCheckpoint(path, header, checkpoints):
    """Write a dictionary of plain values and the checkpoints of replicas, None for none.

    Whatever ends the process or the machine, the file is the former one or this one. Nothing stays if writing fails.
    """
    held = {str(replica): checkpoint for replica, checkpoint in enumerate(checkpoints) if checkpoint is not None}
    digests = {name: sha256(checkpoint).hexdigest() for name, checkpoint in held.items()}
    path = Path(path)
    temporary = path.with_name(f"{path.name}.part")
    try:
        with open(temporary, "wb") as file:
            with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
                archive.writestr(_HEADER, json.dumps({"version": _VERSION, "digests": digests, **header}))
                for name, checkpoint in held.items():
                    archive.writestr(name, checkpoint)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    if os.name == "nt":  # there folders cannot be opened
        return
    folder = os.open(path.parent, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def readCheckpoint(path):
    """Return what `writeCheckpoint` wrote: the dictionary, and a dictionary of checkpoints by replica.

    Raises
    ------
    InputError
        if there is no such file, or it is damaged or of another version
    """
    try:
        with zipfile.ZipFile(path) as archive:
            header = json.loads(archive.read(_HEADER))
            if header["version"] != _VERSION:
                raise InputError(f"{path}: is of another version of openmm-chaintree")
            checkpoints = {name: archive.read(name) for name in header["digests"]}
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
        raise InputError(f"{path}: is no checkpoint of this command, or damaged ({error})") from error
    return header, {int(name): checkpoint for name, checkpoint in checkpoints.items()}
