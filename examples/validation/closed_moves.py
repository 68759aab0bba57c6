"""Do closed moves sample the closures of a loop correctly? Eight torsions between fixed ends, against rejection.

    python closed_moves.py [--batches 300] [--trials 300] [--seed 1]

The loop is a backbone of five residues with fixed, non-planar peptide bonds. Rejection sampling uses neither Newton's
method nor Jacobians nor solutions: it draws all torsions of the first half uniformly, and those of the second half,
which starts at the far end. Where two halves nearly meet, the loop is a sample ("draw") if its end is within TOLERANCE
of the required place. Each batch draws new halves, so that few samples share one.

Every second sample is moved: its ends stay exactly in place, and closed moves lead it to other closures. Whether a loop
is a sample depends on its end alone, so both sets are samples of one ensemble, for any TOLERANCE. Compared are each
torsion, pairs of torsions (two-sample chi-squared) and log |J| of the six pivots (Kolmogorov and Smirnov). Exit status
1 if a p-value is below SIGNIFICANCE divided by their number (Bonferroni), or if the same tests do not notice an
ensemble without 1/|J|, which is made from the moved loops by weighting.

(TestClosedMoves tests that uniform torsions stay uniform; its argument is the number of samples.)
"""

import argparse
import sys

import numpy as np
import openmm
import openmmchaintree as chaintree
from scipy.spatial import cKDTree
from scipy.stats import chi2_contingency, ks_2samp

SIGNIFICANCE = 1e-3
TOLERANCE = 0.09  # nm, root of the summed squares over four points of the end, ARM apart
ARM = 0.3  # nm
MIDDLE = 0.33  # nm, the same over three atoms where the halves meet; no loop within TOLERANCE exceeds it
HALVES = 10000  # per batch, of each half
LENGTHS = {"N": 0.1329, "A": 0.1458, "C": 0.1525}  # nm, of the bond that ends in this atom
ANGLES = {"N": 2.12, "A": 1.94, "C": 2.03}  # rad, at an atom
OMEGAS = (3.1, -2.9, 2.7, -3.0)  # rad
KINDS = "NAC" * 5
TORSIONS = 8
BINS = 8


def place(p1, p2, p3, length, angle, dihedral):
    """Return the points with a bond to p3, an angle p2-p3 and a dihedral p1-p2-p3; arrays of shape (..., 3)."""
    axis = p3 - p2
    axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    normal = np.cross(p2 - p1, axis)
    normal = normal / np.linalg.norm(normal, axis=-1, keepdims=True)
    side = np.cross(normal, axis)
    cosine, sine = np.cos(dihedral)[..., None], np.sin(dihedral)[..., None]
    return p3 + length * (-np.cos(angle) * axis + np.sin(angle) * (cosine * side + sine * normal))


def build(torsions, count=15):
    """Return the first atoms of loops from psi 1, phi 2, ... phi 5, arrays of shape (..., 8) and (..., count, 3)."""
    torsions = np.asarray(torsions)
    shape = torsions.shape[:-1]
    first = np.zeros(3)
    second = np.array([LENGTHS["A"], 0, 0])
    angle = ANGLES["A"]
    third = second + LENGTHS["C"] * np.array([-np.cos(angle), np.sin(angle), 0])
    atoms = [np.broadcast_to(point, (*shape, 3)) for point in (first, second, third)]
    turned = iter(range(TORSIONS))
    for i in range(3, count):
        kind = KINDS[i]
        dihedral = np.full(shape, OMEGAS[i // 3 - 1]) if kind == "A" else torsions[..., next(turned)]
        atoms.append(place(*atoms[-3:], LENGTHS[kind], ANGLES[KINDS[i - 1]], dihedral))
    return np.stack(atoms, axis=-2)


def buildBackward(end, torsions):
    """Return N, alpha and C of residue 3 from those of residue 5 and the torsions psi 3, phi 4, psi 4 and phi 5."""
    shape = torsions.shape[:-1]
    atoms = [np.broadcast_to(point, (*shape, 3)) for point in end[::-1]]
    turned = iter((3, 2, 1, 0))
    for i in range(11, 5, -1):
        # The bond from atom i to i + 1, the angle there, and the dihedral of i ... i + 3.
        dihedral = np.full(shape, OMEGAS[i // 3]) if KINDS[i] == "A" else torsions[..., next(turned)]
        atoms.append(place(*atoms[-3:], LENGTHS[KINDS[i + 1]], ANGLES[KINDS[i + 1]], dihedral))
    return np.stack(atoms[-3:][::-1], axis=-2)


def framePoints(end):
    """Return four points fixed to a residue, from its N, alpha and C: arrays of shape (..., 4, 3)."""
    origin = end[..., 1, :]
    axes = [end[..., 2, :] - origin]
    axes[0] = axes[0] / np.linalg.norm(axes[0], axis=-1, keepdims=True)
    normal = np.cross(axes[0], end[..., 0, :] - origin)
    axes.append(normal / np.linalg.norm(normal, axis=-1, keepdims=True))
    axes.append(np.cross(axes[0], axes[1]))
    return np.stack([origin, *(origin + ARM * axis for axis in axes)], axis=-2)


def reject(start, batches, random):
    """Return the torsions of loops whose ends are within TOLERANCE of that of the loop `start`.

    Also returns the number of halves that occur in an earlier loop, too.
    """
    end = build(start)[12:]
    wanted = framePoints(end)
    closed, shared, farthest = [], 0, 0.0
    for _ in range(batches):
        left = random.uniform(-np.pi, np.pi, (HALVES, 4))
        right = random.uniform(-np.pi, np.pi, (HALVES, 4))
        fromLeft = build(left, 9)[:, 6:].reshape(HALVES, 9)
        fromRight = buildBackward(end, right).reshape(HALVES, 9)
        near = cKDTree(fromLeft).sparse_distance_matrix(cKDTree(fromRight), MIDDLE, output_type="ndarray")
        loops = np.concatenate([left[near["i"]], right[near["j"]]], axis=1)
        misses = np.linalg.norm((framePoints(build(loops)[:, 12:]) - wanted).reshape(len(loops), 12), axis=1)
        isDraw = misses < TOLERANCE
        near = near[isDraw]
        closed.append(loops[isDraw])
        shared += 2 * len(near) - len(set(near["i"])) - len(set(near["j"]))
        farthest = max(farthest, near["v"].max(initial=0.0))
    assert farthest < 0.9 * MIDDLE, f"MIDDLE excludes loops: {farthest}"
    return np.concatenate(closed), shared


def withNeighbors(loop):
    """Return the 17 atoms of a loop and of the bond that holds its end."""
    beyond = place(*loop[-3:], LENGTHS["N"], ANGLES["C"], np.array(2.0))
    return np.concatenate([loop, [beyond, place(*loop[-2:], beyond, LENGTHS["A"], ANGLES["N"], np.array(OMEGAS[3]))]])


def move(loops, trials, seed):
    """Return the torsions of loops between fixed ends after closed moves, and the move's statistics."""
    system = openmm.System()
    force = chaintree.StericExclusionForce()
    for i in range(17):
        system.addParticle(0 if i < 2 or i > 14 else 1)
        force.addParticle(0)
        if i not in (0, 15):
            force.addBond(i - 1, i)
        if 3 <= i < 15 and KINDS[i] != "A":
            force.addTorsion(i - 3, i - 2, i - 1, i)
    force.addClosure(13, 14, 15, 16)
    system.addForce(force)
    integrator = chaintree.TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(seed)
    integrator.setTrialsPerStep(trials)
    integrator.addClosedMove(1, 1.5, hop=0.6)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    moved = []
    for loop in build(loops):
        context.setPositions(withNeighbors(loop))
        integrator.step(1)
        moved.append(integrator.getTorsionAngles(context))
    return np.array(moved), integrator.getMoveStatistics(0)


def logJacobians(torsions):
    """Return log |J| of the pivots phi 2 ... psi 4, which are all torsions except the first and last."""
    atoms = build(torsions)
    screws = []
    for i in (3, 4, 6, 7, 9, 10):
        axis = atoms[..., i + 1, :] - atoms[..., i, :]
        axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
        screws.append(np.concatenate([axis, np.cross(atoms[..., i, :], axis)], axis=-1))
    return np.linalg.slogdet(np.stack(screws, axis=-1))[1]


def compareCounts(bins1, bins2):
    """Return the p-value of a two-sample test of bins; rare bins are merged."""
    size = int(max(bins1.max(), bins2.max())) + 1
    counts = np.array([np.bincount(bins1, minlength=size), np.bincount(bins2, minlength=size)])
    often = counts.sum(axis=0) >= 20
    rare = counts[:, ~often].sum(axis=1, keepdims=True)
    counts = counts[:, often]
    if rare.sum() >= 20:
        counts = np.concatenate([counts, rare], axis=1)
    return float(chi2_contingency(counts).pvalue) if counts.shape[1] > 1 else 1.0


def compare(torsions1, torsions2):
    """Return {quantity: p-value} of two samples of loops."""
    bins1, bins2 = (
        np.floor((torsions % (2 * np.pi)) / (2 * np.pi) * BINS).astype(int) % BINS
        for torsions in (torsions1, torsions2)
    )
    found = {f"torsion {i}": compareCounts(bins1[:, i], bins2[:, i]) for i in range(TORSIONS)}
    for i in range(TORSIONS):
        for j in range(i):
            pairs = (bins[:, i] // 2 * BINS + bins[:, j] // 2 for bins in (bins1, bins2))
            found[f"torsions {j} and {i}"] = compareCounts(*pairs)
    found["log |J|"] = float(ks_2samp(logJacobians(torsions1), logJacobians(torsions2)).pvalue)
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--batches", type=int, default=300)
    parser.add_argument("--trials", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    random = np.random.default_rng(arguments.seed)
    start = np.array([2.2, -1.3, 2.0, -1.1, -0.6, -1.5, 2.4, -1.0])
    draws, shared = reject(start, arguments.batches, random)
    print(f"rejection: {len(draws)} draws whose ends are within {TOLERANCE} nm; {shared} share a half with another")
    moved, statistics = move(draws[::2], arguments.trials, arguments.seed)
    print(f"closed moves: {statistics.accepted / statistics.attempted:.2f} of the trials accepted")
    found = compare(moved, draws[1::2])
    for what in [*sorted(found, key=lambda name: found[name])[:5], "log |J|"]:
        print(f"  {what}: p = {found[what]:.2g}")
    least = min(found.values()) * len(found)
    print(f"closed moves against rejection: p = {min(1.0, least):.2g} ({len(found)} tests)")
    weights = np.exp(logJacobians(moved))
    wrong = moved[random.random(len(moved)) < weights / np.quantile(weights, 0.95)]
    noticed = min(compare(wrong, draws[1::2]).values()) * len(found)
    print(f"without 1/|J| ({len(wrong)} loops): p = {min(1.0, noticed):.2g}")
    return 0 if least > SIGNIFICANCE and noticed < SIGNIFICANCE else 1


if __name__ == "__main__":
    sys.exit(main())
