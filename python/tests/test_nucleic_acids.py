"""Torsions of nucleic acids, and how they are sampled."""

import json
from collections import Counter

import numpy as np
import pytest
from openmm import app
from openmmchaintree import createStericExclusionForce, findTorsions
from openmmchaintree.command.plan import Choice, Plan
from scenes import readDCD, realStructurePath

_SUGAR_AND_PHOSPHATE = "P OP1 OP2 O5' C5' C4' O4' C3' O3' C2' C1' "
_ATOMS = {
    "DA": _SUGAR_AND_PHOSPHATE + "N9 C8 N7 C5 C6 N6 N1 C2 N3 C4",
    "DT": _SUGAR_AND_PHOSPHATE + "N1 C2 O2 N3 C4 O4 C5 C7 C6",
}
_KINDS = ("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "chi")


def nucleicAcid(*names):
    """Make the Topology of a strand that begins without a phosphate."""
    topology = app.Topology()
    chain = topology.addChain("A")
    for number, name in enumerate(names):
        residue = topology.addResidue(name, chain)
        for atom in _ATOMS[name].split()[3 if number == 0 else 0 :]:
            topology.addAtom(atom, app.Element.getBySymbol(atom[0]), residue)
    topology.createStandardBonds()
    return topology


def rename(topology, residue, name, atoms=None):
    chosen = list(topology.residues())[residue]
    chosen.name = name
    for atom in chosen.atoms():
        atom.name = (atoms or {}).get(atom.name, atom.name)


def kindsOf(search):
    return Counter(torsion.kind for torsion in search.torsions)


def test_strand():
    search = findTorsions(nucleicAcid("DA", "DT", "DA"), kinds=_KINDS)
    assert kindsOf(search) == {"alpha": 2, "beta": 2, "gamma": 3, "epsilon": 2, "zeta": 2, "chi": 3}
    assert {(left.kind, left.reason) for left in search.leftOut} == {("delta", "in the ring of the sugar")}


def test_sugarsAreNoReasonToWarn(recwarn):
    createStericExclusionForce(nucleicAcid("DA", "DT"), torsions=_KINDS)
    assert len(recwarn) == 0


@pytest.mark.parametrize(
    ("residue", "atoms"), [("DA", {}), ("DT", {}), ("DT", {"N1": "C5", "C2": "C4", "C5": "N1", "C4": "C2"})]
)
def test_modifiedNucleotideIsKnownByItsAtoms(residue, atoms):
    """The last one is a pseudouridine, whose base hangs on its C5."""
    topology = nucleicAcid("DA", residue, "DA")
    expected = [torsion.particles for torsion in findTorsions(topology, kinds=_KINDS).torsions]
    rename(topology, 1, "XYZ", atoms)
    assert [torsion.particles for torsion in findTorsions(topology, kinds=_KINDS).torsions] == expected


def test_nucleotideAloneIsALigand():
    topology = nucleicAcid("DA")
    assert kindsOf(findTorsions(topology, kinds=_KINDS)) == {"gamma": 1, "chi": 1}
    rename(topology, 0, "ATP")
    assert findTorsions(topology, kinds=_KINDS).torsions == []


def test_torsionsOfTheThirdAtom():
    topology = nucleicAcid("DA", "DT", "DA")
    search = findTorsions(topology, kinds=_KINDS, selection="name O5' or name N1".replace("O5'", '"O5\'"'))
    assert kindsOf(search) == {"alpha": 2, "chi": 1}
    middle = findTorsions(topology, kinds=_KINDS, selection="resid 1")
    # The third atom of ζ is the P that follows.
    assert kindsOf(middle) == {kind: 1 for kind in ("alpha", "beta", "gamma", "epsilon", "zeta", "chi")}
    assert {torsion.residue.index for torsion in middle.torsions if torsion.kind == "zeta"} == {0}


def sample(runCommandHere, folder, *arguments):
    result = runCommandHere("sample", *arguments, "--seed", 1, "--json", "summary.json", "-o", "run")
    assert result.returncode == 0, result.stderr
    return json.loads((folder / "summary.json").read_text()), readDCD(folder / "run.dcd")


def test_duplex(runCommandHere, tmp_path):
    """Each strand hangs on its 5' end, where it was."""
    summary, frames = sample(runCommandHere, tmp_path, realStructurePath("1bna.pdb"), "--trials", 3000, "--frames", 4)
    assert summary["torsions"] == {"chi": 24, "alpha": 22, "beta": 22, "gamma": 24, "epsilon": 22, "zeta": 22}
    assert summary["pairsBeyondLimit"] == []
    assert [note["kind"] for note in summary["notes"]] == [
        "the file is of a crystal (P 21 21 21), whose copies do not count (see clashes --symmetry)"
    ]
    for move in summary["moves"]:
        assert move["attempted"] > move["accepted"] > 0 and "rigid" not in move["name"]
    topology = app.PDBFile(str(tmp_path / "run-topology.pdb")).topology
    for chain in topology.chains():
        first = [atom.index for atom in chain.atoms()][:2]
        assert np.array_equal(frames[0][first], frames[-1][first])
    assert summary["plan"][0].startswith("moves: chain A (241 of 243 atoms), chain B (241 of 243 atoms) by 136 tors")


def test_boundToAProtein(runCommandHere, tmp_path):
    path = realStructurePath("hard/5ugo.pdb.gz")
    summary, _ = sample(runCommandHere, tmp_path, path, "--trials", 3000, "--frames", 2)
    assert {"phi", "psi", "chi1", "chi", "alpha", "zeta"} <= set(summary["torsions"])
    assert summary["pairsBeyondLimit"] == []
    attempted = {move["name"]: move["attempted"] for move in summary["moves"]}
    # By the numbers of their torsions: 637 of the protein's backbone, 149 of the DNA's.
    assert attempted["φ/ψ ±5°"] > 3 * attempted["α–ζ ±5°"] > 0


def test_fixedNucleicAcid(runCommandHere, tmp_path):
    path = realStructurePath("hard/5ugo.pdb.gz")
    summary, frames = sample(runCommandHere, tmp_path, path, "--trials", 1000, "--frames", 2, "--fix", "nucleic")
    assert not {"alpha", "chi"} & set(summary["torsions"])
    topology = app.PDBFile(str(tmp_path / "run-topology.pdb")).topology
    nucleic = [atom.index for atom in topology.atoms() if atom.residue.name in ("DA", "DC", "DG", "DT")]
    assert len(nucleic) > 500
    assert np.array_equal(frames[0][nucleic], frames[-1][nucleic])


def test_largeRNA(realStructure):
    structure = realStructure("hard/1gid.cif.gz")
    plan = Plan(structure, Choice())
    kinds = Counter(torsion.kind for torsion in plan.torsions)
    assert kinds["gamma"] == kinds["chi"] == len(list(structure.topology.residues())) > 100
