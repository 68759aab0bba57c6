"""The jobs of the command ensemble: one for each protein of its source, and the ones that its folder has already."""

import json
import os
import random
import re
from pathlib import Path

from ..ensembles.sequencefiles import isSequenceFile, readSequences
from ..errors import InputError
from .ensembleatoms import atomSettings
from .ensemblejob import EnsembleJob

_FILES = (".dcd", "-topology.pdb", ".csv", ".png", ".json")


def makeJobs(options):
    """Return the list of EnsembleJob of the source."""
    settings = {
        "model": options.model,
        "conformers": options.conformers,
        "temperature": options.temperature,
        "pH": options.ph,
        "ionicStrength": options.ionic,
        "maxTrials": options.max_trials,
        "domains": options.domains,
        **atomSettings(options),
    }
    first = options.seed or random.SystemRandom().randrange(1, 2**30)
    if isSequenceFile(options.source):
        if options.domains:
            raise InputError("--domains needs a structure, not sequences")
        sequences = readSequences(options.source)
        names = _fileNames([each.name for each in sequences])
        sources = [(each.letters, None) for each in sequences]
    else:
        names, sources = [stemOf(options.source)], [(None, os.path.abspath(options.source))]
    return [
        EnsembleJob(
            name, *source, {**settings, "seed": (first + index - 1) % (2**31 - 1) + 1}, index < options.pictures
        )
        for index, (name, source) in enumerate(zip(names, sources, strict=True))
    ]


def stemOf(path):
    """Return the name of a file without its suffixes."""
    return re.sub(r"(\.[^.]*)?(\.(gz|bz2|xz|zst))?$", "", Path(path).name, flags=re.IGNORECASE) or "ensemble"


def _fileNames(names):
    """Return a file's name for each name, all different."""
    used, found = set(), []
    for name in names:
        plain = re.sub(r"[^\w.+-]", "_", name).lstrip(".-")[:100] or "sequence"
        number, unique = 1, plain
        while unique.lower() in used:  # some file systems do not tell cases apart
            number += 1
            unique = f"{plain}-{number}"
        used.add(unique.lower())
        found.append(unique)
    return found


def findDone(folder, jobs, options):
    """Return the summaries of proteins that the folder has, by name, if the run resumes another.

    Raises
    ------
    InputError
        if files exist that may not be replaced, or that another run with other settings has made
    """
    if not options.resume:
        existing = [folder / "summary.csv", *(folder / f"{job.name}{end}" for job in jobs for end in _FILES)]
        found = next((path for path in existing if path.exists()), None)
        if found and not options.overwrite:
            raise InputError(f"{found}: exists; --resume keeps finished proteins, --overwrite replaces all")
        return {}
    if not folder.is_dir():
        raise InputError(f"{folder}: is no folder with the results of a run to resume")
    done = {}
    for job in jobs:
        path = folder / f"{job.name}.json"
        if not path.exists():
            continue
        try:
            summary = json.loads(path.read_text(encoding="utf-8"))
            former = {**summary["settings"], "seed": None}
        except (OSError, ValueError, TypeError, KeyError) as error:
            raise InputError(f"{path}: cannot be read as a protein's averages ({error}); remove it") from error
        for name, value in {**job.settings, "seed": None}.items():
            if former.get(name) != value:
                raise InputError(f"{path}: was made with {name} {former.get(name)}, not {value}")
        done[job.name] = summary
    return done
