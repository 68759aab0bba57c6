"""Names of residues and atoms in messages and tables."""

from typing import NamedTuple


class AtomName(NamedTuple):
    """The name of an atom.

    chain : str, empty if the chain has no name; residue : str, its name and number with insertion code; atom : str
    """

    chain: str
    residue: str
    atom: str

    def __str__(self) -> str:
        return f"{self.describeResidue()} {self.atom}"

    def describeResidue(self) -> str:
        """Return the name of the residue: chain, name, number with insertion code."""
        return joinNames(self.chain, self.residue)


def nameAtom(atom):
    """Return the AtomName of an atom of a Topology."""
    return AtomName(*_chainAndResidue(atom.residue), atom.name)


def describeResidue(residue):
    """Return the name of a residue of a Topology: chain, name, number with insertion code."""
    return joinNames(*_chainAndResidue(residue))


def describeAtom(atom):
    """Return an atom of a Topology in words: its name, then its residue."""
    return f"{atom.name} of {describeResidue(atom.residue)}"


def _chainAndResidue(residue):
    return residue.chain.id.strip(), f"{residue.name} {residue.id}{residue.insertionCode.strip()}"


def joinNames(chain, residue):
    """Return the names of a chain, which may be empty, and a residue as one name."""
    return f"{chain}:{residue}" if chain else residue
