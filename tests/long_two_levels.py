"""Two levels for longer than tests may take: is the ensemble that of plain sampling, and that of other stand-ins?

    python tests/long_two_levels.py SCENE WAY=SECONDS WAY=SECONDS ...

Samples a scene so many seconds in each way, and compares each way with the last one. Reasonable are peptide two=60
smaller=60 other=60 plain=600, and villin two=60 larger=60 plain=900. Absurd stand-ins hold chains fast: a ring that
does not flip keeps the sign that it began with, and p-values say so.

SCENE  peptide: a capped ASP-PHE-LYS-ALA, all of whose torsions move; hot peptide: the same at 900 K; villin: the
       headpiece, of which ten torsions of side chains move; side chains: the headpiece, of which all of these do
WAY    two: two levels, as they are by default; larger: with cutoffs of 1.2 nm; smaller: with cutoffs of 0.5 nm; absurd:
       with cutoffs of 0.3 nm; other: with constants of another conformation, and cutoffs of 0.5 nm; plain: OpenMM
       evaluates all Forces at each trial, on its CPU platform

Prints the means of U (kJ/mol), of the radius of gyration (nm) and of cosines of ten torsions, and for each way p-values
by means of blocks. Exit status 1 if one of them is below SIGNIFICANCE divided by their number. AMBER14 and GBn2, 400 K.
"""

import sys
import time

import numpy as np
import openmm.app as app
from openmm import unit
from openmmchaintree import createStericExclusionForce
from realsystems import Run, makeSystem, readSystem
from scipy.stats import t
from test_native_sampling import SIGNIFICANCE, TEMPERATURE

FORCE_FIELD = ("amber14-all.xml", "implicit/gbn2.xml")
HOT = 900  # K
COLUMNS = 10  # torsions that are looked at
CHAINS = 2
BLOCKS = 12  # a chain

# Born cutoff, cutoff of pairs (nm), trials to an outer test.
STAND_INS = {"two": (0.7, 0.9, 400), "larger": (1.2, 1.2, 400), "smaller": (0.5, 0.5, 20), "absurd": (0.3, 0.3, 4)}
STAND_INS["other"] = STAND_INS["smaller"]


def cutPeptide():
    """Return residues 5 to 8 of the villin headpiece, ASP-PHE-LYS-ALA, capped: topology and positions (nm)."""
    whole, positions = readSystem("villin", FORCE_FIELD[0])
    residues = list(whole.residues())[3:9]
    topology, places = app.Topology(), []
    chain = topology.addChain()
    caps = {0: ("ACE", {"CA": "CH3", "C": "C", "O": "O"}), 5: ("NME", {"N": "N", "CA": "C"})}
    for index, old in enumerate(residues):
        name, names = caps.get(index, (old.name, None))
        new = topology.addResidue(name, chain)
        for atom in old.atoms():
            if names is None or atom.name in names:
                topology.addAtom(atom.name if names is None else names[atom.name], atom.element, new)
                places.append(positions[atom.index])
    topology.createStandardBonds()
    modeller = app.Modeller(topology, np.array(places) * unit.nanometer)
    modeller.addHydrogens(app.ForceField(*FORCE_FIELD))
    return modeller.topology, np.array(modeller.positions.value_in_unit(unit.nanometer))


def makeScene(name):
    """Return a System, its positions and the torsions that move."""
    if "peptide" in name:
        topology, positions = cutPeptide()
        system = app.ForceField(*FORCE_FIELD).createSystem(topology)
        system.addForce(createStericExclusionForce(topology, positions))
    else:
        system, _, positions = makeSystem("villin", FORCE_FIELD[0], solvent=FORCE_FIELD[1], torsions=("chi",))
    count = len(Run(system, positions).torsions)
    return system, positions, [int(i) for i in np.linspace(0, count - 1, COLUMNS)] if name == "villin" else None


def makeRun(scene, way, seed, temperature):
    system, positions, torsions = scene
    isPlain = way == "plain"
    run = Run(
        system,
        positions,
        native=not isPlain,
        seed=seed,
        temperature=temperature,
        moves=((1, 0.5, 1), (3, np.pi, 1)),
        torsions=torsions,
        platform="CPU" if isPlain else "Reference",
    )
    if not isPlain:
        born, pairs, size = STAND_INS[way]
        run.integrator.setStandInCutoffs(born, pairs)
        run.integrator.setTrialsPerOuterTest(size)
    run.integrator.setTrialsPerStep(20 if isPlain else 400)
    return run


def sample(scene, way, seconds, seed, temperature, elsewhere):
    """Return U, radius of gyration and cosines of torsions, one row a step."""
    run = makeRun(scene, way, seed, temperature)
    if way == "other":
        run.context.setPositions(elsewhere)
        run.integrator.renewStandIns(run.context)
        run.context.setPositions(scene[1])
    count = len(run.torsions)
    columns = scene[2] or [int(i) for i in np.linspace(0, count - 1, COLUMNS)]
    rows, end = [], time.monotonic() + seconds
    while time.monotonic() < end or len(rows) < 2 * BLOCKS:
        run.integrator.step(1)
        positions = run.positions
        radius = np.sqrt(positions.var(axis=0).sum())
        rows.append([run.energy, radius, *np.cos(run.torsions[columns])])
    tests = run.integrator.getOuterStatistics()
    kept = f", {tests.accepted / tests.attempted:.3f} of outer tests kept" if tests.attempted > 0 else ""
    trials = len(rows) * run.integrator.getTrialsPerStep()
    print(f"{way}, chain {seed}: {trials} trials, {run.accepted / trials:.4f} accepted{kept}", flush=True)
    return np.array(rows)


def blockMeans(chains):
    """Return means of the blocks of all chains, each without its first fifth."""
    means = []
    for rows in chains:
        rows = rows[len(rows) // 5 :]
        rows = rows[: len(rows) // BLOCKS * BLOCKS]
        means.append(rows.reshape(BLOCKS, -1, rows.shape[1]).mean(axis=1))
    return np.concatenate(means)


def pValues(blocks1, blocks2):
    """Return those of Welch's test, one a column."""
    variances = [blocks.var(axis=0, ddof=1) / len(blocks) for blocks in (blocks1, blocks2)]
    total = np.maximum(variances[0] + variances[1], 1e-30)
    freedom = total**2 / (sum(variance**2 for variance in variances) / (CHAINS * BLOCKS - 1) + 1e-300)
    differences = blocks1.mean(axis=0) - blocks2.mean(axis=0)
    return 2 * t.sf(np.abs(differences) / np.sqrt(total), np.maximum(freedom, 1))


def main(arguments):
    name, *ways = arguments
    seconds = {way: float(value) for way, value in (argument.split("=") for argument in ways)}
    ways = list(seconds)
    scene = makeScene(name)
    temperature = HOT if name.startswith("hot") else TEMPERATURE
    relaxed = []
    for seed in range(1, CHAINS + 2):
        run = makeRun(scene, "two", 100 + seed, temperature)
        run.run(200000)
        relaxed.append(run.positions)
    blocks = {}
    for number, way in enumerate(ways):
        chains = []
        for chain in range(CHAINS):
            start = (scene[0], relaxed[chain], scene[2])
            seed = 10 * number + chain + 1
            chains.append(sample(start, way, seconds[way] / CHAINS, seed, temperature, relaxed[CHAINS]))
        blocks[way] = blockMeans(chains)
        errors = blocks[way].std(axis=0, ddof=1) / np.sqrt(len(blocks[way]))
        means = blocks[way].mean(axis=0)
        print(way, *(f"{m:.3f}({e:.3f})" for m, e in zip(means, errors, strict=True)), flush=True)
    isGood = True
    for way in ways[:-1]:
        found = pValues(blocks[way], blocks[ways[-1]])
        isGood = isGood and found.min() > SIGNIFICANCE / (len(found) * (len(ways) - 1))
        print(f"{way} and {ways[-1]}: p-values", *(f"{value:.3g}" for value in found), flush=True)
    return 0 if isGood else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
