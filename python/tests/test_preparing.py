"""--prepare and --minimize: a structure as a file has it becomes one that a force field has, and the notes say how."""

import gemmi
import numpy as np
import pytest
from commands import assertRefused, filesIn
from openmm import app
from openmmchaintree.command.energymodel import EnergyModel
from openmmchaintree.command.preparing import segments
from openmmchaintree.command.preparing.minimizing import minimizeStructure
from openmmchaintree.command.preparing.preparation import prepareStructure
from openmmchaintree.errors import InputError
from openmmchaintree.selection import selectAtoms
from openmmchaintree.structures.sequencegaps import findSequenceGaps
from openmmchaintree.structures.structure import readStructure
from peptides import linesOf, makePeptides
from scenes import pdbLine, realStructurePath, writePDB

PROTEIN = "amber14/protein.ff14SB.xml"
_SHARES = (("A", "0.30"), ("B", "0.70"))
_BACKBONE = ("N", "CA", "C", "O", "CB")


@pytest.fixture(scope="module")
def model():
    return EnergyModel([PROTEIN], 300, isPrepared=True)


def heavyLines(structure, isChosen=lambda atom: True, rename=lambda atom: (atom.name, atom.residue.name)):
    """Return lines of a PDB file of the heavy atoms of a Structure that a function chooses, in chain A."""
    chosen = [
        atom for atom in structure.topology.atoms() if atom.element is not app.element.hydrogen and isChosen(atom)
    ]
    lines = []
    for serial, atom in enumerate(chosen, start=1):
        name, residue = rename(atom)
        place = 10 * structure.positions[atom.index]
        element = "Se" if residue == "MSE" and name == "SE" else None
        lines.append(pdbLine(serial, name, residue, "A", atom.residue.id, *place, element=element))
    return lines


def sequenceLines(structure, before=(), after=()):
    """Return SEQRES of a Structure, with more residues at its ends."""
    names = [*before, *(residue.name for residue in structure.topology.residues()), *after]
    rows = [names[start : start + 13] for start in range(0, len(names), 13)]
    return [f"SEQRES {n:>3} A {len(names):>4}  {' '.join(row)}" for n, row in enumerate(rows, start=1)]


def asFromTheBank(structure):
    """Villin as the Protein Data Bank might have it: gap, side chain cut, MSE, alternates, water, ion, glycerol."""

    def isThere(atom):
        number = int(atom.residue.id)
        return number not in (21, 22, 23) and (number != 7 or atom.name in _BACKBONE) and atom.name != "OXT"

    def rename(atom):
        isMethionine = atom.residue.name == "MET"
        return (
            "SE" if isMethionine and atom.name == "SD" else atom.name,
            "MSE" if isMethionine else atom.residue.name,
        )

    lines = []
    for line in heavyLines(structure, isThere, rename):
        isTwice = line[12:26].split() == ["OG", "SER", "A", "2"]
        lines += (
            [f"{line[:16]}{label}{line[17:54]}  {share}{line[60:]}" for label, share in _SHARES] if isTwice else [line]
        )
    return lines


@pytest.fixture(scope="module")
def bankLines(villin):
    lines = asFromTheBank(villin)
    low = villin.positions.min(axis=0) * 10 - 8
    others = [
        pdbLine(901, "O", "HOH", "A", 901, *low, record="HETATM"),
        pdbLine(902, "CL", "CL", "A", 902, *(low - 5), record="HETATM", element="Cl"),
    ]
    glycerol = [("C1", 0, 0), ("O1", 1.4, 0), ("C2", -0.7, 1.3), ("O2", -2.1, 1.3), ("C3", 0, 2.6), ("O3", 1.4, 2.6)]
    others += [
        pdbLine(910 + number, name, "GOL", "A", 903, *(low - [10 - x, 10 - y, 10]), record="HETATM")
        for number, (name, x, y) in enumerate(glycerol)
    ]
    return [*sequenceLines(villin, ["GLY", "SER"], ["GLY"]), *lines, "TER", *others]


@pytest.fixture(scope="module")
def bankFile(bankLines, tmp_path_factory):
    return writePDB(tmp_path_factory.mktemp("bank") / "bank.pdb", bankLines)


@pytest.fixture(scope="module")
def prepared(bankFile, model):
    return prepareStructure(readStructure(bankFile), model, 7, 1)[0]


def itemsOf(structure, words):
    """Return the items of the only Note of a Structure whose kind has these words."""
    (note,) = [note for note in structure.notes if words in note.kind]
    return note.items


def byName(structure):
    atoms = structure.topology.atoms()
    return {(atom.residue.id, atom.name): tuple(structure.positions[atom.index].tolist()) for atom in atoms}


def test_prepareSaysWhatItDoes(prepared):
    (gap,) = itemsOf(prepared, "built from the sequence")
    assert gap.count(" – ") == 1 and len(gap.split(": ")[1].split()) == 3
    assert itemsOf(prepared, "conformer of highest occupancy") == ["A:SER 2 conformer B"]
    assert any(item.startswith("A:LYS 7 (") for item in itemsOf(prepared, "residues completed"))
    assert [item for item in itemsOf(prepared, "replaced") if "MSE" in item and item.endswith("by MET")]
    assert itemsOf(prepared, "additives") == ["A:GOL 903"]
    assert itemsOf(prepared, "ions left out, since nothing") == ["A:CL 902"]
    assert not [note for note in prepared.notes if "gaps in the chain" == note.kind]
    assert not [note for note in prepared.notes if "chirality" in note.kind or "too long" in note.kind]


def test_prepareCompletesWithoutMovingWhatIsThere(prepared, villin, bankFile, model):
    assert [residue.name for residue in prepared.topology.residues()] == [
        residue.name for residue in villin.topology.residues()
    ]
    assert [residue.id for residue in prepared.topology.residues()] == [
        residue.id for residue in villin.topology.residues()
    ]
    assert prepared.topology.getNumChains() == 1
    places = byName(prepared)
    given = byName(readStructure(bankFile))
    removed = {
        ("12", "SE"),
        ("12", "CE"),
        *((number, name) for number, name in given if number in ("901", "902", "903")),
    }
    stayed = given.keys() - removed
    assert stayed <= places.keys() and all(places[key] == given[key] for key in stayed)
    system, _ = model.makeSystem(prepared)
    assert system.getNumParticles() == villin.topology.getNumAtoms()


def test_prepareIsReproducible(prepared, bankFile, model):
    again = prepareStructure(readStructure(bankFile), model, 7, 1)[0]
    assert again.positions.tobytes() == prepared.positions.tobytes()


def test_minimizeLowersTheEnergyAndLeavesFixedAtoms(prepared, model):
    lower = minimizeStructure(prepared, model, "resSeq 1 to 10")
    fixed = [atom.index for atom in prepared.topology.atoms() if int(atom.residue.id) <= 10]
    assert np.array_equal(lower.positions[fixed], prepared.positions[fixed])
    moved = np.linalg.norm(lower.positions - prepared.positions, axis=1).max()
    assert f"moved by at most {moved:.3f} nm" in lower.notes[-1].kind and moved > 0
    before, after = (float(part.replace(",", "")) for part in _energies(lower.notes[-1].kind))
    assert after < before


def _energies(text):
    return text.split("energy ")[1].split(" kJ/mol")[0].split(" to ")


def test_longGapsStayOpenAndGetEnds(prepared, bankFile, model, monkeypatch):
    monkeypatch.setattr(segments, "LONGEST_GAP", 2)
    opened = prepareStructure(readStructure(bankFile), model, 7, 1)[0]
    (item,) = itemsOf(opened, "stay open")
    assert item.endswith("3 residues, and at most 2 are built")
    assert opened.topology.getNumChains() == 2
    assert len([atom for atom in opened.topology.atoms() if atom.name in ("OXT", "OC2")]) == 2
    model.makeSystem(opened)


def test_gapsAreThoseOfMmCIF(bankFile, tmp_path):
    file = gemmi.read_structure(str(bankFile))
    expected, _ = findSequenceGaps(file, 0)
    assert [len(gap.names) for gap in expected] == [3]
    file.setup_entities()
    file.make_mmcif_document().write_file(str(tmp_path / "bank.cif"))
    again = readStructure(tmp_path / "bank.cif")
    assert findSequenceGaps(again.file, again.model)[0] == expected


def test_aSingleAminoAcidBetweenGapsIsLeftOut(villin, tmp_path, model):
    lines = heavyLines(villin, lambda atom: int(atom.residue.id) not in (20, 22))
    whole, _ = prepareStructure(readStructure(writePDB(tmp_path / "single.pdb", lines)), model, 7, 1)
    (single,) = itemsOf(whole, "single amino acids")
    assert single.endswith(" 21") and "21" not in [residue.id for residue in whole.topology.residues()]
    model.makeSystem(whole)


def test_withoutAForceFieldNothingIsLeftOut(bankFile):
    whole, added = prepareStructure(readStructure(bankFile), None, 7, 1)
    names = [residue.name for residue in whole.topology.residues()]
    assert "MSE" in names and "GOL" in names and added > 200
    assert whole.topology.getNumAtoms() > 500


def test_aResidueWithoutItsBackboneIsBuiltAgain(villin, tmp_path, model):
    """Also next to a gap, with which it is built; at an end it is left out."""

    def isThere(atom):
        number = int(atom.residue.id)
        return number != 22 and (number not in (21, 35) or atom.name == "N")

    lines = [*sequenceLines(villin), *heavyLines(villin, isThere)]
    whole, _ = prepareStructure(readStructure(writePDB(tmp_path / "stub.pdb", lines)), model, 7, 1)
    names = [residue.name for residue in villin.topology.residues()]
    assert [residue.name for residue in whole.topology.residues()] == names[:34]
    assert itemsOf(whole, "built from the sequence")[0].endswith(f": {names[20]} {names[21]}")
    model.makeSystem(whole)


def test_aSequenceThatDiffersIsNotUsed(bankLines, tmp_path, model):
    lines = [line[:19] + "GLY " * 13 if line.startswith("SEQRES") else line for line in bankLines]
    structure = readStructure(writePDB(tmp_path / "other.pdb", lines))
    gaps, notes = findSequenceGaps(structure.file, 0)
    assert gaps == [] and "differ from the sequence" in notes[0].kind


def test_anAlphaCarbonModelIsRefused(villin, tmp_path, model):
    lines = heavyLines(villin, lambda atom: atom.name == "CA")
    with pytest.raises(InputError, match="lack N, CA or C"):
        prepareStructure(readStructure(writePDB(tmp_path / "ca.pdb", lines)), model, 7, 1)


def test_builtResiduesGetFreeNumbers(villin, tmp_path, model):
    """The residues behind the gap are numbered as if nothing were missing."""
    lines = [*sequenceLines(villin), *heavyLines(villin, lambda atom: int(atom.residue.id) not in (21, 22))]
    lines = [
        line[:22] + f"{int(line[22:26]) - 2:>4}" + line[26:] if line[:4] == "ATOM" and int(line[22:26]) > 22 else line
        for line in lines
    ]
    whole, _ = prepareStructure(readStructure(writePDB(tmp_path / "n.pdb", lines)), model, 7, 1)
    labels = [residue.id + residue.insertionCode for residue in whole.topology.residues()]
    assert labels[19:24] == ["20", "20A", "20B", "21", "22"] and len(set(labels)) == len(labels)


def test_minimizeNeedsAForceField(runCommandHere, tmp_path):
    assertRefused(runCommandHere("sample", "--minimize"), tmp_path, [], "--minimize", "--forcefield")


@pytest.mark.parametrize(("name", "selection"), [("LIG", "resname LIG"), ("2PN", "resname '2PN'")])
def test_aLigandIsNamedWithTheOptionThatLeavesItOut(runCommandHere, tmp_path, villin, name, selection):
    lines = heavyLines(villin)
    ligand = [pdbLine(900 + n, f"C{n}", name, "B", 1, -20 + 1.5 * n, -20, -20, record="HETATM") for n in range(3)]
    structure = writePDB(tmp_path / "ligand.pdb", [*lines, "TER", *ligand])
    result = runCommandHere("sample", structure, "--prepare", "--forcefield", PROTEIN)
    assertRefused(result, tmp_path, filesIn(tmp_path), f"B:{name} 1", f'--leave-out "{selection}"')
    assert len(selectAtoms(readStructure(structure).topology, selection)) == 3


def test_atomsAtMetalsGetNoHydrogen(tmp_path):
    topology, positions = makePeptides(("ACE", "CYS", "NME"), ("ACE", "HIS", "NME"))
    places = {(atom.residue.name, atom.name): 10 * positions[atom.index] for atom in topology.atoms()}
    shift = places["CYS", "SG"] + [2.3, 0, 0] - (places["HIS", "NE2"] - [2.1, 0, 0])
    first = sum(1 for atom in topology.atoms() if atom.residue.chain.index == 0)
    moved = np.where(np.arange(len(positions))[:, None] < first, positions, positions + shift / 10)
    zinc = pdbLine(999, "ZN", "ZN", "C", 1, *(places["CYS", "SG"] + [2.3, 0, 0]), record="HETATM", element="Zn")
    structure = readStructure(writePDB(tmp_path / "zinc.pdb", [*linesOf(topology, moved), zinc]))
    model = EnergyModel([PROTEIN, "amber14/tip3p.xml"], 300, isPrepared=True)
    whole, _ = prepareStructure(structure, model, 7, 1)
    names = {(atom.residue.name, atom.name) for atom in whole.topology.atoms()}
    assert ("CYS", "HG") not in names and ("HIS", "HE2") not in names and ("HIS", "HD1") in names
    model.makeSystem(whole)
    bare = EnergyModel([PROTEIN], 300, isPrepared=True)  # zinc is no ion of a buffer
    with pytest.raises(InputError, match="C:ZN 1"):
        bare.makeSystem(whole)


def strandLines(first, last):
    """Return the lines of some nucleotides of a real strand of DNA."""
    lines = realStructurePath("1bna.pdb").read_text().splitlines()
    return [line for line in lines if line.startswith("ATOM") and line[21] == "A" and first <= int(line[22:26]) <= last]


@pytest.mark.parametrize("names", [("P", "OP1", "OP2"), ("P",), ("O5'",), ("P", "OP1", "OP2", "O5'")])
def test_phosphatesWithinAStrandAreBuiltWhereTheyWere(names, tmp_path):
    """In one nucleotide, and in all; the 5' end stays as it is."""
    whole = readStructure(writePDB(tmp_path / "whole.pdb", strandLines(1, 5)))
    model = EnergyModel(["amber14/DNA.OL15.xml"], 300, isPrepared=True)
    places = byName(whole)
    for numbers in (["4"], ["2", "3", "4", "5"]):
        kept = [
            line for line in strandLines(1, 5) if line[12:16].strip() not in names or line[22:26].strip() not in numbers
        ]
        structure = readStructure(writePDB(tmp_path / "strand.pdb", kept))
        completed, _ = prepareStructure(structure, model, 7, 1)
        found = byName(completed)
        assert [(number, name) for number, name in found if name == "P"] == [(n, "P") for n in ("2", "3", "4", "5")]
        assert len(itemsOf(completed, "residues completed")) == len(numbers)
        assert not [note for note in completed.notes if "gaps" in note.kind or "phosphates" in note.kind]
        away = [np.linalg.norm(np.subtract(found[key], places[key])) for key in places]
        assert max(away) < 0.06
        model.makeSystem(completed)


def test_nucleosidesWithHydroxylsOrFarApartStayApart(tmp_path):
    kept = [line for line in strandLines(1, 3) if line[12:16].strip() not in ("P", "OP1", "OP2")]
    shifted = [line[:30] + f"{float(line[30:38]) + 4 * int(line[25]):8.3f}" + line[38:] for line in kept]
    model = EnergyModel(["amber14/DNA.OL15.xml"], 300, isPrepared=True)
    apart, _ = prepareStructure(readStructure(writePDB(tmp_path / "far.pdb", shifted)), model, 7, 1)
    assert len(itemsOf(apart, "stay open")) == 2
    topology, positions = apart.topology, apart.positions.copy()
    firsts = np.array([int(atom.residue.id) for atom in topology.atoms()])
    positions[:, 0] -= 0.4 * firsts
    lines = linesOf(topology, positions)
    again, _ = prepareStructure(readStructure(writePDB(tmp_path / "hydroxyls.pdb", lines)), model, 7, 1)
    assert len(itemsOf(again, "stay open")) == 2


def test_aPhosphateAtTheEndOfDNA(tmp_path):
    kept = strandLines(2, 5)
    structure = readStructure(writePDB(tmp_path / "dna.pdb", kept))
    model = EnergyModel(["amber14/DNA.OL15.xml"], 300, isPrepared=True)
    whole, _ = prepareStructure(structure, model, 7, 1)
    assert itemsOf(whole, "phosphates at 5' ends") == ["A:DG 2"]
    model.makeSystem(whole)
