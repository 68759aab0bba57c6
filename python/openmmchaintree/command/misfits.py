"""Explains in one line why residues do not match a force field, with a remedy."""

import re
from collections import Counter, defaultdict
from textwrap import shorten

from openmm.app import element

from ..naming import describeResidue
from ..notes import Note, listFirst
from ..residues import aminoAcid, isNucleotide, isPolymer, nucleotide
from ..selection import selectAtoms
from ..templates import atomAliases, standardName

_ADD_ATOMS = "--prepare adds them"
_ADD_HYDROGENS = "--add-hydrogens adds them"
_CANNOT_ADD_HYDROGENS = "--add-hydrogens knows no more of them: are names or bonds of atoms unusual?"
_ADD_RESIDUES = "--prepare adds ends and short gaps"
_LEAVE_OUT = 'name another file that has them, or leave them out (--leave-out "{}")'
_LEAVE_ATOMS = "name another file that has these, or leave atoms out (--leave-out)"
_REPLACE = "name another file that has them, or let --prepare replace them"
_OTHER_FILE = "name another file that has them, or leave out what they bind (--leave-out)"
_CORRECT_BONDS = "correct the bonds in the file (CONECT, SSBOND, _struct_conn)"
_OTHER_HYDROGENS = '--leave-out "element H" --add-hydrogens puts others in their place'

_CANNOT_PREPARE = "--prepare knows no more of them: are names or bonds of atoms unusual?"

# Advice for users who have already followed the first advice.
_NEXT_ADVICE = {_ADD_HYDROGENS: _CANNOT_ADD_HYDROGENS}
_NEXT_ADVICE_WITHOUT_HYDROGENS = {**_NEXT_ADVICE, _OTHER_HYDROGENS: _REPLACE}
_NEXT_ADVICE_PREPARED = {
    _ADD_ATOMS: _CANNOT_PREPARE,
    _ADD_HYDROGENS: _CANNOT_PREPARE,
    _ADD_RESIDUES: _CANNOT_PREPARE,
    _REPLACE: _LEAVE_OUT,
}

# Largest number of residue names in a suggested selection; letters of OpenMM's message.
_LONGEST_SELECTION = 3
_LONGEST_SENTENCE = 300


def describeMisfits(forceField, files, topology, error, hydrogensWereAdded, someAreLeftOut=False, isPrepared=False):
    """Return one line on why a ForceField cannot make a System.

    Parameters
    ----------
    forceField : openmm.app.ForceField
    files : list of str
        its files, for the message
    topology : openmm.app.Topology
    error : Exception
        what createSystem raised
    hydrogensWereAdded : bool
        whether hydrogens were added as far as possible
    someAreLeftOut : bool
        whether the user chose atoms to omit
    isPrepared : bool
        whether --prepare has done what it can
    """
    name = f"--forcefield {' '.join(files)}"
    first = re.match(r"No template found for residue (\d+) ", str(error))
    if first is None:
        return f"{name}: {firstSentence(error)}"
    residues = forceField.getUnmatchedResidues(topology)
    if forceField._patches:  # the list ignores patches, so some of its residues may match
        residues = [residue for residue in residues if residue.index == int(first[1])]
    bonds = _bondsBetweenResidues(topology)
    unknown = {residue for residue in residues if not templatesOf(forceField, residue)}
    misfits = defaultdict(list)
    for residue in residues:
        what, remedy, detail = _whyMisfit(forceField, residue, bonds[residue])
        if remedy == _OTHER_FILE and any(other.residue in unknown for _, other in bonds[residue]):
            continue  # without the unknown residue it fits
        if isPrepared:
            remedy = _NEXT_ADVICE_PREPARED.get(remedy, remedy)
        elif hydrogensWereAdded:
            remedy = (_NEXT_ADVICE_WITHOUT_HYDROGENS if someAreLeftOut else _NEXT_ADVICE).get(remedy, remedy)
        misfits[what, remedy].append((residue, f" ({detail})" if detail else ""))
    parts = []
    for (what, remedy), found in misfits.items():
        items = [f"{describeResidue(residue)}{detail}" for residue, detail in found]
        if remedy == _LEAVE_OUT:
            remedy = remedy.format(_selection([residue for residue, _ in found], topology))
        parts.append(f"{Note(f'residues {what}', items)}: {remedy}")
    return f"{name}: {listFirst(parts, '; ') or firstSentence(error)}"


def _selection(residues, topology):
    """Return a selection of residues of a Topology: by name, of the rest beside polymers, or an example."""
    names = list(dict.fromkeys(residue.name for residue in residues))
    if len(names) > _LONGEST_SELECTION and not any(map(isPolymer, residues)):
        selection = (
            "not (protein or nucleic)"
            if any(isNucleotide(residue.name) for residue in topology.residues())
            else "not protein"
        )
        atoms = list(topology.atoms())
        try:
            chosen = {atoms[index].residue for index in selectAtoms(topology, selection)}
        except ValueError:  # MDTraj counts all of them among proteins
            chosen = set()
        if chosen.issuperset(residues) and not any(map(isPolymer, chosen)):
            return selection
    if len(names) > _LONGEST_SELECTION:
        names = names[:1]
    # The language takes a name that begins with a digit for a number unless it is in quotes.
    return " or ".join(f"resname {name}" if name.isidentifier() else f"resname '{name}'" for name in names)


def firstSentence(error):
    """Return the first sentence of OpenMM's message, to include in a line."""
    text = " ".join(str(error).split()) or type(error).__name__
    return shorten(text.split(".  ")[0].split(". ")[0].rstrip("."), _LONGEST_SENTENCE, placeholder=" …")


def _bondsBetweenResidues(topology):
    """Return a dictionary of each residue's bonds to others, as a list of (its atom, the other atom)."""
    bonds = defaultdict(list)
    for first, second in topology.bonds():
        if first.residue is not second.residue:
            bonds[first.residue].append((first, second))
            bonds[second.residue].append((second, first))
    return bonds


def _whyMisfit(forceField, residue, bonds):
    """Return what is wrong with a residue that no template fits, what to do, and details."""
    templates = templatesOf(forceField, residue)
    if not templates:
        return "that the force field does not have", _REPLACE if isPolymer(residue) else _LEAVE_OUT, ""
    misfit = min((_Misfit(residue, bonds, template) for template in templates), key=_Misfit.size)
    if misfit.missing:
        return "that lack heavy atoms", _ADD_ATOMS, listFirst(sorted(misfit.missing))
    if misfit.extra:
        return "with atoms that their names do not have", _LEAVE_ATOMS, listFirst(sorted(misfit.extra))
    if misfit.lackingHydrogens > 0 and forceField._patches:  # by which bonds may be others
        return "that lack hydrogens", _ADD_HYDROGENS, ""
    if misfit.missingBonds:
        atoms = listFirst(sorted(misfit.missingBonds))
        return "that lack their neighbour in the chain, or the atoms of an end", _ADD_RESIDUES, f"at {atoms}"
    if misfit.extraBonds:
        return "bound to what the force field does not bind", _OTHER_FILE, _describeBonds(bonds, misfit.extraBonds)
    if misfit.lackingHydrogens > 0 and _isBehindGap(residue, bonds):
        return "that lack their neighbour in the chain, or the atoms of an end", _ADD_RESIDUES, "at N"
    if misfit.lackingHydrogens > 0:
        return "that lack hydrogens", _ADD_HYDROGENS, ""
    if misfit.lackingHydrogens < 0:
        return "with hydrogens too many", _OTHER_HYDROGENS, ""
    repeated = {name for name, count in Counter(atom.name for atom, _ in bonds).items() if count > 1}
    return "whose bonds do not fit their names", _CORRECT_BONDS, _describeBonds(bonds, repeated)


def templatesOf(forceField, residue):
    """Return the templates of a ForceField that a residue's name suggests; for an ion those of its element."""
    if len(residue) == 1 and not isPolymer(residue):
        elements = [next(residue.atoms()).element]
        return [each for each in forceField._templates.values() if [atom.element for atom in each.atoms] == elements]
    return [template for name, template in forceField._templates.items() if _isOf(name, residue.name)]


class _Misfit:
    """How a residue differs from a template that its name suggests."""

    def __init__(self, residue, bonds, template):
        heavy, hydrogens = _atomNames(residue.atoms())
        aliases = atomAliases(standardName(residue.name))
        templateHeavy, templateHydrogens = _atomNames(template.atoms)
        heavy, templateHeavy = ({aliases.get(name, name) for name in names} for names in (heavy, templateHeavy))
        self.missing = templateHeavy - heavy
        self.extra = heavy - templateHeavy
        bound = {atom.name for atom, _ in bonds}
        templateBonds = {template.atoms[atom].name for atom in template.externalBonds}
        self.missingBonds = templateBonds - bound
        self.extraBonds = bound - templateBonds
        self.lackingHydrogens = len(templateHydrogens) - len(hydrogens)

    def size(self):
        """Return the size of the difference, as a tuple for sorting templates."""
        bonds = len(self.missingBonds) + len(self.extraBonds)
        return len(self.missing) + len(self.extra), bonds, abs(self.lackingHydrogens)


def _isOf(templateName, residueName):
    """Whether template and residue match by name, such as CALA and ALA, or DC5 and C (its name in old files)."""
    if templateName == residueName:
        return True
    amino = aminoAcid(residueName)
    if amino is not None:
        return aminoAcid(templateName) == amino
    base = nucleotide(residueName)
    return base is not None and (nucleotide(templateName) or "").removeprefix("D") == base.removeprefix("D")


def _atomNames(atoms):
    """Return the names of heavy atoms and of hydrogens, as two sets."""
    heavy, hydrogens = set(), set()
    for atom in atoms:
        if atom.element is not None:
            (hydrogens if atom.element is element.hydrogen else heavy).add(atom.name)
    return heavy, hydrogens


def _isBehindGap(residue, bonds):
    """Whether an amino acid is not the first of its chain and has an unbonded N."""
    isFirst = residue is next(residue.chain.residues())
    return aminoAcid(residue.name) is not None and not isFirst and all(atom.name != "N" for atom, _ in bonds)


def _describeBonds(bonds, names):
    return listFirst(
        f"{atom.name} – {describeResidue(other.residue)} {other.name}" for atom, other in bonds if atom.name in names
    )
