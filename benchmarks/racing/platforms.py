"""What of OpenMM and of other packages is there to be raced against."""

import importlib.util

import openmm

CPU = "CPU"  # the platform

_INSTALL = {"scipy": "scipy", "fcl": "python-fcl"}


def whyNot(requirement):
    """Return why something that a contestant needs, OpenMM's CPU platform or a package, is not there; None if it is."""
    if requirement == CPU:
        return None if CPU in _platformNames() else "OpenMM has no CPU platform here"
    if importlib.util.find_spec(requirement) is None:
        return f"the package {_INSTALL[requirement]} is not installed"
    return None


def _platformNames():
    return [openmm.Platform.getPlatform(i).getName() for i in range(openmm.Platform.getNumPlatforms())]


def makeContext(platformName, particleCount, *forces):
    """Make a Context, for one thread, of particles with some forces."""
    system = openmm.System()
    for _ in range(particleCount):
        system.addParticle(1.0)
    for force in forces:
        system.addForce(force)
    properties = {"Threads": "1"} if platformName == CPU else {}
    platform = openmm.Platform.getPlatformByName(platformName)
    return openmm.Context(system, openmm.VerletIntegrator(0.001), platform, properties)
