"""Hydrogens as Reduce places them, against places that Reduce gave, and small cases that one can judge."""

import csv
from pathlib import Path

import numpy as np
import pytest
from openmm import app
from openmmchaintree.scoring.clashscore import clashscore
from openmmchaintree.scoring.protonation import withHydrogens
from openmmchaintree.structures.structure import readModels, readStructure
from scenes import realStructurePath

# Places, angstrom, that Reduce 4.16 gives hydrogens of the villin headpiece of OpenMM's package.
_PLACES = """\
1.H1 24.547 14.762 19.672
1.H2 25.006 13.398 19.874
1.H3 25.969 14.464 19.653
1.HA 24.584 13.094 17.933
1.HB2 24.815 15.841 17.261
1.HB3 24.565 14.762 16.164
1.HG 22.822 15.355 18.300
1.HD11 21.448 15.931 16.282
2.H 26.078 12.554 16.236
2.HG 27.395 9.847 14.923
6.HD1 27.190 20.852 15.261
6.HZ 26.270 21.905 19.049
7.HZ1 29.996 22.753 5.675
7.HZ2 30.757 22.433 6.871
8.HB1 22.163 17.122 8.901
9.HB 19.676 20.174 13.696
9.HG12 19.596 18.183 12.505
11.HA2 25.058 23.855 9.611
11.HA3 24.737 25.318 10.046
12.HE2 26.583 28.002 13.856
13.HG1 33.734 22.381 14.074
13.HG21 33.649 21.213 12.099
14.HE 30.989 16.851 19.982
14.HH11 28.603 14.658 19.340
14.HH22 29.656 15.025 22.296
19.HD21 34.657 32.252 18.302
19.HD22 33.889 31.214 17.558
21.HD2 27.445 32.528 22.204
23.HE1 25.462 34.864 27.309
23.HZ3 20.621 33.615 24.567
25.HE21 29.267 27.582 24.139
27.HE1 15.093 30.244 22.467
27.HE2 14.956 30.829 24.812
29.HZ3 24.905 19.081 24.594
"""


def villin():
    structure = readStructure()
    return structure.topology, np.round(10 * structure.positions, 3) / 10


def named(topology):
    return {f"{atom.residue.id}.{atom.name}": atom.index for atom in topology.atoms()}


def residueOf(topology, chain, name, atoms):
    residue = topology.addResidue(name, chain)
    for atom in atoms:
        topology.addAtom(atom, app.Element.getBySymbol("Zn" if atom == "ZN" else atom[0]), residue)


def build(*residues):
    """Return a Topology and positions of residues: (name, {atom: (x, y, z)}), each in its chain."""
    topology = app.Topology()
    for name, atoms in residues:
        residueOf(topology, topology.addChain(), name, atoms)
    return topology, np.array([place for _, atoms in residues for place in atoms.values()], dtype=float)


def hydrogensOf(found):
    return [atom.name for atom in found.topology.atoms() if atom.element is app.element.hydrogen]


def test_villinGetsTheHydrogensOfReduce():
    found = withHydrogens(*villin())
    index = named(found.topology)
    for line in _PLACES.splitlines():
        name, *place = line.split()
        assert 10 * found.positions[index[name]] == pytest.approx(np.array(place, dtype=float), abs=2e-3), name
    assert "27.HD1" not in index  # NE2 bears it
    assert found.topology.getNumAtoms() == 582


def test_hydrogensOfTheFileAreReplacedAndOtherAtomsKept():
    topology, positions = villin()
    before = positions.copy()
    found = withHydrogens(topology, positions)
    heavy = [atom.index for atom in topology.atoms() if atom.element is not app.element.hydrogen]
    assert found.origins[found.origins >= 0].tolist() == heavy
    assert (found.positions[found.origins >= 0] == positions[heavy]).all() and (positions == before).all()
    # Hydrogens come after the other atoms of their residue, next to the atoms that bear them.
    atoms, original = list(found.topology.atoms()), list(topology.atoms())
    for atom, bearer in zip(atoms, found.bearers.tolist(), strict=True):
        assert atom.residue.id == original[bearer].residue.id
        assert np.linalg.norm(found.positions[atom.index] - positions[bearer]) < 0.1
    # A second pass changes nothing.
    again = withHydrogens(found.topology, found.positions)
    assert again.positions == pytest.approx(found.positions, abs=1e-12)


def test_aHydroxylPointsAtTheAcceptorNearIt():
    serine = {"CA": (0, 0, 0), "CB": (0.153, 0, 0), "OG": (0.2, 0.134, 0)}
    for place in ((0.47, 0.2, 0.05), (0.2, 0.3, 0.25), (0.3, 0.3, -0.2)):
        found = withHydrogens(*build(("SER", serine), ("ASP", {"OD1": place})))
        index = named(found.topology)
        hydrogen = found.positions[next(index[name] for name in index if name.endswith(".HG"))]
        oxygen = found.positions[2]
        assert np.linalg.norm(hydrogen - oxygen) == pytest.approx(0.084)
        # It lies as near to the acceptor as its angle lets it, to a degree or two.
        axis = (oxygen - found.positions[1]) / np.linalg.norm(oxygen - found.positions[1])
        arm = hydrogen - oxygen - ((hydrogen - oxygen) @ axis) * axis
        wanted = np.array(place) - oxygen - ((np.array(place) - oxygen) @ axis) * axis
        cosine = arm @ wanted / np.linalg.norm(arm) / np.linalg.norm(wanted)
        assert np.degrees(np.arccos(cosine)) < 12


def test_twoHydroxylsFormOneChain():
    # Each is the other's only neighbor: one donates and the other accepts, and hydrogens do not meet.
    first = {"CA": (0, 0, 0), "CB": (0.153, 0, 0), "OG": (0.2, 0.134, 0)}
    second = {name: (0.67 - x, 0.27 - y, z) for name, (x, y, z) in first.items()}
    found = withHydrogens(*build(("SER", first), ("SER", second)))
    hydrogens = [atom.index for atom in found.topology.atoms() if atom.name == "HG"]
    oxygens = [atom.index for atom in found.topology.atoms() if atom.name == "OG"]
    across = [
        np.linalg.norm(found.positions[h] - found.positions[o]) for h, o in zip(hydrogens, oxygens[::-1], strict=True)
    ]
    assert min(across) < 0.2
    assert np.linalg.norm(found.positions[hydrogens[0]] - found.positions[hydrogens[1]]) > 0.17


@pytest.mark.parametrize("nitrogen, hydrogen", [("ND1", "HD1"), ("NE2", "HE2")])
def test_aHistidineDonatesToTheAcceptorBesideIt(nitrogen, hydrogen):
    angles = {"CG": 90, "ND1": 162, "CE1": 234, "NE2": 306, "CD2": 18}
    ring = {name: 0.117 * np.array([np.cos(np.radians(a)), np.sin(np.radians(a)), 0]) for name, a in angles.items()}
    acceptor = 0.39 / 0.117 * ring[nitrogen]
    found = withHydrogens(*build(("HIS", ring), ("ASP", {"OD1": acceptor})))
    polar = [name for name in hydrogensOf(found) if name in ("HD1", "HE2")]
    assert polar == [hydrogen]


@pytest.mark.parametrize("distance, count", [(0.2, 0), (0.3, 1)])
def test_bondedSulfursBearNoHydrogen(distance, count):
    half = {"CA": (0, 0, 0), "CB": (0.153, 0, 0), "SG": (0.21, 0.17, 0)}
    other = {name: (0.42 + distance - x, y, z) for name, (x, y, z) in half.items()}
    found = withHydrogens(*build(("CYS", half), ("CYS", other)))
    assert hydrogensOf(found).count("HG") == 2 * count


def test_metalsReplaceHydrogens():
    half = {"CA": (0, 0, 0), "CB": (0.153, 0, 0), "SG": (0.21, 0.17, 0)}
    metal = ("ZN", {"ZN": (0.21, 0.4, 0)})
    assert "HG" in hydrogensOf(withHydrogens(*build(("CYS", half))))
    assert "HG" not in hydrogensOf(withHydrogens(*build(("CYS", half), metal)))


def peptide(gap, ids):
    """Return two alanines, C and N of which are `gap` apart, with these numbers."""
    topology = app.Topology()
    chain = topology.addChain()
    backbone = {
        "N": (0, 0, 0),
        "CA": (0.146, 0, 0),
        "C": (0.2, 0.143, 0),
        "CB": (0.2, -0.07, 0.12),
    }
    places = []
    for number, identifier in enumerate(ids):
        residue = topology.addResidue("ALA", chain, identifier)
        for name, (x, y, z) in backbone.items():
            topology.addAtom(name, app.Element.getBySymbol(name[0]), residue)
            places.append((x + number * (0.2 + 0.5 * gap), y + number * (0.143 + 0.866 * gap), z))
    return topology, np.array(places)


@pytest.mark.parametrize(
    "gap, ids, nitrogens",
    [(0.133, ("1", "2"), ["H1 H2 H3", "H"]), (0.133, ("5", "6"), ["", "H"]), (0.2, ("1", "9"), ["H1 H2 H3", ""])],
)
def test_chainsBeginWithAmmoniumAndFragmentsWithABareNitrogen(gap, ids, nitrogens):
    found = withHydrogens(*peptide(gap, ids))
    names = [
        " ".join(atom.name for atom in residue.atoms() if atom.name in ("H", "H1", "H2", "H3"))
        for residue in found.topology.residues()
    ]
    assert names == nitrogens


def test_ligandsKeepTheirHydrogensAndWaterGetsNone():
    ligand = ("LIG", {"C1": (0, 0, 0), "H1": (0.109, 0, 0)})
    found = withHydrogens(*build(ligand, ("HOH", {"O": (1, 0, 0), "H1": (1.1, 0, 0)})))
    assert [atom.name for atom in found.topology.atoms()] == ["C1", "H1", "O"]


@pytest.mark.parametrize("name, added", [("ALA", 0), ("UNK", 0), ("DG", 0)])
def test_fragmentsOfResiduesGetWhatTheirAtomsTell(name, added):
    found = withHydrogens(*build((name, {"CA": (0, 0, 0)})))
    assert len(hydrogensOf(found)) == added


def test_sideChainsThatReduceFlips():
    models = readModels(realStructurePath("1ubi_h.pdb"))
    found = withHydrogens(models.topology, models.positions[0], flips=True)
    residues = list(found.topology.residues())
    names = [f"{residues[index].name} {residues[index].id}" for index in found.flipped]
    assert names == ["ASN 25", "GLN 49", "ASN 60", "GLN 62"]  # as by reduce -build
    # They exchange atoms, and leave all others where they were.
    kept = np.flatnonzero(found.origins >= 0)
    before, after = models.positions[0][found.origins[kept]], found.positions[kept]
    residueOf = np.array([atom.residue.index for atom in found.topology.atoms()])[kept]
    assert set(residueOf[(before != after).any(axis=1)]) == set(found.flipped)
    assert (np.sort(before, axis=0) == np.sort(after, axis=0)).all()


@pytest.mark.parametrize("name", ["1shg.pdb", "1ubi_h.pdb", "models/hp_T1065s2.pdb.gz", "models/al_dimer0.pdb.gz"])
def test_clashscoresAreThoseOfReduceAndProbe(name):
    path = realStructurePath(name)
    with open(Path(realStructurePath("clashscores.tsv")), newline="", encoding="utf-8") as file:
        rows = {row["file"]: row for row in csv.DictReader(file, delimiter="\t")}
    row = rows[Path(name).name]
    models = readModels(path)
    found = withHydrogens(models.topology, models.positions[0])
    score = clashscore(found.topology, found.positions, np.array([atom.occ for atom in models.atoms])[found.bearers])
    assert score.atomCount == int(row["atoms with H"])
    assert abs(len(score.pairs) - int(row["clashes"])) <= 2
