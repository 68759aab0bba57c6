"""The files that a run writes before it begins: the structure that belongs to its trajectories, and its settings."""

import io

import openmm.app
from openmm import unit

from ...errors import InputError
from ..config import asTOML, readSettings

# What a run that goes on may change.
_CHANGED = ("trials", "frames")


def writeScene(outputs, structure, settings):
    """Write the Outputs "topology", a PDB file, and "settings", if there is one; neither stays if one fails.

    The topology, which all runs with the same names of files have, is held until it is released: it keeps others out.
    """
    text = io.StringIO()
    openmm.app.PDBFile.writeFile(structure.topology, structure.positions * unit.nanometer, text, keepIds=True)
    try:
        outputs["topology"].write(text.getvalue())
        outputs["topology"].hold()
        if "settings" in outputs:
            outputs["settings"].write(asTOML(settings))
    except BaseException:
        removeScene(outputs)
        raise


def renewSettings(outputs, settings, free):
    """Write the settings of a run that goes on to more trials to the Output "settings".

    A file that is not as the run has written it stays: it may be the user's. free : names of settings that do not count
    """
    output = outputs["settings"]
    try:
        there = readSettings(output.path)
    except InputError:
        return
    former, present = ({**those, **dict.fromkeys((*free, *_CHANGED))} for those in (there, settings))
    isOurs = former == present and output.path.read_text(encoding="utf-8") == asTOML(there)
    if isOurs and any(there.get(name) != settings[name] for name in _CHANGED):
        output.write(asTOML(settings))


def removeScene(outputs):
    """Remove what `writeScene` wrote."""
    for kind in ("topology", "settings"):
        if kind in outputs:
            outputs[kind].remove()
