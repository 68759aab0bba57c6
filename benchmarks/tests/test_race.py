"""The script race.py, as a user runs it. No test looks at how long anything takes."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import commands
import numpy as np
import openmm
import pytest
import race
from commands import assertRefused, filesIn
from racing import platforms, rivals, steps
from racing.course import Course
from racing.program import Program, ProgramError
from racing.proteins import ProteinModels, makeSystem, readProtein
from racing.recording import readRecording
from racing.report import readCSV
from racing.rows import GROUPS, Plan
from racing.table import exponent
from racing.tables import combineChains, makeTables
from scenes import GLYCINES, realStructurePath, writePDB

SCRIPT = [sys.executable, race.__file__]


@pytest.fixture
def runHere(runScriptHere):
    """A function that runs the script where no structures lie ready."""
    return lambda *arguments: runScriptHere(race.main, *arguments)


def readEntries(path):
    return readCSV(path)[1]


# ---- Runs ----


def test_everythingQuickly(tmp_path):
    files = ["--csv", "a.csv", "--markdown", "a.md", "--picture", "a.png"]
    result = commands.run("--quick", "--trials", 100, *files, folder=tmp_path, command=SCRIPT)
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stderr == ""
    assert "wrote a.csv, a.md, a.png" in result.stdout
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")

    machine, entries = readCSV(tmp_path / "a.csv")
    assert machine["processor"] and machine["commit"] and "-ffp-contract=off" in machine["compiler"]
    assert "openmm 8." in machine["versions"]
    assert len(machine["load at begin"].split(", ")) == len(machine["load at end"].split(", ")) == 3
    assert machine["instruction sets of the engine"]

    assert list(dict.fromkeys(entry["group"] for entry in entries)) == [name for name in GROUPS if name != "large"]
    for entry in entries:
        assert 0 < entry["quartile1"] <= entry["microseconds"] <= entry["quartile3"]
        assert entry["trials"] == entry["asked"] > 0 and entry["particles"] > 0
    races = {}
    for entry in entries:
        key = tuple(entry.get(key) for key in ("group", "chain", "particles", "moves", "seed"))
        races.setdefault(key, []).append(entry)
    for group in ("chains", "figures", "proteins", "windows", "sidechains", "positions"):
        ofGroup = {key: ofOne for key, ofOne in races.items() if key[0] == group}
        assert {key[-1] for key in ofGroup} == {1, 2}
        for ofOne in ofGroup.values():
            assert {"lazygrid", "ours"} <= {entry["contestant"] for entry in ofOne}
            assert len({entry["accepted"] for entry in ofOne}) == 1
            assert 0 < ofOne[0]["accepted"] <= 1
            assert ofOne[0]["rgOfScene"] > 0 and ofOne[0]["rgEnd"] > 0
            assert all((entry["positions"] == "each") == (group == "positions") for entry in ofOne)
        assert any(entry["bytes"] > 0 for ofOne in ofGroup.values() for entry in ofOne)
    # Those who take much longer race on the first chain.
    assert {entry["seed"] for entry in entries if entry["contestant"] == "kobbtree"} == {1}
    for group in ("calls", "python"):
        contestants = {entry["contestant"] for entry in entries if entry["group"] == group}
        assert {"ours", "ours from Python", "Simulation.step"} <= contestants

    tables = (tmp_path / "a.md").read_text(encoding="utf-8").split("\n**")[1:]
    headings = [words for name, words in GROUPS.items() if name not in ("figures", "large")]
    for heading in ("Figure 7", "Figure 8", "Table 1", "Memory", *headings):
        assert any(table.startswith(heading) for table in tables)
        assert f"\n{heading}" in result.stdout
    for table in tables:
        rows = [line for line in table.splitlines() if line.startswith("|")]
        assert len(rows) >= 3 and len({row.count("|") for row in rows}) == 1


def test_tablesOfAnEarlierRun(runHere, tmp_path):
    arguments = ["--quick", "--trials", 100, "--rows", "figures,worst,pairs"]
    result = runHere(*arguments, "--csv", "a.csv", "--markdown", "a.md", "--picture", "a.png")
    assert result.returncode == 0
    result = runHere("--read", "a.csv", "--markdown", "b.md", "--picture", "b.png")
    assert result.returncode == 0
    for kind in ("md", "png"):
        assert (tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes()


def test_rowsAndContestantsOfChoice(runHere, tmp_path):
    arguments = ["--quick", "--trials", 200, "--rows", "chains,worst", "--contestants", "brute,published,lazygrid"]
    result = runHere(*arguments, "--csv", "a.csv", "--markdown", "-")
    assert result.returncode == 0
    assert "\n| random compact | uniform | 1,000 | 2 × 200 | " in result.stdout and "wrote" not in result.stdout
    contestants = {"chains": set(), "worst": set()}
    for entry in readEntries(tmp_path / "a.csv"):
        contestants[entry["group"]].add(entry["contestant"])
    assert contestants == {"chains": {"brute", "published", "lazygrid"}, "worst": {"brute", "published"}}


def test_noPictureOfNobody(runHere, tmp_path):
    arguments = ["--quick", "--trials", 50, "--chains", 1, "--rows", "figures", "--contestants", "brute"]
    result = runHere(*arguments, "--picture", "a.png")
    assert result.returncode == 0 and "wrote" not in result.stdout and filesIn(tmp_path) == []


def test_sameSeedSameTrials(runHere, tmp_path):
    def count(name, *arguments):
        # The calmest chain, in which the most happens.
        runHere("--quick", "--trials", 400, "--rows", "sidechains", "--chains", 3, "--csv", name, *arguments)
        entries = readEntries(tmp_path / name)
        return {entry["seed"]: entry["particleTests"] for entry in entries if entry["contestant"] == "ours"}

    first = count("a.csv")
    assert first == count("b.csv", "--seed", 1) and len(set(first.values())) > 1
    assert [*first.values()][1:] == [*count("c.csv", "--seed", 2).values()][:-1]


def test_numbersOfTrialsAreFixed(tmp_path, monkeypatch):
    """All contestants of a row run as many trials, as many as the paper's for its figures: no clock ends them."""
    program = Program()
    villin = ProteinModels(readProtein())
    rows, _ = Plan(["figures", "chains", "worst"], program.contestants, None, [villin], False).makeRows()
    given = []
    monkeypatch.setattr(program, "race", lambda options, variables=None: given.append(options) or [])
    course = Course(program, 1, 1, None, tmp_path)
    for row in rows:
        row.run(course, 1)
    assert {row.trials for row in rows if row.group == "figures"} == {20000}
    assert len({row.trials for row in rows if row.group == "chains"}) == 1
    assert all("--seconds" not in options for options in given)


def test_whatIsNotThereIsSkipped(runHere, monkeypatch):
    monkeypatch.setattr(platforms.importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(platforms, "_platformNames", lambda: ["Reference"])
    result = runHere("--quick", "--trials", 100, "--rows", "python,forces,pairs,sidechains")
    assert result.returncode == 0
    for line in (
        "skipped: SciPy: the package scipy is not installed",
        "skipped: FCL: the package python-fcl is not installed",
        "skipped: OpenMM CPU: OpenMM has no CPU platform here",
        "skipped: forces on the CPU platform: OpenMM has no CPU platform here",
        "skipped: SciPy's pairs: the package scipy is not installed",
    ):
        assert line in result.stdout.splitlines()


def test_missingStructuresAreNamed(runHere):
    result = runHere("--trials", 20, "--chains", 1, "--rows", "sidechains")
    assert result.returncode == 0
    for name in ("bpti_h.pdb", "5dfr_h.pdb", "1shg.pdb", "1htb.pdb", "2cas.pdb.gz"):
        assert f"skipped: {name}: not in the folder that CHAINTREE_TEST_DATA names" in result.stdout.splitlines()


def test_aProteinWithoutSideChains(runHere, tmp_path):
    writePDB(tmp_path / "glycines.pdb", GLYCINES)
    arguments = ["--trials", 100, "--chains", 1, "--rows", "proteins,windows,sidechains,needs", "--csv", "a.csv"]
    result = runHere("glycines.pdb", *arguments)
    assert result.returncode == 0
    assert "skipped: sidechains: glycines heavy atoms, sidechain: there are 0 torsions of side chains" in result.stdout
    assert "skipped: needs: glycines heavy atoms, 12 residues: there are 2 residues" in result.stdout
    assert "skipped: windows: glycines heavy atoms, 8 × 5°: there are 2 torsions of the backbone" in result.stdout
    assert "glycines heavy atoms" in {entry["chain"] for entry in readEntries(tmp_path / "a.csv")}


def test_theLongestChainOfAStructure(runHere, tmp_path):
    arguments = ["--rows", "sidechains", "--trials", 100, "--chains", 1, "--csv", "a.csv"]
    result = runHere(realStructurePath("1htb.pdb"), realStructurePath("2cas.pdb.gz"), *arguments)
    assert result.returncode == 0
    entries = readEntries(tmp_path / "a.csv")
    assert {(entry["chain"], entry["particles"]) for entry in entries} == {
        ("1htb heavy atoms", 2776),
        ("2cas heavy atoms", 4347),
    }


def test_progressBarOnATerminal(tmp_path):
    arguments = ["--quick", "--trials", 50, "--rows", "sidechains"]
    status, _, shown = commands.runOnATerminal(*arguments, folder=tmp_path, command=SCRIPT)
    assert status == 0 and "2/2" in shown


def test_interruptLeavesWhatThereIs(tmp_path):
    arguments = ["--rows", "chains", "--trials", "1000", "--csv", "a.csv"]
    status, output, _ = commands.runOnATerminal(
        *arguments, folder=tmp_path, command=SCRIPT, interruptAt=r" ([7-9]|[1-8]\d)/100"
    )
    assert status == 130
    assert "interrupted: this is what was measured so far" in output
    # A row of which not all chains have run is left out.
    rows = {}
    for entry in readEntries(tmp_path / "a.csv"):
        rows.setdefault((entry["chain"], entry["moves"], entry["particles"]), set()).add(entry["seed"])
    assert 1 <= len(rows) < 20 and all(seeds == {1, 2, 3, 4, 5} for seeds in rows.values())


# ---- Verdicts ----


@pytest.mark.parametrize("name", [None, "bpti_h.pdb", "1htb.pdb"])
def test_sceneAgreesWithTheForce(tmp_path, name):
    """What the program says of trials of a protein's scene is what the force says of the same trials."""
    models = ProteinModels(readProtein(None if name is None else realStructurePath(name)))
    for model in (models.backbone, *models.withSideChains()):
        # Backbones alone are loose.
        moves = "uniform" if model is models.backbone else "gaussian"
        recording = record(tmp_path, "--chain", writeScene(tmp_path, model), "--moves", moves)
        assert recording.names.tolist() != list(range(len(recording.names))) or model is models.backbone
        force = model.force
        context = openmm.Context(
            makeSystem(model.protein, force),
            openmm.VerletIntegrator(0.001),
            openmm.Platform.getPlatformByName("Reference"),
        )
        context.setPositions(model.protein.positions)
        assert not force.hasClash(context)
        torsions = {frozenset(force.getTorsionParticles(i)[1:3]): i for i in range(force.getNumTorsions())}
        for trial in recording.trials:
            axis = recording.names[recording.torsions[trial.torsion, :2]].tolist()
            isFree = force.proposeTorsions(context, [torsions[frozenset(axis)]], [trial.angle])
            assert isFree != trial.clash
            if isFree:
                force.acceptProposal(context)
            else:
                force.rejectProposal(context)


@pytest.mark.parametrize("rival", rivals.RIVALS)
def test_rivalsAgreeWithTheProgram(tmp_path, rival):
    reason = platforms.whyNot(rival.requirement)
    if reason is not None:
        pytest.skip(reason)
    villin = ProteinModels(readProtein()).heavyAtoms
    for scene in (["--chain", writeScene(tmp_path, villin)], ["--chain", "random", "--n", 200]):
        recording = record(tmp_path, *scene)
        contestant = rival(recording)
        disagreements = 0
        for trial in recording.trials:
            disagreements += contestant.test(trial) != trial.clash
            if not trial.clash:
                contestant.accept()
        assert disagreements <= (0 if rival.isExact else 2)


def record(folder, *options):
    """The Recording of trials that the program has run, some of which clash."""
    given = {"--trials": 400, "--block": 100, "--record": folder / "record"}
    Program().race({**given, **dict(zip(options[::2], options[1::2], strict=True))})
    recording = readRecording(folder / "record")
    assert len(recording.trials) == 500
    assert 10 < sum(trial.clash for trial in recording.trials) < 490
    return recording


def writeScene(folder, model):
    model.scene.write(folder / "scene")
    return folder / "scene"


def test_aWrongVerdictIsReported(runHere, tmp_path, monkeypatch):
    monkeypatch.setattr(rivals.OpenMMForce, "_clashes", lambda rival, turned: False)
    arguments = ["--quick", "--trials", 200, "--rows", "python,sidechains", "--csv", "a.csv"]
    result = runHere(*arguments)
    assert result.returncode == 0
    assert "OpenMM CPU differs in " in result.stdout

    monkeypatch.setattr(rivals.OpenMMForce, "isExact", True)
    result = runHere(*arguments, "--overwrite")
    assert result.returncode == 1
    assert "FAILED: python: villin all atoms, uniform: OpenMM CPU calls trial " in result.stdout
    assert "free of clashes, lazygrid does not" in result.stdout
    assert result.stdout.count("FAILED: ") == 2
    assert {entry["group"] for entry in readEntries(tmp_path / "a.csv")} == {"sidechains"}


def test_watersThatAreInTheWayAreReported(runHere, monkeypatch):
    """As if waters of radius 0 were in the way, here by having another."""
    honest = steps.Simulated.plus
    monkeypatch.setattr(
        steps.Simulated, "plus", lambda self, radii, *rest: honest(self, np.full(len(radii), 0.01), *rest)
    )
    result = runHere("--quick", "--trials", 300, "--rows", "needs")
    assert result.returncode == 1
    assert "FAILED: needs: villin heavy atoms: of the same trials are accepted 0 and " in result.stdout


def test_aFailingRowDoesNotEndTheOthers(runHere, monkeypatch):
    honest = Program.race

    def fail(self, options, instructionSet=None):
        if options["--n"] == 1000:
            raise ProgramError("ours calls trial 7 a clash, lazygrid does not")
        return honest(self, options, instructionSet)

    monkeypatch.setattr(Program, "race", fail)
    monkeypatch.setattr("racing.rows._SIZES", (1000, 500))
    result = runHere("--quick", "--trials", 100, "--rows", "chains")
    assert result.returncode == 1
    line = "FAILED: chains: random compact, 1,000 spheres, uniform: ours calls trial 7 a clash, lazygrid does not"
    assert line in result.stdout
    assert "random compact   uniform   500 " in result.stdout


def test_theProgramSaysWhatIsWrong():
    with pytest.raises(ProgramError, match="^there is no contestant nobody for this measure$"):
        Program().race({"--contestants": "nobody"})


# ---- Bad input ----


def test_noProgram(runHere, tmp_path, monkeypatch):
    words = ["there is no program ", "CHAINTREE_BUILD_BENCHMARKS=ON"]
    assertRefused(runHere("--quick", "--program", "nothing"), tmp_path, [], *words)
    monkeypatch.setenv("CHAINTREE_CONTESTANTS", "nowhere")
    assertRefused(runHere("--quick"), tmp_path, [], *words, "nowhere")


def test_aProgramThatDoesNotRun(runHere, tmp_path):
    (tmp_path / "a.txt").write_text("nothing")
    result = runHere("--quick", "--program", tmp_path / "a.txt")
    assertRefused(result, tmp_path, ["a.txt"], "a.txt does not run (Permission denied)")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--rows", "chains,nothing"], "'nothing' is none of figures, chains, large"),
        (["--contestants", "ours,nobody"], "there is no contestant 'nobody'; there are brute, "),
        (["--trials", "0"], "--trials"),
        (["--seed", "0"], "--seed"),
        (["none.pdb"], "none.pdb: No such file"),
        (["water.pdb"], "water.pdb: there is no chain of amino acids"),
        (["--picture", "a.doc"], "a.doc: a picture's name ends in .png, .pdf, .svg"),
        (["--picture", "a.png", "--rows", "chains"], "--picture shows the rows of figures, which --rows leaves out"),
        (["--csv", "a", "--markdown", "a"], "a: is named for two outputs"),
        (["--csv", "-", "--markdown", "-"], "standard output (-): is named for two outputs"),
        (["--csv", ""], "the name of the csv file is empty"),
        (["--csv", "missing/a.csv"], "there is no folder missing"),
        (["water.pdb", "--csv", "water.pdb"], "water.pdb: would overwrite a file that is read"),
        (["--read", "water.pdb", "--csv", "water.pdb"], "water.pdb: would overwrite a file that is read"),
        (["--read", "water.pdb"], "water.pdb: is no CSV that the benchmarks wrote"),
    ],
)
def test_badArguments(runHere, tmp_path, arguments, words):
    # Residues that are no water by their name, and no amino acids.
    writePDB(tmp_path / "water.pdb", [line.replace("GLY", "LIG").replace("ATOM  ", "HETATM") for line in GLYCINES])
    assertRefused(runHere(*arguments), tmp_path, ["water.pdb"], words)
    assert filesIn(tmp_path) == ["water.pdb"]


def test_noFileIsOverwritten(runHere, tmp_path):
    (tmp_path / "a.md").write_text("mine")
    assertRefused(runHere("--quick", "--markdown", "a.md"), tmp_path, ["a.md"], "a.md: exists; --overwrite replaces it")
    assert (tmp_path / "a.md").read_text() == "mine"


def test_csvOnStandardOutput(runHere, tmp_path):
    result = runHere("--quick", "--trials", 50, "--rows", "sidechains", "--csv", "-")
    assert result.returncode == 0 and filesIn(tmp_path) == []
    lines = [line for line in result.stdout.splitlines() if not line.startswith("# ")]
    assert len(list(csv.DictReader(lines))) >= 6 and GROUPS["sidechains"] in result.stderr


def test_typesFit():
    pytest.importorskip("mypy")
    folder = Path(race.__file__).parent
    options = ["--config-file", folder.parent / "pyproject.toml", "--cache-dir", os.devnull]
    command = [sys.executable, "-m", "mypy", *options, "race.py", "accuracy.py"]
    result = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert result.returncode == 0, result.stdout + result.stderr


# ---- Tables ----


def makeEntry(contestant, size, time, seed=1, **others):
    """An entry of a chain."""
    entry = {"group": "chains", "chain": "random compact", "particles": size, "moves": "uniform", "seed": seed}
    return {**entry, "trials": 100, "asked": 100, "contestant": contestant, "microseconds": time, **others}


def test_chainsOfARow():
    times = {1: 5.0, 2: 1.0, 3: 2.0}
    entries = [makeEntry("ours", 1000, time, seed, accepted=0.1 * seed) for seed, time in times.items()]
    (combined,) = combineChains(entries)
    assert [combined[key] for key in ("least", "microseconds", "most", "chains")] == [1.0, 2.0, 5.0, 3]
    assert combined["accepted"] == pytest.approx(0.2)


def test_whatDidNotRunItsTrialsIsInNoTable():
    entries = [makeEntry("ours", 1000, 1.0), makeEntry("published", 1000, 3.0, trials=99)]
    (table,) = makeTables(entries)
    assert "ours" in table.columns and "ChainTree 2002" not in table.columns


def test_growthIsOfAllSizes():
    """A line through all sizes: the middle one counts, too."""
    (table,) = makeTables([makeEntry("ours", size, time) for size, time in ((100, 1.0), (1000, 8.0), (10000, 4.0))])
    assert "N^0.30 (random compact, uniform, 100 to 10,000)" in table.notes[0]
    assert exponent({100: 1.0, 1000: 8.0, 10000: 64.0}) == pytest.approx(np.log10(8.0))
