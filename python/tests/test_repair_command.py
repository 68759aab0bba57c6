"""The command repair: files, exit statuses, errors."""

import gzip
import json

import gemmi
import numpy as np
import pytest
from openmm import app
from repairmodels import asPDB, villinPacked


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """A PDB file of villin with clashes."""
    path = tmp_path_factory.mktemp("repair") / "model.pdb"
    path.write_text(asPDB(*villinPacked()))
    return path


def test_theFileDiffersInCoordinatesOnly(runCommandHere, model, tmp_path):
    result = runCommandHere("repair", model, "--json", "a.json", "--csv", "a.csv", "-o", "a.pdb")
    assert result.returncode == 0, result.stderr
    before, after = model.read_text().splitlines(), (tmp_path / "a.pdb").read_text().splitlines()
    assert len(before) == len(after)
    assert all(old[:30] + old[54:] == new[:30] + new[54:] for old, new in zip(before, after, strict=True))
    assert before != after
    summary = json.loads((tmp_path / "a.json").read_text())
    (only,) = summary["models"]
    assert summary["isClean"] and only["clashscoreAfter"] <= 2 < only["clashscoreBefore"]
    assert "clashscore" in result.stdout and "written: a.pdb" in result.stdout
    lines = (tmp_path / "a.csv").read_text().splitlines()
    assert len(lines) == 36 and lines[1].startswith("0,A:LEU 1,")
    # The files say what happened.
    old, new = (gemmi.read_pdb(str(path))[0] for path in (model, tmp_path / "a.pdb"))
    places = [np.array([r["CA"][0].pos.tolist() for c in m for r in c]) for m in (old, new)]
    shifts = 0.1 * np.linalg.norm(places[1] - places[0], axis=1)
    assert only["traceShiftLargest"] == pytest.approx(shifts.max(), abs=2e-4)


def test_whatIsNotClean(runCommandHere, model, tmp_path):
    result = runCommandHere("repair", model, "--fix", "not resSeq 35", "--clean", "0.5")
    assert result.returncode == 3
    assert "not clean" in result.stdout and "held" in result.stdout
    assert (tmp_path / "model-repaired.pdb").exists()


def test_hydrogens(runCommandHere, model, tmp_path):
    def hydrogensOf(name):
        topology = app.PDBFile(str(tmp_path / name)).topology
        return sum(atom.element is app.element.hydrogen for atom in topology.atoms())

    runCommandHere("repair", model, "--hydrogens", "none", "-o", "none.pdb")
    assert hydrogensOf("none.pdb") == 0
    runCommandHere("repair", "none.pdb", "--hydrogens", "add", "-o", "add.pdb")
    assert hydrogensOf("add.pdb") > 280
    runCommandHere("repair", "none.pdb", "-o", "keep.pdb")
    assert hydrogensOf("keep.pdb") == 0


def test_mmCIF(runCommandHere, model, tmp_path):
    gemmi.read_structure(str(model)).make_mmcif_document().write_file(str(tmp_path / "m.cif"))
    result = runCommandHere("repair", "m.cif")
    assert result.returncode == 0, result.stderr
    assert "clean" in result.stdout
    assert (tmp_path / "m-repaired.cif").read_text().startswith("data_")


@pytest.mark.parametrize(
    "arguments, message",
    [
        (["missing.pdb"], "missing.pdb: No such file"),
        (["empty.pdb"], "empty.pdb: there are no atoms"),
        (["MODEL", "--interface", "A"], "does not name two chains"),
        (["MODEL", "--interface", "A,A"], "does not name two chains"),
        (["MODEL", "--interface", "A,B"], "there is no chain 'B'"),
        (["MODEL", "--max-shift", "0"], "not in the range"),
        (["MODEL", "--max-shift", "far"], "not a number"),
        (["MODEL", "-o", "x.cif"], "of the kind of the given one"),
        (["MODEL", "-o", "MODEL", "--overwrite"], "would overwrite a file that is read"),
        (["MODEL", "-o", "empty.pdb"], "--overwrite replaces it"),
        (["MODEL", "--fix", "resname XYZ"], "selects no atom"),
        (["MODEL", "--fix", "nonsense ("], "not in MDTraj's selection language"),
        (["MODEL", "--hydrogens", "al"], "invalid choice"),
        (["MODEL", "--seed", "0"], "not in the range"),
        ([], "required: structure"),
    ],
)
def test_errors(runCommandHere, model, tmp_path, arguments, message):
    (tmp_path / "empty.pdb").write_text("")
    result = runCommandHere("repair", *(str(model) if word == "MODEL" else word for word in arguments))
    assert result.returncode == 2
    assert message in result.stderr and len(result.stderr.splitlines()) == 1
    assert sorted(path.name for path in tmp_path.iterdir()) == ["empty.pdb"]
    assert (tmp_path / "empty.pdb").read_text() == ""


def test_aFolder(runCommandHere, model, tmp_path):
    """Files are repaired as alone; a second run keeps them; a damaged file fails alone."""
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "a.pdb").write_text(model.read_text())
    (tmp_path / "models" / "b.pdb.gz").write_bytes(gzip.compress(model.read_bytes()))
    (tmp_path / "models" / "notes.txt").write_text("no model")
    result = runCommandHere("repair", "models", "-o", "out", "--workers", "2", "--json", "all.json")
    assert result.returncode == 0, result.stderr
    assert "repaired 2 of 2 files to out: 2 clean" in result.stdout
    alone = runCommandHere("repair", model, "-o", "alone.pdb")
    assert alone.returncode == 0
    expected = (tmp_path / "alone.pdb").read_bytes()
    assert (tmp_path / "out" / "a.pdb").read_bytes() == expected
    assert gzip.decompress((tmp_path / "out" / "b.pdb.gz").read_bytes()) == expected
    table = (tmp_path / "out" / "summary.csv").read_text()
    assert [line.split(",")[0] for line in table.splitlines()] == ["structure", "a.pdb", "b.pdb.gz"]
    assert len(json.loads((tmp_path / "all.json").read_text())["structures"]) == 2

    (tmp_path / "models" / "c.pdb").write_text("nothing")
    refused = runCommandHere("repair", "models", "-o", "out")
    assert refused.returncode == 2 and "--resume keeps repaired files" in refused.stderr
    other = runCommandHere("repair", "models", "-o", "out", "--resume", "--seed", "2")
    assert other.returncode == 2 and "other options" in other.stderr
    times = (tmp_path / "out" / "a.pdb").stat().st_mtime_ns
    resumed = runCommandHere("repair", "models", "-o", "out", "--resume")
    assert resumed.returncode == 2
    assert "1 of 3 files failed" in resumed.stderr and "c.pdb: there are no atoms" in resumed.stderr
    assert (tmp_path / "out" / "a.pdb").stat().st_mtime_ns == times
    assert (tmp_path / "out" / "summary.csv").read_text() == table


def test_wrongFolders(runCommandHere, tmp_path):
    (tmp_path / "empty").mkdir()
    for arguments, message in (
        (["empty"], "there is no PDB or mmCIF file"),
        (["empty", "-o", "empty"], "another folder than that of the models"),
        (["empty", "--csv", "a.csv"], "--csv needs one model"),
        (["x.pdb", "--resume"], "--resume needs a folder of models"),
    ):
        result = runCommandHere("repair", *arguments)
        assert result.returncode == 2 and message in result.stderr
