"""The bonds of residues by the names of their atoms.

Amino acids, nucleotides and water are in OpenMM's tables, with the names that programs give to their atoms. Other
residues are looked up in the chemical component dictionary of the Protein Data Bank, which the package biotite holds.
"""

import xml.etree.ElementTree as ElementTree
from functools import cache
from pathlib import Path

import openmm.app

from .extras import importExtra
from .residues import aminoAcid, isCalledWater, nucleotide

_DATA = Path(openmm.app.__file__).parent / "data"


def isStandard(residueName):
    """Whether OpenMM's tables have a residue of this name."""
    return residueName in _standardBonds()


def templateBonds(residueName, atomNames):
    """Return the bonds of a residue as pairs of indices into the names of its atoms; [] for an unknown residue.

    A residue is known if the dictionary has its name and the names of all its atoms except hydrogens.

    Parameters
    ----------
    residueName : str
    atomNames : list of str
    """
    name = "HOH" if isCalledWater(residueName) else standardName(residueName)
    standard = _standardBonds().get(name)
    if standard is not None:
        aliases = atomAliases(name)
        places = {aliases.get(atom, atom): number for number, atom in enumerate(atomNames)}
        bonds = standard
    else:
        places = {atom: number for number, atom in enumerate(atomNames)}
        bonds = _dictionaryBonds(name)
        known = {atom for bond in bonds for atom in bond}
        if any(atom not in known for atom in atomNames if not mayBeHydrogen(atom)):
            return []
    return [(places[first], places[second]) for first, second in bonds if first in places and second in places]


@cache
def _standardBonds():
    """Return OpenMM's table: residue names, each with the pairs of atoms that are bonded within the residue."""
    table = {}
    for residue in ElementTree.parse(_DATA / "residues.xml").getroot().iter("Residue"):
        bonds = [(bond.attrib["from"], bond.attrib["to"]) for bond in residue.iter("Bond")]
        table[residue.attrib["name"]] = [bond for bond in bonds if not any(name[0] in "+-" for name in bond)]
    return table


def standardName(residueName):
    """Return the name of a residue in OpenMM's tables: ALA for DAL, NH2 for NHE, DA for DA5, or else the same name."""
    return aminoAcid(residueName) or nucleotide(residueName) or _residueAliases().get(residueName, residueName)


@cache
def _residueAliases():
    """Return other names of residues, each with the name in OpenMM's table."""
    residues = list(_names().iter("Residue"))
    return {
        other: residue.attrib["name"]
        for residue in residues
        for key, other in residue.attrib.items()
        if key.startswith("alt")
    }


@cache
def atomAliases(residueName):
    """Return other names of the atoms of a residue, each with the name in OpenMM's table."""
    aliases = {}
    residues = {residue.attrib["name"]: residue for residue in _names().iter("Residue")}
    kind = residues[residueName].attrib.get("type") if residueName in residues else None
    for source in ("All", kind, residueName):
        for atom in residues[source].iter("Atom") if source in residues else ():
            for key, other in atom.attrib.items():
                if key != "name":
                    aliases[other] = atom.attrib["name"]
    return aliases


@cache
def _names():
    return ElementTree.parse(_DATA / "pdbNames.xml").getroot()


@cache
def _dictionaryBonds(residueName):
    # The dictionary takes seconds to load, and few structures need it.
    info = importExtra("biotite.structure.info", f"finding the bonds of {residueName}, which its Topology lacks,")
    return list(info.bonds_in_residue(residueName))


def mayBeHydrogen(name):
    """Whether the name of an atom begins as those of hydrogen and deuterium."""
    return name.lstrip("0123456789").startswith(("H", "D"))
