"""What `openmm.app.ForceField` has to know of openmm-chaintree before anybody uses it.

OpenMM calls `dataDirectory` for every program that makes a ForceField, and an exception here would hide the files of
other packages. So this module stands beside the package openmmchaintree, imports nothing of it, and loads no library.
"""

import os

_TAG = "StericExclusionForce"


def dataDirectory():
    """Return the folder below which ForceField finds openmmchaintree/steric-exclusion.xml: an openmm.forcefielddir."""
    try:
        registerParser()
    except Exception:
        return ""  # without a parser ForceField would pass over the tag: better that the file is not found
    return os.path.dirname(os.path.abspath(__file__))


def registerParser():
    """Tell ForceField how to read the tag StericExclusionForce."""
    from openmm.app import forcefield

    forcefield.parsers[_TAG] = _parse


def _parse(element, forceField):
    from openmmchaintree.forcefield import StericExclusionGenerator

    StericExclusionGenerator.parseElement(element, forceField)
