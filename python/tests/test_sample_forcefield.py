"""The command openmm-chaintree sample in a force field, as a user runs it."""

import io
import json
import random
import re
import signal

import commands
import numpy as np
import openmm
import pytest
from commands import VILLIN_FILES, assertRefused, filesIn
from openmm import app, unit
from openmmchaintree.command.energymodel import EnergyModel
from openmmchaintree.command.forbidden import measureForbidden
from openmmchaintree.command.sampling import Sampling
from openmmchaintree.command.terminal import Interrupts
from openmmchaintree.replicas import segment
from openmmchaintree.structures.structure import readStructure
from scenes import GLYCINES, readDCD, realStructurePath, writePDB

PROTEIN = "amber14/protein.ff14SB.xml"  # a part of amber14-all.xml, quicker to read


@pytest.fixture
def runHere(runCommandHere):
    return lambda *arguments: runCommandHere("sample", *arguments)


@pytest.fixture(scope="module")
def lines(villin):
    """A function that returns the lines of a PDB file of villin's atoms that a function chooses, and names residues."""

    def choose(isChosen, rename=lambda residue: residue.name):
        modeller = app.Modeller(villin.topology, villin.positions * unit.nanometer)
        modeller.delete([atom for atom in modeller.topology.atoms() if not isChosen(atom)])
        for residue in modeller.topology.residues():  # of a copy by now
            residue.name = rename(residue)
        text = io.StringIO()
        app.PDBFile.writeFile(modeller.topology, modeller.positions, text, keepIds=True)
        text = text.getvalue().splitlines()
        return [line[:21] + "A" + line[22:] for line in text if line.startswith(("ATOM", "HETATM", "TER"))]

    return choose


def isHeavy(atom):
    return atom.element is not app.element.hydrogen


def energyByOpenMM(topology, positions, *files, **arguments):
    """U of the Reference platform, by files and the topology that the command has written."""
    system = app.ForceField(*files).createSystem(topology, **arguments)
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    return context.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)


_FATES = {"notMade": "not made", "clashed": "clashed", "rejectedByEnergy": "rejected", "accepted": "accepted"}


def assertTrialsAddUp(summary, output):
    """Each trial was not made, clashed, was rejected or accepted, in the table as in JSON; return those not made."""
    moves = summary["moves"]
    for move in moves:
        assert move["attempted"] == sum(move[fate] for fate in _FATES)
    outer = summary["energy"]["outerTests"]
    takenBack = outer["trialsTakenBack"] if outer else 0
    assert sum(move["attempted"] for move in moves) + takenBack == summary["trials"]
    notMade = {move["name"]: move["notMade"] for move in moves}
    fates = [fate for fate in _FATES if fate != "notMade" or any(notMade.values())]
    lines = output.splitlines()
    header = next(index for index, line in enumerate(lines) if line.split()[:2] == ["move", "attempted"])
    assert re.split("  +", lines[header].strip()) == ["move", "attempted", *(_FATES[fate] for fate in fates), "%"]
    for line, move in zip(lines[header + 1 :], moves, strict=False):
        name, *counts, _ = re.split("  +", line.strip())
        assert name == move["name"]
        assert [int(count.replace(",", "")) for count in counts] == [move[key] for key in ("attempted", *fates)]
    below = lines[header + 1 + len(moves) + (len(moves) > 1)]
    assert below.startswith("not made: ") == any(notMade.values())
    return notMade


def test_villin(runHere, tmp_path):
    result = runHere(
        *("--forcefield", "amber14-all.xml", "--temperature", 310, "--trials", 2000, "--frames", 4, "--seed", 1),
        *("--json", "summary.json"),
    )
    assert result.returncode == 0, result.stderr
    assert filesIn(tmp_path) == ["summary.json", *VILLIN_FILES]
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert [move["name"] for move in summary["moves"]] == [
        *("φ/ψ closed 8°", "φ/ψ local 4°", "φ/ψ ends ±10°", "φ/ψ ends ±180°", "φ/ψ ±1°"),
        *("χ ±10°", "χ rotamers", "χ outer rotamers", "χ of ends ±10°", "χ of ends rotamers"),
        *("ω local 4°", "ω ±1°", "rotor ±10°", "rotor ±180°", "planar ±10°", "planar ±180°"),
        *("others ±10°", "others ±180°"),
    ]
    notMade = assertTrialsAddUp(summary, result.stdout)
    assert notMade.pop("φ/ψ closed 8°") > 0 and not any(notMade.values())
    assert all(move["accepted"] > 0 for move in summary["moves"] if move["attempted"] >= 50)
    energy = summary["energy"]
    assert (energy["forceField"], energy["temperature"], energy["nonbondedCutoff"]) == (["amber14-all.xml"], 310, None)

    frames = readDCD(tmp_path / "villin.dcd")
    topology = app.PDBFile(str(tmp_path / "villin-topology.pdb")).topology
    assert frames.shape == (5, topology.getNumAtoms(), 3) and summary["addedHydrogens"] == 0
    # Positions in the trajectory are in single precision.
    for frame, held in zip(frames, energy["potentialEnergies"], strict=True):
        assert held == pytest.approx(energyByOpenMM(topology, frame, "amber14-all.xml"), abs=0.2)
    assert np.abs(np.diff(energy["potentialEnergies"])).min() > 0.5

    ends = energy["potentialEnergy"]
    assert ends["first"] == energy["potentialEnergies"][0] and ends["last"] == energy["potentialEnergies"][-1]
    assert ends["mean"] == pytest.approx(np.mean(energy["potentialEnergies"][1:]))
    assert ends["lastByOpenMM"] == pytest.approx(ends["last"], rel=1e-6, abs=5e-3)
    assert sum(force["energy"] for force in energy["forces"]) == pytest.approx(ends["lastByOpenMM"])
    assert {force["name"]: force["kind"] for force in energy["forces"]} == {
        "HarmonicBondForce": "constant",
        "HarmonicAngleForce": "constant",
        "PeriodicTorsionForce": "native",
        "NonbondedForce": "native",
    }
    assert all(force["reason"] for force in energy["forces"])
    stages = {stage["stage"]: stage for stage in energy["stages"]}
    assert list(stages) == ["bonded terms", "near pairs", "other pairs"]
    refused = sum(move["rejectedByEnergy"] for move in summary["moves"])
    assert sum(stage["refused"] for stage in stages.values()) == refused > 0

    assert "rigid: bond lengths and angles; rings (HIE, PHE, PRO, TRP)\n" in result.stdout
    planned = "energy: amber14-all.xml at 310 K, no cutoff; native PeriodicTorsionForce, NonbondedForce; constant "
    assert planned in result.stdout
    assert f"U: {ends['first']:,.1f} kJ/mol at the start, {ends['mean']:,.1f} as the mean" in result.stdout
    assert "note: the energy is computed in vacuum" in result.stdout
    for force in energy["forces"]:
        (line,) = [line for line in result.stdout.splitlines() if line.startswith(f"{force['name']} ")]
        assert f"{force['energy']:,.1f}  {force['kind']}" in line and line.endswith(force["reason"])


@pytest.fixture
def sampleMoves(runHere, tmp_path):
    """A function that samples a number of trials with options and returns the impossible trials of each move."""

    def sample(trials, *options):
        common = ("--forcefield", PROTEIN, "--frames", trials // 400, "--seed", 1, "--json", "summary.json")
        result = runHere(*common, "--trials", trials, *options)
        assert result.returncode == 0, result.stderr
        summary = json.loads((tmp_path / "summary.json").read_text())
        notMade = assertTrialsAddUp(summary, result.stdout)
        assert list(notMade) == [move["name"] for move in summary["moves"]]
        return notMade

    return sample


def test_oneResidueHasNoWindows(sampleMoves):
    """Nothing closes among φ, ψ and three χ in the middle of the chain, which is no end either."""
    notMade = sampleMoves(800, "--move", "resSeq 17")
    assert list(notMade) == [
        *("φ/ψ local 4°", "φ/ψ ±1°", "χ ±10°", "χ rotamers", "χ outer rotamers", "ω local 4°", "ω ±1°")
    ]
    assert not any(notMade.values())


def test_disorderedChains(runHere, sampleMoves, tmp_path):
    assertRefused(runHere("--disordered"), tmp_path, [], "--disordered", "--forcefield")
    ofBackbones = [name for name in sampleMoves(800, "--disordered") if name.startswith("φ/ψ")]
    assert ofBackbones == ["φ/ψ by residue", "φ/ψ ±180°", "φ/ψ ±30°", "φ/ψ closed 20°"]


def test_otherKindsOfTorsions(sampleMoves):
    """ω turns by little and to the other side, rotors by more; all are named."""
    assert list(sampleMoves(400, "--torsions", "omega,rotor")) == ["ω ±1°", "ω ±180°", "rotor ±10°", "rotor ±180°"]


def test_nucleicAcid(runHere, tmp_path):
    files = ("amber14/DNA.OL15.xml", "implicit/gbn2.xml")
    result = runHere(
        *(realStructurePath("1bna.pdb"), "--add-hydrogens", "--forcefield", *files, "--trials", 800, "--frames", 20),
        *("--rigid-bodies", "--seed", 1, "--json", "summary.json"),
    )
    assert result.returncode == 0, result.stderr
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert [move["name"] for move in summary["moves"]] == [
        *("α–ζ closed 8°", "α–ζ local 4°", "α–ζ ends ±10°", "α–ζ ±1°", "χ of bases ±10°", "χ of bases ±180°"),
        *("rotor ±10°", "rotor ±180°", "planar ±10°", "planar ±180°"),
        "rigid body 0.01 nm, ±1°",
    ]
    assert assertTrialsAddUp(summary, result.stdout)["α–ζ closed 8°"] > 0


def test_sameSeedSameFrames(runHere, tmp_path):
    moves = {}
    for name, seed in (("first", 7), ("second", 7), ("third", 8)):
        options = ("--forcefield", PROTEIN, "--trials", 800, "--frames", 2, "--seed", seed)
        assert runHere(*options, "--json", f"{name}.json", "-o", name).returncode == 0
        moves[name] = json.loads((tmp_path / f"{name}.json").read_text())["moves"]
    frames = {name: readDCD(tmp_path / f"{name}.dcd") for name in moves}
    assert np.array_equal(frames["first"], frames["second"]) and moves["first"] == moves["second"]
    assert not np.array_equal(frames["first"], frames["third"]) and moves["first"] != moves["third"]


def test_hardSpheresAloneHaveNoEnergy(runHere, tmp_path):
    result = runHere("--trials", 100, "--json", "summary.json")
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["energy"] is None and summary["addedHydrogens"] == 0
    assert "kJ/mol" not in result.stdout and "energy:" not in result.stdout


@pytest.mark.parametrize("trials", [400, 20000])
def test_hardSpheresBesideAForceField(runHere, tmp_path, trials):
    """They are reported with the share of conformations that they forbid, or with the reason why it is not known."""
    options = ("--forcefield", PROTEIN, "--steric", "hard", "--trials", trials, "--frames", 1, "--seed", 1)
    result = runHere(*options, "--json", "hard.json")
    summary = json.loads((tmp_path / "hard.json").read_text())
    assert result.returncode == 0 and summary["stericMode"] == "hard" and summary["pairsBeyondLimit"] == []
    forbidden = summary["forbiddenBySpheres"]
    assert f"hard spheres: {forbidden['text']}" in " ".join(result.stdout.split())
    if trials == 400:
        assert forbidden["forbidden"] is None and "that takes a run of 20,000 trials or more" in forbidden["text"]
    else:
        assert 0 < forbidden["forbidden"] <= forbidden["frames"] == 50


def test_interruptsEndWhatHardSpheresForbid():
    """A run that was interrupted is not followed by another one."""
    interrupts = Interrupts(lambda: None)
    interrupts.receive(signal.SIGINT)
    choice = EnergyModel([PROTEIN], 300.0, steric="hard")
    sampling = Sampling(readStructure(), 1, energyModel=choice)
    before = sampling.integrator.getMoveStatistics(0)
    forbidden = measureForbidden(sampling, 10**6, interrupts)
    assert forbidden["forbidden"] is None and "the run was interrupted" in forbidden["text"]
    assert sampling.integrator.getMoveStatistics(0) == before


def test_noSpheresBesideAForceField(runHere, tmp_path):
    """By default atoms may overlap as the force field lets them: they are counted, and no error."""
    result = runHere("--forcefield", PROTEIN, "--trials", 4000, "--frames", 1, "--seed", 1, "--json", "off.json")
    summary = json.loads((tmp_path / "off.json").read_text())
    assert result.returncode == 0 and summary["stericMode"] == "off" and summary["forbiddenBySpheres"] is None
    assert summary["toleratedPairs"] == summary["pairsBeyondLimit"] == []
    count = summary["clashesAtEnd"]
    words = f"{count} overlap{'s' if count == 1 else ''} by more than hard spheres may"
    assert words in " ".join(result.stdout.split())
    refused = runHere("--steric", "hard")
    assert refused.returncode == 2 and "--steric needs --forcefield" in refused.stderr


def test_implicitSolvent(runHere, tmp_path):
    """The file has water, which an implicit solvent stands for."""
    files = ("amber14-all.xml", "implicit/obc2.xml")
    result = runHere("--forcefield", *files, "--trials", 5, "--frames", 1, "--seed", 1, "--json", "summary.json")
    assert result.returncode == 0, result.stderr
    assert "vacuum" not in result.stdout
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["atoms"] == 582
    topology = app.PDBFile(str(tmp_path / "villin-topology.pdb")).topology
    last = readDCD(tmp_path / "villin.dcd")[-1]
    ends = summary["energy"]["potentialEnergy"]
    assert ends["last"] == pytest.approx(energyByOpenMM(topology, last, *files), abs=0.2)
    assert ends["lastByOpenMM"] == pytest.approx(ends["last"], rel=1e-5)
    (solvent,) = [force for force in summary["energy"]["forces"] if force["name"] == "CustomGBForce"]
    assert solvent["energy"] < -1000


def test_cutoff(runHere, tmp_path):
    result = runHere(
        *("--forcefield", PROTEIN, "--nonbonded-cutoff", 0.8, "--trials", 400, "--frames", 1, "--seed", 1),
        *("--json", "summary.json"),
    )
    assert "pairs up to 0.8 nm" in result.stdout
    energy = json.loads((tmp_path / "summary.json").read_text())["energy"]
    topology = app.PDBFile(str(tmp_path / "villin-topology.pdb")).topology
    last = readDCD(tmp_path / "villin.dcd")[-1]
    options = {"nonbondedMethod": app.CutoffNonPeriodic, "nonbondedCutoff": 0.8}
    assert energy["potentialEnergy"]["last"] == pytest.approx(
        energyByOpenMM(topology, last, PROTEIN, **options), abs=0.2
    )
    assert energy["nonbondedCutoff"] == 0.8


def test_temperature(runHere, tmp_path):
    """At 10,000 K more is accepted."""
    accepted = []
    for kelvin in (100, 10000):
        name = f"{kelvin}.json"
        options = ("--forcefield", PROTEIN, "--temperature", kelvin, "--trials", 800, "--frames", 1, "--seed", 1)
        runHere(*options, "--overwrite", "--json", name)
        summary = json.loads((tmp_path / name).read_text())
        assert summary["energy"]["temperature"] == kelvin
        accepted.append(sum(move["accepted"] for move in summary["moves"]))
    assert accepted[1] > 1.5 * accepted[0]


def test_addHydrogens(runHere, tmp_path, villin, lines):
    writePDB(tmp_path / "bare.pdb", lines(isHeavy))
    options = ("--add-hydrogens", "--forcefield", PROTEIN, "--trials", 400, "--frames", 2, "--seed", 3)
    result = runHere("bare.pdb", *options, "--json", "summary.json")
    assert result.returncode == 0, result.stderr
    summary = json.loads((tmp_path / "summary.json").read_text())
    heavy = np.array([isHeavy(atom) for atom in villin.topology.atoms()])
    assert summary["addedHydrogens"] == np.count_nonzero(~heavy) and summary["atoms"] == 582
    assert f"582 atoms, {np.count_nonzero(~heavy)} of them added hydrogens" in result.stdout

    pdb = app.PDBFile(str(tmp_path / "bare-topology.pdb"))
    start = pdb.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    frames = readDCD(tmp_path / "bare.dcd")
    assert frames.shape == (3, 582, 3) and frames[0] == pytest.approx(start, abs=1e-4)
    # Villin's own file has hydrogens in the same order, and Modeller puts them near to where they are there.
    places = [(atom.residue.id, atom.element.symbol) for atom in villin.topology.atoms()]
    assert [(atom.residue.id, atom.element.symbol) for atom in pdb.topology.atoms()] == places
    assert start[heavy] == pytest.approx(villin.positions[heavy], abs=1e-4)
    # Hydrogens have the bond lengths of the force field, not Modeller's initial ones.
    lengths = {"C": 0.109, "N": 0.101, "O": 0.096}
    for atom1, atom2 in pdb.topology.bonds():
        parent, child = (atom1, atom2) if isHeavy(atom1) else (atom2, atom1)
        if not isHeavy(child):
            length = np.linalg.norm(start[parent.index] - start[child.index])
            assert length == pytest.approx(lengths.get(parent.element.symbol, 0.134), abs=0.004)
    ends = summary["energy"]["potentialEnergy"]
    assert ends["last"] == pytest.approx(energyByOpenMM(pdb.topology, frames[-1], PROTEIN), abs=0.2)

    random.seed(4)  # Modeller draws random numbers of Python
    again = runHere("bare.pdb", *options, "-o", "again")
    assert again.returncode == 0, again.stderr
    assert np.array_equal(readDCD(tmp_path / "again.dcd"), frames)


def test_hydrogensThatAreThereStay(runHere, tmp_path, villin, lines):
    """Only those of one residue are missing, and the pH says whether a glutamate has one."""
    isLeft = lambda atom: isHeavy(atom) or atom.residue.id != "4"  # noqa: E731
    structure = writePDB(tmp_path / "most.pdb", lines(isLeft, lambda residue: residue.name))
    assert [residue.name for residue in villin.topology.residues() if residue.id == "4"] == ["GLU"]
    counts = []
    for pH in (7, 2):
        options = ("--add-hydrogens", "--ph", pH, "--trials", 10, "--overwrite", "--json", "summary.json")
        result = runHere(structure, *options)
        assert result.returncode == 0, result.stderr
        counts.append(json.loads((tmp_path / "summary.json").read_text())["addedHydrogens"])
    assert counts[0] == 6 and counts[1] > 6
    assert readDCD(tmp_path / "most.dcd").shape[1] == 576 + counts[1]


def test_addHydrogensKeepsNames(runHere, tmp_path, lines):
    """Names of protonation states tell how many hydrogens there are, and stay."""
    rename = lambda residue: "LYN" if residue.id == "7" else residue.name  # noqa: E731
    structure = writePDB(tmp_path / "named.pdb", lines(isHeavy, rename))
    result = runHere(structure, "--add-hydrogens", "--forcefield", PROTEIN, "--trials", 10, "--frames", 1)
    assert result.returncode == 0, result.stderr
    assert "A:LYN 7 LYN" in result.stdout
    text = (tmp_path / "named-topology.pdb").read_text()
    assert " NZ  LYN A   7" in text and text.count("LYN A   7") == 21


def test_leaveOut(runHere, tmp_path, lines):
    ligand = [
        "HETATM  900  S   SO4 B   1      40.000  40.000  40.000  1.00  0.00           S",
        "HETATM  901  O1  SO4 B   1      41.500  40.000  40.000  1.00  0.00           O",
    ]
    structure = writePDB(tmp_path / "bound.pdb", [*lines(lambda atom: True), *ligand])
    options = ("--forcefield", PROTEIN, "--trials", 10, "--frames", 1)
    assertRefused(
        runHere(structure, *options),
        tmp_path,
        ["bound.pdb"],
        f"bound.pdb: --forcefield {PROTEIN}: residues that the force field does not have (1): B:SO4 1: ",
        '--leave-out "resname SO4"',
    )
    result = runHere(structure, *options, "--leave-out", "resname SO4", "--json", "summary.json")
    assert result.returncode == 0, result.stderr
    assert json.loads((tmp_path / "summary.json").read_text())["atoms"] == 582
    assertRefused(
        runHere(structure, "--leave-out", "all", "--overwrite"), tmp_path, filesIn(tmp_path), "no atom remains"
    )
    assertRefused(
        runHere(structure, "--leave-out", "resname XYZ", "--overwrite"), tmp_path, filesIn(tmp_path), "--leave-out"
    )


@pytest.mark.parametrize(
    ("isChosen", "rename", "words"),
    [
        (isHeavy, None, ["residues that lack hydrogens (35): A:LEU 1; ", "and 32 more: --add-hydrogens adds them"]),
        (
            lambda atom: atom.residue.id != "7" or atom.name not in ("NZ", "HZ1", "HZ2", "HZ3"),
            None,
            ["residues that lack heavy atoms (1): A:LYS 7 (NZ): --prepare adds them"],
        ),
        (
            lambda atom: atom.residue.id != "12" and atom.name not in ("OXT", "OC2"),
            None,
            [
                "in the chain, or the atoms of an end (3): A:GLY 11 (at C); A:THR 13 (at N); A:PHE 35 (at C)",
                "--prepare",
            ],
        ),
        (
            lambda atom: True,
            lambda residue: "TPO" if residue.id == "12" else residue.name,
            ["residues that the force field does not have (1): A:TPO 12: ", "--prepare"],
        ),
    ],
)
def test_residuesThatDoNotFit(runHere, tmp_path, lines, isChosen, rename, words):
    chosen = lines(isChosen, *([rename] if rename else []))
    if rename:  # another atom, else the residue fits by its bonds
        chosen = [line.replace("ATOM  ", "HETATM").replace(" HA  TPO", " F1  TPO") for line in chosen]
        chosen = [line[:76] + " F" if " F1  TPO" in line else line for line in chosen]
    structure = writePDB(tmp_path / "unfit.pdb", chosen)
    result = runHere(structure, "--forcefield", PROTEIN)
    assertRefused(result, tmp_path, ["unfit.pdb"], "unfit.pdb: --forcefield", *words)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--temperature", "300"], "--temperature needs --forcefield"),
        (["--nonbonded-cutoff", "1"], "--nonbonded-cutoff needs --forcefield"),
        (["--trials-per-outer-test", "7"], "--trials-per-outer-test needs --forcefield"),
        (["--ph", "7"], "--ph needs --add-hydrogens"),
        (["--forcefield"], "--forcefield: expected at least one argument"),
        (["--forcefield", "amber41.xml"], '--forcefield amber41.xml: Could not locate file "amber41.xml"'),
        (["--forcefield", PROTEIN, "--temperature", "-1"], "-1 is not in the range"),
        (["--forcefield", PROTEIN, "--temperature", "nan"], "nan is not in the range"),
        (["--forcefield", PROTEIN, "--temperature", "warm"], "'warm' is not a number"),
        (["--forcefield", PROTEIN, "--nonbonded-cutoff", "0"], "0 is not in the range"),
        (["--forcefield", PROTEIN, "--add-hydrogens", "--ph", "15"], "15 is not in the range 0 to 14"),
        (["--forcefield", PROTEIN, "structure.pdb"], "structure.pdb: is not an XML file; name the structure before"),
        (["--forcefield", "broken.xml"], "--forcefield broken.xml: "),
        (["--forcefield", PROTEIN, "steric.xml"], "adds its own StericExclusionForce"),
        (["--forcefield", "implicit/gbn2.xml"], "--forcefield implicit/gbn2.xml: "),
        (["--forcefield", "tip3p.xml"], "residues that the force field does not have (35): LEU 1; "),
    ],
)
def test_badArguments(runHere, tmp_path, arguments, words):
    writePDB(tmp_path / "structure.pdb", GLYCINES)
    (tmp_path / "broken.xml").write_text("<ForceField><Residues>")
    (tmp_path / "steric.xml").write_text("<ForceField><StericExclusionForce/></ForceField>")
    assertRefused(runHere(*arguments), tmp_path, ["broken.xml", "steric.xml", "structure.pdb"], words)


def test_nothingIsOverwritten(runHere, tmp_path):
    (tmp_path / "villin-topology.pdb").write_text("mine")
    result = runHere("--forcefield", PROTEIN, "--trials", 10)
    assertRefused(result, tmp_path, ["villin-topology.pdb"], "villin-topology.pdb: exists; --overwrite replaces it")
    assert (tmp_path / "villin-topology.pdb").read_text() == "mine"


def test_fixedAtomsStay(runHere, tmp_path):
    options = ("--forcefield", PROTEIN, "--trials", 800, "--frames", 2, "--seed", 1, "--json", "summary.json")
    result = runHere(*options, "--fix", "resSeq 20 to 30", "--move", "resSeq 1 to 10")
    assert result.returncode == 0, result.stderr
    frames = readDCD(tmp_path / "villin.dcd")
    hasMoved = np.abs(frames[-1] - frames[0]).max(axis=1) > 0
    atoms = list(app.PDBFile(str(tmp_path / "villin-topology.pdb")).topology.atoms())
    assert not any(moved and 20 <= int(atom.residue.id) <= 30 for atom, moved in zip(atoms, hasMoved, strict=True))
    assert hasMoved.any()
    ends = json.loads((tmp_path / "summary.json").read_text())["energy"]["potentialEnergy"]
    assert ends["lastByOpenMM"] == pytest.approx(ends["last"], rel=1e-6, abs=5e-3)


def test_aWrongEnergyWouldBeSeen(runHere, monkeypatch):
    """Were the energy that is held wrong, the comparison with OpenMM would say so."""
    honest = segment._Replica._energy
    monkeypatch.setattr(segment._Replica, "_energy", lambda replica: honest(replica) + 7)
    result = runHere("--forcefield", PROTEIN, "--trials", 10)
    assert "OpenMM's Reference platform differs there by 7" in result.stdout


def test_outerTests(runHere, tmp_path):
    """A force with a table, which OpenMM evaluates, is evaluated once in 20 trials; undone trials are not counted."""
    (tmp_path / "pull.xml").write_text(
        "<ForceField><Script>\n"
        "import openmm\n"
        "force = openmm.CustomCentroidBondForce(2, '100*same(distance(g1,g2))')\n"
        "force.addTabulatedFunction('same', openmm.Continuous1DFunction([0, 30], 0, 30))\n"
        "ends = [0], [sys.getNumParticles() - 1]\n"
        "force.addBond([force.addGroup(end) for end in ends], [])\n"
        "sys.addForce(force)\n"
        "</Script></ForceField>"
    )
    result = runHere(
        *("--forcefield", PROTEIN, "pull.xml", "--trials-per-outer-test", 20, "--trials", 2000, "--frames", 2),
        *("--seed", 1, "--json", "summary.json"),
    )
    assert result.returncode == 0, result.stderr
    summary = json.loads((tmp_path / "summary.json").read_text())
    outer = summary["energy"]["outerTests"]
    assertTrialsAddUp(summary, result.stdout)
    assert 100 <= outer["attempted"] <= 101 and 0 < outer["accepted"] < outer["attempted"]
    assert outer["standardDeviation"] > 0
    attempted = sum(move["attempted"] for move in summary["moves"])
    assert summary["trials"] == 2000 == attempted + outer["trialsTakenBack"] > attempted
    (pull,) = [force for force in summary["energy"]["forces"] if force["name"] == "CustomCentroidBondForce"]
    assert pull["kind"] == "foreign" and pull["energy"] > 0
    ends = summary["energy"]["potentialEnergy"]
    assert ends["lastByOpenMM"] == pytest.approx(ends["last"], rel=1e-6, abs=5e-3)
    assert f"{outer['accepted']} of {outer['attempted']} kept their trials" in result.stdout


def test_bondsOfMetalsAreIgnored(runHere, tmp_path, lines):
    """A metal is an ion to the force field, and moves with what it is bound to all the same."""
    (zinc,) = [line for line in lines(lambda atom: True) if line[12:16] == " OD1" and line[22:26] == "   3"]
    x = float(zinc[30:38]) + 2.1
    zinc = f"HETATM  900 ZN    ZN B   1    {x:8.3f}{zinc[38:54]}  1.00  0.00          ZN"
    structure = writePDB(tmp_path / "zinc.pdb", [*lines(lambda atom: True), zinc])
    options = ("--trials", 10, "--frames", 1, "--json", "summary.json")
    result = runHere(structure, "--forcefield", PROTEIN, "amber14/tip3p.xml", *options)
    assert result.returncode == 0, result.stderr
    assert "note: bonds of metals that the force field does not have (" in result.stdout
    assert json.loads((tmp_path / "summary.json").read_text())["atoms"] == 583


def test_fewTrialsAndManyFrames(tmp_path):
    """A step has at least 400 trials, but never more than lie between two frames."""
    options = ("sample", "--forcefield", PROTEIN, "--seed", 1, "--trials", 1000, "--json", "summary.json")
    for frames in (3, 10):
        result = commands.run(*options, "--frames", frames, "--overwrite", folder=tmp_path)
        assert result.returncode == 0, result.stderr
        summary = json.loads((tmp_path / "summary.json").read_text())
        assert summary["trials"] == 1000 and len(summary["energy"]["potentialEnergies"]) == frames + 1
