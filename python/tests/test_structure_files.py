"""Files as programs write them: what other tools read is read, or refused with the line."""

import gzip
import io

import gemmi
import numpy as np
import pytest
from openmm import app, unit
from openmmchaintree import InputError
from openmmchaintree.structures.structure import readModels, readStructure
from scenes import GLYCINES, bondNames, pdbLine, realStructurePath, writePDB

_SHIFTED = [line[:30] + f"{float(line[30:38]) + 50:8.3f}" + line[38:] for line in GLYCINES]


def read(path, *lines, model=0):
    return readStructure(writePDB(path / "file.pdb", lines), model)


@pytest.mark.parametrize(
    "lines",
    [
        ["MODEL", *GLYCINES, "ENDMDL", "MODEL", *_SHIFTED, "ENDMDL"],
        ["MODEL        x", *GLYCINES, "ENDMDL", "MODEL        x", *_SHIFTED, "ENDMDL"],
        ["MODEL        7", *GLYCINES, "ENDMDL", "MODEL        7", *_SHIFTED, "ENDMDL"],
        [*GLYCINES, "END", *_SHIFTED, "END"],
        ["MODEL        1", *GLYCINES, "TER", "ENDMDL", "MODEL        2", *_SHIFTED, "TER", "ENDMDL"],
    ],
)
def test_modelsByAnyMark(tmp_path, lines):
    path = writePDB(tmp_path / "models.pdb", lines)
    models = readModels(path)
    assert models.damage is None and len(models.positions) == 2
    assert models.positions[1] == pytest.approx(models.positions[0] + [5, 0, 0])
    assert np.array_equal(readStructure(path, 1).positions, models.positions[1])
    with pytest.raises(InputError, match=r"models.pdb: there is no model 2 \(from 0\), but 2 in all$"):
        readStructure(path, 2)


def test_oneOfModelsOfDifferentLength(tmp_path):
    lines = ["MODEL        1", *GLYCINES, "ENDMDL", "MODEL        2", *GLYCINES[:7], "ENDMDL", "MODEL        3"]
    path = writePDB(tmp_path / "unequal.pdb", [*lines, *_SHIFTED, "ENDMDL"])
    assert [readStructure(path, model).topology.getNumAtoms() for model in range(3)] == [8, 7, 8]
    assert readModels(path).damage is not None


def test_modelsOfOtherAtoms(tmp_path):
    other = [line.replace(" O ", " S ") for line in GLYCINES]
    path = writePDB(tmp_path / "other.pdb", ["MODEL 1", *GLYCINES, "ENDMDL", "MODEL 2", *other, "ENDMDL"])
    assert "has atom A:GLY 1 S where model 0 has A:GLY 1 O" in str(readModels(path).damage)


@pytest.mark.parametrize("serial", ["     ", "*****", "A0000", "    0"])
def test_serialNumbersDoNotMatter(tmp_path, serial):
    lines = [line[:6] + serial + line[11:] for line in GLYCINES]
    assert bondNames(read(tmp_path, *lines).topology) == bondNames(read(tmp_path, *GLYCINES).topology)


def test_whatIsOfNoUseMayBeDamaged(tmp_path, villin):
    """Here a sequence refers to one of a database that the file does not tell of."""
    names = ("align_id", "ref_id", "pdbx_strand_id", "seq_align_beg", "seq_align_end", "db_align_beg", "db_align_end")
    text = io.StringIO("".join(["data_villin\n", *(f"_struct_ref_seq.{name} 1\n" for name in names)]))
    text.seek(0, io.SEEK_END)
    app.PDBxFile.writeFile(villin.topology, villin.positions * unit.nanometer, text)
    path = tmp_path / "villin.cif"
    path.write_text(text.getvalue().replace("data_cell\n", ""))
    assert readStructure(path).topology.getNumAtoms() == villin.topology.getNumAtoms()


@pytest.mark.parametrize("encoding", ["latin-1", "utf-8"])
def test_lettersThatAreNotASCII(tmp_path, encoding):
    """They take a column each, in whatever bytes."""
    lines = ["REMARK  \u00c5ngstr\u00f6m", *(line[:6] + "  \u00e9 1" + line[11:] for line in GLYCINES)]
    path = tmp_path / "letters.pdb"
    path.write_bytes("\n".join(lines).encode(encoding))
    found, expected = readStructure(path), read(tmp_path, *GLYCINES)
    assert np.array_equal(found.positions, expected.positions)
    assert bondNames(found.topology) == bondNames(expected.topology)


def test_endsOfLinesAndLetters(tmp_path):
    path = tmp_path / "odd.pdb"
    path.write_bytes("\r\n".join(["REMARK caf\u00e9", *GLYCINES, ""]).encode("latin-1"))
    assert readStructure(path).topology.getNumAtoms() == 8


@pytest.mark.parametrize("width", [54, 66, 76])
def test_elementsFromNames(tmp_path, width):
    """Without the columns of the element, whichever column the name begins in."""
    lines = [
        pdbLine(1, "N", "LYS", "A", 1, 0, 0, 0),
        pdbLine(2, "CA", "LYS", "A", 1, 1.45, 0, 0),
        pdbLine(3, "C", "LYS", "A", 1, 1.95, 1.42, 0),
        pdbLine(4, "CE", "LYS", "A", 1, 1.95, -1.42, 1.2),
        pdbLine(5, "HE21", "LYS", "A", 1, 1.95, -2.42, 1.2),
        pdbLine(6, "1HE", "LYS", "A", 1, 1.0, -1.42, 1.8),
        pdbLine(7, "NZ", "LYS", "A", 1, 3.3, -1.42, 1.8),
        pdbLine(8, "SE", "MSE", "A", 2, 9.3, -1.42, 1.8, element="SE"),
        pdbLine(9, "CA", "CA", "A", 3, 30, 0, 0, element="CA", record="HETATM"),
        pdbLine(10, "CL1", "LIG", "A", 4, 40, 0, 0, element="CL", record="HETATM"),
        pdbLine(11, "C2", "LIG", "A", 4, 41.7, 0, 0, record="HETATM"),
    ]
    for justify in (str, lambda line: line[:12] + f"{line[12:16].strip():<4}" + line[16:]):
        path = writePDB(tmp_path / "elements.pdb", [justify(line)[:width] for line in lines])
        elements = [atom.element.symbol for atom in readModels(path).topology.atoms()]
        assert elements == ["N", "C", "C", "C", "H", "H", "N", "Se", "Ca", "Cl", "C"]


def test_residueNamesOfFourLetters(tmp_path):
    """Water is left out, and a histidine is one, as GROMACS and CHARMM write them."""
    water = pdbLine(9, "OW", "TIP", " ", 3, 30, 0, 0).replace("TIP  ", "TIP3 ")
    named = [line.replace("GLY A", "HISE ") if "GLY A   2" in line else line for line in GLYCINES]
    histidine = [line.replace(" A ", "   ") for line in named]
    structure = read(tmp_path, *histidine, water)
    assert [residue.name for residue in structure.topology.residues()] == ["GLY", "HISE"]
    assert len(bondNames(structure.topology)) == 7


def test_chainNamesOfTwoLetters(tmp_path):
    lines = [line.replace("GLY A", "GLYAB") for line in GLYCINES]
    ligand = [
        pdbLine(9, "C1", "LIG", "A", 3, 30, 0, 0, record="HETATM").replace("LIG A", "LIGAC"),
        pdbLine(10, "C2", "LIG", "A", 3, 31.5, 0, 0, record="HETATM").replace("LIG A", "LIGAC"),
    ]
    residues = read(tmp_path, *lines, *ligand).topology.residues()
    assert [(residue.chain.id, residue.name) for residue in residues] == [("AB", "GLY"), ("AB", "GLY"), ("AC", "LIG")]


@pytest.mark.parametrize("residue", ["  A", " DA", "HOH", " ZN", "ATP", "MSE", "ACE", "PSU"])
@pytest.mark.parametrize("chain", ["AB", "aB", "Ba", "1A"])
def test_chainNamesOfTwoLettersWithoutAminoAcids(tmp_path, residue, chain):
    name = {"HOH": " O  ", " ZN": "ZN  "}.get(residue, " P  ")
    path = writePDB(tmp_path / "chain.pdb", [f"HETATM   20 {name} {residue}{chain}   7       3.000   0.000   0.000"])
    (found,) = readModels(path).topology.residues()
    assert (found.chain.id, found.name) == (chain, residue.strip())


@pytest.mark.parametrize("residue", ["TIP3", "HISE", "NALA", "SOLV", "POPC", "HEME", "BMAN", "ALAD", "ABCD"])
def test_residueNamesOfFourLettersBeforeAChain(tmp_path, residue):
    line = f"ATOM     20  C1  {residue}X   7       3.000   0.000   0.000"
    (found,) = readModels(writePDB(tmp_path / "residue.pdb", [line])).topology.residues()
    assert (found.chain.id, found.name) == ("X", residue)


def test_oldNamesOfNucleotides(tmp_path):
    """C1* for C1', and the phosphate of the next nucleotide is bonded."""
    path = realStructurePath("1bna.pdb")
    old = tmp_path / "old.pdb"
    old.write_text(path.read_text().replace("'", "*"))
    assert bondNames(readStructure(old).topology) == bondNames(readStructure(path).topology)


def test_binaryCIF(tmp_path, villin):
    """Made by biotite of what OpenMM wrote."""
    import biotite.structure.io.pdbx as pdbx

    with open(tmp_path / "villin.cif", "w") as file:
        app.PDBxFile.writeFile(villin.topology, villin.positions * unit.nanometer, file)
    columns = gemmi.cif.read(str(tmp_path / "villin.cif")).sole_block().get_mmcif_category("_atom_site.", raw=True)
    category = pdbx.BinaryCIFCategory({name: np.array(values, dtype=str) for name, values in columns.items()})
    pdbx.BinaryCIFFile({"villin": pdbx.BinaryCIFBlock({"atom_site": category})}).write(tmp_path / "villin.bcif")
    (tmp_path / "villin.bcif.gz").write_bytes(gzip.compress((tmp_path / "villin.bcif").read_bytes()))
    expected = readStructure(tmp_path / "villin.cif")
    for name in ("villin.bcif", "villin.bcif.gz"):
        structure = readStructure(tmp_path / name)
        assert bondNames(structure.topology) == bondNames(expected.topology)
        assert structure.positions == pytest.approx(expected.positions, abs=1e-9)
    (tmp_path / "cut.bcif").write_bytes((tmp_path / "villin.bcif").read_bytes()[:2000])
    with pytest.raises(InputError, match="cut.bcif: not a BinaryCIF file that can be read"):
        readStructure(tmp_path / "cut.bcif")


def test_ligandOfTheDictionary():
    structure = readStructure(realStructurePath("hard/mol_03F.cif.gz"))
    assert structure.topology.getNumAtoms() == 130
    assert structure.topology.getNumBonds() >= 130 - 1


def test_atomsOfUnknownElementAlone(tmp_path):
    """UNX, which crystallographers put where they know no better, is left out as an ion is."""
    unknown = pdbLine(9, "UNK", "UNX", "A", 3, 30, 0, 0, record="HETATM", element="X")
    assert read(tmp_path, *GLYCINES, unknown).topology.getNumAtoms() == 8
    another = pdbLine(10, "UN2", "UNX", "A", 3, 33, 0, 0, record="HETATM", element="X")
    with pytest.raises(
        InputError, match="whose element is not known .2.: UNK of A:UNX 3; UN2 of A:UNX 3: give elements"
    ):
        read(tmp_path, *GLYCINES, unknown, another)
