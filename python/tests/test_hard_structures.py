"""Files that once broke something: nothing that is bonded at the start is parted, whatever found the bonds."""

import gemmi
import numpy as np
import pytest
from openmmchaintree.command.plan import Choice
from openmmchaintree.command.sampling import Sampling
from openmmchaintree.structures.structure import readStructure
from scenes import realStructurePath
from scipy.spatial import cKDTree

_FILES = [
    "hard/1A8O.cif.gz", "hard/1igy.cif.gz", "hard/1igy.pdb.gz", "hard/5PTI.cif.gz", "hard/3JQH.cif.gz",
    "hard/2n0n_M1.pdb.gz", "hard/1gid.cif.gz", "hard/5ugo.pdb.gz", "hard/adk_oplsaa.pdb.gz", "hard/edge_altloc.cif",
    "4hhb.pdb", "1htb.pdb", "6msm.pdb",
]  # fmt: skip


def pairsAtCovalentDistance(structure):
    """Found without what finds bonds: all pairs of atoms nearer than 1.15 times the sum of their covalent radii."""
    radii = 0.1 * np.array([gemmi.Element(atom.element.symbol).covalent_r for atom in structure.topology.atoms()])
    pairs = cKDTree(structure.positions).query_pairs(0.3, output_type="ndarray")
    distances = np.linalg.norm(structure.positions[pairs[:, 0]] - structure.positions[pairs[:, 1]], axis=1)
    return pairs[distances < 1.15 * radii[pairs].sum(axis=1)]


@pytest.mark.parametrize("name", _FILES)
def test_bondedAtomsStayTogether(name):
    structure = readStructure(realStructurePath(name))
    pairs = pairsAtCovalentDistance(structure)
    assert len(pairs) >= structure.topology.getNumAtoms() * 0.9
    sampling = Sampling(structure, 1, Choice(rigidBodies=True))
    sampling.integrator.setTrialsPerStep(500)
    sampling.integrator.step(1)
    last = sampling.positions()
    assert np.abs(last - structure.positions).max() > 0.1

    def lengths(positions):
        return np.linalg.norm(positions[pairs[:, 0]] - positions[pairs[:, 1]], axis=1)

    changes = np.abs(lengths(last) - lengths(structure.positions))
    names = [f"{atom.residue.name} {atom.residue.id} {atom.name}" for atom in structure.topology.atoms()]
    assert changes.max() < 1e-9, [names[atom] for atom in pairs[changes.argmax()]]
