"""Densities of the torsions of proteins, by residue, for moves that draw torsions.

The tables are in `tables`, each with its source.
"""

import functools
from typing import NamedTuple

import numpy as np
from openmm import app

from .datatables import readTable
from .openmmchaintree import StericExclusionForce, TorsionDensity
from .residues import aminoAcid, isMirrored
from .selection import AtomSelection
from .torsions import findTorsions
from .units import inUnit

# The table of rotamers gives the last chi of these modulo half a turn.
ENDS_ALIKE = ("ASP", "GLU", "PHE", "TYR")
# Amino acids without rotamers in the table, and the amino acid whose rotamers they get.
_STAND_INS = {"MSE": "MET"}


class DrawnTorsions(NamedTuple):
    """Sets of torsions, by their indices in a StericExclusionForce, and the density of each."""

    torsions: list[tuple[int, ...]]
    density: list[TorsionDensity]


def rotamerDensities(
    topology: app.Topology,
    force: StericExclusionForce,
    selection: AtomSelection | None = None,
    floor: float = 0.1,
    parts: bool = True,
) -> DrawnTorsions:
    """Find the side chains of a Topology, with the density of their rotamers.

    A set is all χ of a residue that are torsions of the force, or some consecutive ones: in a folded protein, a side
    chain often has room to turn only its end, or only χ1. Its density is a sum of bells, one for each rotamer, with the
    frequencies, means and standard deviations of MolProbity's ultimate rotamer library (Hintze, Lewis, Richardson and
    Richardson, Proteins 84, 1177 (2016)), independent of the backbone and of χ outside the set. D-amino acids have the
    mirror images, and selenomethionine has the rotamers of methionine. Residues that the library lacks have no set.

    Parameters
    ----------
    topology : openmm.app.Topology
        that the force was made for
    force : StericExclusionForce
        as `createStericExclusionForce` makes it; torsions that it defines by other particles than `findTorsions` are
        left out
    selection : str, array of int or bool, or callable, optional
        the atoms whose torsions are wanted, as in `findTorsions`. Default: all.
    floor : float
        the share of draws of each χ that are uniform, above 0 and at most 1
    parts : bool
        whether there are sets of parts of a side chain, such as χ1 alone, χ1 and χ2, or χ2 alone. If not, each side
        chain is drawn as a whole.

    Returns
    -------
    DrawnTorsions
        torsions: the sets; density: one for each. `TorsionMonteCarloIntegrator.addDrawnMove` takes it as it is.

    Raises
    ------
    ValueError
        if there is no such torsion, or the selection selects nothing
    """
    floor = inUnit(floor, "1", "floor")
    drawn = DrawnTorsions([], [])
    for residue, torsions in _torsionsByResidue(topology, force, ("chi1", "chi2", "chi3", "chi4"), selection):
        name = rotamersOf(residue.name)
        if name is None:
            continue
        chis = tuple(sorted(int(kind[-1]) - 1 for kind in torsions))
        for run in _runs(chis) if parts else (chis,):
            drawn.torsions.append(tuple(torsions[f"chi{chi + 1}"] for chi in run))
            drawn.density.append(rotamerDensity(name, isMirrored(residue.name), run, floor))
    return _notEmpty(drawn, "side chains")


def ramachandranDensities(
    topology: app.Topology,
    force: StericExclusionForce,
    selection: AtomSelection | None = None,
    floor: float = 0.1,
) -> DrawnTorsions:
    """Find φ and ψ of the residues of a Topology, with their density in loops.

    A set is φ and ψ of a residue, or only φ or ψ if the force lacks the other. Its density is a table of the
    frequencies of φ and ψ in residues of its kind outside helices and strands, in bins of 12°: the loops of the
    Ramachandran Z-score (Sobolev et al., Structure 28, 1249 (2020)). Residues before a proline have a separate table.
    Prolines have the density of ψ in trans prolines. D-amino acids have the mirror images. Residues that are no amino
    acids have no set.

    Parameters
    ----------
    topology : openmm.app.Topology
        that the force was made for
    force : StericExclusionForce
        as `createStericExclusionForce` makes it; torsions that it defines by other particles than `findTorsions` are
        left out
    selection : str, array of int or bool, or callable, optional
        the atoms whose torsions are wanted, as in `findTorsions`. Default: all.
    floor : float
        the share of draws that are uniform, above 0 and at most 1

    Returns
    -------
    DrawnTorsions
        torsions: the sets; density: one for each. `TorsionMonteCarloIntegrator.addDrawnMove` takes it as it is.

    Raises
    ------
    ValueError
        if there is no such torsion, or the selection selects nothing
    """
    floor = inUnit(floor, "1", "floor")
    drawn = DrawnTorsions([], [])
    atoms = list(topology.atoms())
    for residue, torsions in _torsionsByResidue(topology, force, ("phi", "psi"), selection):
        following = None
        if "psi" in torsions:
            ends = (force.getTorsionParticles(torsions["psi"])[end] for end in (0, 3))
            following = next((atoms[end].residue for end in ends if atoms[end].residue is not residue), None)
        name = loopKind(residue.name, following and following.name)
        if name is None:
            continue
        kinds = tuple(kind for kind in ("phi", "psi") if kind in torsions)
        drawn.torsions.append(tuple(torsions[kind] for kind in kinds))
        drawn.density.append(_loopDensity(name, isMirrored(residue.name), kinds, floor))
    return _notEmpty(drawn, "backbones of proteins")


def torsionIndices(force):
    """Return the index of each torsion of a StericExclusionForce by its four particles, in both directions."""
    indices = {}
    for index in range(force.getNumTorsions()):
        particles = tuple(force.getTorsionParticles(index))
        indices[particles] = indices[particles[::-1]] = index
    return indices


def _torsionsByResidue(topology, force, kinds, selection):
    """Generate (residue, {kind: index of the force's torsion}) for residues with torsions of these kinds."""
    indices = torsionIndices(force)
    found = {}
    search = findTorsions(topology, kinds=kinds, cutDisulfides=True, cutMetals=True, selection=selection)
    for torsion in search.torsions:
        if torsion.particles in indices:
            _, torsions = found.setdefault(torsion.residue.index, (torsion.residue, {}))
            torsions[torsion.kind] = indices[torsion.particles]
    yield from found.values()


def _runs(chis):
    """Generate all runs of consecutive items of a tuple, longer ones first."""
    for length in range(len(chis), 0, -1):
        for first in range(len(chis) - length + 1):
            yield chis[first : first + length]


def _notEmpty(drawn, what):
    if not drawn.torsions:
        raise ValueError(f"no torsion of the StericExclusionForce is one of {what} in tables")
    return drawn


def rotamersOf(residueName):
    """Return the name of a residue in the table of rotamers; None if it is not there."""
    name = _nameInTables(residueName)
    return name if name in rotamerTables() else None


@functools.cache
def rotamerDensity(name, mirrored, chis, floor):
    """Return the TorsionDensity of some χ, by their numbers from 0, of an amino acid in the table of rotamers."""
    counts, means, deviations = rotamerTables()[name]
    means = -means if mirrored else means
    last = means.shape[1] - 1
    if name in ENDS_ALIKE and last in chis:
        turned = means + np.where(np.arange(last + 1) == last, 180, 0)
        counts, deviations = np.tile(counts, 2), np.tile(deviations, (2, 1))
        means = (np.concatenate((means, turned)) + 180) % 360 - 180
    return TorsionDensity.fromRotamers(counts, np.radians(means[:, chis]), np.radians(deviations[:, chis]), floor)


@functools.cache
def _loopDensity(name, mirrored, kinds, floor):
    counts = loopCounts()[name]
    if mirrored:
        counts = counts[::-1, ::-1]
    if len(kinds) == 1:
        counts = counts.sum(axis=1 if kinds == ("phi",) else 0)
    return TorsionDensity.fromTable(counts, floor)


def _nameInTables(residueName):
    name = aminoAcid(residueName)
    return _STAND_INS.get(name, name)


def loopKind(residueName, nextName=None):
    """Return the name of a residue in the table of loops, given the next residue's name; None for other residues."""
    name = _nameInTables(residueName)
    if name == "PRO":
        return "transPRO"
    if nextName is not None and aminoAcid(nextName) == "PRO" and name not in (None, "GLY"):
        return "prePRO"
    return name


@functools.cache
def rotamerTables():
    """Return for each amino acid the counts of its rotamers, and means and deviations of each χ in degrees."""
    rows = {}
    for residue, _, *numbers in readTable("rotamers.csv"):
        rows.setdefault(residue, []).append([float(number) for number in numbers])
    tables = {residue: np.array(table) for residue, table in rows.items()}
    return {residue: (table[:, 0], table[:, 1::2], table[:, 2::2]) for residue, table in tables.items()}


@functools.cache
def loopCounts():
    """Return for each kind of residue the counts by φ and ψ."""
    rows = {}
    for residue, _, counts in readTable("loops.csv"):
        rows.setdefault(residue, []).append([int(count) for count in counts.split()])
    return {residue: np.array(table) for residue, table in rows.items()}
