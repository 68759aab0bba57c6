"""Describes the moving and the fixed parts of a sampling run."""

from collections import Counter

import numpy as np

from ...naming import describeResidue
from ...notes import countOf
from ...residues import isPolymer
from ...torsions import KINDS
from .energyreport import describeEnergies

# A line names at most this number of parts, and counts the rest.
_LONGEST_LIST = 5


def describePlan(plan):
    """Return lines on a Plan: moving parts; fixed parts, with reasons; roots of moving molecules; cut bonds.

    If energies are sampled, another line lists the rigid parts, or says that molecules are flexible.
    """
    lines = _Describer(plan).lines()
    if plan.rigid is not None:
        lines.append(f"rigid: {plan.rigid}")
    if plan.choice.isFlexible:
        lines.append("flexible: all atoms of what moves are also displaced one by one, unless --fix selects them")
    for what, bonds in (
        ("cut disulfides", plan.cutDisulfides),
        ("cut bonds of metals", plan.cutMetals),
        ("bonds that closed moves keep", plan.closed),
    ):
        if bonds:
            lines.append(f"{what}: {_join([' – '.join(residues) for residues in bonds])}")
    return lines


def printPlan(sampling, console):
    """Print what a Sampling moves and which code evaluates its energies on a rich Console."""
    for line in describePlan(sampling.plan):
        console.print(line)
    if sampling.energies is not None:
        console.print(describeEnergies(sampling.energies))


class _Describer:
    def __init__(self, plan):
        self._plan = plan
        self._atoms = list(plan.structure.topology.atoms())
        self._residues = _distinctResidues(self._atoms, plan.molecules)
        self._atomCounts = np.bincount(plan.molecules)
        self._stayingCounts = np.bincount(plan.molecules, weights=plan.stays).astype(int)
        self._chainsOfMolecule = Counter(
            chain for residues in self._residues for chain in {r.chain.id for r in residues if isPolymer(r)}
        )

    def lines(self):
        return [f"moves: {self._moves()}", f"stays: {self._stays()}", f"held: {self._held()}"]

    def _moves(self):
        plan = self._plan
        parts = []
        for molecule in np.flatnonzero(plan.isTurning):
            count, moving = self._atomCounts[molecule], self._atomCounts[molecule] - self._stayingCounts[molecule]
            atoms = f"{count:,} atoms" if moving == count else f"{moving:,} of {count:,} atoms"
            parts.append(f"{self._name(molecule)} ({atoms})")
        text = _join(parts)
        if parts:
            counts = Counter(torsion.kind for torsion in plan.torsions)
            kinds = ", ".join(f"{counts[kind]:,} {kind}" for kind in KINDS if counts[kind])
            text += f" by {countOf(len(plan.torsions), 'torsion')} ({kinds})"
        if plan.isRigidBody.any():
            turning = [self._name(molecule) for molecule in np.flatnonzero(plan.isRigidBody & plan.isTurning)]
            others = self._group(np.flatnonzero(plan.isRigidBody & ~plan.isTurning))
            text += f"{'; ' if parts else ''}as a whole {_join(turning + others)}"
        return text

    def _stays(self):
        plan = self._plan
        byReason = {}
        for molecule in np.flatnonzero(~plan.isTurning & ~plan.isRigidBody):
            byReason.setdefault(self._whyItStays(molecule), []).append(molecule)
        parts = [f"{_join(self._group(found))}: {reason}" for reason, found in byReason.items()]
        holding = np.count_nonzero(plan.stays & plan.isTurning[plan.molecules])
        if holding:
            parts.append(f"{countOf(holding, 'atom')} that hold{'s' if holding == 1 else ''} what moves")
        return "; ".join(parts) or "nothing"

    def _whyItStays(self, molecule):
        plan = self._plan
        if molecule in plan.molecules[plan.fixedAtoms]:
            return "--fix"
        if molecule in plan.idleMolecules:
            return "not in --move"
        return "no torsion"

    def _held(self):
        plan = self._plan
        parts = []
        for molecule in np.flatnonzero(plan.isTurning & ~plan.isRigidBody):
            atoms = [self._atoms[i] for i in np.flatnonzero(plan.stays & (plan.molecules == molecule))]
            option = ", --fix" if molecule in plan.molecules[plan.fixedAtoms] else ""
            where = _range([atom.residue for atom in atoms])
            parts.append(f"{self._name(molecule)} at {where} ({countOf(len(atoms), 'atom')}{option})")
        text = _join(parts) or "nothing"
        if not plan.choice.rigidBodies:
            return f"{text}; no molecule moves as a whole (--rigid-bodies)"
        atGaps = [molecule for molecule in plan.moleculesAtGaps if not plan.isRigidBody[molecule]]
        if atGaps and plan.choice.move is None:
            text += "; fragments next to a gap do not move as a whole unless --move names them"
        return text

    def _name(self, molecule):
        """Name a molecule by its chains, or by its residues if it is a part of a chain."""
        residues = [residue for residue in self._residues[molecule] if isPolymer(residue)]
        chains = dict.fromkeys(residue.chain.id for residue in residues)
        if any(self._chainsOfMolecule[chain] > 1 for chain in chains) or not residues:
            return _range(residues or self._residues[molecule])
        if not all(chain.strip() for chain in chains):
            return f"chain {_range(residues)}"
        return f"chain{'s' if len(chains) > 1 else ''} {_join(list(chains))}"

    def _group(self, molecules):
        """List molecules with their numbers of atoms; equal molecules that are not polymers form one entry."""
        parts = []
        others = {}
        for molecule in molecules:
            residues = self._residues[molecule]
            if sum(map(isPolymer, residues)) > 1:
                parts.append(f"{self._name(molecule)} ({countOf(self._atomCounts[molecule], 'atom')})")
            else:
                others.setdefault("-".join(residue.name for residue in residues), []).append(molecule)
        for names, found in others.items():
            number = f"{len(found)} " if len(found) > 1 else ""
            parts.append(f"{number}{names} ({countOf(self._atomCounts[found].sum(), 'atom')})")
        return parts


def _distinctResidues(atoms, molecules):
    """Return the residues of each molecule, in the order of their atoms."""
    residues = [{} for _ in range(max(molecules) + 1)]
    for atom, molecule in zip(atoms, molecules, strict=True):
        residues[molecule][atom.residue] = None
    return [list(found) for found in residues]


def _range(residues):
    first, last = describeResidue(residues[0]), describeResidue(residues[-1])
    return first if first == last else f"{first} – {last}"


def _join(parts):
    more = len(parts) - _LONGEST_LIST
    return ", ".join(parts if more <= 0 else [*parts[:_LONGEST_LIST], f"{more} more"])
