"""Making a StericExclusionForce from a Topology."""

import warnings
from collections import Counter
from collections.abc import Iterable

import numpy as np
from openmm import app

from .bonds import BondGraph
from .naming import describeResidue
from .openmmchaintree import StericExclusionForce
from .radii import RADII_SETS, defaultRadii, hydrogenBondRoles, particleRadii
from .torsions import DISULFIDE_RING, PROLINE_RING, Torsion, TorsionSearch, searchTorsions
from .units import Array, Number, inUnit, positionsInNm


def createStericExclusionForce(
    topology: app.Topology,
    positions: Array | None = None,
    radii: str | Array | None = None,
    torsions: str | Iterable[str] | Iterable[Torsion] = ("phi", "psi", "chi"),
    bondCutoff: int = 3,
    cutDisulfides: bool = False,
    forceGroup: int = 31,
    unknownRadius: Number | None = None,
) -> StericExclusionForce:
    """Create a StericExclusionForce for the molecules of a Topology.

    Every atom becomes a particle, water and ions too: what should not be in the way can be given the radius 0. An
    extra particle (an atom without element) has radius 0. Residues without torsions of the kinds asked for, and
    heterogens, are rigid. What is left out, because it lies in a ring or next to a gap in the chain, is reported by a
    warning, and by `findTorsions` in detail.

    Parameters
    ----------
    topology : openmm.app.Topology
        with the residue and atom names of the Protein Data Bank, as `openmm.app.PDBFile` gives them
    positions : array of shape (n, 3) or Quantity, optional
        nm. With them, a bond between residues that is longer than 0.4 nm is a gap: left out, so that the chain becomes
        two molecules. Atoms of residues for which the Topology has no bond at all are bonded where they are near.
    radii : str or array of shape (n) or Quantity, optional
        "all-atom" (Word et al. 1999), "united-atom" (Tsai et al. 1999; hydrogens get radius 0), or a radius in nm for
        each atom. Default: "all-atom" if the Topology has hydrogens, else "united-atom".
    torsions : str or iterable of str, or iterable of Torsion
        the kinds of torsions, as in `findTorsions`, or torsions that it returned
    bondCutoff : int
        pairs up to this many bonds apart are excluded
    cutDisulfides : bool
        leave disulfide bonds out, so that the torsions between their ends can turn. The atoms stay excluded as if the
        bonds were there; nothing keeps the sulfurs together.
    forceGroup : int
        the force group of the force, of its own unless other forces use it
    unknownRadius : float or Quantity, optional
        the radius in nm of atoms of elements for which the set of radii has none. Default: they are an error.

    Returns
    -------
    StericExclusionForce

    Raises
    ------
    ValueError
        if an argument is out of range or of the wrong shape, or an element has no radius
    TypeError
        if positions or radii have a unit that is not a length
    """
    if positions is not None:
        positions = positionsInNm(positions, topology.getNumAtoms())
    graph = BondGraph(topology, positions, cutDisulfides)
    values, roles = _radiiAndRoles(graph, radii, unknownRadius)
    found = _torsionsOf(graph, topology, torsions)
    _warn(graph, found.leftOut)

    force = StericExclusionForce()
    force.setName("StericExclusionForce")
    force.setForceGroup(forceGroup)
    for radius, role in zip(values.tolist(), roles, strict=True):
        force.addParticle(radius, role)
    for atom1, atom2 in graph.bonds:
        force.addBond(atom1, atom2)
    for torsion in found.torsions:
        force.addTorsion(*torsion.particles)
    force.createExclusionsFromBonds(bondCutoff)
    if cutDisulfides:
        for atom1, atom2 in graph.disulfides:
            for pair in _pairsAcross(graph.neighbors, atom1, atom2, bondCutoff):
                force.addExclusion(*pair)
    return force


def _radiiAndRoles(graph, radii, unknownRadius):
    if radii is None:
        radii = defaultRadii(graph)
    if isinstance(radii, str):
        if radii not in RADII_SETS:
            raise ValueError(f"{radii!r} is no set of radii; the sets are {', '.join(RADII_SETS)}")
        if unknownRadius is not None:
            unknownRadius = inUnit(unknownRadius, "nm", "unknownRadius")
        return particleRadii(graph, radii, unknownRadius), hydrogenBondRoles(graph, radii)
    values = np.asarray(inUnit(radii, "nm", "radii"), dtype=np.float64)
    if values.shape != (len(graph.atoms),):
        raise ValueError(f"radii must have the shape ({len(graph.atoms)},), not {values.shape}")
    return values, hydrogenBondRoles(graph, defaultRadii(graph))


def _torsionsOf(graph, topology, torsions):
    if not isinstance(torsions, str):
        torsions = tuple(torsions)
        if all(isinstance(torsion, Torsion) for torsion in torsions):
            return TorsionSearch(list(torsions), [])
    return searchTorsions(graph, topology, torsions)


def _warn(graph, leftOut):
    """Say what was left out, except for the torsions that nobody expects to turn: proline's φ."""
    for gap in graph.gaps:
        residues = f"{describeResidue(gap.residue1)} and {describeResidue(gap.residue2)}"
        warnings.warn(f"there is a gap in the chain between {residues}: {gap.reason}", stacklevel=3)
    reasons = Counter(torsion.reason for torsion in leftOut if not torsion.nextToGap)
    for reason, count in reasons.items():
        if reason != PROLINE_RING:
            remedy = ", which can be cut (cutDisulfides)" if reason == DISULFIDE_RING else ""
            verb = "torsion is" if count == 1 else "torsions are"
            warnings.warn(f"{count} {verb} left out: {reason}{remedy}", stacklevel=3)


def _pairsAcross(neighbors, atom1, atom2, bondCutoff):
    """Return the pairs at most bondCutoff bonds apart by way of a bond atom1–atom2 that neighbors does not have."""
    shells1 = _shells(neighbors, atom1, bondCutoff)
    shells2 = _shells(neighbors, atom2, bondCutoff)
    return [
        (first, second)
        for distance1, shell1 in enumerate(shells1)
        for distance2, shell2 in enumerate(shells2)
        if distance1 + 1 + distance2 <= bondCutoff
        for first in shell1
        for second in shell2
    ]


def _shells(neighbors, start, count):
    """Return the atoms 0, 1, …, count - 1 bonds away from an atom."""
    shells, seen = [], set()
    shell = {start}
    for _ in range(count):
        shells.append(shell)
        seen |= shell
        shell = {other for atom in shell for other in neighbors[atom]} - seen
    return shells
