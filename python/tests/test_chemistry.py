"""Ligands, N-methylated and phosphorylated residues, peptoids and glycans, each with its force field."""

from xml.etree import ElementTree

import numpy as np
import pytest
from biotite.structure.info import residue as component
from commands import filesIn
from openmm import app
from openmmchaintree.command.energymodel import EnergyModel
from openmmchaintree.command.plan import Choice
from openmmchaintree.command.preparing.preparation import prepareStructure
from openmmchaintree.command.sampling import Sampling
from openmmchaintree.structures.structure import readStructure
from peptides import linesOf, makePeptides
from scenes import pdbLine, writePDB

PROTEIN = "amber14/protein.ff14SB.xml"

# N-methylglycine, a peptoid residue, and N-methylalanine, by types of ff14SB: name, type, charge, and bonds.
_N_METHYL = [("N", "N", -0.25), ("CN", "CT", -0.05), *((f"HN{i}", "H1", 0.06) for i in (1, 2, 3)), ("CA", "CX", -0.02)]
_CARBONYL = [("C", "C", 0.59), ("O", "O", -0.57)]
_RESIDUES = {
    "SAR": (
        [*_N_METHYL, ("HA2", "H1", 0.06), ("HA3", "H1", 0.06), *_CARBONYL],
        "N-CN CN-HN1 CN-HN2 CN-HN3 N-CA CA-HA2 CA-HA3 CA-C C-O",
    ),
    "MAA": (
        [*_N_METHYL, ("HA", "H1", 0.06), ("CB", "CT", -0.06), *((f"HB{i}", "HC", 0.04) for i in (1, 2, 3)), *_CARBONYL],
        "N-CN CN-HN1 CN-HN2 CN-HN3 N-CA CA-HA CA-CB CB-HB1 CB-HB2 CB-HB3 CA-C C-O",
    ),
}
_OF_DICTIONARY = {"MAA": {"CM": "CN", "HM1": "HN1", "HM2": "HN2", "HM3": "HN3"}}


def writeForceField(path, residues, ends=("N", "C"), others=""):
    """Write templates of residues as a file of OpenMM's ForceField, with other elements of the file as text."""
    root = ElementTree.fromstring(f"<ForceField>{others}<Residues/></ForceField>")
    for name, (atoms, bonds) in residues.items():
        entry = ElementTree.SubElement(root.find("Residues"), "Residue", name=name)
        rest = sum(charge for _, _, charge in atoms) / len(atoms)
        for atom, kind, charge in atoms:
            kind = kind if "-" in kind else f"protein-{kind}"
            ElementTree.SubElement(entry, "Atom", name=atom, type=kind, charge=f"{charge - rest:.8f}")
        for bond in bonds.split():
            first, second = bond.split("-")
            ElementTree.SubElement(entry, "Bond", atomName1=first, atomName2=second)
        for end in ends:
            ElementTree.SubElement(entry, "ExternalBond", atomName=end)
    path.write_text(ElementTree.tostring(root, encoding="unicode"))
    return path


def sample(structure, model, trials=300):
    """Prepare and sample a structure; U as held is that of OpenMM. Return the Sampling."""
    whole, _ = prepareStructure(structure, model, 7, 1)
    sampling = Sampling(whole, 1, Choice(hasEnergies=True), model)
    sampling.integrator.setTrialsPerStep(trials)
    sampling.integrator.step(1)
    assert sampling.energies.held() == pytest.approx(sampling.energyByOpenMM(), abs=1e-2)
    assert sum(sampling.integrator.getMoveStatistics(move).accepted for move in range(len(sampling.moves))) > 0
    return sampling


def turningResidues(sampling):
    return {torsion.residue.name for torsion in sampling.torsions}


@pytest.fixture(scope="module")
def nMethylFiles(tmp_path_factory):
    return [PROTEIN, str(writeForceField(tmp_path_factory.mktemp("ff") / "nmethyl.xml", _RESIDUES))]


@pytest.mark.parametrize("names", [("ACE", "SAR", "SAR", "SAR", "NME"), ("ACE", "ALA", "MAA", "ALA", "NME")])
def test_peptoidsAndNMethylatedResidues(names, nMethylFiles, tmp_path):
    """With a template the residue stays; its φ, ψ and ω turn."""
    topology, positions = makePeptides(names)

    def rename(atom):
        own = _OF_DICTIONARY.get(atom.residue.name, {})
        return own.get(atom.name, atom.name), atom.residue.name, atom.residue.index + 1

    structure = readStructure(writePDB(tmp_path / "peptoid.pdb", linesOf(topology, positions, rename)))
    sampling = sample(structure, EnergyModel(nMethylFiles, 300, isPrepared=True))
    kinds = {torsion.kind for torsion in sampling.torsions if torsion.residue.name == names[2]}
    assert {"phi", "psi", "omega"} <= kinds


def test_withoutATemplateTheMethylGroupGoes(tmp_path):
    topology, positions = makePeptides(("ACE", "MAA", "NME"))
    structure = readStructure(writePDB(tmp_path / "n.pdb", linesOf(topology, positions)))
    whole, _ = prepareStructure(structure, EnergyModel([PROTEIN], 300, isPrepared=True), 7, 1)
    assert [residue.name for residue in whole.topology.residues()] == ["ACE", "ALA", "NME"]
    assert [note.items for note in whole.notes if "replaced" in note.kind] == [["A:MAA 2 by ALA"]]


_PHOSPHATE = """
<AtomTypes>
  <Type name="sep-P" class="sep-P" element="P" mass="30.97"/>
  <Type name="sep-O" class="sep-O" element="O" mass="16.0"/>
  <Type name="sep-OS" class="sep-OS" element="O" mass="16.0"/>
</AtomTypes>
<HarmonicBondForce>
  <Bond class1="sep-P" class2="sep-O" length="0.148" k="439320"/>
  <Bond class1="sep-P" class2="sep-OS" length="0.161" k="192464"/>
  <Bond class1="sep-OS" class2="protein-2C" length="0.141" k="267776"/>
</HarmonicBondForce>
<HarmonicAngleForce>
  <Angle class1="sep-O" class2="sep-P" class3="sep-O" angle="2.0944" k="1171.5"/>
  <Angle class1="sep-O" class2="sep-P" class3="sep-OS" angle="1.8868" k="836.8"/>
  <Angle class1="sep-P" class2="sep-OS" class3="protein-2C" angle="2.1031" k="836.8"/>
  <Angle class1="sep-OS" class2="protein-2C" class3="protein-CX" angle="1.9111" k="418.4"/>
  <Angle class1="sep-OS" class2="protein-2C" class3="protein-H1" angle="1.9111" k="418.4"/>
</HarmonicAngleForce>
<PeriodicTorsionForce>
  <Proper class1="" class2="sep-OS" class3="sep-P" class4="" periodicity1="3" phase1="0" k1="1.046"/>
  <Proper class1="" class2="protein-2C" class3="sep-OS" class4="" periodicity1="3" phase1="0" k1="1.6"/>
</PeriodicTorsionForce>
<NonbondedForce coulomb14scale="0.8333333333333334" lj14scale="0.5">
  <UseAttributeFromResidue name="charge"/>
  <Atom type="sep-P" sigma="0.374" epsilon="0.8368"/>
  <Atom type="sep-O" sigma="0.296" epsilon="0.8786"/>
  <Atom type="sep-OS" sigma="0.300" epsilon="0.7113"/>
</NonbondedForce>
"""
_SEP = (
    [
        ("N", "N", -0.4), ("H", "H", 0.28), ("CA", "CX", 0.0), ("HA", "H1", 0.08), ("CB", "2C", 0.07),
        ("HB2", "H1", 0.03), ("HB3", "H1", 0.03), ("OG", "sep-OS", -0.47), ("P", "sep-P", 1.2), ("O1P", "sep-O", -0.9),
        ("O2P", "sep-O", -0.9), ("O3P", "sep-O", -0.9), ("C", "C", 0.6), ("O", "O", -0.57),
    ],
    "N-H N-CA CA-HA CA-CB CB-HB2 CB-HB3 CB-OG OG-P P-O1P P-O2P P-O3P CA-C C-O",
)  # fmt: skip


def test_phosphorylatedResidues(tmp_path):
    topology, positions = makePeptides(("ACE", "ALA", "SEP", "ALA", "NME"))
    structure = readStructure(writePDB(tmp_path / "sep.pdb", linesOf(topology, positions)))
    files = [PROTEIN, str(writeForceField(tmp_path / "sep.xml", {"SEP": _SEP}, others=_PHOSPHATE))]
    sampling = sample(structure, EnergyModel(files, 300, isPrepared=True))
    assert "SEP" in [residue.name for residue in sampling.structure.topology.residues()]
    axes = {tuple(sampling.plan.graph.atoms[atom].name for atom in t.particles[1:3]) for t in sampling.torsions}
    assert axes & {("OG", "P"), ("P", "OG")} and axes & {("CB", "OG"), ("OG", "CB")}


def test_aLigandOfItsOwnXML(runCommandHere, tmp_path):
    """Beside a peptide: its hydrogens come from its template, and its rotatable bonds turn."""
    peptide, positions = makePeptides(("ACE", "ALA", "NME"))
    lines = linesOf(peptide, positions)
    ligand = [("C1", 0, 0), ("C2", 1.5, 0.3), ("C3", 2.2, 1.65), ("C4", 3.7, 1.7)]
    lines += [
        pdbLine(900 + n, name, "LIG", "B", 1, x, y - 8, 0, record="HETATM") for n, (name, x, y) in enumerate(ligand)
    ]
    hydrogens = {"C1": 3, "C2": 2, "C3": 2, "C4": 3}
    atoms = [(name, "CT", -0.06 * count / 3) for name, count in hydrogens.items()]
    atoms += [(f"H{name[1]}{i}", "HC", 0.02) for name, count in hydrogens.items() for i in range(count)]
    bonds = "C1-C2 C2-C3 C3-C4 " + " ".join(f"C{name[1]}-{name}" for name, kind, _ in atoms if kind == "HC")
    forceField = writeForceField(tmp_path / "ligand.xml", {"LIG": (atoms, bonds)}, ends=())
    structure = writePDB(tmp_path / "complex.pdb", lines)
    result = runCommandHere(
        "sample", structure, "--prepare", "--forcefield", PROTEIN, forceField, "--torsions", "rotatable",
        "--trials", 300, "--seed", 1,
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    assert "LIG" in result.stdout and "1 other" in result.stdout
    before = filesIn(tmp_path)
    refused = runCommandHere("sample", structure, "--prepare", "--forcefield", PROTEIN, "--overwrite")
    assert refused.returncode == 2 and 'leave them out (--leave-out "resname LIG")' in refused.stderr
    assert filesIn(tmp_path) == before


def test_glycans(tmp_path):
    """Cellobiose of GLYCAM 06, whose residues GLYCAM tells by their names; the glycosidic bond turns."""
    parts = component("CBI")
    lines = []
    for serial, (name, element, place) in enumerate(zip(parts.atom_name, parts.element, parts.coord, strict=True), 1):
        if element == "H" and name != "HO1'":
            continue
        isReducing = name.endswith("'")
        residue, number, short = ("4GB", 2, name.rstrip("'")) if isReducing else ("0GB", 3, name)
        if name in ("O1'", "HO1'"):
            residue, number = "ROH", 1
        lines.append((number, pdbLine(serial, short, residue, "A", number, *place, record="HETATM")))
    structure = readStructure(writePDB(tmp_path / "glycan.pdb", [line for _, line in sorted(lines)]))
    assert structure.topology.getNumBonds() == 25
    model = EnergyModel([PROTEIN, "amber14/GLYCAM_06j-1.xml"], 300, isPrepared=True)
    sampling = sample(structure, model)
    assert np.isfinite(sampling.energies.held())
    across = [
        torsion
        for torsion in sampling.torsions
        if len({sampling.plan.graph.atoms[atom].residue.name for atom in torsion.particles} & {"4GB", "0GB"}) == 2
    ]
    assert len(across) == 2  # φ and ψ of the glycosidic bond
    assert app.element.hydrogen in {atom.element for atom in sampling.structure.topology.atoms()}
