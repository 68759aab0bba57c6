"""sample with Systems of others: AMBER, GROMACS and CHARMM files, and serialized Systems."""

import json
import re
import shutil

import foreignfiles
import numpy as np
import openmm
import pytest
from commands import assertRefused, filesIn
from foreignfiles import Terms, sdfOf
from mdtraj.formats import DCDTrajectoryFile
from openmm import app, unit
from scenes import DIPEPTIDE, readDCD, writePDB

CUTOFF = 0.9


class Peptide:
    """A dipeptide in AMBER14 as OpenMM makes it, and all kinds of files of it in a folder."""

    def __init__(self, folder):
        """Write the files."""
        pdb = app.PDBFile(str(writePDB(folder / "a.pdb", DIPEPTIDE)))
        self.topology = pdb.topology
        self.atoms = list(pdb.topology.atoms())
        self.positions = pdb.getPositions(asNumpy=True).value_in_unit(unit.nanometer)
        self.box = np.array([2.0, 2.1, 2.2])
        self.system = self.create()
        self.terms = terms = Terms(self.topology, self.system)
        foreignfiles.writePrmtop(folder / "a.prmtop", terms)
        foreignfiles.writeInpcrd(folder / "a.inpcrd", self.positions, self.box)
        foreignfiles.writeTop(folder / "a.top", terms)
        foreignfiles.writeGro(folder / "a.gro", self.atoms, self.positions, self.box, decimals=5)
        foreignfiles.writePsf(folder / "a.psf", terms)
        foreignfiles.writeCrd(folder / "a.crd", self.atoms, self.positions)
        foreignfiles.writeParameters(folder / "a.rtf", folder / "a.prm", terms)
        (folder / "a.xml").write_text(openmm.XmlSerializer.serialize(self.system))

    def create(self, **arguments):
        """Make its System."""
        forceField = app.ForceField("amber14/protein.ff14SB.xml", *arguments.pop("files", ()))
        return forceField.createSystem(self.topology, removeCMMotion=False, **arguments)


@pytest.fixture(scope="module")
def peptide(tmp_path_factory):
    peptide = Peptide(folder := tmp_path_factory.mktemp("peptide"))
    peptide.folder = folder
    return peptide


@pytest.fixture
def here(peptide, runCommandHere, tmp_path):
    """A function that runs sample in a folder with copies of the peptide's files."""
    for file in peptide.folder.iterdir():
        shutil.copy(file, tmp_path)

    def run(*arguments, trials=300):
        fixed = ("--trials", trials, "--frames", 2, "--seed", 1, "-o", "run", "--json", "run.json", "--overwrite")
        return runCommandHere("sample", *arguments, *fixed)

    return run


def energyOf(system, positions, box=None):
    context = openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))
    if box is not None:
        context.setPeriodicBoxVectors(*np.diag(box))
    context.setPositions(positions)
    return context.getState(energy=True).getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)


def energiesOf(result, folder):
    """Return U of the first and the last frame, that of the last by OpenMM, and all frames, of a run."""
    assert result.returncode == 0, result.stderr
    ends = json.loads((folder / "run.json").read_text())["energy"]["potentialEnergy"]
    with DCDTrajectoryFile(str(folder / "run.dcd")) as file:
        frames = 0.1 * file.read()[0]
    return ends["first"], ends["last"], ends["lastByOpenMM"], frames


# The accuracies are those of the digits in the files: of charges in PSF, of positions in gro and DCD.
KINDS = {
    "amber": (("a.inpcrd", "--system", "a.prmtop"), 1e-3),
    "gromacs": (("a.gro", "--system", "a.top"), 0.1),
    "charmm": (("a.crd", "--system", "a.psf", "--parameters", "a.rtf", "a.prm"), 0.02),
    "serialized": (("a.pdb", "--system", "a.xml"), 1e-4),
    "amber, other structure": (("a.pdb", "--system", "a.prmtop"), 1e-3),
    "gromacs, other structure": (("a.inpcrd", "--system", "a.top"), 1e-3),
    "charmm, other structure": (("a.gro", "--system", "a.psf", "--parameters", "a.rtf", "a.prm"), 0.1),
}


@pytest.mark.parametrize("kind", KINDS)
def test_sameEnergyAsOfOpenMM(here, peptide, tmp_path, kind):
    """The System of each kind of file has the energy of the System that the files were written from."""
    arguments, accuracy = KINDS[kind]
    first, last, byOpenMM, frames = energiesOf(here(*arguments), tmp_path)
    assert first == pytest.approx(energyOf(peptide.system, peptide.positions), abs=accuracy)
    assert last == pytest.approx(byOpenMM, abs=1e-3) and last != first
    assert last == pytest.approx(energyOf(peptide.system, frames[-1]), abs=accuracy + 0.05)


def test_theStartDoesNotDependOnTheKind(here, tmp_path):
    """A prmtop samples the trajectory of --forcefield, whose Topology has the same atoms."""
    here("a.pdb", "--system", "a.xml")
    expected = readDCD(tmp_path / "run.dcd")
    here("a.pdb", "--forcefield", "amber14/protein.ff14SB.xml")
    assert np.array_equal(readDCD(tmp_path / "run.dcd"), expected)


@pytest.mark.parametrize(
    ("kind", "name"), [("amber", "HCT"), ("amber", "obc2"), ("amber", "gbn2"), ("charmm", "GBn"), ("charmm", "OBC1")]
)
def test_implicitSolvent(here, peptide, tmp_path, kind, name):
    first, last, byOpenMM, _ = energiesOf(here(*KINDS[kind][0], "--implicit", name, trials=20), tmp_path)
    official = {"obc2": "OBC2", "gbn2": "GBn2"}.get(name, name)
    if kind == "amber":
        system = app.AmberPrmtopFile(str(tmp_path / "a.prmtop")).createSystem(implicitSolvent=getattr(app, official))
    else:
        parameters = app.CharmmParameterSet(str(tmp_path / "a.rtf"), str(tmp_path / "a.prm"))
        psf = app.CharmmPsfFile(str(tmp_path / "a.psf"))
        system = psf.createSystem(parameters, implicitSolvent=getattr(app, official))
    assert first == pytest.approx(energyOf(system, peptide.positions), abs=1e-3)
    assert last == pytest.approx(byOpenMM, abs=1e-3)
    notes = json.loads((tmp_path / "run.json").read_text())["notes"]
    assert any("Non-optimal GB parameters" in str(note) for note in notes) == (kind == "amber")
    settings = (tmp_path / "run-settings.toml").read_text()
    assert f'implicit = "{official}"' in settings


@pytest.mark.parametrize(
    ("method", "option"), [("PME", ()), ("CutoffPeriodic", ("--nonbonded-method", "CutoffPeriodic"))]
)
@pytest.mark.parametrize("kind", ["amber", "gromacs", "charmm, other structure"])
def test_boxOfTheFile(here, peptide, tmp_path, kind, method, option):
    arguments = (*KINDS[kind][0], "--periodic", "--nonbonded-cutoff", CUTOFF, *option)
    first, last, byOpenMM, _ = energiesOf(here(*arguments), tmp_path)
    box = openmm.Vec3(2, 0, 0), openmm.Vec3(0, 2.1, 0), openmm.Vec3(0, 0, 2.2)
    peptide.topology.setPeriodicBoxVectors(box * unit.nanometer)
    system = peptide.create(nonbondedMethod=getattr(app, method), nonbondedCutoff=CUTOFF)
    peptide.topology.setPeriodicBoxVectors(None)
    assert first == pytest.approx(energyOf(system, peptide.positions, peptide.box), abs=0.15)
    assert last == pytest.approx(byOpenMM, abs=0.01) and last != first


def test_periodicSerialized(here, peptide, tmp_path):
    """Its box is that of the structure, or else its own; images count as its Forces say."""
    peptide.topology.setPeriodicBoxVectors(np.diag([2.5, 2.5, 2.5]) * unit.nanometer)
    system = peptide.create(nonbondedMethod=app.PME, nonbondedCutoff=CUTOFF)
    peptide.topology.setPeriodicBoxVectors(None)
    (tmp_path / "p.xml").write_text(openmm.XmlSerializer.serialize(system))
    before = filesIn(tmp_path)
    assertRefused(here("a.pdb", "--system", "p.xml"), tmp_path, before, "p.xml: needs --periodic, since")
    assertRefused(here("a.pdb", "--system", "a.xml", "--periodic"), tmp_path, before, "a.xml: cannot have it")
    for name, box in (("a.pdb", [2.5] * 3), ("a.gro", peptide.box)):
        first, *_ = energiesOf(here(name, "--system", "p.xml", "--periodic", trials=20), tmp_path)
        assert first == pytest.approx(energyOf(system, peptide.positions, box), abs=0.15)


def test_constraints(here, peptide, tmp_path):
    """Torsion moves keep them; bond lengths cannot change beside them."""
    system = peptide.create(constraints=app.HBonds, rigidWater=False)
    assert system.getNumConstraints() > 0
    (tmp_path / "c.xml").write_text(openmm.XmlSerializer.serialize(system))
    first, last, byOpenMM, _ = energiesOf(here("a.pdb", "--system", "c.xml"), tmp_path)
    assert first == pytest.approx(energyOf(system, peptide.positions), abs=1e-4)
    assert last == pytest.approx(byOpenMM, abs=1e-3) and last != first
    here("a.pdb", "--system", "a.xml")
    files = filesIn(tmp_path)
    result = here("a.pdb", "--system", "c.xml", "--flexible")
    assertRefused(result, tmp_path, files, "--flexible: the System is built with constraints")
    assert here("a.pdb", "--system", "a.xml", "--flexible", trials=50).returncode == 0
    system.addConstraint(0, len(peptide.atoms) - 1, np.linalg.norm(peptide.positions[0] - peptide.positions[-1]))
    (tmp_path / "c.xml").write_text(openmm.XmlSerializer.serialize(system))
    assertRefused(here("a.pdb", "--system", "c.xml"), tmp_path, files, "onstraint")


def test_heavyHydrogens(here, peptide, tmp_path):
    """Repartitioned masses, and those of united atoms, are no sign of another structure."""
    united = openmm.XmlSerializer.clone(peptide.system)
    united.setParticleMass(1, 15.035)
    for system in (peptide.create(hydrogenMass=4 * unit.dalton), united):
        (tmp_path / "h.xml").write_text(openmm.XmlSerializer.serialize(system))
        assert here("a.pdb", "--system", "h.xml", trials=20).returncode == 0


def test_CMAP(here, peptide, tmp_path):
    """Maps of φ and ψ."""
    forceField = app.ForceField("amber19/protein.ff19SB.xml")
    system = forceField.createSystem(peptide.topology, removeCMMotion=False)
    assert any(isinstance(force, openmm.CMAPTorsionForce) for force in system.getForces())
    (tmp_path / "cmap.xml").write_text(openmm.XmlSerializer.serialize(system))
    first, last, byOpenMM, frames = energiesOf(here("a.pdb", "--system", "cmap.xml"), tmp_path)
    assert first == pytest.approx(energyOf(system, peptide.positions), abs=1e-4)
    assert last == pytest.approx(byOpenMM, abs=1e-3)
    assert last == pytest.approx(energyOf(system, frames[-1]), abs=0.05) and last != first


def test_minimize(here, peptide, tmp_path):
    first, *_ = energiesOf(here("a.pdb", "--system", "a.xml", "--minimize", trials=20), tmp_path)
    assert first < energyOf(peptide.system, peptide.positions) - 5


def test_names(here, tmp_path):
    """AMBER's names without suffixes, and names with spaces and other letters, also of folders."""
    folder = tmp_path / "ein Ordner äß"
    folder.mkdir()
    for name, copy in {
        "a.inpcrd": "inpcrd",
        "a.prmtop": "prmtop",
        "a.gro": "Größe 1.gro",
        "a.top": "topol β.top",
    }.items():
        shutil.copy(tmp_path / name, folder / copy)
    assert here(folder / "inpcrd", "--system", folder / "prmtop", trials=20).returncode == 0
    assert here(folder / "Größe 1.gro", "--system", folder / "topol β.top", trials=20).returncode == 0


def test_NBFIX(here, peptide, tmp_path):
    """Pairs with parameters of their own: OpenMM makes a CustomNonbondedForce of them."""
    bonded = peptide.terms.excluded
    i, j = next((i, j) for i in range(22) for j in range(i + 1, 22) if (i, j) not in bonded)
    foreignfiles.writeParameters(tmp_path / "a.rtf", tmp_path / "a.prm", peptide.terms, [(i, j, 0.4, 0.8)])
    first, last, byOpenMM, _ = energiesOf(here(*KINDS["charmm"][0]), tmp_path)
    parameters = app.CharmmParameterSet(str(tmp_path / "a.rtf"), str(tmp_path / "a.prm"))
    system = app.CharmmPsfFile(str(tmp_path / "a.psf")).createSystem(parameters)
    assert any(isinstance(force, openmm.CustomNonbondedForce) for force in system.getForces())
    assert first == pytest.approx(energyOf(system, peptide.positions), abs=1e-3)
    assert abs(first - energyOf(peptide.system, peptide.positions)) > 0.05
    assert last == pytest.approx(byOpenMM, abs=1e-3)


def test_explicitWater(here, peptide, tmp_path):
    """Water with virtual sites, ions and PME: torsions of the peptide turn, and the rest stays."""
    forceField = app.ForceField("amber14/protein.ff14SB.xml", "amber14/tip4pew.xml")
    modeller = app.Modeller(peptide.topology, peptide.positions * unit.nanometer)
    modeller.addSolvent(forceField, "tip4pew", boxSize=openmm.Vec3(2, 2, 2) * unit.nanometer, neutralize=False)
    system = forceField.createSystem(
        modeller.topology, nonbondedMethod=app.PME, nonbondedCutoff=CUTOFF, constraints=app.HBonds
    )
    with open(tmp_path / "w.pdb", "w") as file:
        app.PDBFile.writeFile(modeller.topology, modeller.positions, file)
    (tmp_path / "w.xml").write_text(openmm.XmlSerializer.serialize(system))
    result = here("w.pdb", "--system", "w.xml", "--periodic", trials=200)
    first, last, byOpenMM, frames = energiesOf(result, tmp_path)
    positions = app.PDBFile(str(tmp_path / "w.pdb")).getPositions(asNumpy=True).value_in_unit(unit.nanometer)
    assert system.isVirtualSite(system.getNumParticles() - 1)
    assert first == pytest.approx(energyOf(system, positions), abs=0.02)
    assert last == pytest.approx(byOpenMM, abs=0.05) and last != first
    areSites = np.array([system.isVirtualSite(i) for i in range(22, len(positions))])
    assert np.array_equal(frames[0][22:][~areSites], frames[-1][22:][~areSites]) and "vacuum" not in result.stdout
    assert np.abs(frames[-1][22:] - frames[0][22:]).max() < 1e-3  # the file rounds sites, which the run places


def test_aResumedRunReadsTheSystemAgain(here, tmp_path):
    arguments = (*KINDS["charmm"][0], "--implicit", "GBn2")
    assert here(*arguments, "--replicas", 2, trials=40).returncode == 0
    settings = (tmp_path / "run-settings.toml").read_text()
    assert 'system = "a.psf"' in settings and re.search(r'parameters = \[\s*"a.rtf",\s*"a.prm",?\s*\]', settings)
    assert here("--config", "run-settings.toml", trials=40).returncode == 0


def test_temperatures(here, tmp_path):
    arguments = ("--temperatures", "300:400:2", "--trials-per-exchange", 20, "--workers", 1)
    result = here("a.inpcrd", "--system", "a.prmtop", *arguments, trials=40)
    assert result.returncode == 0, result.stderr
    files = filesIn(tmp_path)
    assert here("--resume", "run.checkpoint", trials=80).returncode == 0
    assert filesIn(tmp_path) == files


# ---- What is refused ----


def test_files(here, peptide, tmp_path):
    """One sentence that names the file that is wrong, or missing."""
    (tmp_path / "empty.top").write_text("")
    (tmp_path / "text.prmtop").write_text("nothing\n")
    (tmp_path / "cut.prmtop").write_text((tmp_path / "a.prmtop").read_text()[:3000])
    (tmp_path / "cut.psf").write_text((tmp_path / "a.psf").read_text()[:500])
    (tmp_path / "cut.xml").write_text((tmp_path / "a.xml").read_text()[:3000])
    (tmp_path / "state.xml").write_text('<?xml version="1.0" ?>\n<State version="1"/>\n')
    (tmp_path / "ff.xml").write_text("<ForceField>\n</ForceField>\n")
    (tmp_path / "binary").write_bytes(bytes(range(256)))
    foreignfiles.writeTop(tmp_path / "include.top", peptide.terms, tmp_path / "types.itp")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "types.itp").rename(tmp_path / "elsewhere" / "types.itp")
    before = filesIn(tmp_path)
    for arguments, words in {
        ("a.pdb", "--system", "none.prmtop"): "none.prmtop: No such file",
        ("a.pdb", "--system", "elsewhere"): "elsewhere: Is a directory",
        ("a.pdb", "--system", "empty.top"): "empty.top: is empty",
        ("a.pdb", "--system", "text.prmtop"): "text.prmtop: is not a file of a System; it takes AMBER prmtop",
        ("a.pdb", "--system", "binary"): "binary: is not a file of a System",
        ("a.pdb", "--system", "a.pdb"): "a.pdb: is not a file of a System",
        ("a.pdb", "--system", "cut.prmtop"): "cut.prmtop: OpenMM cannot read an AMBER prmtop file like this",
        ("a.pdb", "--system", "cut.psf", "--parameters", "a.prm"): "cut.psf: OpenMM cannot read a CHARMM PSF",
        ("a.pdb", "--system", "cut.xml"): "cut.xml: OpenMM cannot read a serialized System",
        ("a.pdb", "--system", "state.xml"): "state.xml: has a State, not a System",
        ("a.pdb", "--system", "ff.xml"): "ff.xml: is a file of a ForceField, which --forcefield reads",
        ("a.pdb", "--forcefield", "a.xml"): "a.xml: is a serialized System, which --system reads",
        ("a.pdb", "--system", "a.psf"): "a.psf: needs --parameters",
        ("a.pdb", "--system", "a.psf", "--parameters", "none.prm"): "none.prm: No such file",
        (
            "a.pdb",
            "--system",
            "a.psf",
            "--parameters",
            "a.rtf",
        ): "a.psf: OpenMM cannot read a CHARMM PSF file like this",
        ("a.pdb", "--system", "a.psf", "--parameters", "a.pdb"): "Unrecognized file type: a.pdb",
        ("a.gro", "--system", "include.top"): "types.itp",
        ("--system", "a.prmtop"): "a.prmtop: name the structure, too",
        ("a.inpcrd", "--system", "a.prmtop", "--model", 1): "a.inpcrd: there is no model 1 (from 0)",
        ("a.pdb", "--system", "a.prmtop", "--fix", "all"): "--fix 'all' leaves nothing that moves\n",
        ("a.inpcrd",): "a.inpcrd: there are no atoms; names of atoms are in another file, such as a prmtop",
        ("a.prmtop", "--system", "a.inpcrd"): "a.inpcrd: is not a file of a System",
        ("a.inpcrd", "--system", "a.xml"): "a.inpcrd: has no names of atoms, which a.xml lacks, too",
    }.items():
        assertRefused(here(*arguments), tmp_path, before, words)
    assertRefused(here("a.gro", "--system", "include.top"), tmp_path, before, "--include names the folder that has it")
    assert here("a.gro", "--system", "include.top", "--include", "elsewhere", trials=20).returncode == 0


def test_options(here, tmp_path):
    before = filesIn(tmp_path)
    for arguments, words in {
        ("--system", "a.xml", "--forcefield", "amber14-all.xml"): "--forcefield and --system cannot be used together",
        ("--system", "a.xml", "--add-hydrogens"): "--add-hydrogens cannot be used with --system",
        ("--system", "a.xml", "--prepare"): "--prepare cannot be used with --system",
        ("--system", "a.xml", "--leave-out", "element H"): "--leave-out cannot be used with --system",
        ("--system", "a.xml", "--nonbonded-cutoff", 1): "--nonbonded-cutoff does not apply to a.xml",
        ("--system", "a.xml", "--periodic", "--nonbonded-method", "PME"): "--nonbonded-method does not apply to a.xml",
        ("--system", "a.xml", "--implicit", "gbn2"): "--implicit does not apply to a.xml, a serialized System",
        ("--system", "a.prmtop", "--parameters", "a.prm"): "--parameters does not apply to a.prmtop, an AMBER prmtop",
        ("--system", "a.prmtop", "--include", "."): "--include does not apply to a.prmtop",
        ("--system", "a.top", "--implicit", "gbn2"): "--implicit does not apply to a.top, a GROMACS top file",
        ("--system", "a.prmtop", "--implicit", "tip3p"): "'tip3p' is not one of HCT, OBC1",
        ("--system", "a.prmtop", "--periodic"): "--periodic needs --nonbonded-cutoff",
        ("--system", "a.prmtop", "--nonbonded-method", "PME"): "--nonbonded-method needs --periodic",
        ("--system", "a.prmtop", "--periodic", "--nonbonded-cutoff", 0.9): "a.pdb: there is no periodic box",
        ("--implicit", "gbn2"): "--implicit needs --system",
        ("--temperature", 300): "--temperature needs --forcefield or --system",
    }.items():
        assertRefused(here("a.pdb", *arguments), tmp_path, before, words)


def test_structuresThatDoNotFit(here, peptide, tmp_path):
    """What differs first is named."""
    lines = DIPEPTIDE[:-1]
    swapped = [*DIPEPTIDE]
    swapped[6], swapped[7] = swapped[7], swapped[6]  # N and H of alanine
    writePDB(tmp_path / "short.pdb", lines)
    writePDB(tmp_path / "swapped.pdb", swapped)
    swapped = [*DIPEPTIDE]
    swapped[6], swapped[8] = swapped[8], swapped[6]  # N and CA of alanine
    writePDB(tmp_path / "heavy.pdb", swapped)
    foreignfiles.writeInpcrd(tmp_path / "short.inpcrd", peptide.positions[:-1])
    foreignfiles.writeInpcrd(tmp_path / "torn.inpcrd", peptide.positions * np.where(np.arange(22) < 9, 1, -3)[:, None])
    foreignfiles.writeInpcrd(tmp_path / "same.inpcrd", 0 * peptide.positions)
    (tmp_path / "empty.inpcrd").write_text("")
    (tmp_path / "text.rst7").write_text("some text\nthat is\nno restart\n")
    before = filesIn(tmp_path)
    for (structure, system), words in {
        ("short.pdb", "a.prmtop"): ["short.pdb: does not fit a.prmtop: it has 21 atoms, not 22"],
        ("short.pdb", "a.xml"): ["short.pdb: does not fit a.xml: it has 21 atoms, not 22"],
        ("short.inpcrd", "a.prmtop"): ["short.inpcrd: does not fit a.prmtop: it has 21 atoms, not 22"],
        ("swapped.pdb", "a.prmtop"): ["number 6 (from 0), H of A:ALA 2, there N of", "ALA 2"],
        ("swapped.pdb", "a.xml"): ["number 6 (from 0), H of A:ALA 2, there of 14.01 Da"],
        ("heavy.pdb", "a.xml"): ["number 6 (from 0), CA of A:ALA 2, there of 14.01 Da"],
        ("torn.inpcrd", "a.prmtop"): ["atoms bonded in a.prmtop are far apart", "do the files belong together?"],
        ("same.inpcrd", "a.prmtop"): ["same.inpcrd: "],
        ("empty.inpcrd", "a.prmtop"): ["empty.inpcrd: is empty"],
        ("text.rst7", "a.prmtop"): ["text.rst7: not an AMBER inpcrd or restart file"],
        ("none.inpcrd", "a.prmtop"): ["none.inpcrd: No such file"],
    }.items():
        assertRefused(here(structure, "--system", system), tmp_path, before, *words)


def test_forces(here, peptide, tmp_path):
    """Forces that a run cannot sample."""
    drude = openmm.DrudeForce()
    drude.addParticle(1, 0, -1, -1, -1, -1, 0.001, 1, 1)
    for force, words in (
        (openmm.MonteCarloBarostat(1, 300), "MonteCarloBarostat changes the box"),
        (drude, "Drude particles"),
    ):
        system = openmm.XmlSerializer.clone(peptide.system)
        system.addForce(force)
        (tmp_path / "f.xml").write_text(openmm.XmlSerializer.serialize(system))
        result = here("a.pdb", "--system", "f.xml")
        assertRefused(result, tmp_path, sorted({*filesIn(peptide.folder), "f.xml"}), "f.xml: ", words)


def test_moleculeFile(here, peptide, tmp_path):
    """The structure of a serialized System may be an SDF or Mol2 file, as force fields of small molecules have it."""
    elements = [atom.element.symbol for atom in peptide.atoms]
    bonds = [tuple(atom.index for atom in bond) for bond in peptide.topology.bonds()]
    (tmp_path / "m.sdf").write_text(sdfOf(elements, bonds, 10 * peptide.positions))
    first, last, byOpenMM, _ = energiesOf(here("m.sdf", "--system", "a.xml"), tmp_path)
    assert first == pytest.approx(energyOf(peptide.system, peptide.positions), abs=0.01)
    assert last == pytest.approx(byOpenMM, abs=1e-3) and last != first
