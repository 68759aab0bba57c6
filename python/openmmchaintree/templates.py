"""The bonds of residues by the names of their atoms.

Amino acids, nucleotides and water are in OpenMM's tables, with the names that programs give to their atoms. Other
residues are looked up in the chemical component dictionary of the Protein Data Bank, which the package biotite holds.
"""

from functools import cache

from openmm import app

from .extras import importExtra
from .residues import aminoAcid, isCalledWater, nucleotide


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
    app.Topology().createStandardBonds()  # loads the table
    return {
        name: [bond for bond in bonds if not any(atom[0] in "+-" for atom in bond)]
        for name, bonds in app.Topology._standardBonds.items()
    }


def standardName(residueName):
    """Return the name of a residue in OpenMM's tables: ALA for DAL, NH2 for NHE, DA for DA5, or else the same name."""
    return aminoAcid(residueName) or nucleotide(residueName) or _otherNames()[0].get(residueName, residueName)


def atomAliases(residueName):
    """Return other names of the atoms of a residue, each with the name in OpenMM's table."""
    byResidue = _otherNames()[1]
    return byResidue.get(residueName, byResidue["All"])


@cache
def _otherNames():
    """Return OpenMM's tables of other names: for residues, and for the atoms of each residue."""
    app.PDBFile._loadNameReplacementTables()
    return app.PDBFile._residueNameReplacements, app.PDBFile._atomNameReplacements


@cache
def _dictionaryBonds(residueName):
    # The dictionary takes seconds to load, and few structures need it.
    info = importExtra("biotite.structure.info", f"finding the bonds of {residueName}, which its Topology lacks,")
    return list(info.bonds_in_residue(residueName))


@cache
def templateOrders(residueName, atomNames):
    """Return the orders of the bonds of a residue by pairs of names, a frozenset each; {} for an unknown residue.

    1, 2 or 3, of one Kekulé formula. A residue is known if the chemical component dictionary has its name and the
    names of all its atoms except hydrogens.

    Parameters
    ----------
    residueName : str
    atomNames : tuple of str
    """
    info = importExtra("biotite.structure.info", f"finding the orders of the bonds of {residueName}")
    orders = {frozenset(pair): _orderOf(kind) for pair, kind in info.bonds_in_residue(residueName).items()}
    known = {name for pair in orders for name in pair}
    return orders if all(name in known for name in atomNames if not mayBeHydrogen(name)) else {}


def _orderOf(bondType):
    """Return the order of biotite's type of a bond, in aromatic rings that of one Kekulé formula; None without one."""
    return {"SINGLE": 1, "DOUBLE": 2, "TRIPLE": 3}.get(bondType.name.removeprefix("AROMATIC_"))


def mayBeHydrogen(name):
    """Whether the name of an atom begins like a name of hydrogen or deuterium."""
    return name.lstrip("0123456789").startswith(("H", "D"))
