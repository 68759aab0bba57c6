"""Fixing particles of a System: mass 0, and no constraint between a fixed and a moving particle."""

from openmm import unit

from ..errors import InputError


def fixParticles(system, plan):
    """Give the fixed atoms of a Plan mass 0 in a System.

    OpenMM refuses constraints of a particle without mass to one that moves. Torsion moves keep the distance of bonded
    atoms, and of atoms bonded to one atom, so their constraints are removed; OpenMM refuses others.

    Raises
    ------
    InputError
        if bond lengths change, and constraints keep some of them
    """
    fixed = plan.fixed.tolist()
    pairs = [system.getConstraintParameters(i)[:2] for i in range(system.getNumConstraints())]
    if plan.choice.isFlexible and not all(fixed[first] and fixed[second] for first, second in pairs):
        raise InputError(
            "--flexible: the System is built with constraints, which keep bond lengths: build it with constraints=None"
        )
    neighbors = plan.graph.neighbors
    for index in reversed(range(len(pairs))):
        first, second = pairs[index]
        isKept = second in neighbors[first] or not set(neighbors[first]).isdisjoint(neighbors[second])
        if fixed[first] != fixed[second] and isKept:
            system.removeConstraint(index)
    for particle, isFixed in enumerate(fixed):
        if isFixed:
            system.setParticleMass(particle, 0 * unit.dalton)
