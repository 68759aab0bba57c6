"""Renames atoms and residues after the templates of a force field.

Parts of OpenMM depend on names: GBn2 has special radii for hydrogens of ARG whose names begin with HH or HE, and other
parameters in residues named as nucleotides.
"""

import openmm.app

from ..residues import aminoAcid, nucleotide
from ..solute import subset


def nameByTemplates(forceField, topology):
    """Return a copy of a Topology with the names of the templates that match its residues.

    Raises
    ------
    Exception
        the exception of ForceField.createSystem if a residue matches no template
    """
    matching = _Matching(topology)
    forceField._matchAllResiduesToTemplates(matching, topology, {}, False)
    named = subset(topology, list(topology.atoms()))
    for copy, atom in zip(named.atoms(), topology.atoms(), strict=True):
        copy.name = matching.atomNames.get(atom, atom.name)
        copy.residue.name = matching.residueNames.get(atom.residue, atom.residue.name)
    return named


class _Matching(openmm.app.ForceField._SystemData):
    """Records the names of templates while OpenMM matches them.

    atomNames, residueNames : dict, names by Atom and Residue
    """

    def __init__(self, topology):
        super().__init__(topology)
        self.atomNames = {}
        self.residueNames = {}

    def recordMatchedAtomParameters(self, residue, template, matches):
        super().recordMatchedAtomParameters(residue, template, matches)
        for atom, match in zip(residue.atoms(), matches, strict=True):
            self.atomNames[atom] = template.atoms[match].name
            self.residueNames[atom.residue] = _residueName(template.name, atom.residue.name)


def _residueName(templateName, ownName):
    """Return the standard name of a residue with a template, such as ARG for NARG or DA for DA5, else its name."""
    base = templateName.split("-")[0]  # names of patches follow
    return aminoAcid(base) or nucleotide(base) or ownName
