"""Write your own Monte Carlo: the force proposes and tests trials, and the program accepts or rejects them.

    python own_monte_carlo.py [TRIALS]

Pulls the ends of the villin headpiece that comes with OpenMM, as hard spheres, to a distance of 3 nm with a spring that
OpenMM does not know.
"""

import math
import random
import sys
from pathlib import Path

import numpy as np
import openmm
import openmm.app as app
import openmmchaintree as chaintree
from openmm import unit

trials = int(sys.argv[1]) if len(sys.argv) > 1 else 20000
generator = random.Random(1)

pdb = app.PDBFile(str(Path(app.__file__).parent / "data" / "test.pdb"))
protein = app.Modeller(pdb.topology, pdb.positions)
protein.delete([residue for residue in pdb.topology.residues() if residue.name in ("HOH", "Cl")])

force = chaintree.createStericExclusionForce(protein.topology, protein.positions)
system = openmm.System()
for atom in protein.topology.atoms():
    system.addParticle(atom.element.mass)
system.addForce(force)
# A Context needs an integrator, but this one never makes a step.
context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))
context.setPositions(protein.positions)

alphaCarbons = [atom.index for atom in protein.topology.atoms() if atom.name == "CA"]
first, last = alphaCarbons[0], alphaCarbons[-1]


def lengthOf(positions: np.ndarray) -> float:
    """Return the distance between the ends in nm."""
    return math.dist(positions[last], positions[first])  # the last bit of NumPy's norm depends on the machine


def energyOf(positions: np.ndarray) -> float:
    """Return the energy of the spring in units of kT."""
    return 0.5 * 20.0 * (lengthOf(positions) - 3.0) ** 2


def presentPositions() -> np.ndarray:
    positions: np.ndarray = context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    return positions


print(f"start: the ends are {lengthOf(presentPositions()):.2f} nm apart")
energy = energyOf(presentPositions())
clashed = accepted = 0
for _ in range(trials):
    torsion = generator.randrange(force.getNumTorsions())
    if not force.proposeTorsions(context, [torsion], [generator.uniform(-0.1, 0.1)]):
        clashed += 1
        continue
    proposed = energyOf(force.getProposedPositions(context))
    if proposed <= energy or generator.random() < math.exp(energy - proposed):
        force.acceptProposal(context)
        energy = proposed
        accepted += 1

print(f"end: the ends are {lengthOf(presentPositions()):.2f} nm apart")
print(f"{trials} trials, {clashed} clashed, {accepted} accepted")
print(f"clashes now: {len(force.getClashes(context)[0])}")
