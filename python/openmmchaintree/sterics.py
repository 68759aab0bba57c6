"""Making a StericExclusionForce from a Topology."""

from collections.abc import Iterable

import numpy as np
import openmm
from openmm import app

from .bonds import LOOPS, BondGraph, Closures, defaultClosures, ringBonds
from .naming import describeResidue, nameAtom
from .notes import Note, found, warnOf
from .openmmchaintree import StericExclusionForce
from .radii import RADII_SETS, defaultRadii, hydrogenBondRoles, particleRadii
from .residues import aminoAcid, isAlphaCarbonOnly
from .selection import AtomSelection, selectAtoms
from .systemreading import bondsOfBareAtoms, checkParticles, fixedParticles, hasPairEnergies
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
    ballJoints: str | Iterable[tuple[int, int]] = (),
    closures: Closures | None = None,
    fixed: AtomSelection | None = None,
    system: openmm.System | None = None,
) -> StericExclusionForce:
    """Create a StericExclusionForce for the molecules of a Topology.

    Every atom becomes a particle, water and ions too: what should not be in the way can be given the radius 0. An
    extra particle (an atom without element) has radius 0. Residues without torsions of the kinds asked for, and
    heterogens, are rigid. What is left out, because it lies in a ring or next to a gap in the chain, is reported by
    `findTorsions` in detail.

    Bonds are those of the Topology. Residues that these do not hold together get the bonds of their template (OpenMM's
    tables, then the chemical component dictionary); with positions, bonds that are still missing are found by distance,
    those of metals among them. One warning a kind tells of gaps, of bonds that the Topology lacks, and of atoms at
    covalent distance that are not bonded and that a torsion moves apart: a sign that a bond is missing. Its attribute
    `note` holds all of them.

    Parameters
    ----------
    topology : openmm.app.Topology
        with the residue and atom names of the Protein Data Bank, as `openmm.app.PDBFile` gives them
    positions : array of shape (n, 3) or Quantity, optional
        nm. With them, a bond between residues that is longer than 0.4 nm is a gap: left out, so that the chain becomes
        two molecules. Molecules may be split over the periodic box of the Topology.
    radii : str or array of shape (n) or Quantity, optional
        "all-atom" (Word et al. 1999), "united-atom" (Tsai et al. 1999; hydrogens get radius 0), or a radius in nm for
        each atom. Default: for each molecule "all-atom" if it shows its hydrogens, else "united-atom".
    torsions : str or iterable of str, or iterable of Torsion, optional
        the kinds of torsions, as in `findTorsions`, or torsions that it returned: its `selection` chooses them.
        "rotatable" are all bonds in no ring. Default: "rotatable" if the `system` has the energies of a force field,
        else φ, ψ and χ.
    bondCutoff : int
        pairs up to this many bonds apart are excluded
    cutDisulfides : bool
        leave disulfide bonds out, so that the torsions between their ends can turn. The atoms stay excluded as if the
        bonds were there; nothing keeps the sulfurs together.
    cutMetals : bool
        the same for the bonds between metals and other residues
    forceGroup : int
        the force group of the force, of its own unless other forces use it
    unknownRadius : float or Quantity, optional
        the radius in nm of atoms of elements for which the set of radii has none. Default: they are an error.
    ballJoints : "bonds" or iterable of (int, int)
        pairs of bonded atoms, about the first of which the molecule turns freely; or "bonds" for all bonds that lie in
        no ring and have no torsion: each then turns about the atom that is nearer to the lowest-numbered one of its
        molecule, so that of a chain every bond can take any direction. Models of beads want ``torsions=()``,
        ``ballJoints="bonds"``, radii, and mostly ``bondCutoff=1``. Where a bead is fixed that is not the first of its
        molecule, give pairs that lead away from it.
    closures : "disulfides", "loops" or an iterable of these and of (int, int)
        bonds that close rings, or loops between fixed parts, and become closures (`StericExclusionForce.addClosure`):
        the torsions of their rings turn by closed moves, which keep them. "disulfides" are all that close a ring;
        "loops" are the last bonds, from C to N or O3' to P, of all rows of residues between those with `fixed` atoms.
        Default: "disulfides" if the `system` has the energies of a force field and they are not cut, else none.
    fixed : str, array of int or bool, or callable, optional
        atoms that are not to move, as in `findTorsions`, to which the System gives the mass 0 (given a `system`, a
        warning names those that have another one): torsions between two of them are left out. So
        ``fixed="not resSeq 20 to 30", closures="loops"`` samples a loop.
    system : openmm.System, optional
        to which the force will be added. What has mass 0 there, and is no virtual site, is fixed as well. Atoms without
        bonds in the Topology, such as beads or Drude particles, get those of its HarmonicBondForce, constraints and
        DrudeForce, or else of its CustomBondForce. If it has a NonbondedForce, CustomNonbondedForce or the like, all
        that turns is sampled by default, rings of disulfides too, and a warning says what bonds in no ring stay rigid.

    Returns
    -------
    StericExclusionForce

    Raises
    ------
    ValueError
        if an argument is out of range or of the wrong shape, an element has no radius, or bonds are ten times as long
        as bonds are, as if positions were in ångström
    TypeError
        if positions or radii have a unit that is not a length
    """
    if positions is not None:
        positions = positionsInNm(positions, topology.getNumAtoms())
    held = np.empty(0, dtype=int) if fixed is None else selectAtoms(topology, fixed)
    others, moving = [], []
    if system is not None:
        checkParticles(topology, system)
        massless = fixedParticles(system)
        moving = np.setdiff1d(held, massless).tolist()
        held = np.union1d(held, massless)
        others = bondsOfBareAtoms(topology, system)
    hasEnergies = system is not None and hasPairEnergies(system)
    if closures is None:
        closures = defaultClosures(hasEnergies, cutDisulfides)
    graph = BondGraph(topology, positions, cutDisulfides, cutMetals, closures, held, others)
    if torsions is None:
        torsions = KINDS_WITH_ENERGIES if hasEnergies else ("phi", "psi", "chi")
    search = _torsionsOf(graph, topology, torsions, held)
    force = makeForce(graph, search.torsions, radii, bondCutoff, forceGroup, unknownRadius)
    joints = _ballJointsOf(graph, search.torsions, ballJoints)
    for atom1, atom2 in joints:
        force.addBallJoint(atom1, atom2)
    notes = notesOnGeometry(graph, search.torsions) if not joints else []
    if hasEnergies and not joints:
        rigid = bondsThatStay(graph, search.torsions, held.tolist())
        notes += found([Note("bonds in no ring that stay rigid", map(graph.describePair, rigid))])
    notes += found([Note(_MOVING, [str(nameAtom(graph.atoms[atom])) for atom in moving])])
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
        for pair in _pairsAcross(graph.neighbors, atom1, atom2, bondCutoff):
            force.addExclusion(*pair)
    return force


def _radiiAndRoles(graph, radii, unknownRadius):
    if radii is None or isinstance(radii, str):
        if radii is None:
            radii = defaultRadii(graph)
        elif radii not in RADII_SETS:
            raise ValueError(f"{radii!r} is no set of radii; the sets are {', '.join(RADII_SETS)}")
        if unknownRadius is not None:
            unknownRadius = inUnit(unknownRadius, "nm", "unknownRadius")
        return particleRadii(graph, radii, unknownRadius), hydrogenBondRoles(graph, radii)
    values = np.asarray(inUnit(radii, "nm", "radii"), dtype=np.float64)
    if values.shape != (len(graph.atoms),):
        raise ValueError(f"radii must have the shape ({len(graph.atoms)},), not {values.shape}")
    return values, hydrogenBondRoles(graph, defaultRadii(graph))


def _ballJointsOf(graph, torsions, ballJoints):
    """Return pairs of atoms: those given, or all bonds that can be ball joints, each from the side of the root."""
    if not isinstance(ballJoints, str):
        return [(int(atom1), int(atom2)) for atom1, atom2 in ballJoints]
    if ballJoints != "bonds":
        raise ValueError(f'ballJoints must be "bonds" or pairs of atoms, not {ballJoints!r}')
    stiff = ringBonds(graph.neighbors) | {tuple(sorted(torsion.particles[1:3])) for torsion in torsions}
    joints, reached = [], [False] * len(graph.atoms)
    for root in range(len(graph.atoms)):
        pending = [] if reached[root] else [root]
        reached[root] = True
        while pending:
            atom = pending.pop()
            for other in graph.neighbors[atom]:
                if not reached[other]:
                    reached[other] = True
                    pending.append(other)
                    if (min(atom, other), max(atom, other)) not in stiff:
                        joints.append((atom, other))
    return sorted(joints)


def _torsionsOf(graph, topology, torsions, fixed):
    if not isinstance(torsions, str):
        torsions = tuple(torsions)
        if all(isinstance(torsion, Torsion) for torsion in torsions):
            return TorsionSearch(list(torsions), [])
    return withoutThoseBetween(searchTorsions(graph, topology, torsions), graph, fixed)


def notesOnGeometry(graph, torsions):
    """Return Notes on bonds that are too long, on atoms that lack a bond, and on residues that are but a Cα atom."""
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


def notesOnAlphaCarbons(graph):
    """Return a list of a Note on residues that are nothing but a Cα atom, empty without such."""
    residues = {atom.residue: None for atom in graph.atoms if aminoAcid(atom.residue.name) is not None}
    bare = [residue for residue in residues if isAlphaCarbonOnly(residue)]
    if bare and len(bare) == len(residues):
        return [Note("there is no torsion of a protein, because the model has only Cα atoms")]
    return found([Note("residues without torsions, because there are only their Cα atoms", map(describeResidue, bare))])


def notesOnTorsions(leftOut, remedies=_ARGUMENTS):
    """Return a Note for each reason why torsions are left out, but for what nobody expects to turn.

    Those next to a gap, and of residues that are but a Cα atom, have notes of their own. The remedies say by reason
    what could be done.
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
