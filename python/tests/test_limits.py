"""What is small but stands for gigabytes: refused in one line, at a limit that one can raise."""

import bz2
import gzip

import msgpack
import numpy as np
import pytest
from commands import assertRefused, filesIn
from scenes import GLYCINES, writePDB

BYTES, INTS = {"kind": "ByteArray", "type": 4}, {"kind": "ByteArray", "type": 3}
RAISES = "the environment variable CHAINTREE_MAX_MEGABYTES raises this limit"


@pytest.fixture
def oneMegabyte(monkeypatch):
    monkeypatch.setenv("CHAINTREE_MAX_MEGABYTES", "1")


def ints(*values):
    return np.array(values, "<i4").tobytes()


def strings(text, offsets, data, encoding):
    return {
        "data": data,
        "encoding": [
            {
                "kind": "StringArray",
                "dataEncoding": encoding,
                "stringData": text,
                "offsetEncoding": [INTS],
                "offsets": ints(*offsets),
            }
        ],
    }


def bcif(data, mask=None):
    columns = [{"name": name, "data": data, "mask": mask} for name in ("id", "Cartn_x", "label_atom_id")]
    category = {"name": "_atom_site", "rowCount": 3, "columns": columns}
    return msgpack.packb({"dataBlocks": [{"header": "X", "categories": [category]}]})


def runs(count, **size):
    return [{"kind": "RunLength", "srcType": 3, **size}, INTS]


COUNT = 2 * 10**9
THREE = {"data": bytes(3), "encoding": [BYTES]}
LARGE = {
    "a.pdb": b"ATOM  \n" * 200000,
    "a.pdb.gz": gzip.compress(b"REMARK\n" * 200000),
    "twice.gz": 2 * gzip.compress(b"REMARK\n" * 100000),
    "a.pdb.bz2": bz2.compress(b"REMARK\n" * 200000),
    "runs.bcif": bcif({"data": ints(1, COUNT), "encoding": runs(COUNT, srcSize=COUNT)}),
    "mask.bcif": bcif(THREE, {"data": ints(1, COUNT), "encoding": runs(COUNT, srcSize=COUNT)}),
    "packed.bcif": bcif(
        {"data": b"\1", "encoding": [{"kind": "IntegerPacking", "byteCount": 1, "srcSize": COUNT}, BYTES]}
    ),
    "strings.bcif": bcif(strings("CA", (0, 2), ints(0, COUNT), runs(COUNT, srcSize=COUNT))),
    "long.bcif": bcif(strings("C" * 30000, (0, *30 * [30000]), ints(*range(30)), [INTS])),
    "cells.bcif": bcif({"data": ints(1, 6000), "encoding": runs(6000, srcSize=6000)}),
    "tree.bcif.gz": gzip.compress(b"\x81\xaadataBlocks\xdc\x07\xd0" + (b"\xdc\x00\x14" + 20 * b"\x90") * 2000),
}


@pytest.mark.parametrize("name", LARGE)
def test_largeFiles(runCommandHere, tmp_path, oneMegabyte, name):
    (tmp_path / name).write_bytes(LARGE[name])
    result = runCommandHere("clashes", name)
    assertRefused(result, tmp_path, [name], f"{name}: h", " more than 1 MB; " + RAISES)
    assert "(" not in result.stderr


@pytest.mark.parametrize(
    "column",
    [
        {"data": ints(1, COUNT), "encoding": runs(COUNT)},
        strings("CA", (0, 2, 0, 2), ints(0), [INTS]),
        {"data": ints(0), "encoding": [{"kind": "Delta"}, *strings("CA", (0, 2), ints(0), [INTS])["encoding"]]},
    ],
)
def test_noSize(runCommandHere, tmp_path, column):
    (tmp_path / "a.bcif").write_bytes(bcif(column))
    assertRefused(runCommandHere("clashes", "a.bcif"), tmp_path, ["a.bcif"], "a.bcif: not a BinaryCIF file that can be")


def test_theLimitIsRaised(runCommandHere, tmp_path, monkeypatch):
    writePDB(tmp_path / "run.pdb", [*20000 * ["REMARK" + 60 * " "], *GLYCINES])
    monkeypatch.setenv("CHAINTREE_MAX_MEGABYTES", "1")
    assert runCommandHere("clashes", "run.pdb").returncode == 2
    monkeypatch.setenv("CHAINTREE_MAX_MEGABYTES", "2")
    assert runCommandHere("clashes", "run.pdb").returncode == 0
    for value in ("0", "many", ""):
        monkeypatch.setenv("CHAINTREE_MAX_MEGABYTES", value)
        words = f"CHAINTREE_MAX_MEGABYTES={value}: is not a whole number above 0"
        assertRefused(runCommandHere("clashes", "run.pdb"), tmp_path, filesIn(tmp_path), words)
