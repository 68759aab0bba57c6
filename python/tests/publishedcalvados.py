"""Systems of disordered proteins in CALVADOS 2 and 3, as their authors build them: a bead for each residue, in a box.

Tesei and Lindorff-Larsen, Open Res. Eur. 2, 94 (2023); Cao, von Bülow, Tesei and Lindorff-Larsen, Protein Sci. 33,
e5172 (2024). Parameters from github.com/KULL-Centre/CALVADOS.
"""

import math

import numpy as np
import openmm
from openmm import app, unit

# The name of a residue, its mass (Da), charge, sigma (nm), and lambda in CALVADOS 2 and 3.
RESIDUES = {
    "A": ("ALA", 71.07, 0, 0.504, 0.274329796904, 0.3377244362031627),
    "C": ("CYS", 103.14, 0, 0.548, 0.561543509914, 0.5922529084601322),
    "D": ("ASP", 115.09, -1, 0.558, 0.041604048061, 0.092587557536158),
    "E": ("GLU", 129.11, -1, 0.592, 0.000693546096, 0.000249590539426),
    "F": ("PHE", 147.18, 0, 0.636, 0.867235898206, 0.8906449355499866),
    "G": ("GLY", 57.05, 0, 0.450, 0.705884373367, 0.7538308115197386),
    "H": ("HIS", 137.14, 0, 0.608, 0.466366729056, 0.4087176216525476),
    "I": ("ILE", 113.16, 0, 0.618, 0.542362361067, 0.5130398874425708),
    "K": ("LYS", 128.17, 1, 0.636, 0.179021173899, 0.1380602542039267),
    "L": ("LEU", 113.16, 0, 0.618, 0.644000500778, 0.5548615312993875),
    "M": ("MET", 131.20, 0, 0.618, 0.530848113434, 0.5170874160398543),
    "N": ("ASN", 114.10, 0, 0.568, 0.425585900979, 0.3706962163690402),
    "P": ("PRO", 97.12, 0, 0.556, 0.359312657636, 0.3469777523519372),
    "Q": ("GLN", 128.13, 0, 0.602, 0.393431855106, 0.3143449791669133),
    "R": ("ARG", 156.19, 1, 0.656, 0.730762476752, 0.7407902764839954),
    "S": ("SER", 87.08, 0, 0.518, 0.462541681161, 0.4473142572693176),
    "T": ("THR", 101.11, 0, 0.562, 0.371316297627, 0.2672387936544146),
    "V": ("VAL", 99.13, 0, 0.586, 0.208376960817, 0.2936174211771383),
    "W": ("TRP", 186.22, 0, 0.678, 0.989376474037, 1.033450123574512),
    "Y": ("TYR", 163.18, 0, 0.646, 0.977461144934, 0.950628687301107),
}

BOND = 0.38  # nm, the length of least energy
_STIFFNESS, _NETWORK_STIFFNESS = 8033.0, 700.0  # kJ/mol/nm²
_NETWORK_REACH = 0.9  # nm
_EPSILON = 0.2 * 4.184  # kJ/mol
_CUTOFF, _YUKAWA_CUTOFF = 2.0, 4.0  # nm


def makeCalvados(sequence, count, box, temperature=293.0, ionicStrength=0.15, version=2, domain=(), positions=None):
    """Return the Topology, without bonds, and the System of `count` chains in a rectangular box.

    sequence : str; box : three lengths in nm; ionicStrength : mol/l
    domain : residues of a chain that an elastic network holds, as in the `positions` of the first chain, in nm
    """
    system = openmm.System()
    system.setDefaultPeriodicBoxVectors(*np.diag(np.asarray(box, dtype=float)))
    ashbaughHatch, yukawa = _ashbaughHatch(), _yukawa(temperature, ionicStrength)
    bonds, network = openmm.HarmonicBondForce(), openmm.HarmonicBondForce()
    for force in (bonds, network):
        force.setUsesPeriodicBoundaryConditions(True)
    topology = app.Topology()
    topology.setUnitCellDimensions(box)
    length = len(sequence)
    for _ in range(count):
        chain, first = topology.addChain(), system.getNumParticles()
        for place, letter in enumerate(sequence):
            name, mass, charge, sigma, *lambdas = RESIDUES[letter]
            isFirst, isLast = place == 0, place == length - 1
            topology.addAtom("CA", app.element.carbon, topology.addResidue(name, chain))
            system.addParticle(mass + 2 * isFirst + 16 * isLast)
            ashbaughHatch.addParticle([sigma, lambdas[version - 2], 1])
            yukawa.addParticle([charge + isFirst - isLast])
        pairs = []
        for place in range(length - 1):
            isOfDomain = place in domain or place + 1 in domain
            bond = math.dist(*positions[place : place + 2]) if isOfDomain else BOND
            pairs.append((place, place + 1, bond, _STIFFNESS, bonds))
        for i in domain:
            for j in domain:
                if j > i + 1 and (distance := math.dist(positions[i], positions[j])) <= _NETWORK_REACH:
                    pairs.append((i, j, distance, _NETWORK_STIFFNESS, network))
        for i, j, distance, stiffness, force in pairs:
            force.addBond(first + i, first + j, distance, stiffness)
            for other in (ashbaughHatch, yukawa):
                other.addExclusion(first + i, first + j)
    for force in (yukawa, ashbaughHatch, bonds, *([network] if domain else [])):
        system.addForce(force)
    return topology, system


def _ashbaughHatch():
    # The ids are those of lipids (0) and crowders (-1); a pair with a lipid has the lambda behind them.
    force = openmm.CustomNonbondedForce(
        f"{_EPSILON}*select(step(r-2^(1/6)*s), 4*l*((s/r)^12-(s/r)^6-shift), 4*((s/r)^12-(s/r)^6-l*shift)+(1-l));"
        f"l=select(id1+id2, (id1*id2)*0.5*(l1+l2), 0); shift=(s/{_CUTOFF})^12-(s/{_CUTOFF})^6; s=0.5*(s1+s2)"
    )
    for name in ("s", "l", "id"):
        force.addPerParticleParameter(name)
    force.setNonbondedMethod(force.CutoffPeriodic)
    force.setCutoffDistance(_CUTOFF * unit.nanometer)
    return force


def _yukawa(temperature, ionicStrength):
    t = temperature
    permittivity = 5321 / t + 233.76 - 0.9297 * t + 1.417e-3 * t**2 - 8.292e-7 * t**3
    thermal = 8.3145e-3 * t  # kJ/mol
    bjerrum = 1.6021766**2 / (4 * math.pi * 8.854188 * permittivity) * 6022.14076 / thermal  # nm
    screening = math.sqrt(8 * math.pi * bjerrum * ionicStrength * 0.602214076)  # 1/nm
    shift = math.exp(-screening * _YUKAWA_CUTOFF) / _YUKAWA_CUTOFF
    force = openmm.CustomNonbondedForce(f"q*{bjerrum * thermal}*(exp(-{screening}*r)/r-{shift}); q=q1*q2")
    force.addPerParticleParameter("q")
    force.setNonbondedMethod(force.CutoffPeriodic)
    force.setCutoffDistance(_YUKAWA_CUTOFF * unit.nanometer)
    force.setForceGroup(1)  # platforms want one cutoff in a group
    return force


def serpentine(count, bond=BOND):
    """Return a path through a cube of a lattice, an (n, 3) array: beads that touch, without overlaps."""
    side = math.ceil(count ** (1 / 3) - 1e-9)
    index = np.arange(count)
    row, layer = index // side, index // side**2
    x, y = index % side, row % side
    x = np.where(row % 2 == 0, x, side - 1 - x)
    y = np.where(layer % 2 == 0, y, side - 1 - y)
    return bond * np.column_stack([x, y, layer]).astype(float)
