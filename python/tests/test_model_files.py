"""Model files whose coordinates change, and nothing else."""

import gzip

import gemmi
import numpy as np
import pytest
from openmmchaintree import InputError
from openmmchaintree.structures.modelfile import NewAtom, compressedAs, readModelFile
from openmmchaintree.structures.structure import readModels

_PDB = """\
HEADER    A PROTEIN
REMARK  99 KEEP ME
CRYST1   50.000   50.000   50.000  90.00  90.00  90.00 P 1           1
ATOM      1  N   ALA A   5A      1.000   2.000   3.000  1.00 12.34      SEGA N1+
ATOM      2  CA AALA A   5A      2.000   2.000   3.000  0.60 11.00      SEGA C
ATOM      3  CA BALA A   5A      2.000   2.500   3.000  0.40 11.00      SEGA C
ATOM      4  HA  ALA A   5A      2.500   2.500   3.000  1.00 11.00      SEGA H
ANISOU    4  HA  ALA A   5A     2406   1892   1614    198    519   -328       H
TER       5      ALA A   5A
HETATM    6  O   HOH B   1       9.000   9.000   9.000  1.00 30.00           O
CONECT    1    2    4
CONECT    4    1
MASTER        0    0
END
"""

_CIF = """\
data_x
_entry.id x
_my.own "stays as it is"
loop_
_atom_site.group_PDB
_atom_site.id
_atom_site.type_symbol
_atom_site.label_atom_id
_atom_site.label_alt_id
_atom_site.label_comp_id
_atom_site.label_asym_id
_atom_site.label_entity_id
_atom_site.label_seq_id
_atom_site.Cartn_x
_atom_site.Cartn_y
_atom_site.Cartn_z
_atom_site.occupancy
_atom_site.B_iso_or_equiv
_atom_site.auth_asym_id
_atom_site.auth_seq_id
_atom_site.pdbx_PDB_model_num
ATOM 1 N N . ALA A 1 1 1.0000 2.000 3.000 1.00 12.34 A 5 1
ATOM 2 C CA . ALA A 1 1 2.000 2.000 3.000 1.00 11.00 A 5 1
ATOM 3 N N . ALA A 1 1 1.100 2.000 3.000 1.00 12.34 A 5 2
ATOM 4 C CA . ALA A 1 1 2.100 2.000 3.000 1.00 11.00 A 5 2
"""


def written(tmp_path, name, text):
    path = tmp_path / name
    path.write_bytes(text) if isinstance(text, bytes) else path.write_text(text)
    return path


def test_aPDBFileKeepsEverythingElse(tmp_path):
    file = readModelFile(written(tmp_path, "a.pdb", _PDB))
    lines = _PDB.splitlines()
    text = file.write({3: np.array([-1.0, 2.25, 1000.0])})
    expected = list(lines)
    expected[3] = lines[3][:30] + "  -1.000   2.2501000.000" + lines[3][54:]
    assert text.splitlines() == expected
    assert file.write({}) == _PDB


def test_otherConformersFollow(tmp_path):
    path = written(tmp_path, "a.pdb", _PDB)
    file = readModelFile(path)
    models = readModels(path, 0)
    rows = file.matchRows(0, 10 * models.positions[0])
    moved = {row: 10 * place + 1 for row, place in zip(rows, models.positions[0], strict=True) if row == 4}
    whole = file.withAlternates(0, moved)
    assert sorted(whole) == [4, 5]
    assert np.allclose(whole[5], [3.0, 3.5, 4.0])


def test_aShiftBelowTheLastDigitChangesNothing(tmp_path):
    file = readModelFile(written(tmp_path, "a.pdb", _PDB))
    assert file.withAlternates(0, {3: np.array([1.0004, 2.0, 3.0])}) == {}


def test_hydrogensAreRemovedWithTheirBonds(tmp_path):
    file = readModelFile(written(tmp_path, "a.pdb", _PDB))
    text = file.write({}, removed={6})
    assert " HA " not in "".join(line for line in text.splitlines() if line.startswith("ATOM"))
    assert [line.rstrip() for line in text.splitlines() if line.startswith("CONECT")] == ["CONECT    1    2"]
    assert "REMARK  99 KEEP ME" in text and text.endswith("END\n")


def test_hydrogensAreAddedToTheirResidue(tmp_path):
    file = readModelFile(written(tmp_path, "a.pdb", _PDB))
    text = file.write({}, added=[NewAtom(3, "H2", np.array([1.5, 2.5, 3.5]))])
    (line,) = [line for line in text.splitlines() if " H2 " in line]
    assert line == "ATOM      7  H2  ALA A   5A      1.500   2.500   3.500  1.00 12.34      SEGA H"
    structure = gemmi.read_pdb_string(text)
    assert [atom.name for atom in structure[0]["A"][0]] == ["N", "CA", "CA", "HA", "H2"]


def test_mmCIF(tmp_path):
    file = readModelFile(written(tmp_path, "a.cif", _CIF))
    assert [len(model) for model in file.models] == [2, 2]
    text = file.write({0: np.array([-1.0, 2.25, 7.0])})
    block, before = gemmi.cif.read_string(text).sole_block(), gemmi.cif.read_string(_CIF).sole_block()
    assert block.find_value("_my.own") == '"stays as it is"'
    changed = block.get_mmcif_category("_atom_site.", raw=True)
    given = before.get_mmcif_category("_atom_site.", raw=True)
    assert [changed.pop(f"Cartn_{axis}")[0] for axis in "xyz"] == ["-1.0000", "2.250", "7.000"]
    for axis in "xyz":
        given.pop(f"Cartn_{axis}")
    assert changed == given
    file = readModelFile(written(tmp_path, "b.cif", _CIF))
    text = file.write({}, removed={1}, added=[NewAtom(2, "H", np.array([1.0, 1.0, 1.0]))])
    rows = gemmi.cif.read_string(text).sole_block().find("_atom_site.", ["id", "label_atom_id", "type_symbol"])
    assert [list(row) for row in rows] == [["1", "N", "N"], ["3", "N", "N"], ["4", "CA", "C"], ["5", "H", "H"]]


@pytest.mark.parametrize("name", ["a.pdb.gz", "a.pdb.bz2", "a.pdb"])
def test_compression(tmp_path, name):
    content = compressedAs(name, _PDB)
    assert readModelFile(written(tmp_path, name, content)).write({}) == _PDB
    if name.endswith(".gz"):
        assert gzip.decompress(content).decode() == _PDB
        assert content == compressedAs(name, _PDB)  # without a time


def test_notEveryFileCanBeRepaired(tmp_path):
    for name, text, message in (
        ("a.gro", "x\n0\n", "only PDB and mmCIF"),
        ("a.cif", "data_x\n_a.b 1\n", "no atoms in _atom_site"),
        ("b.cif", "data_x\n_atom_site.id 1 2\n", "not an mmCIF file"),
        ("c.cif", _CIF.replace("2.000 3.000 1.00 12.34 A 5 1", "? 3.000 1.00 12.34 A 5 1"), "is no number"),
    ):
        with pytest.raises(InputError, match=message):
            readModelFile(written(tmp_path, name, text))
    with pytest.raises(InputError, match="No such file"):
        readModelFile(tmp_path / "missing.pdb")


def test_coordinatesOutOfTheirColumns(tmp_path):
    file = readModelFile(written(tmp_path, "a.pdb", _PDB))
    with pytest.raises(InputError, match="not where they should be"):
        file.matchRows(0, [[5.0, 5.0, 5.0]])
    with pytest.raises(InputError, match="beyond what a PDB file holds"):
        file.write({3: np.array([1e5, 0.0, 0.0])})
