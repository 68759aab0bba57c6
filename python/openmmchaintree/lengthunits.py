"""Detection of positions in a wrong unit, by the lengths of bonds."""

import numpy as np

from .errors import InputError

# The range of a molecule's median bond length in nm: about 0.10 with most bonds to hydrogen, 0.15 without hydrogens.
_SHORTEST, _LONGEST = 0.09, 0.17


def checkBondLengths(lengths):
    """Raise an InputError if bond lengths, an array in nm, are about ten times too long or too short."""
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
