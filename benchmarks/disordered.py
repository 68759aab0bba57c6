"""A coarse-grained disordered protein: one bead a residue, with Ashbaugh-Hatch and Debye-Hückel pairs."""

import numpy as np
import openmm

BOND = 0.38  # nm

# Stickiness, diameter (nm), charge and mass of residues: CALVADOS 2, Tesei and Lindorff-Larsen, Open Res. Eur. 2, 94
# (2023), to four digits.
RESIDUES = {
    "A": (0.2743, 0.504, 0, 71.07),
    "R": (0.7308, 0.656, 1, 156.19),
    "N": (0.4256, 0.568, 0, 114.10),
    "D": (0.0416, 0.558, -1, 115.09),
    "Q": (0.3934, 0.602, 0, 128.13),
    "E": (0.0007, 0.592, -1, 129.11),
    "G": (0.7059, 0.450, 0, 57.05),
    "H": (0.4664, 0.608, 0, 137.14),
    "I": (0.5424, 0.618, 0, 113.16),
    "L": (0.6440, 0.618, 0, 113.16),
    "K": (0.1790, 0.636, 1, 128.17),
    "M": (0.5308, 0.618, 0, 131.20),
    "F": (0.8672, 0.636, 0, 147.18),
    "P": (0.3593, 0.556, 0, 97.12),
    "S": (0.4625, 0.518, 0, 87.08),
    "T": (0.3713, 0.562, 0, 101.11),
    "Y": (0.9775, 0.646, 0, 163.18),
    "V": (0.2084, 0.586, 0, 99.13),
}

# Disordered regions are rich in these. The sequence is nobody's.
_COMPOSITION = {
    "G": 8, "S": 11, "P": 8, "E": 9, "K": 8, "A": 7.5, "Q": 6, "T": 5.5, "D": 6.5, "N": 5, "R": 5, "L": 5.5, "V": 4,
    "I": 2.5, "Y": 2, "F": 2, "H": 2, "M": 2,
}  # fmt: skip

_EPSILON = 0.8368  # kJ/mol
_STICKY_CUTOFF, _CHARGE_CUTOFF = 2.0, 4.0  # nm
_SCREENING = 0.96  # nm, at 0.1 mol/l
_COULOMB = 1.7721  # kJ/mol nm, in water
_STIFFNESS = 8033.0  # kJ/mol/nm^2, of bonds in dynamics


def makeSequence(length, seed=1):
    """Return the one-letter codes of a chain."""
    letters = list(_COMPOSITION)
    shares = np.array([_COMPOSITION[letter] for letter in letters])
    return "".join(np.random.default_rng(seed).choice(letters, size=length, p=shares / shares.sum()))


def makePairForces(sequence):
    """Return the Forces of pairs but neighbours."""
    cut = f"{4 * _EPSILON}*((s/{_STICKY_CUTOFF})^12-(s/{_STICKY_CUTOFF})^6)"
    sticky = openmm.CustomNonbondedForce(
        f"select(step(r-2^(1/6)*s), l*(lj-cut), lj+{_EPSILON}*(1-l)-l*cut);"
        f"lj={4 * _EPSILON}*((s/r)^12-(s/r)^6); cut={cut}; s=0.5*(s1+s2); l=0.5*(l1+l2)"
    )
    sticky.addPerParticleParameter("s")
    sticky.addPerParticleParameter("l")
    shift = np.exp(-_CHARGE_CUTOFF / _SCREENING) / _CHARGE_CUTOFF
    charged = openmm.CustomNonbondedForce(f"q1*q2*{_COULOMB}*(exp(-r/{_SCREENING})/r-{shift})")
    charged.addPerParticleParameter("q")
    for letter in sequence:
        stickiness, diameter, charge, _ = RESIDUES[letter]
        sticky.addParticle([diameter, stickiness])
        charged.addParticle([charge])
    for force, cutoff in ((sticky, _STICKY_CUTOFF), (charged, _CHARGE_CUTOFF)):
        force.setNonbondedMethod(openmm.CustomNonbondedForce.CutoffNonPeriodic)
        force.setCutoffDistance(cutoff)
        force.createExclusionsFromBonds([(bead, bead + 1) for bead in range(len(sequence) - 1)], 1)
    return [sticky, charged]


def makeDynamicsSystem(sequence):
    """Return the System of dynamics: harmonic bonds and the pairs."""
    system, bonds = openmm.System(), openmm.HarmonicBondForce()
    for bead, letter in enumerate(sequence):
        system.addParticle(RESIDUES[letter][3])
        if bead > 0:
            bonds.addBond(bead - 1, bead, BOND, _STIFFNESS)
    for force in [bonds, *makePairForces(sequence)]:
        system.addForce(force)
    return system
