"""Damaged files: one sentence that names the file and the damage, and what comes before it is not lost."""

import gzip
import os
import re
import warnings

import numpy as np
import pytest
from openmm import app, unit
from openmmchaintree import InputError, findClashes
from openmmchaintree.structures import trajectory
from openmmchaintree.structures.structure import readStructure
from scenes import GLYCINES, writeDCD, writePDB, writeXTC

_ATOMS = 582

# Of the DCD files that OpenMM writes.
_DCD_HEADER = 276
_DCD_FRAME = 3 * (4 * _ATOMS + 8)


@pytest.fixture
def frames(villin):
    """Three frames of villin: 1, 0 and 1 clashes."""
    return [villin.positions, 3 * villin.positions, villin.positions]


def damageIn(structure, trajectory=None):
    """Return the message, and the number of clashes of the frames before the damage."""
    with pytest.raises(InputError) as caught, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a header that tells of more frames
        findClashes(structure, trajectory)
    message = str(caught.value)
    assert "\n" not in message
    return message, [len(frame.clashes) for frame in caught.value.frames]


# ---- Trajectories ----


@pytest.mark.parametrize(
    ("length", "words", "clashes"),
    [
        (0, "is empty", []),
        (3, "not a DCD file, or damaged at its start", []),
        (100, "not a DCD file, or damaged at its start", []),
        (_DCD_HEADER + 100, "not a DCD file, or damaged at its start", []),
        (_DCD_HEADER + _DCD_FRAME + 1, "frame 1 (from 0) is cut off", [1]),
        (_DCD_HEADER + _DCD_FRAME + _DCD_FRAME // 3, "frame 1 (from 0) is cut off", [1]),
        (_DCD_HEADER + 3 * _DCD_FRAME - 1, "frame 2 (from 0) is cut off", [1, 0]),
    ],
)
def test_truncatedDCD(tmp_path, villin, structure, frames, length, words, clashes):
    path = writeDCD(tmp_path / "short", villin.topology, frames)
    assert path.stat().st_size == _DCD_HEADER + 3 * _DCD_FRAME
    os.truncate(path, length)
    assert damageIn(structure, path) == (f"{path}: {words}", clashes)


def test_DCDWithFewerFramesThanItsHeaderTells(tmp_path, villin, structure, frames):
    path = writeDCD(tmp_path / "fewer", villin.topology, frames)
    os.truncate(path, _DCD_HEADER + 2 * _DCD_FRAME)
    with pytest.warns(UserWarning, match="its header tells of 3 frames, but it holds 2"):
        assert len(findClashes(structure, path)) == 2


def test_DCDDamagedInTheMiddle(tmp_path, villin, structure, frames):
    path = writeDCD(tmp_path / "damaged", villin.topology, frames)
    data = bytearray(path.read_bytes())
    data[_DCD_HEADER + _DCD_FRAME : _DCD_HEADER + _DCD_FRAME + 8] = b"\xff" * 8
    path.write_bytes(data)
    assert damageIn(structure, path) == (f"{path}: frame 1 (from 0) is damaged", [1])


def test_truncatedXTC(tmp_path, villin, structure, frames):
    whole = writeXTC(tmp_path / "whole", villin.topology, frames).read_bytes()
    one = writeXTC(tmp_path / "one", villin.topology, frames[:1]).stat().st_size
    path = tmp_path / "short.xtc"
    for length, words, clashes in [
        (0, "is empty", []),
        (3, "not an XTC file, or damaged at its start", []),
        (20, "frame 0 (from 0) is damaged", []),
        (one - 1, "frame 0 (from 0) is damaged", []),
        (one + 60, "frame 1 (from 0) is damaged", [1]),
        (len(whole) - 1, "frame 2 (from 0) is damaged", [1, 0]),
    ]:
        path.write_bytes(whole[:length])
        assert damageIn(structure, path) == (f"{path}: {words}", clashes)


def test_XTCDamagedInTheMiddle(tmp_path, villin, structure, frames):
    path = writeXTC(tmp_path / "damaged", villin.topology, frames)
    one = writeXTC(tmp_path / "one", villin.topology, frames[:1]).stat().st_size
    data = bytearray(path.read_bytes())
    data[one : one + 8] = b"\xff" * 8
    path.write_bytes(data)
    assert damageIn(structure, path) == (f"{path}: frame 1 (from 0) is damaged", [1])


def test_aReaderThatCrashes(tmp_path, villin, structure, frames, monkeypatch):
    """As the C code of any reader may do: here it ends by a signal, after it has read two frames."""
    reader = tmp_path / "reader.py"
    np.save(tmp_path / "loose.npy", 3 * villin.positions)
    reader.write_text(
        "import os, pickle, signal, sys\n"
        "import numpy as np\n"
        "pickle.dump((3, 3, 1.0), sys.stdout.buffer)\n"
        "for _ in range(2):\n"
        f"    pickle.dump((np.load({str(tmp_path / 'loose.npy')!r}), None), sys.stdout.buffer)\n"
        "sys.stdout.buffer.write(b'half a pick')\n"
        "sys.stdout.flush()\n"
        "os.kill(os.getpid(), signal.SIGSEGV)\n"
    )
    monkeypatch.setattr(trajectory, "_READER", reader)
    path = writeDCD(tmp_path / "good", villin.topology, frames)
    assert damageIn(structure, path) == (f"{path}: frame 2 (from 0) is damaged so that its reader crashed", [0, 0])


def test_theReaderEndsIfTheStructureIsDamaged(tmp_path, villin, frames, monkeypatch):
    """It has started before the structure is read."""
    readers = []
    honest = trajectory.Trajectory.__init__

    def note(reader, path):
        honest(reader, path)
        readers.append(reader._process)

    monkeypatch.setattr(trajectory.Trajectory, "__init__", note)
    (tmp_path / "text.pdb").write_text("not a structure\n")
    path = writeDCD(tmp_path / "good", villin.topology, frames)
    with pytest.raises(InputError, match="text.pdb"):
        findClashes(tmp_path / "text.pdb", path)
    assert [reader.poll() is not None for reader in readers] == [True]


@pytest.mark.parametrize("name", ["text.dcd", "text.xtc", "text.trr", "text.nc", "text.h5"])
def test_noTrajectoryAtAll(tmp_path, structure, name):
    path = tmp_path / name
    path.write_text("not a trajectory\n" * 1000)
    message, clashes = damageIn(structure, path)
    assert message.startswith(f"{path}: not a") and clashes == []


def test_unknownFormat(tmp_path, structure):
    (tmp_path / "run.mdcrd").write_text("")
    message, _ = damageIn(structure, tmp_path / "run.mdcrd")
    known = ".dcd, .xtc, .trr, .nc, .ncdf, .netcdf, .h5, .hdf5"
    assert message.endswith(f"run.mdcrd: is not named as a trajectory of a known format ({known})")
    assert damageIn(structure, tmp_path / "none.dcd")[0].endswith("none.dcd: No such file or directory")


@pytest.mark.parametrize("write", [writeDCD, writeXTC])
def test_otherNumberOfAtoms(tmp_path, villin, structure, frames, write):
    topology = app.Modeller(villin.topology, villin.positions * unit.nanometer)
    topology.delete([next(topology.topology.residues())])
    count = topology.topology.getNumAtoms()
    path = write(tmp_path / "other", topology.topology, [frame[:count] for frame in frames])
    assert damageIn(structure, path) == (f"{path}: has {count} atoms, but {structure} has {_ATOMS}", [])


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_coordinateThatIsNoNumber(tmp_path, villin, structure, frames, value):
    path = writeDCD(tmp_path / "nan", villin.topology, frames)
    data = bytearray(path.read_bytes())
    place = _DCD_HEADER + _DCD_FRAME + 4 + 4 * 100  # x of particle 100, frame 1
    data[place : place + 4] = np.float32(value).tobytes()
    path.write_bytes(data)
    atom = list(villin.topology.atoms())[100]
    message, clashes = damageIn(structure, path)
    assert message.startswith(f"{path}: frame 1 (from 0): atom {atom.name} of A:{atom.residue.name} {atom.residue.id} ")
    assert message.endswith("has a coordinate that is not a finite number") and clashes == [1]


# ---- Structures ----


def models(*moves):
    lines = []
    for number, move in enumerate(moves):
        lines += [f"MODEL     {number + 1:4}", *map(move, GLYCINES), "ENDMDL"]
    return lines


def same(line):
    return line


def cut(path, text):
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    ("lines", "words", "count"),
    [
        ([*models(same), "MODEL        2", *GLYCINES[:3]], "the file ends within model 1 (from 0)", 1),
        ([*models(same, same), "MODEL        3", GLYCINES[0][:40]], "line 22 has no coordinates", 2),
        (models(same, lambda line: line.replace("1.420", "*****")), "line 14 has no coordinates", 1),
        (models(same, lambda line: line.replace("1.420", "  nan")), "model 1 (from 0): atom C of A:GLY 1 has a", 1),
        ([*models(same)[:-1]], "the file ends within model 0 (from 0)", 0),
        ([GLYCINES[0], GLYCINES[1][:50]], "line 2 has no coordinates", 0),
    ],
)
def test_damagedPDB(tmp_path, lines, words, count):
    message, clashes = damageIn(cut(tmp_path / "bad.pdb", "\n".join(lines)))
    assert message.startswith(f"{tmp_path / 'bad.pdb'}: {words}")
    assert clashes == [0] * count


def test_coordinateBeyondAll(tmp_path):
    lines = models(same, lambda line: line.replace("   1.420", "   1e300"))
    message, clashes = damageIn(writePDB(tmp_path / "far.pdb", lines))
    assert message.endswith("model 1 (from 0): atom C of A:GLY 1 has a coordinate beyond 1e+15 nm") and clashes == [0]


def test_modelsOfDifferentSize(tmp_path):
    lines = [*models(same), "MODEL        2", *GLYCINES[:-1], "ENDMDL", *models(same)]
    message, clashes = damageIn(writePDB(tmp_path / "bad.pdb", lines))
    assert message == f"{tmp_path / 'bad.pdb'}: model 1 (from 0) has 7 atoms, but model 0 has 8"
    assert clashes == [0]


def test_bondsAfterADamagedModelCount(tmp_path):
    """Two atoms that would clash were they not bonded by a CONECT record at the end of the file."""
    ligand = [
        "HETATM    9  C1  LIG B   1      50.000   0.000   0.000  1.00  0.00           C",
        "HETATM   10  C2  LIG B   1      51.500   0.000   0.000  1.00  0.00           C",
        "HETATM   11  C3  LIG B   1      50.000  50.000   0.000  1.00  0.00           C",
        "HETATM   12  C4  LIG B   1      50.000  51.500   0.000  1.00  0.00           C",
    ]
    bonds = ["CONECT    9   10", "CONECT   11   12"]
    lines = ["MODEL        1", *ligand, "ENDMDL", "MODEL        2", ligand[0][:40], "ENDMDL", *bonds]
    assert damageIn(writePDB(tmp_path / "bad.pdb", lines))[1] == [0]


def test_damagedMmCIF(tmp_path, villin):
    path = tmp_path / "bad.cif"
    with open(path, "w") as file:
        app.PDBxFile.writeFile(villin.topology, villin.positions * unit.nanometer, file)
    text = path.read_text()
    row = text.index("ATOM    100 ")
    unreadable = "not an mmCIF file that can be read ("
    for content, words in [
        (text.replace("_atom_site.label_atom_id", "_atom_site'.label_atom_id"), unreadable + "Tag _atom_site'"),
        ("data_LIG\nloop_\n_chem_comp_atom.comp_id\n_chem.atom_id\nLIG C1\n", unreadable + "Tag _chem.atom_id"),
        (
            text[:row] + re.sub(r"7 \. ", "7 'é' ", text[row:], count=1),
            "the pdbx_PDB_ins_code of an atom, 'é', is not ASCII",
        ),
        (text[: row + 30], unreadable + "string:35:0("),
        ("data_nothing\n#\n", "there are no atoms"),
        (text[:row] + re.sub(r"\.\d", ".x", text[row:], count=1), "atom "),
    ]:
        path.write_text(content)
        message, clashes = damageIn(path)
        assert message.startswith(f"{path}: {words}") and clashes == []


def test_gzip(tmp_path, structure):
    path = tmp_path / "villin.pdb.gz"
    whole = gzip.compress(structure.read_bytes())
    path.write_bytes(whole)
    (frame,) = findClashes(path)
    assert [clash[:2] for clash in frame.clashes] == [clash[:2] for clash in findClashes(structure)[0].clashes]
    assert readStructure(path).name == "villin"
    for damaged in (whole[:1000], whole[:5], whole[:1000] + b"*" * 1000, whole[:-8] + bytes(8)):
        path.write_bytes(damaged)
        message, clashes = damageIn(path)
        assert message.startswith(f"{path}: cannot be decompressed (") and clashes == []
