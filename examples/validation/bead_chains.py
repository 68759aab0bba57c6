"""Do ball joints, pivot moves and rigid-body moves sample correctly? Tests of any length, with numbers.

    python bead_chains.py [PART ...] [--effort X] [--seed N]

Each part compares with a method that is independent of the plugin, and prints a line for each number. A part fails if a
p-value is below 1e-4 divided by the number of lines, which a correct program practically never reaches. Parts:

directions  without energy and spheres, bond directions are uniform and independent (Pearson's test)
short       four and five hard beads: end-to-end distance against quadrature
chains      32 and 128 tangent hard spheres: mean squared end-to-end distance and radius of gyration against
            dimerization (Suzuki, Prog. Theor. Phys. 39, 1375 (1968); Alexandrowicz, J. Chem. Phys. 51, 561 (1969))
exponent    the same with 256 to 65,536 beads: nu from a fit with one correction term must be 0.5876 within 0.005
            (Clisby, Phys. Rev. Lett. 104, 055702 (2010))
letters     a chain of two types of beads with Ashbaugh-Hatch pairs: ends and size against Langevin dynamics in OpenMM
bodies      two rigid bodies on a spring against the exact distribution
drift       bond lengths after ten million moves
"""

import argparse
import sys
import time

import numpy as np
import openmm
import openmmchaintree as chaintree
from openmm import unit
from scipy import stats

PLATFORM = "Reference"
THERMAL = 8.31446261815324e-3 * 300  # kJ/mol


# ---- Chains of beads in the plugin ----


class Beads:
    """A chain of beads that rotate freely at each bond, sampled with pivot moves."""

    def __init__(self, positions, radius, seed, moves=((1, np.pi),), forces=(), bondCutoff=1):
        self.system = openmm.System()
        self.force = chaintree.StericExclusionForce()
        self.force.setOverlapTolerance(0)
        self.force.setForceGroup(31)
        for i in range(len(positions)):
            self.system.addParticle(100)
            self.force.addParticle(radius)
            if i > 0:
                self.force.addBond(i - 1, i)
                self.force.addBallJoint(i - 1, i)
        self.force.createExclusionsFromBonds(bondCutoff)
        self.system.addForce(self.force)
        for force in forces:
            self.system.addForce(force)
        self.integrator = chaintree.TorsionMonteCarloIntegrator(300)
        self.integrator.setRandomNumberSeed(seed)
        for weight, angle in moves:
            self.integrator.addPivotMove(weight, angle)
        self.context = openmm.Context(self.system, self.integrator, openmm.Platform.getPlatformByName(PLATFORM))
        self.context.setPositions(positions)

    def run(self, trials):
        self.integrator.setTrialsPerStep(max(1, trials))
        self.integrator.step(1)

    @property
    def positions(self):
        return positionsOf(self.context)


def positionsOf(context):
    return context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)


def stairs(count, bond):
    """Return positions of beads that do not touch, in the shape of stairs."""
    steps = np.array([[0.6, 0, 0.8], [0, 0.6, 0.8], [0.6, 0, 0.8], [0, -0.6, 0.8]])
    return bond * np.concatenate([[[0, 0, 0]], np.cumsum(np.resize(steps, (count - 1, 3)), axis=0)])


def squares(positions):
    """Return the squared end-to-end distance and the squared radius of gyration."""
    ends = positions[-1] - positions[0]
    return ends @ ends, np.mean(np.sum((positions - positions.mean(axis=0)) ** 2, axis=1))


def drawDirections(random, *shape):
    vectors = random.standard_normal((*shape, 3))
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


# ---- Statistics ----


class Report:
    """Lines with p-values."""

    def __init__(self):
        self.values = []

    def line(self, name, text, p=None):
        print(f"{name:<44} {text}" + (f"  p = {p:.3g}" if p is not None else ""), flush=True)
        if p is not None:
            self.values.append(p)

    def compare(self, name, found, foundError, expected, expectedError=0.0):
        error = np.hypot(foundError, expectedError)
        p = 2 * stats.norm.sf(abs(found - expected) / error)
        self.line(name, f"{found:.5g} ± {foundError:.2g}, expected {expected:.5g} ± {expectedError:.2g}", p)

    def uniform(self, name, counts, shares=None):
        """Compare counts with expected shares of their sum."""
        counts = np.asarray(counts)
        shares = np.full(len(counts), 1 / len(counts)) if shares is None else shares
        statistic, p = stats.chisquare(counts, shares * counts.sum())
        self.line(name, f"chi-squared {statistic:.1f} of {len(counts)} cells, {counts.sum()} samples", p)

    def succeeded(self):
        return all(p > 1e-4 / len(self.values) for p in self.values)


def meanAndError(samples, blocks=32):
    """Return the mean of correlated samples, and its error from block means."""
    means = np.array([block.mean(axis=0) for block in np.array_split(np.asarray(samples), blocks)])
    return means.mean(axis=0), means.std(axis=0, ddof=1) / np.sqrt(blocks)


# ---- The parts ----


def directions(report, effort, seed):
    """Test that moves from exact samples give exact samples; since the starts are independent, so are the results."""
    random = np.random.default_rng(seed)
    bonds = 6
    for name, moves in {"pi": ((1, np.pi),), "1.0": ((1, 1.0),), "both": ((1, np.pi), (1, 0.3))}.items():
        beads = Beads(stairs(bonds + 1, 1), 0, seed, moves)
        samples = []
        for _ in range(int(40000 * effort)):
            start = np.cumsum(drawDirections(random, bonds), axis=0)
            beads.context.setPositions(np.concatenate([[[0, 0, 0]], start]))
            beads.run(5)
            samples.append(np.diff(beads.positions, axis=0))
        u = np.array(samples)
        cells = 12
        for k in range(bonds):
            report.uniform(f"{name}: height of bond {k}", np.histogram(u[:, k, 2], cells, (-1, 1))[0])
            azimuth = np.arctan2(u[:, k, 1], u[:, k, 0])
            report.uniform(f"{name}: azimuth of bond {k}", np.histogram(azimuth, cells, (-np.pi, np.pi))[0])
        for k in range(bonds - 1):
            cosines = np.sum(u[:, k] * u[:, k + 1], axis=1)
            report.uniform(f"{name}: angle of bonds {k}, {k + 1}", np.histogram(cosines, cells, (-1, 1))[0])
        both = np.histogram2d(u[:, 0, 2], u[:, bonds - 1, 2], 5, ((-1, 1), (-1, 1)))[0]
        report.uniform(f"{name}: heights of the first and the last bond", both.astype(int).ravel())


def quadratureOfEnds(beads, diameter, size, edges):
    """Return the probabilities of end-to-end distances between `edges`, by the midpoint rule for angles and dihedrals.

    Cosines of angles are uniform up to the value at which second neighbours touch.
    """
    largest = 1 - 0.5 * diameter**2
    cosines = -1 + (np.arange(size) + 0.5) / size * (largest + 1)
    dihedrals = (np.arange(2 * size) + 0.5) / size * np.pi
    shares = np.zeros(len(edges) - 1)
    # By mirror symmetry, half the range of the first dihedral is enough.
    axes = [cosines] * (beads - 2) + [dihedrals[:size]] + [dihedrals] * (beads - 4)
    for first in axes[0]:
        grid = np.meshgrid([first], *axes[1:], indexing="ij")
        angles = [axis.ravel() for axis in grid]
        x = np.zeros((beads, 3, len(angles[0])))
        x[1] = [[1], [0], [0]]
        sine = np.sqrt(1 - angles[0] ** 2)
        x[2] = x[1] + [-angles[0], sine, 0 * sine]
        for k in range(3, beads):
            cosine, dihedral = angles[k - 2], angles[beads - 2 + k - 3]
            sine = np.sqrt(1 - cosine**2)
            axis = x[k - 1] - x[k - 2]
            normal = np.cross(x[k - 2] - x[k - 3], axis, axis=0)
            normal /= np.linalg.norm(normal, axis=0)
            side = np.cross(normal, axis, axis=0)
            turned = np.cos(dihedral) * side + np.sin(dihedral) * normal
            x[k] = x[k - 1] - cosine * axis + sine * turned
        free = np.ones(len(angles[0]), dtype=bool)
        for i in range(beads):
            for j in range(i + 3, beads):
                free &= np.sum((x[j] - x[i]) ** 2, axis=0) >= diameter**2
        shares += np.histogram(np.linalg.norm(x[-1] - x[0], axis=0)[free], edges)[0]
    return shares / shares.sum()


def short(report, effort, seed):
    """Treat samples 40 trials apart as independent: a trial moves half of the beads, and most are accepted."""
    diameter = 0.9
    for beads, size in ((4, 160), (5, 30)):
        edges = np.linspace(diameter, beads - 1, 13)
        shares = quadratureOfEnds(beads, diameter, size, edges)
        chain = Beads(stairs(beads, 1), diameter / 2, seed, ((1, np.pi), (1, 0.8)))
        ends = []
        for _ in range(int(60000 * effort)):
            chain.run(40)
            ends.append(np.sqrt(squares(chain.positions)[0]))
        kept = shares > 1e-3  # the midpoint rule is too inaccurate for the others
        counts = np.histogram(ends, edges)[0][kept]
        report.uniform(f"{beads} hard beads: distance of the ends", counts, shares[kept] / shares[kept].sum())


def joinChains(left, right, diameter, random):
    """Join each left chain with a right one, last bead to first bead; return the joined chains without clashes."""
    count, length = left.shape[:2]
    shift = left[:, -1] + drawDirections(random, count) - right[:, 0]
    right = right + shift[:, None]
    isFree = np.empty(count, dtype=bool)
    chunk = max(1, 4000000 // (length * right.shape[1]))
    for begin in range(0, count, chunk):
        a, b = left[begin : begin + chunk], right[begin : begin + chunk]
        middle = a[:, -1:]
        a, b = a - middle, b - middle
        squared = np.sum(a**2, axis=2)[:, :, None] + np.sum(b**2, axis=2)[:, None] - 2 * a @ b.transpose(0, 2, 1)
        squared[:, -1, 0] = np.inf  # a bond
        isFree[begin : begin + chunk] = squared.min(axis=(1, 2)) >= diameter**2
    return np.concatenate([left[isFree], right[isFree]], axis=1)


def dimerize(length, count, diameter, random):
    """Return `count` chains of hard beads with uniform probability, joined from uniform halves."""
    if length == 1:
        return np.zeros((count, 1, 3))
    found, total, tried = [], 0, 2 * count
    while total < count:
        halves = dimerize(length // 2, 2 * tried, diameter, random)
        made = joinChains(halves[:tried], halves[tried : 2 * tried], diameter, random)
        found.append(made)
        total += len(made)
        tried = int(1.2 * (count - total) * tried / max(1, len(made))) + 16
    return np.concatenate(found)[:count]


def chains(report, effort, seed):
    """Compare block means of long runs with means of independent chains."""
    random = np.random.default_rng(seed)
    for beads in (32, 128):
        expected = []
        batch = 500 if beads == 128 else 5000
        for _ in range(max(1, int((16 if beads == 128 else 20) * effort))):
            made = dimerize(beads, batch, 1.0, random)
            ends = np.sum((made[:, -1] - made[:, 0]) ** 2, axis=1)
            size = np.mean(np.sum((made - made.mean(axis=1, keepdims=True)) ** 2, axis=2), axis=1)
            expected += zip(ends, size, strict=True)
        expected = np.array(expected)
        chain = Beads(stairs(beads, 1), 0.5, seed, ((1, np.pi), (1, 0.5)))
        chain.run(400 * beads)
        samples = []
        for _ in range(int(60000 * effort)):
            chain.run(beads)
            samples.append(squares(chain.positions))
        found, errors = meanAndError(samples)
        for k, name in enumerate(("squared end-to-end distance", "squared radius of gyration")):
            mean, error = expected[:, k].mean(), expected[:, k].std() / np.sqrt(len(expected))
            report.compare(f"{beads} hard beads: {name}", found[k], errors[k], mean, error)


def exponent(report, effort, seed, largest=65536):
    """Fit log<R^2> = log A + 2 nu log n + log(1 + B n^-0.528) for n bonds."""
    sizes, means, errors = [], [], []
    beads = 256
    while beads <= largest:
        begin = time.process_time()
        chain = Beads(stairs(beads, 1), 0.5, seed + beads)
        chain.run(int(4 * beads * np.log(beads)))  # about ten rotations of each joint
        samples = []
        for _ in range(int(20000 * effort)):
            chain.run(60)
            samples.append(squares(chain.positions))
        mean, error = meanAndError(samples)
        statistics = chain.integrator.getMoveStatistics(0)
        seconds = time.process_time() - begin
        sizes.append(beads - 1)
        means.append(mean)
        errors.append(error)
        text = f"Re² {mean[0]:.6g} ± {error[0]:.2g}, Rg² {mean[1]:.6g} ± {error[1]:.2g}"
        share = statistics.accepted / statistics.attempted
        report.line(f"{beads} beads", f"{text}, {share:.3f} accepted, {seconds:.0f} s")
        beads *= 2
    n = np.array(sizes, dtype=float)
    for k, name in enumerate(("end-to-end distance", "radius of gyration")):
        y = np.log(np.array(means)[:, k])
        sigma = np.array(errors)[:, k] / np.array(means)[:, k]
        # To first order in n^-0.528 the problem is linear.
        design = np.stack([np.ones_like(n), 2 * np.log(n), n**-0.528], axis=1) / sigma[:, None]
        covariance = np.linalg.inv(design.T @ design)
        fitted = covariance @ design.T @ (y / sigma)
        chi = np.sum((design @ fitted - y / sigma) ** 2)
        error = np.sqrt(covariance[1, 1])
        freedom = len(n) - 3
        p = stats.chi2.sf(chi, freedom) if freedom > 0 else None
        report.line(f"nu by the {name}", f"{fitted[1]:.5f} ± {error:.5f}, B {fitted[2]:.3f}, chi² {chi:.1f}", p)
        # The published value is 0.587597(7).
        report.compare(f"nu by the {name}, published", fitted[1], error, 0.587597, 7e-6)


def ashbaughHatch(letters, cutoff):
    """Return the pair force of a chain of beads of types H (sticky) and P, in nm and kJ/mol."""
    force = openmm.CustomNonbondedForce(
        "select(step(2^(1/6)*s-r), lj+0.8*(1-l), l*lj);lj=4*0.8*((s/r)^12-(s/r)^6); s=0.5*(s1+s2); l=0.5*(l1+l2)"
    )
    force.addPerParticleParameter("s")
    force.addPerParticleParameter("l")
    force.setNonbondedMethod(openmm.CustomNonbondedForce.CutoffNonPeriodic)
    force.setCutoffDistance(cutoff)
    for letter in letters:
        force.addParticle([0.5, 0.9] if letter == "H" else [0.45, 0.1])
    return force


def letters(report, effort, seed):
    """Compare with dynamics of bonds so stiff that their lengths hardly matter, for many chains far from each other.

    With stiff springs, bond directions are uniform apart from the energy, as with pivot moves. (Constraints would add
    the determinant of their metric: Fixman, Proc. Natl. Acad. Sci. 71, 3050 (1974).) To first order, springs increase
    the mean squared length by 5 (sigma/b)^2, which is corrected.
    """
    sequence = "HPPHHPHPPPHHPHPPHHPHPPPH"
    bond, stiffness, copies, cutoff = 0.38, 5e4, 24, 2.0
    beads = len(sequence)
    pairs = ashbaughHatch(sequence, cutoff)
    pairs.createExclusionsFromBonds([(i, i + 1) for i in range(beads - 1)], 1)
    chain = Beads(stairs(beads, bond), 0, seed, ((1, np.pi), (1, 0.6)), [pairs])
    chain.run(20000)
    sampled = []
    for _ in range(int(40000 * effort)):
        chain.run(100)
        sampled.append(squares(chain.positions))
    found, errors = meanAndError(sampled)

    system = openmm.System()
    pairs = ashbaughHatch(sequence * copies, cutoff)
    bonds = openmm.HarmonicBondForce()
    positions = []
    for copy in range(copies):
        positions.append(stairs(beads, bond) + [100.0 * copy, 0, 0])
        for i in range(beads):
            system.addParticle(100)
            if i > 0:
                bonds.addBond(beads * copy + i - 1, beads * copy + i, bond, stiffness)
                pairs.addExclusion(beads * copy + i - 1, beads * copy + i)
    system.addForce(pairs)
    system.addForce(bonds)
    integrator = openmm.LangevinMiddleIntegrator(300, 1.0, 0.01)
    integrator.setRandomNumberSeed(seed)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("CPU"), {"Threads": "1"})
    context.setPositions(np.concatenate(positions))
    openmm.LocalEnergyMinimizer.minimize(context)
    context.setVelocitiesToTemperature(300, seed)
    integrator.step(40000)
    dynamic = []
    for _ in range(int(4000 * effort)):
        integrator.step(200)
        dynamic.append([squares(x) for x in np.split(positionsOf(context), copies)])
    dynamic = np.array(dynamic)
    ofCopies = dynamic.mean(axis=0)
    stretch = 1 + 5 * THERMAL / stiffness / bond**2
    expected = ofCopies.mean(axis=0) / stretch
    expectedErrors = ofCopies.std(axis=0, ddof=1) / np.sqrt(copies) / stretch
    for k, name in enumerate(("squared end-to-end distance", "squared radius of gyration")):
        report.compare(f"{beads} letters: {name}", found[k], errors[k], expected[k], expectedErrors[k])
    # Use samples far enough apart to be independent.
    spacing = max(1, len(dynamic) // 40)
    statistic, p = stats.ks_2samp(
        np.sqrt(np.array(sampled)[::20, 0]), np.sqrt(dynamic[::spacing, :, 0].ravel() / stretch)
    )
    report.line(f"{beads} letters: distribution of the ends", f"Kolmogorov-Smirnov {statistic:.4f}", p)


def bodies(report, effort, seed):
    """Test that a spring's length has the density r^2 exp(-k (r - r0)^2 / 2 kT), and that its direction is uniform."""
    system, force = openmm.System(), chaintree.StericExclusionForce()
    body = np.array([[0, 0, 0], [0.3, 0, 0], [0, 0.4, 0], [0.1, 0.2, 0.5]])
    for i in range(8):
        system.addParticle(0 if i < 4 else 12)
        force.addParticle(0)
        if i % 4 > 0:
            force.addBond(i - i % 4, i)
    k, r0 = 40.0, 0.6
    spring = openmm.HarmonicBondForce()
    spring.addBond(2, 5, r0, k)
    system.addForce(spring)
    system.addForce(force)
    integrator = chaintree.TorsionMonteCarloIntegrator(300)
    integrator.setRandomNumberSeed(seed)
    integrator.addRigidBodyMove(1, 0.6, np.pi)
    integrator.setTrialsPerStep(60)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName(PLATFORM))
    context.setPositions(np.concatenate([body, body + [0.2, 0.6, 0]]))
    samples = []
    for _ in range(int(60000 * effort)):
        integrator.step(1)
        samples.append(positionsOf(context))
    x = np.array(samples)
    d = x[:, 5] - x[:, 2]
    r = np.linalg.norm(d, axis=1)
    edges = np.concatenate([[0], np.linspace(0.2, 1.3, 12), [3]])
    fine = np.linspace(0, 3, 300001)
    density = fine**2 * np.exp(-0.5 * k * (fine - r0) ** 2 / THERMAL)
    below = np.interp(edges, fine, np.cumsum(density) / density.sum())
    report.uniform("two bodies: length of the spring", np.histogram(r, edges)[0], np.diff(below))
    report.uniform("two bodies: height of the spring", np.histogram(d[:, 2] / r, 12, (-1, 1))[0])
    arm = (x[:, 7] - x[:, 5]) / np.linalg.norm(body[3] - body[1])
    report.uniform("two bodies: height of an arm", np.histogram(arm[:, 2], 12, (-1, 1))[0])
    cosines = np.sum(arm * d, axis=1) / r
    report.uniform("two bodies: angle of arm and spring", np.histogram(cosines, 12, (-1, 1))[0])


def drift(report, effort, seed):
    """Test that bond lengths change by no more than the rounding of positions."""
    beads = 300
    chain = Beads(stairs(beads, 0.38), 0.19, seed, ((1, np.pi), (1, 0.2)))
    begin = time.process_time()
    for _ in range(10):
        chain.run(int(1000000 * effort))
    lengths = np.linalg.norm(np.diff(chain.positions, axis=0), axis=1)
    worst = np.abs(lengths - 0.38).max()
    statistics = [chain.integrator.getMoveStatistics(move) for move in range(2)]
    accepted = sum(counts.accepted for counts in statistics)
    attempted = sum(counts.attempted for counts in statistics)
    seconds = time.process_time() - begin
    text = f"{worst:.1e} nm off at worst, {attempted:,} trials, {accepted:,} accepted, {seconds:.0f} s"
    report.line(f"{beads} beads: lengths of bonds", text, 1.0 if worst < 1e-12 else 0.0)


PARTS = {part.__name__: part for part in (directions, short, chains, exponent, letters, bodies, drift)}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("parts", nargs="*", metavar="PART", help="which parts to run (default: all)")
    parser.add_argument("--effort", type=float, default=1, help="factor for the number of samples (default: 1)")
    parser.add_argument("--seed", type=int, default=1, help="random seed (default: 1)")
    parser.add_argument("--largest", type=int, default=65536, help="number of beads in the longest chain of `exponent`")
    options = parser.parse_args()
    unknown = set(options.parts) - set(PARTS)
    if unknown:
        parser.error(f"there is no part {', '.join(sorted(unknown))}; parts are {', '.join(PARTS)}")
    report = Report()
    for name in options.parts or PARTS:
        print(f"---- {name} ----", flush=True)
        more = {"largest": options.largest} if name == "exponent" else {}
        PARTS[name](report, options.effort, options.seed, **more)
    print(f"{len(report.values)} p-values, the least {min(report.values):.3g}: ", end="")
    print("passed" if report.succeeded() else "FAILED")
    return 0 if report.succeeded() else 1


if __name__ == "__main__":
    sys.exit(main())
