"""Adding moves to an integrator, with a name and a purpose for each."""

from typing import NamedTuple

from openmm import unit

HALF_TURN = 180  # degrees: a torsion drawn uniformly

_DEGREE = unit.degree


class AddedMove(NamedTuple):
    """A move that `addDefaultMoves` has added: its index, its description, and its purpose."""

    move: int
    description: str
    purpose: str


class NamedMove(NamedTuple):
    """The short name of a move, for tables, and its weight."""

    name: str
    weight: float


class AddedMoves(list[AddedMove]):
    """The moves that `addDefaultMoves` has added: a list of AddedMove that prints as a table."""

    def __str__(self) -> str:
        width = max((len(added.description) for added in self), default=0)
        return "\n".join(f"{added.move:>3}  {added.description:<{width}}  {added.purpose}" for added in self)


class MoveAdder:
    """Adds moves, with a name and a purpose for each.

    inRings : set of int, torsions that only closed moves turn; hasClosed : bool, whether there is a closed move
    added : AddedMoves; named : list of NamedMove
    """

    def __init__(self, integrator, inRings):
        self.integrator = integrator
        self.inRings = inRings
        self.hasClosed = False
        self.added = AddedMoves()
        self.named = []

    def begin(self, name, share):
        """Begin moves of other torsions or joints: set their short name, and the factor of all weights."""
        self._name = name
        self._share = share

    def add(self, purpose, size, weight, addMove, *parameters):
        """Add a move by a method of the integrator that takes a weight and parameters."""
        share = float(f"{self._share * weight:.3g}")
        index = addMove(share, *parameters)
        self.added.append(AddedMove(index, self.integrator.getMoveDescription(index), purpose))
        self.named.append(NamedMove(f"{self._name} {size}", share))

    def turn(self, purpose, weight, degrees, torsions, where=""):
        """Add a move that turns one of some torsions, without torsions in rings of closures."""
        torsions = self.outsideRings(torsions)
        if torsions:
            size = f"{where}±{degrees}°"
            self.add(purpose, size, weight, self.integrator.addTorsionMove, degrees * _DEGREE, torsions)

    def findDrawn(self, findDensities, scene):
        """Return (torsions, density) pairs of residues, without pairs with torsions in rings of closures."""
        try:
            found = findDensities(scene.topology, scene.force)
        except ValueError:
            return []
        return [pair for pair in zip(*found, strict=True) if self.inRings.isdisjoint(pair[0])]

    def draw(self, purpose, size, weight, drawn):
        """Add a move that draws one of the sets of (torsions, density) pairs."""
        if drawn:
            sets, densities = map(list, zip(*drawn, strict=True))
            self.add(purpose, size, weight, self.integrator.addDrawnMove, sets, densities)

    def drawOrTurn(self, purpose, size, weight, drawn, torsions):
        """Add a move that draws pairs, and one that draws torsions uniformly that are in no pair."""
        hasDensity = {torsion for pair in drawn for torsion in pair[0]}
        others = [torsion for torsion in self.outsideRings(torsions) if torsion not in hasDensity]
        ofOthers = len(others) / max(1, len(others) + len(hasDensity)) * weight
        self.draw(purpose, size, weight - ofOthers, drawn)
        self.turn(purpose, ofOthers, HALF_TURN, others)

    def close(self, weight, degrees, torsions, purpose="backbones: the rest stays where it is"):
        """Add a closed move of backbones, perhaps with torsions in rings."""
        self.hasClosed = True
        self.add(purpose, f"closed {degrees}°", weight, self.integrator.addClosedMove, degrees * _DEGREE, torsions)

    def bend(self, weight, degrees, stiffness, torsions, purpose="backbones and their ends: the rest hardly moves"):
        """Add a local move of backbones, without torsions in rings of closures."""
        torsions = self.outsideRings(torsions)
        if torsions:
            size = f"local {degrees}°"
            self.add(purpose, size, weight, self.integrator.addLocalMove, degrees * _DEGREE, stiffness, torsions)

    def pivot(self, purpose, weight, degrees):
        """Add a pivot move of all ball joints."""
        self.add(purpose, f"±{degrees}°", weight, self.integrator.addPivotMove, degrees * _DEGREE)

    def crank(self, purpose, weight, degrees):
        """Add a crankshaft move of all ball joints."""
        self.add(purpose, f"crankshaft ±{degrees}°", weight, self.integrator.addCrankshaftMove, degrees * _DEGREE)

    def shift(self, purpose, weight, length, degrees, molecules):
        """Add a rigid-body move of molecules; the length is in nm."""
        size = f"{length} nm, ±{degrees}°"
        self.add(purpose, size, weight, self.integrator.addRigidBodyMove, length, degrees * _DEGREE, molecules)

    def outsideRings(self, torsions):
        """Return the torsions that lie in no ring of a closure, so that any move may turn them."""
        return [torsion for torsion in torsions if torsion not in self.inRings]
