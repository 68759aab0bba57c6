"""The density of torsions in a random coil: as the energy of a Force, and as densities for moves that draw torsions."""

import functools
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import openmm
from openmm import app
from openmm.unit import MOLAR_GAS_CONSTANT_R, kelvin, kilojoule_per_mole

from .datatables import readRows
from .densities import DrawnTorsions, loopCounts, loopKind, rotamerDensity, rotamersOf, torsionIndices
from .densitymaps import binsOf, mapOf, smoothLogDensity
from .errors import InputError
from .openmmchaintree import StericExclusionForce, TorsionDensity
from .residues import isMirrored
from .selection import AtomSelection
from .torsions import findTorsions
from .units import Array, Number, inUnit

_FLOOR = 0.01  # the share of p that is uniform, so that no energy is infinite
_DIVISION = 3  # of bins, for draws: p changes by little within a third
_NODES = 60  # of the map of a density of rotamers
_FEWEST_BINS = 6
# φ, ψ, and the standard deviation of both, in degrees.
_BELLS = {"helix": (-63, -42, 8), "extended": (-120, 130, 18), "polyproline": (-70, 148, 12)}
_BACKBONE, _SIDE_CHAIN = ("phi", "psi"), ("chi1", "chi2", "chi3", "chi4")

CoilTables = Mapping[str, Array] | str | Path


class _Set(NamedTuple):
    """One or two torsions with a common density.

    torsions : tuple of tuples of four atoms; name : str, of the table; isMirrored : bool
    axes : tuple of int, of the table, or for side chains the numbers of their χ from 0
    isSideChain : bool
    """

    torsions: tuple
    name: str
    isMirrored: bool
    axes: tuple
    isSideChain: bool


def createCoilForce(
    topology: app.Topology,
    temperature: Number = 298.0,
    positions: Array | None = None,
    selection: AtomSelection | None = None,
    tables: CoilTables | None = None,
    sideChains: bool = True,
    kinds: Mapping[int, str] | None = None,
) -> openmm.CMAPTorsionForce:
    """Create a Force whose energy is −kT ln p, with the density p of torsions in a random coil.

    At the same temperature, chains without other interactions have φ and ψ as in the tables. The tables hold the
    frequencies of φ and ψ in residues of each kind outside helices and strands, in bins of 12 degrees (see
    `ramachandranDensities`); residues before a proline have a separate table. ln p is a periodic cubic spline whose
    mean density in each bin is that of the table. Where the first or last residue of a chain, or proline, has only one
    of the two torsions, the other one is averaged over. Side chains have the density of `rotamerDensities`: of χ1 and
    χ2 together, and of χ3 and χ4. 1 % of each density is uniform. D-amino acids have the mirror images. The energy is 0
    where p is uniform.

        system.addForce(createCoilForce(topology, temperature=300))

    Parameters
    ----------
    topology : openmm.app.Topology
    temperature : float or Quantity
        K, that of the simulation
    positions : array of shape (n, 3) or Quantity, optional
        nm. With them, a bond between residues that is longer than 0.4 nm is a gap in the chain.
    selection : str, array of int or bool, or callable, optional
        the atoms whose torsions get an energy, as in `findTorsions`. Default: all.
    tables : mapping of str to array, or path, optional
        other frequencies of φ (rows) and ψ (columns) in equal bins from −180 degrees on, by the name of the amino acid,
        "prePRO" (any but glycine and proline before a proline), "transPRO", or an amino acid and the next one as in
        "ALA-GLY"; tables that are not given are those of the package. Or a CSV file with the columns residue, phi (the
        lower end of a bin, in degrees), and counts by psi, between spaces.
    sideChains : bool
        whether side chains get an energy
    kinds : mapping of int to str, optional
        the names of the tables of some residues, by their index in the Topology, in place of those of their amino
        acids: given ones, "helix", "extended" or "polyproline", which are bells about the φ and ψ of these structures

    Returns
    -------
    openmm.CMAPTorsionForce

    Raises
    ------
    ValueError
        if no torsion has a density
    InputError
        if a table cannot be read or has too few bins, negative numbers, or none above 0
    """
    tables = readCoilTables(tables)
    energy = (MOLAR_GAS_CONSTANT_R * float(inUnit(temperature, "K", "temperature")) * kelvin).value_in_unit(
        kilojoule_per_mole
    )
    if not energy > 0:
        raise InputError("temperature must be above 0")
    force = openmm.CMAPTorsionForce()
    force.setName("CoilForce")
    maps = {}
    for found in _findSets(topology, positions, selection, tables, sideChains, kinds or {}):
        key = found[1:]
        if key not in maps:
            nodes = -energy * _mapOfSet(found, tables)
            maps[key] = force.addMap(len(nodes), nodes.ravel(order="F").tolist())
        force.addTorsion(maps[key], *found.torsions[0], *found.torsions[-1])
    if force.getNumTorsions() == 0:
        raise ValueError("no torsion is one of amino acids in tables of random coils")
    return force


def coilDensities(
    topology: app.Topology,
    force: StericExclusionForce,
    selection: AtomSelection | None = None,
    tables: CoilTables | None = None,
    kinds: Mapping[int, str] | None = None,
) -> DrawnTorsions:
    """Find φ and ψ of the residues of a Topology, with the density that `createCoilForce` makes an energy of.

    The density is constant in bins of 4 degrees. Beside that energy, nearly every draw is accepted that meets no other
    interaction.

    Parameters
    ----------
    topology, selection, tables, kinds
        as for `createCoilForce`
    force : StericExclusionForce
        as `createStericExclusionForce` makes it for this Topology

    Returns
    -------
    DrawnTorsions
        torsions: the sets; density: one for each. `TorsionMonteCarloIntegrator.addDrawnMove` takes it as it is.

    Raises
    ------
    ValueError, InputError
        as `createCoilForce`
    """
    tables = readCoilTables(tables)
    indices = torsionIndices(force)
    drawn, densities = DrawnTorsions([], []), {}
    for found in _findSets(topology, None, selection, tables, False, kinds or {}):
        turning = [(indices[one], axis) for one, axis in zip(found.torsions, found.axes, strict=True) if one in indices]
        if not turning:
            continue
        torsions, axes = zip(*turning, strict=True)
        key = found.name, found.isMirrored, axes
        if key not in densities:
            densities[key] = TorsionDensity.fromTable(binsOf(_smooth(found._replace(axes=axes), tables), _DIVISION))
        drawn.torsions.append(torsions)
        drawn.density.append(densities[key])
    if not drawn.torsions:
        raise ValueError("no torsion of the StericExclusionForce is one of amino acids in tables of random coils")
    return drawn


def _findSets(topology, positions, selection, tables, sideChains, own):
    """Generate the _Sets of all residues with a density."""
    residues, atoms = {}, list(topology.atoms())
    searched = (*_BACKBONE, *_SIDE_CHAIN) if sideChains else _BACKBONE
    search = findTorsions(topology, positions, searched, cutDisulfides=True, cutMetals=True, selection=selection)
    for torsion in search.torsions:
        _, torsions = residues.setdefault(torsion.residue.index, (torsion.residue, {}))
        torsions[torsion.kind] = torsion.particles
    for residue, torsions in residues.values():
        following = atoms[torsions["psi"][3]].residue if "psi" in torsions else None
        name = own.get(residue.index) or tableOf(residue.name, following and following.name, tables)
        if name is not None and name not in tables:
            raise InputError(f"there is no table {name!r} of phi and psi")
        mirrored = isMirrored(residue.name)
        axes = tuple(axis for axis, kind in enumerate(_BACKBONE) if kind in torsions)
        if name is not None and axes:
            yield _Set(tuple(torsions[_BACKBONE[axis]] for axis in axes), name, mirrored, axes, False)
        chis = [number for number, kind in enumerate(_SIDE_CHAIN) if kind in torsions]
        name = rotamersOf(residue.name)
        if name is not None:
            for first in (0, 2):
                pair = tuple(number for number in chis if first <= number < first + 2)
                if pair:
                    yield _Set(tuple(torsions[_SIDE_CHAIN[number]] for number in pair), name, mirrored, pair, True)


def tableOf(residueName, nextName, tables):
    """Return the name of the table of φ and ψ of a residue, given the next residue's name or None; None without one."""
    kind, after = loopKind(residueName, nextName), nextName and loopKind(nextName)
    pair = f"{_plainName(loopKind(residueName))}-{_plainName(after)}" if after else None
    return next((name for name in (pair, kind) if name in tables), None)


def _plainName(kind):
    """Return the amino acid of a kind of residue."""
    return "PRO" if kind == "transPRO" else kind


def _mapOfSet(found, tables):
    """Return ln p of a _Set at the nodes of a square map."""
    if found.isSideChain:
        values = _rotamerMap(found.name, found.isMirrored, found.axes)
    else:
        values = mapOf(_smooth(found, tables))
    return np.tile(values, (len(values), 1)) if values.ndim == 1 else values


def _smooth(found, tables):
    """Return ln p of φ and ψ, or of one of them, at the centers of bins."""
    counts = tables[found.name]
    if found.isMirrored:
        counts = counts[::-1, ::-1]
    if len(found.axes) == 1:
        counts = counts.sum(axis=1 - found.axes[0])
    return _smoothCounts(counts.tobytes(), counts.shape)


@functools.lru_cache(maxsize=1000)
def _smoothCounts(data, shape):
    return smoothLogDensity(np.frombuffer(data).reshape(shape), _FLOOR)


@functools.cache
def _rotamerMap(name, mirrored, chis):
    density = rotamerDensity(name, mirrored, chis, _FLOOR)
    angles = np.arange(_NODES) * 2 * np.pi / _NODES
    angles = np.where(angles > np.pi, angles - 2 * np.pi, angles)
    points = np.stack(np.meshgrid(*[angles] * len(chis), indexing="ij"), axis=-1).reshape(-1, len(chis))
    values = np.array([density.evaluate(point.tolist()) for point in points])
    return np.log(values * (2 * np.pi) ** len(chis)).reshape([_NODES] * len(chis))


def readCoilTables(tables):
    """Return the tables by name, as float64 arrays: those of the package, and given ones in their place."""
    given = {} if tables is None else _readFile(tables) if isinstance(tables, str | Path) else tables
    found = {name: np.asarray(table, dtype=np.float64) for name, table in {**loopCounts(), **_bells(), **given}.items()}
    for name in given:
        _check(name, found[name])
    return found


@functools.cache
def _bells():
    """Return tables of secondary structures: bells about their φ and ψ."""
    angles = np.radians(np.arange(-180 + 2.5, 180, 5))
    found = {}
    for name, (*middle, width) in _BELLS.items():
        phi, psi = (np.exp((np.cos(angles - np.radians(place)) - 1) / np.radians(width) ** 2) for place in middle)
        found[name] = np.outer(phi, psi)
    return found


def _check(name, table):
    if table.ndim != 2 or table.shape[0] != table.shape[1] or len(table) < _FEWEST_BINS:
        raise InputError(f"the table of {name} must have as many columns as rows, at least {_FEWEST_BINS}")
    if not (np.isfinite(table).all() and (table >= 0).all() and table.sum() > 0):
        raise InputError(f"the table of {name} must have no negative number, and one above 0")


def _readFile(path):
    """Return the tables of a CSV file, by name."""
    rows = {}
    try:
        for residue, phi, counts in readRows(path):
            rows.setdefault(residue, []).append((float(phi), [float(count) for count in counts.split()]))
        found = {name: np.array([counts for _, counts in sorted(lines)]) for name, lines in rows.items()}
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from error
    except ValueError as error:
        raise InputError(f"{path}: is no table with the columns residue, phi and counts ({error})") from error
    if not found:
        raise InputError(f"{path}: holds no table")
    return found
