"""What README.md shows has to work."""

import re
from pathlib import Path

import openmm.app
from openmm import unit
from openmmchaintree.structure import readStructure

README = Path(__file__).parents[1] / "README.md"


def test_theExampleInPythonRuns(tmp_path, monkeypatch):
    (example,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    villin = readStructure()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("OPENMM_DEFAULT_PLATFORM", "CPU")  # the quickest that every machine has
    with open("protein.pdb", "w") as file:
        openmm.app.PDBFile.writeFile(villin.topology, villin.positions * unit.nanometer, file)
    variables = {}
    exec(example, variables)

    assert Path("protein.dcd").stat().st_size > 0
    attempted, clashed, rejected, accepted = variables["integrator"].getMoveStatistics(0)
    assert attempted == 10000
    assert min(clashed, rejected, accepted) > 0
