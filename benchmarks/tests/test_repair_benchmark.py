"""The benchmark repair.py. No test looks at how long anything takes."""

import csv

import repair
from repairmodels import asPDB, villinPacked


def test_aModel(runHere, tmp_path):
    (tmp_path / "villin.pdb").write_text(asPDB(*villinPacked()))
    outputs = ("--csv", "a.csv", "--markdown", "a.md")
    result = runHere(repair.main, "villin.pdb", "--minimizers", "vacuum", "--mend-bonds", *outputs)
    assert result.returncode == 0, result.stderr
    rows = list(csv.DictReader((tmp_path / "a.csv").open()))
    assert [row["method"] for row in rows] == [repair.REPAIR, repair.MENDED, "vacuum"]
    assert all(float(row["after"]) < float(row["before"]) and not row["failure"] for row in rows)
    assert float(rows[0]["largestBondChange"]) < 1e-9 < float(rows[2]["largestBondChange"])
    assert len((tmp_path / "a.md").read_text().splitlines()) == 5
