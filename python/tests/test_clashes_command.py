"""The command openmm-chaintree clashes, as a user runs it."""

import csv
import json
import re
import subprocess

import commands
import pytest
from commands import assertRefused, filesIn
from openmm import app, unit
from openmmchaintree import findClashes
from scenes import GLYCINES, realStructurePath, writeDCD, writeLongTrajectory, writePDB


def run(*arguments, folder):
    return commands.run("clashes", *arguments, folder=folder)


@pytest.fixture
def runHere(runCommandHere):
    return lambda *arguments: runCommandHere("clashes", *arguments)


@pytest.fixture
def trajectory(villin, tmp_path):
    """villin.pdb and villin.dcd in tmp_path: three frames with 1, 0 and 1 clashes."""
    with open(tmp_path / "villin.pdb", "w") as file:
        app.PDBFile.writeFile(villin.topology, villin.positions * unit.nanometer, file)
    writeDCD(tmp_path / "villin", villin.topology, [villin.positions, 3 * villin.positions, villin.positions])
    return "villin.pdb", "villin.dcd"


def test_villinByDefault(tmp_path):
    result = run(folder=tmp_path)
    assert result.returncode == 0 and result.stderr == ""
    assert filesIn(tmp_path) == []
    assert "582 of 8,867 atoms looked at, all-atom radii" in result.stdout
    assert "1 clash, 1.7 per 1,000 atoms" in result.stdout
    assert "0.0464  PHE 10 CE1  LYS 32 HE2" in result.stdout


def test_noClash(runHere, tmp_path):
    writePDB(tmp_path / "glycines.pdb", GLYCINES)
    result = runHere("glycines.pdb", "--picture", "a.svg")
    assert result.returncode == 0
    assert result.stdout.splitlines()[1:] == ["0 clashes, 0.0 per 1,000 atoms", "wrote a.svg"]
    assert "\N{MINUS SIGN}" not in (tmp_path / "a.svg").read_text(encoding="utf-8")  # no axis of clashes goes below 0


def test_filesOfAStructure(runHere, tmp_path):
    path = realStructurePath("4hhb.pdb")
    result = runHere(path, "--csv", "a.csv", "--json", "a.json", "--picture", "a.png", "--rows", 3)
    assert result.returncode == 0 and result.stderr == ""
    assert "wrote a.csv, a.json, a.png" in result.stdout
    (frame,) = findClashes(path)
    assert f"worst clashes ({len(frame.clashes) - 3} more not shown)" in result.stdout

    summary = json.loads((tmp_path / "a.json").read_text())
    assert summary["structure"] == str(path) and summary["trajectory"] is None
    assert summary["radii"] == "united-atom" and summary["damage"] is None
    assert summary["overlapTolerance"] == 0.04 and summary["hydrogenBondAllowance"] == 0.06
    (written,) = summary["frames"]
    assert written["index"] == 0
    assert written["clashesPer1000Atoms"] == frame.clashesPer1000Atoms == summary["clashesPer1000Atoms"]
    assert [
        (clash["particle1"], clash["particle2"], tuple(clash["atom1"].values()), clash["overlap"])
        for clash in written["clashes"]
    ] == [(clash.particle1, clash.particle2, clash.atom1, clash.overlap) for clash in frame.clashes]
    counts = {}
    for clash in frame.clashes:
        for residue in {clash.atom1[:2], clash.atom2[:2]}:
            counts[":".join(residue)] = counts.get(":".join(residue), 0) + 1
    assert {entry["residue"]: entry["clashes"] for entry in summary["residues"]} == counts
    assert summary["residues"][0] == {
        "residue": "D:HEM 148", "clashes": 5, "frames": 1, "worstFrame": 0,
        "worstOverlap": max(clash.overlap for clash in frame.clashes if "HEM 148" in clash.atom2.residue),
    }  # fmt: skip
    assert written["worstResidues"] == [entry["residue"] for entry in summary["residues"][:5]]

    with open(tmp_path / "a.csv", newline="") as file:
        lines = list(csv.DictReader(file))
    assert len(lines) == len(frame.clashes)
    for line, clash in zip(lines, frame.clashes, strict=True):
        assert (line["frame"], int(line["particle1"]), int(line["particle2"])) == ("0", *clash[:2])
        assert (line["chain1"], line["residue1"], line["atom1"]) == clash.atom1
        assert (line["chain2"], line["residue2"], line["atom2"]) == clash.atom2
        assert float(line["overlap_nm"]) == pytest.approx(clash.overlap, abs=1e-6)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_filesOfATrajectory(runHere, tmp_path, trajectory):
    result = runHere(*trajectory, "--csv", "a.csv", "--json", "a.json", "--picture", "a.svg")
    assert result.returncode == 0 and result.stderr == ""
    assert "3 frames: 0.7 clashes a frame (0 to 1), 1.1 per 1,000 atoms" in result.stdout
    assert re.search(r"67 +0\.0464 +0 +A:PHE 10 CE1 +A:LYS 32 HE2", result.stdout)
    summary = json.loads((tmp_path / "a.json").read_text())
    assert [frame["index"] for frame in summary["frames"]] == [0, 1, 2]
    assert [len(frame["clashes"]) for frame in summary["frames"]] == [1, 0, 1]
    (pair,) = summary["pairs"]
    assert pair["atoms"] == ["A:PHE 10 CE1", "A:LYS 32 HE2"] and pair["frames"] == pair["clashes"] == 2
    assert [line.split(",")[0] for line in (tmp_path / "a.csv").read_text().splitlines()] == ["frame", "0", "2"]
    assert b"<svg" in (tmp_path / "a.svg").read_bytes()


def test_modelsAreCalledModels(runHere):
    result = runHere(realStructurePath("1l2y.pdb"))
    assert "38 models: 1.6 clashes a model (0 to 4)" in result.stdout and "frame" not in result.stdout


def test_options(runHere, villin):
    path = realStructurePath("1htb.pdb")
    counts = {
        options: runHere(path, *options).stdout.split(" of ")[0].split()[-1]
        for options in [(), ("--ions",), ("--water",), ("--water", "--ions")]
    }
    assert counts[()] == "5,656" and len(set(counts.values())) == 4
    assert "all-atom radii" in runHere("--radii", "all-atom").stdout
    heavy = sum(atom.element.symbol != "H" for atom in villin.topology.atoms())
    assert f" {heavy} of 8,867 atoms looked at, united-atom radii" in runHere("--radii", "united-atom").stdout


# ---- On a terminal and in a pipe ----


def test_progressBarOnATerminal(tmp_path, trajectory):
    status, _, shown = commands.runOnATerminal("clashes", *trajectory, folder=tmp_path)
    assert status == 0 and "3/3" in shown


def test_nobodyReads(tmp_path):
    process = subprocess.Popen(
        [*commands.COMMAND, "clashes"], cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    process.stdout.close()
    assert process.stderr.read() == b""
    assert process.wait() == 141


def test_interruptLeavesWhatThereIs(tmp_path, villin):
    arguments = writeLongTrajectory(tmp_path, villin)
    status, output, shown = commands.runOnATerminal(
        *("clashes", *arguments, "--json", "a.json"), folder=tmp_path, interruptAt=r"[1-9]\d*/50001"
    )
    assert status == 130
    assert "Traceback" not in shown and "openmm-chaintree:" not in shown
    assert "interrupted: these are the clashes of the frames before" in output
    summary = json.loads((tmp_path / "a.json").read_text())
    assert summary["interrupted"] and 0 < len(summary["frames"]) < 50001


# ---- Bad input ----


def test_damagedTrajectoryKeepsWhatComesBefore(runHere, tmp_path, trajectory):
    path = tmp_path / trajectory[1]
    path.write_bytes(path.read_bytes()[:-5])
    result = runHere(*trajectory, "--json", "a.json", "--csv", "a.csv", "--picture", "a.png")
    assert result.returncode == 2
    damage = "villin.dcd: frame 2 (from 0) is cut off"
    assert result.stderr == f"openmm-chaintree: {damage}; the results cover the frames before it\n"
    assert "2 frames: 0.5 clashes a frame" in result.stdout
    summary = json.loads((tmp_path / "a.json").read_text())
    assert summary["damage"] == damage and len(summary["frames"]) == 2
    assert len((tmp_path / "a.csv").read_text().splitlines()) == 2
    assert (tmp_path / "a.png").exists()


def test_damagedBeforeAnyFrame(runHere, tmp_path, trajectory):
    path = tmp_path / trajectory[1]
    path.write_bytes(path.read_bytes()[:400])
    result = runHere(*trajectory, "--json", "a.json", "--csv", "a.csv", "--picture", "a.png")
    assertRefused(result, tmp_path, ["villin.dcd", "villin.pdb"], "villin.dcd: not a DCD file, or damaged at its start")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["none.pdb"], "none.pdb: No such file"),
        (["."], ".: Is a directory"),
        (["glycines.pdb", "none.xtc"], "none.xtc: No such file"),
        (["glycines.pdb", "glycines.pdb"], "glycines.pdb: is not named as a trajectory"),
        (["glycines.pdb", "glycines.pdb", "more"], "unrecognized arguments: more"),
        (["--rows", "0"], "--rows"),
        (["--radii", "bondi"], "'bondi'"),
        (["--json", "missing/a.json"], "there is no folder missing"),
        (["--csv", "a", "--json", "a"], "a: is named for two outputs"),
        (["--picture", "a.doc"], "a.doc: a picture's name ends in .png, .pdf, .svg"),
        (["glycines.pdb", "--csv", "glycines.pdb"], "glycines.pdb: would overwrite"),
    ],
)
def test_badArguments(runHere, tmp_path, arguments, words):
    writePDB(tmp_path / "glycines.pdb", GLYCINES)
    assertRefused(runHere(*arguments), tmp_path, ["glycines.pdb"], words)


def test_trajectoryIsNotOverwritten(runHere, tmp_path, trajectory):
    result = runHere(*trajectory, "--json", "./villin.dcd")
    assertRefused(result, tmp_path, ["villin.dcd", "villin.pdb"], "villin.dcd: would overwrite a file that is read")
