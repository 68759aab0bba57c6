"""The scores of all models of a structure, or of all frames of a trajectory, by several definitions."""

from typing import NamedTuple

import numpy as np

from ..clashes import Clash, FrameClashes
from ..errors import InputError
from ..naming import describeResidue, nameAtom
from ..notes import Note
from ..residues import isPolymer
from ..structures.clashsearch import ClashSearch
from ..structures.structure import readModels, villinPath
from .chainoverlap import ChainOverlap, chainOverlaps
from .clashscore import clashscore
from .contactatoms import LEAST_OCCUPANCY
from .covalentfaults import BrokenBond, PiercedRing, covalentFaults
from .poses import PoseCheck, checkPoses
from .protonation import Protonated, withHydrogens

OWN, MOLPROBITY, AF3, POSEBUSTERS = DEFINITIONS = ("own", "molprobity", "af3", "posebusters")


class MolProbityScore(NamedTuple):
    """MolProbity's clashscore.

    clashscore : float, clashes per 1,000 atoms with hydrogens and without water; atomCount : int, of these atoms
    clashes : list of Clash, whose particles are atoms of the structure, for an added hydrogen the atom that bears it
    flipped : list of str, residues whose side chains were flipped before
    """

    clashscore: float
    atomCount: int
    clashes: list[Clash]
    flipped: list[str]


class ClashScores(NamedTuple):
    """The scores of a model or a frame. A score by a definition that was not asked for is None.

    number : int, from 0; own : FrameClashes; molprobity : MolProbityScore
    chains : list of ChainOverlap, AlphaFold 3's verdict by chain, of which `has_clash` is whether any clashes
    poses : list of PoseCheck, PoseBusters' verdicts, by ligand and by kind of molecule around it
    brokenBonds : list of BrokenBond; piercedRings : list of PiercedRing
    """

    number: int
    own: FrameClashes | None
    molprobity: MolProbityScore | None
    chains: list[ChainOverlap] | None
    poses: list[PoseCheck] | None
    brokenBonds: list[BrokenBond]
    piercedRings: list[PiercedRing]


class ScoreSearch:
    """The scores of a structure, model by model, or of a trajectory, frame by frame: iterate it once.

    Iteration yields ClashScores. At a damaged model or frame it raises an InputError.

    Attributes
    ----------
    source : str or Path, of the structure
    topology : openmm.app.Topology
    names : list of AtomName
    notes : list of Note, on the input
    """

    def __init__(self, structure, trajectory=None, definitions=(MOLPROBITY,), keepHydrogens=False, flips=False):
        """Read a structure.

        Parameters
        ----------
        structure, trajectory : str or Path
            as for `findClashes`
        definitions : sequence of str
            of DEFINITIONS
        keepHydrogens : bool
            score the hydrogens of the file, instead of those that Reduce would place
        flips : bool
            flip side chains of Asn, Gln and His first, where hydrogens fit clearly better

        Raises
        ------
        InputError
            if a file cannot be read, or hydrogens are to be kept and there are none
        """
        self._definitions, self._keepHydrogens, self._flips = definitions, keepHydrogens, flips
        self.source = villinPath() if structure is None else structure
        needsSearch = OWN in definitions or trajectory is not None
        self._search = ClashSearch(structure, trajectory) if needsSearch else None
        self._models = readModels(self.source) if self._search is None else self._search.models
        self.topology = self._models.topology
        self.names = [nameAtom(atom) for atom in self.topology.atoms()]
        self.notes = self._models.notes if self._search is None else self._search.notes
        self._occupancies = np.array([atom.occ for atom in self._models.atoms])
        if (np.abs(self._occupancies) < LEAST_OCCUPANCY).all():
            self._occupancies[:] = 1
            self.notes.append(Note("all occupancies are 0, and do not count"))
        self._areHetero = _heteroAtoms(self._models) if POSEBUSTERS in definitions else None
        if keepHydrogens and MOLPROBITY in definitions and not _hasHydrogens(self.topology):
            raise InputError(f"{structure}: there are no hydrogens to keep")

    def __iter__(self):
        if self._search is None:
            for number, positions in enumerate(self._models.positions):
                yield self.score(positions, number)
            if self._models.damage is not None:
                raise self._models.damage
            return
        try:
            for number, positions, box in self._search.wholeFrames():
                yield self.score(positions, number, box)
        finally:
            self._search.close()

    def score(self, positions, number=0, box=None):
        """Return the ClashScores at positions, (n, 3) in nm, of whole molecules."""
        own = chains = poses = molprobity = None
        if OWN in self._definitions:
            clashes = self._search.finder.find(positions, box)
            own = FrameClashes(number, clashes, 1000 * len(clashes) / self._search.finder.checkedCount)
        if MOLPROBITY in self._definitions:
            molprobity = self._molprobity(positions)
        if AF3 in self._definitions:
            chains = chainOverlaps(self.topology, positions)
        if POSEBUSTERS in self._definitions:
            poses = checkPoses(self.topology, positions, self._areHetero)
        try:
            faults = covalentFaults(self.topology, positions)
        except InputError as error:
            raise InputError(f"{self.source}: {error}") from error
        return ClashScores(number, own, molprobity, chains, poses, *faults)

    def _molprobity(self, positions):
        if self._keepHydrogens:
            atoms = np.arange(len(positions))
            made = Protonated(self.topology, positions, atoms, atoms)
        else:
            made = withHydrogens(self.topology, positions, flips=self._flips)
        found = clashscore(made.topology, made.positions, self._occupancies[made.bearers])
        if found.atomCount == 0:
            raise InputError(f"{self.source}: there is nothing but water")
        atoms = list(made.topology.atoms())
        clashes = []
        for (first, second), overlap in zip(found.pairs.tolist(), found.overlaps.tolist(), strict=True):
            ends = sorted((int(made.bearers[atom]), nameAtom(atoms[atom])) for atom in (first, second))
            (particle1, name1), (particle2, name2) = ends
            clashes.append(Clash(particle1, particle2, name1, name2, overlap))
        residues = list(made.topology.residues())
        flipped = [describeResidue(residues[index]) for index in made.flipped]
        ordered = sorted(clashes, key=lambda clash: clash[:4])
        return MolProbityScore(found.score, found.atomCount, ordered, flipped)


def _heteroAtoms(models):
    """Return for each atom whether the file calls it a heteroatom; without such marks, whether it is of no polymer."""
    marks = {
        (chain.name, str(residue.seqid.num), residue.seqid.icode.strip(), residue.name): residue.het_flag
        for chain in models.file[0]
        for residue in chain
    }
    found = []
    for residue in models.topology.residues():
        mark = marks.get((residue.chain.id, residue.id, residue.insertionCode, residue.name))
        isHetero = mark == "H" if mark in ("H", "A") else not isPolymer(residue)
        found += [isHetero] * sum(1 for _ in residue.atoms())
    return np.array(found, dtype=bool)


def _hasHydrogens(topology):
    return any(atom.element is not None and atom.element.symbol == "H" for atom in topology.atoms())
