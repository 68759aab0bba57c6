"""Densities of phi and psi for ranges of residues, such as a helix that forms in a disordered chain."""

from pathlib import Path

from ..beadplaces import beadResidues
from ..coil import readCoilTables, tableOf
from ..errors import InputError
from .domains import residuesOf

NAMES = ("helix", "extended", "polyproline")


def readBiases(texts, topology, tables):
    """Return the names of tables by the index of a residue, and all tables by name, for `createCoilForce`.

    Parameters
    ----------
    texts : iterable of str
        each a range of residues by number and a density: "70-80:helix", "A:5-9:extended", or "12-20:own.csv" with a
        file as `createCoilForce` reads it
    topology : openmm.app.Topology
    tables
        as for `createCoilForce`

    Raises
    ------
    InputError
        if a text cannot be read, there are no such residues, or a residue has two biases
    """
    kinds, known = {}, dict(readCoilTables(tables))
    residues = [residue for chain in beadResidues(topology) for residue, _ in chain]
    for text in texts:
        segment, _, name = text.strip().rpartition(":")
        if not segment or not (name in NAMES or Path(name).suffix):
            raise InputError(f"{text!r} is no bias such as 70-80:helix: densities are {', '.join(NAMES)}, or a file")
        own = None if name in NAMES else readCoilTables(name)
        for index in residuesOf(segment, residues):
            residue = residues[index]
            if residue.index in kinds:
                raise InputError(f"residue {residue.id} has two biases, one of them {text}")
            kinds[residue.index] = name
            if own is not None:
                after = residues[index + 1].name if index + 1 < len(residues) else None
                found = tableOf(residue.name, after, own)
                kinds[residue.index] = f"{name}/{found}"
                known[kinds[residue.index]] = own[found]
    return kinds, known
