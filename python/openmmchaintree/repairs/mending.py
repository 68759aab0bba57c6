"""Mending broken bonds: residues with them get ideal distances by OpenMM's minimizer, and all others stay."""

from functools import cache

import numpy as np
import openmm
from openmm import unit

from ..bonds import BondGraph, polymerLinks
from ..extras import importExtra
from ..residues import isPolymer
from ..scoring.covalentfaults import covalentFaults
from ..templates import atomAliases, standardName
from .carrying import carryAlong

_BONDED, _ANGLE, _START = 3e5, 1e5, 50.0  # kJ/mol/nm²: bonds, distances of atoms two bonds apart, and springs
_HYDROGEN = 1

# Distances (nm) between two residues by the names of their atoms, first that of the residue that comes first. Peptides:
# Engh and Huber, Acta Cryst. A47, 392 (1991), with Cα–Cα of trans; nucleotides: Gelbin et al., JACS 118, 519 (1996).
_LINKS = {
    ("C", "N"): (0.1329, _BONDED), ("CA", "N"): (0.2425, _ANGLE), ("O", "N"): (0.2250, _ANGLE),
    ("C", "CA"): (0.2435, _ANGLE),
    ("O3'", "P"): (0.1607, _BONDED), ("C3'", "P"): (0.2610, _ANGLE), ("O3'", "O5'"): (0.2505, _ANGLE),
    ("O3'", "OP1"): (0.2520, _ANGLE), ("O3'", "OP2"): (0.2520, _ANGLE),
}  # fmt: skip
_TRANS, _CIS = 0.380, 0.295  # Cα to Cα


def mendBonds(topology, positions):
    """Return positions (nm) with ideal bonds and angles in residues with broken bonds, and the names of these bonds.

    positions : (n, 3) float64 array, nm

    Ideal distances within residues are those of the chemical component dictionary. Residues that it lacks stay.
    """
    broken = covalentFaults(topology, positions).brokenBonds
    if not broken:
        return positions, []
    graph = BondGraph(topology, positions)
    residues = {int(graph.residueOf[atom]) for bond in broken for atom in (bond.particle1, bond.particle2)}
    chosen = [residue for residue in topology.residues() if residue.index in residues and isPolymer(residue)]
    moving = np.zeros(len(positions), dtype=bool)
    springs = {}
    for residue in chosen:
        inside = _distancesWithin(residue, graph)
        springs |= inside
        if inside:
            moving[[atom.index for atom in residue.atoms() if graph.numbers[atom.index] > _HYDROGEN]] = True
    springs |= _distancesBetween(graph, positions, moving)
    mended = _minimize(positions, moving, springs)
    hydrogens = np.flatnonzero(graph.numbers == _HYDROGEN)
    parents = np.array([next(iter(graph.heavyNeighborsOf(atom)), -1) for atom in hydrogens.tolist()], dtype=int)
    follows = (parents >= 0) & moving[parents]
    heavy = [[other for other in near if graph.numbers[other] > _HYDROGEN] for near in graph.neighbors]
    chosen = hydrogens[follows]
    mended[chosen] = carryAlong(heavy, positions, mended, parents[follows], positions[chosen])
    return mended, [graph.describePair((bond.particle1, bond.particle2)) for bond in broken]


def _distancesWithin(residue, graph):
    """Return ideal distances (nm) of heavy atoms up to two bonds apart, with their stiffness, by pairs of atoms."""
    ideal = _idealPlaces(standardName(residue.name))
    aliases = atomAliases(standardName(residue.name))
    names = {atom.index: aliases.get(atom.name, atom.name) for atom in residue.atoms()}
    own = [atom for atom in names if graph.numbers[atom] > _HYDROGEN]
    if any(names[atom] not in ideal for atom in own):
        return {}
    found = {}
    inside = set(own)
    for atom in own:
        near = [other for other in graph.neighbors[atom] if other in inside]
        for number, first in enumerate(near):
            found[tuple(sorted((atom, first)))] = _BONDED
            for second in near[number + 1 :]:
                found.setdefault(tuple(sorted((first, second))), _ANGLE)
    places = {atom: ideal[names[atom]] for atom in own}
    return {
        pair: (float(np.linalg.norm(places[pair[0]] - places[pair[1]])), stiffness) for pair, stiffness in found.items()
    }


@cache
def _idealPlaces(name):
    """Return the ideal places (nm) of the atoms of a residue by their names, {} for an unknown one."""
    info = importExtra("biotite.structure.info", "mending bonds")
    try:
        atoms = info.residue(name)
    except KeyError:
        return {}
    return dict(zip(atoms.atom_name.tolist(), 0.1 * atoms.coord.astype(np.float64), strict=True))


def _distancesBetween(graph, positions, moving):
    """Return ideal distances across the links of residues of which one moves, as `_distancesWithin` does."""
    found = {}
    for first, second in polymerLinks(graph.atoms, graph.bonds):
        before = {atom.name: atom.index for atom in first.residue.atoms()}
        after = {atom.name: atom.index for atom in second.residue.atoms()}
        pairs = dict(_LINKS)
        if "CA" in before and "CA" in after:
            length = np.linalg.norm(positions[before["CA"]] - positions[after["CA"]])
            pairs["CA", "CA"] = _CIS if length < 0.5 * (_CIS + _TRANS) else _TRANS, _ANGLE
        for (name1, name2), value in pairs.items():
            if name1 in before and name2 in after and (moving[before[name1]] or moving[after[name2]]):
                found[tuple(sorted((before[name1], after[name2])))] = value
    return found


def _minimize(positions, moving, distances):
    """Return positions (nm) at the minimum of springs for distances, with weak springs to the start."""
    system = openmm.System()
    bonds = openmm.HarmonicBondForce()
    start = openmm.CustomExternalForce(f"0.5*{_START}*((x-x0)^2+(y-y0)^2+(z-z0)^2)")
    for name in ("x0", "y0", "z0"):
        start.addPerParticleParameter(name)
    for atom, moves in enumerate(moving.tolist()):
        system.addParticle(1.0 if moves else 0.0)
        if moves:
            start.addParticle(atom, positions[atom])
    for pair, (length, stiffness) in distances.items():
        if moving[list(pair)].any():
            bonds.addBond(*pair, length, stiffness)
    system.addForce(bonds)
    system.addForce(start)
    platform = openmm.Platform.getPlatformByName("Reference")
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), platform)
    context.setPositions(positions)
    openmm.LocalEnergyMinimizer.minimize(context, 0.1, 5000)
    mended = context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    return np.where(moving[:, None], mended, positions)
