"""Adding hydrogens to a Structure."""

import random
from collections import defaultdict
from contextlib import contextmanager
from itertools import groupby

import numpy as np
import openmm.app
from openmm import unit
from openmm.app import element

from ..covalent import isMetal
from ..errors import InputError
from ..naming import describeResidue
from ..notes import Note, found
from ..residues import aminoAcid, isPolymer
from ..templates import atomAliases, standardName

# Modeller's names of protonation states, and residue names that imply them; Amber prefixes N or C at chain ends.
_VARIANTS = {
    "HID": ("HID", "HSD", "HISA", "HISD"), "HIE": ("HIE", "HSE", "HISB", "HISE"), "HIP": ("HIP", "HSP", "HISH", "HISP"),
    "ASH": ("ASH", "ASPH", "ASPP"), "GLH": ("GLH", "GLUH", "GLUP"), "LYN": ("LYN", "LYSN", "LSN"),
    "CYX": ("CYX", "CYM", "CYS2"),
}  # fmt: skip
_VARIANT_OF_NAME = {
    f"{end}{name}": variant for variant, names in _VARIANTS.items() for name in names for end in ("", "N", "C")
}

# The variant without a hydrogen on an atom that binds a metal.
_AT_METALS = {"SG": "CYX", "NE2": "HID", "ND1": "HIE"}

# Atoms that bind a residue to the one before it, and to the one after it, in proteins and nucleic acids.
_FRONT, _BACK = ("N", "P"), ("C", "O3'")
_NON_METALS = (element.carbon, element.nitrogen, element.oxygen, element.phosphorus, element.sulfur)


def addHydrogens(structure, pH, seed, mindMetals=False):
    """Return a Structure with its missing hydrogens added by Modeller, and their indices, an int array.

    Each hydrogen follows the atom to which it is bonded. Everything else is unchanged. With mindMetals, sulfur of CYS
    and nitrogen of HIS that bind a metal get no hydrogen.

    Raises
    ------
    InputError
        if heavy atoms are missing that define the places of hydrogens
    """
    atMetals = _atomsAtMetals(structure.topology) if mindMetals else {}
    named, own, variants = _withStandardNames(structure.topology, atMetals)
    modeller = openmm.app.Modeller(named, structure.positions * unit.nanometer)
    platform = openmm.Platform.getPlatformByName("CPU")
    with repeatable(seed, platform):
        try:
            chosen = modeller.addHydrogens(pH=pH, variants=variants, platform=platform)
        except ValueError as error:
            raise InputError(f"--add-hydrogens: {error}") from error
    return _restore(structure, modeller, own, _noteVariants(own, chosen, pH))


@contextmanager
def repeatable(seed, platform):
    """Make Modeller, which starts from random places, reproducible: seed it and use one thread."""
    state, threads = random.getstate(), platform.getPropertyDefaultValue("Threads")
    random.seed(seed)
    platform.setPropertyDefaultValue("Threads", "1")
    try:
        yield
    finally:
        random.setstate(state)
        platform.setPropertyDefaultValue("Threads", threads)


def _atomsAtMetals(topology):
    """Return the residues that bind metals, each with the names of the atoms that do."""
    binding = defaultdict(set)
    for bond in topology.bonds():
        for atom, other in (bond, bond[::-1]):
            if atom.residue is not other.residue and isMetal(other.element.atomic_number):
                binding[atom.residue].add(atom.name)
    return binding


def _withStandardNames(topology, atMetals):
    """Return a copy with Modeller's names, and for each residue the original and the variant implied by its names.

    Modeller treats the first and the last residue of a chain as its ends. So the copy's chains end where polymers do;
    an empty residue without an original stands next to an end that is bonded to a residue, as in a cyclic peptide.
    """
    named = openmm.app.Topology()
    copies, own, variants = {}, [], []
    front, back = boundEnds(topology)

    def add(residue, name, chain):
        own.append(residue)
        return named.addResidue(name, chain, *((residue.id, residue.insertionCode) if residue else ()))

    for chain in topology.chains():
        for _, group in groupby(chain.residues(), isPolymer):
            residues, newChain = list(group), named.addChain(chain.id)
            if residues[0] in front:
                add(None, "", newChain)
            for residue in residues:
                name = _modellerName(residue)
                aliases = atomAliases(name)
                newResidue = add(residue, name, newChain)
                for atom in residue.atoms():
                    isHydrogen = atom.element is element.hydrogen
                    newName = atom.name if isHydrogen else aliases.get(atom.name, atom.name)
                    copies[atom] = named.addAtom(newName, atom.element, newResidue)
            if residues[-1] in back:
                add(None, "", newChain)
    for bond in topology.bonds():
        named.addBond(copies[bond[0]], copies[bond[1]], bond.type, bond.order)
    for residue, newResidue in zip(own, named.residues(), strict=True):
        variants.append(None if residue is None else _variant(residue, newResidue, atMetals.get(residue, ())))
    return named, own, variants


def _modellerName(residue):
    """Return Modeller's name of a residue; old files and CHARMM use the names of RNA for DNA."""
    name = standardName(residue.name)
    isDNA = name in ("A", "C", "G") and not any(atom.name == "O2'" for atom in residue.atoms())
    return f"D{name}" if isDNA else name


def boundEnds(topology):
    """Return two sets: residues whose front, and whose back, is bonded to another residue other than a metal."""
    front, back = set(), set()
    for bond in topology.bonds():
        for atom, other in (bond, bond[::-1]):
            if atom.residue is not other.residue and other.element in _NON_METALS:
                name = atomAliases(standardName(atom.residue.name)).get(atom.name, atom.name)
                if name in _FRONT:
                    front.add(atom.residue)
                if name in _BACK:
                    back.add(atom.residue)
    return front, back


def _variant(residue, named, atMetals):
    """Return the variant implied by the name of a residue without hydrogens; hydrogens would define it themselves.

    named : its copy with standard names; atMetals : the names of its atoms that bind a metal
    """
    names = {atom.name for atom in named.atoms()}
    if aminoAcid(residue.name) == "HIS" and not {"ND1", "NE2"} <= names:
        raise InputError(
            f"--add-hydrogens: {describeResidue(residue)} lacks {' and '.join(sorted({'ND1', 'NE2'} - names))}, "
            "which --prepare adds"
        )
    if any(atom.element is element.hydrogen for atom in residue.atoms()):
        return None
    byMetal = [variant for atom, variant in _AT_METALS.items() if atom in atMetals]
    return byMetal[0] if byMetal else _VARIANT_OF_NAME.get(residue.name)


def _noteVariants(own, chosen, pH):
    items = [
        f"{describeResidue(residue)} {variant}"
        for residue, variant in zip(own, chosen, strict=True)
        if variant in _VARIANTS and variant != "CYX"
    ]
    return found([Note(f"protonation states of residues with added hydrogens, at pH {pH:g}", items)])


def _restore(structure, modeller, own, notes):
    """Return a Structure with the atoms of a Modeller under the original names, and the indices of the new atoms."""
    placed = modeller.positions.value_in_unit(unit.nanometer)
    topology = openmm.app.Topology()
    copies, sources = [], []
    made = dict(zip(own, modeller.topology.residues(), strict=True))
    for chain in structure.topology.chains():
        newChain = topology.addChain(chain.id)
        for residue in chain.residues():
            newResidue = topology.addResidue(residue.name, newChain, residue.id, residue.insertionCode)
            old = list(residue.atoms())
            for atom in made[residue].atoms():
                # Modeller keeps the order and the places of the original atoms.
                if old and tuple(placed[atom.index]) == tuple(structure.positions[old[0].index].tolist()):
                    source = old.pop(0)
                    copies.append(topology.addAtom(source.name, source.element, newResidue, source.id))
                    sources.append(source.index)
                else:
                    copies.append(topology.addAtom(atom.name, atom.element, newResidue))
                    sources.append(-1)
    for bond in modeller.topology.bonds():
        topology.addBond(copies[bond[0].index], copies[bond[1].index], bond.type, bond.order)
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
