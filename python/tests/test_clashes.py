"""The clashes of files, against computations that share nothing with the engine."""

import json
import warnings

import numpy as np
import pytest
from openmm import app, unit
from openmmchaintree import AtomName, InputError, createStericExclusionForce, findClashes
from scenes import GLYCINES, realStructurePath, writeDCD, writePDB, writeXTC
from scipy.spatial import cKDTree

_TOLERANCE, _ALLOWANCE = 0.04, 0.06
_DONOR, _ACCEPTOR = 1, 2


class Reference:
    """Clashes by a k-d tree; excluded are pairs up to three bonds apart, found breadth-first along the bonds."""

    def __init__(self, topology, positions, isLeftOut):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # gaps
            force = createStericExclusionForce(topology, positions, unknownRadius=0)
        parameters = [force.getParticleParameters(i) for i in range(force.getNumParticles())]
        self.radii = np.array([radius.value_in_unit(unit.nanometer) for radius, _ in parameters])
        self.roles = [role for _, role in parameters]
        self.particles = np.array(
            [atom.index for atom in topology.atoms() if not isLeftOut(atom.residue) and self.radii[atom.index] > 0]
        )
        bonded = [set() for _ in self.roles]
        for atom1, atom2 in [*topology.bonds(), *metalBonds(topology, positions)]:
            isLink = {atom1.name, atom2.name} == {"C", "N"} and atom1.residue is not atom2.residue
            if not isLink or np.linalg.norm(positions[atom1.index] - positions[atom2.index]) < 0.4:
                bonded[atom1.index].add(atom2.index)
                bonded[atom2.index].add(atom1.index)
        self.excluded = [{i} for i in range(len(bonded))]
        for _ in range(3):
            self.excluded = [reached.union(*(bonded[atom] for atom in reached)) for reached in self.excluded]

    def clashes(self, positions):
        found = {}
        pairs = cKDTree(positions[self.particles]).query_pairs(2 * self.radii.max(), output_type="ndarray")
        for i, j in np.sort(self.particles[pairs], axis=1).tolist():
            overlap = self.radii[i] + self.radii[j] - np.sqrt(((positions[i] - positions[j]) ** 2).sum())
            if overlap > self._tolerance(i, j) and j not in self.excluded[i]:
                found[i, j] = overlap
        return found

    def _tolerance(self, i, j):
        for donor, acceptor in ((i, j), (j, i)):
            if self.roles[donor] & _DONOR and self.roles[acceptor] & _ACCEPTOR:
                return _TOLERANCE + _ALLOWANCE
        return _TOLERANCE


# Metals of these structures within this distance of a nitrogen, oxygen or sulfur are bound.
_METALS = {"Zn": 0.26, "Fe": 0.23, "Mg": 0.28}


def metalBonds(topology, positions):
    atoms = [atom for atom in topology.atoms() if atom.residue.name != "HOH" and atom.element is not None]
    donors = [atom for atom in atoms if atom.element.symbol in ("N", "O", "S")]
    for metal in atoms:
        for donor in donors if metal.element.symbol in _METALS else ():
            distance = np.linalg.norm(positions[metal.index] - positions[donor.index])
            if metal.residue is not donor.residue and distance < _METALS[metal.element.symbol]:
                yield metal, donor


def isSolvent(residue):
    atoms = list(residue.atoms())
    return residue.name == "HOH" or len(atoms) == 1 and atoms[0].element.symbol not in _METALS


def assertSame(frame, expected, accuracy=1e-9):
    assert [(clash.particle1, clash.particle2) for clash in frame.clashes] == sorted(expected)
    for clash in frame.clashes:
        assert clash.overlap == pytest.approx(expected[clash.particle1, clash.particle2], abs=accuracy)


def positionsOf(pdb, model=0):
    return np.array(pdb.getPositions(frame=model).value_in_unit(unit.nanometer))


def overlaps(frame):
    return {(clash.particle1, clash.particle2): clash.overlap for clash in frame.clashes}


# ---- Structures ----


@pytest.mark.filterwarnings("ignore:gaps in the chain", "ignore:ions left out")
@pytest.mark.parametrize(("name", "least"), [("1l2y", 50), ("1htb", 30), ("4hhb", 40), ("6msm", 80), ("5dfr_h", 2)])
def test_modelsAgainstAKDTree(name, least):
    path = realStructurePath(f"{name}.pdb")
    frames = findClashes(path)
    pdb = app.PDBFile(str(path))
    reference = Reference(pdb.topology, positionsOf(pdb), isSolvent)
    assert [frame.number for frame in frames] == list(range(pdb.getNumFrames()))
    for frame in frames:
        assertSame(frame, reference.clashes(positionsOf(pdb, frame.number)))
        assert frame.clashesPer1000Atoms == pytest.approx(1000 * len(frame.clashes) / len(reference.particles))
    assert sum(len(frame.clashes) for frame in frames) >= least


def test_namesAreThoseOfTheFile():
    (frame,) = findClashes(realStructurePath("4hhb.pdb"))
    worst = max(frame.clashes, key=lambda clash: clash.overlap)
    assert worst.atom1 == AtomName("D", "THR 4", "CB") and worst.atom2 == AtomName("D", "GLU 6", "OE2")
    assert str(worst.atom1) == "D:THR 4 CB"
    atoms = list(app.PDBFile(str(realStructurePath("4hhb.pdb"))).topology.atoms())
    for clash in frame.clashes:
        assert (clash.atom1.atom, clash.atom2.atom) == (atoms[clash.particle1].name, atoms[clash.particle2].name)


@pytest.mark.filterwarnings("ignore:ions left out", "ignore:atoms not looked at")
@pytest.mark.parametrize(("water", "ions"), [(True, False), (False, True), (True, True)])
def test_waterAndIonsOnRequest(water, ions):
    path = realStructurePath("1htb.pdb")
    (frame,) = findClashes(path, water=water, ions=ions)
    pdb = app.PDBFile(str(path))

    def isLeftOut(residue):
        return not water if residue.name == "HOH" else not ions and isSolvent(residue)

    assertSame(frame, Reference(pdb.topology, positionsOf(pdb), isLeftOut).clashes(positionsOf(pdb)))
    (dry,) = findClashes(path)
    assert len(frame.clashes) - len(dry.clashes) >= (1 if water else 0)


def test_particlesAreNumberedAsInTheFile(tmp_path):
    """Water that is left out and comes before the protein counts."""
    water = "HETATM    1  O   HOH W   1      90.000   0.000   0.000  1.00  0.00           O"
    clashing = "ATOM      9  C1  LIG B   1       0.100   0.000   0.000  1.00  0.00           C"
    second = "ATOM     10  C2  LIG B   1       0.100 -30.000   0.000  1.00  0.00           C"
    (frame,) = findClashes(writePDB(tmp_path / "wet.pdb", [water, *GLYCINES, clashing, second]))
    assert {clash.particle1 for clash in frame.clashes} >= {1, 2}
    assert {clash.particle2 for clash in frame.clashes} == {9}
    assert {str(clash.atom2) for clash in frame.clashes} == {"B:LIG 1 C1"}
    assert frame.clashesPer1000Atoms == 100 * len(frame.clashes)  # of ten atoms


def test_noClash(tmp_path):
    (frame,) = findClashes(writePDB(tmp_path / "glycines.pdb", GLYCINES))
    assert frame == (0, [], 0.0)


def test_radiiOfChoice():
    path = realStructurePath("1ubi_h.pdb")
    allAtom, unitedAtom = (findClashes(path, radii=radii)[0].clashes for radii in ("all-atom", "united-atom"))
    assert any(clash.atom1.atom.startswith("H") for clash in allAtom)
    assert unitedAtom and not any(name.atom.startswith("H") for clash in unitedAtom for name in clash[2:4])
    with pytest.raises(ValueError, match="'bondi' is not a set of radii"):
        findClashes(path, radii="bondi")


def test_atomOfUnknownRadiusIsNotLookedAt(tmp_path):
    xenon = "HETATM    9 XE   XEN B   1       0.000   0.000   0.000  1.00  0.00          XE"
    other = "HETATM   10  C   XEN B   1      50.000   0.000   0.000  1.00  0.00           C"
    path = writePDB(tmp_path / "xenon.pdb", [*GLYCINES, xenon, other])
    with pytest.warns(UserWarning, match="^atoms not looked at, since no radius is known .*: B:XEN 1 XE, xenon$"):
        (frame,) = findClashes(path)
    assert frame.clashes == []
    with pytest.raises(InputError, match="xenon.pdb: there is no atom with a known radius"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        findClashes(writePDB(tmp_path / "xenon.pdb", [xenon, xenon.replace("XE   X", "XE2  X")]))


def test_gapIsTold():
    with pytest.warns(UserWarning, match="^gaps in the chain") as caught:
        findClashes(realStructurePath("6msm.pdb"))
    (warning,) = [warning for warning in caught if warning.message.note.kind == "gaps in the chain"]
    assert len(warning.message.note.items) == 4 and "A:PHE 409 and A:LEU 435" in str(warning.message)


# ---- mmCIF ----


def writeMmCIF(path, pdb):
    with open(path, "w") as file:
        app.PDBxFile.writeHeader(pdb.topology, file, keepIds=True)
        for model in range(pdb.getNumFrames()):
            app.PDBxFile.writeModel(pdb.topology, pdb.getPositions(frame=model), file, model + 1, keepIds=True)
    return path


def writeMmCIFWithoutBonds(path, pdb):
    """Such as many programs write them: without the table of bonds, disulfides among them."""
    bare = app.Topology()
    for chain in pdb.topology.chains():
        newChain = bare.addChain(chain.id)
        for residue in chain.residues():
            newResidue = bare.addResidue(residue.name, newChain, residue.id)
            for atom in residue.atoms():
                bare.addAtom(atom.name, atom.element, newResidue)
    with open(path, "w") as file:
        app.PDBxFile.writeFile(bare, pdb.positions, file, keepIds=True)
    return path


@pytest.mark.parametrize("name", ["1l2y", "4hhb"])
def test_mmCIFAndPDBAgree(tmp_path, name):
    path = realStructurePath(f"{name}.pdb")
    pdb = app.PDBFile(str(path))
    frames = findClashes(writeMmCIF(tmp_path / "same.cif", pdb))
    expected = findClashes(path)
    assert len(frames) == len(expected)
    for frame, other in zip(frames, expected, strict=True):
        assertSame(frame, overlaps(other))
        assert [clash[2:4] for clash in frame.clashes] == [clash[2:4] for clash in other.clashes]


def test_disulfidesInMmCIFWithoutBonds(tmp_path):
    path = realStructurePath("bpti_h.pdb")
    (frame,) = findClashes(writeMmCIFWithoutBonds(tmp_path / "bare.cif", app.PDBFile(str(path))))
    assertSame(frame, overlaps(findClashes(path)[0]))


# ---- Trajectories ----


def test_trajectoryAgainstAKDTree():
    structure, trajectory = realStructurePath("adk_open_h.pdb"), realStructurePath("adk_dims.dcd")
    with pytest.warns(UserWarning, match="its header tells of 500 frames, but it holds 98"):
        frames = findClashes(structure, trajectory)
    pdb = app.PDBFile(str(structure))
    reference = Reference(pdb.topology, positionsOf(pdb), isSolvent)
    # A frame is three records, each between markers of four bytes.
    records = np.fromfile(trajectory, np.uint8)[-98 * 3 * (4 * 3341 + 8) :].reshape(98, 3, -1)[:, :, 4:-4]
    coordinates = np.ascontiguousarray(records).view("<f4").astype(float) / 10
    assert len(frames) == len(coordinates) and all(len(frame.clashes) > 20 for frame in frames)
    for number in (0, 1, *range(7, 97, 10), 96, 97):
        positions = coordinates[number].T
        assertSame(frames[number], reference.clashes(positions), 1e-6)


@pytest.mark.parametrize(("name", "accuracy"), [("1l2y.dcd", 1e-6), ("1l2y.xtc", 0.002)])
def test_trajectoryAndModelsAgree(name, accuracy):
    """Up to the rounding of the format: in XTC, 0.0005 nm of each coordinate."""
    structure = realStructurePath("1l2y.pdb")
    models, frames = findClashes(structure), findClashes(structure, realStructurePath(name))
    assert len(frames) == len(models) == 38
    common = 0
    for model, frame in zip(models, frames, strict=True):
        assert frame.number == model.number
        expected, found = overlaps(model), overlaps(frame)
        for pair in expected.keys() ^ found.keys():
            # Tolerances are 0.04 and 0.1 nm.
            overlap = expected.get(pair, found.get(pair))
            assert min(abs(overlap - 0.04), abs(overlap - 0.1)) < accuracy
        for pair in expected.keys() & found.keys():
            assert found[pair] == pytest.approx(expected[pair], abs=accuracy)
            common += 1
    assert common > 40


@pytest.mark.parametrize("write", [writeDCD, writeXTC])
def test_writtenByOpenMM(tmp_path, villin, write):
    """A trajectory of villin that comes apart and back: the atoms of frame 1 are far from each other."""
    structure = tmp_path / "villin.pdb"
    with open(structure, "w") as file:
        app.PDBFile.writeFile(villin.topology, villin.positions * unit.nanometer, file)
    path = write(tmp_path / "villin", villin.topology, [villin.positions, 3 * villin.positions, villin.positions])
    frames = findClashes(structure, path)
    assert [len(frame.clashes) for frame in frames] == [1, 0, 1]
    assert frames[0].clashes[0].overlap == pytest.approx(findClashes(structure)[0].clashes[0].overlap, abs=0.002)


def test_resultsArePlainData():
    """All but tuples, lists, strings and numbers would not survive this."""
    frames = findClashes(realStructurePath("1l2y.pdb"))
    assert json.loads(json.dumps(frames))[1][1][0][4] == frames[1].clashes[0].overlap
