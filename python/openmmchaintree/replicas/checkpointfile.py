"""The file that a run goes on from: what is counted, and a checkpoint of each replica."""

import json
import os
import zipfile
from pathlib import Path

from ..errors import InputError

_VERSION = 1
_HEADER = "run.json"


def writeCheckpoint(path, header, checkpoints):
    """Write a dictionary of plain values and the checkpoints of replicas, None for none.

    Whatever ends the process or the machine, the file is the former one or this one.
    """
    path = Path(path)
    temporary = path.with_name(f"{path.name}.part")
    with open(temporary, "wb") as file:
        with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
            archive.writestr(_HEADER, json.dumps({"version": _VERSION, **header}))
            for replica, checkpoint in enumerate(checkpoints):
                if checkpoint is not None:
                    archive.writestr(str(replica), checkpoint)
        file.flush()
        os.fsync(file.fileno())
    os.replace(temporary, path)
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
            names = [name for name in archive.namelist() if name != _HEADER]
            checkpoints = {int(name): archive.read(name) for name in names}
    except FileNotFoundError:
        raise InputError(f"{path}: there is no such file") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error
    except (zipfile.BadZipFile, KeyError, ValueError) as error:
        raise InputError(f"{path}: is no checkpoint of this command, or damaged ({error})") from error
    if header.get("version") != _VERSION:
        raise InputError(f"{path}: is of another version of openmm-chaintree")
    return header, checkpoints
