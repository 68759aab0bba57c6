"""Each command of docs/recipes.md runs, with few trials."""

import os
import shutil
from pathlib import Path

import pytest
from pages import blocksOf, commandsOf, runCommand

# The files of the page in the folder of real structures.
FILES = {
    "1l2y.pdb": "1l2y.pdb",
    "1l2y.xtc": "1l2y.xtc",
    "1shg.pdb": "1shg.pdb",
    "1ubi.pdb": "1ubi_h.pdb",
    "4hhb.pdb": "4hhb.pdb",
    "5pti.cif.gz": "hard/5PTI.cif.gz",
    "prediction.pdb.gz": "models/af2_violations.pdb.gz",
}
FEW = {"--trials": "200", "--frames": "1", "--temperatures": "300:320:2"}
COMMANDS = [words for name, text in blocksOf("recipes.md") if name == "sh" for words in commandsOf(text)]


def test_thereAreTenRecipes():
    text = (Path(__file__).parents[1] / "docs" / "recipes.md").read_text(encoding="utf-8")
    assert [line.split()[1] for line in text.splitlines() if line.startswith("## ")] == [f"{n}." for n in range(1, 11)]


@pytest.mark.parametrize("words", [words for words in COMMANDS if "--resume" not in words], ids=" ".join)
def test_theRecipeRuns(words, tmp_path, monkeypatch, capsys):
    bringFiles(words, tmp_path)
    monkeypatch.chdir(tmp_path)
    if words[1] == "clashes":
        assert "1,000 atoms" in runCommand(words, capsys)
        return
    if words[1] == "ensemble":
        words = list(words)
        words[words.index("--conformers") + 1] = "1"
        report = runCommand(words + ["--trials", "200"] * ("--loop" in words), capsys)
        folder = Path(words[words.index("-o") + 1])
        assert f"to {folder}" in report and len(list(folder.glob("*-topology.pdb"))) == 1
        return
    report = runCommand(withFewTrials(words), capsys)
    prefix = words[words.index("-o") + 1]
    assert f"{prefix}.png" in report and Path(f"{prefix}-topology.pdb").exists()


def test_aRunIsExtended(tmp_path, monkeypatch, capsys):
    (resume,) = (words for words in COMMANDS if "--resume" in words)
    (ladder,) = (words for words in COMMANDS if "--temperatures" in words)
    bringFiles(ladder, tmp_path)
    monkeypatch.chdir(tmp_path)
    runCommand([*withFewTrials(ladder), "--trials-per-exchange", "100"], capsys)
    report = runCommand([*resume[:-1], "400"], capsys)
    assert "400 trials of each" in report


def bringFiles(words, folder):
    """Copy the files that a command reads, or skip the test."""
    for name in FILES.keys() & set(words):
        if "CHAINTREE_TEST_DATA" not in os.environ:
            pytest.skip("CHAINTREE_TEST_DATA is not set")
        shutil.copy(Path(os.environ["CHAINTREE_TEST_DATA"]) / FILES[name], folder / name)


def withFewTrials(words):
    """Return a command `sample` for few trials, frames and temperatures."""
    words = list(words)
    for option, value in FEW.items():
        if option in words:
            words[words.index(option) + 1] = value
        elif option != "--temperatures":
            words += [option, value]
    return words
