"""Errors on unknown names suggest the nearest one that exists."""

import pytest
from commands import assertRefused, filesIn
from openmmchaintree import findTorsions, selectAtoms
from openmmchaintree.nearnames import didYouMean, nearestName
from scenes import peptide, writeSmallStructures


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["sampel"], ["invalid choice: 'sampel'", "did you mean sample?"]),
        (["sample", "--forcefeild", "x.xml"], ["unrecognized arguments: --forcefeild", "did you mean --forcefield?"]),
        (["sample", "--trails=5"], ["did you mean --trials?"]),
        (["clashes", "run.pdb", "--symetry"], ["did you mean --symmetry?"]),
        (["sample", "--torsions", "phi,spi"], ["'spi' is not one of", "did you mean psi?"]),
        (["sample", "--steric", "of"], ["did you mean off?"]),
        (["sample", "--config", "wrong.toml"], ["trails is not a setting of this command; did you mean trials?"]),
        (["sample", "run.pdb", "--forcefield", "amber14"], ["did you mean amber14-all.xml?"]),
        (["sample", "run.pdb", "--forcefield", "amber14-all"], ["did you mean amber14-all.xml?"]),
        (["sample", "run.pdb", "--forcefield", "amber14-all.xml", "gbn2.xml"], ["did you mean implicit/gbn2.xml?"]),
        (["sample", "run.pdb", "--forcefield", "amber14_all.xml"], ["did you mean amber14-all.xml?"]),
        (["sample", "run.pdb", "--forcefield", "my.xml"], ["did you mean mine.xml?"]),
        (["sample", "run.pdb", "--move", "resname GYL"], ["there is no residue GYL; did you mean GLY?"]),
        (["sample", "run.pdb", "--fix", "name CAB"], ["--fix: 'name CAB' selects no atom", "did you mean CA?"]),
        (["sample", "run.pdb", "--move", "segname Q"], ["there is no chain Q; the structure has A"]),
        (["sample", "run.pdb", "--move", "resSeq 500 to 510"], ["resSeq is 1 to 2 here"]),
        (["sample", "run.pdb", "--move", "resnam GLY"], ["did you mean resname?"]),
        (["sample", "run.pdb", "--move", "chain A"], ["did you mean segname?"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_suggested(runCommandHere, tmp_path, arguments, words):
    writeSmallStructures(tmp_path)
    (tmp_path / "wrong.toml").write_text("[sample]\ntrails = 5\n")
    (tmp_path / "mine.xml").write_text("<ForceField/>")
    assertRefused(runCommandHere(*arguments), tmp_path, filesIn(tmp_path), *words)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["sample", "--bogus"], "unrecognized arguments: --bogus"),
        (["sample", "a.pdb", "b.pdb"], "unrecognized arguments: b.pdb"),
        (["sample", "run.pdb", "--forcefield", "nothing/of/this.xml"], 'Could not locate file "nothing/of/this.xml"'),
        (["sample", "run.pdb", "--forcefield", "wrong.xml"], "--forcefield wrong.xml"),
        (["sample", "run.pdb", "--move", ""], "a part is missing"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_notSuggested(runCommandHere, tmp_path, arguments, words):
    writeSmallStructures(tmp_path)
    (tmp_path / "wrong.xml").write_text("no XML")
    result = runCommandHere(*arguments)
    assertRefused(result, tmp_path, filesIn(tmp_path), words)
    assert "did you mean" not in result.stderr


def test_ofPython():
    topology = peptide("ALA", "LYS", "SER")
    with pytest.raises(ValueError, match="since there is no residue ALE; did you mean ALA"):
        selectAtoms(topology, "resname ALE")
    with pytest.raises(ValueError, match="'ch1' is not a kind of torsion; .*; did you mean chi1"):
        findTorsions(topology, kinds=("ch1",))


@pytest.mark.parametrize(
    ("name", "known", "near"),
    [
        ("leu", ["LEU", "LYS"], "LEU"),
        ("", ["a"], None),
        ("abc", [], None),
        ("x" * 50, ["y"], None),
        ("β", ["β1"], "β1"),
    ],
)
def test_nearest(name, known, near):
    assert nearestName(name, known) == near
    assert didYouMean(name, known) == ("" if near is None else f"; did you mean {near}?")
