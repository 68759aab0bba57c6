"""Reads sequences of amino acids from FASTA files."""

import gzip
import re
from pathlib import Path
from typing import NamedTuple

import gemmi

from ..errors import InputError

_SUFFIXES = (".fasta", ".fa", ".faa", ".fas", ".seq")
_LARGEST_FILE = 2**30  # bytes


class NamedSequence(NamedTuple):
    """A sequence in letters, and its name: the first word of its header."""

    name: str
    letters: str


def isSequenceFile(path):
    """Whether a file's name is that of a FASTA file, plain or compressed by gzip."""
    return Path(str(path).lower().removesuffix(".gz")).suffix in _SUFFIXES


def readSequences(path):
    """Return the list of NamedSequence of a FASTA file.

    Raises
    ------
    InputError
        if the file cannot be read, has no sequence, or a sequence is empty or has something else than letters
    """
    try:
        with gzip.open(path, "rb") if str(path).lower().endswith(".gz") else open(path, "rb") as file:
            data = file.read(_LARGEST_FILE + 1)
    except (OSError, EOFError) as error:
        raise InputError(f"{path}: {getattr(error, 'strerror', None) or error}") from error
    if len(data) > _LARGEST_FILE:
        raise InputError(f"{path}: is larger than {_LARGEST_FILE:,} bytes")
    try:
        records = gemmi.read_pir_or_fasta(data.decode())
    except (UnicodeDecodeError, ValueError, RuntimeError) as error:
        raise InputError(f"{path}: is no FASTA file ({error})") from error
    if not records:
        raise InputError(f"{path}: has no sequence")
    found = []
    for number, record in enumerate(records, 1):
        words = record.header.split()
        name = words[0] if words else f"sequence-{number}"
        letters = record.seq.rstrip("*").upper()
        if not re.fullmatch("[A-Z]+", letters):
            raise InputError(f"{path}: sequence {name} is empty, or has other signs than letters")
        found.append(NamedSequence(name, letters))
    return found
