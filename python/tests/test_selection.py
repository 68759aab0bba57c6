"""selectAtoms, and findTorsions by selection."""

from collections import Counter

import numpy as np
import pytest
from openmm import app
from openmmchaintree import findTorsions, selectAtoms
from scenes import peptide


def twoChains():
    """Chains X and Y of ALA LYS SER, with residues 51, 52 and 52A."""
    topology = peptide("ALA", "LYS", "SER", chains=2)
    for chain, name in zip(topology.chains(), "XY", strict=True):
        chain.id = name
        for residue, number, code in zip(chain.residues(), ("51", "52", "52"), "  A", strict=True):
            residue.id, residue.insertionCode = number, code
    return topology


def namesOf(topology, atoms):
    found = list(topology.atoms())
    return [(found[i].residue.chain.id, found[i].residue.name, found[i].name) for i in atoms]


def kindsOf(search):
    return Counter((torsion.kind, torsion.residue.name) for torsion in search.torsions)


def test_text():
    topology = twoChains()
    assert namesOf(topology, selectAtoms(topology, "name CA and resname LYS")) == [
        ("X", "LYS", "CA"), ("Y", "LYS", "CA")
    ]  # fmt: skip
    every = np.arange(topology.getNumAtoms())
    assert np.array_equal(selectAtoms(topology, "all"), every)
    ofX, ofY = selectAtoms(topology, "segname X"), selectAtoms(topology, "segname Y")
    assert np.array_equal(np.concatenate([ofX, ofY]), every) and len(ofX) == len(ofY)
    assert np.array_equal(selectAtoms(topology, "chainid 1"), ofY)


def test_numbersOfResidues():
    topology = twoChains()

    def residues(text):
        return [residue.index for residue in topology.residues() if set(_atomsOf(residue)) & chosen(text)]

    def chosen(text):
        return set(selectAtoms(topology, text).tolist())

    assert residues("resSeq 51") == [0, 3]
    assert residues("resSeq 52") == [1, 2, 4, 5]  # insertion codes do not count
    assert residues("resid 2 to 3") == [2, 3]
    assert residues("segname Y and (resSeq ge 52)") == [4, 5]


def _atomsOf(residue):
    return [atom.index for atom in residue.atoms()]


def test_function():
    topology = twoChains()
    atoms = selectAtoms(topology, lambda atom: atom.residue.insertionCode == "A" and atom.name == "OG")
    assert namesOf(topology, atoms) == [("X", "SER", "OG"), ("Y", "SER", "OG")]


def test_indices():
    topology = twoChains()
    for selection in ([4, 2, 2], (2, 4), np.array([2, 4]), np.isin(np.arange(topology.getNumAtoms()), (2, 4))):
        atoms = selectAtoms(topology, selection)
        assert atoms.tolist() == [2, 4]


@pytest.mark.parametrize(
    ("selection", "words"),
    [
        ("resname TRP", "'resname TRP' selects no atom"),
        ("chain X", "'chain X' is not in MDTraj's selection language .Expected end of text, found 'X'"),
        ("", "'' is not in MDTraj's selection language .a part is missing"),
        ("resSeq 10:20", "resSeq 10:20"),
        ("name > 5", "name > 5"),
        ("mass 1.2.3", "mass 1.2.3"),
        ("CA", "CA"),
        ("1", "a value alone is not a condition"),
        ("protein && resSeq < 52", "put comparisons in parentheses"),
        ("protein and resSeq lt 52", "put comparisons in parentheses"),
        ("protein and name =~ 'C.*'", "put comparisons in parentheses"),
        (lambda atom: False, "^the selection has no atom$"),
        ([], "^the selection has no atom$"),
        ([0, 40], "^the selection has atom 40, but there are atoms 0 to 39 only$"),
        ([-1], "^the selection has atom -1"),
        ([0.5], "a text, a function of an atom, or a list of atom indices"),
        ([[1, 2]], "a text, a function of an atom, or a list of atom indices"),
        ([True, False], r"must have the shape \(40,\), not \(2,\)"),
    ],
)
def test_badSelection(selection, words):
    topology = twoChains()
    assert topology.getNumAtoms() == 40
    with pytest.raises(ValueError, match=words) as raised:
        selectAtoms(topology, selection)
    assert "\n" not in str(raised.value)


def test_parenthesesSettleWhatIsMeant():
    topology = twoChains()
    assert len(selectAtoms(topology, "protein && (resSeq < 52)")) == 10
    assert len(selectAtoms(topology, "protein and (name =~ 'C.*')")) > 10


def test_extraParticles():
    topology = twoChains()
    residue = topology.addResidue("HOH", topology.addChain("W"))
    topology.addAtom("O", app.Element.getBySymbol("O"), residue)
    topology.addAtom("M", None, residue)
    assert selectAtoms(topology, "water").tolist() == [40, 41]
    assert selectAtoms(topology, "segname W").tolist() == [40, 41]


def test_torsionsOfTheThirdAtom():
    topology = peptide("ALA", "LYS", "SER")
    kinds = ("phi", "psi", "omega", "chi")
    everything = kindsOf(findTorsions(topology, kinds=kinds))
    assert kindsOf(findTorsions(topology, kinds=kinds, selection="all")) == everything
    assert kindsOf(findTorsions(topology, kinds=kinds, selection="backbone")) == {
        key: number for key, number in everything.items() if not key[0].startswith("chi")
    }
    assert kindsOf(findTorsions(topology, kinds=kinds, selection="sidechain")) == {
        key: number for key, number in everything.items() if key[0].startswith("chi")
    }
    ofLysine = findTorsions(topology, selection="resname LYS")
    assert kindsOf(ofLysine) == {(kind, "LYS"): 1 for kind in ("phi", "psi", "chi1", "chi2", "chi3", "chi4")}
    assert kindsOf(findTorsions(topology, selection="name CB")) == {("chi1", "LYS"): 1, ("chi1", "SER"): 1}


def test_theSameByTextIndicesAndFunction():
    topology = peptide("ALA", "LYS", "SER")
    byText = findTorsions(topology, selection="resid 1").torsions
    assert byText
    assert findTorsions(topology, selection=lambda atom: atom.residue.index == 1).torsions == byText
    assert findTorsions(topology, selection=selectAtoms(topology, "resid 1")).torsions == byText


def test_leftOutAreThoseOfTheSelection():
    topology = peptide("ALA", "PRO", "ALA", "PRO")
    assert [left.residue.index for left in findTorsions(topology, selection="resid 1").leftOut] == [1]


def test_fixedEndsHoldALoop():
    """Between the residues 1 and 4 no torsion of the backbone turns, beyond them all do."""
    topology = peptide("ALA", "LYS", "SER", "VAL", "LYS", "ALA")
    search = findTorsions(topology, fixed=lambda atom: atom.residue.index in (1, 4) and atom.name in ("N", "CA", "C"))
    backbone = [(t.kind, t.residue.index) for t in search.torsions if not t.kind.startswith("chi")]
    assert backbone == [("psi", 0), ("phi", 5)]
    chi = sorted((t.residue.index, t.kind) for t in search.torsions if t.kind.startswith("chi"))
    assert chi == sorted((t.residue.index, t.kind) for t in findTorsions(topology, kinds="chi").torsions)
    assert Counter(left.reason for left in search.leftOut) == {
        "between two fixed parts": 4,
        "about a bond between fixed atoms": 4,
    }


def test_fixedTipHoldsItsSideChainOnly():
    """The other side of each torsion is free to move."""
    topology = peptide("ALA", "LYS", "ALA")
    search = findTorsions(topology, fixed="name NZ")
    assert search.torsions == findTorsions(topology).torsions and search.leftOut == []
    both = findTorsions(topology, fixed="name NZ or (resid 1 and name CA)")
    assert {left.kind for left in both.leftOut} == {"chi1", "chi2", "chi3", "chi4"}
    assert kindsOf(both) == {("phi", "LYS"): 1, ("psi", "LYS"): 1, ("psi", "ALA"): 1, ("phi", "ALA"): 1}


def test_selectionMakesOneRigidPartOfFixedOnes():
    """What does not turn joins fixed atoms, so that nothing between them has to be left out."""
    topology = peptide("ALA", "LYS", "SER", "ALA")
    search = findTorsions(topology, selection="sidechain", fixed="name CA")
    assert kindsOf(search) == kindsOf(findTorsions(topology, kinds="chi"))
    assert search.leftOut == []
