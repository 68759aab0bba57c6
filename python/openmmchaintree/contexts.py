"""Contexts of a StericExclusionForce alone, for asking it about any positions."""

import openmm

from .images import vectorsOf


def contextOf(force, box=None):
    """Return a Context of a System with a StericExclusionForce alone, on the Reference platform.

    box : (3, 3) array, nm, the vectors of the periodic box in OpenMM's reduced form; None: OpenMM's default
    """
    system = openmm.System()
    for _ in range(force.getNumParticles()):
        system.addParticle(1)
    system.addForce(force)
    if box is not None:
        system.setDefaultPeriodicBoxVectors(*vectorsOf(box))
    platform = openmm.Platform.getPlatformByName("Reference")
    return openmm.Context(system, openmm.VerletIntegrator(0.001), platform)
