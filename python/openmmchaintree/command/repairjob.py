"""The repair of one file by the command repair: all its models, and the text of the repaired file."""

import warnings
from typing import NamedTuple

import numpy as np

from ..errors import InputError
from ..notes import Note, NoteWarning
from ..repair import Repair, repairStructure
from ..structures.modelfile import NewAtom, compressedAs, readModelFile
from ..structures.structure import readModels

KEEP, ADD, NONE = "keep", "add", "none"
HYDROGENS = (KEEP, ADD, NONE)


class RepairJob(NamedTuple):
    """A file to repair. path : str; settings : dict, arguments of repairStructure; hydrogens : str, of HYDROGENS"""

    path: str
    settings: dict
    hydrogens: str


class RepairedFile(NamedTuple):
    """The repairs of the models of a file, the content of the repaired file for a name, and notes on the input."""

    repairs: list[Repair]
    text: str
    notes: list[Note]

    def contentFor(self, name):
        """Return the bytes of the repaired file, compressed if the name says so."""
        return compressedAs(name, self.text)


def runRepair(job):
    """Repair all models of a file; return a RepairedFile.

    Raises
    ------
    InputError
        if the file cannot be read or repaired
    """
    file = readModelFile(job.path)
    repairs, notes = [], []
    moved, removed, added = {}, set(), []
    for number in range(len(file.models)):
        models = readModels(job.path, number)
        source = job.path if len(file.models) == 1 else f"{job.path}: model {number} (from 0)"
        before = models.positions[0]
        repair, found = _repair(source, models.topology, before, job.settings)
        repairs.append(repair)
        notes += [*models.notes, *found] if number == 0 else []
        rows = file.matchRows(number, 10 * before)
        hasMoved = np.abs(repair.positions - before).max(axis=1) > 0
        places = {row: 10 * place for row, place, has in zip(rows, repair.positions, hasMoved, strict=True) if has}
        moved |= file.withAlternates(number, places)
        if job.hydrogens != KEEP:
            _changeHydrogens(job.hydrogens, models.topology, repair, rows, removed, added)
    moved = {row: place for row, place in moved.items() if row not in removed}
    return RepairedFile(repairs, file.write(moved, removed, added), notes)


def _repair(source, topology, positions, settings):
    """Return the Repair of a structure, and the Notes of its warnings."""
    try:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", NoteWarning)
            repair = repairStructure(topology, positions, **settings)
    except ValueError as error:
        raise InputError(f"{source}: {error}") from error
    return repair, [warning.message.note for warning in caught if isinstance(warning.message, NoteWarning)]


def _changeHydrogens(choice, topology, repair, rows, removed, added):
    """Note the rows of hydrogens to remove, and the hydrogens to add."""
    protonated = repair.protonated
    kept = set(protonated.origins.tolist())
    for atom in topology.atoms():
        isHydrogen = atom.element is not None and atom.element.atomic_number == 1
        if isHydrogen and (choice == NONE or atom.index not in kept):
            removed.add(rows[atom.index])
    if choice == NONE:
        return
    for atom, origin, bearer in zip(
        protonated.topology.atoms(), protonated.origins.tolist(), protonated.bearers.tolist(), strict=True
    ):
        if origin < 0:
            added.append(NewAtom(rows[bearer], atom.name, 10 * protonated.positions[atom.index]))
