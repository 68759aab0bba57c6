"""Monitor the clashes of a molecular dynamics simulation, and end it if two atoms overlap too much.

    python watch_clashes.py [STEPS]

Simulates the villin headpiece that comes with OpenMM in AMBER14 with implicit solvent at 300 K. Writes clashes.csv.
"""

import sys
from pathlib import Path

import openmm
import openmm.app as app
import openmmchaintree as chaintree
from openmm import unit

steps = int(sys.argv[1]) if len(sys.argv) > 1 else 1000

pdb = app.PDBFile(str(Path(app.__file__).parent / "data" / "test.pdb"))
protein = app.Modeller(pdb.topology, pdb.positions)
protein.delete([residue for residue in pdb.topology.residues() if residue.name in ("HOH", "Cl")])

# The System needs no force of this package: the reporter creates its own.
forceField = app.ForceField("amber14-all.xml", "implicit/gbn2.xml")
system = forceField.createSystem(protein.topology, constraints=app.HBonds)
integrator = openmm.LangevinMiddleIntegrator(300 * unit.kelvin, 1 / unit.picosecond, 2 * unit.femtoseconds)
simulation = app.Simulation(protein.topology, system, integrator)
simulation.context.setPositions(protein.positions)
simulation.context.setVelocitiesToTemperature(300 * unit.kelvin)

simulation.reporters.append(chaintree.ClashReporter("clashes.csv", 50, maxOverlap=0.15 * unit.nanometer))
try:
    simulation.step(steps)
except chaintree.ClashError as error:
    sys.exit(f"the simulation failed at {error}")
print(Path("clashes.csv").read_text(), end="")
