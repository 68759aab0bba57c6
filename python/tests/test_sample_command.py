"""The command openmm-chaintree sample, as a user runs it."""

import json
import os
from pathlib import Path

import commands
import numpy as np
import pytest
from commands import assertRefused, filesIn
from openmm import app, unit
from openmmchaintree.command.sampling import Sampling
from scenes import GLYCINES, readDCD, realStructurePath, writePDB


def run(*arguments, folder):
    return commands.run("sample", *arguments, folder=folder)


@pytest.fixture
def runHere(runCommandHere):
    return lambda *arguments: runCommandHere("sample", *arguments)


def readPositions(path):
    pdb = app.PDBFile(str(path))
    return pdb.getPositions(asNumpy=True).value_in_unit(unit.nanometer)


def test_villinByDefault(tmp_path):
    result = run("--trials", 5000, "--frames", 20, "--seed", 1, "--json", "summary.json", folder=tmp_path)
    assert result.returncode == 0, result.stderr
    assert result.stderr == ""
    assert filesIn(tmp_path) == ["summary.json", *commands.VILLIN_FILES]

    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["trials"] == 5000 and summary["seed"] == 1 and not summary["interrupted"]
    assert summary["atoms"] == 582 and summary["fixedAtoms"] == 0
    assert summary["torsions"] == {"phi": 33, "psi": 34, "chi1": 29, "chi2": 25, "chi3": 11, "chi4": 6}
    for move in summary["moves"]:
        assert move["attempted"] == move["clashed"] + move["rejectedByEnergy"] + move["accepted"] > 0
        assert move["notMade"] == 0
    assert [move["name"] for move in summary["moves"]] == [
        *(f"{torsions} ±{size}°" for torsions, size in (("φ/ψ", 5), ("φ/ψ", 30), ("φ/ψ", 180), ("χ", 30), ("χ", 180)))
    ]
    assert sum(move["attempted"] for move in summary["moves"]) == 5000
    assert sum(move["accepted"] for move in summary["moves"]) > 500
    assert summary["trialsPerSecond"] == pytest.approx(5000 / summary["secondsInSteps"])
    assert summary["microsecondsPerTrial"] == pytest.approx(1e6 * summary["secondsInSteps"] / 5000)
    assert summary["clashesAtStart"] == 1 and summary["pairsBeyondLimit"] == []

    frames = readDCD(tmp_path / "villin.dcd")
    topology = app.PDBFile(str(tmp_path / "villin-topology.pdb")).topology
    assert summary["frames"] == 21 and frames.shape == (21, topology.getNumAtoms(), 3)
    assert (tmp_path / "villin.png").read_bytes().startswith(b"\x89PNG")

    for heading in ("attempted", "clashed", "rejected", "accepted"):
        assert heading in result.stdout
    assert "not made" not in result.stdout
    assert "µs a trial" in result.stdout and "trials a second" in result.stdout
    assert "none beyond its limit" in result.stdout
    assert 0 < summary["largestBondChange"] < 1e-12 and summary["changedBonds"] == []
    assert f"largest change of a bond's length: {summary['largestBondChange']:.1g} nm" in result.stdout
    assert "21 frames, the first of them the start" in result.stdout


def test_theStartIsFirst(runHere, tmp_path, villin):
    for name in ("first", "second"):
        runHere("--trials", 400, "--frames", 2, "-o", name)
        frames = readDCD(tmp_path / f"{name}.dcd")
        assert len(frames) == 3
        assert frames[0] == pytest.approx(villin.positions, abs=1e-5)
        assert np.abs(frames[1] - frames[0]).max() > 0.01


def test_aPairBeyondItsLimitIsReported(runHere, tmp_path, monkeypatch):
    """Were the engine wrong, the check of the last positions would say so: here an atom is put onto another."""
    honest = Sampling.positions

    def corrupt(sampling):
        positions = honest(sampling)
        positions[500] = positions[100]
        return positions

    monkeypatch.setattr(Sampling, "positions", corrupt)
    result = runHere("--trials", 100, "--frames", 1, "--json", "summary.json")
    assert result.returncode == 1
    assert "beyond its limit: " in result.stdout
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert [100, 500] in [pair["particles"] for pair in summary["pairsBeyondLimit"]]


def test_aChangedBondIsReported(runHere, tmp_path, monkeypatch):
    """Were the engine wrong, the lengths of bonds would say so: here an atom moves by less than makes a clash."""
    honest = Sampling.positions

    def corrupt(sampling):
        positions = honest(sampling)
        bonds = [sampling.force.getBondParticles(i) for i in range(sampling.force.getNumBonds())]
        (partner,) = [sum(bond) - 581 for bond in bonds if 581 in bond]
        positions[581] += 3e-9 / 0.125 * (positions[581] - positions[partner])
        return positions

    monkeypatch.setattr(Sampling, "positions", corrupt)
    result = runHere("--trials", 100, "--frames", 1, "--json", "summary.json")
    assert result.returncode == 1
    summary = json.loads((tmp_path / "summary.json").read_text())
    (bond,) = summary["changedBonds"]
    assert f"  bond changed: {' – '.join(bond['atoms'])}, by {bond['change']:.3g} nm" in result.stdout.splitlines()
    assert summary["pairsBeyondLimit"] == [] and 581 in bond["particles"]
    assert bond["change"] == summary["largestBondChange"] == pytest.approx(3e-9, rel=0.1)


def test_toleratedPairsAreExplained(runHere, tmp_path):
    above = [line.replace(" A ", " B ").replace("   0.000  1.00", "   3.200  1.00") for line in GLYCINES]
    structure = writePDB(tmp_path / "close.pdb", [*GLYCINES, "TER", *above])
    result = runHere(structure, "--trials", 1, "--seed", 1)
    assert result.returncode == 0, result.stderr
    explanation = "tolerated pairs clashed at the start: they may still overlap, but never by more"
    lines = result.stdout.splitlines()
    assert lines[lines.index(explanation) + 1].startswith("  tolerated: A:GLY ")
    villin = runHere("--trials", 1000, "--seed", 1, "-o", "villin")
    assert "0 tolerated (1 clashed" in villin.stdout and explanation not in villin.stdout


def test_bondLengthsAndAnglesAreKept(tmp_path):
    run("--trials", 2000, "--frames", 4, "--seed", 1, folder=tmp_path)
    start = readPositions(tmp_path / "villin-topology.pdb")
    last = readDCD(tmp_path / "villin.dcd")[-1]
    topology = app.PDBFile(str(tmp_path / "villin-topology.pdb")).topology
    bonds = np.array([(bond[0].index, bond[1].index) for bond in topology.bonds()])

    def lengths(positions):
        return np.linalg.norm(positions[bonds[:, 0]] - positions[bonds[:, 1]], axis=1)

    assert lengths(last) == pytest.approx(lengths(start), abs=2e-4)  # PDB files have three decimals, in Å
    assert np.abs(last - start).max() > 0.1


def test_sameSeedSameFrames(tmp_path):
    for name in ("first", "second"):
        run("--trials", 1000, "--frames", 3, "--seed", 9, "-o", name, folder=tmp_path)
    assert np.array_equal(readDCD(tmp_path / "first.dcd"), readDCD(tmp_path / "second.dcd"))


def test_lastFrameHoldsTheRemainder(tmp_path):
    run("--trials", 1000, "--frames", 3, "--seed", 9, "--json", "summary.json", folder=tmp_path)
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["trials"] == 1000 and summary["frames"] == 4 == len(summary["radiusOfGyration"])


def test_interruptLeavesWhatThereIs(tmp_path):
    status, output, shown = commands.runOnATerminal(
        *("sample", "--trials", 10**9, "--frames", 10**6, "--seed", 1, "--json", "summary.json"),
        folder=tmp_path,
        interruptAt=r"[1-9]\d{5,}/1000000000",  # after the first rounds of 10,000 trials
    )
    assert status == 130
    assert "Traceback" not in shown and "openmm-chaintree:" not in shown
    assert "interrupted" in output and "accepted" in output
    summary = json.loads((tmp_path / "summary.json").read_text())
    frames = readDCD(tmp_path / "villin.dcd")
    assert summary["interrupted"] and summary["frames"] == len(frames) > 1
    assert np.all(np.isfinite(frames))
    assert (tmp_path / "villin.png").exists()


def test_progressBarOnATerminal(tmp_path):
    status, _, shown = commands.runOnATerminal("sample", "--trials", 20000, folder=tmp_path)
    assert status == 0
    assert "20000/20000" in shown


_XENON = [
    "HETATM    9 XE1  XEN B   1       9.000   9.000   9.000  1.00  0.00          XE",
    "HETATM   10 XE2  XEN B   1      15.000   9.000   9.000  1.00  0.00          XE",
]


def test_smallestProtein(tmp_path):
    """Two residues: no residue with both φ and ψ, no χ."""
    structure = writePDB(tmp_path / "glycines.pdb", GLYCINES)
    result = run(structure, "--trials", 500, "--frames", 5, folder=tmp_path)
    assert result.returncode == 0, result.stderr
    assert filesIn(tmp_path) == [
        *(f"glycines{ending}" for ending in ("-settings.toml", "-topology.pdb", ".checkpoint", ".csv")),
        *(f"glycines{ending}" for ending in (".dcd", ".pdb", ".png")),
    ]
    assert "1 phi, 1 psi" in result.stdout


def test_firstConformerAndModelCount(tmp_path):
    other = [line[:16] + "B" + line[17:30] + "   9.000" + line[38:] for line in GLYCINES[3:4]]
    lines = ["MODEL        1", *GLYCINES[:3], GLYCINES[3][:16] + "A" + GLYCINES[3][17:], *other, *GLYCINES[4:]]
    moved = [line[:30] + "  99.000" + line[38:] for line in GLYCINES]
    structure = writePDB(tmp_path / "two.pdb", [*lines, "ENDMDL", "MODEL        2", *moved, "ENDMDL"])
    result = run(structure, "--trials", 100, "--frames", 1, folder=tmp_path)
    assert result.returncode == 0, result.stderr
    positions = readPositions(tmp_path / "two-topology.pdb")
    assert positions[3] == pytest.approx([0.12, 0.238, 0.0], abs=1e-4)


def test_otherMoleculesAreFixedWaterAndIonsLeftOut(tmp_path):
    lines = [
        *GLYCINES,
        "TER",
        "HETATM    9  C1  LIG B   1       0.000   9.000   0.000  1.00  0.00           C",
        "HETATM   10  O1  LIG B   1       1.200   9.000   0.000  1.00  0.00           O",
        "HETATM   11 ZN    ZN B   2       0.000  15.000   0.000  1.00  0.00          ZN",
        "HETATM   12  O   HOH B   3       0.000  20.000   0.000  1.00  0.00           O",
    ]
    structure = writePDB(tmp_path / "ligand.pdb", lines)
    result = run(structure, "--trials", 500, "--frames", 5, "--json", "summary.json", folder=tmp_path)
    assert result.returncode == 0, result.stderr
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["atoms"] == 10 and summary["fixedAtoms"] == 2
    frames = readDCD(tmp_path / "ligand.dcd")
    assert np.array_equal(frames[0, 8:], frames[-1, 8:])
    assert not np.array_equal(frames[0, :8], frames[-1, :8])


def test_missingFile(tmp_path):
    assertRefused(run("nothing.pdb", folder=tmp_path), tmp_path, [], "nothing.pdb", "No such file")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "there are no atoms"),
        ("not a structure\n", "there are no atoms"),
        ("\n".join(GLYCINES).replace("1.450", "a.bcd"), "line 2 has no coordinates"),
        ("\n".join(GLYCINES).replace("1.450", "  nan"), "atom CA of A:GLY 1 has a coordinate that is not a finite"),
        (GLYCINES[0].replace(" N ", " O ").replace("GLY", "HOH"), "nothing but water and ions"),
        ("\n".join(GLYCINES[:4]), "no torsion of a protein"),
        ("\n".join([*GLYCINES, *_XENON]), "B:XEN 1 XE1, xenon"),
    ],
)
def test_badStructure(runHere, tmp_path, content, words):
    (tmp_path / "bad.pdb").write_text(content)
    assertRefused(runHere("bad.pdb"), tmp_path, ["bad.pdb"], "bad.pdb", words)


def test_binaryFile(runHere, tmp_path):
    (tmp_path / "bad.pdb").write_bytes(bytes(range(256)) * 10)
    assertRefused(runHere("bad.pdb"), tmp_path, ["bad.pdb"], "bad.pdb")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--trials", "0"], "--trials"),
        (["--trials", "many"], "'many' is not a whole number"),
        (["--frames", "-1"], "--frames"),
        (["--seed", "0"], "--seed"),
        (["--seed", "2147483648"], "--seed"),
        (["--unknown"], "--unknown"),
        (["-o", "missing/run"], "missing/run.dcd: there is no folder missing"),
        (["-o", ""], "-o '': the names of output files need a beginning, such as villin"),
        (["-o", "."], "-o .: the names of output files need a beginning, such as ./villin"),
        (["-o", ".."], "-o ..: the names of output files need a beginning, such as ../villin"),
        (["-o", "runs/"], "-o runs/: the names of output files need a beginning, such as runs/villin"),
        (["--json", ""], "the name of the json file is empty"),
        (["--json", "missing/run.json"], "there is no folder missing"),
        (["--json", "."], "is a folder"),
    ],
)
def test_badArguments(runHere, tmp_path, arguments, words):
    assertRefused(runHere(*arguments), tmp_path, [], words)


def test_structureIsNotOverwritten(runHere, tmp_path):
    structure = writePDB(tmp_path / "run-topology.pdb", GLYCINES)
    before = structure.read_bytes()
    result = runHere(structure, "-o", "run")
    assertRefused(result, tmp_path, ["run-topology.pdb"], "run-topology.pdb", "would overwrite")
    assert structure.read_bytes() == before


def test_unwritableFile(runHere, tmp_path):
    folder = tmp_path / "locked"
    folder.mkdir()
    folder.chmod(0o500)
    path = folder / "run"
    if os.access(folder, os.W_OK):  # the superuser may write everywhere, but not into /proc
        path = Path("/proc/run")
        if not path.parent.is_dir():
            pytest.skip("there is no place where this user may not write")
    assertRefused(runHere("-o", path), tmp_path, ["locked"], str(path), "cannot be written")
    assertRefused(runHere("--json", path), tmp_path, ["locked"], str(path), "cannot be written")


@pytest.mark.parametrize("name", ["1l2y", "bpti_h", "4hhb"])
def test_realStructure(tmp_path, name):
    path = realStructurePath(f"{name}.pdb")
    result = run(path, "--trials", 2000, "--frames", 4, "--seed", 2, "--json", "summary.json", folder=tmp_path)
    assert result.returncode == 0, result.stderr
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["pairsBeyondLimit"] == []
    # Disulfides make one rigid part of most of the backbone.
    assert summary["fixedAtoms"] == (374 if name == "bpti_h" else 0)
    frames = readDCD(tmp_path / f"{name}.dcd")
    assert frames.shape == (5, summary["atoms"], 3)
    if name == "4hhb":
        atoms = list(app.PDBFile(str(tmp_path / "4hhb-topology.pdb")).topology.atoms())
        irons = [atom.index for atom in atoms if atom.name == "FE"]
        histidines = [atom.index for atom in atoms if atom.name == "NE2" and atom.residue.id in ("87", "92")]
        distances = np.linalg.norm(frames[:, irons, None] - frames[:, None, histidines], axis=-1)
        bound = distances[0] < 0.25
        assert bound.sum() == 4
        assert distances[-1][bound] == pytest.approx(distances[0][bound], abs=1e-5)
    if name == "bpti_h":
        assert "disulfide" in result.stdout
        free = run(path, "--trials", 500, "--cut-disulfides", "-o", "cut", "--json", "cut.json", folder=tmp_path)
        assert free.returncode == 0, free.stderr
        cut = json.loads((tmp_path / "cut.json").read_text())
        assert sum(cut["torsions"].values()) > sum(summary["torsions"].values())
        assert cut["fixedAtoms"] == 0


def test_filesAreNamedAfterTheStructure(tmp_path):
    (tmp_path / "somewhere").mkdir()
    structure = writePDB(tmp_path / "somewhere" / "glycines.pdb", GLYCINES)
    work = tmp_path / "work"
    work.mkdir()
    run(structure, "--trials", 100, folder=work)
    assert filesIn(work) == [name.replace("villin", "glycines") for name in commands.VILLIN_FILES]
    assert filesIn(Path(structure).parent) == ["glycines.pdb"]
