"""Telling positions in a wrong unit by the lengths of bonds."""

import numpy as np

from .errors import InputError

# nm: where the median bond length of a molecule lies, 0.10 with most bonds to hydrogen and 0.15 without, with room.
_SHORTEST, _LONGEST = 0.09, 0.17


def checkBondLengths(lengths):
    """Refuse positions at which bonds, an array of lengths in nm, are ten times as long as bonds are, or a tenth.

    Raises
    ------
    InputError
    """
    if len(lengths) == 0:
        return
    median = float(np.median(lengths))
    if 10 * _SHORTEST <= median <= 10 * _LONGEST:
        raise InputError(
            f"half of the bonds are longer than {median:.2f} nm, ten times as long as bonds are: positions in ångström "
            "need their unit (positions * unit.angstrom) or a division by 10"
        )
    if _SHORTEST <= 10 * median <= _LONGEST:
        raise InputError(
            f"half of the bonds are shorter than {median:.4f} nm, a tenth of what bonds are: positions must be in nm, "
            "and coordinates in PDB and mmCIF files in ångström"
        )
