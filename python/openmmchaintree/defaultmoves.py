"""Default mixtures of moves, with weights and sizes from measurements."""

from typing import NamedTuple

import openmm
from openmm import app

from .densities import ramachandranDensities, rotamerDensities
from .moveadder import HALF_TURN, AddedMoves, MoveAdder
from .movescene import MoveScene
from .openmmchaintree import TorsionMonteCarloIntegrator

_TORSION_STEP, _PIVOT_STEP, _BALL_STEP = 10, 1, 30  # degrees
_CLOSED_STEP, _CLOSED_PEPTIDE_STEP = 8, 2  # degrees
_BEND_STEP, _BEND_STIFFNESS = 4, 10000  # degrees, nm⁻²
_RIGID_STEP = 0.02, 2  # nm, degrees
_BOUND_STEP = 0.01, 1  # of molecules that touch others
_CHAIN_STEP = 0.1, 5  # of chains of beads
_FAR = 2  # nm, without a box
_RIGID_WEIGHT = 0.1  # to one for all torsions and joints
_MINOR = ("peptide bonds", "rotors", "planar groups")
_MINOR_SHARE = 0.1  # the largest share of trials, so that the other torsions move hardly more slowly


class _Weights(NamedTuple):
    """The weights of moves of folded backbones."""

    closed: float
    local: float
    ends: float
    endsDrawn: float
    pivots: float


class _BeadWeights(NamedTuple):
    """The weights of moves of beads: large and small pivots, and crankshafts."""

    pivots: float
    smallPivots: float
    crankshafts: float


_BEADS_ALONE, _BEADS_AMONG_CHAINS = _BeadWeights(0.72, 0.18, 0.1), _BeadWeights(0.15, 0.15, 0.7)

_NUCLEOTIDES = _Weights(0.6, 0.2, 0.15, 0, 0.05)


class _Ends(NamedTuple):
    """How often torsions at ends of chains get additional trials."""

    factor: float  # how much more often than other torsions they turn
    most: float  # their largest share of trials, since in a small protein they would take too many from its core


_ENDS_OF_BACKBONES, _ENDS_OF_SIDE_CHAINS = _Ends(5.4, 0.4), _Ends(2.7, 0.3)


def addDefaultMoves(
    integrator: TorsionMonteCarloIntegrator,
    topology: app.Topology,
    system: openmm.System,
    disordered: bool = False,
) -> AddedMoves:
    """Add moves that suit a System to an integrator: for proteins, nucleic acids, chains of beads, other molecules.

    The weights for folded proteins maximize the number of independent samples a second of torsions and of the RMSD in
    implicit solvent (benchmarks/moves.py); for loose chains and beads, of the radius of gyration. Backbones
    of proteins and nucleic acids get closed and local moves, which keep the rest of a chain in place, turns of the ends
    of chains, and few turns elsewhere. Side chains get small turns, and are drawn from the density of their rotamers:
    mostly from their first torsion on, which is the slowest. Side chains at the ends of chains are drawn more often,
    since their salt bridges hold loose ends. Bases, and torsions of other kinds, get small turns and are drawn
    uniformly. Ball joints get pivot and crankshaft moves. Molecules without fixed particles get rigid-body moves if
    there is more than one molecule; chains of beads also large ones, which exchange chains between phases. Around a
    solute in a periodic box, water and ions stay as they are.

    Sizes were chosen by measurement. Acceptance may be low: closed moves of up to 8 degrees gave more independent
    samples than smaller ones that were accepted twice as often. So let sizes adapt
    (`TorsionMonteCarloIntegrator.setAdaptMoveSizes`) only if hardly any trial of a move is accepted.

        print(addDefaultMoves(integrator, topology, system))

    Parameters
    ----------
    integrator : TorsionMonteCarloIntegrator
        the integrator, which keeps the moves that it has
    topology : openmm.app.Topology
        the Topology of the System
    system : openmm.System
        a System with a StericExclusionForce, whose torsions and ball joints get moves
    disordered : bool
        whether chains are loose, as in disordered proteins: then backbones are mostly drawn from the density of
        residues in loops, and get large turns

    Returns
    -------
    AddedMoves
        a list of (move, description, purpose), in the order in which moves were added; it prints as a table

    Raises
    ------
    ValueError
        if the System's particles and the Topology's atoms differ in number, if the System does not have exactly one
        StericExclusionForce, or if nothing can move
    """
    scene = MoveScene(topology, system)
    rigidBodies = scene.freeMolecules() if scene.moleculeCount > 1 else []
    return _addMixtures(integrator, scene, rigidBodies, _RIGID_STEP, disordered).added


def addMovesOfPlan(integrator, topology, system, torsions, rigidBodies, disordered):
    """Add the moves of `addDefaultMoves` for a list of Torsion, and for molecules by a particle of each.

    Return the NamedMoves in the order of their indices.
    """
    scene = MoveScene(topology, system, torsions)
    return _addMixtures(integrator, scene, rigidBodies, _BOUND_STEP, disordered).named


def _addMixtures(integrator, scene, rigidBodies, rigidStep, disordered):
    """Add moves for all torsions, ball joints and molecules; return the MoveAdder."""
    adder = MoveAdder(integrator, scene.findRings())
    shares = _sharesOf(scene)
    for group, (shortName, addMoves) in _MIXTURES.items():
        if scene.torsions[group]:
            adder.begin(shortName, shares[group])
            addMoves(adder, scene, group, disordered)
    if adder.inRings and not adder.hasClosed and scene.canClose(sorted(adder.inRings)):
        adder.begin("rings", sum(shares[group] for group in _MIXTURES))
        adder.close(1, _CLOSED_STEP, sorted(adder.inRings), "rings of closures")
    if scene.force.getNumBallJoints() > 0:
        adder.begin("beads", shares["beads"])
        _addBeads(adder, scene)
    if rigidBodies:
        adder.begin("rigid body", 1.0)
        _addRigidBodies(adder, scene, rigidBodies, rigidStep)
    if not adder.added:
        raise ValueError(
            "there is nothing to move: no ball joint, no second molecule, and no torsion outside loops and rings that "
            "have too few torsions for closed moves"
        )
    return adder


def _addBeads(adder, scene):
    """Add moves of ball joints: mostly pivots for a single chain, crankshafts where chains hinder each other."""
    weights = _BEADS_AMONG_CHAINS if scene.moleculeCount > 1 else _BEADS_ALONE
    hasPieces = scene.canTurnPieces()
    factor = 1 if hasPieces else 1 / (weights.pivots + weights.smallPivots)
    adder.pivot("chains of beads, all directions", factor * weights.pivots, HALF_TURN)
    adder.pivot("chains of beads where there is no room", factor * weights.smallPivots, _BALL_STEP)
    if hasPieces:
        adder.crank("chains of beads, piece by piece", weights.crankshafts, HALF_TURN)


def _addRigidBodies(adder, scene, molecules, step):
    if scene.force.getNumBallJoints() == 0:
        adder.shift("where molecules are", _RIGID_WEIGHT, *step, molecules)
        return
    adder.shift("where chains are", 0.5 * _RIGID_WEIGHT, *_CHAIN_STEP, molecules)
    farthest = round(0.5 * scene.boxLength, 3) if scene.boxLength else _FAR
    adder.shift("chains to anywhere", 0.5 * _RIGID_WEIGHT, farthest, HALF_TURN, molecules)


def _areMinor(scene):
    """Whether a force field is sampled in which other torsions than ω, rotors and planar groups get most trials."""
    others = sum(len(torsions) for name, torsions in scene.torsions.items() if name not in _MINOR)
    return scene.hasEnergies and others + scene.force.getNumBallJoints() > 0


def _sharesOf(scene):
    """Return the share of trials of each group of torsions, and of ball joints, by their numbers."""
    counts = {name: len(torsions) for name, torsions in scene.torsions.items()}
    counts["beads"] = scene.force.getNumBallJoints()
    total = max(1, sum(counts.values()))
    minor = sum(counts[name] for name in _MINOR)
    ofMinor = min(_MINOR_SHARE, minor / total) if _areMinor(scene) else minor / total
    shares = {}
    for name, count in counts.items():
        share, number = (ofMinor, minor) if name in _MINOR else (1 - ofMinor, total - minor)
        shares[name] = share * count / max(1, number)
    return shares


def _addPeptideBackbones(adder, scene, group, disordered):
    torsions = scene.torsions[group]
    if disordered:
        drawn = adder.findDrawn(ramachandranDensities, scene)
        adder.drawOrTurn("loose chains, by residue", "by residue", 0.4, drawn, torsions)
        adder.turn("loose chains, drawn uniformly", 0.3, HALF_TURN, torsions)
        adder.turn("loose chains, by some degrees", 0.2, 30, torsions)
        ringsAndBackbones = _ringsAndBackbones(adder, scene, torsions)
        if scene.canClose(ringsAndBackbones):
            adder.close(0.1, 20, ringsAndBackbones)
        return
    ends = adder.outsideRings(scene.endsOf(torsions))
    ofEnds = _shareOf(ends, torsions, _ENDS_OF_BACKBONES)
    others = 1 - ofEnds
    weights = _Weights(0.54 * others, 0.21 * others, 0.45 * ofEnds, 0.36 * ofEnds, 0.06 * others)
    _addFoldedBackbones(adder, scene, torsions, ends, weights)


def _shareOf(ends, torsions, moves):
    """Return the share of trials for _Ends moves of some of the torsions."""
    ratio = moves.factor * len(ends) / len(torsions)
    return min(moves.most, ratio / (1 + ratio))


def _ringsAndBackbones(adder, scene, torsions):
    """Return the torsions of closed moves: not ω in a force field, which is too stiff for windows of these sizes."""
    stiff = scene.torsions["peptide bonds"] if scene.hasEnergies else ()
    return sorted(adder.inRings.difference(stiff).union(torsions))


def _addFoldedBackbones(adder, scene, torsions, ends, weights):
    ringsAndBackbones = _ringsAndBackbones(adder, scene, torsions)
    canClose = scene.canClose(ringsAndBackbones)
    if canClose:
        adder.close(weights.closed, _CLOSED_STEP, ringsAndBackbones)
    adder.bend(weights.local + (0 if canClose else weights.closed), _BEND_STEP, _BEND_STIFFNESS, torsions)
    adder.turn("ends of chains", weights.ends, _TORSION_STEP, ends, "ends ")
    if weights.endsDrawn > 0:
        adder.turn("ends of chains, drawn uniformly", weights.endsDrawn, HALF_TURN, ends, "ends ")
    adder.turn("how parts of a chain lie to each other", weights.pivots, _PIVOT_STEP, torsions)


def _addSideChains(adder, scene, group, disordered):
    torsions = scene.torsions[group]
    ends = [] if disordered else adder.outsideRings(scene.endsOf(torsions))
    ofEnds = _shareOf(ends, torsions, _ENDS_OF_SIDE_CHAINS)
    ofAll = 1 - ofEnds
    drawn = adder.findDrawn(rotamerDensities, scene)
    behindOthers = {torsion for pair in drawn for torsion in pair[0][1:]}
    heads = [pair for pair in drawn if pair[0][0] not in behindOthers]
    tails = [pair for pair in drawn if pair[0][0] in behindOthers]
    adder.turn("side chains within a rotamer", 0.25 * ofAll, _TORSION_STEP, torsions)
    adder.drawOrTurn("side chains from rotamer to rotamer", "rotamers", 0.55 * ofAll, heads, torsions)
    adder.draw("ends of side chains from rotamer to rotamer", "outer rotamers", 0.2 * ofAll, tails)
    endTorsions = set(ends)
    atEnds = [pair for pair in drawn if not endTorsions.isdisjoint(pair[0])]
    adder.turn("side chains of ends of chains", 0.25 * ofEnds, _TORSION_STEP, ends, "of ends ")
    adder.draw("side chains of ends of chains, by rotamers", "of ends rotamers", 0.75 * ofEnds, atEnds)


def _addNucleotideBackbones(adder, scene, group, disordered):
    torsions = scene.torsions[group]
    if disordered:
        adder.turn("loose chains, by some degrees", 0.5, 30, torsions)
        adder.turn("loose chains, drawn uniformly", 0.5, HALF_TURN, torsions)
        return
    _addFoldedBackbones(adder, scene, torsions, adder.outsideRings(scene.endsOf(torsions)), _NUCLEOTIDES)


def _addPeptideBonds(adder, scene, group, disordered):
    torsions = scene.torsions[group]
    if not _areMinor(scene):
        _turnAndDraw(adder, "other torsions", torsions, _PIVOT_STEP)
        return
    ofRings = len(adder.inRings.intersection(torsions)) / len(torsions)
    backbones = sorted({*torsions, *scene.torsions["peptide backbones"]})
    if ofRings > 0 and scene.canClose(ringsAndBackbones := sorted(adder.inRings.union(backbones))):
        adder.close(ofRings, _CLOSED_PEPTIDE_STEP, ringsAndBackbones, "peptide bonds of rings")
    if ofRings < 1:
        adder.bend(0.6 * (1 - ofRings), _BEND_STEP, _BEND_STIFFNESS, backbones, "peptide bonds: the rest hardly moves")
        adder.turn("peptide bonds, by a little", 0.4 * (1 - ofRings), _PIVOT_STEP, torsions)


def _addOthers(adder, scene, group, disordered):
    _turnAndDraw(adder, group if group in ("bases", "planar groups") else "other torsions", scene.torsions[group])


def _addRotors(adder, scene, group, disordered):
    _turnAndDraw(adder, "rotors" if scene.hasEnergies else "other torsions", scene.torsions[group])


def _turnAndDraw(adder, words, torsions, step=_TORSION_STEP):
    adder.turn(f"{words}, by a little", 0.5, step, torsions)
    adder.turn(f"{words}, drawn uniformly", 0.5, HALF_TURN, torsions)


# The groups of torsions, with their short names in tables and the functions that add their moves.
_MIXTURES = {
    "peptide backbones": ("φ/ψ", _addPeptideBackbones),
    "side chains": ("χ", _addSideChains),
    "nucleotide backbones": ("α–ζ", _addNucleotideBackbones),
    "bases": ("χ of bases", _addOthers),
    "peptide bonds": ("ω", _addPeptideBonds),
    "rotors": ("rotor", _addRotors),
    "planar groups": ("planar", _addOthers),
    "others": ("others", _addOthers),
}
