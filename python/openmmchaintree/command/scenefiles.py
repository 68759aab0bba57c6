"""The files that a run writes before it begins: the structure that belongs to its trajectories, and its settings."""

import io

import openmm.app
from openmm import unit

from .config import asTOML


def writeScene(outputs, structure, settings):
    """Write the Outputs "topology", a PDB file, and "settings", if there is one; neither stays if one fails."""
    text = io.StringIO()
    openmm.app.PDBFile.writeFile(structure.topology, structure.positions * unit.nanometer, text, keepIds=True)
    outputs["topology"].write(text.getvalue())
    if "settings" in outputs:
        try:
            outputs["settings"].write(asTOML(settings))
        except BaseException:
            outputs["topology"].remove()
            raise


def removeScene(outputs):
    """Remove what `writeScene` wrote."""
    for kind in ("topology", "settings"):
        if kind in outputs:
            outputs[kind].remove()
