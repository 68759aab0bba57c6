"""StericExclusionForce in files of OpenMM's ForceField."""

import copy
import io
import os
import subprocess
import sys
from pathlib import Path

import openmm
import openmmchaintree_forcefield
import pytest
from openmm import app
from openmmchaintree import StericExclusionForce, TorsionMonteCarloIntegrator, createStericExclusionForce

_FILE = "openmmchaintree/steric-exclusion.xml"

_METADATA = "Metadata-Version: 2.1\nName: openmm-chaintree\nVersion: 0.1.0\n"
_ENTRY_POINTS = "[openmm.forcefielddir]\nopenmmchaintree = openmmchaintree_forcefield:dataDirectory\n"


def runInstalled(folder, program, entryPoints=_ENTRY_POINTS):
    """Run a program where the packages of the build tree are installed, as far as entry points can tell."""
    information = folder / "openmm_chaintree-0.1.0.dist-info"
    information.mkdir()
    (information / "METADATA").write_text(_METADATA)
    (information / "entry_points.txt").write_text(entryPoints)
    path = os.pathsep.join([str(folder), *filter(None, sys.path)])
    environment = {**os.environ, "PYTHONPATH": path}
    return subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True)


def createForces(topology, *files):
    """Return copies of the StericExclusionForces of a System that AMBER14 and files make."""
    system = app.ForceField("amber14-all.xml", *files).createSystem(topology)
    found = [force for force in system.getForces() if StericExclusionForce.isinstance(force)]
    return [copy.deepcopy(StericExclusionForce.cast(force)) for force in found]


def tag(attributes):
    return io.StringIO(f"<ForceField><StericExclusionForce {attributes}/></ForceField>")


def assertSame(force, expected):
    """XML tells of everything that a force has."""
    assert openmm.XmlSerializer.serialize(force) == openmm.XmlSerializer.serialize(expected)


def shippedFile():
    path = Path(openmmchaintree_forcefield.dataDirectory()) / _FILE
    assert path.is_file()
    return str(path)


def test_shippedFile(villin):
    (force,) = createForces(villin.topology, shippedFile())
    assert force.getNumTorsions() > 100
    assertSame(force, createStericExclusionForce(villin.topology))


def test_attributes(villin):
    attributes = (
        "radii='united-atom' torsions='phi chi1' bondCutoff='2' forceGroup='7' cutDisulfides='true' "
        "overlapTolerance='0.03' hydrogenBondAllowance='0.05' forceConstant='2e4'"
    )
    (force,) = createForces(villin.topology, tag(attributes))
    expected = createStericExclusionForce(
        villin.topology,
        radii="united-atom",
        torsions=("phi", "chi1"),
        bondCutoff=2,
        forceGroup=7,
        cutDisulfides=True,
    )
    expected.setOverlapTolerance(0.03)
    expected.setHydrogenBondAllowance(0.05)
    expected.setForceConstant(2e4)
    assertSame(force, expected)
    (force,) = createForces(villin.topology, tag(""))
    assertSame(force, createStericExclusionForce(villin.topology))


@pytest.mark.parametrize(
    ("attributes", "message"),
    [
        ("colour='red'", "<StericExclusionForce> has no attribute colour; its attributes are radii, torsions, "),
        ("bondCutoff='many'", "<StericExclusionForce>: bondCutoff cannot be 'many'"),
        ("cutDisulfides='perhaps'", "<StericExclusionForce>: cutDisulfides cannot be 'perhaps'"),
        ("forceConstant=''", "<StericExclusionForce>: forceConstant cannot be ''"),
    ],
)
def test_badAttributes(attributes, message):
    with pytest.raises(ValueError) as caught:
        app.ForceField(tag(attributes))
    assert str(caught.value).startswith(message)


def test_valuesOutOfRangeAreToldWhenTheSystemIsMade(villin):
    for attributes, words in [
        ("radii='bondi'", "'bondi' is not a set of radii"),
        ("torsions='tau'", "'tau' is not a kind"),
        ("closures='rings'", "closures must be"),
    ]:
        with pytest.raises(ValueError, match=words):
            createForces(villin.topology, tag(attributes))


def test_onlyOnce():
    with pytest.raises(ValueError, match="^a ForceField can have <StericExclusionForce> only once$"):
        app.ForceField(tag(""), tag(""))


def test_sampling(villin):
    """The System is one that TorsionMonteCarloIntegrator takes."""
    system = app.ForceField("amber14-all.xml", "implicit/gbn2.xml", shippedFile()).createSystem(villin.topology)
    integrator = TorsionMonteCarloIntegrator(300)
    integrator.addTorsionMove(1, 0.2)
    context = openmm.Context(system, integrator, openmm.Platform.getPlatformByName("Reference"))
    context.setPositions(villin.positions)
    integrator.step(1)
    assert integrator.getMoveStatistics(0).attempted + integrator.getOuterStatistics().trialsTakenBack == 100


# ---- In programs that have not imported the package ----

_FINDS = f"""
import sys, openmm.app as app
forceField = app.ForceField("amber14-all.xml", "amber14/tip3p.xml", "{_FILE}")
assert "openmmchaintree._openmmchaintree" in sys.modules
villin = app.PDBFile(app.__path__[0] + "/data/test.pdb")
modeller = app.Modeller(villin.topology, villin.positions)
modeller.deleteWater()
system = forceField.createSystem(modeller.topology)
print([force.getName() for force in system.getForces()])
"""


def test_foundByItsEntryPoint(tmp_path):
    result = runInstalled(tmp_path, _FINDS)
    assert result.returncode == 0, result.stderr
    assert "'StericExclusionForce'" in result.stdout


_OTHERS = """
import sys, openmm.app as app
app.ForceField("amber14-all.xml", "amber14/tip3p.xml")
assert not [name for name in sys.modules if name.split(".")[0] == "openmmchaintree"], "the package is loaded"
assert "openmmchaintree_forcefield" in sys.modules
"""


def test_otherForceFieldsDoNotLoadTheLibrary(tmp_path):
    result = runInstalled(tmp_path, _OTHERS)
    assert result.returncode == 0, result.stderr


def test_otherForceFieldsDoNotCareIfThePackageIsBroken(tmp_path):
    """Another package's entry point comes after ours, and our parser cannot be registered."""
    (tmp_path / "others.py").write_text("def folder():\n    return __file__.rsplit('/', 1)[0]\n")
    (tmp_path / "other.xml").write_text("<ForceField/>")
    program = (
        "import openmm.app.forcefield as forcefield\n"
        "parsers, forcefield.parsers = forcefield.parsers, None\n"
        "forcefield._getDataDirectories()\n"
        "forcefield.parsers = parsers\n"
        "forcefield.ForceField('amber14-all.xml', 'other.xml')\n"
        "try:\n"
        f"    forcefield.ForceField('{_FILE}')\n"
        "except ValueError as error:\n"
        "    print(error)\n"
    )
    result = runInstalled(tmp_path, program, _ENTRY_POINTS + "others = others:folder\n")
    assert result.returncode == 0, result.stderr
    assert result.stdout == f'Could not locate file "{_FILE}"\n'
