"""The scene of a repair: soft spheres, torsions, and springs to the start."""

import numpy as np
import openmm
from openmm import unit
from scipy import sparse

from ..bonds import DISULFIDES, LOOPS, BondGraph
from ..graphs import connectedParts
from ..openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator
from ..residues import isPolymer, polymerBackbone
from ..scoring.contactatoms import ACCEPTOR, DONOR, contactAtoms
from ..torsions import searchTorsions, withoutThoseBetween
from .angles import dihedral

# nm: overlaps beyond the first are pushed apart, beyond the second they count as clashes while the repair runs, and
# beyond the third its last step makes none. MolProbity counts from 0.04, and from 0.06 in hydrogen bonds.
TOLERANCE, CLASHING, HARD_TOLERANCE = 0.033, 0.036, 0.0355
_HYDROGEN_BOND = 0.02

_FORCE_CONSTANT = 1e5  # kJ/mol/nm²
_PEPTIDE_STIFFNESS = 300  # kJ/mol/rad²
_WALL = 1e8  # kJ/mol/nm², beyond the largest shift
# nm: the length of a disulfide, and the range in which it stays as it is.
_DISULFIDE, _SHORTEST_DISULFIDE, _LONGEST_DISULFIDE = 0.205, 0.175, 0.22
_DISULFIDE_STIFFNESS = 2e4  # kJ/mol/nm²

BACKBONES = ("phi", "psi", "alpha", "beta", "gamma", "delta", "epsilon", "zeta")
_CARBON, _HYDROGEN = 6, 1


class Scene:
    """The atoms of a RepairModel in a Context that samples their torsions.

    topology : openmm.app.Topology; graph : BondGraph
    start, anchors : (n, 3) float64 arrays, nm, where the atoms begin, and where springs pull heavy atoms
    torsions : list of Torsion, by index in the force; residues : list of openmm.app.Residue; residueOf : (n,) int array
    isHeavy, isFixed : (n,) bool arrays; molecules : (n,) int array, the molecule of each atom
    links : (n,) int array, equal for atoms that no torsion moves relative to each other
    """

    def __init__(self, model, fixed=(), seed=1, maxShift=None, turnsLigands=False, holdsRotors=False):
        """Make the Context. Atoms of `fixed` do not move, nor do water, ions and ligands that are bound to no polymer.

        model : RepairModel; fixed : iterable of int; maxShift : float, nm, of any backbone atom
        turnsLigands : let free ligands move; holdsRotors : hold hydroxyl, thiol and ammonium groups
        """
        self.topology = model.topology
        self.start, self.anchors = model.start, model.anchors
        self.residues = list(self.topology.residues())
        self._readBonds(fixed, turnsLigands)
        self._chooseTorsions(holdsRotors)
        self._order = self._orderParticles()
        self._place = np.argsort(self._order)
        self._makeSystem(maxShift)
        self.integrator = TorsionMonteCarloIntegrator(300)
        self.integrator.setRandomNumberSeed(seed)
        self.integrator.setStericMode(self.integrator.Soft)
        platform = openmm.Platform.getPlatformByName("Reference")
        self.context = openmm.Context(self._system, self.integrator, platform)
        self.positions = self.start

    # ---- Bonds and torsions ----

    def _readBonds(self, fixed, turnsLigands):
        whole = BondGraph(self.topology, self.start)
        lengths = {pair: np.linalg.norm(self.anchors[pair[0]] - self.anchors[pair[1]]) for pair in whole.disulfides}
        self.open = [p for p in whole.disulfides if not _SHORTEST_DISULFIDE < lengths[p] < _LONGEST_DISULFIDE]
        self.notes = whole.notes
        self.residueOf = whole.residueOf
        self.isHeavy = whole.numbers > _HYDROGEN
        self.numbers = whole.numbers
        self.excluded = _pairsNearInBonds(whole)
        self.molecules = connectedParts(len(whole.atoms), whole.bonds)
        self.isFixed = self._heldAtoms(turnsLigands)
        self.isFixed[list(fixed)] = True
        closures = (DISULFIDES, LOOPS) if self.isFixed.any() else (DISULFIDES,)
        held = np.flatnonzero(self.isFixed)
        self.graph = BondGraph(self.topology, self.start, self.open, closures=closures, fixed=held)

    def _heldAtoms(self, turnsLigands):
        """Return whether each atom belongs to a molecule without a polymer, or to water or an ion in any case."""
        held = np.ones(len(self.molecules), dtype=bool)
        for residue in self.residues:
            first = next(residue.atoms()).index
            size = np.count_nonzero(self.molecules == self.molecules[first]) if turnsLigands else 0
            if isPolymer(residue) or size > 3:
                held[self.molecules == self.molecules[first]] = False
        return held

    def _chooseTorsions(self, holdsRotors):
        """Choose the torsions: of polymers, and rotatable ones of other residues. Methyl groups stay staggered."""
        others = [residue for residue in self.residues if not isPolymer(residue)]
        moving = [r for r in others if not self.isFixed[[atom.index for atom in r.atoms()]].all()]
        kinds = [*BACKBONES, "omega", "chi", *([] if holdsRotors else ["rotor"]), *(["rotatable"] if moving else [])]
        search = searchTorsions(self.graph, self.topology, kinds)
        search = withoutThoseBetween(search, self.graph, np.flatnonzero(self.isFixed))
        self.torsions = [
            torsion
            for torsion in search.torsions
            if not (torsion.kind == "rotor" and self.numbers[torsion.particles[2]] == _CARBON)
        ]
        self.kinds = np.array([torsion.kind for torsion in self.torsions], dtype="U8")
        self.residueOfTorsion = np.array([torsion.residue.index for torsion in self.torsions], dtype=int)
        axes = {tuple(sorted(torsion.particles[1:3])) for torsion in self.torsions}
        rigid = [bond for bond in self.graph.bonds if bond not in axes]
        self.links = connectedParts(len(self.numbers), rigid + [closure[1:3] for closure in self.graph.closures])

    # ---- Forces ----

    def _orderParticles(self):
        """Return the atoms in the order of particles: a backbone atom in the middle of each molecule comes first.

        The first particle of a molecule is its root, and a torsion moves the side without it.
        """
        backbones = {}
        for residue in self.residues:
            for atom in polymerBackbone(residue)[1:2]:
                backbones.setdefault(int(self.molecules[atom]), []).append(atom)
        isMiddle = np.zeros(len(self.molecules), dtype=bool)
        isMiddle[[atoms[len(atoms) // 2] for atoms in backbones.values()]] = True
        return np.concatenate([np.flatnonzero(isMiddle), np.flatnonzero(~isMiddle)])

    def _makeSystem(self, maxShift):
        self._system = openmm.System()
        for atom in self._order.tolist():
            self._system.addParticle(0 if self.isFixed[atom] else 1)
        self.force = self._makeSpheres()
        for force in (self._makeSprings(maxShift), self._holdPeptides(), self._mendDisulfides(), self.force):
            self._system.addForce(force)

    def _makeSpheres(self):
        seen = contactAtoms(self.topology, self.start)
        self.isDonor, self.isAcceptor = seen.flags & DONOR > 0, seen.flags & ACCEPTOR > 0
        force, place = StericExclusionForce(), self._place.tolist()
        force.setForceGroup(31)
        roles = np.where(self.isDonor, force.Donor, 0) | np.where(self.isAcceptor, force.Acceptor, 0)
        for atom in self._order.tolist():
            force.addParticle(float(seen.radii[atom]), int(roles[atom]))
        for first, second in self.graph.bonds:
            force.addBond(place[first], place[second])
        for torsion in self.torsions:
            force.addTorsion(*(place[atom] for atom in torsion.particles))
        for closure in self.graph.closures:
            force.addClosure(*(place[atom] for atom in closure))
        for first, second in self._place[self.excluded].tolist():
            force.addExclusion(first, second)
        force.setOverlapTolerance(TOLERANCE)
        force.setHydrogenBondAllowance(_HYDROGEN_BOND)
        force.setForceConstant(_FORCE_CONSTANT)
        return force

    def _makeSprings(self, maxShift):
        """Return a Force that pulls heavy atoms to their start, and backbone atoms also back below a largest shift."""
        wall = "" if maxShift is None else f" + 0.5*{_WALL}*wall*max(0, sqrt(d2)-{0.97 * maxShift})^2"
        force = openmm.CustomExternalForce(f"0.5*springs*d2{wall}; d2=(x-x0)^2+(y-y0)^2+(z-z0)^2")
        force.addGlobalParameter("springs", 1)
        for name in ("x0", "y0", "z0", *([] if maxShift is None else ["wall"])):
            force.addPerParticleParameter(name)
        backbone = {atom for residue in self.residues for atom in polymerBackbone(residue)}
        for particle, atom in enumerate(self._order.tolist()):
            if self.isHeavy[atom] and not self.isFixed[atom]:
                wall = [] if maxShift is None else [float(atom in backbone)]
                force.addParticle(particle, [*self.anchors[atom], *wall])
        return force

    def _holdPeptides(self):
        """Return a Force that holds each ω near its start."""
        force = openmm.CustomTorsionForce("0.5*stiffness*d^2; d=min(dt, 6.283185307179586-dt); dt=abs(theta-theta0)")
        force.addGlobalParameter("stiffness", _PEPTIDE_STIFFNESS)
        force.addPerTorsionParameter("theta0")
        for torsion in self.torsions:
            if torsion.kind == "omega":
                atoms = list(torsion.particles)
                force.addTorsion(*self._place[atoms].tolist(), [float(dihedral(self.anchors[atoms]))])
        return force

    def _mendDisulfides(self):
        """Return a Force that brings the sulfurs of disulfides that are too long or too short to their distance."""
        force = openmm.HarmonicBondForce()
        for pair in self.open:
            force.addBond(*self._place[list(pair)].tolist(), _DISULFIDE, _DISULFIDE_STIFFNESS)
        return force

    # ---- State ----

    @property
    def positions(self):
        """The positions (nm) of all atoms, an (n, 3) float64 array."""
        state = self.context.getState(positions=True)
        return state.getPositions(asNumpy=True).value_in_unit(unit.nanometer)[self._place]

    @positions.setter
    def positions(self, values):
        self.context.setPositions(values[self._order])

    def angles(self):
        """Return the values of all torsions (rad)."""
        return self.force.getTorsionAngles(self.context)

    def clashes(self):
        """Return the pairs of atoms that clash and that torsions or rigid motions move, and their overlaps (nm).

        The overlap of partners in a hydrogen bond is less what these may overlap more than others.
        """
        pairs, overlaps = self.force.getClashes(self.context)
        pairs = self._order[pairs].reshape(-1, 2)
        donors, acceptors = self.isDonor[pairs], self.isAcceptor[pairs]
        areBound = (donors[:, 0] & acceptors[:, 1]) | (donors[:, 1] & acceptors[:, 0])
        overlaps = overlaps - _HYDROGEN_BOND * areBound
        chosen = (overlaps > CLASHING) & (self.links[pairs[:, 0]] != self.links[pairs[:, 1]])
        chosen &= ~self.isFixed[pairs].all(axis=1)
        return pairs[chosen], overlaps[chosen]

    def setTolerance(self, tolerance, isHard):
        """Set the overlap (nm) that spheres may have, and whether trials beyond it are rejected."""
        self.force.setOverlapTolerance(tolerance)
        self.force.updateParametersInContext(self.context)
        self.integrator.setStericMode(self.integrator.Hard if isHard else self.integrator.Soft)

    def anneal(self, hot, cold, trials, springs, stages):
        """Run trials while the temperature falls from hot to cold (K), with springs (kJ/mol/nm²) to the start."""
        self.context.setParameter("springs", springs)
        self.integrator.setTrialsPerStep(max(1, trials // stages))
        for temperature in np.geomspace(hot, cold, stages).tolist():
            self.integrator.setTemperature(temperature)
            self.integrator.step(1)

    def rootsOfMovable(self):
        """Return a particle of each molecule that can move as a whole, largest molecules first."""
        molecules, sizes = np.unique(self.molecules, return_counts=True)
        held = set(self.molecules[self.isFixed].tolist())
        free = [(-size, molecule) for molecule, size in zip(molecules.tolist(), sizes.tolist(), strict=True)]
        firsts = [np.flatnonzero(self.molecules == molecule)[0] for _, molecule in sorted(free) if molecule not in held]
        return [int(self._place[first]) for first in firsts]


def _pairsNearInBonds(graph):
    """Return the pairs up to three bonds apart, and four with a hydrogen, as a sorted (m, 2) int array."""
    count = len(graph.atoms)
    first, second = np.array(graph.bonds, dtype=int).reshape(-1, 2).T
    ones = np.ones(2 * len(first), dtype=np.int32)
    shape = (count, count)
    step = sparse.csr_array((ones, (np.concatenate([first, second]), np.concatenate([second, first]))), shape=shape)
    step = step + sparse.eye_array(count, dtype=np.int32, format="csr")
    three = step @ step @ step
    found = []
    for reached, needsHydrogen in ((three.tocoo(), False), ((three @ step).tocoo(), True)):
        pairs = np.stack([reached.row, reached.col], axis=1)
        pairs = pairs[pairs[:, 0] < pairs[:, 1]]
        found.append(pairs[(graph.numbers[pairs] == _HYDROGEN).any(axis=1)] if needsHydrogen else pairs)
    return np.unique(np.concatenate(found), axis=0)
