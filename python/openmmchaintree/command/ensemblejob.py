"""One protein of a run of the command ensemble: its conformers, and the files that describe them."""

import csv
import io
import warnings
from typing import NamedTuple

import numpy as np
import openmm.app
from openmm import unit

from ..ensemble import sampleEnsemble
from ..ensembles.chainshape import scalingExponent
from ..ensembles.domains import readDomains
from ..notes import NoteWarning
from ..structures.structure import readStructure
from .outputs.dcdfile import TITLE
from .pictures import savePicture
from .reports.noteoutput import asPlain

_BLOCKS = 5  # of conformers, whose scaling exponents tell its error


class EnsembleJob(NamedTuple):
    """What one protein's ensemble is made of.

    name : str, of its files; sequence : str, or None; structure : str, a path, or None
    settings : dict, the arguments of sampleEnsemble without its source, and `domains` as text; hasPicture : bool
    """

    name: str
    sequence: str | None
    structure: str | None
    settings: dict
    hasPicture: bool


class EnsembleResult(NamedTuple):
    """The summary of a protein's ensemble, and the contents of its files by the ends of their names."""

    summary: dict
    files: dict[str, bytes]


def runJob(job):
    """Sample a protein; return an EnsembleResult, so that workers on other machines need no folder in common."""
    settings = dict(job.settings)
    domains = settings.pop("domains")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", NoteWarning)
        if job.structure is None or settings.get("missing"):
            ensemble = sampleEnsemble(job.sequence or job.structure, **settings)
        else:
            source = readStructure(job.structure)
            chosen = readDomains(domains, source.topology) if domains else []
            ensemble = sampleEnsemble(source, domains=chosen, **settings)
    notes = [each.message.note for each in caught if isinstance(each.message, NoteWarning)]
    summary = {**_summarize(job, ensemble), "notes": asPlain(notes)}
    files = {"-topology.pdb": asPDB(ensemble), ".dcd": asDCD(ensemble), ".csv": _asCSV(ensemble.shapes)}
    if job.hasPicture:
        picture = _Memory(f"{job.name}.png")
        savePicture("ensemblepicture", picture, job.name, ensemble)
        files[".png"] = picture.content
    return EnsembleResult(summary, files)


class _Memory:
    """Takes a picture in place of an Output."""

    def __init__(self, name):
        self.name = name

    def write(self, content):
        self.content = content


def _summarize(job, ensemble):
    """Return a dictionary of plain numbers."""
    exponent, error = _exponentWithError(ensemble.positions[:, ensemble.trace])
    estimates = {name: _plain(one) for name, one in ensemble.estimates.items()}
    return {
        "name": job.name,
        "residues": ensemble.topology.getNumResidues(),
        "conformers": len(ensemble.positions),
        "effectiveSampleSize": round(ensemble.effectiveSampleSize, 1),
        "isComplete": ensemble.isComplete,
        "trials": ensemble.trials,
        "estimates": estimates,
        "scalingExponent": exponent,
        "scalingExponentError": error,
        "settings": job.settings,
    }


def _plain(one):
    return {
        "mean": one.mean,
        "standardError": one.standardError,
        "effectiveSampleSize": one.effectiveSampleSize,
        "rhat": one.rhat,
        "verdict": one.verdict,
    }


def _exponentWithError(positions):
    """Return Flory's exponent, and its standard error by blocks of conformers; None where they are not defined."""
    exponent = scalingExponent(positions)
    if exponent is None or len(positions) < 2 * _BLOCKS:
        return exponent, None
    blocks = [scalingExponent(block) for block in np.array_split(positions, _BLOCKS)]
    return exponent, float(np.std(blocks, ddof=1) / np.sqrt(_BLOCKS))


def asPDB(ensemble):
    text = io.StringIO()
    positions = ensemble.positions[0].astype(float) * unit.nanometer
    openmm.app.PDBFile.writeFile(ensemble.topology, positions, text, keepIds=True)
    return text.getvalue().encode()


def asDCD(ensemble):
    content = io.BytesIO()
    trajectory = openmm.app.DCDFile(content, ensemble.topology, 1 * unit.picosecond)
    for positions in ensemble.positions:
        trajectory.writeModel(positions.astype(float) * unit.nanometer)
    whole = bytearray(content.getvalue())
    whole[TITLE] = b" " * len(whole[TITLE])  # so that the same run gives the same file
    return bytes(whole)


def _asCSV(shapes):
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["conformer", "radius of gyration (nm)", "end-to-end distance (nm)", "asphericity"])
    for index, values in enumerate(zip(*shapes, strict=True)):
        writer.writerow([index, *(f"{value:.6f}" for value in values)])
    return text.getvalue().encode()
