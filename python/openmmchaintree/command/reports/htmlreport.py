"""One page with all of a run: convergence, picture, moves, energies, settings, and the ensemble in three dimensions."""

import base64
import io
from importlib.resources import files

import mdtraj
import numpy as np
import openmm.app
from openmm import unit

from ... import __version__
from ...errors import InputError
from ...extras import importExtra
from .convergencereport import rowsOf
from .tables import percent

MOST_FRAMES = 30  # to show in three dimensions
_TEMPLATE = "run.html.jinja"


def importPackages():
    """Return the modules jinja2 and molstar_cli.

    Raises
    ------
    InputError
        if one of them cannot be imported
    """
    return importExtra("jinja2", "--report", InputError), importExtra("molstar_cli", "--report", InputError)


def asHTML(summary, picture, settings, topology, frames):
    """Return the page, which needs no network.

    Parameters
    ----------
    summary : dict
        of the run, as its JSON has it
    picture : bytes
        PNG, or None
    settings : str
        TOML
    topology : openmm.app.Topology
    frames : (frames, n, 3) array
        nm, to show in three dimensions
    """
    jinja2, molstar = importPackages()
    energy = summary.get("energy")
    viewer = files(molstar) / "static" / "molstar"
    environment = jinja2.Environment(loader=jinja2.PackageLoader(__package__, "."), autoescape=True)
    return environment.get_template(_TEMPLATE).render(
        summary=summary,
        version=__version__,
        rows={
            "estimates": [rowsOf(one) for one in summary["estimates"]],
            "moves": [_describeMove(move) for move in summary["moves"]],
            "forces": [_describeForce(force) for force in energy["forces"]] if energy else [],
        },
        picture=None if picture is None else base64.b64encode(picture).decode(),
        settings=settings,
        frameCount=len(frames),
        frames=_asModels(topology, np.asarray(frames)),
        viewerStyle=(viewer / "molstar.css").read_text(encoding="utf-8"),
        viewerScript=(viewer / "molstar.js").read_text(encoding="utf-8"),
    )


def _describeMove(move):
    """Return the cells of a move's row."""
    counts = [move[name] for name in ("attempted", "notMade", "clashed", "rejectedByEnergy", "accepted")]
    return (move["name"], *(f"{count:,}" for count in counts), percent(move["accepted"], move["attempted"]))


def _describeForce(force):
    energy = force["energy"]
    return force["name"], "–" if energy is None else f"{energy:,.1f}", force["kind"]


def _asModels(topology, frames):
    """Return frames, superposed on the first by Cα and C4′ atoms, or by all, as the models of a PDB file."""
    trajectory = mdtraj.Trajectory(frames, mdtraj.Topology.from_openmm(topology))
    trace = trajectory.topology.select("name CA or name \"C4'\"")
    trajectory.superpose(trajectory, 0, atom_indices=trace if len(trace) > 2 else None)
    text = io.StringIO()
    openmm.app.PDBFile.writeHeader(topology, text)
    for number, positions in enumerate(trajectory.xyz, 1):
        openmm.app.PDBFile.writeModel(topology, positions * unit.nanometer, text, number)
    openmm.app.PDBFile.writeFooter(topology, text)
    return text.getvalue()
