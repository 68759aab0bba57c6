"""Averages at one temperature from samples at several temperatures, by MBAR."""

import warnings
from typing import NamedTuple

import numpy as np

from .pymbarimport import mbar

_GAS_CONSTANT = 0.00831446261815324  # kJ/mol/K

# pymbar's own choice takes a minute where temperatures do not overlap.
_SOLVERS = ({"method": "hybr", "continuation": True}, {"method": "L-BFGS-B"})


class Reweighting(NamedTuple):
    """Samples of all temperatures with weights for one of them.

    weights : (n,) float64 array, with the sum 1
    sampleSize : float, Kish's effective number of samples, 1 / Σ w²
    means, errors : float64 arrays, of each observable at that temperature
    """

    weights: np.ndarray
    sampleSize: float
    means: np.ndarray
    errors: np.ndarray


def reweight(energies, temperatures, observables, target=0):
    """Return the Reweighting of independent samples by Shirts & Chodera (2008), https://doi.org/10.1063/1.2978177.

    It takes a time proportional to samples × temperatures: some 0.1 s for 2,000 samples of 12 temperatures.

    Parameters
    ----------
    energies : list of 1-D arrays
        kJ/mol, of the samples at each temperature; some may be empty
    temperatures : list of float
        K
    observables : list of 1-D arrays
        of all samples, in the order of the energies
    target : int
        the number of the temperature to average at

    Returns
    -------
    Reweighting or None
        None if the free energies cannot be solved for
    """
    counts = np.array([len(each) for each in energies])
    together = np.concatenate(energies)
    if len(together) < 2 or counts[target] == 0 or not np.isfinite(together).all():
        return None
    betas = 1 / (_GAS_CONSTANT * np.asarray(temperatures))
    reduced = np.outer(betas, together - together.min())
    module = mbar()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            solved = module.MBAR(reduced, counts, solver_protocol=_SOLVERS)
            found = [solved.compute_expectations(values) for values in observables]
        except (ArithmeticError, ValueError, np.linalg.LinAlgError, module.ParameterError, module.DataError):
            return None
    weights = solved.W_nk[:, target]
    return Reweighting(
        weights,
        float(1 / (weights**2).sum()),
        np.array([one["mu"][target] for one in found]),
        np.array([one["sigma"][target] for one in found]),
    )
