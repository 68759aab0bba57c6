"""A Topology for a System that comes without one, from elements and bonds."""

from collections import Counter
from collections.abc import Iterable

import openmm
from openmm import app, unit

from .graphs import connectedParts
from .systemreading import bondsOf, drudeParticles

# Masses (Da) of an element differ by less among force fields.
_MASS_TOLERANCE = 0.1

_RESIDUE = "UNL"  # the name of an unknown ligand in the Protein Data Bank


def createTopology(
    system: openmm.System,
    elements: Iterable[app.Element | str | int | None] | None = None,
    bonds: Iterable[tuple[int, int]] | None = None,
) -> app.Topology:
    """Create a Topology for a System that comes without one.

    Molecules become chains of one residue, and atoms are named by their elements. So `findTorsions` and selections find
    no amino acids, but all bonds outside rings turn with

        topology = createTopology(system)
        createStericExclusionForce(topology, positions, torsions="all", system=system)

    Parameters
    ----------
    system : openmm.System
        the System whose particles become atoms
    elements : iterable of openmm.app.Element, str, int or None, optional
        the element of each particle, as an Element, its symbol or atomic number; None for beads and extra particles,
        which have no default radius. Default: by masses; virtual sites and Drude particles get None.
    bonds : iterable of (int, int), optional
        Default: the bonds of the System's HarmonicBondForces, constraints and DrudeForces. A hydrogen has only the
        shortest of its bonds, since the others constrain angles.

    Returns
    -------
    openmm.app.Topology

    Raises
    ------
    ValueError
        if the numbers of elements and particles differ, no element has a mass, or a bond names no particle
    """
    count = system.getNumParticles()
    found = _elementsByMass(system) if elements is None else [_asElement(element) for element in elements]
    if len(found) != count:
        raise ValueError(f"there are {len(found):,} elements, but {count:,} particles")
    pairs = _bondsOfSystem(system, found) if bonds is None else [(int(first), int(second)) for first, second in bonds]
    for pair in pairs:
        if not all(0 <= particle < count for particle in pair):
            raise ValueError(f"bonds names particles {pair[0]} and {pair[1]}, but there are {count:,} particles")
    return _makeTopology(found, pairs)


def _makeTopology(elements, bonds):
    """Make the Topology: consecutive atoms of a molecule are a residue, since a residue's atoms must be consecutive."""
    topology = app.Topology()
    parts = connectedParts(len(elements), bonds).tolist() if elements else []
    atoms, names = [], Counter()
    for index, (element, part) in enumerate(zip(elements, parts, strict=True)):
        if index == 0 or parts[index - 1] != part:
            residue = topology.addResidue(_RESIDUE, topology.addChain())
            names.clear()
        symbol = "X" if element is None else element.symbol
        names[symbol] += 1
        atoms.append(topology.addAtom(f"{symbol}{names[symbol]}", element, residue))
    for first, second in bonds:
        topology.addBond(atoms[first], atoms[second])
    return topology


def _asElement(element):
    if isinstance(element, str):
        return app.Element.getBySymbol(element)
    if element is None or isinstance(element, app.Element):
        return element
    return app.Element.getByAtomicNumber(int(element)) if int(element) > 0 else None


def _elementsByMass(system):
    without = {drude for drude, _ in drudeParticles(system)}
    elements = []
    for particle in range(system.getNumParticles()):
        mass = system.getParticleMass(particle).value_in_unit(unit.dalton)
        if particle in without or system.isVirtualSite(particle):
            elements.append(None)
            continue
        element = app.Element.getByMass(mass)
        if element is None or abs(element.mass.value_in_unit(unit.dalton) - mass) > _MASS_TOLERANCE:
            raise ValueError(f"particle {particle} has the mass {mass:g} Da, which no element has: give elements")
        elements.append(element)
    return elements


def _bondsOfSystem(system, elements):
    """Return the bonds of a System as sorted pairs, with only the shortest bond of each hydrogen."""
    lengths = {}
    for first, second, length, _ in bondsOf(system):
        pair = min(first, second), max(first, second)
        lengths[pair] = min(length, lengths.get(pair, length))
    nearest = {}
    for pair in sorted(lengths, key=lengths.get):
        for particle in pair:
            nearest.setdefault(particle, pair)

    def isHydrogen(particle):
        return elements[particle] is not None and elements[particle].atomic_number == 1

    def isExtra(particle):
        return elements[particle] is None

    def counts(pair):
        if any(map(isExtra, pair)):
            return True
        return all(nearest[particle] == pair for particle in pair if isHydrogen(particle))

    return sorted(pair for pair in lengths if counts(pair))
