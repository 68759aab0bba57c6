"""Making and reading what tests work on."""

import os
from pathlib import Path

import numpy as np
import openmm
import pytest
from openmm import app, unit


def realStructurePath(name):
    folder = os.environ.get("CHAINTREE_TEST_DATA")
    if not folder:
        pytest.skip("CHAINTREE_TEST_DATA is not set")
    return Path(folder) / name


def makeContext(structure, force, integrator):
    context = openmm.Context(makeSystem(structure, force), integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(structure.positions)
    return context


def makeSystem(structure, *forces):
    system = openmm.System()
    for atom in structure.topology.atoms():
        system.addParticle(atom.element.mass)
    for force in forces:
        system.addForce(force)
    return system


def positionsOf(context):
    return context.getState(positions=True).getPositions(asNumpy=True).value_in_unit(unit.nanometer)


def peptide(*residueNames, chains=1):
    """Make the Topology of a peptide from its residue names, without hydrogens and positions."""
    topology = app.Topology()
    for _ in range(chains):
        chain = topology.addChain()
        for name in residueNames:
            residue = topology.addResidue(name, chain)
            for atom in HEAVY_ATOMS[name].split():
                topology.addAtom(atom, app.Element.getBySymbol(atom[0]), residue)
    topology.createStandardBonds()
    return topology


_BACKBONE = "N CA C O "
HEAVY_ATOMS = {
    name: _BACKBONE + sideChain
    for name, sideChain in {
        "ALA": "CB",
        "ARG": "CB CG CD NE CZ NH1 NH2",
        "ASN": "CB CG OD1 ND2",
        "ASP": "CB CG OD1 OD2",
        "CYS": "CB SG",
        "GLN": "CB CG CD OE1 NE2",
        "GLU": "CB CG CD OE1 OE2",
        "GLY": "",
        "HIS": "CB CG ND1 CD2 CE1 NE2",
        "ILE": "CB CG1 CG2 CD1",
        "LEU": "CB CG CD1 CD2",
        "LYS": "CB CG CD CE NZ",
        "MET": "CB CG SD CE",
        "PHE": "CB CG CD1 CD2 CE1 CE2 CZ",
        "PRO": "CB CG CD",
        "SER": "CB OG",
        "THR": "CB OG1 CG2",
        "TRP": "CB CG CD1 CD2 NE1 CE2 CE3 CZ2 CZ3 CH2",
        "TYR": "CB CG CD1 CD2 CE1 CE2 CZ OH",
        "VAL": "CB CG1 CG2",
    }.items()
}


def readDCD(path):
    """Read the frames of a DCD file without a box, float32, nm; a frame that the header does not count is an error."""
    data = Path(path).read_bytes()
    count = int(np.frombuffer(data, "<i4", 1, 8)[0])
    atoms = int(np.frombuffer(data, "<i4", 1, 268)[0])
    record = 4 * atoms + 8
    assert len(data) == 276 + count * 3 * record
    frames = np.frombuffer(data, np.uint8, offset=276).reshape(count, 3, record)
    values = np.ascontiguousarray(frames[:, :, 4:-4]).view("<f4")
    return values.transpose(0, 2, 1) / 10


def writePDB(path, lines):
    path.write_text("\n".join([*lines, "END", ""]))
    return path


GLYCINES = [
    "ATOM      1  N   GLY A   1       0.000   0.000   0.000  1.00  0.00           N",
    "ATOM      2  CA  GLY A   1       1.450   0.000   0.000  1.00  0.00           C",
    "ATOM      3  C   GLY A   1       1.950   1.420   0.000  1.00  0.00           C",
    "ATOM      4  O   GLY A   1       1.200   2.380   0.000  1.00  0.00           O",
    "ATOM      5  N   GLY A   2       3.270   1.560   0.000  1.00  0.00           N",
    "ATOM      6  CA  GLY A   2       3.900   2.870   0.000  1.00  0.00           C",
    "ATOM      7  C   GLY A   2       5.410   2.750   0.000  1.00  0.00           C",
    "ATOM      8  O   GLY A   2       6.000   1.670   0.000  1.00  0.00           O",
]


def writeDCD(path, topology, frames):
    """Write positions (nm) as path with .dcd, and return that."""
    path = path.with_suffix(".dcd")
    with open(path, "wb") as file:
        trajectory = app.DCDFile(file, topology, 1 * unit.picosecond)
        for positions in frames:
            trajectory.writeModel(positions * unit.nanometer)
    return path


def writeLongTrajectory(folder, structure):
    """Write a structure, and a trajectory that shows it in 50,001 frames; return the names of the two files."""
    with open(folder / "long.pdb", "w") as file:
        app.PDBFile.writeFile(structure.topology, structure.positions * unit.nanometer, file)
    trajectory = writeDCD(folder / "long", structure.topology, [structure.positions])
    data = bytearray(trajectory.read_bytes())
    frame = data[276:]
    data[8:12] = np.int32(50001).tobytes()
    with open(trajectory, "wb") as file:
        file.write(data)
        for _ in range(50):
            file.write(frame * 1000)
    return "long.pdb", trajectory.name


def writeXTC(path, topology, frames):
    """Write positions (nm) as path with .xtc, and return that."""
    path = path.with_suffix(".xtc")
    trajectory = app.XTCFile(str(path), topology, 1 * unit.picosecond)
    for positions in frames:
        trajectory.writeModel(positions * unit.nanometer)
    return path


def pdbLine(serial, name, residue, chain, number, x, y, z, *, record="ATOM", altloc="", occupancy=1.0, element=None):
    """Return a line of a PDB file; the position is in Å. The element is the first letter of the name if not given."""
    element = name.strip("0123456789")[0] if element is None else element
    column = f"{name:<4}" if len(name) == 4 or len(element) == 2 else f" {name:<3}"
    return (
        f"{record:<6}{serial:>5} {column}{altloc:1}{residue:>3} {chain:1}{number:>4}    "
        f"{x:8.3f}{y:8.3f}{z:8.3f}{occupancy:6.2f}{0.0:6.2f}          {element:>2}"
    )


def bondNames(topology):
    """Return the bonds of a Topology as sorted pairs of "residue number, atom"."""
    names = [sorted(f"{atom.residue.id} {atom.name}" for atom in bond) for bond in topology.bonds()]
    return sorted(map(tuple, names))


# ACE-ALA-NME with all hydrogens, extended.
DIPEPTIDE = [
    pdbLine(serial, name, residue, "A", number, *position)
    for serial, (residue, number, name, *position) in enumerate(
        [
            ("ACE", 1, "HH31", 0.000, 0.000, 0.000),
            ("ACE", 1, "CH3", 1.090, 0.000, 0.000),
            ("ACE", 1, "HH32", 1.454, 1.027, 0.000),
            ("ACE", 1, "HH33", 1.454, -0.514, 0.890),
            ("ACE", 1, "C", 1.598, -0.717, -1.242),
            ("ACE", 1, "O", 0.806, -1.187, -2.057),
            ("ALA", 2, "N", 2.923, -0.800, -1.385),
            ("ALA", 2, "H", 3.529, -0.396, -0.686),
            ("ALA", 2, "CA", 3.531, -1.458, -2.525),
            ("ALA", 2, "HA", 3.024, -1.146, -3.438),
            ("ALA", 2, "CB", 5.006, -1.078, -2.611),
            ("ALA", 2, "HB1", 5.516, -1.390, -1.699),
            ("ALA", 2, "HB2", 5.460, -1.574, -3.469),
            ("ALA", 2, "HB3", 5.098, 0.002, -2.726),
            ("ALA", 2, "C", 3.414, -2.968, -2.380),
            ("ALA", 2, "O", 3.396, -3.487, -1.266),
            ("NME", 3, "N", 3.336, -3.673, -3.511),
            ("NME", 3, "H", 3.356, -3.196, -4.401),
            ("NME", 3, "CH3", 3.222, -5.117, -3.507),
            ("NME", 3, "HH31", 2.317, -5.409, -2.975),
            ("NME", 3, "HH32", 3.172, -5.481, -4.533),
            ("NME", 3, "HH33", 4.090, -5.549, -3.010),
        ],
        start=1,
    )
]


def writeSmallStructures(folder):
    """Write run.pdb, two glycines, and dipeptide.pdb to a folder."""
    writePDB(folder / "run.pdb", GLYCINES)
    writePDB(folder / "dipeptide.pdb", DIPEPTIDE)
