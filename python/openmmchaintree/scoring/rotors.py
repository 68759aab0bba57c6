"""Turning hydroxyls, thiols and ammonium groups, and choosing the hydrogens of histidines, as the program Reduce does.

Each group has a few angles: towards each acceptor near it, and where it bumps least. Groups that can touch each other
are optimized in turn until none changes; then each angle is refined by degrees.

Source: Reduce 4.16 (RotDonor.cpp, Rot3Fold.cpp, AtomPositions.cpp); J. M. Word et al., J. Mol. Biol. 285, 1735-1747
(1999). Reduce searches sets of groups exhaustively.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy.spatial import cKDTree

from .contactatoms import ABSENT, ACCEPTOR, POSITIVE
from .dotcontacts import areIn, bondedWithin, rowOf
from .dotscore import scorePlaces
from .hydrogens import TETRAHEDRAL, turnedPlace

# Dots do not count in atoms that so few bonds join to theirs.
_BONDS = 3
# Acceptors within this distance (nm) of O or S attract its hydrogen, if it can touch them at this bond length.
_NEAR, _HYDROGEN_RADIUS, _BOND, _BOND_OF_SULFUR = 0.4, 0.105, 0.1, 0.13
# Overlaps (nm) beyond which angles beside that towards the acceptor are tried, too, and how far beside, degrees.
_TOUCH, _SIDES = -1e-4, ((-0.07, 15.0), (-0.09, 30.0))
# Steps of angles, degrees: of rough and fine ones.
_STEP, _STEP_OF_THREE, _FINE = 10, 30, 1
_START, _STARTS_OF_AROMATIC = 180.0, (150.0, -30.0)
# Groups whose N, O or S are farther apart than this (nm) cannot touch.
_LINKED = 0.45
_MOST_SWEEPS = 10


@dataclass
class _Group:
    """Atoms whose orientation is chosen.

    scored : list of int, the atoms whose dots count; angles : of rough orientations, degrees; orientation : the present
    one, an angle, or the number of the state of a Choice; linked : the numbers of groups that it can touch
    """

    scored: list[int]
    angles: list[float]
    orientation: float
    linked: list[int] = field(default_factory=list)


def optimizeRotors(atoms, positions, rotors, choices, mayAccept):
    """Turn rotors in place, choose a state of each of the choices, and return these states as a list of int.

    Parameters
    ----------
    atoms : ContactAtoms
        with all hydrogens
    positions : (n, 3) float64 array, nm
        those of hydrogens change, and those that choices move
    rotors : list of Rotor
    choices : list of Choice
    mayAccept : (n,) bool array
        atoms that hydroxyls try to point at
    """
    if not rotors and not choices:
        return []
    return _Optimizer(atoms, positions, rotors, choices, mayAccept).run()


class _Optimizer:
    def __init__(self, atoms, positions, rotors, choices, mayAccept):
        self._atoms = atoms._replace(flags=atoms.flags.copy())
        self._positions, self._mayAccept = positions, mayAccept
        self._rotors, self._choices = rotors, choices
        self._groups = [_Group([rotor.axis[0], *rotor.hydrogens], [], _START) for rotor in rotors]
        for choice in choices:
            self._groups.append(_Group(choice.scored, list(map(float, range(len(choice.absent)))), 0.0))
            if choice.hydrogens:
                self._neutralize(choice.hydrogens)
        # How far choices move atoms, nm.
        self._margin = 0.25 if any(choice.moved for choice in choices) else 0.0
        self._circles = [self._circleOf(rotor) for rotor in rotors]
        for rotor in self._rotors:
            if rotor.kind == "NH3":
                self._atoms.flags[rotor.hydrogens] |= POSITIVE
        self._tree = cKDTree(positions)
        self._bonded = bondedWithin(atoms, _BONDS)
        self._isMarked = np.zeros(len(positions), dtype=bool)
        self._link()
        self._surroundings: dict[int, tuple[np.ndarray, np.ndarray]] = {}

    def _neutralize(self, pair):
        """Undo the charge of a histidine that seems to have both hydrogens, and begin without that on ND1."""
        flags = self._atoms.flags
        ring = np.flatnonzero((self._atoms.residues == self._atoms.residues[pair[0]]) & (flags & POSITIVE > 0))
        flags[ring] = flags[ring] & ~POSITIVE
        flags[ring[self._atoms.parents[ring] < 0]] |= ACCEPTOR
        flags[pair[0]] |= ABSENT

    def _link(self):
        """Find the groups that can touch each other; their dots on each other count twice, for both."""
        centers = np.array([self._positions[group.scored[0]] for group in self._groups])
        for first, second in cKDTree(centers).query_pairs(_LINKED + self._margin):
            self._groups[first].linked.append(second)
            self._groups[second].linked.append(first)
        self._weights = np.ones(len(self._positions))
        for group in self._groups:
            if group.linked:
                self._weights[group.scored] = 2

    def run(self):
        groups = self._groups
        for number, rotor in enumerate(self._rotors):
            groups[number].angles = self._roughAngles(number, rotor)
        waiting = list(range(len(groups)))
        for _ in range(_MOST_SWEEPS):
            changed = [number for number in waiting if self._choose(number, groups[number].angles)]
            waiting = sorted({other for number in changed for other in groups[number].linked})
            if not waiting:
                break
        for number, rotor in enumerate(self._rotors):
            if rotor.kind != "aromatic CH3":
                most = _STEP_OF_THREE if rotor.kind == "NH3" else _STEP
                middle = groups[number].orientation
                self._choose(number, [middle + offset for offset in _aroundZero(2 * most, _FINE)])
        return [int(group.orientation) for group in groups[len(self._rotors) :]]

    def _roughAngles(self, number, rotor):
        """Return the angles that are tried first; a hydroxyl or thiol turns to where it bumps least."""
        if rotor.kind == "aromatic CH3":
            return list(_STARTS_OF_AROMATIC)
        if rotor.kind == "NH3":
            return [_START + offset for offset in _aroundZero(4, _STEP_OF_THREE)]
        angles = self._anglesOfAcceptors(rotor)
        tried = [_START + offset for offset in _aroundZero(360 // _STEP, _STEP)]
        if angles:
            apart = np.abs(_wrap(np.array(tried)[:, None] - np.array(angles))).min(axis=1)
            tried = np.array(tried)[apart >= _STEP].tolist()
        best = tried[int(self._scores(number, tried, onlyBumps=True).argmax())] if tried else _START
        self._orient(number, best)
        merged: list[float] = []
        for angle in sorted([*angles, _wrap(best)], reverse=True):
            if not merged or (merged[-1] - angle > 0.5 * _STEP and angle >= 0.5 * _STEP - 180):
                merged.append(angle)
        return merged

    def _anglesOfAcceptors(self, rotor):
        """Return the angles, degrees, at which a hydrogen points at acceptors near it, or a little beside them."""
        positions = self._positions
        bearer, neighbor, reference = rotor.axis
        near = np.array(self._tree.query_ball_point(positions[bearer], _NEAR), dtype=int)
        near = near[(near != bearer) & (near != neighbor) & self._mayAccept[near]]
        gaps = np.linalg.norm(positions[near] - positions[bearer], axis=1)
        gaps -= _HYDROGEN_RADIUS + self._atoms.radii[near] + (_BOND_OF_SULFUR if rotor.kind == "SH" else _BOND)
        angles = []
        for atom, gap in zip(near.tolist(), gaps.tolist(), strict=True):
            if gap < _TOUCH:
                angle = _dihedral(*positions[[atom, bearer, neighbor, reference]])
                sides = [side for limit, side in _SIDES if gap < limit]
                angles += [angle, *(_wrap(angle + sign * side) for side in sides for sign in (-1, 1))]
        return angles

    def _choose(self, number, orientations):
        """Give a group the best orientation, of equal ones the first, and return whether it changed."""
        before = self._groups[number].orientation
        best = orientations[int(self._scores(number, orientations).argmax())]
        self._orient(number, best)
        return best != before

    def _orient(self, number, orientation):
        self._groups[number].orientation = orientation
        if number < len(self._rotors):
            self._positions[self._rotors[number].hydrogens] = self._placesAt(number, [orientation])[0]
        else:
            choice = self._choices[number - len(self._rotors)]
            self._positions[choice.moved] = choice.places[int(orientation)]
            self._atoms.flags[choice.hydrogens] &= ~ABSENT
            self._atoms.flags[choice.absent[int(orientation)]] |= ABSENT

    def _circleOf(self, rotor):
        """Return the middle of the circle on which a rotor's hydrogens lie, and its places of dihedrals 0 and 90."""
        points = [self._positions[atom][None] for atom in rotor.axis]
        length = np.linalg.norm(self._positions[rotor.hydrogens[0]] - points[0])
        zero, quarter, half = (
            turnedPlace(*points, length, TETRAHEDRAL, dihedral)[0] for dihedral in (0.0, 90.0, 180.0)
        )
        middle = 0.5 * (zero + half)
        return middle, zero - middle, quarter - middle

    def _placesAt(self, number, angles):
        """Return the places of a rotor's hydrogens at each of some angles, a (k, hydrogens, 3) array."""
        middle, zero, quarter = self._circles[number]
        offsets = np.array((0.0, 120.0, -120.0)[: len(self._rotors[number].hydrogens)])
        angles = np.radians(np.array(angles)[:, None] + offsets)[..., None]
        return middle + np.cos(angles) * zero + np.sin(angles) * quarter

    def _scores(self, number, orientations, onlyBumps=False):
        """Return the scores of orientations of a group, a (k,) array."""
        if number >= len(self._rotors):
            scores = []
            penalties = self._choices[number - len(self._rotors)].penalties
            for orientation, penalty in zip(orientations, penalties, strict=True):
                self._orient(number, orientation)
                scores.append(self._scoresOf(number, [0.0], None, onlyBumps)[0] - penalty)
            return np.array(scores)
        return self._scoresOf(number, orientations, self._placesAt(number, orientations), onlyBumps)

    def _scoresOf(self, number, orientations, hydrogenPlaces, onlyBumps):
        atoms, positions = self._atoms, self._positions
        hydrogens = [] if hydrogenPlaces is None else self._rotors[number].hydrogens
        total = np.zeros(len(orientations))
        for atom in self._groups[number].scored:
            if atoms.flags[atom] & ABSENT:
                continue
            others, hiding = self._around(atom)
            others, hiding = (found[atoms.flags[found] & ABSENT == 0] for found in (others, hiding))
            moving = []
            if hydrogenPlaces is not None:
                hiding = hiding[~areIn(hiding, hydrogens, self._isMarked)]
                moving = [
                    (atoms.radii[other], hydrogenPlaces[:, column])
                    for column, other in enumerate(hydrogens)
                    if other != atom
                ]
            places = positions[atom][None]
            if atom in hydrogens:
                places = hydrogenPlaces[:, hydrogens.index(atom)]
            total += scorePlaces(
                atoms, atom, places, others, positions, hiding, moving, onlyBumps, self._weights[others]
            )
        return total

    def _around(self, atom):
        """Return the atoms that an atom of a group may touch, and those that bonds join to it."""
        if atom not in self._surroundings:
            atoms = self._atoms
            isHeavy = atoms.parents[atom] < 0
            center = self._positions[atom if isHeavy else atoms.parents[atom]]
            # Hydrogens turn, those of other groups, too.
            reach = atoms.radii[atom] + atoms.radii.max() + (0.2 if isHeavy else 0.33) + 2 * self._margin
            near = np.array(self._tree.query_ball_point(center, reach), dtype=int)
            areBonded = areIn(near, rowOf(self._bonded, atom), self._isMarked)
            self._surroundings[atom] = near[~areBonded & (near != atom)], near[areBonded & (near != atom)]
        return self._surroundings[atom]


def _aroundZero(count, step):
    """Return 0, step, -step, 2 step, … in all count numbers."""
    return [(i + 1) // 2 * (step if i % 2 else -step) for i in range(count)]


def _wrap(angle):
    """Return an angle in degrees above -180, up to 180."""
    return 180 - (180 - angle) % 360


def _dihedral(point, bearer, neighbor, reference):
    """Return the dihedral of four points as `turnedPlace` takes it, in degrees."""
    axis = (neighbor - bearer) / np.linalg.norm(neighbor - bearer)
    across = reference - neighbor
    across = across - (across @ axis) * axis
    vector = point - bearer
    return float(np.degrees(np.arctan2(-vector @ np.cross(axis, across), vector @ across)))
