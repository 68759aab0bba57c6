"""The proteins of the benchmark: which there are, and a force and a scene for each way of looking at them."""

import os
import warnings
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
import openmm
from openmm import app, unit
from openmmchaintree import StericExclusionForce
from openmmchaintree.command.allpairs import HardSpheres
from openmmchaintree.errors import InputError
from openmmchaintree.residues import aminoAcid
from openmmchaintree.sterics import createStericExclusionForce
from openmmchaintree.structures.structure import readStructure
from openmmchaintree.torsions import Torsion, findTorsions

from .scene import Scene, makeScene

# What is run where nobody names structures: the villin headpiece that OpenMM carries along, and of these those that lie
# in the folder that the variable names. The last three are a small, a medium and a long backbone as in the paper.
_FOLDER = "CHAINTREE_TEST_DATA"
_FILES = ("bpti_h.pdb", "5dfr_h.pdb", "1shg.pdb", "1htb.pdb", "2cas.pdb.gz")

_BACKBONE_ATOMS = ("N", "CA", "C")
_BACKBONE_KINDS = ("phi", "psi")
_KINDS = ("phi", "psi", "chi")


class Protein(NamedTuple):
    """The longest chain of amino acids of a structure.

    name : str; residues : int; topology : openmm.app.Topology; positions : (n, 3) float64 array, nm
    """

    name: str
    residues: int
    topology: app.Topology
    positions: np.ndarray

    @property
    def hasHydrogens(self):
        """Whether there is a hydrogen."""
        return any(_isHydrogen(atom) for atom in self.topology.atoms())


class Model(NamedTuple):
    """A protein as hard spheres, without the roles that atoms have in hydrogen bonds; pairs that overlap are excluded.

    protein : Protein; force : StericExclusionForce; torsions : list of Torsion, as in the force; scene : Scene
    """

    protein: Protein
    force: StericExclusionForce
    torsions: list[Torsion]
    scene: Scene

    @property
    def name(self):
        """What tables call it."""
        return self.protein.name

    def backboneTorsions(self):
        """Return the indices of the force's torsions that are of the backbone."""
        return [i for i, torsion in enumerate(self.torsions) if torsion.kind in _BACKBONE_KINDS]


class ProteinModels:
    """The Models of a Protein, made when they are asked for; an InputError tells of an element without radius.

    protein : Protein
    """

    def __init__(self, protein):
        """Take over a Protein."""
        self.protein = protein

    @cached_property
    def backbone(self):
        """The Model with three atoms of each residue."""
        return self._only("backbone", lambda atom: atom.name in _BACKBONE_ATOMS)

    @cached_property
    def heavyAtoms(self):
        """The Model without hydrogens."""
        return self._only("heavy atoms", lambda atom: not _isHydrogen(atom))

    @cached_property
    def allAtoms(self):
        """The Model with hydrogens, if it has some."""
        return self._only("all atoms", lambda atom: True)

    def withSideChains(self):
        """Return the Models with side chains, the one with hydrogens last."""
        return [self.heavyAtoms, self.allAtoms] if self.protein.hasHydrogens else [self.heavyAtoms]

    def _only(self, words, isWanted):
        name, _, topology, positions = self.protein
        return _makeModel(_choose(f"{name} {words}", topology, positions, isWanted))


def findProteins(isQuick):
    """Read the structures that lie ready, or only the smallest of them.

    Returns
    -------
    proteins : list of Protein
    missing : list of str
        the names of those that are not there

    Raises
    ------
    InputError
        if a file cannot be read or holds no chain of amino acids
    """
    if isQuick:
        return [readProtein()], []
    folder = os.environ.get(_FOLDER)
    found = [Path(folder, name) for name in _FILES if folder and Path(folder, name).exists()]
    missing = [name for name in _FILES if name not in {path.name for path in found}]
    return [readProtein(path) for path in (None, *found)], missing


def readProtein(path=None):
    """Read the Protein of a file, by default the villin headpiece."""
    structure = readStructure(path)
    chains = [
        {residue for residue in chain.residues() if aminoAcid(residue.name) is not None}
        for chain in structure.topology.chains()
    ]
    longest = max(chains, key=len)
    if not longest:
        raise InputError(f"{path}: there is no chain of amino acids")
    return _choose(structure.name, structure.topology, structure.positions, lambda atom: atom.residue in longest)


def _choose(name, topology, positions, isWanted):
    """Make the Protein of some atoms."""
    atoms = list(topology.atoms())
    kept = [atom.index for atom in atoms if isWanted(atom)]
    modeller = app.Modeller(topology, np.zeros((len(atoms), 3)) * unit.nanometer)
    modeller.delete([atom for atom in atoms if not isWanted(atom)])
    return Protein(name, modeller.topology.getNumResidues(), modeller.topology, positions[kept])


def _isHydrogen(atom):
    return atom.element is app.element.hydrogen


def _makeModel(protein):
    """Make the Model of a Protein; disulfides are cut, so that nothing of the chain is in a ring."""
    torsions = findTorsions(protein.topology, protein.positions, _KINDS, cutDisulfides=True).torsions
    force = makeForce(protein, torsions)
    force.setHydrogenBondAllowance(0)
    for pair in HardSpheres(force).overlaps(protein.positions).pairs.tolist():
        force.addExclusion(*pair)
    sideChains = [torsion.kind not in _BACKBONE_KINDS for torsion in torsions]
    return Model(protein, force, torsions, makeScene(force, protein.positions, sideChains))


def makeForce(protein, torsions=_KINDS):
    """Make the StericExclusionForce of a Protein.

    Raises
    ------
    InputError
        if an element has no radius
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what is left out is no news to those who want to know times
        try:
            return createStericExclusionForce(
                protein.topology, protein.positions, torsions=torsions, cutDisulfides=True
            )
        except ValueError as error:
            raise InputError(f"{protein.name}: {error}") from error


def makeSystem(protein, *forces):
    """Make the System of a Protein with some forces."""
    system = openmm.System()
    for atom in protein.topology.atoms():
        system.addParticle(atom.element.mass)
    for force in forces:
        system.addForce(force)
    return system
