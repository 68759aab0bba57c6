"""The command openmm-chaintree benchmark, as a user runs it. No test looks at how long anything takes."""

import csv
import json
from pathlib import Path

import commands
import numpy as np
import openmm
import openmmchaintree
import pytest
from commands import assertRefused, filesIn
from openmmchaintree.command.benchmarking import platforms, program, rivals, steps
from openmmchaintree.command.benchmarking.program import Program, ProgramError
from openmmchaintree.command.benchmarking.proteins import ProteinModels, makeSystem, readProtein
from openmmchaintree.command.benchmarking.recording import readRecording
from openmmchaintree.command.benchmarking.rows import GROUPS
from scenes import GLYCINES, realStructurePath, writePDB

pytestmark = pytest.mark.skipif(
    not (Path(openmmchaintree._openmmchaintree.__file__).parent / "bin").exists(),
    reason="built with CHAINTREE_BUILD_BENCHMARKS=OFF",
)


def run(*arguments, folder):
    return commands.run("benchmark", *arguments, folder=folder)


@pytest.fixture
def runHere(runCommandHere, monkeypatch):
    """A function that runs the command where no structures lie ready."""

    def run(*arguments):
        monkeypatch.delenv("CHAINTREE_TEST_DATA", raising=False)
        return runCommandHere("benchmark", *arguments)

    return run


def readEntries(path):
    return json.loads(path.read_text(encoding="utf-8"))["entries"]


# ---- Runs ----


def test_everythingQuickly(tmp_path):
    files = ["--json", "a.json", "--csv", "a.csv", "--markdown", "a.md", "--picture", "a.png"]
    result = run("--quick", "--trials", 300, *files, folder=tmp_path)
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stderr == ""
    assert "wrote a.json, a.csv, a.md, a.png" in result.stdout
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")

    summary = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert summary["seed"] == 1 and summary["trials"] == 300
    assert not summary["interrupted"] and summary["failures"] == []
    assert summary["machine"]["processor"] and summary["machine"]["versions"]["openmm"].startswith("8.")
    assert summary["proteins"] == [{"name": "villin", "residues": 35, "atoms": 582}]
    assert len(summary["instructionSets"]) >= 1

    entries = summary["entries"]
    assert list(dict.fromkeys(entry["group"] for entry in entries)) == [name for name in GROUPS if name != "large"]
    for entry in entries:
        first, third = entry["quartiles"]
        assert 0 < first <= entry["microseconds"] <= third
        assert entry["trials"] > 0 and entry["particles"] > 0
    races = {}
    for entry in entries:
        races.setdefault(tuple(entry.get(key) for key in ("group", "chain", "particles", "moves")), []).append(entry)
    for group in ("chains", "figures", "proteins", "windows", "sidechains"):
        for race in (race for key, race in races.items() if key[0] == group):
            assert {"lazygrid", "ours"} <= {entry["contestant"] for entry in race}
            assert len({(entry["accepted"], entry["trials"]) for entry in race}) == 1
            assert 0 < race[0]["accepted"] < 1

    with open(tmp_path / "a.csv", newline="", encoding="utf-8") as file:
        lines = list(csv.DictReader(file))
    assert [float(line["microseconds"]) for line in lines] == [entry["microseconds"] for entry in entries]
    assert [float(line["quartile3"]) for line in lines] == [entry["quartiles"][1] for entry in entries]

    tables = (tmp_path / "a.md").read_text(encoding="utf-8").split("\n**")[1:]
    for heading in ("Figure 7", "Figure 8", "Table 1", *(words for name, words in GROUPS.items() if name != "figures")):
        if heading != GROUPS["large"]:
            assert any(table.startswith(heading) for table in tables)
            assert f"\n{heading}" in result.stdout
    for table in tables:
        rows = [line for line in table.splitlines() if line.startswith("|")]
        assert len(rows) >= 3 and len({row.count("|") for row in rows}) == 1


def test_rowsAndContestantsOfChoice(runHere, tmp_path):
    arguments = ["--quick", "--trials", 200, "--rows", "chains,worst", "--contestants", "brute,published,lazygrid"]
    result = runHere(*arguments, "--json", "a.json", "--markdown", "-")
    assert result.returncode == 0
    assert "\n| random compact | uniform | 1,000 | 200 | " in result.stdout and "wrote" not in result.stdout
    contestants = {"chains": set(), "worst": set()}
    for entry in readEntries(tmp_path / "a.json"):
        contestants[entry["group"]].add(entry["contestant"])
    assert contestants == {"chains": {"brute", "published", "lazygrid"}, "worst": {"brute", "published"}}


def test_sameSeedSameTrials(runHere, tmp_path):
    def count(name, *arguments):
        # The calmest chain, in which the most happens.
        runHere("--quick", "--trials", 400, "--rows", "sidechains", "--seconds", 60, "--json", name, *arguments)
        return [(entry["accepted"], entry["particleTests"]) for entry in readEntries(tmp_path / name)]

    assert count("a.json") == count("b.json", "--seed", 1) != count("c.json", "--seed", 2)


def test_timeIsUp(runHere, tmp_path):
    result = runHere("--quick", "--rows", "sidechains", "--seconds", 1e-6, "--json", "a.json")
    assert result.returncode == 0
    assert {entry["trials"] for entry in readEntries(tmp_path / "a.json")} == {2000}


def test_whatIsNotThereIsSkipped(runHere, monkeypatch):
    monkeypatch.setattr(platforms.importlib.util, "find_spec", lambda name: None)
    monkeypatch.setattr(platforms, "_platformNames", lambda: ["Reference"])
    result = runHere("--trials", 100, "--seconds", 0.01, "--rows", "python,forces,pairs,sidechains")
    assert result.returncode == 0
    for line in (
        "skipped: SciPy: the package scipy is not installed",
        "skipped: FCL: the package python-fcl is not installed",
        "skipped: OpenMM CPU: OpenMM has no CPU platform here",
        "skipped: forces on the CPU platform: OpenMM has no CPU platform here",
        "skipped: SciPy's pairs: the package scipy is not installed",
        *(
            f"skipped: {name}: not in the folder that CHAINTREE_TEST_DATA names"
            for name in ("bpti_h.pdb", "5dfr_h.pdb", "1shg.pdb", "1htb.pdb", "2cas.pdb.gz")
        ),
    ):
        assert line in result.stdout.splitlines()


def test_aProteinWithoutSideChains(runHere, tmp_path):
    writePDB(tmp_path / "glycines.pdb", GLYCINES)
    arguments = ["--trials", 100, "--rows", "proteins,windows,sidechains,needs", "--json", "a.json"]
    result = runHere("glycines.pdb", *arguments)
    assert result.returncode == 0
    assert "skipped: sidechains: glycines heavy atoms, sidechain: there are 0 torsions of side chains" in result.stdout
    assert "skipped: needs: glycines heavy atoms, 12 residues: there are 2 residues" in result.stdout
    assert "skipped: windows: glycines heavy atoms, 8 × 5°: there are 2 torsions of the backbone" in result.stdout
    assert "glycines heavy atoms" in {entry["chain"] for entry in readEntries(tmp_path / "a.json")}


def test_theLongestChainOfAStructure(runHere, tmp_path):
    arguments = ["--rows", "sidechains", "--trials", 100, "--json", "a.json"]
    result = runHere(realStructurePath("1htb.pdb"), realStructurePath("2cas.pdb.gz"), *arguments)
    assert result.returncode == 0
    summary = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert [(protein["name"], protein["residues"]) for protein in summary["proteins"]] == [("1htb", 374), ("2cas", 548)]
    assert {entry["particles"] for entry in summary["entries"]} == {2776, 4347}


def test_progressBarOnATerminal(tmp_path):
    arguments = ["--quick", "--trials", 50, "--rows", "sidechains"]
    status, _, shown = commands.runOnATerminal("benchmark", *arguments, folder=tmp_path)
    assert status == 0 and "1/1" in shown


def test_interruptLeavesWhatThereIs(tmp_path):
    arguments = ["--rows", "chains", "--trials", "1000", "--json", "a.json"]
    status, output, _ = commands.runOnATerminal("benchmark", *arguments, folder=tmp_path, interruptAt=r" 2/20")
    assert status == 130
    assert "interrupted: this is what was measured so far" in output
    summary = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert summary["interrupted"] and 6 <= len(summary["entries"]) < 3 * 20


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
    arguments = ["--quick", "--trials", 200, "--rows", "python,sidechains", "--json", "a.json"]
    result = runHere(*arguments)
    assert result.returncode == 0
    assert "OpenMM CPU differs in " in result.stdout

    monkeypatch.setattr(rivals.OpenMMForce, "isExact", True)
    result = runHere(*arguments, "--overwrite")
    assert result.returncode == 1
    assert "FAILED: python: villin all atoms, uniform: OpenMM CPU calls trial " in result.stdout
    assert "free of clashes, lazygrid does not" in result.stdout
    summary = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))
    assert len(summary["failures"]) == 2
    assert {entry["group"] for entry in summary["entries"]} == {"sidechains"}


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
    monkeypatch.setattr("openmmchaintree.command.benchmarking.rows._SIZES", (1000, 500))
    result = runHere("--quick", "--trials", 100, "--rows", "chains")
    assert result.returncode == 1
    line = "FAILED: chains: random compact, 1,000 spheres, uniform: ours calls trial 7 a clash, lazygrid does not"
    assert line in result.stdout
    assert "random compact  uniform  500" in result.stdout


def test_theProgramSaysWhatIsWrong():
    with pytest.raises(ProgramError, match="^there is no contestant nobody for this measure$"):
        Program().race({"--contestants": "nobody"})


# ---- Bad input ----


def test_noProgram(runHere, tmp_path, monkeypatch):
    monkeypatch.setattr(program, "_NAME", "nothing")
    result = runHere("--quick")
    assertRefused(result, tmp_path, [], "the program nothing is not in ", "install openmm-chaintree again")


def test_aProgramThatDoesNotRun(runHere, tmp_path, monkeypatch):
    monkeypatch.setattr(program, "_NAME", "../_build.py")
    assertRefused(runHere("--quick"), tmp_path, [], "_build.py does not run (Permission denied)")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--rows", "chains,nothing"], "'nothing' is none of chains, large, figures"),
        (["--contestants", "ours,nobody"], "there is no contestant 'nobody'; there are brute, "),
        (["--trials", "0"], "--trials"),
        (["--seconds", "-1"], "-1 is not a number above 0"),
        (["--seconds", "soon"], "'soon' is not a number"),
        (["--seed", "0"], "--seed"),
        (["none.pdb"], "none.pdb: No such file"),
        (["water.pdb"], "water.pdb: there is no chain of amino acids"),
        (["--picture", "a.doc"], "a.doc: a picture's name ends in .png, .pdf, .svg"),
        (["--picture", "a.png", "--rows", "chains"], "--picture shows the rows of figures, which --rows leaves out"),
        (["--json", "a", "--markdown", "a"], "a: is named for two outputs"),
        (["--json", "-", "--markdown", "-"], "standard output (-): is named for two outputs"),
        (["--json", ""], "the name of the json file is empty"),
        (["--csv", "missing/a.csv"], "there is no folder missing"),
        (["water.pdb", "--json", "water.pdb"], "water.pdb: would overwrite a file that is read"),
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


def test_jsonOnStandardOutput(runHere, tmp_path):
    result = runHere("--quick", "--trials", 50, "--rows", "sidechains", "--json", "-")
    assert result.returncode == 0 and filesIn(tmp_path) == []
    assert json.loads(result.stdout)["entries"] and GROUPS["sidechains"] in result.stderr
