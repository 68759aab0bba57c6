"""Sample torsions of a protein in AMBER14 with implicit solvent at 300 K, with the Metropolis criterion.

    python sample_protein.py [STEPS]

Samples the villin headpiece that comes with OpenMM; a step makes 400 trials. Writes sampled.pdb and sampled.dcd.
"""

import sys
from pathlib import Path

import openmm.app as app
import openmmchaintree as chaintree
from openmm import unit

steps = int(sys.argv[1]) if len(sys.argv) > 1 else 20

# Keep only the protein, without water and ions.
pdb = app.PDBFile(str(Path(app.__file__).parent / "data" / "test.pdb"))
protein = app.Modeller(pdb.topology, pdb.positions)
protein.delete([residue for residue in pdb.topology.residues() if residue.name in ("HOH", "Cl")])

system = app.ForceField("amber14-all.xml", "implicit/gbn2.xml").createSystem(protein.topology)
system.addForce(chaintree.createStericExclusionForce(protein.topology, protein.positions))

# A backbone torsion moves half of the protein, so its changes are small; side chains may change by any angle.
backbone: list[int] = []
sideChains: list[int] = []
for number, torsion in enumerate(chaintree.findTorsions(protein.topology, protein.positions).torsions):
    (backbone if torsion.kind in ("phi", "psi") else sideChains).append(number)
integrator = chaintree.TorsionMonteCarloIntegrator(300 * unit.kelvin)
integrator.addTorsionMove(1.0, 1 * unit.degree, backbone)
integrator.addTorsionMove(1.0, 10 * unit.degree, sideChains)
integrator.addTorsionMove(0.5, 180 * unit.degree, sideChains)
integrator.setTrialsPerStep(400)

simulation = app.Simulation(protein.topology, system, integrator)
simulation.context.setPositions(protein.positions)
print(integrator.getEnergyPlan(simulation.context))
simulation.reporters.append(app.PDBReporter("sampled.pdb", steps))  # the last conformation
simulation.reporters.append(app.DCDReporter("sampled.dcd", 1))
columns = {"step": True, "potentialEnergy": True, "remainingTime": True, "totalSteps": steps}
simulation.reporters.append(app.StateDataReporter(sys.stdout, 10, **columns))
simulation.step(steps)

for number, name in enumerate(("backbone", "side chains", "rotamers")):
    statistics = integrator.getMoveStatistics(number)
    print(
        f"{name}: {statistics.attempted} trials, {statistics.clashed} clashed, "
        f"{statistics.rejectedByEnergy} rejected by energy, {statistics.accepted} accepted"
    )
for stage in integrator.getStageStatistics():
    print(f"{stage.stage}: computed for {stage.computed} trials, rejected {stage.refused}")
outer = integrator.getOuterStatistics()
print(f"outer tests: {outer.accepted} of {outer.attempted} kept their trials, {outer.trialsTakenBack} were undone")
