"""Contexts of a StericExclusionForce alone, for asking it about any positions."""

import openmm


def contextOf(force):
    """Return a Context of a System with nothing but a StericExclusionForce, on the Reference platform."""
    system = openmm.System()
    for _ in range(force.getNumParticles()):
        system.addParticle(1)
    system.addForce(force)
    platform = openmm.Platform.getPlatformByName("Reference")
    return openmm.Context(system, openmm.VerletIntegrator(0.001), platform)
