"""Covalent radii are those of gemmi, bit by bit, and near pairs those of a k-d tree."""

import gemmi
import numpy as np
import pytest
from openmmchaintree import covalent
from scipy.spatial import cKDTree


def test_radiiAndMetalsAreThoseOfGemmi():
    elements = [gemmi.Element(number) for number in range(1, 119)]
    numbers = np.arange(1, 119)
    withItself = covalent.longestBonds(numbers, numbers, 0.5)
    expected = np.array([0.5 * (2 * (0.1 * element.covalent_r)) for element in elements])
    assert np.array_equal(withItself[1:], expected[1:])  # bonds of hydrogen stretch by a factor of their own
    assert covalent._radii()[1] == 0.1 * elements[0].covalent_r
    assert covalent.isMetal(numbers).tolist() == [element.is_metal for element in elements]
    assert not covalent.isMetal(0)


@pytest.mark.parametrize("count", [0, 1, 2, 30, 5000])
@pytest.mark.parametrize("place", [0, 1e4])
def test_nearPairs(count, place):
    positions = place + np.random.default_rng(1).random((count, 3)) * (count / 50) ** (1 / 3)
    tree = cKDTree(positions.reshape(-1, 3)).query_pairs(0.2, output_type="ndarray")
    assert covalent.nearPairs(positions, 0.2).tolist() == sorted(tree.tolist())


def test_pointsAtOnePlaceAreNear():
    assert covalent.nearPairs(np.zeros((3, 3)), 0.1).tolist() == [[0, 1], [0, 2], [1, 2]]


def test_pointsAtTheDistanceItselfAreNear():
    positions = np.array([[0.0, 0.0, 0.0], [0.25, 0.0, 0.0], [np.nextafter(0.5, 1), 0.0, 0.0]])
    assert covalent.nearPairs(positions, 0.25).tolist() == [[0, 1]]


def test_coordinatesMustBeFinite():
    with pytest.raises(ValueError, match="finite"):
        covalent.nearPairs(np.full((2, 3), np.nan), 0.1)
