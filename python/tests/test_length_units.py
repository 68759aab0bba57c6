"""Positions in a wrong unit, and models with only Cα atoms, are recognized."""

import numpy as np
import pytest
from openmm import app, unit
from openmmchaintree import InputError, createStericExclusionForce, findTorsions
from openmmchaintree.command.sampling import Sampling
from openmmchaintree.structures.structure import Structure
from scenes import GLYCINES, peptide, writePDB


@pytest.mark.parametrize("function", [createStericExclusionForce, findTorsions])
def test_angstroms(villin, function):
    with pytest.raises(ValueError, match=r"ten times as long as bonds are: .*positions \* unit.angstrom"):
        function(villin.topology, 10 * villin.positions)
    function(villin.topology, 10 * villin.positions * unit.angstrom)


@pytest.mark.parametrize("function", [createStericExclusionForce, findTorsions])
def test_tenthsOfNanometers(villin, function):
    with pytest.raises(ValueError, match="a tenth of what bonds are: positions must be in nm"):
        function(villin.topology, 0.1 * villin.positions)


def test_coarseBondsHaveAnyLength():
    topology = app.Topology()
    residue = topology.addResidue("BEA", topology.addChain())
    beads = [topology.addAtom(f"B{i}", None, residue) for i in range(3)]
    topology.addBond(*beads[:2])
    topology.addBond(*beads[1:])
    createStericExclusionForce(topology, [[0, 0, 0], [1.5, 0, 0], [3, 0, 0]], radii=np.full(3, 0.5))


@pytest.mark.parametrize("command", ["sample", "clashes"])
def test_fileInNanometers(runCommandHere, tmp_path, command):
    def divide(line):
        return line[:30] + "".join(f"{float(line[i : i + 8]) / 10:8.3f}" for i in (30, 38, 46)) + line[54:]

    writePDB(tmp_path / "nm.pdb", map(divide, GLYCINES))
    result = runCommandHere(command, "nm.pdb")
    assert result.returncode == 2
    assert result.stderr.startswith("openmm-chaintree: nm.pdb: ") and len(result.stderr.splitlines()) == 1
    assert "coordinates in PDB and mmCIF files in ångström" in result.stderr


def alphaCarbons(*bare, count=4):
    """A peptide of glycines; the residues with these numbers have only a Cα atom."""
    topology = app.Topology()
    chain = topology.addChain("A")
    for number in range(count):
        residue = topology.addResidue("GLY", chain)
        for name in ["CA"] if number in bare else ["N", "CA", "C", "O"]:
            topology.addAtom(name, app.Element.getBySymbol(name[0]), residue)
    topology.createStandardBonds()
    return topology


def test_alphaCarbonModel(recwarn):
    topology = alphaCarbons(0, 1, 2, 3)
    createStericExclusionForce(topology, 0.38 * np.arange(12).reshape(4, 3))
    assert [str(warning.message) for warning in recwarn] == [
        "there is no torsion of a protein, because the model has only Cα atoms"
    ]
    with pytest.raises(InputError, match="because the model has only Cα atoms$"):
        Sampling(Structure("model", topology, 0.38 * np.arange(12.0).reshape(4, 3)), 1)


def test_someAlphaCarbons(recwarn):
    createStericExclusionForce(alphaCarbons(3))
    assert [str(warning.message) for warning in recwarn] == [
        "residues without torsions, because there are only their Cα atoms (1): A:GLY 4"
    ]


def test_wholeModelsAreNot(recwarn):
    createStericExclusionForce(peptide("GLY", "ALA"))
    assert len(recwarn) == 0
