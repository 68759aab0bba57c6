"""Methods of OpenMM that return Forces and Integrators, made to return objects of this package's classes.

OpenMM knows only its own classes when it chooses the Python class of an object that C++ returns: it returns others as
bare Force or Integrator. So the few methods that return such objects are wrapped here. Methods that an OpenMM version
lacks are skipped; `cast` works on any object.
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
    """Let the methods of OpenMM return objects of this package's classes. A second call changes nothing."""
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
