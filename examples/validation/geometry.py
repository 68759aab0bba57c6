"""Lengths, angles and torsions of a molecule in many frames, by MDTraj; bonds and angles by their parameters."""

from typing import NamedTuple

import mdtraj
import numpy as np
import openmm
from molecules import namedTorsions


class Measured(NamedTuple):
    """Internal coordinates of n frames: nm and degrees."""

    lengths: dict  # {kind of bond: (n, members)}
    angles: dict  # {kind of angle: (n, members)}
    torsions: dict  # {(residue, name): (n,)}

    @property
    def planes(self):
        """Return phi and psi of the residues that have both, {residue: ((n,), (n,))}."""
        residues = [residue for residue, name in self.torsions if (residue, "psi") in self.torsions and name == "phi"]
        return {residue: (self.torsions[residue, "phi"], self.torsions[residue, "psi"]) for residue in residues}


class Geometry:
    """The internal coordinates that a comparison measures."""

    def __init__(self, topology, system):
        self.topology = topology
        self.residues = [f"{residue.name} {residue.index}" for residue in topology.residues()]
        self.bonds = self._kinds(system, openmm.HarmonicBondForce, "Bond", 2)
        self.angles = self._kinds(system, openmm.HarmonicAngleForce, "Angle", 3)
        self.torsions = namedTorsions(topology)

    def _kinds(self, system, forceClass, term, count):
        """Return the terms of a Force by their parameters, {name of the first one: particles of all}."""
        names = [atom.name for atom in self.topology.atoms()]
        kinds, labels = {}, {}
        (force,) = [force for force in system.getForces() if isinstance(force, forceClass)]
        for index in range(getattr(force, f"getNum{term}s")()):
            values = getattr(force, f"get{term}Parameters")(index)
            particles, parameters = values[:count], tuple(value._value for value in values[count:])
            label = labels.setdefault(parameters, self._newLabel("-".join(names[i] for i in particles), kinds))
            kinds.setdefault(label, []).append(particles)
        return {label: np.array(particles) for label, particles in kinds.items()}

    def _newLabel(self, label, kinds):
        return label if label not in kinds else f"{label} ({len(kinds)})"

    def measure(self, positions):
        """Return what is Measured of frames (n, atoms, 3)."""
        frames = mdtraj.Trajectory(positions, mdtraj.Topology.from_openmm(self.topology))
        lengths = {kind: mdtraj.compute_distances(frames, pairs) for kind, pairs in self.bonds.items()}
        angles = {kind: np.degrees(mdtraj.compute_angles(frames, threes)) for kind, threes in self.angles.items()}
        torsions = np.degrees(mdtraj.compute_dihedrals(frames, np.array(list(self.torsions.values()))))
        return Measured(lengths, angles, dict(zip(self.torsions, torsions.T, strict=True)))


def basins(phi, psi):
    """Return in which basin each frame is: {name: (n,) bool array}. Angles are in degrees."""
    isLeft = phi > 0
    isAlpha = ~isLeft & (psi > -120) & (psi < 50)
    isBeta = ~isLeft & ~isAlpha & (phi < -100)
    return {"alpha": isAlpha, "beta": isBeta, "PPII": ~(isLeft | isAlpha | isBeta), "left": isLeft}


def thirds(angles):
    """Return in which third of the circle each frame is: {name: (n,) bool array}. Angles are in degrees."""
    number = np.floor(angles % 360 / 120)
    return {name: number == i for i, name in enumerate(("g+", "trans", "g-"))}
