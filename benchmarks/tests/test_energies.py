"""The benchmark energies.py. No test looks at how long anything takes."""

import energies
import numpy as np
import openmm
import pytest
from energytables import ONE_ENERGY, findWrong
from forcefield import writeEnergy
from measure import Course
from openmm import app, unit
from openmmchaintree.errors import InputError
from program import Program, ProgramError
from proteins import NO_CUTOFF, REACTION_FIELD, readProtein
from rivals import turnAbout

LITTLE = ("--trials", 60, "--warm", 100)


@pytest.fixture(scope="module")
def villin():
    """The villin headpiece."""
    return readProtein()


def test_everythingQuickly(runQuickly):
    machine, entries, tables = runQuickly(energies.main, *LITTLE)
    assert "portable" in machine["instruction sets of the engine"]
    work = [entry for entry in entries if entry["group"] == "work"]
    assert {entry["method"] for entry in work} == {REACTION_FIELD.name, NO_CUTOFF.name}
    assert len({entry["moves"] for entry in work}) == 3
    for entry in work:
        if entry["contestant"].startswith("ours"):
            parts = [entry[part] for part in ("terms", "near", "other")]
            assert parts[0]["reached"] == entry["free"] <= 60
            assert sum(part["refused"] for part in parts) + entry["accepted"] == entry["free"]
        if entry["contestant"] in ("ours-portable", ONE_ENERGY):
            assert 0 < entry["energyError"] < 0.1 and 0 < entry["changeError"]["largest"] < 0.01
    (ours,) = (entry for entry in entries if entry["group"] == "trials" and entry["contestant"] == "ours")
    refused = sum(stage["refused"] for stage in ours["stages"].values())
    assert ours["clashed"] + refused + ours["accepted"] == ours["attempted"]
    assert len(tables) == 5


def test_wrongEnergiesAreReported(runHere, monkeypatch):
    honest = energies.writeEnergy

    def writeWrong(path, system):
        honest(path, system)
        lines = path.read_text().splitlines()
        lines[3] = "0.1 " + lines[3].partition(" ")[2]  # the first charge
        path.write_text("\n".join(lines))

    monkeypatch.setattr(energies, "writeEnergy", writeWrong)
    result = runHere(energies.main, "--quick", *LITTLE, "--rows", "work")
    assert result.returncode == 1 and "WRONG: villin, no cutoff: U and its changes differ" in result.stdout


def test_aFailingRowDoesNotEndTheOthers(runHere, monkeypatch):
    def fail(self, options):
        raise ProgramError("not enough memory")

    monkeypatch.setattr(Program, "run", fail)
    result = runHere(energies.main, "--quick", *LITTLE)
    assert result.returncode == 1
    assert "FAILED: work: villin, no cutoff, pivot, 1°: not enough memory" in result.stdout
    assert "Whole trials, µs:" in result.stdout


@pytest.mark.parametrize(
    ("values", "isWrong"),
    [
        ({"energyError": 5e-3, "changeError": {"largest": 1e-4}}, False),
        ({"energyError": 7e-2, "changeError": {"largest": 1e-4}}, True),
        ({"energyError": float("nan")}, True),
        ({"energyError": 1e-3, "changeError": {"largest": 2e-2}}, True),
        ({"contestant": "other", "energyError": 1.0}, False),
    ],
)
def test_whatIsWrong(values, isWrong):
    entry = {"contestant": "ours-avx2", "chain": "villin", "method": "", "energy": -1000.0, **values}
    assert len(findWrong([entry])) == isWrong


def test_foreignForcesAreRefused(villin, tmp_path):
    system = villin.makeSystem(NO_CUTOFF, sterics=False)
    system.addForce(openmm.CustomExternalForce("x"))
    for wrong, word in ((system, "CustomExternalForce"), (openmm.System(), "NonbondedForce")):
        with pytest.raises(InputError, match=word):
            writeEnergy(tmp_path / "energy", wrong)


def test_hydrogensAreAdded(tmp_path, villin):
    heavy = app.Modeller(villin.topology, villin.positions * unit.nanometer)
    heavy.delete([atom for atom in villin.topology.atoms() if atom.element is app.element.hydrogen])
    with open(tmp_path / "heavy.pdb", "w", encoding="ascii") as file:
        app.PDBFile.writeFile(heavy.topology, heavy.positions, file)
    text = (tmp_path / "heavy.pdb").read_text(encoding="ascii").replace("HIE", "HIS")
    (tmp_path / "heavy.pdb").write_text(text, encoding="ascii")
    protein = readProtein(tmp_path / "heavy.pdb")
    assert protein.name == "heavy" and len(protein.positions) == 582 and np.isfinite(protein.positions).all()


def test_turnsKeepBonds(villin):
    moved = villin.makeScene().movedBy()
    assert len(moved) == len(villin.torsions)
    bonds = np.array([(bond.atom1.index, bond.atom2.index) for bond in villin.topology.bonds()])
    for (near, far), atoms in moved[::10]:
        before = villin.positions
        after = before.copy()
        after[atoms] = turnAbout(before[near], before[far], before[atoms], 0.3)
        lengths = [np.linalg.norm(np.subtract(*x[bonds.T]), axis=1) for x in (before, after)]
        np.testing.assert_allclose(*lengths, atol=1e-12)
        assert far in atoms and near not in atoms


def test_scenesAreInOrder(villin, tmp_path):
    """In a scene's file, a torsion turns an interval of particles, the heaviest branch of a link is the last."""
    scene = villin.makeScene()
    turned = [scene.countTorsions(ofSideChains) for ofSideChains in (False, True)]
    assert turned == [len(villin.torsionsOf(which)) for which in ("backbone", "side chains")]
    scene.write(tmp_path / "scene")
    _, counts, *lines = (tmp_path / "scene").read_text().splitlines()
    particles, links = int(counts.split()[1]), int(counts.split()[3])
    names = [int(line.split()[5]) for line in lines[:particles]]
    assert sorted(names) == list(range(582))
    rows = [[int(word) for word in line.split()] for line in lines[particles : particles + links]]
    expected = {axis: set(atoms.tolist()) for axis, atoms in scene.movedBy()}
    heaviest, lastBranch = {}, {}
    for parent, near, far, first, last, _ in rows:
        if parent >= 0:
            assert expected.pop((names[near], names[far])) == set(names[first:last])
            heaviest[parent] = max(heaviest.get(parent, 0), last - first)
            lastBranch[parent] = last - first
    assert not expected and lastBranch == heaviest
    course = Course(Program(), 1, None, tmp_path)
    lines = course.program.run({"--chain": tmp_path / "scene", "--trials": 20, "--contestants": "lazygrid,ours"})
    assert {line["particles"] for line in lines} == {582}
