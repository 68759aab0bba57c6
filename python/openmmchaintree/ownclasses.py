"""Forces and Integrators that come out of OpenMM as the classes of this package that they are.

OpenMM chooses the Python class of an object that C++ returns from a list of its own classes, and asks nobody about
others: they come as bare Force or Integrator. So the few methods by which such objects come are followed by a look at
what they return. A method that an OpenMM does not have is passed over; `cast` works on any object.
"""

import functools

import openmm

from .openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator

_CLASSES = {openmm.Force: StericExclusionForce, openmm.Integrator: TorsionMonteCarloIntegrator}

_SOURCES = {
    "System": ["getForce"],
    "CompoundIntegrator": ["getIntegrator"],
    "CustomCVForce": ["getCollectiveVariable"],
    "XmlSerializer": ["deserialize", "clone"],
}


def ofOwnClass(thing):
    """Return a bare Force or Integrator as the class of this package that it is, and anything else as it is."""
    cls = _CLASSES.get(type(thing))
    return cls.cast(thing) if cls is not None and cls.isinstance(thing) else thing


def registerClasses():
    """Let the methods of OpenMM return objects of our classes. To do so twice is harmless."""
    for owner, names in _SOURCES.items():
        for name in names:
            cls = getattr(openmm, owner, None)
            method = vars(cls).get(name) if cls is not None else None
            if method is None or hasattr(method, "returnsOwnClasses"):
                continue
            if isinstance(method, staticmethod):
                setattr(cls, name, staticmethod(_follow(method.__func__)))
            else:
                setattr(cls, name, _follow(method))


def _follow(method):
    @functools.wraps(method)
    def followed(*arguments, **keywords):
        return ofOwnClass(method(*arguments, **keywords))

    followed.returnsOwnClasses = True
    return followed
