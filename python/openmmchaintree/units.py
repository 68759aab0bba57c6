"""Numbers with and without units, converted to the units of the plugin (nm, rad, kJ/mol, K); signs of a wrong unit."""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from openmm import unit

from .errors import InputError

Number: TypeAlias = float | unit.Quantity
Array: TypeAlias = npt.ArrayLike | unit.Quantity

_DIMENSIONS = {
    "nm": (unit.nanometer, "a length (nm)"),
    "rad": (unit.radian, "an angle (rad)"),
    "K": (unit.kelvin, "a temperature (K)"),
    "kJ/mol/nm^2": (unit.kilojoule_per_mole / unit.nanometer**2, "a force constant (kJ/mol/nm^2)"),
    "bar": (unit.bar, "a pressure (bar)"),
    "nm^-2": (unit.nanometer**-2, "an inverse square of a length (nm^-2)"),
    "1": (unit.dimensionless, "a number without unit"),
}

# The range of a molecule's median bond length in nm: about 0.10 with most bonds to hydrogen, 0.15 without hydrogens.
_SHORTEST, _LONGEST = 0.09, 0.17


def inUnit(value, symbol, name):
    """Return a value as a plain number, or plain numbers, in the unit that symbol names.

    Parameters
    ----------
    value : number, sequence or Quantity
        returned unchanged if it has no unit; a sequence may hold Quantities
    symbol : str
        "nm", "rad", "K", "kJ/mol/nm^2", "bar", "nm^-2" or "1"
    name : str
        the parameter, for the error message

    Raises
    ------
    TypeError
        if the value has a unit of another dimension
    """
    target, description = _DIMENSIONS[symbol]
    if unit.is_quantity(value):
        if not value.unit.is_compatible(target):
            raise TypeError(f"{name} must be {description}, but has the unit {value.unit.get_symbol()}")
        return value.value_in_unit(target)
    if isinstance(value, (list, tuple)):
        return [inUnit(item, symbol, name) for item in value]
    return value


def withUnit(value, symbol):
    """Return a number as Quantity in the unit that symbol names. See inUnit() for symbols."""
    return unit.Quantity(value, _DIMENSIONS[symbol][0])


def positionsInNm(positions, count):
    """Return positions as a float64 array of shape (count, 3) in nm.

    Raises
    ------
    TypeError
        if they have a unit that is not a length
    ValueError
        if their shape is not (count, 3)
    """
    array = np.asarray(inUnit(positions, "nm", "positions"), dtype=np.float64)
    if array.shape != (count, 3):
        raise ValueError(f"positions must have the shape ({count}, 3), not {array.shape}")
    return array


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
