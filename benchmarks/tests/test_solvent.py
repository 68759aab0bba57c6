"""The script solvent.py, as a user runs it. No test looks at how long anything takes."""

import numpy as np
import openmm
import pytest
import solvent
from commands import assertRefused
from energy import rows, solventrows
from energy.autocorrelation import statisticalInefficiency
from energy.proteins import BACKBONE, ENDS, REACTION_FIELD, SIDE_CHAINS, Evaluator, readSampled
from energy.samplerows import OBSERVABLES, SAMPLE_BLOCKS, SAMPLE_CUTOFFS, summarize
from energy.sampletables import combineSamples, relativeError
from energy.solventgoals import judge
from energy.solventrows import BLOCKS, CUTOFFS, KT, OUTER_TEST, combineOuter, replaceNonbonded
from energy.solventtables import makeTables, outerShare
from energy.tables import combineRuns
from openmmchaintree import OuterStatistics
from racing.report import readCSV


@pytest.fixture
def runHere(runScriptHere):
    """A function that runs the script where no structures lie ready."""
    return lambda *arguments: runScriptHere(solvent.main, *arguments)


def test_everythingQuickly(runHere, tmp_path):
    result = runHere("--quick", "--csv", "a.csv", "--markdown", "a.md", "--picture", "a.png")
    assert result.returncode == 0, result.stdout + result.stderr
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    _, entries = readCSV(tmp_path / "a.csv")
    assert {entry["group"] for entry in entries} == set(solvent.GROUPS)
    for entry in entries:
        assert 0 <= entry["quartile1"] <= entry["microseconds"] <= entry["quartile3"]
        if "energyError" in entry:
            assert entry["energyError"] < 0.05
    standIns = [entry for entry in entries if entry["group"] == "standins"]
    assert [(e["bornCutoff"], e["pairCutoff"], e["block"]) for e in standIns] == [
        (*cutoffs, block) for cutoffs in CUTOFFS for block in BLOCKS
    ]
    for entry in standIns:
        assert entry["outer"]["tests"] == 400 // entry["block"] >= entry["outer"]["kept"]
    samples = [entry for entry in entries if entry["group"] == "samples"]
    assert [(e["bornCutoff"], e["pairCutoff"], e["block"]) for e in samples] == [
        (*cutoffs, block) for cutoffs in SAMPLE_CUTOFFS for block in SAMPLE_BLOCKS
    ]
    for entry in samples:
        assert entry["outer"]["tests"] == entry["trials"] // entry["block"]
        for key, apart in entry["apart"].items():
            assert apart >= 800 and entry["rate"][key] * apart * entry["microseconds"] == pytest.approx(1e6)
    (foreign,) = (entry for entry in entries if entry["contestant"] == rows.FOREIGN)
    assert foreign["trials"] == foreign["attempted"] == 10

    tables = (tmp_path / "a.md").read_text(encoding="utf-8").split("\n**")[1:]
    assert len(tables) == 7
    for table in tables:
        lines = [line for line in table.splitlines() if line.startswith("|")]
        assert len(lines) >= 3 and len({line.count("|") for line in lines}) == 1
    assert "OpenMM's Reference platform: reached (" in result.stdout

    result = runHere("--read", "a.csv", "--markdown", "b.md", "--picture", "b.png")
    assert result.returncode == 0
    for kind in ("md", "png"):
        assert (tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes()


def test_badArguments(runHere, tmp_path):
    assertRefused(runHere("a.pdb"), tmp_path, [], "a.pdb")
    assertRefused(runHere("--rows", "growth"), tmp_path, [], "growth")


def test_anExpressionHasTheEnergyOfANonbondedForce():
    protein = readSampled()
    systems = [protein.makeSystem(REACTION_FIELD, sterics=False) for _ in range(2)]
    replaceNonbonded(systems[1])
    assert not any(isinstance(force, openmm.NonbondedForce) for force in systems[1].getForces())
    expected, found = (Evaluator(system, "Reference").energy(protein.positions) for system in systems)
    assert found == pytest.approx(expected, abs=1e-6)


def test_outerTestsOfTurnsAreCombined():
    differences = np.random.default_rng(1).normal(1.0, 2.0, size=(3, 20))
    parts = [OuterStatistics(20, 5, 0, float(of.mean()), float(of.std(ddof=1))) for of in differences]
    combined = combineOuter(parts)
    assert combined == {"tests": 60, "kept": 15, "deviation": pytest.approx(float(differences.std(ddof=1)))}


def makeChain(correlation, length, seed):
    """Make a chain each of whose values remembers so much of the one before: 1 + 2 Σ ρ = (1 + c) / (1 - c)."""
    noise = np.random.default_rng(seed).normal(size=length)
    values = [noise[0]]
    for change in noise[1:]:
        values.append(correlation * values[-1] + np.sqrt(1 - correlation**2) * change)
    return np.array(values)


def test_independentSamplesOfKnownChains():
    correlations = np.array([0.0, 0.5, 0.9, 0.98])
    chains = np.stack([makeChain(correlation, 200000, seed) for seed, correlation in enumerate(correlations)], axis=1)
    expected = (1 + correlations) / (1 - correlations)
    assert statisticalInefficiency(3 + 7 * chains) == pytest.approx(expected, rel=0.1)
    assert statisticalInefficiency(3 + chains, np.full(4, 3.0)) == pytest.approx(expected, rel=0.1)
    # What is anticorrelated is worth no more than independent samples; what never changes is no error.
    assert statisticalInefficiency(makeChain(-0.9, 1000, 5)[:, np.newaxis])[0] == 1
    assert np.all(np.isfinite(statisticalInefficiency(np.ones((10, 2)))))
    # A chain that stays far from the mean has not begun to be sampled.
    stuck = makeChain(0.0, 1000, 6)[:, np.newaxis]
    assert statisticalInefficiency(10 + stuck, np.zeros(1))[0] > 100


def test_ofSeveralTorsionsTheMedianIsTaken():
    torsions = {"chi": [0, 2, 4], "backbone": [1, 3]}
    found = summarize(np.array([7.0, 8.0, 1.0, 10.0, 30.0, 20.0, 5.0]), torsions)
    assert dict(zip(OBSERVABLES, found.tolist(), strict=True)) == {
        "chi": 5.0,
        "backbone": 15.0,
        "energy": 7.0,
        "rg": 8.0,
    }


def makeSample(seed, rate, block):
    numbers = dict.fromkeys(OBSERVABLES, rate)
    return {
        **{"group": "samples", "chain": "villin", "particles": 582, "asked": 800, "trials": 800, "seed": seed},
        **{"contestant": f"m = {block}", "bornCutoff": 0.7, "pairCutoff": 0.9, "block": block, "microseconds": 50.0},
        **{
            "method": "GBn2",
            "moves": "",
            "outer": {"tests": 10, "kept": 8},
            "rate": numbers,
            "apart": dict.fromkeys(OBSERVABLES, 1e4),
        },
    }


def test_ratesAndTheirErrorAreOfAllRuns():
    entries = [makeSample(seed, rate, 100) for seed, rate in enumerate((1.0, 4.0))]
    entries += [makeSample(seed, rate, 400) for seed, rate in enumerate((3.0, 3.0))]
    (settings,) = combineSamples(entries).values()
    assert [setting["rate"]["chi"] for setting in settings] == pytest.approx([2.0, 3.0])
    assert settings[0]["kept"] == 0.8
    # Of the logarithms: a variance of 2 ln(2)² in one line, none in the other; two runs.
    assert relativeError(settings, "chi") == pytest.approx(np.log(2) / np.sqrt(2))
    # By cutoffs there is one mean, of two lines, and so has half of their variance; by m there are two.
    means = makeTables(entries)[0].notes[-1]
    assert "0.7 / 0.9 nm: 2.45 (± 35 %); over" in means and "m = 100: 2.00, m = 400: 3.00 (± 49 %)" in means
    (alone,) = combineSamples(entries[:1]).values()
    assert relativeError(alone, "chi") is None
    assert "Standard error" not in str(makeTables(entries[:1])) and "Standard error" in str(makeTables(entries))


def test_endsMoveNothingButTheEnd():
    protein = readSampled()
    backbone, sideChains, ends = (protein.torsionsOf(which) for which in (BACKBONE, SIDE_CHAINS, ENDS))
    assert sorted(backbone + sideChains) == list(range(len(protein.torsions)))
    assert set(ends) < set(backbone) and 8 <= len(ends) <= 16
    last = [residue.index for residue in protein.topology.residues()][-8:]
    assert {protein.torsions[number].residue.index for number in ends} <= set(last)


def test_growthIsThatOfEachMove():
    sizes = [(100, 10.0, 5.0), (10000, 20.0, 10.0)]
    entries = []
    for atoms, chi, end in sizes:
        for moves, time in (("χ", chi), ("end", end)):
            entry = makeEntry("sizes", "ours", time, accepted=0.5, attempted=10)
            entries += [{**entry, "chain": str(atoms), "particles": atoms, "moves": moves}]
            entries += [{**entries[-1], "contestant": OUTER_TEST}]
    lines, _ = judge(entries)
    assert lines == [f"goal: {name}, in solvent: grow up to N^0.2: reached (N^0.15)" for name in ("χ", "end")]
    (table,) = makeTables(entries)
    assert len(table.rows) == 4


def makeEntry(group, contestant, microseconds, **values):
    entry = {"group": group, "chain": "villin", "particles": 582, "method": "GBn2", "moves": "", "asked": 1}
    return {**entry, "contestant": contestant, "microseconds": microseconds, **values}


def makeEntries(microseconds=30.0, kept=90, error=1e-3):
    outer = {"tests": 100, "kept": kept, "deviation": KT}
    stages = {"near pairs": {"computed": 50, "refused": 10}}
    counts = {"attempted": 100, "clashed": 20, "accepted": 0.4, "stages": stages}
    return [
        makeEntry(solventrows.SOLVENT, "ours", microseconds, outer=outer, **counts),
        makeEntry(solventrows.SOLVENT, rows.FOREIGN, 60000.0),
        makeEntry(solventrows.WHOLE, OUTER_TEST, 240.0, energy=-1000.0, energyError=error),
        makeEntry(solventrows.WHOLE, rows.ONE_ENERGY, 60000.0, energy=-1000.0, energyError=0.1),
    ]


def test_goals():
    lines, isWrong = judge(makeEntries())
    assert not isWrong and "NOT REACHED" not in "".join(lines)
    assert "goal: villin, whole trial: 35 µs: reached (30.0)" in lines
    assert "goal: villin, outer tests: up to a sixth of the time: reached (2 %)" in lines
    lines, isWrong = judge(makeEntries(70.0, 70, 7e-3))
    assert not isWrong and len([line for line in lines if "NOT REACHED" in line]) == 4
    assert judge(makeEntries(error=0.2))[1]
    assert judge(makeEntries(error=float("nan")))[1]


def test_countsAreThoseOfAllRuns():
    table = makeTables(makeEntries() + makeEntries(40.0, 70))[0]
    (line,) = table.rows
    assert line[table.columns.index("ours")] == "35.0 (30.0–40.0)"
    assert line[table.columns.index("outer tests kept")] == "0.80 of 200"
    assert line[table.columns.index("difference, kT")] == "1.00"
    combined = combineRuns(makeEntries())
    assert outerShare(combined[0], combined[1:]) == pytest.approx(240 / (400 * 30))
