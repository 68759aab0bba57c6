"""Handedness of centers in completed residues, and peptide bonds of built ones.

PDBFixer places atoms by soft potentials that do not keep the hand of a center.
"""

from itertools import combinations
from typing import NamedTuple

import numpy as np
from openmm import unit
from openmm.app import Residue, element

from ...bonds import polymerLinks
from ...graphs import neighborLists
from ...templates import atomAliases, standardName
from ..geometry import dihedrals

# A center of a template with a smaller angle between its planes (rad) than this from planarity has no hand.
_PLANAR = np.radians(30)

# The mirror of one center changes the hand of the next one.
_PASSES = 3

_PEPTIDE = ("CA", "C", "N", "CA")

# Which oxygen of a phosphate is called OP1, as in the Protein Data Bank: PDBFixer's templates disagree with each other.
_PHOSPHATE, _PHOSPHATE_ANGLE = ("OP1", "P", "OP2", "O5'"), np.radians(124)


class Shape(NamedTuple):
    """A dihedral that a completed residue should have.

    particles : (int, int, int, int); angle : float, rad; residue : Residue
    """

    particles: tuple[int, int, int, int]
    angle: float
    residue: Residue


def findShapes(structure, added, templates):
    """Return the Shapes of a Structure in which atoms were added.

    They are those of centers with three heavy neighbors, from the residue's template, and of peptide bonds.

    added : (n,) bool array; templates : dict of PDBFixer's Template by residue name
    """
    shapes = []
    for residue in structure.topology.residues():
        atoms = _placesByName(residue)
        template = templates.get(standardName(residue.name))
        if template is not None and any(added[index] for index in atoms.values()):
            for names, angle in _centersOf(template):
                particles = tuple(atoms.get(name, -1) for name in names)
                if min(particles) >= 0 and added[list(particles)].any():
                    shapes.append(Shape(particles, angle, residue))
    allAtoms = list(structure.topology.atoms())
    bonds = [(bond[0].index, bond[1].index) for bond in structure.topology.bonds()]
    for first, second in polymerLinks(allAtoms, bonds):
        before, after = _placesByName(first.residue), _placesByName(second.residue)
        places = before, before, after, after
        particles = tuple(place.get(name, -1) for place, name in zip(places, _PEPTIDE, strict=True))
        if min(particles) >= 0 and added[list(particles)].any():
            shapes.append(Shape(particles, np.pi, second.residue))
    return shapes


def wrongShapes(shapes, positions):
    """Return the Shapes whose dihedral has the other sign or, for peptide bonds, is cis."""
    if not shapes:
        return []
    angles = dihedrals(positions, np.array([shape.particles for shape in shapes]))
    wanted = np.array([shape.angle for shape in shapes])
    isWrong = np.where(wanted == np.pi, np.cos(angles) > 0, np.sin(angles) * np.sin(wanted) < 0)
    return [shape for shape, wrong in zip(shapes, isWrong.tolist(), strict=True) if wrong]


def mirrorWrongCenters(structure, added, shapes):
    """Return the positions of a Structure with added branches at centers of the wrong hand mirrored.

    The mirror is the plane of the center and two of its neighbors. Lengths of rings that this breaks are to be relaxed.
    The two added oxygens of a phosphate change places.

    added : (n,) bool array, the atoms that may move
    """
    bonds = [(bond[0].index, bond[1].index) for bond in structure.topology.bonds()]
    neighbors = neighborLists(structure.topology.getNumAtoms(), bonds)
    positions = structure.positions.copy()
    for _ in range(_PASSES):
        for shape in wrongShapes(shapes, positions):
            center = shape.particles[1]
            if shape.angle == _PHOSPHATE_ANGLE:
                oxygens = [shape.particles[0], shape.particles[2]]
                if added[oxygens].all():
                    positions[oxygens] = positions[oxygens[::-1]]
                continue
            others = [atom for atom in shape.particles if atom != center]
            pairs = () if shape.angle == np.pi else combinations(others, 2)
            branches = [(_branchAt(center, pair, neighbors), pair) for pair in pairs]
            branches = [(len(branch), branch, pair) for branch, pair in branches if added[branch].all()]
            if branches:
                _, branch, (first, second) = min(branches)
                normal = np.cross(positions[first] - positions[center], positions[second] - positions[center])
                normal /= np.linalg.norm(normal)
                heights = (positions[branch] - positions[center]) @ normal
                positions[branch] -= 2 * heights[:, None] * normal
    return positions


def _branchAt(center, others, neighbors):
    """Return the atoms connected to a center, without it and without passing some of its neighbors, as a list."""
    found, pending = {center, *others}, [center]
    while pending:
        for atom in neighbors[pending.pop()]:
            if atom not in found:
                found.add(atom)
                pending.append(atom)
    return sorted(found - {center, *others})


def _placesByName(residue):
    aliases = atomAliases(standardName(residue.name))
    return {aliases.get(atom.name, atom.name): atom.index for atom in residue.atoms()}


def _centersOf(template):
    """Yield (four names, dihedral) of the centers of a template that are not planar."""
    positions = np.array(template.positions.value_in_unit(unit.nanometer))
    neighbors = {}
    for first, second in template.topology.bonds():
        if element.hydrogen in (first.element, second.element):
            continue
        neighbors.setdefault(first, []).append(second)
        neighbors.setdefault(second, []).append(first)
    for center, others in neighbors.items():
        if len(others) < 3:
            continue
        if center.name == "P":
            yield _PHOSPHATE, _PHOSPHATE_ANGLE
            continue
        first, second, third = others[:3]
        atoms = first, center, second, third
        angle = float(dihedrals(positions, np.array([[atom.index for atom in atoms]]))[0])
        if abs(np.sin(angle)) > np.sin(_PLANAR):
            yield tuple(atom.name for atom in atoms), angle
