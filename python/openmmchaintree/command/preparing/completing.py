"""Adding missing heavy atoms and residues by PDBFixer."""

from collections import defaultdict
from io import StringIO
from string import ascii_uppercase

import numpy as np
import openmm.app
from openmm import unit
from openmm.app import element

from ...bonds import LINKS
from ...errors import InputError
from ...extras import importExtra
from ...naming import describeResidue
from ...notes import Note, found
from ...residues import aminoAcid, isPolymer
from ...structures.sequencegaps import findSequenceGaps, lacksBackbone
from ...structures.structure import withoutAtoms
from ...templates import atomAliases, standardName, templateBonds
from ..hydrogens import boundEnds, repeatable
from .phosphates import withoutPhosphates
from .segments import Missing, findSegments, gapsWithStubs

# PDBFixer is made from a file; its Topology and positions are replaced at once.
_ANY_FILE = "ATOM      1  CA  GLY A   1       0.000   0.000   0.000  1.00  0.00           C\nEND\n"


def completeHeavyAtoms(structure, energyModel, seed):
    """Return a Structure with its missing heavy atoms, the indices of these, PDBFixer's templates, and a list of Note.

    Side chains, the ends of chains (OXT), short gaps and the phosphates between nucleotides are completed; atoms that
    are there stay in place. Sides of other gaps become ends of chains. Phosphates at 5' ends that an EnergyModel, if
    given, does not have are left out.

    Raises
    ------
    InputError
        if most of a chain's backbone is missing
    """
    gaps, notes = ([], []) if structure.file is None else findSequenceGaps(structure.file, structure.model)
    structure, gaps, more = _withoutStubs(structure, gaps)
    notes += more
    structure, more = withoutPhosphates(structure, energyModel)
    notes += more
    structure, more = _withoutSingles(structure, findSegments(structure, gaps)[0])
    notes += more
    segments, more = findSegments(structure, gaps)
    notes += more
    made = _runPDBFixer(structure, segments, seed)
    completed, added, more = _restore(structure, segments, made)
    return completed, added, made.templates, notes + more


def _withoutStubs(structure, gaps):
    """Return a Structure without amino acids that lack N, CA or C, its SequenceGaps, and a list of Note."""
    stubs = [residue for residue in structure.topology.residues() if lacksBackbone(residue)]
    if not stubs:
        return structure, gaps, []
    count = sum(1 for residue in structure.topology.residues() if not lacksBackbone(residue))
    if 2 * len(stubs) > count:
        raise InputError(
            f"--prepare: {len(stubs)} amino acids lack N, CA or C, such as {describeResidue(stubs[0])}; only side "
            "chains, ends and short gaps are built"
        )
    atoms = np.array([atom.index for residue in stubs for atom in residue.atoms()])
    note = Note("residues without N, CA or C, left out or built again", map(describeResidue, stubs))
    return withoutAtoms(structure, atoms), gapsWithStubs(structure.topology, gaps, set(stubs)), [note]


def _withoutSingles(structure, segments):
    """Return a Structure without amino acids alone between gaps, which no force field has, and a list of Note."""
    between = [bond for bond in structure.topology.bonds() if bond[0].residue is not bond[1].residue]
    bound = {atom.residue for bond in between for atom in bond}
    alone = [segment.residues[0] for segment in segments if len(segment.residues) == 1]
    singles = [residue for residue in alone if aminoAcid(residue.name) is not None and residue not in bound]
    if not singles or len(singles) == structure.topology.getNumResidues():
        return structure, []
    atoms = np.array([atom.index for residue in singles for atom in residue.atoms()])
    return withoutAtoms(structure, atoms), [Note("single amino acids left out", map(describeResidue, singles))]


def _runPDBFixer(structure, segments, seed):
    """Complete a copy of a Structure, with a chain for each Segment; return the PDBFixer."""
    fixer = importExtra("pdbfixer", "--prepare", InputError).PDBFixer(pdbfile=StringIO(_ANY_FILE))
    topology, copies, own = openmm.app.Topology(), {}, {}
    missing = defaultdict(list)
    for segment in segments:
        chain = topology.addChain()
        place = 0
        for residue in segment.residues:
            if isinstance(residue, Missing):
                missing[chain.index, place].append(residue.name)
                continue
            place += 1
            name = standardName(residue.name)
            aliases = atomAliases(name)
            newResidue = topology.addResidue(name, chain)
            own[newResidue] = residue
            for atom in residue.atoms():
                newName = atom.name if atom.element is element.hydrogen else aliases.get(atom.name, atom.name)
                copies[atom] = topology.addAtom(newName, atom.element, newResidue)
    for first, second in structure.topology.bonds():
        topology.addBond(copies[first], copies[second])
    platform = openmm.Platform.getPlatformByName("CPU")
    fixer.topology, fixer.platform, fixer.missingResidues = topology, platform, dict(missing)
    fixer.positions = [openmm.Vec3(*position) for position in structure.positions.tolist()] * unit.nanometer
    fixer.findMissingAtoms()
    _, back = boundEnds(structure.topology)
    fixer.missingTerminals = {
        residue: atoms for residue, atoms in fixer.missingTerminals.items() if own[residue] not in back
    }
    with repeatable(seed, platform):
        fixer.addMissingAtoms(seed=seed)
    return fixer


def _restore(structure, segments, fixer):
    """Return a Structure with the atoms of a PDBFixer, the indices of added ones, and a list of Note."""
    made = fixer.topology.residues()
    builder = _Builder(structure, fixer.positions.value_in_unit(unit.nanometer))
    before = None
    for segment in segments:
        builder.beginSegment(segment, before)
        for residue, following in zip(segment.residues, [*segment.residues[1:], None], strict=True):
            builder.addResidue(residue, next(made), isinstance(following, Missing))
        before = segment
    return builder.finish()


class _Builder:
    """A Structure in the making: old residues and new ones, with old atoms first in each."""

    def __init__(self, structure, placed):
        self._structure = structure
        self._placed = placed
        self._topology = openmm.app.Topology()
        self._taken = {_labels(residue) for residue in structure.topology.residues()}
        self._chain = self._previous = None
        self._joined = set()
        self._copies = {}
        self._sources, self._positions, self._bonds, self._completed = [], [], [], []

    def beginSegment(self, segment, before):
        """Begin a new chain of the same name at the begin of a chain, and behind an open gap."""
        first = segment.residues[0]
        last = None if before is None else before.residues[-1]
        if last is None or last.chain is not first.chain or isPolymer(last) == isPolymer(first):
            self._chain = self._topology.addChain(first.chain.id)
        self._previous, self._joined = None, segment.joined

    def addResidue(self, residue, made, isBeforeGap):
        """Add a residue with the atoms that PDBFixer made: old ones in their order, then new ones."""
        isNew = isinstance(residue, Missing)
        old = [] if isNew else [atom for atom in residue.atoms() if not (isBeforeGap and _isEnd(atom))]
        labels = self._freeLabels(residue) if isNew else _labels(residue)
        name = residue.name
        newResidue = self._topology.addResidue(name, self._chain, *labels[1:])
        added = []
        for number, atom in enumerate(made.atoms()):
            source = old[number] if number < len(old) else None
            if source is None:
                added.append(self._topology.addAtom(atom.name, atom.element, newResidue))
                self._sources.append(-1)
            else:
                copy = self._topology.addAtom(source.name, source.element, newResidue, source.id)
                self._copies[source] = copy
                self._sources.append(source.index)
            self._positions.append(tuple(self._placed[atom.index]))
        if added:
            atoms = list(newResidue.atoms())
            bonds = templateBonds(name, [atom.name for atom in atoms])
            self._bonds += [(atoms[first], atoms[second]) for first, second in bonds]
            if not isNew:
                self._completed.append(f"{describeResidue(newResidue)} ({', '.join(atom.name for atom in added)})")
        if self._previous is not None and (isNew or isinstance(self._previous[0], Missing) or residue in self._joined):
            self._bonds.append(_linkAtoms(self._previous[1], newResidue))
        self._previous = residue, newResidue

    def _freeLabels(self, missing):
        """Return chain, number and insertion code of a new residue, which no other residue has."""
        chain, number, _ = _labels(missing.after)
        begin = int(number)
        labels = chain, str(begin + missing.number), ""
        codes = iter(ascii_uppercase)
        while labels in self._taken:
            labels = chain, number, next(codes)
        self._taken.add(labels)
        return labels

    def finish(self):
        """Return the Structure, the indices of added atoms, and a list of Note."""
        structure = self._structure
        orders = dict.fromkeys((tuple(sorted((a.index, b.index))) for a, b in self._bonds), (None, None))
        for bond in structure.topology.bonds():
            if bond[0] in self._copies and bond[1] in self._copies:
                pair = sorted(self._copies[atom].index for atom in bond[:2])
                orders[tuple(pair)] = bond.type, bond.order
        atoms = list(self._topology.atoms())
        for (first, second), order in orders.items():
            self._topology.addBond(atoms[first], atoms[second], *order)
        sources = np.array(self._sources)
        positions = np.array(self._positions)
        positions[sources >= 0] = structure.positions[sources[sources >= 0]]
        alternates = [structure.alternates[i] if i >= 0 and structure.alternates else "" for i in self._sources]
        notes = found([Note("residues completed", self._completed)])
        whole = structure._replace(topology=self._topology, positions=positions, alternates=alternates)
        return whole, np.flatnonzero(sources < 0), notes


def _labels(residue):
    return residue.chain.id, residue.id, residue.insertionCode


def _linkAtoms(first, second):
    """Return the atoms of the bond between two residues, the first before the second."""
    atoms = [{_nameInTable(atom): atom for atom in residue.atoms()} for residue in (first, second)]
    return next((atoms[0][name], atoms[1][other]) for name, other in LINKS if name in atoms[0] and other in atoms[1])


def _isEnd(atom):
    """Whether an atom is the second oxygen of a chain's end."""
    return _nameInTable(atom) == "OXT"


def _nameInTable(atom):
    """Return the name of an atom in OpenMM's table."""
    return atomAliases(standardName(atom.residue.name)).get(atom.name, atom.name)
