"""Files of AMBER, GROMACS and CHARMM, written from a System of OpenMM that has bonds, angles, torsions and charges; SDF
and Mol2.

Each atom has its own type, so that types have any parameters.
"""

import math
from itertools import combinations_with_replacement

import numpy as np
import openmm
from openmm import unit

_KCAL = 4.184
_FUDGE_LJ, _FUDGE_QQ = 2.0, 1.2  # the divisors of 1-4 pairs in AMBER


class Terms:
    """The terms of a System as numbers in nm, rad, kJ/mol, e and Da."""

    def __init__(self, topology, system):
        self.atoms = list(topology.atoms())
        self.residues = list(topology.residues())
        count = system.getNumParticles()
        self.masses = [system.getParticleMass(i).value_in_unit(unit.dalton) for i in range(count)]
        byKind = {type(force): force for force in system.getForces()}
        bonds, angles, torsions, pairs = (
            byKind[kind]
            for kind in (
                *(openmm.HarmonicBondForce, openmm.HarmonicAngleForce),
                *(openmm.PeriodicTorsionForce, openmm.NonbondedForce),
            )
        )
        self.bonds = [_plain(bonds.getBondParameters(i)) for i in range(bonds.getNumBonds())]
        self.angles = [_plain(angles.getAngleParameters(i)) for i in range(angles.getNumAngles())]
        self.torsions = [_plain(torsions.getTorsionParameters(i)) for i in range(torsions.getNumTorsions())]
        self.particles = [_plain(pairs.getParticleParameters(i)) for i in range(count)]
        exceptions = [_plain(pairs.getExceptionParameters(i)) for i in range(pairs.getNumExceptions())]
        self.excluded = {tuple(sorted(one[:2])) for one in exceptions}
        self.pairs14 = {tuple(sorted(one[:2])) for one in exceptions if one[2] != 0 or one[4] != 0}
        self._addTorsionsOfPairs()

    def _addTorsionsOfPairs(self):
        """Give pairs three bonds apart without a torsion one without energy: prmtop lists such pairs by torsions."""
        neighbors = {i: set() for i in range(len(self.atoms))}
        for i, j, *_ in self.bonds:
            neighbors[i].add(j)
            neighbors[j].add(i)
        for i, m in sorted(self.pairs14 - {tuple(sorted((term[0], term[3]))) for term in self.torsions}):
            j, k = next((j, k) for j in neighbors[i] for k in neighbors[j] if m in neighbors[k])
            self.torsions.append([i, j, k, m, 1, 0.0, 0.0])


def _plain(values):
    return [value.value_in_unit_system(unit.md_unit_system) if unit.is_quantity(value) else value for value in values]


def writePrmtop(path, terms):
    """Write an AMBER prmtop."""
    n, isHydrogen = len(terms.atoms), [atom.element.atomic_number == 1 for atom in terms.atoms]
    index = {pair: number + 1 for number, pair in enumerate(combinations_with_replacement(range(n), 2))}
    a, b = [], []
    for first, second in index:
        sigma = (terms.particles[first][1] + terms.particles[second][1]) / 2 * 10
        epsilon = math.sqrt(terms.particles[first][2] * terms.particles[second][2]) / _KCAL
        a.append(4 * epsilon * sigma**12)
        b.append(4 * epsilon * sigma**6)
    lists = {"BONDS": ([], []), "ANGLES": ([], []), "DIHEDRALS": ([], [])}

    def add(name, particles, number, *signs):
        signs = signs or (1,) * len(particles)
        row = [3 * sign * particle for particle, sign in zip(particles, signs, strict=True)]
        lists[name][0 if any(isHydrogen[particle] for particle in particles) else 1].append([*row, number + 1])

    for number, (*particles, _, _) in enumerate(terms.bonds):
        add("BONDS", particles, number)
    for number, (*particles, _, _) in enumerate(terms.angles):
        add("ANGLES", particles, number)
    left = set(terms.pairs14)
    for number, (i, j, k, m, *_) in enumerate(terms.torsions):
        particles = (m, k, j, i) if 0 in (k, m) else (i, j, k, m)
        pair = min(i, m), max(i, m)
        add("DIHEDRALS", particles, number, 1, 1, 1 if pair in left else -1, 1)
        left.discard(pair)
    assert not left
    excluded = [[other for other in range(i + 1, n) if (i, other) in terms.excluded] for i in range(n)]
    starts = [residue_start + 1 for residue_start in (next(one.atoms()).index for one in terms.residues)]
    longest = max(len(residue) for residue in terms.residues)
    pointers = [n, n, *(len(rows) for pair in lists.values() for rows in pair), 0, 0]
    pointers += [sum(max(1, len(one)) for one in excluded), len(terms.residues)]
    pointers += [len(pair[1]) for pair in lists.values()]
    pointers += [len(terms.bonds), len(terms.angles), len(terms.torsions), n, *([0] * 9), longest, 0, 0]
    flags = {
        "TITLE": ("20a4", ["peptide"]),
        "POINTERS": ("10I8", pointers),
        "ATOM_NAME": ("20a4", [atom.name for atom in terms.atoms]),
        "CHARGE": ("5E16.8", [18.2223 * charge for charge, _, _ in terms.particles]),
        "ATOMIC_NUMBER": ("10I8", [atom.element.atomic_number for atom in terms.atoms]),
        "MASS": ("5E16.8", terms.masses),
        "ATOM_TYPE_INDEX": ("10I8", range(1, n + 1)),
        "NUMBER_EXCLUDED_ATOMS": ("10I8", [max(1, len(one)) for one in excluded]),
        "NONBONDED_PARM_INDEX": ("10I8", [index[min(i, j), max(i, j)] for i in range(n) for j in range(n)]),
        "RESIDUE_LABEL": ("20a4", [residue.name for residue in terms.residues]),
        "RESIDUE_POINTER": ("10I8", starts),
        "BOND_FORCE_CONSTANT": ("5E16.8", [k / 2 / _KCAL / 100 for *_, k in terms.bonds]),
        "BOND_EQUIL_VALUE": ("5E16.8", [10 * length for *_, length, _ in terms.bonds]),
        "ANGLE_FORCE_CONSTANT": ("5E16.8", [k / 2 / _KCAL for *_, k in terms.angles]),
        "ANGLE_EQUIL_VALUE": ("5E16.8", [angle for *_, angle, _ in terms.angles]),
        "DIHEDRAL_FORCE_CONSTANT": ("5E16.8", [k / _KCAL for *_, k in terms.torsions]),
        "DIHEDRAL_PERIODICITY": ("5E16.8", [term[4] for term in terms.torsions]),
        "DIHEDRAL_PHASE": ("5E16.8", [term[5] for term in terms.torsions]),
        "SCEE_SCALE_FACTOR": ("5E16.8", [_FUDGE_QQ] * len(terms.torsions)),
        "SCNB_SCALE_FACTOR": ("5E16.8", [_FUDGE_LJ] * len(terms.torsions)),
        "LENNARD_JONES_ACOEF": ("5E16.8", a),
        "LENNARD_JONES_BCOEF": ("5E16.8", b),
        **{
            f"{name}_{ending}": ("10I8", sum(rows, []))
            for name, pair in lists.items()
            for ending, rows in zip(("INC_HYDROGEN", "WITHOUT_HYDROGEN"), pair, strict=True)
        },
        "HBOND_ACOEF": ("5E16.8", []),
        "HBOND_BCOEF": ("5E16.8", []),
        "EXCLUDED_ATOMS_LIST": ("10I8", [other + 1 for one in excluded for other in (one or [-1])]),
        "AMBER_ATOM_TYPE": ("20a4", [atom.name[:1] for atom in terms.atoms]),
        "RADII": ("5E16.8", [1.3 if light else 1.7 for light in isHydrogen]),
        "SCREEN": ("5E16.8", [0.85 if light else 0.72 for light in isHydrogen]),
    }
    with open(path, "w") as file:
        file.write("%VERSION  VERSION_STAMP = V0001.000  DATE = 01/01/01  00:00:00\n")
        for name, (form, values) in flags.items():
            file.write(f"%FLAG {name}\n%FORMAT({form})\n")
            texts = [_format(form, value) for value in values]
            width = int(form[: form.index(next(filter(str.isalpha, form)))])
            for start in range(0, max(1, len(texts)), width):
                file.write("".join(texts[start : start + width]) + "\n")
    return path


def _format(form, value):
    return {"20a4": lambda: f"{value:<4}", "10I8": lambda: f"{value:8d}", "5E16.8": lambda: f"{value:16.8E}"}[form]()


def writeInpcrd(path, positions, box=None):
    """Write positions (nm), and the lengths of a rectangular box, as AMBER's inpcrd."""
    numbers = [*(10 * np.asarray(positions)).ravel().tolist()]
    rows = [numbers[start : start + 6] for start in range(0, len(numbers), 6)]
    if box is not None:
        rows.append([*(10 * length for length in box), 90, 90, 90])
    text = "".join("".join(f"{value:12.7f}" for value in row) + "\n" for row in rows)
    path.write_text(f"peptide\n{len(numbers) // 3:5d}\n{text}")
    return path


def writeTop(path, terms, include=None):
    """Write a GROMACS top; with include, its atom types go to that file."""
    types = "[ atomtypes ]\n" + "".join(
        f"T{i} {mass} {charge} A {sigma:.12g} {epsilon:.12g}\n"
        for i, (mass, (charge, sigma, epsilon)) in enumerate(zip(terms.masses, terms.particles, strict=True))
    )
    if include is not None:
        include.write_text(types)
        types = f'#include "{include.name}"\n'
    atoms = "".join(
        f"{i + 1} T{i} {int(atom.residue.id)} {atom.residue.name} {atom.name} {i + 1} {charge} {mass}\n"
        for i, (atom, (charge, *_), mass) in enumerate(zip(terms.atoms, terms.particles, terms.masses, strict=True))
    )
    sections = {
        "bonds": [[i + 1, j + 1, 1, length, k] for i, j, length, k in terms.bonds],
        "pairs": [[i + 1, j + 1, 1] for i, j in sorted(terms.pairs14)],
        "angles": [[i + 1, j + 1, k + 1, 1, math.degrees(angle), c] for i, j, k, angle, c in terms.angles],
        "dihedrals": [
            [*(p + 1 for p in term[:4]), 9, math.degrees(term[5]), term[6], term[4]] for term in terms.torsions
        ],
    }
    body = "".join(
        f"[ {name} ]\n" + "".join(" ".join(f"{value:.12g}" for value in row) + "\n" for row in rows)
        for name, rows in sections.items()
    )
    path.write_text(
        f"[ defaults ]\n1 2 yes {1 / _FUDGE_LJ} {1 / _FUDGE_QQ}\n{types}[ moleculetype ]\npeptide 3\n[ atoms ]\n{atoms}"
        f"{body}[ system ]\npeptide\n[ molecules ]\npeptide 1\n"
    )
    return path


def writeGro(path, atoms, positions, box=(0, 0, 0), decimals=3):
    """Write atoms of a Topology as a gro file, with columns for any number of decimals."""
    lines = [
        f"{int(atom.residue.id) % 100000:5d}{atom.residue.name:<5}{atom.name:>5}{(i + 1) % 100000:5d}"
        + "".join(f"{value:{decimals + 5}.{decimals}f}" for value in position)
        for i, (atom, position) in enumerate(zip(atoms, np.asarray(positions).tolist(), strict=True))
    ]
    path.write_text("\n".join(["peptide", f"{len(lines):5d}", *lines, " ".join(f"{value:.5f}" for value in box), ""]))
    return path


def writePsf(path, terms):
    """Write a CHARMM PSF."""
    lines = ["PSF", "", "       1 !NTITLE", " REMARKS peptide", "", f"{len(terms.atoms):8d} !NATOM"]
    for i, atom in enumerate(terms.atoms):
        residue = atom.residue
        lines.append(
            f"{i + 1:8d} {'PEP':<4} {residue.id:<4} {residue.name:<4} {atom.name:<4} {f'T{i}':<4} "
            f"{terms.particles[i][0]:10.6f} {terms.masses[i]:13.4f} {0:11d}"
        )
    dihedrals = list(dict.fromkeys(tuple(term[:4]) for term in terms.torsions))
    for name, rows, each in (
        ("NBOND: bonds", [term[:2] for term in terms.bonds], 4),
        ("NTHETA: angles", [term[:3] for term in terms.angles], 3),
        ("NPHI: dihedrals", dihedrals, 2),
        ("NIMPHI: impropers", [], 2),
        ("NDON: donors", [], 4),
        ("NACC: acceptors", [], 4),
        ("NNB", [], 4),
    ):
        lines += ["", f"{len(rows):8d} !{name}"]
        for start in range(0, len(rows), each):
            lines.append("".join(f"{particle + 1:8d}" for row in rows[start : start + each] for particle in row))
        lines += [] if rows else [""]
    lines += ["", f"{1:8d}{0:8d} !NGRP NST2", f"{0:8d}{1:8d}{0:8d}", ""]
    path.write_text("\n".join(lines) + "\n")
    return path


def writeParameters(rtf, prm, terms, nbfix=()):
    """Write CHARMM's files of masses and parameters for a PSF; nbfix: (i, j, sigma, epsilon) of single pairs."""
    types = range(len(terms.atoms))
    masses = [f"MASS {i + 1} T{i} {terms.masses[i]:.5f} {terms.atoms[i].element.symbol}" for i in types]
    rtf.write_text("\n".join(["* peptide", "*", "36 1", *masses, "END", ""]))

    def rmin(sigma):
        return 10 * sigma * 2 ** (1 / 6)

    lines = ["* peptide", "*", "", "BONDS"]
    lines += [f"T{i} T{j} {k / 2 / _KCAL / 100:.10g} {10 * length:.10g}" for i, j, length, k in terms.bonds]
    lines += ["", "ANGLES"]
    lines += [f"T{i} T{j} T{k} {c / 2 / _KCAL:.10g} {math.degrees(a):.10g}" for i, j, k, a, c in terms.angles]
    lines += ["", "DIHEDRALS"]
    for i, j, k, m, period, phase, c in terms.torsions:
        lines.append(f"T{i} T{j} T{k} T{m} {c / _KCAL:.10g} {period} {math.degrees(phase):.10g}")
    lines += [
        "",
        f"NONBONDED nbxmod 5 atom cdiel cutnb 14.0 ctofnb 12.0 ctonnb 10.0 eps 1.0 e14fac {1 / _FUDGE_QQ} wmin 1.5",
    ]
    for i, (_, sigma, epsilon) in enumerate(terms.particles):
        half, well = rmin(sigma) / 2, -epsilon / _KCAL
        lines.append(f"T{i} 0.0 {well:.10g} {half:.10g} 0.0 {well / _FUDGE_LJ:.10g} {half:.10g}")
    if nbfix:
        lines += ["", "NBFIX"]
        lines += [f"T{i} T{j} {-epsilon / _KCAL:.10g} {rmin(sigma):.10g}" for i, j, sigma, epsilon in nbfix]
    prm.write_text("\n".join([*lines, "", "END", ""]))
    return [rtf, prm]


def writeCrd(path, atoms, positions):
    """Write CHARMM's crd, in its extended form."""
    lines = ["* peptide", "*", f"{len(atoms):10d}  EXT"]
    for i, (atom, position) in enumerate(zip(atoms, (10 * np.asarray(positions)).tolist(), strict=True)):
        number = f"{i + 1:10d}{atom.residue.index + 1:10d}  {atom.residue.name:<8}  {atom.name:<8}"
        lines.append(
            number + "".join(f"{value:20.10f}" for value in position) + f"  {'PEP':<8}  {atom.residue.id:<8}{0:20.10f}"
        )
    path.write_text("\n".join([*lines, ""]))
    return path


def orderOf(elements, first, second):
    """The bonds of carbon and oxygen in the molecule are double."""
    return 2 if {elements[first], elements[second]} == {"C", "O"} else 1


def sdfOf(elements, bonds, *frames):
    """Return the text of an SDF file of a molecule at some positions (Å)."""
    text = ""
    for positions in frames:
        text += f"molecule\n  program\n\n{len(elements):3d}{len(bonds):3d}  0  0  0  0  0  0  0  0999 V2000\n"
        for symbol, (x, y, z) in zip(elements, positions.tolist(), strict=True):
            text += f"{x:10.4f}{y:10.4f}{z:10.4f} {symbol:<3} 0  0  0  0  0  0  0  0  0  0  0  0\n"
        for first, second in bonds:
            text += f"{first + 1:3d}{second + 1:3d}  {orderOf(elements, first, second)}  0\n"
        text += "M  END\n> <NAME>\nvalue\n\n$$$$\n"
    return text


def mol2Of(elements, bonds, *frames, kinds=str, residue="LIG1"):
    """Return the text of a Mol2 file; kinds : a function of elements that returns types."""
    text = "# a comment\n"
    for positions in frames:
        text += f"@<TRIPOS>MOLECULE\nmolecule\n{len(elements)} {len(bonds)} 1 0 0\nSMALL\nNO_CHARGES\n\n@<TRIPOS>ATOM\n"
        for i, (symbol, (x, y, z)) in enumerate(zip(elements, positions.tolist(), strict=True), 1):
            text += f"{i:6d} {symbol}{i:<6} {x:.4f} {y:.4f} {z:.4f} {kinds(symbol)} 1 {residue} 0.0\n"
        text += "@<TRIPOS>BOND\n"
        for i, (first, second) in enumerate(bonds, 1):
            text += f"{i} {first + 1} {second + 1} {orderOf(elements, first, second)}\n"
    return text
