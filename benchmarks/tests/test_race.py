"""The benchmark race.py. No test looks at how long anything takes."""

import openmm
import pytest
import race
import rivals
from commands import filesIn
from measure import Course
from program import Program, ProgramError
from proteins import ChainModels
from racetables import makeTables
from report import combineRuns, exponent
from scenes import GLYCINES, realStructurePath, writePDB

# ---- Runs ----


def test_everythingQuickly(runQuickly):
    machine, entries, tables = runQuickly(race.main, "--trials", 100)
    assert machine["processor"] and machine["commit"] and "-ffp-contract=off" in machine["compiler"]
    assert len(machine["load at begin"].split(", ")) == len(machine["load at end"].split(", ")) == 3
    assert machine["instruction sets of the engine"]
    assert list(dict.fromkeys(entry["group"] for entry in entries)) == [name for name in race.GROUPS if name != "large"]
    races = {}
    for entry in entries:
        races.setdefault((entry["group"], entry["chain"], entry.get("moves")), {})[entry["contestant"]] = entry
    for (group, _, _), contestants in races.items():
        if group not in ("pairs", "python"):
            assert {"lazygrid", "ours"} <= contestants.keys()
            assert len({entry["accepted"] for entry in contestants.values()}) == 1
        if group == "figures":
            assert {"fullgrid", "obbtree1", "kobbtree", "published", "improved"} <= contestants.keys()
            assert contestants["published"]["volumeTests"] > contestants["ours"]["volumeTests"] > 0
        if group == "python":
            assert {"ours from Python", "SciPy", "FCL", "OpenMM CPU", "Simulation.step"} <= contestants.keys()
    assert len(tables) == 9


def test_sameSeedSameTrials(runHere):
    def count(*arguments):
        result = runHere(race.main, "--quick", "--rows", "sidechains", "--csv", "a.csv", *arguments)
        assert result.returncode == 0
        with open("a.csv", encoding="utf-8") as file:
            lines = [line.split(",") for line in file if not line.startswith("# ")]
        return [line[lines[0].index("particleTests")] for line in lines[1:]]

    assert count() == count("--seed", 1) != count("--seed", 2)


def test_slowContestantsRaceOnTheFirstChain(runHere):
    result = runHere(race.main, "--quick", "--trials", 50, "--runs", 2, "--rows", "figures", "--markdown", "a.md")
    assert result.returncode == 0
    with open("a.md", encoding="utf-8") as file:
        table = file.read().split("\n**")[1]
    lines = {line.split(" | ")[0]: line for line in table.splitlines() if line.startswith("| ")}
    assert "(" in lines["| ours"] and "(" not in lines["| K-OBBTree"] and "2 × 50" in lines["| trials"]


def test_missingStructuresAreNamed(runHere):
    result = runHere(race.main, "--trials", 20, "--runs", 1, "--rows", "sidechains")
    assert result.returncode == 0
    for name in race.FILES:
        assert f"skipped: {name}: not in the folder that CHAINTREE_TEST_DATA names" in result.stdout.splitlines()


def test_theLongestChainOfAStructure():
    assert len(ChainModels(realStructurePath("1htb.pdb")).heavyAtoms.positions) == 2776
    assert len(ChainModels(realStructurePath("2cas.pdb.gz")).heavyAtoms.positions) == 4347


# ---- Verdicts ----


@pytest.mark.parametrize("name", [None, "bpti_h.pdb", "1htb.pdb"])
def test_sceneAgreesWithTheForce(tmp_path, name):
    """What the program says about trials of a protein's scene is what the force says about the same trials."""
    models = ChainModels(None if name is None else realStructurePath(name))
    for model in (models.backbone, models.heavyAtoms, models.allAtoms):
        if model is None:
            continue
        # Backbones alone are loose.
        moves = "uniform" if model is models.backbone else "gaussian"
        recording = record(tmp_path, model, "--moves", moves)
        assert recording.names.tolist() != list(range(len(recording.names))) or model is models.backbone
        force = model.force
        system = openmm.System()
        for _ in model.positions:
            system.addParticle(1)
        system.addForce(force)
        platform = openmm.Platform.getPlatformByName("Reference")
        context = openmm.Context(system, openmm.VerletIntegrator(0.001), platform)
        context.setPositions(model.positions)
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


@pytest.mark.parametrize("rival", [*rivals.RIVALS, rivals.OurCalls])
def test_rivalsAgreeWithTheProgram(tmp_path, rival):
    if rival is not rivals.OurCalls and not rivals.isHere(rival):
        pytest.skip(f"{rival.name} is not installed")
    for chain in (ChainModels(None).heavyAtoms, race.Chain("random", 200)):
        recording = record(tmp_path, chain)
        contestant = rival(recording)
        disagreements = 0
        for trial in recording.trials:
            disagreements += contestant.test(trial) != trial.clash
            if not trial.clash:
                contestant.accept()
        assert disagreements <= (0 if rival.isExact else 2)


def record(folder, chain, *options):
    """The Recording of trials that the program has run, some of which clash."""
    given = {"--trials": 400, "--block": 100, "--record": folder / "record"}
    course = Course(Program(), 1, None, folder)
    course.program.run({**given, **chain.options(course), **dict(zip(options[::2], options[1::2], strict=True))})
    recording = rivals.readRecording(folder / "record")
    assert len(recording.trials) == 500
    assert 10 < sum(trial.clash for trial in recording.trials) < 490
    return recording


def test_aWrongVerdictIsReported(runHere, monkeypatch):
    monkeypatch.setattr(rivals.ScipyTrees, "_clashes", lambda *arguments: False)
    result = runHere(race.main, "--quick", "--rows", "python,sidechains", "--csv", "a.csv")
    assert result.returncode == 1
    assert "FAILED: python: villin all atoms, uniform: SciPy calls trial " in result.stdout
    assert "free of clashes, lazygrid does not" in result.stdout
    with open("a.csv", encoding="utf-8") as file:
        assert "\npython," not in file.read()


def test_aFailingRowDoesNotEndTheOthers(runHere, monkeypatch):
    honest = Program.run

    def fail(self, options):
        if options.get("--moves") == "uniform":
            raise ProgramError("ours calls trial 7 a clash, lazygrid does not")
        return honest(self, options)

    monkeypatch.setattr(Program, "run", fail)
    result = runHere(race.main, "--quick", "--trials", 100, "--rows", "chains")
    assert result.returncode == 1
    line = "FAILED: chains: random compact, 1,000 spheres, uniform: ours calls trial 7 a clash, lazygrid does not"
    assert line in result.stdout and "random compact   5° " in result.stdout


def test_interruptLeavesWhatThereIs(runHere, monkeypatch):
    honest, calls = Program.run, []

    def interrupt(self, options):
        calls.append(options)
        if len(calls) > 2:
            raise KeyboardInterrupt
        return honest(self, options)

    monkeypatch.setattr(Program, "run", interrupt)
    result = runHere(race.main, "--quick", "--trials", 100, "--rows", "chains")
    assert result.returncode == 130
    assert "interrupted: this is what was measured so far" in result.stdout and "random compact" in result.stdout


# ---- Bad input ----


def test_theProgramSaysWhatIsWrong():
    with pytest.raises(ProgramError, match="^there is no contestant nobody for this measure$"):
        Program().run({"--contestants": "nobody"})


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--rows", "chains,nothing"], "'nothing' is none of figures, chains, large"),
        (["--trials", "0"], "--trials"),
        (["none.pdb"], "none.pdb: No such file"),
        (["water.pdb"], "water.pdb: there is no chain of amino acids"),
        (["--read", "water.pdb"], "water.pdb: is no CSV that the benchmarks wrote"),
        (["--quick", "--program", "nothing"], "there is no program nothing"),
        (["--quick", "--program", "water.pdb"], "water.pdb does not run (Permission denied)"),
    ],
)
def test_badArguments(runHere, tmp_path, arguments, words):
    # Residues that are no water by their name, and no amino acids.
    writePDB(tmp_path / "water.pdb", [line.replace("GLY", "LIG").replace("ATOM  ", "HETATM") for line in GLYCINES])
    result = runHere(race.main, *arguments, "--csv", "a.csv")
    assert result.returncode == 2 and words in result.stderr and result.stdout == ""
    assert filesIn(tmp_path) == ["water.pdb"]


# ---- Tables ----


def makeEntry(contestant, size, time, **others):
    """An entry of a run."""
    entry = {"group": "chains", "chain": "random compact", "particles": size, "moves": "uniform", "trials": 100}
    return {**entry, "contestant": contestant, "microseconds": time, "accepted": 0.5, **others}


def test_runsAreCombined():
    times = {5.0: 0.1, 1.0: 0.2, 2.0: 0.3}
    runs = [makeEntry("ours", 1000, time, accepted=accepted) for time, accepted in times.items()]
    (combined,) = combineRuns(runs)
    assert [combined[key] for key in ("least", "microseconds", "most", "runs")] == [1.0, 2.0, 5.0, 3]
    assert combined["accepted"] == pytest.approx(0.2) and combined["trials"] == 300
    counts = [{"near": {"refused": 2, "microseconds": 3}}, {"near": {"refused": 4, "microseconds": 5}}]
    (combined,) = combineRuns([makeEntry("ours", 1000, 1.0, **one, error={"largest": 1.0}) for one in counts])
    assert combined["near"] == {"refused": 6, "microseconds": 4} and combined["error"] == {"largest": 1.0}


def test_growthIsOfAllSizes():
    """A line through all sizes: the middle one counts, too."""
    times = {100: 1.0, 1000: 8.0, 10000: 4.0}
    entries = [makeEntry(name, size, time) for size, time in times.items() for name in ("lazygrid", "ours")]
    (table,) = makeTables(combineRuns(entries))
    assert "N^0.30 (random compact, uniform)" in table.notes[0]
    assert exponent({100: 1.0, 1000: 8.0, 10000: 64.0}) == pytest.approx(0.90309)
