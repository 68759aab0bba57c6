"""Files that define a System: those of AMBER, GROMACS and CHARMM, and serialized Systems. OpenMM reads them.

Each class opens one kind of file, given the periodic box (three vectors in nm) or None. It has `topology`, unless the
file is a serialized System, and `createSystem(arguments)`. It raises whatever OpenMM raises.
"""

import os

import openmm
from openmm import app, unit

from ..errors import InputError
from ..images import vectorsOf
from ..residues import isPolymer
from ..structures.filekinds import rootOfXML

IMPLICIT_SOLVENTS = ("HCT", "OBC1", "OBC2", "GBn", "GBn2")

_BEGINNING = 4096  # bytes that show the kind of a file


class _SystemFile:
    kind = ""
    options: tuple[str, ...] = ()
    isSerialized = False


class _AmberFile(_SystemFile):
    kind = "an AMBER prmtop"
    options = ("implicit",)

    def __init__(self, path, box, options):
        self._file = app.AmberPrmtopFile(path, periodicBoxVectors=box)
        self.topology = _withChains(self._file.topology)
        self._implicit = options.implicit

    def createSystem(self, arguments):
        return self._file.createSystem(**arguments, implicitSolvent=_asSolvent(self._implicit))


class _GromacsFile(_SystemFile):
    kind = "a GROMACS top"
    options = ("include",)

    def __init__(self, path, box, options):
        self._file = app.GromacsTopFile(path, periodicBoxVectors=box, includeDir=options.include)
        self.topology = self._file.topology

    def createSystem(self, arguments):
        return self._file.createSystem(**arguments)


class _CharmmFile(_SystemFile):
    kind = "a CHARMM PSF"
    options = ("parameters", "implicit")

    def __init__(self, path, box, options):
        if options.parameters is None:
            raise InputError(f"--system {path}: needs --parameters, CHARMM's files of topology and parameters")
        self._file = app.CharmmPsfFile(path, periodicBoxVectors=box)
        self._parameters = app.CharmmParameterSet(*options.parameters)
        self.topology = self._file.topology
        self._implicit = options.implicit

    def createSystem(self, arguments):
        return self._file.createSystem(self._parameters, **arguments, implicitSolvent=_asSolvent(self._implicit))


class _SerializedFile(_SystemFile):
    kind = "a serialized System"
    isSerialized = True

    def __init__(self, path, box, options):
        with open(path, encoding="utf-8") as file:
            self.system = openmm.XmlSerializer.deserialize(file.read())

    def createSystem(self, arguments):
        return openmm.XmlSerializer.clone(self.system)


def kindOf(path):
    """Return the class of this module that reads a file, by its first bytes.

    Raises
    ------
    InputError
        if it cannot be read, or is of no such kind
    """
    try:
        with open(path, "rb") as file:
            start = file.read(_BEGINNING).removeprefix(b"\xef\xbb\xbf").lstrip()
        if start.startswith(b"<"):
            return _kindOfXML(path)
    except OSError as error:
        raise InputError(f"--system {path}: {error.strerror}") from error
    if start.startswith((b"%VERSION", b"%FLAG")):
        return _AmberFile
    if start.startswith(b"PSF"):
        return _CharmmFile
    if b"\0" not in start and (b"[" in start or b"#include" in start):
        return _GromacsFile
    raise InputError(
        f"--system {path}: is {'empty' if not start else 'not a file of a System'}; it takes AMBER prmtop, GROMACS "
        "top, CHARMM PSF, and XML of a System"
    )


def _kindOfXML(path):
    root = rootOfXML(path)
    if root == "System":
        return _SerializedFile
    if root == "ForceField":
        raise InputError(f"--system {path}: is a file of a ForceField, which --forcefield reads")
    what = "is not XML that can be read" if root is None else f"has a {root}, not a System"
    raise InputError(f"--system {path}: {what}")


def checkFiles(names):
    """Raise an InputError that names the first file that is not there."""
    for name in names:
        if not os.path.isfile(name):
            raise InputError(f"--parameters {name}: {'is not a file' if os.path.exists(name) else 'No such file'}")


def _withChains(topology):
    """Return a copy of the Topology of a prmtop, which has no chains: another begins where no bond joins polymers."""
    joined = {(bond[0].residue.index, bond[1].residue.index) for bond in topology.bonds()}
    copy = app.Topology()
    copy.setPeriodicBoxVectors(topology.getPeriodicBoxVectors())
    copies, last = {}, None
    for residue in topology.residues():
        areBoth = last is not None and isPolymer(residue) == isPolymer(last)
        if not areBoth or (isPolymer(residue) and (last.index, residue.index) not in joined):
            chain = copy.addChain()
        newResidue = copy.addResidue(residue.name, chain, residue.id, residue.insertionCode)
        copies |= {atom: copy.addAtom(atom.name, atom.element, newResidue, atom.id) for atom in residue.atoms()}
        last = residue
    for first, second in topology.bonds():
        copy.addBond(copies[first], copies[second])
    return copy


def _asSolvent(name):
    return None if name is None else getattr(app, name)


def asVectors(box):
    """Return a box, a (3, 3) array in nm or None, as OpenMM's readers take it."""
    return None if box is None else unit.Quantity(vectorsOf(box), unit.nanometer)
