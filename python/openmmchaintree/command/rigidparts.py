"""Describes parts of molecules that stay rigid, although their energy would allow rotation."""

from ..bonds import neighborLists, ringBonds
from ..naming import describeResidue
from ..notes import Note
from ..torsions import bondsThatStay


def describeRigidParts(graph, torsions, fixed):
    """Return a line on the rigid parts of a BondGraph under a list of Torsion; some atoms may be fixed."""
    parts = ["bond lengths and angles"]
    residueOf = [atom.residue for atom in graph.atoms]
    within = [bond for bond in graph.bonds if residueOf[bond[0]] is residueOf[bond[1]]]
    inRings = ringBonds(neighborLists(len(residueOf), within))
    if inRings:
        parts.append(f"rings ({', '.join(sorted({residueOf[bond[0]].name for bond in inRings}))})")
    across = ringBonds(graph.neighbors) - inRings
    if across:
        parts.append(str(Note("bonds in rings of several residues", map(graph.describePair, sorted(across)))))
    if graph.closures:
        bonds = [[describeResidue(graph.atoms[atom].residue) for atom in closure[1:3]] for closure in graph.closures]
        # A window in one ring keeps the others, so it may exclude torsions next to its closure.
        beside = ", and some beside them" if len(bonds) > 1 else ""
        parts.append(str(Note(f"turns about bonds that closed moves keep{beside}", map(" – ".join, bonds))))
    stiff = bondsThatStay(graph, torsions, fixed)
    if stiff:
        parts.append(str(Note("bonds in no ring", map(graph.describePair, stiff))))
    return "; ".join(parts)
