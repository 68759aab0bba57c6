"""The verdicts of AlphaFold 3 and PoseBusters, broken bonds and pierced rings."""

import numpy as np
import pytest
from openmm import app
from openmmchaintree import InputError, scoreClashes
from openmmchaintree.scoring.chainoverlap import chainOverlaps
from openmmchaintree.scoring.covalentfaults import covalentFaults
from openmmchaintree.scoring.parts import countByParts
from openmmchaintree.scoring.poses import checkPoses
from openmmchaintree.structures.structure import readModels, readStructure
from scenes import realStructurePath


def build(*residues):
    """Return a Topology and positions of residues: (chain, number, name, {atom: (x, y, z)})."""
    topology = app.Topology()
    chains = {}
    for chain, number, name, atoms in residues:
        if chain not in chains:
            chains[chain] = topology.addChain(chain)
        residue = topology.addResidue(name, chains[chain], str(number))
        for atom in atoms:
            topology.addAtom(atom, app.Element.getBySymbol("Zn" if atom == "ZN" else atom[0]), residue)
    return topology, np.array([place for *_, atoms in residues for place in atoms.values()], dtype=float)


# ---- AlphaFold 3 ----


def alanines(chain, first, places):
    return [
        (chain, first + number, "ALA", {f"C{atom}": place for atom, place in enumerate(atoms)})
        for number, atoms in enumerate(places)
    ]


def hasClashByLoops(topology, positions):
    """The definition, atom by atom: confidences.py of AlphaFold 3."""
    atoms = list(topology.atoms())
    clashing = set()
    for first in atoms:
        for second in atoms:
            isNear = np.linalg.norm(positions[first.index] - positions[second.index]) <= 0.11
            isFar = abs(int(first.residue.id) - int(second.residue.id)) > 1
            if isNear and (isFar or first.residue.chain.id != second.residue.chain.id):
                clashing.add(first.index)
    verdict = False
    for chain in topology.chains():
        own = [atom.index for atom in chain.atoms()]
        count = len(clashing.intersection(own))
        verdict |= count > 100 or count > 0.5 * len(own)
    return verdict


@pytest.mark.parametrize("seed", range(6))
def test_hasClashIsThatOfAlphaFold(seed):
    generator = np.random.default_rng(seed)
    size = generator.uniform(0.3, 1.2)
    residues = [
        entry for chain in "AB" for entry in alanines(chain, 1, generator.uniform(0, size, size=(8, 4, 3)).tolist())
    ]
    topology, positions = build(*residues)
    assert any(chain.hasClash for chain in chainOverlaps(topology, positions)) == hasClashByLoops(topology, positions)


@pytest.mark.parametrize("count, verdict", [(100, False), (101, True)])
def test_moreThanAHundredAtomsOfALongChainClash(count, verdict):
    line = np.zeros((120, 4, 3))
    line[..., 0] = np.arange(480).reshape(120, 4)
    other = line[:, :1].copy()[:count] + [0.05, 0, 0]
    far = 5 * np.ones((400, 1, 3)) * np.arange(1, 401)[:, None, None]
    topology, positions = build(*alanines("A", 1, line), *alanines("B", 1, [*other, *far]))
    chains = {chain.chain: chain for chain in chainOverlaps(topology, positions)}
    assert (chains["A"].clashingCount, chains["A"].hasClash) == (count, verdict)


def test_neighborsInTheChainAndLigandsDoNotClash():
    near = [[(0, 0, 0)], [(0.05, 0, 0)]]
    assert not any(chain.hasClash for chain in chainOverlaps(*build(*alanines("A", 1, near))))
    ligand = ("B", 1, "LIG", {"C1": (0.05, 0, 0)})
    (chain,) = chainOverlaps(*build(*alanines("A", 1, near[:1]), ligand))
    assert (chain.chain, chain.clashingCount) == ("A", 0)


# ---- PoseBusters ----

_CARBON, _IRON = 1.7, 2.05  # RDKit's van der Waals radii, angstrom; its covalent radius of carbon is 0.76, of Zn 1.22


def poseOf(distance, other=("A", 1, "ALA", "CB"), isHetero=False):
    pytest.importorskip("rdkit")
    chain, number, name, atom = other
    topology, positions = build(
        (chain, number, name, {atom: (0, 0, 0)}),
        ("B", 1, "LIG", {"C1": (0, 0, distance), "C2": (0, 0, distance + 0.15)}),
    )
    return checkPoses(topology, positions, np.array([isHetero, True, True]))


@pytest.mark.parametrize("distance, passes", [(0.254, False), (0.256, True)])
def test_aLigandFailsNearerThanThreeQuartersOfTheRadii(distance, passes):
    (check,) = poseOf(distance)  # 0.75 x 3.4 angstrom is 2.55
    assert (check.ligand, check.other, check.clashCount == 0) == ("B:LIG 1", "protein", passes)
    assert check.leastDistance == pytest.approx(distance / 0.34)


def test_metalsHaveCovalentRadii():
    (near,) = poseOf(0.14, ("C", 1, "ZN", "ZN"), isHetero=True)
    (far,) = poseOf(0.16, ("C", 1, "ZN", "ZN"), isHetero=True)
    assert near.other == far.other == "inorganic cofactors"
    assert near.clashCount == 1 and far.clashCount == 0


def test_aLigandInsideAProteinFailsByVolume():
    pytest.importorskip("rdkit")
    grid = {f"C{number}": place for number, place in enumerate(np.ndindex(3, 3, 3))}
    cage = {name: tuple(0.3 * np.array(place)) for name, place in grid.items()}
    topology, positions = build(("A", 1, "ALA", cage), ("B", 1, "LIG", {"C1": (0.3, 0.3, 0.15), "C2": (0.3, 0.3, 0.3)}))
    (check,) = checkPoses(topology, positions, np.array([False] * 27 + [True] * 2))
    assert check.volumeOverlap > 0.5 and not check.passes


def test_ligandsBondedToAPolymerAreNone():
    pytest.importorskip("rdkit")
    topology, positions = build(
        ("A", 1, "ASN", {"ND2": (0, 0, 0)}), ("A", 2, "NAG", {"C1": (0, 0, 0.145), "C2": (0, 0, 0.3)})
    )
    atoms = list(topology.atoms())
    assert len(checkPoses(topology, positions, np.array([False, True, True]))) == 1
    topology.addBond(atoms[0], atoms[1])
    assert checkPoses(topology, positions, np.array([False, True, True])) == []


def moveLine(line, shift):
    return f"{line[:30]}{float(line[30:38]) + shift:8.3f}{line[38:]}"


def test_verdictsAreThoseOfPoseBusters(tmp_path):
    rdkit = pytest.importorskip("rdkit.Chem")
    distances = pytest.importorskip("posebusters.modules.intermolecular_distance").check_intermolecular_distance
    volumes = pytest.importorskip("posebusters.modules.volume_overlap").check_volume_overlap
    text = realStructurePath("3ptb.pdb").read_text()
    lines = [
        line for line in text.splitlines() if line[:6] in ("ATOM  ", "HETATM") and line[17:20] not in ("HOH", " CA")
    ]
    ignored = {"hydrogens", "organic_cofactors", "inorganic_cofactors", "waters"}
    verdicts = set()
    for shift in (0, 1, 2, 3):
        moved = [moveLine(line, shift) if line[17:20] == "BEN" else line for line in lines]
        (tmp_path / "a.pdb").write_text("\n".join([*moved, "END", ""]))
        models = readModels(tmp_path / "a.pdb")
        isHetero = np.array([atom.residue.name == "BEN" for atom in models.topology.atoms()])
        (own,) = checkPoses(models.topology, models.positions[0], isHetero)
        ligand, protein = (
            rdkit.MolFromPDBBlock("\n".join(line for line in moved if ("BEN" in line) == isLigand), sanitize=False)
            for isLigand in (True, False)
        )
        near = distances(ligand, protein, ignore_types=ignored)["results"]
        inside = volumes(ligand, protein, clash_cutoff=0.075, ignore_types=ignored)["results"]
        assert own.clashCount == near["num_pairwise_clashes"]
        assert own.volumeOverlap == pytest.approx(inside["volume_overlap"], abs=1e-6)
        assert own.passes == bool(near["no_clashes"] and inside["no_volume_clash"])
        verdicts.add(own.passes)
    assert verdicts == {True, False}


# ---- Covalent faults ----


def test_villinHasNoFaults():
    structure = readStructure()
    faults = covalentFaults(structure.topology, structure.positions)
    assert faults.brokenBonds == [] and faults.piercedRings == []


@pytest.mark.parametrize("shift", [0.06, -0.05])
def test_aStretchedOrSqueezedPeptideBondIsBroken(shift):
    structure = readStructure()
    atoms = list(structure.topology.atoms())
    index = {(atom.residue.id, atom.name): atom.index for atom in atoms}
    carbon, nitrogen = index["20", "C"], index["21", "N"]
    positions = structure.positions.copy()
    along = positions[nitrogen] - positions[carbon]
    later = [atom.index for atom in atoms if int(atom.residue.id) > 20]
    positions[later] += shift * along / np.linalg.norm(along)
    (broken,) = covalentFaults(structure.topology, positions).brokenBonds
    assert (broken.particle1, broken.particle2) == (carbon, nitrogen)
    assert broken.length == pytest.approx(np.linalg.norm(along) + shift)


def phenylalanineAndBond(begin, end):
    ring = {
        name: (0.14 * np.cos(np.radians(angle)), 0.14 * np.sin(np.radians(angle)), 0)
        for name, angle in zip(("CG", "CD1", "CE1", "CZ", "CE2", "CD2"), range(0, 360, 60), strict=True)
    }
    backbone = {"N": (0.4, 0.22, 0), "CA": (0.37, 0.08, 0), "C": (0.5, 0, 0), "O": (0.5, -0.12, 0), "CB": (0.29, 0, 0)}
    return build(("A", 1, "PHE", backbone | ring), ("B", 1, "LIG", {"C1": begin, "C2": end}))


@pytest.mark.parametrize(
    "begin, end, isPierced",
    [
        ((0, 0, -0.07), (0, 0, 0.08), True),
        ((0.05, 0.03, -0.07), (0.05, 0.03, 0.08), True),
        ((0.2, 0.1, -0.07), (0.2, 0.1, 0.08), False),  # beside the ring
        ((0, 0, 0.05), (0, 0, 0.2), False),  # before it reaches the ring
    ],
)
def test_aBondThroughARingIsFound(begin, end, isPierced):
    topology, positions = phenylalanineAndBond(begin, end)
    pierced = covalentFaults(topology, positions).piercedRings
    assert len(pierced) == isPierced
    if isPierced:
        atoms = list(topology.atoms())
        assert {atoms[particle].name for particle in pierced[0].ring} == {"CG", "CD1", "CE1", "CZ", "CE2", "CD2"}
        assert [atoms[particle].name for particle in pierced[0][1:]] == ["C1", "C2"]


# ---- Together ----


def test_clashesAreCountedByChainInterfaceAndLigand():
    topology, _ = build(
        ("A", 1, "ALA", {"CA": (0, 0, 0)}),
        ("A", 2, "ALA", {"CA": (0, 0, 0)}),
        ("B", 1, "ALA", {"CA": (0, 0, 0)}),
        ("B", 2, "LIG", {"C1": (0, 0, 0), "C2": (0, 0, 0)}),
        ("B", 3, "HOH", {"O": (0, 0, 0)}),
    )
    counts = countByParts(topology, [(0, 1), (0, 2), (1, 2), (2, 3), (3, 4), (4, 5)])
    assert counts.chains == {"B": 3, "A": 1} and counts.interfaces == {("A", "B"): 2}
    assert counts.ligands == {"B:LIG 2": 2}


def test_scoreClashesOfAFile(tmp_path):
    villin = readStructure()
    with open(tmp_path / "a.pdb", "w") as file:
        app.PDBFile.writeFile(villin.topology, 10 * villin.positions, file)
    (scores,) = scoreClashes(tmp_path / "a.pdb", definitions=("own", "molprobity", "af3"))
    assert len(scores.own.clashes) == 1 and scores.poses is None and not scores.chains[0].hasClash
    assert scores.molprobity.atomCount == 582 and scores.molprobity.clashscore < 5
    (kept,) = scoreClashes(tmp_path / "a.pdb", keepHydrogens=True)
    (clash,) = kept.molprobity.clashes
    assert kept.own is None and {str(clash.atom1), str(clash.atom2)} == {"A:PHE 10 CE1", "A:LYS 32 HE2"}
    with pytest.raises(ValueError, match="no definition 'molprobty'; did you mean molprobity?"):
        scoreClashes(tmp_path / "a.pdb", definitions="molprobty")


def test_occupanciesThatAreAllZeroDoNotCount(tmp_path):
    villin = readStructure()
    with open(tmp_path / "a.pdb", "w") as file:
        app.PDBFile.writeFile(villin.topology, 10 * villin.positions, file)
    text = (tmp_path / "a.pdb").read_text()
    (tmp_path / "b.pdb").write_text(text.replace("  1.00  0.00 ", "  0.00  0.00 "))
    with pytest.warns(UserWarning, match="all occupancies are 0, and do not count"):
        (zero,) = scoreClashes(tmp_path / "b.pdb", keepHydrogens=True)
    assert zero.molprobity.atomCount == 582 and len(zero.molprobity.clashes) == 1


def test_waterAloneHasNoScore(tmp_path):
    topology, positions = build(("A", 1, "HOH", {"O": (0, 0, 0)}))
    with open(tmp_path / "a.pdb", "w") as file:
        app.PDBFile.writeFile(topology, 10 * positions, file)
    with pytest.raises(InputError, match="a.pdb: there is nothing but water"):
        scoreClashes(tmp_path / "a.pdb")


def test_atomsAtOnePlaceAreABrokenBond():
    villin = readStructure()
    index = {(atom.residue.id, atom.name): atom.index for atom in villin.topology.atoms()}
    positions = villin.positions.copy()
    positions[index["20", "C"]] = positions[index["20", "CA"]]
    bonds = [bond[:2] for bond in covalentFaults(villin.topology, positions).brokenBonds]
    assert tuple(sorted((index["20", "C"], index["20", "CA"]))) in bonds


def test_hydrogensThatAreNotThereCannotBeKept(tmp_path):
    glycine = {"N": (0, 0, 0), "CA": (0.146, 0, 0), "C": (0.2, 0.143, 0)}
    topology, positions = build(("A", 1, "GLY", glycine))
    with open(tmp_path / "a.pdb", "w") as file:
        app.PDBFile.writeFile(topology, 10 * positions, file)
    with pytest.raises(InputError, match="a.pdb: there are no hydrogens to keep"):
        scoreClashes(tmp_path / "a.pdb", keepHydrogens=True)
    assert scoreClashes(tmp_path / "a.pdb")[0].molprobity.atomCount == 8
