"""The shape of chains: radius of gyration, end-to-end distance, asphericity, and the scaling exponent."""

from typing import NamedTuple

import numpy as np

_SHORTEST_SEPARATION = 5  # residues, above which distances scale


class ChainShape(NamedTuple):
    """Arrays of a value for each frame.

    radiusOfGyration : nm, weighted by mass
    endToEndDistance : nm, of the first and last particle
    asphericity : relative shape anisotropy, from 0 for a sphere to 1 for a rod
    """

    radiusOfGyration: np.ndarray
    endToEndDistance: np.ndarray
    asphericity: np.ndarray

    def byName(self):
        """Return the arrays by their names."""
        return dict(zip(("radius of gyration", "end-to-end distance", "asphericity"), self, strict=True))


def shapesOf(positions, masses):
    """Return the ChainShape of frames.

    positions : (frames, n, 3) array, nm; masses : (n) array, Da
    """
    weights = masses / masses.sum()
    positions = np.asarray(positions, dtype=np.float64)
    centered = positions - np.einsum("i,fik->fk", weights, positions)[:, np.newaxis]
    tensors = np.einsum("i,fij,fik->fjk", weights, centered, centered)
    squares = np.trace(tensors, axis1=1, axis2=2)
    moments = np.linalg.eigvalsh(tensors)
    anisotropy = 1.5 * np.sum(moments**2, axis=1) / np.maximum(squares, 1e-300) ** 2 - 0.5
    ends = np.linalg.norm(positions[:, -1] - positions[:, 0], axis=1)
    return ChainShape(np.sqrt(squares), ends, anisotropy)


def scalingExponent(positions):
    """Return Flory's exponent: of the root mean square distance of residues by how many apart they are in the chain.

    Separations of more than 5 residues count, by least squares of logarithms. Returns None for chains of fewer than 12.

    positions : (frames, n, 3) array of one chain, nm
    """
    count = positions.shape[1]
    if count < 2 * (_SHORTEST_SEPARATION + 1):
        return None
    separations = np.arange(_SHORTEST_SEPARATION + 1, count)
    squares = [np.mean(np.sum((positions[:, s:] - positions[:, :-s]) ** 2, axis=2)) for s in separations]
    return float(np.polyfit(np.log(separations), 0.5 * np.log(squares), 1)[0])
