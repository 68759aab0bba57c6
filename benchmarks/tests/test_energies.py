"""The script energies.py, as a user runs it. No test looks at how long anything takes."""

import energies
import numpy as np
import openmm
import pytest
from commands import assertRefused
from energy import proteins, rows
from energy.forcefield import readSystem
from energy.goals import judge
from energy.packing import PackedCopies
from energy.proteins import METHODS, NO_CUTOFF, REACTION_FIELD, Evaluator, readSampled
from energy.rows import PIVOT, SIDE_CHAIN, SMALL_PIVOT, WINDOW
from energy.tables import combineRuns, growthOf, makeTables
from openmm import app, unit
from openmmchaintree.errors import InputError
from racing import platforms
from racing.program import Program, ProgramError
from racing.report import readCSV
from racing.table import exponent

LITTLE = ("--quick", "--trials", 60, "--warm", 100)


@pytest.fixture
def runHere(runScriptHere):
    """A function that runs the script where no structures lie ready."""
    return lambda *arguments: runScriptHere(energies.main, *arguments)


@pytest.fixture(scope="module")
def villin():
    """The villin headpiece."""
    return readSampled()


# ---- Runs ----


def test_everythingQuickly(runHere, tmp_path):
    result = runHere(*LITTLE, "--csv", "a.csv", "--markdown", "a.md", "--picture", "a.png")
    assert result.returncode == 0, result.stdout + result.stderr
    assert "wrote a.csv, a.md, a.png" in result.stdout
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")
    machine, entries = readCSV(tmp_path / "a.csv")
    assert "portable" in machine["instruction sets of the engine"]

    work = [entry for entry in entries if entry["group"] == "work"]
    assert {entry["method"] for entry in work} == {method.name for method in METHODS}
    assert {entry["moves"] for entry in work} == {str(moves) for moves in (SIDE_CHAIN, WINDOW, PIVOT)}
    for entry in work:
        assert 0 < entry["quartile1"] <= entry["microseconds"] <= entry["quartile3"]
        if entry["contestant"].startswith("ours"):
            parts = [entry[part] for part in ("terms", "near", "other")]
            assert parts[0]["reached"] == entry["free"] <= entry["asked"] == 60
            assert sum(part["refused"] for part in parts) + entry["accepted"] == entry["free"]
        if entry["contestant"] in ("ours-portable", rows.ONE_ENERGY):
            assert 0 < entry["energyError"] < 0.1 and 0 < entry["changeError"]["largest"] < 0.01
    for ours in (entry for entry in entries if entry["group"] == "trials" and entry["contestant"] == "ours"):
        refused = sum(stage["refused"] for stage in ours["stages"].values())
        assert ours["clashed"] + refused + round(ours["accepted"] * ours["attempted"]) == ours["attempted"]
    assert {entry["particles"] for entry in entries if entry["group"] == "growth"} == {582, 2 * 582}

    tables = (tmp_path / "a.md").read_text(encoding="utf-8").split("\n**")[1:]
    assert len(tables) == 7
    for table in tables:
        lines = [line for line in table.splitlines() if line.startswith("|")]
        assert len(lines) >= 3 and len({line.count("|") for line in lines}) == 1
        assert f"\n{table[: table.index('*')]}" in result.stdout
    goals = [line for line in result.stdout.splitlines() if line.startswith("goal: ")]
    assert "OpenMM's Reference platform: reached (" in goals[0]

    result = runHere("--read", "a.csv", "--markdown", "b.md", "--picture", "b.png")
    assert result.returncode == 0
    for kind in ("md", "png"):
        assert (tmp_path / f"a.{kind}").read_bytes() == (tmp_path / f"b.{kind}").read_bytes()


def test_sameSeedSameTrials(runHere, tmp_path, monkeypatch):
    monkeypatch.setattr(energies, "_QUICK_COPIES", (1,))

    def count(name, *arguments):
        runHere(*LITTLE, "--rows", "growth", "--csv", name, *arguments)
        return [(entry["free"], entry["accepted"]) for entry in readCSV(tmp_path / name)[1]]

    assert count("a.csv") == count("b.csv", "--seed", 1) != count("c.csv", "--seed", 2)


def test_whatIsNotThereIsSkipped(runHere, monkeypatch):
    monkeypatch.setattr(platforms, "_platformNames", lambda: ["Reference"])
    result = runHere(*LITTLE, "--rows", "work", "--markdown", "-")
    assert result.returncode == 0
    assert "skipped: OpenMM's energies: OpenMM has no CPU platform here" in result.stdout


def test_badArguments(runHere, tmp_path):
    assertRefused(runHere("a.pdb"), tmp_path, [], "a.pdb")
    assertRefused(runHere("--rows", "figures"), tmp_path, [], "figures")
    assertRefused(runHere("--picture", "a.doc"), tmp_path, [], "a.doc: a picture's name ends in .png, .pdf, .svg")


# ---- What goes wrong is reported ----


def test_wrongEnergiesAreReported(runHere, monkeypatch):
    honest = proteins.SampledProtein.readTerms

    def readTerms(self, method):
        terms = honest(self, method)
        terms.particles[0, 0] += 0.1
        return terms

    monkeypatch.setattr(proteins.SampledProtein, "readTerms", readTerms)
    result = runHere(*LITTLE, "--rows", "work")
    assert result.returncode == 1
    assert "of OpenMM's Reference platform: NOT REACHED (" in result.stdout


def test_aFailingRowDoesNotEndTheOthers(runHere, tmp_path, monkeypatch):
    def fail(self, options, variables=None):
        raise ProgramError("not enough memory")

    monkeypatch.setattr(Program, "race", fail)
    result = runHere(*LITTLE, "--rows", "work,trials", "--csv", "a.csv")
    assert result.returncode == 1
    assert "FAILED: work: villin, no cutoff, pivot, 1°: not enough memory" in result.stdout
    assert {entry["group"] for entry in readCSV(tmp_path / "a.csv")[1]} == {"trials"}


# ---- Force fields ----


def test_foreignForcesAreRefused(villin):
    system = villin.makeSystem(NO_CUTOFF, sterics=False)
    system.addForce(openmm.CustomExternalForce("x"))
    with pytest.raises(InputError, match="CustomExternalForce"):
        readSystem(system)
    with pytest.raises(InputError, match="NonbondedForce"):
        readSystem(openmm.System())


def test_termsOfASystem(villin):
    system = villin.makeSystem(REACTION_FIELD, sterics=False)
    terms = readSystem(system)
    assert terms.cutoff == 1.0 and terms.switching == 0 and terms.dielectric == 78.3
    assert len(terms.particles) == 582 and readSystem(villin.makeSystem(NO_CUTOFF, sterics=False)).cutoff == 0
    # Their bonds have the energy that OpenMM's have.
    alone = openmm.System()
    for _ in range(582):
        alone.addParticle(1)
    bonds = next(force for force in system.getForces() if isinstance(force, openmm.HarmonicBondForce))
    alone.addForce(openmm.XmlSerializer.clone(bonds))
    bond = next(termSet for termSet in terms.termSets if termSet.kind == 0)
    ends = villin.positions[bond.particles]
    lengths = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)
    energy = np.sum(0.5 * bond.parameters[:, 1] * (lengths - bond.parameters[:, 0]) ** 2)
    assert energy == pytest.approx(Evaluator(alone, "Reference").energy(villin.positions), rel=1e-9)


def test_hydrogensAreAdded(tmp_path, villin):
    heavy = app.Modeller(villin.topology, villin.positions * unit.nanometer)
    heavy.delete([atom for atom in villin.topology.atoms() if atom.element is app.element.hydrogen])
    with open(tmp_path / "heavy.pdb", "w", encoding="ascii") as file:
        app.PDBFile.writeFile(heavy.topology, heavy.positions, file)
    text = (tmp_path / "heavy.pdb").read_text(encoding="ascii").replace("HIE", "HIS")
    (tmp_path / "heavy.pdb").write_text(text, encoding="ascii")
    protein = readSampled(tmp_path / "heavy.pdb")
    assert protein.name == "heavy, hydrogens added" and len(protein.positions) == 582
    assert np.isfinite(protein.positions).all()


# ---- Trials of others ----


def test_othersTurnWhatTorsionsTurn(villin):
    moved = rows._movedBy(villin)
    assert len(moved) == len(villin.torsions)
    bonds = [(bond.atom1.index, bond.atom2.index) for bond in villin.topology.bonds()]
    for (near, far), atoms in moved[::10]:
        turned = rows._turned(villin.positions, near, far, atoms, 0.3)
        lengths = [[np.linalg.norm(places[i] - places[j]) for i, j in bonds] for places in (villin.positions, turned)]
        np.testing.assert_allclose(*lengths, atol=1e-12)
        still = np.setdiff1d(np.arange(582), atoms)
        assert (turned[still] == villin.positions[still]).all()
        assert far in atoms and near in still


# ---- Copies ----


@pytest.mark.parametrize("count", [1, 2, 4])
def test_copiesAreNear(villin, count):
    packed = PackedCopies(villin, count)
    copies = packed.positions.reshape(count, 582, 3)
    nearest = [
        min(np.linalg.norm(a[:, None] - b[None], axis=2).min() for k, b in enumerate(copies) if k != n)
        for n, a in enumerate(copies)
        if count > 1
    ]
    assert all(0.3 <= distance < 0.35 for distance in nearest)
    scene = packed.makeScene()
    assert len(scene.spheres) == len(packed.positions) == 582 * count
    assert sum(link.parent < 0 for link in scene.links) == 1
    assert len(scene.links) == 1 + len(villin.torsions) * count
    assert len(packed.readTerms(REACTION_FIELD).particles) == 582 * count
    # A pivot in the first copy moves all others.
    behind = [len(villin.torsions)] if count > 1 else []
    for number, link in enumerate(scene.links):
        if link.parent in behind:
            behind.append(number)
    first = min(number for number, link in enumerate(scene.links) if link.parent == 0 and not link.isSideChain)
    chain = {first}
    for number, link in enumerate(scene.links):
        if link.parent in chain:
            chain.add(number)
    assert set(scene.particleLinks[582:].tolist()) <= chain


# ---- Goals and tables ----


def makeEntry(contestant="ours-avx512", **values):
    entry = {"group": "work", "chain": "5dfr_h", "particles": 2489, "method": REACTION_FIELD.name, "moves": str(PIVOT)}
    return {**entry, "asked": 100, "contestant": contestant, "microseconds": 100.0, **values}


def errors(energy, change):
    return {"energy": -1000.0, "energyError": energy, "changeError": {"largest": change, "rms": change}}


@pytest.mark.parametrize(
    ("entry", "words", "isWrong"),
    [
        (makeEntry(**errors(5e-3, 1e-4)), "kJ/mol of OpenMM's Reference platform: reached", False),
        (makeEntry(**errors(7e-3, 1e-4)), "kJ/mol of OpenMM's Reference platform: NOT REACHED", False),
        (makeEntry(**errors(7e-2, 1e-4)), "kJ/mol of OpenMM's Reference platform: NOT REACHED", True),
        (makeEntry(**errors(1e-3, 2e-3)), "changes of U within 0.001 kJ/mol: NOT REACHED", False),
        (makeEntry(**errors(1e-3, 2e-2)), "changes of U within 0.001 kJ/mol: NOT REACHED", True),
        (makeEntry("other", **errors(1.0, 1.0)), "no energies were compared", False),
    ],
)
def test_goalsOfErrors(entry, words, isWrong):
    entry = {**entry, "bytes": -1, "treeBytes": -1}
    stages = makeEntry("ours-stages", mean=50.0)
    lines, wrong = judge([entry, stages] if entry["contestant"] != "other" else [])
    assert wrong == isWrong and any(words in line for line in lines)


def test_goalsOfTimes():
    def lines(time, mean):
        return judge([makeEntry(microseconds=time, bytes=-1), makeEntry("ours-stages", mean=mean)])[0]

    assert "goal: 5dfr_h, reaction field 1.0 nm, pivot, 1°: 110 µs: reached (100.0)" in lines(100.0, 50.0)
    assert "goal: 5dfr_h, reaction field 1.0 nm, pivot, 1°: 110 µs: NOT REACHED (111.0)" in lines(111.0, 50.0)
    assert any("until refused: 55 µs: NOT REACHED (60.0)" in line for line in lines(100.0, 60.0))


def test_mediansOverRuns():
    runs = [makeEntry(microseconds=time, free=10, near={"refused": 2}) for time in (1.0, 5.0, 3.0)]
    (row,) = combineRuns(runs)
    entry = row["ours-avx512"]
    assert (entry["microseconds"], entry["least"], entry["most"]) == (3.0, 1.0, 5.0)
    assert entry["free"] == 30 and entry["near"] == {"refused": 6}


def test_growth():
    runs = [
        makeEntry("ours", group="growth", moves=str(SMALL_PIVOT), particles=n, microseconds=float(n) ** 0.7)
        for n in (2500, 5000, 40000)
    ]
    assert growthOf(combineRuns(runs)) == {"pivot, 0.1°": pytest.approx(0.7)}
    assert exponent({10: 1.0, 100: 10.0}) == pytest.approx(1)
    assert makeTables([]) == []
