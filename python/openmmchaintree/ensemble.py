"""Independent conformers of a disordered protein, of one with domains, or of tails and linkers, in one call."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from openmm import app

from .calvados import MODELS as BEAD_MODELS
from .calvados import createCalvadosSystem
from .coil import CoilTables
from .errors import InputError
from .missing import buildMissing
from .units import Number, inUnit

if TYPE_CHECKING:
    from .ensembles.chainshape import ChainShape
    from .statistics.estimates import Estimate


MODELS = (*BEAD_MODELS, "coil")


class Ensemble(NamedTuple):
    """Independent conformers, and averages over the run.

    topology : openmm.app.Topology
    positions : (conformers, n, 3) float32 array, nm, centered if nothing is fixed
    shapes : ChainShape, arrays of a value for each conformer; radii of gyration and asphericities are of all particles
    estimates : dict of Estimate by name, from all frames of the run, not only from these conformers
    effectiveSampleSize : float, the least of the values that decide when the run ends
    trials : int, of the run
    isComplete : bool, whether the requested number of independent conformers was reached
    trace : int array, from the first to the last particle of the end-to-end distance: beads, or Cα of the longest part
    """

    topology: app.Topology
    positions: np.ndarray
    shapes: "ChainShape"
    estimates: "dict[str, Estimate]"
    effectiveSampleSize: float
    trials: int
    isComplete: bool
    trace: np.ndarray


def sampleEnsemble(
    source: str | Path | Sequence[str] | app.PDBFile | app.PDBxFile | app.Modeller,
    model: str = "calvados2",
    conformers: int = 1000,
    seed: int = 0,
    temperature: Number = 298.0,
    pH: float = 7.0,
    ionicStrength: float = 0.15,
    domains: Iterable[Iterable[int]] = (),
    maxTrials: int = 10**9,
    missing: bool = False,
    sequences: Iterable[str | Sequence[str]] | None = None,
    hydrogens: bool | None = None,
    moveDomains: bool = False,
    tables: CoilTables | None = None,
    avoid: Iterable[str] = (),
    bias: Iterable[str] = (),
) -> Ensemble:
    """Sample independent conformers of a protein: with a bead for each residue, or all atoms as a random coil.

    The run ends when the effective sample sizes of the radius of gyration and of the end-to-end distance reach
    `conformers`. The returned conformers are equally spaced in the equilibrated part of the run. A chain of 100
    residues takes about 3 ms of one core for each.

        ensemble = sampleEnsemble("MDVFMKGLSKAKEGVVAAAEKTKQGVAEAAGKTKEGVLYVGSKTKEGVVHG", conformers=100)
        print(ensemble.estimates["radius of gyration"])

    The model "coil" has hard spheres and the energy of `createCoilForce`. A sequence is built with all heavy atoms.
    In a structure, such as a prediction, residues outside `domains` are flexible. With `missing`, the source is a
    structure file, and the residues are flexible that `buildMissing` builds. In each chain the largest domain stays,
    and others move with their linkers as rigid bodies; everything else stays in place as an obstacle. The sample sizes
    of the place of each part, and of the means of sin ψ and sin χ1 over its residues, have to be large enough, too.
    Clashes of the start are removed first.

        ensemble = sampleEnsemble("1shg.pdb", "coil", missing=True, conformers=100)

    Parameters
    ----------
    source, temperature, pH, ionicStrength, model, domains
        as for `createCalvadosSystem`; one chain, or the chains of a structure that domains hold together. For the model
        "coil": one sequence in letters or names of residues, a structure or, with `missing`, the path of a file; pH and
        ionic strength have no effect.
    conformers : int
        the number of conformers to return
    seed : int
        the random number seed; 0 draws one
    maxTrials : int
        the largest number of trials
    missing : bool
        build and sample the residues that a structure file lacks; needs the model "coil"
    sequences, hydrogens, moveDomains, tables
        as for `buildMissing`, for the model "coil"
    avoid : iterable of str
        regions that atoms which move must not enter, in nm: "z < 0" is a half space, "z > -2 and z < 2" a slab; for the
        model "coil"
    bias : iterable of str
        other densities of φ and ψ by residue numbers: "70-80:helix", "A:5-9:extended", "A:90-99:polyproline", or the
        file of a table as in "12-20:own.csv"; for the model "coil"

    Returns
    -------
    Ensemble

    Raises
    ------
    InputError
        as `createCalvadosSystem` and `buildMissing`; or if a number is not positive, or clashes of the start cannot be
        removed
    """
    if conformers < 1 or maxTrials < 1:
        raise InputError("conformers and maxTrials must be above 0")
    kelvin = float(inUnit(temperature, "K", "temperature"))
    if model == "coil":
        from .ensembles.coilrun import sampleCoil
        from .ensembles.coilscene import sceneOfBuilt, sceneOfDomains

        if missing and isinstance(source, str | Path):
            if domains:
                raise InputError("domains are of a structure without missing residues")
            scene = sceneOfBuilt(buildMissing(source, sequences, hydrogens, moveDomains, seed, tables))
        elif missing or isinstance(source, Path):
            raise InputError('the model "coil" needs a sequence, a structure or, with missing=True, the path of a file')
        elif hasattr(source, "topology"):
            scene = sceneOfDomains(source, domains)
        elif domains:
            raise InputError("domains need a structure with positions, not a sequence")
        else:
            scene = sceneOfBuilt(buildMissing(None, [source], hydrogens, False, seed, tables))
        return sampleCoil(scene, kelvin, seed, int(conformers), int(maxTrials), tables, avoid, bias)
    if missing or sequences is not None or tables is not None or avoid or bias:
        raise InputError('missing residues, tables, biases and regions to avoid need the model "coil"')
    from .ensembles.beadrun import sampleBeads  # which estimates errors, by packages of an extra

    topology, system, positions = createCalvadosSystem(source, temperature, pH, ionicStrength, model, domains)
    return sampleBeads(topology, system, positions, kelvin, seed, int(conformers), int(maxTrials))
