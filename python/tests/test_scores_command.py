"""The command openmm-chaintree clashes with the definitions of other programs, as a user runs it."""

import csv
import io
import json
from pathlib import Path

import numpy as np
import pytest
from commands import assertRefused
from openmm import app, unit
from scenes import writeDCD

_SCHEMA = Path(__file__).parents[2] / "docs" / "clashscores.schema.json"


@pytest.fixture
def runHere(runCommandHere):
    return lambda *arguments: runCommandHere("clashes", *arguments)


@pytest.fixture
def shrunken(villin, tmp_path):
    """Write villin shrunk by 5%, in tmp_path; return the name of the file."""
    write(villin, 0.95 * villin.positions, tmp_path / "villin.pdb")
    return "villin.pdb"


def write(structure, positions, path):
    with open(path, "w") as file:
        app.PDBFile.writeFile(structure.topology, positions * unit.nanometer, file)


def assertFollowsSchema(content):
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.Draft202012Validator(json.loads(_SCHEMA.read_text())).validate(content)


def readCSV(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_aFileByAllDefinitions(runHere, shrunken, tmp_path):
    pytest.importorskip("rdkit")
    definitions = "own,molprobity,af3,posebusters"
    result = runHere(shrunken, "--definition", definitions, "--json", "a.json", "--csv", "a.csv")
    assert result.returncode == 0 and result.stderr == ""
    for line in ("own definition: ", "MolProbity: clashscore ", "AlphaFold 3: has_clash false", "there is no ligand"):
        assert line in result.stdout
    assert "wrote a.csv, a.json" in result.stdout
    content = json.loads((tmp_path / "a.json").read_text())
    assertFollowsSchema(content)
    (model,) = content["files"][0]["models"]
    score = model["molprobity"]
    assert score["clashscore"] == pytest.approx(1000 * score["clashes"] / score["atoms"])
    assert len(score["pairs"]) == score["clashes"] == sum(chain["clashes"] for chain in score["chains"])
    (row,) = readCSV((tmp_path / "a.csv").read_text())
    assert (row["file"], row["model"], row["clashes"]) == ("villin.pdb", "0", str(score["clashes"]))
    assert (row["has_clash"], row["poses_pass"], row["error"]) == ("false", "true", "")


def test_hydrogensOfTheFile(runHere, shrunken):
    result = runHere(shrunken, "--definition", "molprobity", "--keep-hydrogens")
    assert "MolProbity: clashscore 12.03, 7 clashes of 582 atoms" in result.stdout


def test_flips(runHere, villin, tmp_path):
    """An asparagine beside a carboxylate whose O and N are exchanged is flipped back."""
    write(villin, villin.positions, tmp_path / "a.pdb")
    lines = (tmp_path / "a.pdb").read_text().splitlines()
    asparagine = [line for line in lines if line[22:26].strip() == "19" and line.startswith("ATOM")]
    places = {line[12:16].strip(): np.array([float(line[i : i + 8]) for i in (30, 38, 46)]) for line in asparagine}
    beyond = places["ND2"] + 2.9 * (places["ND2"] - places["CG"]) / 1.33
    others = [
        f"ATOM      1  OD1 ASP B   1    {''.join(f'{x:8.3f}' for x in beyond)}  1.00  0.00           O",
        f"ATOM      2  CG  ASP B   1    {''.join(f'{x:8.3f}' for x in beyond + [0.9, 0.9, 0])}  1.00  0.00           C",
    ]
    exchanged = {"OD1": "ND2", "ND2": "OD1"}
    swapped = []
    for line in asparagine:
        name = line[12:16].strip()
        if not line[12:16].strip().startswith("H"):
            place = places[exchanged.get(name, name)]
            swapped.append(f"{line[:30]}{''.join(f'{x:8.3f}' for x in place)}{line[54:]}")
    (tmp_path / "b.pdb").write_text("\n".join([*swapped, "TER", *others, "END", ""]))
    for options, expected in (((), []), (("--flips",), ["A:ASN 19"])):
        result = runHere("b.pdb", "--definition", "molprobity", *options, "--json", "b.json", "--overwrite")
        assert result.returncode == 0 and ("flipped: A:ASN 19" in result.stdout) == bool(expected)
        content = json.loads((tmp_path / "b.json").read_text())
        assertFollowsSchema(content)
        assert content["files"][0]["models"][0]["molprobity"]["flipped"] == expected


@pytest.mark.parametrize("limit, status", [(12.0, 1), (12.1, 0)])
def test_statusOfAHighClashscore(runHere, shrunken, limit, status):
    assert runHere(shrunken, "--keep-hydrogens", "--fail-above", limit).returncode == status


def test_framesOfATrajectory(runHere, villin, shrunken, tmp_path):
    writeDCD(tmp_path / "villin", villin.topology, [villin.positions, 0.95 * villin.positions])
    result = runHere(shrunken, "villin.dcd", "--definition", "molprobity", "--keep-hydrogens", "--csv", "-")
    assert result.returncode == 0
    assert [row["clashes"] for row in readCSV(result.stdout)] == ["1", "7"]


def test_aFolderOfModels(runHere, villin, shrunken, tmp_path):
    (tmp_path / "models").mkdir()
    for number, scale in enumerate((1, 0.95, 0.9)):
        write(villin, scale * villin.positions, tmp_path / "models" / f"{number}.pdb")
    (tmp_path / "models" / "2b.pdb").write_text("ATOM  nonsense\n")
    (tmp_path / "models" / "3.cif").write_bytes(b"\x00\x01\x02")
    (tmp_path / "models" / "notes.txt").write_text("no structure")
    arguments = ("--models", "models", "--keep-hydrogens", "--definition", "molprobity,af3", "--overwrite")
    result = runHere(*arguments, "--csv", "a.csv", "--json", "a.json")
    assert result.returncode == 0
    lines = result.stderr.splitlines()
    assert len(lines) == 2 and "models/2b.pdb: " in lines[0] and "models/3.cif: " in lines[1]
    rows = readCSV((tmp_path / "a.csv").read_text())
    assert [row["file"] for row in rows] == [
        f"models/{name}" for name in ("0.pdb", "1.pdb", "2.pdb", "2b.pdb", "3.cif")
    ]
    assert [row["clashes"] for row in rows[:2]] == ["1", "7"] and rows[3]["error"] and not rows[3]["clashes"]
    assertFollowsSchema(json.loads((tmp_path / "a.json").read_text()))
    parallel = runHere(*arguments, "--csv", "b.csv", "--workers", 2)
    assert parallel.returncode == 0
    assert (tmp_path / "b.csv").read_text() == (tmp_path / "a.csv").read_text()


def test_aFolderOfBadModelsOnly(runHere, tmp_path):
    (tmp_path / "models").mkdir()
    (tmp_path / "models" / "a.pdb").write_text("")
    result = runHere("--models", "models", "--csv", "-")
    assert result.returncode == 2 and "models/a.pdb: " in result.stderr
    assert len(readCSV(result.stdout)) == 1


def test_aDamagedModelEndsAFile(runHere, villin, shrunken, tmp_path):
    text = (tmp_path / shrunken).read_text()
    body = "".join(line for line in text.splitlines(keepends=True) if line.startswith(("ATOM", "HETATM", "TER")))
    shorter = "".join(body.splitlines(keepends=True)[1:])
    (tmp_path / "a.pdb").write_text(f"MODEL 1\n{body}ENDMDL\nMODEL 2\n{shorter}ENDMDL\nEND\n")
    result = runHere("a.pdb", "--definition", "molprobity", "--keep-hydrogens", "--csv", "-")
    assert result.returncode == 2 and "a.pdb: model 1 (from 0)" in result.stderr
    assert [row["clashes"] for row in readCSV(result.stdout)] == ["7", ""]


def test_picturesOfOneModelAndOfFrames(runHere, villin, shrunken, tmp_path):
    kept = ("--definition", "molprobity", "--keep-hydrogens")
    assert runHere(shrunken, *kept, "--picture", "a.svg").returncode == 0
    text = (tmp_path / "a.svg").read_text(encoding="utf-8")
    assert text.count("<use ") > 7 and "clashes per 1,000 atoms" in (tmp_path / "a.svg").read_text(encoding="utf-8")
    writeDCD(tmp_path / "villin", villin.topology, [villin.positions, 0.95 * villin.positions])
    result = runHere(shrunken, "villin.dcd", *kept, "--picture", "b.png")
    assert result.returncode == 0 and (tmp_path / "b.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "name, lines",
    [
        ("a.pml", ["load {file}, scored", "distance clashes, {first} and name CE1, {second} and name HE2"]),
        ("a.cxc", ['open "{file}" id 1', "pbond #1/A:10@CE1 #1/A:32@HE2 color magenta radius 0.1 name clashes"]),
    ],
)
def test_scriptsForViewers(runHere, shrunken, tmp_path, name, lines):
    result = runHere(shrunken, "--keep-hydrogens", "--script", name)
    assert result.returncode == 0 and f"wrote {name}" in result.stdout
    text = (tmp_path / name).read_text().splitlines()
    first, second = ('scored and chain "A" and resi 10 and resn PHE', 'scored and chain "A" and resi 32 and resn LYS')
    for line in lines:
        assert line.format(file=(tmp_path / shrunken).as_posix(), first=first, second=second) in text
    assert sum("clashes," in line or "pbond" in line for line in text) >= 7


@pytest.mark.parametrize(
    "arguments, reason",
    [
        (("--definition", "molprobty"), "did you mean molprobity?"),
        (("--definition", ""), "is not one of own, molprobity"),
        (("--definition", "af3", "--water"), "--water works only with the definition own"),
        (("--definition", "af3", "--picture", "a.png"), "--picture shows clashes by --definition molprobity or own"),
        (("--definition", "molprobity", "--picture", "a.txt"), "a.txt: a picture's name ends in .png"),
        (("--flips", "--keep-hydrogens"), "--flips places hydrogens"),
        (("--definition", "af3", "--flips"), "--flips needs --definition molprobity"),
        (("--script", "a.py"), "a.py: a script's name ends in .pml or .cxc"),
        (("--definition", "af3", "--fail-above", "3"), "--fail-above needs --definition molprobity"),
        (("--fail-above", "nan"), "fail-above"),
        (("--fail-above", "-1"), "not in the range 0 to 1e+06"),
        (("--definition", "af3", "--workers", "2"), "--workers needs --models"),
        (("--models", "nowhere"), "nowhere: is not a folder"),
        (("--models", "."), ".: has no structure files"),
    ],
)
def test_wrongOptions(runHere, tmp_path, arguments, reason):
    assertRefused(runHere(*arguments), tmp_path, [], reason)


def test_aFolderAndAStructure(runHere, shrunken, tmp_path):
    reason = "--models takes a folder of models, and no other structure"
    assertRefused(runHere(shrunken, "--models", "."), tmp_path, [shrunken], reason)


def test_aMissingFile(runHere, tmp_path):
    result = runHere("missing.pdb", "--definition", "molprobity")
    assert result.returncode == 2 and result.stderr.count("\n") == 1 and "missing.pdb" in result.stderr


def test_noOutputIsReplaced(runHere, shrunken, tmp_path):
    (tmp_path / "a.csv").write_text("mine")
    before = (tmp_path / shrunken).read_text()
    for name, reason in (("a.csv", "exists; --overwrite replaces it"), (shrunken, "overwrite a file that is read")):
        result = runHere(shrunken, "--definition", "af3", "--csv", name)
        assertRefused(result, tmp_path, ["a.csv", shrunken], reason)
    assert (tmp_path / "a.csv").read_text() == "mine" and (tmp_path / shrunken).read_text() == before
