"""Ensembles of tails, linkers and whole chains as random coils of all atoms, by the call and by the command."""

import csv
import json

import mdtraj
import numpy as np
import pytest
from openmm import app, unit
from openmmchaintree import InputError, buildMissing, createStericExclusionForce, sampleEnsemble
from openmmchaintree.command.cli import main
from openmmchaintree.ensembles.avoidedregions import readRegion
from openmmchaintree.ensembles.chainshape import shapesOf
from openmmchaintree.ensembles.coilshape import CoilShape
from openmmchaintree.structures.structure import readStructure

SEQUENCE = "LSDEDFKAVFGMTRSAFANLPLWKQQHLKKEKGLFGSTEAR"  # villin in OpenMM's package, and a tail of six

pytestmark = pytest.mark.filterwarnings("ignore::openmmchaintree.notes.NoteWarning")


@pytest.fixture
def villin(tmp_path, monkeypatch):
    """The path of villin's heavy atoms without residues 13 to 16."""
    monkeypatch.chdir(tmp_path)
    structure = readStructure()
    modeller = app.Modeller(structure.topology, structure.positions * unit.nanometer)
    modeller.delete(
        [a for a in modeller.topology.atoms() if a.element.symbol == "H" or a.residue.index in range(12, 16)]
    )
    path = tmp_path / "villin.pdb"
    with open(path, "w", encoding="utf-8") as file:
        app.PDBFile.writeFile(modeller.topology, modeller.positions, file, keepIds=True)
    return path


def overlapsOf(topology, positions, isMoving):
    """Return the largest overlap beyond the tolerance of pairs with a moving atom, by a look at all pairs (nm)."""
    force = createStericExclusionForce(topology)
    count = len(positions)
    radii, roles = zip(*(force.getParticleParameters(i) for i in range(count)), strict=True)
    radii, roles = np.array([radius.value_in_unit(unit.nanometer) for radius in radii]), np.array(roles)
    limits = force.getOverlapTolerance(), force.getHydrogenBondAllowance()
    tolerance, allowance = (limit.value_in_unit(unit.nanometer) for limit in limits)
    mayBond = ((roles[:, None] & 1) & (roles >> 1)) | ((roles[:, None] >> 1) & (roles & 1))
    overlaps = radii[:, None] + radii - np.linalg.norm(positions[:, None] - positions, axis=2)
    overlaps -= tolerance + allowance * mayBond
    overlaps[np.diag_indices(count)] = -1
    for index in range(force.getNumExclusions()):
        first, second = force.getExclusionParticles(index)
        overlaps[first, second] = overlaps[second, first] = -1
    return overlaps[isMoving].max()


def test_tailsMoveAndNothingElse(villin):
    built = buildMissing(villin, [SEQUENCE], seed=4)
    ensemble = sampleEnsemble(villin, "coil", conformers=25, seed=4, missing=True, sequences=[SEQUENCE])
    assert ensemble.isComplete and len(ensemble.positions) == 25
    fixed = built.positions[~built.isBuilt].astype(np.float32)
    assert all(np.array_equal(frame[~built.isBuilt], fixed) for frame in ensemble.positions)
    assert max(overlapsOf(ensemble.topology, frame, built.isBuilt) for frame in ensemble.positions[::3]) < 1e-6
    trace = [atom.name for atom in ensemble.topology.atoms() if atom.index in set(ensemble.trace)]
    assert trace == ["CA"] * 6
    first, last = ensemble.positions[:, ensemble.trace[0]], ensemble.positions[:, ensemble.trace[-1]]
    assert np.linalg.norm(last - first, axis=1) == pytest.approx(ensemble.shapes.endToEndDistance, rel=1e-5)
    masses = np.array([atom.element.mass.value_in_unit(unit.dalton) for atom in ensemble.topology.atoms()])
    shapes = shapesOf(ensemble.positions, masses)
    assert shapes.radiusOfGyration == pytest.approx(ensemble.shapes.radiusOfGyration, rel=1e-5)
    assert shapes.asphericity == pytest.approx(ensemble.shapes.asphericity, rel=1e-4)
    again = sampleEnsemble(villin, "coil", conformers=25, seed=4, missing=True, sequences=[SEQUENCE])
    assert np.array_equal(ensemble.positions, again.positions)


def test_aWholeChain():
    ensemble = sampleEnsemble("GSTEARKLPDVF", "coil", conformers=30, seed=1, temperature=310)
    assert ensemble.isComplete and ensemble.topology.getNumResidues() == 12
    isMoving = np.ones(ensemble.topology.getNumAtoms(), dtype=bool)
    assert max(overlapsOf(ensemble.topology, frame, isMoving) for frame in ensemble.positions[::5]) < 1e-6
    bonds = [(a.index, b.index) for a, b in ensemble.topology.bonds()]
    lengths = [np.linalg.norm(frame[a] - frame[b]) for a, b in bonds for frame in ensemble.positions[:3]]
    assert 0.12 < min(lengths) and max(lengths) < 0.19
    assert [name for name in ensemble.estimates if " of " not in name] == ["end-to-end distance", "asphericity"]


def test_domainsMoveAsRigidBodies(villin):
    ensemble = sampleEnsemble(
        villin, "coil", conformers=15, seed=2, missing=True, sequences=[SEQUENCE], moveDomains=True
    )
    built = buildMissing(villin, [SEQUENCE], moveDomains=True, seed=2)
    moved = ensemble.positions[:, built.isMoved]
    distances = np.linalg.norm(moved[:, :, None] - moved[:, None], axis=3)
    assert np.ptp(distances, axis=0).max() < 1e-5
    assert np.ptp(moved, axis=0).max() > 1
    stay = ensemble.positions[:, ~built.isMoved & ~built.isBuilt]
    assert np.ptp(stay, axis=0).max() == 0
    isMoving = built.isMoved | built.isBuilt
    between = overlapsOf(ensemble.topology, ensemble.positions[-1], built.isBuilt)
    assert between < 1e-6 and isMoving.sum() > built.isBuilt.sum()


def test_domainsOfAStructureStayRigid():
    structure = readStructure()  # villin with hydrogens
    residues = list(structure.topology.residues())
    domains = [range(3, 12), range(16, 30)]
    ensemble = sampleEnsemble(structure, "coil", conformers=10, seed=3, domains=domains)

    def atomsOf(indices):
        return [atom.index for index in indices for atom in residues[index].atoms()]

    large, small = atomsOf(domains[1]), atomsOf(domains[0])
    assert all(np.array_equal(frame, structure.positions[large].astype("f4")) for frame in ensemble.positions[:, large])
    moved = ensemble.positions[:, small].astype(float)
    before = np.linalg.norm(structure.positions[small][:, None] - structure.positions[small], axis=2)
    for frame in moved:
        assert np.linalg.norm(frame[:, None] - frame, axis=2) == pytest.approx(before, abs=1e-5)
    assert np.ptp(moved, axis=0).max() > 1
    names = [name for name in ensemble.estimates if name.startswith("end-to-end distance of")]
    assert [name[23:] for name in names] == ["LEU 1 – ASP 3", "THR 13 – ALA 16", "GLU 31 – PHE 35"]
    isFlexible = np.ones(len(structure.positions), dtype=bool)
    isFlexible[large + small] = False
    assert overlapsOf(ensemble.topology, ensemble.positions[-1], isFlexible) < 1e-6
    with pytest.raises(InputError, match="nothing is flexible"):
        sampleEnsemble(structure, "coil", domains=[range(35)])
    with pytest.raises(InputError, match="cannot move: it has several segments"):
        sampleEnsemble(structure, "coil", domains=[[0, 1, 5, 6], range(16, 30)])
    with pytest.raises(InputError, match="domains names residue 35"):
        sampleEnsemble(structure, "coil", domains=[[35]])


def test_regionsAreAvoided(villin):
    built = buildMissing(villin, [SEQUENCE], seed=4)
    edge = built.positions[~built.isBuilt][:, 2].max() - 0.3
    region = f"z > {edge:.3f}"
    ensemble = sampleEnsemble(villin, "coil", conformers=30, seed=4, missing=True, sequences=[SEQUENCE], avoid=[region])
    assert not readRegion(region).holds(ensemble.positions[:, built.isBuilt]).any()
    with pytest.raises(InputError, match=r"cannot leave the region to avoid: z < 1000"):
        sampleEnsemble(villin, "coil", seed=4, missing=True, sequences=[SEQUENCE], avoid=["z < 1000"])


def test_biasesMakeSecondaryStructure(tmp_path):
    ensemble = sampleEnsemble("GSTEARKLADVFGSTEARKL", "coil", conformers=30, seed=1, bias=["6-16:helix"])
    frames = mdtraj.Trajectory(ensemble.positions, mdtraj.Topology.from_openmm(ensemble.topology))
    isHelix = mdtraj.compute_dssp(frames) == "H"
    assert isHelix[:, 6:14].mean() > 0.9 and isHelix[:, [1, 18]].mean() < 0.1
    counts = np.zeros((12, 12), dtype=int)
    counts[2, 10] = 1  # φ from −120 to −90 degrees, ψ from 120 to 150
    rows = [f"ALA,{30 * row - 180},{' '.join(map(str, line))}" for row, line in enumerate(counts)]
    path = tmp_path / "own.csv"
    path.write_text("residue,phi,counts\n" + "\n".join(rows), encoding="utf-8")
    ensemble = sampleEnsemble("GAAAAG", "coil", conformers=30, seed=1, bias=[f"2-5:{path}"])
    frames = mdtraj.Trajectory(ensemble.positions, mdtraj.Topology.from_openmm(ensemble.topology))
    phi = np.degrees(mdtraj.compute_phi(frames)[1][:, :4])
    assert ((phi > -120) & (phi < -90)).mean() > 0.9
    for bias, message in (
        ("2-5", "'2-5' is no bias"),
        ("2-5:coil", "'2-5:coil' is no bias"),
        ("20-25:helix", "20-25: there are no residues"),
        ("2-5:none.csv", "none.csv: No such file"),
        (["2-4:helix", "4-5:extended"], "residue 4 has two biases"),
    ):
        with pytest.raises(InputError, match=message):
            sampleEnsemble("GAAAAG", "coil", bias=bias)


def test_textsOfRegions():
    slab = readRegion("z>=-2 and z < 2.5e0")
    assert slab.conditions == [("z", ">", -2), ("z", "<", 2.5)] and str(slab) == "z > -2 and z < 2.5"
    points = np.array([[0, 0, -3], [0, 0, 0], [0, 0, 3.0]])
    assert slab.holds(points).tolist() == [False, True, False]
    for text in ("", "z", "z < ", "w < 1", "z < 1 or z > 2", "z < nan", "z < 1e999", "z < 1 nm"):
        with pytest.raises(InputError, match="is no region"):
            readRegion(text)


def test_theLikenessOfFixedAtomsHasTheirShape(villin):
    built = buildMissing(villin, [SEQUENCE], seed=4)
    shape = CoilShape(built, built.positions, built.isBuilt)
    masses = np.array([atom.element.mass.value_in_unit(unit.dalton) for atom in built.topology.atoms()])
    expected = shapesOf(built.positions[np.newaxis], masses)
    values = shape.valuesOf(shape.frameOf(built.positions)[np.newaxis])
    assert values["radius of gyration"] == pytest.approx(expected.radiusOfGyration, rel=1e-6)
    assert values["asphericity"] == pytest.approx(expected.asphericity, rel=1e-6)


# ---- The command ----


def run(capsys, *arguments):
    status = main(["ensemble", *map(str, arguments)])
    return status, *capsys.readouterr()


@pytest.fixture
def fasta(tmp_path):
    path = tmp_path / "whole.fasta"
    path.write_text(f">villin with a tail\n{SEQUENCE}\n", encoding="utf-8")
    return path


def test_theCommandSamplesTails(villin, fasta, tmp_path, capsys):
    arguments = (villin, "--missing", "--sequence", fasta, "--model", "coil", "--conformers", 20, "--seed", 5)
    status, printed, errors = run(capsys, *arguments, "--json", "all.json")
    folder = tmp_path / "villin-ensemble"
    assert (
        status == 0 and errors == "" and "note: tails built (1): 6 residues (GLY SER THR …) behind A:PHE 35" in printed
    )
    assert "gaps that stay open" in printed
    trajectory = mdtraj.load(folder / "villin.dcd", top=folder / "villin-topology.pdb")
    ensemble = sampleEnsemble(villin, "coil", conformers=20, seed=5, missing=True, sequences=[SEQUENCE])
    assert trajectory.xyz == pytest.approx(ensemble.positions, abs=1e-5)
    with open(folder / "villin.csv", encoding="utf-8", newline="") as file:
        assert len(list(csv.DictReader(file))) == 20
    summary = json.loads((tmp_path / "all.json").read_text(encoding="utf-8"))["proteins"][0]
    assert summary["residues"] == 37 and summary["isComplete"] and (folder / "villin.png").stat().st_size > 10000
    assert run(capsys, *arguments, "--resume")[0] == 0
    assert "was made with avoid" in run(capsys, *arguments, "--resume", "--avoid", "z < -9")[2]


def test_theCommandSamplesSequences(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "two.fasta").write_text(">a\nGSTEAR\n>b\nMXK\n", encoding="utf-8")
    status, _, errors = run(capsys, "two.fasta", "--model", "coil", "--conformers", 20, "--pictures", 0)
    assert status == 2 and "1 of 2 proteins failed; the first: b: 'X' in a sequence is no amino acid" in errors
    assert (tmp_path / "two-ensemble" / "a.dcd").exists()


def test_errorsOfTheCommand(villin, fasta, tmp_path, capsys):
    (tmp_path / "bad.csv").write_text("residue,phi,counts\nALA,-180,1\n", encoding="utf-8")
    (tmp_path / "other.fasta").write_text(">x\nWWWWWWWWWWWWWWW\n", encoding="utf-8")
    coil = (villin, "--model", "coil")
    for arguments, message in (
        ((villin, "--missing"), "--missing needs --model coil"),
        ((villin, "--avoid", "z < 0"), "--avoid needs --model coil"),
        (coil, "there is a gap between A:MET 12 and A:PHE 17, beside residues that would move"),
        ((fasta, "--model", "coil", "--missing"), "--missing needs a structure"),
        ((*coil, "--sequence", fasta), "--sequence needs --missing"),
        ((*coil, "--missing", "--domains", "1-5"), "--domains needs a structure without missing residues"),
        ((*coil, "--missing", "--sequence", "none.fasta"), "none.fasta: No such file"),
        ((*coil, "--missing"), "no residue is missing"),
        ((*coil, "--missing", "--sequence", "other.fasta"), "chains that differ from all given sequences"),
        ((*coil, "--missing", "--sequence", fasta, "--coil-tables", "bad.csv"), "ALA must have as many columns"),
        ((*coil, "--missing", "--sequence", fasta, "--avoid", "z"), "'z' is no region"),
        ((*coil, "--missing", "--sequence", fasta, "--bias", "3-4:beta"), "'3-4:beta' is no bias"),
    ):
        status, _, errors = run(capsys, *arguments)
        assert status == 2 and message in errors, (arguments, errors)
        assert not (tmp_path / "villin-ensemble").exists()
