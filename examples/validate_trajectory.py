"""Check a trajectory: the clashes of each frame and their residues, and changes of bond lengths.

    python validate_trajectory.py [STRUCTURE TRAJECTORY]

Without files it first makes dynamics.pdb and dynamics.dcd: 2 ps of molecular dynamics in vacuum of the villin headpiece
that comes with OpenMM.
"""

import collections
import sys
from pathlib import Path

import mdtraj
import numpy as np
import openmm
import openmm.app as app
import openmmchaintree as chaintree
from openmm import unit


def runDynamics(structure: str, trajectory: str) -> None:
    """Write a structure and its trajectory."""
    pdb = app.PDBFile(str(Path(app.__file__).parent / "data" / "test.pdb"))
    protein = app.Modeller(pdb.topology, pdb.positions)
    protein.delete([residue for residue in pdb.topology.residues() if residue.name in ("HOH", "Cl")])
    with open(structure, "w") as file:
        app.PDBFile.writeFile(protein.topology, protein.positions, file)
    system = app.ForceField("amber14-all.xml").createSystem(protein.topology)
    integrator = openmm.LangevinMiddleIntegrator(300 * unit.kelvin, 1 / unit.picosecond, 1 * unit.femtosecond)
    integrator.setRandomNumberSeed(1)
    simulation = app.Simulation(protein.topology, system, integrator)
    simulation.context.setPositions(protein.positions)
    simulation.reporters.append(app.DCDReporter(trajectory, 100))
    simulation.step(2000)


if len(sys.argv) > 2:
    structure, trajectory = sys.argv[1:3]
else:
    structure, trajectory = "dynamics.pdb", "dynamics.dcd"
    runDynamics(structure, trajectory)

# Clashes: atoms more than three bonds apart that overlap by more than usual in crystal structures.
(reference,) = chaintree.findClashes(structure)
frames = chaintree.findClashes(structure, trajectory)
counts = [frame.clashesPer1000Atoms for frame in frames]
print(f"{structure}: {reference.clashesPer1000Atoms:.1f} clashes in 1,000 atoms")
print(f"{len(frames)} frames: {min(counts):.1f} to {max(counts):.1f}, median {np.median(counts):.1f}")

# Residues: pairs that clash in most frames, and their largest overlap.
overlaps = collections.defaultdict(list)
for frame in frames:
    worst: dict[tuple[str, str], float] = {}
    for clash in frame.clashes:
        pair = clash.atom1.describeResidue(), clash.atom2.describeResidue()
        worst[pair] = max(clash.overlap, worst.get(pair, 0))
    for pair, overlap in worst.items():
        overlaps[pair].append(overlap)
for pair, ofPair in sorted(overlaps.items(), key=lambda item: -len(item[1]))[:3]:
    print(f"{pair[0]} and {pair[1]}: in {len(ofPair)} frames, by up to {max(ofPair):.3f} nm")

# Bonds: the range of each length along the trajectory.
topology = mdtraj.load(structure).topology
bonds = [(bond.atom1.index, bond.atom2.index) for bond in topology.bonds]
lengths = mdtraj.compute_distances(mdtraj.load(trajectory, top=structure), bonds, periodic=False)
changes = np.ptp(lengths, axis=0)
print(f"{len(bonds)} bonds: lengths change by {changes.mean():.4f} nm in the mean, {changes.max():.4f} at most")
