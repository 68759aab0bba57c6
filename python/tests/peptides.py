"""Peptides of any residues, put together from the chemical component dictionary; their hydrogens and U by OpenMM."""

import random
import warnings

import numpy as np
import openmm
from biotite.structure.info import residue as component
from openmm import app, unit
from scenes import pdbLine
from scipy.spatial.distance import cdist

_LINK = 1.33  # Å, from C to N
_APART = 40.0  # Å, from chain to chain


def makePeptides(*chains):
    """Return the Topology of chains without hydrogens, each a tuple of residue names, and their positions in nm.

    Residues follow each other by trans peptide bonds; ACE and NME may be at the ends.
    """
    topology, positions = app.Topology(), []
    for number, names in enumerate(chains):
        chain = topology.addChain("ABCDEFGH"[number])
        before, link = np.empty((0, 3)), None  # of the chain: its atoms, and its end with axes along the next bond
        for place, name in enumerate(names, start=1):
            isLast = place == len(names)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of hydrogens without coordinates
                parts = component(name)
            places = dict(zip(parts.atom_name.tolist(), parts.coord.astype(float), strict=True))
            kept = [atom for atom in places if atom[0] != "H" and (atom != "OXT" or isLast)]
            if link is None:
                places = {atom: place + [_APART * number, 0, 0] for atom, place in places.items()}
            else:
                tries = [_turnedBy(angle, places, *link) for angle in np.arange(0, 2 * np.pi, np.pi / 12)]
                side = [atom for atom in kept if atom not in ("N", "CA")]
                places = max(tries, key=lambda one: cdist([one[atom] for atom in side], before).min())
            residue = topology.addResidue(name, chain)
            for atom, element in zip(parts.atom_name.tolist(), parts.element.tolist(), strict=True):
                if atom in kept:
                    topology.addAtom(atom, app.Element.getBySymbol(element.capitalize()), residue)
                    positions.append(places[atom])
            before = np.array(positions[-len(before) - len(kept) :])
            leaving, neighbor = ("H", "CH3") if name == "ACE" else ("OXT", "CA")
            if leaving in places:
                axes = _frame(places[leaving] - places["C"], places[neighbor] - places["C"])
                link = places["C"] + _LINK * axes[:, 0], axes
    topology.createStandardBonds()
    return topology, 0.1 * np.array(positions)


def _turnedBy(phi, places, end, axes):
    """Return the places of a residue whose N is at the end of a chain, with some φ."""
    neighbor = places["C" if "CA" not in places else "CA"] - places["N"]
    x = neighbor / np.linalg.norm(neighbor)
    _, y, z = _frame(x, np.array([0.3, 0.5, 0.8])).T
    # The atom before is at 120° from the neighbour, at an angle phi about the bond to that.
    backwards = -0.5 * x + np.sqrt(0.75) * (np.cos(phi) * y + np.sin(phi) * z)
    turned = axes @ _frame(-backwards, -neighbor).T
    return {atom: end + turned @ (place - places["N"]) for atom, place in places.items()}


def _frame(along, beside):
    """Return axes as columns: along one vector, then towards another."""
    x = along / np.linalg.norm(along)
    y = beside - (beside @ x) * x
    y /= np.linalg.norm(y)
    return np.stack([x, y, np.cross(x, y)], axis=1)


def withHydrogens(topology, positions):
    """Return the Topology and the positions (nm) with what OpenMM's Modeller adds."""
    modeller = app.Modeller(topology, positions * unit.nanometer)
    random.seed(1)  # Modeller draws random numbers of Python
    modeller.addHydrogens()
    return modeller.topology, np.array(modeller.positions.value_in_unit(unit.nanometer))


def energyOf(system, positions):
    """Return U in kJ/mol on the Reference platform."""
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(positions)
    return context.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)


def linesOf(topology, positions, rename=lambda atom: (atom.name, atom.residue.name, atom.residue.index + 1)):
    """Return the lines of a PDB file; a function gives the names of an atom and its residue, and the number of that."""
    lines = []
    for atom in topology.atoms():
        name, residue, number = rename(atom)
        line = pdbLine(atom.index + 1, name, residue, "A", number, *10 * positions[atom.index])
        lines.append(line[:76] + f"{atom.element.symbol:>2}")
    return lines
