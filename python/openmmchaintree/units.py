"""Conversion of numbers with and without units to the units of the plugin: nm, rad, kJ/mol, K."""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from openmm import unit

Number: TypeAlias = float | unit.Quantity
Array: TypeAlias = npt.ArrayLike | unit.Quantity

_DIMENSIONS = {
    "nm": (unit.nanometer, "a length (nm)"),
    "rad": (unit.radian, "an angle (rad)"),
    "K": (unit.kelvin, "a temperature (K)"),
    "kJ/mol/nm^2": (unit.kilojoule_per_mole / unit.nanometer**2, "a force constant (kJ/mol/nm^2)"),
    "nm^-2": (unit.nanometer**-2, "an inverse square of a length (nm^-2)"),
    "1": (unit.dimensionless, "a number without unit"),
}


def inUnit(value, symbol, name):
    """Return a value as a plain number, or plain numbers, in the unit that symbol names.

    Parameters
    ----------
    value : number, sequence or Quantity
        returned unchanged if it has no unit; a sequence may hold Quantities
    symbol : str
        "nm", "rad", "K", "kJ/mol/nm^2", "nm^-2" or "1"
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
