"""Making a StericExclusionForce from a Topology."""

from collections.abc import Iterable

import numpy as np
import openmm
from openmm import app

from .beadnetwork import BeadNetwork
from .bonds import LOOPS, BondGraph, Closures, defaultClosures
from .graphs import growTrees, ringBonds
from .naming import describeResidue, nameAtom
from .notes import Note, countOf, found, warnOf
from .openmmchaintree import StericExclusionForce
from .radii import RADII_SETS, defaultRadii, hydrogenBondRoles, particleRadii
from .residues import aminoAcid, isAlphaCarbonOnly
from .selection import AtomSelection, selectAtoms
from .systemreading import bondsOf, bondsOfBareAtoms, checkParticles, fixedParticles, hasPairEnergies, isPeriodic
from .torsions import (
    BETWEEN_FIXED,
    DISULFIDE_RING,
    KINDS_WITH_ENERGIES,
    METAL_RING,
    QUIET_REASONS,
    RING,
    Torsion,
    TorsionSearch,
    bondsThatStay,
    searchTorsions,
    withoutThoseBetween,
)
from .unbonded import unbondedNeighbors
from .units import Array, Number, inUnit, positionsInNm

# Reasons that name no atoms.
_COMMON_REASONS = {RING, DISULFIDE_RING, METAL_RING, BETWEEN_FIXED}

# Of atoms in `fixed`.
_MOVING = (
    "fixed atoms with a mass, which dynamics and moves of whole molecules move unless the System gives them mass 0"
)

_ARGUMENTS = {
    DISULFIDE_RING: 'which can be cut (cutDisulfides) or closed (closures="disulfides")',
    METAL_RING: "which can be cut (cutMetals)",
    BETWEEN_FIXED: f'where only side chains turn, unless loops are closed (closures="{LOOPS}")',
}


def createStericExclusionForce(
    topology: app.Topology,
    positions: Array | None = None,
    radii: str | Array | None = None,
    torsions: str | Iterable[str] | Iterable[Torsion] | None = None,
    bondCutoff: int = 3,
    cutDisulfides: bool = False,
    forceGroup: int = 31,
    unknownRadius: Number | None = None,
    cutMetals: bool = False,
    ballJoints: str | Iterable[tuple[int, int]] | None = None,
    closures: Closures | None = None,
    fixed: AtomSelection | None = None,
    system: openmm.System | None = None,
) -> StericExclusionForce:
    """Create a StericExclusionForce for the molecules of a Topology.

    Every atom becomes a particle, including water and ions: give atoms the radius 0 to ignore them. An extra particle
    (an atom without element) has radius 0. Residues without torsions of the chosen kinds, and heterogens, are rigid.
    `findTorsions` lists torsions that are left out since they lie in a ring or next to a gap in the chain.

    Bonds are taken from the Topology. Residues whose atoms these do not connect get the bonds of their template
    (OpenMM's tables, then the chemical component dictionary); with positions, bonds that are still missing, such as
    bonds of metals, are found by distance. One warning of each kind reports gaps, bonds that the Topology lacks, and
    unbonded atoms at covalent distance that a torsion moves apart: a sign that a bond is missing. The warning's
    attribute `note` lists all of them.

    Parameters
    ----------
    topology : openmm.app.Topology
        with the residue and atom names of the Protein Data Bank, as `openmm.app.PDBFile` gives them
    positions : array of shape (n, 3) or Quantity, optional
        nm. With them, a bond between residues that is longer than 0.4 nm is a gap: it is left out, and the chain
        becomes two molecules. Molecules may be split over the periodic box of the Topology.
    radii : str or array of shape (n) or Quantity, optional
        "all-atom" (Word et al. 1999), "united-atom" (Tsai et al. 1999; hydrogens get radius 0), or a radius in nm for
        each atom. Default: for each molecule "all-atom" if it shows its hydrogens, else "united-atom".
    torsions : str or iterable of str, or iterable of Torsion, optional
        the kinds of torsions, as in `findTorsions`, or torsions that it returned, for example with a `selection`.
        "all" means all bonds outside rings, "rotatable" the single ones of these that are neither terminal nor
        conjugated as in amides. Default: "all" if the `system` has the energies of a force field, else φ, ψ and χ.
    bondCutoff : int
        pairs up to this number of bonds apart are excluded
    cutDisulfides : bool
        leave disulfide bonds out, so that the torsions between their ends can turn. The atoms stay excluded as if the
        bonds were there, but nothing keeps the sulfurs together.
    cutMetals : bool
        the same for the bonds between metals and other residues
    forceGroup : int
        the force group of the force; by default one that other forces seldom use
    unknownRadius : float or Quantity, optional
        the radius in nm of atoms whose element has no radius in the set. Default: such atoms are an error.
    ballJoints : "bonds" or iterable of (int, int), optional
        pairs of bonded atoms: the molecule turns freely about the first one. Or "bonds" for all bonds that lie in no
        ring and have no torsion: each turns about its atom that is nearer to the molecule's lowest-numbered atom, so
        that every bond of a chain can take any direction. Default: the bonds of beads if the `system` has the energies
        of a force field (see below), else none. For hard beads without a System use ``torsions=()``,
        ``ballJoints="bonds"``, radii, and usually ``bondCutoff=1``. If a bead is fixed that is not the first of its
        molecule, give pairs that lead away from it.
    closures : "disulfides", "loops" or an iterable of these and of (int, int)
        bonds that close rings, or loops between fixed parts, and become closures (`StericExclusionForce.addClosure`):
        closed moves turn the torsions of their rings and keep these bonds. "disulfides" are all disulfides that close a
        ring; "loops" are the last bonds, from C to N or O3' to P, of all rows of residues between residues with `fixed`
        atoms. Default: "disulfides" if the `system` has the energies of a force field and they are not cut, else none.
    fixed : str, array of int or bool, or callable, optional
        atoms that must not move, as in `findTorsions`, which need the mass 0 in the System (given a `system`, a warning
        names atoms with another mass): torsions between two fixed atoms are left out. For example,
        ``fixed="not resSeq 20 to 30", closures="loops"`` samples a loop.
    system : openmm.System, optional
        the System to which the force will be added. Its particles of mass 0, except virtual sites, are fixed as well.
        Atoms without bonds in the Topology, such as beads or Drude particles, get the bonds of its HarmonicBondForce,
        constraints and DrudeForce, or else of its CustomBondForce. If it has a force between all pairs, such as a
        NonbondedForce or CustomNonbondedForce, all bonds outside rings and all rings of disulfides turn by default, and
        a warning lists bonds outside rings that stay rigid. If one of its Forces uses periodic boundary conditions, the
        force does, too (`StericExclusionForce.setUsesPeriodicBoundaryConditions`); without a System it does not.

    Beads are recognized in a System with energies of pairs: particles whose bonds are all longer than covalent bonds,
    as in CALVADOS, COCOMO and Mpipi. They have no radius by default, since their energies keep them apart, no torsions,
    and a ball joint at each bond, also of a Topology that calls them CA. Bonds stay as long as they are in the
    positions (`setBondLengths` changes that). An elastic network of harmonic bonds, as in a folded domain,
    makes a part rigid: joints lie between such parts. Other bonds that close rings, and bonds between chains that the
    Topology lacks, are left to their energies. Warnings list these parts and bonds.

    Returns
    -------
    StericExclusionForce

    Raises
    ------
    ValueError
        if an argument is out of range or of the wrong shape, an element has no radius, or positions seem to be in a
        wrong unit, such as ångström
    TypeError
        if positions or radii have a unit that is not a length
    """
    if positions is not None:
        positions = positionsInNm(positions, topology.getNumAtoms())
    held = np.empty(0, dtype=int) if fixed is None else selectAtoms(topology, fixed)
    others, moving, network = [], [], None
    hasEnergies = system is not None and hasPairEnergies(system)
    if system is not None:
        checkParticles(topology, system)
        massless = fixedParticles(system)
        moving = np.setdiff1d(held, massless).tolist()
        held = np.union1d(held, massless)
        bonds = bondsOf(system)
        others = bondsOfBareAtoms(topology, system, bonds)
        if hasEnergies:
            network = BeadNetwork(topology, system, bonds, positions)
            others = [*network.bonds, *(pair for pair in others if not network.beads.issuperset(pair))]
    if closures is None:
        closures = defaultClosures(hasEnergies, cutDisulfides)
    beads = network.beads if network else ()
    graph = BondGraph(topology, positions, cutDisulfides, cutMetals, closures, held, others, beads)
    kinds = torsions
    if torsions is None:
        kinds = KINDS_WITH_ENERGIES if hasEnergies else ("phi", "psi", "chi")
    search = _torsionsOf(graph, topology, kinds, held)
    if network and ballJoints is None:
        search, ballJoints = _turnBeads(search, network, torsions is None)
    force = makeForce(graph, search.torsions, radii, bondCutoff, forceGroup, unknownRadius)
    force.setUsesPeriodicBoundaryConditions(system is not None and isPeriodic(system))
    joints = _ballJointsOf(graph, search.torsions, ballJoints)
    for atom1, atom2 in joints:
        force.addBallJoint(atom1, atom2)
    notes = notesOnGeometry(graph, search.torsions) if not joints else []
    if hasEnergies and not joints:
        rigid = bondsThatStay(graph, search.torsions, held.tolist())
        notes += found([Note("bonds in no ring that stay rigid", map(graph.describePair, rigid))])
    notes += found([Note(_MOVING, [str(nameAtom(graph.atoms[atom])) for atom in moving])])
    if network:
        notes += _notesOnBeads(graph, network)
    warnOf([*graph.notes, *notes, *notesOnTorsions(search.leftOut)], stacklevel=2)
    return force


def makeForce(graph, torsions, radii=None, bondCutoff=3, forceGroup=31, unknownRadius=None):
    """Do the work of `createStericExclusionForce` on a BondGraph and a list of Torsions."""
    values, roles = _radiiAndRoles(graph, radii, unknownRadius)
    force = StericExclusionForce()
    force.setName("StericExclusionForce")
    force.setForceGroup(forceGroup)
    for radius, role in zip(values.tolist(), roles, strict=True):
        force.addParticle(radius, role)
    for atom1, atom2 in graph.bonds:
        force.addBond(atom1, atom2)
    for torsion in torsions:
        force.addTorsion(*torsion.particles)
    for closure in graph.closures:
        force.addClosure(*closure)
    force.createExclusionsFromBonds(bondCutoff)
    for atom1, atom2 in graph.cut:
        for pair in pairsAcross(graph.neighbors, atom1, atom2, bondCutoff):
            force.addExclusion(*pair)
    return force


def _radiiAndRoles(graph, radii, unknownRadius):
    if radii is None or isinstance(radii, str):
        if radii is None:
            radii = defaultRadii(graph)
        elif radii not in RADII_SETS:
            raise ValueError(f"{radii!r} is not a set of radii; the sets are {', '.join(RADII_SETS)}")
        if unknownRadius is not None:
            unknownRadius = inUnit(unknownRadius, "nm", "unknownRadius")
        return particleRadii(graph, radii, unknownRadius), hydrogenBondRoles(graph, radii)
    values = np.asarray(inUnit(radii, "nm", "radii"), dtype=np.float64)
    if values.shape != (len(graph.atoms),):
        raise ValueError(f"radii must have the shape ({len(graph.atoms)},), not {values.shape}")
    return values, hydrogenBondRoles(graph, defaultRadii(graph))


def _ballJointsOf(graph, torsions, ballJoints):
    """Return the given pairs of atoms, or all bonds that can be ball joints, each from the side of the root."""
    if ballJoints is None:
        return []
    if not isinstance(ballJoints, str):
        return [(int(atom1), int(atom2)) for atom1, atom2 in ballJoints]
    if ballJoints != "bonds":
        raise ValueError(f'ballJoints must be "bonds" or pairs of atoms, not {ballJoints!r}')
    stiff = ringBonds(graph.neighbors) | {tuple(sorted(torsion.particles[1:3])) for torsion in torsions}
    trees = growTrees(graph.neighbors, range(len(graph.atoms)))
    return sorted((parent, atom) for atom, parent in trees if (min(atom, parent), max(atom, parent)) not in stiff)


def _turnBeads(search, network, areJointsFirst):
    """Return a TorsionSearch and the ball joints of a BeadNetwork: where a bond is both, joints or torsions come first.

    Nobody expects torsions of residues in beads.
    """
    axes = {frozenset(torsion.particles[1:3]) for torsion in search.torsions}
    joints = [pair for pair in network.joints if areJointsFirst or frozenset(pair) not in axes]
    turning = set(map(frozenset, joints))
    torsions = [torsion for torsion in search.torsions if frozenset(torsion.particles[1:3]) not in turning]
    leftOut = [left for left in search.leftOut if network.beads.isdisjoint(atom.index for atom in left.residue.atoms())]
    return TorsionSearch(torsions, leftOut), joints


def _torsionsOf(graph, topology, torsions, fixed):
    if not isinstance(torsions, str):
        torsions = tuple(torsions)
        if all(isinstance(torsion, Torsion) for torsion in torsions):
            return TorsionSearch(list(torsions), [])
    return withoutThoseBetween(searchTorsions(graph, topology, torsions), graph, fixed)


def notesOnGeometry(graph, torsions):
    """Return Notes on bonds that are too long, on atoms that may lack a bond, and on residues with only a Cα atom."""
    notes = notesOnAlphaCarbons(graph)
    if graph.positions is None:
        return notes
    unbonded = unbondedNeighbors(graph, (torsion.particles[1:3] for torsion in torsions))
    overlong = map(graph.describePair, graph.overlong)
    return notes + found(
        [
            Note("bonds longer than 0.8 nm: are molecules split over a periodic box?", overlong),
            Note("atoms at covalent distance that are not bonded, and that torsions move apart", map(str, unbonded)),
        ]
    )


def _notesOnBeads(graph, network):
    """Return Notes on bonds of beads whose energies have no effect, and on beads that bonds hold in an unusual way."""
    notes = []
    if network.springs:
        springs = countOf(len(network.springs), "harmonic bond")
        notes.append(
            Note(f"{springs} of beads stay as long as they are in the positions, or as setBondLengths makes them")
        )
    if not graph.bonds and len(graph.atoms) > 1:
        text = "neither the Topology nor the System has a bond, so that each particle is a molecule"
        notes.append(Note(f"{text}, which only rigid-body moves can move"))
    parts = [
        f"{nameAtom(graph.atoms[part[0]])} … {nameAtom(graph.atoms[part[-1]])}, {len(part)} beads"
        for part in network.parts
    ]
    return notes + found(
        [
            Note("rigid parts of chains of beads, each an elastic network of bonds", parts),
            Note(
                "bonds of beads that close rings or join chains, which only their energies hold",
                map(graph.describePair, network.loose),
            ),
        ]
    )


def notesOnAlphaCarbons(graph):
    """Return a list with a Note on residues with only a Cα atom, empty if there are none."""
    residues = {atom.residue: None for atom in graph.atoms if aminoAcid(atom.residue.name) is not None}
    bare = [residue for residue in residues if isAlphaCarbonOnly(residue)]
    if bare and len(bare) == len(residues):
        return [Note("there is no torsion of a protein, because the model has only Cα atoms")]
    return found([Note("residues without torsions, because there are only their Cα atoms", map(describeResidue, bare))])


def notesOnTorsions(leftOut, remedies=_ARGUMENTS):
    """Return a Note for each reason why torsions are left out, except torsions that nobody expects to turn.

    Torsions next to a gap, and of residues with only a Cα atom, have other notes. remedies : dict, advice by reason
    """
    byReason = {}
    for torsion in leftOut:
        if not (torsion.nextToGap or torsion.reason in QUIET_REASONS or isAlphaCarbonOnly(torsion.residue)):
            name = f"{torsion.kind} of {describeResidue(torsion.residue)}"
            if torsion.reason in _COMMON_REASONS:
                byReason.setdefault(torsion.reason, []).append(name)
            else:
                byReason.setdefault("since atoms or bonds are missing", []).append(f"{name} ({torsion.reason})")
    more = {reason: f", {remedy}" for reason, remedy in remedies.items()}
    return [Note(f"torsions left out, {reason}{more.get(reason, '')}", names) for reason, names in byReason.items()]


def pairsAcross(neighbors, atom1, atom2, bondCutoff, length=1):
    """Return the pairs at most bondCutoff bonds apart along a bond atom1–atom2 that neighbors lacks.

    length : number of bonds between these; 0: they are one atom
    """
    shells1 = _shells(neighbors, atom1, bondCutoff + 1 - length)
    shells2 = _shells(neighbors, atom2, bondCutoff + 1 - length)
    return [
        (first, second)
        for distance1, shell1 in enumerate(shells1)
        for distance2, shell2 in enumerate(shells2)
        if distance1 + length + distance2 <= bondCutoff
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
