"""Conformers of a loop between fixed parts, in one call."""

from typing import NamedTuple

import numpy as np
from openmm import app

from .errors import InputError
from .units import Array, Number, inUnit, positionsInNm

MODELS = ("coil", "spheres")


class LoopEnsemble(NamedTuple):
    """Conformers of a loop, and the loops that were grown for them.

    topology : openmm.app.Topology
    positions : (conformers, n, 3) float64 array, nm; all but the loop is where it was
    energies : (conformers) array, kJ/mol, of the model
    distances : (conformers) array, nm, root mean square distance of N, CA, C and O of the loop from the given one, in
        the frame of the fixed part
    basins : (conformers) array of int, numbered from 0: conformers within 0.1 nm of the first one of a basin, in the
        same sense, belong to it
    parents : (conformers) array of int, the grown loop from which each was sampled
    effectiveSampleSize : float, of the weights of grown loops, (Σ w)² / Σ w²
    grown : int, closed loops without clashes, each independent of all others; runs : int, attempts
    isComplete : bool, whether the requested number of independent conformers was reached
    """

    topology: app.Topology
    positions: np.ndarray
    energies: np.ndarray
    distances: np.ndarray
    basins: np.ndarray
    parents: np.ndarray
    effectiveSampleSize: float
    grown: int
    runs: int
    isComplete: bool


def sampleLoop(
    topology: app.Topology,
    positions: Array,
    loop: str,
    model: str = "coil",
    conformers: int = 100,
    seed: int = 0,
    temperature: Number = 298.0,
    trials: int = 5000,
    maxGrown: int | None = None,
) -> LoopEnsemble:
    """Sample independent conformers of a loop whose ends are fixed, as all other atoms are.

    φ, ψ and χ of the loop turn; bond lengths, bond angles and ω are those of the given positions. The ensemble is
    exp(−U/kT) for loops that are closed and whose atoms, as hard spheres, do not clash. In the model "coil" U is
    −kT ln p with the density p of a random coil (`createCoilForce`), in the model "spheres" it is 0.

    Each loop is grown independently, from both ends, and closed exactly by φ and ψ of three residues (`LoopGrowth`).
    Its weight corrects the probability of growth, so that weighted means over grown loops are means over the ensemble.
    Loops are grown until the effective sample size of the weights reaches `conformers`. Then conformers are drawn by
    weight, and each is sampled by moves that keep the ensemble. Loops in open places have more equal weights than
    crowded ones.

        ensemble = sampleLoop(pdb.topology, pdb.positions, "A:63-74", conformers=20)
        print(ensemble.effectiveSampleSize, ensemble.basins.max() + 1)

    Parameters
    ----------
    topology : openmm.app.Topology
        with all bonds; without water, which would be an obstacle
    positions : array of shape (n, 3) or Quantity
        nm, with the loop closed
    loop : str
        the chain and the numbers of its first and last residue, with insertion codes, such as "A:63-74" or "H:52-52C"
    model : str
        "coil" or "spheres"
    conformers : int
        the number of conformers to return
    seed : int
        the random number seed; 0 draws one
    temperature : float or Quantity
        K
    trials : int
        trials of moves from each drawn loop to its conformer
    maxGrown : int, optional
        the largest number of loops to grow. Default: 30 for each conformer.

    Returns
    -------
    LoopEnsemble

    Raises
    ------
    InputError
        if the loop reaches an end of its chain, has a gap, less than three residues, or a bond beside the peptide bonds
        at its ends, as of a disulfide; if no loop without a clash is found; or if an argument is out of range
    """
    if model not in MODELS:
        raise InputError(f"{model!r} is no model of loops; the models are {', '.join(MODELS)}")
    if conformers < 1 or trials < 0 or (maxGrown is not None and maxGrown < 1):
        raise InputError("conformers and maxGrown must be above 0, and trials not below 0")
    kelvin = float(inUnit(temperature, "K", "temperature"))
    if not kelvin > 0:
        raise InputError("temperature must be above 0")
    from .ensembles.looprun import LoopRun  # like other runs of ensembles

    positions = positionsInNm(positions, topology.getNumAtoms())
    run = LoopRun(topology, positions, loop, model, kelvin, seed)
    return run.sample(int(conformers), int(trials), int(maxGrown or 30 * conformers))
