"""Loops of polymers between fixed parts, and the bonds that can close them."""

from .bondsearch import polymerLinks

# Fewer residues have too few torsions for a closed window.
_SHORTEST = 3


def loopBonds(atoms, bonds, fixed):
    """Return the last bond of each loop: a row of residues without fixed atoms, between two residues with fixed atoms.

    The whole loop then hangs on one fixed part, so that windows can lie anywhere in it.

    Parameters
    ----------
    atoms : list of openmm.app.Atom
    bonds : iterable of (int, int)
    fixed : iterable of int

    Returns
    -------
    set of (int, int), lower index first
    """
    held = {atoms[atom].residue.index for atom in fixed}
    following = {}  # the residue after a residue, and the bond between them
    for first, second in polymerLinks(atoms, bonds):
        bond = min(first.index, second.index), max(first.index, second.index)
        following[first.residue.index] = second.residue.index, bond
    found = set()
    for start in sorted(held):
        row, residue = [], start
        while residue in following and (residue == start or residue not in held):
            residue, bond = following[residue]
            row.append(bond)
        if residue in held and len(row) > _SHORTEST:
            found.add(row[-1])
    return found
