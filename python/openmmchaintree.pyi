# The part of the stub that makeStub.py cannot find elsewhere. It adds the classes, fields and methods that are missing.
# ruff: noqa: F401, F821

"""The classes that SWIG wraps.

Numbers are in nm, rad, kJ/mol and K. Where an argument may have a unit, a Quantity of that dimension is taken, too; an
OpenMMException tells of values that are out of range, and a TypeError of a unit of another dimension.
"""

from collections.abc import Sequence
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
import openmm
from openmm.unit import Quantity

from .densities import DrawnTorsions

_Number: TypeAlias = float | Quantity
_Vector: TypeAlias = Sequence[float] | npt.NDArray[np.floating[Any]] | Quantity
_Indices: TypeAlias = Sequence[int] | npt.NDArray[np.integer[Any]]

_Ints: TypeAlias = npt.NDArray[np.int32]
_Floats: TypeAlias = npt.NDArray[np.float64]

class StericExclusionForce(openmm.Force):
    def __init__(self) -> None: ...
    def getOverlapTolerance(self) -> Quantity: ...
    def getHydrogenBondAllowance(self) -> Quantity: ...
    def getForceConstant(self) -> Quantity: ...
    def getMinimumDistance(
        self, context: openmm.Context, particles1: _Indices, particles2: _Indices
    ) -> MinimumDistance: ...
    def getTraversalStatistics(self, context: openmm.Context) -> TraversalStatistics: ...
    @staticmethod
    def isinstance(object: openmm.Force) -> bool: ...

class TorsionMonteCarloIntegrator(openmm.Integrator):
    def getTemperature(self) -> Quantity: ...
    def getOuterStatistics(self) -> OuterStatistics: ...
    def getStandInCutoffs(self) -> tuple[Quantity, Quantity]: ...
    def getStageStatistics(self) -> list[StageStatistics]: ...
    def getMoveStatistics(self, move: int) -> MoveStatistics: ...
    @staticmethod
    def isinstance(object: openmm.Integrator) -> bool: ...

class LoopGrowth:
    def __init__(
        self,
        system: openmm.System,
        force: StericExclusionForce,
        positions: npt.ArrayLike | Quantity,
        torsions: Sequence[Sequence[int]],
        densities: Sequence[TorsionDensity],
    ) -> None: ...
    def getNumDrawnTorsions(self) -> int: ...
    def grow(self, seed: int, population: int, backboneDraws: int, sideDraws: int) -> GrownLoop: ...
