"""Systems of the CALVADOS models: a bead for each residue of disordered proteins and of proteins with domains."""

import math
from collections.abc import Iterable, Sequence
from functools import cache
from itertools import combinations
from typing import NamedTuple

import numpy as np
import openmm
from openmm import app, unit

from .beadplaces import layOut, placesOfResidues
from .datatables import readTable
from .errors import InputError
from .residues import aminoAcid
from .units import Array, Number, inUnit

MODELS = ("calvados2", "calvados3")

# nm: the length of least energy of a bond, and its mean length in dynamics, which trials with rigid bonds need.
_BOND, MEAN_BOND = 0.38, 0.3825
_STIFFNESS, _NETWORK_STIFFNESS = 8033.0, 700.0  # kJ/mol/nm²
_NETWORK_REACH = 0.9  # nm
_EPSILON = 0.2 * 4.184  # kJ/mol
_CUTOFF, _YUKAWA_CUTOFF = 2.0, 4.0  # nm
_MASS_OF_N_TERMINUS, _MASS_OF_C_TERMINUS = 2.0, 16.0  # Da


class _Bead(NamedTuple):
    residue: str
    mass: float
    charge: float
    pKa: float | None
    sigma: float
    stickiness: float


class CalvadosSystem(NamedTuple):
    """What `createCalvadosSystem` returns: topology, system, and positions, an (n, 3) array in nm."""

    topology: app.Topology
    system: openmm.System
    positions: np.ndarray


def createCalvadosSystem(
    source: str | Sequence[str] | app.PDBFile | app.PDBxFile | app.Modeller,
    temperature: Number = 298.0,
    pH: float = 7.0,
    ionicStrength: float = 0.15,
    model: str = "calvados2",
    domains: Iterable[Iterable[int]] = (),
    box: Array | None = None,
) -> CalvadosSystem:
    """Create the System of proteins in CALVADOS 2 or 3, as the authors of the models build it.

    Energies follow github.com/KULL-Centre/CALVADOS: harmonic bonds, Ashbaugh-Hatch and screened Coulomb
    interactions with charged termini, histidine and phosphorylated residues charged by pH, and elastic networks in
    domains. Trials keep the bond lengths of the positions; a sequence gets the mean lengths of dynamics:

        topology, system, positions = createCalvadosSystem("GSYRDFKAWELQ", temperature=298)
        system.addForce(createStericExclusionForce(topology, positions, system=system))

    Parameters
    ----------
    source : str, sequence of str, or an object with `topology` and `positions`
        a sequence in letters (B is phosphoserine, O phosphothreonine), one for each chain, or a protein with all atoms,
        whose residues become beads at their centers of mass (the Cα atoms in CALVADOS 2)
    temperature : float or Quantity
        K; the permittivity of water depends on it
    ionicStrength : float
        mol/l
    model : "calvados2" or "calvados3"
        CALVADOS 3 was made for proteins with domains
    domains : iterable of iterables of int
        the residues of each folded domain, counted from 0 over all chains, which an elastic network holds; they need a
        source with positions
    box : three lengths or Quantity, optional
        nm, of a rectangular periodic box, which several chains need; default: no box

    Returns
    -------
    CalvadosSystem
        topology, system and positions (nm); sequences start stretched, side by side

    Raises
    ------
    InputError
        if the model lacks a residue, a chain is broken, several chains have no box, or a domain names no residue
    """
    if model not in MODELS:
        raise InputError(f"there is no model {model!r}: choose one of {', '.join(MODELS)}")
    temperature = float(inUnit(temperature, "K", "temperature"))
    if not (temperature > 0 and ionicStrength > 0):
        raise InputError("temperature and ionicStrength must be above 0")
    lengths = None if box is None else _lengthsOf(box)
    chains, positions = _readChains(source, model, lengths)
    found = _readDomains(domains, len(positions), hasattr(source, "topology"))
    bonds, networks = _bondForces([len(chain) for chain in chains], positions, found)
    ashbaughHatch, yukawa = _ashbaughHatch(), _yukawa(temperature, ionicStrength)
    system = openmm.System()
    for chain in chains:
        for place, bead in enumerate(chain):
            isFirst, isLast = place == 0, place == len(chain) - 1
            system.addParticle(bead.mass + _MASS_OF_N_TERMINUS * isFirst + _MASS_OF_C_TERMINUS * isLast)
            ashbaughHatch.addParticle([bead.sigma, bead.stickiness])
            yukawa.addParticle([_chargeOf(bead, pH) + isFirst - isLast])
    _exclude((ashbaughHatch, yukawa), (bonds, networks))
    if lengths is not None:
        system.setDefaultPeriodicBoxVectors(*np.diag(lengths))
        for force in (ashbaughHatch, yukawa):
            force.setNonbondedMethod(force.CutoffPeriodic)
        for force in (bonds, networks):
            force.setUsesPeriodicBoundaryConditions(True)
    for force in (ashbaughHatch, yukawa, bonds, *([networks] if networks.getNumBonds() > 0 else [])):
        system.addForce(force)
    return CalvadosSystem(_makeTopology(chains, lengths), system, positions)


# ---- Residues ----


@cache
def _readBeads(model):
    column = 6 + MODELS.index(model)
    beads = {}
    for row in readTable("calvados.csv"):
        letter, residue, mass, charge, pKa, sigma = row[:6]
        if row[column]:
            constant = float(pKa) if pKa else None
            beads[letter] = _Bead(residue, float(mass), float(charge), constant, float(sigma), float(row[column]))
    return beads


def _beadOf(name, model):
    """Return the bead of a residue by its letter or name."""
    table = _readBeads(model)
    byName = {bead.residue: bead for bead in table.values()}
    bead = table.get(name) or byName.get(name) or byName.get(aminoAcid(name))
    if bead is None:
        raise InputError(f"{model} has no residue {name}")
    return bead


def _chargeOf(bead, pH):
    """Return the mean charge of a bead by Henderson and Hasselbalch, without that of a terminus."""
    return bead.charge if bead.pKa is None else bead.charge + 1 / (1 + 10 ** (pH - bead.pKa))


def _readChains(source, model, lengths):
    """Return the beads of each chain, and their places (nm)."""
    if hasattr(source, "topology"):
        names, positions = placesOfResidues(source, usesMassCenters=model == "calvados3")
        if not names:
            raise InputError("the structure has no amino acid with a Cα atom")
    else:
        names = ["".join(each.split()) for each in ([source] if isinstance(source, str) else source)]
        if not names or not all(names):
            raise InputError("a sequence is empty")
        if len(names) > 1 and lengths is None:
            raise InputError("several chains need a box: without one they drift apart")
        positions = layOut([len(chain) for chain in names], MEAN_BOND, lengths)
    return [[_beadOf(name, model) for name in chain] for chain in names], positions


def _lengthsOf(box):
    """Return the lengths of a box, checked."""
    lengths = np.asarray(inUnit(box, "nm", "box"), dtype=np.float64)
    if lengths.shape != (3,) or not (lengths >= 2 * _YUKAWA_CUTOFF).all():
        raise InputError(f"box must be three lengths of {2 * _YUKAWA_CUTOFF:g} nm, twice the largest cutoff, or more")
    return lengths


# ---- Domains, bonds and energies ----


def _readDomains(domains, count, hasPositions):
    """Return the sets of residues of domains."""
    found = [frozenset(int(residue) for residue in domain) for domain in domains]
    if found and not hasPositions:
        raise InputError("domains need a structure with positions, not a sequence")
    for domain in found:
        for residue in domain:
            if not 0 <= residue < count:
                raise InputError(f"domains names residue {residue}, but there are {count:,} residues")
    return found


def _makeTopology(chains, lengths):
    topology = app.Topology()
    if lengths is not None:
        topology.setUnitCellDimensions(lengths * unit.nanometer)
    for beads in chains:
        chain, previous = topology.addChain(), None
        for bead in beads:
            atom = topology.addAtom("CA", app.element.carbon, topology.addResidue(bead.residue, chain))
            if previous is not None:
                topology.addBond(previous, atom)
            previous = atom
    return topology


def _bondForces(counts, positions, domains):
    """Return the harmonic bonds of chains, and the elastic networks of domains."""
    bonds, networks = openmm.HarmonicBondForce(), openmm.HarmonicBondForce()
    inDomain = frozenset().union(*domains)
    first = 0
    for count in counts:
        for i in range(first, first + count - 1):
            length = math.dist(positions[i], positions[i + 1]) if inDomain & {i, i + 1} else _BOND
            bonds.addBond(i, i + 1, length, _STIFFNESS)
        first += count
    pairs = {pair for domain in domains for pair in combinations(sorted(domain), 2) if pair[1] > pair[0] + 1}
    for i, j in sorted(pairs):
        distance = math.dist(positions[i], positions[j])
        if distance <= _NETWORK_REACH:
            networks.addBond(i, j, distance, _NETWORK_STIFFNESS)
    return bonds, networks


def _exclude(nonbonded, bonded):
    """Exclude the pairs of bonded Forces from nonbonded ones."""
    for bonds in bonded:
        for index in range(bonds.getNumBonds()):
            first, second = bonds.getBondParameters(index)[:2]
            for force in nonbonded:
                force.addExclusion(first, second)


def _ashbaughHatch():
    force = openmm.CustomNonbondedForce(
        f"{_EPSILON}*select(step(r-2^(1/6)*s), 4*l*((s/r)^12-(s/r)^6-shift), 4*((s/r)^12-(s/r)^6-l*shift)+(1-l));"
        f"l=0.5*(l1+l2); shift=(s/{_CUTOFF})^12-(s/{_CUTOFF})^6; s=0.5*(s1+s2)"
    )
    for name in ("s", "l"):
        force.addPerParticleParameter(name)
    force.setNonbondedMethod(force.CutoffNonPeriodic)
    force.setCutoffDistance(_CUTOFF * unit.nanometer)
    return force


def _yukawa(t, ionicStrength):
    permittivity = 5321 / t + 233.76 - 0.9297 * t + 1.417e-3 * t**2 - 8.292e-7 * t**3
    thermal = 8.3145e-3 * t  # kJ/mol
    bjerrum = 1.6021766**2 / (4 * math.pi * 8.854188 * permittivity) * 6022.14076 / thermal  # nm
    screening = math.sqrt(8 * math.pi * bjerrum * ionicStrength * 0.602214076)  # 1/nm
    shift = math.exp(-screening * _YUKAWA_CUTOFF) / _YUKAWA_CUTOFF
    force = openmm.CustomNonbondedForce(f"q*{bjerrum * thermal}*(exp(-{screening}*r)/r-{shift}); q=q1*q2")
    force.addPerParticleParameter("q")
    force.setNonbondedMethod(force.CutoffNonPeriodic)
    force.setCutoffDistance(_YUKAWA_CUTOFF * unit.nanometer)
    force.setForceGroup(1)  # platforms want one cutoff in a group
    return force
