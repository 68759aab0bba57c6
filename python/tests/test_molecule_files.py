"""SDF and Mol2 files: their bonds are those of the file, and clashes those of the same molecule in PDB."""

import json

import numpy as np
import pytest
from foreignfiles import mol2Of, sdfOf
from openmmchaintree import InputError, findClashes
from openmmchaintree.structures.structure import readModels, readStructure
from scenes import DIPEPTIDE, readDCD, writePDB


@pytest.fixture(scope="module")
def molecule(tmp_path_factory):
    """The PDB file of a dipeptide, its elements, bonds and positions (Å)."""
    path = writePDB(tmp_path_factory.mktemp("molecule") / "molecule.pdb", DIPEPTIDE)
    structure = readStructure(path)
    elements = [atom.element.symbol for atom in structure.topology.atoms()]
    bonds = sorted(tuple(sorted(atom.index for atom in bond)) for bond in structure.topology.bonds())
    return path, elements, bonds, 10 * structure.positions


WRITERS = {"sdf": sdfOf, "mol2": mol2Of}


@pytest.mark.parametrize("suffix", WRITERS)
def test_conformers(tmp_path, molecule, suffix):
    """Molecules of a file are models; bonds are those of the first, and are never found by distance."""
    pdb, elements, bonds, positions = molecule
    folded = positions.copy()
    folded[-1] = positions[0] + [0, 0, 1.0]
    path = tmp_path / f"m.{suffix}"
    path.write_text(WRITERS[suffix](elements, bonds, positions, folded))
    models = readModels(path)
    assert [atom.element.symbol for atom in models.topology.atoms()] == elements
    assert sorted(tuple(sorted(atom.index for atom in bond)) for bond in models.topology.bonds()) == bonds
    assert [
        np.abs(10 * found - frame).max() < 1e-4
        for found, frame in zip(models.positions, (positions, folded), strict=True)
    ]
    first, second = findClashes(path)
    (expected,) = findClashes(pdb)
    assert {(clash.particle1, clash.particle2) for clash in first.clashes} == {
        (clash.particle1, clash.particle2) for clash in expected.clashes
    }
    assert (0, 21) in {(clash.particle1, clash.particle2) for clash in second.clashes}


@pytest.mark.parametrize(
    ("kinds", "residue"),
    [
        ({"C": "C.3", "N": "N.am", "O": "O.2", "H": "H"}.get, "LIG1"),  # of SYBYL
        ({"C": "c3", "N": "n", "O": "o", "H": "hc"}.get, "<0>"),  # of GAFF
        ({"C": "CT", "N": "N", "O": "O", "H": "HC"}.get, "LIG"),  # of AMBER
    ],
)
def test_typesOfMol2(tmp_path, molecule, kinds, residue):
    _, elements, bonds, positions = molecule
    path = tmp_path / "m.mol2"
    path.write_text(mol2Of(elements, bonds, positions, kinds=kinds, residue=residue))
    topology = readModels(path).topology
    assert [atom.element.symbol for atom in topology.atoms()] == elements
    assert {one.name for one in topology.residues()} == {"UNL" if residue == "<0>" else "LIG"}


def test_metalsAndHalogens(tmp_path):
    lines = [("ZN", "Zn"), ("CL1", "Cl"), ("BR1", "br"), ("CL2", "cl"), ("C1", "C.ar")]
    path = tmp_path / "m.mol2"
    text = "".join(f"{i} {name} {3 * i} 0 0 {kind} 1 LIG\n" for i, (name, kind) in enumerate(lines, 1))
    path.write_text(f"@<TRIPOS>MOLECULE\nm\n5 0\n@<TRIPOS>ATOM\n{text}")
    assert [atom.element.symbol for atom in readModels(path).topology.atoms()] == ["Zn", "Cl", "Br", "Cl", "C"]


@pytest.mark.parametrize("suffix", WRITERS)
def test_sampleHardSpheres(tmp_path, molecule, runCommandHere, suffix):
    """By the orders in the file, φ and ψ are rotatable bonds, and amides are not."""
    _, elements, bonds, positions = molecule
    (tmp_path / f"m.{suffix}").write_text(WRITERS[suffix](elements, bonds, positions))
    options = ("--trials", 500, "--frames", 2, "--seed", 1, "--json", "m.json")
    result = runCommandHere("sample", f"m.{suffix}", "--torsions", "rotatable", *options)
    assert result.returncode == 0, result.stderr
    assert "by 2 torsions (2 other)" in result.stdout
    summary = json.loads((tmp_path / "m.json").read_text())
    assert sum(move["accepted"] for move in summary["moves"]) > 100
    frames = readDCD(tmp_path / "m.dcd")
    assert np.abs(frames[-1] - frames[0]).max() > 0.1
    for frame in frames:
        lengths = [np.linalg.norm(frame[first] - frame[second]) for first, second in bonds]
        assert lengths == pytest.approx([np.linalg.norm(positions[i] - positions[j]) / 10 for i, j in bonds], abs=1e-4)


def test_noTorsionOfAProtein(tmp_path, molecule, runCommandHere):
    """The default kinds are of polymers: an option turns ligands."""
    _, elements, bonds, positions = molecule
    (tmp_path / "m.sdf").write_text(sdfOf(elements, bonds, positions))
    result = runCommandHere("sample", "m.sdf")
    assert result.returncode == 2 and "--torsions rotatable also turns bonds of other molecules" in result.stderr


def test_damaged(tmp_path, molecule):
    """One sentence that names the file and the molecule; molecules before the damage are searched."""
    _, elements, bonds, positions = molecule
    path = tmp_path / "m.sdf"
    sdf, mol2 = sdfOf(elements, bonds, positions), mol2Of(elements, bonds, positions)
    for suffix, text in [
        ("sdf", ""),
        ("sdf", "nothing\n"),
        ("sdf", sdf[:500]),
        ("sdf", sdf.replace("M  END", "")),
        ("sdf", sdf.replace(" 22 21", " 23 21")),
        ("mol2", ""),
        ("mol2", "nothing\n"),
        ("mol2", mol2[:500]),
        ("mol2", mol2.replace("22 21 1", "23 21 1")),
        ("mol2", mol2.replace("1 1 2 1\n", "1 1 99 1\n")),
        ("mol2", mol2.replace("@<TRIPOS>ATOM", "@<TRIPOS>ATOMS")),
        ("mol2", mol2.replace("0.0000", "zero")),
        ("mol2", mol2.replace("0.0000", "nan")),
    ]:
        path = tmp_path / f"m.{suffix}"
        path.write_text(text)
        with pytest.raises(InputError, match=f"m.{suffix}: ") as caught:
            readStructure(path)
        assert "\n" not in str(caught.value) and len(str(caught.value)) < 400
    for suffix, whole in (("sdf", sdf), ("mol2", mol2)):
        path = tmp_path / f"m.{suffix}"
        path.write_text(whole + whole[: len(whole) // 2])
        with pytest.raises(InputError, match=rf"m.{suffix}: molecule 1 \(from 0\)") as caught:
            findClashes(path)
        assert len(caught.value.frames) == 1


def test_otherMolecules(tmp_path, molecule):
    """A library of different molecules is not one structure."""
    _, elements, bonds, positions = molecule
    path = tmp_path / "m.sdf"
    path.write_text(sdfOf(elements, bonds, positions) + sdfOf(["C", "O"], [(0, 1)], np.array([[0, 0, 0], [1.4, 0, 0]])))
    with pytest.raises(InputError, match=r"model 1 \(from 0\) has 2 atoms, but model 0 has 22"):
        findClashes(path)
