"""Regions of space that atoms must not enter, such as a membrane: between planes normal to the axes."""

import math
import re
from typing import NamedTuple

import openmm

from ..errors import InputError

_CONDITION = re.compile(r"\s*(?P<axis>[xyz])\s*(?P<sign>[<>])=?\s*(?P<place>[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?)\s*")
_ENERGY = 1000.0  # kJ/mol for each atom inside: at 1000 K, a share of exp(-120) of all atoms


class AvoidedRegion(NamedTuple):
    """Where all conditions hold: each an axis, "<" or ">", and a place in nm."""

    conditions: list[tuple[str, str, float]]

    def __str__(self):
        return " and ".join(f"{axis} {sign} {place:g}" for axis, sign, place in self.conditions)

    def createForce(self, particles):
        """Return an openmm.CustomExternalForce that keeps particles out, given by an int array."""
        steps = [
            f"step({place!r}-{axis})" if sign == "<" else f"step({axis}-({place!r}))"
            for axis, sign, place in self.conditions
        ]
        force = openmm.CustomExternalForce("*".join([repr(_ENERGY), *steps]))
        for particle in particles.tolist():
            force.addParticle(particle, [])
        return force

    def holds(self, positions):
        """Return for each of (…, 3) positions (nm) whether it lies inside."""
        inside = True
        for axis, sign, place in self.conditions:
            values = positions[..., "xyz".index(axis)]
            inside = inside & (values < place if sign == "<" else values > place)
        return inside


def readRegion(text):
    """Return the AvoidedRegion that a text such as "z < 0" or "z > -2 and z < 2" describes, in nm.

    Raises
    ------
    InputError
        if the text cannot be read
    """
    conditions = []
    for part in re.split(r"\band\b|,", text):
        match = _CONDITION.fullmatch(part)
        if match is None or not math.isfinite(float(match["place"])):
            raise InputError(f"{text!r} is no region such as 'z < 0' or 'z > -2 and z < 2' (nm)")
        conditions.append((match["axis"], match["sign"], float(match["place"])))
    return AvoidedRegion(conditions)
