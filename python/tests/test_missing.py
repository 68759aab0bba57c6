"""Building residues that a model lacks, and a chain from its sequence."""

import numpy as np
import openmm
import pytest
from openmm import app, unit
from openmmchaintree import InputError, buildMissing, findTorsions
from openmmchaintree.building.coildraws import CoilDraws
from openmmchaintree.densities import loopCounts
from openmmchaintree.structures.structure import readStructure
from scenes import realStructurePath

VILLIN = "LSDEDFKAVFGMTRSAFANLPLWKQQHLKKEKGLF"  # residues 1 to 35 in OpenMM's package
LETTERS = "ACDEFGHIKLMNPQRSTVWY"

pytestmark = pytest.mark.filterwarnings("ignore::openmmchaintree.notes.NoteWarning")


@pytest.fixture(scope="module")
def villin():
    return readStructure()


@pytest.fixture
def writeVillin(villin, tmp_path):
    """Write villin without some residues, and perhaps without hydrogens; return the path."""

    def write(left, hydrogens=True, chain="A", header=""):
        modeller = app.Modeller(villin.topology, villin.positions * unit.nanometer)
        atoms = [
            atom
            for atom in modeller.topology.atoms()
            if atom.residue.index in left or (not hydrogens and atom.element.symbol == "H")
        ]
        modeller.delete(atoms)
        next(modeller.topology.chains()).id = chain
        path = tmp_path / "part.pdb"
        with open(path, "w", encoding="utf-8") as file:
            file.write(header)
            app.PDBFile.writeFile(modeller.topology, modeller.positions, file, keepIds=True)
        return path

    return write


def addressesOf(topology):
    residues = ((atom, atom.residue) for atom in topology.atoms())
    return [(each.chain.id, each.id, each.insertionCode, each.name, atom.name) for atom, each in residues]


def checkNothingMoved(path, built, mayLack=("OC2", "OXT", "H", "H1", "H2", "H3")):
    """Check that the atoms of a file are in their order and places, bit for bit, but for those of free ends."""
    before = readStructure(path)
    old = dict(zip(addressesOf(before.topology), before.positions, strict=True))
    kept = ~built.isBuilt & ~built.isMoved
    names = [each for each, one in zip(addressesOf(built.topology), kept, strict=True) if one]
    assert names == [each for each in addressesOf(before.topology) if each in set(names)]
    assert all(each[4] in mayLack for each in set(old) - set(names) if not built.isMoved.any())
    assert np.array_equal(built.positions[kept], np.array([old[each] for each in names]))


def energiesOf(built):
    """Return the energies of bonds, angles and torsions by name in AMBER (kJ/mol)."""
    system = app.ForceField("amber14-all.xml").createSystem(built.topology)
    for number, force in enumerate(system.getForces()):
        force.setForceGroup(number)
    context = openmm.Context(system, openmm.VerletIntegrator(1), openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(built.positions)
    return {
        force.getName(): context.getState(energy=True, groups=1 << number)
        .getPotentialEnergy()
        .value_in_unit(unit.kilojoule_per_mole)
        for number, force in enumerate(system.getForces())
    }


def dihedrals(built, kind):
    found = [torsion.particles for torsion in findTorsions(built.topology, kinds=kind).torsions]
    first, second, third, fourth = (built.positions[list(one)] for one in zip(*found, strict=True))
    axis, normal1 = third - second, np.cross(second - first, third - second)
    normal2 = np.cross(axis, fourth - third)
    sine = np.einsum("ij,ij->i", np.cross(normal1, normal2), axis) / np.linalg.norm(axis, axis=1)
    return np.degrees(np.arctan2(sine, np.einsum("ij,ij->i", normal1, normal2)))


def test_aChainHasTheGeometryOfAForceField():
    built = buildMissing(None, [LETTERS], hydrogens=True, seed=3)
    energies = energiesOf(built)  # which needs all atoms and bonds of each residue
    assert energies["HarmonicBondForce"] < 15 * len(LETTERS)
    assert energies["HarmonicAngleForce"] < 20 * len(LETTERS)
    assert np.abs(dihedrals(built, "omega")) == pytest.approx(180, abs=1e-6)
    heavy = buildMissing(None, [LETTERS], seed=3)
    isHeavy = [atom.element.symbol != "H" for atom in built.topology.atoms()]
    assert heavy.positions == pytest.approx(built.positions[isHeavy])
    assert [atom.name for atom in heavy.topology.atoms()].count("OXT") == 1
    assert np.array_equal(heavy.positions, buildMissing(None, [LETTERS], seed=3).positions)
    assert not np.array_equal(heavy.positions, buildMissing(None, [LETTERS], seed=4).positions)


def test_centersHaveTheirHand():
    names = ["ALA", "DAL", "ILE", "DIL", "THR", "DTH", "PRO", "DPR"]
    built = buildMissing(None, [names], seed=1)
    volumes = []
    for residue in built.topology.residues():
        n, ca, c, cb = (
            next(built.positions[atom.index] for atom in residue.atoms() if atom.name == name)
            for name in ("N", "CA", "C", "CB")
        )
        volumes.append(np.dot(np.cross(n - ca, c - ca), cb - ca))
    assert np.sign(volumes).tolist() == [1, -1] * 4


def test_capsAndModifiedResidues():
    built = buildMissing(None, [["ACE", "GLY", "MSE", "SER", "NME"]], hydrogens=True, seed=1)
    names = {residue.name: sorted(atom.name for atom in residue.atoms()) for residue in built.topology.residues()}
    assert names["ACE"] == ["C", "CH3", "H1", "H2", "H3", "O"] and names["NME"] == ["C", "H", "H1", "H2", "H3", "N"]
    assert "SE" in names["MSE"] and "OXT" not in names["SER"]
    standard = buildMissing(None, [["ACE", "PRO", "ALA", "NME"]], hydrogens=True, seed=1)
    assert energiesOf(standard)["HarmonicAngleForce"] < 100
    pytest.importorskip("biotite")
    own = buildMissing(None, ["ABO"], seed=1)
    assert [residue.name for residue in own.topology.residues()] == ["ALA", "SEP", "TPO"]


def test_drawsHaveTheDensityOfTheTables():
    draws = CoilDraws(5)
    angles = np.degrees([draws.backbone("LYS", "ALA") for _ in range(20000)])
    counts = loopCounts()["LYS"]
    found, _, _ = np.histogram2d(*angles.T, bins=30, range=[(-180, 180)] * 2)
    assert np.abs(found / len(angles) - counts / counts.sum()).sum() / 2 < 0.06
    phi, _ = np.transpose([draws.backbone("DLY") for _ in range(500)])
    assert (phi > 0).mean() > 0.8


@pytest.mark.parametrize("hydrogens", [True, False])
def test_tailsAtBothEnds(writeVillin, hydrogens):
    path = writeVillin([0, 1, 2, 31, 32, 33, 34], hydrogens)
    built = buildMissing(path, [VILLIN], seed=2)
    assert [[residue.name for residue in part] for part in built.parts] == [
        ["LEU", "SER", "ASP"], ["LYS", "GLY", "LEU", "PHE"],
    ]  # fmt: skip
    assert [residue.id for part in built.parts for residue in part] == "1 2 3 32 33 34 35".split()
    checkNothingMoved(path, built)
    if hydrogens:
        whole = readStructure()
        assert built.topology.getNumAtoms() == whole.topology.getNumAtoms()
        assert energiesOf(built)["HarmonicAngleForce"] < energiesOf(whole)["HarmonicAngleForce"] + 7 * 20
    else:
        assert not any(atom.element.symbol == "H" for atom in built.topology.atoms())
    assert np.abs(dihedrals(built, "omega")[[0, 1, -1, -2]]) == pytest.approx(180, abs=1e-6)


def test_theAmineOfAFreeEndBecomesAnAmide(writeVillin):
    path = writeVillin([])  # with NH3+ and OXT
    built = buildMissing(path, ["GAP" + VILLIN + "SA"], seed=2)
    checkNothingMoved(path, built)
    names = [atom.name for atom in list(built.topology.residues())[3].atoms()]
    assert names.count("H") == 1 and "H2" not in names and "H3" not in names
    assert energiesOf(built)["HarmonicBondForce"] < 2000  # each bond is there
    with pytest.warns(UserWarning, match="atoms of free ends left out"):
        buildMissing(path, ["GAP" + VILLIN + "SA"], seed=2)


def test_theSequenceOfTheFile(writeVillin):
    names = [residue.name for residue in readStructure().topology.residues()]
    rows = [names[first : first + 13] for first in range(0, len(names), 13)]
    header = "".join(f"SEQRES {i:3} A {len(names):4}  {' '.join(row)}\n" for i, row in enumerate(rows, 1))
    built = buildMissing(writeVillin([0, 1, 34], header=header), seed=1)
    assert [len(part) for part in built.parts] == [2, 1]


def test_domainsMoveWithTheirLinkers(writeVillin):
    path = writeVillin([*range(8, 13), *range(27, 31)], hydrogens=False)
    with pytest.raises(InputError, match=r"gaps become linkers with ensemble --move-domains"):
        buildMissing(path, [VILLIN])
    built = buildMissing(path, [VILLIN], moveDomains=True, seed=3)
    assert [len(part) for part in built.parts] == [5, 4]
    checkNothingMoved(path, built)
    names = {atom.residue.id for atom, moved in zip(built.topology.atoms(), built.isMoved, strict=True) if moved}
    assert names == {str(number) for number in [*range(1, 9), *range(32, 36)]}
    old = dict(zip(addressesOf(readStructure(path).topology), readStructure(path).positions, strict=True))
    for numbers in (range(1, 9), range(32, 36)):
        inDomain = [each for each in addressesOf(built.topology) if int(each[1]) in numbers and each in old]
        places = [addressesOf(built.topology).index(each) for each in inDomain]
        before, after = np.array([old[each] for each in inDomain]), built.positions[places]
        distances = [np.linalg.norm(x[:, None] - x, axis=2) for x in (before, after)]
        assert distances[0] == pytest.approx(distances[1], abs=1e-9) and np.abs(before - after).max() > 0.1
    lengths = [np.linalg.norm(built.positions[a.index] - built.positions[b.index]) for a, b in built.topology.bonds()]
    assert max(lengths) < 0.19
    assert np.abs(dihedrals(built, "omega"))[7:13] == pytest.approx(180, abs=1e-6)


@pytest.mark.parametrize("hydrogens", [True, False])
def test_gapsAreClosed(writeVillin, hydrogens):
    path = writeVillin(range(12, 17), hydrogens)
    built = buildMissing(path, [VILLIN], closeGaps=True, seed=2)
    assert [[residue.name for residue in part] for part in built.parts] == [["THR", "ARG", "SER", "ALA", "PHE"]]
    checkNothingMoved(path, built, mayLack=())
    places = {(a.residue.index, a.name): built.positions[a.index] for a in built.topology.atoms()}
    c, n, ca = places[16, "C"], places[17, "N"], places[17, "CA"]
    assert np.linalg.norm(c - n) == pytest.approx(0.1329, abs=1e-9)
    for corner, before, after, degrees in ((n, c, ca, 121.7), (c, places[16, "CA"], n, 116.2)):
        arms = before - corner, after - corner
        cosine = arms[0] @ arms[1] / np.linalg.norm(arms[0]) / np.linalg.norm(arms[1])
        assert np.degrees(np.arccos(cosine)) == pytest.approx(degrees, abs=1e-6)
    assert np.abs(dihedrals(built, "omega")[11:17]) == pytest.approx(180, abs=1e-6)
    if hydrogens:
        assert energiesOf(built)["HarmonicBondForce"] < energiesOf(readStructure())["HarmonicBondForce"] + 5 * 15
    with pytest.raises(InputError, match="exclude each other"):
        buildMissing(path, [VILLIN], closeGaps=True, moveDomains=True)


def test_gapsThatCannotBeClosed(writeVillin):
    path = writeVillin(range(12, 14), False)
    with pytest.raises(InputError, match=r"gaps that stay open, since both sides stay in place \(1\): 2 residues"):
        buildMissing(path, [VILLIN], closeGaps=True)
    path = writeVillin(range(8, 20), False)
    with pytest.raises(InputError, match="gaps that stay open"):
        buildMissing(path, [VILLIN[:8] + "GS" + VILLIN[20:]], closeGaps=True)


def test_realStructures():
    for name in ("1shg.pdb", "hard/1A8O.cif.gz"):
        path = realStructurePath(name)
        try:
            built = buildMissing(path, seed=1)
        except InputError as error:
            assert "no residue is missing" in str(error)
            continue
        checkNothingMoved(path, built)
        assert max(len(part) for part in built.parts) > 0


def test_errors(writeVillin, tmp_path):
    path = writeVillin([0])
    for arguments, message in (
        ((None, None), "one sequence is needed"),
        ((None, ["AXA"]), "'X' in a sequence is no amino acid"),
        ((None, [""]), "a sequence is empty"),
        ((None, [["ALA", "QQQ9"]]), "QQQ9 cannot be built"),
        ((None, [["ALA", "HOH"]]), "HOH cannot be built: it has no atoms N, CA and C"),
        ((None, [["ALA", "ACE"]]), "ACE can only be the first"),
        ((None, [["NME", "ALA"]]), "NME can only be the last"),
        ((None, [["NH2"]]), "NH2 can only be the last"),
        ((path, None), r"no residue is missing at the ends of chains; chains of which the file has no sequence \(1\)"),
        ((path, ["W" * 40]), "chains that differ from all given sequences"),
        ((tmp_path / "none.pdb", None), "No such file"),
    ):
        with pytest.raises(InputError, match=message):
            buildMissing(*arguments)


def test_residuesWithoutABackboneAreBuiltAgain(writeVillin):
    path = writeVillin([0, 33, 34], hydrogens=False)
    lines = path.read_text().splitlines(keepends=True)
    left = (" CA  SER A   2", " C   SER A   2", " N   GLY A  33")
    path.write_text("".join(line for line in lines if line[12:26] not in left))
    built = buildMissing(path, [VILLIN], seed=1)
    assert [[residue.name for residue in part] for part in built.parts] == [["LEU", "SER"], ["GLY", "LEU", "PHE"]]
    assert [residue.name for residue in built.topology.residues()] == [
        residue.name for residue in readStructure().topology.residues()
    ]
    with pytest.warns(UserWarning, match="residues without N, CA or C, left out and built again"):
        buildMissing(path, [VILLIN], seed=1)
    path.write_text("".join(line for line in lines if line[12:16] == " CA "))
    with pytest.raises(InputError, match="lacks N, CA or C, and is alone beside missing residues"):
        buildMissing(path, [VILLIN])
