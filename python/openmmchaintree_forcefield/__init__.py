"""The entry point for `openmm.app.ForceField`: the folder of openmm-chaintree's XML file, and the parser of its tag.

OpenMM calls `dataDirectory` in every program that makes a ForceField, and an exception here would hide the files of
other packages. So this module is not a part of the package openmmchaintree, does not import it, and loads no library.
"""

import os

_TAG = "StericExclusionForce"


def dataDirectory():
    """Return the folder below which ForceField finds openmmchaintree/steric-exclusion.xml: an openmm.forcefielddir."""
    try:
        registerParser()
    except Exception:
        return ""  # without a parser ForceField would ignore the tag, so it must not find the file
    return os.path.dirname(os.path.abspath(__file__))


def registerParser():
    """Tell ForceField how to read the tag StericExclusionForce."""
    from openmm.app import forcefield

    forcefield.parsers[_TAG] = _parse


def _parse(element, forceField):
    from openmmchaintree.forcefield import StericExclusionGenerator

    StericExclusionGenerator.parseElement(element, forceField)
