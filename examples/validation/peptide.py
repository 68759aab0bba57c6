"""A small peptide for tests of sampling: ASP-PHE-LYS-ALA with caps, of the villin headpiece that comes with OpenMM."""

from pathlib import Path

import numpy as np
import openmm.app as app
from openmm import unit

FORCE_FIELD = ("amber14-all.xml", "implicit/gbn2.xml")
MUTATED = {name: name for name in ("N", "CA", "C", "O", "CB")}  # the heavy atoms of alanine


def cutPeptide(first=4, count=4, mutant=None):
    """Return residues of the villin headpiece, counted from 0, with caps: topology and positions (nm).

    `mutant` is "ALA", or None: with it, all residues between the caps are alanine.
    """
    pdb = app.PDBFile(str(Path(app.__file__).parent / "data" / "test.pdb"))
    places = np.array(pdb.positions.value_in_unit(unit.nanometer))
    topology, kept = app.Topology(), []
    chain = topology.addChain()
    caps = {0: ("ACE", {"CA": "CH3", "C": "C", "O": "O"}), count + 1: ("NME", {"N": "N", "CA": "C"})}
    for index, old in enumerate(list(pdb.topology.residues())[first - 1 : first + count + 1]):
        name, names = caps.get(index, (mutant or old.name, MUTATED if mutant else None))
        new = topology.addResidue(name, chain)
        for atom in old.atoms():
            if names is None or atom.name in names:
                topology.addAtom(atom.name if names is None else names[atom.name], atom.element, new)
                kept.append(places[atom.index])
    topology.createStandardBonds()
    modeller = app.Modeller(topology, np.array(kept) * unit.nanometer)
    modeller.addHydrogens(app.ForceField(*FORCE_FIELD))
    return modeller.topology, np.array(modeller.positions.value_in_unit(unit.nanometer))
