"""The command's options on what is read: the model, notes, and bonds that are cut or missing."""

import json

import pytest
from openmm import app, unit
from scenes import GLYCINES, pdbLine, realStructurePath, writePDB


@pytest.fixture
def sample(runCommandHere):
    return lambda *arguments: runCommandHere("sample", "--trials", 100, "--frames", 1, "--seed", 1, *arguments)


def moved(lines, x, y, z, chain="A", first=1):
    """GLYCINES moved, in a chain of another name."""
    return [
        f"{line[:6]}{first + number:>5}{line[11:21]}{chain}{line[22:30]}"
        f"{float(line[30:38]) + x:8.3f}{float(line[38:46]) + y:8.3f}{float(line[46:54]) + z:8.3f}{line[54:]}"
        for number, line in enumerate(lines)
    ]


def test_model(sample, tmp_path):
    lines = ["MODEL        1", *GLYCINES, "ENDMDL", "MODEL        2", *moved(GLYCINES, 9, 0, 0), "ENDMDL"]
    path = writePDB(tmp_path / "two.pdb", lines)
    assert sample(path, "--model", 1).returncode == 0
    positions = app.PDBFile(str(tmp_path / "two-topology.pdb")).getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    assert positions[0] == pytest.approx([0.9, 0, 0])
    result = sample(path, "--model", 2, "-o", "none")
    assert result.returncode == 2 and "there is no model 2 (from 0), but 2 in all" in result.stderr
    assert "--model" in sample(path, "--model", -1, "-o", "none").stderr


def test_aBondThatIsMissing(sample, tmp_path):
    """A nitrogen of another chain 1.4 Å above a Cα: which of the two it belongs to, the file must say."""
    lines = [*GLYCINES, "TER", *moved(GLYCINES, 3.9, 2.87, 1.4, chain="B", first=11)]
    path = writePDB(tmp_path / "near.pdb", lines)
    result = sample(path)
    assert result.returncode == 2 and not (tmp_path / "near.dcd").exists()
    (line,) = result.stderr.splitlines()
    assert "A:GLY 2 CA – B:GLY 1 N, 0.140 nm" in line and "--allow-unbonded" in line and "CONECT" in line
    result = sample(path, "--allow-unbonded", "--json", "near.json")
    assert result.returncode == 0
    kinds = [note["kind"] for note in json.loads((tmp_path / "near.json").read_text())["notes"]]
    assert kinds == ["unbonded atoms at the distance of a bond, which trials move apart"]
    bonded = writePDB(tmp_path / "bonded.pdb", [*lines, "CONECT    6   11"])
    assert sample(bonded).returncode == 0


def test_cutMetals(sample, tmp_path):
    path = realStructurePath("1htb.pdb")
    counts = {}
    for name, options in (("whole", ()), ("cut", ("--cut-metals",))):
        result = sample(path, *options, "--json", f"{name}.json", "-o", name)
        assert result.returncode == 0, result.stderr
        summary = json.loads((tmp_path / f"{name}.json").read_text())
        counts[name] = sum(summary["torsions"].values())
        isTold = "cut bonds of metals: A:CYS 46 – A:ZN 376" in result.stdout
        assert bool(summary["cutMetals"]) == isTold == bool(options)
    assert counts["cut"] > counts["whole"] + 400


def test_allNotes(sample, runCommandHere, tmp_path):
    ions = [pdbLine(20 + i, "NA", "NA", "I", i + 1, 50 + 9 * i, 0, 0, record="HETATM", element="NA") for i in range(5)]
    path = writePDB(tmp_path / "ions.pdb", [*GLYCINES, *ions])
    short = "note: ions left out, since nothing binds them (5): I:NA 1; I:NA 2; I:NA 3; and 2 more"
    whole = ["ions left out, since nothing binds them (5):", *(f"  I:NA {number}" for number in range(1, 6))]
    result = sample(path, "--notes", "all.txt")
    assert short in result.stdout.splitlines()
    assert (tmp_path / "all.txt").read_text().splitlines() == whole
    result = runCommandHere("clashes", path, "-v")
    assert "\n".join(["note: " + whole[0], *whole[1:]]) in result.stdout
    result = runCommandHere("clashes", path, "--notes", "-")
    assert result.stdout.splitlines() == whole and short in result.stderr.splitlines()
