"""Adding hydrogens to a Structure."""

import random
from contextlib import contextmanager

import numpy as np
import openmm.app
from openmm import unit
from openmm.app import element

from ..errors import InputError
from ..naming import describeResidue
from ..notes import Note, found
from ..residues import aminoAcid, isPolymer
from ..templates import atomAliases

# Names that tell how a residue is protonated, and what Modeller calls that.
_VARIANTS = {
    "HID": "HID", "HSD": "HID", "HIE": "HIE", "HSE": "HIE", "HIP": "HIP", "HSP": "HIP",
    "ASH": "ASH", "GLH": "GLH", "LYN": "LYN", "CYX": "CYX",
}  # fmt: skip


def addHydrogens(structure, pH, seed):
    """Return a Structure with the hydrogens that were missing, and their indices, an int array.

    Modeller adds them, each next to the atom that it is bonded to. All else stays as it was.

    Raises
    ------
    InputError
        if atoms are missing without which it cannot be told where hydrogens go
    """
    named, variants = _withStandardNames(structure.topology)
    modeller = openmm.app.Modeller(named, structure.positions * unit.nanometer)
    platform = openmm.Platform.getPlatformByName("CPU")
    with _repeatable(seed, platform):
        try:
            chosen = modeller.addHydrogens(pH=pH, variants=variants, platform=platform)
        except ValueError as error:
            raise InputError(f"--add-hydrogens: {error}") from error
    return _restore(structure, modeller, _noteVariants(structure.topology, chosen, pH))


@contextmanager
def _repeatable(seed, platform):
    """Let Modeller, which begins with random places, do the same for the same seed: sums of many threads vary."""
    state, threads = random.getstate(), platform.getPropertyDefaultValue("Threads")
    random.seed(seed)
    platform.setPropertyDefaultValue("Threads", "1")
    try:
        yield
    finally:
        random.setstate(state)
        platform.setPropertyDefaultValue("Threads", threads)


def _withStandardNames(topology):
    """Return a copy with the names that Modeller knows, and its variants, where names tell them, as a list.

    A chain ends where a polymer does, so that Modeller sees its ends.
    """
    named = openmm.app.Topology()
    copies, variants = {}, []
    for chain in topology.chains():
        newChain, wasPolymer = None, None
        for residue in chain.residues():
            if newChain is None or isPolymer(residue) != wasPolymer:
                newChain, wasPolymer = named.addChain(chain.id), isPolymer(residue)
            name = aminoAcid(residue.name) or residue.name
            aliases = atomAliases(name)
            newResidue = named.addResidue(name, newChain, residue.id, residue.insertionCode)
            for atom in residue.atoms():
                isHydrogen = atom.element is element.hydrogen
                newName = atom.name if isHydrogen else aliases.get(atom.name, atom.name)
                copies[atom] = named.addAtom(newName, atom.element, newResidue)
            variants.append(_variant(residue, {atom.name for atom in newResidue.atoms()}))
    for first, second in topology.bonds():
        named.addBond(copies[first], copies[second])
    return named, variants


def _variant(residue, names):
    """Return the variant that the name of a residue tells, if it has no hydrogens that tell it, too."""
    if aminoAcid(residue.name) == "HIS" and not {"ND1", "NE2"} <= names:
        raise InputError(
            f"--add-hydrogens: {describeResidue(residue)} lacks {' and '.join(sorted({'ND1', 'NE2'} - names))}, "
            "which PDBFixer adds"
        )
    if any(atom.element is element.hydrogen for atom in residue.atoms()):
        return None
    return _VARIANTS.get(residue.name)


def _noteVariants(topology, chosen, pH):
    items = [
        f"{describeResidue(residue)} {variant}"
        for residue, variant in zip(topology.residues(), chosen, strict=True)
        if variant in _VARIANTS and variant != "CYX"
    ]
    return found([Note(f"protonation that hydrogens were added by, at pH {pH:g}", items)])


def _restore(structure, modeller, notes):
    """Return a Structure with the atoms of a Modeller and the names that were there before, and what is new."""
    placed = modeller.positions.value_in_unit(unit.nanometer)
    topology = openmm.app.Topology()
    copies, sources = [], []
    newResidues = modeller.topology.residues()
    for chain in structure.topology.chains():
        newChain = topology.addChain(chain.id)
        for residue in chain.residues():
            newResidue = topology.addResidue(residue.name, newChain, residue.id, residue.insertionCode)
            old = list(residue.atoms())
            for atom in next(newResidues).atoms():
                # Modeller leaves what there was in its order, and where it was.
                if old and tuple(placed[atom.index]) == tuple(structure.positions[old[0].index].tolist()):
                    source = old.pop(0)
                    copies.append(topology.addAtom(source.name, source.element, newResidue, source.id))
                    sources.append(source.index)
                else:
                    copies.append(topology.addAtom(atom.name, atom.element, newResidue))
                    sources.append(-1)
    for first, second in modeller.topology.bonds():
        topology.addBond(copies[first.index], copies[second.index])
    sources = np.array(sources)
    assert np.array_equal(sources[sources >= 0], np.arange(structure.topology.getNumAtoms()))
    alternates = [structure.alternates[source] if source >= 0 and structure.alternates else "" for source in sources]
    whole = structure._replace(
        topology=topology,
        positions=np.array([tuple(position) for position in placed]),
        alternates=alternates,
        notes=[*structure.notes, *notes],
    )
    return whole, np.flatnonzero(sources < 0)
