"""Two levels for longer than tests may take: is the ensemble that of plain sampling, and that of other stand-ins?

    python tests/long_two_levels.py SCENE WAY=SECONDS WAY=SECONDS ...
    python tests/long_two_levels.py SCENE --from WAY=SECONDS WAY WAY ...
    python tests/long_two_levels.py dipeptide DRAWS

--seed=NUMBER at the end chooses other random numbers.

Samples a scene for SECONDS of processor time in each way, and compares each way with the last one. Reasonable are
peptide two=60 smaller=60 other=60 plain=600, and villin larger=60 smaller=60 other=60 two=90. Absurd stand-ins hold
chains fast: a ring that does not flip keeps the sign that it began with, and p-values say so. The line "chains agree"
has p-values of chains of one way among each other: low ones say that they have not mixed.

With --from, one long chain gives draws, and each other way makes a step from each of them: what ends there has to be
distributed as the draws, whether that way mixes or not. The p-values are those of the mean changes. The dipeptide has
exact draws instead, and quadrature to compare them with: see test_two_levels.py.

SCENE  peptide: a capped ASP-PHE-LYS-ALA, all of whose torsions move, at 400 K; hot peptide: the same at 900 K; villin:
       the headpiece at 300 K, of which ten torsions of side chains move that turn often; side chains: the headpiece at
       300 K, of which all torsions of side chains move
WAY    two: two levels, as they are by default; often: with 50 trials to an outer test; one: with one; larger: with
       cutoffs of 1.0 and 1.2 nm; smaller: with cutoffs of 0.5 nm; absurd: with cutoffs of 0.3 nm; bonded: trials see
       bonded terms alone, and a test after each decides by our own whole energy; other: with constants of another
       conformation, and cutoffs of 0.5 nm; plain: OpenMM evaluates all Forces at each trial, on its CPU platform

Prints the means of U (kJ/mol), of the radius of gyration (nm) and of cosines of ten torsions, and for each way p-values
by means of blocks. Exit status 1 if one of them is below SIGNIFICANCE divided by their number. AMBER14 and GBn2.
"""

import sys
import time
from pathlib import Path

import numpy as np
import openmm.app as app
from openmmchaintree import StericExclusionForce, createStericExclusionForce
from realsystems import Run, isSteric, makeSystem
from scipy.stats import f_oneway, t
from test_native_sampling import SIGNIFICANCE, TEMPERATURE
from test_two_levels import ABSURD, DEFAULT, SHORT, makeDipeptide, pValueOfChanges

sys.path.append(str(Path(__file__).parents[1] / "examples" / "validation"))
from peptide import FORCE_FIELD, cutPeptide  # noqa: E402

HOT, COLD = 900, 300  # K
COLUMNS = 10  # torsions that are looked at
CHAINS = 4
BLOCKS = 12  # a chain
STEPS = 5  # between two draws
RELAXATION = 100000  # trials
LENGTHS = 40, 400  # trials from each exact draw
TOLERANCE = 0.05  # nm, of villin: so that it has no clash, and limits do not depend on where a chain begins

# Born cutoff, cutoff of pairs (nm), trials to an outer test.
STAND_INS = {
    "two": (0.55, 0.8, 400),
    "often": (0.55, 0.8, 50),
    "one": (0.55, 0.8, 1),
    "larger": (1.0, 1.2, 400),
    "smaller": (0.5, 0.5, 20),
    "absurd": (0.3, 0.3, 4),
    "bonded": (0.05, 0.05, 1),
}
STAND_INS["other"] = STAND_INS["smaller"]

# Of the side chains of villin: of GLU 4, ASP 5, LYS 7, ASN 19, HIS 27, LYS 30 and PHE 35.
FREE = [6, 7, 9, 14, 15, 31, 49, 58, 59, 69]


def makeScene(name):
    """Return a System, its positions and the torsions that move."""
    if "peptide" in name:
        topology, positions = cutPeptide()
        system = app.ForceField(*FORCE_FIELD).createSystem(topology)
        system.addForce(createStericExclusionForce(topology, positions))
    else:
        system, _, positions = makeSystem("villin", FORCE_FIELD[0], solvent=FORCE_FIELD[1], torsions=("chi",))
        force = next(force for force in system.getForces() if isSteric(force))
        StericExclusionForce.cast(force).setOverlapTolerance(TOLERANCE)
    return system, positions, FREE if name == "villin" else None


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


def makeRunOf(way, scene, seed, temperature, elsewhere):
    """Return a run at the start, whose stand-in has the constants that it is to have."""
    run = makeRun(scene, way, seed, temperature)
    run.context.setPositions(elsewhere if way == "other" else scene[1])
    run.integrator.renewStandIns(run.context)
    run.context.setPositions(scene[1])
    return run


def look(run, columns):
    """Return U, radius of gyration and cosines of torsions."""
    assert run.integrator.getNumToleratedClashes(run.context) == 0
    radius = np.sqrt(run.positions.var(axis=0).sum())
    count = len(run.torsions)
    return [run.energy, radius, *np.cos(run.torsions[columns or [int(i) for i in np.linspace(0, count - 1, COLUMNS)]])]


def sample(scene, way, seconds, seed, temperature, elsewhere):
    """Return the observed quantities, a row per step."""
    run = makeRunOf(way, scene, seed, temperature, elsewhere)
    rows, end = [], time.process_time() + seconds
    while time.process_time() < end or len(rows) < 2 * BLOCKS:
        run.integrator.step(1)
        rows.append(look(run, scene[2]))
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


def show(title, values, form="{:.3g}"):
    print(title, *(form.format(value) for value in values), flush=True)


def compareChains(ways, scene, relaxed, temperature, firstSeed):
    """Return whether all ways sample the same distribution as the last one."""
    blocks = {}
    for number, (way, seconds) in enumerate(ways.items()):
        chains = []
        for chain in range(CHAINS):
            start = (scene[0], relaxed[chain], scene[2])
            seed = firstSeed + 10 * number + chain
            chains.append(sample(start, way, seconds / CHAINS, seed, temperature, relaxed[CHAINS]))
        blocks[way] = blockMeans(chains)
        errors = blocks[way].std(axis=0, ddof=1) / np.sqrt(len(blocks[way]))
        print(way, *(f"{m:.3f}({e:.3f})" for m, e in zip(blocks[way].mean(axis=0), errors, strict=True)), flush=True)
        show(f"{way}, chains agree: p-values", f_oneway(*blocks[way].reshape(CHAINS, BLOCKS, -1)).pvalue)
    *others, last = ways
    isGood = True
    for way in others:
        found = pValues(blocks[way], blocks[last])
        isGood = isGood and found.min() > SIGNIFICANCE / (len(found) * len(others))
        show(f"{way} and {last}: p-values", found)
    return isGood


def followDraws(source, seconds, ways, scene, relaxed, temperature, firstSeed):
    """Return whether a step of each way leaves the distribution of states of another way's chain as it is."""
    elsewhere = relaxed[CHAINS]
    start = (scene[0], relaxed[0], scene[2])
    chain = makeRunOf(source, start, firstSeed, temperature, elsewhere)
    runs = {way: makeRunOf(way, start, firstSeed + 1 + i, temperature, elsewhere) for i, way in enumerate(ways)}
    changes, end = {way: [] for way in ways}, time.process_time() + seconds
    while time.process_time() < end:
        chain.integrator.step(STEPS)
        state, drawn = chain.positions, np.array(look(chain, scene[2]))
        for way, run in runs.items():
            run.context.setPositions(state)
            run.integrator.step(1)
            changes[way].append(np.array(look(run, scene[2])) - drawn)
    isGood = True
    for way, run in runs.items():
        rows = np.array(changes[way])
        tests = run.integrator.getOuterStatistics()
        kept = f", {tests.accepted / tests.attempted:.3f} of outer tests kept" if tests.attempted > 0 else ""
        print(f"{way}: {run.integrator.getTrialsPerStep()} trials from each of {len(rows)} draws of {source}{kept}")
        blocks = rows[: len(rows) // BLOCKS * BLOCKS].reshape(BLOCKS, -1, rows.shape[1]).mean(axis=1)
        errors = blocks.std(axis=0, ddof=1) / np.sqrt(BLOCKS) + 1e-300
        print(f"{way}, changes", *(f"{m:.4f}({e:.4f})" for m, e in zip(blocks.mean(axis=0), errors, strict=True)))
        show(f"{way}, root of mean squared changes", np.sqrt((rows**2).mean(axis=0)))
        found = 2 * t.sf(np.abs(blocks.mean(axis=0)) / errors, BLOCKS - 1)
        isGood = isGood and found.min() > SIGNIFICANCE / (len(found) * len(ways))
        show(f"{way} from draws of {source}: p-values", found)
    return isGood


def followExactDraws(count):
    """Return whether trials by any stand-in leave exact draws of a dipeptide as they are."""
    scene = makeDipeptide(TEMPERATURE)
    draws = scene.draw(count)
    values = scene.valuesOf(draws)
    found = [scene.pValue(values[None])]
    print(f"{count} draws against quadrature: p-value {found[0]:.3g}", flush=True)
    for name, standIn in {"default": DEFAULT, "short": SHORT, **ABSURD}.items():
        for trials in LENGTHS:
            ends = scene.follow(draws, standIn, trials, TEMPERATURE)
            after = scene.valuesOf(ends)
            found += [scene.pValue(after[None]), pValueOfChanges(values, after)]
            kept = scene.tests.accepted / scene.tests.attempted
            stays = np.corrcoef(np.sin(draws[:, 0]), np.sin(ends[:, 0]))[0, 1]
            show(f"{name}, {trials} trials: p-values against quadrature, of changes", found[-2:])
            show("    outer tests kept, correlation of sin(phi) with that before", (kept, stays))
    return min(found) > SIGNIFICANCE / len(found)


def main(arguments):
    name, *ways = arguments
    if name == "dipeptide":
        return 0 if followExactDraws(int(ways[0])) else 1
    isFollowed = ways[0] == "--from"
    firstSeed = 1
    if ways[-1].startswith("--seed="):
        firstSeed = 1 + 1000 * int(ways.pop().partition("=")[2])
    seconds = {way: float(value) for way, _, value in (argument.partition("=") for argument in ways if "=" in argument)}
    scene = makeScene(name)
    temperature = TEMPERATURE if name == "peptide" else HOT if name.startswith("hot") else COLD
    relaxed = []
    for seed in range(1, CHAINS + 2):
        run = makeRun(scene, "two", 99 + firstSeed + seed, temperature)
        run.run(RELAXATION)
        relaxed.append(run.positions)
    if isFollowed:
        source, length = next(iter(seconds.items()))
        return 0 if followDraws(source, length, ways[2:], scene, relaxed, temperature, firstSeed) else 1
    return 0 if compareChains(seconds, scene, relaxed, temperature, firstSeed) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
