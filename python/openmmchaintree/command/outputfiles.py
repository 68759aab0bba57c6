"""Output files, checked before anything is written and written in one go."""

import json
from pathlib import Path

from ..errors import InputError

_PICTURES = (".png", ".pdf", ".svg")


def checkOutput(paths, inputs):
    """Refuse files that cannot be written, are among the inputs, or are named twice."""
    paths = [Path(path) for path in paths]
    for number, path in enumerate(paths):
        if any(path.exists() and Path(path_).exists() and path.samefile(path_) for path_ in inputs):
            raise InputError(f"{path}: would overwrite a file that is read")
        if path in paths[:number]:
            raise InputError(f"{path}: is named for two outputs")
        if path.is_dir():
            raise InputError(f"{path}: is a folder, not a file")
        if not path.parent.is_dir():
            raise InputError(f"{path}: there is no folder {path.parent}")
        _checkWritable(path)


def checkPicture(path):
    """Refuse a picture in a format that is not known."""
    if Path(path).suffix.lower() not in _PICTURES:
        raise InputError(f"{path}: a picture's name ends in {', '.join(_PICTURES)}")


def writeJSON(path, content):
    """Write plain dictionaries and lists as JSON."""
    text = json.dumps(content, indent=2, ensure_ascii=False, allow_nan=False)
    Path(path).write_text(text + "\n", encoding="utf-8")


def _checkWritable(path):
    """Open a file for writing without changing it; this is the only test that holds for every user and file system."""
    isNew = not path.exists()
    try:
        path.open("ab").close()
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from error
    if isNew:
        path.unlink()
