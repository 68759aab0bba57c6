"""The tag StericExclusionForce in files of `openmm.app.ForceField`."""

from .sterics import createStericExclusionForce


class StericExclusionGenerator:
    """The generator of the tag: it adds the force that `createStericExclusionForce` makes from the Topology."""

    def __init__(self, arguments, parameters):
        """Keep arguments of createStericExclusionForce, and parameters of the force as {name: value}."""
        self._arguments = arguments
        self._parameters = parameters

    @staticmethod
    def parseElement(element, forceField):
        """Read the tag.

        Raises
        ------
        ValueError
            if an attribute is unknown or cannot be read, or if another file of the ForceField has the tag
        """
        if any(isinstance(other, StericExclusionGenerator) for other in forceField.getGenerators()):
            raise ValueError(f"a ForceField can have <{element.tag}> only once")
        arguments, parameters = {}, {}
        for name, text in element.attrib.items():
            if name not in _ARGUMENTS and name not in _PARAMETERS:
                known = ", ".join([*_ARGUMENTS, *_PARAMETERS])
                raise ValueError(f"<{element.tag}> has no attribute {name}; its attributes are {known}")
            try:
                if name in _ARGUMENTS:
                    arguments[name] = _ARGUMENTS[name](text)
                else:
                    parameters[name] = float(text)
            except ValueError:
                raise ValueError(f"<{element.tag}>: {name} cannot be {text!r}") from None
        forceField.registerGenerator(StericExclusionGenerator(arguments, parameters))

    def createForce(self, system, data, nonbondedMethod, nonbondedCutoff, args):
        """Add the force; ForceField calls this when it creates a System."""
        if not data.atoms:
            return
        topology = data.atoms[0].residue.chain.topology
        force = createStericExclusionForce(topology, **self._arguments)
        for name, value in self._parameters.items():
            getattr(force, _PARAMETERS[name])(value)
        system.addForce(force)


def _readTruth(text):
    if text.lower() not in ("true", "false"):
        raise ValueError(text)
    return text.lower() == "true"


_ARGUMENTS = {
    "radii": str,
    "torsions": str.split,
    "bondCutoff": int,
    "cutDisulfides": _readTruth,
    "closures": str,
    "forceGroup": int,
}
_PARAMETERS = {
    "overlapTolerance": "setOverlapTolerance",
    "hydrogenBondAllowance": "setHydrogenBondAllowance",
    "forceConstant": "setForceConstant",
}
