"""The time of a trial in a periodic box: native, by OpenMM's CPU platform, and by Faunus (pip install faunus).

    python faunus.py [--chains 1] [--box 20 20 20] [--trials 20000]

The chains are those of slab.py. Each program makes pivots, and translations of chains if there are several, from the
same positions. The script prints their energy, which must agree, the processor time of a trial, of one thread, and the
share of accepted pivots.
"""

import argparse
import os
import re
import resource
import shutil
import subprocess
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np
import openmm
from openmmchaintree import TorsionMonteCarloIntegrator, createCalvadosSystem, createStericExclusionForce
from slab import A1_LCD, TEMPERATURE, drawShapes, place

_SALT = 0.15  # mol/l
_PIVOT, _SHIFT = 0.4, 0.3  # rad, nm: the largest of a trial
_FEWER = {"OpenMM's CPU platform": 200, "Faunus": 20}  # by which trials are divided
_COULOMB = 138.935458  # kJ nm/mol


def makeSystem(chains, box):
    """Return the System, and the permittivity of water. Its charges have no shift at the cutoff: Faunus has none."""
    topology, system, _ = createCalvadosSystem([A1_LCD] * chains, TEMPERATURE, ionicStrength=_SALT, box=box)
    yukawa = system.getForce(1)
    coulomb = float(re.match(r"q\*([^*]+)\*", yukawa.getEnergyFunction())[1])
    yukawa.setEnergyFunction(re.sub(r"/r-[^)]+\)", "/r)", yukawa.getEnergyFunction()))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that bonds are rigid
        system.addForce(createStericExclusionForce(topology, None, system=system))
    return system, _COULOMB / coulomb


def makeContext(system, positions, chains, platform="Reference"):
    integrator = TorsionMonteCarloIntegrator(TEMPERATURE)
    integrator.setRandomNumberSeed(1)
    integrator.setNativeEnergies(platform == "Reference")
    integrator.addPivotMove(1, _PIVOT)
    if chains > 1:
        integrator.addRigidBodyMove(1, _SHIFT, 0)
    settings = {"Threads": "1"} if platform == "CPU" else {}
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName(platform), settings)
    context.setPositions(positions)
    return context, integrator


def timeOurs(system, positions, chains, trials, platform):
    """Return the energy at the start, µs a trial, and the share of accepted pivots."""
    context, integrator = makeContext(system, positions, chains, platform)
    energy = integrator.getPotentialEnergy(context)
    integrator.setTrialsPerStep(1)
    integrator.step(1)  # which prepares the energies
    integrator.resetMoveStatistics()
    integrator.setTrialsPerStep(trials)
    start = time.process_time()
    integrator.step(1)
    spent = time.process_time() - start
    moves = integrator.getMoveStatistics(0)
    return energy, 1e6 * spent / trials, moves.accepted / max(1, moves.attempted)


def describe(system, positions, chains, box, permittivity, trials):
    """Return Faunus' input. Names of beads end with the charge, since the first and last residue have another one."""
    atoms, beads = {}, []
    for index, letter in enumerate(A1_LCD):
        sigma, hydrophobicity = system.getForce(0).getParticleParameters(index)
        (charge,) = system.getForce(1).getParticleParameters(index)
        beads.append(f"{letter}{charge + 1}")
        atoms[beads[-1]] = (
            f"{{name: {beads[-1]}, mass: 1, charge: {charge}, sigma: {10 * sigma}, epsilon: {0.2 * 4.184}, "
            f"hydrophobicity: !Lambda {hydrophobicity}}}"
        )
    bonds = ", ".join(f"{{index: [{bead}, {bead + 1}]}}" for bead in range(len(beads) - 1))
    moves = f"!PivotMove {{molecule: polymer, max_angle: {_PIVOT}, weight: 1}}"
    if chains > 1:
        moves += f", !TranslateMolecule {{molecule: polymer, max_displacement: {10 * _SHIFT}, weight: 1}}"
    inBox = 10 * (positions - box * np.rint(positions / box))
    return f"""
atoms: [{", ".join(atoms.values())}]
molecules: [{{name: polymer, atoms: [{", ".join(beads)}], excluded_neighbours: 1, bonds: [{bonds}]}}]
system:
  cell: !Cuboid {(10.0 * np.array(box)).tolist()}
  medium: {{permittivity: !Fixed {permittivity}, temperature: {TEMPERATURE}, salt: [!NaCl, {_SALT}]}}
  blocks: [{{molecule: polymer, N: {chains}, insert: !Manual {inBox.round(6).tolist()}}}]
  energy:
    - !Nonbonded
      default: [!AshbaughHatch {{mixing: arithmetic, cutoff: 20.0}}, !Coulomb {{cutoff: 40.0}}]
      cutoff: 40.0
analysis: []
propagate:
  seed: !Fixed 1
  criterion: MetropolisHastings
  steps: 1
  collections: [!Stochastic {{cycles: {trials}, moves: [{moves}]}}]
"""


def runFaunus(text):
    """Return the energy at the start, processor time (s), and the share of accepted pivots."""
    with tempfile.TemporaryDirectory() as folder:
        given, output = Path(folder) / "in.yaml", Path(folder) / "out.yaml"
        given.write_text(text, encoding="utf-8")
        command = ["faunus", "--output", str(output), "run", "--input", str(given)]
        before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
        environment = {**os.environ, "RAYON_NUM_THREADS": "1"}
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
        spent = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
        written = output.read_text(encoding="utf-8").split("propagate:")[-1]
    accepted = re.search(r"acceptance_ratio: (\S+)", written)
    return (
        float(re.search(r"Initial energy = (\S+)", done.stderr)[1]),
        spent,
        float(accepted[1]) if accepted else np.nan,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("--chains", type=int, default=1)
    parser.add_argument("--box", type=float, nargs=3, default=(20, 20, 20), help="nm")
    parser.add_argument("--trials", type=int, default=20000, help="native ones; the others make fewer")
    parser.add_argument("--relaxation", type=int, default=5000, help="trials for each chain before")
    options = parser.parse_args()
    chains, box = options.chains, options.box
    system, permittivity = makeSystem(chains, box)
    context, integrator = makeContext(system, place(drawShapes(A1_LCD, chains, 1), box, False), chains)
    integrator.setTrialsPerStep(options.relaxation * chains)
    integrator.step(1)
    positions = context.getState(positions=True).getPositions(asNumpy=True)._value
    print(f"{len(positions)} beads; kJ/mol, µs for a trial, accepted pivots")
    results = {}
    for name, platform in (("native", "Reference"), ("OpenMM's CPU platform", "CPU")):
        trials = max(1, options.trials // _FEWER.get(name, 1))
        results[name] = timeOurs(system, positions, chains, trials, platform)
    if shutil.which("faunus"):
        trials = max(1, options.trials // _FEWER["Faunus"])
        inputs = [describe(system, positions, chains, box, permittivity, count) for count in (1, trials + 1)]
        runs = [runFaunus(each) for each in inputs]
        results["Faunus"] = (runs[0][0], 1e6 * (runs[1][1] - runs[0][1]) / trials, runs[1][2])
    for name, (energy, microseconds, accepted) in results.items():
        print(f"{name:<22} {energy:12.2f} {microseconds:12.1f} {accepted:6.3f}", flush=True)


if __name__ == "__main__":
    main()
