"""The code of tutorials runs.

The pieces of a program on a page form the whole program, in order; test_examples.py runs it. All code of a page, with
the blocks between these pieces, runs from top to bottom; and so do its commands.
"""

import sys
from pathlib import Path

import openmm
import pytest
from openmm import app, unit
from openmmchaintree import createCalvadosSystem
from pages import PROJECT, blocksOf, commandsOf, runCommand

TUTORIALS = {
    "sampling.md": "sample_protein.py",
    "own-monte-carlo.md": "own_monte_carlo.py",
    "validating.md": "validate_trajectory.py",
}


@pytest.mark.parametrize("page, program", TUTORIALS.items())
def test_theTutorialShowsTheWholeProgram(page, program):
    _, _, body = (PROJECT / "examples" / program).read_text(encoding="utf-8").split('"""', 2)
    shown = "".join(text for name, text in blocksOf(page) if name == program)
    assert shown.strip() == body.strip()


def test_theExamplesPageShowsAllExamples():
    shown = {name for name, _ in blocksOf("examples.md")}
    assert shown == {path.name for path in (PROJECT / "examples").glob("*.py")}


@pytest.mark.parametrize("page", ["sampling.md", "own-monte-carlo.md"])
def test_thePageRunsFromTopToBottom(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OPENMM_DEFAULT_PLATFORM", "CPU")
    monkeypatch.setattr(sys, "argv", [page, "1"])  # a step, or a trial
    blocks = [text for name, text in blocksOf(page) if name in (TUTORIALS[page], "python")]
    assert sum(name == "python" for name, _ in blocksOf(page)) == 1
    variables = {}
    for text in blocks:
        exec(compile(text, page, "exec"), variables)
    if page == "sampling.md":
        integrator = variables["integrator"]
        moves = range(integrator.getNumMoves())
        assert len(moves) > 6  # of the program, and those of addDefaultMoves
        attempted = sum(integrator.getMoveStatistics(move).attempted for move in moves)
        assert attempted + integrator.getOuterStatistics().trialsTakenBack == 400
    else:
        pairs, before, after = (variables[name] for name in ("pairs", "before", "after"))
        assert len(pairs) == len(before) == len(after) > 100 and variables["change"] != 0


def test_theSnippetForBeadsRuns(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OPENMM_DEFAULT_PLATFORM", "CPU")
    topology, system, positions = createCalvadosSystem(["GSYRDFKAWELQTVNPHIC"] * 2, box=(12, 12, 12))
    Path("system.xml").write_text(openmm.XmlSerializer.serialize(system), encoding="utf-8")
    with open("top.pdb", "w", encoding="utf-8") as file:
        app.PDBFile.writeFile(topology, positions * unit.nanometer, file)
    variables = {}
    with pytest.warns(UserWarning, match="36 harmonic bonds of beads stay"):
        for name, text in blocksOf("beads.md"):
            if name == "python":
                exec(compile(text, name, "exec"), variables)
    plan = variables["integrator"].getEnergyPlan(variables["simulation"].context)
    assert [one.kind for one in plan] == ["native", "native", "native", "not sampled"]
    assert variables["force"].getNumBallJoints() == 36 and Path("chains.dcd").stat().st_size > 0


def test_theCommandsRun(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    blocks = (text for page in TUTORIALS for name, text in blocksOf(page) if name == "sh")
    commands = [words for text in blocks for words in commandsOf(text)]
    assert [words[1] for words in commands] == ["sample", *4 * ["clashes"]]
    (sample, clashes), (ofCrystal,) = commands[:2], [words for words in commands if "--symmetry" in words]
    scores, ofFolder = (words for words in commands if "--definition" in words)
    runCommand(sample, capsys)
    (tmp_path / "solvated-topology.pdb").replace(tmp_path / "my.pdb")
    (tmp_path / "solvated.dcd").replace(tmp_path / "my.dcd")
    runCommand(clashes, capsys)
    assert (tmp_path / "clashes.csv").exists()
    lines = (tmp_path / "my.pdb").read_text().splitlines(keepends=True)
    cell = "CRYST1  100.000  110.000  120.000  90.00  90.00  90.00 P 21 21 21    4\n"
    (tmp_path / "my.pdb").write_text("".join([cell, *(line for line in lines if not line.startswith("CRYST1"))]))
    runCommand(ofCrystal, capsys)
    assert (tmp_path / "contacts.json").exists()
    (tmp_path / "predictions").mkdir()
    for name in ("model.pdb", "predictions/first.pdb"):
        (tmp_path / name).write_text("".join(lines))
    assert "MolProbity: clashscore " in runCommand(scores, capsys)
    runCommand(ofFolder, capsys)
    assert len((tmp_path / "scores.csv").read_text().splitlines()) == 2
