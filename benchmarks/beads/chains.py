"""Chains of beads as the plugin samples them, compact ones and coils."""

import numpy as np
import openmm
import openmmchaintree as chaintree
from openmm import unit

REFERENCE = "Reference"  # the platform: ours needs nothing of it

_BACKBITES_PER_SITE = 12
_STAIRS = np.array([[0.6, 0, 0.8], [0, 0.6, 0.8], [0.6, 0, 0.8], [0, -0.6, 0.8]])


def stairs(count, bond):
    """Return positions of `count` beads of which only neighbours are near each other: an (n, 3) array."""
    return bond * np.cumsum(np.resize(_STAIRS, (count, 3)), axis=0)


def compactWalk(count, spacing, random):
    """Return a random path through a cubic lattice: the serpentine after moves by which an end goes to a neighbour.

    The path is threaded anew from there. Moves to free sites, of which a cube that is not full has some, are left out.
    """
    side = int(np.ceil(count ** (1 / 3) - 1e-9))
    index = np.arange(count)
    row, layer = index // side, index // side**2
    x, y = index % side, row % side
    x, y = np.where(row % 2 == 0, x, side - 1 - x), np.where(layer % 2 == 0, y, side - 1 - y)
    strides = (1, side, side**2)
    sites = x + side * y + side**2 * layer
    places = np.full(side**3, -1)
    places[sites] = index
    for atStart, axis, step in zip(
        *(random.integers(high, size=_BACKBITES_PER_SITE * count) for high in (2, 3, 2)), strict=True
    ):
        site = sites[0 if atStart else -1]
        along = site // strides[axis] % side + 2 * step - 1
        site += (2 * step - 1) * strides[axis]
        if not 0 <= along < side or places[site] < 0:
            continue
        turned = slice(0, places[site]) if atStart else slice(places[site] + 1, count)
        sites[turned] = sites[turned][::-1].copy()
        places[sites[turned]] = index[turned]
    return spacing * np.stack([sites // stride % side for stride in strides], axis=1)


def makeForce(count, radius):
    """Return a StericExclusionForce of a chain: each bead turns freely about the one before."""
    force = chaintree.StericExclusionForce()
    force.setOverlapTolerance(0)
    force.setForceGroup(31)
    for bead in range(count):
        force.addParticle(radius)
        if bead > 0:
            force.addBond(bead - 1, bead)
            force.addBallJoint(bead - 1, bead)
    force.createExclusionsFromBonds(1)
    return force


class PivotRun:
    """A chain in a Context, and its integrator."""

    def __init__(self, positions, radius, moves, seed, forces=(), temperature=300):
        """Take positions in nm, pivot moves as (weight, largest angle), and more Forces."""
        self._system = openmm.System()
        for _ in positions:
            self._system.addParticle(1)
        self._system.addForce(makeForce(len(positions), radius))
        for force in forces:
            self._system.addForce(force)
        self.integrator = chaintree.TorsionMonteCarloIntegrator(temperature)
        self.integrator.setRandomNumberSeed(seed)
        for weight, angle in moves:
            self.integrator.addPivotMove(weight, angle)
        self.context = openmm.Context(self._system, self.integrator, openmm.Platform.getPlatformByName(REFERENCE))
        self.context.setPositions(positions)

    def run(self, trials):
        """Run so many trials, in one step."""
        self.integrator.setTrialsPerStep(trials)
        self.integrator.step(1)

    def accepted(self):
        """Return the share of trials that were accepted so far."""
        counts = [self.integrator.getMoveStatistics(move) for move in range(self.integrator.getNumMoves())]
        return sum(one.accepted for one in counts) / max(1, sum(one.attempted for one in counts))


def positionsOf(context):
    """Return the positions of a Context in nm."""
    return context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)


def radiusOfGyration(positions):
    """Return the radius of gyration of beads of one mass."""
    return float(np.sqrt(positions.var(axis=0).sum()))
