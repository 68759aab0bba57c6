"""Finding the torsions of proteins and nucleic acids in a Topology."""

from collections.abc import Iterable
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from openmm import app
from openmm.app import Residue

from .bonds import BondGraph, Closures, polymerLinks
from .graphs import neighborLists, ringBonds
from .links import Links
from .naming import describeResidue
from .nearnames import didYouMean
from .residues import (
    CAPS,
    NUCLEOTIDE_BACKBONE,
    PEPTIDE_BACKBONE,
    aminoAcid,
    chiAtoms,
    glycosidicAtoms,
    isNucleotide,
)
from .rotatable import ROTATABLE, UNKNOWN_ORDER, RotatableBonds
from .selection import AtomSelection, selectAtoms
from .units import Array, positionsInNm

# Kinds of torsions that have no name of their own in IUPAC's rules.
_UNNAMED = ("planar", "other")

# The kinds that each word in a list of kinds means.
_KINDS = {
    "phi": ("phi",),
    "psi": ("psi",),
    "omega": ("omega",),
    "chi": ("chi1", "chi2", "chi3", "chi4", "chi"),
    **{kind: (kind,) for kind in ("chi1", "chi2", "chi3", "chi4", "rotor")},
    **{kind: (kind,) for kind in ("alpha", "beta", "gamma", "delta", "epsilon", "zeta")},
    **{kind: (kind,) for kind in _UNNAMED},
}
_KINDS["all"] = tuple(dict.fromkeys(kind for kinds in _KINDS.values() for kind in kinds))
KINDS = _KINDS["all"]
KINDS_WITH_ENERGIES = ("all",)
KIND_WORDS = (*_KINDS, ROTATABLE)

# Atoms of the residue itself, of the residue before it (-) and after it (+); IUPAC-IUB 1970 and 1983.
_PEPTIDE = {
    "phi": ("-C", "N", "CA", "C"),
    "psi": ("N", "CA", "C", "+N"),
    "omega": ("CA", "C", "+N", "+CA"),
}
_NUCLEOTIDE = {
    "alpha": ("-O3'", "P", "O5'", "C5'"),
    "beta": ("P", "O5'", "C5'", "C4'"),
    "gamma": ("O5'", "C5'", "C4'", "C3'"),
    "delta": ("C5'", "C4'", "C3'", "O3'"),
    "epsilon": ("C4'", "C3'", "O3'", "+P"),
    "zeta": ("C3'", "O3'", "+P", "+O5'"),
}
# The last two atoms of the glycosidic chi, O4'-C1'-…: purines, pyrimidines, pseudouridine.
_GLYCOSIDIC_ENDS = (("N9", "C4"), ("N1", "C2"), ("C5", "C4"))

# Atoms of caps that take the place of CA.
_CAP_CARBONS = {"ACE": ("CH3",), "NME": ("CH3", "C")}

RING = "in a ring"
DISULFIDE_RING = "in a ring that disulfide bonds close"
METAL_RING = "in a ring that bonds of metals close"
PROLINE_RING = "in the ring of proline"
SUGAR_RING = "in the ring of the sugar"
BETWEEN_FIXED = "between two fixed parts"
FIXED = "about a bond between fixed atoms"
# Reasons that need no note, since nobody expects these torsions to turn.
QUIET_REASONS = (PROLINE_RING, SUGAR_RING, FIXED)


class Torsion(NamedTuple):
    """A rotation about the bond particles[1]–particles[2]."""

    particles: tuple[int, int, int, int]
    kind: str
    residue: Residue


class LeftOutTorsion(NamedTuple):
    """A torsion of a requested kind that cannot turn."""

    kind: str
    residue: Residue
    reason: str
    nextToGap: bool = False


class TorsionSearch(NamedTuple):
    """The result of `findTorsions`: the torsions, and the torsions that were left out, each with the reason."""

    torsions: list[Torsion]
    leftOut: list[LeftOutTorsion]


def findTorsions(
    topology: app.Topology,
    positions: Array | None = None,
    kinds: str | Iterable[str] = ("phi", "psi", "chi"),
    cutDisulfides: bool = False,
    cutMetals: bool = False,
    selection: AtomSelection | None = None,
    fixed: AtomSelection | None = None,
    closures: Closures = (),
) -> TorsionSearch:
    """Find the torsions of the amino acids and nucleotides of a Topology.

    Particles are in the order of IUPAC: their dihedral is φ, ψ, ω, χ1 … χ4, α … ζ or the glycosidic χ of the residue. A
    bond in a ring is never a torsion. The first φ and the last ψ and ω of a chain do not exist. Residues of unknown
    name have backbone torsions if they have the atoms, and χ if they are nucleotides in a chain.

    Parameters
    ----------
    topology : openmm.app.Topology
        with the residue and atom names of the Protein Data Bank, as `openmm.app.PDBFile` gives them. The names of
        protonation variants in Amber and CHARMM (HID, HIE, HIP, CYX, CYM, ASH, GLH, LYN, …) are known.
    positions : array of shape (n, 3) or Quantity, optional
        nm. With them, a bond between residues that is longer than 0.4 nm is a gap in the chain, not a bond.
    kinds : str or iterable of str
        any of phi, psi, omega, chi (chi1 … chi4, and chi of nucleotides), chi1, chi2, chi3, chi4; alpha, beta, gamma,
        delta, epsilon, zeta of nucleic acids; rotor (methyl, hydroxyl, thiol and amine groups, turned by a hydrogen);
        planar (other bonds between a trigonal carbon and a nitrogen, as of amides at the end of side chains, of
        guanidinium, and of amino groups of bases); other (all other bonds outside rings that have atoms beyond both
        ends, also in ligands); all for all of these, which are all bonds outside rings; or rotatable for
        rotatable bonds as in chemistry: single bonds that are neither terminal (one end binds no other
        heavy atom, as of methyl and hydroxyl groups) nor conjugated as in amides (between a carbon with a double bond
        to N, O or S and another N, O or S: amides with ω, esters, guanidinium). Bond orders come from the
        Topology, else from the chemical component dictionary (of biotite); bonds of unknown order are left out.
    cutDisulfides, cutMetals : bool
        treat disulfides, or the bonds between metals and other residues, as if they were not bonds
    selection : str, array of int or bool, or callable, optional
        the atoms whose torsions are wanted, as in `selectAtoms`. A torsion belongs to its third particle: φ to CA, ψ to
        C, ω to the next N, χ1 to CB, χ2 to the atom after it, and so on; α to O5', β to C5', γ to C4', δ to C3', ε to
        O3', ζ to the next P, χ of nucleotides to the atom of the base. So "backbone" selects φ and ψ, "sidechain" all
        χ, and "resSeq 10 to 20" all torsions of these residues. Default: all.
    fixed : str, array of int or bool, or callable, optional
        atoms that must not move, which have the mass 0 in the System. Torsions between two fixed atoms that are not in
        one rigid part, as in a backbone between fixed ends, are left out.
    closures : "disulfides", "loops" or an iterable of these and of (int, int), optional
        bonds that close rings, or loops between fixed parts, and that closed moves keep, as in
        `createStericExclusionForce`. A ring that one of them closes does not count as a ring, nor a loop as lying
        between fixed parts. A torsion next to such a bond has another particle instead of the one beyond the bond, so
        that its value differs from IUPAC's.

    Returns
    -------
    TorsionSearch
        torsions: list of (particles, kind, residue), in the order of residues; leftOut: list of (kind, residue,
        reason, nextToGap), for rings, gaps, missing atoms and fixed parts

    Raises
    ------
    ValueError
        if a kind is unknown, positions have the wrong shape or a wrong unit, or a selection selects nothing
    TypeError
        if positions have a unit that is not a length
    """
    if positions is not None:
        positions = positionsInNm(positions, topology.getNumAtoms())
    held = np.empty(0, dtype=int) if fixed is None else selectAtoms(topology, fixed)
    graph = BondGraph(topology, positions, cutDisulfides, cutMetals, closures, held)
    search = searchTorsions(graph, topology, kinds)
    if selection is not None:
        search = ofAtoms(search, selectAtoms(topology, selection))
    return withoutThoseBetween(search, graph, held)


def searchTorsions(graph, topology, kinds):
    """Do the work of `findTorsions` on a BondGraph of the topology."""
    kinds, areRotatable = _expandKinds(kinds)
    search = _Search(graph, topology)
    hasUnnamed = areRotatable or not kinds.isdisjoint(_UNNAMED)  # to find these, all other kinds must be known
    for residue in topology.residues():
        search.addResidue(residue, set(KINDS) if hasUnnamed else kinds)
    if hasUnnamed:
        search.addUnnamed()
    torsions = [torsion for torsion in search.torsions if torsion.kind in kinds]
    leftOut = [left for left in search.leftOut if left.kind in kinds]
    if areRotatable:
        return _withRotatable(TorsionSearch(torsions, leftOut), search, RotatableBonds(graph, topology))
    return TorsionSearch(torsions, leftOut)


def _withRotatable(chosen, search, bonds):
    """Return a TorsionSearch with the torsions of a _Search about RotatableBonds as well, in its order."""
    kept = {torsion.particles for torsion in chosen.torsions}
    torsions, leftOut = [], list(chosen.leftOut)
    for torsion in search.torsions:
        isRotatable = torsion.particles in kept or bonds.has(torsion)
        if isRotatable:
            torsions.append(torsion)
        elif isRotatable is None:
            leftOut.append(LeftOutTorsion(torsion.kind, torsion.residue, UNKNOWN_ORDER))
    return TorsionSearch(torsions, leftOut)


def ofAtoms(search, atoms):
    """Return a TorsionSearch with only the torsions whose third particle is one of the atoms.

    Of torsions that were left out, whose particles are unknown, it keeps torsions of residues that have such an atom.
    """
    chosen = set(atoms.tolist())
    torsions = [torsion for torsion in search.torsions if torsion.particles[2] in chosen]
    leftOut = [left for left in search.leftOut if any(atom.index in chosen for atom in left.residue.atoms())]
    return TorsionSearch(torsions, leftOut)


def withoutThoseBetween(search, graph, fixed):
    """Return a TorsionSearch that leaves out torsions with fixed atoms, an array of indices, on both sides."""
    if len(fixed) == 0:
        return search
    between = Links(graph, search.torsions).torsionsBetween(fixed).tolist()
    turning = [torsion for torsion, isBetween in zip(search.torsions, between, strict=True) if not isBetween]
    stuck = [torsion for torsion, isBetween in zip(search.torsions, between, strict=True) if isBetween]
    held = set(fixed.tolist())
    reasons = [FIXED if held.issuperset(torsion.particles[1:3]) else BETWEEN_FIXED for torsion in stuck]
    leftOut = [
        LeftOutTorsion(torsion.kind, torsion.residue, reason) for torsion, reason in zip(stuck, reasons, strict=True)
    ]
    return TorsionSearch(turning, search.leftOut + leftOut)


def _expandKinds(kinds):
    """Return the kinds that words mean, and whether the rotatable ones of all kinds are among them."""
    words = (kinds,) if isinstance(kinds, str) else tuple(kinds)
    for word in words:
        if word not in KIND_WORDS:
            near = didYouMean(word, KIND_WORDS)
            raise ValueError(f"{word!r} is not a kind of torsion; the kinds are {', '.join(KIND_WORDS)}{near}")
    return {kind for word in words for kind in _KINDS.get(word, ())}, ROTATABLE in words


class _Search:
    """One search: the lookups that finding a torsion needs, and what was found."""

    def __init__(self, graph, topology):
        self.torsions = []
        self.leftOut = []
        self._graph = graph
        self._rings = self._findRings(graph)
        self._atoms = [_atomsByName(residue) for residue in topology.residues()]
        self._gapAfter = {gap.residue1.index: gap for gap in graph.gaps}
        self._gapBefore = {gap.residue2.index: gap for gap in graph.gaps}
        self._previous, self._next = self._linkedResidues()

    @staticmethod
    def _findRings(graph):
        """Return for each bond in a ring the reason why it does not turn."""
        disulfides, metalBonds = set(graph.disulfides), set(graph.metalBonds)
        closing = disulfides | metalBonds
        kinds = [(RING, set()), (DISULFIDE_RING, disulfides), (METAL_RING, metalBonds)]
        if disulfides and metalBonds:  # rings that need both
            kinds.append((METAL_RING, closing))
        found = {}
        for reason, bonds in [kinds[0], *(kind for kind in kinds[1:] if kind[1])]:
            kept = [bond for bond in graph.bonds if bond not in closing or bond in bonds]
            for bond in ringBonds(neighborLists(len(graph.atoms), kept)):
                found.setdefault(bond, reason)
        return found

    def _linkedResidues(self):
        """Return two dicts: the residues before and after each residue in its polymer, by bonds."""
        previous, following = {}, {}
        bonds = [*self._graph.bonds, *(closure[1:3] for closure in self._graph.closures)]
        for first, second in polymerLinks(self._graph.atoms, bonds):
            previous[second.residue.index] = first.residue
            following[first.residue.index] = second.residue
        return previous, following

    def addResidue(self, residue, kinds):
        amino = aminoAcid(residue.name)
        if residue.name in CAPS:
            self._addPolymerTorsions(residue, {"omega": _PEPTIDE["omega"]}, kinds)
        elif amino is not None or self._hasInARow(residue, PEPTIDE_BACKBONE):
            self._addPolymerTorsions(residue, _PEPTIDE, kinds)
        if amino is not None:
            for number, names in enumerate(chiAtoms(amino), start=1):
                if f"chi{number}" in kinds:
                    self._addInternal(f"chi{number}", residue, names)
        nucleotide = isNucleotide(residue.name) or self._isModifiedNucleotide(residue)
        if nucleotide:
            self._addPolymerTorsions(residue, _NUCLEOTIDE, kinds)
            if "chi" in kinds:
                self._addInternal("chi", residue, [(name,) for name in self._glycosidicAtoms(residue)])
        if "rotor" in kinds and (amino is not None or nucleotide or residue.name in CAPS):
            self._addRotors(residue)

    def _hasInARow(self, residue, names):
        """Whether a residue, perhaps of an unknown name, has atoms of these names, each bonded to the next."""
        atoms = self._atoms[residue.index]
        if not all(name in atoms for name in names):
            return False
        return all(atoms[other] in self._graph.neighbors[atoms[name]] for name, other in pairwise(names))

    def _isModifiedNucleotide(self, residue):
        """Whether a residue is a modified nucleotide in a chain: ligands such as ATP have no neighbor."""
        isLinked = residue.index in self._previous or residue.index in self._next
        return isLinked and self._hasInARow(residue, NUCLEOTIDE_BACKBONE)

    def _glycosidicAtoms(self, residue):
        """Return the names of the atoms of chi: by the residue's name or, in a modified nucleotide, by its bonds."""
        if isNucleotide(residue.name):
            return glycosidicAtoms(residue.name)
        for end in _GLYCOSIDIC_ENDS:
            if self._hasInARow(residue, ("O4'", "C1'", *end)):
                return ("O4'", "C1'", *end)
        return ()

    def _addPolymerTorsions(self, residue, table, kinds):
        """Add torsions that may reach into the residues before and after."""
        for kind, names in table.items():
            if kind in kinds:
                self._addPolymerTorsion(kind, residue, names)

    def _addPolymerTorsion(self, kind, residue, names):
        particles = []
        for name in names:
            holder, gap = self._holderOf(name, residue)
            name = name.lstrip("+-")
            if holder is None:
                if gap is not None:
                    self._leaveOut(kind, residue, f"next to a gap in the chain: {gap.reason}", nextToGap=True)
                return
            if name not in self._atoms[holder.index]:
                self._noteMissingAtom(kind, residue, holder, name)
                return
            particles.append(self._atoms[holder.index][name])
        self._add(kind, residue, particles)

    def _holderOf(self, name, residue):
        """Return the residue that holds an atom of a table above, or None, and the gap next to it."""
        if name[0] == "-":
            return self._previous.get(residue.index), self._gapBefore.get(residue.index)
        if name[0] == "+":
            return self._next.get(residue.index), self._gapAfter.get(residue.index)
        return residue, None

    def _noteMissingAtom(self, kind, residue, holder, name):
        # The 5' end of a nucleic acid has no phosphate: its alpha and beta do not exist.
        if name == "P" and holder is residue and residue.index not in self._previous:
            return
        # A torsion that lacks an atom in a cap is no torsion of a residue.
        if residue.name in CAPS or holder.name in CAPS:
            return
        self._leaveOut(kind, residue, f"atom {name} of {describeResidue(holder)} is missing")

    def _addInternal(self, kind, residue, alternatives):
        """Add a torsion whose atoms all lie in one residue."""
        atoms = self._atoms[residue.index]
        particles = []
        for names in alternatives:
            atom = next((atoms[name] for name in names if name in atoms), None)
            if atom is None:
                self._leaveOut(kind, residue, f"atom {names[0]} of {describeResidue(residue)} is missing")
                return
            particles.append(atom)
        if particles:
            self._add(kind, residue, particles)

    def _addRotors(self, residue):
        """Add groups whose rotation moves only hydrogens: XH or XH3 at the end of a branch, and neutral amines."""
        graph = self._graph
        for end in [atom.index for atom in residue.atoms()]:
            heavy, hydrogens = graph.heavyNeighborsOf(end), graph.hydrogensOf(end)
            if len(heavy) != 1 or not hydrogens:
                continue
            axis = heavy[0]
            element, count = graph.elementNumber(end), len(hydrogens)
            isAmine = element == 7 and count == 2 and len(graph.neighbors[axis]) == 4
            if isAmine or (element, count) in {(6, 3), (7, 3), (8, 1), (16, 1)}:
                before = sorted(other for other in graph.heavyNeighborsOf(axis) if other != end)
                if before:
                    self._add("rotor", residue, [before[0], axis, end, min(hydrogens)])

    def addUnnamed(self):
        """Add the bonds that could turn and have no torsion yet."""
        graph = self._graph
        for atom1, atom2 in bondsWithoutTorsions(graph, self.torsions):
            kind = "planar" if self._isPlanar(atom1, atom2) or self._isPlanar(atom2, atom1) else "other"
            particles = (min(graph.beyond(atom1, atom2)), atom1, atom2, min(graph.beyond(atom2, atom1)))
            self.torsions.append(Torsion(particles, kind, graph.atoms[atom2].residue))

    def _isPlanar(self, carbon, nitrogen):
        """Whether a bond is one between a trigonal carbon and a nitrogen."""
        graph = self._graph
        elements = graph.elementNumber(carbon), graph.elementNumber(nitrogen)
        return elements == (6, 7) and len(graph.neighbors[carbon]) == 3

    def _add(self, kind, residue, particles):
        neighbors = self._graph.neighbors
        particles = self._besideClosures(particles)
        for atom, other in pairwise(particles):
            if other not in neighbors[atom]:
                names = [self._graph.atoms[particle].name for particle in (atom, other)]
                self._leaveOut(kind, residue, f"{names[0]} and {names[1]} are not bonded")
                return
        axis = (min(particles[1:3]), max(particles[1:3]))
        if kind == "phi" and aminoAcid(residue.name) == "PRO":
            self._leaveOut(kind, residue, PROLINE_RING)
        elif kind == "delta" and self._rings.get(axis) == RING:
            self._leaveOut(kind, residue, SUGAR_RING)
        elif axis in self._rings:
            self._leaveOut(kind, residue, self._rings[axis])
        else:
            self.torsions.append(Torsion(tuple(particles), kind, residue))

    def _besideClosures(self, particles):
        """Return the particles of a torsion, with one beyond a closure replaced by another on the same side."""
        closing = {frozenset(closure[1:3]) for closure in self._graph.closures}
        particles = list(particles)
        for beyond, end, inner in ((0, 1, 2), (3, 2, 1)):
            if frozenset((particles[beyond], particles[end])) in closing:
                others = [other for other in self._graph.neighbors[particles[end]] if other != particles[inner]]
                particles[beyond] = min(others, default=particles[beyond])
        return particles

    def _leaveOut(self, kind, residue, reason, nextToGap=False):
        self.leftOut.append(LeftOutTorsion(kind, residue, reason, nextToGap))


def bondsWithoutTorsions(graph, torsions):
    """Return the bonds of a BondGraph that could turn but have no Torsion, as sorted pairs.

    They lie in no ring and have atoms beyond both ends; extra particles count only beyond an extra particle.
    """
    excluded = ringBonds(graph.neighbors).union(tuple(sorted(torsion.particles[1:3])) for torsion in torsions)
    return [bond for bond in graph.bonds if bond not in excluded and graph.beyond(*bond) and graph.beyond(*bond[::-1])]


def bondsThatStay(graph, torsions, fixed):
    """Return the bonds of `bondsWithoutTorsions`, without bonds between two atoms of `fixed`, an iterable."""
    held = set(fixed)
    return [bond for bond in bondsWithoutTorsions(graph, torsions) if not held.issuperset(bond)]


def _atomsByName(residue):
    atoms = {atom.name: atom.index for atom in residue.atoms()}
    for name in _CAP_CARBONS.get(residue.name, ()):
        if name in atoms:
            atoms.setdefault("CA", atoms[name])
    return atoms
