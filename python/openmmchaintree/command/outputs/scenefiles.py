"""The files that a run writes before it begins: the topology of its trajectories, and its settings."""

import io

import openmm.app
from openmm import unit

from ...errors import InputError
from ..config import asTOML, readSettings

# Settings that an extended run changes.
_CHANGED = ("trials", "frames")


def writeScene(outputs, structure, settings):
    """Write the Outputs "topology", a PDB file, and "settings", if present; remove both if one fails.

    The topology is locked until it is released, which excludes other runs with the same file names.
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
    """Write the settings of a run that is extended to more trials to the Output "settings".

    A file that the run did not write may be the user's, and is kept. free : names of settings that may differ
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
    """Remove the files that `writeScene` wrote."""
    for kind in ("topology", "settings"):
        if kind in outputs:
            outputs[kind].remove()
