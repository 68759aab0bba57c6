"""Systems of beads as the authors of CALVADOS, COCOMO and Mpipi build them, made from their formulas.

Each function returns a Topology as the authors have it, a System, and positions (nm) of chains. `domain` are the
residues of a chain that an elastic network holds.
"""

import math

import numpy as np
import openmm
from openmm import app
from publishedcalvados import RESIDUES, makeCalvados, serpentine

PROTEIN = "MGSYRDFKAWELQTVNPHICGSRYGGFSDKRNGSYGGE"  # all residues
_APART = 3.5  # nm, between chains


def calvados2(count, box, domain=()):
    positions = _chains(len(PROTEIN), count, domain)
    return *makeCalvados(PROTEIN, count, box, domain=domain, positions=positions), positions


def calvados3(count, box, domain=()):
    positions = _chains(len(PROTEIN), count, domain)
    return *makeCalvados(PROTEIN, count, box, version=3, domain=domain, positions=positions), positions


# ---- COCOMO 2: Jussupow, Bartley, Lapidus and Feig, J. Chem. Theory Comput. 21, 2095 (2025) ----

_RADII = dict(
    zip(
        "ARNDCQEGHILKMFPSTWYV",
        (0.2845, 0.3567, 0.3150, 0.3114, 0.3024, 0.3311, 0.3279, 0.2617, 0.3338, 0.3360)
        + (0.3363, 0.3439, 0.3381, 0.3556, 0.3187, 0.2927, 0.3108, 0.3754, 0.3611, 0.3205),
        strict=True,
    )
)
_POLAR, _CATIONS, _AROMATIC = "RNDEQHKST", "RK", "FWY"

# A potential is switched to zero between r_on and r_off, with a continuous derivative.
_SWITCHED = (
    "select(step(r_on-r), {name}+sdel, switch); {name}={full}; switch=sk*((1/r)^3-1/(r_off)^3)^2;"
    "sdel=sk*((1/r_on)^3-1/(r_off)^3)^2-{atOn}; sk=-derivative/switch_derivative; derivative={derivative};"
    "switch_derivative=6*(1/r_on^3-1/r_off^3)*1/r_on^4;"
)
_LONG_RANGE = _SWITCHED.format(
    name="longrange",
    full="(AZ)*exp(-r/K0)/r",
    atOn="(AZ)/r_on*exp(-r_on/K0)",
    derivative="-1*(AZ)*exp(-r_on/K0)/r_on*(1/K0+1/r_on)",
)
_SHORT_RANGE = _SWITCHED.format(
    name="shortrange",
    full="4*eps*((sigma/r)^10-(sigma/r)^5)",
    atOn="4*eps*((sigma/r_on)^10-(sigma/r_on)^5)",
    derivative="4*eps*(-10*(sigma/r_on)^11*1/r_on+5*(sigma/r_on)^5*1/r_on)",
)


def cocomo2(count, box, domain=()):
    length, system = len(PROTEIN), openmm.System()
    positions = _chains(length, count, domain)
    topology = _bondedTopology([RESIDUES[letter][0] for letter in PROTEIN], "CA", count, box)
    system.setDefaultPeriodicBoxVectors(*np.diag(np.asarray(box, dtype=float)))
    bonds, angles = openmm.HarmonicBondForce(), openmm.HarmonicAngleForce()
    network = openmm.CustomBondForce("0.5*kenm*(r-r0)^2")
    network.addGlobalParameter("kenm", 500)
    network.addPerBondParameter("r0")
    longRange = openmm.CustomNonbondedForce(_LONG_RANGE + "AZ=S*(A+Z); S=(S1*S2)^0.5; A=A1*A2; Z=Z1+Z2")
    shortRange = openmm.CustomNonbondedForce(
        _SHORT_RANGE + "sigma=0.5*(sigma1+sigma2);"
        "eps=S*(eps_mix+eps_catpi_pro*min(1,catpipropair)+eps_pipi*min(1,pipipair)); S=(S1*S2)^0.5;"
        "catpipropair=isCation1*isAromatic2+isCation2*isAromatic1;"
        "pipipair=isAromatic1*isAromatic2+isAromatic2*isAromatic1; eps_mix=sqrt(epsilon1*epsilon2);"
    )
    globals1, globals2 = {"K0": 1}, {"eps_catpi_pro": 0.3, "eps_pipi": 0.1}
    names1, names2 = ("A", "Z", "S"), ("sigma", "epsilon", "isCation", "isAromatic", "S")
    for force, names, values in ((longRange, names1, globals1), (shortRange, names2, globals2)):
        for name in names:
            force.addPerParticleParameter(name)
        for name, value in {**values, "r_on": 2.9, "r_off": 3.1}.items():
            force.addGlobalParameter(name, value)
        force.setNonbondedMethod(force.CutoffPeriodic)
        force.setCutoffDistance(3.1)
    for place in range(count * length):
        letter = PROTEIN[place % length]
        charge, exposed = RESIDUES[letter][2], 0.6 + 0.4 * (place % length) / length
        system.addParticle(RESIDUES[letter][1])
        isPolar = letter in _POLAR
        longRange.addParticle(
            [math.copysign(math.sqrt(0.75 * abs(charge)), charge), 0 if isPolar else 0.01568, exposed]
        )
        epsilon = 0.17596101 if isPolar else 0.29519131
        sigma = 2 ** (5 / 6) * _RADII[letter]
        shortRange.addParticle([sigma, epsilon, letter in _CATIONS, letter in _AROMATIC, exposed])
    for first in range(0, count * length, length):
        for place in range(first, first + length - 1):
            bonds.addBond(place, place + 1, 0.38, 4184)
        for place in range(first, first + length - 2):
            angles.addAngle(place, place + 1, place + 2, math.pi, 4.184)
        for i, j, distance in _network(positions, domain, first, 3, 0.9):
            network.addBond(i, j, [distance])
    for force in (longRange, shortRange):
        force.createExclusionsFromBonds([(bond[0].index, bond[1].index) for bond in topology.bonds()], 1)
    for group, force in enumerate((bonds, angles, longRange, shortRange, network, openmm.CMMotionRemover())):
        force.setForceGroup(group)
        system.addForce(force)
    return topology, system, positions


# ---- Mpipi-Recharged: Tejedor et al., ACS Cent. Sci. 11, 302 (2025); a few residues ----

_MPIPI = "GSYRD"
_MPIPI_PROTEIN = "GSYRDGGSYRGDSGYGSRDYGGSRYSDGGRSYGDSGRG"
# epsilon (kJ/mol), sigma (nm) and mu of each pair, and the product of charges over the permittivity (nm kJ/mol).
_PAIRS = {
    "GG": (0.72374832, 0.469511, 3, 0), "GS": (0.59672208, 0.505389, 3, 0), "GY": (1.75514616, 0.571437, 3, 0),
    "GR": (1.40297888, 0.576708, 3, 0), "GD": (0.73550536, 0.525931, 3, 0), "SS": (0.46969584, 0.541267, 4, 0),
    "SY": (1.63506536, 0.607315, 3, 0), "SR": (1.28059688, 0.612586, 3, 0), "SD": (0.61291416, 0.561810, 3, 0),
    "YY": (2.70185984, 0.673363, 2, 0), "YR": (3.36481464, 0.678634, 2, 0), "YD": (1.72899616, 0.627858, 3, 0),
    "RR": (0.63065432, 0.683905, 3, 1.6736), "RD": (0.02820016, 0.633129, 7, -2.06232498),
    "DD": (0.57709912, 0.582352, 3, 1.6736),
}  # fmt: skip
_WANG_FRENKEL = """
    glob_factor * step(rc-r)*epsilon*alpha*((sigma/r)^(2*mu)-1)*((rc/r)^(2*mu)-1)^2;
    alpha = 2*(3^(2*mu))*((3)/(2*((3^(2*mu))-1)))^3; rc = 3*sigma;
    glob_factor = select(globular1*globular2, 0.7, select(globular1+globular2, sqrt(0.7), 1));
    epsilon = wf_table(index1, index2, 0); sigma = wf_table(index1, index2, 1); mu = floor(wf_table(index1, index2, 2));
"""


def mpipi(count, box, domain=()):
    length, system = len(_MPIPI_PROTEIN), openmm.System()
    positions = _chains(length, count, domain)
    system.setDefaultPeriodicBoxVectors(*np.diag(np.asarray(box, dtype=float)))
    wangFrenkel = openmm.CustomNonbondedForce(_WANG_FRENKEL)
    yukawa = openmm.CustomNonbondedForce("(A_table(index1, index2)/r) * exp(-kappa*r);")
    yukawa.addGlobalParameter("kappa", 1 / 0.794)
    wangFrenkel.addPerParticleParameter("index")
    wangFrenkel.addPerParticleParameter("globular")
    yukawa.addPerParticleParameter("index")
    pairs = [[_PAIRS.get(a + b) or _PAIRS[b + a] for a in _MPIPI] for b in _MPIPI]
    table = np.array(pairs).transpose(2, 0, 1)
    size = len(_MPIPI)
    wangFrenkel.addTabulatedFunction("wf_table", openmm.Discrete3DFunction(size, size, 3, table[:3].ravel().tolist()))
    yukawa.addTabulatedFunction("A_table", openmm.Discrete2DFunction(size, size, table[3].ravel().tolist()))
    for force, cutoff in ((wangFrenkel, 2.5), (yukawa, 3.5)):
        force.setNonbondedMethod(force.CutoffPeriodic)
        force.setCutoffDistance(cutoff)
    yukawa.setForceGroup(1)
    topology = app.Topology()
    topology.setUnitCellDimensions(box)
    bonds = openmm.HarmonicBondForce()
    for first in range(0, count * length, length):
        chain = topology.addChain()
        for place, letter in enumerate(_MPIPI_PROTEIN):
            element = app.element.platinum if place in domain else app.element.carbon
            topology.addAtom("p" + letter, element, topology.addResidue(RESIDUES[letter][0], chain))
            system.addParticle(RESIDUES[letter][1])
            wangFrenkel.addParticle([_MPIPI.index(letter), place in domain])
            yukawa.addParticle([_MPIPI.index(letter)])
        for place in range(length - 1):
            if place not in domain or place + 1 not in domain:
                bonds.addBond(first + place, first + place + 1, 0.381, 8031)
        for i, j, distance in _network(positions, domain, first, 1, 0.75):
            bonds.addBond(i, j, distance, 8031)
            bonds.addBond(j, i, distance, 8031)  # as its authors do
    atoms = list(topology.atoms())
    for index in range(bonds.getNumBonds()):
        topology.addBond(*(atoms[atom] for atom in bonds.getBondParameters(index)[:2]))
    bonded = [tuple(bonds.getBondParameters(index)[:2]) for index in range(bonds.getNumBonds())]
    for force in (wangFrenkel, yukawa):
        force.createExclusionsFromBonds(bonded, 1)
    for force in (bonds, wangFrenkel, yukawa):
        system.addForce(force)
    return topology, system, positions


# ---- What they share ----


def _chains(length, count, domain):
    """Return positions of parallel chains, an (n, 3) array: zigzags, with the domain on a lattice."""
    index = np.arange(length)
    chain = 0.27 * np.column_stack([index % 2, 0 * index, index])
    if domain:
        last = domain[-1] + 1
        behind = chain[last:] - chain[domain[-1]]
        lattice = serpentine(len(domain), 0.5)
        chain[domain] = lattice - lattice[0] + chain[domain[0]]
        chain[last:] = behind + chain[domain[-1]]
    return np.concatenate([chain + [0, place * _APART, 0] for place in range(count)])


def _bondedTopology(names, atomName, count, box):
    topology = app.Topology()
    topology.setUnitCellDimensions(box)
    for _ in range(count):
        chain, before = topology.addChain(), None
        for name in names:
            atom = topology.addAtom(atomName, app.element.carbon, topology.addResidue(name, chain))
            if before is not None:
                topology.addBond(before, atom)
            before = atom
    return topology


def _network(positions, domain, first, apart, reach):
    """Return (particle, particle, distance) of a domain's elastic network: pairs of residues at least `apart`."""
    pairs = [(first + i, first + j) for i in domain for j in domain if j - i >= apart]
    found = [(i, j, math.dist(positions[i], positions[j])) for i, j in pairs]
    return [pair for pair in found if pair[2] < reach]


MODELS = {"CALVADOS 2": calvados2, "CALVADOS 3": calvados3, "COCOMO 2": cocomo2, "Mpipi": mpipi}
