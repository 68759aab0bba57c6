"""What README.md shows has to work."""

import re
from pathlib import Path

import openmm.app
from openmm import unit
from openmmchaintree.structure import readStructure

README = Path(__file__).parents[1] / "README.md"


def test_theExampleInPythonRuns(tmp_path, monkeypatch):
    (example,) = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)
    # As it is written, it takes minutes.
    short, changes = re.subn(r"simulation\.step\(\d+\)", "simulation.step(2)", example)
    assert changes == 1

    villin = readStructure()
    monkeypatch.chdir(tmp_path)
    with open("protein.pdb", "w") as file:
        openmm.app.PDBFile.writeFile(villin.topology, villin.positions * unit.nanometer, file)
    variables = {}
    exec(short, variables)

    assert Path("protein.dcd").stat().st_size > 0
    attempted, clashed, rejected, accepted = variables["integrator"].getMoveStatistics(0)
    assert attempted == 200
    assert min(clashed, rejected, accepted) > 0
