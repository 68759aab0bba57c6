"""MolProbity's clashscore, against Probe's own answers and dots that are counted one by one."""

import numpy as np
import pytest
from openmm import app
from openmmchaintree.scoring.clashscore import clashscore
from openmmchaintree.scoring.contactatoms import contactAtoms
from openmmchaintree.scoring.dotcontacts import dotSphere
from openmmchaintree.structures.structure import readStructure

# Probe 2.26's clashes of the villin headpiece of OpenMM's package, shrunk by 5%: pairs, and their overlaps in angstrom.
_SHRUNK = """\
9.CG2 10.CD2 0.420
9.HG21 10.CD2 0.480
10.CD1 32.HE2 0.480
10.CE1 28.HB1 0.409
10.CE1 32.HE2 0.636
17.CE1 25.HG2 0.458
21.HD1 24.HD1 0.468
"""


def topologyOf(*residues):
    """Return a Topology of residues, each in a chain: (name, [(atom name, element), ...])."""
    topology = app.Topology()
    for name, atoms in residues:
        residue = topology.addResidue(name, topology.addChain())
        for atom, element in atoms:
            topology.addAtom(atom, app.Element.getBySymbol(element), residue)
    return topology


METHANE = ("LIG", [("C1", "C")])


def scoreOf(residues, positions, **others):
    return clashscore(topologyOf(*residues), np.array(positions, dtype=float), **others)


def test_shrunkenVillinHasTheClashesThatProbeFinds():
    villin = readStructure()
    positions = np.round(9.5 * villin.positions, 3) / 10
    found = clashscore(villin.topology, positions)
    atoms = list(villin.topology.atoms())
    names = [frozenset(f"{atoms[i].residue.id}.{atoms[i].name}" for i in pair) for pair in found.pairs]
    expected = {frozenset(line.split()[:2]): float(line.split()[2]) for line in _SHRUNK.splitlines()}
    assert set(names) == set(expected) and len(names) == len(expected)
    assert [expected[name] for name in names] == pytest.approx(10 * found.overlaps, abs=6e-4)
    assert (found.atomCount, found.score) == (582, pytest.approx(1000 * len(names) / 582))


def test_dotsAreAsDenseAsProbesAndOnTheSphere():
    dots = dotSphere(0.17)
    assert np.linalg.norm(dots, axis=1) == pytest.approx(0.17)
    assert 0.9 < len(dots) / (4 * np.pi * 1.7**2 * 16) <= 1
    # A cap of the sphere holds its share of dots, wherever it lies.
    generator = np.random.default_rng(3)
    for axis in generator.normal(size=(20, 3)):
        share = (dots @ axis > 0.5 * 0.17 * np.linalg.norm(axis)).mean()
        assert share == pytest.approx(0.25, abs=0.015)


@pytest.mark.parametrize("distance, count", [(0.2985, 1), (0.3005, 0), (0.05, 1)])
def test_twoAtomsClashWhereTheyOverlapByFourTenths(distance, count):
    # 2 x 0.170 nm less 0.04; the deepest dot misses the line between the centers by up to half a spacing.
    found = scoreOf([METHANE, METHANE], [[0, 0, 0], [0, 0, distance]])
    assert len(found.pairs) == count
    assert found.score == 500 * count


def test_aBondedPairDoesNotClash():
    assert len(scoreOf([METHANE, METHANE], [[0, 0, 0], [0, 0, 0.173]]).pairs) == 0
    assert len(scoreOf([METHANE, METHANE], [[0, 0, 0], [0, 0, 0.175]]).pairs) == 1


def test_anAtomBetweenTwoHidesTheirClash():
    far, between = [0, 0, 0.28], [0, 0, 0.14]  # the one between is bonded to neither: it is no carbon of theirs
    three = scoreOf([METHANE, METHANE, ("XE", [("XE", "Xe")])], [[0, 0, 0], far, between])
    assert (0, 1) not in [tuple(pair) for pair in three.pairs.tolist()]
    assert [tuple(pair) for pair in scoreOf([METHANE, METHANE], [[0, 0, 0], far]).pairs.tolist()] == [(0, 1)]


def test_hydrogenBondsMayOverlapFartherAndChargedOnesFarthest():
    def count(distance, other):
        hydrogen = ("LYS", [("NZ", "N"), ("HZ1", "H")])
        return len(scoreOf([hydrogen, other], [[0, 0, -0.086], [0, 0, 0], [0, 0, distance]]).pairs)

    water, carbonyl, carboxylate = ("HOH", [("O", "O")]), ("ALA", [("O", "O")]), ("ASP", [("OD1", "O")])
    assert [count(0.16, other) for other in (water, carbonyl, carboxylate)] == [0, 0, 0]
    assert count(0.16, METHANE) == 2  # N and H


def test_waterClashesWithOthersAndNotWithItself():
    water = ("HOH", [("O", "O")])
    assert len(scoreOf([water, water], [[0, 0, 0], [0, 0, 0.21]]).pairs) == 0
    found = scoreOf([METHANE, water], [[0, 0, 0], [0, 0, 0.22]])
    assert len(found.pairs) == 1 and found.atomCount == 1


def test_anAtomThatIsNowhereClashesWithNothing():
    pair = [METHANE, METHANE], [[0, 0, 0], [0, 0, 0.25]]
    assert len(scoreOf(*pair, occupancies=np.array([1, 0.5])).pairs) == 1
    absent = scoreOf(*pair, occupancies=np.array([1, 0.01]))
    assert len(absent.pairs) == 0 and absent.atomCount == 1


def test_radiiAndRolesFollowFromNeighbors():
    residue = ("PHE", [("C", "C"), ("CZ", "C"), ("HZ", "H"), ("CA", "C"), ("HA", "H"), ("N", "N"), ("H", "H")])
    z = np.arange(7) * 1.0
    places = np.column_stack([0 * z, 0 * z, z])
    places[[2, 4, 6]] = places[[1, 3, 5]] + [0.1, 0, 0]
    atoms = contactAtoms(topologyOf(residue), places)
    assert 10 * atoms.radii == pytest.approx([1.65, 1.75, 1.05, 1.70, 1.22, 1.55, 1.05])
    assert atoms.parents.tolist() == [-1, -1, 1, -1, 3, -1, 5]


def test_noAtomsHaveNoClashes():
    found = clashscore(app.Topology(), np.zeros((0, 3)))
    assert (found.score, found.atomCount, len(found.pairs)) == (0, 0, 0)
