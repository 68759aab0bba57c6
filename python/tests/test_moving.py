"""What moves in openmm-chaintree sample and what stays, chosen and said."""

import json
from itertools import count

import numpy as np
import pytest
from commands import assertRefused
from openmm import app, unit
from openmmchaintree.command.plan import Choice, Plan
from openmmchaintree.command.reports.planreport import describePlan
from openmmchaintree.structures.structure import Structure
from scenes import GLYCINES, readDCD, realStructurePath, writePDB

LEFT_OUT = (
    "torsions left out, between two fixed parts, where only side chains turn, unless loops are closed (--close loops)"
)


@pytest.fixture
def sample(runCommandHere, tmp_path):
    """A function that samples; it returns the summary, the frames and the atoms."""
    names = map("run{}".format, count())

    def run(*arguments):
        name = next(names)
        options = ("--trials", 1000, "--frames", 2, "--seed", 1, "-o", name, "--json", f"{name}.json")
        result = runCommandHere("sample", *arguments, *options)
        assert result.returncode == 0, result.stderr
        summary = json.loads((tmp_path / f"{name}.json").read_text())
        assert result.stdout.splitlines()[: len(summary["plan"])] == summary["plan"]
        frames = readDCD(tmp_path / f"{name}.dcd")
        return summary, frames, list(app.PDBFile(str(tmp_path / f"{name}-topology.pdb")).topology.atoms())

    return run


def shifted(lines, chain, distance, firstSerial):
    """The lines of another chain, distance (Å) along z."""
    return [
        f"{line[:6]}{serial:5d}{line[11:21]}{chain}{line[22:46]}{float(line[46:54]) + distance:8.3f}{line[54:]}"
        for serial, line in enumerate(lines, start=firstSerial)
    ]


@pytest.fixture
def twoChains(tmp_path):
    """Two chains of two glycines, and a carbon monoxide."""
    ligand = [
        "HETATM   21  C1  LIG L   1       0.000   9.000   0.000  1.00  0.00           C",
        "HETATM   22  O1  LIG L   1       1.200   9.000   0.000  1.00  0.00           O",
    ]
    return writePDB(
        tmp_path / "two.pdb", [*GLYCINES, "TER", *shifted(GLYCINES, "B", 20, 10), "TER", *ligand, "CONECT   21   22"]
    )


def hasMoved(frames, atoms, start):
    return np.abs(frames - start[None])[:, atoms].max() > 1e-4


def startOf(path):
    return np.array(app.PDBFile(str(path)).getPositions(asNumpy=True)._value)


def test_wholeMoleculesStay(sample, twoChains):
    summary, frames, atoms = sample(twoChains)
    assert summary["plan"] == [
        "moves: chain A (6 of 8 atoms), chain B (6 of 8 atoms) by 4 torsions (2 phi, 2 psi)",
        "stays: LIG (2 atoms): no torsion; 4 atoms that hold what moves",
        "held: chain A at A:GLY 1 (2 atoms), chain B at B:GLY 1 (2 atoms); no molecule moves as a whole "
        "(--rigid-bodies)",
    ]
    assert not any("rigid" in move["name"] for move in summary["moves"])
    start = startOf(twoChains)
    assert not hasMoved(frames, [0, 1, 8, 9, 16, 17], start)
    assert hasMoved(frames, [7], start) and hasMoved(frames, [15], start)


def test_wholeMoleculesMoveOnRequest(sample, twoChains):
    summary, frames, _ = sample(twoChains, "--rigid-bodies")
    assert summary["plan"][0].endswith("; as a whole chain A, chain B, LIG (2 atoms)")
    assert summary["plan"][1:] == ["stays: nothing", "held: nothing"]
    assert summary["fixedAtoms"] == 0
    (rigid,) = [move for move in summary["moves"] if "rigid" in move["name"]]
    assert rigid["accepted"] > 0
    start = startOf(twoChains)
    assert all(hasMoved(frames, [atom], start) for atom in (0, 8, 16))


def test_chosenMoleculesMoveAsAWhole(sample, twoChains):
    summary, frames, _ = sample(twoChains, "--rigid-bodies", "--move", "resname LIG")
    assert summary["plan"] == [
        "moves: as a whole LIG (2 atoms)",
        "stays: chain A (8 atoms), chain B (8 atoms): not in --move",
        "held: nothing",
    ]
    assert summary["torsions"] == {} and summary["fixedAtoms"] == 16
    start = startOf(twoChains)
    assert hasMoved(frames, [16, 17], start) and not hasMoved(frames, list(range(16)), start)


def test_move(sample, twoChains):
    summary, frames, _ = sample(twoChains, "--move", "segname B")
    assert summary["plan"][0] == "moves: chain B (6 of 8 atoms) by 2 torsions (1 phi, 1 psi)"
    assert summary["plan"][1].startswith("stays: chain A (8 atoms): not in --move; LIG (2 atoms): no torsion; ")
    start = startOf(twoChains)
    assert not hasMoved(frames, list(range(8)), start) and hasMoved(frames, [15], start)


def test_fix(sample, twoChains):
    """The last oxygen of chain A holds it: its beginning moves."""
    summary, frames, _ = sample(twoChains, "--fix", "segname B or (segname A and resSeq 2 and name O)")
    assert "chain B (8 atoms): --fix" in summary["plan"][1]
    assert "chain A at A:GLY 2 (" in summary["plan"][2] and ", --fix)" in summary["plan"][2]
    start = startOf(twoChains)
    assert not hasMoved(frames, [7, *range(8, 18)], start) and hasMoved(frames, [0], start)


def test_fixedPartDoesNotMoveAsAWhole(sample, twoChains):
    summary, frames, _ = sample(twoChains, "--fix", "segname A and name CA", "--rigid-bodies")
    assert "as a whole chain B, LIG (2 atoms)" in summary["plan"][0]
    assert not hasMoved(frames, [1, 5], startOf(twoChains))
    (note,) = summary["notes"]
    assert note["kind"] == LEFT_OUT
    assert len(note["items"]) == 2


def test_torsionsOfChoice(sample):
    summary, *_ = sample("--torsions", "psi,chi1,omega,rotor")
    assert set(summary["torsions"]) == {"psi", "chi1", "omega", "rotor"}
    names = {move["name"].split(" ")[0] for move in summary["moves"]}
    assert names == {"φ/ψ", "ω", "χ", "rotor"}
    assert all(move["accepted"] > 0 for move in summary["moves"])


def test_tailMovesAndTheRestStays(sample, villin):
    """The largest part that does not turn stays, here what follows; nothing before it is named."""
    summary, frames, atoms = sample("--move", "resid 0 to 4")
    outside = [atom.index for atom in atoms if atom.residue.index > 4]
    assert np.abs(frames[-1] - villin.positions)[outside].max() < 1e-6
    assert np.abs(frames[-1] - villin.positions)[0].max() > 0.1
    assert summary["fixedAtoms"] > len(outside)


def test_loopBetweenFixedEnds(sample, villin):
    summary, frames, atoms = sample("--move", "resid 10 to 14", "--fix", "not resid 10 to 14")
    assert set(summary["torsions"]) <= {"chi1", "chi2", "chi3", "chi4"}
    moved = {atoms[i].residue.index for i in np.flatnonzero(np.abs(frames[-1] - villin.positions).max(axis=1) > 1e-4)}
    assert moved and moved <= set(range(10, 15))
    kinds = [note["kind"] for note in summary["notes"]]
    assert any(kind == LEFT_OUT for kind in kinds)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--move", "resname XYZ"], ["--move: 'resname XYZ' selects no atom"]),
        (["--fix", "resname XYZ"], ["--fix: 'resname XYZ' selects no atom"]),
        (["--move", "chain A"], ["--move: 'chain A' is not in MDTraj's selection language"]),
        (["--fix", "("], ["--fix: '(' is not in MDTraj's selection language"]),
        (["--move", "name O"], ["--move 'name O': none of these atoms has a torsion"]),
        (
            ["--fix", "name CA"],
            ["--fix 'name CA' leaves nothing that moves", "torsions left out, between two fixed parts"],
        ),
        (["--fix", "all", "--rigid-bodies"], ["--fix 'all' leaves nothing that moves"]),
        (["--torsions", "phi,tau"], ["--torsions", "'tau' is not one of phi, psi"]),
        (["--torsions", "alpha"], ["there is no torsion of a protein or nucleic acid (alpha)"]),
    ],
)
def test_badChoice(runCommandHere, tmp_path, arguments, words):
    path = writePDB(tmp_path / "glycines.pdb", GLYCINES)
    assertRefused(runCommandHere("sample", path, *arguments), tmp_path, ["glycines.pdb"], *words)


def gapped():
    """Two fragments of a chain, with residues between them missing."""
    return [*GLYCINES, *[f"{line[:22]}{int(line[22:26]) + 7:4d}{line[26:]}" for line in shifted(GLYCINES, "A", 20, 10)]]


def test_fragmentsAtAGapStay(sample, tmp_path):
    path = writePDB(tmp_path / "gap.pdb", gapped())
    start = startOf(path)
    for arguments in ([], ["--rigid-bodies", "--torsions", "phi,psi"]):
        summary, frames, _ = sample(path, *arguments)
        assert (
            "held: A:GLY 1 – A:GLY 2 at A:GLY 1 (2 atoms), A:GLY 8 – A:GLY 9 at A:GLY 8 (2 atoms)"
            in (summary["plan"][2])
        )
        assert not hasMoved(frames, [0, 8], start) and hasMoved(frames, [7], start) and hasMoved(frames, [15], start)
    assert summary["plan"][2].endswith("; fragments next to a gap do not move as a whole unless --move names them")
    summary, frames, _ = sample(path, "--rigid-bodies", "--move", "resSeq 8 to 9")
    assert not hasMoved(frames, [0, 7], start) and hasMoved(frames, [8], start)


def cystines():
    """Two glycines with sulfurs on their Cα, named as cysteines: a disulfide between residues, in a ring."""
    lines = [line.replace("GLY", "CYS") for line in GLYCINES]
    sulfurs = [
        "ATOM      9  SG  CYS A   1       1.800  -0.900   1.500  1.00  0.00           S",
        "ATOM     10  SG  CYS A   2       3.500   0.000   1.800  1.00  0.00           S",
    ]
    bonds = ["CONECT    2    9", "CONECT    6   10", "CONECT    9   10"]
    return [*lines[:4], sulfurs[0], *lines[4:], sulfurs[1], *bonds]


def test_cutsAreReported(sample, tmp_path):
    path = writePDB(tmp_path / "cystines.pdb", cystines())
    summary, *_ = sample(path, "--cut-disulfides")
    assert summary["cutDisulfides"] == [["A:CYS 1", "A:CYS 2"]]
    assert summary["plan"][3] == "cut disulfides: A:CYS 1 – A:CYS 2"
    assert sum(summary["torsions"].values()) > 0


def test_nothingToCutIsSaid(sample):
    summary, *_ = sample("--cut-disulfides")
    assert {"kind": "there is no disulfide to cut", "items": []} in summary["notes"] and summary["cutDisulfides"] == []


def test_loopIsSampledClosed(sample):
    # Closed moves turn the loop and single turns its side chains; nothing else moves, and no bond changes.
    summary, frames, atoms = sample("--fix", "not resid 9 to 15", "--close", "loops")
    inLoop = np.array([9 <= atom.residue.index <= 15 for atom in atoms])
    moved = np.abs(frames[-1] - frames[0]).max(axis=1)
    assert not moved[~inLoop].any() and (moved[inLoop] > 1e-3).mean() > 0.5
    assert (
        len(summary["closed"]) == 1
        and f"bonds that closed moves keep: {' – '.join(summary['closed'][0])}" in (summary["plan"])
    )
    assert summary["moves"][0]["name"] == "closed 12°" and summary["moves"][0]["accepted"] > 0
    assert summary["changedBonds"] == [] and summary["torsions"]["phi"] >= 6


def test_disulfidesAreSampledClosed(sample):
    summary, frames, _ = sample(realStructurePath("bpti_h.pdb"), "--close", "disulfides")
    assert len(summary["closed"]) == 3 and summary["changedBonds"] == []
    assert summary["moves"][0]["name"] == "closed 12°" and summary["moves"][0]["accepted"] > 0
    assert not any("disulfide" in note["kind"] for note in summary["notes"])


def test_nothingToCloseIsSaid(sample):
    summary, *_ = sample("--close", "disulfides,loops")
    assert {"kind": "there is no bond to close (disulfides, loops)", "items": []} in summary["notes"]
    assert summary["closed"] == []


def test_disulfideCoreHolds(realStructure):
    plan = Plan(realStructure("bpti_h.pdb"), Choice())
    assert "held: chain A at A:CYS 5 – A:CYS 55 (374 atoms)" in describePlan(plan)[2]


def test_disulfidesAreClosedWhereEnergiesAreSampled(realStructure):
    structure = realStructure("bpti_h.pdb")
    lines = describePlan(Plan(structure, Choice(hasEnergies=True)))
    assert "held: chain A at A:ARG 1 (" in lines[2]
    assert lines[3].startswith(
        "rigid: bond lengths and angles; rings (PHE, PRO, TYR); turns about bonds that closed moves"
    )
    closed = "A:CYS 5 – A:CYS 55, A:CYS 14 – A:CYS 38, A:CYS 30 – A:CYS 51"
    assert lines[4] == f"bonds that closed moves keep: {closed}"
    for choice in (Choice(hasEnergies=True, close=()), Choice(hasEnergies=True, cutDisulfides=True)):
        assert Plan(structure, choice).closed == []
    kinds = Choice(kinds=("phi", "psi", "chi"), close=(), hasEnergies=True)
    lines = describePlan(Plan(structure, kinds))
    assert (
        "held: chain A at A:CYS 5 – A:CYS 55 (374 atoms)" in lines[2]
        and "bonds in rings of several residues" in lines[3]
    )


def test_closingNothingIsAChoice(sample):
    summary, *_ = sample("--close", "none")
    assert summary["closed"] == [] and not any("close" in note["kind"] for note in summary["notes"])


def test_oneChainOfFour(sample):
    summary, frames, atoms = sample(realStructurePath("4hhb.pdb"), "--move", "segname B and protein")
    assert summary["plan"][0].startswith("moves: chain B (1,164 of 1,166 atoms) by ")
    assert "chain A (1,112 atoms), chain C (1,112 atoms), chain D (1,166 atoms): not in --move" in summary["plan"][1]
    others = [atom.index for atom in atoms if atom.residue.chain.id != "B"]
    assert np.array_equal(frames[0][others], frames[-1][others])


def test_planOfManyParts(villin):
    """A line names the first parts and counts the others."""
    positions = [villin.positions + [0, 0, 10 * i] for i in range(9)]
    modeller = app.Modeller(villin.topology, positions[0] * unit.nanometer)
    for copy in positions[1:]:
        modeller.add(villin.topology, copy * unit.nanometer)
    lines = describePlan(Plan(Structure("many", modeller.topology, np.vstack(positions)), Choice()))
    assert len(lines) == 3
    assert ", 4 more by 1,242 torsions (" in lines[0] and ", 4 more; no molecule moves" in lines[2]
