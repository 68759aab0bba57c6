"""Small molecules in AMBER14 with OBC2, all atoms of which can move: for comparisons with dynamics."""

import random
from pathlib import Path

import numpy as np
import openmm
import openmm.app as app
from openmm import unit
from peptide import cutPeptide

FORCE_FIELD = ("amber14-all.xml", "implicit/obc2.xml")
OFFSET = 0.009  # nm, from a particle's Born radius to the radius that CustomGBForce holds
DIELECTRICS = 1, 78.5

# Residues of the villin headpiece, counted from 0, how many, and whether they become alanine.
PEPTIDES = {
    "alanine": (7, 1, None),
    "glycine": (10, 1, None),
    "valine": (8, 1, None),
    "proline": (20, 1, None),
    "trialanine": (12, 3, "ALA"),
}
NAMES = (*PEPTIDES, "dinucleotide")

# The atoms of torsions, of the residue itself, the one before it (-) and after it (+).
TORSIONS = (
    ("phi", "-C", "N", "CA", "C"),
    ("psi", "N", "CA", "C", "+N"),
    ("chi1", "N", "CA", "CB", "CG"),
    ("chi1", "N", "CA", "CB", "CG1"),
    ("alpha", "-O3'", "P", "O5'", "C5'"),
    ("beta", "P", "O5'", "C5'", "C4'"),
    ("gamma", "O5'", "C5'", "C4'", "C3'"),
    ("delta", "C5'", "C4'", "C3'", "O3'"),
    ("epsilon", "C4'", "C3'", "O3'", "+P"),
    ("zeta", "C3'", "O3'", "+P", "+O5'"),
    ("chi", "O4'", "C1'", "N9", "C4"),
)


def makeMolecule(name):
    """Return the Topology, the System, without constraints, and positions (nm) of one of NAMES."""
    if name == "dinucleotide":
        # ApA, from two nucleotides of the DNA 1BNA with an O2' each, after a local minimization in FORCE_FIELD
        pdb = app.PDBFile(str(Path(__file__).with_name("dinucleotide.pdb")))
        topology, positions = pdb.topology, np.array(pdb.positions.value_in_unit(unit.nanometer))
    else:
        random.seed(1)  # hydrogens are added at random places, and then relaxed
        topology, positions = cutPeptide(*PEPTIDES[name])
    system = app.ForceField(*FORCE_FIELD).createSystem(topology, constraints=None, removeCMMotion=False)
    _replaceSolvent(system)
    for group, force in enumerate(system.getForces()):
        force.setForceGroup(group)
    return topology, system, positions


def _replaceSolvent(system):
    """Replace OBC2 as a CustomGBForce by a GBSAOBCForce: on a CPU, OpenMM evaluates it 30 times as fast."""
    (index,) = [i for i, force in enumerate(system.getForces()) if isinstance(force, openmm.CustomGBForce)]
    custom, solvent = system.getForce(index), openmm.GBSAOBCForce()
    solvent.setSoluteDielectric(DIELECTRICS[0])
    solvent.setSolventDielectric(DIELECTRICS[1])
    for particle in range(custom.getNumParticles()):
        charge, radius, scaledRadius = custom.getParticleParameters(particle)
        solvent.addParticle(charge, radius + OFFSET, scaledRadius / radius)
    system.removeForce(index)
    system.addForce(solvent)


def namedTorsions(topology):
    """Return the torsions of TORSIONS that a Topology has: {(number of the residue, name): four particles}."""
    residues = list(topology.residues())
    atoms = [{atom.name: atom.index for atom in residue.atoms()} for residue in residues]
    found = {}
    for number in range(len(residues)):
        for name, *names in TORSIONS:
            particles = [_find(atoms, number, atom) for atom in names]
            if None not in particles:
                found[number, name] = tuple(particles)
    return found


def _find(atoms, number, name):
    number += {"-": -1, "+": 1}.get(name[0], 0)
    return atoms[number].get(name.lstrip("-+")) if 0 <= number < len(atoms) else None
