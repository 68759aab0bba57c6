"""Radii of atoms, and their roles in hydrogen bonds.

*all-atom*: the radii of Word et al., J. Mol. Biol. 285, 1711–1733 (1999), for structures with hydrogens, as in their
program Probe.

*united-atom*: the radii of Tsai et al., J. Mol. Biol. 290, 253–266 (1999), in which carbon, nitrogen, oxygen and sulfur
include their hydrogens.

Neither paper covers other elements. For these, both sets use the radii of Probe: Bondi, J. Phys. Chem. 68, 441–451
(1964) and Gavezzotti, J. Am. Chem. Soc. 105, 5220–5225 (1983) for non-metals, and Pauling's ionic radii for metals,
since metals are usually bound.
"""

import numpy as np

from .errors import UnknownRadiusError
from .naming import nameAtom
from .notes import Note
from .residues import aminoAcid, isSp2Carbon

ALL_ATOM = "all-atom"
UNITED_ATOM = "united-atom"
RADII_SETS = (ALL_ATOM, UNITED_ATOM)

# Bits of StericExclusionForce.HydrogenBondRole.
_DONOR, _ACCEPTOR = 1, 2

_H, _C, _N, _O, _S = 1, 6, 7, 8, 16

# nm
_OTHER_ELEMENTS = {
    "F": 0.130, "P": 0.180, "Cl": 0.177, "As": 0.200, "Se": 0.190, "Br": 0.195, "I": 0.210,
    "Li": 0.060, "Na": 0.095, "Mg": 0.065, "Al": 0.050, "K": 0.133, "Ca": 0.099, "Mn": 0.080, "Fe": 0.074,
    "Co": 0.070, "Ni": 0.066, "Cu": 0.072, "Zn": 0.071, "Rb": 0.148, "Sr": 0.110, "Mo": 0.093, "Ag": 0.126,
    "Cd": 0.091, "In": 0.081, "Cs": 0.169, "Ba": 0.129, "Au": 0.110, "Hg": 0.100, "Tl": 0.144, "Pb": 0.084,
}  # fmt: skip


def defaultRadii(graph):
    """Return for each atom of a BondGraph the set for its molecule: all-atom if the molecule shows its hydrogens.

    A molecule shows them if at least as many of its residues have a hydrogen on a carbon as have a carbon that lacks
    one. Where only nitrogen and oxygen have hydrogens, as some programs write, carbons include theirs.
    """
    return np.where(graph.shownHydrogens.areShown, ALL_ATOM, UNITED_ATOM).tolist()


def describeSets(radiiSets):
    """Return the names of the sets of some atoms, in words."""
    return " and ".join(name for name in RADII_SETS if name in set(radiiSets))


def particleRadii(graph, radiiSets, unknownRadius=None):
    """Return the radii (nm) of the atoms of a BondGraph as a float64 array; 0 for extra particles.

    radiiSets : the set of each atom, as `defaultRadii` returns them, or one set for all

    Raises
    ------
    UnknownRadiusError
        if the set has no radius for the element of an atom and unknownRadius is None
    """
    functions = {ALL_ATOM: _allAtomRadius, UNITED_ATOM: _unitedAtomRadius}
    radii = [functions[radiiSet](graph, atom) for atom, radiiSet in enumerate(_setOfEach(graph, radiiSets))]
    unknown = [f"{nameAtom(graph.atoms[i])}, {graph.atoms[i].element.name}" for i, r in enumerate(radii) if r is None]
    if unknown and unknownRadius is None:
        note = Note("atoms of elements without a known radius", unknown)
        raise UnknownRadiusError(note, "pass radii or unknownRadius")
    return np.array([unknownRadius if value is None else value for value in radii], dtype=np.float64)


def hydrogenBondRoles(graph, radiiSets):
    """Return the hydrogen bond role of each atom of a BondGraph, as integers of HydrogenBondRole.

    In the all-atom set hydrogens donate, in the united-atom set the atoms that bear them. If a molecule does not show
    its hydrogens, roles in amino acids follow from the residue, and other atoms may both donate and accept.
    """
    arePolarShown = graph.shownHydrogens.arePolarShown.tolist()
    roles = []
    for atom, radiiSet in enumerate(_setOfEach(graph, radiiSets)):
        isUnited, isShown = radiiSet == UNITED_ATOM, arePolarShown[atom]
        donor = _bearsHydrogen(graph, atom, isShown) if isUnited else _isPolarHydrogen(graph, atom)
        acceptor = _isAcceptor(graph, atom, isShown)
        roles.append((_DONOR if donor else 0) | (_ACCEPTOR if acceptor else 0))
    return roles


def _setOfEach(graph, radiiSets):
    return [radiiSets] * len(graph.atoms) if isinstance(radiiSets, str) else radiiSets


def _allAtomRadius(graph, atom):
    element = graph.elementNumber(atom)
    if element == _H:
        onSp2Carbon = any(
            graph.elementNumber(other) == _C and len(graph.neighbors[other]) == 3 for other in graph.neighbors[atom]
        )
        return 0.100 if onSp2Carbon or _isPolarHydrogen(graph, atom) else 0.117
    if element == _C:
        isCarbonyl = any(
            graph.elementNumber(other) == _O and len(graph.neighbors[other]) == 1 for other in graph.neighbors[atom]
        )
        return 0.165 if isCarbonyl else 0.175
    return {_N: 0.155, _O: 0.140, _S: 0.180}.get(element, _otherRadius(graph, atom))


def _unitedAtomRadius(graph, atom):
    element = graph.elementNumber(atom)
    if element == _H:
        return 0.0
    name, residue = graph.atoms[atom].name, graph.atoms[atom].residue.name
    if element == _C:
        if isSp2Carbon(residue, name, withHydrogen=False):
            return 0.161
        return 0.176 if isSp2Carbon(residue, name, withHydrogen=True) else 0.188
    if element == _O:
        return 0.142 if _isCarbonylOxygen(graph, atom) else 0.146
    return {_N: 0.164, _S: 0.177}.get(element, _otherRadius(graph, atom))


def _otherRadius(graph, atom):
    return _OTHER_ELEMENTS.get(graph.atoms[atom].element.symbol) if graph.elementNumber(atom) else 0.0


def _isCarbonylOxygen(graph, atom):
    """Whether an oxygen belongs to a carbonyl or carboxylate: by its name in amino acids, else by its bonds."""
    name, residue = graph.atoms[atom].name, graph.atoms[atom].residue.name
    if aminoAcid(residue) is not None:
        return name not in ("OG", "OG1", "OH")
    neighbors = graph.neighbors[atom]
    if len(neighbors) != 1 or graph.elementNumber(neighbors[0]) != _C:
        return False
    return isSp2Carbon(residue, graph.atoms[neighbors[0]].name, withHydrogen=False)


def _isPolarHydrogen(graph, atom):
    return graph.elementNumber(atom) == _H and any(
        graph.elementNumber(other) in (_N, _O, _S) for other in graph.neighbors[atom]
    )


def _bearsHydrogen(graph, atom, hasHydrogens):
    """Whether an N or O has a hydrogen, or may have one that the Topology does not show.

    Hydrogen bonds of sulfur are not shorter than contacts, so sulfur needs no role.
    """
    element = graph.elementNumber(atom)
    if element not in (_N, _O):
        return False
    if hasHydrogens:
        return bool(graph.hydrogensOf(atom))
    heavy = len(graph.heavyNeighborsOf(atom))
    if element == _N:
        return heavy < 3
    return heavy < 2 and not _isCarbonylOxygen(graph, atom)


def _isAcceptor(graph, atom, hasHydrogens):
    """Whether an atom has a lone pair to accept with."""
    element = graph.elementNumber(atom)
    if element in (_O, _S):
        return True
    if element != _N or len(graph.heavyNeighborsOf(atom)) > 2 or graph.hydrogensOf(atom):
        return False
    amino = aminoAcid(graph.atoms[atom].residue.name)
    return hasHydrogens or amino is None or (amino == "HIS" and graph.atoms[atom].name != "N")
