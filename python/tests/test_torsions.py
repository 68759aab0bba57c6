"""findTorsions, on peptides of known sequence and on real structures."""

from collections import Counter

import numpy as np
import pytest
from openmm import app
from openmmchaintree import findTorsions
from openmmchaintree.graphs import neighborLists, ringBonds
from openmmchaintree.residues import aminoAcid
from scenes import HEAVY_ATOMS, peptide

# Side-chain torsions of IUPAC that are no ring bonds, and not the planar end of arginine.
_CHI_COUNTS = {
    "ALA": 0, "ARG": 4, "ASN": 2, "ASP": 2, "CYS": 1, "GLN": 3, "GLU": 3, "GLY": 0, "HIS": 2, "ILE": 2, "LEU": 2,
    "LYS": 4, "MET": 3, "PHE": 2, "PRO": 0, "SER": 1, "THR": 1, "TRP": 2, "TYR": 2, "VAL": 1,
}  # fmt: skip


def kindsOf(search):
    return Counter(torsion.kind for torsion in search.torsions)


def namesOf(topology, torsion):
    atoms = list(topology.atoms())
    return [atoms[particle].name for particle in torsion.particles]


def only(search, kind, residue):
    (torsion,) = [t for t in search.torsions if t.kind == kind and t.residue.index == residue]
    return torsion


@pytest.mark.parametrize("name", sorted(HEAVY_ATOMS))
def test_everyAminoAcid(name):
    topology = peptide("GLY", name, "GLY")
    search = findTorsions(topology)
    kinds = kindsOf(search)
    assert kinds["psi"] == 2
    assert kinds["phi"] == (1 if name == "PRO" else 2)
    assert sum(kinds[f"chi{i}"] for i in range(1, 5)) == _CHI_COUNTS[name]
    assert len(search.torsions) == sum(kinds.values())


def test_quadruplesAreThoseOfIUPAC():
    topology = peptide("ALA", "ARG", "ALA")
    search = findTorsions(topology, kinds=("phi", "psi", "omega", "chi"))
    assert namesOf(topology, only(search, "phi", 1)) == ["C", "N", "CA", "C"]
    assert namesOf(topology, only(search, "psi", 1)) == ["N", "CA", "C", "N"]
    assert namesOf(topology, only(search, "omega", 1)) == ["CA", "C", "N", "CA"]
    expected = "N CA CB CG CD NE CZ".split()
    for number in range(1, 5):
        assert namesOf(topology, only(search, f"chi{number}", 1)) == expected[number - 1 : number + 3]
    atoms = list(topology.atoms())
    residues = [[atoms[p].residue.index for p in t.particles] for t in search.torsions if t.kind == "phi"]
    assert residues == [[0, 1, 1, 1], [1, 2, 2, 2]]


def test_branchesFollowTheLowerNumber():
    topology = peptide("ILE", "LEU", "THR", "VAL", "ASP", "HIS", "TRP")
    search = findTorsions(topology, kinds="chi")
    ends = [namesOf(topology, only(search, f"chi{n}", r))[3] for r, n in enumerate((2, 2, 1, 1, 2, 2, 2))]
    assert ends == ["CD1", "CD1", "OG1", "CG1", "OD1", "ND1", "CD1"]


def test_prolinePhiIsLeftOut():
    search = findTorsions(peptide("ALA", "PRO", "ALA"), kinds="phi")
    assert [torsion.residue.index for torsion in search.torsions] == [2]
    assert [(left.kind, left.residue.name, left.reason) for left in search.leftOut] == [
        ("phi", "PRO", "in the ring of proline")
    ]


@pytest.mark.parametrize(
    ("standard", "variants"),
    [
        ("HIS", ["HID", "HIE", "HIP", "HSD", "HSE", "HSP", "NHIE"]),
        ("CYS", ["CYX", "CYM", "CCYX"]),
        ("ASP", ["ASH"]),
        ("GLU", ["GLH"]),
        ("LYS", ["LYN"]),
    ],
)
def test_variantsOfProtonation(standard, variants):
    topology = peptide("ALA", standard, "ALA")
    expected = [torsion.particles for torsion in findTorsions(topology).torsions]
    for variant in variants:
        list(topology.residues())[1].name = variant
        assert [torsion.particles for torsion in findTorsions(topology).torsions] == expected


def test_chainsAreSeparate():
    search = findTorsions(peptide("ALA", "ALA", chains=2))
    assert kindsOf(search) == {"phi": 2, "psi": 2}
    assert search.leftOut == []


def test_missingAtomIsNamed():
    topology = peptide("ALA", "LYS", "ALA")
    modeller = app.Modeller(topology, np.zeros((topology.getNumAtoms(), 3)))
    modeller.delete([atom for atom in topology.atoms() if atom.name in ("CE", "NZ")])
    search = findTorsions(modeller.topology)
    assert kindsOf(search)["chi2"] == 1
    assert [left.kind for left in search.leftOut] == ["chi3", "chi4"]
    assert all(left.reason.startswith("atom CE of ") and "LYS 2" in left.reason for left in search.leftOut)


def test_missingBondBetweenResiduesIsAGap():
    topology = peptide("ALA", "ALA")
    bonds = [bond for bond in topology.bonds() if bond[0].residue is bond[1].residue]
    topology._bonds = bonds
    search = findTorsions(topology)
    assert search.torsions == []
    assert [(left.kind, left.nextToGap) for left in search.leftOut] == [("psi", True), ("phi", True)]
    assert search.leftOut[0].reason == "next to a gap in the chain: the Topology has no bond between them"


def test_longBondIsAGap():
    topology = peptide("ALA", "ALA", "ALA")
    positions = np.zeros((topology.getNumAtoms(), 3))
    positions[5:, 0] = 0.41
    assert len(findTorsions(topology).torsions) == 4
    search = findTorsions(topology, positions)
    assert [torsion.kind for torsion in search.torsions] == ["psi", "phi"]
    assert search.leftOut[0].reason == (
        "next to a gap in the chain: C and N, bonded in the Topology, are 0.41 nm apart"
    )
    positions[5:, 0] = 0.40
    assert len(findTorsions(topology, positions).torsions) == 4


def test_disulfideClosesARing():
    topology = peptide("CYS", "ALA", "ALA", "CYS")
    sulfurs = [atom for atom in topology.atoms() if atom.name == "SG"]
    assert len(findTorsions(topology).torsions) == 8
    topology.addBond(*sulfurs)
    search = findTorsions(topology)
    assert search.torsions == []
    assert Counter(left.reason for left in search.leftOut) == {"in a ring that disulfide bonds close": 8}
    cut = findTorsions(topology, cutDisulfides=True)
    assert len(cut.torsions) == 8 and cut.leftOut == []


def test_disulfideBetweenChainsClosesNoRing():
    topology = peptide("CYS", "ALA", chains=2)
    topology.addBond(*[atom for atom in topology.atoms() if atom.name == "SG"])
    assert kindsOf(findTorsions(topology)) == {"phi": 2, "psi": 2, "chi1": 2}


def test_cyclicPeptideIsARing():
    topology = peptide("GLY", "ALA", "LEU", "ALA")
    atoms = list(topology.atoms())
    last = list(topology.residues())[-1]
    topology.addBond(next(atom for atom in last.atoms() if atom.name == "C"), atoms[0])
    search = findTorsions(topology)
    assert kindsOf(search) == {"chi1": 1, "chi2": 1}
    assert {left.reason for left in search.leftOut} == {"in a ring"}
    assert len(search.leftOut) == 8


def test_unknownKindIsRefused():
    with pytest.raises(ValueError, match="^'tau' is not a kind of torsion; the kinds are phi, psi, omega, chi"):
        findTorsions(peptide("ALA"), kinds=("phi", "tau"))


def test_caps():
    topology = app.Topology()
    chain = topology.addChain()
    capped = {"ACE": "H1 CH3 H2 H3 C O", "ALA": "N H CA HA CB HB1 HB2 HB3 C O", "NME": "N H C H1 H2 H3"}
    for name, atoms in capped.items():
        residue = topology.addResidue(name, chain)
        for atom in atoms.split():
            topology.addAtom(atom, app.Element.getBySymbol(atom[0]), residue)
    topology.createStandardBonds()
    search = findTorsions(topology, kinds=("phi", "psi", "omega", "rotor"))
    assert search.leftOut == []
    found = [(torsion.kind, torsion.residue.name, namesOf(topology, torsion)) for torsion in search.torsions]
    assert found == [
        ("omega", "ACE", ["CH3", "C", "N", "CA"]),
        ("rotor", "ACE", ["O", "C", "CH3", "H1"]),
        ("phi", "ALA", ["C", "N", "CA", "C"]),
        ("psi", "ALA", ["N", "CA", "C", "N"]),
        ("omega", "ALA", ["CA", "C", "N", "C"]),
        ("rotor", "ALA", ["N", "CA", "CB", "HB1"]),
        ("rotor", "NME", ["C", "N", "C", "H1"]),
    ]


def test_aTopologyWithoutAtomsIsRefused():
    with pytest.raises(ValueError, match="^the Topology has no atoms$"):
        findTorsions(app.Topology())


def test_positionsOfAnotherSizeAreRefused():
    with pytest.raises(ValueError, match=r"^positions must have the shape \(5, 3\)"):
        findTorsions(peptide("ALA"), np.zeros((4, 3)))


def test_villin(villin):
    search = findTorsions(villin.topology, villin.positions, ("phi", "psi", "omega", "chi", "rotor"))
    sequence = "LSDEDFKAVFGMTRSAFANLPLWKQQHLKKEKGLF"
    names = Counter(aminoAcid(residue.name) for residue in villin.topology.residues())
    assert sum(names.values()) == len(sequence) == 35 and names["PRO"] == sequence.count("P") == 1
    kinds = kindsOf(search)
    assert kinds["phi"] == 34 - 1
    assert kinds["psi"] == kinds["omega"] == 34
    chi = sum(_CHI_COUNTS[name] * count for name, count in names.items())
    assert sum(kinds[f"chi{i}"] for i in range(1, 5)) == chi
    methyls = names["ALA"] + names["THR"] + names["MET"] + 2 * (names["VAL"] + names["LEU"] + names["ILE"])
    hydroxyls = names["SER"] + names["THR"] + names["TYR"]
    assert kinds["rotor"] == methyls + hydroxyls + names["LYS"] + 1  # and the N-terminus


def test_torsionsAreDifferentBonds(villin):
    search = findTorsions(villin.topology, villin.positions, ("phi", "psi", "omega", "chi", "rotor"))
    axes = {frozenset(torsion.particles[1:3]) for torsion in search.torsions}
    assert len(axes) == len(search.torsions)


def test_trpCage(realStructure):
    structure = realStructure("1l2y.pdb")
    kinds = kindsOf(findTorsions(structure.topology, structure.positions))
    sequence = "NLYIQWLKDGGPSSGRPPPS"
    assert kinds["psi"] == 19
    assert kinds["phi"] == 19 - sequence.count("P")


def test_crambin(realStructure):
    structure = realStructure("1crn.pdb")
    asItIs = findTorsions(structure.topology, structure.positions)
    cut = findTorsions(structure.topology, structure.positions, cutDisulfides=True)
    assert kindsOf(cut)["psi"] == 45 and kindsOf(cut)["phi"] == 45 - 5
    assert {left.reason for left in cut.leftOut} == {"in the ring of proline"}
    # Disulfides 3–40, 4–32 and 16–26: the rings hold the backbone from residue 3 to 40, and their cysteines' chi1.
    free = {torsion.residue.index + 1 for torsion in asItIs.torsions if torsion.kind in ("phi", "psi")}
    assert free == {1, 2, 3, 40, 41, 42, 43, 44, 45, 46}
    assert sum(left.kind == "chi1" for left in asItIs.leftOut) == 6


def test_gapsOf6msm(realStructure):
    structure = realStructure("6msm.pdb")
    search = findTorsions(structure.topology, structure.positions)
    gaps = [left for left in search.leftOut if left.nextToGap]
    assert [(left.kind, left.residue.id) for left in gaps if left.kind == "psi"] == [
        ("psi", "409"), ("psi", "637"), ("psi", "889"), ("psi", "1173")
    ]  # fmt: skip
    assert len(gaps) == 8


def test_nucleicAcid(realStructure):
    structure = realStructure("1bna.pdb")
    kinds = ("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "chi")
    search = findTorsions(structure.topology, structure.positions, kinds)
    assert kindsOf(search) == {"alpha": 22, "beta": 22, "gamma": 24, "epsilon": 22, "zeta": 22, "chi": 24}
    assert Counter((left.kind, left.reason) for left in search.leftOut) == {("delta", "in the ring of the sugar"): 24}
    assert namesOf(structure.topology, only(search, "alpha", 1)) == ["O3'", "P", "O5'", "C5'"]
    assert namesOf(structure.topology, only(search, "chi", 0))[2:] == ["N1", "C2"]
    assert namesOf(structure.topology, only(search, "chi", 1))[2:] == ["N9", "C4"]


def test_ringBondsAgainstRemovingEachBond():
    """A bond is in a ring exactly if its ends stay connected without it."""
    random = np.random.default_rng(1)
    for _ in range(200):
        count = int(random.integers(2, 15))
        drawn = random.integers(0, count, (count + 3, 2)).tolist()
        pairs = {tuple(sorted(pair)) for pair in drawn if pair[0] != pair[1]}
        found = ringBonds(neighborLists(count, pairs))
        assert found == {pair for pair in pairs if isConnected(neighborLists(count, pairs - {pair}), *pair)}


def isConnected(neighbors, start, end):
    seen, pending = {start}, [start]
    while pending:
        for other in neighbors[pending.pop()]:
            if other not in seen:
                seen.add(other)
                pending.append(other)
    return end in seen


def test_allAreTheBondsInNoRing():
    """Torsions of proteins by kind, planar ends of side chains, and others, such as the end's carboxylate."""
    topology = peptide(*sorted(HEAVY_ATOMS))
    ends = topology.addAtom("OXT", app.element.oxygen, list(topology.residues())[-1])
    topology.addBond(next(a for a in topology.atoms() if a.residue is ends.residue and a.name == "C"), ends)
    search = findTorsions(topology, kinds="all")
    neighbors = neighborLists(topology.getNumAtoms(), [(bond[0].index, bond[1].index) for bond in topology.bonds()])
    inRings = ringBonds(neighbors)
    expected = set()
    for bond in topology.bonds():
        pair = (min(bond[0].index, bond[1].index), max(bond[0].index, bond[1].index))
        if pair not in inRings and all(len(neighbors[atom]) > 1 for atom in pair):
            expected.add(pair)
    found = [tuple(sorted(torsion.particles[1:3])) for torsion in search.torsions]
    assert set(found) == expected and len(found) == len(expected)
    named = findTorsions(topology, kinds=("phi", "psi", "omega", "chi", "rotor")).torsions
    assert [torsion for torsion in search.torsions if torsion.kind not in ("planar", "other")] == named
    others = {(torsion.kind, *namesOf(topology, torsion)[1:3]) for torsion in search.torsions if torsion not in named}
    assert others == {("planar", "NE", "CZ"), ("other", "CA", "C")}
    assert [torsion.kind for torsion in findTorsions(topology, kinds="planar").torsions] == ["planar"]


def test_allBondsOfALigand():
    # Butane with an extra particle on its end, whose bond turns nothing.
    topology = app.Topology()
    residue = topology.addResidue("BUT", topology.addChain())
    atoms = [topology.addAtom(f"C{i}", app.element.carbon, residue) for i in range(4)]
    for atom, other in zip(atoms, atoms[1:], strict=False):
        topology.addBond(atom, other)
    topology.addBond(atoms[3], topology.addAtom("LP", None, residue))
    assert findTorsions(topology, kinds="all").torsions == [((0, 1, 2, 3), "other", residue)]
    assert findTorsions(topology).torsions == []
