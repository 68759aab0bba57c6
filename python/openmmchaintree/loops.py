"""Conformers of a loop between fixed parts, in one call."""

from typing import NamedTuple

import numpy as np
import openmm
from openmm import app

from .errors import InputError
from .units import Array, Number, inUnit, positionsInNm

MODELS = ("coil", "spheres")


class LoopEnsemble(NamedTuple):
    """Conformers of a loop, and the loops that were grown for them.

    Conformers within 0.1 nm of the first one of a basin belong to it. Distances are root mean squares over N, CA, C and
    O of the loop, in the frame of the fixed part.

    topology : openmm.app.Topology
    positions : (conformers, n, 3) float64 array, nm; all but the loop is where it was
    energies : (conformers) array, kJ/mol, of the model
    distances : (conformers) array, nm, from the given loop
    basins : (conformers) array of int, numbered from 0
    parents : (conformers) array of int, the grown loop from which each was sampled
    effectiveSampleSize : float, of the weights of grown loops, (Σ w)² / Σ w²
    grown : int, closed loops without clashes, each independent of all others
    runs : int, attempts
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


class AnnealedLoops(NamedTuple):
    """Conformers of a loop that were annealed in a force field, each from a loop of its own growth.

    topology : openmm.app.Topology
    positions : (starts, n, 3) float64 array, nm; all but the loop is where it was
    energies : (starts) array, kJ/mol
    distances, basins : as of `LoopEnsemble`
    native : (positions, energy, distance) of a run that began at the given positions, by the same trials
    grown : int, closed loops without clashes that were grown; runs : int, attempts
    """

    topology: app.Topology
    positions: np.ndarray
    energies: np.ndarray
    distances: np.ndarray
    basins: np.ndarray
    native: tuple[np.ndarray, float, float]
    grown: int
    runs: int


def annealLoop(
    topology: app.Topology,
    positions: Array,
    loop: str,
    system: openmm.System,
    starts: int = 20,
    seed: int = 0,
    temperature: Number = 300.0,
    hottest: Number = 1500.0,
    trials: int = 50000,
) -> AnnealedLoops:
    """Anneal independently grown loops in a force field, with everything else fixed.

    Each run begins with a loop that is grown as for `sampleLoop`, with the density of random coils and hard spheres.
    It samples exp(−U/kT) while the temperature falls by equal factors from `hottest` to `temperature`, in the first
    four fifths of the trials, and then to a fiftieth of it: a quench. All bonds of the loop outside rings turn. The
    conformers are local minima, not a Boltzmann ensemble; longer runs reach lower energies. For comparison, one run of
    the same length begins at the given positions.

        loops = annealLoop(pdb.topology, pdb.positions, "A:63-74", system, starts=10)
        print(loops.energies.min(), loops.native[1])

    Parameters
    ----------
    topology : openmm.app.Topology
        with all bonds and hydrogens
    positions : array of shape (n, 3) or Quantity
        nm, with the loop closed
    loop : str
        the chain and the numbers of its first and last residue, such as "A:63-74"
    system : openmm.System
        the energies; it is copied
    starts : int
        the number of loops
    seed : int
        the random number seed; 0 draws one
    temperature, hottest : float or Quantity
        K
    trials : int
        trials of each run

    Returns
    -------
    AnnealedLoops

    Raises
    ------
    InputError
        as `sampleLoop`
    """
    if starts < 1 or trials < 1:
        raise InputError("starts and trials must be above 0")
    kelvin, most = float(inUnit(temperature, "K", "temperature")), float(inUnit(hottest, "K", "hottest"))
    if not 0 < kelvin <= most:
        raise InputError("temperature must be above 0, and hottest not below it")
    from .ensembles.loopannealing import LoopAnnealing  # like other runs of ensembles

    positions = positionsInNm(positions, topology.getNumAtoms())
    return LoopAnnealing(topology, positions, loop, system, seed).anneal(int(starts), kelvin, most, int(trials))
