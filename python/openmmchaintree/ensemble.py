"""Independent conformers of a disordered protein, or of one with domains, in one call."""

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from openmm import app

from .calvados import createCalvadosSystem
from .errors import InputError
from .units import Number, inUnit

if TYPE_CHECKING:
    from .ensembles.chainshape import ChainShape
    from .statistics.estimates import Estimate


class Ensemble(NamedTuple):
    """Independent conformers, and averages over the run.

    topology : openmm.app.Topology
    positions : (conformers, n, 3) float32 array, nm, centered
    shapes : ChainShape, arrays of a value for each conformer
    estimates : dict of Estimate by name, from all frames of the run, not only from these conformers
    effectiveSampleSize : float, the least of radius of gyration and end-to-end distance
    trials : int, of the run
    isComplete : bool, whether the requested number of independent conformers was reached
    """

    topology: app.Topology
    positions: np.ndarray
    shapes: "ChainShape"
    estimates: "dict[str, Estimate]"
    effectiveSampleSize: float
    trials: int
    isComplete: bool


def sampleEnsemble(
    source: str | Sequence[str] | app.PDBFile | app.PDBxFile | app.Modeller,
    model: str = "calvados2",
    conformers: int = 1000,
    seed: int = 0,
    temperature: Number = 298.0,
    pH: float = 7.0,
    ionicStrength: float = 0.15,
    domains: Iterable[Iterable[int]] = (),
    maxTrials: int = 10**9,
) -> Ensemble:
    """Sample independent conformers of a protein in a model with a bead for each residue.

    The run ends when the effective sample sizes of the radius of gyration and of the end-to-end distance reach
    `conformers`. The returned conformers are equally spaced in the equilibrated part of the run. A chain of 100
    residues takes about 3 ms of one core for each.

        ensemble = sampleEnsemble("MDVFMKGLSKAKEGVVAAAEKTKQGVAEAAGKTKEGVLYVGSKTKEGVVHG", conformers=100)
        print(ensemble.estimates["radius of gyration"])

    Parameters
    ----------
    source, temperature, pH, ionicStrength, model, domains
        as for `createCalvadosSystem`; one chain, or the chains of a structure that domains hold together
    conformers : int
        the number of conformers to return
    seed : int
        the random number seed; 0 draws one
    maxTrials : int
        the largest number of trials

    Returns
    -------
    Ensemble

    Raises
    ------
    InputError
        as `createCalvadosSystem`, or if a number is not positive
    """
    if conformers < 1 or maxTrials < 1:
        raise InputError("conformers and maxTrials must be above 0")
    from .ensembles.beadrun import sampleBeads  # which estimates errors, by packages of an extra

    topology, system, positions = createCalvadosSystem(source, temperature, pH, ionicStrength, model, domains)
    kelvin = float(inUnit(temperature, "K", "temperature"))
    return sampleBeads(topology, system, positions, kelvin, seed, int(conformers), int(maxTrials))
