"""Repairing structures from Python: what moves, what stays, and how far."""

import numpy as np
import pytest
from openmm import app, unit
from openmmchaintree import InputError, createStericExclusionForce, repairStructure, selectAtoms
from openmmchaintree.bonds import BondGraph
from openmmchaintree.contexts import contextOf
from openmmchaintree.repairs.carrying import carryAlong
from openmmchaintree.repairs.defects import findDefects
from openmmchaintree.scoring.clashscore import clashscore
from openmmchaintree.scoring.protonation import withHydrogens
from openmmchaintree.structures.structure import readStructure
from openmmchaintree.torsions import searchTorsions
from repairmodels import villinPacked


@pytest.fixture(scope="module")
def packed():
    return villinPacked()


@pytest.fixture(scope="module")
def repaired(packed):
    return repairStructure(*packed)


def named(topology, *names):
    return [atom.index for atom in topology.atoms() if atom.name in names]


def test_clashesGo(packed, repaired):
    topology, positions = packed
    assert repaired.clashscoreBefore > 20
    assert repaired.clashscoreAfter <= 2 and repaired.isClean
    # The scores are those of the positions, with hydrogens placed for them.
    for given, score in ((positions, repaired.clashscoreBefore), (repaired.positions, repaired.clashscoreAfter)):
        protonated = withHydrogens(topology, given)
        assert clashscore(protonated.topology, protonated.positions).score == score


def test_bondsAndAnglesStay(packed, repaired):
    """All distances of atoms up to two bonds apart, also of the hydrogens that were given."""
    topology, positions = packed
    graph = BondGraph(topology, positions)
    pairs = set(graph.bonds)
    for near in graph.neighbors:
        pairs |= {(first, second) for first in near for second in near if first < second}
    first, second = np.array(sorted(pairs)).T
    before = np.linalg.norm(positions[first] - positions[second], axis=1)
    after = np.linalg.norm(repaired.positions[first] - repaired.positions[second], axis=1)
    assert np.abs(after - before).max() < 1e-9


def test_shiftsAreThoseOfThePositions(packed, repaired):
    topology, positions = packed
    shifts = np.linalg.norm(repaired.positions - positions, axis=1)
    changes = repaired.changes
    traces = shifts[named(topology, "CA")]
    assert changes.traceRms == pytest.approx(np.sqrt((traces**2).mean()), abs=1e-12)
    assert changes.traceLargest == pytest.approx(traces.max(), abs=1e-12)
    assert changes.traceRms < 0.04
    heavy = [atom.index for atom in topology.atoms() if atom.element is not app.element.hydrogen]
    assert changes.rms == pytest.approx(np.sqrt((shifts[heavy] ** 2).mean()), abs=1e-12)
    assert len(changes.residues) == topology.getNumResidues()
    assert 0 < changes.rotamersChanged < changes.rotamers


def test_sameSeedSameResult(packed, repaired):
    assert np.array_equal(repairStructure(*packed).positions, repaired.positions)
    assert not np.array_equal(repairStructure(*packed, seed=2).positions, repaired.positions)


def test_aCleanModelStays():
    villin = readStructure()
    result = repairStructure(villin.topology, villin.positions)
    assert result.clashscoreAfter <= result.clashscoreBefore
    assert result.changes.traceRms < 0.01


def test_units(packed, repaired):
    topology, positions = packed
    result = repairStructure(topology, (10 * positions) * unit.angstrom, maxShift=3 * unit.angstrom)
    assert result.clashscoreAfter <= 2


def test_fixedAtomsKeepAllTheirBits(packed):
    topology, positions = packed
    fixed = "resSeq 5 to 18"
    result = repairStructure(topology, positions, fixed=fixed)
    chosen = selectAtoms(topology, fixed)
    assert np.array_equal(result.positions[chosen], positions[chosen])
    assert result.clashesAfter < result.clashesBefore
    moved = np.flatnonzero((result.positions != positions).any(axis=1))
    assert len(moved) > 0


def test_onlyChosenAtomsMove(packed):
    topology, positions = packed
    chosen = selectAtoms(topology, "resSeq 12 to 25")
    result = repairStructure(topology, positions, move=chosen)
    moved = np.flatnonzero((result.positions != positions).any(axis=1))
    assert len(moved) > 0 and set(moved.tolist()) <= set(chosen.tolist())


def test_sideChainsAlone(packed):
    topology, positions = packed
    result = repairStructure(topology, positions, sideChainsOnly=True)
    backbone = named(topology, "N", "CA", "C", "O", "CB")
    assert np.array_equal(result.positions[backbone], positions[backbone])
    assert result.clashesAfter < result.clashesBefore / 2


def test_theLargestShift(packed):
    topology, positions = packed
    result = repairStructure(topology, positions, maxShift=0.01)
    assert result.changes.traceLargest <= 0.01


def test_hydrogensFollow(packed, repaired):
    """A model without hydrogens is repaired as well as one with them, to the same places."""
    topology, positions = packed
    heavy = [atom for atom in topology.atoms() if atom.element is not app.element.hydrogen]
    modeller = app.Modeller(topology, positions * unit.nanometer)
    modeller.delete([atom for atom in topology.atoms() if atom.element is app.element.hydrogen])
    result = repairStructure(modeller.topology, modeller.positions)
    assert len(result.positions) == len(heavy)
    assert np.allclose(result.positions, repaired.positions[[atom.index for atom in heavy]], atol=1e-9)


@pytest.mark.parametrize(
    "change, message",
    [
        ({"seed": 0}, "seed must be from 1"),
        ({"maxShift": 0}, "maxShift must be above 0"),
        ({"maxShift": float("nan")}, "maxShift must be above 0"),
        ({"fixed": "all"}, "nothing may move"),
        ({"interface": ("A", "Q")}, "there is no chain 'A'"),
        ({"move": "resSeq 1000"}, "selects no atom"),
    ],
)
def test_wrongArguments(packed, change, message):
    with pytest.raises(ValueError, match=message):
        repairStructure(*packed, **change)


@pytest.mark.parametrize(
    "names, message", [({"CA"}, "only Cα atoms"), ({"N", "CA", "C", "O", "H", "HA", "CB"}, "no side chains")]
)
def test_incompleteModels(names, message):
    villin = readStructure()
    modeller = app.Modeller(villin.topology, villin.positions * unit.nanometer)
    modeller.delete([atom for atom in villin.topology.atoms() if atom.name not in names])
    with pytest.raises(InputError, match=message):
        repairStructure(modeller.topology, modeller.positions)


def test_waterAloneIsRefused():
    topology = app.Topology()
    topology.addAtom("O", app.element.oxygen, topology.addResidue("HOH", topology.addChain()))
    with pytest.raises(InputError, match="no protein and no nucleic acid"):
        repairStructure(topology, np.zeros((1, 3)))


# ---- Defects ----


def defectsAt(positions, topology):
    graph = BondGraph(topology, positions)
    return findDefects(topology, positions, searchTorsions(graph, topology, ["omega"]).torsions)


def test_aSoundModelHasNoDefects():
    villin = readStructure()
    assert defectsAt(villin.positions, villin.topology) == []


def test_defectsAreNamed():
    villin = readStructure()
    positions = villin.positions.copy()
    lysine = next(residue for residue in villin.topology.residues() if residue.name == "LYS")
    atoms = {atom.name: atom.index for atom in lysine.atoms()}
    shift = positions[atoms["NZ"]] - positions[atoms["CE"]]
    for name in ("NZ", "HZ1", "HZ2", "HZ3"):
        positions[atoms[name]] += 0.4 * shift
    (defect,) = defectsAt(positions, villin.topology)
    assert defect.kind == "broken bond" and "CE" in defect.text and "NZ" in defect.text
    force = createStericExclusionForce(villin.topology, villin.positions, torsions="omega")
    context = contextOf(force)
    context.setPositions(villin.positions)
    angles = force.getTorsionAngles(context)
    angles[10] += np.pi / 2
    force.setTorsionAngles(context, (angles + np.pi) % (2 * np.pi) - np.pi)
    twisted = context.getState(positions=True).getPositions(asNumpy=True)._value
    kinds = [defect.kind for defect in defectsAt(twisted, villin.topology)]
    assert "twisted peptide" in kinds


def test_pointsFollowTheirAtoms():
    """Points that follow a rigid motion of four atoms make it, too."""
    random = np.random.default_rng(1)
    start, points = random.normal(size=(4, 3)), random.normal(size=(2, 3))
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    end = start @ turn.T + 5
    neighbors = [[1], [0, 2, 3], [1], [1]]
    followed = carryAlong(neighbors, start, end, np.array([0, 1]), points)
    assert np.allclose(followed, points @ turn.T + 5, atol=1e-12)
    alone = carryAlong([[]], start[:1], end[:1], np.array([0]), points[:1])
    assert np.allclose(alone, points[:1] + end[0] - start[0])


# ---- Broken bonds, and chains through one another ----


def test_brokenBondsAreMended(packed):
    """Ends of a lysine and a peptide bond that are far too long: all bonds of other residues keep their lengths."""
    topology, positions = packed
    positions = positions.copy()
    residues = list(topology.residues())
    lysine = next(residue for residue in residues if residue.name == "LYS")
    atoms = {atom.name: atom.index for atom in lysine.atoms()}
    shift = positions[atoms["NZ"]] - positions[atoms["CE"]]
    for name in ("NZ", "HZ1", "HZ2", "HZ3"):
        positions[atoms[name]] += 0.4 * shift
    second = {atom.name: atom.index for atom in residues[20].atoms()}
    before = {atom.name: atom.index for atom in residues[19].atoms()}
    apart = positions[second["N"]] - positions[before["C"]]
    later = [atom.index for atom in topology.atoms() if atom.residue.index >= 20]
    positions[later] += 0.4 * apart
    result = repairStructure(topology, positions, mendsBonds=True)
    assert len(result.mendedBonds) == 2
    assert not [text for text in result.defects if text.startswith("broken bond")]
    assert result.clashscoreAfter <= 2
    for first, last, length in ((atoms["CE"], atoms["NZ"], 0.149), (before["C"], second["N"], 0.133)):
        assert np.linalg.norm(result.positions[first] - result.positions[last]) == pytest.approx(length, abs=0.003)
    mended = {lysine.index, 19, 20}
    graph = BondGraph(topology, positions)
    pairs = [pair for pair in graph.bonds if mended.isdisjoint(graph.residueOf[list(pair)].tolist())]
    first, last = np.array(pairs).T
    lengths = [np.linalg.norm(place[first] - place[last], axis=1) for place in (positions, result.positions)]
    assert np.abs(lengths[1] - lengths[0]).max() < 1e-9
    kept = repairStructure(topology, positions)
    assert [text for text in kept.defects if text.startswith("broken bond")] and kept.mendedBonds == []


def test_chainsThroughOneAnotherPart():
    villin = readStructure()
    modeller = app.Modeller(villin.topology, villin.positions * unit.nanometer)
    modeller.add(villin.topology, (villin.positions + [1.4, 0, 0]) * unit.nanometer)
    result = repairStructure(modeller.topology, modeller.positions)
    assert result.clashscoreBefore > 80
    assert result.clashscoreAfter <= 2
