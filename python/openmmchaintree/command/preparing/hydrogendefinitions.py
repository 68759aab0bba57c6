"""Hydrogens of residues that only a force field knows, such as modified residues, glycans and ligands."""

from io import StringIO
from xml.etree import ElementTree

from openmm import app

from ...templates import isStandard, standardName


def defineHydrogens(topology, energyModel):
    """Tell Modeller which hydrogens residues have that are not in its tables, by the templates of their names.

    Modeller keeps the definitions as long as Python runs.
    """
    root = ElementTree.Element("Residues")
    for name in dict.fromkeys(residue.name for residue in topology.residues()):
        hydrogens = [] if isStandard(standardName(name)) else energyModel.hydrogensOf(name)
        if hydrogens:
            entry = ElementTree.SubElement(root, "Residue", name=name)
            for hydrogen, parent in hydrogens:
                ElementTree.SubElement(entry, "H", name=hydrogen, parent=parent)
    if len(root):
        app.Modeller.loadHydrogenDefinitions(StringIO(ElementTree.tostring(root, encoding="unicode")))
