"""Amino acids, nucleotides and water by the names of residues and atoms.

Names follow the Protein Data Bank, as `openmm.app.PDBFile` gives them.
"""

from functools import cache

from .datatables import readNames

# Names that force fields and programs give to protonation states and to cysteines in disulfides.
_VARIANTS = {
    "HID": "HIS", "HIE": "HIS", "HIP": "HIS", "HSD": "HIS", "HSE": "HIS", "HSP": "HIS",
    "HISA": "HIS", "HISB": "HIS", "HISD": "HIS", "HISE": "HIS", "HISH": "HIS", "HISP": "HIS",
    "CYX": "CYS", "CYM": "CYS", "CYS2": "CYS", "CYSH": "CYS",
    "ASH": "ASP", "ASPH": "ASP", "ASPP": "ASP", "GLH": "GLU", "GLUH": "GLU", "GLUP": "GLU",
    "LYN": "LYS", "LYSH": "LYS", "LYSN": "LYS", "LSN": "LYS", "ARGN": "ARG",
}  # fmt: skip

# Names of D-amino acids in the Protein Data Bank.
_MIRRORED = {
    "DAL": "ALA", "DAR": "ARG", "DSG": "ASN", "DAS": "ASP", "DCY": "CYS", "DGN": "GLN", "DGL": "GLU", "DHI": "HIS",
    "DIL": "ILE", "DLE": "LEU", "DLY": "LYS", "MED": "MET", "DPN": "PHE", "DPR": "PRO", "DSN": "SER", "DTH": "THR",
    "DTR": "TRP", "DTY": "TYR", "DVA": "VAL",
}  # fmt: skip

# The side chain from CB on: chi_n is the dihedral of four consecutive names after N, CA (IUPAC-IUB 1970, rule 4.4).
# A bar separates alternative names, the preferred one first.
_SIDE_CHAINS = {
    "ALA": "", "GLY": "", "PRO": "",
    "ARG": "CB CG CD NE CZ",
    "ASN": "CB CG OD1", "ASP": "CB CG OD1",
    "CYS": "CB SG",
    "GLN": "CB CG CD OE1", "GLU": "CB CG CD OE1",
    "HIS": "CB CG ND1",
    "ILE": "CB CG1 CD1|CD", "LEU": "CB CG CD1",
    "LYS": "CB CG CD CE NZ",
    "MET": "CB CG SD CE", "MSE": "CB CG SE CE",
    "PHE": "CB CG CD1", "TYR": "CB CG CD1", "TRP": "CB CG CD1",
    "SER": "CB OG", "THR": "CB OG1",
    "VAL": "CB CG1",
}  # fmt: skip

_PURINES = {"A", "G", "I", "DA", "DG", "DI"}
_PYRIMIDINES = {"C", "U", "DC", "DT", "DU"}

# Names of nucleotides in old files and in programs: CHARMM's do not name the sugar, and Amber's mark ends.
_NUCLEOTIDES = {"ADE": "A", "GUA": "G", "CYT": "C", "URA": "U", "THY": "DT", "T": "DT"} | {
    f"{sugar}{base}{end}": f"{sugar.strip('R')}{base}"
    for sugar, bases, ends in (("D", "ACGT", "35N"), ("R", "ACGU", "35N"), ("", "ACGU", "35"))
    for base in bases
    for end in ends
}

# sp2 carbons of amino acids and bases: without a hydrogen, and with one.
_BARE_SP2_CARBONS = {
    "ASN": "CG", "ASP": "CG", "GLN": "CD", "GLU": "CD", "ARG": "CZ", "HIS": "CG", "PHE": "CG", "TYR": "CG CZ",
    "TRP": "CG CD2 CE2",
    "A": "C4 C5 C6", "G": "C2 C4 C5 C6", "I": "C4 C5 C6", "C": "C2 C4", "U": "C2 C4", "T": "C2 C4 C5",
}  # fmt: skip
_SP2_CARBONS_WITH_HYDROGEN = {
    "HIS": "CD2 CE1", "PHE": "CD1 CD2 CE1 CE2 CZ", "TYR": "CD1 CD2 CE1 CE2", "TRP": "CD1 CE3 CZ2 CZ3 CH2",
    "A": "C2 C8", "G": "C8", "I": "C2 C8", "C": "C5 C6", "U": "C5 C6", "T": "C6",
}  # fmt: skip

# The backbone of a residue, each atom bonded to the next.
PEPTIDE_BACKBONE = ("N", "CA", "C")
NUCLEOTIDE_BACKBONE = ("O5'", "C5'", "C4'", "C3'", "O3'")

CAPS = {"ACE", "NME", "NMA", "NHE", "NH2"}


def aminoAcid(name):
    """Return the amino acid of a residue name, such as HIS for HIE, CYS for NCYX, ALA for DAL; None for other residues.

    Amber prefixes N or C to the names of terminal residues, CHARMM D to those of mirror images.
    """
    name = _VARIANTS.get(name) or _MIRRORED.get(name, name)
    if name in _SIDE_CHAINS:
        return name
    if len(name) == 4 and name[0] in ("D" if name[1:] in _SIDE_CHAINS else "") + "NC":
        return aminoAcid(name[1:])
    return None


def isMirrored(name):
    """Whether this residue name means a D-amino acid."""
    return name in _MIRRORED or (len(name) == 4 and name[0] == "D" and name[1:] in _SIDE_CHAINS)


def isCalledWater(name):
    """Whether this residue name means water."""
    return name in _waters()


def isWater(residue):
    """Whether a residue of a Topology is water: by its name and by its atoms, since other residues have such names."""
    if residue.name == "HOH":
        return True
    return isCalledWater(residue.name) and isWaterOf(
        "" if atom.element is None else atom.element.symbol for atom in residue.atoms()
    )


def isWaterOf(elements):
    """Whether a molecule of these elements can be water; atoms without an element have an empty symbol or X."""
    heavy = [element for element in elements if element not in ("H", "D", "X", "")]
    return heavy in ([], ["O"], ["O", "O"])  # CHARMM has a virtual site that is called OM


@cache
def _waters():
    return {residue for residue, _ in readNames("water")}


def isAlphaCarbonOnly(residue):
    """Whether a residue of a Topology is an amino acid with a Cα atom alone."""
    return aminoAcid(residue.name) is not None and [atom.name for atom in residue.atoms()] == ["CA"]


def polymerBackbone(residue):
    """Return the indices of the backbone atoms of an amino acid or nucleotide of a Topology; [] for other residues."""
    atoms = {atom.name: atom.index for atom in residue.atoms()}
    for names in (PEPTIDE_BACKBONE, NUCLEOTIDE_BACKBONE):
        if all(name in atoms for name in names):
            return [atoms[name] for name in names]
    return []


def isPolymer(residue):
    """Whether a residue of a Topology belongs to a protein or nucleic acid, by its name or its backbone."""
    return aminoAcid(residue.name) is not None or isNucleotide(residue.name) or bool(polymerBackbone(residue))


def isNucleotide(name):
    """Whether this residue name means a nucleotide of DNA or RNA."""
    return nucleotide(name) is not None


def nucleotide(name):
    """Return the nucleotide of a residue name, such as DA for DA5 and DT for THY; None for other residues."""
    name = _NUCLEOTIDES.get(name, name)
    return name if name in _PURINES or name in _PYRIMIDINES else None


def isPolymerName(name):
    """Whether this residue name means an amino acid, a nucleotide or a cap."""
    return aminoAcid(name) is not None or isNucleotide(name) or name in CAPS


def chiAtoms(name):
    """Return the atom names of chi1, chi2, … of an amino acid (as `aminoAcid` names it).

    Each is four tuples of alternative names.
    """
    line = [("N",), ("CA",)] + [tuple(names.split("|")) for names in _SIDE_CHAINS[name].split()]
    return [tuple(line[i : i + 4]) for i in range(len(line) - 3)]


def glycosidicAtoms(name):
    """Return the atom names of chi of a nucleotide: O4'-C1'-N9-C4 in purines, O4'-C1'-N1-C2 in pyrimidines."""
    return ("O4'", "C1'", "N9", "C4") if nucleotide(name) in _PURINES else ("O4'", "C1'", "N1", "C2")


def isSp2Carbon(residueName, atomName, withHydrogen):
    """Whether a carbon of an amino acid or nucleotide is sp2 and bears a hydrogen or, without withHydrogen, none."""
    amino = aminoAcid(residueName)
    if amino is not None and atomName == "C":
        return not withHydrogen
    base = (nucleotide(residueName) or "").removeprefix("D") or amino
    table = _SP2_CARBONS_WITH_HYDROGEN if withHydrogen else _BARE_SP2_CARBONS
    return atomName in table.get(base, "").split()
